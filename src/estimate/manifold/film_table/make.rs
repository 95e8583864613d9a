//! How the tables are filled: node by node from the solver's starts, and cell by cell on trial.

use super::masks::{self, MASKS, Mask};
use super::{FilmTable, FilmTables, Node, Places, Use, blend, through_slides};
use crate::base::lpe::LpeState;
use crate::base::path::Trail;
use crate::base::rng::{Rng, Stream};
use crate::estimate::ledger::Ledger;
use crate::estimate::manifold::receiver::Crossing;
use crate::estimate::manifold::seeds::connections::{Connections, Entry, index_of};
use crate::estimate::manifold::solver::bicubic::{SIDES, Spot};
use crate::estimate::manifold::solver::newton::{Family, Root, Target, newton};
use crate::estimate::walk::{Travel, Walker};
use crate::world::World;
use crate::world::geometry::Ray;
use crate::world::interior::Interior;
use crate::world::mode::{LaneArray, Mode, lanes};
use crate::world::optics::Optics;
use crate::world::surface::Surface;
use arrayvec::ArrayVec;
use glam::{DVec2, DVec3};

/// The difference from the solved connection is looked at with this probability where the table did well on trial (less
/// would save little more, and make what no trial saw bright and rare),
const LEAST: f64 = 1.0 / 8.0;
/// and always where it was off by this share.
const POOR: f64 = 0.01;
/// A place on a slide that is off by a share of the slide's size counts so many times: pictures have edges.
const SHARP: f64 = 100.0;
/// How far from a lamp's middle tables are tried and differences taken, in radii: within a square lamp.
const ASIDE: f64 = 0.6;
/// So near to the rim of a slide's picture, in pixels, and in errors of the places that a trial has shown, tables are not used.
const RIM_PIXELS: f64 = 0.25;
const RIM_ERRORS: f64 = 4.0;
/// The same of the pupil's rim, in its radii, at the least.
const PUPIL_RIM: f64 = 0.01;
/// So near to the outline of a face, in pixels, nodes and solver may differ on whether it is met.
const MASK_PIXELS: f64 = 0.25;
/// Where a cell at the end of the light is tried beside its middle, in cells from there.
const QUARTERS: [[f64; 2]; 4] = [[-0.4, -0.4], [0.4, -0.4], [-0.4, 0.4], [0.4, 0.4]];
/// Nodes that are added beyond a slide's edge, so that the cells across it have all sixteen.
const BEYOND: usize = 2;
/// Solutions farther than this from the pupil's middle, in radii, are of no use to a table.
const FAR: f64 = 3.0;

/// A solution, followed.
struct Found<M: Mode> {
    root: Root,
    strength: M::Lanes<f64>,
    trail: Trail,
    told: LpeState,
    alone: bool,
    slides: Places,
    /// Where each face of the train is met, recentred world, m.
    met: Vec<DVec3>,
}

/// A branch's nodes over the picture.
type Nodes<M> = Vec<Option<Node<M>>>;

/// A node, and where it meets the faces of the train.
type Met<M> = Option<(Node<M>, Vec<Crossing>)>;

pub(super) struct Maker<'m, M: Mode> {
    pub(super) world: &'m World,
    pub(super) optics: &'m Optics<M>,
    pub(super) connections: &'m Connections,
}

impl<M: Mode> Maker<'_, M> {
    pub(super) fn table(&self, tables: &FilmTables<M>, entry: &Entry) -> FilmTable<M> {
        let node = |branch: usize, node: usize| {
            let film = tables.over.film(tables.over.nodes.at_node(node));
            self.node(entry, film, entry.starts.start(branch, film)?)
        };
        let over = &tables.over.nodes;
        let of_branch = |branch: usize| (0..over.number()).map(|at| node(branch, at)).collect();
        let found: Vec<Vec<Met<M>>> = (0..entry.starts.branches()).map(of_branch).collect();
        let train = &self.connections.trains[entry.train];
        let mut chosen = ArrayVec::<usize, MASKS>::new();
        for nodes in &found {
            let places = |node: &Met<M>| {
                node.as_ref().map(|(_, met)| met.iter().map(|crossing| crossing.local).collect::<Vec<_>>())
            };
            let places: Vec<_> = nodes.iter().map(places).collect();
            for k in masks::of_train(self.world, train, &places, |node| over.lines(node)) {
                if !chosen.contains(&k) && chosen.try_push(k).is_err() {
                    break;
                }
            }
        }
        let masks: ArrayVec<Mask, MASKS> =
            chosen.iter().map(|k| (train.0[*k].link.part, train.0[*k].link.face)).collect();
        let masked = |(mut node, met): (Node<M>, Vec<Crossing>)| {
            node.masks = chosen.iter().filter_map(|k| met.get(*k).cloned()).collect();
            (node.masks.len() == chosen.len()).then_some(node)
        };
        let masked_all =
            |nodes: Vec<Met<M>>| -> Nodes<M> { nodes.into_iter().map(|node| node.and_then(masked)).collect() };
        let mut branches: Vec<Nodes<M>> = found.into_iter().map(masked_all).collect();
        let solved = |at: usize| branches.iter().any(|nodes: &Nodes<M>| nodes[at].is_some());
        let solved: Vec<bool> = (0..tables.over.nodes.number()).map(solved).collect();
        for nodes in &mut branches {
            (0..BEYOND).for_each(|_| self.complete(tables, nodes, &masks));
        }
        let mut uses = vec![Use::SOLVED; tables.over.nodes.number()];
        for cell in tables.over.nodes.cells() {
            uses[cell] = self.use_of(tables, entry, (&branches, &masks, &solved), cell);
        }
        FilmTable { masks, branches, uses }
    }

    /// The solution near a start, followed; none where there is none, or something else stands in the way.
    fn found(&self, entry: &Entry, film: DVec2, start: DVec2, off: DVec2) -> Option<Found<M>> {
        let (world, optics, middle) = (self.world, self.optics, entry.starts.middle());
        let target = Target { point: middle.point + middle.across[0] * off.x + middle.across[1] * off.y, ..*middle };
        let train = &self.connections.trains[entry.train];
        let family = Family::Pupil { film };
        let root = newton(world, &index_of(optics), &family, start, train, &target, entry.starts.size())?;
        if root.u.length() > FAR * world.eye.pupil_radius_m() {
            return None;
        }
        let (origin, (_, dir), ..) = world.eye.ray_of(film, root.u);
        let ray = Ray { origin, dir, from: None };
        let rng = Rng::new(0, Stream::Pilot, 4, 0);
        let mut walker = Walker::new((world, optics), Travel::FromEye, ray, 1.0, Interior::default(), rng);
        let mut ledger = Ledger::new(world.solids.len());
        let (mut slides, mut many) = (Places::new(), false);
        let mut met = Vec::with_capacity(train.0.len());
        let links = train.0.iter().map(|lens| lens.link);
        let seen = walker.follow_to(links, entry.starts.lamp, &mut ledger, |_, vertex, _| {
            met.push(vertex.hit.point);
            let face = &world.faces[vertex.hit.site.part as usize][vertex.hit.site.face as usize];
            if let Surface::Slide(index) = face.surface {
                many |= slides.try_push((index, vertex.hit.local)).is_err();
            }
        })?;
        let (light, alone) = walker.seen(&seen);
        let factor = seen.lamp.area_m2 / (root.slope.determinant().abs() * world.eye.pupil_area_m2());
        // The slides' share at full opening is the leading coefficient over what they let through when open.
        let open: f64 = slides.iter().map(|(index, _)| world.slides[*index].t_white()).product();
        let strength = lanes::<M, _>(|lane| light[lane].open() / open * factor);
        let usable = !many && strength.as_slice().iter().all(|s| s.is_finite());
        usable.then_some(Found { root, strength, trail: walker.trail, told: walker.told, alone, slides, met })
    }

    /// What there is to know of the solution near a start, and where it meets the faces of the train.
    fn node(&self, entry: &Entry, film: DVec2, start: DVec2) -> Option<(Node<M>, Vec<Crossing>)> {
        let found = self.found(entry, film, start, DVec2::ZERO)?;
        let pupil_by = found.root.slope.inverse();
        let step = ASIDE * entry.starts.size();
        // To the one side or to the other: on one of them something may end.
        let aside = |axis: DVec2| {
            let other = |off: DVec2| {
                let other = self.found(entry, film, found.root.u + pupil_by * off, off)?;
                let same = other.slides.iter().map(|(slide, _)| slide).eq(found.slides.iter().map(|(slide, _)| slide));
                same.then_some((off.dot(axis), other))
            };
            other(axis * step).or_else(|| other(-axis * step))
        };
        let [x, y] = [aside(DVec2::X)?, aside(DVec2::Y)?];
        let slope = |(step, other): &(f64, Found<M>)| {
            lanes::<M, _>(|lane| (other.strength[lane] - found.strength[lane]) / step)
        };
        let crossing = |k: usize| {
            let (slide, local) = found.slides[k];
            let by_lamp = [&x, &y].map(|(step, other)| (other.slides[k].1 - local) / *step);
            Crossing { slide, local, by_lamp }
        };
        let slides = (0..found.slides.len()).map(crossing).collect();
        let met = |k: usize| {
            let local = found.met[k];
            let by_lamp = [&x, &y].map(|(step, other)| (other.met[k] - local) / *step);
            Crossing { slide: k, local, by_lamp }
        };
        let met = (0..found.met.len().min(x.1.met.len()).min(y.1.met.len())).map(met).collect();
        let strength_by = [slope(&x), slope(&y)];
        let Found { root, strength, trail, told, alone, .. } = found;
        let finite = pupil_by.is_finite() && strength_by.iter().all(|by| by.as_slice().iter().all(|s| s.is_finite()));
        let masks = ArrayVec::new();
        let node = Node { pupil: root.u, pupil_by, strength, strength_by, trail, told, alone, slides, masks };
        finite.then_some((node, met))
    }

    /// Adds nodes just beyond the edge of a slide's picture, or the outline of a face, by cubics through the four next to them along a row or a
    /// column: picture and outline themselves say where they end.
    fn complete(&self, tables: &FilmTables<M>, nodes: &mut [Option<Node<M>>], masks: &[Mask]) {
        let beyond = |at: usize| {
            let lines = tables.over.nodes.lines(at);
            let found = lines.into_iter().flatten().find_map(|line| {
                let [a, b, c, d] = line.map(|node| nodes[node].as_ref());
                Node::beyond([a?, b?, c?, d?])
            })?;
            let outside =
                |crossing: &Crossing| self.optics.slide(&self.world.slides[crossing.slide], crossing.local).is_none();
            let places: ArrayVec<DVec3, MASKS> = found.masks.iter().map(|crossing| crossing.local).collect();
            let hidden = masks::inside(self.world, masks, &places, 0.0).is_some_and(|inside| inside < 0.0);
            (hidden || found.slides.iter().any(outside)).then_some((at, found))
        };
        let added: Vec<_> = (0..nodes.len()).filter(|at| nodes[*at].is_none()).filter_map(beyond).collect();
        added.into_iter().for_each(|(at, found)| nodes[at] = Some(found));
    }

    /// How a cell is to be used. Where no branch has a node at its corners the table says nothing, and little is expected.
    /// `solved`: the nodes with a solution, none of those that were added beyond them.
    fn use_of(
        &self,
        tables: &FilmTables<M>,
        entry: &Entry,
        (branches, masks, solved): (&[Nodes<M>], &[Mask], &[bool]),
        cell: usize,
    ) -> Use {
        let corners = tables.over.nodes.corners(cell);
        let lit = |nodes: &&Nodes<M>| corners.iter().any(|node| nodes[*node].is_some());
        let lit: Vec<&Nodes<M>> = branches.iter().filter(lit).collect();
        let at = tables.over.nodes.at_node(cell) + 0.5;
        let known = SIDES.into_iter().find_map(|aside| {
            let spot = tables.over.nodes.spot_by(at, aside)?;
            let whole = lit.iter().all(|nodes| spot.nodes().all(|(node, _)| nodes[node].is_some()));
            whole.then_some((aside, spot))
        });
        let (mask_reach, unsure) = self.mask_reach(tables, entry.starts.size(), (&lit, masks), &corners);
        let edges = (masks, unsure);
        let off =
            known.and_then(|(aside, spot)| Some((aside, self.error(tables.over.film(at), entry, &lit, &spot, edges)?)));
        // Where light ends near a cell it may end within it, beside its middle.
        let off = off.filter(|(aside, _)| {
            let inner = known.is_some_and(|(_, spot)| *aside == [0; 2] && spot.nodes().all(|(node, _)| solved[node]));
            inner
                || QUARTERS.into_iter().all(|[x, y]| {
                    let spot = tables.over.nodes.spot_by(at + DVec2::new(x, y), *aside);
                    let tried = |spot| self.error(tables.over.film(at + DVec2::new(x, y)), entry, &lit, &spot, edges);
                    spot.and_then(tried).is_some()
                })
        });
        off.map_or(Use::SOLVED, |(aside, off)| Use {
            share: (off / POOR).clamp(LEAST, 1.0),
            aside,
            rim: (RIM_PIXELS * self.by_pixel(tables, &lit, &corners)).max(RIM_ERRORS * off / SHARP),
            pupil_rim: (RIM_ERRORS * off).max(PUPIL_RIM),
            mask_reach,
        })
    }

    /// How far about the places of a cell the outlines of masks are looked for, m: 0 where all of them are far. And so near to an
    /// outline nodes and solver need not agree.
    fn mask_reach(
        &self,
        tables: &FilmTables<M>,
        size: f64,
        (branches, masks): (&[&Nodes<M>], &[Mask]),
        corners: &[usize],
    ) -> ([f64; MASKS], f64) {
        let (mut reach, mut unsure) = ([0.0; MASKS], 0.0f64);
        for (k, mask) in masks.iter().enumerate() {
            for nodes in branches {
                let crossing = |node: &usize| nodes[*node].as_ref()?.masks.get(k);
                let known: Vec<&Crossing> = corners.iter().filter_map(crossing).collect();
                let places = || known.iter().map(|crossing| crossing.local);
                let apart = places().flat_map(|a| places().map(move |b| a.distance(b))).fold(0.0, f64::max);
                let blur = |crossing: &&Crossing| size * crossing.by_lamp.iter().map(|by| by.length()).sum::<f64>();
                let blur = known.iter().map(blur).fold(0.0, f64::max);
                // No place of the cell is farther from a corner than half of its diagonal.
                let inside = |place: DVec3, reach: f64| masks::inside(self.world, &[*mask], &[place], reach);
                let hidden = places().any(|place| inside(place, 0.0).is_some_and(|inside| inside < 0.0));
                let near = places().any(|place| inside(place, 0.75 * apart + blur).is_some());
                if apart > 0.0 && (hidden || near) {
                    let cells = if hidden { 2.0 + BEYOND as f64 } else { 1.5 };
                    reach[k] = f64::max(reach[k], cells * apart + blur);
                    unsure = unsure.max(MASK_PIXELS * apart / tables.over.pixels);
                }
            }
        }
        (reach, unsure)
    }

    /// How far places on slides are from one pixel to the next, as a share of the slide's size: the most of a cell.
    fn by_pixel(&self, tables: &FilmTables<M>, branches: &[&Nodes<M>], corners: &[usize]) -> f64 {
        let of_branch = |nodes: &&Nodes<M>| {
            let known: Vec<&Node<M>> = corners.iter().filter_map(|node| nodes[*node].as_ref()).collect();
            let pairs = known.iter().enumerate().flat_map(|(k, a)| known[..k].iter().map(move |b| (*a, *b)));
            let apart = |(a, b): (&Node<M>, &Node<M>)| {
                let both = a.slides.iter().zip(&b.slides).filter(|(a, b)| a.slide == b.slide);
                both.map(|(a, b)| a.local.distance(b.local) / self.world.slides[a.slide].size()).fold(0.0, f64::max)
            };
            pairs.map(apart).fold(0.0, f64::max)
        };
        branches.iter().map(of_branch).fold(0.0, f64::max) / tables.over.pixels
    }

    /// By how much what these branches say of a place in the picture is off, by solutions for two points of the lamp; none
    /// where one of both is missing.
    fn error(
        &self,
        film: DVec2,
        entry: &Entry,
        branches: &[&Nodes<M>],
        spot: &Spot,
        (masks, unsure): (&[Mask], f64),
    ) -> Option<f64> {
        let size = entry.starts.size();
        let mut worst = 0f64;
        for nodes in branches {
            for off in [DVec2::new(ASIDE, 0.5 * ASIDE) * size, DVec2::new(-0.5 * ASIDE, -ASIDE) * size] {
                let blend = blend(nodes, spot, off)?;
                let inside = masks::inside(self.world, masks, &blend.masks, 0.0);
                // So near to an outline either may be right.
                if inside.is_some_and(|inside| inside.abs() <= unsure) {
                    continue;
                }
                let hidden = inside.is_some_and(|inside| inside < 0.0);
                let Some(found) = self.found(entry, film, blend.pupil, off) else {
                    // Beside a slide's picture, and beyond an outline, both know of nothing.
                    if hidden || !through_slides(self.world, self.optics, &blend.slides) {
                        continue;
                    }
                    return None;
                };
                if hidden {
                    return None;
                }
                let of_lane = |lane: usize| (blend.strength[lane] / found.strength[lane] - 1.0).abs();
                let strength = (0..M::LANES).map(of_lane).fold(0.0, f64::max);
                let apart = |((slide, a), (_, b)): (&(usize, DVec3), &(usize, DVec3))| {
                    SHARP * a.distance(*b) / self.world.slides[*slide].size()
                };
                let places = blend.slides.iter().zip(&found.slides).map(apart).fold(0.0, f64::max);
                let pupil = blend.pupil.distance(found.root.u) / self.world.eye.pupil_radius_m();
                let error = strength.max(places).max(pupil);
                worst = worst.max(if error.is_nan() { 1.0 } else { error });
            }
        }
        Some(worst)
    }
}

impl<M: Mode> Node<M> {
    /// The next of four in a row by a cubic: 4 a − 6 b + 4 c − d for equally spaced values a, b, c, d behind it.
    fn beyond(nodes: [&Node<M>; 4]) -> Option<Node<M>> {
        const WEIGHTS: [f64; 4] = [4.0, -6.0, 4.0, -1.0];
        let next = nodes[0];
        let alike = |node: &&Node<M>| {
            let slides = node.slides.iter().map(|crossing| crossing.slide);
            (node.alone, node.trail) == (next.alone, next.trail)
                && slides.eq(next.slides.iter().map(|crossing| crossing.slide))
        };
        if !nodes.iter().all(alike) {
            return None;
        }
        let sum = |of: &dyn Fn(&Node<M>) -> f64| nodes.iter().zip(WEIGHTS).map(|(node, w)| w * of(node)).sum::<f64>();
        let place = |of: &dyn Fn(&Node<M>) -> DVec3| nodes.iter().zip(WEIGHTS).map(|(node, w)| w * of(node)).sum();
        let crossing = |k: usize| Crossing {
            slide: next.slides[k].slide,
            local: place(&|node| node.slides[k].local),
            by_lamp: [0, 1].map(|axis| place(&|node| node.slides[k].by_lamp[axis])),
        };
        let mask = |k: usize| Crossing {
            slide: next.masks[k].slide,
            local: place(&|node| node.masks[k].local),
            by_lamp: [0, 1].map(|axis| place(&|node| node.masks[k].by_lamp[axis])),
        };
        Some(Node {
            pupil: DVec2::new(sum(&|node| node.pupil.x), sum(&|node| node.pupil.y)),
            pupil_by: next.pupil_by,
            strength: lanes::<M, _>(|lane| sum(&|node| node.strength[lane])),
            strength_by: next.strength_by,
            trail: next.trail,
            told: next.told,
            alone: next.alone,
            slides: (0..next.slides.len()).map(crossing).collect(),
            masks: (0..next.masks.len()).map(mask).collect(),
        })
    }
}
