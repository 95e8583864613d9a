//! Input that no exporter means: refused in words or traced in peace, never a panic or a hang.

use super::scenes::*;
use super::{Geometry, Ray, Site};
use eyebox_base::rng::{Rng, Stream};
use eyebox_scene::{Finish, Mesh, Shape};
use glam::{DAffine3, DVec3};

fn build(mesh: Mesh, shapes: &[Shape], to_world: DAffine3) -> Result<Geometry, String> {
    Geometry::build(&scene(vec![mesh], vec![part(0, shapes, to_world)])).map_err(|fault| fault.to_string())
}

fn refused(mesh: Mesh, shapes: &[Shape], to_world: DAffine3) -> String {
    build(mesh, shapes, to_world).expect_err("a fault")
}

#[test]
fn faults_say_what_and_where() {
    let ball = || sphere(7.0, 8, 12, DVec3::ZERO);
    let shape = [sphere_shape(7.0, DVec3::ZERO)];
    let one = DAffine3::IDENTITY;
    let stretched = DAffine3::from_scale(DVec3::new(1.0, 1.0, 1.01));
    let text = refused(ball(), &shape, stretched);
    assert!(text.starts_with("part TEST/P0 face 0: ") && text.contains("uniform scale"), "{text}");
    assert!(build(ball(), &[Shape::Mesh], stretched).is_ok());
    assert!(refused(ball(), &shape, DAffine3::from_scale(DVec3::new(1.0, f64::NAN, 1.0))).contains("transform"));
    assert!(refused(ball(), &[Shape::Mesh], DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0))).contains("flattens"));
    assert!(refused(ball(), &[sphere_shape(8.0, DVec3::ZERO)], one).contains("misses its mesh"));
    assert!(refused(ball(), &[sphere_shape(0.0, DVec3::ZERO)], one).contains("no surface"));
    assert!(refused(ball(), &[Shape::Mesh, Shape::Mesh], one).contains("2 faces"));
    assert!(refused(Mesh::default(), &[], one).contains("nothing"));
    let mut mesh = ball();
    mesh.positions[5][1] = f32::NAN;
    assert!(refused(mesh, &shape, one).contains("vertex at"));
    let mut mesh = ball();
    mesh.triangles[9][1] = 1_000_000;
    assert!(refused(mesh, &shape, one).contains("names vertex 1000000"));
    let mut mesh = ball();
    mesh.faces[0].count = u32::MAX;
    assert!(refused(mesh, &shape, one).contains("triangles 0 to 4294967295"));
    let mut scene = scene(vec![ball()], vec![part(0, &shape, one)]);
    scene.parts[0].mesh.0 = 9;
    assert!(Geometry::build(&scene).unwrap_err().to_string().contains("mesh 9 of 1"));
    scene.parts[0].mesh.0 = 0;
    scene.eye.position.x = f64::INFINITY;
    assert!(Geometry::build(&scene).unwrap_err().to_string().contains("the eye is at"));
    scene.eye.position.x = 0.0;
    scene.parts[0].faces[0].finish = Finish::None;
    assert!(Geometry::build(&scene).unwrap_err().to_string().contains("nothing in the scene"));
    // The far sheet of a hyperboloid is not the surface that is meant.
    let shape = Shape::Conic { vertex: DVec3::ZERO, axis: DVec3::Z, radius: 10.0, conic: -2.0 };
    let mut builder = Builder::default();
    let far = |r: f64| [r, -10.0 - (100.0 + r * r).sqrt(), 0.0, 1.0];
    builder.revolve(&[far(1.0), far(2.0), far(3.0)], 12, DVec3::ZERO);
    assert!(refused(builder.mesh, &[shape], one).contains("other sheet"));
}

fn shoot(geometry: &Geometry, rng: &mut Rng) {
    let odd = [0.0, -0.0, 1.0, -1.0, 1e-300, 1e300, f64::NAN, f64::INFINITY, f64::MIN_POSITIVE, 1e-8];
    let mut number =
        |plain: f64| if rng.uniform() < 0.3 { odd[(rng.uniform() * odd.len() as f64) as usize] } else { plain };
    for i in 0..300u32 {
        let (lo, hi) = geometry.bounds();
        let u = f64::from(i) / 300.0;
        let origin = lo + (hi - lo) * u;
        let origin = DVec3::new(number(origin.x), number(origin.y), number(origin.z));
        let dir = DVec3::new(number(u.cos()), number(u.sin()), number(0.5 - u));
        let from = Some(Site { part: i % 3, face: i % 5, triangle: i }).filter(|_| i % 2 == 0);
        for dir in [dir, dir.normalize_or_zero()] {
            let ray = Ray { origin, dir, from };
            for t_max in [f64::INFINITY, 1.0, 0.0, -1.0, f64::NAN] {
                if let Some(hit) = geometry.intersect(&ray, t_max) {
                    assert!(hit.t > 0.0 && hit.t < t_max && hit.point.is_finite() && hit.normal.is_normalized());
                }
                geometry.occluded(&ray, t_max, from);
            }
        }
        geometry.solids_containing(origin);
    }
}

#[test]
fn garbage_neither_panics_nor_hangs() {
    let mut rng = Rng::new(13, Stream::Check, 0, 0);
    let mut traced = 0;
    for case in 0..150 {
        let mut mesh = sphere(10f64.powf(rng.uniform() * 40.0 - 20.0), 4, 6, DVec3::ZERO);
        let pick = |rng: &mut Rng, n: usize| (rng.uniform() * n as f64) as usize;
        let size = 10f32.powf(rng.uniform() as f32 * 60.0 - 30.0);
        for _ in 0..pick(&mut rng, 20) {
            let v = pick(&mut rng, mesh.positions.len());
            let to = [0.0, size, -size, f32::MIN_POSITIVE, 1.0][pick(&mut rng, 5)];
            mesh.positions[v][pick(&mut rng, 3)] = to;
        }
        for _ in 0..pick(&mut rng, 10) {
            let t = pick(&mut rng, mesh.triangles.len());
            mesh.triangles[t] = [pick(&mut rng, 5) as u32, 3, pick(&mut rng, 30) as u32];
        }
        if case % 3 == 0 {
            mesh.normals.clear();
        }
        let scale = 10f64.powf(rng.uniform() * 30.0 - 15.0);
        let to_world = DAffine3::from_scale(DVec3::new(scale, scale, -scale));
        let shapes = [
            Shape::Mesh,
            sphere_shape(10f64.powf(rng.uniform() * 40.0 - 20.0), DVec3::ZERO),
            Shape::Conic {
                vertex: DVec3::ZERO,
                axis: DVec3::X,
                radius: f64::from(size),
                conic: rng.uniform() * 4.0 - 2.0,
            },
        ];
        for shape in shapes {
            if let Ok(geometry) = build(mesh.clone(), &[shape], to_world) {
                traced += 1;
                shoot(&geometry, &mut rng);
            }
        }
    }
    assert!(traced > 50, "{traced}");
}

/// Many copies of one triangle, and triangles nested at every scale.
#[test]
fn degenerate_piles() {
    let mut rng = Rng::new(14, Stream::Check, 0, 0);
    let triangle = |scale: f64| [DVec3::ZERO, DVec3::X, DVec3::Y].map(|v| (v * scale, DVec3::Z));
    for nested in [false, true] {
        let mut builder = Builder::default();
        for i in 0..3000 {
            let scale = if nested { 1.02f64.powi(i - 1500) } else { 1.0 };
            let base = builder.mesh.positions.len() as u32;
            for (p, n) in triangle(scale) {
                builder.mesh.positions.push(p.as_vec3().to_array());
                builder.mesh.normals.push(n.as_vec3().to_array());
            }
            builder.mesh.triangles.push([base, base + 1, base + 2]);
        }
        builder.mesh.faces.push(eyebox_scene::FaceRange { first: 0, count: 3000 });
        let geometry = build(builder.mesh, &[Shape::Mesh], DAffine3::IDENTITY).expect("piles can be traced");
        shoot(&geometry, &mut rng);
        let down = Ray { origin: DVec3::new(1e-3, 1e-3, 1.0) - geometry.origin(), dir: DVec3::NEG_Z, from: None };
        let hit = geometry.intersect(&down, f64::INFINITY).expect("a pile under the ray");
        assert!((hit.t - 1.0).abs() < 1e-12);
        // All of it is one plane: nothing is left for a ray that starts on it.
        assert_eq!(geometry.intersect(&geometry.onwards(&hit, DVec3::NEG_Z), f64::INFINITY), None);
    }
}
