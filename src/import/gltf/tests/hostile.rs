//! Broken and hostile files: always a fault with its place, never a panic, a hang or a flood of memory.

use crate::ReadOptions;
use crate::gltf::read_bytes;
use crate::gltf::testing::Builder;
use eyebox_base::error::Result;
use eyebox_base::rng::{Rng, Stream};
use eyebox_base::{Error, Where};
use serde_json::{Value as Json, json};
use std::path::Path;

fn refused(builder: &Builder) -> Box<Error> {
    builder.read().err().unwrap_or_else(|| panic!("accepted: {}", builder.json))
}

/// (what is done to the square, JSON pointer of the fault, a word of the message)
type Case = (fn(&mut Json), &'static str, &'static str);

#[test]
fn every_wrong_entry_is_a_fault_at_its_pointer() {
    let cases: Vec<Case> = vec![
        (|j| j["asset"]["version"] = json!("1.0"), "/asset/version", "version"),
        (|j| j["asset"]["version"] = json!(2), "/asset/version", "2"),
        (|j| j["asset"]["minVersion"] = json!("3.0"), "/asset/minVersion", "newer"),
        (|j| j["asset"] = json!(null), "/asset", "null"),
        (|j| *j = json!([]), "", "list"),
        (|j| *j = json!({}), "", "asset"),
        (|j| j["nodes"] = json!({}), "/nodes", "object"),
        (|j| j["nodes"] = json!([7]), "/nodes/0", "7"),
        (|j| j["extensionsRequired"] = json!(["XYZ_unheard_of"]), "/extensionsRequired/0", "not known"),
        // nodes
        (|j| j["nodes"][0]["mesh"] = json!(1), "/nodes/0/mesh", "mesh 1"),
        (|j| j["nodes"][0]["mesh"] = json!(-1), "/nodes/0/mesh", "-1"),
        (|j| j["nodes"][0]["mesh"] = json!(1e300), "/nodes/0/mesh", ""),
        (|j| j["nodes"][0]["camera"] = json!(0), "/nodes/0/camera", "camera"),
        (|j| j["nodes"][0]["children"] = json!([9]), "/nodes/0/children/0", "node 9"),
        (|j| j["nodes"][0]["children"] = json!([0]), "/nodes/0", "ancestor"),
        (
            |j| j["nodes"] = json!([{}, { "children": [2] }, { "children": [3] }, { "children": [1] }]),
            "/nodes/1",
            "ancestor",
        ),
        (
            |j| j["nodes"] = json!([{ "children": [2] }, { "children": [2] }, {}]),
            "/nodes/1/children/0",
            "child of node 0",
        ),
        (|j| j["nodes"] = json!([{ "children": [1, 1] }, {}]), "/nodes/0/children/1", "already"),
        (|j| j["scene"] = json!(0), "/scene", "scenes"),
        (
            |j| {
                j["scene"] = json!(0);
                j["scenes"] = json!([{ "nodes": [3] }])
            },
            "/scenes/0/nodes/0",
            "node 3",
        ),
        (|j| j["nodes"][0]["rotation"] = json!([0, 0, 0, 0]), "/nodes/0/rotation", "length 0"),
        (|j| j["nodes"][0]["rotation"] = json!([0, 0, 1]), "/nodes/0/rotation", "3 numbers"),
        (|j| j["nodes"][0]["translation"] = json!([0, "x", 1]), "/nodes/0/translation/1", "text"),
        (
            |j| {
                j["nodes"][0]["matrix"] = json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
                j["nodes"][0]["scale"] = json!([1, 1, 1])
            },
            "/nodes/0/matrix",
            "both",
        ),
        (
            |j| j["nodes"][0]["matrix"] = json!([1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
            "/nodes/0/matrix",
            "affine",
        ),
        (
            |j| j["nodes"] = json!([{ "scale": [1e200, 1e200, 1e200], "children": [1] }, { "scale": [1e200, 1, 1] }]),
            "/nodes/1",
            "overflow",
        ),
        // meshes
        (|j| j["meshes"][0]["primitives"] = json!([]), "/meshes/0", "without primitives"),
        (|j| j["meshes"][0]["primitives"][0]["mode"] = json!(7), "/meshes/0/primitives/0/mode", "7"),
        (|j| j["meshes"][0]["primitives"][0]["material"] = json!(0), "/meshes/0/primitives/0/material", "materials"),
        (|j| j["meshes"][0]["primitives"][0]["indices"] = json!(3), "/meshes/0/primitives/0/indices", "accessor 3"),
        (
            |j| j["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(99),
            "/meshes/0/primitives/0/attributes/POSITION",
            "99",
        ),
        (|j| j["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(2), "/accessors/2/type", "1 components"),
        (|j| j["accessors"][1]["count"] = json!(3), "/meshes/0/primitives/0/attributes/NORMAL", "3 elements for 4"),
        (|j| j["accessors"][2]["componentType"] = json!(5122), "/accessors/2/componentType", "indices"),
        (|j| j["accessors"][0]["count"] = json!(3), "/accessors/2", "index 3 at position 5"),
        // accessors
        (|j| j["accessors"][0]["componentType"] = json!(5124), "/accessors/0/componentType", "5124"),
        (|j| j["accessors"][0]["componentType"] = json!(5125), "/accessors/0/componentType", "component type"),
        (|j| j["accessors"][0]["type"] = json!("VEC5"), "/accessors/0/type", "unknown"),
        (|j| j["accessors"][0]["count"] = json!(0), "/accessors/0/count", "without elements"),
        (|j| j["accessors"][0]["count"] = json!(5), "/accessors/0", "5 elements"),
        (|j| j["accessors"][0]["count"] = json!(u64::MAX), "/accessors/0", "elements"),
        (|j| j["accessors"][0]["count"] = json!(1u64 << 62), "/accessors/0", "elements"),
        (|j| j["accessors"][0]["byteOffset"] = json!(u64::MAX), "/accessors/0", "from byte"),
        (|j| j["accessors"][0]["bufferView"] = json!(17), "/accessors/0/bufferView", "17"),
        (|j| j["bufferViews"][0]["byteStride"] = json!(8), "/accessors/0/bufferView", "byteStride 8"),
        (|j| j["bufferViews"][0]["byteStride"] = json!(1e9), "/bufferViews/0/byteStride", "range"),
        (|j| j["bufferViews"][0]["byteLength"] = json!(4294967295u64), "/bufferViews/0", "4294967295"),
        (|j| j["bufferViews"][0]["byteOffset"] = json!(u64::MAX), "/bufferViews/0", "claims"),
        (|j| j["bufferViews"][0]["buffer"] = json!(1), "/bufferViews/0/buffer", "buffer 1"),
        (|j| j["accessors"][0]["sparse"] = json!({ "count": 5 }), "/accessors/0/sparse/count", "5"),
        (
            |j| {
                j["accessors"][0]["sparse"] =
                    json!({ "count": 1, "indices": { "bufferView": 2, "componentType": 5126 }, "values": {} })
            },
            "/accessors/0/sparse/indices/componentType",
            "sparse",
        ),
        // The indices 0, 1, 2, 0 of the square do not increase.
        (
            |j| {
                j["accessors"][0]["sparse"] = json!({ "count": 4, "indices": { "bufferView": 2, "componentType": 5123 },
            "values": { "bufferView": 0 } })
            },
            "/accessors/0/sparse/indices",
            "position 3",
        ),
        // materials, cameras, attributes
        (
            |j| j["materials"] = json!([{ "extensions": { "KHR_materials_ior": { "ior": 0.5 } } }]),
            "/materials/0/extensions/KHR_materials_ior/ior",
            "0.5",
        ),
        (|j| j["materials"] = json!([{ "emissiveFactor": [0, -1, 0] }]), "/materials/0/emissiveFactor", "negative"),
        (|j| j["materials"] = json!([{ "extensions": [] }]), "/materials/0/extensions", "list"),
        (
            |j| j["materials"] = json!([{ "extensions": { "EYEBOX_optics": { "a": [1, null] } } }]),
            "/materials/0/extensions/EYEBOX_optics/a/1",
            "null",
        ),
        (
            |j| {
                j["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": 4 } }]);
                j["nodes"][0]["camera"] = json!(0)
            },
            "/cameras/0/perspective/yfov",
            "field of view",
        ),
    ];
    for (i, (edit, pointer, words)) in cases.into_iter().enumerate() {
        let mut builder = Builder::square();
        edit(&mut builder.json);
        // `glb` writes the buffers entry, which needs an object.
        let fault = if builder.json.is_object() {
            refused(&builder)
        } else {
            read_bytes(Path::new("test.glb"), builder.json.to_string().as_bytes(), &ReadOptions::default()).unwrap_err()
        };
        let want = Where::Pointer { file: "test.glb".into(), pointer: pointer.to_owned() };
        assert_eq!(fault.at, want, "case {i}: {fault}");
        assert!(words.split('|').any(|word| fault.what.contains(word)), "case {i}: {fault}");
    }
}

#[test]
fn vertices_that_are_not_finite_are_named() {
    for wrong in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut builder = Builder::square();
        builder.bin[16..20].copy_from_slice(&wrong.to_le_bytes()); // vertex 1, y
        let fault = refused(&builder);
        assert!(fault.to_string().contains("#/accessors/0: vertex 1 is at (1, "), "{fault}");
    }
}

#[test]
fn containers_that_lie_are_refused() {
    let glb = Builder::square().glb();
    let read = |bytes: &[u8]| -> Result<_> { read_bytes(Path::new("test.glb"), bytes, &ReadOptions::default()) };
    let with = |offset: usize, word: u32| {
        let mut bytes = glb.clone();
        bytes[offset..offset + 4].copy_from_slice(&word.to_le_bytes());
        read(&bytes).unwrap_err().to_string()
    };
    assert!(read(&glb).is_ok());
    assert!(with(4, 1).contains("version 1"));
    assert!(with(8, u32::MAX).contains("cut short: it claims 4294967295 bytes"));
    assert!(with(12, u32::MAX).contains("claims 4294967295 bytes"));
    assert!(with(16, 0x004E_4942).contains("first chunk"));
    let json = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    assert!(with(20 + json, 0xFFFF_FFF0).contains("past the end"));
    assert!(with(20 + json, 8).contains("cut short") || with(20 + json, 8).contains("past the end"));
    // The data in a chunk that nobody knows: they are not there, which is said.
    let mut hollow = glb.clone();
    hollow[24 + json..28 + json].copy_from_slice(&0x1234_5678u32.to_le_bytes());
    let notes: Vec<String> = read(&hollow).unwrap().notes.into_iter().map(|note| note.text).collect();
    assert!(notes.iter().any(|note| note.starts_with("positions without data")), "{notes:?}");
    assert!(notes.iter().any(|note| note.starts_with("indices without data")), "{notes:?}");
    for length in [0, 3, 4, 8, 11] {
        assert!(read(&glb[..length]).is_err(), "{length} bytes");
    }
    // More than the header says is ignored, and said.
    let mut long = glb.clone();
    long.extend_from_slice(b"rest");
    assert!(read(&long).unwrap().notes[0].text.contains("4 bytes after the end"));
    // Nesting ends with a fault, not with the stack.
    let deep = "[".repeat(1 << 20);
    assert!(read(deep.as_bytes()).unwrap_err().to_string().contains("recursion"));
}

/// Files whose parts refer to the same bytes again and again, or whose names multiply.
#[test]
fn small_files_cannot_ask_for_much_memory() {
    let refuse = |builder: &Builder| {
        let fault = refused(builder);
        assert!(fault.what.contains("repeats itself"), "{fault}");
    };
    // 20 000 primitives over one strip of 60 000 corners.
    let mut builder = Builder::square();
    let indices = builder.accessor("SCALAR", 5121, 60_000, &[0u8, 1, 2, 3].repeat(15_000));
    let mut primitive = builder.json["meshes"][0]["primitives"][0].clone();
    primitive["indices"] = json!(indices);
    primitive["mode"] = json!(5);
    builder.json["meshes"][0]["primitives"] = json!(vec![primitive; 20_000]);
    refuse(&builder);
    // Indices that are all zero and stand nowhere.
    let mut builder = Builder::square();
    builder.json["accessors"][2] = json!({ "componentType": 5125, "type": "SCALAR", "count": 3_000_000_000u64 });
    refuse(&builder);
    // A chain of 40 000 nodes: paths grow with the square.
    let mut builder = Builder::square();
    let chain = (0..40_000).map(|i| if i < 39_999 { json!({ "children": [i + 1] }) } else { json!({}) });
    builder.json["nodes"] = chain.collect();
    refuse(&builder);
    // A million instances of a long name.
    let mut builder = Builder::square();
    let shift = builder.push("accessors", json!({ "componentType": 5126, "type": "VEC3", "count": 1_000_000 }));
    let instancing = json!({ "attributes": { "TRANSLATION": shift } });
    builder.json["nodes"] =
        json!([{ "name": "n".repeat(100_000), "mesh": 0, "extensions": { "EXT_mesh_gpu_instancing": instancing } }]);
    refuse(&builder);
    // Attributes below a long key: every value carries its pointer.
    let mut builder = Builder::square();
    builder.json["extensions"] = json!({ "EYEBOX_optics": { "k".repeat(100_000): vec![0; 50_000] } });
    refuse(&builder);
}

/// Mutates `original` 3000 times. Every result must be an assembly whose indices are in range, or a fault.
fn fuzz(original: &[u8], seed: u64, focus: usize) {
    let mut faults = 0;
    for case in 0..3000 {
        let mut rng = Rng::new(seed, Stream::Check, 0, case);
        let mut below = |limit: usize| (rng.uniform() * limit as f64) as usize;
        let mut bytes = original.to_vec();
        if case % 4 == 0 {
            bytes.truncate(below(bytes.len() + 1));
        }
        // Half of the flips go where the structure is; the rest anywhere.
        let flips = if case % 4 == 0 { below(2) } else { 1 + below(8) };
        for flip in 0..flips {
            let limit = if flip % 2 == 0 { focus.min(bytes.len()) } else { bytes.len() };
            let place = below(limit.max(1));
            let bit = below(8);
            // Digits into other digits keep the JSON valid and lie in it.
            let digit = b'0' + below(10) as u8;
            if let Some(byte) = bytes.get_mut(place) {
                *byte = if byte.is_ascii_digit() && case % 2 == 0 { digit } else { *byte ^ 1 << bit };
            }
        }
        match read_bytes(Path::new("fuzz.gltf"), &bytes, &ReadOptions::default()) {
            Ok(assembly) => {
                for node in &assembly.nodes {
                    assert!(node.mesh.is_none_or(|mesh| mesh < assembly.meshes.len()));
                    assert!(node.to_world.is_finite());
                }
                for source in &assembly.meshes {
                    let mesh = &source.mesh;
                    let vertices = mesh.positions.len();
                    assert!(mesh.triangles.iter().flatten().all(|&vertex| (vertex as usize) < vertices));
                    assert!(mesh.positions.iter().flatten().all(|x| x.is_finite()));
                    let unit = |n: &[f32; 3]| (glam::Vec3::from(*n).length() - 1.0).abs() < 1e-5;
                    assert!(mesh.normals.len() == vertices && mesh.normals.iter().all(unit));
                    assert!(mesh.uvs.is_empty() || mesh.uvs.len() == vertices);
                    assert_eq!(mesh.faces.len(), source.materials.len());
                }
            }
            Err(fault) => {
                faults += 1;
                assert!(!fault.to_string().contains('\n'), "{fault}");
            }
        }
    }
    // The mutations must reach both outcomes.
    assert!((300..2990).contains(&faults), "{faults} faults of 3000");
}

#[test]
fn fuzz_a_cad_export() {
    let bytes = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../../samples/hud-direct/hud_direct.glb")).unwrap();
    let json = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    fuzz(&bytes, 1, 20 + json);
}

#[test]
fn fuzz_a_small_text() {
    let mut builder = Builder::square();
    let uvs = builder.floats("VEC2", &[0., 0., 1., 0., 1., 1., 0., 1.]);
    builder.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(uvs);
    let shift = builder.floats("VEC3", &[0., 0., 0., 1., 0., 0.]);
    let indices = builder.view(&[1, 3], None);
    let values = builder.view(&[0; 24], None);
    builder.json["accessors"][0]["sparse"] = json!({
        "count": 2, "indices": { "bufferView": indices, "componentType": 5121 }, "values": { "bufferView": values },
    });
    let extensions = json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": shift } }, "EYEBOX_optics": { "medium": 0 } });
    builder.push("nodes", json!({ "mesh": 0, "rotation": [0, 0, 0, 1], "extensions": extensions }));
    builder.json["nodes"][0]["children"] = json!([1]);
    builder.push(
        "materials",
        json!({ "emissiveFactor": [1, 1, 1], "extensions": { "KHR_materials_ior": { "ior": 1.5 } } }),
    );
    let bytes = builder.gltf(None);
    fuzz(&bytes, 2, bytes.len());
}
