//! Coordinates on a face that scatters: a grid of nodes over it.

use super::tuning::surface_param::{BEYOND, INSIDE, RING};
use crate::manifold::solver::bicubic::{Nodes, Spot};
use eyebox_film::specular_chain::Screen;
use eyebox_world::World;
use eyebox_world::geometry::{Ray, Site};
use glam::{DVec2, DVec3};

/// A grid over the lit part of a face: places are counted along two axes of a plane.
#[derive(Debug, Clone)]
pub struct SurfaceParam {
    pub part: u32,
    pub face: u32,
    corner: DVec3,
    /// Unit: the face is looked for along it.
    normal: DVec3,
    across: [DVec3; 2],
    cell: DVec2,
    pub nodes: Nodes,
    about: DVec3,
}

impl SurfaceParam {
    /// Over the box of a screen's places, with so many cells along its longer side. None where the face can't be met along
    /// its own normal.
    pub fn new(world: &World, screen: &Screen, cells: usize) -> Option<SurfaceParam> {
        let [lo, hi] = screen.bounds.map(DVec3::from_array);
        let seed = screen.seeds.first()?;
        let (place, dir) = (DVec3::from_array(seed.place), DVec3::from_array(seed.dir));
        let size = (hi - lo).length();
        // The normal there, met from a little off.
        let back = Ray { origin: place + dir * size, dir: -dir, from: None };
        let to_mesh = world.geometry.part_to_world(screen.part).inverse();
        let normal = world.geometry.meet(screen.part, screen.face, &back, to_mesh.transform_point3(place))?.normal;
        let (a, b) = normal.any_orthonormal_pair();
        let corners =
            (0..8usize).map(|k| DVec3::new([lo.x, hi.x][k & 1], [lo.y, hi.y][k >> 1 & 1], [lo.z, hi.z][k >> 2]));
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for corner in corners {
            let q = DVec2::new((corner - place).dot(a), (corner - place).dot(b));
            (low, high) = (low.min(q), high.max(q));
        }
        let longer = (high - low).max_element();
        if !(longer > 0.0 && longer.is_finite()) {
            return None;
        }
        (low, high) = (low + INSIDE * longer, high - INSIDE * longer);
        let size = (high - low).max(DVec2::splat(INSIDE * longer));
        // At least four nodes, for cubics.
        let nodes = |length: f64| ((cells as f64 * length / longer).ceil() as usize).clamp(3, cells.max(3)) + 1;
        let inner = [nodes(size.x), nodes(size.y)];
        let cell = size / DVec2::new((inner[0] - 1) as f64, (inner[1] - 1) as f64);
        let low = low - RING as f64 * cell;
        let corner = place + a * low.x + b * low.y + normal * (2.0 * longer);
        let count = inner.map(|nodes| nodes + 2 * RING);
        Some(SurfaceParam {
            part: screen.part,
            face: screen.face,
            corner,
            normal,
            across: [a, b],
            cell,
            nodes: Nodes { count },
            about: to_mesh.transform_point3(place),
        })
    }

    pub fn across(&self) -> [DVec3; 2] {
        self.across
    }

    /// The place on the face at fractional node coordinates.
    pub fn place(&self, world: &World, at: DVec2) -> Option<(DVec3, Site)> {
        let origin = self.corner + self.across[0] * (at.x * self.cell.x) + self.across[1] * (at.y * self.cell.y);
        let ray = Ray { origin, dir: -self.normal, from: None };
        let meet = world.geometry.meet(self.part, self.face, &ray, self.about)?;
        Some((meet.point, Site { part: self.part, face: self.face, triangle: meet.triangle }))
    }

    /// The longer side of a cell, m.
    pub fn cell_size(&self) -> f64 {
        self.cell.max_element()
    }

    /// From one node to another along the axes, m.
    pub fn step(&self, from: usize, to: usize) -> DVec2 {
        (self.nodes.at_node(to) - self.nodes.at_node(from)) * self.cell
    }

    /// A small step over the face, in cells.
    pub fn step_of(&self, moved: DVec3) -> DVec2 {
        DVec2::new(moved.dot(self.across[0]), moved.dot(self.across[1])) / self.cell
    }

    /// From a node to a spot, m along both axes.
    pub fn offset_of(&self, node: usize, spot: &Spot) -> DVec2 {
        (spot.at - self.nodes.at_node(node)) * self.cell
    }

    /// Where a point of the face lies; none beyond the outer nodes.
    pub fn spot(&self, point: DVec3) -> Option<Spot> {
        self.spot_at(self.at(point))
    }

    fn at(&self, point: DVec3) -> DVec2 {
        let off = point - self.corner;
        DVec2::new(off.dot(self.across[0]), off.dot(self.across[1])) / self.cell
    }

    pub fn spot_at(&self, at: DVec2) -> Option<Spot> {
        self.nodes.spot(at)
    }

    /// Of a point beside the map the nearest place in it; none if that is not within `reach`, m.
    pub fn spot_beside(&self, point: DVec3, reach: f64) -> Option<Spot> {
        let at = self.at(point);
        let nearest = at.clamp(DVec2::ZERO, self.last());
        if ((nearest - at) * self.cell).length() <= reach { self.spot_at(nearest) } else { None }
    }

    /// Whether a square about a spot lies within the outer nodes; `reach`: half of its side, m.
    pub fn is_inside(&self, spot: &Spot, reach: f64) -> bool {
        let reach = reach / self.cell;
        (spot.at - reach).cmpge(DVec2::ZERO).all() && (spot.at + reach).cmple(self.last()).all()
    }

    /// The last node.
    fn last(&self) -> DVec2 {
        DVec2::from_array(self.nodes.count.map(|count| (count - 1) as f64))
    }

    /// The cells that such a square touches.
    pub fn cells_within(&self, spot: &Spot, reach: f64) -> impl Iterator<Item = usize> + use<> {
        let [columns, rows] = self.nodes.count;
        let (low, high) = (spot.at - reach / self.cell, spot.at + reach / self.cell);
        let along = |low: f64, high: f64, count: usize| {
            let cell = |at: f64| (at.max(0.0) as usize).min(count - 2);
            cell(low)..=cell(high)
        };
        let across = along(low.x, high.x, columns);
        along(low.y, high.y, rows).flat_map(move |y| across.clone().map(move |x| y * columns + x))
    }

    /// Of a cell of the ring the one beside it that a pilot found light in; none of others.
    pub fn inner_of(&self, cell: usize) -> Option<usize> {
        let [columns, rows] = self.nodes.count;
        let inside = |at: usize, count: usize| at.clamp(RING, count - 2 - RING);
        let inner = inside(cell / columns, rows) * columns + inside(cell % columns, columns);
        (inner != cell).then_some(inner)
    }

    /// Whether a spot in the ring is a sliver beside the rest.
    pub fn is_beside(&self, spot: &Spot) -> bool {
        let along = |x: f64, count: usize| {
            let (low, high) = (RING as f64, (count - 1 - RING) as f64);
            x >= low - BEYOND && x <= high + BEYOND
        };
        along(spot.at.x, self.nodes.count[0]) && along(spot.at.y, self.nodes.count[1])
    }
}
