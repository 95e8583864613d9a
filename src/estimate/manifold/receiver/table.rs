//! One branch of a train for one lamp as a table over a face: solutions at nodes, and what lies between them.

use super::Incoming;
use super::resolution::Errs;
use super::surface_param::SurfaceParam;
use super::tuning::table::QUADS;
pub(in crate::manifold) use super::tuning::table::SLIDES;
use crate::manifold::pixel_span::Span;
use crate::manifold::solver::bicubic::{Rows, Spot};
use crate::manifold::solver::simd_nodes::{Quad, SimdNodes, filled};
use crate::manifold::tuning::eye_subpath::WIDER;
use arrayvec::ArrayVec;
use eyebox_film::accumulate::Light;
use eyebox_world::World;
use eyebox_world::mode::{LaneArray, Mode, lanes};
use eyebox_world::optics::Optics;
use eyebox_world::slide::footprint::{self, Brightness, Footprint};
use glam::{DVec2, DVec3};

/// A place on a slide, mesh units, and how it moves with the place on the lamp.
#[derive(Debug, Clone, Copy)]
pub(in crate::manifold) struct Crossing {
    pub(in crate::manifold) slide: usize,
    pub(in crate::manifold) local: DVec3,
    pub(in crate::manifold) by_lamp: [DVec3; 2],
}

impl Crossing {
    /// The place for a point of the lamp that is `off` its middle, m.
    pub(in crate::manifold) fn at(&self, off: DVec2) -> DVec3 {
        self.local + self.by_lamp[0] * off.x + self.by_lamp[1] * off.y
    }
}

/// A solution at a node, for the middle of the lamp.
#[derive(Debug, Clone)]
pub(super) struct Node<M: Mode> {
    pub(super) dir: DVec3,
    pub(super) by_lamp: [DVec3; 2],
    pub(super) by_place: [DVec3; 2],
    /// What the whole lamp sends this way, per lane: luminance × solid angle, cd/m²·sr, with the slides open.
    pub(super) strength: M::Lanes<f64>,
    pub(super) alone: bool,
    pub(super) slides: ArrayVec<Crossing, SLIDES>,
    pub(super) exact_only: bool,
}

impl<M: Mode> Node<M> {
    /// How much the direction changes per metre of the face.
    pub(super) fn by_place_size(&self) -> f64 {
        self.by_place[0].length().max(self.by_place[1].length())
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Cell {
    Nothing,
    Interpolated,
    Solved,
    /// Of the ring about what a pilot found, beside a cell with solutions, where no table tells how far the light reaches.
    Rim,
}

/// One branch of a train for one lamp.
#[derive(Debug)]
pub(super) struct ReceiverTable<M: Mode> {
    pub(super) nodes: Vec<Option<Node<M>>>,
    /// What of the nodes is blended; none before they are all there.
    lean: Option<SimdNodes>,
    pub(super) cells: Vec<Cell>,
    /// Of the cells with solutions, in no order.
    pub(super) errs: Vec<Errs>,
}

/// What the nodes say of a place between them.
pub(super) struct Blend<'s, M: Mode> {
    near: &'s Node<M>,
    /// Of the middle of the lamp.
    sums: [Quad; QUADS],
    /// The place on the lamp, from its middle, m.
    off: DVec2,
}

impl<M: Mode> Blend<'_, M> {
    fn three(&self, at: usize) -> DVec3 {
        DVec3::from_slice(&self.sums.as_flattened()[at..at + 3])
    }

    fn moved(&self, by_lamp: &[DVec3; 2]) -> DVec3 {
        by_lamp[0] * self.off.x + by_lamp[1] * self.off.y
    }

    pub(super) fn dir(&self) -> DVec3 {
        self.three(0) + self.moved(&self.near.by_lamp)
    }

    pub(super) fn strength(&self, lane: usize) -> f64 {
        self.sums.as_flattened()[3 + lane]
    }

    /// Slides that are crossed, and where, mesh units.
    pub(super) fn slides(&self) -> impl ExactSizeIterator<Item = (usize, DVec3)> {
        let place = |(k, crossing): (usize, &Crossing)| {
            (crossing.slide, self.three(3 + M::LANES + 3 * k) + self.moved(&crossing.by_lamp))
        };
        self.near.slides.iter().enumerate().map(place)
    }

    pub(super) fn alone(&self) -> bool {
        self.near.alone
    }
}

impl<M: Mode> ReceiverTable<M> {
    /// Of so many nodes, none of which has a solution yet.
    pub(super) fn new(nodes: usize) -> Self {
        ReceiverTable { nodes: vec![None; nodes], lean: None, cells: vec![Cell::Nothing; nodes], errs: Vec::new() }
    }

    /// To be called when all nodes are there, before they are blended.
    pub(super) fn gather(&mut self) {
        const { assert!(3 + M::LANES + 3 * SLIDES <= 4 * QUADS) };
        let slides = self.nodes.iter().flatten().map(|node| node.slides.len()).max().unwrap_or(0);
        let mut lean = SimdNodes::new(self.nodes.len(), (3 + M::LANES + 3 * slides).div_ceil(4), 0.0);
        for (node, lean) in self.nodes.iter().zip(lean.nodes_mut()) {
            let Some(node) = node else { continue };
            let places = node.slides.iter().flat_map(|crossing| crossing.local.to_array());
            let numbers = node.dir.to_array().into_iter().chain(node.strength.as_slice().iter().copied()).chain(places);
            lean.iter_mut().zip(numbers).for_each(|(place, number)| *place = number);
        }
        self.lean = Some(lean);
    }

    /// All numbers of the nodes in these rows, blended; zeros follow.
    #[inline]
    fn blended(&self, rows: &Rows) -> Option<[Quad; QUADS]> {
        let lean = self.lean.as_ref()?;
        match lean.stride() {
            1 => lean.blend::<1>(rows).map(filled),
            2 => lean.blend::<2>(rows).map(filled),
            3 => lean.blend::<3>(rows).map(filled),
            _ => lean.blend::<QUADS>(rows),
        }
    }

    /// Whether the nodes about a spot are all there and can be blended.
    pub(super) fn is_whole(&self, spot: &Spot) -> bool {
        let Some(near) = self.nodes[spot.cell].as_ref() else { return false };
        spot.nodes().all(|(node, _)| {
            self.nodes[node].as_ref().is_some_and(|node| {
                !node.exact_only && node.alone == near.alone && node.slides.len() == near.slides.len()
            })
        })
    }

    /// How connections at a spot of a map are made.
    pub(super) fn cell(&self, map: &SurfaceParam, spot: &Spot) -> Cell {
        match self.cells[spot.cell] {
            Cell::Rim if map.is_beside(spot) => Cell::Solved,
            Cell::Rim => Cell::Nothing,
            cell @ (Cell::Nothing | Cell::Interpolated | Cell::Solved) => cell,
        }
    }

    /// The nodes' solutions in between, in a cell by rows of nodes about it; only where they are whole.
    #[inline]
    pub(super) fn blend(&self, (cell, rows): (usize, &Rows), off: DVec2) -> Option<Blend<'_, M>> {
        Some(Blend { near: self.nodes[cell].as_ref()?, sums: self.blended(rows)?, off })
    }

    /// The direction alone; none before the nodes are all there.
    pub(super) fn blend_dir(&self, spot: &Spot, off: DVec2) -> Option<DVec3> {
        let near = self.nodes[spot.cell].as_ref()?;
        let lean = self.lean.as_ref()?;
        let [dir] = lean.blend(&spot.rows())?;
        let dir = DVec3::from_slice(&dir);
        Some(dir + near.by_lamp[0] * off.x + near.by_lamp[1] * off.y)
    }

    #[inline]
    pub(super) fn interpolate(
        &self,
        (world, optics): (&World, &Optics<M>),
        near: (usize, &Rows),
        lamp: usize,
        off: DVec2,
    ) -> Option<Incoming<'static, M>> {
        let blend = self.blend(near, off)?;
        let mut light = lanes::<M, _>(|lane| Light::ONE.scaled(blend.strength(lane)));
        for (slide, at) in blend.slides() {
            let map = &world.slides[slide];
            let s = optics.slide(map, at)?;
            optics.cross_slide(&mut light, (map, world.rank(slide)), &s);
        }
        Some(Incoming { lamp, letters: &[], dir: blend.dir().normalize(), light, alone: blend.alone() })
    }
}

impl<M: Mode> ReceiverTable<M> {
    /// Whether what comes in a cell crosses slides.
    pub(super) fn crosses_slides(&self, cell: usize) -> bool {
        self.nodes[cell].as_ref().is_some_and(|node| !node.slides.is_empty())
    }

    /// Whether anything does.
    pub(super) fn crosses_any_slides(&self) -> bool {
        self.nodes.iter().flatten().any(|node| !node.slides.is_empty())
    }

    /// The pixel's footprints on the slides that are crossed. `along`: rows of nodes along the pixel to the right and down.
    fn footprints(
        &self,
        blend: &Blend<'_, M>,
        (along, span): (&[Rows; 2], &Span),
    ) -> Option<ArrayVec<Footprint, SLIDES>> {
        let [right, down] = [self.blended(&along[0])?, self.blended(&along[1])?];
        let footprint = |(k, (slide, at)): (usize, (usize, DVec3))| {
            let first = 3 + M::LANES + 3 * k;
            let by = [&right, &down].map(|sums| DVec3::from_slice(&sums.as_flattened()[first..first + 3]));
            Footprint { slide, at: at - by[0] * span.within.x - by[1] * span.within.y, by }
        };
        Some(blend.slides().enumerate().map(footprint).collect())
    }

    /// What comes through slides over all of a pixel, and of how many pieces of their pictures that is.
    fn mean(
        tracing: (&World, &Optics<M>),
        blend: &Blend<'_, M>,
        footprints: &[Footprint],
    ) -> Option<(M::Lanes<Light>, u64)> {
        let none = lanes::<M, _>(|_| 0.0);
        let brightness = Brightness::<M> { middle: lanes::<M, _>(|lane| blend.strength(lane)), by: [none; 2] };
        footprint::mean(tracing, &brightness, (&[], footprints))
    }

    /// See [`Receivers::edge_moves`](super::Receivers::edge_moves). `pupil`: rows of nodes along how the place moves from the middle of
    /// the pupil to its rim; `size`: the lamp's, m.
    pub(super) fn edge_moves(
        &self,
        world: &World,
        near: (usize, &Rows),
        over: (&[Rows; 2], &Span),
        (pupil, size): (&[Rows; 2], f64),
    ) -> Option<f64> {
        let blend = self.blend(near, DVec2::ZERO)?;
        let footprints = self.footprints(&blend, over)?;
        let by_pupil = [self.blended(&pupil[0])?, self.blended(&pupil[1])?];
        let of_slide = |(k, (footprint, crossing)): (usize, (&Footprint, &Crossing))| {
            let first = 3 + M::LANES + 3 * k;
            let by_pupil = by_pupil.each_ref().map(|sums| DVec3::from_slice(&sums.as_flattened()[first..first + 3]));
            let discs = [by_pupil, crossing.by_lamp.map(|by| size * by)];
            world.slides[footprint.slide].edge_moves(footprint, WIDER, &discs)
        };
        footprints.iter().zip(&blend.near.slides).enumerate().filter_map(of_slide).reduce(f64::max)
    }

    /// [`ReceiverTable::interpolate`] with the slides' pictures taken over all of a pixel.
    pub(super) fn interpolate_over(
        &self,
        tracing: (&World, &Optics<M>),
        near: (usize, &Rows),
        (along, span): (&[Rows; 2], &Span),
        lamp: usize,
        off: DVec2,
    ) -> Option<Incoming<'static, M>> {
        let blend = self.blend(near, off)?;
        let (mean, _) = Self::mean(tracing, &blend, &self.footprints(&blend, (along, span))?)?;
        let mut light = lanes::<M, _>(|lane| mean[lane].scaled(span.whole));
        if span.whole != 1.0
            && let Some(incoming) = self.interpolate(tracing, near, lamp, off)
        {
            (0..M::LANES).for_each(|lane| light[lane].add(incoming.light[lane].scaled(1.0 - span.whole)));
        }
        Some(Incoming { lamp, letters: &[], dir: blend.dir().normalize(), light, alone: blend.alone() })
    }
}

/// A cubic's next value: 4 a − 6 b + 4 c − d for equally spaced values a, b, c, d behind it.
pub(super) fn beyond<M: Mode>(nodes: [&Node<M>; 4]) -> Option<Node<M>> {
    const WEIGHTS: [f64; 4] = [4.0, -6.0, 4.0, -1.0];
    let next = nodes[0];
    if nodes.iter().any(|node| node.exact_only || node.alone != next.alone || node.slides.len() != next.slides.len()) {
        return None;
    }
    let mut out = next.clone();
    out.dir = nodes.iter().zip(WEIGHTS).map(|(node, weight)| weight * node.dir).sum();
    out.strength =
        lanes::<M, _>(|lane| nodes.iter().zip(WEIGHTS).map(|(node, weight)| weight * node.strength[lane]).sum());
    for (k, crossing) in out.slides.iter_mut().enumerate() {
        crossing.local = nodes.iter().zip(WEIGHTS).map(|(node, weight)| weight * node.slides[k].local).sum();
    }
    Some(out)
}
