//! The same CAD assembly through USD and through glTF, part by part and face by face.

use crate::{Assembly, ReadOptions, gltf, usd};
use glam::{DAffine3, DQuat, DVec3};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A file of the exporter's.
fn sample(name: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("samples").join(name)
}

type Triangle = [[u32; 3]; 3];

/// The triangles of each face as bits of their corners, the least corner first, sorted.
fn faces(assembly: &Assembly, mesh: usize) -> Vec<Vec<Triangle>> {
    let mesh = &assembly.meshes[mesh].mesh;
    let corner = |i: u32| mesh.positions[i as usize].map(|x| (x + 0.0).to_bits());
    let one = |t: &[u32; 3]| {
        let t = t.map(corner);
        let least = (0..3).min_by_key(|&i| t[i]).unwrap();
        [0, 1, 2].map(|i| t[(least + i) % 3])
    };
    let sorted = |range: &eyebox_scene::FaceRange| {
        let mut all: Vec<Triangle> = mesh.triangles[range.triangles()].iter().map(one).collect();
        all.sort_unstable();
        all
    };
    mesh.faces.iter().map(sorted).collect()
}

#[test]
fn hud_direct_and_hud_diffuse() {
    for (name, parts) in [("hud-direct/hud_direct", 18), ("hud-diffuse/hud_diffuse", 28)] {
        let stage = usd::read(&sample(&format!("{name}.usda")), &ReadOptions::default()).unwrap();
        let glb = gltf::read(&sample(&format!("{name}.glb")), &ReadOptions::default()).unwrap();
        assert_eq!(stage.unit_m, 0.001);
        // The root of the glTF turns z up into y up; without it both are in the CAD frame.
        let turn = glb.nodes[0].to_world.inverse();
        let by_name: BTreeMap<&str, (DAffine3, usize)> = glb
            .nodes
            .iter()
            .filter_map(|node| Some((node.name.as_str(), (turn * node.to_world, node.mesh?))))
            .collect();
        let (mut seen, mut worst_turn, mut worst_shift) = (0, 0.0f64, 0.0f64);
        for node in &stage.nodes {
            let Some(mesh) = node.mesh else { continue };
            let name = node.path.split('/').nth(1).unwrap();
            let (twin, twin_mesh) = by_name[name];
            assert_eq!(faces(&stage, mesh), faces(&glb, twin_mesh), "{name}");
            let turned = DQuat::from_mat3(&(twin.matrix3.inverse() * node.to_world.matrix3));
            worst_turn = worst_turn.max(2.0 * DVec3::new(turned.x, turned.y, turned.z).length());
            worst_shift = worst_shift.max((twin.translation - node.to_world.translation).length());
            seen += 1;
        }
        println!("worst turn {worst_turn:e} rad, worst shift {worst_shift:e} mm");
        assert_eq!(seen, parts);
        assert!(worst_turn < 1e-12 && worst_shift < 1e-9, "{worst_turn:e} rad, {worst_shift:e} mm");
    }
}
