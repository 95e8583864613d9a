//! Motion in which something is not there, or is cut another way, at some frames: everything else moves on.

use super::kit::eyebox;
use super::motion::{Asset, Parts, glb_json, survives, vertices};
use serde_json::{Value as Json, json};
use std::path::{Path, PathBuf};

fn stage(folder: &Path, prims: &str) -> PathBuf {
    let head = "#usda 1.0\n(\n    defaultPrim = \"a\"\n    metersPerUnit = 1\n    upAxis = \"Y\"\n)\n";
    let file = folder.join("stage.usda");
    std::fs::write(&file, format!("{head}def SkelRoot \"a\"\n{{\n{prims}}}\n")).expect("it is written");
    file
}

/// What `convert` warns of.
fn warnings(from: &Path, to: &Path) -> Vec<String> {
    let (code, said, errors) = eyebox(&[Path::new("convert"), from, to]);
    assert_eq!((code, errors.as_str()), (Some(0), ""));
    said.lines().filter(|line| line.starts_with("warning")).map(str::to_owned).collect()
}

/// The points of the parts whose path has `name` in it.
fn points(parts: &Parts, name: &str) -> Vec<[f64; 3]> {
    parts.iter().filter(|(path, ..)| path.contains(name)).flat_map(|(_, points, _)| points.clone()).collect()
}

/// The largest distance from a point of one to the nearest of the other.
fn apart(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    assert!(!a.is_empty() && !b.is_empty());
    let distance = |p: &[f64; 3], q: &[f64; 3]| glam::DVec3::from(*p).distance(glam::DVec3::from(*q));
    let near = |p: &[f64; 3], all: &[[f64; 3]]| all.iter().fold(f64::MAX, |least, q| least.min(distance(p, q)));
    let one = |a: &[[f64; 3]], b: &[[f64; 3]]| a.iter().fold(0.0, |most: f64, p| most.max(near(p, b)));
    one(a, b).max(one(b, a))
}

/// From frame 6 to 11 the joint mirrors, which turns triangles round; it moves at every frame, the last one above all.
#[test]
fn joints_that_mirror_keep_their_frames() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut asset = Asset::new();
    let (positions, normals, indices, count) = asset.pillar(3);
    let joints = asset.bytes("VEC4", 4, &vec![0; 4 * count]);
    let weights = asset.floats("VEC4", 4, &[1.0, 0.0, 0.0, 0.0].repeat(count));
    let attributes = json!({ "POSITION": positions, "NORMAL": normals, "JOINTS_0": joints, "WEIGHTS_0": weights });
    asset.json["meshes"] =
        json!([{ "name": "figure", "primitives": [{ "attributes": attributes, "indices": indices }] }]);
    asset.json["nodes"] = json!([{ "name": "figure", "mesh": 0, "skin": 0 }, { "name": "joint" }]);
    asset.json["skins"] = json!([{ "joints": [1] }]);
    asset.json["scenes"] = json!([{ "nodes": [0, 1] }]);
    asset.json["scene"] = json!(0);
    let input = asset.floats("SCALAR", 1, &[0.0, 0.25, 0.5, 1.0]);
    let sizes = asset.floats("VEC3", 3, &[1.0, 1.0, 1.0, -1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 2.0, 1.0]);
    let places = asset.floats("VEC3", 3, &[0.0, 0.0, 0.0, 1.0, 0.5, 0.0, 0.0, 1.0, 3.0, 5.0, 0.0, 1.0]);
    asset.json["animations"] = json!([{
        "samplers": [{ "input": input, "output": sizes, "interpolation": "STEP" }, { "input": input, "output": places }],
        "channels": [
            { "sampler": 0, "target": { "node": 1, "path": "scale" } },
            { "sampler": 1, "target": { "node": 1, "path": "translation" } },
        ],
    }]);
    let mut json = asset.json.clone();
    let file = asset.write(folder.path(), "mirrored");
    assert_eq!(warnings(&file, &folder.path().join("said.glb")), Vec::<String>::new());
    survives(&file, &["a.usda", "b.glb", "c.usdc"], &[0.0, 3.0, 5.0, 6.0, 9.0, 11.0, 12.0, 18.0, 23.0, 24.0]);
    // A joint that mirrors all the time turns triangles round once, not with each format.
    json["nodes"][1]["scale"] = json!([-1, 1, 1]);
    json["animations"][0]["channels"].as_array_mut().expect("channels").remove(0);
    json["buffers"] = json!([{ "uri": "mirrored.bin", "byteLength": std::fs::metadata(folder.path().join("mirrored.bin")).expect("it is there").len() }]);
    let file = folder.path().join("always.gltf");
    std::fs::write(&file, json.to_string()).expect("it is written");
    survives(&file, &["d.usda", "e.glb"], &[0.0, 9.0, 24.0]);
    let direct = folder.path().join("f.glb");
    assert_eq!(eyebox(&[Path::new("convert"), &file, &direct]).0, Some(0));
    let triangles =
        |file: &Path| super::kit::scene(file).meshes.iter().map(|mesh| mesh.triangles.clone()).collect::<Vec<_>>();
    for to in ["d.usda", "e.glb", "f.glb"] {
        assert_eq!(triangles(&folder.path().join(to)), triangles(&file), "{to}");
    }
}

/// A square whose corner a joint moves through the opposite side: it is cut along its other diagonal then.
#[test]
fn joints_that_make_a_polygon_hollow_keep_their_frames() {
    let folder = tempfile::tempdir().expect("a folder");
    let still = "( (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1) )";
    let prims = format!(
        r#"    def Skeleton "bones" (
        prepend apiSchemas = ["SkelBindingAPI"]
    )
    {{
        uniform token[] joints = ["one", "two"]
        uniform matrix4d[] bindTransforms = [{still}, {still}]
        uniform matrix4d[] restTransforms = [{still}, {still}]
        rel skel:animationSource = </a/bones/motion>
        def SkelAnimation "motion"
        {{
            uniform token[] joints = ["one", "two"]
            quatf[] rotations = [(1, 0, 0, 0), (1, 0, 0, 0)]
            half3[] scales = [(1, 1, 1), (1, 1, 1)]
            float3[] translations.timeSamples = {{
                0: [(0, 0, 0), (0, 0, 0)],
                4: [(0, 0, 0), (-0.8, 0.8, 0)],
                8: [(1, 0, 0), (0, 0, 0)],
                10: [(0, 0, 0), (3, 1, 0)],
            }}
        }}
    }}
    def Mesh "square" (
        prepend apiSchemas = ["SkelBindingAPI"]
    )
    {{
        int[] faceVertexCounts = [4]
        int[] faceVertexIndices = [0, 1, 2, 3]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
        normal3f[] normals = [(0, 0, 1), (0, 0, 1), (0, 0, 1), (0, 0, 1)] ( interpolation = "vertex" )
        uniform token subdivisionScheme = "none"
        rel skel:skeleton = </a/bones>
        int[] primvars:skel:jointIndices = [0, 1, 0, 0] ( elementSize = 1 interpolation = "vertex" )
        float[] primvars:skel:jointWeights = [1, 1, 1, 1] ( elementSize = 1 interpolation = "vertex" )
    }}
"#
    );
    let file = stage(folder.path(), &prims);
    let (usd, glb) = (folder.path().join("a.usdc"), folder.path().join("b.glb"));
    for to in [&usd, &glb] {
        let said = warnings(&file, to);
        let about = said.iter().filter(|line| line.contains("mesh `square` has other triangles at times")).count();
        assert_eq!((about, said.len()), (1, 1), "{said:?}");
        for frame in 0..=10 {
            let frame = Some(f64::from(frame));
            let far = apart(&points(&vertices(&file, frame), "square"), &points(&vertices(to, frame), "square"));
            assert!(far < 2e-6, "{}, frame {frame:?}: {far}", to.display());
        }
    }
}

const FLAG: &str = r#"        int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 2]
        uniform token subdivisionScheme = "none"
"#;

/// One part blinks, and another one appears; what stands between and beside them moves, by its node and by its vertices.
#[test]
fn what_blinks_stops_nothing_else() {
    let folder = tempfile::tempdir().expect("a folder");
    let still = "        point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]\n";
    let blink = |name: &str, seen: &str| {
        format!(
            "    def Mesh \"{name}\"\n    {{\n        token visibility.timeSamples = {{ {seen} }}\n{still}{FLAG}    }}\n"
        )
    };
    let prims = format!(
        r#"{}    def Mesh "goes"
    {{
        double3 xformOp:translate.timeSamples = {{ 0: (0, 0, 0), 5: (1, 2, 3), 10: (4, -2, 0) }}
        uniform token[] xformOpOrder = ["xformOp:translate"]
{still}{FLAG}    }}
    def Mesh "waves"
    {{
        point3f[] points.timeSamples = {{
            0: [(0, 0, 0), (1, 0, 0), (0, 1, 0)],
            4: [(0, 0, 2), (1, 0, 0), (0, 1, 1)],
            10: [(0, 5, 0), (1, 0, 3), (0, 1, 0)],
        }}
{FLAG}    }}
{}"#,
        blink("blinks", "0: \"inherited\", 3: \"invisible\", 6: \"inherited\""),
        blink("appears", "0: \"invisible\", 7: \"inherited\""),
    );
    let file = stage(folder.path(), &prims);
    let (usd, glb) = (folder.path().join("a.usdc"), folder.path().join("b.glb"));
    for to in [&usd, &glb] {
        let said = warnings(&file, to);
        let about = |text: &str| said.iter().filter(|line| line.contains(text)).count();
        assert_eq!((about("parts that vanish"), about("parts that appear")), (1, 1), "{said:?}");
        for frame in 0..=10 {
            let frame = Some(f64::from(frame));
            let (was, is) = (vertices(&file, frame), vertices(to, frame));
            for name in ["goes", "waves"] {
                let far = apart(&points(&was, name), &points(&is, name));
                assert!(far < 2e-6, "{}, {name}, frame {frame:?}: {far}", to.display());
            }
        }
    }
}

/// Each light, camera and material is compared with itself, and each change of one is a line.
#[test]
fn what_changes_and_is_not_carried_is_a_line_each() {
    let folder = tempfile::tempdir().expect("a folder");
    let light = |name: &str, power: u32, seen: &str| {
        format!("    def SphereLight \"{name}\"\n    {{\n        float inputs:intensity = {power}\n{seen}    }}\n")
    };
    let camera = |name: &str, lines: &str| {
        format!("    def Camera \"{name}\"\n    {{\n        token projection = \"orthographic\"\n{lines}    }}\n")
    };
    let paint = |name: &str, color: &str| {
        let shader = format!(
            "            uniform token info:id = \"UsdPreviewSurface\"\n            color3f inputs:diffuseColor{color}\n            token outputs:surface\n"
        );
        format!(
            "    def Mesh \"of_{name}\" (\n        prepend apiSchemas = [\"MaterialBindingAPI\"]\n    )\n    {{\n        point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]\n        rel material:binding = </a/{name}>\n{FLAG}    }}\n    def Material \"{name}\"\n    {{\n        token outputs:surface.connect = </a/{name}/S.outputs:surface>\n        def Shader \"S\"\n        {{\n{shader}        }}\n    }}\n"
        )
    };
    let gone = "        token visibility.timeSamples = { 0: \"inherited\", 2: \"invisible\" }\n";
    let prims = [
        light("first", 1, ""),
        light("middle", 2, gone),
        light("third", 3, ""),
        light("last", 4, gone),
        camera("near", "        float2 clippingRange.timeSamples = { 0: (1, 100), 4: (2, 100) }\n"),
        camera("wide", "        float horizontalAperture.timeSamples = { 0: 20, 4: 30 }\n"),
        camera("calm", "        float2 clippingRange = (1, 100)\n"),
        paint("fades", ".timeSamples = { 0: (1, 0, 0), 4: (0, 1, 0) }"),
        paint("stays", " = (0, 0, 1)"),
    ];
    let file = stage(folder.path(), &prims.concat());
    let said = warnings(&file, &folder.path().join("a.usdc"));
    let about = |name: &str| said.iter().filter(|line| line.contains(&format!("`{name}` changes in time"))).count();
    let names = ["first", "middle", "third", "last", "near", "wide", "calm", "fades", "stays"];
    assert_eq!(names.map(about), [0, 1, 0, 1, 1, 1, 0, 1, 0], "{said:#?}");
}

/// 20 000 triangles of their own, which one key moves at the first of 4001 frames.
#[test]
fn more_motion_than_memory_is_a_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let count = 20_000;
    let list = |of: &dyn Fn(usize) -> String| (0..count).map(of).collect::<Vec<_>>().join(", ");
    let corners = |z: usize| list(&|i| format!("({i}, 0, {z}), ({i}.5, 0, 0), ({i}, 1, 0)"));
    let prims = format!(
        "    def Mesh \"much\"\n    {{\n        int[] faceVertexCounts = [{}]\n        int[] faceVertexIndices = [{}]\n        point3f[] points = [{}]\n        point3f[] points.timeSamples = {{ 0: [{}], 4000: [{}] }}\n        uniform token subdivisionScheme = \"none\"\n    }}\n",
        list(&|_| "3".to_owned()),
        list(&|i| format!("{}, {}, {}", 3 * i, 3 * i + 1, 3 * i + 2)),
        corners(0),
        corners(1),
        corners(2),
    );
    let file = stage(folder.path(), &prims);
    let (code, _, errors) = eyebox(&[Path::new("convert"), &file, &folder.path().join("a.usdc")]);
    assert_eq!((code, errors.trim_end().lines().count()), (Some(2), 1), "{errors}");
    assert!(errors.contains("/a/much") && errors.contains("at 4001 frames") && errors.contains("--frame"), "{errors}");
}

/// No channel moves a node with a `matrix` (glTF 2.0, section 3.5.2), not even where only weights of its mesh move.
#[test]
fn nodes_that_move_have_no_matrix() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut asset = Asset::new();
    let (positions, normals, indices, count) = asset.pillar(2);
    let by: Vec<f32> = (0..3 * count).map(|i| 0.1 * i as f32).collect();
    let target = json!({ "POSITION": asset.floats("VEC3", 3, &by) });
    let attributes = json!({ "POSITION": positions, "NORMAL": normals });
    asset.json["meshes"] = json!([{ "name": "soft", "primitives": [{ "attributes": attributes, "indices": indices, "targets": [target] }] }]);
    asset.json["nodes"] = json!([
        { "name": "soft", "mesh": 0, "translation": [1.0, 2.0, 3.0], "rotation": [0.6, 0.0, 0.0, 0.8], "scale": [1.0, 2.0, 0.5] },
    ]);
    asset.json["scenes"] = json!([{ "nodes": [0] }]);
    asset.json["scene"] = json!(0);
    let input = asset.floats("SCALAR", 1, &[0.0, 1.0]);
    let weights = asset.floats("SCALAR", 1, &[0.0, 1.0]);
    asset.json["animations"] = json!([{
        "samplers": [{ "input": input, "output": weights }],
        "channels": [{ "sampler": 0, "target": { "node": 0, "path": "weights" } }],
    }]);
    let file = asset.write(folder.path(), "soft");
    survives(&file, &["a.glb", "b.usdc", "c.glb"], &[0.0, 7.0, 24.0]);
    for name in ["a.glb", "c.glb"] {
        let written = glb_json(&folder.path().join(name));
        let channels = written["animations"][0]["channels"].as_array().expect("channels");
        let moved = channels.iter().filter_map(|channel| channel["target"]["node"].as_u64());
        let moved: Vec<&Json> = moved.map(|node| &written["nodes"][node as usize]).collect();
        assert!(!moved.is_empty() && moved.iter().all(|node| node.get("matrix").is_none()), "{name}: {moved:?}");
    }
}
