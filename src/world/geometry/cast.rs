//! What a ray meets first, and whether it meets anything: walks through the parts and the trees within.

use super::bvh::node::Lanes;
use super::bvh::wide::Visit;
use super::instance::Instance;
use super::local_ray::Touch;
use super::{Geometry, Hit, Ray, Site};
use glam::DVec3;
use std::ops::ControlFlow;

/// Whose nearest point on a ray is looked for.
struct Nearest<'a> {
    all: &'a Geometry,
    ray: &'a Ray,
    beside: Option<&'a Site>,
    reach: f64,
    best: Option<(&'a Instance, Touch)>,
}

impl Visit for Nearest<'_> {
    #[inline(always)]
    fn leaf(&mut self, slot: u32, lanes: Option<Lanes>) -> ControlFlow<(), Option<f64>> {
        if let Some(instance) = self.all.instances.get(slot as usize)
            && let Some(solid) = self.all.solids.get(instance.solid)
            && let Some((touch, t)) = instance.nearest(lanes, solid, self.ray, self.beside.copied(), self.reach)
        {
            self.reach = t;
            self.best = Some((instance, touch));
            return ControlFlow::Continue(Some(t));
        }
        ControlFlow::Continue(None)
    }
}

/// Whether anything but a target is in the way.
struct Blocked<'a> {
    all: &'a Geometry,
    ray: &'a Ray,
    beside: Option<&'a Site>,
    target: Option<Site>,
    reach: f64,
}

impl Visit for Blocked<'_> {
    #[inline(always)]
    fn leaf(&mut self, slot: u32, lanes: Option<Lanes>) -> ControlFlow<(), Option<f64>> {
        if let Some(instance) = self.all.instances.get(slot as usize)
            && let Some(solid) = self.all.solids.get(instance.solid)
            && instance.blocks(lanes, solid, self.ray, [self.beside.copied(), self.target], self.reach)
        {
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(None)
    }
}

impl Geometry {
    /// The first thing that the ray meets at 0 < t < `t_max`. A ray that is not finite or not unit meets nothing.
    #[inline]
    pub fn intersect(&self, ray: &Ray, t_max: f64) -> Option<Hit> {
        self.intersect_beside(ray, None, t_max)
    }

    /// The same for a ray whose origin lies on the surface `beside` too: it leaves both.
    pub fn intersect_beside(&self, ray: &Ray, beside: Option<Site>, t_max: f64) -> Option<Hit> {
        if self.films.is_empty() {
            return self.intersect_met(ray, beside, t_max);
        }
        let met = |site: Option<Site>| site.map(|site| self.films.met(site));
        self.intersect_met(&Ray { from: met(ray.from), ..*ray }, met(beside), t_max)
    }

    #[inline]
    fn intersect_met(&self, ray: &Ray, beside: Option<Site>, t_max: f64) -> Option<Hit> {
        #[cfg(target_arch = "x86_64")]
        if let Some(lanes) = Lanes::here() {
            // SAFETY: the processor has what the function needs.
            return unsafe { self.intersect_in_lanes(lanes, ray, beside, t_max) };
        }
        self.intersect_by(None, ray, beside, t_max)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    fn intersect_in_lanes(&self, lanes: Lanes, ray: &Ray, beside: Option<Site>, t_max: f64) -> Option<Hit> {
        self.intersect_by(Some(lanes), ray, beside, t_max)
    }

    #[inline(always)]
    fn intersect_by(&self, lanes: Option<Lanes>, ray: &Ray, beside: Option<Site>, t_max: f64) -> Option<Hit> {
        if !is_valid(ray) {
            return None;
        }
        let mut nearest = Nearest { all: self, ray, beside: beside.as_ref(), reach: t_max, best: None };
        let _ = self.top.walk(lanes, [ray.origin, ray.dir], t_max, &mut nearest);
        let (instance, touch) = nearest.best.as_ref()?;
        instance.hit(self.solids.get(instance.solid)?, touch, nearest.reach)
    }

    /// Whether anything but the face of `target` is met at 0 < t < `t_max`.
    #[inline]
    pub fn occluded(&self, ray: &Ray, t_max: f64, target: Option<Site>) -> bool {
        self.occluded_beside(ray, None, t_max, target)
    }

    /// The same for a ray whose origin lies on the surface `beside` too.
    pub fn occluded_beside(&self, ray: &Ray, beside: Option<Site>, t_max: f64, target: Option<Site>) -> bool {
        if self.films.is_empty() {
            return self.occluded_met(ray, beside, t_max, target);
        }
        let met = |site: Option<Site>| site.map(|site| self.films.met(site));
        self.occluded_met(&Ray { from: met(ray.from), ..*ray }, met(beside), t_max, met(target))
    }

    #[inline]
    fn occluded_met(&self, ray: &Ray, beside: Option<Site>, t_max: f64, target: Option<Site>) -> bool {
        #[cfg(target_arch = "x86_64")]
        if let Some(lanes) = Lanes::here() {
            // SAFETY: the processor has what the function needs.
            return unsafe { self.occluded_in_lanes(lanes, ray, [beside, target], t_max) };
        }
        self.occluded_by(None, ray, [beside, target], t_max)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    fn occluded_in_lanes(&self, lanes: Lanes, ray: &Ray, spared: [Option<Site>; 2], t_max: f64) -> bool {
        self.occluded_by(Some(lanes), ray, spared, t_max)
    }

    #[inline(always)]
    fn occluded_by(&self, lanes: Option<Lanes>, ray: &Ray, [beside, target]: [Option<Site>; 2], t_max: f64) -> bool {
        let mut blocked = Blocked { all: self, ray, beside: beside.as_ref(), target, reach: t_max };
        is_valid(ray) && self.top.walk(lanes, [ray.origin, ray.dir], t_max, &mut blocked).is_break()
    }
}

/// Finite, and unit as far as it matters.
#[inline(always)]
fn is_valid(ray: &Ray) -> bool {
    // Zero times what is finite is zero.
    ray.origin.dot(DVec3::ZERO) == 0.0 && (0.25..=4.0).contains(&ray.dir.length_squared())
}
