//! Paths from the eye to what shines, over specular faces alone, and to scatterers; each knows its parts.

use super::chain_sampling::All;
use super::lamp_paths::{Caught, LampEnd, Source, Split, Trace, Way};
use super::part_sequence::Visits;
use eyebox_base::chain::Chain;
use eyebox_base::ids::GroupId;
use eyebox_base::parallel;
use eyebox_base::rng::Rng;
use eyebox_estimate::ShouldStop;
use eyebox_estimate::emission::Shots;
use eyebox_estimate::emitter_hit::EmitterHit;
use eyebox_estimate::ledger::Ledger;
use eyebox_estimate::walk::{Meeting, Met, Travel, Vertex, Walker};
use eyebox_film::accumulate::Light;
use eyebox_film::guide::Point;
use eyebox_world::World;
use eyebox_world::geometry::Ray;
use eyebox_world::interior::Interior;
use eyebox_world::mode::{Mode, components, lanes};
use eyebox_world::optics::Optics;
use eyebox_world::scatter::Scatter;
use std::cell::Cell;

/// A scatterer that a path from the eye has met.
pub struct End<'e, 'w, M: Mode> {
    pub walker: &'e Walker<'w, M>,
    pub vertex: &'e Vertex,
    pub scatter: &'w Scatter,
    pub frame: &'e eyebox_base::warp::Frame,
    /// From the scatterer to the eye.
    pub chain: Visits,
}

/// What paths from the eye look for.
pub struct EyePaths<'a, 'w, M: Mode> {
    pub world: &'w World,
    pub optics: &'w Optics<M>,
    pub split: Split,
    /// Groups whose light over specular faces is looked for.
    pub vision: &'a (dyn Fn(GroupId) -> bool + Sync),
    /// Chains whose light is left out, since others measure it.
    pub owned: &'a All,
    /// How light over specular faces came is kept.
    pub traces: bool,
    /// What is known of the light at a scatterer: group, source, way and luminance towards the eye.
    #[allow(clippy::type_complexity)]
    pub scattered: Option<&'a (dyn Fn(&End<'_, 'w, M>, &mut dyn FnMut(GroupId, Source, Way, f64)) + Sync)>,
}

/// A path from the eye under way.
struct Look {
    vertices: Cell<u32>,
    pixel: u32,
    /// Point of the unit cube of picture and pupil.
    start: Point,
    /// What a unit of luminance is in lm, and in luminance of the pixel.
    per: [f64; 2],
    found: Vec<Caught>,
}

impl Look {
    fn add(&mut self, group: GroupId, source: Source, way: Way, luminance: f64) -> Option<&mut Caught> {
        if !(luminance > 0.0 && luminance.is_finite()) {
            return None;
        }
        let [lumens, luminance] = self.per.map(|per| per * luminance);
        self.found.push(Caught { group, source, way, pixel: self.pixel, lumens, luminance, trace: None });
        self.found.last_mut()
    }
}

impl<'w, M: Mode> EyePaths<'_, 'w, M> {
    /// One pass of paths from the eye, spread evenly over the picture: what each found, in their order.
    pub fn run(&self, shots: Shots, stop: &ShouldStop<'_>) -> Vec<Vec<Caught>> {
        let eye = &self.world.eye;
        let [width, height] = eye.size();
        let pixels = (width * height) as f64;
        let one = |sample: u64| {
            if stop() {
                return None;
            }
            let mut rng = Rng::new(shots.seed, shots.stream, shots.pass, sample);
            let at = ((sample as f64 + rng.uniform()) / shots.paths as f64 * pixels) as usize;
            let pixel = at.min((width * height).saturating_sub(1));
            let (film, lens) = (rng.pair(), rng.pair());
            let (origin, dir) = eye.ray(pixel % width, pixel / width, film, lens);
            let share = pixels / shots.paths as f64;
            let per = [eye.lumens_per_luminance(dir) * share, share];
            let place = |at: usize, within: f64, count: usize| (at as f64 + within) / count as f64;
            let start = [place(pixel % width, film[0], width), place(pixel / width, film[1], height), lens[0], lens[1]];
            let mut look = Look { vertices: Cell::new(0), pixel: pixel as u32, start, per, found: Vec::new() };
            let ray = Ray { origin, dir, from: None };
            let start = (self.world, self.optics);
            let walker = Walker::new(start, Travel::FromEye, ray, 1.0, Interior::default(), rng).recording();
            let mut ledger = Ledger::new(self.world.solids.len());
            self.follow(walker, &mut look, &mut ledger);
            (!look.found.is_empty()).then_some(look.found)
        };
        parallel::filter_map(shots.paths, &one)
    }

    fn visits(&self, source: Option<Source>, walker: &Walker<'w, M>) -> Visits {
        let chain = walker.chain().map(Chain::reversed).unwrap_or_default();
        Source::visits(source, self.world, &chain)
    }

    fn follow(&self, mut walker: Walker<'w, M>, look: &mut Look, ledger: &mut Ledger) {
        loop {
            let vertex = match walker.advance(ledger) {
                Met::Sky => return self.sky(&walker, look),
                Met::Pupil(_) | Met::Ended => return,
                Met::Face(vertex) => vertex,
            };
            if let Some(seen) = walker.lamp_at(&vertex)
                && (self.vision)(seen.lamp.group)
            {
                let hit = &vertex.hit;
                let end = LampEnd {
                    lamp: seen.index,
                    point: hit.point,
                    normal: hit.normal,
                    dir: walker.ray.dir,
                    site: hit.site,
                };
                let found = (seen.lamp.group, Source::Face(seen.index), seen_light(&walker, &seen));
                self.find(&walker, look, found, Some(end));
            }
            if let Some(least) = self.split.at(&walker, &look.vertices)
                && let Some(reflected) = walker.split(&vertex, least, u8::MAX, ledger)
            {
                self.follow(reflected, look, ledger);
            }
            match walker.meet(&vertex, ledger) {
                Meeting::Ended => return,
                Meeting::Went => {}
                Meeting::Scatter(scatter, frame) => {
                    if let Some(scattered) = self.scattered {
                        let chain = self.visits(None, &walker);
                        let end = End { walker: &walker, vertex: &vertex, scatter, frame: &frame, chain };
                        scattered(&end, &mut |group, source, way, luminance| {
                            look.add(group, source, way, luminance);
                        });
                    }
                    return;
                }
            }
        }
    }

    fn sky(&self, walker: &Walker<'w, M>, look: &mut Look) {
        beyond(walker, &mut |group, source, luminance| {
            if (self.vision)(group) {
                self.find(walker, look, (group, source, luminance), None);
            }
        });
    }

    /// Adds light that came over specular faces alone.
    fn find(
        &self,
        walker: &Walker<'w, M>,
        look: &mut Look,
        (group, source, luminance): (GroupId, Source, f64),
        end: Option<LampEnd>,
    ) {
        let chain = walker.chain().map(Chain::reversed).unwrap_or_default();
        if self.owned.owns(group, &chain) {
            return;
        }
        let start = look.start;
        let way = Way::Vision(Source::visits(Some(source), self.world, &chain));
        if let Some(caught) = look.add(group, source, way, luminance).filter(|_| self.traces) {
            caught.trace = Some(Box::new(Trace { chain, start, end }));
        }
    }
}

/// Luminance of a lamp that a path from the eye has met.
fn seen_light<M: Mode>(walker: &Walker<'_, M>, seen: &EmitterHit<'_>) -> f64 {
    let mut out = [Light::default(); 3];
    walker.see(&mut out[..M::COMPONENTS], seen, 1.0);
    components::<M>().luminance_value(&out[..M::COMPONENTS])
}

/// Group, source and luminance of what a path from the eye sees beyond the scene.
fn beyond<M: Mode>(walker: &Walker<'_, M>, each: &mut dyn FnMut(GroupId, Source, f64)) {
    let luminance = |amounts: &M::Lanes<f64>| {
        let mut out = [Light::default(); 3];
        walker.pick_up(&mut out[..M::COMPONENTS], amounts);
        components::<M>().luminance_value(&out[..M::COMPONENTS])
    };
    let world = walker.world;
    if let Some(sky) = &world.sky {
        each(sky.group, Source::Sky, luminance(&walker.optics.sky(sky, walker.ray.dir)));
    }
    for (index, brightness, _) in world.lights.met(walker.ray.dir, None) {
        let Some(light) = world.lights.all().get(index) else { continue };
        let tint = walker.optics.light(index);
        each(light.group(), Source::Light(index), luminance(&lanes::<M, _>(|lane| brightness * tint[lane])));
    }
}

/// Goes on from the end of a chain to all that shines of a group before the next specular face: source and luminance.
pub fn ends<M: Mode>(
    walker: &mut Walker<'_, M>,
    group: GroupId,
    ledger: &mut Ledger,
    each: &mut dyn FnMut(Source, f64),
) {
    let links = |walker: &Walker<'_, M>| walker.chain().map_or(0, |chain| chain.0.len());
    loop {
        let vertex = match walker.advance(ledger) {
            Met::Pupil(_) | Met::Ended => return,
            Met::Sky => {
                return beyond(walker, &mut |own, source, luminance| {
                    if own == group && luminance > 0.0 {
                        each(source, luminance);
                    }
                });
            }
            Met::Face(vertex) => vertex,
        };
        if let Some(seen) = walker.lamp_at(&vertex).filter(|seen| seen.lamp.group == group) {
            each(Source::Face(seen.index), seen_light(walker, &seen));
        }
        let before = links(walker);
        if !matches!(walker.meet(&vertex, ledger), Meeting::Went) || links(walker) > before {
            return;
        }
    }
}
