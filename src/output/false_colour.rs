//! Luminances as colours on a logarithmic scale, with the scale beside them.

use super::canvas::{Canvas, STEP};

/// Decades below the largest luminance that have colours of their own.
pub(super) const DECADES: f64 = 4.0;
/// Colours along the scale: brighter with luminance but for the saturated middle, so that a print in grey still orders them.
pub(super) const STOPS: [(f64, [f64; 3]); 8] = [
    (0.0, [0.0, 0.0, 0.0]),
    (0.15, [60.0, 0.0, 120.0]),
    (0.3, [20.0, 50.0, 230.0]),
    (0.45, [0.0, 140.0, 210.0]),
    (0.6, [20.0, 170.0, 60.0]),
    (0.75, [235.0, 200.0, 0.0]),
    (0.9, [245.0, 70.0, 20.0]),
    (1.0, [255.0, 255.0, 255.0]),
];
/// Where a value is not a number.
const NOT_FINITE: [u8; 3] = [255, 0, 255];

/// The ends of the scale for a picture, cd/m²: the largest luminance rounded up to 1, 2 or 5 times a power of ten, and four
/// decades below. A black picture ends at 1.
pub fn scale(luminance: &[f64]) -> [f64; 2] {
    let largest = luminance.iter().filter(|value| value.is_finite()).fold(0.0f64, |largest, value| largest.max(*value));
    let high = if largest > 0.0 { round_up(largest) } else { 1.0 };
    [high / 10f64.powf(DECADES), high]
}

fn round_up(value: f64) -> f64 {
    let power = 10f64.powf(value.log10().floor());
    // A little slack, so that 100 stays 100 whatever the logarithm rounds to.
    [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|step| step * power)
        .find(|round| *round >= value * (1.0 - 1e-12))
        .unwrap_or(value)
}

/// The colour of a luminance.
pub fn colour(value: f64, [low, high]: [f64; 2]) -> [u8; 3] {
    if !value.is_finite() {
        return NOT_FINITE;
    }
    let place = if value <= low { 0.0 } else { ((value / low).ln() / (high / low).ln()).clamp(0.0, 1.0) };
    let between = STOPS.windows(2).find(|pair| place <= pair[1].0);
    let Some([(from, a), (to, b)]) = between else { return [255; 3] };
    let share = (place - from) / (to - from);
    [0, 1, 2].map(|c| (a[c] + share * (b[c] - a[c])).round() as u8)
}

/// The picture in false colours with its legend on the right: a bar, and labels in cd/m².
pub fn draw(luminance: &[f64], width: usize, height: usize) -> Canvas {
    let ends = scale(luminance);
    let letter = if height >= 300 { 2 } else { 1 };
    let (bar, gap) = (8 * letter, 3 * letter);
    let legend = 2 * gap + bar + letter * STEP[0] * 8;
    let tall = height.max(letter * STEP[1] * 7);
    let mut out = Canvas::new(width + legend, tall, [24; 3]);
    for (index, value) in luminance.iter().enumerate() {
        out.set(index % width.max(1), index / width.max(1), colour(*value, ends));
    }
    let head = letter * STEP[1] + gap;
    out.text([width + gap, gap], "cd/m²", letter, [230; 3]);
    let (top, length) = (head + gap, tall.saturating_sub(head + 2 * gap + letter * STEP[1]).max(1));
    let [low, high] = ends;
    for y in 0..length {
        let place = 1.0 - y as f64 / (length.max(2) - 1) as f64;
        out.fill([width + gap, top + y], [bar, 1], colour(low * (high / low).powf(place), ends));
    }
    for decade in 0..=DECADES as i32 {
        let value = high / 10f64.powi(decade);
        let y = top + (length - 1) * decade as usize / DECADES as usize;
        out.fill([width + gap + bar, y], [gap, 1], [230; 3]);
        let label = if (0.01..10_000.0).contains(&value) { short(value) } else { format!("{value:.0e}") };
        out.text([width + gap + bar + gap + letter, y.saturating_sub(2 * letter)], &label, letter, [230; 3]);
    }
    out
}

/// 200, 2, 0.5, 0.05.
fn short(value: f64) -> String {
    let digits = if value >= 1.0 { 0 } else { 2 };
    let text = format!("{value:.digits$}");
    if digits > 0 { text.trim_end_matches('0').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_and_its_colours() {
        for (largest, high) in [(100.0, 100.0), (101.0, 200.0), (3e5, 5e5), (0.07, 0.1), (0.0, 1.0)] {
            let [low, top] = scale(&[largest, f64::NAN]);
            assert!((top / high - 1.0).abs() < 1e-9 && (low / high - 1e-4).abs() < 1e-12, "{largest}: {low} {top}");
        }
        let ends = [0.01, 100.0];
        assert_eq!([colour(0.0, ends), colour(0.01, ends), colour(1e9, ends)], [[0; 3], [0; 3], [255; 3]]);
        assert_eq!(colour(f64::NAN, ends), NOT_FINITE);
        // 0.6 of four decades above 0.01 is a stop.
        assert_eq!(colour(0.01 * 10f64.powf(2.4), ends), [20, 170, 60]);
    }

    #[test]
    fn the_legend_is_beside_the_picture() {
        let (width, height) = (10, 4);
        let picture: Vec<f64> = (0..40).map(f64::from).collect();
        let raster = draw(&picture, width, height);
        assert!(raster.width > width + 20 && raster.height >= 49);
        assert_eq!(raster.bytes.len(), 3 * raster.width * raster.height);
        assert_eq!(raster.bytes[3 * 9..3 * 10], colour(9.0, scale(&picture)));
        // The top of the bar is the largest value, white; labels are drawn somewhere.
        assert!(raster.bytes.chunks(3).any(|c| c == [230; 3]) && raster.bytes.chunks(3).any(|c| c == [255; 3]));
        assert_eq!([short(200.0), short(2.0), short(0.5), short(0.05)], ["200", "2", "0.5", "0.05"]);
    }
}
