//! The rays of a file in the world: where they start, and their way out of the part that they leave.

use super::geometry::{Geometry, Ray};
use eyebox_base::error::Result;
use eyebox_base::{Error, Shared, Where};
use eyebox_scene::{RaySet, Scene};
use glam::{DMat3, DVec3};

/// Rays of a file that leave a part.
#[derive(Debug, Clone)]
pub struct RayLamp {
    rays: Shared<RaySet>,
    part: u32,
    /// The part's axes in the world, a rotation.
    axes: DMat3,
    /// The part's origin, recentred world, m.
    place: DVec3,
}

/// How far the axes of a part may be from right angles, in cosines: transforms of single precision are.
const SKEW: f64 = 1e-5;
/// Faces of its own part that a ray leaves behind at most: a part that is so folded is taken as it is from there on.
const MOST_FACES: usize = 1024;

impl RayLamp {
    /// `origin`: of the recentred world. Errors: no such part, or one that is mirrored or skewed.
    pub(super) fn build(scene: &Scene, (rays, part): (&Shared<RaySet>, usize), origin: DVec3) -> Result<RayLamp> {
        let fault = |what: &str| Error::new(Where::Nowhere, format!("the rays of {} {what}", rays.file));
        let own = scene.parts.get(part).ok_or_else(|| fault("leave a part that is not there"))?;
        let bad = || {
            Error::new(
                Where::part(&own.path),
                format!("its axes are no rotation, as those of the rays of {}", rays.file),
            )
            .expected("a node that is neither mirrored nor skewed")
        };
        let axis = |axis: DVec3| axis.try_normalize().ok_or_else(bad);
        let of = own.to_world.matrix3;
        let [x, y, z] = [axis(of.x_axis)?, axis(of.y_axis)?, axis(of.z_axis)?];
        if [x.dot(y), y.dot(z), z.dot(x)].iter().any(|cos| cos.abs() > SKEW) || x.cross(y).dot(z) < 0.0 {
            return Err(bad());
        }
        let y = axis(y - x * x.dot(y))?;
        let axes = DMat3::from_cols(x, y, x.cross(y));
        Ok(RayLamp { rays: rays.clone(), part: part as u32, axes, place: own.to_world.translation - origin })
    }

    /// The part that they leave.
    pub fn part(&self) -> u32 {
        self.part
    }

    /// How many they are.
    pub fn count(&self) -> usize {
        self.rays.count
    }

    /// Where the ray at a share of the flux starts, and its unit direction: recentred world, m.
    pub fn emit(&self, u: f64) -> (DVec3, DVec3) {
        const MM: f64 = 1e-3;
        let ray = self.rays.at(u);
        let dir = self.axes * ray.dir.as_dvec3();
        (self.place + self.axes * (MM * ray.place_mm.as_dvec3()), dir.normalize())
    }

    /// A ray of the file once it has left its part: it starts at the last face of the part before it meets another one, or
    /// where the file says if it meets none.
    pub fn leaving(&self, geometry: &Geometry, (origin, dir): (DVec3, DVec3)) -> Ray {
        let mut ray = Ray { origin, dir, from: None };
        for _ in 0..MOST_FACES {
            match geometry.intersect(&ray, f64::INFINITY) {
                Some(hit) if hit.site.part == self.part => ray = Ray { origin: hit.point, dir, from: Some(hit.site) },
                Some(_) | None => break,
            }
        }
        ray
    }
}
