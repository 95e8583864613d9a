//! What points, and their rounding, leave open of a surface.

use super::Found;
use super::model::Sample;
use eyebox_scene::Known;

/// Standard errors of the surface between the points, root mean squares over the face and at worst: from the scatter of
/// the points about it, that of rounding to f32 at least. They hold as far as the surface is of its kind.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Open {
    /// Root mean square by which points that are left out are missed, mesh units.
    pub left_out: f64,
    /// Of the height, mesh units.
    pub height: [f64; 2],
    /// Of the slope, rad.
    pub slope: [f64; 2],
    /// Of the curvature, 1/mesh unit.
    pub curvature: [f64; 2],
    /// Strays that don't count.
    pub set_aside: usize,
}

impl Open {
    /// In physical units, for a mesh unit of so many metres.
    pub fn known(&self, metres: f64) -> Known {
        Known {
            height_um: self.height.map(|x| x * metres * 1e6),
            slope_arcmin: self.slope.map(|x| x.to_degrees() * 60.0),
            curvature_per_m: self.curvature.map(|x| x / metres),
            strays: self.set_aside,
        }
    }
}

/// Places at which the errors are computed.
const PLACES: usize = 200;

pub(super) fn open(found: &Found, samples: &[Sample], size: f64) -> Option<Open> {
    let Found { model, free, left_out, held } = found;
    let own;
    let triangle = match held {
        Some(held) => held,
        None => {
            own = model.triangle(samples, free)?;
            &own
        }
    };
    let trusted = samples.iter().filter(|sample| sample.trust > 0.0).count();
    let freedom = trusted.saturating_sub(model.terms()).max(1) as f64;
    let scatter = (model.cost(samples) * trusted as f64 / freedom).sqrt().max(1.0);
    let reach = model.basis.reach();
    let step = 0.01 * reach;
    let mut sums = [[0.0f64; 2]; 3];
    let mut count = 0.0;
    for sample in samples.iter().step_by(samples.len().div_ceil(PLACES).max(1)) {
        let q = model.frame.local(sample.p);
        let at = |by: [f64; 2], second: bool| {
            let row = model.probe([q.x, q.y], by, second, free);
            row.map(|mut row| triangle.error(&mut row) * scatter)
        };
        let height = at([0.0, 0.0], false)?;
        let slope = at([step, 0.0], false)?.hypot(at([0.0, step], false)?);
        let curvature = at([step, 0.0], true)?.max(at([0.0, step], true)?);
        for (sum, x) in sums.iter_mut().zip([height, slope, curvature]) {
            *sum = [sum[0] + x * x, sum[1].max(x)];
        }
        count += 1.0;
    }
    let [height, slope, curvature] = sums.map(|[sum, most]| [(sum / count).sqrt(), most]);
    let noise = samples.iter().map(|sample| model.noise(sample)).sum::<f64>() / samples.len().max(1) as f64;
    Some(Open {
        left_out: left_out * noise * size,
        height: height.map(|x| x * size),
        slope,
        curvature: curvature.map(|x| x / size),
        set_aside: samples.len() - trusted,
    })
}
