//! How the tables are filled, node by node from the solver's starts.

use super::masks::{self, MASKS, Mask};
use super::tuning::make::FAR;
pub(super) use super::tuning::make::{ASIDE, BEYOND};
use super::{FilmTable, FilmTables, Node, Places, Use};
use crate::ledger::Ledger;
use crate::manifold::receiver::Crossing;
use crate::manifold::seeds::connections::{Connections, Entry, index_of};
use crate::manifold::solver::newton::{Family, Root, Target, newton};
use crate::walk::{Travel, Walker};
use arrayvec::ArrayVec;
use eyebox_base::lpe::LpeState;
use eyebox_base::path::Trail;
use eyebox_base::rng::{Rng, Stream};
use eyebox_world::World;
use eyebox_world::geometry::Ray;
use eyebox_world::interior::Interior;
use eyebox_world::mode::{LaneArray, Mode, lanes};
use eyebox_world::optics::Optics;
use eyebox_world::surface::Surface;
use glam::{DVec2, DVec3};

/// A solution, followed.
pub(super) struct Found<M: Mode> {
    pub(super) root: Root,
    pub(super) strength: M::Lanes<f64>,
    trail: Trail,
    told: LpeState,
    alone: bool,
    pub(super) slides: Places,
    /// Where each face of the train is met, recentred world, m.
    met: Vec<DVec3>,
}

/// A branch's nodes over the picture.
pub(super) type Nodes<M> = Vec<Option<Node<M>>>;

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
    pub(super) fn found(&self, entry: &Entry, film: DVec2, start: DVec2, off: DVec2) -> Option<Found<M>> {
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
