//! How far each point is trusted. Points of the rim come from the curves that trim a face, which a CAD kernel holds to
//! a tolerance of their own; single strays are set aside.

use super::model::Sample;

/// A rim of which the residuals are so many times those inside is trusted by as much less.
const LOOSE: f64 = 2.0;
/// A stray misses by so many standard deviations of its class; more strays than this share are the surface.
const STRAY: f64 = 6.0;
const FEW: f64 = 0.05;

/// Weighs the samples by their residuals (with the trust they had). True where a weight has changed.
pub(super) fn weigh(residuals: &[f64], on_edge: &[bool], terms: usize, samples: &mut [Sample]) -> bool {
    let raw: Vec<f64> = (residuals.iter().zip(samples.iter()))
        .map(|(r, sample)| r.abs() / if sample.trust > 0.0 { sample.trust } else { 1.0 })
        .collect();
    let of = |class: bool| raw.iter().zip(on_edge).filter(|(_, e)| **e == class).map(|(r, _)| *r).collect::<Vec<_>>();
    let (inside, rim) = (of(false), of(true));
    // Without points enough inside, the rim is the face.
    let apart = inside.len() as f64 >= 1.5 * terms as f64 && rim.len() >= 8;
    let (inner, outer) = match apart {
        true => (deviation(inside), deviation(rim)),
        false => {
            let all = deviation(raw.clone());
            (all, all)
        }
    };
    let loose = apart && outer > LOOSE * inner.max(1.0);
    let class = |i: usize| if on_edge[i] && loose { outer } else { inner };
    let stray = |i: usize| raw[i] > STRAY * class(i).max(1.0);
    let strays = (0..raw.len()).filter(|i| stray(*i)).count() as f64;
    let some = strays > 0.0 && strays <= FEW * raw.len() as f64;
    let mut changed = false;
    for (i, sample) in samples.iter_mut().enumerate() {
        let trust = if some && stray(i) {
            0.0
        } else if on_edge[i] && loose {
            inner.max(1.0) / outer
        } else {
            1.0
        };
        changed |= (trust - sample.trust).abs() > 0.2 * trust.max(sample.trust);
        sample.trust = trust;
    }
    changed
}

/// Standard deviation by the median, which strays don't move.
fn deviation(mut residuals: Vec<f64>) -> f64 {
    residuals.sort_by(f64::total_cmp);
    1.4826 * residuals.get(residuals.len() / 2).copied().unwrap_or(0.0)
}
