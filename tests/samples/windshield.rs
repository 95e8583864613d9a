//! `samples/windshield` against an independent tracer of the same design (`tests/data/windshield.csv` says which): directions,
//! distances, the ghost of the windshield's outer face, luminances.

use super::{as_brute_force, bright, sample, scanned};

/// A line of the table; lengths in mm, directions in degrees.
struct Reference {
    eye: [f64; 2],
    point: [f64; 2],
    direction_deg: [f64; 2],
    per_m: [f64; 2],
    ghost_arcmin: [f64; 2],
    ghost_ratio: f64,
    luminance: f64,
}

fn table() -> Vec<Reference> {
    let lines = include_str!("../data/windshield.csv").lines().filter(|line| !line.starts_with('#')).skip(1);
    lines
        .map(|line| {
            let v: Vec<f64> = line.split(',').map(|cell| cell.parse().expect("a number")).collect();
            Reference {
                eye: [v[0], v[1]],
                point: [v[2], v[3]],
                direction_deg: [v[4], v[5]],
                per_m: [v[6], v[7]],
                ghost_arcmin: [v[8], v[9]],
                ghost_ratio: v[10],
                luminance: v[11],
            }
        })
        .collect()
}

#[test]
fn the_virtual_image_is_where_an_independent_tracer_has_it() {
    let found = scanned(&sample("windshield", &[]), [3, 3], [0.12, 0.05], None);
    let table = table();
    assert_eq!(table.len(), 36);
    for want in &table {
        let at = |x: f64, y: f64| (1e3 * x - want.eye[0]).abs() < 1e-9 && (1e3 * y - want.eye[1]).abs() < 1e-9;
        let position = found.positions.iter().find(|position| at(position.x_m, position.y_m)).expect("a corner");
        let here = |cell: [usize; 2]| {
            let [x, y] = super::place(cell);
            (60.0 * x - want.point[0]).abs() < 1e-9 && (20.0 * y - want.point[1]).abs() < 1e-9
        };
        let line = position.points.iter().find(|line| here(line.cell)).expect("a point of the grid");
        assert!(line.seen, "{:?} {:?}", want.eye, want.point);
        let (dir, vergence) = (line.direction_deg.unwrap(), line.vergence.unwrap());
        let ghost = position.ghosts[0].points.iter().find(|point| point.cell == line.cell).expect("its ghost");
        for (got, want) in dir.into_iter().zip(want.direction_deg) {
            let off = 60.0 * (got - want);
            assert!(off.abs() < 1e-4, "{got}°, want {want}°: {off}′");
        }
        for (got, want) in ghost.separation_arcmin.into_iter().zip(want.ghost_arcmin) {
            assert!((got - want).abs() < 1e-3, "ghost {got}′ away, want {want}′");
        }
        for (got, want) in [vergence.horizontal_per_m, vergence.vertical_per_m].into_iter().zip(want.per_m) {
            assert!((got - want).abs() < 1e-6, "{got} 1/m, want {want}");
        }
        assert!((ghost.ratio / want.ghost_ratio - 1.0).abs() < 1e-5, "{} {}", ghost.ratio, want.ghost_ratio);
    }
    let middle = table.iter().find(|line| line.eye == [0.0; 2] && line.point == [0.0; 2]).expect("the middle");
    assert!((middle.ghost_arcmin[1] - 7.346).abs() < 1e-3 && (middle.ghost_ratio - 0.664).abs() < 1e-3);
}

#[test]
fn its_middle_is_as_bright_as_fresnel_says() {
    let want =
        table().iter().find(|line| line.eye == [0.0; 2] && line.point == [0.0; 2]).expect("the middle").luminance;
    let found = scanned(&sample("windshield", &[]), [1, 1], [0.0, 0.0], Some(16));
    bright("windshield", found.positions[0].luminance.expect("a picture").centre, want);
}

#[test]
fn as_planned_it_is_what_plain_paths_see() {
    as_brute_force("windshield", &[], [8, 64]);
}
