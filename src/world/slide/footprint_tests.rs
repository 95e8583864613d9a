//! Footprints on slides, against closed forms and rasters.

use super::*;
use eyebox_scene::Slide;
use std::sync::Arc;

/// `width` pixels side by side along +x and rows of them along +y downwards, each one unit wide, about the origin.
pub fn slide(width: usize, pixels: &[f32]) -> SlideMap {
    let height = pixels.len() / width;
    let slide = Slide {
        name: "lcd".into(),
        file: "lcd.png".into(),
        width,
        height,
        pixels: Arc::new(pixels.to_vec()),
        rgb: None,
        centre: DVec3::ZERO,
        u: DVec3::X,
        v: DVec3::NEG_Y,
        size: [width as f64, height as f64],
        transmittance: 1.0,
        contrast: f64::INFINITY,
        polarisation: None,
        primaries: None,
    };
    SlideMap::build(&slide).expect("it is well formed")
}

fn square() -> Polygon {
    [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].map(DVec2::from_array).into_iter().collect()
}

/// Area, area times s, and s times the place, of the square on a slide; and in how many pieces.
fn sums(map: &SlideMap, footprint: &Footprint) -> (f64, f64, DVec2, usize) {
    let (mut area, mut white, mut place, mut pieces) = (0.0, 0.0, DVec2::ZERO, 0);
    let whole = map.pieces(&square(), footprint, &mut |piece, index| {
        let (of_piece, moment) = moments(piece);
        let s = map.s_of(index);
        (area, white, place, pieces) = (area + of_piece, white + s * of_piece, place + s * moment, pieces + 1);
        Some(())
    });
    assert!(whole.is_some());
    (area, white, place, pieces)
}

pub fn turned(at: DVec3, size: f64, angle: f64) -> Footprint {
    let (sin, cos) = angle.sin_cos();
    let by = [DVec3::new(cos, sin, 0.0) * size, DVec3::new(-sin, cos, 0.0) * size];
    Footprint { slide: 0, at, by }
}

/// The share of a unit square about the origin with n·p ≤ d, for the unit vector n = (cos a, sin a): the integral of the
/// trapezium that is its projection.
fn share_below(d: f64, a: f64) -> f64 {
    let (wide, narrow) = (a.cos().abs().max(a.sin().abs()), a.cos().abs().min(a.sin().abs()));
    let flank = |x: f64| if narrow > 0.0 { x.max(0.0).powi(2) / (2.0 * wide * narrow) } else { x.max(0.0) / wide };
    let [outer, inner] = [0.5 * (wide + narrow), 0.5 * (wide - narrow)];
    match narrow > 0.0 {
        true => flank(d + outer) - flank(d + inner) - flank(d - inner) + flank(d - outer),
        false => flank(d + outer) - flank(d - outer),
    }
}

/// A black and a white half, seen by a pixel that is turned against the edge and lies anywhere across it.
#[test]
fn a_slanted_edge_has_the_share_of_its_closed_form() {
    let map = slide(2, &[0.0, 1.0]);
    for step in 0..=40 {
        for angle in [0.0, 0.1, 0.6, 0.785, 1.2, 2.0, -0.3] {
            let (x, size) = (f64::from(step) * 0.01 - 0.2, 0.25);
            let (area, white, _, _) = sums(&map, &turned(DVec3::new(x, 0.1, 3.0), size, angle));
            let want = 1.0 - share_below(-x / size, angle);
            assert!((area - 1.0).abs() < 1e-14 && (white - want).abs() < 1e-13, "{x} {angle}: {white} {want}");
        }
    }
}

/// What lies beside the picture is not there, and what is even is one piece.
#[test]
fn rims_cut_and_even_places_are_whole() {
    let map = slide(3, &[0.5; 9]);
    assert_eq!(sums(&map, &turned(DVec3::ZERO, 1.0, 0.4)), (1.0, 0.5, DVec2::ZERO, 1));
    let (area, white, place, _) = sums(&map, &turned(DVec3::new(1.5, 0.0, 0.0), 1.0, 0.0));
    assert!((area - 0.5).abs() < 1e-15 && (white - 0.25).abs() < 1e-15);
    // All of it is on the left, a quarter of the side from the middle.
    assert!(place.distance(DVec2::new(-0.25 * 0.25, 0.0)) < 1e-15, "{place}");
    assert_eq!(sums(&map, &turned(DVec3::new(2.6, 0.0, 0.0), 1.0, 0.0)).0, 0.0);
    assert!(map.pieces(&square(), &turned(DVec3::NAN, 1.0, 0.0), &mut |_, _| Some(())).is_none());
}

/// Of any picture and footprint, small, turned, sheared or larger than the picture, against a raster of the square.
#[test]
fn any_footprint_agrees_with_a_raster() {
    let pixels: Vec<f32> =
        (0..35u32).map(|k| f32::from((k * 11 % 7) as u8) / 7.0).map(|s| if s < 0.4 { 0.0 } else { s }).collect();
    let map = slide(7, &pixels);
    let footprints = [
        turned(DVec3::new(0.3, -0.4, 0.0), 1.7, 0.3),
        turned(DVec3::new(-2.9, 1.9, 0.0), 2.0, 1.0),
        turned(DVec3::ZERO, 12.0, 0.2),
        Footprint {
            slide: 0,
            at: DVec3::new(0.5, 0.2, 0.0),
            by: [DVec3::new(2.0, 1.0, 0.0), DVec3::new(1.7, 1.1, 0.4)],
        },
        // Mirrored.
        Footprint {
            slide: 0,
            at: DVec3::new(0.5, 0.2, 0.0),
            by: [DVec3::new(0.1, 1.3, 0.0), DVec3::new(1.4, -0.2, 0.0)],
        },
    ];
    for footprint in footprints {
        let n = 1200;
        let (mut area, mut white, mut place) = (0.0, 0.0, DVec2::ZERO);
        for k in 0..n * n {
            let at = DVec2::new((k % n) as f64 + 0.5, (k / n) as f64 + 0.5) / n as f64 - 0.5;
            if let Some(s) = map.s(footprint.place(at)) {
                (area, white, place) = (area + 1.0, white + s, place + s * at);
            }
        }
        let all = (n * n) as f64;
        let got = sums(&map, &footprint);
        // Each of some 20 lines has a row of the raster's cells on one side or the other.
        let close = 20.0 * 0.3 / n as f64;
        assert!((got.0 - area / all).abs() < close && (got.1 - white / all).abs() < close, "{got:?} {area} {white}");
        assert!(got.2.distance(place / all) < close, "{got:?} {place}");
    }
}
