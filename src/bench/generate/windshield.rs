//! A windshield head-up display: backlit slide → flat fold mirror → freeform mirror → curved glass → eye.

use super::build::{backlight, black, frame, lcd, look, part};
use super::patch::{Freeform, Patch, Toroid};
use super::train::{Pencil, Radii, Train};
use super::{Dice, samples};
use crate::kit;
use eyebox_scene::{Face, Finish, Scene, Shape};
use glam::{DAffine3, DVec2, DVec3};

/// Half of the eyebox, m.
const EYEBOX: DVec2 = DVec2::new(0.06, 0.025);
/// Pixels of the slide.
const PIXELS: [usize; 2] = [24, 8];

/// Where the axis meets a part.
struct Stop {
    place: DAffine3,
    /// What is needed of it, half.
    half: DVec2,
}

/// Half of what light from all over the eyebox with these slopes takes, on a part at right angles to it.
fn reach([x, y]: [Pencil; 2], slope: DVec2) -> DVec2 {
    DVec2::new(x.reach(EYEBOX.x, slope.x), y.reach(EYEBOX.y, slope.y))
}

pub(super) fn build(scene: &mut Scene, dice: &mut Dice) {
    let image = dice.within(2.2, 8.0);
    let down = dice.within(3.0, 6.0).to_radians();
    let mut train = Train::new(DVec3::ZERO, DVec3::new(0.0, -down.sin(), -down.cos()));
    let (axis, up) = (train.dir, DVec3::X.cross(train.dir));
    let mut stops = Vec::new();
    let mut stop = |train: &mut Train, turn: f64, radii: Radii| {
        let pencils = [train.sagittal, train.tangential];
        stops.push((train.reflect(turn, radii), pencils, turn.cos()));
    };

    train.travel(dice.within(0.7, 0.9));
    let inner = Toroid { radius: dice.within(5.0, 8.0), tube_radius: dice.within(2.0, 3.5) };
    let turn = dice.within(56.0, 62.0).to_radians();
    stop(&mut train, turn, Radii { x: inner.tube_radius, y: inner.radius });

    train.travel(dice.within(0.27, 0.33));
    let turn = dice.within(16.0, 20.0).to_radians();
    let (to_fold, to_lcd) = (dice.within(0.12, 0.15), dice.within(0.06, 0.08));
    let radii = train.radii(turn, image, to_fold + to_lcd);
    stop(&mut train, turn, radii);

    train.travel(to_fold);
    // The other way round: down into the dashboard.
    stop(&mut train, -dice.within(28.0, 32.0).to_radians(), Radii::FLAT);
    train.travel(to_lcd);

    let half_width = dice.within(0.02, 0.032);
    let half = DVec2::new(half_width, half_width * PIXELS[1] as f64 / PIXELS[0] as f64);
    let slope = half / DVec2::new(train.sagittal.per_slope(), train.tangential.per_slope()).abs();
    let stops: Vec<Stop> = stops
        .into_iter()
        .map(|(place, pencils, cos)| Stop { place, half: reach(pencils, slope) / DVec2::new(1.0, cos) * 1.1 })
        .collect();
    let [glass, mirror, fold] = stops.as_slice() else { return };

    windshield(scene, dice, glass, inner);
    freeform(scene, dice, mirror, radii);
    let flat = Finish::MirrorIdeal { reflectance: dice.within(0.85, 0.98) };
    part(scene, "FOLD_MIRROR", fold.place, None, (vec![Patch::flat(fold.half)], vec![kit::face(flat)]));

    let tilt = DAffine3::from_rotation_x(dice.within(-0.1, 0.1));
    let display = frame(train.at, -train.dir) * tilt;
    lcd(scene, dice, "LCD", display, (half_width, PIXELS, 0.01));
    let gap = dice.within(5e-4, 4e-3);
    backlight(scene, dice, display, half + DVec2::splat(1e-3), gap);
    world(scene, dice);

    let eye = DVec3::X * dice.within(-EYEBOX.x, EYEBOX.x) + up * dice.within(-EYEBOX.y, EYEBOX.y);
    look(scene, eye, axis * image);
    scene.eye.resolution = [48, 16];
    scene.eye.fov_deg = 2.0 * (0.9 * slope.x).atan().to_degrees();
    scene.eye.focus_distance_m = image;
}

/// Glass between two toroids, the outer one turned by the wedge.
fn windshield(scene: &mut Scene, dice: &mut Dice, stop: &Stop, inner: Toroid) {
    let thickness = dice.within(3.5e-3, 6e-3);
    let wedge = if dice.coin() { dice.within(-8e-4, 8e-4) } else { 0.0 };
    let outer = Toroid { radius: inner.radius + thickness, tube_radius: inner.tube_radius + thickness };
    let behind = DAffine3::from_translation(DVec3::Z * -thickness) * DAffine3::from_rotation_x(wedge);
    // There is more of it than the light needs.
    let (half, steps) = (stop.half + DVec2::splat(0.05), [24, 24]);
    let front = Patch::over(half, steps, |p| inner.height(p));
    let back = Patch::over(half, steps, |p| outer.height(p)).moved(behind);
    let faces = vec![kit::polished(inner.shape(DAffine3::IDENTITY)), kit::polished(outer.shape(behind)), black()];
    part(scene, "WINDSHIELD", stop.place, Some(1.52), (Patch::body(front, back, steps), faces));
}

/// A mirror of these radii with third and fourth orders, exact or as a fine mesh with its normals.
fn freeform(scene: &mut Scene, dice: &mut Dice, stop: &Stop, radii: Radii) {
    let [x, y] = [1.0 / radii.x, 1.0 / radii.y];
    let mean = 0.5 * (x + y);
    let third = [dice.within(-0.15, 0.15), dice.within(-0.4, 0.4)];
    let fourth = [dice.within(-0.5, 0.5), dice.within(-1.0, 1.0), dice.within(-0.5, 0.5)];
    let second = [0.5 * (x - mean), 0.5 * (y - mean)];
    let surface = Freeform {
        radius: 1.0 / mean,
        conic: dice.within(-1.0, 0.2),
        // 1, x, y, x², xy, y², x³, x²y, xy², y³, x⁴, …: symmetric about x = 0.
        coeffs: vec![
            0.0, 0.0, 0.0, second[0], 0.0, second[1], 0.0, third[0], 0.0, third[1], fourth[0], 0.0, fourth[1], 0.0,
            fourth[2],
        ],
    };
    let shape = if dice.coin() { surface.shape() } else { Shape::Mesh };
    let finish = Finish::MirrorIdeal { reflectance: dice.within(0.85, 0.98) };
    let patch = Patch::over(stop.half, [96, 48], |p| surface.height(p));
    part(scene, "FREEFORM_MIRROR", stop.place, None, (vec![patch], vec![Face { shape, ..kit::face(finish) }]));
}

/// What is beyond the glass: nothing, a sky, or a sky over a bonnet.
fn world(scene: &mut Scene, dice: &mut Dice) {
    let which = dice.whole(0, 2);
    if which > 0 {
        samples::sky(scene, dice);
    }
    if which > 1 {
        let bonnet = frame(DVec3::new(0.0, -0.3, -2.2), DVec3::Y);
        let face = samples::matt(dice);
        part(scene, "BONNET", bonnet, None, (vec![Patch::flat(DVec2::new(0.7, 0.6))], vec![face]));
    }
}
