//! Which of two plans' trials is the better: the one with less variance × work, unless it misses light that the other has
//! found. Bias is no variance, so what is missed is out whatever it costs.

use super::Handicap;
use super::pilot_run::Trial;
pub(super) use super::tuning::verdict::FLOOR;
use super::tuning::verdict::SIGMAS;

/// What a comparison of two plans says.
#[derive(Debug)]
pub(super) struct Compared {
    /// The rival's variance × work over that of the other.
    pub ratio: f64,
    /// Whether it is enough for the rival.
    pub wins: bool,
    /// One of the two found this share of the light that the other found, surely less: it is out, whatever it costs.
    pub misses: Option<Misses>,
}

/// A trial that surely misses light that another has found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Misses {
    /// Whether it is the rival's.
    pub rival: bool,
    /// What it found of it.
    pub found: f64,
}

/// What trials of a plan and its rival tell; none where nothing was seen. `margin`: how much better the rival has to be.
pub(super) fn judge(of: [&Trial; 2], handicap: &Handicap, margin: f64) -> Option<Compared> {
    let [own, other] = costs(of, handicap)?;
    let misses = misses(of);
    let wins = misses.map_or(other * margin < own, |misses| !misses.rival);
    Some(Compared { ratio: other / own, wins, misses })
}

/// Whether one of two trials, of a plan and of its rival, surely misses light that the other has found: in the whole
/// picture, or in a quarter of it; or found nothing at all where the other found anything. What is missed has no variance, so no
/// variance × work may speak for it.
fn misses(trials: [&Trial; 2]) -> Option<Misses> {
    let [width, pixels] = [trials[0].width, trials[0].values.len()];
    let height = pixels / width.max(1);
    let whole = |_: usize| true;
    let quarter = |q: usize| {
        move |pixel: usize| {
            (2 * (pixel % width) >= width) == (q & 1 == 1) && (2 * (pixel / width) >= height) == (q & 2 == 2)
        }
    };
    let wholes = trials.map(|trial| trial.light(&whole));
    let less = |one: usize, within: &dyn Fn(usize) -> bool| {
        let [own, other] = [one, 1 - one].map(|k| trials[k].light(within));
        // By what light it comes in, in the whole picture: a part where nothing came in by chance states no error.
        let lump = if wholes[one].0 > 0.0 { wholes[one].1.powi(2) / wholes[one].0 } else { 0.0 };
        let error = own.1.max((lump * other.0.max(0.0)).sqrt());
        let nothing = wholes[one].0 == 0.0 && other.0 > 0.0;
        let surely = nothing || own.0 + SIGMAS * error < other.0 - SIGMAS * other.1;
        surely.then(|| Misses { rival: one == 1, found: own.0 / other.0 })
    };
    let of = |within: &dyn Fn(usize) -> bool| {
        let found = [less(0, within), less(1, within)];
        found.into_iter().flatten().next()
    };
    of(&whole).or_else(|| (0..4).find_map(|q| of(&quarter(q))))
}

/// Variance of a pass, relative to the picture, times its work, for each of two trials of the same scene; none where
/// nothing was seen.
///
/// What a trial has not found states no variance. So the picture of the one that knows more is held against the other's,
/// and their difference counts where it is larger than what is stated.
fn costs(trials: [&Trial; 2], handicap: &Handicap) -> Option<[f64; 2]> {
    let pixels = trials[0].values.len();
    let light = trials.map(|trial| trial.light(&|_| true));
    // One that surely misses light of the other's knows less; else the smoother one knows more.
    let knows = match misses(trials) {
        Some(misses) => usize::from(!misses.rival),
        None => usize::from(light[1].1 < light[0].1),
    };
    let mean = light[knows].0 / pixels.max(1) as f64;
    if !(mean > 0.0 && mean.is_finite()) {
        return None;
    }
    // A pixel that is dark by chance would weigh as much as a dark one.
    let smooth = smooth(&trials[knows].values, trials[knows].width);
    let plain = Handicap::default();
    let cost = |one: usize| {
        let (mut left, mut stated, mut differs) = (0.0, 0.0, 0.0);
        for (pixel, smooth) in smooth.iter().enumerate() {
            let reference = trials[knows].values[pixel];
            let scale = smooth.powi(2) + (FLOOR * mean).powi(2);
            left += trials[one].variance_left(pixel, handicap) / scale;
            stated += trials[one].variance(pixel, handicap) / scale;
            let of_reference = trials[knows].variance(pixel, &plain);
            differs += ((trials[one].values[pixel] - reference).powi(2) - of_reference) / scale;
        }
        // These few passes differ as they state; what evenness saves shows in a run.
        let relative = if one == knows { left } else { left + (differs - stated).max(0.0) };
        relative / pixels as f64 * trials[one].passes * trials[one].work(handicap)
    };
    Some([cost(0), cost(1)])
}

/// Means over each pixel and its neighbours.
pub(super) fn smooth(values: &[f64], width: usize) -> Vec<f64> {
    let height = values.len() / width.max(1);
    let around = |pixel: usize| {
        let (x, y) = (pixel % width, pixel / width);
        let rows = y.saturating_sub(1)..(y + 2).min(height);
        let columns = x.saturating_sub(1)..(x + 2).min(width);
        let count = rows.len() * columns.len();
        let sum: f64 = rows.flat_map(|j| columns.clone().map(move |i| values[j * width + i])).sum();
        sum / count as f64
    };
    (0..values.len()).map(around).collect()
}

#[cfg(test)]
mod tests {
    use super::super::pilot_run::Part;
    use super::*;
    use eyebox_film::plan::Estimator;

    const MARGIN: f64 = 1.25;

    /// A 12 × 4 picture of two passes: `value` of each pixel, with a relative standard error.
    fn trial(estimator: Estimator, value: &dyn Fn(usize) -> f64, relative: f64, work: f64) -> Trial {
        let values: Vec<f64> = (0..48).map(value).collect();
        let variances = values.iter().map(|value| (relative * value).powi(2)).collect();
        Trial::new(vec![Part { estimator, values, variances, left: 1.0, work, scattered: [0.0; 2] }], 48, 2.0, 12)
    }

    fn judged(own: &Trial, rival: &Trial) -> Compared {
        judge([own, rival], &Handicap::default(), MARGIN).expect("something was seen")
    }

    /// Cheap and sure of nothing is no bargain, on whichever side it stands.
    #[test]
    fn the_blind_is_out_whatever_it_costs() {
        let sees = trial(Estimator::Backward, &|_| 1000.0, 0.5, 1e6);
        let blind = trial(Estimator::Manifold, &|_| 0.0, 0.0, 1.0);
        let against = judged(&sees, &blind);
        assert!(!against.wins && against.ratio < 1e-3, "{against:?}");
        assert_eq!(against.misses, Some(Misses { rival: true, found: 0.0 }));
        let instead = judged(&blind, &sees);
        assert!(instead.wins && instead.misses == Some(Misses { rival: false, found: 0.0 }), "{instead:?}");
    }

    /// Light that only a corner of the picture lacks is missed, too, though the whole picture would not tell.
    #[test]
    fn a_quarter_that_is_dark_tells() {
        let sees = trial(Estimator::Backward, &|_| 1.0, 0.5, 1e3);
        let corner = |pixel: usize| pixel % 12 < 6 && pixel / 12 < 2;
        let lacks = trial(Estimator::Manifold, &|pixel| f64::from(u8::from(!corner(pixel))) * 1.25, 0.0, 1.0);
        let against = judged(&sees, &lacks);
        assert!(!against.wins && against.misses.is_some_and(|misses| misses.rival), "{against:?}");
    }

    /// Noise alone, of either, is no reason: the cheaper of two that may agree wins.
    #[test]
    fn noise_does_not_tell() {
        let sees = trial(Estimator::Backward, &|pixel| if pixel == 7 { 96.0 } else { 0.0 }, 1.0, 1e3);
        let smooth = trial(Estimator::Manifold, &|_| 1.0, 0.01, 1.0);
        let against = judged(&sees, &smooth);
        assert!(against.wins && against.misses.is_none(), "{against:?}");
        let blind = trial(Estimator::Forward, &|_| 0.0, 0.0, 1.0);
        assert!(!judged(&sees, &blind).wins && judged(&blind, &sees).wins);
    }
}
