//! What a curve of errors over seconds says: its slope, and the seconds to an error.

/// Seconds at which a curve reaches an error.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Reach {
    /// relMSE.
    pub level: f64,
    /// CPU seconds with the setup; none if the curve says nothing.
    pub seconds: Option<f64>,
    /// The curve ended before: the seconds are what is needed if the error falls as one over the time from its end on.
    pub extrapolated: bool,
}

/// Slope of log error over log time, by least squares over points (seconds, error) with positive error; none for fewer
/// than two. Independent samples give −1.
pub fn slope(points: &[[f64; 2]]) -> Option<f64> {
    let logs: Vec<[f64; 2]> = points.iter().filter(|p| usable(**p)).map(|p| p.map(f64::ln)).collect();
    let count = logs.len() as f64;
    let mean = |i: usize| logs.iter().map(|p| p[i]).sum::<f64>() / count;
    let (x, y) = (mean(0), mean(1));
    let sum = |of: &dyn Fn(&[f64; 2]) -> f64| logs.iter().map(of).sum::<f64>();
    let (xx, xy) = (sum(&|p| (p[0] - x).powi(2)), sum(&|p| (p[0] - x) * (p[1] - y)));
    (logs.len() >= 2 && xx > 0.0).then(|| xy / xx)
}

fn usable([seconds, error]: [f64; 2]) -> bool {
    seconds > 0.0 && error > 0.0 && seconds.is_finite() && error.is_finite()
}

/// When a curve of (seconds of tracing, error) falls to `level` for good: interpolated on the log–log curve after the
/// last point above it. `setup`: seconds before the first pass. An error that is not positive is below what the
/// references resolve, hence below any level.
pub fn reach(points: &[[f64; 2]], setup: f64, level: f64) -> Reach {
    let points: Vec<[f64; 2]> = points.iter().copied().filter(|[s, e]| *s > 0.0 && e.is_finite()).collect();
    let at = |seconds: f64, extrapolated: bool| Reach { level, seconds: Some(setup + seconds), extrapolated };
    let last_above = points.iter().rposition(|[_, error]| *error > level);
    match (last_above.and_then(|i| points.get(i)), last_above.map_or(points.first(), |i| points.get(i + 1))) {
        (Some([s0, e0]), Some([s1, e1])) if *e1 > 0.0 => {
            let share = (e0 / level).ln() / (e0 / e1).ln();
            at((s0.ln() + share * (s1 / s0).ln()).exp(), false)
        }
        // The next point is below anything that can be told: somewhere before it.
        (Some(_), Some([s1, _])) => at(*s1, false),
        (Some([s0, e0]), None) => at(s0 * e0 / level, true),
        // Already there at the first point.
        (None, Some([s0, _])) => at(*s0, false),
        (None, None) => Reach { level, seconds: None, extrapolated: false },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_law_is_read_off_exactly() {
        let law = |s: f64| [s, 3.0 * s.powf(-0.8)];
        let points: Vec<[f64; 2]> = [0.1, 0.3, 0.7, 2.0, 5.0].map(law).to_vec();
        assert!((slope(&points).unwrap() + 0.8).abs() < 1e-12);
        let level: f64 = 2.2;
        let want = (3.0 / level).powf(1.0 / 0.8);
        let got = reach(&points, 0.25, level);
        assert!((got.seconds.unwrap() - 0.25 - want).abs() < 1e-12 && !got.extrapolated, "{got:?}");
    }

    #[test]
    fn the_ends_of_a_curve() {
        let points = [[1.0, 0.1], [2.0, 0.05]];
        // Beyond the end with slope −1: 0.05·2/0.01 = 10 s.
        assert_eq!(reach(&points, 1.0, 0.01), Reach { level: 0.01, seconds: Some(11.0), extrapolated: true });
        // The first point is below already.
        assert_eq!(reach(&points, 1.0, 0.5).seconds, Some(2.0));
        // Below the references' noise.
        assert_eq!(reach(&[[1.0, 0.1], [2.0, -1e-9]], 0.0, 0.01).seconds, Some(2.0));
        // A curve that rises again is there only after it has come back.
        let back = reach(&[[1.0, 0.1], [2.0, 0.01], [4.0, 0.2], [8.0, 0.05]], 0.0, 0.1).seconds.unwrap();
        assert!((back - 4.0 * 2f64.powf(0.5)).abs() < 1e-12, "{back}");
        assert_eq!(reach(&[], 0.0, 0.1).seconds, None);
        assert_eq!(slope(&[[1.0, 0.1]]), None);
        assert_eq!(slope(&[[1.0, 0.1], [1.0, 0.2]]), None);
    }
}
