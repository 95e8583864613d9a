//! Shards whose light lies far from the others': a machine that computes wrongly makes a sound file.

use super::run::Films;
use super::tuning::outliers::{OF_MAPS, SIGMA, TOGETHER};
use eyebox_base::stats::Moments;
use std::path::Path;

/// Light of one plane of a shard, summed over the picture: its mean over passes and what its variance should be.
pub struct PlaneLight {
    name: String,
    mean: f64,
    variance: f64,
    passes: f64,
}

/// The light of all planes of a shard. Estimators that share a plane count together: which of them has a path may depend on
/// the pass (finer maps of lit faces come late).
pub fn light(films: &Films) -> Vec<PlaneLight> {
    let mut all: Vec<PlaneLight> = Vec::new();
    for (_, film, _) in &films.films {
        for (plane, key) in film.planes.iter().enumerate() {
            let pixels = || 0..film.width * film.height;
            let taken = if key.takes == 0 { String::new() } else { format!(", taken by {:b}", key.takes) };
            let name = format!("{} of group {}{taken}", key.layer.name(), key.group.index());
            let mean = pixels().map(|pixel| film.mean(pixel, plane).value).sum();
            let variance = pixels().map(|pixel| film.variance(pixel, plane)).sum();
            let passes = film.passes as f64;
            match all.iter_mut().find(|light| light.name == name) {
                Some(light) => {
                    light.mean += mean;
                    light.variance += variance;
                }
                None => all.push(PlaneLight { name, mean, variance, passes }),
            }
        }
    }
    all
}

/// One line per shard and plane that is far from the rest.
pub fn find(names: &[&Path], lights: &[Vec<PlaneLight>]) -> Vec<String> {
    let planes = lights.iter().map(Vec::len).min().unwrap_or(0);
    let mut lines = Vec::new();
    for plane in 0..planes {
        for (own, name) in names.iter().enumerate() {
            let Some(shard) = lights.get(own).and_then(|shard| shard.get(plane)) else { continue };
            let others: Vec<&PlaneLight> = lights
                .iter()
                .enumerate()
                .filter(|(k, _)| *k != own)
                .filter_map(|(_, shard)| shard.get(plane))
                .collect();
            if let Some(sigmas) = deviation(shard, &others).filter(|sigmas| sigmas.abs() > SIGMA) {
                let side = if sigmas > 0.0 { "above" } else { "below" };
                lines.push(format!(
                    "{}: {} is {:.0} standard errors {side} that of the other shards",
                    name.display(),
                    shard.name,
                    sigmas.abs()
                ));
            }
        }
    }
    lines
}

/// How far a shard lies from the mean of the others, in standard errors: the larger of what its pixels tell and what
/// the others' scatter tells.
fn deviation(own: &PlaneLight, others: &[&PlaneLight]) -> Option<f64> {
    // One pass tells nothing of its error.
    let others: Vec<&&PlaneLight> = others.iter().filter(|other| other.passes >= 2.0).collect();
    if own.passes < 2.0 || others.is_empty() {
        return None;
    }
    let passes: f64 = others.iter().map(|other| other.passes).sum();
    let mean = others.iter().map(|other| other.mean * other.passes).sum::<f64>() / passes;
    let of_pixels = |light: &PlaneLight| light.variance * TOGETHER;
    let rest = others.iter().map(|other| of_pixels(other) * (other.passes / passes).powi(2)).sum::<f64>();
    let mut scatter = Moments::default();
    others.iter().for_each(|other| scatter.add((other.mean - mean) * other.passes.sqrt()));
    let per_pass = if others.len() > 2 { scatter.variance() } else { 0.0 };
    let variance = (of_pixels(own) + rest).max(per_pass * (1.0 / own.passes + 1.0 / passes));
    let apart = (own.mean - mean).abs() - OF_MAPS * mean.abs();
    let apart = apart.max(0.0).copysign(own.mean - mean);
    (variance > 0.0).then(|| apart / variance.sqrt()).or((apart != 0.0).then_some(f64::INFINITY.copysign(apart)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shard(mean: f64, passes: f64) -> Vec<PlaneLight> {
        vec![PlaneLight { name: "direct".to_owned(), mean, variance: 1.0 / passes, passes }]
    }

    /// Light of 1000 ± 1 per pass: a shard of twice the light is told by name, the scatter of sound ones is not, and
    /// shards that scatter more than their pixels say are given that.
    #[test]
    fn tells_the_one_that_is_wrong() {
        let names: Vec<String> = (0..5).map(|k| format!("{k}.exr")).collect();
        let paths: Vec<&Path> = names.iter().map(Path::new).collect();
        let good = [1000.2, 999.7, 1000.9, 999.4, 1000.0];
        let lights: Vec<_> = good.map(|mean| shard(mean, 10.0)).into();
        assert!(find(&paths, &lights).is_empty());
        let mut bad: Vec<_> = good.map(|mean| shard(mean, 10.0)).into();
        bad[3] = shard(2000.0, 10.0);
        let lines = find(&paths, &bad);
        assert!(lines.len() == 1 && lines[0].starts_with("3.exr") && lines[0].contains("above"), "{lines:?}");
        // Single passes have no variance of their own: nothing is claimed.
        let single = |mean| vec![PlaneLight { variance: 0.0, ..shard(mean, 1.0).remove(0) }];
        assert!(find(&paths[..2], &[single(1.0), single(2.0)]).is_empty());
        // Nor of light that comes seldom, which two shards have not met and the single pass of a third has.
        let none = || vec![PlaneLight { variance: 0.0, ..shard(0.0, 2.0).remove(0) }];
        assert!(find(&paths[..3], &[none(), none(), single(1.0)]).is_empty());
        // Maps that come late move light a little, whatever the noise is.
        let quiet = |mean| vec![PlaneLight { variance: 1e-9, ..shard(mean, 10.0).remove(0) }];
        assert!(find(&paths[..4], &[quiet(1000.9), quiet(1000.0), quiet(1000.0), quiet(1000.0)]).is_empty());
        assert_eq!(find(&paths[..4], &[quiet(1001.1), quiet(1000.0), quiet(1000.0), quiet(1000.0)]).len(), 1);
        let wide: Vec<_> = [900.0, 1100.0, 1000.0, 950.0, 1080.0].map(|mean| shard(mean, 10.0)).into();
        assert!(find(&paths, &wide).is_empty());
    }
}
