//! How the tables of a face are filled: from what a pilot found, node by node, and cell by cell on trial.

use super::connect::{Connector, Entry, Solution, letter};
use super::resolution::{Errs, slack};
use super::surface_param::SurfaceParam;
use super::table::{Cell, Crossing, Node, ReceiverTable, beyond};
use super::tuning::build::{ASIDE, BESIDE, EVEN, UNEVEN};
use super::{FORETOLD, MOST_SHEETS, SAME, TOLERANCE};
use crate::manifold::solver::bicubic::Spot;
use crate::manifold::solver::newton::Target;
use arrayvec::ArrayVec;
use eyebox_base::parallel;
use eyebox_film::specular_chain::Screen;
use eyebox_world::World;
use eyebox_world::geometry::Site;
use eyebox_world::lamp::Lamp;
use eyebox_world::mode::Mode;
use eyebox_world::optics::Optics;
use glam::{DVec2, DVec3};
use std::collections::VecDeque;

/// What filling a face's table has come to.
pub(super) enum Filled<M: Mode> {
    Lit(Box<Connector<M>>),
    /// There are solutions, but of lamps whose middle does not stand for them: more cells would not change that.
    LampsTooLarge,
    /// Nothing was found between these nodes.
    Nothing,
}

impl<M: Mode> Filled<M> {
    pub(super) fn lit(self) -> Option<Connector<M>> {
        match self {
            Filled::Lit(lit) => Some(*lit),
            Filled::LampsTooLarge | Filled::Nothing => None,
        }
    }
}

/// Branches of one lamp that were filled for nothing: another seed on one need not fill it again.
struct Barren<M: Mode> {
    sheets: Vec<ReceiverTable<M>>,
    /// One was because its lamp is too large.
    too_large: bool,
}

impl<M: Mode> Connector<M> {
    pub(super) fn with_cells(world: &World, optics: &Optics<M>, screen: &Screen, cells: usize) -> Filled<M> {
        let Some(map) = SurfaceParam::new(world, screen, cells) else { return Filled::Nothing };
        let chain = screen.train.chain().reversed();
        let letters = chain.0.iter().map(|link| letter(world, link)).collect();
        let (share, tolerance) = (screen.share, TOLERANCE * slack(screen));
        let mut lit =
            Connector { map, train: screen.train.clone(), chain, letters, entries: Vec::new(), share, tolerance };
        let lamps = world.lamps.all().iter().enumerate();
        let lamps: Vec<(usize, &Lamp)> =
            lamps.filter(|(_, lamp)| lamp.group == screen.group && lamp.flux_lm > 0.0).collect();
        let of_lamp = |(index, lamp): &(usize, &Lamp)| {
            let (centre, radius) = lamp.around();
            let middle = Target::new(centre, lamp.sample_point([0.5, 0.5]).normal);
            let mut entry = Entry { lamp: *index, middle, size: radius, sheets: Vec::new() };
            let mut barren = Barren { sheets: Vec::new(), too_large: false };
            // A lamp that the pilot found no path from starts with its neighbours' directions.
            let own = screen.seeds.iter().filter(|seed| seed.lamp as usize == *index);
            let rest = screen.seeds.iter().filter(|seed| seed.lamp as usize != *index);
            for seed in own.chain(rest) {
                let [place, dir] = [seed.place, seed.dir].map(DVec3::from_array);
                lit.grow((world, optics), &mut entry, &mut barren, (place, dir));
            }
            (entry, barren.too_large)
        };
        let entries: Vec<(Entry<M>, bool)> = parallel::map_all(&lamps, &of_lamp);
        let too_large = entries.iter().any(|(_, too_large)| *too_large);
        lit.entries = entries.into_iter().map(|(entry, _)| entry).filter(|entry| !entry.sheets.is_empty()).collect();
        match (lit.entries.is_empty(), too_large) {
            (false, _) => Filled::Lit(Box::new(lit)),
            (true, true) => Filled::LampsTooLarge,
            (true, false) => Filled::Nothing,
        }
    }

    /// Adds the branch that has a solution near this one, unless it is known.
    fn grow(
        &self,
        (world, optics): (&World, &Optics<M>),
        entry: &mut Entry<M>,
        barren: &mut Barren<M>,
        (place, dir): (DVec3, DVec3),
    ) {
        if entry.sheets.len().max(barren.sheets.len()) >= MOST_SHEETS {
            return;
        }
        let Some(spot) = self.map.spot(place) else { return };
        let site = Site { part: self.map.part, face: self.map.face, triangle: u32::MAX };
        let middle = entry.middle;
        let Some(seed) = self.node((world, optics), entry, spot.at, dir) else { return };
        let known = entry.sheets.iter().chain(&barren.sheets).any(|sheet| {
            // From afar the solver may fall into a branch that the sheet does not have.
            let near = |(dir, change): (DVec3, f64)| dir.distance(seed.dir) <= FORETOLD * change;
            self.foretell(entry, sheet, &spot, &middle).is_some_and(near)
                && self
                    .solve((world, optics), entry, sheet, &spot, (place, site), &middle)
                    .is_some_and(|other| other.dir.distance(seed.dir) <= SAME)
        });
        if known {
            return;
        }
        let mut sheet = ReceiverTable::new(self.map.nodes.number());
        let mut tried = vec![false; self.map.nodes.number()];
        let from_seed = |at: usize| {
            let step = -self.map.offset_of(at, &spot);
            (at, seed.dir + seed.by_place[0] * step.x + seed.by_place[1] * step.y)
        };
        let mut open: VecDeque<(usize, DVec3)> = self.map.nodes.corners(spot.cell).map(from_seed).into();
        while let Some((at, start)) = open.pop_front() {
            if std::mem::replace(&mut tried[at], true) {
                continue;
            }
            let Some(node) = self.node((world, optics), entry, self.map.nodes.at_node(at), start) else { continue };
            // A solution elsewhere than foretold belongs to another branch.
            if node.dir.distance(start) > FORETOLD * self.map.cell_size() * node.by_place_size() {
                continue;
            }
            for next in self.map.nodes.neighbours(at).filter(|next| !tried[*next]) {
                let step = self.map.step(at, next);
                open.push_back((next, node.dir + node.by_place[0] * step.x + node.by_place[1] * step.y));
            }
            sheet.nodes[at] = Some(node);
        }
        if !self.is_small((world, optics), entry, &sheet) {
            barren.too_large = true;
            barren.sheets.push(sheet);
            return;
        }
        self.complete((world, optics), &mut sheet);
        sheet.gather();
        for cell in self.map.nodes.cells() {
            let (judged, errs) = self.judge((world, optics), entry, &sheet, cell);
            sheet.cells[cell] = judged;
            sheet.errs.extend(errs);
        }
        for cell in self.map.nodes.cells().filter(|cell| sheet.cells[*cell] == Cell::Nothing).collect::<Vec<_>>() {
            let beside = self.map.inner_of(cell).map(|inner| sheet.cells[inner]);
            if matches!(beside, Some(Cell::Interpolated | Cell::Solved)) {
                sheet.cells[cell] = Cell::Rim;
            }
        }
        let sheets = match sheet.cells.iter().any(|cell| *cell != Cell::Nothing) {
            true => &mut entry.sheets,
            false => &mut barren.sheets,
        };
        sheets.push(sheet);
    }

    /// Whether a few nodes see most of the lamp over this train: of a large lamp, or of one with a narrow beam, the middle tells
    /// nothing, and its points would be joined for nothing most of the time. Photons do better there.
    pub(super) fn is_small(&self, tracing: (&World, &Optics<M>), entry: &Entry<M>, sheet: &ReceiverTable<M>) -> bool {
        const LOOKS: usize = 16;
        let known: Vec<usize> = (0..sheet.nodes.len()).filter(|node| sheet.nodes[*node].is_some()).collect();
        let step = known.len().div_ceil(LOOKS).max(1);
        let looks =
            || known.iter().skip(step / 2).step_by(step).filter_map(|at| Some((*at, sheet.nodes[*at].as_ref()?)));
        let whole = looks().filter(|(at, node)| {
            let strength = |from: (DVec3, Site), found: &Solution| {
                let (light, ..) = self.probe(tracing, entry.lamp, from, found.dir)?;
                Some(light[0] * found.factor)
            };
            let from = self.map.place(tracing.0, self.map.nodes.at_node(*at));
            let all = from.and_then(|from| self.aside(tracing, entry, (from, node.dir, node.by_lamp), strength));
            all.is_some_and(|all| all.iter().all(|s| (s - node.strength[0]).abs() <= 0.5 * node.strength[0]))
        });
        // Near folds and rims it never is; a good part of the face has to be.
        3 * whole.count() >= looks().count().max(1)
    }

    /// What `of` makes of the solutions for four points about the lamp's middle, near the rim of a square one; `middle`: the
    /// direction towards that, `by_lamp`: how it changes with the place on the lamp. None where one is missing.
    pub(super) fn aside<T>(
        &self,
        tracing: (&World, &Optics<M>),
        entry: &Entry<M>,
        (from, middle, by_lamp): ((DVec3, Site), DVec3, [DVec3; 2]),
        of: impl Fn((DVec3, Site), &Solution) -> Option<T>,
    ) -> Option<ArrayVec<T, 4>> {
        let far = ASIDE * entry.size;
        let point = |(axis, by): (usize, f64)| {
            let target = Target { point: entry.middle.point + by * entry.middle.across[axis], ..entry.middle };
            of(from, &self.newton(tracing, entry, from, middle + by * by_lamp[axis], &target)?)
        };
        [(0, far), (0, -far), (1, far), (1, -far)].into_iter().map(point).collect()
    }

    /// The factors for these four points. Any ray that meets the lamp's plane is the solution for where it does: those that are
    /// foretold meet it beside the points by little, for which the factors' own change makes up. Where they don't, the points
    /// are solved for.
    fn factors_aside(
        &self,
        tracing: (&World, &Optics<M>),
        entry: &Entry<M>,
        (from, middle, by_lamp): ((DVec3, Site), DVec3, [DVec3; 2]),
    ) -> Option<[f64; 4]> {
        let far = ASIDE * entry.size;
        let along = |axis: usize| -> Option<[(f64, DVec2); 2]> {
            let [one, other] = [far, -far].map(|by| {
                let target = Target { point: entry.middle.point + by * entry.middle.across[axis], ..entry.middle };
                let met = self.meet(tracing, entry, from, middle + by * by_lamp[axis], &target);
                met.filter(|(_, off)| off.length() <= BESIDE * far).or_else(|| {
                    let start = middle + by * by_lamp[axis];
                    Some((self.newton(tracing, entry, from, start, &target)?.factor, DVec2::ZERO))
                })
            });
            Some([one?, other?])
        };
        let both = [along(0)?, along(1)?];
        // Per axis: how the factor changes along it.
        let change = |axis: usize| {
            let [(one, at), (other, from)] = both[axis];
            (one - other) / (2.0 * far + at[axis] - from[axis])
        };
        let change = DVec2::new(change(0), change(1));
        let [[a, b], [c, d]] = both.map(|pair| pair.map(|(factor, off)| factor - change.dot(off)));
        Some([a, b, c, d])
    }

    /// Adds nodes just beyond what is lit, by cubics through the four nodes next to them along a row or a column: where
    /// the edge is that of a slide's picture, cells on it can be interpolated, and the picture itself says where it ends.
    pub(super) fn complete(&self, (world, optics): (&World, &Optics<M>), sheet: &mut ReceiverTable<M>) {
        // Corners of what is lit lie beside nodes that are only there the second time.
        for _ in 0..2 {
            self.extend((world, optics), sheet);
        }
    }

    fn extend(&self, (world, optics): (&World, &Optics<M>), sheet: &mut ReceiverTable<M>) {
        let missing = (0..self.map.nodes.number()).filter(|node| sheet.nodes[*node].is_none());
        let added: Vec<(usize, Node<M>)> = missing
            .filter_map(|node| {
                let lines = self.map.nodes.lines(node);
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

    /// How the connections of a cell are made: by a solution in its middle or, where the slides' pictures end in the cell,
    /// by those about it; and why, where there are any.
    fn judge(
        &self,
        tracing: (&World, &Optics<M>),
        entry: &Entry<M>,
        sheet: &ReceiverTable<M>,
        cell: usize,
    ) -> (Cell, Option<Errs>) {
        let nothing = (Cell::Nothing, None);
        let mut found = nothing;
        for (k, at) in self.map.nodes.trials(cell).enumerate() {
            let Some(spot) = self.map.spot_at(at) else { continue };
            let nodes = || spot.nodes().map(|(node, _)| sheet.nodes[node].as_ref());
            if nodes().all(|node| node.is_none()) {
                return nothing;
            }
            let whole = sheet.is_whole(&spot);
            let start = self.start(entry, sheet, (&spot, whole), &entry.middle);
            let from = self.map.place(tracing.0, at);
            let solved =
                start.zip(from).and_then(|(start, from)| self.newton(tracing, entry, from, start, &entry.middle));
            match from.zip(solved) {
                Some((from, middle)) => match self.try_at(tracing, entry, sheet, (&spot, whole), from, &middle) {
                    Some(Some(errs)) if errs.are_small() => found = (Cell::Interpolated, Some(errs)),
                    Some(Some(errs)) => return (Cell::Solved, Some(errs)),
                    Some(None) => return nothing,
                    None => {}
                },
                // Where the face has ended, or a slide's picture, there is nothing to find; elsewhere the nodes are wrong.
                None if whole && (from.is_none() || has_ended(tracing, sheet, &spot)) => {}
                None => return nothing,
            }
            if k == 0 && found.0 == Cell::Interpolated {
                return found;
            }
        }
        found
    }

    /// By the solution for one place of a cell, by how much it is missed, or none where photons do better; none of that where
    /// nodes and solution agree that a slide's picture has ended. `whole`: all nodes about it are there.
    fn try_at(
        &self,
        tracing: (&World, &Optics<M>),
        entry: &Entry<M>,
        sheet: &ReceiverTable<M>,
        (spot, whole): (&Spot, bool),
        from: (DVec3, Site),
        middle: &Solution,
    ) -> Option<Option<Errs>> {
        // Near a fold the lamp's points have solutions of very different strength, or none: few would bring much.
        let near = spot.nodes().filter_map(|(node, weight)| Some((sheet.nodes[node].as_ref()?, weight)));
        let by_lamp = near.max_by(|a, b| a.1.total_cmp(&b.1)).map_or([DVec3::ZERO; 2], |(node, _)| node.by_lamp);
        let factors = self.factors_aside(tracing, entry, (from, middle.dir, by_lamp));
        let alike = |factor: &f64| (factor - middle.factor).abs() <= UNEVEN * middle.factor;
        let Some(factors) = factors.filter(|factors| factors.iter().all(alike)) else { return Some(None) };
        if !whole {
            return Some(Some(Errs::AtEdge));
        }
        let always = Some(Some(Errs::By(f64::INFINITY)));
        let Some(blend) = sheet.blend((spot.cell, &spot.rows()), DVec2::ZERO) else { return always };
        let (world, _) = tracing;
        let Some((light, alone, slides)) = self.probe(tracing, entry.lamp, from, middle.dir) else {
            return if has_ended(tracing, sheet, spot) { None } else { always };
        };
        if blend.slides().len() != slides.len() || blend.alone() != alone {
            return always;
        }
        // The middle of the lamp has to stand for all of it.
        let mean = factors.iter().sum::<f64>() / factors.len() as f64;
        let even = (mean - middle.factor).abs() <= EVEN * (self.tolerance / TOLERANCE) * middle.factor;
        if !even {
            return always;
        }
        let errs = |lane: usize| {
            let found = light[lane] * middle.factor;
            // Nothing is interpolated exactly where there is nothing.
            if blend.strength(lane) == found { 0.0 } else { (blend.strength(lane) - found).abs() / found.abs() }
        };
        let moved = |((_, at), (slide, local)): ((usize, DVec3), &(usize, DVec3))| {
            at.distance(*local) / world.slides[*slide].size()
        };
        let all = std::iter::once(blend.dir().distance(middle.dir))
            .chain((0..M::LANES).map(errs))
            .chain(blend.slides().zip(&slides).map(moved));
        // What is no number is no small error.
        let most = all.map(|err| if err.is_nan() { f64::INFINITY } else { err }).fold(0.0, f64::max);
        Some(Some(Errs::By(most / self.tolerance)))
    }
}

/// Whether the nodes about a spot, which are whole, say that it lies beside a slide's picture.
fn has_ended<M: Mode>((world, optics): (&World, &Optics<M>), sheet: &ReceiverTable<M>, spot: &Spot) -> bool {
    let ended = |(slide, at): (usize, DVec3)| optics.slide(&world.slides[slide], at).is_none();
    sheet.blend((spot.cell, &spot.rows()), DVec2::ZERO).is_some_and(|blend| blend.slides().any(ended))
}
