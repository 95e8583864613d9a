//! Strips and caps whose normals are known, against the normal that a ray meets and the one that it should meet.

use super::*;

/// A strip of a cylinder of radius 1 in facets of 2°, with its own normals and with flat ones.
#[test]
fn blur_of_a_strip() {
    let step = 2f64.to_radians();
    let (mut smooth, mut flat) = (Mesh::default(), Mesh::default());
    for i in 0..8u32 {
        let at = |k: u32| f64::from(k) * step;
        let side = |angle: f64, z: f32| [angle.cos() as f32, angle.sin() as f32, z];
        let ends = [at(i), at(i + 1)];
        let corners = [side(ends[0], 0.0), side(ends[1], 0.0), side(ends[1], 1.0), side(ends[0], 1.0)];
        for (mesh, normals) in [
            (&mut smooth, [ends[0], ends[1], ends[1], ends[0]].map(|a| side(a, 0.0))),
            (&mut flat, [side(0.5 * (ends[0] + ends[1]), 0.0); 4]),
        ] {
            mesh.positions.extend(corners);
            mesh.normals.extend(normals);
            mesh.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t: [u32; 3]| t.map(|v| v + 4 * i)));
        }
    }
    let range = FaceRange { first: 0, count: 16 };
    let (smooth, flat) = (of(&smooth, range), of(&flat, range));
    assert!((smooth.arcmin() - step * step / 4.0 / ARCMIN).abs() < 1e-3, "{smooth:?}");
    assert!(flat.steps_arcmin > 0.8 * 120.0 && flat.steps_arcmin <= 120.001 && flat.sag_arcmin == 0.0, "{flat:?}");
}

/// A shallow freeform mirror, z = x²/2R + y²/2R + a·x³, over a square: its height and its unit normal.
const RADIUS: f64 = 0.6;
const CUBIC: f64 = 0.4;

fn height([x, y]: [f64; 2]) -> f64 {
    (x * x + y * y) / (2.0 * RADIUS) + CUBIC * x * x * x
}

fn true_normal([x, y]: [f64; 2]) -> DVec3 {
    DVec3::new(-x / RADIUS - 3.0 * CUBIC * x * x, -y / RADIUS, 1.0).normalize()
}

/// The mirror in squares of `step`, each of two triangles; its normals as `normal` has them.
fn mirror(step: f64, normal: impl Fn([f64; 2], usize) -> DVec3) -> Mesh {
    let half = 0.05;
    let count = (2.0 * half / step).round() as usize;
    let mut mesh = Mesh::default();
    for i in 0..(count + 1) * (count + 1) {
        let at = [i % (count + 1), i / (count + 1)].map(|k| -half + step * k as f64);
        mesh.positions.push([at[0], at[1], height(at)].map(|x| x as f32));
        mesh.normals.push(normal(at, i).to_array().map(|x| x as f32));
    }
    for i in 0..count * count {
        let corner = |x: usize, y: usize| ((i / count + y) * (count + 1) + i % count + x) as u32;
        mesh.triangles.push([corner(0, 0), corner(1, 0), corner(1, 1)]);
        mesh.triangles.push([corner(0, 0), corner(1, 1), corner(0, 1)]);
    }
    mesh.faces = vec![FaceRange { first: 0, count: 2 * (count * count) as u32 }];
    mesh
}

/// What a mirrored ray at 45° to the axis in x misses its direction by, root mean square over many rays, arc minutes: it meets the
/// flat facet with the interpolated normal, and should have met the surface with its own.
fn traced(mesh: &Mesh) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for triangle in &mesh.triangles {
        let corner = |k: usize| DVec3::from_array(mesh.positions[triangle[k] as usize].map(f64::from));
        let normal = |k: usize| DVec3::from_array(mesh.normals[triangle[k] as usize].map(f64::from));
        for [a, b, c] in
            [[0.6, 0.2, 0.2], [0.2, 0.6, 0.2], [0.2, 0.2, 0.6], [0.4, 0.4, 0.2], [0.2, 0.4, 0.4], [0.4, 0.2, 0.4]]
        {
            let point = corner(0) * a + corner(1) * b + corner(2) * c;
            let met = (normal(0) * a + normal(1) * b + normal(2) * c).normalize();
            // On along (1, 0, −1), or back, until the surface is there.
            let mut place = point;
            for _ in 0..20 {
                let above = place.z - height([place.x, place.y]);
                place += above * DVec3::new(1.0, 0.0, -1.0);
            }
            let off = 2.0 * met.cross(true_normal([place.x, place.y])).length();
            sum += off * off;
            count += 1.0;
        }
    }
    (sum / count).sqrt() / ARCMIN
}

/// Foretold within a factor of 2.5 of what rays do, for fine and coarse facets with the normals of the surface, with normals
/// that are off by chance, and with the means of the facets' own normals, as programs make them where a file has none.
#[test]
fn what_is_foretold_is_what_rays_do() {
    let tilt = |size: f64, i: usize| {
        let turn = 2.4 * i as f64;
        size * DVec3::new(turn.cos(), turn.sin(), 0.0)
    };
    for step in [0.001, 0.002, 0.005, 0.01] {
        for off in [0.0, 1e-4, 1e-3] {
            let mesh = mirror(step, |at, i| (true_normal(at) + tilt(off, i)).normalize());
            let (foretold, real) = (of(&mesh, mesh.faces[0]).arcmin(), traced(&mesh));
            assert!(foretold < 2.5 * real && real < 2.5 * foretold, "{step} m, {off}: {foretold} {real}");
        }
    }
}

/// A plane mirror does nothing, wherever it lies; nor does what is out of range.
#[test]
fn a_plane_is_exact() {
    let mut mesh = mirror(0.01, |_, _| DVec3::Z);
    let tilted = DVec3::new(0.3, -0.2, 1.0).normalize();
    for (position, normal) in mesh.positions.iter_mut().zip(&mut mesh.normals) {
        let [x, y] = [position[0], position[1]].map(f64::from);
        *position = [x + 3.0, y - 7.0, -(0.3 * x - 0.2 * y) + 5.0].map(|x| x as f32);
        *normal = tilted.to_array().map(|x| x as f32);
    }
    assert!(of(&mesh, mesh.faces[0]).arcmin() < 0.02, "{:?}", of(&mesh, mesh.faces[0]));
    mesh.triangles[0] = [9999; 3];
    mesh.positions[3] = [f32::NAN; 3];
    assert!(of(&mesh, mesh.faces[0]).arcmin().is_finite());
    assert_eq!(of(&mesh, FaceRange { first: u32::MAX, count: u32::MAX }), Facets::default());
}
