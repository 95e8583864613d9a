//! Solids that touch, almost touch, or lie on top of each other.

use super::Case;
use super::places::behind;
use crate::measure::How;
use crate::{closed, kit};
use eyebox_scene::{Finish, Scene, Shape};
use glam::{DAffine3, DVec3};

const INDICES: [f64; 2] = [1.52, 1.62];

/// Two tilted plates, `gap` metres apart, and a panel; below 0 they overlap. What is wanted is one interface.
pub fn stack(gap: f64, degrees: f64) -> (Scene, f64) {
    let mut s = kit::scene(0.01, 1);
    let turn = DAffine3::from_translation(DVec3::NEG_Z * 0.5) * DAffine3::from_rotation_x(degrees.to_radians());
    for (sign, index) in [1.0, -1.0].into_iter().zip(INDICES) {
        let to_world = turn * DAffine3::from_translation(DVec3::Z * sign * (0.001 + 0.5 * gap));
        let body = kit::mesh(&kit::cuboid(DVec3::new(0.4, 0.4, 0.001)));
        kit::add(&mut s, body, to_world, Some(index), vec![kit::polished(Shape::Mesh); 6]);
    }
    behind(&mut s);
    (s, 1000.0 * closed::plates(&[1.0, INDICES[0], INDICES[1], 1.0], degrees.to_radians().sin()))
}

/// Gaps and overlaps that are one interface, and a gap that is air.
pub fn gaps() -> Vec<Case> {
    let mut cases = Vec::new();
    let how = How::backward(800).polarised();
    for degrees in [0.0, 45.0, 75.0] {
        for gap in [0.0, 1e-12, 1e-9, 1e-8, 1e-6, -1e-12, -1e-9, -1e-6] {
            let (s, want) = stack(gap, degrees);
            let name = format!("plates {:e} nm apart at {degrees}°", gap * 1e9);
            cases.push(Case { noise: 5e-3, rounding: 1e-6, ..Case::new(name, s, how, want) });
        }
        let (s, _) = stack(1e-4, degrees);
        let want = 1000.0 * closed::plates(&[1.0, INDICES[0], 1.0, INDICES[1], 1.0], f64::to_radians(degrees).sin());
        let name = format!("plates 0.1 mm apart at {degrees}°, air between");
        cases.push(Case { noise: 5e-3, rounding: 1e-6, ..Case::new(name, s, how, want) });
    }
    cases
}

/// A plate made of three strips side by side, whose walls touch where rays cross them.
fn strips() -> (Scene, f64) {
    let mut s = kit::scene(0.01, 1);
    let turn = DAffine3::from_translation(DVec3::NEG_Z * 0.5) * DAffine3::from_rotation_x(45f64.to_radians());
    for (low, high) in [(-0.4, -0.0005), (-0.0005, 0.0005), (0.0005, 0.4)] {
        let half = DVec3::new(0.4, 0.5 * (high - low), 0.001);
        let to_world = turn * DAffine3::from_translation(DVec3::Y * 0.5 * (low + high));
        kit::add(&mut s, kit::mesh(&kit::cuboid(half)), to_world, Some(1.5), vec![kit::polished(Shape::Mesh); 6]);
    }
    behind(&mut s);
    (s, 1000.0 * closed::plates(&[1.0, 1.5, 1.0], 0.5f64.sqrt()))
}

/// A plate twice at the same place, of two glasses: the first of the asset fills the space.
fn twice(second: f64) -> (Scene, f64) {
    let (mut s, want) = super::places::plate(45.0, 1.5, false);
    let (mesh, to_world) = (s.meshes[0].clone(), s.parts[0].to_world);
    kit::add(&mut s, mesh, to_world, Some(second), vec![kit::polished(Shape::Mesh); 6]);
    (s, want)
}

/// A block flush with the front of a larger one, and of higher priority: the light goes through both.
fn flush() -> (Scene, f64) {
    let mut s = kit::scene(0.01, 1);
    let turn = DAffine3::from_translation(DVec3::NEG_Z * 0.5) * DAffine3::from_rotation_x(45f64.to_radians());
    let glass = || vec![kit::polished(Shape::Mesh); 6];
    kit::add(&mut s, kit::mesh(&kit::cuboid(DVec3::new(0.4, 0.4, 0.002))), turn, Some(INDICES[1]), glass());
    let front = turn * DAffine3::from_translation(DVec3::Z * 0.001);
    let inner = kit::mesh(&kit::cuboid(DVec3::new(0.3, 0.3, 0.001)));
    let part = kit::add(&mut s, inner, front, Some(INDICES[0]), glass());
    s.parts[part].priority = 1;
    behind(&mut s);
    (s, 1000.0 * closed::plates(&[1.0, INDICES[0], INDICES[1], 1.0], 0.5f64.sqrt()))
}

/// A plate with a black sheet on its back, and one on its front: nothing comes through.
fn blackened(front: bool, degrees: f64) -> (Scene, f64) {
    let (mut s, _) = super::places::plate(degrees, 1.5, false);
    let z = if front { 0.001 } else { -0.001 };
    let sheet = kit::mesh(&[kit::quad(DVec3::Z * z, DVec3::X * 0.4, DVec3::Y * 0.4)]);
    let to_world = s.parts[0].to_world;
    kit::add(&mut s, sheet, to_world, None, vec![kit::face(Finish::Absorber)]);
    (s, 0.0)
}

/// Faces on top of faces.
pub fn coincident() -> Vec<Case> {
    let how = How::backward(800).polarised();
    let mut cases = Vec::new();
    let mut add = |name: String, (s, want): (Scene, f64)| {
        cases.push(Case { noise: 5e-3, rounding: 1e-6, ..Case::new(name, s, how, want) });
    };
    add("strips side by side".to_owned(), strips());
    add("a plate twice".to_owned(), twice(1.5));
    add("a plate in the place of another".to_owned(), twice(1.8));
    add("a block flush in a larger one".to_owned(), flush());
    for degrees in [0.0, 45.0, 75.0] {
        add(format!("a black sheet on the back of a plate at {degrees}°"), blackened(false, degrees));
        add(format!("a black sheet on the front of a plate at {degrees}°"), blackened(true, degrees));
    }
    cases
}
