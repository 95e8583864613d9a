//! Where the slide's edges are in the direct HUD's picture.

use super::kit::*;
use super::prescription::DIRECT;
use eyebox::estimate::picture::picture;
use eyebox::plan::Choice;
use eyebox::scene::{Scene, Slide};

/// s of the slide where the prescription puts it: `size` mm, right and up as seen; 0 outside.
fn s_at(slide: &Slide, [x, y]: [f64; 2], size: [f64; 2]) -> f64 {
    let (column, row) = ((x / size[0] + 0.5) * slide.width as f64, (0.5 - y / size[1]) * slide.height as f64);
    let inside = column >= 0.0 && row >= 0.0 && column < slide.width as f64 && row < slide.height as f64;
    if inside { f64::from(slide.pixels[row as usize * slide.width + column as usize]) } else { 0.0 }
}

/// The picture that the prescription expects: share of open of each pixel, by chief rays.
fn expected(scene: &Scene, size: [f64; 2]) -> Vec<f64> {
    const FINE: usize = 8;
    let [width, height] = scene.eye.resolution;
    let half = (scene.eye.fov_deg.to_radians() / 2.0).tan();
    let tangent = |at: f64, count: usize| half * (2.0 * at - count as f64) / width as f64;
    let mut out = Vec::with_capacity(width * height);
    for py in 0..height {
        for px in 0..width {
            let mut sum = 0.0;
            for k in 0..FINE * FINE {
                let sub = |k: usize| (k as f64 + 0.5) / FINE as f64;
                let ax = tangent(px as f64 + sub(k % FINE), width);
                let ay = -tangent(py as f64 + sub(k / FINE), height);
                sum += s_at(&scene.slides[0], DIRECT.trace([0.0; 2], [ax, ay]).0, size);
            }
            out.push(sum / (FINE * FINE) as f64);
        }
    }
    out
}

/// Shifts in pixels of the edges that cross windows of five pixels along `step`, one per edge and row: for an edge from 0
/// to 1 that moves by δ, the window's sum falls by δ.
fn shifts(expected: &[f64], got: &[f64], starts: impl Iterator<Item = usize>, step: usize) -> Vec<(usize, f64)> {
    starts
        .filter_map(|start| {
            let window: Vec<usize> = (0..5).map(|k| start + k * step).collect();
            let value = |k: usize| expected[window[k]];
            let rises = (1..5).all(|k| value(k) >= value(k - 1) - 1e-9);
            let falls = (1..5).all(|k| value(k) <= value(k - 1) + 1e-9);
            let flat = |k: usize| value(k) < 1e-3 || value(k) > 1.0 - 1e-3;
            let edge = (value(4) - value(0)).abs() > 0.99 && flat(0) && flat(1) && flat(3) && flat(4);
            if !(edge && (rises || falls)) {
                return None;
            }
            let difference: f64 = window.iter().map(|&w| expected[w] - got[w]).sum();
            Some((start, difference * (value(4) - value(0)).signum()))
        })
        .collect()
}

/// The picture's share of open: `content` over `open`.
fn render(scene: &Scene, passes: u64) -> Vec<f64> {
    let ready = Ready::new(scene, Choice::Auto);
    let frame = picture(scene, &ready.plan, &ready.run(passes, 3), Default::default()).expect("a sound picture").frame;
    let data = |layer: &str| &frame.component(layer, "R").expect("the split is stored").data;
    let (open, content) = (data("forward_led_open"), data("forward_led_content"));
    content.iter().zip(open).map(|(c, o)| if *o > 0.0 { f64::from(*c) / f64::from(*o) } else { f64::NAN }).collect()
}

/// Mean shift of edges, its standard error, their number.
type Shift = (f64, f64, usize);

#[derive(Debug)]
struct Edges {
    all: Shift,
    /// The region of 30 × 30 pixels that is worst off: single rows are noisy.
    worst: Shift,
}

/// Upright edges, then level ones.
fn edges(scene: &Scene, expected: &[f64], got: &[f64]) -> [Edges; 2] {
    let [width, height] = scene.eye.resolution;
    let across = (0..height).flat_map(|y| (0..width - 4).map(move |x| y * width + x));
    let down = 0..width * (height - 4);
    [shifts(expected, got, across, 1), shifts(expected, got, down, width)].map(|all| {
        let lit: Vec<(usize, f64)> = all.into_iter().filter(|(_, d)| d.is_finite()).collect();
        const TILE: usize = 30;
        let mut tiles = std::collections::BTreeMap::<(usize, usize), Vec<f64>>::new();
        for (start, d) in &lit {
            tiles.entry((start % width / TILE, start / width / TILE)).or_default().push(*d);
        }
        let summed = |values: &[f64]| {
            let (mean, sigma) = of_runs(values);
            (mean, sigma, values.len())
        };
        let worst = tiles
            .values()
            .filter(|values| values.len() >= 8)
            .map(|values| summed(values))
            .max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))
            .expect("edges");
        let edges = Edges { all: summed(&lit.iter().map(|(_, d)| *d).collect::<Vec<f64>>()), worst };
        eprintln!("{edges:?} of {} regions", tiles.len());
        edges
    })
}

#[test]
fn the_slides_edges_are_where_the_prescription_puts_them() {
    let scene = hud("direct", &ONE_LED);
    for edges in edges(&scene, &expected(&scene, [40.0, 20.0]), &render(&scene, 4)) {
        let (mean, sigma, count) = edges.all;
        assert!(count > 300 && sigma < 0.02, "{edges:?}");
        assert!(mean.abs() < 0.05 && edges.worst.0.abs() < 0.2, "{edges:?}");
    }
}

/// A slide of another size puts its edges elsewhere. That the comparison bites: against the old size the edges are pixels
/// away.
#[test]
fn the_slides_size_moves_the_edges() {
    let (factor, size) = (1.1, "[44, 22]");
    let set = format!("LCD_ACTIVE_AREA.slide.size={size}");
    let scene = hud("direct", &[ONE_LED[0], ONE_LED[1], &set]);
    let own = expected(&scene, [40.0 * factor, 20.0 * factor]);
    let got = render(&scene, 2);
    for edges in edges(&scene, &own, &got) {
        assert!(edges.all.2 > 300 && edges.all.0.abs() < 0.05 && edges.worst.0.abs() < 0.2, "{size}: {edges:?}");
    }
    let old = edges(&scene, &expected(&scene, [40.0, 20.0]), &got);
    assert!(old.iter().any(|edges| edges.worst.0.abs() > 1.0), "edges of the old size must not fit: {old:?}");
}
