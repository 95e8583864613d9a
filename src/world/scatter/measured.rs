//! A measured distribution, and sampling by its own cells.

use super::Sampled;
use crate::cdf::Cdf;
use eyebox_scene::ScatterTable;
use glam::{DVec2, DVec3};

/// The table with what its sampling needs.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    table: ScatterTable,
    /// Per angle of incidence: the cells (side, leaving angle, azimuth) by the light in them. None where all is absorbed.
    slices: Vec<Option<Cdf>>,
    /// Scattered share at `FINE` steps between the angles of incidence.
    albedo: Vec<f64>,
}

/// Steps of the albedo between two angles of incidence.
const FINE: usize = 4;

impl Measured {
    pub fn new(table: &ScatterTable) -> Self {
        let (theta, phi) = (table.theta(), table.phi());
        let slice = |i: usize| {
            let mut weights = Vec::with_capacity(2 * (theta.len() - 1) * (phi.len() - 1));
            for side in 0..2 {
                for (o, rings) in theta.windows(2).enumerate() {
                    for (p, sectors) in phi.windows(2).enumerate() {
                        let corners = [(o, p), (o + 1, p), (o, p + 1), (o + 1, p + 1)];
                        let sum: f64 = corners.iter().map(|&(o, p)| table.value(side, i, o, p)).sum();
                        weights.push(sum * area(rings, sectors));
                    }
                }
            }
            Cdf::new(weights)
        };
        let incidence = |k: usize| {
            let (i, part) = (k / FINE, (k % FINE) as f64 / FINE as f64);
            let next = theta.get(i + 1).unwrap_or(&theta[i]);
            theta[i] + part * (next - theta[i])
        };
        Measured {
            slices: (0..theta.len()).map(slice).collect(),
            albedo: (0..=(theta.len() - 1) * FINE).map(|k| table.shares(incidence(k)).iter().sum()).collect(),
            table: table.clone(),
        }
    }

    pub(super) fn eval(&self, d_in: DVec3, d_out: DVec3) -> f64 {
        let (theta_out, phi) = angles(d_in, d_out);
        self.table.at(usize::from(d_out.z < 0.0), polar(d_in), theta_out, phi)
    }

    pub(super) fn pdf(&self, d_in: DVec3, d_out: DVec3) -> f64 {
        let (theta_out, phi) = angles(d_in, d_out);
        let (rings, sectors) = (self.table.theta().len() - 1, self.table.phi().len() - 1);
        let find = |grid: &[f64], x: f64| grid.partition_point(|g| *g <= x).clamp(1, grid.len() - 1) - 1;
        let (o, p) = (find(self.table.theta(), theta_out), find(self.table.phi(), phi));
        let cell = (usize::from(d_out.z < 0.0) * rings + o) * sectors + p;
        let (i, part) = self.table.incidence(polar(d_in));
        let of = |i: usize| self.slices.get(i).and_then(Option::as_ref).map_or(0.0, |slice| slice.probability(cell));
        let probability = (1.0 - part) * of(i) + if part > 0.0 { part * of(i + 1) } else { 0.0 };
        probability / area(&self.table.theta()[o..o + 2], &self.table.phi()[p..p + 2]) * d_out.z.abs()
    }

    pub(super) fn sample(&self, d_in: DVec3, u: [f64; 3]) -> Option<Sampled> {
        let (i, part) = self.table.incidence(polar(d_in));
        let (slice, rest) = if u[0] < part { (i + 1, u[0] / part) } else { (i, (u[0] - part) / (1.0 - part)) };
        let (cell, _) = self.slices.get(slice)?.as_ref()?.sample(rest);
        let (rings, sectors) = (self.table.theta().len() - 1, self.table.phi().len() - 1);
        let (side, o, p) = (cell / (rings * sectors), cell / sectors % rings, cell % sectors);
        let (ring, sector) = (&self.table.theta()[o..o + 2], &self.table.phi()[p..p + 2]);
        // Even in the projection: sin² is.
        let [low, high] = [ring[0], ring[1]].map(|theta| theta.sin() * theta.sin());
        let sin = (low + u[1] * (high - low)).sqrt();
        // Either way round from the plane of incidence.
        let (turn, sign) = if u[2] < 0.5 { (2.0 * u[2], 1.0) } else { (2.0 * u[2] - 1.0, -1.0) };
        let (y, x) = (sector[0] + turn * (sector[1] - sector[0])).sin_cos();
        let onwards = onwards(d_in);
        let across = DVec2::new(-onwards.y, onwards.x) * sign;
        let flat = (onwards * x + across * y) * sin;
        let up = ((1.0 - sin) * (1.0 + sin)).max(0.0).sqrt();
        let dir = DVec3::new(flat.x, flat.y, if side == 0 { up } else { -up });
        let pdf = self.pdf(d_in, dir);
        Some(Sampled { dir, weight: self.eval(d_in, dir) * up / pdf, pdf })
    }

    pub(super) fn albedo(&self, cos_in: f64) -> f64 {
        let (i, part) = self.table.incidence(cos_in.clamp(0.0, 1.0).acos());
        let place = (i as f64 + part) * FINE as f64;
        let below = (place as usize).min(self.albedo.len() - 2);
        self.albedo[below] + (place - below as f64) * (self.albedo[below + 1] - self.albedo[below])
    }
}

/// Projected solid angle of a cell, on both sides of the plane of incidence.
fn area(ring: &[f64], sector: &[f64]) -> f64 {
    // sin² b − sin² a
    (ring[1] - ring[0]).sin() * (ring[1] + ring[0]).sin() * (sector[1] - sector[0])
}

/// Angle to the normal.
fn polar(d: DVec3) -> f64 {
    DVec2::new(d.x, d.y).length().atan2(d.z.abs())
}

/// Direction in the face of the plane of incidence; where light falls straight on the table knows none.
fn onwards(d_in: DVec3) -> DVec2 {
    DVec2::new(d_in.x, d_in.y).try_normalize().unwrap_or(DVec2::X)
}

/// Of a leaving direction: to the normal, and from the plane of incidence.
fn angles(d_in: DVec3, d_out: DVec3) -> (f64, f64) {
    let (a, b) = (onwards(d_in), DVec2::new(d_out.x, d_out.y));
    (polar(d_out), a.perp_dot(b).abs().atan2(a.dot(b)))
}
