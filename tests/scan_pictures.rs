//! What `eyebox scan` takes for the picture where the scene has no picture with sides of its own, how its points lie, and of which piece of
//! the view a luminance is: against the lamp's own sides and closed forms.

use crate::common::{add_group, add_part, face, lamp, mesh, quad, scene};
use eyebox::plan::scan::light::LightAsked;
use eyebox::plan::scan::{Scan, ScanAsked, scan};
use eyebox::plan::{Asked, Choice, Guides, Polarisation};
use eyebox::scene::{Angular, Emitter, Finish, Scene};
use glam::{DVec2, DVec3};

const PLAIN: Asked = Asked { choice: Choice::Auto, polarisation: Polarisation::Off, guides: Guides::On };

fn run(scene: &Scene, points: [usize; 2], light: Option<LightAsked>, x_m: f64) -> Scan {
    let asked = ScanAsked {
        positions: [2, 1],
        size_m: [Some(x_m), Some(0.0)],
        ipd_m: 0.06,
        points,
        target: None,
        light,
        edges: false,
    };
    scan(scene, &asked, &|| false, |_| {}).expect("the scene can be scanned").expect("nobody stopped it")
}

/// A lamp of 24 × 16 mm about `middle` with these sides (unit), which shines along their cross product.
fn lit(at: DVec3, [a, b]: [DVec3; 2]) -> Scene {
    let mut scene = scene();
    let group = add_group(&mut scene, "led");
    let mut shining = face(Finish::Absorber);
    shining.emitter = lamp(group, 1000.0);
    let panel = mesh(&[quad(DVec3::ZERO, 0.012 * a, 0.008 * b)]);
    add_part(&mut scene, "lamp", panel, at, None, vec![shining]);
    scene.eye.resolution = [24, 24];
    scene
}

/// Turned about the line of sight.
fn turned(turn_deg: f64) -> [DVec3; 2] {
    let [a, b] = [DVec2::X, DVec2::Y].map(|side| DVec2::from_angle(turn_deg.to_radians()).rotate(side).extend(0.0));
    [a, b]
}

/// The same in a mirror at 45°: the lamp lies face down 0.5 m above it.
fn in_a_mirror(turn_deg: f64) -> Scene {
    let [a, b] = turned(turn_deg).map(|side| DVec3::new(side.x, 0.0, side.y));
    let mut scene = lit(DVec3::new(0.0, 0.5, -0.3), [a, b]);
    let glass = mesh(&[quad(DVec3::ZERO, DVec3::X * 0.3, DVec3::new(0.0, -1.0, 1.0).normalize() * 0.3)]);
    let finish = Finish::MirrorIdeal { reflectance: 0.8 };
    add_part(&mut scene, "mirror", glass, DVec3::new(0.0, 0.0, -0.3), None, vec![face(finish)]);
    scene
}

/// A lamp is itself, seen whole, however it is turned; the width is what runs to the right.
#[test]
fn a_turned_lamp_is_seen_whole() {
    for turn in [0.0, 2.0, 20.0, 33.0, 44.0, 46.0, 70.0, 90.0, 137.0, -20.0] {
        for scene in [lit(DVec3::Z * -0.8, turned(turn)), in_a_mirror(turn)] {
            let found = run(&scene, [5, 5], None, 0.04);
            let level = turn.to_radians().cos().abs() > turn.to_radians().sin().abs();
            let want = if level { [0.024, 0.016] } else { [0.016, 0.024] };
            for (got, want) in found.picture_m.into_iter().zip(want) {
                assert!((got / want - 1.0).abs() < 1e-6, "{turn}°: {:?}", found.picture_m);
            }
            assert!(found.positions.iter().all(|position| position.seen == 1.0), "{turn}°");
        }
    }
}

/// Half of it behind a screen: as much as is seen is scanned, up to the rim where that is in sight.
#[test]
fn of_a_lamp_that_is_half_hidden_the_other_half_is_scanned() {
    let mut scene = lit(DVec3::Z * -0.8, turned(0.0));
    let screen = mesh(&[quad(DVec3::ZERO, DVec3::X * 0.2, DVec3::Y * 0.2)]);
    add_part(&mut scene, "screen", screen, DVec3::new(-0.2, 0.0, -0.4), None, vec![face(Finish::Absorber)]);
    let found = run(&scene, [5, 5], None, 1e-6);
    let [width, height] = found.picture_m;
    assert!((height / 0.016 - 1.0).abs() < 1e-6 && (width / 0.012 - 1.0).abs() < 0.05, "{:?}", found.picture_m);
    let [right, _] = found.positions[0].points[4].direction_deg.unwrap();
    // The outermost column, half a percent of the width inside.
    let want = ((0.012 - 0.005 * width) / 0.8).atan().to_degrees();
    assert!((right - want).abs() < 1e-4, "{right}° {want}°");
}

/// Nine columns and three rows of points: columns to the right and rows down as seen, however the lamp lies.
#[test]
fn columns_run_to_the_right_as_seen() {
    let tilted = |axis: DVec3, deg: f64| {
        let turn = glam::DQuat::from_axis_angle(axis, f64::to_radians(deg));
        lit(DVec3::Z * -0.8, [turn * DVec3::X, turn * DVec3::Y])
    };
    let upside_down = lit(DVec3::Z * -0.8, [-DVec3::X, -DVec3::Y]);
    for (what, scene) in [
        ("straight", tilted(DVec3::X, 0.0)),
        ("about the vertical", tilted(DVec3::Y, 30.0)),
        ("about the vertical, the other way", tilted(DVec3::Y, -30.0)),
        ("about the horizontal", tilted(DVec3::X, 30.0)),
        ("in a mirror", in_a_mirror(0.0)),
        ("turned", lit(DVec3::Z * -0.8, turned(20.0))),
        ("upside down", upside_down),
    ] {
        let found = run(&scene, [9, 3], None, 0.04);
        let [width, height] = found.picture_m;
        assert!((width / 0.024 - 1.0).abs() < 1e-6 && (height / 0.016 - 1.0).abs() < 1e-6, "{what}: {width} {height}");
        for position in &found.positions {
            let at = |cell: [usize; 2]| {
                let line = position.points.iter().find(|line| line.cell == cell).expect("a point");
                DVec2::from_array(line.direction_deg.expect("it is seen"))
            };
            assert_eq!(position.points.len(), 27);
            for row in 0..3 {
                for column in 0..8 {
                    let step = at([column + 1, row]) - at([column, row]);
                    assert!(step.x > step.y.abs(), "{what}, row {row}: {step}");
                }
            }
            for column in 0..9 {
                let step = at([column, 2]) - at([column, 0]);
                assert!(-step.y > step.x.abs(), "{what}, column {column}: {step}");
            }
        }
    }
}

/// A lamp whose luminance goes with cos²⁰, seen from aside: what is stated is the mean over just the patch that is stated, and within its
/// own error of what an integral over that has.
#[test]
fn a_luminance_is_of_just_its_patch() {
    let (power, away, aside) = (20.0, 0.5, 0.15);
    let mut scene = lit(DVec3::Z * -away, [DVec3::X, DVec3::Y]);
    let shining = scene.parts[0].faces[0].emitter.take().expect("it shines");
    scene.parts[0].faces[0].emitter = Some(Emitter { angular: Angular::CosN { n: power + 1.0 }, ..shining });
    for resolution in [[57, 57], [64, 48], [120, 80]] {
        let light = LightAsked { resolution, passes: 64, seed: 1, asked: PLAIN };
        let found = run(&scene, [5, 5], Some(light), 2.0 * aside);
        for position in &found.positions {
            let white = position.luminance.expect("it is seen");
            let half = (0.5 * white.patch_deg).to_radians().tan();
            // In tangents straight across; the lamp is square to the line of sight.
            let middle = DVec2::new(-position.x_m, 0.0) / away;
            let steps = 200;
            let at = |i: usize| half * ((2 * i + 1) as f64 / steps as f64 - 1.0);
            let cosine = |i: usize| {
                let tangents = middle + DVec2::new(at(i % steps), at(i / steps));
                (1.0 + tangents.length_squared()).sqrt().recip()
            };
            let want = 1000.0 * (0..steps * steps).map(|i| cosine(i).powf(power)).sum::<f64>() / (steps * steps) as f64;
            let centre = white.centre.expect("the middle is seen");
            let sigma = centre.sigma.expect("its error is known");
            println!("{resolution:?}: {} ± {sigma}, want {want}, {}°", centre.value, white.patch_deg);
            assert!(sigma < 1e-3 * want, "{sigma} of {want}");
            assert!((centre.value - want).abs() < 4.0 * sigma + 1e-5 * want, "{} ± {sigma}, want {want}", centre.value);
        }
    }
}
