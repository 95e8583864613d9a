//! What a walk through a tree of plain triangles keeps: the nearest touch so far, or that there is one.

use super::bvh::node::Lanes;
use super::bvh::pack::Pack;
use super::bvh::wide::Visit;
use super::local_ray::{LocalRay, Touch};
use super::patch::{Shear, point_on};
use super::solid::Solid;
use super::surface::Sheet;
use glam::DVec3;
use std::ops::ControlFlow;

/// Looks for the nearest triangle, or any, of a solid whose tree holds nothing but triangles.
pub struct ClosestHit<'a, const ANY: bool> {
    packs: &'a [Pack],
    normals: &'a [[[f32; 3]; 3]],
    faces: &'a [Sheet],
    line: &'a LocalRay,
    /// The line starts on a surface or has one to skip.
    picky: bool,
    /// Where the line enters the tree, t and the place.
    start: f64,
    through: DVec3,
    shear: Shear,
    /// t of the nearest so far.
    pub reach: f64,
    /// Triangle of the mesh that is met there, the first if none is known.
    index: u32,
    found: Option<Found>,
}

/// A lane of a pack, and the weights of its corners.
struct Found {
    leaf: u32,
    lane: usize,
    weights: [f64; 3],
}

impl<'a, const ANY: bool> ClosestHit<'a, ANY> {
    /// Up to `reach`, where the triangle `index` is met if there is one.
    #[inline(always)]
    pub fn new(
        solid: &'a Solid,
        line: &'a LocalRay,
        start: f64,
        reach: f64,
        index: Option<u32>,
    ) -> ClosestHit<'a, ANY> {
        ClosestHit {
            packs: &solid.packs,
            normals: &solid.normals,
            faces: &solid.faces,
            line,
            picky: line.from != u32::MAX || line.skip != u32::MAX,
            start,
            through: line.origin + start * line.dir,
            shear: Shear::along(line.dir),
            reach,
            index: index.unwrap_or(0),
            found: None,
        }
    }

    /// The nearest triangle that is nearer than what was known.
    #[inline(always)]
    pub fn touch(&self) -> Option<Touch> {
        let found = self.found.as_ref()?;
        let pack = self.packs.get(found.leaf as usize)?;
        let triangle = pack.triangle(found.lane);
        let at = point_on(&triangle.corners, found.weights);
        Some(Touch { t: self.reach, slot: pack.slot(found.lane), triangle, at, weights: found.weights })
    }

    /// Whether a line that starts on a surface or skips one meets this face and triangle at t.
    fn counts(&self, (face, index): (u32, u32), t: f64) -> bool {
        self.faces.get(face as usize).is_some_and(|sheet| {
            let starts_here = sheet.identity == self.line.from;
            let left = starts_here && (sheet.surface.is_plane() || index == self.line.from_triangle);
            face != self.line.skip && !left && (!starts_here || t > self.line.grain)
        })
    }
}

impl<const ANY: bool> Visit for ClosestHit<'_, ANY> {
    #[inline(always)]
    fn leaf(&mut self, leaf: u32, lanes: Option<Lanes>) -> ControlFlow<(), Option<f64>> {
        let Some(pack) = self.packs.get(leaf as usize) else { return ControlFlow::Continue(None) };
        let Some(all) = pack.cross(lanes, &self.shear, self.through, [self.start, self.reach]) else {
            return ControlFlow::Continue(None);
        };
        let mut inside = all.inside;
        while inside != 0 {
            let lane = (inside.trailing_zeros() & 3) as usize;
            inside &= inside - 1;
            let (t, whose) = (all.t[lane], pack.whose(lane));
            // Of equally near ones the first triangle.
            let first = t < self.reach || (!ANY && t == self.reach && whose.1 < self.index);
            if !first || (self.picky && !self.counts(whose, t)) {
                continue;
            }
            if ANY {
                return ControlFlow::Break(());
            }
            super::bvh::huge_pages::fetch(self.normals, pack.slot(lane) as usize);
            let weights = [all.weights[0][lane], all.weights[1][lane], all.weights[2][lane]];
            (self.reach, self.index) = (t, whose.1);
            self.found = Some(Found { leaf, lane, weights });
        }
        ControlFlow::Continue(Some(self.reach))
    }
}
