//! The deterministic solver: which ray of a family of two parameters goes through a train of faces to a point of a lamp.
//!
//! Newton's iteration on where the ray meets the plane of the lamp (W. Jakob and S. Marschner, "Manifold exploration",
//! 2012; J. Hanika et al., "Manifold next event estimation", 2015, walk the vertices; here the ray is traced through
//! exact surfaces, so every iterate obeys Snell's law and two unknowns are all there is).

use super::media::Media;
use super::ray_differentials::RayDifferentials;
use super::tuning::newton::{HALVINGS, STEPS};
use eyebox_film::specular_chain::SpecularChain;
use eyebox_world::World;
use eyebox_world::eye::EyeLens;
use eyebox_world::geometry::{Ray, Site};
use glam::{DMat2, DVec2, DVec3};

/// A family of rays with two parameters.
#[derive(Debug, Clone, Copy)]
pub enum Family {
    /// Through a place of the picture, by the place in the pupil (m).
    Pupil { film: DVec2 },
    /// Through a place of the pupil, by the place in the picture (tangents).
    Film { pupil: DVec2 },
    /// From a point, by the tangents of the direction about `axis` along `across`.
    Point { origin: DVec3, from: Option<Site>, axis: DVec3, across: [DVec3; 2] },
    /// Along a direction, by displacement of the origin along `across`.
    Shifted { origin: DVec3, from: Option<Site>, dir: DVec3, across: [DVec3; 2] },
}

impl Family {
    /// Rays from a point about a unit direction, and the unit tangents across it that `u` goes along.
    pub fn about(origin: DVec3, from: Option<Site>, axis: DVec3) -> (Family, [DVec3; 2]) {
        let (a, b) = axis.any_orthonormal_pair();
        (Family::Point { origin, from, axis, across: [a, b] }, [a, b])
    }

    /// The ray of parameters `u`, with derivatives.
    pub fn bundle(&self, eye: &EyeLens, u: DVec2) -> RayDifferentials {
        match *self {
            Family::Pupil { film } => {
                let (origin, dir, [right, up], per_focus) = eye.ray_of(film, u);
                let turn = |axis: DVec3| -per_focus * across(dir.1, axis) / dir.0;
                let ray = Ray { origin, dir: dir.1, from: None };
                RayDifferentials { ray, origin: [right, up], dir: [turn(right), turn(up)] }
            }
            Family::Film { pupil } => {
                let (origin, dir, [right, up], _) = eye.ray_of(u, pupil);
                let turn = |axis: DVec3| across(dir.1, axis) / dir.0;
                let ray = Ray { origin, dir: dir.1, from: None };
                RayDifferentials { ray, origin: [DVec3::ZERO; 2], dir: [turn(right), turn(up)] }
            }
            Family::Point { origin, from, axis, across: [a, b] } => {
                let long = axis + u.x * a + u.y * b;
                let length = long.length();
                let dir = long / length;
                let turn = |along: DVec3| across(dir, along) / length;
                RayDifferentials { ray: Ray { origin, dir, from }, origin: [DVec3::ZERO; 2], dir: [turn(a), turn(b)] }
            }
            Family::Shifted { origin, from, dir, across: [a, b] } => {
                let ray = Ray { origin: origin + u.x * a + u.y * b, dir, from };
                RayDifferentials { ray, origin: [a, b], dir: [DVec3::ZERO; 2] }
            }
        }
    }
}

/// The part of `v` across the unit vector `d`.
fn across(d: DVec3, v: DVec3) -> DVec3 {
    v - d * d.dot(v)
}

/// A point of a lamp as a target.
#[derive(Debug, Clone, Copy)]
pub struct Target {
    pub point: DVec3,
    pub normal: DVec3,
    /// Unit tangents.
    pub across: [DVec3; 2],
}

impl Target {
    pub fn new(point: DVec3, normal: DVec3) -> Target {
        let (a, b) = normal.any_orthonormal_pair();
        Target { point, normal, across: [a, b] }
    }

    /// Coordinates of a point of the plane.
    pub fn local(&self, v: DVec3) -> DVec2 {
        DVec2::new(v.dot(self.across[0]), v.dot(self.across[1]))
    }
}

/// Where rays end, and its derivative by the family's parameters.
#[derive(Debug, Clone, Copy)]
pub struct End {
    /// From the target, m.
    pub off: DVec2,
    /// d(off)/du.
    pub slope: DMat2,
    /// Of the ray that arrives.
    pub dir: DVec3,
}

/// Follows one ray of the family to the plane of the target.
pub fn trace(
    world: &World,
    media: &impl Media,
    family: &Family,
    u: DVec2,
    train: &SpecularChain,
    target: &Target,
) -> Option<End> {
    end_of(&family.bundle(&world.eye, u).through(world, train, media)?, target)
}

/// Where a bundle that has gone through its train meets the plane of the target.
#[inline]
pub fn end_of(bundle: &RayDifferentials, target: &Target) -> Option<End> {
    let landing = bundle.land(target.point, target.normal)?;
    let slope = DMat2::from_cols(target.local(landing.by[0]), target.local(landing.by[1]));
    let off = target.local(landing.point - target.point);
    (off.is_finite() && slope.is_finite()).then_some(End { off, slope, dir: bundle.ray.dir })
}

/// A ray of a family that meets its target.
#[derive(Debug, Clone, Copy)]
pub struct Root {
    pub u: DVec2,
    /// d(place on the lamp)/du.
    pub slope: DMat2,
    pub dir: DVec3,
}

/// Newton's iteration from `start`. `size`: length of the lamp, m, against which closeness is measured. The result is a
/// function of the arguments alone. None where it does not converge, or the map is singular.
pub fn newton(
    world: &World,
    media: &impl Media,
    family: &Family,
    start: DVec2,
    train: &SpecularChain,
    target: &Target,
    size: f64,
) -> Option<Root> {
    // Quadratic: from 1e-5 of the lamp the next step lands at its rounding.
    const NEAR: f64 = 1e-7;
    // What a step leaves is to the offset before it as that is to the one before, squared: where that is this little, the
    // last step need not be looked at, and the slope differs from the root's by less than twice the square.
    const LEFT: f64 = 1e-8;
    const SHRUNK: f64 = 3e-3;
    let mut u = start;
    let mut before = 0.0;
    let mut end = trace(world, media, family, u, train, target)?;
    for _ in 0..STEPS {
        let inverse = end.slope.inverse();
        if !inverse.is_finite() {
            return None;
        }
        let step = inverse * end.off;
        let length = end.off.length();
        let near = length <= NEAR * size;
        let shrunk = length / before;
        if shrunk <= SHRUNK && length * shrunk * shrunk <= LEFT * size {
            return Some(Root { u: u - step, slope: end.slope, dir: end.dir });
        }
        before = length;
        let mut share = 1.0;
        let mut next = None;
        for _ in 0..HALVINGS {
            let tried = u - share * step;
            if let Some(there) = trace(world, media, family, tried, train, target)
                && (there.off.length_squared() < end.off.length_squared() || near)
            {
                next = Some((tried, there));
                break;
            }
            share *= 0.5;
        }
        (u, end) = next?;
        if near {
            return Some(Root { u, slope: end.slope, dir: end.dir });
        }
    }
    None
}
