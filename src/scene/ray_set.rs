//! Rays of a file as a source of light: where each starts, which way it goes, and its share of the light.

use glam::{DVec2, DVec3, Vec3};

/// A ray of a lamp, in the lamp's own axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LampRay {
    /// Where it starts, mm.
    pub place_mm: Vec3,
    /// Unit.
    pub dir: Vec3,
    /// In the unit of its set, above 0 and finite.
    pub flux: f32,
}

/// Rays with one spectrum, in an order in which neighbours start near each other and go nearly the same way: what guides
/// learn of one ray holds for those beside it.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct RaySet {
    /// As it was named.
    pub file: String,
    /// How many there are.
    pub count: usize,
    #[serde(skip)]
    rays: Vec<LampRay>,
    /// Running sums of their flux; none where all have the same.
    #[serde(skip)]
    sums: Option<Vec<f64>>,
}

impl RaySet {
    /// None without rays. Places and directions are finite, directions unit, and each flux is above 0.
    pub fn new(file: String, mut rays: Vec<LampRay>) -> Option<RaySet> {
        let first = rays.first()?;
        let flux = first.flux;
        let (low, high) = rays
            .iter()
            .fold((first.place_mm, first.place_mm), |(low, high), ray| (low.min(ray.place_mm), high.max(ray.place_mm)));
        let (low, size) = (low.as_dvec3(), (high.as_dvec3() - low.as_dvec3()).max_element());
        rays.sort_by_cached_key(|ray| key(ray, low, size));
        let sums = rays.iter().any(|ray| ray.flux != flux).then(|| {
            let mut sum = 0.0;
            rays.iter()
                .map(|ray| {
                    sum += f64::from(ray.flux);
                    sum
                })
                .collect()
        });
        Some(RaySet { file, count: rays.len(), rays, sums })
    }

    /// All of them, in their order.
    pub fn rays(&self) -> &[LampRay] {
        &self.rays
    }

    /// The ray at the share `u`, from 0 to 1, of the set's flux: of 2ᵏ numbers that are even in 2ᵏ cells none takes a ray of
    /// less than a cell's share twice but at a cell's border.
    pub fn at(&self, u: f64) -> LampRay {
        let last = self.rays.len() - 1;
        let index = match &self.sums {
            None => (u * self.rays.len() as f64) as usize,
            Some(sums) => {
                let want = u * sums.last().copied().unwrap_or(0.0);
                sums.partition_point(|sum| *sum <= want)
            }
        };
        self.rays[index.min(last)]
    }
}

/// Place of a ray on a curve of Morton's through its direction and its place, twelve bits each.
fn key(ray: &LampRay, low: DVec3, size: f64) -> u64 {
    const BITS: u32 = 12;
    let [u, v] = on_square(ray.dir.as_dvec3()).to_array();
    let place = if size > 0.0 { (ray.place_mm.as_dvec3() - low) / size } else { DVec3::ZERO };
    let whole = f64::from(1u32 << BITS);
    let cells = [u, v, place.x, place.y, place.z].map(|x| (x * whole).clamp(0.0, whole - 1.0) as u64);
    (0..BITS).rev().fold(0, |key, bit| cells.iter().fold(key, |key, cell| (key << 1) | ((cell >> bit) & 1)))
}

/// A direction on the unit square, neighbours beside each other: an octahedron unfolded (Cigolle et al., "A survey of
/// efficient representations for independent unit vectors", JCGT 3(2), 2014).
fn on_square(dir: DVec3) -> DVec2 {
    let flat = dir.truncate() / (dir.x.abs() + dir.y.abs() + dir.z.abs());
    let sign = DVec2::new(1f64.copysign(flat.x), 1f64.copysign(flat.y));
    let flat = if dir.z < 0.0 { (DVec2::ONE - DVec2::new(flat.y.abs(), flat.x.abs())) * sign } else { flat };
    0.5 * flat + 0.5
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ray(x: f32, flux: f32) -> LampRay {
        LampRay { place_mm: Vec3::new(x, 0.0, 0.0), dir: Vec3::Z, flux }
    }

    #[test]
    fn rays_are_taken_by_their_flux_and_each_once() {
        let equal = RaySet::new(String::new(), (0..64).map(|x| ray(x as f32, 2.0)).collect()).unwrap();
        let mut taken: Vec<f32> = (0..64).map(|k| equal.at((f64::from(k) + 0.3) / 64.0).place_mm.x).collect();
        taken.sort_by(f32::total_cmp);
        assert_eq!(taken, (0..64).map(|x| x as f32).collect::<Vec<_>>());
        assert_eq!(equal.at(1.0), *equal.rays().last().unwrap());
        let uneven = RaySet::new(String::new(), vec![ray(0.0, 1.0), ray(1.0, 3.0), ray(2.0, 4.0)]).unwrap();
        for (x, want) in [(0.0, 125), (1.0, 375), (2.0, 500)] {
            let count = (0..1000).filter(|k| uneven.at((f64::from(*k) + 0.5) / 1000.0).place_mm.x == x).count();
            assert_eq!(count, want, "{x}");
        }
        assert!(RaySet::new(String::new(), Vec::new()).is_none());
    }

    #[test]
    fn the_order_of_the_file_does_not_matter() {
        let rays: Vec<LampRay> = (0..50).map(|k| ray((k * 7 % 50) as f32, (k % 3 + 1) as f32)).collect();
        let back = rays.iter().rev().copied().collect();
        assert_eq!(RaySet::new(String::new(), rays), RaySet::new(String::new(), back));
    }
}
