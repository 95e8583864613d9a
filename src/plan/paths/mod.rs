//! The path table: by which sequences of parts light gets from the lamps to the eye, how much of it, and where in the
//! picture it arrives.

mod chain_sampling;
mod discover;
mod eye_paths;
mod lamp_paths;
mod layer;
mod learn;
mod part_sequence;
pub mod rays;
mod row;
mod scattered;
mod start_side;
mod tally;
mod text;
mod tuning;

pub use lamp_paths::{Source, Way};
pub use layer::{Wanted, header, layer_name, pictures, wanted};
pub use part_sequence::{How, Visit, Visits, part_name};
pub use row::{Kind, Row};
pub use tally::Footprint;
use tuning::paths::{DEEPER, MOST_ROWS, PASSES, PHOTONS};

use crate::{Polarisation, mode};
use chain_sampling::Directed;
use eye_paths::EyePaths;
use eyebox_base::ids::GroupId;
use eyebox_base::parallel;
use eyebox_check::Checked;
use eyebox_estimate::ShouldStop;
use eyebox_estimate::emission::{Shots, Starts};
use eyebox_film::plan::PathMode;
use eyebox_scene::Scene;
use eyebox_world::World;
use eyebox_world::geometry::Site;
use eyebox_world::mode::{Mode, Mono};
use eyebox_world::stokes::Stokes;
use glam::DVec3;
use lamp_paths::{Caught, STREAM, Split};
use scattered::Deposits;
use start_side::{Lamps, Sides};
use std::collections::BTreeMap;
use std::sync::Mutex;
use tally::Tally;

/// What is asked of the table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Asked {
    /// Rows with less of all light than this are left out.
    pub least: f64,
    /// Paths from the lamps; as many from the eye where these are needed.
    pub paths: u64,
    pub polarisation: Polarisation,
}

impl Asked {
    pub const LEAST: f64 = 1e-6;
    pub const PATHS: u64 = 1 << 12;
}

impl Default for Asked {
    fn default() -> Self {
        Asked { least: Self::LEAST, paths: Self::PATHS, polarisation: Polarisation::Auto }
    }
}

impl Asked {
    /// Paths of a pass along a chain.
    fn paths_along(&self, chain: &Directed) -> u64 {
        let scale = self.paths as f64 / Self::PATHS as f64;
        ((chain.paths() * scale / PASSES as f64) as u64).max(4)
    }
}

/// The rows, most light first, and how they were found.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Table {
    pub rows: Vec<Row>,
    /// All light that was found, rows that are left out included, lm into the pupil within the field of view.
    pub flux_lm: f64,
    /// Rows that are left out, and their share of all light.
    pub left_out: (usize, f64),
    /// Paths that were traced from the lamps and from the eye.
    pub paths: [u64; 2],
    /// Chains of faces that had paths of their own, and these paths.
    pub chains: usize,
    pub paths_along: u64,
    /// Degrees right of and above the middle: half the picture's width and height.
    pub half_field_degrees: [f64; 2],
    pub pinhole: bool,
    pub mode: PathMode,
    pub notes: Vec<String>,
}

/// Pilots have a seed of their own: the table is a function of the scene alone.
const SEED: u64 = 0x7ab1e;

type Rows = BTreeMap<(GroupId, Way), Tally>;

/// Makes the table; none if `stop` says true before it is done.
pub fn table(checked: &Checked, world: &World, asked: Asked, stop: &ShouldStop<'_>) -> Option<Table> {
    let scene = checked.scene();
    let mode = mode::decide(checked, world, asked.polarisation, stop);
    let per_pass = asked.paths.div_ceil(PASSES).max(1);
    let split = Split { least: asked.least * DEEPER };
    let sides = Sides::new(checked, world, &mode, (split, asked.least), stop);
    let pinhole = checked.facts().pinhole;
    let mut found = Rows::new();
    let directed: Vec<(&Directed, u64)> =
        sides.directed.chains.iter().map(|chain| (chain, asked.paths_along(chain))).collect();
    let runs = Runs { passes: PASSES, per_pass, split, directed: &directed };
    find(world, &sides, &mode, runs, stop, &mut |pass, caught, even| add(&mut found, pass, caught, (pinhole, even)));
    if stop() {
        return None;
    }
    let ranking = row::Ranking { scene, world, passes: PASSES, per_pass, from_eye: &sides.from_eye, pinhole };
    let ranked = ranking.rank(found, asked.least);
    let total = PASSES * per_pass;
    Some(Table {
        rows: ranked.rows,
        flux_lm: ranked.flux_lm,
        left_out: ranked.left_out,
        paths: [sides.starts() * total, if sides.looks() { total } else { 0 }],
        paths_along: directed.iter().map(|(_, paths)| PASSES * paths).sum(),
        chains: directed.len(),
        half_field_degrees: scene.eye.half_tangents().map(|tangent| tangent.atan().to_degrees()),
        pinhole,
        mode,
        notes: sides.notes,
    })
}

/// How much is traced.
#[derive(Clone, Copy)]
struct Runs<'r> {
    passes: u64,
    per_pass: u64,
    split: Split,
    /// Chains with paths of their own, and how many a pass has.
    directed: &'r [(&'r Directed, u64)],
}

/// Takes what the paths of a pass caught, path by path, and whether they had even points.
type Sink<'s> = dyn FnMut(u64, Vec<Vec<Caught>>, bool) + 's;

fn find(world: &World, sides: &Sides, mode: &PathMode, runs: Runs<'_>, stop: &ShouldStop<'_>, sink: &mut Sink<'_>) {
    let find = if mode.polarised { find_in::<Mono<Stokes>> } else { find_in::<Mono<f64>> };
    find(world, sides, runs, stop, sink);
}

fn find_in<M: Mode>(world: &World, sides: &Sides, runs: Runs<'_>, stop: &ShouldStop<'_>, sink: &mut Sink<'_>) {
    let Runs { passes, per_pass, split, directed } = runs;
    for pass in 0..passes {
        if stop() {
            return;
        }
        let optics = M::optics(world, SEED, pass);
        // One stream of random numbers: four rows of passes, one for each purpose.
        let shots = |purpose: u64, paths: u64| Shots {
            seed: SEED,
            stream: STREAM,
            pass: 4 * pass + purpose,
            paths,
            starts: Starts::OfPass,
        };
        let of_chain = |index: usize| {
            let (chain, paths) = &directed[index];
            // Each chain has numbers of its own.
            let seed = SEED.wrapping_add(1 + index as u64);
            let shots = Shots { seed, stream: STREAM, pass, paths: *paths, starts: Starts::OfPass };
            chain.run((world, &optics), shots, stop)
        };
        let along: Vec<Vec<Vec<Caught>>> = parallel::map(directed.len(), &of_chain);
        along.into_iter().for_each(|caught| sink(pass, caught, true));
        if let Some(Lamps { emission, sources }) = &sides.lamps {
            let from = (emission, sources.as_slice());
            let shots = (shots(0, per_pass), split);
            sink(pass, lamp_paths::from_lamps((world, &optics), from, &sides.directed, shots, stop), false);
        }
        if !sides.looks() {
            continue;
        }
        let vision = |group: GroupId| sides.from_eye.get(group.index()) == Some(&true);
        let mut looking = EyePaths {
            world,
            optics: &optics,
            split,
            vision: &vision,
            owned: &sides.directed,
            traces: false,
            scattered: None,
        };
        match &sides.photons {
            None => sink(pass, looking.run(shots(1, per_pass), stop), false),
            Some(Lamps { emission, sources }) => {
                let ends = ends(&looking, shots(2, 64), stop);
                let from = (emission, sources.as_slice());
                let photons = shots(3, per_pass.saturating_mul(PHOTONS));
                let deposits = Deposits::new((world, &optics), from, photons, &ends, stop);
                let gather = |end: &eye_paths::End<'_, '_, M>, each: &mut dyn FnMut(GroupId, Source, Way, f64)| {
                    deposits.gather(end, each);
                };
                looking.scattered = Some(&gather);
                sink(pass, looking.run(shots(1, per_pass), stop), false);
            }
        }
    }
}

/// Where paths from the eye meet scatterers.
fn ends<M: Mode>(looking: &EyePaths<'_, '_, M>, shots: Shots, stop: &ShouldStop<'_>) -> Vec<(DVec3, Site)> {
    let found = Mutex::new(Vec::new());
    let note = |end: &eye_paths::End<'_, '_, M>, _: &mut dyn FnMut(GroupId, Source, Way, f64)| {
        let hit = &end.vertex.hit;
        if let Ok(mut found) = found.lock() {
            found.push((hit.point, hit.site));
        }
    };
    let nothing = |_: GroupId| false;
    let first = EyePaths {
        world: looking.world,
        optics: looking.optics,
        split: Split { least: 0.1 },
        vision: &nothing,
        owned: looking.owned,
        traces: false,
        scattered: Some(&note),
    };
    first.run(shots, stop);
    let mut found = found.into_inner().unwrap_or_default();
    // In an order of their own: threads must not decide.
    found.sort_by(|(a, _): &(DVec3, Site), (b, _)| {
        a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z))
    });
    found
}

/// Adds what the paths of a pass found: by luminance where no lumen gets in.
fn add(rows: &mut Rows, pass: u64, found: Vec<Vec<Caught>>, (pinhole, even): (bool, bool)) {
    for path in found {
        // A path arrives once in a pixel, by however many branches or lamps.
        let mut sums: BTreeMap<(GroupId, Way), (f64, BTreeMap<u32, f64>)> = BTreeMap::new();
        for caught in path {
            let mut key = (caught.group, caught.way);
            if rows.len() >= MOST_ROWS && !rows.contains_key(&key) {
                key.1 = Way::Vision(Visits { all: Vec::new(), cut: true });
            }
            rows.entry(key.clone()).or_default().sources.insert(caught.source);
            let (amount, pixels) = sums.entry(key).or_default();
            *amount += if pinhole { caught.luminance } else { caught.lumens };
            *pixels.entry(caught.pixel).or_default() += caught.luminance;
        }
        for (key, (amount, pixels)) in sums {
            if let Some(tally) = rows.get_mut(&key) {
                tally.path(pass, amount, even);
                pixels.into_iter().for_each(|(pixel, luminance)| tally.arrive(pixel, luminance));
            }
        }
    }
}

/// What names each source in the scene.
pub fn source_name(scene: &Scene, world: &World, source: Source) -> String {
    match source {
        Source::Face(index) => world
            .lamps
            .get(index)
            .map_or_else(String::new, |lamp| part_name(scene, u32::try_from(lamp.part).unwrap_or(u32::MAX))),
        Source::Light(index) => match world.lights.all().get(index) {
            Some(light) => scene.groups.get(light.group().index()).map_or_else(String::new, |g| g.name.clone()),
            None => String::new(),
        },
        Source::Sky => "sky".to_owned(),
    }
}
