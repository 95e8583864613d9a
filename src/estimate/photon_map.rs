//! Photons in a hash grid: cells of twice the gathering radius, photons sorted by cell, so that a gathering looks at
//! eight cells and always adds in the same order.

pub mod adaptive_kernel;
mod tuning;

use super::throughput::{KeptPolarisation, Throughput};
use super::walk::{Vertex, Walker};
use crate::manifold::receiver::Claim;
use eyebox_base::ids::GroupId;
use eyebox_base::lpe::LpeState;
use eyebox_base::parallel;
use eyebox_base::path::Trail;
use eyebox_film::accumulate::Light;
use eyebox_world::geometry::Site;
use eyebox_world::mode::Mode;
use eyebox_world::stokes::Facets;
use glam::DVec3;
use std::ops::Range;

/// Flux that arrived at a scatterer.
#[derive(Debug, Clone)]
pub struct Photon<M: Mode> {
    /// World, m.
    pub position: DVec3,
    /// Unit direction of propagation.
    pub dir: DVec3,
    /// Per lane, lm.
    pub flux: M::Lanes<Light>,
    pub polarisation: KeptPolarisation<M>,
    /// Dispersion has parted the lanes: the first stands for all.
    pub alone: bool,
    pub group: GroupId,
    /// From the lamp up to, but without, this vertex.
    pub trail: Trail,
    /// What light path expressions know of that.
    pub told: LpeState,
    /// Whether specular connection has the path from the lamp to here, or to where it is gathered.
    pub claim: Claim,
    pub site: Site,
    /// It arrived at the outside of the face.
    pub outside: bool,
}

impl<M: Mode> Photon<M> {
    /// What a path from a lamp of `group` leaves at a scatterer that it has met; `claim`: as the field.
    pub fn new(walker: &Walker<'_, M>, vertex: &Vertex, group: GroupId, claim: Claim) -> Self {
        let (flux, alone) = walker.beam.stored();
        Photon {
            position: vertex.hit.point,
            dir: walker.ray.dir,
            flux,
            polarisation: walker.beam.polarisation(),
            alone,
            group,
            trail: walker.trail,
            told: walker.told,
            claim,
            site: vertex.hit.site,
            outside: vertex.outside,
        }
    }
}

impl<M: Mode> Throughput<M> {
    /// A path from the eye along `dir` where a scatterer sends it a photon's light: with facets it sees how that is polarised.
    #[must_use]
    pub fn gathering(mut self, facets: Option<&M::Lanes<Facets>>, dir: DVec3, photon: &Photon<M>) -> Self {
        if facets.is_some() {
            self.scatter(facets, [dir, -photon.dir], true);
            self = self.meeting(&photon.polarisation, -photon.dir);
        }
        self
    }
}

/// Photons of one pass.
#[derive(Debug)]
pub struct PhotonMap<M: Mode> {
    photons: Vec<Photon<M>>,
    /// Start of each bucket in `photons`; one more at the end.
    starts: Vec<u32>,
    cell: f64,
    radius: f64,
    /// Where the lattice of cells starts, m.
    origin: DVec3,
    /// By how many steps the radius of each photon's kernel is smaller; whether any is.
    steps: Vec<u8>,
    crowded: bool,
    /// Kernels after so many steps: square of the radius, m², and density in the middle, 1/m².
    kernels: [[f64; 2]; adaptive_kernel::MOST + 1],
}

impl<M: Mode> PhotonMap<M> {
    /// Sorts photons into cells for gathering within `radius` metres.
    pub fn new(photons: Vec<Photon<M>>, radius: f64) -> Self {
        Self::crowded(photons, radius, f64::INFINITY, DVec3::ZERO)
    }

    /// The same with smaller kernels where more than `enough` photons lie in a cell, see [`adaptive_kernel`]; what is connected all about or
    /// comes straight from a lamp does not count. `shift`: of the cells, in their sides.
    pub fn crowded(photons: Vec<Photon<M>>, radius: f64, enough: f64, shift: DVec3) -> Self {
        let buckets = (photons.len() * 2).next_power_of_two().max(1);
        let cell = 2.0 * radius;
        let origin = shift * cell;
        let bucket_of: Vec<u32> =
            parallel::map_all(&photons, &|p| bucket(cell_of(p.position - origin, cell), buckets) as u32);
        let mut starts = vec![0u32; buckets + 1];
        bucket_of.iter().for_each(|&b| starts[b as usize + 1] += 1);
        for b in 0..buckets {
            starts[b + 1] += starts[b];
        }
        // A stable counting sort keeps the order of emission inside each bucket.
        let mut next = starts.clone();
        let mut order = vec![0u32; photons.len()];
        for (index, &b) in bucket_of.iter().enumerate() {
            order[next[b as usize] as usize] = index as u32;
            next[b as usize] += 1;
        }
        let photons: Vec<Photon<M>> = parallel::map_all(&order, &|&index| photons[index as usize].clone());
        let crowd = |ends: &[u32]| {
            let free = |&at: &usize| photons[at].claim != Claim::Connected && !photons[at].trail.is_empty();
            let free: Vec<usize> = (ends[0] as usize..ends[1] as usize).filter(free).collect();
            let positions: Vec<DVec3> = free.iter().map(|&at| photons[at].position - origin).collect();
            let steps = adaptive_kernel::steps(&positions, cell, enough);
            free.into_iter().zip(steps).collect::<Vec<(usize, u8)>>()
        };
        let crowded: Vec<&[u32]> = starts.windows(2).filter(|ends| f64::from(ends[1] - ends[0]) > enough).collect();
        let mut steps = vec![0; photons.len()];
        for (at, own) in parallel::map_all(&crowded, &|ends| crowd(ends)).into_iter().flatten() {
            steps[at] = own;
        }
        let crowded = steps.iter().any(|steps| *steps > 0);
        let kernels = std::array::from_fn(|steps| {
            let r2 = adaptive_kernel::radius(radius, steps).powi(2);
            [r2, 2.0 / (std::f64::consts::PI * r2)]
        });
        PhotonMap { photons, starts, cell, radius, origin, steps, crowded, kernels }
    }

    /// m
    pub fn radius(&self) -> f64 {
        self.radius
    }
    pub fn len(&self) -> usize {
        self.photons.len()
    }
    pub fn is_empty(&self) -> bool {
        self.photons.is_empty()
    }

    /// Calls `visit` with each photon on the face of `site` whose kernel reaches `point`, by how many steps the radius of that
    /// is smaller, and the density there of the kernel and of the one of a quarter of its area (1/m², Epanechnikov:
    /// 2/(πr²)·(1 − d²/r²)).
    pub fn gather(&self, point: DVec3, site: Site, mut visit: impl FnMut(&Photon<M>, usize, [f64; 2])) {
        for range in self.about(point) {
            for (photon, steps) in self.photons[range.clone()].iter().zip(&self.steps[range]) {
                let steps = usize::from(*steps);
                let (d2, [r2, peak]) = (photon.position.distance_squared(point), self.kernels[steps]);
                if d2 < r2 && photon.site.is_on_face_of(site) {
                    let near = 1.0 - d2 / r2;
                    visit(photon, steps, [peak * near, 4.0 * peak * (4.0 * near - 3.0).max(0.0)]);
                }
            }
        }
    }

    /// Some photons' kernels are smaller.
    pub fn is_crowded(&self) -> bool {
        self.crowded
    }

    /// How often the smallest kernel is halved, begun ones counted, of the photons within `reach`, m, of a point and within
    /// the map's radius.
    pub fn most_halved(&self, (point, site): (DVec3, Site), reach: f64) -> usize {
        let r2 = reach.min(self.radius).powi(2);
        let mut most = 0;
        for range in self.about(point) {
            for (photon, steps) in self.photons[range.clone()].iter().zip(&self.steps[range]) {
                if *steps > most && photon.site.is_on_face_of(site) && photon.position.distance_squared(point) < r2 {
                    most = *steps;
                }
            }
        }
        usize::from(most).div_ceil(adaptive_kernel::STEPS)
    }

    /// The photons of the cells that a sphere of the radius about a point touches: two per axis, since a cell is as wide as
    /// the sphere.
    fn about(&self, point: DVec3) -> impl Iterator<Item = Range<usize>> {
        let buckets = self.starts.len() - 1;
        let low = cell_of(point - self.origin - DVec3::splat(self.radius), self.cell);
        let mut seen = [usize::MAX; 8];
        (0..8usize).filter_map(move |corner| {
            let cell = [low[0] + (corner & 1) as i64, low[1] + (corner >> 1 & 1) as i64, low[2] + (corner >> 2) as i64];
            let b = bucket(cell, buckets);
            if seen[..corner].contains(&b) {
                return None;
            }
            seen[corner] = b;
            Some(self.starts[b] as usize..self.starts[b + 1] as usize)
        })
    }
}

/// The cell of a grid with this spacing.
pub(super) fn cell_of(p: DVec3, cell: f64) -> [i64; 3] {
    [(p.x / cell).floor() as i64, (p.y / cell).floor() as i64, (p.z / cell).floor() as i64]
}

fn bucket(cell: [i64; 3], buckets: usize) -> usize {
    // Large odd constants, as in Teschner et al. 2003; the multiply-shift spreads them over the table.
    let h = (cell[0] as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)
        ^ (cell[1] as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f)
        ^ (cell[2] as u64).wrapping_mul(0x1656_67b1_9e37_79f9);
    ((h ^ (h >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 20) as usize & (buckets - 1)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use eyebox_base::path::Event;
    use eyebox_base::rng::{Rng, Stream};
    use eyebox_base::stats::Moments;
    use eyebox_world::mode::Mono;

    /// A lumen that came over a specular face.
    pub fn photon(position: DVec3, face: u32) -> Photon<Mono> {
        Photon {
            position,
            dir: DVec3::Z,
            flux: [Light { value: 1.0, ..Light::default() }],
            polarisation: Throughput::<Mono>::new([1.0], DVec3::Z).polarisation(),
            alone: false,
            group: GroupId(0),
            trail: Trail::START.then(Event::Specular),
            told: LpeState::default(),
            claim: Claim::Free,
            site: Site { part: 0, face, triangle: 0 },
            outside: true,
        }
    }

    #[test]
    fn gathers_exactly_the_photons_in_reach() {
        let mut rng = Rng::new(1, Stream::Check, 0, 0);
        let mut point = || DVec3::new(rng.uniform() - 0.5, rng.uniform() - 0.5, rng.uniform() - 0.5);
        let photons: Vec<Photon<Mono>> = (0..5000).map(|i| photon(point(), i % 2)).collect();
        let map = PhotonMap::new(photons.clone(), 0.1);
        for _ in 0..200 {
            let at = point();
            let site = Site { part: 0, face: 1, triangle: 9 };
            let mut found = 0;
            map.gather(at, site, |_, _, densities| {
                assert!(densities.iter().all(|density| *density >= 0.0));
                found += 1;
            });
            let want = photons.iter().filter(|p| p.site.face == 1 && p.position.distance(at) < 0.1).count();
            assert_eq!(found, want);
        }
    }

    const AT: (DVec3, Site) = (DVec3::new(0.5, 0.5, 0.0), Site { part: 0, face: 0, triangle: 0 });

    /// The two densities that a map has of photons on a plane.
    fn densities(photons: Vec<Photon<Mono>>, enough: f64, shift: DVec3) -> [f64; 2] {
        let map = PhotonMap::crowded(photons, 0.1, enough, shift);
        let mut sums = [0.0; 2];
        map.gather(AT.0, AT.1, |photon, _, densities| {
            sums = [0, 1].map(|i| sums[i] + photon.flux[0].value * densities[i]);
        });
        sums
    }

    /// On a plane with a photons per area, the kernel estimate has that mean, halved or not.
    #[test]
    fn kernel_integrates_to_one() {
        let n = 400;
        let photons: Vec<Photon<Mono>> = (0..n * n)
            .map(|i| photon(DVec3::new((i % n) as f64 / n as f64, (i / n) as f64 / n as f64, 0.0), 0))
            .collect();
        for (enough, near) in [(f64::INFINITY, 1e-3), (4000.0, 4e-3)] {
            let sums = densities(photons.clone(), enough, DVec3::splat(0.3));
            assert!(sums.iter().all(|sum| (sum / (n * n) as f64 - 1.0).abs() < near), "{sums:?}");
        }
    }

    /// Whatever number of photons makes a kernel small, chance does not make the mean larger or smaller.
    #[test]
    fn crowded_photons_bring_no_more_in_the_mean() {
        const NUMBER: u64 = 100;
        let (mut found, mut reached) = ([Moments::default(); 2], [0; 2]);
        for map in 0..20_000 {
            let mut rng = Rng::new(5, Stream::Check, map, 0);
            let mut place = || DVec3::new(rng.uniform(), rng.uniform(), 0.0);
            let photons: Vec<Photon<Mono>> = (0..NUMBER).map(|_| photon(place(), 0)).collect();
            let shift = DVec3::new(rng.uniform(), rng.uniform(), rng.uniform());
            reached[0] += u32::from(densities(photons.clone(), f64::INFINITY, shift)[0] > 0.0);
            let densities = densities(photons, 4.0, shift);
            found.iter_mut().zip(densities).for_each(|(found, density)| found.add(density / NUMBER as f64));
            reached[1] += u32::from(densities[0] > 0.0);
        }
        assert!(reached[1] + 300 < reached[0], "kernels are not smaller: {reached:?}");
        for found in found {
            assert!((found.mean - 1.0).abs() < 4.0 * found.stderr() && found.stderr() < 0.02, "{found:?}");
        }
    }

    #[test]
    fn tells_where_photons_are_crowded() {
        let mut rng = Rng::new(7, Stream::Check, 0, 0);
        let mut about = |x: f64, face: u32, number: usize| -> Vec<Photon<Mono>> {
            (0..number).map(|_| photon(DVec3::new(x + 0.01 * rng.uniform(), 0.01 * rng.uniform(), 0.0), face)).collect()
        };
        let photons: Vec<Photon<Mono>> = [about(0.0, 0, 500), about(0.5, 0, 4), about(1.0, 1, 500)].concat();
        let most = |map: &PhotonMap<Mono>, x: f64, reach: f64| map.most_halved((DVec3::X * x, AT.1), reach);
        let map = PhotonMap::crowded(photons.clone(), 0.1, 4.0, DVec3::splat(0.3));
        assert!(map.is_crowded());
        assert_eq!(
            [0.005, 0.505, 1.005].map(|x| most(&map, x, 0.02)),
            [adaptive_kernel::HALVINGS, 0, 0],
            "thin, and another face"
        );
        assert_eq!([0.02, 0.05].map(|reach| most(&map, -0.03, reach)), [0, adaptive_kernel::HALVINGS], "within reach");
        assert!(!PhotonMap::new(photons, 0.1).is_crowded());
    }
}
