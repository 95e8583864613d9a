//! Which slides light crosses one after the other. Only where a look finds such light do paths tell of it, so that nothing is
//! kept for slides that stand beside each other. A look that misses some costs no light: what crosses two slides that were not
//! found in series is told together with what crosses three.

use super::emission::{Emission, Origin, Shots, Starts, Visitor};
use super::ledger::Ledger;
use super::ownership::Ownership;
use super::tuning::series::{PATHS, RAYS};
use super::walk::{Meeting, Met, Travel, Vertex, Walker};
use eyebox_base::rng::{Rng, Stream};
use eyebox_base::warp::disk;
use eyebox_film::accumulate::PlaneKey;
use eyebox_film::layer::Layer;
use eyebox_world::World;
use eyebox_world::eye::Arrival;
use eyebox_world::geometry::Ray;
use eyebox_world::interior::Interior;
use eyebox_world::mode::{Mode, Mono};
use eyebox_world::optics::Optics;
use eyebox_world::scatter::Scatter;
use eyebox_world::surface::Surface;
use glam::DVec2;
use std::collections::BTreeSet;

/// Key of the look's random numbers.
const SEED: u64 = 0x5eed_0000_5e41_e500;

/// Slides by number, a bit each: there are no more than eight where they are told apart.
type Slides = u8;

/// What paths cross of which the contrasts of two slides are told: a slide and another, once each; or, of the light of displays
/// that show a slide, that one alone, once.
pub type Once = (u8, Option<u8>);

/// What a path crosses, or a piece of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
struct Crossed {
    slides: Slides,
    /// Those of them that are crossed more than once.
    again: Slides,
    /// That of them which its lamp shows.
    shown: Slides,
}

impl Crossed {
    /// Light of a lamp that shows this slide, if any.
    fn from_lamp(shown: Slides) -> Crossed {
        Crossed { slides: shown, again: 0, shown }
    }

    /// Both pieces of a path.
    fn and(self, other: Crossed) -> Crossed {
        let again = self.again | other.again | self.slides & other.slides;
        Crossed { slides: self.slides | other.slides, again, shown: self.shown | other.shown }
    }

    fn cross(&mut self, slides: Slides) {
        *self = self.and(Crossed { slides, ..Crossed::default() });
    }

    /// How paths tell that it crosses two, once each.
    fn once(self) -> Option<Once> {
        if self.again != 0 || self.slides.count_ones() != 2 {
            return None;
        }
        let met = self.slides & !self.shown;
        let first = met.trailing_zeros() as u8;
        Some((first, (met.count_ones() == 2).then(|| 7 - met.leading_zeros() as u8)))
    }
}

fn bit(slide: usize) -> Slides {
    1u8.checked_shl(slide as u32).unwrap_or(0)
}

/// The slide that a ray meets.
fn slide_at(walker: &Walker<'_, Mono>, vertex: &Vertex) -> Slides {
    match &walker.face(vertex).surface {
        Surface::Slide(slide) => bit(*slide),
        Surface::Absent
        | Surface::Absorber
        | Surface::Sheet(_)
        | Surface::Splitter(_)
        | Surface::Mirror(_)
        | Surface::Grating(_)
        | Surface::Interface(_)
        | Surface::Scatter(_) => 0,
    }
}

/// What light crosses of slides in series, in rising order.
pub fn find(world: &World, groups: usize) -> Vec<Once> {
    let optics = Mono::<f64>::optics(world, SEED, 0);
    let mut found = Found::default();
    look(world, &optics, &mut found);
    let every = |group, _, _| Some(PlaneKey { layer: Layer::Direct, group, takes: 0 });
    let emission = Emission::new(world, &Ownership::by(groups, &every), groups, None);
    let shots = Shots { seed: SEED, stream: Stream::Pilot, pass: 0, paths: PATHS, starts: Starts::OfPass };
    for path in emission.survey((world, &optics), shots, &|| false, FromLamp::default, |_, _, _, path| Some(path)) {
        found.whole.extend(path.whole);
        found.lit.extend(path.lit);
    }
    // Light of any lamp may go on from what it lit to what the eye saw.
    let met = found.lit.iter().flat_map(|lit| found.seen.iter().map(|seen| lit.and(*seen)));
    let all: BTreeSet<Once> = found.whole.iter().copied().chain(met).filter_map(Crossed::once).collect();
    all.into_iter().collect()
}

#[derive(Default)]
struct Found {
    /// Paths between eye and lamp.
    whole: BTreeSet<Crossed>,
    /// What is crossed on the way from the eye to a scatterer.
    seen: BTreeSet<Crossed>,
    /// Pieces from a lamp to a scatterer.
    lit: BTreeSet<Crossed>,
}

/// Walks paths from the eye until they are absorbed or leave the scene.
fn look(world: &World, optics: &Optics<Mono>, found: &mut Found) {
    let [width, height] = world.eye.size().map(|n| n as f64);
    let mut ledger = Ledger::new(world.solids.len());
    for k in 0..RAYS {
        let mut rng = Rng::new(SEED, Stream::Pilot, 0, k);
        let [x, y] = rng.pair();
        let pupil = disk(rng.pair()) * world.eye.pupil_radius_m();
        let film = world.eye.film_of(0, 0, [x * width, y * height]);
        let (origin, (_, dir), ..) = world.eye.ray_of(film, DVec2::new(pupil.x, pupil.y));
        let ray = Ray { origin, dir, from: None };
        let mut walker = Walker::new((world, optics), Travel::FromEye, ray, 1.0, Interior::default(), rng);
        let mut crossed = Crossed::default();
        loop {
            let vertex = match walker.advance(&mut ledger) {
                Met::Sky => {
                    found.whole.insert(crossed);
                    break;
                }
                Met::Pupil(_) | Met::Ended => break,
                Met::Face(vertex) => vertex,
            };
            if let Some(lamp) = walker.lamp_at(&vertex) {
                let shown = lamp.shown().map_or(0, |(slide, _)| bit(slide));
                found.whole.insert(crossed.and(Crossed::from_lamp(shown)));
            }
            crossed.cross(slide_at(&walker, &vertex));
            match walker.meet(&vertex, &mut ledger) {
                Meeting::Ended => break,
                Meeting::Went => {}
                Meeting::Scatter(scatter, frame) => {
                    found.seen.insert(crossed);
                    if walker.scatter(&vertex, scatter, &frame, &mut ledger).is_none() {
                        break;
                    }
                }
            }
        }
    }
}

/// A path from a lamp.
#[derive(Default)]
struct FromLamp {
    crossed: Crossed,
    whole: Vec<Crossed>,
    lit: Vec<Crossed>,
}

impl FromLamp {
    fn so_far(&self, walker: &Walker<'_, Mono>, from: Origin) -> Crossed {
        let lamp = from.face.and_then(|(lamp, ..)| walker.world.lamps.all().get(lamp));
        let shown = lamp.and_then(|lamp| lamp.shown.as_ref()).map_or(0, |shown| bit(shown.slide));
        self.crossed.and(Crossed::from_lamp(shown))
    }
}

impl Visitor<Mono> for FromLamp {
    fn split_from(&self, _: &Walker<'_, Mono>) -> Option<f64> {
        None
    }

    fn pupil(&mut self, walker: &Walker<'_, Mono>, from: Origin, _: &Arrival) {
        self.whole.push(self.so_far(walker, from));
    }

    fn scatterer(&mut self, walker: &Walker<'_, Mono>, from: Origin, _: &Vertex, _: &Scatter) {
        self.lit.push(self.so_far(walker, from));
    }

    fn lands(&mut self, walker: &Walker<'_, Mono>, _: Origin, vertex: &Vertex) {
        self.crossed.cross(slide_at(walker, vertex));
    }
}
