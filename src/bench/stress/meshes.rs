//! Triangles as they come from careless meshers.

use super::Case;
use super::places::plate;
use crate::kit::{self, Sheet};
use crate::measure::How;
use glam::DVec3;

/// The plate's large faces cut into needles: `count` points crowd on one edge, by the `share` of the last distance each,
/// and every triangle is followed by one without area.
fn needles(degrees: f64, exact: bool, count: u32, share: f64) -> (eyebox_scene::Scene, f64) {
    let (mut s, want) = plate(degrees, 1.5, exact);
    let half = DVec3::new(0.4, 0.4, 0.001);
    let cut = |corners: Vec<DVec3>| -> Sheet {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| corners[k]);
        let mut all = vec![a, b, c, d];
        let mut left = 1.0;
        for _ in 0..count {
            left *= share;
            all.push(c + (b - c) * left);
        }
        // From b along the edge to c; d sees them all.
        let mut edge = vec![1u32];
        edge.extend(4..4 + count);
        edge.push(2);
        let mut triangles = vec![[0, 1, 3]];
        for pair in edge.windows(2) {
            triangles.push([3, pair[0], pair[1]]);
            triangles.push([3, pair[0], pair[0]]);
            triangles.push([pair[0], pair[1], pair[0]]);
        }
        (all, triangles)
    };
    let faces = kit::cuboid(half)
        .into_iter()
        .enumerate()
        .map(|(k, corners)| if k >= 4 { cut(corners) } else { (corners, vec![[0, 1, 2], [0, 2, 3]]) });
    s.meshes[0] = kit::mesh_of(faces).into();
    (s, want)
}

/// Needles, and a ball whose triangles at the poles have no area.
pub fn slivers() -> Vec<Case> {
    let mut cases = Vec::new();
    for (count, share) in [(3, 1e-3), (40, 0.5), (1000, 0.98)] {
        for exact in [false, true] {
            let (s, want) = needles(45.0, exact, count, share);
            let name =
                format!("{count} needles a face, each {share} of the last{}", if exact { ", exact" } else { "" });
            cases.push(Case::new(name, s, How::backward(400).polarised(), want));
        }
    }
    let mut s = kit::scene(20.0, 16);
    kit::sky(&mut s, 16, 8, vec![500.0; 128]);
    let mut mesh = kit::sphere(0.01, 24, 48);
    // All corners of a ring at the pole, and triangles over them.
    let extra: Vec<[u32; 3]> = (0..48).map(|j| [j, (j + 1) % 48, (j + 2) % 48]).collect();
    mesh.faces[0].count += extra.len() as u32;
    mesh.triangles.extend(extra);
    let at = glam::DAffine3::from_translation(DVec3::NEG_Z * 0.05);
    kit::add(&mut s, mesh, at, Some(1.5), vec![kit::polished(kit::ball(0.01))]);
    cases.push(Case::new("ball with triangles without area".to_owned(), s, How::backward(64), 500.0));
    cases
}
