//! A face and a train: the solver for points of the face, and what a solution brings.

use super::surface_param::SurfaceParam;
use super::table::{Crossing, Node, ReceiverTable, SLIDES};
use crate::ledger::Ledger;
use crate::manifold::seeds::connections::index_of;
use crate::manifold::solver::bicubic::Spot;
use crate::manifold::solver::newton::{Family, Target, end_of, newton, trace};
use crate::manifold::solver::ray_differentials::Landing;
use crate::walk::{Travel, Vertex, Walker};
use arrayvec::ArrayVec;
use eyebox_base::chain::{Chain, Link, Step};
use eyebox_base::lpe::Letter;
use eyebox_base::path::Event;
use eyebox_base::rng::{Rng, Stream};
use eyebox_film::accumulate::Light;
use eyebox_film::specular_chain::SpecularChain;
use eyebox_world::World;
use eyebox_world::geometry::{Ray, Site};
use eyebox_world::interior::Interior;
use eyebox_world::mode::{LaneArray, Mode, lanes};
use eyebox_world::optics::Optics;
use eyebox_world::surface::Surface;
use glam::{DMat2, DVec2, DVec3};

/// What the solver finds for a point of a face and a point of a lamp.
#[derive(Debug, Clone, Copy)]
pub(super) struct Solution {
    /// Unit, from the face.
    pub(super) dir: DVec3,
    /// Solid angle that the whole lamp would fill if all of it were as here, sr.
    pub(super) factor: f64,
}

/// All branches of a train for one lamp.
#[derive(Debug)]
pub(super) struct Entry<M: Mode> {
    pub(super) lamp: usize,
    pub(super) middle: Target,
    pub(super) size: f64,
    pub(super) sheets: Vec<ReceiverTable<M>>,
}

/// A face that a train leads to, and what it brings from each lamp.
#[derive(Debug)]
pub(super) struct Connector<M: Mode> {
    pub(super) map: SurfaceParam,
    pub(super) train: SpecularChain,
    /// From the lamp.
    pub(super) chain: Chain,
    /// What happens on it.
    pub(super) letters: Vec<Letter>,
    pub(super) entries: Vec<Entry<M>>,
    /// Of the face's light.
    pub(super) share: f64,
    /// Largest error of what is interpolated.
    pub(super) tolerance: f64,
}

/// What a path does at a face of a chain.
pub(super) fn letter(world: &World, link: &Link) -> Letter {
    let surface = surface(world, link);
    match (link.step, surface) {
        (Step::Through, Some(Surface::Slide(slide))) => world.slide_letter(*slide),
        (Step::Through, Some(Surface::Sheet(_) | Surface::Splitter(_))) => Letter::TransmitStraight,
        (Step::Through, _) => Letter::of(Event::Specular, true),
        (Step::Back, _) => Letter::of(Event::Specular, false),
    }
}

fn surface<'w>(world: &'w World, link: &Link) -> Option<&'w Surface> {
    Some(&world.faces.get(link.part as usize)?.get(link.face as usize)?.surface)
}

impl<M: Mode> Connector<M> {
    /// Solves from a start for the direction to the target.
    pub(super) fn newton(
        &self,
        (world, optics): (&World, &Optics<M>),
        entry: &Entry<M>,
        (point, site): (DVec3, Site),
        axis: DVec3,
        target: &Target,
    ) -> Option<Solution> {
        let axis = axis.try_normalize()?;
        let (family, [a, b]) = Family::about(point, Some(site), axis);
        let root = newton(world, &index_of(optics), &family, DVec2::ZERO, &self.train, target, entry.size)?;
        let long = axis + a * root.u.x + b * root.u.y;
        let length = long.length();
        let area_m2 = world.lamps.get(entry.lamp)?.area_m2;
        // Steradian per unit of the parameters, over the lamp's area per unit of them.
        let factor = area_m2 / (length.powi(3) * root.slope.determinant().abs());
        factor.is_finite().then_some(Solution { dir: long / length, factor })
    }

    /// Where a ray along `axis` meets the plane of the target, from that, m, and the factor of the solution that it is for that
    /// place.
    pub(super) fn meet(
        &self,
        (world, optics): (&World, &Optics<M>),
        entry: &Entry<M>,
        (point, site): (DVec3, Site),
        axis: DVec3,
        target: &Target,
    ) -> Option<(f64, DVec2)> {
        let axis = axis.try_normalize()?;
        let (family, _) = Family::about(point, Some(site), axis);
        let end = trace(world, &index_of(optics), &family, DVec2::ZERO, &self.train, target)?;
        let factor = world.lamps.get(entry.lamp)?.area_m2 / end.slope.determinant().abs();
        factor.is_finite().then_some((factor, end.off))
    }

    /// Solves for a point in a cell of a sheet.
    pub(super) fn solve(
        &self,
        tracing: (&World, &Optics<M>),
        entry: &Entry<M>,
        sheet: &ReceiverTable<M>,
        spot: &Spot,
        from: (DVec3, Site),
        target: &Target,
    ) -> Option<Solution> {
        let start = self.start(entry, sheet, (spot, sheet.is_whole(spot)), target)?;
        self.newton(tracing, entry, from, start, target)
    }

    /// The direction where the solver starts: what the nodes about the spot say together if they are all there (`whole`), else
    /// what the nearest does.
    pub(super) fn start(
        &self,
        entry: &Entry<M>,
        sheet: &ReceiverTable<M>,
        (spot, whole): (&Spot, bool),
        target: &Target,
    ) -> Option<DVec3> {
        let off = entry.middle.local(target.point - entry.middle.point);
        let blended = if whole { sheet.blend_dir(spot, off) } else { None };
        blended.or_else(|| Some(self.foretell(entry, sheet, spot, target)?.0))
    }

    /// The direction that the nearest node of a sheet foretells, and how much it changes over a cell.
    pub(super) fn foretell(
        &self,
        entry: &Entry<M>,
        sheet: &ReceiverTable<M>,
        spot: &Spot,
        target: &Target,
    ) -> Option<(DVec3, f64)> {
        let known = spot.nodes().filter(|(node, _)| sheet.nodes[*node].is_some());
        let (first, _) = known.max_by(|a, b| a.1.total_cmp(&b.1))?;
        self.foretell_from(entry, sheet, first, spot, target)
    }

    /// The same of any node.
    pub(super) fn foretell_from(
        &self,
        entry: &Entry<M>,
        sheet: &ReceiverTable<M>,
        first: usize,
        spot: &Spot,
        target: &Target,
    ) -> Option<(DVec3, f64)> {
        let node = sheet.nodes[first].as_ref()?;
        let off = entry.middle.local(target.point - entry.middle.point);
        let at = self.map.offset_of(first, spot);
        let by_place = node.by_place[0] * at.x + node.by_place[1] * at.y;
        let by_lamp = node.by_lamp[0] * off.x + node.by_lamp[1] * off.y;
        Some((node.dir + by_place + by_lamp, self.map.cell_size() * node.by_place_size()))
    }

    /// Follows a solution as any path is followed; `each` sees the faces. Returns the lamp's luminance as it arrives, per
    /// lane.
    pub(super) fn follow(
        &self,
        (world, optics): (&World, &Optics<M>),
        lamp: usize,
        (point, site, interior, rng): (DVec3, Site, Interior, Rng),
        dir: DVec3,
        ledger: &mut Ledger,
        mut each: impl FnMut(&Vertex),
    ) -> Option<(M::Lanes<Light>, bool)> {
        let ray = Ray { origin: point, dir, from: Some(site) };
        let mut walker = Walker::new((world, optics), Travel::FromEye, ray, 1.0, interior, rng);
        // The point is no pupil: what falls into the eye on the way is stopped there.
        walker.events = 1;
        let links = self.train.0.iter().map(|lens| lens.link);
        let seen = walker.follow_to(links, lamp, ledger, |_, vertex, _| each(vertex))?;
        Some(walker.seen(&seen))
    }

    /// The solution for the middle of the lamp at fractional node coordinates.
    pub(super) fn node(
        &self,
        (world, optics): (&World, &Optics<M>),
        entry: &Entry<M>,
        at: DVec2,
        start: DVec3,
    ) -> Option<Node<M>> {
        let index = index_of(optics);
        let (point, site) = self.map.place(world, at)?;
        let (target, from) = (&entry.middle, (point, site));
        let Solution { dir, factor } = self.newton((world, optics), entry, from, start, target)?;
        let mut planes: Vec<(u32, DVec3, DVec3)> = Vec::new();
        let (light, alone, slides) = self.probe_seen((world, optics), entry.lamp, from, dir, |vertex| {
            planes.push((vertex.hit.site.part, vertex.hit.point, vertex.hit.normal));
        })?;
        let strength = lanes::<M, _>(|lane| light[lane] * factor);
        let (family, [a, b]) = Family::about(point, Some(site), dir);
        // Where the rays about this one cross slides.
        let mut landings: ArrayVec<Option<Landing>, SLIDES> = ArrayVec::new();
        let bundle = family.bundle(&world.eye, DVec2::ZERO);
        let bundle = bundle.through_seen(world, &self.train, &index, |bundle, lens| {
            if let (false, Some(Surface::Slide(_))) = (landings.is_full(), surface(world, &lens.link)) {
                let plane = planes.get(landings.len());
                landings.push(plane.and_then(|(_, place, normal)| bundle.land(*place, *normal)));
            }
        })?;
        let straight = end_of(&bundle, target)?;
        let inverse: DMat2 = straight.slope.inverse();
        let shifted = Family::Shifted { origin: point, from: Some(site), dir, across: self.map.across() };
        let moved = trace(world, &index, &shifted, DVec2::ZERO, &self.train, target)?;
        let turn = |by: DVec2| a * by.x + b * by.y;
        let by_lamp = [turn(inverse.x_axis), turn(inverse.y_axis)];
        let by_place = -(inverse * moved.slope);
        let by_place = [turn(by_place.x_axis), turn(by_place.y_axis)];
        // How the places on slides move with the place on the lamp: as the direction does.
        let mut crossings: ArrayVec<Crossing, SLIDES> = ArrayVec::new();
        let mut exact_only = slides.len() > SLIDES;
        for (k, (slide, local)) in slides.iter().enumerate().take(SLIDES) {
            let (Some(Some(landing)), Some((part, ..))) = (landings.get(k), planes.get(k)) else {
                exact_only = true;
                continue;
            };
            let to_mesh = world.geometry.part_to_world(*part).matrix3.inverse();
            let moves = |by: DVec2| to_mesh * (landing.by[0] * by.x + landing.by[1] * by.y);
            let by_lamp = [moves(inverse.x_axis), moves(inverse.y_axis)];
            crossings.push(Crossing { slide: *slide, local: *local, by_lamp });
        }
        let finite =
            strength.as_slice().iter().all(|s| s.is_finite()) && by_lamp.iter().chain(&by_place).all(|v| v.is_finite());
        finite.then_some(Node { dir, by_lamp, by_place, strength, alone, slides: crossings, exact_only })
    }

    /// What arrives along a direction from the lamp, with the slides open, and where it crosses them.
    #[allow(clippy::type_complexity)]
    pub(super) fn probe(
        &self,
        (world, optics): (&World, &Optics<M>),
        lamp: usize,
        from: (DVec3, Site),
        dir: DVec3,
    ) -> Option<(M::Lanes<f64>, bool, Vec<(usize, DVec3)>)> {
        self.probe_seen((world, optics), lamp, from, dir, |_| {})
    }

    /// The same; `each` sees the slides.
    #[allow(clippy::type_complexity)]
    fn probe_seen(
        &self,
        (world, optics): (&World, &Optics<M>),
        lamp: usize,
        (point, site): (DVec3, Site),
        dir: DVec3,
        mut each: impl FnMut(&Vertex),
    ) -> Option<(M::Lanes<f64>, bool, Vec<(usize, DVec3)>)> {
        let mut ledger = Ledger::new(world.solids.len());
        let interior = Interior::of(world.geometry.solids_containing(point + dir * (1e-6 * self.map.cell_size())));
        let start = (point, site, interior, Rng::new(0, Stream::Pilot, 3, 0));
        let mut slides = Vec::new();
        let (light, alone) = self.follow((world, optics), lamp, start, dir, &mut ledger, |vertex| {
            let face = &world.faces[vertex.hit.site.part as usize][vertex.hit.site.face as usize];
            if let Surface::Slide(index) = face.surface {
                slides.push((index, vertex.hit.local));
                each(vertex);
            }
        })?;
        // The slides' share at full opening is the leading coefficient over what they let through when open.
        let open: f64 = slides.iter().map(|(index, _)| world.slides[*index].t_white()).product();
        Some((lanes::<M, _>(|lane| if open > 0.0 { light[lane].open() / open } else { 0.0 }), alone, slides))
    }
}
