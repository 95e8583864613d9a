//! Displays of several layers: microlenses before emitters or a diffuser, and two slides in a row.

use super::build::{backlight, black, frame_around, lcd, look, panel, part, polished, tube};
use super::patch::{Freeform, Patch};
use super::{Dice, GLASS, samples};
use crate::kit;
use eyebox_scene::{Face, Finish, Scene, Shape};
use glam::{DAffine3, DVec2, DVec3};

/// Meshes of each lens.
const STEPS: usize = 8;

/// An array of microlenses before a display that shines by itself, or before LEDs behind a diffuser.
pub(super) fn microlenses(scene: &mut Scene, dice: &mut Dice) {
    let count = [dice.whole(3, 8) as usize, dice.whole(3, 6) as usize];
    let pitch = dice.within(1e-3, 3e-3);
    let radius = pitch * dice.within(0.9, 2.5);
    let focal = radius / (GLASS - 1.0);
    let thickness = 0.4 * focal;
    let half = 0.5 * pitch * DVec2::new(count[0] as f64, count[1] as f64);
    let place = DAffine3::from_translation(DVec3::Z * -dice.within(0.1, 0.3));
    array(scene, place, count, (pitch, radius, thickness));

    let base = place * DAffine3::from_translation(DVec3::Z * -thickness);
    frame_around(scene, "ARRAY_FRAME", base, half, 0.01);
    // Of the way to the focus of a lens that is flat behind.
    let gap = (focal - thickness / GLASS) * dice.within(0.4, 1.1);
    let depth = if dice.coin() {
        let display = base * DAffine3::from_translation(DVec3::Z * -gap);
        let cells = [dice.whole(3, 9) as usize, dice.whole(3, 6) as usize];
        panel(scene, dice, display, half, cells);
        gap
    } else {
        let sigma_deg = dice.within(5.0, 25.0);
        let finish = if dice.coin() {
            Finish::Gauss { sigma_deg, reflectance: 0.05, transmittance: 0.8 }
        } else {
            Finish::Lambert { reflectance: 0.1, transmittance: 0.7 }
        };
        let sheet = base * DAffine3::from_translation(DVec3::Z * -gap);
        part(scene, "DIFFUSER", sheet, None, (vec![Patch::flat(half)], vec![kit::face(finish)]));
        let back = sheet.translation - DVec3::Z * dice.within(4e-3, 0.015);
        let step = dice.within(0.2, 0.3) * half.min_element();
        samples::leds(scene, dice, back, [DVec3::X, DVec3::Y], step);
        base.translation.z - back.z
    };
    tube(scene, "HOUSING", base, half, depth + 1e-3);

    let eye = DVec3::new(dice.within(-0.02, 0.02), dice.within(-0.02, 0.02), 0.0);
    look(scene, eye, place.translation);
    let distance = (place.translation - eye).length();
    scene.eye.fov_deg = 2.0 * (1.05 * half.x / distance).atan().to_degrees();
    scene.eye.focus_distance_m = distance;
}

/// Plano-convex lenses of one plate, side by side without gaps, their vertices in the plane z = 0.
fn array(scene: &mut Scene, place: DAffine3, [nx, ny]: [usize; 2], (pitch, radius, thickness): (f64, f64, f64)) {
    let lens = Freeform { radius: -radius, conic: 0.0, coeffs: Vec::new() };
    let half = 0.5 * pitch * DVec2::new(nx as f64, ny as f64);
    let (mut patches, mut faces) = (Vec::new(), Vec::new());
    for i in 0..nx * ny {
        let centre = pitch * DVec2::new((i % nx) as f64 + 0.5, (i / nx) as f64 + 0.5) - half;
        let vertex = centre.extend(0.0);
        let patch = Patch::over(DVec2::splat(0.5 * pitch), [STEPS, STEPS], |p| lens.height(p));
        patches.push(patch.moved(DAffine3::from_translation(vertex)));
        faces.push(Face { shape: Shape::Sphere { vertex, axis: DVec3::Z, radius: -radius }, ..polished() });
    }
    // Its rim ends where the lenses do: between two lenses of the edge both are as high.
    let steps = [nx * STEPS, ny * STEPS];
    let within = |x: f64, half: f64, n: usize| {
        let cell = ((x + half) / pitch).floor().clamp(0.0, (n - 1) as f64);
        x + half - (cell + 0.5) * pitch
    };
    let top = Patch::over(half, steps, |p| lens.height(DVec2::new(within(p.x, half.x, nx), within(p.y, half.y, ny))));
    let back =
        Patch::over(half, steps, |_| (0.0, DVec2::ZERO)).moved(DAffine3::from_translation(DVec3::Z * -thickness));
    let wall = Patch::wall(&back.edge(steps), &top.edge(steps));
    patches.extend([back.flipped(), wall]);
    faces.extend([polished(), black()]);
    part(scene, "MICROLENS_ARRAY", place, Some(GLASS), (patches, faces));
}

/// Pixels of the front slide.
const PIXELS: [usize; 2] = [12, 9];

/// Two slides at different depths before a backlight, as displays of two layers and stacks of LCDs for contrast have them.
pub(super) fn two_slides(scene: &mut Scene, dice: &mut Dice) {
    let (distance, gap) = (dice.within(0.3, 0.7), dice.within(1e-3, 0.04));
    let half_width = dice.within(0.015, 0.03);
    let front = DAffine3::from_translation(DVec3::Z * -distance);
    lcd(scene, dice, "LCD_FRONT", front, (half_width, PIXELS, 0.012));
    // As large as it looks from the eye, and a bit more; coarser or not.
    let rear_width = half_width * (1.0 + gap / distance) * dice.within(1.0, 1.15);
    let pixels = if dice.coin() { PIXELS } else { [4, 3] };
    let rear = front * DAffine3::from_translation(DVec3::Z * -gap);
    lcd(scene, dice, "LCD_REAR", rear, (rear_width, pixels, 0.015));
    let half = DVec2::new(rear_width, rear_width * 0.75) + DVec2::splat(2e-3);
    let behind = dice.within(1e-3, 0.01);
    backlight(scene, dice, rear, half, behind);

    let eye = DVec3::new(dice.within(-0.05, 0.05), dice.within(-0.03, 0.03), 0.0);
    look(scene, eye, front.translation);
    let focus = (front.translation - eye).length();
    scene.eye.fov_deg = 2.0 * (half_width / focus).atan().to_degrees();
    scene.eye.focus_distance_m = if dice.coin() { focus } else { focus + gap };
}
