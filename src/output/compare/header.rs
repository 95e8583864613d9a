//! What the headers of two frames say: whether they can be compared, what was different about their making, and how well
//! their errors are known.

use crate::exr::WHITE_LUMINANCE;
use eyebox_film::colours::Colours;
use eyebox_film::frame::Frame;
use eyebox_film::plan::Estimator;

/// Independent scrambles that light tracing learns its error from; see `film::scrambles`.
const REPLICATES: f64 = eyebox_film::replicates::REPLICATES as f64;

/// Samples behind a frame's errors, less one: none known counts as many.
pub fn freedom(frame: &Frame) -> f64 {
    let passes = frame.integer("passes").filter(|passes| *passes > 0).map_or(f64::INFINITY, |passes| passes as f64);
    // Light tracing has one value per scramble, however many the passes.
    let forward = frame.meta.contains_key(&format!("passes.{}", Estimator::Forward.name()));
    if forward { (passes - 1.0).min(REPLICATES - 1.0) } else { passes - 1.0 }
}

/// Why two frames cannot be compared pixel by pixel; empty if they can.
pub fn incomparable(a: &Frame, b: &Frame) -> Vec<String> {
    let mut why = Vec::new();
    if (a.width, a.height) != (b.width, b.height) {
        why.push(format!("size: {} × {} and {} × {}", a.width, a.height, b.width, b.height));
    }
    let [of_a, of_b] = [a, b].map(Colours::of);
    if of_a != of_b {
        why.push(format!("colour space: {} and {}", of_a.name(a), of_b.name(b)));
    }
    let white = |frame: &Frame| frame.number(WHITE_LUMINANCE).unwrap_or(1.0);
    if white(a) != white(b) {
        why.push(format!("unit: whiteLuminance {} and {} cd/m²", white(a), white(b)));
    }
    let filled =
        |frame: &Frame| frame.channels.iter().all(|c| Some(c.data.len()) == frame.width.checked_mul(frame.height));
    for (frame, name) in [(a, 'A'), (b, 'B')] {
        if !filled(frame) || frame.width == 0 || frame.height == 0 {
            why.push(format!("{name} has channels that do not fill it"));
        }
    }
    why
}

/// What else differs, and a word about seeds.
pub fn notes(a: &Frame, b: &Frame) -> Vec<String> {
    let mut notes = Vec::new();
    let said = |frame: &Frame, key: &str| {
        let text = frame.text(key).map(str::to_owned);
        text.or_else(|| frame.number(key).map(|n| n.to_string())).unwrap_or_else(|| "none".to_owned())
    };
    for key in ["scene", "sceneHash", "version", "eye", "contrast", "passes", "mix"] {
        if a.meta.get(key) != b.meta.get(key) {
            notes.push(format!("{key}: {} and {}", short(&said(a, key)), short(&said(b, key))));
        }
    }
    let seed = a.meta.get("seed");
    if seed.is_some() && seed == b.meta.get("seed") {
        notes.push(
            "same seed: noise is shared, so differences come out smaller than the errors allow; a test of two scenes \
             is sharper with two seeds"
                .to_owned(),
        );
    }
    notes
}

fn short(text: &str) -> String {
    const MOST: usize = 60;
    if text.chars().count() <= MOST { text.to_owned() } else { text.chars().take(MOST).chain(['…']).collect() }
}
