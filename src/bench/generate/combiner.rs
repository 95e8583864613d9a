//! A head-up display with a concave mirror and a plane combiner: slide → mirror → partly reflecting plate → eye.

use super::build::{backlight, black, coated, frame, lcd, look, part, partial, plate, tube};
use super::patch::{Freeform, Patch};
use super::train::{Radii, Train};
use super::{Dice, samples};
use crate::kit;
use eyebox_scene::{Face, Finish, Scene, Shape};
use glam::{DAffine3, DVec2, DVec3};

/// Half of the eyebox, m.
const EYEBOX: DVec2 = DVec2::new(0.03, 0.015);
/// Pixels of the slide.
const PIXELS: [usize; 2] = [12, 9];

pub(super) fn build(scene: &mut Scene, dice: &mut Dice) {
    let image = dice.within(1.2, 3.0);
    let mut train = Train::new(DVec3::ZERO, DVec3::NEG_Z);
    let half_width = dice.within(0.012, 0.018);
    let half = DVec2::new(half_width, half_width * PIXELS[1] as f64 / PIXELS[0] as f64);

    train.travel(dice.within(0.35, 0.55));
    let tilt = dice.within(42.0, 50.0).to_radians();
    let on_plate = [train.sagittal, train.tangential];
    let plate_at = train.reflect(tilt, Radii::FLAT);
    train.travel(dice.within(0.14, 0.2));
    let turn = dice.within(15.0, 20.0).to_radians();
    let to_lcd = dice.within(0.1, 0.14);
    let on_mirror = [train.sagittal, train.tangential];
    let radii = train.radii(turn, image, to_lcd);
    let mirror_at = train.reflect(turn, radii);
    train.travel(to_lcd);

    let slope = half / DVec2::new(train.sagittal.per_slope(), train.tangential.per_slope()).abs();
    let reach = |[x, y]: [super::train::Pencil; 2], cos: f64| {
        DVec2::new(x.reach(EYEBOX.x, slope.x), y.reach(EYEBOX.y, slope.y) / cos) * 1.1
    };

    let reflectance = dice.within(0.15, 0.4);
    let coating = partial(scene, "combiner", reflectance, 0.97 - reflectance);
    let thickness = dice.within(1e-3, 3e-3);
    let size = reach(on_plate, tilt.cos()) + DVec2::splat(0.01);
    plate(scene, "COMBINER", plate_at, (size, thickness), (coated(Some(coating)), 1.52));
    mirror(scene, dice, mirror_at, (reach(on_mirror, turn.cos()), radii));

    let display = frame(train.at, -train.dir);
    lcd(scene, dice, "LCD", display, (half_width, PIXELS, 0.008));
    if dice.coin() {
        let gap = dice.within(5e-4, 4e-3);
        backlight(scene, dice, display, half + DVec2::splat(1e-3), gap);
    } else {
        leds_and_diffuser(scene, dice, display, half);
    }
    if dice.coin() {
        samples::sky(scene, dice);
    }
    let eye = DVec2::new(dice.within(-EYEBOX.x, EYEBOX.x), dice.within(-EYEBOX.y, EYEBOX.y));
    look(scene, eye.extend(0.0), DVec3::Z * -image);
    scene.eye.fov_deg = 2.0 * (0.9 * slope.x).atan().to_degrees();
    scene.eye.focus_distance_m = image;
}

/// Hollow, a conic; or a mirror of two radii, which leaves no astigmatism on its axis.
fn mirror(scene: &mut Scene, dice: &mut Dice, place: DAffine3, (half, radii): (DVec2, Radii)) {
    let [x, y] = [1.0 / radii.x, 1.0 / radii.y];
    let mean = 0.5 * (x + y);
    let toric = vec![0.0, 0.0, 0.0, 0.5 * (x - mean), 0.0, 0.5 * (y - mean)];
    let coeffs = if dice.coin() { toric } else { Vec::new() };
    let surface = Freeform { radius: 1.0 / mean, conic: dice.within(-1.2, 0.0), coeffs };
    let shape = if dice.coin() { surface.shape() } else { Shape::Mesh };
    let finish = Finish::MirrorIdeal { reflectance: dice.within(0.85, 0.98) };
    let patch = Patch::over(half, [96, 96], |p| surface.height(p));
    part(scene, "CONCAVE_MIRROR", place, None, (vec![patch], vec![Face { shape, ..kit::face(finish) }]));
}

/// LEDs in a black tube, and a diffuser right behind the slide.
fn leds_and_diffuser(scene: &mut Scene, dice: &mut Dice, display: DAffine3, half: DVec2) {
    let depth = dice.within(0.012, 0.03);
    let back = display.transform_point3(DVec3::Z * -depth);
    let pitch = 0.3 * half.x * dice.within(0.6, 1.0);
    let across = [DVec3::X, DVec3::Y].map(|dir| display.transform_vector3(dir));
    samples::leds(scene, dice, back, across, pitch);
    let finish = if dice.coin() {
        Finish::Gauss { sigma_deg: dice.within(8.0, 25.0), reflectance: 0.05, transmittance: 0.8 }
    } else {
        Finish::Lambert { reflectance: 0.1, transmittance: 0.7 }
    };
    let gap = dice.within(5e-4, 2e-3);
    let behind = display * DAffine3::from_translation(DVec3::Z * -gap);
    let wide = half + DVec2::splat(1e-3);
    part(scene, "DIFFUSER", behind, None, (vec![Patch::flat(wide)], vec![kit::face(finish)]));
    // LEDs in a square may be wider than the slide.
    let hull = DVec2::splat(half.max_element().max(4.0 * pitch)) + DVec2::splat(2e-3);
    tube(scene, "HOUSING", display, hull, depth + 1e-3);
    let lid = display * DAffine3::from_translation(DVec3::Z * -(depth + 1e-3));
    part(scene, "HOUSING_BACK", lid, None, (vec![Patch::flat(hull)], vec![black()]));
}
