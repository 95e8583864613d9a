//! Synthetic cylinders and tori with f32 vertices: the oracle is the closed form that made the points.

use super::*;
use glam::DQuat;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// A mesh over a rectangle of parameters, turned and moved.
fn mesh(
    [from, to]: [[f64; 2]; 2],
    [nu, nv]: [u32; 2],
    place: impl Fn(f64, f64) -> DVec3,
) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let turn = turn();
    let mut points = Vec::new();
    for j in 0..=nv {
        for i in 0..=nu {
            let at = |k: u32, n: u32, c: usize| from[c] + (to[c] - from[c]) * f64::from(k) / f64::from(n);
            let p = turn * place(at(i, nu, 0), at(j, nv, 1)) + SHIFT;
            points.push(p.as_vec3().to_array());
        }
    }
    let mut triangles = Vec::new();
    for j in 0..nv {
        for i in 0..nu {
            let a = j * (nu + 1) + i;
            triangles.extend([[a, a + 1, a + nu + 2], [a, a + nu + 2, a + nu + 1]]);
        }
    }
    (points, triangles)
}

const SHIFT: DVec3 = DVec3::new(30.0, -70.0, 20.0);

fn turn() -> DQuat {
    DQuat::from_axis_angle(DVec3::new(0.3, -0.8, 0.5).normalize(), 1.1)
}

/// A torus about x with its ring in the y–z plane: angle around the axis, angle around the tube from the outside.
fn torus(ring: f64, tube: f64, around: f64, along: f64) -> DVec3 {
    let rho = ring + tube * along.cos();
    DVec3::new(tube * along.sin(), rho * around.sin(), rho * around.cos())
}

#[test]
fn cylinders() {
    for (name, radius, half_angle, half_length, nu, nv, limit) in [
        ("lens", 50.0, 0.3, 10.0, 20, 12, 1e-5),
        ("weak", 400.0, 0.03, 12.0, 20, 12, 2e-4),
        ("half pipe", 8.0, FRAC_PI_2, 20.0, 24, 4, 1e-6),
        ("tube", 5.0, PI, 10.0, 36, 4, 1e-6),
        ("short tube", 12.0, PI, 1.0, 36, 3, 1e-6),
    ] {
        let (points, triangles) = mesh([[-half_angle, -half_length], [half_angle, half_length]], [nu, nv], |a, h| {
            DVec3::new(h, radius * a.sin(), radius * a.cos())
        });
        for kind in [None, Some(Kind::Cylinder)] {
            let found = fit(&points, &triangles, kind, 0.0).unwrap_or_else(|e| panic!("{name}: {e}"));
            let Fitted::Cylinder { vertex, axis, x, radius: r } = found.surface else { panic!("{name}: {found:?}") };
            let lean = x.cross(turn() * DVec3::X).length();
            // The axis of revolution passes through the origin of the model.
            let on_axis = vertex + r * axis - SHIFT;
            let off = (on_axis - on_axis.dot(x) * x).length();
            println!(
                "cylinder {name}: dR/R {:+.1e} lean {lean:.1e} off {off:.1e} max {:.1e}",
                r / radius - 1.0,
                found.max_residual
            );
            assert!((r / radius - 1.0).abs() < limit && off < limit * radius, "{name}: {r} {off}");
            assert!(lean < 1e-5 && axis.dot(x).abs() < 1e-12, "{name}: {lean}");
            if half_angle < 3.0 {
                let middle = turn() * DVec3::new(0.0, 0.0, radius) + SHIFT;
                assert!(vertex.distance(middle) < 0.02 * radius, "{name}: the vertex is not amid the face");
            }
        }
    }
}

#[test]
fn tori() {
    let cap = |half: f64, radius: f64| half / radius;
    for (name, ring, tube, around, along, outside, limit) in [
        // Lenses: R = ring ± tube about the axis, the tube's radius along it.
        ("toric lens", 40.0, 40.0, cap(12.0, 80.0), cap(12.0, 40.0), true, 1e-4),
        ("weak toric", 200.0, 300.0, cap(15.0, 500.0), cap(15.0, 300.0), true, 5e-3),
        ("saddle", 100.0, 45.0, cap(12.0, 55.0), cap(12.0, 45.0), false, 1e-4),
        ("fillet", 20.0, 3.0, PI, FRAC_PI_2, true, 1e-6),
        ("ring", 10.0, 2.0, PI, PI, true, 1e-6),
        ("groove", 15.0, 4.0, PI, 1.2, false, 1e-6),
    ] {
        let middle = if outside { 0.0 } else { PI };
        let (points, triangles) =
            mesh([[-around, middle - along], [around, middle + along]], [30, 16], |a, b| torus(ring, tube, a, b));
        for kind in [None, Some(Kind::Toroid)] {
            let found = fit(&points, &triangles, kind, 0.0).unwrap_or_else(|e| panic!("{name}: {e}"));
            let Fitted::Toroid { vertex, axis, x, radius, tube_radius } = found.surface else {
                panic!("{name}: {found:?}")
            };
            let (want, want_tube) = if outside { (ring + tube, tube) } else { (ring - tube, -tube) };
            let lean = x.cross(turn() * DVec3::X).length();
            let centre = (vertex + radius * axis - SHIFT).length();
            println!(
                "torus {name}: dR/R {:+.1e} dr/r {:+.1e} lean {lean:.1e} centre {centre:.1e} max {:.1e}",
                radius / want - 1.0,
                tube_radius / want_tube - 1.0,
                found.max_residual
            );
            // Of a closed ring either equator may be the vertex'.
            let other = name == "ring" && (radius - (ring - tube)).abs() < 1.0;
            let (want, want_tube) = if other { (ring - tube, -tube) } else { (want, want_tube) };
            assert!((radius / want - 1.0).abs() < limit, "{name}: {radius}");
            assert!((tube_radius / want_tube - 1.0).abs() < limit, "{name}: {tube_radius}");
            assert!(centre < limit * (want + tube) && lean < limit.max(1e-5) * 4.0, "{name}: {centre} {lean}");
        }
    }
    // A barrel: the tube is wider than the ring.
    let (points, triangles) = mesh([[-0.3, -0.12], [0.3, 0.12]], [20, 16], |a, b| {
        let rho = 90.0 * b.cos() - 50.0;
        DVec3::new(90.0 * b.sin(), rho * a.sin(), rho * a.cos())
    });
    let found = fit(&points, &triangles, None, 0.0).expect("a barrel");
    let Fitted::Toroid { radius, tube_radius, .. } = found.surface else { panic!("{found:?}") };
    assert!((radius / 40.0 - 1.0).abs() < 1e-4 && (tube_radius / 90.0 - 1.0).abs() < 1e-4, "{found:?}");
}

#[test]
fn noise_of_a_ten_thousandth_is_within_the_tolerance_and_more_is_not() {
    let jitter = |x: f64, y: f64| 1e-4 * (12.9898 * x + 78.233 * y).sin();
    let (points, triangles) = mesh([[-0.3, -0.25], [0.3, 0.25]], [24, 20], |a, b| {
        torus(60.0, 30.0, a, b) * (1.0 + jitter(977.0 * a, 1013.0 * b) / 90.0)
    });
    let found = fit(&points, &triangles, None, 2e-4).expect("below the tolerance");
    let Fitted::Toroid { radius, tube_radius, .. } = found.surface else { panic!("{found:?}") };
    println!("noisy torus: {:+.1e} {:+.1e} rms {:.1e}", radius / 90.0 - 1.0, tube_radius / 30.0 - 1.0, found.rms);
    assert!((radius / 90.0 - 1.0).abs() < 2e-3 && (tube_radius / 30.0 - 1.0).abs() < 2e-3);
    assert!(matches!(fit(&points, &triangles, Some(Kind::Toroid), 2e-5), Err(FitError::Misses { .. })));
    assert!(matches!(fit(&points, &triangles, None, 2e-5), Err(FitError::Misses { asked: false, .. })));
}

#[test]
fn the_wrong_kind_is_refused() {
    let (cylinder, triangles) =
        mesh([[-0.3, -10.0], [0.3, 10.0]], [16, 12], |a, h| DVec3::new(h, 50.0 * a.sin(), 50.0 * a.cos()));
    assert!(matches!(fit(&cylinder, &triangles, Some(Kind::Toroid), 1e-3), Err(FitError::Undetermined { .. })));
    assert!(matches!(fit(&cylinder, &triangles, Some(Kind::Sphere), 1e-3), Err(FitError::Misses { .. })));
    let (ball, triangles) = mesh([[-0.3, -0.3], [0.3, 0.3]], [16, 16], |a, b| torus(0.0, 50.0, a, b));
    assert!(matches!(fit(&ball, &triangles, Some(Kind::Cylinder), 1e-3), Err(FitError::Misses { .. })));
    assert_eq!(fit(&ball, &triangles, None, 0.0).expect("a sphere").surface.kind(), Kind::Sphere);
    // A sphere is a torus whose ring has shrunk.
    let found = fit(&ball, &triangles, Some(Kind::Toroid), 0.0).expect("a torus of a sphere");
    let Fitted::Toroid { radius, tube_radius, .. } = found.surface else { panic!("{found:?}") };
    assert!((radius / 50.0 - 1.0).abs() < 1e-3 && (tube_radius / 50.0 - 1.0).abs() < 1e-3, "{found:?}");
    let (flat, triangles) = mesh([[-5.0, -5.0], [5.0, 5.0]], [9, 9], |a, b| DVec3::new(a, b, 0.0));
    for kind in [Kind::Cylinder, Kind::Toroid] {
        assert!(matches!(fit(&flat, &triangles, Some(kind), 1.0), Err(FitError::Undetermined { .. })), "{kind}");
    }
}

#[test]
fn odd_points_end() {
    let line: Vec<[f32; 3]> = (0..20).map(|i| [i as f32, 2.0 * i as f32, -i as f32]).collect();
    let two: Vec<[f32; 3]> = (0..40)
        .map(|i| {
            let a = TAU * f64::from(i / 2) / 20.0;
            [5.0 * a.cos() as f32, 5.0 * a.sin() as f32, (i % 2) as f32]
        })
        .collect();
    for kind in [Kind::Cylinder, Kind::Toroid] {
        assert!(fit(&line, &[], Some(kind), 1e-3).is_err());
        assert!(matches!(fit(&[[1.0; 3]; 50], &[], Some(kind), 1.0), Err(FitError::TooFew { .. })));
        let _ = fit(&two, &[], Some(kind), 1e-3);
        let _ = fit(&[[f32::MAX; 3], [f32::MIN; 3], [0.0; 3], [1e-40; 3]], &[], Some(kind), 1.0);
    }
}
