//! The inside of a car in daylight: the sky shines through the glass of windshield and side windows on matt and rough parts,
//! and the eye of the driver looks at those.

use super::build::{frame, look, part, plate, polished};
use super::patch::Patch;
use super::{Dice, samples};
use crate::kit;
use eyebox_scene::{Face, Finish, Scene};
use glam::{DAffine3, DVec2, DVec3};

/// The driver's eye is the origin: walls at the left and right, floor and roof, front and rear, m.
const LOW: DVec3 = DVec3::new(-0.4, -1.0, -1.2);
const HIGH: DVec3 = DVec3::new(1.1, 0.25, 1.0);
/// Height of the sills, and where windshield and side windows end at the roof.
const SILL: f64 = -0.3;
const FRONT: f64 = -0.45;
const BACK: f64 = 0.45;
/// Panes lie so far outside and reach so far over their openings, m.
const OUTSIDE: f64 = 3e-3;
const OVER: f64 = 0.02;

pub(super) fn build(scene: &mut Scene, dice: &mut Dice) {
    shell(scene, dice);
    for (name, x, inwards) in [("LEFT", LOW.x, DVec3::X), ("RIGHT", HIGH.x, DVec3::NEG_X)] {
        side(scene, dice, (name, x, inwards));
    }
    let (low, high) = (DVec3::new(0.35, SILL, LOW.z), DVec3::new(0.35, HIGH.y, FRONT));
    let slope = high - low;
    let inwards = DVec3::X.cross(slope).normalize();
    // Seen from inside it is below and behind the glass.
    let inwards = if inwards.y > 0.0 { -inwards } else { inwards };
    let half = DVec2::new(0.5 * (HIGH.x - LOW.x), 0.5 * slope.length()) + DVec2::splat(OVER);
    pane(scene, dice, "WINDSHIELD", frame(0.5 * (low + high) - OUTSIDE * inwards, inwards), half);
    dashboard(scene, dice);
    seat(scene, dice);
    daylight(scene, dice);
    let to = DVec3::new(dice.within(-0.15, 0.6), dice.within(-0.55, -0.25), -0.72);
    look(scene, DVec3::ZERO, to);
    scene.eye.fov_deg = dice.within(45.0, 70.0);
    scene.eye.focus_distance_m = to.length();
}

/// A pane of two faces.
fn pane(scene: &mut Scene, dice: &mut Dice, name: &str, place: DAffine3, half: DVec2) {
    plate(scene, name, place, (half, dice.within(3e-3, 6e-3)), (polished(), 1.52));
}

/// A wall that faces the middle of the car.
fn wall(scene: &mut Scene, name: &str, corners: Vec<DVec3>, face: Face) {
    let patch = Patch::polygon(corners.clone());
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    let is_inwards = normal.dot(0.5 * (LOW + HIGH) - corners[0]) > 0.0;
    let patch = if is_inwards { patch } else { patch.flipped() };
    part(scene, name, DAffine3::IDENTITY, None, (vec![patch], vec![face]));
}

/// Floor, roof, rear and the wall under the windshield.
fn shell(scene: &mut Scene, dice: &mut Dice) {
    let level = |y: f64, z: f64| {
        [(LOW.x, z), (HIGH.x, z), (HIGH.x, HIGH.z), (LOW.x, HIGH.z)].map(|(x, z)| DVec3::new(x, y, z)).to_vec()
    };
    let upright = |z: f64, top: f64| {
        [(LOW.x, LOW.y), (HIGH.x, LOW.y), (HIGH.x, top), (LOW.x, top)].map(|(x, y)| DVec3::new(x, y, z)).to_vec()
    };
    let walls = [
        ("FLOOR", level(LOW.y, LOW.z)),
        ("ROOF", level(HIGH.y, FRONT)),
        ("REAR", upright(HIGH.z, HIGH.y)),
        ("FIREWALL", upright(LOW.z, SILL)),
    ];
    for (name, corners) in walls {
        let face = samples::matt(dice);
        wall(scene, name, corners, face);
    }
}

/// A door, pillars, and the window between them; it may be closed by a blind.
fn side(scene: &mut Scene, dice: &mut Dice, (name, x, inwards): (&str, f64, DVec3)) {
    let face = samples::matt(dice);
    let at = |points: &[[f64; 2]]| points.iter().map(|[z, y]| DVec3::new(x, *y, *z)).collect::<Vec<_>>();
    let mut panels = vec![
        ("DOOR", at(&[[LOW.z, LOW.y], [HIGH.z, LOW.y], [HIGH.z, SILL], [LOW.z, SILL]])),
        ("A_PILLAR", at(&[[LOW.z, SILL], [FRONT, SILL], [FRONT, HIGH.y]])),
        ("C_PILLAR", at(&[[BACK, SILL], [HIGH.z, SILL], [HIGH.z, HIGH.y], [BACK, HIGH.y]])),
    ];
    let is_open = dice.whole(0, 3) > 0;
    if !is_open {
        panels.push(("BLIND", at(&[[FRONT, SILL], [BACK, SILL], [BACK, HIGH.y], [FRONT, HIGH.y]])));
    }
    for (panel, corners) in panels {
        wall(scene, &format!("{name}_{panel}"), corners, face.clone());
    }
    if is_open {
        let middle = DVec3::new(x, 0.5 * (SILL + HIGH.y), 0.5 * (FRONT + BACK)) - OUTSIDE * inwards;
        // Its frame has x along the world's y.
        let half = DVec2::new(0.5 * (HIGH.y - SILL), 0.5 * (BACK - FRONT)) + DVec2::splat(OVER);
        pane(scene, dice, &format!("{name}_WINDOW"), frame(middle, inwards), half);
    }
}

/// A closed box.
fn block(scene: &mut Scene, name: &str, centre: DVec3, half: DVec3, face: &Face) {
    let sides: Vec<Patch> = kit::cuboid(half).into_iter().map(Patch::polygon).collect();
    let faces = vec![face.clone(); sides.len()];
    part(scene, name, DAffine3::from_translation(centre), None, (sides, faces));
}

/// Something that shines dully.
fn rough(dice: &mut Dice) -> Face {
    let reflectance = dice.within(0.1, 0.6);
    kit::face(if dice.coin() {
        Finish::Gauss { sigma_deg: dice.within(3.0, 20.0), reflectance, transmittance: 0.0 }
    } else {
        Finish::CosM { m: dice.within(20.0, 500.0), reflectance, transmittance: 0.0 }
    })
}

/// A matt dashboard with a rough trim, an instrument behind a rough pane, and the wheel.
fn dashboard(scene: &mut Scene, dice: &mut Dice) {
    let board = kit::face(Finish::Lambert { reflectance: dice.within(0.04, 0.3), transmittance: 0.0 });
    block(scene, "DASHBOARD", DVec3::new(0.35, -0.46, -0.955), DVec3::new(0.74, 0.14, 0.235), &board);
    let trim = DAffine3::from_translation(DVec3::new(0.55, dice.within(-0.5, -0.38), -0.715));
    let face = rough(dice);
    part(scene, "TRIM", trim, None, (vec![Patch::flat(DVec2::new(0.35, 0.03))], vec![face]));

    let dial = DVec3::new(0.0, -0.44, -0.714);
    let face = samples::matt(dice);
    let half = DVec2::new(0.12, 0.06);
    part(scene, "DIAL", DAffine3::from_translation(dial), None, (vec![Patch::flat(half)], vec![face]));
    let front = kit::face(Finish::Rough { alpha: dice.within(0.03, 0.3) });
    let cover = DAffine3::from_translation(dial + DVec3::Z * dice.within(8e-3, 0.02));
    plate(scene, "DIAL_COVER", cover, (half, 2e-3), (front, 1.49));

    let place =
        DAffine3::from_translation(DVec3::new(0.0, -0.38, -0.5)) * DAffine3::from_rotation_x(dice.within(-0.5, -0.3));
    let face = if dice.coin() { rough(dice) } else { samples::matt(dice) };
    part(scene, "STEERING_WHEEL", place, None, (vec![Patch::ring([0.18, 0.015], [48, 16])], vec![face]));
}

fn seat(scene: &mut Scene, dice: &mut Dice) {
    let face = samples::matt(dice);
    block(scene, "SEAT", DVec3::new(0.7, -0.75, 0.0), DVec3::new(0.25, 0.2, 0.25), &face);
    block(scene, "BACKREST", DVec3::new(0.7, -0.2, 0.32), DVec3::new(0.23, 0.33, 0.06), &face);
}

/// A sky over a darker ground, with a bright patch about the sun.
fn daylight(scene: &mut Scene, dice: &mut Dice) {
    let (width, height) = (64usize, 32usize);
    let (zenith, horizon, ground) = (dice.within(2e3, 6e3), dice.within(3e3, 1.2e4), dice.within(300.0, 2e3));
    let [sun_x, sun_y] = [dice.whole(0, 63) as usize, dice.whole(2, 13) as usize];
    let (sun, size) = (dice.within(3e4, 1e6), dice.whole(1, 2) as usize);
    let luminance = (0..width * height).map(|i| {
        let (x, y) = (i % width, i / width);
        let is_sun = (sun_x..sun_x + size).contains(&x) && (sun_y..sun_y + size).contains(&y);
        let up = 1.0 - (y as f64 + 0.5) / (0.5 * height as f64);
        let sky = if up > 0.0 { horizon + (zenith - horizon) * up } else { ground };
        (if is_sun { sun } else { sky }) as f32
    });
    kit::sky(scene, width, height, luminance.collect());
}
