//! Is there a bias: the automatic choice's pictures of many generated scenes against plain sampling.
//!
//! One picture can be held against another to a few standard errors. A bias that is smaller shows in many: the deviates of all
//! blocks of all scenes are those of a normal distribution, or they are not.

use super::choice::{AGAIN, LONGER, MOST_SIGMA};
use super::clock::cpu_seconds;
use super::curve::bias::Blocks;
use super::curve::cells::Batches;
use super::curve::picture::Picture;
use super::curve::race::Ready;
use super::generate::{Family, scene_of};
use eyebox_base::Result;
use eyebox_base::stats::{chi_square_z, normal_tail, sidak_z};
use eyebox_estimate::ShouldStop;
use eyebox_estimate::run::begin;
use eyebox_film::plan::{Estimator, Plan};
use eyebox_film::unseen::Doubts;
use eyebox_plan::{Choice, plan};

/// Plain sampling takes so many times as long, each of its two pictures.
const PLAIN: f64 = 4.0;
/// Passes of a picture at least: what fewer batches say of their variance is a guess.
const LEAST_PASSES: u64 = 8;
/// What sets the seeds of the plain pictures apart from the automatic choice's (any bits would do).
const APART: [u64; 2] = [0x506c_6169_6e2e_2e31, 0x9b3f_c0de_7a51_e432];
/// By each of the measures sets of scenes that are sound are found at fault as often as this.
const FALSE_ALARM: f64 = 0.01;

/// One scene.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Row {
    pub seed: u64,
    pub family: Family,
    /// The estimators that the plan runs.
    pub runs: Vec<&'static str>,
    /// Of the automatic choice, and of plain sampling twice.
    pub passes: [u64; 3],
    /// Deviates of the blocks whose light plain sampling knows, row by row; empty: it does not even know that of the whole.
    pub blocks: Vec<f64>,
    /// That of the whole picture's light, and its light over that of plain sampling.
    pub energy: f64,
    pub ratio: f64,
    /// What the run's own witness says is off.
    pub witness: Vec<String>,
    /// The block that is farthest off when it is asked again, with other random numbers and plain sampling for longer, if it was
    /// beyond the limit of its picture.
    pub again: Option<f64>,
}

/// What all of them say together.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Summary {
    pub scenes: usize,
    /// Those whose light plain sampling does not know.
    pub too_rough: usize,
    pub blocks: Tally,
    pub energies: Tally,
    /// Scenes whose own witness says that light is off.
    pub witnesses: usize,
}

/// Deviates, against those of a normal distribution.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Tally {
    pub count: usize,
    /// Σz² over the number, and how far that is from 1 as a normal deviate.
    pub mean_square: f64,
    pub chi_square_z: f64,
    /// Σz over the root of the number: a normal deviate, far from 0 if all are too bright or too dark.
    pub mean_z: f64,
    /// Share of them beyond 3, which of normal ones is 0.0027.
    pub beyond_3: f64,
    pub largest: f64,
    /// What the largest may be.
    pub limit: f64,
}

impl Tally {
    fn new(deviates: &[f64]) -> Tally {
        let (count, sum) = (deviates.len(), deviates.iter().sum::<f64>());
        let squares: f64 = deviates.iter().map(|z| z * z).sum();
        let number = count.max(1) as f64;
        // One that is no number is off by any measure.
        let larger = |most: f64, z: &f64| if z.is_nan() || z.abs() > most.abs() { *z } else { most };
        Tally {
            count,
            mean_square: squares / number,
            chi_square_z: chi_square_z(squares, number),
            mean_z: sum / number.sqrt(),
            beyond_3: deviates.iter().filter(|z| z.abs().is_nan() || z.abs() > MOST_SIGMA).count() as f64 / number,
            largest: deviates.iter().fold(0.0, larger),
            limit: sidak_z(FALSE_ALARM, count),
        }
    }

    fn holds(&self) -> bool {
        self.largest.abs() <= self.limit
    }
}

impl Row {
    /// What the block that is farthest off may be off by, in this scene alone.
    fn limit(&self) -> f64 {
        sidak_z(2.0 * normal_tail(MOST_SIGMA), self.blocks.len())
    }
}

impl Summary {
    pub fn new(rows: &[Row]) -> Summary {
        let known = || rows.iter().filter(|row| !row.blocks.is_empty());
        let blocks: Vec<f64> = known().flat_map(|row| row.blocks.iter().copied()).collect();
        let energies: Vec<f64> = known().map(|row| row.energy).collect();
        Summary {
            scenes: rows.len(),
            too_rough: rows.len() - energies.len(),
            blocks: Tally::new(&blocks),
            energies: Tally::new(&energies),
            witnesses: rows.iter().filter(|row| !row.witness.is_empty()).count(),
        }
    }

    /// Plain sampling knows some picture, no block and no picture is farther off than the limit, the pictures' energies scatter no
    /// more than normal deviates do and about 0, and no witness objects. Blocks of one picture share light, so their own Σz² is told, and no verdict.
    pub fn holds(&self) -> bool {
        let most = sidak_z(FALSE_ALARM, 1);
        let spread = self.energies.chi_square_z <= most && self.energies.mean_z.abs() <= most;
        self.energies.count > 0 && self.blocks.holds() && self.energies.holds() && spread && self.witnesses == 0
    }
}

/// The plan of plain sampling: paths from the eye, without what pilots have learned.
fn plain(plan: Plan) -> Plan {
    Plan {
        pupil_guide: None,
        sky_guide: None,
        glints: Vec::new(),
        doubts: Doubts::default(),
        backward_share: 1.0,
        unknown_share: 1.0,
        vision_share: 1.0,
        faintest_branch: 1.0,
        ..plan
    }
}

/// A picture of a scene after so many CPU seconds, the number of its passes, and what its witness finds off.
fn traced(
    ready: &Ready<'_>,
    plan: &Plan,
    (seed, seconds, watched): (u64, f64, bool),
    stop: &ShouldStop<'_>,
) -> (Picture, u64, Vec<String>) {
    let (size, groups) = (ready.scene().eye.resolution, &ready.scene().groups);
    let mut tracing = begin(&ready.world, plan, groups.len(), size, seed);
    let start = cpu_seconds();
    if watched {
        tracing.watch(None);
    }
    let mut batches = Batches::default();
    while !tracing.films().films.is_empty() {
        tracing.step(1);
        if tracing.films().passes == batches.next() {
            Picture::of_batches(tracing.films(), size, &mut batches);
        }
        if tracing.films().passes >= LEAST_PASSES && cpu_seconds() - start >= seconds || stop() {
            break;
        }
    }
    let films = tracing.films();
    let name = |group: eyebox_base::ids::GroupId| groups[group.index()].name.clone();
    let off = films.judgement().map(|judgement| judgement.warnings(&name)).unwrap_or_default();
    (Picture::of_batches(films, size, &mut batches), films.passes, off)
}

/// Holds the automatic choice's picture of a seed's scene, `seconds` long, against plain sampling.
///
/// Errors: those of checking and freezing.
pub fn agreement(family: Family, seed: u64, seconds: f64, stop: &ShouldStop<'_>) -> Result<Row> {
    let scene = scene_of(family, seed);
    let auto = Ready::new(&scene, 0.0)?;
    let mut bare = Ready::new(&scene, 0.0)?;
    bare.world.plain = true;
    let plan_auto = plan(&auto.checked, &auto.world, Choice::Auto);
    let plan_plain = plain(plan(&bare.checked, &bare.world, Choice::Only(Estimator::Backward)));
    let compare = |seed: u64, times: f64| {
        let (picture, passes, witness) = traced(&auto, &plan_auto, (seed, seconds, true), stop);
        let [first, second] =
            APART.map(|apart| traced(&bare, &plan_plain, (seed ^ apart, times * PLAIN * seconds, false), stop));
        let blocks = Blocks::new([&first.0, &second.0]);
        let deviates = if blocks.known().is_some() { blocks.deviates(&picture) } else { Vec::new() };
        let sum = |picture: &Picture| picture.values.iter().sum::<f64>();
        let ratio = sum(&picture) / (0.5 * (sum(&first.0) + sum(&second.0)));
        Row {
            seed: 0,
            family,
            runs: Estimator::ALL.into_iter().filter(|e| plan_auto.runs(*e)).map(Estimator::name).collect(),
            passes: [passes, first.1, second.1],
            energy: blocks.whole(&picture),
            blocks: deviates,
            ratio,
            witness,
            again: None,
        }
    };
    let row = Row { seed, ..compare(seed, 1.0) };
    let worst = |row: &Row| Tally::new(&row.blocks).largest;
    if worst(&row).abs() <= row.limit() || row.blocks.is_empty() || stop() {
        return Ok(row);
    }
    let second = compare(seed ^ AGAIN, LONGER);
    Ok(Row { again: Some(worst(&second)), ..row })
}

/// The head over the lines of the scenes.
pub fn head() -> String {
    format!(
        "{:>5} {:12} {:24} {:>22} {:>6} {:>8} {:>7} {:>8} {:>9}",
        "seed", "family", "auto runs", "passes: auto, plain", "blocks", "worst z", "mean z²", "energy z", "ratio"
    )
}

/// The line of a scene.
pub fn line(row: &Row) -> String {
    let tally = Tally::new(&row.blocks);
    let [auto, first, second] = row.passes;
    let [blocks, worst, square] = match row.blocks.as_slice() {
        [] => ["rough", "–", "–"].map(str::to_owned),
        [_, ..] => [tally.count.to_string(), format!("{:+.2}", tally.largest), format!("{:.2}", tally.mean_square)],
    };
    let mut text = format!(
        "{:>5} {:12} {:24} {:>22} {blocks:>6} {worst:>8} {square:>7} {:>+8.2} {:>9.5}",
        row.seed,
        row.family.name(),
        row.runs.join(" + "),
        format!("{auto}, {first} + {second}"),
        row.energy,
        row.ratio,
    );
    if let Some(again) = row.again {
        text += &format!("; asked again with plain sampling for {LONGER} times as long: {again:+.2}");
    }
    row.witness.iter().for_each(|off| text += &format!("; {off}"));
    text
}

/// What all scenes say together, for people.
pub fn summary(summary: &Summary) -> String {
    let line = |what: &str, tally: &Tally| {
        let Tally { count, mean_square, chi_square_z, mean_z, beyond_3, largest, limit } = tally;
        format!(
            "{what}: {count} deviates, mean z² {mean_square:.3} ({chi_square_z:+.1} σ), mean {mean_z:+.2} σ, {:.2} % beyond 3 \
             (normal: 0.27 %), largest {largest:+.2} (limit {limit:.2})",
            100.0 * beyond_3
        )
    };
    let Summary { scenes, too_rough, blocks, energies, witnesses } = summary;
    let verdict = if summary.holds() { "no bias is seen" } else { "a bias, or errors that are stated too small" };
    format!(
        "{scenes} scenes, of {too_rough} plain sampling does not know the light to a tenth; {witnesses} witnesses object\n{}\n{}\n{verdict}",
        line("blocks", blocks),
        line("energies", energies)
    )
}

#[cfg(test)]
#[path = "agreement_tests.rs"]
mod tests;
