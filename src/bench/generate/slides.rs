//! Two slides in a row at different depths before a backlight, as displays of two layers and stacks of LCDs for contrast
//! have them.

use super::Dice;
use super::build::{backlight, lcd, look};
use crate::scene::Scene;
use glam::{DAffine3, DVec2, DVec3};

/// Pixels of the front slide.
const PIXELS: [usize; 2] = [12, 9];

pub(super) fn build(scene: &mut Scene, dice: &mut Dice) {
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
