//! A design as it will be made: parts moved and turned, radii, thicknesses, wedges and indices off by what tolerances allow, and
//! what that does to the virtual image. Definitions are in `docs/tolerance.md`.

mod apply;
mod draw;
pub mod figures;
pub mod parameter;
mod quadrature;
mod statistics;
pub mod table;
mod tuning;

pub use apply::apply;
pub use statistics::{Share, Statistics};

use eyebox_base::error::Result;
use eyebox_base::parallel;
use eyebox_base::{Error, Where};
use eyebox_scene::Scene;
use figures::{Figure, Nominal};
use parameter::Parameter;
use std::sync::atomic::{AtomicUsize, Ordering};
use tuning::tolerance::{FEWEST, MOST, MOST_NUMBERS};

/// What is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct ToleranceAsked {
    pub draws: usize,
    pub seed: u64,
    /// Columns and rows of points of the picture, at least 3 each.
    pub points: [usize; 2],
    /// Path of the part that is looked at.
    pub target: Option<String>,
    /// Interpupillary distance, m.
    pub ipd_m: f64,
}

/// What was found.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Tolerances {
    /// Path of the part that is looked at, and the parts between it and the eye.
    pub part: String,
    pub by: String,
    pub parameters: Vec<Parameter>,
    pub draws: usize,
    /// Draws that could not be traced, designs with one parameter off that could not, and why the first of them could not.
    pub failed: usize,
    pub failed_alone: usize,
    pub why: Option<String>,
    pub figures: Vec<Statistics>,
    /// Of all figures that were looked for.
    #[serde(skip)]
    pub names: Vec<Figure>,
    /// Per draw the parameters' values and the figures (as `names` has them), in their orders; empty where the draw failed.
    #[serde(skip)]
    pub samples: Vec<(Vec<f64>, Vec<f64>)>,
}

/// Draws designs. None if `stop` said true; `each` is told how many of how many designs are done.
///
/// A draw of a parameter hangs on the seed, the number of the draw and the parameter's name alone: other parameters, or
/// another design, leave it what it is, so that two designs are compared by the same draws.
/// Errors: numbers out of range; a nominal design that cannot be looked at.
pub fn tolerance(
    scene: &Scene,
    parameters: &[Parameter],
    asked: &ToleranceAsked,
    stop: &(dyn Fn() -> bool + Sync),
    each: &(dyn Fn(usize, usize) + Sync),
) -> Result<Option<Tolerances>> {
    let option = |text: &str| Where::Option(text.to_owned());
    if !(FEWEST..=MOST).contains(&asked.draws) {
        let fault = Error::new(option("--draws"), format!("{} draws", asked.draws));
        return Err(fault.expected(format!("{FEWEST} to {MOST}")));
    }
    if asked.draws.saturating_mul(parameters.len()) > MOST_NUMBERS {
        let fault = Error::new(option("--draws"), format!("{} draws of {} parameters", asked.draws, parameters.len()));
        return Err(fault.expected(format!("{MOST_NUMBERS} numbers in all")));
    }
    if asked.points.iter().any(|n| !(3..=63).contains(n) || n % 2 == 0) {
        let [columns, rows] = asked.points;
        return Err(Error::new(option("--points"), format!("{columns} × {rows} points of the picture"))
            .expected("odd numbers, 3 to 63: one point is in the middle"));
    }
    if !(asked.ipd_m > 0.0 && asked.ipd_m.is_finite()) {
        return Err(Error::new(option("--ipd"), format!("{} m between the eyes", asked.ipd_m)).expected("above 0"));
    }
    let mut scene = scene.clone();
    // Lines of sight ask for no light.
    scene.sky = None;
    let nominal = Nominal::new(&scene, asked.points, asked.target.as_deref(), asked.ipd_m)?;
    if let Some(own) = parameters.iter().find(|parameter| nominal.is_moved_within(parameter)) {
        return Err(Error::new(own.at.clone(), format!("{} is of the picture itself", own.name))
            .expected("`decenter_mm` and `tilt_arcmin` of the picture's part, which take the picture along"));
    }
    let alone = quadrature::nodes(parameters);
    let all = asked.draws + alone.len();
    let done = AtomicUsize::new(0);
    let look = |values: &[f64]| -> Option<Result<Vec<f64>>> {
        if stop() {
            return None;
        }
        let mut made = scene.clone();
        let found = apply(&mut made, parameters, values).and_then(|()| nominal.of(&made));
        each(done.fetch_add(1, Ordering::Relaxed) + 1, all);
        Some(found)
    };
    let draws: Vec<Vec<f64>> = (0..asked.draws).map(|draw| draw::draw(parameters, asked.seed, draw)).collect();
    let drawn: Option<Vec<_>> = parallel::map_all(&draws, &|values| look(values)).into_iter().collect();
    let single: Option<Vec<_>> =
        parallel::map_all(&alone, &|node| look(&node.values(parameters.len()))).into_iter().collect();
    let (Some(drawn), Some(single)) = (drawn, single) else { return Ok(None) };
    let why = drawn.iter().chain(&single).find_map(|found| found.as_ref().err()).map(ToString::to_string);
    let [failed, failed_alone] = [&drawn, &single].map(|all| all.iter().filter(|found| found.is_err()).count());
    let samples: Vec<(Vec<f64>, Vec<f64>)> =
        draws.into_iter().zip(drawn.into_iter().map(Result::unwrap_or_default)).collect();
    let single: Vec<Vec<f64>> = single.into_iter().map(Result::unwrap_or_default).collect();
    let figures = nominal.figures.iter().enumerate().filter_map(|(index, figure)| {
        let of = |values: &[f64]| values.get(index).copied().unwrap_or(f64::NAN);
        let seen: Vec<f64> = samples.iter().map(|(_, values)| of(values)).collect();
        let nodes: Vec<f64> = single.iter().map(|values| of(values)).collect();
        statistics::of(
            figure,
            of(&nominal.values),
            &seen,
            quadrature::shares(parameters, &alone, &nodes, of(&nominal.values)),
        )
    });
    Ok(Some(Tolerances {
        figures: figures.collect(),
        names: nominal.figures.clone(),
        part: nominal.part.clone(),
        by: nominal.by.clone(),
        parameters: parameters.to_vec(),
        draws: asked.draws,
        failed,
        failed_alone,
        why,
        samples,
    }))
}
