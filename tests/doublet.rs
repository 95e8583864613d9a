//! Cemented doublets whose shared faces coincide, gap a little or overlap a little render the same.

use eyebox::base::rng::{Rng, Stream};
use eyebox::estimate::ledger::Ledger;
use eyebox::estimate::walk::{Met, Travel, Walker};
use eyebox::film::plan::Estimator;
use eyebox::scene::{Dispersion, Finish, Scene, Shape};
use eyebox::world::World;
use eyebox::world::geometry::Ray;
use eyebox::world::interior::Interior;
use eyebox::world::mode::{Mode, Mono};
use eyebox_bench::{closed, kit, measure};
use glam::{DAffine3, DVec3};
use measure::{How, trace};

/// N-BK7 and F2 at 550 nm.
const CROWN: f64 = 1.51852;
const FLINT: f64 = 1.62408;
/// Radii and vertices along z, mm.
const RADII: [f64; 3] = [60.0, -45.0, -130.0];
const PLACES: [f64; 3] = [0.0, 6.0, 8.5];
const EDGE: f64 = 12.5;
const RINGS: [usize; 2] = [24, 48];

/// How the lenses are made.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Spheres,
    /// The same spheres given as aspheres, which are traced by other code.
    Aspheres,
    Triangles,
}

fn shape(kind: Kind, k: usize) -> Shape {
    let (vertex, axis, radius) = (DVec3::Z * PLACES[k], DVec3::Z, RADII[k]);
    match kind {
        Kind::Spheres => Shape::Sphere { vertex, axis, radius },
        Kind::Aspheres => Shape::Asphere { vertex, axis, radius, conic: 0.0, even: vec![0.0, 1e-18] },
        Kind::Triangles => Shape::Mesh,
    }
}

/// One lens from face `k` to face `k + 1`, moved along z by `moved` metres.
fn lens(scene: &mut Scene, kind: Kind, k: usize, index: f64, moved: f64) -> usize {
    let cap = |k: usize, up: bool| kit::cap(PLACES[k], |r| kit::sag_of_sphere(RADII[k], r), EDGE, up, RINGS);
    let (low, high) = (cap(k, false), cap(k + 1, true));
    let wall = kit::wall(&low.0, &high.0, RINGS[1]);
    let to_world = DAffine3::from_translation(DVec3::Z * moved) * DAffine3::from_scale(DVec3::splat(1e-3));
    let mut mesh = kit::mesh_of([low, high, wall]);
    if kind == Kind::Triangles {
        // Normals of the spheres, so that both lenses are shaded alike.
        for (k, range) in [(k, mesh.faces[0]), (k + 1, mesh.faces[1])] {
            let sign = if k == 0 || (k == 1 && range.first == 0) { -1.0 } else { 1.0 };
            let corners: Vec<u32> = mesh.triangles[range.triangles()].iter().flatten().copied().collect();
            for v in corners {
                let [x, y, z] = mesh.positions[v as usize].map(f64::from);
                let from_centre = DVec3::new(x, y, z - PLACES[k] - RADII[k]) / -RADII[k];
                mesh.normals[v as usize] = (sign * from_centre.normalize()).as_vec3().to_array();
            }
        }
    }
    let faces = vec![kit::polished(shape(kind, k)), kit::polished(shape(kind, k + 1)), kit::face(Finish::Absorber)];
    kit::add(scene, mesh, to_world, Some(index), faces)
}

/// The doublet, its second lens `gap` metres away from the first; priorities of the two.
fn doublet(kind: Kind, gap: f64, priorities: [i32; 2]) -> Scene {
    let mut scene = kit::scene(1.0, 4);
    scene.eye.position = DVec3::new(0.0, 0.0, -0.1);
    scene.eye.look = DVec3::Z;
    let parts = [lens(&mut scene, kind, 0, CROWN, 0.0), lens(&mut scene, kind, 1, FLINT, gap)];
    for (part, priority) in parts.into_iter().zip(priorities) {
        scene.parts[part].priority = priority;
    }
    scene
}

/// Where a ray is, where it goes and what it carries after the faces given as (z of the vertex, radius, index behind).
fn sequential(mut p: DVec3, mut d: DVec3, faces: &[(f64, f64, f64)]) -> (DVec3, DVec3, f64) {
    let (mut n1, mut weight) = (1.0, 1.0);
    for &(z, radius, n2) in faces {
        let centre = DVec3::Z * (z + radius);
        let (w, side) = (p - centre, (radius * d.z).signum());
        let b = w.dot(d);
        // Towards +z the near root of a sphere whose centre is ahead, the far one of one whose centre is behind.
        let t = -b - side * (b * b - w.length_squared() + radius * radius).sqrt();
        p += t * d;
        let normal = (p - centre) / radius.abs() * side;
        let cos = -d.dot(normal);
        let sin = d.cross(normal).length();
        let r = closed::reflectance(n1, n2, sin, cos);
        weight *= 1.0 - 0.5 * (r[0] + r[1]);
        let ratio = n1 / n2;
        let cos_t = (1.0 - ratio * ratio * sin * sin).sqrt();
        d = (ratio * d + (ratio * cos - cos_t) * normal).normalize();
        n1 = n2;
    }
    (p, d, weight)
}

/// Sends a ray straight on through a scene; the last point, the direction, the weight and what the ledger noted.
fn straight(world: &World, p: DVec3, d: DVec3) -> (DVec3, DVec3, f64, u64) {
    type M = Mono<f64>;
    let optics = M::optics(world, 0, 0);
    let ray = Ray { origin: p - world.geometry.origin(), dir: d, from: None };
    let rng = Rng::new(1, Stream::Check, 0, 0);
    let mut walker = Walker::<M>::new((world, &optics), Travel::FromLamp, ray, 1.0, Interior::default(), rng);
    let mut ledger = Ledger::new(world.solids.len());
    while let Met::Face(vertex) = walker.advance(&mut ledger) {
        assert!(walker.go_straight_on(&vertex, &mut ledger), "stopped at {:?}", vertex.hit);
    }
    let at = walker.ray.origin + world.geometry.origin();
    assert_eq!(walker.interior, Interior::default(), "inside of something at {at}");
    (at, walker.ray.dir, walker.beam.weight(), ledger.mismatches)
}

const GAPS: [f64; 8] = [0.0, 1e-12, 1e-9, 1e-8, 1e-6, -1e-12, -1e-9, -1e-6];

/// Every ray leaves a doublet where, how and as bright as a sequential trace of three faces says, in both directions.
#[test]
fn rays_through_a_doublet_are_those_of_three_faces() {
    for kind in [Kind::Spheres, Kind::Aspheres] {
        for gap in GAPS {
            for priorities in [[0, 0], [0, 1], [2, 1]] {
                let world = World::freeze(&doublet(kind, gap, priorities)).expect("it can be traced");
                assert_eq!(world.contacts.pairs(), [1, 0], "{gap}");
                let mut rng = Rng::new(2, Stream::Check, 0, 0);
                for k in 0..400 {
                    let aim = DVec3::new(rng.uniform() - 0.5, rng.uniform() - 0.5, 0.0) * 0.014;
                    let slope = DVec3::new(rng.uniform() - 0.5, rng.uniform() - 0.5, 0.0) * 0.3;
                    let on = (DVec3::Z + slope).normalize();
                    let back = k % 2 == 1;
                    let (d, start) = if back { (-on, 0.05) } else { (on, -0.05) };
                    let p = aim + d * (start / d.z);
                    let m = 1e-3;
                    let mut faces = [
                        (PLACES[0] * m, RADII[0] * m, CROWN),
                        (PLACES[1] * m, RADII[1] * m, FLINT),
                        (PLACES[2] * m + gap, RADII[2] * m, 1.0),
                    ];
                    if back {
                        faces.reverse();
                        (faces[0].2, faces[1].2, faces[2].2) = (FLINT, CROWN, 1.0);
                    }
                    let (at, dir, weight) = sequential(p, d, &faces);
                    let got = straight(&world, p, d);
                    // What a shift of the shared face by the gap does.
                    let allowed = 1e-12 + gap.abs();
                    let name = format!("gap {gap:e} m, priorities {priorities:?}, ray {k}");
                    assert!((got.0 - at).length() < allowed, "{name}: {} {at}", got.0);
                    assert!((got.1 - dir).length() < allowed / 0.01, "{name}: {} {dir}", got.1);
                    assert!((got.2 - weight).abs() < 1e-12 + 1e3 * gap.abs(), "{name}: {} {weight}", got.2);
                    assert_eq!(got.3, 0, "{name}: contradictions");
                }
            }
        }
    }
}

/// Lenses of triangles alone, equal on both sides of the shared face.
#[test]
fn faceted_doublets_too() {
    let reference = World::freeze(&doublet(Kind::Triangles, 0.0, [0, 0])).expect("it can be traced");
    for gap in GAPS {
        let world = World::freeze(&doublet(Kind::Triangles, gap, [0, 0])).expect("it can be traced");
        let mut rng = Rng::new(3, Stream::Check, 0, 0);
        for k in 0..400 {
            let aim = DVec3::new(rng.uniform() - 0.5, rng.uniform() - 0.5, 0.0) * 0.014;
            let d = if k % 2 == 0 { DVec3::Z } else { DVec3::NEG_Z };
            let p = aim - 0.05 * d;
            let (want, got) = (straight(&reference, p, d), straight(&world, p, d));
            assert_eq!(got.3, 0, "gap {gap:e}, ray {k}");
            assert!((got.1 - want.1).length() < 1e-9 + 1e3 * gap.abs(), "gap {gap:e}: {} {}", got.1, want.1);
            assert!((got.2 - want.2).abs() < 1e-9 + 1e3 * gap.abs(), "gap {gap:e}: {} {}", got.2, want.2);
            assert!((want.2 - 0.9025).abs() < 0.003, "{}", want.2);
        }
    }
}

/// A real air gap is two faces, and a deep overlap is the face of the higher priority.
#[test]
fn real_gaps_and_deep_overlaps_stay() {
    let m = 1e-3;
    let p = DVec3::new(0.002, 0.001, -0.05);
    let first = (PLACES[0] * m, RADII[0] * m, CROWN);
    let gap = 1e-4;
    let world = World::freeze(&doublet(Kind::Spheres, gap, [0, 0])).expect("it can be traced");
    assert_eq!(world.contacts.pairs(), [0, 0]);
    let faces = [
        first,
        (PLACES[1] * m, RADII[1] * m, 1.0),
        (PLACES[1] * m + gap, RADII[1] * m, FLINT),
        (PLACES[2] * m + gap, RADII[2] * m, 1.0),
    ];
    let (want, got) = (sequential(p, DVec3::Z, &faces), straight(&world, p, DVec3::Z));
    assert!((got.1 - want.1).length() < 1e-12 && (got.2 - want.2).abs() < 1e-12, "{got:?} {want:?}");
    for (priorities, z) in [([1, 0], PLACES[1] * m), ([0, 1], PLACES[1] * m - gap)] {
        let world = World::freeze(&doublet(Kind::Spheres, -gap, priorities)).expect("it can be traced");
        let faces = [first, (z, RADII[1] * m, FLINT), (PLACES[2] * m - gap, RADII[2] * m, 1.0)];
        let (want, got) = (sequential(p, DVec3::Z, &faces), straight(&world, p, DVec3::Z));
        assert!((got.1 - want.1).length() < 1e-12 && (got.2 - want.2).abs() < 1e-12, "{got:?} {want:?}");
    }
}

/// Plates that touch, steep: total reflection at air would show in every one of these pictures.
fn stack(gap: f64, degrees: f64, coated: Option<usize>, priorities: [i32; 2]) -> Scene {
    let mut s = kit::scene(0.01, 1);
    let turn = DAffine3::from_translation(DVec3::NEG_Z * 0.5) * DAffine3::from_rotation_x(degrees.to_radians());
    let half = DVec3::new(0.4, 0.4, 0.001);
    for (k, (index, z)) in [(CROWN, 0.001 + 0.5 * gap), (FLINT, -0.001 - 0.5 * gap)].into_iter().enumerate() {
        let to_world = turn * DAffine3::from_translation(DVec3::Z * z);
        let mut faces = vec![kit::face(Finish::Polished); 6];
        if coated == Some(k) {
            // +z of the lower one, −z of the upper one: the shared face.
            let film = kit::film(&mut s, Dispersion::Constant(2.2), 62.5);
            faces[if k == 0 { 4 } else { 5 }].coating = Some(film);
        }
        let part = kit::add(&mut s, kit::mesh(&kit::cuboid(half)), to_world, Some(index), faces);
        s.parts[part].priority = priorities[k];
    }
    kit::panel(&mut s, 1000.0, kit::quad(DVec3::NEG_Z * 1.5, DVec3::X * 0.2, DVec3::Y * 0.2));
    s
}

#[test]
fn plates_that_touch_have_three_faces() {
    for degrees in [0.0f64, 45.0, 75.0] {
        let sin = degrees.to_radians().sin();
        let want = 1000.0 * closed::plates(&[1.0, CROWN, FLINT, 1.0], sin);
        let apart = 1000.0 * closed::plates(&[1.0, CROWN, 1.0, FLINT, 1.0], sin);
        for gap in [0.0, 1e-9, 1e-8, 1e-6, -1e-9, -1e-6] {
            let got = trace(&stack(gap, degrees, None, [0, 0]), How::backward(1000).polarised()).expect("it is traced");
            let (name, noise) = (format!("gap {gap:e}, {degrees}°"), got.sigma + 1e-5 * want);
            assert!(got.sigma < 2e-3 * want && (got.mean - want).abs() < 4.0 * noise, "{name}: {got:?} {want}");
            assert!(got.loss.abs() < 1e-12 + 4.0 * got.loss_sigma && got.nan == 0, "{name}: {got:?}");
            assert_eq!((got.mismatches, got.cut), (0.0, 0.0), "{name}: {got:?}");
            assert!((apart - want).abs() > 8.0 * got.sigma, "the test bites: {apart} {want} {got:?}");
        }
        let gap = trace(&stack(1e-3, degrees, None, [0, 0]), How::backward(1000).polarised()).expect("it is traced");
        assert!((gap.mean - apart).abs() < 4.0 * gap.sigma + 4e-5 * apart, "{degrees}°: {gap:?} {apart}");
    }
}

/// At a shared face the coating of the higher priority holds, among equals that of the first in the asset.
#[test]
fn the_coating_of_the_higher_priority_holds() {
    let bare = 1000.0 * closed::plates(&[1.0, CROWN, FLINT, 1.0], 0.0);
    let of = |n1: f64, n2: f64| closed::reflectance(n1, n2, 0.0, 1.0)[0];
    let film = closed::film(CROWN, [2.2, 0.0], 62.5, FLINT, 550.0)[0];
    let sum: f64 = [of(1.0, CROWN), film, of(FLINT, 1.0)].iter().map(|r| r / (1.0 - r)).sum();
    let coated = 1000.0 / (1.0 + sum);
    assert!((coated / bare - 1.0).abs() > 0.02, "{coated} {bare}");
    for gap in [0.0, 1e-9, -1e-9, -1e-6] {
        for (which, priorities, want) in [
            (0, [0, 0], coated),
            (1, [0, 0], bare),
            (0, [0, 1], bare),
            (1, [0, 1], coated),
            (0, [1, 0], coated),
            (1, [1, 0], bare),
        ] {
            let got = trace(&stack(gap, 0.0, Some(which), priorities), How::backward(500)).expect("it is traced");
            let noise = got.sigma + 1e-5 * want;
            assert!((got.mean - want).abs() < 4.0 * noise, "{gap:e} {which} {priorities:?}: {got:?} {want}");
        }
    }
}

long! {
/// The picture of a panel through the doublet from the eye and from the lamp, and its brightness near the axis.
#[test]
fn forward_is_backward_through_a_doublet() {
    for gap in [0.0, 1e-9, -1e-6] {
        let mut s = doublet(Kind::Spheres, gap, [0, 0]);
        s.eye.pupil_diameter_m = 0.004;
        kit::panel(&mut s, 1000.0, kit::quad(DVec3::Z * 0.06, DVec3::Y * 0.02, DVec3::X * 0.02));
        let on_axis = trace(&s, How::backward(64)).expect("it is traced");
        let want: f64 = [(1.0, CROWN), (CROWN, FLINT), (FLINT, 1.0)]
            .iter()
            .map(|(n1, n2)| 1.0 - closed::reflectance(*n1, *n2, 0.0, 1.0)[0])
            .product();
        // Light that was reflected twice comes on top: 0.4 %.
        assert!((on_axis.mean / 1000.0 / want - 1.002).abs() < 3e-3, "{on_axis:?} {want}");
        s.eye.pupil_diameter_m = 0.04;
        s.eye.fov_deg = 16.0;
        let back = trace(&s, How::backward(2000)).expect("it is traced");
        let forth = trace(&s, How { estimator: Estimator::Forward, ..How::backward(1000) }).expect("it is traced");
        let sigma = back.sigma.hypot(forth.sigma);
        assert!(sigma < 5e-3 * back.mean, "{back:?} {forth:?}");
        assert!((back.mean - forth.mean).abs() < 4.0 * sigma, "gap {gap:e}: {back:?} {forth:?}");
        for got in [back, forth] {
            assert!(got.loss.abs() < 1e-12 + 4.0 * got.loss_sigma && got.nan == 0, "gap {gap:e}: {got:?}");
        }
    }
}
}
