//! How the relative error fell with passes.

use crate::luminance::layer_luminance;
use eyebox_base::stats::beyond_noise;
use eyebox_film::frame::Frame;
use serde_json::{Value, json};

/// Where `render --convergence` leaves its list of [passes, relative error].
const KEY: &str = "convergence";

/// Points of all frames, fewest passes first: what their headers list, and the error of each frame itself.
pub fn points(frames: &[(String, &Frame)]) -> Vec<Value> {
    let mut points: Vec<(f64, f64, String)> = Vec::new();
    for (name, frame) in frames {
        let listed = frame.text(KEY).and_then(|json| serde_json::from_str::<Vec<[f64; 2]>>(json).ok());
        let listed = listed.unwrap_or_default();
        points.extend(listed.into_iter().map(|[passes, error]| (passes, error, format!("header of {name}"))));
        if let (Some(passes), Some(error)) = (frame.integer("passes"), relative_noise(frame)) {
            // What the header says holds what photons blur, too.
            if !points.iter().any(|(of, _, from)| *of == passes as f64 && from.ends_with(name)) {
                points.push((passes as f64, error, name.clone()));
            }
        }
    }
    points.retain(|(passes, error, _)| *passes >= 1.0 && passes.is_finite() && *error > 0.0 && error.is_finite());
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points.into_iter().map(|(passes, error, from)| json!({ "passes": passes, "error": error, "from": from })).collect()
}

/// Root of the sum of the squared standard errors over that of the squared luminances, less what of these is noise: the error
/// that `render` states without what photons blur and without what few pixels or few passes hide. None where it is unknown.
pub fn relative_noise(frame: &Frame) -> Option<f64> {
    let (light, error) = (layer_luminance(frame, "")?, layer_luminance(frame, "stderr")?);
    let squares = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>();
    let noise = Some(squares(&error)).filter(|noise| !noise.is_nan())?;
    beyond_noise(noise, squares(&light)).map(|signal| (noise / signal).sqrt())
}
