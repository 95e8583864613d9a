//! The trees against trying every triangle.

use super::scenes::*;
use super::{Geometry, Ray, Site};
use eyebox_base::rng::{Rng, Stream};
use eyebox_base::warp;
use glam::{DAffine3, DVec3};

pub(super) fn check(geometry: &Geometry, ray: &Ray, t_max: f64) -> Option<super::Hit> {
    let (fast, all) = (geometry.intersect(ray, t_max), geometry.intersect_all(ray, t_max));
    assert_eq!(fast.is_some(), all.is_some(), "{ray:?}");
    if let (Some(fast), Some(all)) = (&fast, &all) {
        assert_eq!(fast.t, all.t, "{ray:?}");
        assert_eq!(fast.site, all.site, "{ray:?}");
    }
    assert_eq!(geometry.occluded(ray, t_max, None), all.is_some(), "{ray:?}");
    fast
}

#[test]
fn random_rays_and_their_bounces() {
    for (case, scale) in [1.0, 1e-4, 1e5].into_iter().enumerate() {
        let scene = assembly(DAffine3::from_scale(DVec3::splat(scale)));
        let geometry = Geometry::build(&scene).unwrap();
        let mut rng = Rng::new(11, Stream::Check, 0, case as u64);
        let mut hits = 0;
        for _ in 0..15_000 {
            let mut ray = random_ray(&geometry, &mut rng);
            for _ in 0..4 {
                let t_max = if rng.uniform() < 0.3 { 0.1 * scale * rng.uniform() } else { f64::INFINITY };
                let Some(hit) = check(&geometry, &ray, t_max) else { break };
                hits += 1;
                ray = geometry.onwards(&hit, warp::sphere(rng.pair()));
            }
        }
        assert!(hits > 8_000, "{hits}");
    }
}

/// Rays at each patch in turn, so that every box counts.
#[test]
fn every_patch_is_in_its_box() {
    let scene = assembly(DAffine3::IDENTITY);
    let geometry = Geometry::build(&scene).unwrap();
    let mut rng = Rng::new(15, Stream::Check, 0, 0);
    let mut met = 0;
    for (index, part) in scene.parts.iter().enumerate() {
        for triangle in 0..scene.mesh(part.mesh).triangles.len() as u32 {
            for _ in 0..30 {
                let site = Site { part: index as u32, face: 0, triangle };
                let weights = warp::triangle(rng.pair());
                let aim: DVec3 = (0..3).map(|k| geometry.corner(&scene, site, k) * weights[k]).sum();
                let dir = warp::sphere(rng.pair());
                let ray = Ray { origin: aim - dir * 1e-3, dir, from: None };
                met += check(&geometry, &ray, 5e-3).is_some_and(|hit| hit.site.triangle == triangle) as u32;
            }
        }
    }
    assert!(met > 20_000, "{met}");
}

/// At vertices, along edges, along coordinate axes, in face planes.
#[test]
fn aimed_rays() {
    let scene = assembly(DAffine3::IDENTITY);
    let geometry = Geometry::build(&scene).unwrap();
    let mut rng = Rng::new(12, Stream::Check, 0, 0);
    for _ in 0..30_000 {
        let part = (rng.uniform() * scene.parts.len() as f64) as usize;
        let mesh = scene.mesh(scene.parts[part].mesh);
        let triangle = (rng.uniform() * mesh.triangles.len() as f64) as u32;
        let site = Site { part: part as u32, face: 0, triangle };
        let [a, b] = [geometry.corner(&scene, site, 0), geometry.corner(&scene, site, 1)];
        let aim = if rng.uniform() < 0.5 { a } else { a + (b - a) * rng.uniform() };
        let dir = match (rng.uniform() * 4.0) as u32 {
            0 => (b - a).normalize_or(DVec3::X),
            1 => [DVec3::X, DVec3::NEG_Y, DVec3::new(0.0, -0.0, -1.0)][(rng.uniform() * 3.0) as usize],
            2 => DVec3::new(0.6, -0.0, 0.8),
            _ => warp::sphere(rng.pair()),
        };
        let ray = Ray { origin: aim - dir * 0.2 * rng.uniform(), dir, from: None };
        check(&geometry, &ray, f64::INFINITY);
    }
}
