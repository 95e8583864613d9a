//! One branch of a train for one lamp as a table over a face: solutions at nodes, and what lies between them.

use super::Incoming;
use crate::estimate::manifold::nodes::Spot;
use crate::film::accumulate::Light;
use crate::world::World;
use crate::world::mode::{Mode, lanes};
use crate::world::optics::Optics;
use arrayvec::ArrayVec;
use glam::{DVec2, DVec3};

/// Slides that a train may cross to be interpolated.
pub(in crate::estimate::manifold) const SLIDES: usize = 2;

/// A place on a slide, mesh units, and how it moves with the place on the lamp.
#[derive(Debug, Clone, Copy)]
pub(in crate::estimate::manifold) struct Crossing {
    pub(in crate::estimate::manifold) slide: usize,
    pub(in crate::estimate::manifold) local: DVec3,
    pub(in crate::estimate::manifold) by_lamp: [DVec3; 2],
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
}

/// One branch of a train for one lamp.
#[derive(Debug)]
pub(super) struct Sheet<M: Mode> {
    pub(super) nodes: Vec<Option<Node<M>>>,
    pub(super) cells: Vec<Cell>,
}

/// What the nodes say of a place between them.
pub(super) struct Blend<M: Mode> {
    pub(super) dir: DVec3,
    pub(super) strength: M::Lanes<f64>,
    /// Which, and where on it, mesh units.
    pub(super) slides: ArrayVec<(usize, DVec3), SLIDES>,
    pub(super) alone: bool,
}

impl<M: Mode> Sheet<M> {
    /// How connections at a spot are made.
    pub(super) fn cell(&self, spot: &Spot) -> Cell {
        match self.cells[spot.cell] {
            Cell::Interpolated if spot.outside => Cell::Solved,
            cell @ (Cell::Nothing | Cell::Interpolated | Cell::Solved) => cell,
        }
    }

    /// Whether a spot beyond the outer nodes is beside the slides' pictures, so that nothing need be solved for.
    pub(super) fn is_dark(&self, world: &World, optics: &Optics<M>, spot: &Spot, off: DVec2) -> bool {
        spot.outside
            && self.cells[spot.cell] == Cell::Interpolated
            && self.blend(spot, off).is_some_and(|blend| {
                blend.slides.iter().any(|(slide, at)| optics.slide(&world.slides[*slide], *at).is_none())
            })
    }

    /// The nodes' solutions in between; none where one is missing or they do not cross the same slides.
    pub(super) fn blend(&self, spot: &Spot, off: DVec2) -> Option<Blend<M>> {
        let near = self.nodes[spot.cell].as_ref()?;
        let mut dir = DVec3::ZERO;
        let mut strength = lanes::<M, _>(|_| 0.0);
        let mut slides: ArrayVec<(usize, DVec3), SLIDES> =
            near.slides.iter().map(|crossing| (crossing.slide, DVec3::ZERO)).collect();
        for (node, weight) in spot.nodes() {
            let node = self.nodes[node].as_ref()?;
            if node.slides.len() != near.slides.len() || node.alone != near.alone {
                return None;
            }
            dir += weight * node.dir;
            for lane in 0..M::LANES {
                strength[lane] += weight * node.strength[lane];
            }
            slides.iter_mut().zip(&node.slides).for_each(|((_, at), crossing)| *at += weight * crossing.local);
        }
        dir += near.by_lamp[0] * off.x + near.by_lamp[1] * off.y;
        for ((_, at), crossing) in slides.iter_mut().zip(&near.slides) {
            *at += crossing.by_lamp[0] * off.x + crossing.by_lamp[1] * off.y;
        }
        Some(Blend { dir, strength, slides, alone: near.alone })
    }

    pub(super) fn interpolate(
        &self,
        world: &World,
        optics: &Optics<M>,
        spot: &Spot,
        lamp: usize,
        off: DVec2,
    ) -> Option<Incoming<'static, M>> {
        let blend = self.blend(spot, off)?;
        let mut light = lanes::<M, _>(|lane| Light::ONE.scaled(blend.strength[lane]));
        for (slide, at) in &blend.slides {
            let map = &world.slides[*slide];
            let s = optics.slide(map, *at)?;
            for lane in 0..M::LANES {
                light[lane].cross(map.t_white(), map.transmittance(s[lane]), s[lane]);
            }
        }
        Some(Incoming { lamp, letters: &[], dir: blend.dir.normalize(), light, alone: blend.alone })
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
