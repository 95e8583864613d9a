//! What lies at a face: the questions that find solids in contact.

use super::bound::Bounds;
use super::instance::Instance;
use super::{Geometry, Hit, Ray};
use glam::DVec3;
use std::ops::ControlFlow;

/// Faces lie on each other if the cosine between them is at least this (26°).
const ALONG: f64 = 0.9;

impl Geometry {
    /// Whether the box of another part comes within `reach` metres of the box of this one.
    pub fn has_neighbours(&self, part: u32, reach: f64) -> bool {
        self.instance_of(part).is_some_and(|own| {
            let is_near = |other: &Instance| own.bounds.comes_near(other.bounds, reach);
            self.instances.iter().any(|other| other.part != part && is_near(other))
        })
    }

    /// Whether the boxes of two different parts come within `reach` metres of each other.
    pub fn are_near(&self, parts: [u32; 2], reach: f64) -> bool {
        let [a, b] = parts.map(|part| self.instance_of(part));
        parts[0] != parts[1] && a.zip(b).is_some_and(|(a, b)| a.bounds.comes_near(b.bounds, reach))
    }

    /// Whether the box of these points comes within `reach` metres of the box of a part.
    pub fn is_near(&self, part: u32, points: impl Iterator<Item = DVec3>, reach: f64) -> bool {
        let points = Bounds::of(points);
        self.instance_of(part).is_some_and(|instance| instance.bounds.comes_near(points, reach))
    }

    /// The point of a part's face that the line through `p` along the unit vector `normal` meets within `reach` metres.
    pub fn on_face(&self, part: u32, face: u32, p: DVec3, normal: DVec3, reach: f64) -> Option<Hit> {
        let hit = self.meet_part(part, p + reach * normal, -normal, 2.0 * reach)?;
        (hit.site.face == face && hit.normal.dot(normal) > 0.0).then_some(hit)
    }

    /// Where `part` has a face along a surface at `p` with the unit normal `normal`, at most `reach` metres before or
    /// behind it.
    pub fn beside(&self, part: u32, p: DVec3, normal: DVec3, reach: f64) -> Option<Hit> {
        let hit = self.meet_part(part, p + 2.0 * reach * normal, -normal, 4.0 * reach)?;
        ((hit.t - 2.0 * reach).abs() <= reach && hit.normal.dot(normal).abs() > ALONG).then_some(hit)
    }

    /// [`Geometry::beside`] for all parts but `own`, until `visit` breaks.
    pub fn all_beside(
        &self,
        own: u32,
        p: DVec3,
        normal: DVec3,
        reach: f64,
        mut visit: impl FnMut(Hit) -> ControlFlow<()>,
    ) {
        let far = 4.0 * reach;
        let _ = self.top.along(p + 2.0 * reach * normal, -normal, far, |slot| {
            if let Some(instance) = self.instances.get(slot as usize)
                && instance.part != own
                && let Some(hit) = self.beside(instance.part, p, normal, reach)
            {
                visit(hit)?;
            }
            ControlFlow::Continue(far)
        });
    }

    fn instance_of(&self, part: u32) -> Option<&Instance> {
        self.instances.get(*self.slots.get(part as usize)? as usize)
    }

    fn meet_part(&self, part: u32, origin: DVec3, dir: DVec3, reach: f64) -> Option<Hit> {
        let instance = self.instance_of(part)?;
        let solid = &self.solids[instance.solid];
        let ray = Ray { origin, dir, from: None };
        let (touch, t) = instance.nearest(None, solid, &ray, None, reach)?;
        instance.hit(solid, &touch, t)
    }
}
