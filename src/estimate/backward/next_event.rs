//! Light that lamps send to a scatterer on a path from the eye: places on them, and directions of the sky, chosen as they
//! shine.

use super::Backward;
use crate::ledger::Ledger;
use crate::walk::{Vertex, Walker};
use eyebox_base::ids::GroupId;
use eyebox_base::lpe::{Letter, Source};
use eyebox_base::path::Event;
use eyebox_base::warp::Frame;
use eyebox_film::accumulate::Light;
use eyebox_world::geometry::{Ray, Site};
use eyebox_world::light::Strength;
use eyebox_world::mode::{LaneArray, Mode, lanes, plane_of};
use eyebox_world::scatter::Scatter;
use eyebox_world::slide::SlideMap;
use glam::DVec3;

/// Where a path from the eye has met a scatterer.
pub(super) struct Here<'a, 'w, M: Mode> {
    pub walker: &'a Walker<'w, M>,
    pub vertex: &'a Vertex,
    pub scatter: &'a Scatter,
    pub frame: &'a Frame,
}

/// A slide and its [rank](World::rank).
type Ranked<'a> = (&'a SlideMap, f64);

/// Light that a lamp sends to a scatterer.
struct Sent<'a, M: Mode> {
    /// Unit direction to the lamp.
    dir: DVec3,
    distance: f64,
    target: Option<Site>,
    /// Per lane: cd/m², or lx across the direction for a lamp that has no luminance.
    luminance: M::Lanes<f64>,
    /// Density of the direction per steradian, or the probability of a lamp without luminance.
    pdf: f64,
    /// A scattered ray could have found the lamp too.
    by_chance: bool,
    group: GroupId,
    source: Source,
    /// The picture that it comes through, and its values there.
    shown: Option<(Ranked<'a>, M::Lanes<f64>)>,
    /// The direction that it is polarised along, and to which degree.
    polarisation: Option<(DVec3, f64)>,
}

/// What a ray finds that leaves the scene.
#[derive(Clone, Copy)]
enum Beyond {
    Sky,
    /// The disc of the light of this number.
    Disc(usize),
}

impl<M: Mode> Backward<'_, M> {
    pub(super) fn sample_lamps(&self, here: &Here<'_, '_, M>, [pick, u, v]: [f64; 3], out: &mut [Light]) {
        let from = here.vertex.hit.point;
        let Some((index, probability)) = self.world.lamps.pick_for_point(from, pick) else { return };
        let lamp = &self.world.lamps.all()[index];
        if self.share_of(here, lamp.group).is_none() {
            return;
        }
        let target = lamp.sample_point([u, v]);
        let offset = target.position - from;
        let distance = offset.length();
        let dir = offset / distance;
        let cos = -dir.dot(target.normal);
        let luminance = lamp.luminance_along(target.normal, -dir);
        if luminance <= 0.0 || !dir.is_finite() {
            return;
        }
        let pdf = probability / lamp.area_m2 * distance * distance / cos;
        let site = Site { part: lamp.part as u32, face: lamp.face as u32, triangle: target.triangle };
        let distance =
            match self.world.contacts.under(&self.world.geometry, site, [target.position, target.normal, -dir]) {
                None => distance,
                // The glass that it lies on bends the light: rays meet it.
                Some((glass, _)) if dir.dot(glass.normal) > 0.0 => return,
                // What is behind the lamp is not before it, whatever rounding says.
                Some((_, reach)) => distance - 4.0 * reach / cos,
            };
        let tint = here.walker.optics.lamp_at(index, lamp.glow(&target, -dir));
        let (target, on_lamp) = (Some(site), target.position);
        let luminance = lanes::<M, _>(|lane| luminance * tint[lane]);
        let (group, source) = (lamp.group, Source::Face);
        let shown = match &lamp.shown {
            None => None,
            Some(shown) => {
                let slide = &self.world.slides[shown.slide];
                let Some(s) = here.walker.optics.slide(slide, shown.local(on_lamp)) else { return };
                Some(((slide, self.world.rank(shown.slide)), s))
            }
        };
        let by_chance = true;
        let polarisation = lamp.polarisation;
        let sent = Sent { dir, distance, target, luminance, pdf, by_chance, group, source, shown, polarisation };
        self.connect(here, &sent, out);
    }

    /// `scratch`: what is booked of directions that are followed through panes; its work counts.
    pub(super) fn sample_sky(
        &self,
        here: &Here<'_, '_, M>,
        [_, u, v]: [f64; 3],
        out: &mut [Light],
        scratch: &mut Ledger,
    ) {
        let Some(sky) = &self.world.sky else { return };
        if self.share_of(here, sky.group).is_none() && !self.may_be_behind_panes(here, sky.group) {
            return;
        }
        let (dir, pdf) = self.skyward.sample(sky, here.vertex.hit.point, [u, v]);
        if pdf > 0.0 {
            let luminance = here.walker.optics.sky(sky, dir);
            let (distance, target, group, source) = (f64::INFINITY, None, sky.group, Source::Sky);
            let (by_chance, shown, polarisation) = (true, None, None);
            let sent = Sent { dir, distance, target, luminance, pdf, by_chance, group, source, shown, polarisation };
            if !self.connect(here, &sent, out) {
                self.through_panes(here, &sent, Beyond::Sky, out, scratch);
            }
        }
    }

    /// Lights that are no faces, as [`Backward::sample_sky`].
    pub(super) fn sample_lights(
        &self,
        here: &Here<'_, '_, M>,
        [pick, u, v]: [f64; 3],
        out: &mut [Light],
        scratch: &mut Ledger,
    ) {
        if self.world.lights.all().is_empty() {
            return;
        }
        let Some((index, probability, toward)) = self.world.lights.sample(here.vertex.hit.point, pick, [u, v]) else {
            return;
        };
        let group = self.world.lights.all()[index].group();
        if self.share_of(here, group).is_none() && !self.may_be_behind_panes(here, group) {
            return;
        }
        let (luminance, pdf, by_chance) = match toward.light {
            Strength::Delta(illuminance) => (illuminance, probability, false),
            Strength::Area(luminance, density) => (luminance, probability * density, true),
        };
        let tint = here.walker.optics.light(index);
        let luminance = lanes::<M, _>(|lane| luminance * tint[lane]);
        let (dir, distance, source) = (toward.dir, toward.distance, Source::Light);
        let (target, shown, polarisation) = (None, None, None);
        let sent = Sent { dir, distance, target, luminance, pdf, by_chance, group, source, shown, polarisation };
        if !self.connect(here, &sent, out) {
            if by_chance {
                self.through_panes(here, &sent, Beyond::Disc(index), out, scratch);
            } else if self.world.ordinary {
                self.through_cutouts(here, &sent, out, scratch);
            }
        }
    }

    /// Share of the picture that a group's light has which is scattered here; none: not ours.
    fn share_of(&self, here: &Here<'_, '_, M>, group: GroupId) -> Option<usize> {
        self.route.from_eye(group, here.walker.trail.then(here.scatter.event()))
    }

    /// Whether light of a group that comes over faces which transmit, or which are not there, may be ours.
    fn may_be_behind_panes(&self, here: &Here<'_, '_, M>, group: GroupId) -> bool {
        let trail = here.walker.trail.then(here.scatter.event());
        let owned = |trail| self.route.from_eye(group, trail).is_some();
        self.panes && (owned(trail) || owned(trail.then(Event::Specular)))
    }

    /// Adds the light that comes from a lamp, if nothing is in between; false if something is.
    fn connect(&self, here: &Here<'_, '_, M>, sent: &Sent<'_, M>, out: &mut [Light]) -> bool {
        let Here { walker, vertex, scatter, frame } = *here;
        let Sent { dir, distance, target, luminance, pdf, by_chance, group, source, shown, polarisation } = *sent;
        let (d_in, d_out) = (frame.to_local(walker.ray.dir), frame.to_local(dir));
        let sides = walker.sides(vertex, scatter);
        let (values, alone) = sides.eval(scatter, d_in, d_out);
        let through = d_out.z < 0.0;
        if values.as_slice().iter().all(|value| *value <= 0.0) || !vertex.is_left_by(dir, through) {
            return true;
        }
        let ray = Ray { origin: vertex.hit.point, dir, from: Some(vertex.hit.site) };
        let at_once = vertex.at_once(through).is_some_and(|hit| !self.world.is_absent(hit.site));
        if at_once || self.world.geometry.occluded_beside(&ray, vertex.beside, distance, target) {
            return false;
        }
        if self.world.eye.blocks_reversed(ray.origin, ray.dir, distance) {
            return true;
        }
        let Some(share) = self.share_of(here, group) else { return true };
        let plane = self.route.plane(share, |sieve| {
            let told = sieve.after(walker.told, Letter::of(scatter.event(), through));
            sieve.takes(told, sieve.lamp(group.index(), source))
        });
        let out = plane_of::<M>(out, plane);
        let (index, transmittance) = walker.beyond(vertex, through, distance);
        let weight = if by_chance { pdf / (pdf + scatter.pdf(d_in, d_out, sides.of(0))) } else { 1.0 };
        let factor = d_out.z.abs() / pdf * weight;
        let arriving = lanes::<M, _>(|lane| luminance[lane] * (values[lane] * factor) * transmittance[lane]);
        let mut beam = walker.beam;
        if alone {
            beam.part();
        }
        if let Some(facets) = sides.facets(scatter, (d_in, d_out), &values) {
            beam.scatter(Some(&facets), [walker.ray.dir, dir], true);
            if let Some(light) = polarisation {
                beam = beam.polarised(light, dir, true);
            }
        }
        if let Some((slide, s)) = &shown {
            beam.show(*slide, s);
        }
        let amounts = lanes::<M, _>(|lane| arriving[lane] / (index[lane] * index[lane]));
        beam.deposit(walker.optics, out, &amounts);
        true
    }

    /// Adds the light of a point or of a direction that comes through cut-out materials, which no scattered ray finds.
    fn through_cutouts(&self, here: &Here<'_, '_, M>, sent: &Sent<'_, M>, out: &mut [Light], scratch: &mut Ledger) {
        let Some(share) = self.share_of(here, sent.group) else { return };
        let Here { walker, vertex, scatter, frame } = *here;
        let mut walker = walker.clone();
        walker.rng = walker.rng.fork();
        let sent_here = (vertex, scatter, frame);
        if !walker.scatter_to(sent_here, (sent.dir, sent.pdf), scratch) || !walker.go_straight(sent.distance, scratch) {
            return;
        }
        let plane = self.route.plane_from_eye(share, walker.told, sent.group, sent.source);
        walker.pick_up(plane_of::<M>(out, plane), &sent.luminance);
    }

    /// Adds the light that comes from a direction over faces that transmit. Where they bend it, what is found is what lies
    /// in the bent direction: the chosen one is as good as any, and weighed by how it was chosen.
    fn through_panes(
        &self,
        here: &Here<'_, '_, M>,
        sent: &Sent<'_, M>,
        beyond: Beyond,
        out: &mut [Light],
        scratch: &mut Ledger,
    ) {
        if !self.may_be_behind_panes(here, sent.group) {
            return;
        }
        let Here { walker, vertex, scatter, frame } = *here;
        let (d_in, d_out) = (frame.to_local(walker.ray.dir), frame.to_local(sent.dir));
        let density = scatter.pdf(d_in, d_out, walker.sides(vertex, scatter).of(0));
        let mut walker = walker.clone();
        walker.rng = walker.rng.fork();
        let sent_here = (vertex, scatter, frame);
        if !walker.scatter_to(sent_here, (sent.dir, sent.pdf + density), scratch) || !walker.leave(scratch) {
            return;
        }
        let Some(share) = self.route.from_eye(sent.group, walker.trail) else { return };
        let luminance = match (beyond, &self.world.sky) {
            (Beyond::Sky, Some(sky)) => walker.optics.sky(sky, walker.ray.dir),
            (Beyond::Sky, None) => return,
            (Beyond::Disc(index), _) => {
                let tint = walker.optics.light(index);
                let luminance = self.world.lights.luminance(index, walker.ray.dir);
                lanes::<M, _>(|lane| luminance * tint[lane])
            }
        };
        let plane = self.route.plane_from_eye(share, walker.told, sent.group, sent.source);
        walker.pick_up(plane_of::<M>(out, plane), &luminance);
    }
}
