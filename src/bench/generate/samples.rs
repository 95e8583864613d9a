//! The first seven families: small displays like the two samples, panoramas and rooms. The eye is at the origin and looks
//! along −z.

use super::{Dice, GLASS};
use crate::kit;
use eyebox_base::ids::{GroupId, SlideId};
use eyebox_scene::{Face, Finish, Scene, Shape, Slide};
use glam::{DAffine3, DVec3};
use std::sync::Arc;

/// A display behind a tilted plate that shows a panorama.
pub(super) fn both(scene: &mut Scene, dice: &mut Dice) {
    let diffuser = dice.coin();
    display(scene, dice, diffuser);
    let place = DAffine3::from_translation(DVec3::Z * -0.025) * DAffine3::from_rotation_x(dice.within(0.5, 0.9));
    plate(scene, place, 0.03, Finish::Polished);
    sky(scene, dice);
}

/// 1 to 45 LEDs in a square grid `depth` in front of the eye, facing `towards` (a × b of their sides).
pub(super) fn leds(scene: &mut Scene, dice: &mut Dice, centre: DVec3, [a, b]: [DVec3; 2], pitch: f64) -> GroupId {
    let count = if dice.coin() { dice.whole(1, 4) } else { dice.whole(5, 45) };
    let half = pitch * dice.within(0.08, 0.4);
    let luminance = dice.within(1e5, 5e6);
    let side = (1..).find(|side| side * side >= count).unwrap_or(7);
    let place = |i: u64| pitch * (i as f64 - 0.5 * (side - 1) as f64);
    let polygons: Vec<Vec<DVec3>> =
        (0..count).map(|i| kit::quad(centre + a * place(i % side) + b * place(i / side), a * half, b * half)).collect();
    let group = kit::group(scene, "led");
    let faces = polygons.iter().map(|_| kit::shining(group, luminance)).collect();
    kit::add(scene, kit::mesh(&polygons), DAffine3::IDENTITY, None, faces);
    group
}

/// A biconvex lens of this focal length (thin-lens formula) about the axis of sight, with a black rim.
pub fn lens(scene: &mut Scene, depth: f64, focal: f64, edge: f64) {
    lens_at(scene, DAffine3::from_translation(DVec3::Z * -depth), focal, edge);
}

/// The same about the origin of `place`, its axis along z.
pub(super) fn lens_at(scene: &mut Scene, place: DAffine3, focal: f64, edge: f64) {
    let radius = 2.0 * (GLASS - 1.0) * focal;
    let half = kit::sag_of_sphere(radius, edge) + 5e-4;
    let low = kit::cap(-half, |r| kit::sag_of_sphere(radius, r), edge, false, [12, 48]);
    let high = kit::cap(half, |r| kit::sag_of_sphere(-radius, r), edge, true, [12, 48]);
    let wall = kit::wall(&low.0, &high.0, 48);
    let sphere = |z: f64, radius: f64| Shape::Sphere { vertex: DVec3::Z * z, axis: DVec3::Z, radius };
    let faces =
        vec![kit::polished(sphere(-half, radius)), kit::polished(sphere(half, -radius)), kit::face(Finish::Absorber)];
    kit::add(scene, kit::mesh_of([low, high, wall]), place, Some(GLASS), faces);
}

/// A pane about the origin of `place`, 1 mm thick, its front (towards +z) with this finish.
pub fn plate(scene: &mut Scene, place: DAffine3, half: f64, front: Finish) {
    let mut faces: Vec<Face> = (0..6).map(|_| kit::face(Finish::Absorber)).collect();
    faces[4] = kit::face(Finish::Polished);
    faces[5] = kit::face(front);
    kit::add(scene, kit::mesh(&kit::cuboid(DVec3::new(half, half, 5e-4))), place, Some(GLASS), faces);
}

/// A one-sided sheet through `centre` with half sides a and b, facing a × b.
pub(super) fn sheet(scene: &mut Scene, centre: DVec3, a: DVec3, b: DVec3, face: Face) {
    kit::add(scene, kit::mesh(&[kit::quad(centre, a, b)]), DAffine3::IDENTITY, None, vec![face]);
}

pub(super) fn matt(dice: &mut Dice) -> Face {
    kit::face(Finish::Lambert { reflectance: dice.within(0.2, 0.8), transmittance: 0.0 })
}

/// LEDs → lens → (diffuser →) slide → eye, in a black tube. The lens images the LEDs into the pupil.
pub(super) fn display(scene: &mut Scene, dice: &mut Dice, diffuser: bool) {
    let (depth, focal, edge) = (dice.within(0.07, 0.1), dice.within(0.02, 0.03), 0.01);
    let behind = 1.0 / (1.0 / focal - 1.0 / depth);
    let (x, y) = (DVec3::X, DVec3::Y);
    let pitch = dice.within(5e-4, 1.2e-3);
    leds(scene, dice, DVec3::Z * -(depth + behind), [x, y], pitch);
    lens(scene, depth, focal, edge);
    let front = depth - 0.006;
    let half = 0.008;
    slide(scene, dice, front, half);
    if diffuser {
        let finish = if dice.coin() {
            Finish::Gauss { sigma_deg: dice.within(3.0, 20.0), reflectance: 0.05, transmittance: 0.8 }
        } else {
            Finish::Lambert { reflectance: 0.1, transmittance: 0.7 }
        };
        sheet(scene, DVec3::Z * -(front + 5e-4), x * half, y * half, kit::face(finish));
    }
    // The rest of what would pass by the slide is stopped.
    let frame = half + 0.02;
    for (along, across) in [(x, y), (-x, y), (y, -x), (-y, -x)] {
        let centre = DVec3::Z * -front + along * 0.5 * (half + frame);
        let (a, b) = (along * 0.5 * (frame - half), across * frame);
        sheet(scene, centre, a, b, kit::face(Finish::Absorber));
    }
    scene.eye.focus_distance_m = front;
    scene.eye.fov_deg = 2.0 * (0.9 * half / front).atan().to_degrees();
}

/// Bars and steps of grey, as wide and high as `half` says twice.
fn slide(scene: &mut Scene, dice: &mut Dice, depth: f64, half: f64) {
    let (width, height) = (8, 6);
    let pixels: Vec<f32> =
        (0..width * height).map(|i| if (i % width) % 3 == 0 { 1.0 } else { (i / width) as f32 / 6.0 }).collect();
    scene.slides.push(Slide {
        name: "bars".to_owned(),
        file: "made in code".to_owned(),
        width,
        height,
        pixels: Arc::new(pixels),
        rgb: None,
        centre: DVec3::Z * -depth,
        u: DVec3::X,
        v: DVec3::Y,
        size: [2.0 * half, 2.0 * half],
        transmittance: 0.3,
        contrast: dice.within(30.0, 1000.0),
        polarisation: None,
        primaries: None,
    });
    let face = Face { slide: Some(SlideId::from_index(scene.slides.len() - 1)), ..kit::face(Finish::None) };
    sheet(scene, DVec3::Z * -depth, DVec3::X * half, DVec3::Y * half, face);
}

/// A gradient with a bright spot.
pub(super) fn sky(scene: &mut Scene, dice: &mut Dice) {
    let (width, height) = (32usize, 16usize);
    let (spot, ground) = (dice.whole(0, 31) as usize, dice.within(50.0, 400.0));
    let bright = ground * dice.within(5.0, 100.0);
    let luminance = (0..width * height).map(|i| {
        let (x, y) = (i % width, i / width);
        let near = x.abs_diff(spot) <= 1 && (4..6).contains(&y);
        (if near { bright } else { ground * (1.5 - y as f64 / height as f64) }) as f32
    });
    kit::sky(scene, width, height, luminance.collect());
}

pub(super) fn panorama(scene: &mut Scene, dice: &mut Dice) {
    sky(scene, dice);
    scene.eye.fov_deg = 50.0;
    let floor = matt(dice);
    sheet(scene, DVec3::new(0.0, -0.3, -1.0), DVec3::Z, DVec3::X, floor);
    let radius = dice.within(0.05, 0.12);
    let place = DAffine3::from_translation(DVec3::new(dice.within(-0.2, 0.2), radius - 0.29, -0.7));
    let ball = kit::sphere(radius, 12, 24);
    kit::add(scene, ball, place, Some(GLASS), vec![kit::polished(kit::ball(radius))]);
    let place = DAffine3::from_translation(DVec3::new(-0.25, 0.0, -0.6)) * DAffine3::from_rotation_y(0.4);
    plate(scene, place, 0.12, Finish::Polished);
}

pub(super) fn rough_glass(scene: &mut Scene, dice: &mut Dice) {
    let pitch = dice.within(2e-3, 5e-3);
    leds(scene, dice, DVec3::Z * -0.4, [DVec3::X, DVec3::Y], pitch);
    let rough = Finish::Rough { alpha: dice.within(0.05, 0.4) };
    plate(scene, DAffine3::from_translation(DVec3::Z * -0.3), 0.06, rough);
    let wall = matt(dice);
    sheet(scene, DVec3::Z * -0.45, DVec3::X * 0.2, DVec3::Y * 0.2, wall);
    scene.eye.focus_distance_m = 0.3;
}

pub(super) fn no_lens(scene: &mut Scene, dice: &mut Dice) {
    let pitch = dice.within(5e-3, 2e-2);
    leds(scene, dice, DVec3::new(0.0, 0.35, -0.8), [DVec3::X, DVec3::Z], pitch);
    let (floor, wall) = (matt(dice), matt(dice));
    sheet(scene, DVec3::new(0.0, -0.3, -1.0), DVec3::Z, DVec3::X, floor);
    sheet(scene, DVec3::new(0.0, 0.3, -1.3), DVec3::X, DVec3::Y, wall);
    scene.eye.fov_deg = 50.0;
    if dice.coin() {
        scene.eye.pupil_diameter_m = 0.0;
    }
}

/// 4 × 2.6 × 4 m, a window of glass or without in the wall at the left.
pub(super) fn room(scene: &mut Scene, dice: &mut Dice) {
    sky(scene, dice);
    let (x, y, z) = (DVec3::X * 2.0, DVec3::Y * 1.3, DVec3::Z * 2.0);
    let middle = DVec3::Z * -1.0;
    // Facing in: floor, ceiling, right, front and back.
    for (centre, a, b) in [(-y, z, x), (y, x, z), (x, z, y), (-z, x, y), (z, y, x)] {
        let face = matt(dice);
        sheet(scene, middle + centre, a, b, face);
    }
    // The wall at the left leaves a window: below, above, before and behind.
    let (half, wall) = (dice.within(0.3, 0.8), matt(dice));
    let left = middle - x;
    for side in [-1.0, 1.0] {
        let strip = 0.5 * (1.3 - half);
        sheet(scene, left + DVec3::Y * side * (half + strip), DVec3::Y * strip, z, wall.clone());
        let strip = 0.5 * (2.0 - half);
        sheet(scene, left + DVec3::Z * side * (half + strip), DVec3::Y * half, DVec3::Z * strip, wall.clone());
    }
    if dice.coin() {
        let place = DAffine3::from_translation(left) * DAffine3::from_rotation_y(std::f64::consts::FRAC_PI_2);
        plate(scene, place, half, Finish::Polished);
    }
    scene.eye.fov_deg = 70.0;
}
