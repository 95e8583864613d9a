//! Rays that start on surfaces, and the normals that they start with.

use super::scenes::*;
use super::{Geometry, Ray};
use eyebox_base::rng::{Rng, Stream};
use eyebox_base::warp;
use eyebox_scene::Shape;
use glam::{DAffine3, DVec3};

/// A point on an edge or at a vertex of a mesh in mm, for every triangle, and a ray to it from outside.
fn at_edges(geometry: &Geometry, mesh: &eyebox_scene::Mesh, rng: &mut Rng) -> Vec<Ray> {
    let to_world = geometry.part_to_world(0);
    let corner = |v: u32| to_world.transform_point3(super::patch::vertex(mesh.positions[v as usize]));
    let aim = |t: &[u32; 3], rng: &mut Rng| {
        let share = if rng.uniform() < 0.3 { 1.0 } else { rng.uniform() };
        corner(t[0]) * share + corner(t[1]) * (1.0 - share)
    };
    let ray = |t: &[u32; 3]| {
        let aim = aim(t, rng);
        let origin = aim + warp::sphere(rng.pair()) * 0.01;
        Ray { origin, dir: (aim - origin).normalize(), from: None }
    };
    mesh.triangles.iter().map(ray).collect()
}

/// From the edges of a convex body nothing of it is ahead outwards, and inwards it is a body away.
#[test]
fn a_faceted_ball_does_not_shadow_itself() {
    let mesh = sphere(3.0, 30, 40, DVec3::new(100.0, -50.0, 20.0));
    let geometry = alone(mesh.clone(), &[Shape::Mesh]);
    let mut rng = Rng::new(31, Stream::Check, 0, 0);
    let mut left = 0;
    for _ in 0..40 {
        for ray in at_edges(&geometry, &mesh, &mut rng) {
            let Some(hit) = geometry.intersect(&ray, f64::INFINITY) else { continue };
            let dir = warp::sphere(rng.pair());
            // Away from every facet around: they differ by up to 0.16 rad.
            let cos = dir.dot(hit.normal);
            if cos > 0.2 {
                assert_eq!(geometry.intersect(&geometry.onwards(&hit, dir), f64::INFINITY), None, "{ray:?} {dir}");
                left += 1;
            } else if cos < -0.2 {
                let exit = geometry.intersect(&geometry.onwards(&hit, dir), f64::INFINITY).expect("the other side");
                assert!(exit.t > 1e-4 && exit.normal.dot(dir) > 0.0, "{ray:?} {dir} {exit:?}");
            }
        }
    }
    assert!(left > 10_000, "{left}");
}

/// A ball as two faces of one exact surface: their seam is no surface of its own.
#[test]
fn a_seam_between_two_faces_of_one_sphere_is_not_there() {
    let centre = DVec3::new(1.0, 2.0, 3.0);
    let mut mesh = sphere(3.0, 10, 16, centre);
    let half = mesh.faces[0].count / 2;
    mesh.faces =
        vec![eyebox_scene::FaceRange { first: 0, count: half }, eyebox_scene::FaceRange { first: half, count: half }];
    let geometry = alone(mesh.clone(), &[sphere_shape(3.0, centre), sphere_shape(3.0, centre)]);
    let mut rng = Rng::new(32, Stream::Check, 0, 0);
    let (mut faces, mut seam) = ([0; 2], 0);
    for round in 0..200 {
        for mut ray in at_edges(&geometry, &mesh, &mut rng) {
            if round % 2 == 0 {
                // The equator is the seam.
                let middle = geometry.part_to_world(0).transform_point3(centre);
                ray.origin.z = middle.z;
                ray.dir = ((middle - ray.origin) * DVec3::new(1.0, 1.0, 0.0)).normalize_or(DVec3::X);
            }
            let Some(hit) = geometry.intersect(&ray, f64::INFINITY) else {
                assert!(round % 2 == 1, "only a tangent can miss: {ray:?}");
                continue;
            };
            faces[hit.site.face as usize] += 1;
            seam += (round % 2 == 0) as u32;
            let dir = warp::sphere(rng.pair());
            let next = geometry.intersect(&geometry.onwards(&hit, dir), f64::INFINITY);
            let chord = -2.0 * 3e-3 * dir.dot(hit.normal);
            match next {
                None => assert!(chord < 1e-15, "{chord}"),
                Some(exit) => assert!((exit.t - chord).abs() < 1e-16, "{} {chord}", exit.t),
            }
        }
    }
    assert!(faces[0] > 1000 && faces[1] > 1000 && seam > 1000, "{faces:?} {seam}");
}

/// Normals in mirrored and stretched parts are those of the triangles where they end up.
#[test]
fn normals_follow_the_surface() {
    let mesh = sphere(4.0, 12, 18, DVec3::ZERO);
    for scale in [DVec3::new(1.0, 1.0, 1.0), DVec3::new(-1.0, 1.0, 1.0), DVec3::new(1.0, -3.0, 0.4), -DVec3::ONE] {
        let turn = DAffine3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 0.9);
        let to_world = turn * DAffine3::from_scale(scale * 1e-3);
        let scene = scene(vec![mesh.clone()], vec![part(0, &[Shape::Mesh], to_world)]);
        let geometry = Geometry::build(&scene).unwrap();
        let middle = geometry.part_to_world(0).transform_point3(DVec3::ZERO);
        let mut rng = Rng::new(33, Stream::Check, 0, 0);
        for _ in 0..5000 {
            let ray = Ray { origin: middle, dir: warp::sphere(rng.pair()), from: None };
            let hit = geometry.intersect(&ray, f64::INFINITY).expect("all around");
            let [a, b, c] = [0, 1, 2].map(|k| geometry.corner(&scene, hit.site, k));
            let facet = (b - a).cross(c - a).normalize() * (scale.x * scale.y * scale.z).signum();
            assert!((hit.normal - facet).length() < 1e-12, "{scale}: {} {facet}", hit.normal);
            assert!(hit.normal.dot(ray.dir) > 0.0 && hit.shading.dot(hit.normal) > 0.0);
            // The normal of the smooth ellipsoid: the gradient of |to_local(p)|².
            let smooth = to_world.matrix3.inverse().transpose() * hit.local.normalize();
            assert!((hit.shading - smooth.normalize()).length() < 0.02, "{scale}: {}", hit.shading);
        }
    }
}
