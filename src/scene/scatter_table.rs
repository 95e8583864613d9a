//! Measured scattering: a table of the distribution over angles of incidence and of leaving.

use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt;

/// One side of a measurement: values at a grid of angles.
#[derive(Debug, Clone, PartialEq)]
pub struct Measurement {
    /// Rising, rad: of incidence, of leaving (to the normal of the side where it leaves), and of azimuth (0: onwards in the
    /// plane of incidence, π: back).
    pub theta_in: Vec<f64>,
    pub theta_out: Vec<f64>,
    pub phi: Vec<f64>,
    /// 1/sr, `[in][out][phi]`.
    pub values: Vec<f64>,
}

impl Measurement {
    /// Linear between the angles, constant beyond them; 0 if there is nothing.
    fn at(&self, theta_in: f64, theta_out: f64, phi: f64) -> f64 {
        let (i, o, p) = (place(&self.theta_in, theta_in), place(&self.theta_out, theta_out), place(&self.phi, phi));
        let (outs, phis) = (self.theta_out.len(), self.phi.len());
        let value = |i: usize, o: usize, p: usize| self.values.get((i * outs + o) * phis + p).copied().unwrap_or(0.0);
        mix(i, |i| mix(o, |o| mix(p, |p| value(i, o, p))))
    }
}

/// A face's measured scattering, isotropic, the same from both sides, and reciprocal: what was measured is averaged with
/// itself under exchanged directions.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ScatterTable {
    pub file: String,
    /// Angles to the normal from 0 to π/2 and azimuths from 0 to π, rad.
    theta: Vec<f64>,
    phi: Vec<f64>,
    /// 1/sr, `[in][out][phi]`: reflected and transmitted.
    values: [Vec<f64>; 2],
}

/// Why measurements make no table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Flaw {
    TooLarge {
        angles: usize,
        azimuths: usize,
    },
    /// `sum` of the light that arrives at `degrees` leaves.
    GainsEnergy {
        degrees: f64,
        sum: f64,
    },
}

impl fmt::Display for Flaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Flaw::TooLarge { angles, azimuths } => {
                write!(f, "{angles} angles to the normal and {azimuths} azimuths are too many")
            }
            Flaw::GainsEnergy { degrees, sum } => {
                write!(f, "of the light at {degrees:.2}° it scatters {sum:.6}: it gains energy")
            }
        }
    }
}

impl ScatterTable {
    /// The most values of one side.
    pub const MOST: usize = 1 << 21;

    /// The table that two measurements (reflected, transmitted) give. Errors: it would be too large, or more light leaves
    /// than arrives.
    pub fn new(file: &str, measured: &[Option<Measurement>; 2]) -> Result<ScatterTable, Flaw> {
        let both = || measured.iter().flatten();
        let theta = union(both().flat_map(|m| m.theta_in.iter().chain(&m.theta_out)), FRAC_PI_2);
        let phi = union(both().flat_map(|m| &m.phi), PI);
        let count = theta.len().saturating_mul(theta.len()).saturating_mul(phi.len());
        if count > Self::MOST {
            return Err(Flaw::TooLarge { angles: theta.len(), azimuths: phi.len() });
        }
        let fill = |m: &Option<Measurement>| {
            let Some(m) = m else { return Vec::new() };
            let mut values = Vec::with_capacity(count);
            for i in &theta {
                for o in &theta {
                    let row = phi.iter().map(|p| 0.5 * (m.at(*i, *o, *p) + m.at(*o, *i, *p)));
                    if *i > 0.0 && *o > 0.0 {
                        values.extend(row);
                    } else {
                        // Along the normal there is no azimuth.
                        let row: Vec<f64> = row.collect();
                        let cells = phi.windows(2).zip(row.windows(2));
                        let whole: f64 = cells.map(|(phi, f)| 0.5 * (f[0] + f[1]) * (phi[1] - phi[0])).sum();
                        values.extend(row.iter().map(|_| whole / PI));
                    }
                }
            }
            values
        };
        let values = [fill(&measured[0]), fill(&measured[1])];
        let table = ScatterTable { file: file.to_owned(), theta, phi, values };
        for pair in table.theta.windows(2) {
            for step in 0..=4 {
                let theta = pair[0] + (pair[1] - pair[0]) * f64::from(step) / 4.0;
                let [r, t] = table.shares(theta);
                // What the sums round.
                if r + t > 1.0 + 1e-6 {
                    return Err(Flaw::GainsEnergy { degrees: theta.to_degrees(), sum: r + t });
                }
            }
        }
        Ok(table)
    }

    /// The angles to the normal, rad.
    pub fn theta(&self) -> &[f64] {
        &self.theta
    }

    /// The azimuths, rad.
    pub fn phi(&self) -> &[f64] {
        &self.phi
    }

    /// The value at grid points; `side` 0 reflected, 1 transmitted.
    pub fn value(&self, side: usize, i: usize, o: usize, p: usize) -> f64 {
        self.values[side].get((i * self.theta.len() + o) * self.phi.len() + p).copied().unwrap_or(0.0)
    }

    /// 1/sr between the grid points, linear in all three angles.
    pub fn at(&self, side: usize, theta_in: f64, theta_out: f64, phi: f64) -> f64 {
        let (i, o, p) = (place(&self.theta, theta_in), place(&self.theta, theta_out), place(&self.phi, phi));
        mix(i, |i| mix(o, |o| mix(p, |p| self.value(side, i, o, p))))
    }

    /// Where an angle of incidence lies: a grid point, and how far on to the next.
    pub fn incidence(&self, theta: f64) -> (usize, f64) {
        place(&self.theta, theta)
    }

    /// Shares reflected and transmitted of light at `theta`: trapezoids over the azimuth (exact), three points of Gauss and
    /// Legendre in every 3° of the leaving angle.
    pub fn shares(&self, theta_in: f64) -> [f64; 2] {
        const POINTS: [(f64, f64); 3] =
            [(-0.774_596_669_241_483_4, 5.0 / 18.0), (0.0, 4.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 18.0)];
        let i = place(&self.theta, theta_in);
        [0, 1].map(|side| {
            if self.values[side].is_empty() {
                return 0.0;
            }
            let around = |o: (usize, f64)| -> f64 {
                let at = |p: usize| mix(i, |i| mix(o, |o| self.value(side, i, o, p)));
                let cells = self.phi.windows(2).enumerate();
                2.0 * cells.map(|(p, edge)| 0.5 * (at(p) + at(p + 1)) * (edge[1] - edge[0])).sum::<f64>()
            };
            let mut sum = 0.0;
            for (cell, edge) in self.theta.windows(2).enumerate() {
                let width = edge[1] - edge[0];
                let pieces = (width / 3f64.to_radians()).ceil().max(1.0);
                for piece in 0..pieces as usize {
                    for (x, weight) in POINTS {
                        let part = (piece as f64 + 0.5 + 0.5 * x) / pieces;
                        let (sin, cos) = (edge[0] + width * part).sin_cos();
                        sum += weight * width / pieces * sin * cos * around((cell, part));
                    }
                }
            }
            sum
        })
    }
}

/// All of the angles, with 0 and the end.
fn union<'a>(angles: impl Iterator<Item = &'a f64>, end: f64) -> Vec<f64> {
    let mut all: Vec<f64> = angles.copied().chain([0.0, end]).map(|angle| angle.clamp(0.0, end)).collect();
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

/// The grid point at or below `x`, and how far on to the next it lies.
pub fn place(grid: &[f64], x: f64) -> (usize, f64) {
    let above = grid.partition_point(|g| *g <= x);
    let below = above.saturating_sub(1);
    match (grid.get(below), grid.get(below + 1)) {
        (Some(a), Some(b)) if x > *a => (below, ((x - a) / (b - a)).min(1.0)),
        (Some(_) | None, _) => (below, 0.0),
    }
}

/// Between a grid point and the next.
pub fn mix((at, part): (usize, f64), value: impl Fn(usize) -> f64) -> f64 {
    if part == 0.0 { value(at) } else { (1.0 - part) * value(at) + part * value(at + 1) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn constant(value: f64, theta_in: &[f64]) -> Measurement {
        let theta_out = vec![0.0, 0.3, FRAC_PI_2];
        let count = theta_in.len() * theta_out.len();
        Measurement { theta_in: theta_in.to_vec(), theta_out, phi: vec![0.0], values: vec![value; count] }
    }

    #[test]
    fn constants_are_lambertian_and_gains_are_refused() {
        let halves = [Some(constant(0.5 / PI, &[0.0])), Some(constant(0.25 / PI, &[0.2, 0.9]))];
        let table = ScatterTable::new("x", &halves).unwrap();
        for theta in [0.0, 0.7, 1.5] {
            let [r, t] = table.shares(theta);
            assert!((r - 0.5).abs() < 1e-7 && (t - 0.25).abs() < 1e-7, "{r} {t}");
        }
        let too_much = ScatterTable::new("x", &[Some(constant(1.01 / PI, &[0.0])), None]);
        assert!(matches!(too_much, Err(Flaw::GainsEnergy { .. })));
    }

    /// Exchanged directions, off the grid.
    #[test]
    fn reciprocal() {
        let values = vec![0.0, 0.1, 0.02, 0.3, 0.0, 0.05, 0.06, 0.0];
        let m = Measurement { theta_in: vec![0.1, 1.0], theta_out: vec![0.0, 0.9], phi: vec![0.0, 2.0], values };
        let table = ScatterTable::new("x", &[Some(m), None]).unwrap();
        for (i, o, p) in [(0.0, 0.5, 0.1), (1.2, 0.3, 2.5), (0.95, 1.55, 1.0)] {
            assert!((table.at(0, i, o, p) - table.at(0, o, i, p)).abs() < 1e-15);
        }
    }
}
