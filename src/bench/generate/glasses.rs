//! Glasses that show a display before the world: a birdbath, and a light guide with embedded partial mirrors.

use super::build::{black, coated, frame, look, panel, part, partial, plate, polished};
use super::patch::Patch;
use super::{Dice, GLASS, samples};
use crate::kit;
use eyebox_base::ids::CoatingId;
use eyebox_scene::{Face, Finish, Scene, Shape};
use glam::{DAffine3, DMat3, DVec2, DVec3};

/// The display shines down onto a beam splitter at 45°, from there to a concave half mirror and back through the splitter
/// into the eye.
pub(super) fn birdbath(scene: &mut Scene, dice: &mut Dice) {
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
    plate(scene, "BEAM_SPLITTER", tilted, (size, dice.within(3e-4, 1e-3)), (coated(Some(coating)), GLASS));
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

/// A collimated display shines into a slab of glass, whose slanted end mirrors the light into total reflection; a row of
/// partial mirrors inside turns it towards the eye.
pub(super) fn light_guide(scene: &mut Scene, dice: &mut Dice) {
    let (relief, thickness) = (dice.within(0.018, 0.024), dice.within(1.6e-3, 2.8e-3));
    let index = dice.within(1.5, 1.7);
    // Mirrors are inclined by half of the angle to which they turn the light.
    let incline = dice.within(26.0, 30.5).to_radians();
    let run = thickness / incline.tan();
    let count = dice.whole(3, 6);
    let pitch = run * dice.within(0.9, 1.15);
    let half_height = dice.within(7e-3, 9e-3);
    let entrance = -dice.within(0.026, 0.034);
    let last = pitch * 0.5 * (count - 1) as f64;
    let start = entrance - 0.5 * run;
    let place = DAffine3::from_translation(DVec3::Z * -relief);

    // x and z: far face, end, face towards the eye, slanted end.
    let outline = [
        DVec2::new(start + run, -thickness),
        DVec2::new(last + run + 8e-3, -thickness),
        DVec2::new(last + run + 8e-3, 0.0),
        DVec2::new(start, 0.0),
    ];
    let mirror = kit::face(Finish::MirrorIdeal { reflectance: dice.within(0.85, 0.98) });
    let faces = vec![polished(), black(), polished(), mirror, black(), black()];
    part(scene, "LIGHT_GUIDE", place, Some(index), (Patch::bar(&outline, half_height), faces));

    let share = dice.within(0.1, 0.3);
    for i in 0..count {
        // What is left grows less, so that later mirrors take more of it.
        let reflectance = (share * (1.0 + 0.3 * i as f64)).min(0.5);
        let name = format!("partial{}", i + 1);
        let coating = partial(scene, &name, reflectance, 0.99 - reflectance);
        let x = pitch * i as f64 - last;
        partial_mirror(scene, &name.to_uppercase(), place, (x, thickness, incline), (half_height, index, coating));
    }

    // The eye is at the height of the slab's middle, the display beside it.
    let focal = dice.within(0.017, 0.024);
    let lens = DVec3::new(entrance, 0.0, -relief + 3e-3);
    samples::lens_at(scene, DAffine3::from_translation(lens), focal, 5e-3);
    let display = frame(lens + DVec3::Z * focal * dice.within(0.97, 1.0), DVec3::NEG_Z);
    let half = DVec2::new(4.0, 3.0) * dice.within(4e-4, 7e-4);
    let cells = [dice.whole(2, 6) as usize, dice.whole(2, 4) as usize];
    panel(scene, dice, display, half, cells);
    if dice.coin() {
        samples::sky(scene, dice);
    }
    let eye = DVec3::new(dice.within(-2e-3, 2e-3), dice.within(-2e-3, 2e-3), 0.0);
    look(scene, eye, eye - DVec3::Z);
    scene.eye.fov_deg = 2.0 * (0.95 * half.x / focal).atan().to_degrees();
}

/// A thin plate of the guide's own glass, which wins over it where both are; one face is coated.
fn partial_mirror(
    scene: &mut Scene,
    name: &str,
    guide: DAffine3,
    (x, thickness, incline): (f64, f64, f64),
    (half_height, index, coating): (f64, f64, CoatingId),
) {
    const THIN: f64 = 2e-5;
    let (sin, cos) = incline.sin_cos();
    let axes = DMat3::from_cols(DVec3::new(cos, 0.0, sin), DVec3::Y, DVec3::new(-sin, 0.0, cos));
    let middle = DVec3::new(x, 0.0, -0.5 * thickness);
    let place = guide * DAffine3 { matrix3: axes, translation: middle };
    // It ends inside of the guide.
    let half = DVec2::new(0.49 * thickness / sin, 0.98 * half_height);
    let back = Patch::flat(half).moved(DAffine3::from_translation(DVec3::Z * -THIN));
    let patches = Patch::body(Patch::flat(half), back, [1, 1]);
    part(scene, name, place, Some(index), (patches, vec![coated(Some(coating)), polished(), polished()]));
    if let Some(part) = scene.parts.last_mut() {
        part.priority = 1;
    }
}
