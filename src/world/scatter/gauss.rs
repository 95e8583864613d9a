//! Lobes about the specular directions: `share · lobe(t)/max(cos_i, cos_o)`, t the angle to the mirrored direction for
//! reflection, to the straight one for transmission. With the larger cosine below, no direction of incidence gains
//! energy.

use super::{Sampled, Shares, mirrored};
use crate::gauss::GaussLobe;
use glam::DVec3;

fn axis(d_in: DVec3, d_out: DVec3) -> DVec3 {
    if d_out.z > 0.0 { mirrored(d_in) } else { d_in }
}

pub(super) fn eval(lobe: &GaussLobe, shares: Shares, d_in: DVec3, d_out: DVec3) -> f64 {
    shares.side(d_out) * lobe.value(axis(d_in, d_out), d_out) / (-d_in.z).max(d_out.z.abs())
}

pub(super) fn pdf(lobe: &GaussLobe, shares: Shares, d_in: DVec3, d_out: DVec3) -> f64 {
    shares.side(d_out) / shares.total() * lobe.pdf(axis(d_in, d_out), d_out)
}

pub(super) fn sample(lobe: &GaussLobe, shares: Shares, d_in: DVec3, u: [f64; 3]) -> Option<Sampled> {
    let reflects = shares.reflects(u[0]);
    let (dir, ratio) = lobe.sample(if reflects { mirrored(d_in) } else { d_in }, [u[1], u[2]]);
    let right_side = if reflects { dir.z > 0.0 } else { dir.z < 0.0 };
    let weight = shares.total() * ratio * dir.z.abs() / (-d_in.z).max(dir.z.abs());
    right_side.then(|| Sampled { dir, weight, pdf: pdf(lobe, shares, d_in, dir) })
}
