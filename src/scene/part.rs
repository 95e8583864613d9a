//! Parts: nodes with geometry, and what each of their faces is optically.

use super::{Dispersion, Emitter, FilmBase, Finish, Sensor, Shape};
use eyebox_base::colour::uplift_reflectance;
use eyebox_base::ids::{CoatingId, MediumId, MeshId, SlideId};
use glam::DAffine3;

/// What fills a closed solid.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Medium {
    /// Glass name, or what it was made from.
    pub name: String,
    pub index: Dispersion,
    pub absorption: Absorption,
}

/// Napierian absorption coefficient, 1/m (Beer–Lambert: exp(−a·length)).
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Absorption {
    /// The same at every wavelength.
    Constant(f64),
    /// Rows (λ nm, 1/m) by rising λ: linear between them, constant beyond them.
    Table(Vec<[f64; 2]>),
    /// A linear Rec.709 colour that white light has after `distance_m`, each primary falling by itself: rgb^(x/distance),
    /// as `KHR_materials_volume` has it. That is exact where paths carry the three primaries; at a wavelength the colour's
    /// smooth reflectance spectrum stands for it, which is exact at `distance_m` alone.
    Colour { rgb: [f64; 3], distance_m: f64 },
}

impl Absorption {
    pub const NONE: Absorption = Absorption::Constant(0.0);

    /// 1/m at a wavelength in vacuum.
    pub fn per_m(&self, nm: f64) -> f64 {
        match self {
            Absorption::Constant(per_m) => *per_m,
            Absorption::Colour { rgb, distance_m } => fall(uplift_reflectance(*rgb, nm), *distance_m),
            Absorption::Table(rows) => {
                let after = rows.partition_point(|row| row[0] < nm);
                let above = rows.get(after).or(rows.last());
                let below = after.checked_sub(1).and_then(|i| rows.get(i)).or(above);
                match (below, above) {
                    (Some([x0, a0]), Some([x1, a1])) if x0 < x1 => a0 + (a1 - a0) * (nm - x0) / (x1 - x0),
                    (Some([_, a]), _) => *a,
                    (None, _) => 0.0,
                }
            }
        }
    }
}

/// 1/m of what leaves the share `through` over `distance_m`; very much of what leaves nothing.
fn fall(through: f64, distance_m: f64) -> f64 {
    // Finite, so that no way at all takes nothing.
    const MOST: f64 = 1e300;
    (-through.min(1.0).ln() / distance_m).clamp(0.0, MOST)
}

impl Medium {
    /// Absorption of a primary of Rec.709 (0 red, 1 green, 2 blue) where paths carry those, 1/m; what goes by wavelength is
    /// taken at `nm`.
    pub fn absorption_per_m_of(&self, primary: usize, nm: f64) -> f64 {
        match &self.absorption {
            Absorption::Colour { rgb, distance_m } => {
                let through = rgb.get(primary).copied().unwrap_or(1.0);
                fall(through, *distance_m) + self.absorption_by_index(nm)
            }
            Absorption::Constant(_) | Absorption::Table(_) => self.absorption_per_m_at(nm),
        }
    }

    /// 4πk/λ of an imaginary index, 1/m.
    pub fn absorption_by_index(&self, nm: f64) -> f64 {
        4.0 * std::f64::consts::PI * self.index.index(nm).im / (nm * 1e-9)
    }

    /// Absorption at a wavelength in vacuum, 1/m: its own, and 4πk/λ of an imaginary index.
    pub fn absorption_per_m_at(&self, nm: f64) -> f64 {
        self.absorption.per_m(nm) + self.absorption_by_index(nm)
    }
}

/// A node with geometry.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Part {
    /// Last segment of `path`.
    pub name: String,
    /// Root-relative path, e.g. `HUD_B/LENS_01_PMMA`.
    pub path: String,
    pub mesh: MeshId,
    /// Mesh units → world metres.
    pub to_world: DAffine3,
    /// The medium of the solid, or none: an opaque body or a thin sheet.
    pub medium: Option<MediumId>,
    /// Where solids overlap or touch, the higher priority wins.
    pub priority: i32,
    /// One entry per CAD face of the mesh, in order.
    pub faces: Vec<Face>,
    /// The names of the faces' materials in the asset, in the same order; `none` where it has none. Empty where nobody asks.
    pub materials: Vec<String>,
    /// A film that is laminated to a face of a solid, below its surface ([`Scene::laminate`](super::Scene::laminate)).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub film_in: Option<FilmBase>,
}

/// What a CAD face of a part is optically.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Face {
    pub finish: Finish,
    /// Only on `Finish::Polished`.
    pub coating: Option<CoatingId>,
    pub shape: Shape,
    pub emitter: Option<Emitter>,
    /// Share of the light that gets through a polished face, linear Rec.709, beside what Fresnel's equations or the coating say:
    /// stained glass. None: all.
    pub tint: Option<[f64; 3]>,
    /// A face with a slide transmits straight through, weighted by the picture, whatever its finish. One that emits is a display:
    /// it shines through the picture, and light that meets it finds its finish.
    pub slide: Option<SlideId>,
    /// A map of the light that arrives at it is asked for. It changes no light.
    pub sensor: Option<Sensor>,
}

impl Face {
    /// Whether light goes through it, weighted by a picture.
    pub fn is_slide(&self) -> bool {
        self.slide.is_some() && self.emitter.is_none()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// rgb^(x/d) per primary; by wavelength, the uplifted colour at d; a primary that nothing is left of stays finite.
    #[test]
    fn a_colour_falls_by_its_primaries() {
        let rgb = [0.9, 0.25, 0.0];
        let absorption = Absorption::Colour { rgb, distance_m: 0.02 };
        let medium = Medium { name: "tint".into(), index: Dispersion::Constant(1.5), absorption };
        for (primary, c) in rgb.into_iter().enumerate() {
            let through = (-medium.absorption_per_m_of(primary, 555.0) * 0.05).exp();
            assert!((through - c.powf(2.5)).abs() < 1e-12, "{primary}: {through}");
            assert_eq!((-medium.absorption_per_m_of(primary, 555.0) * 0.0).exp(), 1.0);
        }
        for nm in [450.0, 555.0, 620.0] {
            let through = (-medium.absorption_per_m_at(nm) * 0.02).exp();
            assert!((through - uplift_reflectance(rgb, nm)).abs() < 1e-12, "{nm}");
        }
    }
}
