use super::super::ghosts::Ghost;
use super::super::{Line, Scan};
use super::*;
use eyebox_estimate::virtual_image::ghosts::GhostPoint;
use eyebox_estimate::virtual_image::image::{Vergence, distortion};
use eyebox_estimate::virtual_image::subject::Kind;
use glam::{DVec2, DVec3};

const HOSTILE: &str = "</svg><img src=x onerror=\"alert(1)\">{{data}}\u{7}";

/// A cubic picture of 5 × 3 points from two positions, with a ghost 6′ to the right and 3′ down at each point.
fn scan() -> Scan {
    let position = |x_m: f64| {
        let line = |i: usize| {
            let cell = [i % 5, i / 5];
            let p = DVec2::new(cell[0] as f64 / 4.0 - 0.5, 0.5 - cell[1] as f64 / 2.0) * DVec2::new(0.2, 0.1);
            let t = p * (1.0 + 3.0 * p.length_squared());
            let per_m = 0.4 + 0.1 * cell[0] as f64;
            Line {
                cell,
                seen: i != 14,
                direction_deg: Some([t.x, t.y].map(|side| side.atan().to_degrees())),
                vergence: (i != 14)
                    .then_some(Vergence { horizontal_per_m: per_m - 0.01, vertical_per_m: per_m + 0.01 }),
                disparity: None,
            }
        };
        let ghost = |cell: [usize; 2]| GhostPoint { cell, separation_arcmin: [6.0, -3.0], ratio: 0.1 };
        let points = (0..14).map(|i| ghost([i % 5, i / 5])).collect();
        let by = HOSTILE.to_owned();
        let ghosts = vec![Ghost { by, mean_ratio: 0.1, most_ratio: 0.1, most_arcmin: 45f64.sqrt(), points }];
        Position { x_m, points: (0..15).map(line).collect(), ghosts, ..Position::nowhere() }
    };
    Scan {
        part: HOSTILE.to_owned(),
        face: 0,
        kind: Kind::Slide,
        by: "mirror".to_owned(),
        picture_m: [0.2, 0.1],
        eyebox_m: [0.1, 0.0],
        ipd_m: 0.063,
        positions: vec![position(-0.05), position(0.05)],
        ghosts_left_out: 0.0,
        edges: None,
    }
}

/// Numbers of an attribute, in their order.
fn numbers(svg: &str, element: &str, name: &str) -> Vec<f64> {
    let elements = svg.split('<').filter(|part| part.starts_with(element));
    let value = |part: &str| part.split(&format!(" {name}=\"")).nth(1)?.split('"').next()?.parse().ok();
    elements.filter_map(value).collect()
}

/// What is drawn as deviations is what `scan` states as distortion.
#[test]
fn deviations_are_the_distortion() {
    let scan = scan();
    let position = &scan.positions[0];
    let dir = |deg: [f64; 2]| {
        let [x, y] = deg.map(|angle| angle.to_radians().tan());
        DVec3::new(x, y, -1.0).normalize()
    };
    let found = distortion::deviations(&scan, position);
    assert_eq!(found.len(), 14);
    let places: Vec<(DVec2, DVec3)> = found
        .iter()
        .map(|(cell, real, _)| {
            (DVec2::new(cell[0] as f64 / 4.0 - 0.5, 0.5 - cell[1] as f64 / 2.0) * DVec2::new(0.2, 0.1), dir(*real))
        })
        .collect();
    let want = distortion(&places, places[7].1, DVec3::X).unwrap().max_arcmin;
    let most = found.iter().map(|(_, real, ideal)| dir(*real).angle_between(dir(*ideal)).to_degrees() * 60.0);
    let most = most.fold(0.0, f64::max);
    assert!(want > 1.0 && (most / want - 1.0).abs() < 1e-6, "{most} {want}");
}

#[test]
fn ghosts_are_drawn_where_they_are() {
    let scan = scan();
    let chart = ghosts::chart(&scan).unwrap();
    let factor: f64 = chart.note.split(", ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    let scale = sheet::Sheet::new(&scan).unwrap().scale;
    let [x1, x2, y1, y2] = ["x1", "x2", "y1", "y2"].map(|name| numbers(&chart.svg, "line", name));
    assert_eq!(x1.len(), 28);
    for i in 0..28 {
        // 6′ to the right, 3′ down, which is down in the picture, too.
        assert!((x2[i] - x1[i] - factor * scale * 0.1).abs() < 2e-3, "{} {}", x1[i], x2[i]);
        assert!((y2[i] - y1[i] - factor * scale * 0.05).abs() < 2e-3, "{} {}", y1[i], y2[i]);
    }
}

#[test]
fn distances_have_colours_in_their_order() {
    let chart = vergence::chart(&scan()).unwrap();
    assert_eq!(numbers(&chart.svg, "circle", "cx").len(), 28);
    assert!(chart.note.contains("from 0.4000 1/m") && chart.note.contains("to 0.8000 1/m"), "{}", chart.note);
    let light = |share: f64| {
        let text = vergence::colour(share);
        let part = |at: usize| f64::from(u8::from_str_radix(&text[at..at + 2], 16).unwrap());
        0.2126 * part(1) + 0.7152 * part(3) + 0.0722 * part(5)
    };
    let all: Vec<f64> = (0..=20).map(|k| light(f64::from(k) / 20.0)).collect();
    assert!(all.windows(2).all(|pair| pair[0] < pair[1]), "{all:?}");
}

#[test]
fn a_section_is_safe_and_bounded() {
    let mut scan = scan();
    let html = section(&scan).unwrap();
    assert!(
        !html.contains("<img") && !html.contains("{{") && !html.contains("NaN") && !html.contains("=\"inf"),
        "{html}"
    );
    assert_eq!(html.matches("<svg class=\"chart\"").count(), 3);
    assert_eq!(html.matches("<svg").count(), html.matches("</svg>").count());
    // It may be read back from what `scan -o` writes.
    let json = serde_json::to_string(&scan).unwrap();
    assert_eq!(serde_json::from_str::<Scan>(&json).unwrap(), scan);
    scan.positions[0].points[3].direction_deg = Some([90.0, 0.0]);
    assert!(section(&scan).unwrap_err().to_string().contains("column 3, row 0 is not ahead"));
    // Nothing seen is nothing drawn.
    for position in &mut scan.positions {
        position.ghosts.clear();
        for line in &mut position.points {
            (line.seen, line.direction_deg, line.vergence) = (false, None, None);
        }
    }
    assert_eq!(section(&scan).unwrap().matches("<svg").count(), 0);
    let point = scan.positions[0].points[0];
    scan.positions[0].points = vec![point; 20_000];
    assert!(section(&scan).unwrap_err().to_string().contains("at most 16384"));
    scan.positions.clear();
    assert!(section(&scan).unwrap_err().to_string().contains("no positions"));
}

#[test]
fn round_factors() {
    assert_eq!([0.3, 1.0, 1.9, 4.9, 70.0, 1e9, f64::INFINITY].map(round_down), [1.0, 1.0, 1.0, 2.0, 50.0, 1e9, 1.0]);
}
