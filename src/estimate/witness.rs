//! An independent witness of a run: beside each pass, naive paths look at some pixels for the light that anybody but such
//! paths has traced: from the eye, over whatever face they meet, with next-event estimation at scatterers. No table, no
//! connection, no photon, numbers of their own. All that they are told is where
//! in the pupil lamps are seen, and where light that lands about a place came from; a share of them goes anywhere. What they see goes into no picture;
//! [`judge`](eyebox_film::witness::judge) holds it against one.
//!
//! What such paths have traced themselves is followed from the lamps (`from_lamps`).
//!
//! How many looks a pass gets is a function of that pass: its counted work over that of a look, which a few looks before the
//! first pass tell. So the same looks are made in whatever pieces the passes are.

mod from_lamps;

use super::backward::{Backward, Glow};
use super::ledger::Ledger;
use super::ownership::Ownership;
use super::photon::{Landing, PhotonMapper};
use super::pixel::Pixel;
use super::tuning::witness::{
    BEFORE, CHUNK, ENOUGH, MOST_SAMPLES, MOST_TIMES, PHOTONS, ROUNDS, SELDOM, SHARE, SHARE_OF_SENT, TRIED,
    TRIED_SAMPLES,
};
use super::vision::Hints;
use crate::manifold::receiver::Receivers;
use eyebox_base::ids::GroupId;
use eyebox_base::parallel;
use eyebox_base::path::Class;
use eyebox_base::rng::{Rng, Stream};
use eyebox_film::accumulate::{Light, PlaneKey};
use eyebox_film::guide::ApertureGuide;
use eyebox_film::plan::{Estimator, Plan, Radii, Row, Verdict};
use eyebox_film::witness::{Unwatched, Watched, Witness as Record, pixels};
use eyebox_world::World;
use eyebox_world::lamp::Lamp;
use eyebox_world::mode::{Mode, Mono, components};
use eyebox_world::surface::Surface;
use from_lamps::FromLamps;
use std::sync::Arc;

/// A witness, ready to look.
pub struct Witness<'w, M: Mode> {
    world: &'w World,
    backward: Backward<'w, M>,
    pixels: Vec<u32>,
    width: usize,
    seed: u64,
    /// Counted work of a look.
    cost: f64,
    /// What rays from the eye trace themselves, followed from the lamps; with the counted work of a sample of it.
    sent: Option<(FromLamps<'w>, f64)>,
    pub record: Record,
}

impl<'w, M: Mode> Witness<'w, M> {
    /// None if there is no light. `guide`: where in the pupil lamps are seen; a share of the
    /// rays goes anywhere.
    pub fn new(
        world: &'w World,
        plan: &Plan,
        groups: usize,
        (size, guide): ([usize; 2], Option<&ApertureGuide>),
        seed: u64,
    ) -> Option<Self> {
        let (watched, mut unwatched) = kinds(world, plan);
        // Other numbers than those of paths from the eye that are part of the run.
        let own_seed = Rng::new(seed, Stream::Witness, 1, 0).next_u64();
        let (from_lamps, more) = FromLamps::new(world, plan, groups, size, own_seed);
        unwatched.extend(more);
        let (from_lamps, sent) = from_lamps.unzip();
        let sent = sent.unwrap_or_default();
        if watched.is_empty() && unwatched.is_empty() && sent.is_empty() {
            return None;
        }
        let key = |group: GroupId, class: Class, has_broad: bool| {
            let layer = plan.layer(Estimator::Backward, group, class, has_broad);
            let skipped = matches!(plan.row(group, class).verdict, Verdict::Skip { .. });
            let ours = watched.iter().any(|own| (own.layer, own.group) == (layer, group));
            (ours && !skipped).then_some(PlaneKey { layer, group, takes: 0 })
        };
        let route = Ownership::by(groups, &key);
        // Planes come in the order in which paths ask for them.
        let watched: Vec<Watched> = route
            .planes
            .iter()
            .filter_map(|key| watched.iter().find(|own| (own.layer, own.group) == (key.layer, key.group)).cloned())
            .collect();
        let scatters = watched.iter().any(|own| own.classes.iter().any(|class| *class != Class::Vision));
        let hints = Hints { pupil: guide, ..Hints::of_sky(None) };
        let backward = Backward::new(world, route, (u32::from(scatters), 1.0), hints, own_seed);
        let glow = if scatters { glow(world, plan, groups, &key, own_seed) } else { None };
        let aimed = glow.is_some();
        let missed = glow.as_ref().map_or(0.0, Glow::missed);
        let backward = backward.towards(glow);
        let mut watched = watched;
        for own in &mut watched {
            let scattered = own.classes.iter().any(|class| *class != Class::Vision);
            own.aimed = if scattered { aimed } else { guide.is_some() };
            own.missed = if scattered { missed } else { 0.0 };
            own.brightest *= if own.aimed { SELDOM } else { 1.0 };
        }
        let record = Record::new(size, seed, (watched, sent), unwatched);
        let sent = from_lamps.map(|from_lamps| {
            let work: u64 = (0..TRIED_SAMPLES).map(|tried| from_lamps.sample::<M>(BEFORE + tried).1).sum();
            (from_lamps, (work as f64 / TRIED_SAMPLES as f64).max(1.0))
        });
        let pixels = pixels(size, seed);
        let mut witness = Witness { world, backward, pixels, width: size[0], seed: own_seed, cost: 1.0, sent, record };
        if witness.record.watched.is_empty() {
            return Some(witness);
        }
        let looks = witness.looks(BEFORE, TRIED);
        let work = looks.iter().map(|(_, work)| work).sum::<u64>();
        witness.cost = (work as f64 / TRIED as f64).max(1.0);
        Some(witness)
    }

    /// Looks beside passes of these numbers and counted work.
    pub fn attend(&mut self, passes: &[(u64, u64)]) {
        for (pass, work) in passes {
            self.follow_light(*pass, *work);
            self.record.beside = self.record.beside.saturating_add(*work);
            if self.record.watched.is_empty() {
                continue;
            }
            let mut rng = Rng::new(self.seed, Stream::Witness, 2, *pass);
            let most = MOST_TIMES * self.pixels.len() as u64;
            // Beyond the whole ones chance decides.
            let count = ((SHARE * *work as f64 / self.cost + rng.uniform()) as u64).min(most);
            let looks = self.looks(*pass, count);
            for (chunk, work) in looks {
                for (slot, light) in chunk {
                    self.record.add(slot, &light);
                }
                self.record.work = self.record.work.saturating_add(work);
            }
        }
    }

    /// Follows light from the lamps beside a pass of this number and counted work.
    fn follow_light(&mut self, pass: u64, work: u64) {
        let Some((from_lamps, cost)) = &self.sent else { return };
        let share = SHARE_OF_SENT[usize::from(!self.record.watched.is_empty())];
        let mut rng = Rng::new(self.seed, Stream::Witness, 6, pass);
        let count = ((share * work as f64 / cost + rng.uniform()) as u64).min(MOST_SAMPLES);
        let number = |sample: u64| pass.wrapping_mul(MOST_SAMPLES).wrapping_add(sample);
        let samples: Vec<_> = parallel::map(count as usize, &|sample| from_lamps.sample::<M>(number(sample as u64)));
        for (parts, work) in samples {
            self.record.sent.iter_mut().zip(&parts).for_each(|(sent, parts)| sent.add(parts));
            self.record.work = self.record.work.saturating_add(work);
        }
    }

    /// So many looks of a pass, chunk by chunk, each with its counted work.
    fn looks(&self, pass: u64, count: u64) -> Vec<(Vec<Seen>, u64)> {
        let slots = self.pixels.len() as u64;
        // Passes start anywhere among the pixels, so all have their turn however few looks a pass has.
        let first = Rng::new(self.seed, Stream::Witness, 3, pass).next_u64() % slots.max(1);
        let chunks = count.div_ceil(CHUNK);
        let of_chunk = |chunk: u64| {
            // One number after the other: wavelengths go by the lowest bits.
            let optics = M::optics(self.world, self.seed, pass.wrapping_mul(chunks).wrapping_add(chunk));
            let parts = self.world.solids.len();
            let mut ledgers = [Ledger::new(parts), Ledger::new(parts)];
            let mut light = vec![Light::default(); self.record.watched.len() * M::COMPONENTS];
            let mut seen = Vec::new();
            for number in chunk * CHUNK..((chunk + 1) * CHUNK).min(count) {
                let slot = ((first + number) % slots) as usize;
                let pixel = self.pixels[slot] as usize;
                let time = pass.wrapping_mul(MOST_TIMES).wrapping_add(number / slots);
                light.fill(Light::default());
                let pixel = Pixel::new((pixel % self.width, pixel / self.width), self.width, time);
                self.backward.look(&optics, pixel, &mut light, &mut ledgers);
                let luminance = |entries: &[Light]| components::<M>().luminance(entries);
                let each = light.chunks(M::COMPONENTS).map(luminance).map(|light| [light.value, light.open()]);
                seen.push((slot, each.collect()));
            }
            (seen, ledgers[0].work + ledgers[1].work)
        };
        parallel::map(count.div_ceil(CHUNK) as usize, &|chunk| of_chunk(chunk as u64))
    }
}

/// Where light that lands on scatterers came from, by photons that no connection has a part in.
fn glow(
    world: &World,
    plan: &Plan,
    groups: usize,
    key: &dyn Fn(GroupId, Class, bool) -> Option<PlaneKey>,
    seed: u64,
) -> Option<Glow> {
    // Beside connection a plan's photons go where that leaves light.
    let connected =
        plan.rows.iter().any(|row| row.class == Class::Caustic && matches!(row.verdict, Verdict::Connect { .. }));
    let guide = plan.photon_guide.as_ref().filter(|_| !connected);
    let screens = Arc::new(Receivers::new(world, &Mono::<f64>::optics(world, seed, 0), &[]));
    let route = Ownership::by(groups, key);
    let photons = PhotonMapper::<Mono>::new(world, route, groups, PHOTONS, guide, Radii::default(), screens, seed);
    let mut landed: Vec<Landing> = Vec::new();
    for round in 0..ROUNDS {
        landed.extend(photons.landings(BEFORE + round, &|| false).into_iter().flat_map(|landed| landed.landings));
        if landed.len() >= ENOUGH {
            break;
        }
    }
    Glow::new(&landed)
}

/// A pixel by number, and per kind of light what a look brought.
type Seen = (usize, Vec<[f64; 2]>);

/// The light that naive paths have to look for, and what they can't see.
fn kinds(world: &World, plan: &Plan) -> (Vec<Watched>, Vec<Unwatched>) {
    let (mut watched, mut unwatched): (Vec<Watched>, Vec<Unwatched>) = (Vec::new(), Vec::new());
    let layer = |row: &Row, has_broad: bool| plan.layer(Estimator::Backward, row.group, row.class, has_broad);
    let specular = world.faces.iter().flatten().any(|face| match face.surface {
        Surface::Mirror(_)
        | Surface::Interface(_)
        | Surface::Sheet(_)
        | Surface::Splitter(_)
        | Surface::Grating(_)
        | Surface::Slide(_) => true,
        Surface::Absent | Surface::Absorber | Surface::Scatter(_) => false,
    });
    for row in plan.rows.iter().filter(|row| !is_plain(&row.verdict)) {
        let points = || world.lights.all().iter().any(|light| light.group() == row.group && !light.is_visible());
        let over_faces = matches!(row.class, Class::Caustic | Class::Secondary);
        let rays = world.lights.all().iter().any(|light| light.group() == row.group && light.rays().is_some());
        if rays {
            let because = "no path from the eye meets the rays of a file".to_owned();
            unwatched.push(Unwatched { group: row.group, class: row.class, because });
            continue;
        }
        if specular && over_faces && points() {
            let because = "no path from the eye meets a lamp without extent".to_owned();
            unwatched.push(Unwatched { group: row.group, class: row.class, because });
            continue;
        }
        let layer = layer(row, row.class != Class::Vision);
        match watched.iter_mut().find(|own| (own.layer, own.group) == (layer, row.group)) {
            Some(own) => own.classes.push(row.class),
            None => {
                let brightest = brightest(world, row.group);
                let classes = vec![row.class];
                watched.push(Watched { layer, group: row.group, classes, brightest, aimed: true, missed: 0.0 });
            }
        }
    }
    // Their light is in the same layer as that which is watched, so it has to be looked for, too.
    for row in plan.rows.iter().filter(|row| matches!(row.verdict, Verdict::Own { owner: Estimator::Backward, .. })) {
        let layer = layer(row, row.class != Class::Vision);
        if let Some(own) = watched.iter_mut().find(|own| (own.layer, own.group) == (layer, row.group)) {
            own.classes.push(row.class);
        }
    }
    watched.iter_mut().for_each(|own| own.classes.sort_unstable());
    (watched, unwatched)
}

/// Whether naive paths trace this light anyway, or there is none.
fn is_plain(verdict: &Verdict) -> bool {
    match verdict {
        Verdict::Own { owner, .. } => *owner == Estimator::Backward,
        Verdict::Connect { .. } | Verdict::Emitted { .. } => false,
        Verdict::Skip { .. } => true,
    }
}

/// The largest luminance of a group's lamps, cd/m²; infinite if something else than emitting faces may be seen.
fn brightest(world: &World, group: GroupId) -> f64 {
    let others = world.lights.all().iter().any(|light| light.group() == group);
    let sky = world.sky.as_ref().is_some_and(|sky| sky.group == group);
    if others || sky {
        return f64::INFINITY;
    }
    world.lamps.all().iter().filter(|lamp| lamp.group == group).map(Lamp::brightest).fold(0.0, f64::max)
}
