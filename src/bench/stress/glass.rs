//! One face between two indices at every angle, and light that is reflected a hundred thousand times.

use super::Case;
use super::places::plate;
use crate::measure::How;
use crate::{closed, kit};
use eyebox_scene::{Finish, Scene, Shape};
use glam::{DAffine3, DVec3};

/// Field of view of a single ray: its angle is the same all over to 1e-10.
const RAY_DEG: f64 = 1e-8;

/// The eye sees a panel of 1000 cd/m² by reflection in one face. `cos` is that of the angle of incidence.
pub fn reflected(index: f64, degrees: f64) -> (Scene, f64) {
    let mut s = kit::scene(RAY_DEG, 1);
    let (sin, cos) = degrees.to_radians().sin_cos();
    let mut faces = vec![kit::face(Finish::Absorber); 6];
    faces[5] = kit::polished(Shape::Plane { vertex: DVec3::ZERO, axis: DVec3::Z });
    let body: Vec<Vec<DVec3>> = kit::cuboid(DVec3::new(0.5, 0.5, 0.05))
        .into_iter()
        .map(|face| face.into_iter().map(|p| p - DVec3::Z * 0.05).collect())
        .collect();
    kit::add(&mut s, kit::mesh(&body), DAffine3::IDENTITY, Some(index), faces);
    kit::look(&mut s, DVec3::new(-sin, 0.0, cos) * 0.3, DVec3::ZERO);
    let towards = DVec3::new(sin, 0.0, cos);
    let along = DVec3::new(-cos, 0.0, sin);
    kit::panel(&mut s, 1000.0, kit::quad(towards, along * 0.05, DVec3::Y * 0.05));
    let r = closed::reflectance(1.0, index, sin, cos);
    (s, 500.0 * (r[0] + r[1]))
}

/// A number in few digits.
struct Number(f64);

impl std::fmt::Display for Number {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.0.abs() < 1e-3 && self.0 != 0.0 {
            write!(f, "{:.0e}", self.0)
        } else {
            write!(f, "{}", (self.0 * 1e3).round() / 1e3)
        }
    }
}

/// Glass that is almost air, and a diamond.
pub fn indices() -> Vec<Case> {
    let mut cases = Vec::new();
    for index in [1.0 + 1e-7, 1.0 + 1e-12, 1.0, 2.42] {
        for degrees in [0.0, 45.0] {
            let (s, want) = plate(degrees, index, true);
            let name = format!("n = 1 + {}, through a plate at {degrees}°", Number(index - 1.0));
            let case = Case::new(name, s, How::backward(800).polarised(), want);
            cases.push(Case { noise: 5e-3, rounding: 1e-12, ..case });
        }
    }
    cases
}

/// Reflection up to 89.9999°. Below 1/256 a reflection is left to chance, so only what is above is here.
pub fn grazing() -> Vec<Case> {
    let mut cases = Vec::new();
    for (index, angles) in [
        (1.5, [0.0, 60.0, 85.0, 89.0, 89.9, 89.99, 89.9999]),
        (1.0 + 1e-7, [89.98, 89.985, 89.99, 89.995, 89.999, 89.9999, 89.99999]),
    ] {
        for degrees in angles {
            let (s, want) = reflected(index, degrees);
            for polarised in [false, true] {
                let name = format!(
                    "n = 1 + {}, reflected at {degrees}°{}",
                    Number(index - 1.0),
                    if polarised { ", polarised" } else { "" }
                );
                // Of four even points a pass: four passes of them may agree by chance.
                let how = How { polarised, ..How::backward(16) };
                // What crosses is left to chance below 1/256 too, and may not come at all.
                let crosses = 1.0 - want / 1000.0;
                let rounding = if crosses < 1.0 / 256.0 { crosses } else { 1e-8 };
                cases.push(Case { rounding, noise: 1e-2, ..Case::new(name, s.clone(), how, want) });
            }
        }
    }
    cases
}

/// A wedge whose second face is met from inside `beyond` radians above the critical angle; the panel is along that face.
pub fn wedge(index: f64, beyond: f64) -> (Scene, f64) {
    let mut s = kit::scene(RAY_DEG, 1);
    let angle = (1.0f64 / index).asin() + beyond;
    let (sin, cos) = angle.sin_cos();
    let (w, depth) = (0.05, 0.1);
    let corner = |x: f64, back: bool, y: f64| DVec3::new(x, y, if back { x * sin / cos - depth } else { 0.0 });
    let side = |x: f64, turn: bool| {
        let mut face = vec![corner(x, true, -w), corner(x, true, w), corner(x, false, w), corner(x, false, -w)];
        if turn {
            face.reverse();
        }
        face
    };
    let end = |y: f64, turn: bool| {
        let mut face = vec![corner(-w, true, y), corner(w, true, y), corner(w, false, y), corner(-w, false, y)];
        if turn {
            face.reverse();
        }
        face
    };
    let front = vec![corner(-w, false, -w), corner(w, false, -w), corner(w, false, w), corner(-w, false, w)];
    let back = vec![corner(-w, true, -w), corner(-w, true, w), corner(w, true, w), corner(w, true, -w)];
    let polygons = [front, back, side(-w, true), side(w, false), end(-w, false), end(w, true)];
    let mut faces = vec![kit::face(Finish::Absorber); 6];
    faces[0] = kit::polished(Shape::Plane { vertex: DVec3::ZERO, axis: DVec3::Z });
    let out = DVec3::new(sin, 0.0, -cos);
    faces[1] = kit::polished(Shape::Plane { vertex: DVec3::NEG_Z * depth, axis: out });
    kit::add(&mut s, kit::mesh(&polygons), DAffine3::from_translation(DVec3::NEG_Z * 0.1), Some(index), faces);
    // What leaves runs along the face.
    let along = DVec3::new(-cos, 0.0, -sin);
    let centre = DVec3::NEG_Z * (0.1 + depth) + along * 0.3;
    kit::panel(&mut s, 1000.0, kit::quad(centre, out * 0.05, DVec3::Y * 0.05));
    let at_front = closed::reflectance(1.0, index, 0.0, 1.0)[0];
    let r = closed::reflectance(index, 1.0, sin, cos);
    (s, 1000.0 * (1.0 - at_front) * (1.0 - 0.5 * (r[0] + r[1])))
}

/// Around the critical angle.
pub fn critical() -> Vec<Case> {
    let mut cases = Vec::new();
    for beyond in [-1e-3, -1e-4, -1e-5, -1e-6, 0.0, 1e-6, 1e-4] {
        let (s, want) = wedge(1.5, beyond);
        // At the angle itself rounding decides, between nothing and almost nothing.
        let rounding = if beyond == 0.0 { 1e-2 } else { 1e-8 };
        for polarised in [false, true] {
            let name = format!("critical angle {beyond:+e} rad{}", if polarised { ", polarised" } else { "" });
            let how = How { polarised, ..How::backward(16) };
            cases.push(Case { rounding, ..Case::new(name, s.clone(), how, want) });
        }
    }
    cases
}

/// A strip of glass, 0.1 mm thick and as long as makes `bounces` reflections, looked into under 60°.
pub fn guide(bounces: f64) -> (Scene, f64) {
    let mut s = kit::scene(1e-6, 1);
    let (sin, cos) = 60f64.to_radians().sin_cos();
    let inside = sin / 1.5;
    let thick = 1e-4;
    let length = bounces * thick * (1.0 - inside * inside).sqrt() / inside;
    let body = kit::cuboid(DVec3::new(0.5 * thick, 1e-3, 0.5 * length));
    let at = DAffine3::from_translation(DVec3::NEG_Z * 0.5 * length);
    kit::add(&mut s, kit::mesh(&body), at, Some(1.5), vec![kit::polished(Shape::Mesh); 6]);
    kit::look(&mut s, DVec3::new(sin, 0.0, cos) * 0.05, DVec3::ZERO);
    let beyond = DVec3::NEG_Z * (length + 1e-3);
    kit::panel(&mut s, 1000.0, kit::quad(beyond, DVec3::X * 0.01, DVec3::Y * 0.01));
    (s, 1000.0 * closed::plates(&[1.0, 1.5, 1.0], sin))
}

/// Light guides.
pub fn guides() -> Vec<Case> {
    [(1e2, 400, 5e-3), (1e3, 100, 1e-2), (1e4, 100, 0.2), (1e5, 60, 0.4)]
        .into_iter()
        .map(|(bounces, passes, noise)| {
            let (s, want) = guide(bounces);
            let case = Case::new(format!("{bounces:e} reflections"), s, How::backward(passes).polarised(), want);
            Case { noise, ..case }
        })
        .collect()
}
