//! A light guide with embedded partial mirrors: a collimated display shines into a slab of glass, whose slanted end mirrors
//! the light into total reflection; a row of partial mirrors inside turns it towards the eye, which sees the world through
//! them.

use super::build::{black, coated, frame, look, panel, part, partial, polished};
use super::patch::Patch;
use super::{Dice, samples};
use crate::bench::kit;
use crate::scene::{Finish, Scene};
use glam::{DAffine3, DMat3, DVec2, DVec3};

pub(super) fn build(scene: &mut Scene, dice: &mut Dice) {
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
    (half_height, index, coating): (f64, f64, crate::base::ids::CoatingId),
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
