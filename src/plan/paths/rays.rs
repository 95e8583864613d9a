//! Some paths one by one, with every point where they turn, and what became of each: for "why is it black?".

use super::tuning::rays::MOST_POINTS;
use super::{Source, part_name, source_name};
use eyebox_base::parallel;
use eyebox_base::rng::{Rng, Stream};
use eyebox_check::Checked;
use eyebox_estimate::ShouldStop;
use eyebox_estimate::ledger::Ledger;
use eyebox_estimate::walk::{Meeting, Met, Travel, Walker};
use eyebox_output::rays::{End, Fate, Fates, Strip};
use eyebox_world::World;
use eyebox_world::geometry::{Ray, Site};
use eyebox_world::interior::Interior;
use eyebox_world::mode::{Mode, MonoStokes};
use eyebox_world::optics::Optics;
use eyebox_world::surface::Surface;
use glam::DVec3;
use std::collections::BTreeMap;

/// Where paths start.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum From {
    /// On the lamps, by flux and intensity.
    Lamps,
    /// In the pupil: through this pixel (column, row), or the whole picture.
    Eye(Option<[usize; 2]>),
}

/// Which paths are traced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Asked {
    pub from: From,
    /// Paths that are kept with their points (rare ends among them), and all that are counted, at least as many.
    pub kept: u64,
    pub counted: u64,
    pub seed: u64,
}

/// What one path left.
struct Traced {
    strip: Strip,
    fates: Fates,
    ledger: Ledger,
}

/// Traces the paths: strips in the recentred frame of the world (see `Geometry::origin`), what became of their light, and
/// the ledger that says so too. Light is traced at one wavelength, with its polarisation. Once `stop` says true the rest is
/// left out.
pub fn rays(checked: &Checked, world: &World, asked: Asked, stop: &ShouldStop<'_>) -> (Vec<Strip>, Fates, Ledger) {
    let optics = MonoStokes::optics(world, asked.seed, 0);
    let counted = asked.counted.max(asked.kept);
    let (mut drawn, mut fates) = (Drawn::new(asked.kept), Fates::default());
    let mut ledger = Ledger::new(world.solids.len());
    // In blocks, so that memory does not grow with the paths that are counted.
    const BLOCK: u64 = 1 << 12;
    for block in 0..counted.div_ceil(BLOCK) {
        let samples = block * BLOCK..((block + 1) * BLOCK).min(counted);
        let one = |k: u64| if stop() { None } else { trace((checked, world, &optics), asked, samples.start + k) };
        let traced: Vec<Traced> = parallel::filter_map(samples.end - samples.start, &one);
        for one in traced {
            drawn.add(one.strip);
            fates.merge(one.fates);
            ledger.merge(&one.ledger);
        }
    }
    (drawn.strips(), fates, ledger)
}

/// Paths that are drawn: one half as they come, the other from each end in turn, so that rare ends are seen too.
struct Drawn {
    first: Vec<Strip>,
    rest: BTreeMap<End, Vec<Strip>>,
    kept: usize,
}

impl Drawn {
    fn new(kept: u64) -> Self {
        Drawn { first: Vec::new(), rest: BTreeMap::new(), kept: usize::try_from(kept).unwrap_or(usize::MAX) }
    }

    fn add(&mut self, strip: Strip) {
        let half = self.kept.div_ceil(2);
        if self.first.len() < half {
            return self.first.push(strip);
        }
        let own = self.rest.entry(strip.end.clone()).or_default();
        if own.len() < self.kept - half {
            own.push(strip);
        }
    }

    fn strips(self) -> Vec<Strip> {
        let (mut strips, mut rest) = (self.first, self.rest.into_values().map(Vec::into_iter).collect::<Vec<_>>());
        while strips.len() < self.kept && !rest.is_empty() {
            let left = self.kept - strips.len();
            strips.extend(rest.iter_mut().filter_map(Iterator::next).take(left));
            rest.retain(|strips| strips.len() > 0);
        }
        strips
    }
}

/// Starts a path; none if nothing shines.
fn start<'w>(
    (world, optics): (&'w World, &'w Optics<MonoStokes>),
    from: From,
    mut rng: Rng,
) -> Option<(Walker<'w, MonoStokes>, Option<Source>)> {
    match from {
        From::Eye(pixel) => {
            let [width, height] = world.eye.size();
            let [u, v] = rng.pair();
            let [x, y] = pixel.unwrap_or([(u * width as f64) as usize, (v * height as f64) as usize]);
            let (origin, dir) = world.eye.ray(x, y, rng.pair(), rng.pair());
            let ray = Ray { origin, dir, from: None };
            let walker = Walker::new((world, optics), Travel::FromEye, ray, 1.0, Interior::default(), rng);
            Some((walker, None))
        }
        From::Lamps => {
            let lights: f64 = world.lights.all().iter().map(|light| light.flux_lm()).sum();
            let faces = world.lamps.total_flux_lm();
            let pick = rng.uniform() * (faces + lights);
            let (source, ray, normal, interior) = if pick < faces {
                let (index, _) = world.lamps.pick_by_flux(rng.uniform())?;
                let lamp = world.lamps.get(index)?;
                let point = lamp.sample_point(rng.pair());
                let dir = lamp.sample_direction(point.normal, rng.pair());
                let from = Site { part: lamp.part as u32, face: lamp.face as u32, triangle: point.triangle };
                let ray = Ray { origin: point.position, dir, from: Some(from) };
                (Source::Face(index), ray, Some(point.normal), *world.lamp_interiors.get(index)?)
            } else {
                let mut left = pick - faces;
                let mut all = world.lights.all().iter().enumerate().filter(|(_, light)| light.flux_lm() > 0.0);
                let (index, _) = all.find(|(_, light)| {
                    left -= light.flux_lm();
                    left < 0.0
                })?;
                let (ray, interior) = world.start_of_light(index, rng.pair(), rng.pair());
                (Source::Light(index), ray, None, interior)
            };
            let dir = ray.dir;
            let mut walker = Walker::new((world, optics), Travel::FromLamp, ray, 1.0, interior, rng);
            if let Some(normal) = normal {
                walker = walker.from_face(normal);
            }
            if let Source::Face(index) = source
                && let Some(light) = world.lamps.get(index).and_then(|lamp| lamp.polarisation)
            {
                walker.beam = walker.beam.polarised(light, dir, false);
            }
            Some((walker, Some(source)))
        }
    }
}

fn trace(
    (checked, world, optics): (&Checked, &World, &Optics<MonoStokes>),
    asked: Asked,
    sample: u64,
) -> Option<Traced> {
    let scene = checked.scene();
    let rng = Rng::new(asked.seed, Stream::Check, 0, sample);
    let (mut walker, source) = start((world, optics), asked.from, rng)?;
    let mut ledger = Ledger::new(world.solids.len());
    ledger.paths = 1;
    ledger.emitted = walker.beam.carried();
    let mut points = vec![walker.ray.origin];
    let mut met: Vec<String> = source.iter().map(|source| source_name(scene, world, *source)).collect();
    // From the eye: what lamps took, which the ledger books with their parts.
    let mut at_lamps: BTreeMap<u32, f64> = BTreeMap::new();
    let (_, reach) = bounds(world);
    let (end, carried) = loop {
        let (origin, dir) = (walker.ray.origin, walker.ray.dir);
        let before = walker.beam.carried();
        match walker.advance(&mut ledger) {
            Met::Sky => {
                points.push(origin + dir * reach);
                walker.escape(&mut ledger);
                let sky = asked.from != From::Lamps && world.sky.is_some();
                break (if sky { End::Sky } else { End::Escaped }, walker.beam.carried());
            }
            Met::Pupil(arrival) => {
                points.push(origin + dir * arrival.t);
                ledger.arrived += walker.beam.carried();
                let end = if arrival.pixel.is_some() { End::Arrived } else { End::PastField };
                break (end, walker.beam.carried());
            }
            // Only the eye stops a path between two faces.
            Met::Ended => break (End::Arrived, before),
            Met::Face(vertex) => {
                if points.len() < MOST_POINTS {
                    points.push(vertex.hit.point);
                }
                let part = vertex.hit.site.part;
                let name = part_name(scene, part);
                if met.last() != Some(&name) && met.len() < MOST_POINTS {
                    met.push(name.clone());
                }
                let shines = asked.from != From::Lamps && walker.lamp_at(&vertex).is_some();
                let before = walker.beam.carried();
                let taken = ledger.absorbed.get(part as usize).copied().unwrap_or_default();
                let (cut, wrong, lost) = (ledger.cut, ledger.wrong_side, ledger.roulette_lost);
                let went = match walker.meet(&vertex, &mut ledger) {
                    Meeting::Went => true,
                    Meeting::Ended => false,
                    Meeting::Scatter(scatter, frame) => walker.scatter(&vertex, scatter, &frame, &mut ledger).is_some(),
                };
                if shines {
                    let took = ledger.absorbed.get(part as usize).copied().unwrap_or_default() - taken;
                    *at_lamps.entry(part).or_default() += took;
                }
                if !went {
                    let absorber = matches!(walker.face(&vertex).surface, Surface::Absorber);
                    let end = if shines && absorber {
                        End::Lamp(name)
                    } else if ledger.cut > cut {
                        End::Cut
                    } else if ledger.wrong_side > wrong {
                        End::WrongSide
                    } else if ledger.roulette_lost > lost && !absorber {
                        End::Faint
                    } else {
                        End::Absorbed(name)
                    };
                    break (end, before);
                }
            }
        }
    };
    let strip = Strip { points, met, end: end.clone(), power: carried };
    let fates = book(checked, &ledger, &end, &at_lamps);
    Some(Traced { strip, fates, ledger })
}

/// The ledger of one path by name.
fn book(checked: &Checked, ledger: &Ledger, end: &End, at_lamps: &BTreeMap<u32, f64>) -> Fates {
    let scene = checked.scene();
    let mut fates = Fates { started: ledger.emitted, paths: 1, gained: ledger.roulette_gained, all: BTreeMap::new() };
    let mut add = |end: End, amount: f64| {
        if amount != 0.0 {
            fates.all.entry(end).or_insert(Fate { power: 0.0, paths: 0 }).power += amount;
        }
    };
    for (part, amount) in ledger.absorbed.iter().enumerate().filter(|(_, amount)| **amount != 0.0) {
        let part = u32::try_from(part).unwrap_or(u32::MAX);
        let lamp = at_lamps.get(&part).copied().unwrap_or_default();
        add(End::Lamp(part_name(scene, part)), lamp);
        add(End::Absorbed(part_name(scene, part)), amount - lamp);
    }
    let arrived = if *end == End::PastField { End::PastField } else { End::Arrived };
    let escaped = if *end == End::Sky { End::Sky } else { End::Escaped };
    add(arrived, ledger.arrived);
    add(escaped, ledger.escaped);
    add(End::Faint, ledger.roulette_lost);
    add(End::WrongSide, ledger.wrong_side);
    add(End::Cut, ledger.cut);
    fates.all.entry(end.clone()).or_insert(Fate { power: 0.0, paths: 0 }).paths += 1;
    fates
}

/// Middle of the scene and how far a path is drawn that leaves it, m.
fn bounds(world: &World) -> (DVec3, f64) {
    let (low, high) = world.geometry.bounds();
    (0.5 * (low + high), 0.25 * (high - low).length())
}
