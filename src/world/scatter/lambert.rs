//! The same luminance in every direction of each side.

use super::{Sampled, Shares};
use eyebox_base::warp;
use glam::DVec3;
use std::f64::consts::PI;

pub(super) fn eval(shares: Shares, d_out: DVec3) -> f64 {
    shares.side(d_out) / PI
}

pub(super) fn pdf(shares: Shares, d_out: DVec3) -> f64 {
    shares.side(d_out) / shares.total() * d_out.z.abs() / PI
}

pub(super) fn sample(shares: Shares, u: [f64; 3]) -> Option<Sampled> {
    let up = warp::cosine_hemisphere([u[1], u[2]]);
    let dir = if shares.reflects(u[0]) { up } else { -up };
    Some(Sampled { dir, weight: shares.total(), pdf: pdf(shares, dir) })
}
