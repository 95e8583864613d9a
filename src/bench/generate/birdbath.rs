//! Birdbath glasses: a display above sends its light down onto a beam splitter at 45°, from there to a concave half mirror
//! and back through the splitter into the eye, which sees the world through both.

use super::build::{black, coated, frame, look, panel, part, partial, plate};
use super::patch::Patch;
use super::{Dice, samples};
use crate::bench::kit;
use crate::scene::{Face, Finish, Scene, Shape};
use glam::{DAffine3, DVec2, DVec3};

pub(super) fn build(scene: &mut Scene, dice: &mut Dice) {
    let (focal, image) = (dice.within(0.026, 0.036), dice.within(1.0, 10.0));
    // Eye to splitter, splitter to mirror.
    let (relief, arm) = (dice.within(0.02, 0.026), dice.within(0.015, 0.018));
    let half = DVec2::new(4.0, 3.0) * dice.within(1e-3, 1.6e-3);
    let tangent = half.x / focal;

    // The mirror shows the display at `image` from the eye: 1/g + 1/b = 1/f.
    let object = 1.0 / (1.0 / focal + 1.0 / (image + relief + arm));
    let splitter = DVec3::Z * -relief;
    let above = frame(splitter + DVec3::Y * (object - arm), DVec3::NEG_Y);
    let cells = [dice.whole(2, 6) as usize, dice.whole(2, 4) as usize];
    panel(scene, dice, above, half, cells);

    let share = dice.within(0.4, 0.55);
    let coating = partial(scene, "splitter", share, 0.98 - share);
    let tilted = frame(splitter, DVec3::new(0.0, 1.0, -1.0).normalize());
    let size = DVec2::new(0.015, 0.0125);
    plate(scene, "BEAM_SPLITTER", tilted, (size, dice.within(3e-4, 1e-3)), (coated(Some(coating)), 1.5168));
    half_mirror(scene, dice, splitter - DVec3::Z * arm, 2.0 * focal);

    // The eye sees what is below mirrored in the splitter: something black, something matt, or the world.
    let cheek = match dice.whole(0, 2) {
        0 => Some(black()),
        1 => Some(samples::matt(dice)),
        _ => None,
    };
    if let Some(face) = cheek {
        let below = frame(splitter - DVec3::Y * 0.025, DVec3::Y);
        part(scene, "COVER", below, None, (vec![Patch::flat(DVec2::splat(0.015))], vec![face]));
    }
    samples::sky(scene, dice);
    let eye = DVec3::new(dice.within(-3e-3, 3e-3), dice.within(-2e-3, 2e-3), 0.0);
    look(scene, eye, DVec3::Z * -image);
    scene.eye.fov_deg = 2.0 * (0.95 * tangent).atan().to_degrees();
    scene.eye.focus_distance_m = image;
}

/// A meniscus about one centre, which bends what passes through but little; its hollow side is coated. Exact or as a fine
/// mesh with its normals.
fn half_mirror(scene: &mut Scene, dice: &mut Dice, vertex: DVec3, radius: f64) {
    let thickness = dice.within(8e-4, 2e-3);
    let share = dice.within(0.3, 0.6);
    let coating = partial(scene, "half mirror", share, 0.97 - share);
    let ball = |p: DVec2, radius: f64| {
        let root = (radius * radius - p.length_squared()).sqrt();
        (p.length_squared() / (radius + root), p / root)
    };
    let (half, steps) = (DVec2::new(0.015, 0.0125), [64, 64]);
    let down = DAffine3::from_translation(DVec3::Z * -thickness);
    let front = Patch::over(half, steps, |p| ball(p, radius));
    let back = Patch::over(half, steps, |p| ball(p, radius + thickness)).moved(down);
    let is_exact = dice.coin();
    let shape = |z: f64, radius: f64| {
        let exact = Shape::Sphere { vertex: DVec3::Z * z, axis: DVec3::Z, radius };
        if is_exact { exact } else { Shape::Mesh }
    };
    let faces = vec![
        Face { shape: shape(0.0, radius), ..coated(Some(coating)) },
        Face { shape: shape(-thickness, radius + thickness), ..kit::face(Finish::Polished) },
        black(),
    ];
    let place = DAffine3::from_translation(vertex);
    part(scene, "HALF_MIRROR", place, Some(1.53), (Patch::body(front, back, steps), faces));
}
