//! What rays meet, against closed forms.

use super::exact::Quadric;
use super::scenes::*;
use super::{Geometry, Ray};
use eyebox_base::rng::{Rng, Stream};
use eyebox_base::warp;
use eyebox_scene::{Finish, Shape};
use glam::{DAffine3, DVec3};

fn rng(sample: u64) -> Rng {
    Rng::new(7, Stream::Check, 0, sample)
}

fn point_in_ball(rng: &mut Rng, radius: f64) -> DVec3 {
    warp::sphere(rng.pair()) * radius * rng.uniform().cbrt()
}

/// Rays from inside a closed ball, some of them exactly at vertices and edges: none gets out, exact face or mesh.
#[test]
fn nothing_escapes_from_a_closed_ball() {
    let radius = 20.0;
    for (shape, exact) in [(sphere_shape(radius, DVec3::ZERO), true), (Shape::Mesh, false)] {
        let mesh = sphere(radius, 40, 60, DVec3::ZERO);
        let scene = scene(vec![mesh.clone()], vec![part(0, &[shape], DAffine3::from_scale(DVec3::splat(1e-3)))]);
        let geometry = Geometry::build(&scene).unwrap();
        let to_world = geometry.part_to_world(0);
        let mut rng = rng(1);
        for i in 0..1_000_000u32 {
            // The facets lie up to 0.4 % inside the sphere.
            let origin = to_world.transform_point3(point_in_ball(&mut rng, 0.99 * radius));
            let corner = |k: usize, t: usize| super::patch::vertex(mesh.positions[mesh.triangles[t][k] as usize]);
            let triangle = (rng.uniform() * mesh.triangles.len() as f64) as usize;
            let dir = match i % 4 {
                0 => to_world.transform_point3(corner(0, triangle)) - origin,
                1 => {
                    let t = rng.uniform();
                    to_world.transform_point3(corner(0, triangle) * t + corner(1, triangle) * (1.0 - t)) - origin
                }
                _ => warp::sphere(rng.pair()),
            };
            let ray = Ray { origin, dir: dir.normalize(), from: None };
            let hit = geometry.intersect(&ray, f64::INFINITY).unwrap_or_else(|| panic!("{ray:?} escaped"));
            assert!(hit.normal.dot(ray.dir) > 0.0);
            if exact {
                assert!((hit.local.length() - radius).abs() < 1e-13 * radius, "{}", hit.local.length() - radius);
                assert!((hit.point - (ray.origin + hit.t * ray.dir)).length() < 1e-16 + 1e-14 * radius * 1e-3);
            }
        }
    }
}

/// Chords of a ball that is one exact face: a ray that enters leaves through the same face, and so on at grazing angles.
#[test]
fn a_ball_is_entered_and_left_through_the_same_face() {
    let (radius, centre) = (2.0, DVec3::new(30.0, -10.0, 5.0));
    let geometry = alone(sphere(radius, 16, 24, centre), &[sphere_shape(radius, centre)]);
    let centre = geometry.part_to_world(0).transform_point3(centre);
    let radius = radius * 1e-3;
    let mut rng = rng(2);
    for _ in 0..20_000 {
        let start = centre + warp::sphere(rng.pair()) * 0.05;
        let aim = centre + warp::sphere(rng.pair()) * radius * 0.999 * rng.uniform();
        let ray = Ray { origin: start, dir: (aim - start).normalize(), from: None };
        let hit = geometry.intersect(&ray, f64::INFINITY).expect("aimed at the ball");
        assert!(hit.normal.dot(ray.dir) < 0.0 && hit.normal == hit.shading);
        // From the surface inwards at an angle to the tangent down to 1e-9 rad.
        let grazing = 10f64.powf(-9.0 * rng.uniform());
        let tangent = warp::Frame::about(hit.normal).x;
        let dir = (tangent - grazing * hit.normal).normalize();
        let inside = geometry.onwards(&hit, dir);
        let exit = geometry.intersect(&inside, f64::INFINITY).expect("a way out");
        // The normal itself is known to one rounding, hence so is the sine of the angle.
        let chord = -2.0 * radius * dir.dot(hit.normal);
        assert!((exit.t - chord).abs() <= 1e-12 * chord + 1e-15 * radius * 100.0, "{grazing}: {} {chord}", exit.t);
        assert!(exit.normal.dot(dir) > 0.0);
        // Outwards it is gone, and from the exit too.
        assert_eq!(geometry.intersect(&geometry.onwards(&exit, dir), f64::INFINITY), None);
        assert_eq!(geometry.intersect(&geometry.onwards(&hit, -dir), f64::INFINITY), None);
        assert!(!geometry.occluded(&geometry.onwards(&hit, -dir), f64::INFINITY, None));
        assert!(geometry.occluded(&inside, 1.001 * exit.t, None));
        assert!(!geometry.occluded(&inside, 0.999 * exit.t, None));
        assert!(!geometry.occluded(&inside, f64::INFINITY, Some(exit.site)));
    }
}

/// The caps of a lens are their conics out to the aperture, however coarse the mesh is.
#[test]
fn a_coarse_lens_has_exact_caps() {
    for (radii, conic) in
        [([50.0, -40.0], [0.0, -0.6]), ([-30.0, -20.0], [-1.5, 0.3]), ([25.0, f64::INFINITY], [-1.0, 0.0])]
    {
        let (aperture, thickness, around) = (12.0, 9.0, 12);
        let (mesh, shapes) = lens(radii, conic, aperture, thickness, 2, around);
        let geometry = alone(mesh, &shapes);
        let to_world = geometry.part_to_world(0);
        let mut rng = rng(3);
        // The mesh ends at a polygon.
        let inner = aperture * (std::f64::consts::PI / f64::from(around)).cos() * 0.999;
        for _ in 0..20_000 {
            let aim = warp::disk(rng.pair()) * inner;
            let aim = DVec3::new(aim.x, aim.y, 0.0);
            let entry = Quadric::from_shape(&shapes[0]).unwrap();
            let aim = aim + DVec3::Z * entry.sag(aim.length_squared());
            let origin = DVec3::new(4.0 * rng.uniform() - 2.0, 4.0 * rng.uniform() - 2.0, -400.0);
            let ray = Ray {
                origin: to_world.transform_point3(origin),
                dir: to_world.transform_vector3(aim - origin).normalize(),
                from: None,
            };
            let hit = geometry.intersect(&ray, f64::INFINITY).expect("through the aperture");
            assert_eq!(hit.site.face, 0, "{aim}");
            assert!((hit.local - aim).length() < 2e-13 * 400.0, "{:?}", hit.local - aim);
            assert!(hit.normal.z < 0.0 && (hit.normal + entry.normal(aim)).length() < 1e-12);
            let next = geometry.intersect(&geometry.onwards(&hit, DVec3::Z), f64::INFINITY).expect("an exit");
            let exit = Quadric::from_shape(&shapes[2]).unwrap();
            let want = exit.vertex.z + exit.sag(hit.local.x.powi(2) + hit.local.y.powi(2));
            assert_eq!(next.site.face, 2);
            assert!((next.local.z - want).abs() < 1e-13 && next.normal.z > 0.0);
        }
    }
}

/// A shift by 10 km and a scale by 10^±3 change no hit but by the rounding of the shift.
#[test]
fn place_and_scale_do_not_matter() {
    let here = Geometry::build(&assembly(DAffine3::IDENTITY)).unwrap();
    for scale in [1.0, 1e-3, 1e3] {
        let shift = DVec3::new(1e4, -2e3, 5e3) * if scale == 1.0 { 1.0 } else { 0.0 };
        let place = DAffine3::from_scale_rotation_translation(DVec3::splat(scale), glam::DQuat::IDENTITY, shift);
        let there = Geometry::build(&assembly(place)).unwrap();
        let tolerance = 1e-13 + 4.0 * f64::EPSILON * shift.length() / scale;
        let mut rng = rng(4);
        let (mut hits, mut others) = (0, 0);
        for _ in 0..50_000 {
            let ray = random_ray(&here, &mut rng);
            let moved = |p: DVec3| place.transform_point3(p + here.origin()) - there.origin();
            let other = Ray { origin: moved(ray.origin), ..ray };
            match (here.intersect(&ray, f64::INFINITY), there.intersect(&other, f64::INFINITY)) {
                (Some(a), Some(b)) if a.site.is_on_face_of(b.site) => {
                    let cos = a.normal.dot(ray.dir).abs();
                    // A point that moves by a rounding moves its hit by that over the cosine, near tangents by its root.
                    let near = (tolerance * (1.0 + a.t)) / cos.max(1e-6);
                    assert!((b.t / scale - a.t).abs() < 20.0 * near, "{scale}: {} {} {cos}", a.t, b.t / scale);
                    assert!((b.normal - a.normal).length() < 1e5 * near);
                    hits += 1;
                }
                (None, None) => {}
                // The edge of a silhouette.
                (Some(_) | None, _) => others += 1,
            }
        }
        assert!(hits > 10_000 && others <= 2, "{hits} {others}");
    }
}

#[test]
fn faces_without_light_are_left_out_and_emitters_are_flat() {
    let (mesh, shapes) = lens([50.0, -40.0], [0.0, 0.0], 10.0, 6.0, 2, 12);
    let mm = DAffine3::from_scale(DVec3::splat(1e-3));
    let mut scene = scene(vec![mesh], vec![part(0, &shapes, mm)]);
    scene.parts[0].faces[0].finish = Finish::None;
    let ray = |g: &Geometry| Ray { origin: DVec3::new(1e-3, 2e-3, -0.1) - g.origin(), dir: DVec3::Z, from: None };
    let geometry = Geometry::build(&scene).unwrap();
    let hit = geometry.intersect(&ray(&geometry), f64::INFINITY).unwrap();
    assert_eq!((hit.site.face, hit.normal.z > 0.0), (2, true));
    scene.parts[0].faces[0].emitter = Some(emitter());
    let geometry = Geometry::build(&scene).unwrap();
    let hit = geometry.intersect(&ray(&geometry), f64::INFINITY).unwrap();
    let exact = Quadric::from_shape(&shapes[0]).unwrap();
    // A facet of a coarse cap, not the cap.
    assert!(hit.site.face == 0 && exact.distance(hit.local) > 1e-3, "{}", exact.distance(hit.local));
    assert!(hit.shading.dot(hit.normal) > 0.9 && hit.shading != hit.normal);
}

#[test]
fn points_know_their_solids() {
    let scene = assembly(DAffine3::IDENTITY);
    let geometry = Geometry::build(&scene).unwrap();
    // Part, a point in its mesh coordinates, whether inside.
    for (part, local, inside) in [
        (0u32, DVec3::new(1.0, 2.0, 4.0), true),
        (0, DVec3::new(1.0, 2.0, -1.0), false),
        (0, DVec3::new(0.0, 0.0, 1e-9), true),
        (0, DVec3::new(0.0, 0.0, -1e-9), false),
        (1, DVec3::new(14.0, 0.0, 3.0), true),
        (2, DVec3::new(0.0, 0.0, 1.0), true),
        (2, DVec3::new(9.0, 0.0, 0.0), true),
        (2, DVec3::new(0.0, 0.0, -1.0), false),
        (3, DVec3::new(1.0, 2.0, 3.0), true),
        (4, DVec3::new(1.0, 2.0, 3.0), true),
        (4, DVec3::new(1.0, 2.0, 10.1), false),
        (5, DVec3::new(0.0, 0.0, 1.0), true),
        (7, DVec3::new(19.0, 14.0, 1.9), true),
        (7, DVec3::new(19.0, 15.1, 1.9), false),
    ] {
        let p = geometry.part_to_world(part).transform_point3(local);
        assert_eq!(geometry.solids_containing(p).contains(&part), inside, "{part} {local}");
    }
    assert!(geometry.solids_containing(DVec3::splat(1e3)).is_empty());
}

/// A box of flat faces without a shape: each is met from both sides, the far ones through the near ones, and what lies
/// beside is not.
#[test]
fn a_face_of_a_mesh_is_met_through_others_of_its_part() {
    let flat: Vec<Shape> = (0..6).map(|_| Shape::Mesh).collect();
    let geometry = alone(cuboid(DVec3::splat(-1.0), DVec3::ONE), &flat);
    let at = |local: DVec3| geometry.part_to_world(0).transform_point3(local);
    let ray = |x: f64| Ray { origin: at(DVec3::new(x, 0.3, -5.0)), dir: DVec3::Z, from: None };
    for (face, z) in [(4u32, -1.0), (5, 1.0)] {
        let meet = geometry.meet(0, face, &ray(0.2), DVec3::ZERO).expect("the ray crosses it");
        let want = at(DVec3::new(0.2, 0.3, z));
        assert!((meet.point - want).length() < 1e-15 && (meet.t - 1e-3 * (5.0 + z)).abs() < 1e-15, "{meet:?}");
        assert!((meet.normal - DVec3::Z * z).length() < 1e-12, "{meet:?}");
        assert!(geometry.meet(0, face, &ray(1.1), DVec3::ZERO).is_none());
    }
    assert!(geometry.meet(0, 0, &ray(0.2), DVec3::ZERO).is_none());
}
