//! A ray in a solid's coordinates, and what is computed once for all of its candidates.

use super::exact::Quadric;
use super::patch::{Projection, Shear};
use super::solid::Solid;
use super::triangle::Triangle;
use glam::DVec3;

/// A ray in a solid's coordinates.
#[derive(Debug, Clone, Copy)]
pub struct LocalRay {
    pub origin: DVec3,
    /// Unit, about.
    pub dir: DVec3,
    /// Where it enters the solid's bounds.
    pub start: f64,
    /// The surface that the ray starts on, `u32::MAX` for none, and the triangle.
    pub from: u32,
    pub from_triangle: u32,
    /// A face that is not to be seen, `u32::MAX` for none.
    pub skip: u32,
    /// How far a point may be from where it should be after all roundings.
    pub grain: f64,
}

/// A line prepared for triangles.
pub struct Probe {
    /// Where it enters the tree's bounds.
    pub start: f64,
    /// origin + start·dir.
    pub through: DVec3,
    pub shear: Shear,
    /// Of the exact face that was tried last.
    pub roots: Option<Roots>,
    /// All places of the line on the curved face that was tried last, which may be many, ascending.
    many: Option<Box<Many>>,
}

/// The face, and t and the point of each place.
type Many = (u32, Vec<(f64, DVec3)>);

/// A point where a line meets a solid.
#[derive(Debug, Clone, Copy)]
pub struct Touch {
    pub t: f64,
    pub slot: u32,
    pub triangle: Triangle,
    pub at: DVec3,
    /// Of the triangle's corners; only for triangles that are not exact.
    pub weights: [f64; 3],
}

/// Both points of a line on the exact surface of one face, kept while its triangles are tried.
pub struct Roots {
    pub face: u32,
    /// NaN where there is none ahead.
    pub t: [f64; 2],
    pub at: [DVec3; 2],
    /// From the centre towards the points, for central projections.
    pub shear: [Shear; 2],
}

impl LocalRay {
    /// A ray from `origin` along the unit vector `dir`; none if it misses the solid's bounds.
    #[inline(always)]
    pub fn new(solid: &Solid, origin: DVec3, dir: DVec3, reach: f64, grain: f64) -> Option<LocalRay> {
        let start = solid.bounds.enter(origin, dir)?;
        let [from, from_triangle, skip] = [u32::MAX; 3];
        (start <= reach).then_some(LocalRay { origin, dir, start, from, from_triangle, skip, grain })
    }

    /// The ray starts on this face and triangle.
    #[inline]
    pub fn leave(&mut self, solid: &Solid, face: u32, triangle: u32) {
        if let Some(sheet) = solid.faces.get(face as usize) {
            self.from = sheet.identity;
            self.from_triangle = triangle;
        }
    }

    pub fn skip(&mut self, face: u32) {
        self.skip = face;
    }
}

impl Probe {
    pub fn new(line: &LocalRay, start: f64) -> Probe {
        let through = line.origin + start * line.dir;
        Probe { start, through, shear: Shear::along(line.dir), roots: None, many: None }
    }

    /// The places on a curved face, found once while its triangles are tried.
    pub fn many_of(&mut self, face: u32, find: impl FnOnce() -> Vec<(f64, DVec3)>) -> &[(f64, DVec3)] {
        if self.many.as_ref().is_none_or(|many| many.0 != face) {
            self.many = Some(Box::new((face, find())));
        }
        self.many.as_ref().map_or(&[], |many| &many.1)
    }
}

impl Roots {
    #[inline]
    pub fn of(face: u32, quadric: &Quadric, projection: &Projection, line: &LocalRay, starts_here: bool) -> Roots {
        let shear = Shear::along(DVec3::Z);
        let mut roots = Roots { face, t: [f64::NAN; 2], at: [DVec3::ZERO; 2], shear: [shear; 2] };
        let found = quadric.intersect(line.origin, line.dir, starts_here);
        for (i, t) in found.into_iter().enumerate() {
            if !(t > 0.0 && t < f64::INFINITY) {
                continue;
            }
            let at = line.origin + t * line.dir;
            match projection {
                Projection::Axial(_) => {
                    // The far half of an ellipsoid and the other sheet of a hyperboloid are not meant.
                    if quadric.branch(at) > 0.0 {
                        (roots.t[i], roots.at[i]) = (t, at);
                    }
                }
                Projection::Central(centre) => {
                    (roots.t[i], roots.at[i]) = (t, at);
                    roots.shear[i] = Shear::along(at - *centre);
                }
            }
        }
        roots
    }
}
