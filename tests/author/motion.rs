//! What moves, from one format to the other and back: at every frame that is asked for, vertices are where they were.

use super::kit::eyebox;
use eyebox::import::{ImportOptions, ReadOptions, import};
use serde_json::{Value as Json, json};
use std::path::{Path, PathBuf};

/// A glTF asset under construction.
pub(super) struct Asset {
    pub(super) json: Json,
    bin: Vec<u8>,
}

impl Asset {
    pub(super) fn new() -> Self {
        let json = json!({ "asset": { "version": "2.0" }, "bufferViews": [], "accessors": [] });
        Asset { json, bin: Vec::new() }
    }
    pub(super) fn data(&mut self, bytes: &[u8], component: u32, kind: &str, count: usize) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let view = json!({ "buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len() });
        self.bin.extend(bytes);
        let views = self.json["bufferViews"].as_array_mut().expect("a list");
        views.push(view);
        let view = views.len() - 1;
        let accessors = self.json["accessors"].as_array_mut().expect("a list");
        accessors.push(json!({ "bufferView": view, "componentType": component, "type": kind, "count": count }));
        accessors.len() - 1
    }
    pub(super) fn floats(&mut self, kind: &str, lanes: usize, values: &[f32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.data(&bytes, 5126, kind, values.len() / lanes)
    }
    pub(super) fn bytes(&mut self, kind: &str, lanes: usize, values: &[u8]) -> usize {
        self.data(values, 5121, kind, values.len() / lanes)
    }
    pub(super) fn write(mut self, folder: &Path, name: &str) -> PathBuf {
        std::fs::write(folder.join(format!("{name}.bin")), &self.bin).expect("it is written");
        self.json["buffers"] = json!([{ "uri": format!("{name}.bin"), "byteLength": self.bin.len() }]);
        let file = folder.join(format!("{name}.gltf"));
        std::fs::write(&file, self.json.to_string()).expect("it is written");
        file
    }
    /// A pillar of `rings` squares along y: positions, normals, triangles.
    pub(super) fn pillar(&mut self, rings: usize) -> (usize, usize, usize, usize) {
        let corners = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0_f32]];
        let ring = |y: usize| corners.map(|[x, z]| [0.3 * x, y as f32, 0.3 * z]);
        let positions: Vec<f32> = (0..rings).flat_map(ring).flatten().collect();
        let normals: Vec<f32> = (0..rings).flat_map(|_| corners.map(|[x, z]| [x, 0.0, z])).flatten().collect();
        let mut triangles = Vec::new();
        for y in 0..rings as u8 - 1 {
            for k in 0..4 {
                let (a, b) = (4 * y + k, 4 * y + (k + 1) % 4);
                triangles.extend([a, a + 4, b, b, a + 4, b + 4]);
            }
        }
        let count = positions.len() / 3;
        let positions = self.floats("VEC3", 3, &positions);
        let normals = self.floats("VEC3", 3, &normals);
        (positions, normals, self.bytes("SCALAR", 1, &triangles), count)
    }
}

/// Numbers that look like none.
fn dice(seed: u64) -> impl FnMut() -> f32 {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 40) as f32 / (1 << 23) as f32 - 1.0
    }
}

fn turn(next: &mut impl FnMut() -> f32) -> [f32; 4] {
    let q = [next(), next(), next(), next() + 1.5];
    let length = q.iter().map(|x| x * x).sum::<f32>().sqrt();
    q.map(|x| x / length)
}

/// Nodes above each other, each with its own way of moving.
fn moving(folder: &Path, seed: u64) -> PathBuf {
    let mut next = dice(seed);
    let mut asset = Asset::new();
    let (positions, normals, indices, _) = asset.pillar(2);
    let primitive = json!({ "attributes": { "POSITION": positions, "NORMAL": normals }, "indices": indices });
    asset.json["meshes"] = json!([{ "name": "pillar", "primitives": [primitive] }]);
    let node = |name: &str, below: Option<usize>, next: &mut dyn FnMut() -> f32| {
        let mut node =
            json!({ "name": name, "mesh": 0, "translation": [next(), next(), next()], "scale": [1.5, 0.75, 1.0] });
        if let Some(below) = below {
            node["children"] = json!([below]);
        }
        node
    };
    asset.json["nodes"] =
        json!([node("top", Some(1), &mut next), node("middle", Some(2), &mut next), node("low", None, &mut next)]);
    asset.json["nodes"][0]["scale"] = json!([2.0, 2.0, 2.0]);
    asset.json["scenes"] = json!([{ "nodes": [0] }]);
    asset.json["scene"] = json!(0);
    let times = [0.1, 0.4, 0.5, 1.03_f32];
    let input = asset.floats("SCALAR", 1, &times);
    let vectors = |count: usize, next: &mut dyn FnMut() -> f32| (0..3 * count).map(|_| next()).collect::<Vec<f32>>();
    let line = vectors(4, &mut next);
    let step = vectors(4, &mut next);
    let spline = vectors(12, &mut next);
    let turns: Vec<f32> = (0..4).flat_map(|_| turn(&mut next)).collect();
    let turns_in_steps: Vec<f32> = (0..4).flat_map(|_| turn(&mut next)).collect();
    let sizes: Vec<f32> = (0..4)
        .flat_map(|_| {
            let x = next() + 1.7;
            [x, x, x]
        })
        .collect();
    let outputs = [
        asset.floats("VEC3", 3, &line),
        asset.floats("VEC3", 3, &step),
        asset.floats("VEC3", 3, &spline),
        asset.floats("VEC4", 4, &turns),
        asset.floats("VEC4", 4, &turns_in_steps),
        asset.floats("VEC3", 3, &sizes),
    ];
    let kinds = ["LINEAR", "STEP", "CUBICSPLINE", "LINEAR", "STEP", "LINEAR"];
    let samplers: Vec<Json> = outputs
        .iter()
        .zip(kinds)
        .map(|(output, kind)| json!({ "input": input, "output": output, "interpolation": kind }))
        .collect();
    let channel = |sampler: usize, node: usize, path: &str| json!({ "sampler": sampler, "target": { "node": node, "path": path } });
    asset.json["animations"] = json!([{
        "name": "all", "samplers": samplers,
        "channels": [
            channel(0, 0, "translation"), channel(1, 1, "translation"), channel(2, 2, "translation"),
            channel(3, 0, "rotation"), channel(4, 1, "rotation"), channel(5, 0, "scale"),
        ],
    }]);
    asset.write(folder, "moving")
}

/// A pillar that four joints bend and three targets shape, all of them moving; a second mesh hangs on a joint.
fn bent(folder: &Path, seed: u64) -> PathBuf {
    let mut next = dice(seed);
    let mut asset = Asset::new();
    let (positions, normals, indices, count) = asset.pillar(5);
    let joints: Vec<u8> = (0..count)
        .flat_map(|vertex| {
            let ring = (vertex / 4) as u8;
            [ring.min(3), ring.saturating_sub(1), 0, 0]
        })
        .collect();
    let weights: Vec<f32> =
        (0..count).flat_map(|vertex| if vertex < 4 { [1.0, 0.0, 0.0, 0.0] } else { [0.75, 0.25, 0.0, 0.0] }).collect();
    let joints = asset.bytes("VEC4", 4, &joints);
    let weights = asset.floats("VEC4", 4, &weights);
    let targets: Vec<Json> = (0..3)
        .map(|_| {
            let by: Vec<f32> = (0..3 * count).map(|_| 0.1 * next()).collect();
            let normals: Vec<f32> = (0..3 * count).map(|_| 0.1 * next()).collect();
            json!({ "POSITION": asset.floats("VEC3", 3, &by), "NORMAL": asset.floats("VEC3", 3, &normals) })
        })
        .collect();
    let attributes = json!({ "POSITION": positions, "NORMAL": normals, "JOINTS_0": joints, "WEIGHTS_0": weights });
    asset.json["meshes"] = json!([
        { "name": "figure", "primitives": [{ "attributes": attributes, "indices": indices, "targets": targets }], "weights": [0.25, 0.0, 0.0] },
        { "name": "hat", "primitives": [{ "attributes": { "POSITION": positions, "NORMAL": normals }, "indices": indices }] },
    ]);
    // The figure's own node moves nothing of it.
    let joint = |name: &str, next: &mut dyn FnMut() -> f32| json!({ "name": name, "translation": [0.05 * next(), 1.0, 0.0], "scale": [0.7, 0.7, 0.7] });
    asset.json["nodes"] = json!([
        { "name": "figure", "mesh": 0, "skin": 0, "translation": [3.0, 0.0, 1.0] },
        joint("hip", &mut next), joint("knee", &mut next), joint("an kle", &mut next), joint("an/kle", &mut next),
        { "name": "hat", "mesh": 1, "translation": [0.0, 0.5, 0.25] },
        { "name": "root", "children": [0, 1], "rotation": [0.0, 0.6, 0.0, 0.8], "translation": [0.5, 0.0, 0.0] },
    ]);
    for (node, below) in [(1, vec![2]), (2, vec![3, 4]), (4, vec![5])] {
        asset.json["nodes"][node]["children"] = json!(below);
    }
    asset.json["scenes"] = json!([{ "nodes": [6] }]);
    asset.json["scene"] = json!(0);
    let binds: Vec<f32> = (0..4)
        .flat_map(|joint| {
            let mut m = glam::Mat4::from_translation(glam::Vec3::new(0.0, -(joint as f32), 0.1 * next()));
            m *= glam::Mat4::from_rotation_z(0.3 * next());
            m.to_cols_array()
        })
        .collect();
    let binds = asset.floats("MAT4", 16, &binds);
    asset.json["skins"] = json!([{ "joints": [1, 2, 3, 4], "inverseBindMatrices": binds }]);
    let input = asset.floats("SCALAR", 1, &[0.0, 0.25, 0.5, 1.0]);
    let turns: Vec<Vec<f32>> = (0..4).map(|_| (0..4).flat_map(|_| turn(&mut next)).collect()).collect();
    let mut samplers: Vec<Json> =
        turns.iter().map(|turns| json!({ "input": input, "output": asset.floats("VEC4", 4, turns) })).collect();
    let weights: Vec<f32> = (0..12).map(|_| next()).collect();
    samplers.push(json!({ "input": input, "output": asset.floats("SCALAR", 1, &weights) }));
    let places: Vec<f32> = (0..12).map(|_| next()).collect();
    samplers.push(json!({ "input": input, "output": asset.floats("VEC3", 3, &places) }));
    let mut channels: Vec<Json> =
        (0..4).map(|joint| json!({ "sampler": joint, "target": { "node": joint + 1, "path": "rotation" } })).collect();
    channels.push(json!({ "sampler": 4, "target": { "node": 0, "path": "weights" } }));
    channels.push(json!({ "sampler": 5, "target": { "node": 6, "path": "translation" } }));
    asset.json["animations"] = json!([{ "samplers": samplers, "channels": channels }]);
    asset.write(folder, "bent")
}

/// Parts by their paths: vertices in the world and their normals.
pub(super) type Parts = Vec<(String, Vec<[f64; 3]>, Vec<[f64; 3]>)>;

pub(super) fn vertices(file: &Path, frame: Option<f64>) -> Parts {
    let options =
        ImportOptions { reading: ReadOptions { frame, ..ReadOptions::default() }, ..ImportOptions::default() };
    let scene = import(file, &options).unwrap_or_else(|fault| panic!("{}: {fault}", file.display())).scene;
    scene
        .parts
        .iter()
        .map(|part| {
            let mesh = &scene.meshes[part.mesh.index()];
            let wide = |p: &[f32; 3]| glam::DVec3::from(p.map(f64::from));
            let turned = part.to_world.matrix3.inverse().transpose();
            let positions = mesh.positions.iter().map(|p| part.to_world.transform_point3(wide(p)).to_array()).collect();
            let normals = mesh.normals.iter().map(|n| (turned * wide(n)).normalize().to_array()).collect();
            (part.path.clone(), positions, normals)
        })
        .collect()
}

fn largest(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.as_flattened().iter().zip(b.as_flattened()).fold(0.0, |most, (a, b)| f64::max(most, (a - b).abs()))
}

/// Converts `file` along `names` and compares each with it at frames, whole ones and others where both formats are exact.
pub(super) fn survives(file: &Path, names: &[&str], frames: &[f64]) {
    let folder = file.parent().expect("a folder");
    let mut from = file.to_owned();
    for name in names {
        let to = folder.join(name);
        let (code, _, errors) = eyebox(&[Path::new("convert"), &from, &to]);
        assert_eq!((code, errors.as_str()), (Some(0), ""), "{name}");
        for frame in frames.iter().map(|frame| Some(*frame)).chain([None]) {
            let (was, is) = (vertices(file, frame), vertices(&to, frame));
            let paths =
                |all: &[(String, Vec<_>, Vec<_>)]| all.iter().map(|(path, ..)| path.clone()).collect::<Vec<_>>();
            assert_eq!(paths(&was), paths(&is), "{name}");
            for ((path, points, normals), (_, other, others)) in was.iter().zip(&is) {
                let (far, turned) = (largest(points, other), largest(normals, others));
                assert!(far < 2e-6 && turned < 2e-5, "{name}, frame {frame:?}, {path}: {far}, {turned}");
            }
        }
        from = to;
    }
}

/// Keys are at 2.4, 9.6, 12 and 24.72 frames: before the first, on whole frames, on keys, just before a step, after the last.
#[test]
fn nodes_move_as_they_did() {
    for seed in [1, 2] {
        let folder = tempfile::tempdir().expect("a folder");
        let file = moving(folder.path(), seed);
        survives(
            &file,
            &["a.usda", "b.glb", "c.usdc", "d.gltf", "e.usdz"],
            &[0.0, 3.0, 7.0, 9.0, 10.0, 11.0, 12.0, 13.0, 24.0, 25.0, 40.0],
        );
    }
}

#[test]
fn joints_and_targets_bend_as_they_did() {
    for seed in [3, 4] {
        let folder = tempfile::tempdir().expect("a folder");
        let file = bent(folder.path(), seed);
        survives(&file, &["a.usda", "b.glb", "c.usdc", "d.gltf"], &[0.0, 2.0, 5.0, 6.0, 9.0, 12.0, 17.0, 24.0, 30.0]);
    }
}

/// A stage whose points, transforms and camera move, by samples that neither lie on whole frames nor start at 0.
const STAGE: &str = r#"#usda 1.0
(
    defaultPrim = "a"
    metersPerUnit = 0.01
    upAxis = "Z"
    startTimeCode = 4
    endTimeCode = 16
    timeCodesPerSecond = 24
)
def Xform "a"
{
    float3 xformOp:rotateXYZ.timeSamples = { 4: (0, 0, 0), 10.5: (90, 20, 200), 16: (0, -40, 10) }
    uniform token[] xformOpOrder = ["xformOp:rotateXYZ"]
    def Mesh "wave"
    {
        int[] faceVertexCounts = [3, 3]
        int[] faceVertexIndices = [0, 1, 2, 0, 2, 3]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
        point3f[] points.timeSamples = {
            4: [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)],
            9: [(0, 0, 1), (1, 0, 0.5), (1, 1, 0), (0, 1, 2)],
            14: [(0, 0, 1), (1, 0.25, 0.5), (2, 1, 0), (0, 1, -2)],
        }
        uniform token subdivisionScheme = "none"
    }
    def Xform "sheared"
    {
        matrix4d xformOp:transform.timeSamples = {
            4: ( (1, 0, 0, 0), (0.5, 1, 0, 0), (0, 0, 1, 0), (3, 0, 0, 1) ),
            12: ( (1, 0, 0, 0), (-0.5, 1, 0.25, 0), (0, 0, 1, 0), (3, 1, 0, 1) ),
        }
        uniform token[] xformOpOrder = ["xformOp:transform"]
        def Sphere "ball"
        {
            double radius = 0.5
        }
    }
    def Camera "eye"
    {
        float2 clippingRange = (0.5, 400)
        double3 xformOp:translate.timeSamples = { 4: (0, 0, 10), 16: (4, 0, 10) }
        uniform token[] xformOpOrder = ["xformOp:translate"]
        token projection = "orthographic"
        float horizontalAperture = 30
        float verticalAperture = 10
    }
}
"#;

#[test]
fn what_a_stage_moves_is_where_it_was() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("stage.usda");
    std::fs::write(&file, STAGE).expect("it is written");
    survives(&file, &["a.usdc", "b.usdz"], &[4.0, 7.0, 9.0, 11.0, 16.0]);
    let glb = folder.path().join("c.glb");
    let (code, said, _) = eyebox(&[Path::new("convert"), &file, &glb]);
    assert_eq!(code, Some(0));
    let warnings: Vec<&str> = said.lines().filter(|line| line.starts_with("warning")).collect();
    assert!(warnings.iter().any(|line| line.contains("mesh `wave` moves by its vertices")), "{warnings:?}");
    for frame in [4.0, 7.0, 9.0, 11.0, 16.0] {
        for ((path, points, _), (_, other, _)) in vertices(&file, Some(frame)).iter().zip(&vertices(&glb, Some(frame)))
        {
            let far = largest(points, other);
            // Vertices in centimetres, of single precision. What is sheared stands still.
            assert!(far < 1e-7 || path.contains("sheared"), "frame {frame}, {path}: {far}");
        }
    }
    let written = glb_json(&glb);
    let camera = &written["cameras"][0]["orthographic"];
    for (key, metres) in [("znear", 0.005), ("zfar", 4.0), ("xmag", 0.015), ("ymag", 0.005)] {
        let found = camera[key].as_f64().expect("a number");
        assert!((found - metres).abs() < 1e-9, "{key}: {found}");
    }
    let moved = written["animations"][0]["channels"].as_array().expect("channels");
    let eye = written["nodes"].as_array().expect("nodes").iter().position(|node| node.get("camera").is_some());
    assert!(moved.iter().any(|channel| channel["target"]["node"].as_u64() == eye.map(|eye| eye as u64)));
}

pub(super) fn glb_json(file: &Path) -> Json {
    let bytes = std::fs::read(file).expect("it is there");
    let length = u32::from_le_bytes(bytes[12..16].try_into().expect("four bytes")) as usize;
    serde_json::from_slice(&bytes[20..20 + length]).expect("JSON")
}

/// A sheared node that moves stands still in glTF, which one line tells; frames before 0 start at 0.
#[test]
fn what_gltf_cannot_say_is_a_line_each() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("stage.usda");
    std::fs::write(&file, STAGE.replace(" 4: (", " -8: (")).expect("it is written");
    let (code, said, _) = eyebox(&[Path::new("convert"), &file, &folder.path().join("a.gltf")]);
    assert_eq!(code, Some(0));
    let about = |text: &str| said.lines().filter(|line| line.starts_with("warning") && line.contains(text)).count();
    assert_eq!(
        (about("moves with a shear"), about("frames before 0"), about("moves by its vertices")),
        (1, 1, 1),
        "{said}"
    );
}

/// With a frame nothing moves: what is written is that moment.
#[test]
fn a_frame_is_a_moment() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = bent(folder.path(), 5);
    let still = folder.path().join("still.gltf");
    let (code, ..) = eyebox(&[Path::new("convert"), &file, &still, Path::new("--frame"), Path::new("7")]);
    assert_eq!(code, Some(0));
    let json: Json = serde_json::from_slice(&std::fs::read(&still).expect("it is there")).expect("JSON");
    assert!(json.get("animations").is_none() && json.get("skins").is_none());
    for ((path, points, _), (_, other, _)) in vertices(&file, Some(7.0)).iter().zip(&vertices(&still, None)) {
        assert_eq!(largest(points, other), 0.0, "{path}");
    }
}
