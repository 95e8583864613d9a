//! Places of the picture that show lamps: the pixels that they reach into have points of their own for them.

use crate::tuning::vision::{LARGE, MOST_GLINTS, MOST_PIXELS};
use eyebox_film::glint::Glint;
use eyebox_world::eye::EyeLens;
use std::collections::HashMap;
use std::ops::Range;

/// Columns and rows of the pixels that a glint reaches into; none if it is left to the paths of each.
fn reach(eye: &EyeLens, glint: &Glint) -> Option<[Range<usize>; 2]> {
    let (half, [w, h], [width, height]) = (eye.half(), eye.pixel(), eye.size());
    if glint.area() > LARGE * w * h {
        return None;
    }
    let range = |lo: f64, hi: f64, count: usize| {
        let clamped = |x: f64| x.floor().clamp(0.0, count as f64) as usize;
        clamped(lo)..clamped(hi + 1.0)
    };
    let ([x, y], [wide, high]) = (glint.middle, glint.half());
    let columns = range((half.x + x - wide) / w, (half.x + x + wide) / w, width);
    let rows = range((half.y - y - high) / h, (half.y - y + high) / h, height);
    (columns.len() * rows.len() <= MOST_PIXELS).then_some([columns, rows])
}

/// Whether pixels have points of their own for a glint.
pub fn is_looked_about(eye: &EyeLens, glint: &Glint) -> bool {
    reach(eye, glint).is_some()
}

/// The glints that reach into each pixel: of many the first.
pub(super) fn by_pixel(eye: &EyeLens, glints: &[Glint]) -> HashMap<u64, Vec<Glint>> {
    let [width, _] = eye.size();
    let mut all: HashMap<u64, Vec<Glint>> = HashMap::new();
    for (glint, [columns, rows]) in glints.iter().filter_map(|glint| Some((glint, reach(eye, glint)?))) {
        for (px, py) in rows.flat_map(|py| columns.clone().map(move |px| (px, py))) {
            let here = all.entry((py * width + px) as u64).or_default();
            if here.len() < MOST_GLINTS {
                here.push(*glint);
            }
        }
    }
    all
}
