//! The lens caps of the CAD samples against the prescription they were modelled from.

use super::cad::{find, primitives};
use super::*;

/// R (mm, positive: centre of curvature towards +z of the part), conic constant, z of the vertex: prescription.md and
/// prescription.json (`conic`, to all its digits) of the reference HUDs.
struct Cap(&'static str, &'static str, usize, f64, f64, f64);

const K: f64 = -2.2278183778808804;
const DIRECT: &str = "hud-direct/hud_direct.glb";
const DIFFUSE: &str = "hud-diffuse/hud_diffuse.glb";
const CAPS: [Cap; 11] = [
    Cap(DIRECT, "LENS_01_PMMA", 0, 49.25878, K, 0.0),
    Cap(DIRECT, "LENS_02_NBK7", 0, 103.70448, 0.0, 0.0),
    Cap(DIFFUSE, "LENS_01_PMMA", 0, 14.77763, K, 0.0),
    Cap(DIFFUSE, "LENS_02_PMMA", 2, -39.98267, K, 5.0),
    Cap(DIFFUSE, "LENS_03_NSK16", 0, 18.39533, 0.0, 0.0),
    Cap(DIFFUSE, "LENS_03_NSK16", 2, -79.68360, 0.0, 2.9521),
    Cap(DIFFUSE, "LENS_04_F2", 0, -20.29192, 0.0, 0.0),
    Cap(DIFFUSE, "LENS_04_F2", 2, 22.21328, 0.0, 1.0),
    Cap(DIFFUSE, "LENS_05_NSK16", 0, 435.76044, 0.0, 0.0),
    Cap(DIFFUSE, "LENS_05_NSK16", 2, -22.01359, 0.0, 3.2590),
    Cap(DIFFUSE, "LENS_06_NBK7", 0, 103.70448, 0.0, 0.0),
];

/// Tolerance that a sidecar would name: 0.05 µm.
const TOLERANCE: f64 = 5e-5;

#[test]
fn every_cap_gives_back_its_prescription() {
    let (mut worst_r, mut worst_k, mut worst_residual) = (0.0f64, 0.0f64, 0.0f64);
    for Cap(file, part, face, r, k, z) in CAPS {
        let all = primitives(file);
        let cap = find(&all, part, face);
        let began = std::time::Instant::now();
        let simplest = fit(&cap.positions, &cap.triangles, None, TOLERANCE).expect("a cap is a sphere or conic");
        let conic = fit(&cap.positions, &cap.triangles, Some(Kind::Conic), TOLERANCE).expect("a cap is a conic");
        let time = began.elapsed();
        let Fitted::Conic { vertex, axis, radius, conic: k_found } = conic.surface else { panic!("asked for a conic") };
        let r_signed = |axis: DVec3, radius: f64| axis.z.signum() * radius;
        let (dr, dk) = (r_signed(axis, radius) / r - 1.0, k_found - k);
        println!(
            "{part} {face}: conic dR/R {dr:+.1e} dk {dk:+.1e} dz {:+.1e} dxy {:.1e} tilt {:.1e} rms {:.1e} max {:.1e} | {:?} rms {:.1e} max {:.1e} | {} points {:?}",
            vertex.z - z,
            vertex.x.hypot(vertex.y),
            axis.x.hypot(axis.y),
            conic.rms,
            conic.max_residual,
            simplest.surface,
            simplest.rms,
            simplest.max_residual,
            conic.points,
            time,
        );
        (worst_k, worst_r) = (worst_k.max(dk.abs()), worst_r.max(dr.abs()));
        worst_residual = worst_residual.max(conic.max_residual);
        match simplest.surface {
            Fitted::Sphere { vertex, axis, radius } => {
                assert_eq!(k, 0.0, "{part} {face} is not a sphere");
                worst_r = worst_r.max((r_signed(axis, radius) / r - 1.0).abs());
                // The middle of a cap's edge is on the axis it was revolved about.
                assert!(vertex.x.hypot(vertex.y) < 1e-5 * radius && axis.z.abs() > 1.0 - 1e-9, "{vertex} {axis}");
                assert!((vertex.z - z).abs() < 1e-4, "{part} {face}: {vertex}");
            }
            Fitted::Conic { .. } => {
                assert!(k != 0.0, "{part} {face} is a sphere");
                worst_r = worst_r.max(dr.abs());
                assert!((vertex.z - z).abs() < 1e-4, "{part} {face}: {vertex}");
                assert!(vertex.x.hypot(vertex.y) < 1e-4 && axis.z.abs() > 1.0 - 1e-9, "{vertex} {axis}");
            }
            Fitted::Plane { .. }
            | Fitted::Cylinder { .. }
            | Fitted::Toroid { .. }
            | Fitted::Asphere { .. }
            | Fitted::XyPoly { .. }
            | Fitted::Zernike { .. }
            | Fitted::Bspline { .. } => {
                panic!("{part} {face} is a {}", simplest.surface.kind())
            }
        }
    }
    println!("worst dR/R {worst_r:.1e}, dk {worst_k:.1e}, residual {worst_residual:.1e} mm");
    assert!(worst_r < 3e-6 && worst_k < 2e-3 && worst_residual < 1e-5, "{worst_r:e} {worst_k:e} {worst_residual:e}");
}

#[test]
fn flat_faces_are_planes_and_rims_are_refused() {
    for file in [DIRECT, DIFFUSE] {
        for face in primitives(file) {
            let found = fit(&face.positions, &face.triangles, None, TOLERANCE);
            let cap = CAPS.iter().any(|c| c.0 == file && c.1 == face.part && c.2 == face.face);
            match found {
                Ok(Fit { surface: Fitted::Plane { axis, .. }, max_residual, .. }) => {
                    assert!(!cap && max_residual <= TOLERANCE, "{} {}", face.part, face.face);
                    let along = axis.to_array().into_iter().fold(0.0f64, |m, x| m.max(x.abs()));
                    assert!(along > 1.0 - 1e-12, "{} {}: {axis}", face.part, face.face);
                }
                Ok(_) => assert!(cap, "{} {} is no cap but came out curved: {found:?}", face.part, face.face),
                Err(error) => {
                    println!("{} {}: {error}", face.part, face.face);
                    assert!(!cap, "{} {}: {error}", face.part, face.face);
                }
            }
        }
    }
}
