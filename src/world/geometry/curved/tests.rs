//! Roots against dense sampling of textbook heights, closed forms where a line starts on the surface, and whole faces
//! against trying every triangle.

use super::Curved;
use crate::geometry::brute_tests::check;
use crate::geometry::scenes::{Builder, part, random_ray, scene};
use crate::geometry::{Geometry, Ray};
use eyebox_base::rng::{Rng, Stream};
use eyebox_base::warp;
use eyebox_scene::Shape;
use glam::{DAffine3, DQuat, DVec2, DVec3};
use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

/// Heights as textbooks write them, in the frame of the shape; independent of `height`.
fn textbook(shape: &Shape, x: f64, y: f64) -> f64 {
    let conic = |radius: f64, k: f64| {
        let (c, r2) = (1.0 / radius, x * x + y * y);
        c * r2 / (1.0 + (1.0 - (1.0 + k) * c * c * r2).sqrt())
    };
    match shape {
        Shape::Asphere { radius, conic: k, even, .. } => {
            let r = x.hypot(y);
            conic(*radius, *k) + even.iter().enumerate().map(|(i, a)| a * r.powi(2 * i as i32 + 2)).sum::<f64>()
        }
        Shape::Cylinder { radius, .. } => radius - radius.signum() * (radius * radius - y * y).sqrt(),
        Shape::Toroid { radius, tube_radius, .. } => {
            let profile = tube_radius - tube_radius.signum() * (tube_radius * tube_radius - x * x).sqrt();
            radius - radius.signum() * ((radius - profile).powi(2) - y * y).sqrt()
        }
        Shape::XyPoly { radius, conic: k, coeffs, .. } => {
            let mut sum = conic(*radius, *k);
            let (mut i, mut j) = (0, 0);
            for c in coeffs {
                sum += c * x.powi(i) * y.powi(j);
                (i, j) = if i == 0 { (j + 1, 0) } else { (i - 1, j + 1) };
            }
            sum
        }
        Shape::Zernike { radius, conic: k, norm_radius, coeffs, .. } => {
            // The first ten by hand.
            let (x, y) = (x / norm_radius, y / norm_radius);
            let r2 = x * x + y * y;
            let terms = [
                1.0,
                2.0 * y,
                2.0 * x,
                6f64.sqrt() * 2.0 * x * y,
                3f64.sqrt() * (2.0 * r2 - 1.0),
                6f64.sqrt() * (x * x - y * y),
                8f64.sqrt() * (3.0 * x * x * y - y * y * y),
                8f64.sqrt() * (3.0 * r2 - 2.0) * y,
                8f64.sqrt() * (3.0 * r2 - 2.0) * x,
                8f64.sqrt() * (x * x * x - 3.0 * x * y * y),
            ];
            conic(*radius, *k) + coeffs.iter().zip(terms).map(|(c, z)| c * z).sum::<f64>()
        }
        Shape::Bspline { radius, conic: k, half, spans, coeffs, .. } => {
            // The B-spline of order three as the fourth difference of cubes cut off (I. Schoenberg 1946).
            let cubic = |at: f64| {
                let cut = |x: f64| x.max(0.0).powi(3);
                (cut(at) - 4.0 * cut(at - 1.0) + 6.0 * cut(at - 2.0) - 4.0 * cut(at - 3.0) + cut(at - 4.0)) / 6.0
            };
            let [u, v] = [0, 1].map(|i| ([x, y][i] + half[i]) * f64::from(spans[i]) / (2.0 * half[i]));
            let width = spans[1] as usize + 3;
            let term =
                |(n, c): (usize, &f64)| c * cubic(u + 3.0 - (n / width) as f64) * cubic(v + 3.0 - (n % width) as f64);
            conic(*radius, *k) + coeffs.iter().enumerate().map(term).sum::<f64>()
        }
        Shape::Mesh | Shape::Plane { .. } | Shape::Sphere { .. } | Shape::Conic { .. } => f64::NAN,
    }
}

/// Axis, x and a corner of a rectangular face (half sizes) of each kind, lengths of order one.
fn shapes() -> Vec<(&'static str, Shape, DVec2)> {
    let turn = DQuat::from_euler(glam::EulerRot::XYZ, 0.4, -0.7, 1.1);
    let (vertex, axis, x) = (DVec3::new(0.3, -0.2, 0.5), turn * DVec3::Z, turn * DVec3::X);
    let half = DVec2::new(0.5, 0.4);
    vec![
        ("asphere", Shape::Asphere { vertex, axis, radius: 1.2, conic: -0.6, even: vec![0.05, -0.3, 0.8, -0.5] }, half),
        // A gull wing: a ray meets it up to four times.
        ("wings", Shape::Asphere { vertex, axis, radius: -0.7, conic: 0.0, even: vec![0.0, 9.0, -18.0] }, half),
        ("cylinder", Shape::Cylinder { vertex, axis, x, radius: -0.8 }, half),
        ("toric", Shape::Toroid { vertex, axis, x, radius: 1.3, tube_radius: 0.9 }, half),
        ("saddle", Shape::Toroid { vertex, axis, x, radius: 1.1, tube_radius: -2.0 }, half),
        (
            "polynomial",
            Shape::XyPoly {
                vertex,
                axis,
                x,
                radius: -3.0,
                conic: -2.0,
                coeffs: vec![0.01, 0.1, -0.05, 0.4, 0.3, -0.6, 0.9, -0.7, 0.2, 1.1, 2.0, -3.0, 1.0, 0.5, -1.5],
            },
            half,
        ),
        (
            "zernike",
            Shape::Zernike {
                vertex,
                axis,
                x,
                radius: 2.0,
                conic: 0.3,
                norm_radius: 0.7,
                coeffs: vec![0.1, 0.0, -0.02, 0.03, 0.05, -0.04, 0.02, 0.03, -0.01, 0.015],
            },
            half,
        ),
        (
            "bspline",
            Shape::Bspline {
                vertex,
                axis,
                x,
                radius: -2.5,
                conic: 0.4,
                half: [0.55, 0.45],
                spans: [5, 3],
                coeffs: (0..48).map(|i| 0.06 * f64::from(i * i + 1).sin()).collect(),
            },
            half,
        ),
    ]
}

/// A shape with all lengths multiplied.
fn scaled(shape: &Shape, s: f64) -> Shape {
    let mut out = shape.clone();
    match &mut out {
        Shape::Mesh => {}
        Shape::Plane { vertex, .. } => *vertex *= s,
        Shape::Sphere { vertex, radius, .. }
        | Shape::Conic { vertex, radius, .. }
        | Shape::Cylinder { vertex, radius, .. } => (*vertex, *radius) = (*vertex * s, *radius * s),
        Shape::Toroid { vertex, radius, tube_radius, .. } => {
            (*vertex, *radius, *tube_radius) = (*vertex * s, *radius * s, *tube_radius * s);
        }
        Shape::Asphere { vertex, radius, even, .. } => {
            (*vertex, *radius) = (*vertex * s, *radius * s);
            even.iter_mut().enumerate().for_each(|(i, a)| *a *= s.powi(-2 * i as i32 - 1));
        }
        Shape::XyPoly { vertex, radius, coeffs, .. } => {
            (*vertex, *radius) = (*vertex * s, *radius * s);
            let mut degree = 0;
            for (i, c) in coeffs.iter_mut().enumerate() {
                while (degree + 1) * (degree + 2) / 2 <= i {
                    degree += 1;
                }
                *c *= s.powi(1 - degree as i32);
            }
        }
        Shape::Zernike { vertex, radius, norm_radius, coeffs, .. } => {
            (*vertex, *radius, *norm_radius) = (*vertex * s, *radius * s, *norm_radius * s);
            coeffs.iter_mut().for_each(|c| *c *= s);
        }
        Shape::Bspline { vertex, radius, half, coeffs, .. } => {
            (*vertex, *radius) = (*vertex * s, *radius * s);
            half.iter_mut().chain(coeffs).for_each(|c| *c *= s);
        }
    }
    out
}

fn frame(shape: &Shape) -> (DVec3, DVec3, DVec3, DVec3) {
    let (vertex, axis, x) = match shape {
        Shape::Mesh => (DVec3::ZERO, DVec3::Z, DVec3::X),
        Shape::Plane { vertex, axis }
        | Shape::Sphere { vertex, axis, .. }
        | Shape::Conic { vertex, axis, .. }
        | Shape::Asphere { vertex, axis, .. } => (*vertex, *axis, Shape::default_x(*axis)),
        Shape::Cylinder { vertex, axis, x, .. }
        | Shape::Toroid { vertex, axis, x, .. }
        | Shape::XyPoly { vertex, axis, x, .. }
        | Shape::Zernike { vertex, axis, x, .. }
        | Shape::Bspline { vertex, axis, x, .. } => (*vertex, *axis, *x),
    };
    (vertex, x, axis.cross(x), axis)
}

/// The face's point over (x, y).
fn point(shape: &Shape, x: f64, y: f64) -> DVec3 {
    let (vertex, u, v, axis) = frame(shape);
    vertex + x * u + y * v + textbook(shape, x, y) * axis
}

fn curved(shape: &Shape, half: DVec2) -> Curved {
    let corners = (0..81).map(|i| {
        let at = |k: i32| f64::from(k) / 4.0 - 1.0;
        point(shape, half.x * at(i % 9), half.y * at(i / 9))
    });
    Curved::new(shape, corners).expect("a surface").expect("a curved one")
}

fn all(curved: &Curved, origin: DVec3, dir: DVec3, from_surface: bool) -> Vec<f64> {
    let mut found = Vec::new();
    let _ = curved.along(origin, dir, from_surface, f64::INFINITY, &mut |t, at| {
        assert!((at - origin - t * dir).length() <= 1e-14 * (origin.length() + t));
        found.push(t);
        ControlFlow::Continue(())
    });
    assert!(found.is_sorted());
    found
}

/// (x, y) of a point, and its height over the textbook surface.
fn over(shape: &Shape, p: DVec3) -> (DVec2, f64) {
    let (vertex, u, v, axis) = frame(shape);
    let q = p - vertex;
    let at = DVec2::new(q.dot(u), q.dot(v));
    (at, q.dot(axis) - textbook(shape, at.x, at.y))
}

/// Roots over the rectangle by sampling and halving; near the rectangle's edge also those outside, marked.
fn sampled(shape: &Shape, half: DVec2, origin: DVec3, dir: DVec3, to: f64) -> Vec<(f64, bool)> {
    const SAMPLES: u32 = 3000;
    let value = |t: f64| over(shape, origin + t * dir).1;
    let mut found = Vec::new();
    let step = to / f64::from(SAMPLES);
    let mut last = value(0.0);
    for i in 1..=SAMPLES {
        let (mut a, mut b) = (step * f64::from(i - 1), step * f64::from(i));
        let next = value(b);
        if last.is_finite() && next.is_finite() && (last >= 0.0) != (next >= 0.0) {
            for _ in 0..60 {
                let m = 0.5 * (a + b);
                if (value(m) >= 0.0) == (last >= 0.0) { a = m } else { b = m }
            }
            let at = over(shape, origin + a * dir).0.abs() / half;
            if at.max_element() < 1.0 + 1e-6 {
                found.push((a, at.max_element() < 1.0 - 1e-6));
            }
        }
        last = next;
    }
    found
}

/// Every root that sampling finds is found, and nothing else but what lies between two samples.
fn compare(name: &str, shape: &Shape, half: DVec2, curved: &Curved, origin: DVec3, dir: DVec3) -> usize {
    let size = half.x;
    let to = 8.0 * size;
    let want = sampled(shape, half, origin, dir, to);
    // The face's window is the rectangle and as far as its corners: all of the rectangle.
    let got = all(curved, origin, dir, false);
    let mut left = got.clone();
    for (t, inside) in &want {
        let near = left.iter().position(|g| (g - t).abs() < 1e-7 * size);
        assert!(near.is_some() || !inside, "{name}: {t} is missed of {want:?}: {got:?} from {origin} along {dir}");
        if let Some(i) = near {
            left.remove(i);
        }
    }
    for t in &left {
        let (at, off) = over(shape, origin + t * dir);
        assert!(off.abs() < 1e-12 * size, "{name}: {t} is no root, off by {off:e}");
        let rim = (at.abs() / half).max_element() > 1.0 - 1e-5;
        let twin = left.iter().any(|o| o != t && (o - t).abs() < 2.0 * to / 3000.0);
        assert!(rim || twin || *t > to, "{name}: {t} of {got:?} is more than sampling finds: {want:?}");
    }
    want.len()
}

#[test]
fn roots_are_those_of_dense_sampling() {
    for (case, (name, shape, half)) in shapes().into_iter().enumerate() {
        let mut most = 0;
        for scale in [1.0, 1e-6, 1e6] {
            let (shape, half) = (scaled(&shape, scale), half * scale);
            let curved = curved(&shape, half);
            let mut rng = Rng::new(61, Stream::Check, 0, case as u64);
            for _ in 0..if scale == 1.0 { 1200 } else { 200 } {
                let mut place = || (2.0 * DVec2::new(rng.uniform(), rng.uniform()) - 1.0) * half;
                let (a, b) = (place(), place());
                let (from, to) = (point(&shape, a.x, a.y), point(&shape, b.x, b.y));
                let dir = (to - from + 0.3 * half.x * warp::sphere(rng.pair()) * rng.uniform()).normalize();
                most = most.max(compare(name, &shape, half, &curved, from - 3.0 * half.x * dir, dir));
            }
        }
        println!("{name}: up to {most} roots");
        assert!(most >= 2, "{name}: {most}");
    }
}

/// Lines through the surface at a shallow angle and lines that pass it at a distance of 1e-9 of its size.
#[test]
fn tangents_meet_twice_or_pass() {
    for (case, (name, shape, half)) in shapes().into_iter().enumerate() {
        let curved = curved(&shape, half);
        let mut rng = Rng::new(62, Stream::Check, 0, case as u64);
        let (mut twice, mut none) = (0, 0);
        for _ in 0..800 {
            let place = (1.6 * DVec2::new(rng.uniform(), rng.uniform()) - 0.8) * half;
            let p = curved.settle(point(&shape, place.x, place.y));
            let normal = curved.normal(p);
            let dir = normal.cross(warp::sphere(rng.pair())).normalize();
            // Bending along the line: positive where the surface is on the normal's side of its tangent.
            let bent = |s: f64| curved.normal(p + s * dir).dot(dir);
            let bend = -(bent(1e-4) - bent(-1e-4)) / 2e-4;
            let change = (bent(0.01) + bent(-0.01)).abs() / 1e-4;
            // Parabolic within what is looked at.
            if bend.abs() < 0.1 || 0.01 * change > 0.5 * bend.abs() {
                continue;
            }
            for gap in [1e-9, -1e-9, 1e-12, -1e-12, 1e-6, -1e-6] {
                let origin = p + gap * normal - 0.05 * dir;
                let near = all(&curved, origin, dir, false).into_iter().filter(|t| (t - 0.05).abs() < 0.01).count();
                let distance = (2.0 * gap.abs() / bend.abs()).sqrt();
                if distance > 5e-3 {
                    continue;
                }
                if gap * bend > 0.0 {
                    assert_eq!(near, 2, "{name} {gap}: from {origin} along {dir}, bend {bend}");
                    twice += 1;
                } else {
                    assert_eq!(near, 0, "{name} {gap}: from {origin} along {dir}, bend {bend}");
                    none += 1;
                }
            }
        }
        assert!(twice > 300 && none > 300, "{name}: {twice} {none}");
    }
}

/// A paraboloid z = a r² and its rotated twin: chords in closed form, down to grazing.
#[test]
fn a_start_on_the_surface_is_no_root_and_the_next_is_exact() {
    let frame = (DVec3::new(5.0, -3.0, 2.0), DVec3::Z, DVec3::X);
    let (vertex, axis, x) = frame;
    let a = 0.25;
    let flat = 1e300;
    let paraboloids = [
        Shape::XyPoly { vertex, axis, x, radius: flat, conic: 0.0, coeffs: vec![0.0, 0.0, 0.0, a, 0.0, a] },
        Shape::Asphere { vertex, axis, radius: 0.5 / a, conic: -1.0, even: vec![0.0] },
        Shape::Asphere { vertex, axis, radius: flat, conic: 0.0, even: vec![a] },
        Shape::Zernike {
            vertex,
            axis,
            x,
            radius: flat,
            conic: 0.0,
            norm_radius: 2.0,
            coeffs: vec![2.0 * a, 0.0, 0.0, 0.0, 2.0 * a / 3f64.sqrt()],
        },
    ];
    for shape in paraboloids {
        let curved = curved(&shape, DVec2::splat(1.5));
        let mut rng = Rng::new(63, Stream::Check, 0, 0);
        let mut met = 0;
        for _ in 0..2000 {
            // Dyadic places are on the surface to the last bit.
            let place =
                DVec2::new((rng.uniform() * 16.0).floor() / 8.0 - 1.0, (rng.uniform() * 16.0).floor() / 8.0 - 1.0);
            let p = vertex + place.extend(a * place.length_squared());
            let phi = TAU * rng.uniform();
            let across = DVec2::new(phi.cos(), phi.sin());
            let lift = 10f64.powf(-10.0 * rng.uniform());
            let dir = across.extend(2.0 * a * place.dot(across) + lift);
            let (dir, length) = (dir.normalize(), dir.length());
            // z − a r² along the line: lift·s − a s², s across; the direction's rounding counts over the lift.
            let exact = (dir.z - 2.0 * a * place.dot(dir.truncate())) / (a * dir.truncate().length_squared());
            let found = all(&curved, p, dir, true);
            let end = place + exact * dir.truncate();
            if end.abs().max_element() < 1.5 {
                assert_eq!(found.len(), 1, "{shape:?} {place} {dir}: {found:?} for {exact}");
                assert!((found[0] - exact).abs() < 1e-13 * exact + 4e-15, "{shape:?} {}: {exact}", found[0] - exact);
                met += 1;
            } else if end.length() > 1.5f64.hypot(1.5) {
                assert!(found.is_empty(), "{shape:?}: {found:?}");
            }
            // Outwards nothing is ahead.
            assert!(all(&curved, p, (dir - 4.0 * lift / length * DVec3::Z).normalize(), true).is_empty());
        }
        assert!(met > 1000, "{met}");
    }
}

/// Cylinders and ring tori as wholes: a chord and, through a torus, four places, symmetric about the middle.
#[test]
fn whole_tubes() {
    let (vertex, axis, x) = (DVec3::new(-5.0, 0.0, 0.0), DVec3::X, DVec3::Z);
    let points = |n: i32| {
        (0..n).map(move |i| DVec3::new((TAU * f64::from(i) / 7.0).cos(), (TAU * f64::from(i) / 7.0).sin(), 0.0))
    };
    let cylinder = Shape::Cylinder { vertex, axis, x, radius: 5.0 };
    let ring = points(7).map(|p| 5.0 * p);
    let whole = Curved::new(&cylinder, ring).unwrap().unwrap();
    assert!(whole.shear.is_none());
    let dir = DVec3::new(0.6, 0.0, 0.8);
    let found = all(&whole, DVec3::new(-30.0, 3.0, -1.0), dir, false);
    assert!(found.len() == 2 && ((found[1] - found[0]) * 0.6 - 8.0).abs() < 1e-13, "{found:?}");
    for cos in [0.5, 1e-4, 1e-8] {
        let dir = DVec3::new(cos, (1.0f64 - cos * cos).sqrt(), 0.0);
        let found = all(&whole, vertex, dir, true);
        assert!(found.len() == 1 && (found[0] / (10.0 * cos) - 1.0).abs() < 1e-12, "{cos} {found:?}");
    }
    // Outer equator 5, tube 1: ring 4.
    let torus = Shape::Toroid { vertex, axis, x, radius: 5.0, tube_radius: 1.0 };
    let whole = Curved::new(&torus, points(7).map(|p| 5.0 * p)).unwrap().unwrap();
    assert!(whole.shear.is_none());
    let found = all(&whole, DVec3::new(-20.0, 0.0, 0.0), DVec3::X, false);
    for (t, want) in found.iter().zip([15.0, 17.0, 23.0, 25.0]) {
        assert!((t - want).abs() < 1e-13, "{found:?}");
    }
    assert_eq!(found.len(), 4);
    let found = all(&whole, vertex, DVec3::X, true);
    for (t, want) in found.iter().zip([2.0, 8.0, 10.0]) {
        assert!((t - want).abs() < 1e-13, "{found:?}");
    }
    let mut rng = Rng::new(64, Stream::Check, 0, 0);
    let mut counts = [0; 5];
    for _ in 0..5000 {
        let dir = warp::sphere(rng.pair());
        let origin = 5.0 * warp::sphere(rng.pair()) * rng.uniform() - 12.0 * dir;
        let found = all(&whole, origin, dir, false);
        let off = |t: f64| {
            let p = origin + t * dir;
            p.z.hypot(p.x.hypot(p.y) - 4.0) - 1.0
        };
        assert!(found.iter().all(|t| off(*t).abs() < 1e-12), "{found:?}");
        // By sampling.
        let signs: Vec<bool> = (0..6000).map(|i| off(f64::from(i) * 0.004) > 0.0).collect();
        let changes = signs.windows(2).filter(|w| w[0] != w[1]).count();
        let close = found.windows(2).filter(|w| w[1] - w[0] < 0.008).count();
        assert!(found.len() == changes || found.len() == changes + 2 && close > 0, "{found:?} {changes}");
        counts[found.len()] += 1;
        // And from each place on it, the others.
        for (i, t) in found.iter().enumerate() {
            let p = whole.settle(origin + t * dir);
            let rest = all(&whole, p, dir, true);
            assert_eq!(rest.len(), found.len() - 1 - i, "{found:?} {rest:?} from {i}");
            for (r, want) in rest.iter().zip(&found[i + 1..]) {
                assert!((r - (want - t)).abs() < 1e-9, "{rest:?} {found:?}");
            }
        }
    }
    assert!(counts[2] > 500 && counts[4] > 100 && counts[1] + counts[3] == 0, "{counts:?}");
}

/// A rectangular face of a shape, n × n cells.
fn face(shape: &Shape, half: DVec2, n: u32) -> Builder {
    let mut vertices = Vec::new();
    for j in 0..=n {
        for i in 0..=n {
            let at = |k: u32| 2.0 * f64::from(k) / f64::from(n) - 1.0;
            vertices.push((point(shape, half.x * at(i), half.y * at(j)), DVec3::ZERO));
        }
    }
    let mut triangles = Vec::new();
    for j in 0..n {
        for i in 0..n {
            let a = j * (n + 1) + i;
            triangles.extend([[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]);
        }
    }
    let mut builder = Builder::default();
    builder.face(&vertices, &triangles);
    builder
}

/// A closed tube: rings of a torus, or of a cylinder along z.
fn tube(torus: bool) -> (Builder, Shape) {
    let (vertex, axis, x) = (DVec3::new(-5.0, 0.0, 0.0), DVec3::X, DVec3::Z);
    let profile: Vec<[f64; 4]> = (0..=24)
        .map(|i| {
            let t = TAU * f64::from(i) / 24.0 - PI;
            if torus { [4.0 + t.cos(), t.sin(), t.cos(), t.sin()] } else { [5.0, t, 1.0, 0.0] }
        })
        .collect();
    let mut builder = Builder::default();
    builder.revolve(&profile, 48, DVec3::ZERO);
    let shape = match torus {
        true => Shape::Toroid { vertex, axis, x, radius: 5.0, tube_radius: 1.0 },
        false => Shape::Cylinder { vertex, axis, x, radius: 5.0 },
    };
    (builder, shape)
}

/// All kinds of faces, with grids and without, moved, turned, mirrored, scaled.
fn assembly(place: DAffine3) -> eyebox_scene::Scene {
    let mut meshes = Vec::new();
    let mut parts = Vec::new();
    let mut add = |builder: Builder, shapes: &[Shape], size: f64| {
        let i = parts.len() as f64;
        let turn = DAffine3::from_axis_angle(DVec3::new(0.6, 0.48, 0.64), 0.7 * i);
        let mirror = DAffine3::from_scale(DVec3::new(if parts.len() % 2 == 0 { size } else { -size }, size, size));
        let at = DAffine3::from_translation(DVec3::new(0.8 * i - 3.0, 0.3 * (i % 3.0), 0.4 * (i % 4.0)));
        meshes.push(builder.mesh);
        parts.push(part(meshes.len() as u32 - 1, shapes, place * at * turn * mirror));
    };
    for (_, shape, half) in shapes() {
        add(face(&shape, half, 7), std::slice::from_ref(&shape), 1.0);
    }
    for torus in [false, true] {
        let (builder, shape) = tube(torus);
        add(builder, &[shape], 0.1);
    }
    // Eight faces on one part: more than are looked up in grids.
    let mut many = Builder::default();
    let mut list = Vec::new();
    for (_, shape, half) in shapes().into_iter().chain(shapes().into_iter().take(1)) {
        let by = DVec3::new(0.0, 0.0, 0.4 * list.len() as f64);
        let own = face(&shape, half, 4).mesh;
        let vertices: Vec<(DVec3, DVec3)> =
            own.positions.iter().map(|p| (crate::geometry::patch::vertex(*p) + by, DVec3::ZERO)).collect();
        many.face(&vertices, &own.triangles);
        let mut moved = shape.clone();
        match &mut moved {
            Shape::Mesh => {}
            Shape::Plane { vertex, .. }
            | Shape::Sphere { vertex, .. }
            | Shape::Conic { vertex, .. }
            | Shape::Asphere { vertex, .. }
            | Shape::Cylinder { vertex, .. }
            | Shape::Toroid { vertex, .. }
            | Shape::XyPoly { vertex, .. }
            | Shape::Zernike { vertex, .. }
            | Shape::Bspline { vertex, .. } => *vertex += by,
        }
        list.push(moved);
    }
    add(many, &list, 0.6);
    let mut scene = scene(meshes, parts);
    scene.eye.position = place.transform_point3(DVec3::ZERO);
    scene
}

#[test]
fn trees_and_grids_against_every_triangle() {
    let places =
        [DAffine3::IDENTITY, DAffine3::from_scale(DVec3::splat(1e-6)), DAffine3::from_scale(DVec3::splat(1e6))];
    for (case, place) in places.into_iter().enumerate() {
        let geometry = Geometry::build(&assembly(place)).expect("valid");
        let mut rng = Rng::new(65, Stream::Check, 0, case as u64);
        let mut hits = 0;
        for _ in 0..6000 {
            let mut ray = random_ray(&geometry, &mut rng);
            for _ in 0..4 {
                let Some(hit) = check(&geometry, &ray, f64::INFINITY) else { break };
                hits += 1;
                ray = geometry.onwards(&hit, warp::sphere(rng.pair()));
            }
        }
        assert!(hits > 1000, "{hits}");
    }
}

/// Every patch is in its box: rays at random points of every triangle meet the surface near the triangle.
#[test]
fn every_triangle_is_met() {
    let scene = assembly(DAffine3::IDENTITY);
    let geometry = Geometry::build(&scene).expect("valid");
    let mut rng = Rng::new(66, Stream::Check, 0, 0);
    let (mut met, mut tried) = (0, 0);
    for (index, part) in scene.parts.iter().enumerate() {
        for triangle in 0..scene.mesh(part.mesh).triangles.len() as u32 {
            for _ in 0..6 {
                let site = crate::geometry::Site { part: index as u32, face: 0, triangle };
                let weights = warp::triangle(rng.pair());
                let aim: DVec3 = (0..3).map(|k| geometry.corner(&scene, site, k) * weights[k]).sum();
                let dir = warp::sphere(rng.pair());
                let ray = Ray { origin: aim - dir * 0.05, dir, from: None };
                tried += 1;
                met += u32::from(check(&geometry, &ray, 0.1).is_some());
            }
        }
    }
    assert!(f64::from(met) > 0.9 * f64::from(tried), "{met} of {tried}");
}

/// An assembly 1e8 sizes away is the same assembly: geometry is local.
#[test]
fn far_from_the_origin() {
    let home = assembly(DAffine3::IDENTITY);
    let mut away = home.clone();
    // A power of two, so that the translations add without rounding.
    let by = DVec3::new(2f64.powi(27), -(2f64.powi(26)), 2f64.powi(27));
    away.parts.iter_mut().for_each(|part| part.to_world.translation += by);
    away.eye.position += by;
    let (home, away) = (Geometry::build(&home).unwrap(), Geometry::build(&away).unwrap());
    assert!((away.origin() - home.origin() - by).length() < 1e-7);
    let mut rng = Rng::new(67, Stream::Check, 0, 0);
    let mut hits = 0;
    for _ in 0..3000 {
        let ray = random_ray(&home, &mut rng);
        let moved = Ray { origin: ray.origin + (home.origin() + by - away.origin()), ..ray };
        // Translations near 1e8 are rounded to 1.5e-8: grazing and rim rays may differ.
        let (a, b) = (home.intersect(&ray, f64::INFINITY), away.intersect(&moved, f64::INFINITY));
        if let (Some(a), Some(b)) = (a, b)
            && a.site.part == b.site.part
        {
            let grazing = 1e-6 / a.normal.dot(ray.dir).abs();
            assert!((a.t - b.t).abs() < grazing.max(1e-6) || a.site.face != b.site.face, "{ray:?}: {} {}", a.t, b.t);
            hits += 1;
        }
    }
    assert!(hits > 500, "{hits}");
}

/// What no lens is: refused in words, or traced in peace.
#[test]
fn hostile_parameters() {
    let half = DVec2::new(0.5, 0.4);
    let odd = [0.0, -0.0, f64::NAN, f64::INFINITY, 1e308, -1e308, 1e-308, f64::MIN_POSITIVE, 1.0, -1.0, 1e16];
    let mut rng = Rng::new(68, Stream::Check, 0, 0);
    let (mut refused, mut built) = (0, 0);
    for round in 0..3000 {
        let list = shapes();
        let (_, mut shape, _) = list[round % list.len()].clone();
        let points: Vec<DVec3> = (0..25)
            .map(|i| point(&shape, half.x * (f64::from(i % 5) / 2.0 - 1.0), half.y * (f64::from(i / 5) / 2.0 - 1.0)))
            .collect();
        let mut spoil = |x: &mut f64| {
            if rng.uniform() < 0.4 {
                *x = odd[(rng.uniform() * odd.len() as f64) as usize];
            }
        };
        match &mut shape {
            Shape::Mesh | Shape::Plane { .. } | Shape::Sphere { .. } | Shape::Conic { .. } => {}
            Shape::Asphere { radius, conic, even, .. } => {
                spoil(radius);
                spoil(conic);
                even.iter_mut().for_each(&mut spoil);
            }
            Shape::Cylinder { radius, axis, .. } => {
                spoil(radius);
                spoil(&mut axis.x);
            }
            Shape::Toroid { radius, tube_radius, x, .. } => {
                spoil(radius);
                spoil(tube_radius);
                spoil(&mut x.y);
            }
            Shape::XyPoly { radius, conic, coeffs, vertex, .. } => {
                spoil(radius);
                spoil(conic);
                spoil(&mut vertex.z);
                coeffs.iter_mut().for_each(&mut spoil);
            }
            Shape::Zernike { radius, conic, norm_radius, coeffs, .. } => {
                spoil(radius);
                spoil(conic);
                spoil(norm_radius);
                coeffs.iter_mut().for_each(&mut spoil);
            }
            Shape::Bspline { radius, conic, half, coeffs, .. } => {
                spoil(radius);
                spoil(conic);
                half.iter_mut().chain(coeffs).for_each(&mut spoil);
            }
        }
        match Curved::new(&shape, points.iter().copied()) {
            Err(why) => {
                assert!(!why.is_empty());
                refused += 1;
            }
            Ok(None) => panic!("{shape:?}"),
            Ok(Some(curved)) => {
                built += 1;
                for p in &points {
                    let dir = warp::sphere(rng.pair());
                    for (origin, from) in [(*p, true), (*p - 2.0 * dir, false), (*p * 1e300, false)] {
                        let mut count = 0;
                        let _ = curved.along(origin, dir, from, f64::INFINITY, &mut |_, _| {
                            count += 1;
                            ControlFlow::Continue(())
                        });
                        assert!(count < 10_000, "{shape:?}");
                    }
                    let _ = (curved.normal(*p), curved.settle(*p), curved.distance(*p));
                }
            }
        }
    }
    assert!(refused > 500 && built > 100, "{refused} {built}");
    let text = |shape: &Shape| Curved::new(shape, [DVec3::ZERO, DVec3::X].into_iter()).expect_err("a fault");
    let (vertex, axis, x) = (DVec3::ZERO, DVec3::Z, DVec3::X);
    assert!(text(&Shape::Cylinder { vertex, axis, x, radius: 0.0 }).contains("no surface"));
    assert!(text(&Shape::Cylinder { vertex, axis, x: DVec3::Z, radius: 1.0 }).contains("no surface"));
    let steep = Shape::Asphere { vertex, axis, radius: 0.9, conic: 0.0, even: vec![0.1] };
    assert!(text(&steep).contains("where its shape has no height"));
    let huge = Shape::Asphere { vertex, axis, radius: 9.0, conic: 0.0, even: vec![1e308, -1e308, 1e308] };
    assert!(text(&huge).contains("finite height"));
    let spindle = Shape::Toroid { vertex, axis, x, radius: 0.9, tube_radius: 0.6 };
    assert!(text(&spindle).contains("crosses itself"));
}

/// Grazing and lying lines cost bounded work.
#[test]
fn a_line_in_the_surface_ends() {
    // A saddle z = xy has straight lines in it.
    let (vertex, axis, x) = (DVec3::ZERO, DVec3::Z, DVec3::X);
    let saddle = Shape::XyPoly { vertex, axis, x, radius: 1e300, conic: 0.0, coeffs: vec![0.0, 0.0, 0.0, 0.0, 1.0] };
    let curved = curved(&saddle, DVec2::ONE);
    for y in [0.0, 0.3, 0.7] {
        let dir = DVec3::new(1.0, 0.0, y).normalize();
        let origin = DVec3::new(-3.0, y, -3.0 * y);
        let started = std::time::Instant::now();
        for _ in 0..100 {
            assert!(all(&curved, origin, dir, false).len() < 10_000);
            assert!(all(&curved, origin + 2.5 * dir, dir, true).len() < 10_000);
        }
        println!("{y}: {:.1} µs", started.elapsed().as_secs_f64() * 1e4 / 2.0);
    }
}

/// Through interior vertices and edges of the mesh nothing slips, and at the rim a line meets the face or passes it, by
/// which side it is on.
#[test]
fn edges_and_rims() {
    for (name, shape, half) in shapes() {
        let mesh = face(&shape, half, 8).mesh;
        let one = scene(vec![mesh.clone()], vec![part(0, std::slice::from_ref(&shape), DAffine3::IDENTITY)]);
        let geometry = Geometry::build(&one).expect("valid");
        let curved = curved(&shape, half);
        let to = |p: DVec3| p - geometry.origin();
        let mut rng = Rng::new(69, Stream::Check, 0, 0);
        let (vertex, u, v, axis) = frame(&shape);
        let vertices: Vec<DVec2> = (mesh.positions.iter())
            .map(|p| crate::geometry::patch::vertex(*p) - vertex)
            .map(|q| DVec2::new(q.dot(u), q.dot(v)))
            .collect();
        let mut aim = |at: DVec2, inside: bool| {
            let p = curved.settle(vertex + at.x * u + at.y * v + textbook(&shape, at.x, at.y) * axis);
            for _ in 0..20 {
                let dir = warp::sphere(rng.pair());
                if curved.normal(p).dot(dir).abs() < 0.05 {
                    continue;
                }
                let ray = Ray { origin: to(p) - 1e-3 * dir, dir, from: None };
                let met = geometry.intersect(&ray, 2e-3);
                assert_eq!(met.is_some(), inside, "{name} at {at} along {dir}");
                if let Some(hit) = met {
                    assert!((hit.t - 1e-3).abs() < 1e-14 && (hit.point - to(p)).length() < 1e-14, "{name} {at}");
                    assert!((hit.normal.dot(curved.normal(p)).abs() - 1.0).abs() < 1e-14);
                }
            }
        };
        for t in &mesh.triangles {
            let [a, b] = [0, 1].map(|k| vertices[t[k] as usize]);
            for share in [0.0, 0.25, 0.5] {
                let at = a.lerp(b, share);
                let from_rim = 1.0 - (at.abs() / half).max_element();
                if from_rim > 1e-3 {
                    aim(at, true);
                } else {
                    // Vertices of the rim are rounded to f32.
                    aim(at * (1.0 - 1e-6), true);
                    aim(at * (1.0 + 1e-6), false);
                }
            }
        }
    }
}
