//! Faces that scatter, joined with lamps over trains of specular faces.
//!
//! For a point y of the face and a point x of the lamp the solver finds the direction from y. What a train brings is
//! smooth over a face but for the slides' pictures: so per train and lamp the solutions are kept at the nodes of a grid,
//! and between them direction, strength and places on slides are interpolated wherever a solution in the middle of a cell
//! says that this errs by no more than [`TOLERANCE`]. In other cells every connection is solved for. Cells without a
//! solution are left to whoever computes the rest.

use super::connections::index_of;
use super::face_map::{FaceMap, Spot};
use super::solve::{Family, Root, Target, newton, trace};
use crate::base::chain::Chain;
use crate::base::rng::{Rng, Stream};
use crate::estimate::ledger::Ledger;
use crate::estimate::walk::{Travel, Walker};
use crate::film::accumulate::Light;
use crate::film::train::{Screen, Train};
use crate::world::World;
use crate::world::geometry::{Ray, Site};
use crate::world::interior::Interior;
use crate::world::lamp::Lamp;
use crate::world::mode::{Mode, lanes};
use crate::world::optics::Optics;
use crate::world::surface::Surface;
use arrayvec::ArrayVec;
use glam::{DMat2, DVec2, DVec3};
use rayon::prelude::*;
use std::collections::VecDeque;

/// Largest error of an interpolated strength or direction (radians) that is let pass.
pub const TOLERANCE: f64 = 3e-4;
/// Directions nearer than this, in radians, are the same solution.
const SAME: f64 = 1e-6;
/// The same where they are interpolated.
const ABOUT_SAME: f64 = 1e-2;
/// Slides that a train may cross to be interpolated.
const SLIDES: usize = 2;
/// Sheets of one train and lamp.
const MOST_SHEETS: usize = 4;

/// A place on a slide, mesh units, and how it moves with the place on the lamp.
#[derive(Debug, Clone, Copy)]
struct Crossing {
    slide: usize,
    local: DVec3,
    by_lamp: [DVec3; 2],
}

/// A solution at a node, for the middle of the lamp.
#[derive(Debug, Clone)]
struct Node<M: Mode> {
    dir: DVec3,
    by_lamp: [DVec3; 2],
    by_place: [DVec3; 2],
    /// What the whole lamp sends this way, per lane: luminance × solid angle, cd/m²·sr, with the slides open.
    strength: M::Lanes<f64>,
    alone: bool,
    slides: ArrayVec<Crossing, SLIDES>,
    exact_only: bool,
}

/// How far a probe went aside on the lamp, m, and where it crossed slides.
type Aside = (f64, Vec<(usize, DVec3)>);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Cell {
    Nothing,
    Interpolated,
    Solved,
}

/// One branch of a train for one lamp.
#[derive(Debug)]
struct Sheet<M: Mode> {
    nodes: Vec<Option<Node<M>>>,
    cells: Vec<Cell>,
}

#[derive(Debug)]
struct Entry<M: Mode> {
    lamp: usize,
    middle: Target,
    size: f64,
    sheets: Vec<Sheet<M>>,
}

#[derive(Debug)]
struct Lit<M: Mode> {
    map: FaceMap,
    train: Train,
    /// From the lamp.
    chain: Chain,
    entries: Vec<Entry<M>>,
}

/// All of a plan, at the wavelengths of one pass.
#[derive(Debug)]
pub struct Screens<M: Mode> {
    lit: Vec<Lit<M>>,
}

/// Light that comes to a point of a scatterer.
pub struct Incoming<M: Mode> {
    pub lamp: usize,
    /// Unit direction towards where it comes from.
    pub dir: DVec3,
    /// Luminance × solid angle per lane, cd/m²·sr, with the slides as polynomials.
    pub light: M::Lanes<Light>,
    pub alone: bool,
}

impl<M: Mode> Screens<M> {
    pub fn new(world: &World, optics: &Optics<M>, screens: &[Screen]) -> Screens<M> {
        let lit = screens.iter().filter_map(|screen| Lit::new(world, optics, screen)).collect();
        Screens { lit }
    }

    pub fn is_empty(&self) -> bool {
        self.lit.is_empty()
    }

    /// Calls `visit` with what comes to a point of a face from each lamp. `uv`: where on the lamps. `interior`: around the
    /// ray that leaves the point towards a lamp.
    #[allow(clippy::too_many_arguments)] // what a point of a face knows
    pub fn gather(
        &self,
        (world, optics): (&World, &Optics<M>),
        (point, site): (DVec3, Site),
        interior: &dyn Fn(DVec3) -> Interior,
        uv: [f64; 2],
        rng: &mut Rng,
        ledger: &mut Ledger,
        mut visit: impl FnMut(Incoming<M>),
    ) {
        for lit in self.lit.iter().filter(|lit| (lit.map.part, lit.map.face) == (site.part, site.face)) {
            let Some(spot) = lit.map.spot(point) else { continue };
            for entry in &lit.entries {
                let Some(lamp) = world.lamps.get(entry.lamp) else { continue };
                let x = lamp.sample_point(uv);
                let off = entry.middle.local(x.position - entry.middle.point);
                let mut solved: ArrayVec<DVec3, MOST_SHEETS> = ArrayVec::new();
                for sheet in &entry.sheets {
                    match sheet.cell(&spot) {
                        Cell::Nothing => {}
                        Cell::Interpolated => {
                            if let Some(incoming) = sheet.interpolate(world, optics, &spot, entry.lamp, off) {
                                visit(incoming);
                            }
                        }
                        Cell::Solved => {
                            let target = Target::new(x.position, x.normal);
                            let Some((root, dir, wide)) =
                                lit.solve((world, optics), entry, sheet, &spot, (point, site), &target)
                            else {
                                continue;
                            };
                            if solved.iter().any(|other| other.distance(dir) <= SAME) {
                                continue;
                            }
                            solved.push(dir);
                            let start = (point, site, interior(dir), rng.fork());
                            let found = lit.follow((world, optics), entry.lamp, start, dir, ledger);
                            if let Some((light, alone)) = found {
                                let factor = lamp.area_m2 * wide / root.slope.determinant().abs();
                                if factor.is_finite() {
                                    let light = lanes::<M, _>(|lane| light[lane].scaled(factor));
                                    visit(Incoming { lamp: entry.lamp, dir, light, alone });
                                }
                            }
                        }
                    }
                }
            }
        }
    }

    /// Whether the path from a point of `lamp` over `chain` (from the lamp) that arrives at a point of a face along `dir` is
    /// one that [`Screens::gather`] finds for these ends.
    pub fn owns(
        &self,
        (world, optics): (&World, &Optics<M>),
        chain: &Chain,
        (lamp, target): (usize, &Target),
        (point, site, dir): (DVec3, Site, DVec3),
    ) -> bool {
        let face = |lit: &&Lit<M>| (lit.map.part, lit.map.face) == (site.part, site.face) && lit.chain == *chain;
        self.lit.iter().filter(face).any(|lit| {
            let Some(spot) = lit.map.spot(point) else { return false };
            lit.entries.iter().filter(|entry| entry.lamp == lamp).any(|entry| {
                let off = entry.middle.local(target.point - entry.middle.point);
                entry.sheets.iter().any(|sheet| match sheet.cell(&spot) {
                    Cell::Nothing => false,
                    Cell::Interpolated => sheet
                        .interpolate(world, optics, &spot, lamp, off)
                        .is_some_and(|incoming| incoming.dir.distance(-dir) <= ABOUT_SAME),
                    Cell::Solved => lit
                        .solve((world, optics), entry, sheet, &spot, (point, site), target)
                        .is_some_and(|(_, found, _)| found.distance(-dir) <= SAME),
                })
            })
        })
    }
}

impl<M: Mode> Sheet<M> {
    /// How connections at a spot are made.
    fn cell(&self, spot: &Spot) -> Cell {
        match self.cells[spot.cell] {
            Cell::Interpolated if spot.outside => Cell::Solved,
            cell @ (Cell::Nothing | Cell::Interpolated | Cell::Solved) => cell,
        }
    }

    fn interpolate(
        &self,
        world: &World,
        optics: &Optics<M>,
        spot: &Spot,
        lamp: usize,
        off: DVec2,
    ) -> Option<Incoming<M>> {
        let near = self.nodes[spot.cell].as_ref()?;
        let mut dir = DVec3::ZERO;
        let mut strength = lanes::<M, _>(|_| 0.0);
        let mut slides: ArrayVec<DVec3, SLIDES> = near.slides.iter().map(|_| DVec3::ZERO).collect();
        for (node, weight) in spot.nodes() {
            let node = self.nodes[node].as_ref()?;
            dir += weight * node.dir;
            for lane in 0..M::LANES {
                strength[lane] += weight * node.strength[lane];
            }
            slides.iter_mut().zip(&node.slides).for_each(|(at, crossing)| *at += weight * crossing.local);
        }
        dir += near.by_lamp[0] * off.x + near.by_lamp[1] * off.y;
        let mut light = lanes::<M, _>(|lane| Light::ONE.scaled(strength[lane]));
        for (at, crossing) in slides.iter().zip(&near.slides) {
            let map = &world.slides[crossing.slide];
            let s = optics.slide(map, *at + crossing.by_lamp[0] * off.x + crossing.by_lamp[1] * off.y)?;
            let dark = 1.0 / map.contrast();
            for lane in 0..M::LANES {
                let value = map.t_white() * (dark + s[lane] * (1.0 - dark));
                light[lane].cross(map.t_white(), value, s[lane]);
            }
        }
        Some(Incoming { lamp, dir: dir.normalize(), light, alone: near.alone })
    }
}

impl<M: Mode> Lit<M> {
    fn new(world: &World, optics: &Optics<M>, screen: &Screen) -> Option<Lit<M>> {
        let map = FaceMap::new(world, screen)?;
        let chain = screen.train.chain().reversed();
        let mut lit = Lit { map, train: screen.train.clone(), chain, entries: Vec::new() };
        let lamps = world.lamps.all().iter().enumerate();
        let lamps: Vec<(usize, &Lamp)> =
            lamps.filter(|(_, lamp)| lamp.group == screen.group && lamp.flux_lm > 0.0).collect();
        let entries: Vec<Entry<M>> = lamps
            .par_iter()
            .map(|(index, lamp)| {
                let (centre, radius) = lamp.around();
                let middle = Target::new(centre, lamp.sample_point([0.5, 0.5]).normal);
                let mut entry = Entry { lamp: *index, middle, size: radius, sheets: Vec::new() };
                // A lamp that the pilot found no path from starts with its neighbours' directions.
                let own = screen.seeds.iter().filter(|seed| seed.lamp as usize == *index);
                let rest = screen.seeds.iter().filter(|seed| seed.lamp as usize != *index);
                for seed in own.chain(rest) {
                    lit.grow((world, optics), &mut entry, DVec3::from_array(seed.place), DVec3::from_array(seed.dir));
                }
                entry
            })
            .collect();
        lit.entries = entries.into_iter().filter(|entry| !entry.sheets.is_empty()).collect();
        (!lit.entries.is_empty()).then_some(lit)
    }

    /// Solves from a start for the direction to the target: root, direction, and sr per unit of its parameters.
    fn newton(
        &self,
        (world, optics): (&World, &Optics<M>),
        size: f64,
        (point, site): (DVec3, Site),
        axis: DVec3,
        target: &Target,
    ) -> Option<(Root, DVec3, f64)> {
        let axis = axis.try_normalize()?;
        let (a, b) = axis.any_orthonormal_pair();
        let family = Family::Point { origin: point, from: Some(site), axis, across: [a, b] };
        let root = newton(world, &index_of(optics), &family, DVec2::ZERO, &self.train, target, size)?;
        let long = axis + a * root.u.x + b * root.u.y;
        let length = long.length();
        Some((root, long / length, length.powi(-3)))
    }

    /// Solves for a point in a cell of a sheet.
    fn solve(
        &self,
        tracing: (&World, &Optics<M>),
        entry: &Entry<M>,
        sheet: &Sheet<M>,
        spot: &Spot,
        from: (DVec3, Site),
        target: &Target,
    ) -> Option<(Root, DVec3, f64)> {
        let known = spot.nodes().filter(|(node, _)| sheet.nodes[*node].is_some());
        let (first, _) = known.max_by(|a, b| a.1.total_cmp(&b.1))?;
        let node = sheet.nodes[first].as_ref()?;
        let off = entry.middle.local(target.point - entry.middle.point);
        let at = self.map.from_node(first, spot);
        let start = node.dir
            + node.by_place[0] * at.x
            + node.by_place[1] * at.y
            + node.by_lamp[0] * off.x
            + node.by_lamp[1] * off.y;
        self.newton(tracing, entry.size, from, start, target)
    }

    /// Follows a solution as any path is followed. Returns the lamp's luminance as it arrives, per lane.
    fn follow(
        &self,
        (world, optics): (&World, &Optics<M>),
        lamp: usize,
        (point, site, interior, rng): (DVec3, Site, Interior, Rng),
        dir: DVec3,
        ledger: &mut Ledger,
    ) -> Option<(M::Lanes<Light>, bool)> {
        let ray = Ray { origin: point, dir, from: Some(site) };
        let mut walker = Walker::new((world, optics), Travel::FromEye, ray, 1.0, interior, rng);
        // The point is no pupil: what falls into the eye on the way is stopped there.
        walker.events = 1;
        if !walker.follow(self.train.0.iter().map(|lens| lens.link), ledger, |_, _, _| {}) {
            return None;
        }
        let seen = walker.reach_lamp(ledger).filter(|seen| seen.index == lamp)?;
        Some(walker.seen(&seen))
    }

    /// Adds the branch that has a solution near this one, unless it is known.
    fn grow(&self, (world, optics): (&World, &Optics<M>), entry: &mut Entry<M>, place: DVec3, dir: DVec3) {
        if entry.sheets.len() >= MOST_SHEETS {
            return;
        }
        let Some(spot) = self.map.spot(place) else { return };
        let site = Site { part: self.map.part, face: self.map.face, triangle: u32::MAX };
        let middle = entry.middle;
        let Some((_, dir, _)) = self.newton((world, optics), entry.size, (place, site), dir, &middle) else { return };
        let known = entry.sheets.iter().any(|sheet| {
            let found = self.solve((world, optics), entry, sheet, &spot, (place, site), &middle);
            found.is_some_and(|(_, other, _)| other.distance(dir) <= SAME)
        });
        if known {
            return;
        }
        let mut sheet = Sheet { nodes: vec![None; self.map.nodes()], cells: vec![Cell::Nothing; self.map.nodes()] };
        let mut tried = vec![false; self.map.nodes()];
        let mut open = VecDeque::from([(spot.cell, dir)]);
        while let Some((at, start)) = open.pop_front() {
            if std::mem::replace(&mut tried[at], true) {
                continue;
            }
            let Some(node) = self.node((world, optics), entry, self.map.at_node(at), start) else { continue };
            for next in self.map.neighbours(at).filter(|next| !tried[*next]) {
                let step = self.map.step(at, next);
                open.push_back((next, node.dir + node.by_place[0] * step.x + node.by_place[1] * step.y));
            }
            sheet.nodes[at] = Some(node);
        }
        if !self.is_small((world, optics), entry, &sheet) {
            return;
        }
        self.complete((world, optics), &mut sheet);
        for cell in self.map.cells() {
            sheet.cells[cell] = self.judge((world, optics), entry, &sheet, cell);
        }
        if sheet.cells.iter().any(|cell| *cell != Cell::Nothing) {
            entry.sheets.push(sheet);
        }
    }

    /// Whether what a few nodes see of the lamp is much the same all over it: of a large lamp, or of one with a narrow beam,
    /// the middle tells nothing, and its points would be joined for nothing most of the time. Photons do better there.
    fn is_small(&self, tracing: (&World, &Optics<M>), entry: &Entry<M>, sheet: &Sheet<M>) -> bool {
        const LOOKS: usize = 5;
        // Of the lamp's radius: corners of a square are a little farther out.
        const ASIDE: f64 = 0.7;
        // The mean over opposite points may differ from the middle by this share, and each of them by half.
        const EVEN: f64 = 3e-3;
        let known: Vec<usize> = (0..sheet.nodes.len()).filter(|node| sheet.nodes[*node].is_some()).collect();
        let step = known.len().div_ceil(LOOKS).max(1);
        let even = known.iter().skip(step / 2).step_by(step).filter(|at| {
            let Some(node) = &sheet.nodes[**at] else { return false };
            let [a, b] = entry.middle.across.map(|axis| axis * (ASIDE * entry.size));
            let strengths = [a, -a, b, -b].map(|off| {
                let target = Target { point: entry.middle.point + off, ..entry.middle };
                let found = self.node_to(tracing, entry, &target, self.map.at_node(**at), node.dir);
                found.map_or(0.0, |found| found.strength[0])
            });
            let mean = strengths.iter().sum::<f64>() / 4.0;
            let middle = node.strength[0];
            (mean - middle).abs() <= EVEN * middle && strengths.iter().all(|s| (s - middle).abs() <= 0.5 * middle)
        });
        // Near folds and rims it is never even; a good part of the face has to be.
        let looked = known.iter().skip(step / 2).step_by(step).count();
        3 * even.count() >= looked.max(1)
    }

    /// Adds nodes just beyond what is lit, by cubics through the four nodes next to them along a row or a column: where
    /// the edge is that of a slide's picture, cells on it can be interpolated, and the picture itself says where it ends.
    fn complete(&self, (world, optics): (&World, &Optics<M>), sheet: &mut Sheet<M>) {
        let missing = (0..self.map.nodes()).filter(|node| sheet.nodes[*node].is_none());
        let added: Vec<(usize, Node<M>)> = missing
            .filter_map(|node| {
                let lines = self.map.lines(node);
                let found = lines.into_iter().flatten().find_map(|line| {
                    let [a, b, c, d] = line.map(|node| sheet.nodes[node].as_ref());
                    beyond([a?, b?, c?, d?])
                })?;
                let outside =
                    |crossing: &Crossing| optics.slide(&world.slides[crossing.slide], crossing.local).is_none();
                found.slides.iter().any(outside).then_some((node, found))
            })
            .collect();
        for (node, found) in added {
            sheet.nodes[node] = Some(found);
        }
    }

    /// Whether a cell can be interpolated: by a solution in its middle.
    fn judge(&self, tracing: (&World, &Optics<M>), entry: &Entry<M>, sheet: &Sheet<M>, cell: usize) -> Cell {
        let at = self.map.middle(cell);
        let Some(spot) = self.map.spot_at(at) else { return Cell::Nothing };
        let nodes = || spot.nodes().map(|(node, _)| sheet.nodes[node].as_ref());
        if nodes().all(|node| node.is_none()) {
            return Cell::Nothing;
        }
        if !nodes().all(|node| node.is_some_and(|node| !node.exact_only)) {
            return Cell::Solved;
        }
        let near = sheet.nodes[cell].as_ref();
        let Some(found) = near.and_then(|near| self.node(tracing, entry, at, near.dir)) else { return Cell::Solved };
        let mut dir = DVec3::ZERO;
        let mut strength = lanes::<M, _>(|_| 0.0);
        let mut slides: ArrayVec<DVec3, SLIDES> = found.slides.iter().map(|_| DVec3::ZERO).collect();
        for (index, weight) in spot.nodes() {
            let Some(node) = &sheet.nodes[index] else { return Cell::Solved };
            if node.slides.len() != found.slides.len() || node.alone != found.alone {
                return Cell::Solved;
            }
            dir += weight * node.dir;
            for lane in 0..M::LANES {
                strength[lane] += weight * node.strength[lane];
            }
            slides.iter_mut().zip(&node.slides).for_each(|(sum, crossing)| *sum += weight * crossing.local);
        }
        let errs = (0..M::LANES)
            .any(|lane| (strength[lane] - found.strength[lane]).abs() > TOLERANCE * found.strength[lane].abs());
        let moved = slides
            .iter()
            .zip(&found.slides)
            .any(|(at, crossing)| at.distance(crossing.local) > TOLERANCE * tracing.0.slides[crossing.slide].size());
        let turned = dir.distance(found.dir) > TOLERANCE;
        if errs || moved || turned { Cell::Solved } else { Cell::Interpolated }
    }

    /// The solution for the middle of the lamp at fractional node coordinates.
    fn node(&self, tracing: (&World, &Optics<M>), entry: &Entry<M>, at: DVec2, start: DVec3) -> Option<Node<M>> {
        self.node_to(tracing, entry, &entry.middle, at, start)
    }

    /// The same for any of its points.
    fn node_to(
        &self,
        (world, optics): (&World, &Optics<M>),
        entry: &Entry<M>,
        target: &Target,
        at: DVec2,
        start: DVec3,
    ) -> Option<Node<M>> {
        let index = index_of(optics);
        let (point, site) = self.map.place(world, at)?;
        let from = (point, site);
        let (root, dir, wide) = self.newton((world, optics), entry.size, from, start, target)?;
        let (a, b) = dir.any_orthonormal_pair();
        let family = Family::Point { origin: point, from: Some(site), axis: dir, across: [a, b] };
        let straight = trace(world, &index, &family, DVec2::ZERO, &self.train, target)?;
        let inverse: DMat2 = straight.slope.inverse();
        let shifted = Family::Shifted { origin: point, from: Some(site), dir, across: self.map.across() };
        let moved = trace(world, &index, &shifted, DVec2::ZERO, &self.train, target)?;
        let turn = |by: DVec2| a * by.x + b * by.y;
        let by_lamp = [turn(inverse.x_axis), turn(inverse.y_axis)];
        let by_place = -(inverse * moved.slope);
        let by_place = [turn(by_place.x_axis), turn(by_place.y_axis)];
        let lamp = world.lamps.get(entry.lamp)?;
        let factor = lamp.area_m2 * wide / root.slope.determinant().abs();
        let (light, alone, slides) = self.probe((world, optics), entry.lamp, from, dir)?;
        let strength = lanes::<M, _>(|lane| light[lane] * factor);
        // How the places on slides move with the place on the lamp: by the derivative of the direction.
        let step = 0.25 * entry.size;
        let mut crossings: ArrayVec<Crossing, SLIDES> = ArrayVec::new();
        let mut exact_only = slides.len() > SLIDES;
        let aside: [Option<Aside>; 2] = if slides.is_empty() {
            [None, None]
        } else {
            // To the one side or to the other: on one of them the slide's picture may have ended.
            [0, 1].map(|k| {
                [step, -step].into_iter().find_map(|step| {
                    let (_, _, slides) =
                        self.probe((world, optics), entry.lamp, from, (dir + by_lamp[k] * step).normalize())?;
                    Some((step, slides))
                })
            })
        };
        for (k, (slide, local)) in slides.iter().enumerate().take(SLIDES) {
            let by = |axis: usize| -> Option<DVec3> {
                let (step, places) = aside[axis].as_ref()?;
                let other = places.get(k)?;
                (other.0 == *slide).then(|| (other.1 - *local) / *step)
            };
            match (by(0), by(1)) {
                (Some(x), Some(y)) => crossings.push(Crossing { slide: *slide, local: *local, by_lamp: [x, y] }),
                _ => exact_only = true,
            }
        }
        let finite = strength.as_slice_is_finite() && by_lamp.iter().chain(&by_place).all(|v| v.is_finite());
        finite.then_some(Node { dir, by_lamp, by_place, strength, alone, slides: crossings, exact_only })
    }

    /// What arrives along a direction from the lamp, with the slides open, and where it crosses them.
    #[allow(clippy::type_complexity)]
    fn probe(
        &self,
        (world, optics): (&World, &Optics<M>),
        lamp: usize,
        (point, site): (DVec3, Site),
        dir: DVec3,
    ) -> Option<(M::Lanes<f64>, bool, Vec<(usize, DVec3)>)> {
        let mut ledger = Ledger::new(world.solids.len());
        let interior = Interior::of(world.geometry.solids_containing(point + dir * (1e-6 * self.map.cell_size())));
        let ray = Ray { origin: point, dir, from: Some(site) };
        let rng = Rng::new(0, Stream::Pilot, 3, 0);
        let mut walker = Walker::new((world, optics), Travel::FromEye, ray, 1.0, interior, rng);
        walker.events = 1;
        let mut slides = Vec::new();
        let whole = walker.follow(self.train.0.iter().map(|lens| lens.link), &mut ledger, |_, vertex, _| {
            let face = &world.faces[vertex.hit.site.part as usize][vertex.hit.site.face as usize];
            if let Surface::Slide(index) = face.surface {
                slides.push((index, vertex.hit.local));
            }
        });
        let seen = whole.then(|| walker.reach_lamp(&mut ledger))?.filter(|seen| seen.index == lamp)?;
        let (light, alone) = walker.seen(&seen);
        // The slides' share at full opening is the leading coefficient over what they let through when open.
        let open: f64 = slides.iter().map(|(index, _)| world.slides[*index].t_white()).product();
        Some((lanes::<M, _>(|lane| if open > 0.0 { light[lane].open() / open } else { 0.0 }), alone, slides))
    }
}

/// A cubic's next value: 4 a − 6 b + 4 c − d for equally spaced values a, b, c, d behind it.
fn beyond<M: Mode>(nodes: [&Node<M>; 4]) -> Option<Node<M>> {
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

/// Whether all lanes are finite.
trait AllFinite {
    fn as_slice_is_finite(&self) -> bool;
}
impl<L: crate::world::mode::LaneArray<f64>> AllFinite for L {
    fn as_slice_is_finite(&self) -> bool {
        self.as_slice().iter().all(|x| x.is_finite())
    }
}
