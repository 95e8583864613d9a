//! One mesh with its exact surfaces, traced in its own coordinates and shared by the parts that instance it.

use super::bound::Bounds;
use super::bvh::huge_pages;
use super::bvh::node::Lanes;
use super::bvh::pack::Pack;
use super::bvh::tree::Tree;
use super::bvh::wide::Leaf;
use super::closest_hit::ClosestHit;
use super::curved::Curved;
use super::grid::Grid;
use super::local_ray::{LocalRay, Probe, Roots, Touch};
use super::patch::{Projection, Shear, point_on};
use super::surface::{Sheet, Surface};
use super::triangle::{Triangle, winding};
use glam::DVec3;
use std::ops::ControlFlow;

#[derive(Debug)]
pub struct Solid {
    /// Contains everything, with a margin for rounding.
    pub bounds: Bounds,
    /// Of the triangles that are not in a grid.
    pub tree: Tree,
    /// The corners of each leaf of the tree, if its triangles are all no more than triangles; else none.
    pub packs: Vec<Pack>,
    /// Exact height fields: the faces that are looked up by their points, and where.
    pub grids: Vec<(u32, Grid)>,
    /// In the order of the tree's slots, then the grids'.
    pub triangles: Vec<Triangle>,
    /// Unit normals at the corners, in the same order.
    pub normals: Vec<[[f32; 3]; 3]>,
    /// One per CAD face of the mesh.
    pub faces: Vec<Sheet>,
}

/// Whether a grid's triangles contain a point.
type Covers = fn(&Grid, &Shear, DVec3) -> bool;

impl Solid {
    /// The nearest point of the line on the solid with 0 < t < reach; of equally near ones the first triangle's.
    #[inline(always)]
    pub fn nearest(&self, lanes: Option<Lanes>, line: &LocalRay, reach: f64) -> Option<Touch> {
        if !self.grids.is_empty() || self.packs.is_empty() {
            return self.nearest_of_exact(line, reach);
        }
        let mut hunt = ClosestHit::<false>::new(self, line, line.start, reach, None);
        let _ = self.tree.walk(lanes, [line.origin, line.dir], [line.start, reach], &self.packs, &mut hunt);
        hunt.touch()
    }

    /// The same where there are exact surfaces.
    #[inline(never)]
    fn nearest_of_exact(&self, line: &LocalRay, reach: f64) -> Option<Touch> {
        let mut best: Option<Touch> = None;
        let mut reach = reach;
        let mut consider = |touch: Touch, reach: &mut f64| {
            let first = match &best {
                _ if touch.t < *reach => true,
                Some(other) => touch.triangle.index < other.triangle.index,
                None => false,
            };
            if first {
                *reach = touch.t;
                best = Some(touch);
            }
        };
        for (face, grid) in &self.grids {
            if let Some(touch) = self.look_up(*face, grid, line, reach, Grid::covers) {
                consider(touch, &mut reach);
            }
        }
        let Some(start) = self.start(line).filter(|start| *start <= reach) else { return best };
        let along = [line.origin, line.dir];
        if !self.packs.is_empty() {
            let mut hunt = ClosestHit::<false>::new(self, line, start, reach, best.map(|best| best.triangle.index));
            let _ = self.tree.walk(None, along, [start, reach], &self.packs, &mut hunt);
            return hunt.touch().or(best);
        }
        let mut probe = Probe::new(line, start);
        let _ = self.tree.candidates(None, along, [start, reach], |leaf| {
            self.each(leaf, |slot, triangle| {
                if let Some(touch) = self.touch(slot, triangle, line, reach, &mut probe) {
                    consider(touch, &mut reach);
                }
                ControlFlow::Continue(())
            })?;
            ControlFlow::Continue(reach)
        });
        best
    }

    /// Calls `visit` with the slots of a leaf and their triangles.
    #[inline(always)]
    fn each(&self, leaf: u32, mut visit: impl FnMut(u32, &Triangle) -> ControlFlow<()>) -> ControlFlow<()> {
        if let Some(Leaf { first, count }) = self.tree.leaves().get(leaf as usize).copied() {
            for slot in first..first + count {
                let Some(triangle) = self.triangles.get(slot as usize) else { break };
                visit(slot, triangle)?;
            }
        }
        ControlFlow::Continue(())
    }

    /// Where the line enters the tree's bounds. Without grids the tree holds all that the solid's bounds do.
    #[inline]
    fn start(&self, line: &LocalRay) -> Option<f64> {
        if self.grids.is_empty() { Some(line.start) } else { self.tree.bounds.enter(line.origin, line.dir) }
    }

    /// Where the line meets a face that has a grid, with 0 < t ≤ reach. Its first triangle stands for all of an exact face:
    /// nobody needs to know which it is.
    #[inline]
    fn look_up(&self, face: u32, grid: &Grid, line: &LocalRay, reach: f64, covers: Covers) -> Option<Touch> {
        let sheet = self.faces.get(face as usize)?;
        let (quadric, shear) = match &sheet.surface {
            Surface::Exact { quadric, projection: Projection::Axial(shear), .. } => (quadric, shear),
            Surface::Curved { curved, .. } => return self.look_up_curved(face, curved, grid, line, reach, covers),
            Surface::Exact { .. } | Surface::Absent | Surface::Flat | Surface::Faceted => return None,
        };
        let starts_here = sheet.identity == line.from;
        if face == line.skip || (starts_here && sheet.surface.is_plane()) {
            return None;
        }
        for t in quadric.intersect(line.origin, line.dir, starts_here) {
            if !(t > 0.0 && t <= reach && t < f64::INFINITY) {
                continue;
            }
            let at = line.origin + t * line.dir;
            // The far half of an ellipsoid and the other sheet of a hyperboloid are not meant.
            if quadric.branch(at) > 0.0
                && covers(grid, shear, at)
                && let Some(triangle) = self.triangles.get(grid.first() as usize)
            {
                return Some(Touch { t, slot: grid.first(), triangle: *triangle, at, weights: [0.0; 3] });
            }
        }
        None
    }

    /// The same for surfaces beyond quadrics, kept apart so that those stay small.
    #[inline(never)]
    fn look_up_curved(
        &self,
        face: u32,
        curved: &Curved,
        grid: &Grid,
        line: &LocalRay,
        reach: f64,
        covers: Covers,
    ) -> Option<Touch> {
        let shear = curved.shear.as_ref()?;
        let starts_here = self.faces.get(face as usize).is_some_and(|sheet| sheet.identity == line.from);
        if face == line.skip {
            return None;
        }
        let mut touch = None;
        // A touch at the reach itself counts.
        let _ = curved.along(line.origin, line.dir, starts_here, reach.next_up(), &mut |t, at| {
            if covers(grid, shear, at)
                && let Some(triangle) = self.triangles.get(grid.first() as usize)
            {
                touch = Some(Touch { t, slot: grid.first(), triangle: *triangle, at, weights: [0.0; 3] });
                return ControlFlow::Break(());
            }
            ControlFlow::Continue(())
        });
        touch
    }

    /// Where the line meets the patch of a curved surface that a slot's triangle stands for.
    #[inline(never)]
    fn touch_curved(
        &self,
        slot: u32,
        triangle: &Triangle,
        curved: &Curved,
        line: &LocalRay,
        reach: f64,
        probe: &mut Probe,
    ) -> Option<Touch> {
        let starts_here = self.faces.get(triangle.face as usize).is_some_and(|sheet| sheet.identity == line.from);
        let all = probe.many_of(triangle.face, || {
            let mut all = Vec::new();
            let _ = curved.along(line.origin, line.dir, starts_here, f64::INFINITY, &mut |t, at| {
                all.push((t, at));
                ControlFlow::Continue(())
            });
            all
        });
        let mut near = all.iter().take_while(|(t, _)| *t <= reach);
        let found = near.find(|(_, at)| curved.belongs(*at, &triangle.corners));
        found.map(|(t, at)| Touch { t: *t, slot, triangle: *triangle, at: *at, weights: [0.0; 3] })
    }

    /// [`Solid::nearest`] without the tree: every triangle is tried.
    #[cfg(any(test, feature = "testing"))]
    pub fn nearest_of_all(&self, line: &LocalRay, reach: f64) -> Option<Touch> {
        let mut probe = Probe::new(line, self.start(line).unwrap_or(0.0));
        let has_grid = |face: u32| self.grids.iter().any(|(other, _)| *other == face);
        let slots = (0..self.triangles.len() as u32).zip(&self.triangles).filter(|(_, t)| !has_grid(t.face));
        let mut all: Vec<Touch> =
            slots.filter_map(|(slot, triangle)| self.touch(slot, triangle, line, reach, &mut probe)).collect();
        // A grid has its own rounding at edges, which is no matter of its cells.
        all.extend(
            self.grids.iter().filter_map(|(face, grid)| self.look_up(*face, grid, line, reach, Grid::covers_by_all)),
        );
        all.retain(|touch| touch.t < reach);
        all.into_iter().min_by(|a, b| a.t.total_cmp(&b.t).then(a.triangle.index.cmp(&b.triangle.index)))
    }

    /// Whether the line meets the solid with 0 < t < reach.
    #[inline(always)]
    pub fn blocks(&self, lanes: Option<Lanes>, line: &LocalRay, reach: f64) -> bool {
        if !self.grids.is_empty() || self.packs.is_empty() {
            return self.blocks_of_exact(line, reach);
        }
        let mut hunt = ClosestHit::<true>::new(self, line, line.start, reach, None);
        self.tree.walk(lanes, [line.origin, line.dir], [line.start, reach], &self.packs, &mut hunt).is_break()
    }

    /// The same where there are exact surfaces.
    #[inline(never)]
    fn blocks_of_exact(&self, line: &LocalRay, reach: f64) -> bool {
        let touches = |touch: Option<Touch>| touch.is_some_and(|touch| touch.t < reach);
        if self.grids.iter().any(|(face, grid)| touches(self.look_up(*face, grid, line, reach, Grid::covers))) {
            return true;
        }
        let Some(start) = self.start(line).filter(|start| *start <= reach) else { return false };
        let along = [line.origin, line.dir];
        if !self.packs.is_empty() {
            let mut hunt = ClosestHit::<true>::new(self, line, start, reach, None);
            return self.tree.walk(None, along, [start, reach], &self.packs, &mut hunt).is_break();
        }
        let mut probe = Probe::new(line, start);
        let visit = |leaf| {
            self.each(leaf, |slot, triangle| {
                let blocked = touches(self.touch(slot, triangle, line, reach, &mut probe));
                if blocked { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            })?;
            ControlFlow::Continue(reach)
        };
        self.tree.candidates(None, along, [start, reach], visit).is_break()
    }

    /// Where the line meets the part of the surface that a slot's triangle stands for, with 0 < t ≤ reach.
    #[inline]
    fn touch(&self, slot: u32, triangle: &Triangle, line: &LocalRay, reach: f64, probe: &mut Probe) -> Option<Touch> {
        let sheet = self.faces.get(triangle.face as usize)?;
        let starts_here = sheet.identity == line.from;
        if triangle.face == line.skip || (starts_here && sheet.surface.is_plane()) {
            return None;
        }
        match &sheet.surface {
            Surface::Absent => None,
            Surface::Flat | Surface::Faceted => {
                if starts_here && triangle.index == line.from_triangle {
                    return None;
                }
                let crossing = probe.shear.cross(&triangle.corners, probe.through)?;
                let t = probe.start + crossing.t;
                let least = if starts_here { line.grain } else { 0.0 };
                let at = || point_on(&triangle.corners, crossing.weights);
                (t > least && t <= reach).then(|| {
                    huge_pages::fetch(&self.normals, slot as usize);
                    Touch { t, slot, triangle: *triangle, at: at(), weights: crossing.weights }
                })
            }
            Surface::Exact { quadric, projection, .. } => {
                let known = probe.roots.take().filter(|roots| roots.face == triangle.face);
                let roots = known.unwrap_or_else(|| Roots::of(triangle.face, quadric, projection, line, starts_here));
                let roots = probe.roots.insert(roots);
                for i in 0..2 {
                    let (t, at) = (roots.t[i], roots.at[i]);
                    // Not so for a root that is missing.
                    let ahead = t <= reach;
                    let inside = ahead
                        && match projection {
                            Projection::Axial(shear) => shear.cross(&triangle.corners, at).is_some(),
                            Projection::Central(centre) => roots.shear[i]
                                .cross(&triangle.corners, *centre)
                                .is_some_and(|crossing| crossing.t > 0.0),
                        };
                    if inside {
                        return Some(Touch { t, slot, triangle: *triangle, at, weights: [0.0; 3] });
                    }
                }
                None
            }
            Surface::Curved { curved, .. } => self.touch_curved(slot, triangle, curved, line, reach, probe),
        }
    }

    /// Normals at a touch, of any length, outward of the solid in its coordinates: of the surface, and for shading, which
    /// may be zero where a file says nothing.
    #[inline(always)]
    pub fn normals_at(&self, touch: &Touch) -> Option<(DVec3, DVec3)> {
        let triangle = &touch.triangle;
        match &self.faces.get(triangle.face as usize)?.surface {
            Surface::Absent => None,
            Surface::Exact { quadric, outward, .. } => {
                let normal = *outward * quadric.normal(touch.at);
                Some((normal, normal))
            }
            Surface::Curved { curved, outward } => {
                let normal = *outward * curved.normal(touch.at);
                Some((normal, normal))
            }
            Surface::Flat | Surface::Faceted => {
                let corners = self.normals.get(touch.slot as usize)?;
                Some((winding(&triangle.corners), point_on(corners, touch.weights)))
            }
        }
    }

    /// The touch moved onto the exact surface as far as f64 can say.
    #[inline(always)]
    pub fn settle(&self, touch: &Touch) -> DVec3 {
        match self.faces.get(touch.triangle.face as usize).map(|sheet| &sheet.surface) {
            Some(Surface::Exact { quadric, .. }) => quadric.settle(touch.at),
            Some(Surface::Curved { curved, .. }) => curved.settle(touch.at),
            Some(Surface::Absent | Surface::Flat | Surface::Faceted) | None => touch.at,
        }
    }
}
