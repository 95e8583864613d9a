//! Derivatives of diffraction against finite differences of rays that the tracer's own law bends.

use super::*;
use eyebox_base::chain::Link;
use eyebox_base::ids::{GratingId, MediumId};
use eyebox_base::rng::{Rng, Stream};
use eyebox_scene::{Finish, Grating, Order, Scene};
use eyebox_world::geometry::scenes;
use glam::{DAffine3, DQuat, DVec2};

const NM: f64 = 550.0;

struct Bent;

impl Media for Bent {
    fn index(&self, part: Option<u32>) -> f64 {
        if part.is_some() { 1.5 } else { 1.0 }
    }
    fn nm(&self) -> Option<f64> {
        Some(NM)
    }
    fn past_rims(&self) -> bool {
        false
    }
}

/// A ball of glass with an exact face, or a plane sheet, in which a grating is cut; tilted and scaled.
fn gratings(shape: Option<f64>, place: DAffine3) -> Scene {
    let mut scene = match shape {
        Some(radius) => {
            let mesh = scenes::sphere(radius, 24, 48, DVec3::ZERO);
            let shape = scenes::sphere_shape(radius, DVec3::ZERO);
            let mut scene = scenes::scene(vec![mesh], vec![scenes::part(0, &[shape], place)]);
            scene.parts[0].medium = Some(MediumId::from_index(0));
            scene
        }
        None => {
            let mut scene = scenes::scene(vec![], vec![]);
            scenes::add_square(&mut scene, (30.0, 0.0, DVec3::Z), Finish::Absorber, place);
            scene
        }
    };
    // Out of the way.
    scene.eye.position = DVec3::NEG_Z;
    scene.gratings.push(Grating {
        direction: DVec3::new(0.6, 0.8, 0.3),
        lines_per_mm: 400.0,
        orders: vec![Order { order: 1, transmittance: 0.5, reflectance: 0.5 }].into(),
        rest_in_zero_order: false,
    });
    scene.parts[0].faces[0].finish = Finish::Grating { grating: GratingId::from_index(0) };
    scene
}

/// Every order, through and back, from a medium and into it, on a plane and on a sphere: to what central differences leave (a part in 10⁹
/// of steps of 1e-5, squared, and the rounding of places).
#[test]
fn diffraction_has_its_derivatives() {
    let mut rng = Rng::new(1, Stream::Check, 0, 0);
    let (mut tried, mut worst) = (0, 0f64);
    for shape in [None, Some(20.0)] {
        for turn in 0..4 {
            let axis = DVec3::new(rng.uniform() - 0.5, rng.uniform() - 0.5, 1.0).normalize();
            let place = DAffine3::from_scale_rotation_translation(
                DVec3::splat(1e-3 * (1.0 + f64::from(turn))),
                DQuat::from_axis_angle(axis, 0.2 * f64::from(turn)),
                DVec3::new(0.0, 0.0, 0.02 * f64::from(turn)),
            );
            let scene = gratings(shape, place);
            let world = World::freeze(&scene).expect("it can be traced");
            for (step, order) in [Step::Through, Step::Back].into_iter().flat_map(|s| (-2..=2).map(move |m| (s, m))) {
                for inside in [false, true] {
                    if inside && shape.is_none() {
                        continue;
                    }
                    let middle = place.translation - world.geometry.origin();
                    let about = |towards: DVec3, by: f64| middle + by * 1e-3 * (1.0 + f64::from(turn)) * towards;
                    let start = if inside {
                        about(DVec3::new(0.1, 0.2, 0.1), 20.0)
                    } else {
                        about(DVec3::new(0.3, -0.2, 3.0), 20.0)
                    };
                    let aim = about(DVec3::new(0.1 - 0.2 * rng.uniform(), 0.1, 0.8), 20.0);
                    let axis = if inside {
                        aim - start
                    } else {
                        about(DVec3::new(0.1, 0.2 * rng.uniform(), 0.0), 20.0) - start
                    };
                    let axis = axis.normalize();
                    let (a, b) = axis.any_orthonormal_pair();
                    // By a shift and a turn at once.
                    let bundle = |u: DVec2| {
                        let long = axis + u.x * a + u.y * b;
                        let length = long.length();
                        let dir = long / length;
                        let turn = |along: DVec3| (along - dir * dir.dot(along)) / length;
                        let ray = Ray { origin: start + 1e-2 * (u.x * b - u.y * a), dir, from: None };
                        RayDifferentials { ray, origin: [1e-2 * b, -1e-2 * a], dir: [turn(a), turn(b)] }
                    };
                    let glass = shape.map(|_| 0);
                    let (before, beyond) = if inside { (glass, None) } else { (None, glass) };
                    let after = if step == Step::Through { beyond } else { before };
                    let about = world.geometry.intersect(&bundle(DVec2::ZERO).ray, f64::INFINITY).map(|hit| hit.local);
                    let Some(about) = about else { continue };
                    let link = Link { part: 0, face: 0, step, order };
                    let train = SpecularChain(vec![Lens { link, about: about.to_array(), before, after }]);
                    let through = |u: DVec2| bundle(u).through(&world, &train, &Bent);
                    let Some(exact) = through(DVec2::ZERO) else { continue };
                    if order == 0 && step == Step::Through && shape.is_none() {
                        continue;
                    }
                    const STEP: f64 = 1e-5;
                    for (k, unit) in [DVec2::X, DVec2::Y].into_iter().enumerate() {
                        let (Some(after), Some(before)) = (through(STEP * unit), through(-STEP * unit)) else {
                            continue;
                        };
                        let of = |get: fn(&RayDifferentials) -> DVec3| (get(&after) - get(&before)) / (2.0 * STEP);
                        let (dir, origin) = (of(|r| r.ray.dir), of(|r| r.ray.origin));
                        let off = dir.distance(exact.dir[k]) / (1.0 + dir.length());
                        let beside = origin.distance(exact.origin[k]) / (1e-2 + origin.length());
                        worst = worst.max(off).max(beside);
                        assert!(
                            off < 1e-7 && beside < 1e-7,
                            "{shape:?} {step:?} {order} {inside}: {off:.1e} {beside:.1e}"
                        );
                        assert!(exact.dir[k].dot(exact.ray.dir).abs() < 1e-9, "a direction turns across itself");
                        tried += 1;
                    }
                }
            }
        }
    }
    println!("{tried} derivatives, off by up to {worst:.1e}");
    assert!(tried > 150, "{tried}");
}

/// Paths that have many wavelengths are not followed over an order.
#[test]
fn without_a_wavelength_orders_are_not_followed() {
    let scene = gratings(None, DAffine3::from_scale(DVec3::splat(1e-3)));
    let world = World::freeze(&scene).expect("it can be traced");
    let link = Link { part: 0, face: 0, step: Step::Through, order: 1 };
    let train = SpecularChain(vec![Lens { link, about: [0.0; 3], before: None, after: None }]);
    let ray = Ray { origin: DVec3::Z - world.geometry.origin(), dir: DVec3::NEG_Z, from: None };
    let bundle = RayDifferentials { ray, origin: [DVec3::ZERO; 2], dir: [DVec3::X, DVec3::Y] };
    assert!(bundle.through(&world, &train, &Bent).is_some());
    assert!(bundle.through(&world, &train, &|_| 1.0).is_none());
}
