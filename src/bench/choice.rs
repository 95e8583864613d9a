//! The automatic choice against every choice by hand, on scenes from seeds.

use super::clock::cpu_seconds;
use super::curve::error::{Error, References};
use super::curve::fit::reach;
use super::curve::race::{Budget, Ready, race};
use super::curve::reference::{Source, references};
use super::curve::{Curve, contenders};
use super::generate::{Family, scene_of};
use eyebox_base::Result;
use eyebox_base::stats::normal_tail;
use eyebox_estimate::ShouldStop;
use eyebox_film::plan::Estimator;
use eyebox_plan::Choice;

/// How much slower than the best choice by hand the automatic one may be.
pub const MOST_RATIO: f64 = 1.3;
/// Standard errors by which a picture may differ from the brute-force one, before the correction for many blocks.
pub const MOST_SIGMA: f64 = 3.0;

/// One choice by hand.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Single {
    pub estimator: &'static str,
    /// relMSE at the end.
    pub relmse: f64,
    /// CPU seconds to the automatic choice's last error, setup included; none: nothing to say.
    pub seconds: Option<f64>,
    /// The same without the setup.
    pub trace_seconds: Option<f64>,
}

/// What is more than [`MOST_SIGMA`] from brute force is asked again, with other random numbers and brute force for so many
/// times as long: in a hundred scenes some lie there by chance, more where light comes in few bright hits, whose errors are
/// not normal. A bias that is not small beside the picture's own noise does it again: brute force errs by half as much.
pub(super) const LONGER: f64 = 4.0;
/// What sets those random numbers apart (any bits would do).
pub(super) const AGAIN: u64 = 0x4167_6169_6e21_0000;

/// What came of one scene.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Row {
    pub seed: u64,
    pub family: Family,
    /// The estimators that the plan runs.
    pub runs: Vec<&'static str>,
    /// The automatic choice's relMSE at its end, which the others are to reach.
    pub level: f64,
    /// Its CPU seconds, setup included.
    pub seconds: f64,
    pub setup_seconds: f64,
    pub singles: Vec<Single>,
    pub best: &'static str,
    /// Seconds over the best choice's.
    pub ratio: f64,
    /// The same without setup on both sides.
    pub trace_ratio: f64,
    #[serde(flatten)]
    pub agreement: Agreement,
}

/// The automatic choice's last picture beside brute force.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Agreement {
    /// The block that differs most, in standard errors; and the limit.
    pub worst_sigma: f64,
    /// Blocks that were compared; none: brute force does not know the light of the whole to a tenth.
    pub blocks: Option<usize>,
    pub most_sigma: f64,
    pub energy: f64,
    pub energy_sigma: f64,
    /// All this is of a second time: in the first the picture was farther from brute force than the limit.
    pub again: bool,
}

impl Row {
    /// Fast enough.
    pub fn is_fast(&self) -> bool {
        self.ratio <= MOST_RATIO
    }
}

impl Agreement {
    /// What the last error of a curve says.
    fn new(auto: Option<&Curve>, references: &References, again: bool) -> Agreement {
        let error = auto.and_then(|auto| auto.points.last()).map(|point| point.error);
        let told = |of: fn(Error) -> f64| error.map_or(f64::NAN, of);
        Agreement {
            worst_sigma: told(|error| error.worst_sigma),
            blocks: references.known_blocks(),
            most_sigma: references.most_sigma_at(2.0 * normal_tail(MOST_SIGMA)),
            energy: told(|error| error.energy),
            energy_sigma: told(|error| error.energy_sigma),
            again,
        }
    }
    /// As bright as brute force, as far as that knows.
    pub fn holds(&self) -> bool {
        self.worst_sigma.abs() <= self.most_sigma || self.blocks.is_none()
    }
}

/// Lets all choices trace the scene of a seed in a family for `seconds` each; the references are from the eye, `factor` times as long
/// each. Where they don't know the light of every block to a tenth, they can't tell who is fast either: then the automatic
/// choice makes two more for that, and brute force says what it can of a bias. What is beyond the limit then is judged once
/// more by new brute force, four times as long, if that knows the picture's light at all.
///
/// Errors: those of checking and freezing.
pub fn judge(family: Family, seed: u64, seconds: f64, factor: f64, stop: &ShouldStop<'_>) -> Result<Row> {
    let start = cpu_seconds();
    let scene = scene_of(family, seed);
    let ready = Ready::new(&scene, cpu_seconds() - start)?;
    let trace = |choice: Choice, seed: u64, times: f64| -> Result<References> {
        let source = Source::Traced { choice, passes: None, seconds: times * factor * seconds };
        Ok(references(&ready, &source, seed, stop)?.0)
    };
    let brute = trace(Choice::Only(Estimator::Backward), seed, 1.0)?;
    let references = if brute.know_all() { brute } else { trace(Choice::Auto, seed, 1.0)?.with_bias_by(brute) };
    let budget = Budget { seconds, passes: None };
    let curves = race(&ready, &contenders(), &references, seed, budget, stop);
    let row = row((family, seed), &curves, &references);
    if row.agreement.holds() || stop() {
        return Ok(row);
    }
    let again = seed ^ AGAIN;
    let brute = trace(Choice::Only(Estimator::Backward), again, LONGER)?;
    if brute.known_blocks().is_none() {
        return Ok(row);
    }
    let references = references.with_bias_by(brute);
    let curves = race(&ready, &[Choice::Auto], &references, again, budget, stop);
    Ok(Row { agreement: Agreement::new(curves.first(), &references, true), ..row })
}

/// What the curves say; the first is the automatic choice's.
fn row((family, seed): (Family, u64), curves: &[Curve], references: &References) -> Row {
    let resolution = references.resolution();
    let auto = curves.first();
    let last = auto.and_then(|auto| auto.points.last());
    let level = last.map_or(f64::NAN, |point| point.error.relmse.max(resolution));
    let (setup, trace) = (auto.map_or(0.0, |auto| auto.setup_seconds), last.map_or(0.0, |point| point.seconds));
    // The automatic choice may have been below the resolution long before its end.
    let own = auto.map(|auto| pairs(auto, resolution));
    let trace = own.and_then(|pairs| reach(&pairs, 0.0, level).seconds).unwrap_or(trace);
    let singles: Vec<Single> = curves
        .iter()
        .skip(1)
        .map(|curve| Single {
            estimator: curve.estimator,
            relmse: curve.points.last().map_or(f64::NAN, |point| point.error.relmse),
            seconds: reach(&pairs(curve, resolution), curve.setup_seconds, level).seconds,
            trace_seconds: reach(&pairs(curve, resolution), 0.0, level).seconds,
        })
        .collect();
    let fastest = |of: &dyn Fn(&Single) -> Option<f64>| {
        singles.iter().filter_map(|single| Some((of(single)?, single.estimator))).min_by(|a, b| a.0.total_cmp(&b.0))
    };
    let (best_seconds, best) = fastest(&|single| single.seconds).unwrap_or((f64::NAN, "none"));
    let (best_trace, _) = fastest(&|single| single.trace_seconds).unwrap_or((f64::NAN, "none"));
    Row {
        seed,
        family,
        runs: auto.map_or_else(Vec::new, |auto| auto.runs.clone()),
        level,
        seconds: setup + trace,
        setup_seconds: setup,
        best,
        ratio: (setup + trace) / best_seconds,
        trace_ratio: trace / best_trace,
        agreement: Agreement::new(auto, references, false),
        singles,
    }
}

/// (seconds of tracing, error) with errors that cannot be told set to what can.
fn pairs(curve: &Curve, resolution: f64) -> Vec<[f64; 2]> {
    curve.points.iter().map(|point| [point.seconds, point.error.relmse.max(resolution)]).collect()
}

/// The head over the lines of the scenes.
pub fn head() -> String {
    format!(
        "{:>5} {:12} {:24} {:>9} {:>8} {:>8} {:10} {:>6} {:>6} {:>8} {:>9} {:>17}  seconds (relMSE at the end)",
        "seed",
        "family",
        "auto runs",
        "relMSE",
        "auto s",
        "setup s",
        "best",
        "ratio",
        "trace",
        "worst σ",
        "blocks",
        "energy"
    )
}

/// The line of a scene.
pub fn line(row: &Row) -> String {
    let singles: Vec<String> = row
        .singles
        .iter()
        .map(|s| {
            format!("{} {} ({:.1e})", s.estimator, s.seconds.map_or("–".to_owned(), |s| format!("{s:.2}")), s.relmse)
        })
        .collect();
    let mut verdict = String::new();
    if !row.is_fast() {
        verdict += "; slower than the best by hand";
    }
    let told = &row.agreement;
    if !told.holds() {
        verdict += &format!("; more than {:.1} σ from brute force", told.most_sigma);
    }
    if told.again {
        verdict += &format!("; told of brute force for {LONGER} times as long, as the first was beyond the limit");
    }
    let blocks = told.blocks.map_or("too rough".to_owned(), |blocks| blocks.to_string());
    format!(
        "{:>5} {:12} {:24} {:>9.2e} {:>8.2} {:>8.3} {:10} {:>6.2} {:>6.2} {:>+8.1} {blocks:>9} {:>8.4} ± {:.4}  {}{verdict}",
        row.seed,
        row.family.name(),
        row.runs.join(" + "),
        row.level,
        row.seconds,
        row.setup_seconds,
        row.best,
        row.ratio,
        row.trace_ratio,
        told.worst_sigma,
        told.energy,
        told.energy_sigma,
        singles.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::Point;
    use crate::curve::cells::Batches;
    use crate::curve::picture::Picture;

    /// An error of `factor`/s after `setup` seconds.
    fn curve(estimator: &'static str, factor: f64, setup_seconds: f64, worst_sigma: f64) -> Curve {
        let point = |k: i32| {
            let (seconds, passes) = (0.125 * 2f64.powi(k), 1 << k);
            let relmse = factor / seconds;
            let error =
                Error { relmse, trimmed: relmse, flat: None, edges: None, energy: 1.0, energy_sigma: 0.0, worst_sigma };
            Point { passes, seconds, paths: 1, error }
        };
        Curve {
            estimator,
            runs: vec![estimator],
            setup_seconds,
            points: (0..5).map(point).collect(),
            paths_per_second: 1.0,
            slope: None,
            reach: Vec::new(),
            reach_trimmed: Vec::new(),
            reach_flat: Vec::new(),
        }
    }

    fn exact() -> References {
        let picture = Picture {
            width: 32,
            height: 24,
            values: vec![1.0; 768],
            variances: vec![0.0; 768],
            batches: Batches::default(),
        };
        References::new(picture.clone(), picture)
    }

    /// After 2 s of tracing and 1 s of setup the automatic choice is at 0.01/2; the other needs a quarter of the time to
    /// that, and no setup.
    #[test]
    fn a_bad_choice_shows() {
        let curves =
            [curve("auto", 0.01, 1.0, 0.5), curve("forward", 0.1, 0.0, 0.0), curve("photon", 0.0025, 0.0, 0.0)];
        let row = row((Family::Direct, 0), &curves, &exact());
        assert_eq!((row.best, row.is_fast(), row.agreement.holds()), ("photon", false, true));
        assert!((row.ratio - 6.0).abs() < 1e-9 && (row.trace_ratio - 4.0).abs() < 1e-9, "{row:?}");
        assert!(line(&row).contains("slower"), "{}", line(&row));
    }

    #[test]
    fn a_good_choice_is_fast_and_a_wrong_picture_is_told() {
        let curves = [curve("auto", 0.01, 0.1, -9.0), curve("forward", 0.01, 0.1, 0.0), curve("photon", 1.0, 0.0, 0.0)];
        let row = row((Family::Direct, 0), &curves, &exact());
        assert_eq!((row.best, row.is_fast(), row.agreement.holds()), ("forward", true, false));
        assert!((row.ratio - 1.0).abs() < 1e-9 && line(&row).contains("σ from brute force"), "{row:?}");
        // 48 blocks at 3 σ in all.
        assert!((3.9..4.1).contains(&row.agreement.most_sigma), "{}", row.agreement.most_sigma);
    }
}
