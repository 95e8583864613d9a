//! Honest files that were refused, or read in silence as something else.

use super::{data, read, seen, warnings};
use eyebox::import::{self, ReadOptions};
use eyebox::plan::Choice;
use eyebox::scene::{Colour, Finish, Shape};
use std::fmt::Write;
use std::path::Path;

/// Unity's exporter lists nodes that have a parent.
#[test]
fn a_scene_may_list_what_is_no_root() {
    let built = read(&data("not_a_root.gltf"), &[]);
    assert_eq!(built.scene.parts.len(), 1);
    assert!(
        warnings(&built).iter().any(|text| text.contains("lists a node that has a parent")),
        "{:?}",
        built.scene.notes
    );
    let text = std::fs::read_to_string(data("not_a_root.gltf")).expect("a text");
    let folder = tempfile::tempdir().expect("a folder");
    let asset = folder.path().join("a.gltf");
    // What is above stays out, unless it is listed, too; and what is listed twice is there once.
    let moved = text.replace(r#"{"name": "tmpParent","#, r#"{"name": "tmpParent", "translation": [5, 0, 0],"#);
    for (nodes, shift) in [("[1]", 0.0), ("[0, 1]", 5.0), ("[1, 0]", 5.0), ("[1, 1]", 0.0), ("[0]", 5.0)] {
        std::fs::write(&asset, moved.replace(r#""nodes": [1]"#, &format!(r#""nodes": {nodes}"#))).expect("a file");
        let built = read(&asset, &[]);
        assert_eq!(built.scene.parts.len(), 1, "{nodes}");
        assert_eq!(built.scene.parts[0].to_world.translation.x, shift, "{nodes}");
        assert_eq!(warnings(&built).is_empty(), nodes == "[0]", "{nodes}: {:?}", built.scene.notes);
    }
}

/// What reads coordinates that a shape has not has the fallback of its reader, as on a mesh.
#[test]
fn shapes_without_coordinates_may_have_pictures() {
    let text = std::fs::read_to_string(data("textured_sphere.usda")).expect("a text");
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::copy(data("q.png"), folder.path().join("q.png")).expect("a copy");
    let asset = folder.path().join("a.usda");
    for kind in ["Sphere", "Plane", "Capsule", "Cube", "Cone", "Cylinder"] {
        let text = text.replace("def Sphere", &format!("def {kind}")).replace("double radius=1", "");
        // The middle of the upper left texel, which is red.
        let text = text.replace(
            "string inputs:varname=\"st\"",
            "string inputs:varname=\"st\"\nfloat2 inputs:fallback=(0.25, 0.75)",
        );
        std::fs::write(&asset, &text).expect("a file");
        let built = read(&asset, &[]);
        let said = warnings(&built).join("\n");
        assert!(said.contains("reads the texture coordinates `st`"), "{kind}: {said}");
        let exact = built.scene.parts[0].faces.iter().filter(|face| face.shape != Shape::Mesh).count();
        assert_eq!(
            exact,
            match kind {
                "Sphere" => 1,
                "Capsule" => 2,
                _ => 0,
            },
            "{kind}"
        );
        let (found, _) = seen(&asset, &[], Choice::Auto, 4);
        assert!(found > 0.0, "{kind}");
        // One that is said holds all over.
        let with = text.replace("rel material:binding", "texCoord2f primvars:st = (0.75, 0.75)\n rel material:binding");
        std::fs::write(&asset, with).expect("a file");
        assert!(warnings(&read(&asset, &[])).is_empty(), "{kind}");
    }
}

/// A lamp says nothing of what it lights.
#[test]
fn a_mesh_light_leaves_the_rest_as_it_looks() {
    let built = read(&data("M1_ml_grey.usda"), &[]);
    let [lamp, wall] = &built.scene.parts[..] else { panic!("two parts") };
    assert!(lamp.faces[0].emitter.is_some() && wall.faces[0].emitter.is_none());
    let Finish::Surface { surface } = wall.faces[0].finish else { panic!("{:?}", wall.faces[0].finish) };
    assert_eq!(built.scene.surfaces[surface.index()].base_color, Colour::new([0.8; 3]));
    assert!(built.scene.sky.is_none(), "the lamp lights it");
    // As glTF it is the same.
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("a.glb");
    let assembly = import::asset(&data("M1_ml_grey.usda")).unwrap_or_else(|fault| panic!("{fault}"));
    eyebox::author::convert(&assembly, &out).unwrap_or_else(|fault| panic!("{fault}"));
    assert_eq!(read(&out, &[]).scene.parts.len(), 2);
}

fn shapes(path: &Path, count: usize, shape: impl Fn(usize) -> String) -> usize {
    let mut text = "#usda 1.0\n(\n metersPerUnit = 1\n)\n".to_owned();
    for k in 0..count {
        let x = 3 * k;
        let _ = writeln!(
            text,
            "def {} double3 xformOp:translate = ({x}, 0, 0)\n uniform token[] xformOpOrder = [\"xformOp:translate\"] }}",
            shape(k)
        );
    }
    std::fs::write(path, text).expect("a file");
    let found = import::asset(path).unwrap_or_else(|fault| panic!("{fault}"));
    assert_eq!(found.nodes.len(), count);
    found.meshes.len()
}

/// Shapes that are alike share a mesh whatever they are called, and many that are not are honest, too.
#[test]
fn many_shapes_are_no_attack() {
    let folder = tempfile::tempdir().expect("a folder");
    let asset = folder.path().join("a.usda");
    let alike = shapes(&asset, 200, |k| format!("Capsule \"S{k}\" {{ double radius = 0.2\n double height = 0.3\n"));
    assert_eq!(alike, 1);
    let other = shapes(&asset, 600, |k| format!("Sphere \"S{k}\" {{ double radius = {}\n", 1.0 + 1e-3 * k as f64));
    assert_eq!(other, 600);
}

/// A shader of a kind that is not known has its base colour where a name says it, and a warning in any case.
#[test]
fn unknown_materials_are_said() {
    let built = read(&data("disney.usda"), &[]);
    let said = warnings(&built).join("\n");
    assert!(said.contains("disney_principled") && said.contains("`baseColor` is taken"), "{said}");
    let id = built.scene.parts[0].faces[0].finish.surface().expect("a surface");
    let colour = built.scene.surfaces[id.index()].base_color.factor;
    assert!(colour.iter().zip([0.9, 0.1, 0.1]).all(|(a, b)| (a - b).abs() < 1e-6), "{colour:?}");
    let other = |outputs: &str, shader: &str| {
        let folder = tempfile::tempdir().expect("a folder");
        let asset = folder.path().join("a.usda");
        let text = format!(
            "#usda 1.0\n(\n metersPerUnit = 1\n)\ndef Sphere \"S\" (prepend apiSchemas = [\"MaterialBindingAPI\"]) {{ rel material:binding = </M> }}\ndef Material \"M\" {{ token outputs:{outputs}.connect = </M/S.outputs:out>\n def Shader \"S\" {{ {shader}\n token outputs:out }} }}\n"
        );
        std::fs::write(&asset, text).expect("a file");
        let built = read(&asset, &[]);
        let id = built.scene.parts[0].faces[0].finish.surface().expect("a surface");
        (built.scene.surfaces[id.index()].base_color.factor[0], warnings(&built).join("\n"))
    };
    let (red, said) =
        other("ri:surface", "uniform token info:id = \"PxrSurface\"\ncolor3f inputs:diffuseColor = (0.25, 0, 0)");
    assert!(red == 0.25 && said.contains("PxrSurface"), "{red} {said}");
    let mdl = "uniform token info:implementationSource = \"sourceAsset\"\nuniform token info:mdl:sourceAsset:subIdentifier = \"OmniPBR\"\ncolor3f inputs:diffuse_color_constant = (0.5, 0, 0)";
    let (red, said) = other("mdl:surface", mdl);
    assert!(red == 0.5 && said.contains("OmniPBR"), "{red} {said}");
    let (red, said) = other("surface", "uniform token info:id = \"chiang_hair\"\nfloat inputs:ior = 1.55");
    assert!(red == 0.8 && said.contains("chiang_hair") && said.contains("grey"), "{red} {said}");
    // Arnold's is the standard surface under another name.
    let arnold = "uniform token info:id = \"arnold:standard_surface\"\ncolor3f inputs:base_color = (0.125, 0, 0)\nfloat inputs:base = 1";
    let (red, said) = other("arnold:surface", arnold);
    assert!(red == 0.125 && said.is_empty(), "{red} {said}");
}

/// Exporters write an animation for each thing that moves: all of them move.
#[test]
fn several_animations_move_at_once() {
    let text = std::fs::read_to_string(data("not_a_root.gltf")).expect("a text");
    let folder = tempfile::tempdir().expect("a folder");
    let asset = folder.path().join("a.gltf");
    // Times 0 and 1 s, and places from 0 to (1, 0, 0): bytes of the positions do for both.
    let bytes = |numbers: &[f32]| numbers.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    std::fs::write(folder.path().join("keys.bin"), bytes(&[0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 2.0, 0.0])).expect("a file");
    let mut json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    json["scenes"][0]["nodes"] = serde_json::json!([0]);
    let push = |json: &mut serde_json::Value, list: &str, item: serde_json::Value| {
        json[list].as_array_mut().expect("a list").push(item)
    };
    push(&mut json, "buffers", serde_json::json!({ "byteLength": 32, "uri": "keys.bin" }));
    for (offset, length, kind, count) in [(0, 8, "SCALAR", 2), (8, 24, "VEC3", 2)] {
        push(&mut json, "bufferViews", serde_json::json!({ "buffer": 1, "byteOffset": offset, "byteLength": length }));
        push(
            &mut json,
            "accessors",
            serde_json::json!({ "bufferView": if count == 2 && kind == "SCALAR" { 4 } else { 5 }, "componentType": 5126, "count": count, "type": kind, "min": if kind == "SCALAR" { vec![0.0] } else { vec![0.0; 3] }, "max": if kind == "SCALAR" { vec![1.0] } else { vec![1.0, 2.0, 0.0] } }),
        );
    }
    let animation = |name: &str, node: usize| serde_json::json!({ "name": name, "samplers": [{ "input": 4, "output": 5 }], "channels": [{ "sampler": 0, "target": { "node": node, "path": "translation" } }] });
    json["animations"] = serde_json::json!([animation("parent", 0), animation("child", 1)]);
    std::fs::write(&asset, json.to_string()).expect("a file");
    let at = |animation: Option<&str>| {
        let options =
            ReadOptions { frame: Some(24.0), animation: animation.map(str::to_owned), ..ReadOptions::default() };
        let (assembly, _) = import::read(&asset, &options).unwrap_or_else(|fault| panic!("{fault}"));
        assembly.nodes.last().expect("a node").to_world.translation.x
    };
    assert_eq!([at(None), at(Some("parent")), at(Some("child"))], [2.0, 1.0, 1.0]);
    let (moving, _) = import::moving(&asset, &ReadOptions::default()).unwrap_or_else(|fault| panic!("{fault}"));
    assert_eq!(moving.motion.expect("it moves").nodes.len(), 2);
}

/// A polygon that bends may be cut into other triangles, and normals that differ may fall together: what bends it is the same.
#[test]
fn a_skin_is_kept_whatever_polygons_are_cut_into() {
    let folder = tempfile::tempdir().expect("a folder");
    let asset = folder.path().join("a.usda");
    std::fs::write(&asset, SKIN).expect("a file");
    let (found, _) = import::moving(&asset, &ReadOptions::default()).unwrap_or_else(|fault| panic!("{fault}"));
    let rig = found.meshes[0].rig.as_ref().expect("what bends it");
    assert_eq!(rig.skin.as_ref().expect("a skin").joints.len(), 2);
    assert_eq!(found.motion.expect("it moves").rigs.len(), 1);
    // At rest the corner is at (1, 0), and now inside.
    assert!(
        rig.rest.positions.contains(&[1.0, 0.0, 0.0]) && found.meshes[0].mesh.positions.iter().any(|p| p[0] == 0.25)
    );
}

const SKIN: &str = r#"#usda 1.0
(
    metersPerUnit = 1
    upAxis = "Y"
    startTimeCode = 0
    endTimeCode = 2
)
def SkelRoot "Root" (prepend apiSchemas = ["SkelBindingAPI"]) {
    rel skel:skeleton = </Root/Rig>
    def Skeleton "Rig" (prepend apiSchemas = ["SkelBindingAPI"]) {
        uniform token[] joints = ["foot", "foot/corner"]
        uniform matrix4d[] bindTransforms = [
            ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)),
            ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1))]
        uniform matrix4d[] restTransforms = [
            ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)),
            ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1))]
        rel skel:animationSource = </Root/Rig/Move>
        def SkelAnimation "Move" {
            uniform token[] joints = ["foot", "foot/corner"]
            float3[] translations = [(0, 0, 0), (-0.75, 0.75, 0)]
            float3[] translations.timeSamples = {
                0: [(0, 0, 0), (-0.75, 0.75, 0)], 2: [(0, 0, 0), (0, 0, 0)], }
            quatf[] rotations = [(1, 0, 0, 0), (1, 0, 0, 0)]
            half3[] scales = [(1, 1, 1), (1, 1, 1)]
        }
    }
    def Mesh "Square" (prepend apiSchemas = ["SkelBindingAPI"]) {
        uniform token subdivisionScheme = "none"
        int[] faceVertexCounts = [4]
        int[] faceVertexIndices = [0, 1, 2, 3]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
        normal3f[] normals = [(0, 0, 1), (0, 0, 1), (0, 0, 1), (0, 0, 1)]
        int[] primvars:skel:jointIndices = [0, 1, 0, 0] (
            elementSize = 1
            interpolation = "vertex")
        float[] primvars:skel:jointWeights = [1, 1, 1, 1] (
            elementSize = 1
            interpolation = "vertex")
    }
}
"#;
