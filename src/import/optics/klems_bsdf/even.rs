//! A sample that scatters differently along and across, as one that scatters alike all round: finishes know no directions along
//! a face.

use super::basis::Basis;
use eyebox_scene::scatter_table::Measurement;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Steps of the azimuth from 0 to π: borders of patches are kept to half a degree.
const STEPS: usize = 360;
/// How far from the border of two rings each still has its own value, in widths of a ring.
const EDGE: f64 = 1e-3;

/// The mean over rotations of the sample and over both sides of the plane of incidence, constant in each ring, and how far
/// patches lie from it: the sum of their distances over the sum of all light.
pub(super) fn even(basis: &Basis, matrix: &[f64]) -> (Measurement, f64) {
    let rings = basis.rings.len();
    let azimuths: Vec<f64> = (0..=STEPS).map(|k| PI * k as f64 / STEPS as f64).collect();
    let (mut means, mut off, mut light) = (vec![0.0; rings * rings * azimuths.len()], 0.0, 0.0);
    for from in 0..rings {
        let count = basis.rings[from].1;
        for to in 0..rings {
            for (k, azimuth) in azimuths.iter().enumerate() {
                let of = |patch: usize, turn: f64| {
                    let own = TAU * patch as f64 / count as f64;
                    matrix[(basis.first(from) + patch) * basis.patches() + basis.at(to, own + turn)]
                };
                let all = (0..count).flat_map(|patch| [of(patch, *azimuth), of(patch, -azimuth)]);
                let mean = all.clone().sum::<f64>() / (2 * count) as f64;
                means[(from * rings + to) * azimuths.len() + k] = mean;
                let weight = basis.solid_angle(from) * basis.solid_angle(to) * (basis.rings[to].1 * count) as f64;
                off += weight * all.map(|value| (value - mean).abs()).sum::<f64>() / (2 * count) as f64;
                light += weight * mean;
            }
        }
    }
    // Each ring at both of its ends.
    let ends = |(ring, ([low, high], _)): (usize, &([f64; 2], usize))| {
        let edge = EDGE * (high - low);
        let low = if ring == 0 { 0.0 } else { low + edge };
        [low, if ring + 1 == rings { FRAC_PI_2 } else { high - edge }]
    };
    let theta: Vec<f64> = basis.rings.iter().enumerate().flat_map(ends).collect();
    let mut values = Vec::with_capacity(theta.len() * theta.len() * azimuths.len());
    for i in 0..theta.len() {
        for o in 0..theta.len() {
            let first = (i / 2 * rings + o / 2) * azimuths.len();
            values.extend_from_slice(&means[first..first + azimuths.len()]);
        }
    }
    (
        Measurement { theta_in: theta.clone(), theta_out: theta, phi: azimuths, values },
        if light > 0.0 { off / light } else { 0.0 },
    )
}
