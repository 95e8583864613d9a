//! Animations, morph targets and skins against closed forms.

use crate::gltf::testing::Builder;
use crate::{Assembly, ReadOptions};
use glam::{DQuat, DVec3};
use serde_json::json;
use std::f32::consts::FRAC_1_SQRT_2;

/// At one frame a second, a frame is a second.
fn at(frame: f64) -> ReadOptions {
    ReadOptions { frame: Some(frame), fps: Some(1.0), animation: None, ..ReadOptions::default() }
}

fn has_note(assembly: &Assembly, text: &str) -> bool {
    assembly.notes.iter().any(|note| note.text.contains(text))
}

/// A square whose node one sampler moves.
fn moving(path: &str, interpolation: &str, times: &[f32], kind: &str, values: &[f32]) -> Builder {
    let mut builder = Builder::square();
    let (input, output) = (builder.floats("SCALAR", times), builder.floats(kind, values));
    let sampler = json!({ "input": input, "output": output, "interpolation": interpolation });
    let channel = json!({ "sampler": 0, "target": { "node": 0, "path": path } });
    builder.push("animations", json!({ "name": "go", "samplers": [sampler], "channels": [channel] }));
    builder
}

fn near(found: DVec3, want: [f64; 3]) -> bool {
    (found - DVec3::from(want)).length() < 1e-6
}

#[test]
fn steps_lines_and_splines_at_and_between_and_beside_their_keys() {
    let times = [1.0, 3.0, 4.0];
    let values = [1., 0., 0., 3., 2., 0., 0., 0., 8.];
    let place = |builder: &Builder, frame| builder.read_at(&at(frame)).unwrap().nodes[0].to_world.translation;
    let step = moving("translation", "STEP", &times, "VEC3", &values);
    let line = moving("translation", "LINEAR", &times, "VEC3", &values);
    for (frame, stepped, lined) in [
        (0.0, [1., 0., 0.], [1., 0., 0.]),
        (1.0, [1., 0., 0.], [1., 0., 0.]),
        (1.5, [1., 0., 0.], [1.5, 0.5, 0.]),
        (3.0, [3., 2., 0.], [3., 2., 0.]),
        (3.75, [3., 2., 0.], [0.75, 0.5, 6.]),
        (99.0, [0., 0., 8.], [0., 0., 8.]),
    ] {
        assert!(near(place(&step, frame), stepped), "{frame}");
        assert!(near(place(&line, frame), lined), "{frame}");
    }
    assert!(near(line.read().unwrap().nodes[0].to_world.translation, [0.0; 3]), "as written without a frame");
    // x³ with its slopes, and twice that: arriving, value, leaving.
    let cubic = |x: f32| [3. * x * x, x * x * x, 3. * x * x];
    let row = |x: f32| cubic(x).map(|v| [v, 2. * v, 0.]).concat();
    let spline = moving("translation", "CUBICSPLINE", &[1., 3.], "VEC3", &[row(1.), row(3.)].concat());
    for frame in [1.0, 1.5, 2.0, 2.75, 3.0] {
        let found = place(&spline, frame);
        assert!(near(found, [frame.powi(3), 2.0 * frame.powi(3), 0.0]), "{frame}: {found}");
    }
    assert!(near(place(&spline, 0.0), [1., 2., 0.]) && near(place(&spline, 5.0), [27., 54., 0.]));
}

#[test]
fn rotations_turn_evenly_along_the_shorter_way() {
    // From none to 90° about z, the end written with the other sign.
    let turns = [0., 0., 0., 1., 0., 0., -FRAC_1_SQRT_2, -FRAC_1_SQRT_2];
    let builder = moving("rotation", "LINEAR", &[0., 3.], "VEC4", &turns);
    let found = builder.read_at(&at(1.0)).unwrap().nodes[0].to_world;
    let want = DQuat::from_rotation_z(30f64.to_radians()) * DVec3::X;
    assert!(near(found.transform_vector3(DVec3::X), want.to_array()), "{found}");
    // Normalised bytes: 127 is 1.
    let mut bytes = builder.clone();
    let output = bytes.accessor("VEC4", 5120, 2, &[0, 0, 0, 127, 0, 0, 127, 0]);
    bytes.json["accessors"][output]["normalized"] = json!(true);
    bytes.json["animations"][0]["samplers"][0]["output"] = json!(output);
    let found = bytes.read_at(&at(1.0)).unwrap().nodes[0].to_world;
    let want = DQuat::from_rotation_z(60f64.to_radians()) * DVec3::X;
    assert!(near(found.transform_vector3(DVec3::X), want.to_array()), "{found}");
}

#[test]
fn frames_are_counted_and_animations_chosen() {
    let mut builder = moving("scale", "LINEAR", &[0., 1.], "VEC3", &[1., 1., 1., 3., 3., 3.]);
    let mut other = builder.json["animations"][0].clone();
    other["name"] = json!("stay");
    other["channels"] = json!([]);
    builder.push("animations", other);
    let size = |options: &ReadOptions| builder.read_at(options).map(|found| found.nodes[0].to_world.matrix3.x_axis.x);
    let asked = |frame, fps, animation: Option<&str>| ReadOptions {
        frame,
        fps,
        animation: animation.map(str::to_owned),
        ..ReadOptions::default()
    };
    assert_eq!(size(&asked(Some(12.0), None, None)).unwrap(), 2.0, "24 frames a second");
    assert_eq!(size(&asked(Some(12.0), Some(48.0), Some("go"))).unwrap(), 1.5);
    assert_eq!(size(&asked(Some(12.0), None, Some("stay"))).unwrap(), 1.0);
    assert_eq!(size(&asked(Some(12.0), None, Some("1"))).unwrap(), 1.0);
    let found = builder.read_at(&asked(Some(12.0), None, None)).unwrap();
    assert!(has_note(
        &found,
        "frame 12 is 0.5 s at 24 frames/s (`--fps`) of all 2 animations at once (`--animation` takes one)"
    ));
    let fault = size(&asked(Some(0.0), None, Some("sty"))).unwrap_err().to_string();
    assert!(fault.contains("--animation sty") && fault.contains("did you mean `stay`?"), "{fault}");
    for (fps, animation) in [(Some(1.0), None), (None, Some("go"))] {
        assert!(size(&asked(None, fps, animation)).unwrap_err().to_string().contains("says nothing without a frame"));
    }
    assert!(has_note(&builder.read().unwrap(), "nodes stand as they are written"));
    assert!(has_note(&Builder::square().read_at(&at(1.0)).unwrap(), "no animations"));
}

#[test]
fn animations_that_are_wrong_say_where() {
    let broken = |edit: &dyn Fn(&mut Builder)| {
        let mut builder = moving("translation", "LINEAR", &[0., 1.], "VEC3", &[0.; 6]);
        edit(&mut builder);
        assert!(builder.read().is_ok(), "not looked at without a frame");
        builder.read_at(&at(0.5)).unwrap_err().to_string()
    };
    let fault = broken(&|builder| builder.json["animations"][0]["samplers"][0]["interpolation"] = json!("LINAER"));
    assert!(fault.contains("/animations/0/samplers/0/interpolation") && fault.contains("`LINEAR`"), "{fault}");
    let fault = broken(&|builder| builder.json["animations"][0]["channels"][0]["target"]["path"] = json!("turn"));
    assert!(fault.contains("unknown property"), "{fault}");
    let fault = broken(&|builder| builder.json["animations"][0]["channels"][0]["target"]["node"] = json!(7));
    assert!(fault.contains("node 7"), "{fault}");
    let fault = broken(&|builder| builder.json["animations"][0]["channels"][0]["sampler"] = json!(1));
    assert!(fault.contains("sampler 1"), "{fault}");
    let fault = broken(&|builder| {
        let input = builder.floats("SCALAR", &[1., 1.]);
        builder.json["animations"][0]["samplers"][0]["input"] = json!(input);
    });
    assert!(fault.contains("key 1 is at 1 s"), "{fault}");
    let fault =
        broken(&|builder| builder.json["nodes"][0]["matrix"] = json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]));
    assert!(fault.contains("moves a node that has a matrix"), "{fault}");
    let fault = broken(&|builder| {
        let output = builder.floats("VEC3", &[0.; 3]);
        builder.json["animations"][0]["samplers"][0]["output"] = json!(output);
    });
    assert!(fault.contains("1 values for 2 keys"), "{fault}");
    let fault = broken(&|builder| {
        let output = builder.floats("VEC3", &[f32::NAN; 6]);
        builder.json["animations"][0]["samplers"][0]["output"] = json!(output);
    });
    assert!(fault.contains("not finite"), "{fault}");
    let mut builder = moving("translation", "LINEAR", &[0., 1.], "VEC3", &[0.; 6]);
    let pointer = json!({ "pointer": "/materials/0/emissiveFactor" });
    builder.json["animations"][0]["channels"][0]["target"] =
        json!({ "path": "pointer", "extensions": { "KHR_animation_pointer": pointer } });
    assert!(has_note(
        &builder.read_at(&at(0.5)).unwrap(),
        "an animation of `/materials/0/emissiveFactor` is not applied"
    ));
    builder.json["animations"][0]["channels"][0]["target"]["extensions"]["KHR_animation_pointer"]["pointer"] =
        json!("/nodes/0/translation");
    let output = builder.floats("VEC3", &[0., 0., 0., 4., 0., 0.]);
    builder.json["animations"][0]["samplers"][0]["output"] = json!(output);
    assert!(near(builder.read_at(&at(0.5)).unwrap().nodes[0].to_world.translation, [2., 0., 0.]));
}

/// A square with two morph targets, the second of which is sparse and turns the normal of one corner.
fn morphing() -> Builder {
    let mut builder = Builder::square();
    let up = builder.floats("VEC3", &[0., 0., 1.].repeat(4));
    let (index, corner) =
        (builder.view(&[2, 0], None), builder.view(&[&2f32.to_le_bytes()[..], &[0; 8]].concat(), None));
    let sparse = json!({
        "count": 1, "indices": { "bufferView": index, "componentType": 5121 }, "values": { "bufferView": corner },
    });
    let out = builder.push("accessors", json!({ "componentType": 5126, "count": 4, "type": "VEC3", "sparse": sparse }));
    builder.json["meshes"][0]["primitives"][0]["targets"] =
        json!([{ "POSITION": up }, { "POSITION": out, "NORMAL": out }]);
    builder
}

#[test]
fn morphs_are_linear_combinations() {
    let mut builder = morphing();
    let corner = |builder: &Builder, options: &ReadOptions| {
        let found = builder.read_at(options).unwrap();
        let mesh = &found.meshes[found.nodes[0].mesh.unwrap()].mesh;
        (mesh.positions[2], mesh.normals[2], mesh.normals[0])
    };
    let rest = ReadOptions::default();
    assert_eq!(corner(&builder, &rest).0, [1., 1., 0.]);
    builder.json["meshes"][0]["weights"] = json!([0.5, 0.25]);
    let (position, normal, other) = corner(&builder, &rest);
    assert_eq!(position, [1.5, 1., 0.5]);
    // (0, 0, 1) + 0.25 · (2, 0, 0), at unit length.
    let want = DVec3::new(0.5, 0.0, 1.0).normalize();
    assert!((DVec3::from(normal.map(f64::from)) - want).length() < 1e-7 && other == [0., 0., 1.]);
    // The node's own go before the mesh's, the animated before the node's.
    builder.json["nodes"][0]["weights"] = json!([2, 0]);
    assert_eq!(corner(&builder, &rest).0, [1., 1., 2.]);
    let (input, output) = (builder.floats("SCALAR", &[0., 1.]), builder.floats("SCALAR", &[0., 0., 4., 1.]));
    builder.push(
        "animations",
        json!({
            "samplers": [{ "input": input, "output": output }],
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "weights" } }],
        }),
    );
    assert_eq!(corner(&builder, &at(0.5)).0, [2., 1., 2.]);
    builder.json["nodes"][0]["weights"] = json!([1]);
    let fault = builder.read().unwrap_err().to_string();
    assert!(fault.contains("/meshes/0/primitives/0") && fault.contains("2 morph targets for 1 weights"), "{fault}");
}

/// Nodes that bend a mesh otherwise have one of their own; those that do it alike share it, and the mesh's number stays.
#[test]
fn bends_have_meshes_of_their_own() {
    let mut builder = morphing();
    let node = |weights: [f64; 2]| json!({ "mesh": 0, "weights": weights });
    builder.json["nodes"] = json!([node([1., 0.]), node([0., 0.]), node([1., 0.]), node([0., 1.]), { "mesh": 0 }]);
    let found = builder.read().unwrap();
    let meshes: Vec<_> = found.nodes.iter().map(|node| node.mesh.unwrap()).collect();
    assert_eq!(meshes, [0, 1, 0, 2, 1]);
    let height = |mesh: usize| found.meshes[mesh].mesh.positions[0][2];
    assert_eq!((found.meshes.len(), height(0), height(1)), (3, 1.0, 0.0));
}

#[test]
fn quantized_morphs_and_colours() {
    let mut builder = morphing();
    let bytes: Vec<u8> = [0i8, 0, 127, 0].repeat(4).iter().map(|x| x.to_le_bytes()[0]).collect();
    let view = builder.view(&bytes, Some(4));
    let up = builder.push(
        "accessors",
        json!({ "bufferView": view, "componentType": 5120, "normalized": true, "count": 4, "type": "VEC3" }),
    );
    builder.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    let (grey, darker) = (builder.floats("VEC3", &[0.5; 12]), builder.floats("VEC3", &[-0.25; 12]));
    builder.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(grey);
    builder.json["meshes"][0]["primitives"][0]["targets"][0] = json!({ "POSITION": up, "COLOR_0": darker });
    builder.json["meshes"][0]["weights"] = json!([3, 0]);
    let mesh = builder.read().unwrap().meshes[0].mesh.clone();
    assert_eq!((mesh.positions[0], mesh.colors[0]), ([0., 0., 3.], [0., 0., 0., 1.]));
}

/// A bar from y = 0 to 2 with a joint at its foot and one at 1, in the middle: the upper one turns by `degrees` about z.
/// Nodes: 0 the bar, 1 the foot, 2 the upper joint.
fn bar(degrees: f64) -> Builder {
    let mut builder = Builder::new();
    let positions =
        builder.floats("VEC3", &[-0.1, 0., 0., 0.1, 0., 0., -0.1, 1., 0., 0.1, 1., 0., -0.1, 2., 0., 0.1, 2., 0.]);
    let normals = builder.floats("VEC3", &[0., 0., 1.].repeat(6));
    let indices = builder.shorts(&[0, 1, 2, 1, 3, 2, 2, 3, 4, 3, 5, 4]);
    let joints = builder.accessor("VEC4", 5121, 6, &[0, 1, 0, 0].repeat(6));
    let weights =
        [[1., 0.], [1., 0.], [0.5, 0.5], [0.5, 0.5], [0., 1.], [0., 1.]].map(|[a, b]| [a, b, 0., 0.]).concat();
    let weights = builder.floats("VEC4", &weights);
    let column = |y: f32| [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., y, 0., 1.];
    let binds = builder.floats("MAT4", &[column(0.), column(-1.)].concat());
    let attributes = json!({ "POSITION": positions, "NORMAL": normals, "JOINTS_0": joints, "WEIGHTS_0": weights });
    builder.push("meshes", json!({ "primitives": [{ "attributes": attributes, "indices": indices }] }));
    builder.push("skins", json!({ "joints": [1, 2], "inverseBindMatrices": binds }));
    let (sine, cosine) = (degrees.to_radians() / 2.0).sin_cos();
    builder.push("nodes", json!({ "name": "BAR", "mesh": 0, "skin": 0 }));
    builder.push("nodes", json!({ "name": "foot", "children": [2] }));
    builder.push("nodes", json!({ "translation": [0, 1, 0], "rotation": [0, 0, sine, cosine] }));
    builder
}

/// The vertices of the bar in the world.
fn bent(builder: &Builder, options: &ReadOptions) -> Vec<DVec3> {
    let found = builder.read_at(options).unwrap();
    let node = found.nodes.iter().find(|node| node.name == "BAR").unwrap();
    let mesh = &found.meshes[node.mesh.unwrap()].mesh;
    mesh.positions.iter().map(|p| node.to_world.transform_point3(DVec3::from(p.map(f64::from)))).collect()
}

/// The tip turns about (0, 1, 0), the middle is the mean of turned and unturned.
fn check_bar(found: &[DVec3], shift: DVec3) {
    let want = [[-0.1, 0.], [0.1, 0.], [-0.05, 0.95], [0.05, 1.05], [-1., 0.9], [-1., 1.1]];
    for (found, [x, y]) in found.iter().zip(want) {
        assert!(near(*found - shift, [x, y, 0.0]), "{found} {x} {y}");
    }
}

#[test]
fn a_bar_bends_by_its_joints_and_not_by_its_node() {
    let rest = ReadOptions::default();
    check_bar(&bent(&bar(90.0), &rest), DVec3::ZERO);
    // Wherever the node stands, even if it is flat or mirrors; and with the joints, where those stand.
    for node in [json!({ "translation": [7, 8, 9] }), json!({ "scale": [-3, 2, 1] }), json!({ "scale": [0, 1, 1] })] {
        let mut builder = bar(90.0);
        for (key, value) in node.as_object().unwrap() {
            builder.json["nodes"][0][key] = value.clone();
        }
        builder.json["nodes"][1]["translation"] = json!([1, 2, 3]);
        check_bar(&bent(&builder, &rest), DVec3::new(1., 2., 3.));
        // The front stays the front: the winding of triangles in the world.
        let found = builder.read().unwrap();
        let (node, mesh) = (&found.nodes[0], &found.meshes[0].mesh);
        let [a, b, c] = mesh.triangles[0].map(|i| DVec3::from(mesh.positions[i as usize].map(f64::from)));
        let side = if node.to_world.matrix3.determinant() < 0.0 { -1.0 } else { 1.0 };
        let [a, b, c] = [a, b, c].map(|p| node.to_world.transform_point3(p));
        assert!(side * (b - a).cross(c - a).z > 0.0);
        let normal = DVec3::from(mesh.normals[0].map(f64::from));
        assert!(near((node.to_world.matrix3.inverse().transpose() * normal).normalize(), [0., 0., 1.]) || side == 0.0);
    }
    // The same by an animation of the joint.
    let mut builder = bar(0.0);
    let (input, output) =
        (builder.floats("SCALAR", &[0., 1.]), builder.floats("VEC4", &[0., 0., 0., 1., 0., 0., 1., 0.]));
    builder.push(
        "animations",
        json!({
            "samplers": [{ "input": input, "output": output }],
            "channels": [{ "sampler": 0, "target": { "node": 2, "path": "rotation" } }],
        }),
    );
    check_bar(&bent(&builder, &at(0.5)), DVec3::ZERO);
    assert!(near(bent(&builder, &rest)[5], [0.1, 2., 0.]));
}

#[test]
fn joints_and_weights_come_in_sets_of_any_type() {
    let rest = ReadOptions::default();
    // Without matrices, joints hold what was modelled about their origin.
    let mut builder = bar(90.0);
    builder.json["skins"][0].as_object_mut().unwrap().remove("inverseBindMatrices");
    assert!(near(bent(&builder, &rest)[4], [-2., 0.9, 0.]));
    // Half of the weight in a second set, joints in shorts, weights in normalised bytes that do not quite add up.
    let mut builder = bar(90.0);
    let wide: Vec<u8> = [0u16, 0, 0, 0].repeat(6).iter().flat_map(|x| x.to_le_bytes()).collect();
    let first = builder.accessor("VEC4", 5123, 6, &wide);
    let weights = [[255, 0], [255, 0], [128, 128], [128, 128], [0, 255], [0, 255]];
    let of = |set: usize| weights.map(|both: [u8; 2]| [both[set], 0, 0, 0]).concat();
    let foot = builder.accessor("VEC4", 5121, 6, &of(0));
    let upper = builder.accessor("VEC4", 5121, 6, &of(1));
    let second = builder.accessor("VEC4", 5121, 6, &[1, 9, 9, 9].repeat(6));
    for weights in [foot, upper] {
        builder.json["accessors"][weights]["normalized"] = json!(true);
    }
    let attributes = &mut builder.json["meshes"][0]["primitives"][0]["attributes"];
    (attributes["JOINTS_0"], attributes["WEIGHTS_0"]) = (json!(first), json!(foot));
    (attributes["JOINTS_1"], attributes["WEIGHTS_1"]) = (json!(second), json!(upper));
    check_bar(&bent(&builder, &rest), DVec3::ZERO);
}

#[test]
fn skins_that_are_wrong_say_where() {
    let broken = |edit: &dyn Fn(&mut Builder)| {
        let mut builder = bar(90.0);
        edit(&mut builder);
        builder.read().unwrap_err().to_string()
    };
    let fault = broken(&|builder| builder.json["nodes"][0]["skin"] = json!(3));
    assert!(fault.contains("/nodes/0/skin") && fault.contains("skin 3"), "{fault}");
    let fault = broken(&|builder| builder.json["skins"][0]["joints"] = json!([1]));
    assert!(fault.contains("/accessors/3") && fault.contains("vertex 2 names joint 1 of /skins/0"), "{fault}");
    let fault = broken(&|builder| builder.json["skins"][0]["joints"] = json!([1, 2, 2]));
    assert!(fault.contains("2 inverse bind matrices for 3 joints"), "{fault}");
    let fault = broken(&|builder| builder.json["skins"][0]["joints"] = json!([]));
    assert!(fault.contains("a skin without joints"), "{fault}");
    for bad in [-0.5, f32::NAN] {
        let fault = broken(&|builder| {
            let weights = builder.floats("VEC4", &[bad; 24]);
            builder.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(weights);
        });
        assert!(fault.contains("vertex 0 has a weight of"), "{fault}");
    }
    let fault = broken(&|builder| {
        builder.json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("WEIGHTS_0");
    });
    assert!(fault.contains("`WEIGHTS_0` is missing"), "{fault}");
    // What can be made sense of is said.
    let mut builder = bar(90.0);
    let weights = builder.floats("VEC4", &[[0.; 4], [3., 0., 0., 0.]].concat().repeat(3));
    builder.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(weights);
    let found = builder.read().unwrap();
    assert!(
        has_note(&found, "3 vertices without weights") && has_note(&found, "the weights of 3 vertices do not add up")
    );
    let attributes = builder.json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap();
    attributes.retain(|name, _| name == "POSITION" || name == "NORMAL");
    assert!(has_note(&builder.read().unwrap(), "a primitive without joints"));
}
