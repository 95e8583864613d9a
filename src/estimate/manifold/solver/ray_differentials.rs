//! A ray with its derivatives by two parameters, followed through a train of faces.
//!
//! The derivatives of reflection and refraction are those of the laws of `design/formulas.md` section 4, differentiated
//! (the ray differentials of H. Igehy, SIGGRAPH 1999, with the exact change of the normal along the surface), those of diffraction
//! of the phase match in `world/grating.rs`, at one wavelength.

use super::media::Media;
use eyebox_base::chain::Step;
use eyebox_film::specular_chain::{Lens, SpecularChain};
use eyebox_world::World;
use eyebox_world::fresnel::{reflect, refract};
use eyebox_world::geometry::interface_derivatives::{Meet, site_of};
use eyebox_world::geometry::{Ray, Site};
use eyebox_world::grating::diffract;
use eyebox_world::surface::Surface;
use glam::DVec3;

/// A ray and how its origin and direction change with two parameters.
#[derive(Debug, Clone, Copy)]
pub struct RayDifferentials {
    pub ray: Ray,
    /// Per parameter.
    pub origin: [DVec3; 2],
    pub dir: [DVec3; 2],
}

/// A place on a plane, with derivatives.
#[derive(Debug, Clone, Copy)]
pub struct Landing {
    pub point: DVec3,
    pub by: [DVec3; 2],
}

impl RayDifferentials {
    /// Follows the train. None where the ray misses a face, is totally reflected where it should go through, should leave in an
    /// order that is evanescent, or in any but 0 where the media have no wavelength.
    #[inline]
    pub fn through(self, world: &World, train: &SpecularChain, media: &impl Media) -> Option<RayDifferentials> {
        self.through_seen(world, train, media, |_, _| {})
    }

    /// The same; `straight` sees the bundle before each slide and sheet, which bend nothing.
    #[inline]
    pub fn through_seen(
        mut self,
        world: &World,
        train: &SpecularChain,
        media: &impl Media,
        mut straight: impl FnMut(&RayDifferentials, &Lens),
    ) -> Option<RayDifferentials> {
        for lens in &train.0 {
            let order = lens.link.order;
            if order == 0 && lens.link.step == Step::Through && lens.before == lens.after {
                straight(&self, lens);
                continue;
            }
            let (part, face, about) = (lens.link.part, lens.link.face, DVec3::from_array(lens.about));
            let meet = if media.past_rims() {
                world.geometry.meet_past_rim(part, face, &self.ray, about)?
            } else {
                world.geometry.meet(part, face, &self.ray, about)?
            };
            self = if order == 0 { self.at(lens, &meet, media)? } else { self.diffracted(world, lens, &meet, media)? };
        }
        Some(self)
    }

    /// Derivatives of where the ray meets a face.
    fn landed(&self, meet: &Meet) -> [DVec3; 2] {
        let dir = self.ray.dir;
        let along = meet.normal.dot(dir);
        std::array::from_fn(|k| {
            let moved = self.origin[k] + meet.t * self.dir[k];
            moved - dir * (meet.normal.dot(moved) / along)
        })
    }

    fn at(&self, lens: &Lens, meet: &Meet, media: &impl Media) -> Option<RayDifferentials> {
        let dir = self.ray.dir;
        let landed = self.landed(meet);
        let site: Site = site_of(lens.link.part, lens.link.face, meet);
        let ray = |dir: DVec3| Ray { origin: meet.point, dir, from: Some(site) };
        // The normal on the side where the ray arrives.
        let side = if dir.dot(meet.shading) > 0.0 { -1.0 } else { 1.0 };
        let n = side * meet.shading;
        let bent = |k: usize| side * meet.turn(landed[k]);
        let cos = -dir.dot(n);
        let turned = |k: usize, dn: DVec3| self.dir[k].dot(n) + dir.dot(dn);
        match lens.link.step {
            Step::Back => {
                let by = std::array::from_fn(|k| {
                    let dn = bent(k);
                    self.dir[k] - 2.0 * (turned(k, dn) * n - cos * dn)
                });
                Some(RayDifferentials { ray: ray(reflect(dir, n)), origin: landed, dir: by })
            }
            Step::Through => {
                let (n1, n2) = (media.index(lens.before), media.index(lens.after));
                if n1 == n2 {
                    return Some(RayDifferentials { ray: ray(dir), origin: landed, dir: self.dir });
                }
                let eta = n1 / n2;
                let onward = refract(dir, n, eta)?;
                // d' = η d + m n with m = η c₁ − c₂ and c₂² = 1 − η² + η² c₁².
                let cos2 = -onward.dot(n);
                let m = eta * cos - cos2;
                let by = std::array::from_fn(|k| {
                    let dn = bent(k);
                    let dcos = -turned(k, dn);
                    let dm = eta * dcos - eta * eta * cos * dcos / cos2;
                    eta * self.dir[k] + dm * n + m * dn
                });
                Some(RayDifferentials { ray: ray(onward), origin: landed, dir: by })
            }
        }
    }

    /// Leaves a grating: n' d' = t ± √(n'² − t²) N with t = (1 − N Nᵀ)(n d + m λ/d g), in which g is the same all over the face and
    /// the normal N is not.
    fn diffracted(&self, world: &World, lens: &Lens, meet: &Meet, media: &impl Media) -> Option<RayDifferentials> {
        let link = lens.link;
        let Surface::Grating(grating) = &world.faces.get(link.part as usize)?.get(link.face as usize)?.surface else {
            return None;
        };
        let across = world.geometry.part_to_world(link.part).transform_vector3(grating.direction);
        let shift = grating.shift(across, media.nm()?) * f64::from(link.order);
        let dir = self.ray.dir;
        let landed = self.landed(meet);
        let side = if dir.dot(meet.shading) > 0.0 { -1.0 } else { 1.0 };
        let n = side * meet.shading;
        let through = link.step == Step::Through;
        let n1 = media.index(lens.before);
        let n2 = if through { media.index(lens.after) } else { n1 };
        let onward = diffract(dir, n, (n1, n2), shift, through)?;
        let sum = n1 * dir + shift;
        let (high, depth) = (sum.dot(n), n2 * onward.dot(n));
        let along = sum - high * n;
        let by = std::array::from_fn(|k| {
            let (by_sum, dn) = (n1 * self.dir[k], side * meet.turn(landed[k]));
            let by_along = by_sum - high * dn - (by_sum.dot(n) + sum.dot(dn)) * n;
            // The root of n'² − t² keeps its sign.
            (by_along + depth * dn - (along.dot(by_along) / depth) * n) / n2
        });
        let site: Site = site_of(link.part, link.face, meet);
        let ray = Ray { origin: meet.point, dir: onward, from: Some(site) };
        Some(RayDifferentials { ray, origin: landed, dir: by })
    }

    /// Where the ray meets the plane through `point` with this normal, ahead of it; or at once, where a lamp lies on the
    /// last face: to rounding of the places.
    pub fn land(&self, point: DVec3, normal: DVec3) -> Option<Landing> {
        const ROUNDING: f64 = 64.0 * f64::EPSILON;
        let along = normal.dot(self.ray.dir);
        let ahead = normal.dot(point - self.ray.origin) * along.signum();
        let behind = ROUNDING * point.abs().max(self.ray.origin.abs()).max_element();
        let t = ahead / along.abs();
        if !(ahead > -behind && t.is_finite()) {
            return None;
        }
        let by = std::array::from_fn(|k| {
            let moved = self.origin[k] + t * self.dir[k];
            moved - self.ray.dir * (normal.dot(moved) / along)
        });
        Some(Landing { point: self.ray.origin + t * self.ray.dir, by })
    }
}

#[cfg(test)]
#[path = "ray_differentials_tests.rs"]
mod tests;
