//! Solids of nothing but triangles, four of which are tried at a time, against trying them one by one: bit for bit, for
//! rays that other tests of this kind spare.

use super::scenes::*;
use super::{Geometry, Hit, Ray, Site};
use eyebox_base::rng::{Rng, Stream};
use eyebox_base::warp;
use eyebox_scene::{FaceRange, Mesh, Shape};
use glam::{DAffine3, DVec3};

fn pick(rng: &mut Rng, count: usize) -> usize {
    ((rng.uniform() * count as f64) as usize).min(count - 1)
}

/// A facetted ball, a sheet of right angles along the axes, slivers, needles at every scale, the same triangle many times.
fn pile(rng: &mut Rng) -> Mesh {
    let mut mesh = sphere(1.0, 13, 17, DVec3::ZERO);
    let mut add = |corners: [DVec3; 3]| {
        let base = mesh.positions.len() as u32;
        mesh.positions.extend(corners.map(|p| p.as_vec3().to_array()));
        mesh.normals.extend([[0.0, 0.0, 1.0]; 3]);
        mesh.triangles.push([base, base + 1, base + 2]);
    };
    for i in 0..100u32 {
        let p = DVec3::new(f64::from(i % 10), f64::from(i / 10), -2.0) * 0.25;
        add([p, p + DVec3::X * 0.25, p + DVec3::new(0.25, 0.25, 0.0)]);
        add([p, p + DVec3::new(0.25, 0.25, 0.0), p + DVec3::Y * 0.25]);
        let (q, dir) = (warp::sphere(rng.pair()), warp::sphere(rng.pair()));
        add([q, q + dir, q + dir * 0.5 + warp::sphere(rng.pair()) * 1e-6]);
        let size = 10f64.powf(-rng.uniform() * 12.0);
        add([q, q + dir * size, q + warp::sphere(rng.pair()) * size * size]);
        add([DVec3::ZERO, DVec3::X, DVec3::Y]);
    }
    mesh.faces = vec![FaceRange { first: 0, count: mesh.triangles.len() as u32 }];
    mesh
}

fn same(geometry: &Geometry, ray: &Ray, t_max: f64) -> Option<Hit> {
    let (fast, all) = (geometry.intersect(ray, t_max), geometry.intersect_all(ray, t_max));
    let bits = |hit: &Hit| {
        let places = [hit.point, hit.local, hit.normal, hit.shading];
        (hit.t.to_bits(), hit.site, places.map(|p| p.to_array().map(f64::to_bits)))
    };
    assert_eq!(fast.as_ref().map(bits), all.as_ref().map(bits), "{ray:?} up to {t_max}");
    assert_eq!(geometry.occluded(ray, t_max, None), all.is_some(), "{ray:?} up to {t_max}");
    fast
}

#[test]
fn four_at_a_time_is_one_by_one() {
    let mut hits = 0;
    for (case, scale) in [1.0, 1e-12, 1e12].into_iter().enumerate() {
        let mut rng = Rng::new(31, Stream::Check, 0, case as u64);
        let shift = DVec3::new(0.0, 7.0, -1e3) * scale;
        let world = scene(
            vec![pile(&mut rng)],
            vec![part(
                0,
                &[Shape::Mesh],
                DAffine3::from_scale_rotation_translation(DVec3::splat(scale), Default::default(), shift),
            )],
        );
        let geometry = Geometry::build(&world).unwrap();
        let count = world.meshes[0].triangles.len();
        for _ in 0..12_000 {
            let site = Site { part: 0, face: 0, triangle: pick(&mut rng, count) as u32 };
            let [a, b, c] = [0, 1, 2].map(|k| geometry.corner(&world, site, k));
            // At a corner, a place of an edge, a place within.
            let aim = match pick(&mut rng, 3) {
                0 => a,
                1 => a + (b - a) * rng.uniform(),
                _ => a + (b - a) * 0.3 + (c - a) * rng.uniform() * 0.7,
            };
            let dir = match pick(&mut rng, 5) {
                // Along an edge, in the plane, nearly in it, along an axis with either zero.
                0 => (b - a).normalize_or(DVec3::X),
                1 => ((b - a) * (rng.uniform() - 0.5) + (c - a) * (rng.uniform() - 0.5)).normalize_or(DVec3::Y),
                2 => ((c - b).normalize_or(DVec3::Z) + warp::sphere(rng.pair()) * 1e-9).normalize(),
                3 => {
                    [DVec3::X, DVec3::new(-0.0, -1.0, 0.0), DVec3::new(0.0, -0.0, 1.0), DVec3::NEG_Z][pick(&mut rng, 4)]
                }
                _ => warp::sphere(rng.pair()),
            };
            // On the surface itself, near it, far out.
            let back = [0.0, 1e-9, 0.5, 3.0, 1e5][pick(&mut rng, 5)] * scale;
            let ray = Ray { origin: aim - dir * back, dir, from: None };
            let t_max = if rng.uniform() < 0.3 { scale * rng.uniform() * 4.0 } else { f64::INFINITY };
            hits += u32::from(same(&geometry, &ray, t_max).is_some());
        }
    }
    assert!(hits > 15_000, "{hits}");
}

/// Up to the very distance of a hit there is nothing, up to the next number there is the hit; of copies of one triangle the
/// first counts.
#[test]
fn reach_is_exclusive_and_copies_have_an_order() {
    let mut rng = Rng::new(32, Stream::Check, 0, 0);
    let world = scene(vec![pile(&mut rng)], vec![part(0, &[Shape::Mesh], DAffine3::IDENTITY)]);
    let geometry = Geometry::build(&world).unwrap();
    let mut hits = 0;
    for _ in 0..4_000 {
        let ray = random_ray(&geometry, &mut rng);
        let Some(hit) = same(&geometry, &ray, f64::INFINITY) else { continue };
        hits += 1;
        let before = same(&geometry, &ray, hit.t);
        assert!(before.is_none_or(|other| other.t < hit.t), "{ray:?}");
        assert_eq!(same(&geometry, &ray, hit.t.next_up()), Some(hit));
    }
    assert!(hits > 1_000, "{hits}");
}
