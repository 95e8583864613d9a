//! One small asset per feature.

use crate::gltf::testing::Builder;
use crate::gltf::{looks_like_millimetres, read, read_bytes};
use crate::{Assembly, Data, ReadOptions};
use eyebox_base::Where;
use eyebox_scene::Severity;
use glam::{DQuat, DVec3};
use serde_json::{Value as Json, json};
use std::path::Path;

fn bytes<const N: usize, T: Copy>(numbers: &[T], of: impl Fn(T) -> [u8; N]) -> Vec<u8> {
    numbers.iter().flat_map(|&x| of(x)).collect()
}

fn has_note(assembly: &Assembly, text: &str) -> bool {
    assembly.notes.iter().any(|note| note.text.contains(text))
}

fn pointer(at: &Where) -> &str {
    match at {
        Where::Pointer { pointer, .. } => pointer,
        other => panic!("{other:?}"),
    }
}

/// A mesh of one primitive over the five corners of a strip, with `edit` applied to the primitive.
fn strip_asset(edit: impl Fn(&mut Json)) -> Assembly {
    let mut builder = Builder::new();
    let positions = builder.floats("VEC3", &[0., 0., 0., 1., 0., 0., 0., 1., 0., 1., 1., 0., 0., 2., 0.]);
    let mut primitive = json!({ "attributes": { "POSITION": positions } });
    edit(&mut primitive);
    let mesh = builder.push("meshes", json!({ "primitives": [primitive] }));
    builder.push("nodes", json!({ "mesh": mesh }));
    builder.read().unwrap()
}

/// The corners of each triangle, as positions.
fn triangles(assembly: &Assembly) -> Vec<[[f32; 3]; 3]> {
    let mesh = &assembly.meshes[0].mesh;
    mesh.triangles.iter().map(|t| t.map(|i| mesh.positions[i as usize])).collect()
}

#[test]
fn strips_and_fans_become_triangles_of_one_winding() {
    let strip = strip_asset(|primitive| primitive["mode"] = json!(5));
    let p = |x: f32, y: f32| [x, y, 0.0];
    let want =
        [[p(0., 0.), p(1., 0.), p(0., 1.)], [p(1., 0.), p(1., 1.), p(0., 1.)], [p(0., 1.), p(1., 1.), p(0., 2.)]];
    assert_eq!(triangles(&strip), want);
    // No normals in the file: flat ones on vertices of their own. All triangles are seen from the same side.
    let mesh = &strip.meshes[0].mesh;
    assert_eq!(mesh.positions.len(), 9);
    assert!(mesh.normals.iter().all(|&normal| normal == [0.0, 0.0, 1.0]));
    assert!(has_note(&strip, "no normals"));

    let fan = strip_asset(|primitive| primitive["mode"] = json!(6));
    let want = [[1, 2, 0], [2, 3, 0], [3, 4, 0]];
    let corners = [p(0., 0.), p(1., 0.), p(0., 1.), p(1., 1.), p(0., 2.)];
    assert_eq!(triangles(&fan), want.map(|t: [usize; 3]| t.map(|i| corners[i])));
}

#[test]
fn stitching_triangles_of_a_strip_are_left_out_and_other_indices_read() {
    let mut builder = Builder::new();
    let positions = builder.floats("VEC3", &[0., 0., 0., 1., 0., 0., 0., 1., 0., 1., 1., 0.]);
    let strip = builder.accessor("SCALAR", 5121, 8, &[0, 1, 2, 2, 1, 1, 3, 2]);
    let wide = builder.accessor("SCALAR", 5125, 3, &bytes(&[3u32, 2, 1], u32::to_le_bytes));
    let attributes = json!({ "POSITION": positions });
    let primitives = json!([
        { "attributes": attributes, "indices": strip, "mode": 5 },
        { "attributes": attributes, "indices": wide },
    ]);
    builder.push("meshes", json!({ "primitives": primitives }));
    let assembly = builder.read().unwrap();
    let p = |x: f32, y: f32| [x, y, 0.0];
    // 012 · 2,1,2 and other stitches · 1,3,2 with the winding of an even place
    let want = [[p(0., 0.), p(1., 0.), p(0., 1.)], [p(1., 0.), p(1., 0.), p(1., 0.)]];
    let found = triangles(&assembly);
    assert_eq!(found[0], want[0]);
    let face = assembly.meshes[0].mesh.faces[1];
    assert_eq!(found[face.first as usize], [p(1., 1.), p(0., 1.), p(1., 0.)]);
    assert!(found.iter().all(|[a, b, c]| a != b && b != c && c != a));
}

#[test]
fn faces_keep_their_numbers_when_one_has_no_surface() {
    let mut builder = Builder::square();
    let primitive = builder.json["meshes"][0]["primitives"][0].clone();
    let mut lines = primitive.clone();
    lines["mode"] = json!(1);
    builder.json["meshes"][0]["primitives"] = json!([primitive, lines, primitive]);
    let assembly = builder.read().unwrap();
    let counts: Vec<u32> = assembly.meshes[0].mesh.faces.iter().map(|face| face.count).collect();
    assert_eq!(counts, [2, 0, 2]);
    // Nothing is merged between faces.
    assert_eq!(assembly.meshes[0].mesh.positions.len(), 8);
    let note = assembly.notes.iter().find(|note| note.text.contains("points and lines")).unwrap();
    assert_eq!(pointer(&note.at), "/meshes/0/primitives/1");
}

#[test]
fn only_the_vertices_of_a_face_are_kept_in_their_order() {
    // A shared accessor of 1000 vertices, of which each face uses three.
    let mut builder = Builder::new();
    let numbers: Vec<f32> = (0..3000).map(|i| if i % 3 == 2 { 0.0 } else { ((i * i) % 977) as f32 }).collect();
    let positions = builder.floats("VEC3", &numbers);
    let indices = builder.shorts(&[900, 10, 500]);
    builder.push(
        "meshes",
        json!({ "primitives": [{ "attributes": { "POSITION": positions, "NORMAL": positions }, "indices": indices }] }),
    );
    let mesh = builder.read().unwrap().meshes.remove(0).mesh;
    let at = |i: usize| [numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]];
    assert_eq!(mesh.positions, [at(10), at(500), at(900)]);
    assert_eq!(mesh.triangles, [[2, 0, 1]]);
}

#[test]
fn sparse_accessors_replace_elements() {
    let mut builder = Builder::square();
    let indices = builder.view(&[1, 3], None);
    let values = builder.view(&bytes(&[5.0f32, 0., 0., 0., 7., 0.], f32::to_le_bytes), None);
    let sparse = json!({
        "count": 2, "indices": { "bufferView": indices, "componentType": 5121 }, "values": { "bufferView": values },
    });
    builder.json["accessors"][0]["sparse"] = sparse;
    let positions = &builder.read().unwrap().meshes[0].mesh.positions;
    assert_eq!(positions[..], [[0., 0., 0.], [5., 0., 0.], [1., 1., 0.], [0., 7., 0.]]);
    // Without a dense part the other elements are zero.
    builder.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    let positions = &builder.read().unwrap().meshes[0].mesh.positions;
    assert_eq!(positions[..], [[0., 0., 0.], [5., 0., 0.], [0., 0., 0.], [0., 7., 0.]]);
}

#[test]
fn quantized_and_interleaved_attributes() {
    let mut builder = Builder::square();
    builder.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    builder.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    // i16 positions and i8 normals in one view with a stride of 12: x y z pad, normal pad.
    let mut interleaved = Vec::new();
    for [x, y] in [[0i16, 0], [32767, 0], [32767, -32768], [0, -16384]] {
        interleaved.extend(bytes(&[x, y, 0, 0], i16::to_le_bytes));
        interleaved.extend(bytes(&[0i8, 0, -128, 0], i8::to_le_bytes));
    }
    let view = builder.view(&interleaved, Some(12));
    let accessor = |offset, component| {
        json!({
            "bufferView": view, "byteOffset": offset, "componentType": component, "normalized": true, "count": 4, "type": "VEC3",
        })
    };
    builder.json["accessors"][0] = accessor(0, 5122);
    builder.json["accessors"][1] = accessor(8, 5120);
    let uvs = builder.accessor("VEC2", 5121, 4, &[0, 0, 255, 0, 255, 51, 0, 51]);
    builder.json["accessors"][uvs]["normalized"] = json!(true);
    builder.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(uvs);
    let assembly = builder.read().unwrap();
    let mesh = &assembly.meshes[0].mesh;
    // f = max(c / 32767, −1), glTF 2.0 section 3.11
    assert_eq!(mesh.positions[..], [[0., 0., 0.], [1., 0., 0.], [1., -1., 0.], [0., -16384. / 32767., 0.]]);
    assert!(mesh.normals.iter().all(|&normal| normal == [0., 0., -1.]));
    assert_eq!(mesh.uvs[..], [[0., 0.], [1., 0.], [1., 0.2], [0., 0.2]]);
    assert!(assembly.notes.is_empty(), "{:?}", assembly.notes);
    // Not normalised: the integers themselves.
    builder.json["accessors"][0]["normalized"] = json!(false);
    assert_eq!(builder.read().unwrap().meshes[0].mesh.positions[1], [32767., 0., 0.]);
    // Not declared: read all the same, and said.
    builder.json["extensionsUsed"] = json!([]);
    assert!(has_note(&builder.read().unwrap(), "KHR_mesh_quantization"));
}

#[test]
fn normals_without_direction_come_from_the_triangles() {
    let mut builder = Builder::square();
    let normals = builder.floats("VEC3", &[0., 0., 0., 0., f32::NAN, 1., 0., 0., 2., f32::INFINITY, 0., 0.]);
    builder.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    let assembly = builder.read().unwrap();
    assert!(assembly.meshes[0].mesh.normals.iter().all(|&normal| normal == [0., 0., 1.]));
    let note = assembly.notes.iter().find(|note| note.text.contains("zero or not finite")).unwrap();
    assert_eq!((note.severity, pointer(&note.at)), (Severity::Warning, "/accessors/3"));
    assert!(note.text.contains("(3 places"), "{}", note.text);
    assert!(has_note(&assembly, "not of unit length"));
}

#[test]
fn matrices_mirrors_and_hierarchies_in_f64() {
    let mut builder = Builder::square();
    let (a, b) = (0.1234567890123456, -553.778_649_820_895_5);
    builder.json["nodes"] = json!([
        { "name": "ROOT", "children": [2], "rotation": [0.0, 0.0, 2.0, 2.0], "translation": [b, 0, 0] },
        { "name": "OTHER" },
        { "children": [3], "matrix": [0, 2, 0, 0, -2, 0, 0, 0, 0, 0, 2, 0, a, 0, 0, 1] },
        { "name": "LEAF", "mesh": 0, "scale": [-1, 1, 1] },
    ]);
    let assembly = builder.read().unwrap();
    let paths: Vec<&str> = assembly.nodes.iter().map(|node| node.path.as_str()).collect();
    assert_eq!(paths, ["ROOT", "ROOT/node_2", "ROOT/node_2/LEAF", "OTHER"]);
    assert_eq!(assembly.nodes.iter().map(|node| node.parent).collect::<Vec<_>>(), [None, Some(0), Some(1), None]);
    // Two quarter turns about z, a scale of 2 and a mirrored x: x → (+2, 0, 0), and a is turned once.
    let leaf = assembly.nodes[2].to_world;
    let near = |found: DVec3, want: DVec3| assert!((found - want).length() < 1e-12 * want.length(), "{found} {want}");
    near(leaf.transform_vector3(DVec3::X), DVec3::new(2.0, 0.0, 0.0));
    near(leaf.transform_vector3(DVec3::Y), DVec3::new(0.0, -2.0, 0.0));
    near(leaf.transform_point3(DVec3::ZERO), DVec3::new(b, a, 0.0));
    assert!(leaf.matrix3.determinant() < 0.0, "a mirror stays one: the winding is turned by whoever traces it");
    let note = assembly.notes.iter().find(|note| note.text.contains("unit quaternion")).unwrap();
    assert_eq!(pointer(&note.at), "/nodes/0/rotation");
    // Flattened nodes are read, with a note.
    builder.json["nodes"][3]["scale"] = json!([1, 1, 0]);
    assert!(has_note(&builder.read().unwrap(), "singular"));
    builder.json["nodes"][3]["scale"] = json!([1e-100, 1e-100, 1e-100]);
    assert!(!has_note(&builder.read().unwrap(), "singular"));
}

#[test]
fn the_default_scene_decides_which_nodes_are_there() {
    let mut builder = Builder::square();
    builder.json["nodes"] =
        json!([{ "name": "A", "children": [2] }, { "name": "B", "mesh": 0 }, { "name": "C", "mesh": 0 }]);
    builder.json["scenes"] = json!([{ "nodes": [0] }, { "nodes": [1, 0] }]);
    let names = |builder: &Builder| -> Vec<String> {
        builder.read().unwrap().nodes.into_iter().map(|node| node.path).collect()
    };
    assert_eq!(names(&builder), ["A", "A/C", "B"]);
    builder.json["scene"] = json!(0);
    assert_eq!(names(&builder), ["A", "A/C"]);
    builder.json["scene"] = json!(1);
    assert_eq!(names(&builder), ["B", "A", "A/C"]);
    // Two nodes, one mesh.
    let assembly = builder.read().unwrap();
    assert_eq!((assembly.meshes.len(), assembly.nodes[0].mesh, assembly.nodes[2].mesh), (1, Some(0), Some(0)));
}

#[test]
fn instances_become_nodes() {
    let mut builder = Builder::square();
    let shift = builder.floats("VEC3", &[0., 0., 0., 10., 0., 0., 0., 0., 5.]);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let turn = builder.floats("VEC4", &[0., 0., 0., 1., 0., 0., half, half, 0., 0., 0., 1.]);
    let attributes = json!({ "TRANSLATION": shift, "ROTATION": turn, "_ID": 99 });
    builder.json["nodes"] = json!([
        { "name": "BOARD", "children": [1], "translation": [0, 1, 0] },
        { "name": "LED", "mesh": 0, "scale": [2, 2, 2], "children": [2], "extensions": {
            "EXT_mesh_gpu_instancing": { "attributes": attributes }, "EYEBOX_optics": { "emitter": 0 } } },
        { "name": "WIRE", "mesh": 0 },
    ]);
    let assembly = builder.read().unwrap();
    let paths: Vec<&str> = assembly.nodes.iter().map(|node| node.path.as_str()).collect();
    assert_eq!(paths, ["BOARD", "BOARD/LED", "BOARD/LED[0]", "BOARD/LED[1]", "BOARD/LED[2]", "BOARD/LED/WIRE"]);
    let meshes: Vec<Option<usize>> = assembly.nodes.iter().map(|node| node.mesh).collect();
    assert_eq!(meshes, [None, None, Some(0), Some(0), Some(0), Some(0)]);
    assert!(assembly.nodes.iter().skip(2).take(3).all(|node| node.parent == Some(0) && node.attributes.is_some()));
    // The instance first, then the node: 2·(10, 0, 0) + (0, 1, 0); x turns to y.
    let second = assembly.nodes[3].to_world;
    assert!((second.transform_point3(DVec3::ZERO) - DVec3::new(20.0, 1.0, 0.0)).length() < 1e-12);
    assert!((second.transform_vector3(DVec3::X) - DVec3::new(0.0, 2.0, 0.0)).length() < 1e-7);
    let quarter = DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2);
    assert!((second.transform_vector3(DVec3::Y) - quarter * DVec3::Y * 2.0).length() < 1e-7);
    assert!(assembly.notes.is_empty(), "{:?}", assembly.notes);
}

#[test]
fn data_uris_external_files_and_byte_order_marks() {
    let builder = Builder::square();
    let glb = builder.read().unwrap();
    let inside = read_bytes(Path::new("a.gltf"), &builder.gltf(None), &ReadOptions::default()).unwrap();
    assert_eq!(inside.meshes[0].mesh, glb.meshes[0].mesh);

    let folder = tempfile::tempdir().unwrap();
    let asset = folder.path().join("a.gltf");
    std::fs::create_dir(folder.path().join("my data")).unwrap();
    std::fs::write(folder.path().join("my data/ü.bin"), &builder.bin).unwrap();
    let mut text = vec![0xEF, 0xBB, 0xBF];
    text.extend(builder.gltf(Some("my%20data/%C3%BC.bin")));
    std::fs::write(&asset, text).unwrap();
    let beside = read(&asset, &ReadOptions::default()).unwrap();
    assert_eq!(beside.meshes[0].mesh, glb.meshes[0].mesh);
    assert_eq!(beside.dependencies, [asset.clone(), folder.path().join("my data/ü.bin")]);
    assert!(has_note(&beside, "byte order mark"));

    std::fs::write(folder.path().join("my data/ü.bin"), &builder.bin[1..]).unwrap();
    let fault = read(&asset, &ReadOptions::default()).unwrap_err();
    assert_eq!(pointer(&fault.at), "/buffers/0/byteLength");
    for (uri, what) in
        [("gone.bin", "cannot read"), ("my%20data", "regular file"), ("/dev/zero", "URI"), ("../../dev/zero", "")]
    {
        std::fs::write(&asset, builder.gltf(Some(uri))).unwrap();
        let fault = read(&asset, &ReadOptions::default()).unwrap_err();
        assert_eq!(pointer(&fault.at), "/buffers/0/uri");
        assert!(fault.what.contains(what), "{fault}");
    }
    assert!(read(folder.path(), &ReadOptions::default()).unwrap_err().what.contains("folder"));
}

#[test]
fn materials_map_to_our_names() {
    let mut builder = Builder::square();
    builder.push("materials", json!({
        "name": "GLASS", "doubleSided": true, "alphaMode": "BLEND",
        "extensions": {
            "KHR_materials_ior": { "ior": 1.4925878124522123 },
            "KHR_materials_dispersion": { "dispersion": 0.31 },
            "KHR_materials_transmission": { "transmissionFactor": 0.9 },
            "KHR_materials_volume": { "thicknessFactor": 2, "attenuationDistance": 0.05, "attenuationColor": [1, 0.5, 0.25] },
            "EYEBOX_optics": { "finish": "polished" },
        },
    }));
    builder.push("materials", json!({
        "emissiveFactor": [1, 0.5, 0], "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 1000 } },
    }));
    builder.push("materials", json!({ "emissiveFactor": [0, 0, 0], "extensions": { "KHR_materials_ior": {} } }));
    builder.json["meshes"][0]["primitives"][0]["material"] = json!(1);
    builder.json["meshes"][0]["primitives"][0]["extensions"] =
        json!({ "EYEBOX_optics": { "shape": { "kind": "plane" } } });
    builder.json["extensions"] = json!({ "EYEBOX_optics": { "version": 1 } });
    let assembly = builder.read().unwrap();
    let glass = &assembly.materials[0];
    let number = |name: &str| match glass.mapped.iter().find(|(key, _)| key == name).map(|(_, value)| &value.data) {
        Some(Data::Number(number)) => *number,
        other => panic!("{name}: {other:?}"),
    };
    assert_eq!(number("ior"), 1.4925878124522123); // an f32 would be 1.49258780479
    assert_eq!(["dispersion", "transmission", "thickness", "attenuation_distance"].map(number), [0.31, 0.9, 2.0, 0.05]);
    let (name, color) = &glass.mapped[5];
    let Data::List(lanes) = &color.data else { panic!("{color:?}") };
    assert_eq!((name.as_str(), lanes[2].data.clone()), ("attenuation_color", Data::Number(0.25)));
    assert_eq!(pointer(&lanes[2].at), "/materials/0/extensions/KHR_materials_volume/attenuationColor/2");
    let finish = glass.attributes.as_ref().unwrap().get("finish").unwrap();
    assert_eq!(pointer(&finish.at), "/materials/0/extensions/EYEBOX_optics/finish");

    let lamp = &assembly.materials[1];
    assert_eq!((lamp.name.as_str(), lamp.mapped.len()), ("material_1", 2));
    let Data::Number(luminance) = lamp.mapped[0].1.data else { panic!("a number") };
    assert_eq!(lamp.mapped[0].0, "luminance_cd_m2");
    assert!((luminance - (212.639_005_871_510_36 + 357.584_339_383_877_95)).abs() < 1e-9, "{luminance}");
    assert_eq!(lamp.mapped[1].0, "emitter.spectrum");
    assert_eq!(lamp.mapped[1].1.to_string(), "{ rgb = [1, 0.5, 0] }");
    assert_eq!(assembly.materials[2].mapped.len(), 1);
    assert_eq!(assembly.materials[2].mapped[0].1.data, Data::Number(1.5));

    assert_eq!(assembly.meshes[0].materials, [Some(1)]);
    let shape = assembly.meshes[0].attributes[0].as_ref().unwrap().get("shape").unwrap();
    assert_eq!(pointer(&shape.at), "/meshes/0/primitives/0/extensions/EYEBOX_optics/shape");
    assert!(assembly.optics.unwrap().get("version").is_some());
    assert!(assembly.notes.is_empty(), "{:?}", assembly.notes);
}

#[test]
fn what_bears_on_light_and_is_not_used_is_said_once_per_kind() {
    let mut builder = Builder::square();
    builder.json["extensions"] =
        json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }, { "type": "spot" }] } });
    builder.json["nodes"][0]["extensions"] = json!({ "KHR_lights_punctual": { "light": 0 }, "EYEBOX_optic": {} });
    builder.json["nodes"][0]["extras"] = json!({ "extensions": { "NOT_AN_EXTENSION": {} } });
    for _ in 0..3 {
        builder.push("materials", json!({ "extensions": { "KHR_materials_subsurface": {} } }));
    }
    builder.json["meshes"][0]["extensions"] = json!({ "EYEBOX_optics": { "shape": {} } });
    let assembly = builder.read().unwrap();
    let found: Vec<(&str, &str)> = assembly.notes.iter().map(|note| (pointer(&note.at), note.text.as_str())).collect();
    let want = [
        ("/meshes/0/extensions/EYEBOX_optics", "`EYEBOX_optics` means nothing here: ignored"),
        (
            "/nodes/0/extensions/EYEBOX_optic",
            "the extension `EYEBOX_optic` is not known and was ignored; did you mean `EYEBOX_optics`?",
        ),
        (
            "/materials/0/extensions/KHR_materials_subsurface",
            "`KHR_materials_subsurface` bears on what is seen but is not used (3 places, first here)",
        ),
    ];
    assert_eq!(found.len(), want.len(), "{found:?}");
    for expected in want {
        assert!(found.contains(&expected), "{expected:?} is not in {found:?}");
    }
}

/// KHR_node_visibility: a node is seen if it and all above it are visible; cameras stay. The same whether the asset
/// requires the extension or only uses it.
#[test]
fn hidden_nodes_have_no_meshes_and_lights() {
    let mut builder = Builder::square();
    builder.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }] } });
    builder.push("cameras", json!({ "type": "perspective", "perspective": { "yfov": 0.5 } }));
    let visible = |visible: bool| json!({ "KHR_node_visibility": { "visible": visible } });
    builder.json["nodes"] = json!([
        { "name": "hidden", "mesh": 0, "children": [1, 2], "extensions": visible(false) },
        { "name": "below", "mesh": 0, "camera": 0, "extensions": visible(true) },
        { "name": "lamp", "extensions": { "KHR_lights_punctual": { "light": 0 } } },
        { "name": "seen", "mesh": 0, "extensions": { "KHR_node_visibility": {} } },
    ]);
    let pointer = json!({ "pointer": "/nodes/0/extensions/KHR_node_visibility/visible" });
    let target = json!({ "path": "pointer", "extensions": { "KHR_animation_pointer": pointer } });
    for required in [json!([]), json!(["KHR_node_visibility"])] {
        builder.json["extensionsRequired"] = required;
        builder.json["animations"] = json!([]);
        let found = builder.read().unwrap();
        let meshes: Vec<_> = found.nodes.iter().map(|node| (node.name.as_str(), node.mesh.is_some())).collect();
        assert_eq!(meshes, [("hidden", false), ("below", false), ("lamp", false), ("seen", true)]);
        assert_eq!((found.cameras.len(), found.lights.len()), (1, 0));
        assert!(has_note(&found, "hidden by `KHR_node_visibility`") && !has_note(&found, "shows or hides"));
        builder.json["animations"] = json!([{ "channels": [{ "sampler": 0, "target": target }], "samplers": [] }]);
        assert!(has_note(&builder.read().unwrap(), "an animation shows or hides nodes"));
    }
    builder.json["nodes"][0]["extensions"]["KHR_node_visibility"]["visible"] = json!(0);
    assert!(builder.read().is_err());
}

#[test]
fn what_an_asset_requires_is_applied_or_refused_unless_light_does_without() {
    let mut builder = Builder::square();
    for name in ["KHR_texture_basisu", "NV_texture_of_tomorrow", "KHR_xmp_json_ld", "KHR_materials_variants"] {
        builder.json["extensionsRequired"] = json!([name]);
        assert!(builder.read().is_ok(), "{name}");
    }
    for name in ["KHR_materials_subsurface", "EXT_lights_image_based", "MSFT_lod"] {
        builder.json["extensionsRequired"] = json!([name]);
        let fault = builder.read().unwrap_err().to_string();
        assert!(fault.contains(&format!("requires `{name}`, which bears on light")), "{fault}");
    }
}

#[test]
fn cameras_look_along_minus_z_of_their_node() {
    let mut builder = Builder::square();
    builder.push(
        "cameras",
        json!({ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1, "aspectRatio": 2 } }),
    );
    builder.push("cameras", json!({ "type": "orthographic", "name": "FLAT", "orthographic": { "xmag": 1 } }));
    builder.push("nodes", json!({ "name": "EYE", "camera": 0, "translation": [0, 0, 3] }));
    builder.push("nodes", json!({ "name": "TOP", "camera": 1 }));
    let cameras = builder.read().unwrap().cameras;
    let seen: Vec<_> = cameras.iter().map(|c| (c.name.as_str(), c.yfov, c.aspect, c.to_world.translation.z)).collect();
    assert_eq!(seen, [("EYE", Some(0.5), Some(2.0), 3.0), ("FLAT", None, None, 0.0)]);
}

/// A street of 100 m with small things in it is in metres.
#[test]
fn a_large_scene_of_small_things_is_not_in_millimetres() {
    let mut builder = Builder::square();
    builder.push("nodes", json!({ "name": "STREET", "mesh": 0, "scale": [100, 10, 1] }));
    builder.push("nodes", json!({ "name": "CAR", "mesh": 0, "scale": [4, 2, 1] }));
    builder.push("nodes", json!({ "name": "HUD", "mesh": 0, "scale": [0.3, 0.2, 1] }));
    builder.push("nodes", json!({ "name": "TREE", "mesh": 0, "scale": [3, 3, 3] }));
    assert_eq!(looks_like_millimetres(&builder.read().unwrap()), None);
    for node in builder.json["nodes"].as_array_mut().unwrap() {
        node["scale"] = json!([300, 200, 1]);
    }
    let note = looks_like_millimetres(&builder.read().unwrap()).unwrap();
    assert!(note.text.starts_with("largest extent 300 m"), "{}", note.text);
}

#[test]
fn a_glb_with_chunks_out_of_step_is_read_all_the_same() {
    let builder = Builder::square();
    let glb = builder.glb();
    // One more blank in the text: neither the text's length nor the data's place is a multiple of 4 any more.
    let size = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let mut odd = glb[..8].to_vec();
    odd.extend(((glb.len() + 1) as u32).to_le_bytes());
    odd.extend(((size + 1) as u32).to_le_bytes());
    odd.extend(&glb[16..20 + size]);
    odd.push(b' ');
    odd.extend(&glb[20 + size..]);
    let assembly = read_bytes(Path::new("a.glb"), &odd, &ReadOptions::default()).unwrap();
    assert_eq!(assembly.meshes[0].mesh, builder.read().unwrap().meshes[0].mesh);
}

#[test]
fn corners_left_over_are_ignored_and_said() {
    let mut builder = Builder::square();
    builder.json["accessors"][2]["count"] = json!(5);
    let assembly = builder.read().unwrap();
    assert_eq!(assembly.meshes[0].mesh.triangles.len(), 1);
    assert!(has_note(&assembly, "5 corners do not make triangles: the last 2 are ignored"));
    // A fan of two corners is nothing.
    let fan = strip_asset(|primitive| primitive["mode"] = json!(6));
    assert_eq!(fan.meshes[0].mesh.triangles.len(), 3);
    builder.json["accessors"][2]["count"] = json!(2);
    builder.json["meshes"][0]["primitives"][0]["mode"] = json!(6);
    let assembly = builder.read().unwrap();
    assert!(assembly.meshes[0].mesh.triangles.is_empty() && has_note(&assembly, "the last 2 are ignored"));
}
