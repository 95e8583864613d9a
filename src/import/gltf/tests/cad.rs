//! The two HUDs as a CAD kernel exported them. What is known of them comes from the optical prescription
//! (positions of the lenses), from a count over the JSON by another program, and from the `gltf` crate.

use crate::ReadOptions;
use crate::gltf::{looks_like_millimetres, read};
use eyebox_base::Where;
use eyebox_scene::Severity;
use glam::DVec3;
use std::path::Path;

const DIRECT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../samples/hud-direct/hud_direct.glb");
const DIFFUSE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../samples/hud-diffuse/hud_diffuse.glb");

/// (name, faces, triangles, vertices) in the order of the file.
#[rustfmt::skip]
const DIRECT_PARTS: [(&str, usize, usize, usize); 18] = [
    ("LENS_01_PMMA", 3, 4149, 2604), ("LCD_ACTIVE_AREA", 6, 12, 24), ("LENS_02_NBK7", 3, 2445, 1738),
    ("COMBINER_PLATE_NBK7", 6, 12, 24), ("LED_DIE_1", 6, 12, 24), ("LED_DIE_2", 6, 12, 24), ("LED_DIE_3", 6, 12, 24),
    ("LED_DIE_4", 6, 12, 24), ("LED_DIE_5", 6, 12, 24), ("LED_DIE_6", 6, 12, 24), ("LED_DIE_7", 6, 12, 24),
    ("LED_DIE_8", 6, 12, 24), ("LED_DIE_9", 6, 12, 24), ("LED_PCB", 6, 12, 24), ("HOUSING_TUBE", 4, 2016, 2020),
    ("BAFFLE_01", 6, 3024, 3032), ("LCD_BEZEL", 7, 1024, 1034), ("BAFFLE_03", 6, 3024, 3032),
];
#[rustfmt::skip]
const DIFFUSE_PARTS: [(&str, usize, usize, usize); 28] = [
    ("LENS_01_PMMA", 3, 5239, 3160), ("LENS_02_PMMA", 3, 3243, 2144), ("LCD_ACTIVE_AREA", 6, 12, 24),
    ("LENS_03_NSK16", 3, 5328, 3192), ("LENS_04_F2", 3, 5692, 3375), ("LENS_05_NSK16", 3, 4262, 2657),
    ("DIFFUSER_SHEET", 6, 12, 24), ("LENS_06_NBK7", 3, 3169, 2103), ("COMBINER_PLATE_NBK7", 6, 12, 24),
    ("LED_DIE_1", 6, 12, 24), ("LED_DIE_2", 6, 12, 24), ("LED_DIE_3", 6, 12, 24), ("LED_DIE_4", 6, 12, 24),
    ("LED_DIE_5", 6, 12, 24), ("LED_DIE_6", 6, 12, 24), ("LED_DIE_7", 6, 12, 24), ("LED_DIE_8", 6, 12, 24),
    ("LED_DIE_9", 6, 12, 24), ("LED_PCB", 6, 12, 24), ("HOUSING_TUBE", 4, 2016, 2020), ("BAFFLE_01", 6, 3024, 3032),
    ("BAFFLE_02", 6, 3024, 3032), ("LCD_BEZEL", 7, 1024, 1034), ("BAFFLE_04", 6, 3024, 3032),
    ("BAFFLE_05", 6, 3024, 3032), ("BAFFLE_06", 6, 3024, 3032), ("DIFFUSER_FRAME", 7, 1024, 1034),
    ("BAFFLE_08", 6, 3024, 3032),
];

#[test]
fn names_faces_and_triangles() {
    for (file, root, parts) in [(DIRECT, "HUD_B", &DIRECT_PARTS[..]), (DIFFUSE, "HUD_A", &DIFFUSE_PARTS[..])] {
        let assembly = read(Path::new(file), &ReadOptions::default()).unwrap();
        assert_eq!(assembly.dependencies, [Path::new(file)]);
        assert_eq!(assembly.unit_m, 1.0);
        let paths: Vec<&str> = assembly.nodes.iter().map(|node| node.path.as_str()).collect();
        let want: Vec<String> =
            [root.to_owned()].into_iter().chain(parts.iter().map(|part| format!("{root}/{}", part.0))).collect();
        assert_eq!(paths, want);
        assert!(assembly.nodes[1..].iter().all(|node| node.parent == Some(0)));
        for (node, &(name, faces, triangles, vertices)) in assembly.nodes[1..].iter().zip(parts) {
            let source = &assembly.meshes[node.mesh.unwrap()];
            let mesh = &source.mesh;
            assert_eq!((node.name.as_str(), mesh.name.as_str()), (name, name));
            let found = (mesh.faces.len(), mesh.triangles.len(), mesh.positions.len());
            assert_eq!(found, (faces, triangles, vertices), "{name}");
            assert_eq!((mesh.normals.len(), source.materials.len(), source.attributes.len()), (vertices, faces, faces));
            let mut next = 0;
            for face in &mesh.faces {
                assert_eq!(face.first, next);
                next += face.count;
            }
            assert_eq!(next as usize, triangles);
        }
        let materials: Vec<&str> = assembly.materials.iter().map(|material| material.name.as_str()).collect();
        assert_eq!(materials, ["mat_0", "mat_1", "mat_2"]);
        assert!(assembly.materials.iter().all(|material| material.mapped.is_empty() && material.attributes.is_none()));
    }
}

/// The first lens of the direct HUD: its frame stands at CAD (0, −295.707, −120) with local z along CAD +y (prescription,
/// surface `cond_hyp`), and the root turns CAD (x, y, z) into glTF (x, z, −y).
#[test]
fn world_transforms_to_rounding() {
    let assembly = read(Path::new(DIRECT), &ReadOptions::default()).unwrap();
    let world_from_cad = |p: DVec3| DVec3::new(p.x, p.z, -p.y);
    let lens = assembly.nodes.iter().find(|node| node.name == "LENS_01_PMMA").unwrap();
    let near = |a: DVec3, b: DVec3| assert!((a - b).length() < 1e-12 * b.length().max(1.0), "{a} is not {b}");
    near(lens.to_world.transform_point3(DVec3::ZERO), world_from_cad(DVec3::new(0.0, -295.707, -120.0)));
    near(lens.to_world.transform_vector3(DVec3::X), world_from_cad(DVec3::X));
    near(lens.to_world.transform_vector3(DVec3::Y), world_from_cad(-DVec3::Z));
    near(lens.to_world.transform_vector3(DVec3::Z), world_from_cad(DVec3::Y));
    // In the CAD frame itself, which is the root's.
    let in_cad = assembly.nodes[0].to_world.inverse() * lens.to_world;
    near(in_cad.transform_point3(DVec3::ZERO), DVec3::new(0.0, -295.707, -120.0));
    let die = assembly.nodes.iter().find(|node| node.name == "LED_DIE_3").unwrap();
    near(die.to_world.transform_point3(DVec3::ZERO), world_from_cad(DVec3::new(1.3, -395.707, -118.7)));
    // A transform that went through f32 is off by 2e-5.
    let assembly = read(Path::new(DIFFUSE), &ReadOptions::default()).unwrap();
    let lens = assembly.nodes.iter().find(|node| node.name == "LENS_03_NSK16").unwrap();
    near(lens.to_world.transform_point3(DVec3::ZERO), world_from_cad(DVec3::new(0.0, -437.363596, -120.0)));
}

/// The bounds of every face are those that the exporter wrote beside its positions (`min` and `max` of the accessor, in
/// doubles); a lens is 8 mm thick, with a clear radius of 24 mm, and its faces are cap, rim, cap.
#[test]
fn bounds_of_faces() {
    let mut lens = Vec::new();
    for file in [DIRECT, DIFFUSE] {
        let assembly = read(Path::new(file), &ReadOptions::default()).unwrap();
        let bytes = std::fs::read(file).unwrap();
        let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        let json: serde_json::Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
        for (index, source) in assembly.meshes.iter().enumerate() {
            let mesh = &source.mesh;
            for (number, face) in mesh.faces.iter().enumerate() {
                let corners = mesh.triangles[face.triangles()].iter().flatten();
                let points = corners.map(|&i| glam::Vec3::from(mesh.positions[i as usize]));
                let empty = (glam::Vec3::INFINITY, glam::Vec3::NEG_INFINITY);
                let (low, high) = points.fold(empty, |(a, b), p| (a.min(p), b.max(p)));
                let primitive = &json["meshes"][index]["primitives"][number];
                let accessor = &json["accessors"][primitive["attributes"]["POSITION"].as_u64().unwrap() as usize];
                let written = |key: &str| [0, 1, 2].map(|lane| accessor[key][lane].as_f64().unwrap() as f32);
                assert_eq!(
                    (low.to_array(), high.to_array()),
                    (written("min"), written("max")),
                    "{} {number}",
                    mesh.name
                );
                lens.push((low, high));
            }
        }
    }
    assert_eq!((lens[0].0.z, lens[1].1.z, lens[2].0.z, lens[2].1.z), (0.0, 8.0, 8.0, 8.0));
    assert!(lens[..3].iter().all(|(low, high)| low.truncate() == -high.truncate() && high.x == 24.0 && high.y == 24.0));
}

/// Positions, indices and normals are those that the `gltf` crate reads.
#[test]
fn geometry_agrees_with_the_gltf_crate() {
    for file in [DIRECT, DIFFUSE] {
        let assembly = read(Path::new(file), &ReadOptions::default()).unwrap();
        let bytes = std::fs::read(file).unwrap();
        let other = ::gltf::Gltf::from_slice(&bytes).unwrap();
        let blob = other.blob.as_deref().unwrap();
        for (source, theirs) in assembly.meshes.iter().zip(other.document.meshes()) {
            let mesh = &source.mesh;
            for (face, primitive) in mesh.faces.iter().zip(theirs.primitives()) {
                let reader = primitive.reader(|_| Some(blob));
                let positions: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
                let normals: Vec<[f32; 3]> = reader.read_normals().unwrap().collect();
                let corners: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
                let ours: Vec<u32> = mesh.triangles[face.triangles()].iter().flatten().copied().collect();
                assert_eq!(ours.len(), corners.len());
                for (&ours, &theirs) in ours.iter().zip(&corners) {
                    assert_eq!(mesh.positions[ours as usize], positions[theirs as usize]);
                    assert_eq!(mesh.normals[ours as usize], normals[theirs as usize]);
                }
            }
        }
    }
}

/// The file with these normals (mesh, primitive, vertex) the other way round.
fn turned(file: &str, wrong: &[(usize, usize, usize)], out: &Path) {
    let mut bytes = std::fs::read(file).unwrap();
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let json: serde_json::Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    for &(mesh, primitive, vertex) in wrong {
        let number = |value: &serde_json::Value| value.as_u64().unwrap_or(0) as usize;
        let attributes = &json["meshes"][mesh]["primitives"][primitive]["attributes"];
        let accessor = &json["accessors"][number(&attributes["NORMAL"])];
        let view = &json["bufferViews"][number(&accessor["bufferView"])];
        let stride = view["byteStride"].as_u64().map_or(12, |stride| stride as usize);
        let first = 20 + length + 8 + number(&view["byteOffset"]) + number(&accessor["byteOffset"]) + stride * vertex;
        (0..3).for_each(|lane| bytes[first + 4 * lane + 3] ^= 0x80);
    }
    std::fs::write(out, bytes).unwrap();
}

/// What a person is told about the two exports: nothing; and, as they came from CAD, of the normals of three poles.
#[test]
fn wrong_pole_normals_are_turned_and_said() {
    let folder = tempfile::tempdir().unwrap();
    for (file, wrong, want) in [
        (DIRECT, &[(0, 0, 0), (0, 0, 1)][..], &[("LENS_01_PMMA face 0", "2 turned", "/meshes/0/primitives/0")][..]),
        (
            DIFFUSE,
            &[(0, 0, 0), (0, 0, 1), (4, 2, 263)],
            &[
                ("LENS_01_PMMA face 0", "2 turned", "/meshes/0/primitives/0"),
                ("LENS_04_F2 face 2", "1 turned", "/meshes/4/primitives/2"),
            ],
        ),
    ] {
        assert!(read(Path::new(file), &ReadOptions::default()).unwrap().notes.is_empty());
        let came = folder.path().join("came.glb");
        turned(file, wrong, &came);
        let notes = read(&came, &ReadOptions::default()).unwrap().notes;
        assert_eq!(notes.len(), want.len(), "{notes:?}");
        for (note, (face, turned, pointer)) in notes.iter().zip(want) {
            assert_eq!(note.severity, Severity::Warning);
            assert!(note.text.contains(face) && note.text.contains(turned), "{}", note.text);
            assert_eq!(note.at, Where::Pointer { file: came.clone(), pointer: (*pointer).to_owned() });
        }
    }
}

/// Extents over all vertices, computed by another program: 439.526 and 597.598.
#[test]
fn millimetres_are_noticed() {
    for (file, extent) in [(DIRECT, "440 m"), (DIFFUSE, "598 m")] {
        let mut assembly = read(Path::new(file), &ReadOptions::default()).unwrap();
        let note = looks_like_millimetres(&assembly).unwrap();
        assert!(note.text.contains(extent) && note.text.contains("unit = 0.001"), "{}", note.text);
        let at = eyebox_base::Where::Nowhere;
        let said = crate::gltf::large_by_its_unit(&assembly, 1.0, at.clone()).unwrap();
        assert!(said.text.contains(extent) && said.text.contains("in a wrong unit"), "{}", said.text);
        assert_eq!(crate::gltf::large_by_its_unit(&assembly, 0.001, at), None);
        assembly.unit_m = 0.001;
        assert_eq!(looks_like_millimetres(&assembly), None);
    }
}
