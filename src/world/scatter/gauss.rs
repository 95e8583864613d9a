//! Lobes about the specular directions: `share · lobe(t)/max(cos_i, cos_o)`, t the angle to the mirrored direction for
//! reflection, to the straight one for transmission. With the larger cosine below, no direction of incidence gains
//! energy. What a direction loses by it, and beyond the horizon, leaves with the [rest](GaussLobe::rest), broadly: the shares are what
//! is reflected and transmitted whichever way light arrives.

use super::{Sampled, Shares, mirrored};
use crate::gauss::GaussLobe;
use glam::DVec3;

fn axis(d_in: DVec3, d_out: DVec3) -> DVec3 {
    if d_out.z > 0.0 { mirrored(d_in) } else { d_in }
}

pub(super) fn eval(lobe: &GaussLobe, shares: Shares, d_in: DVec3, d_out: DVec3) -> f64 {
    value(lobe, lobe.lost(d_in.z), d_in, d_out) * shares.side(d_out)
}

/// Of a share of 1, where the lobe loses `lost` of what arrives.
fn value(lobe: &GaussLobe, lost: f64, d_in: DVec3, d_out: DVec3) -> f64 {
    lobe.value(axis(d_in, d_out), d_out) / (-d_in.z).max(d_out.z.abs()) + lobe.rest([lost, lobe.lost(d_out.z)])
}

pub(super) fn pdf(lobe: &GaussLobe, shares: Shares, d_in: DVec3, d_out: DVec3) -> f64 {
    shares.side(d_out) / shares.total() * density(lobe, lobe.lost(d_in.z), d_in, d_out)
}

/// On the side of `d_out` alone.
fn density(lobe: &GaussLobe, lost: f64, d_in: DVec3, d_out: DVec3) -> f64 {
    (1.0 - lost) * lobe.pdf(axis(d_in, d_out), d_out) + lost * lobe.rest_pdf(d_out.z)
}

pub(super) fn sample(lobe: &GaussLobe, shares: Shares, d_in: DVec3, u: [f64; 3]) -> Option<Sampled> {
    let reflects = shares.reflects(u[0]);
    let lost = lobe.lost(d_in.z);
    let dir = if u[1] < lost {
        let up = lobe.sample_rest([u[1] / lost, u[2]])?;
        if reflects { up } else { mirrored(up) }
    } else {
        let rest = (u[1] - lost) / (1.0 - lost);
        lobe.sample(if reflects { mirrored(d_in) } else { d_in }, [rest, u[2]])
    };
    let right_side = if reflects { dir.z > 0.0 } else { dir.z < 0.0 };
    let density = density(lobe, lost, d_in, dir);
    right_side.then(|| Sampled {
        dir,
        weight: shares.total() * value(lobe, lost, d_in, dir) * dir.z.abs() / density,
        pdf: shares.side(dir) / shares.total() * density,
    })
}
