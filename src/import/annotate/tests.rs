//! An annotated asset means by itself what the asset and its sidecar mean together.

use super::annotate;
use crate::testing::assembly;
use crate::tests::BASE;
use crate::{Assembly, Value, build, toml};
use eyebox_base::relative_path::folder_of;
use eyebox_scene::Scene;
use proptest::prelude::*;
use std::path::Path;

/// What a scene says, without names of files, notes and the hash of its inputs.
pub fn said(scene: &Scene) -> serde_json::Value {
    let mut json = serde_json::to_value(scene).unwrap();
    for key in ["name", "hash", "notes"] {
        json.as_object_mut().unwrap().remove(key);
    }
    if let Some(sky) = json["sky"].as_object_mut() {
        sky.remove("file");
    }
    for slide in json["slides"].as_array_mut().unwrap() {
        slide.as_object_mut().unwrap().remove("file");
    }
    json
}

fn alone(assembly: &Assembly, sidecar: &Value, out: &Path) -> Assembly {
    let mut alone = assembly.clone();
    annotate(assembly, Some(sidecar), out).unwrap().apply(&mut alone);
    alone
}

#[test]
fn both_huds_mean_the_same_without_their_sidecars() {
    for sample in ["samples/hud-direct/hud.optics.toml", "samples/hud-diffuse/hud.optics.toml"] {
        let file = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join(sample);
        let (asset, sidecar) = crate::read(&file, &Default::default()).unwrap();
        let sidecar = sidecar.unwrap().1;
        let alone = alone(&asset, &sidecar, &folder_of(&file));
        let again = annotate(&alone, None, &folder_of(&file)).unwrap();
        assert!(again.is_empty(), "{again:?}");
        let together = build(asset, Some(&sidecar), &[]).unwrap().scene;
        assert_eq!(said(&build(alone, None, &[]).unwrap().scene), said(&together), "{sample}");
    }
}

#[test]
fn references_become_indices_and_equal_faces_one_row() {
    let text = format!(
        "{BASE}[coating.ar]\nstack = [{{ n = 1.38, thickness_nm = 99.638 }}]\n[medium.oil]\nior = 1.4\npriority = 2\n\
         [[bind]]\nname = \"LENS\"\nmedium = \"oil\"\n[[bind]]\nname = \"LENS\"\nfaces = [0, 2]\nfinish = \"polished\"\n\
         coating = \"ar\"\nshape = {{ kind = \"fit\", tolerance_um = 1 }}\n\
         [[bind]]\nname = \"L*D*\"\nnormal = \"+z\"\nemitter = {{ group = \"led\", flux_lm = 1 }}\n"
    );
    let sidecar = toml::parse(&text, Path::new("hud.optics.toml")).unwrap();
    let annotation = annotate(&assembly(&["LENS", "LED_1", "LED_2"]), Some(&sidecar), Path::new(".")).unwrap();
    let nodes: Vec<String> = annotation.nodes.iter().map(|(node, value)| format!("{node}: {value}")).collect();
    assert_eq!(
        nodes,
        [
            "1: { medium = 0, faces = [{ faces = [0, 2], finish = \"polished\", coating = 0, shape = { kind = \"fit\", tolerance_um = 1 } }] }",
            "2: { faces = [{ faces = [5], emitter = 0 }] }",
            "3: { faces = [{ faces = [5], emitter = 0 }] }",
        ]
    );
    let root = annotation.root.unwrap();
    let arrays: Vec<String> = ["version", "default", "media", "coatings", "emitters", "slides"]
        .iter()
        .filter_map(|key| root.get(key))
        .map(Value::to_string)
        .collect();
    assert_eq!(
        arrays,
        [
            "1",
            "{ finish = \"absorber\" }",
            "[{ name = \"oil\", ior = 1.4, priority = 2 }]",
            "[{ name = \"ar\", stack = [{ n = 1.38, thickness_nm = 99.638 }] }]",
            "[{ group = \"led\", flux_lm = 1 }]"
        ]
    );
}

#[test]
fn an_empty_sidecar_says_nothing() {
    let sidecar = toml::parse("schema = 1\nasset = \"a.glb\"\n", Path::new("a.optics.toml")).unwrap();
    assert!(annotate(&assembly(&["A"]), Some(&sidecar), Path::new(".")).unwrap().is_empty());
}

#[test]
fn images_are_named_from_the_new_folder() {
    let text = "schema = 1\n[sky]\nimage = \"env.exr\"\n[[bind]]\nname = \"A\"\nnormal = \"+z\"\n\
         slide = { image = \"sub/s.png\", size = [1, 1], u = [1, 0, 0], v = [0, 1, 0] }\n";
    let sidecar = toml::parse(text, Path::new("here/hud.optics.toml")).unwrap();
    let root = annotate(&assembly(&["A"]), Some(&sidecar), Path::new("there")).unwrap().root.unwrap();
    assert_eq!(root.get("sky").unwrap().get("image").unwrap().text(), Some("../here/env.exr"));
    let slide = &root.get("slides").unwrap().list().unwrap()[0];
    assert_eq!(slide.get("image").unwrap().text(), Some("../here/sub/s.png"));
}

/// Rows that an asset or a sidecar may say of whole parts, of faces, and of both.
const PART: [&str; 6] = [
    "ior = 1.25",
    "glass = \"N-BK7\"\nabsorption_per_m = 3",
    "medium = \"oil\"",
    "priority = 3",
    "medium = \"none\"",
    "absorption_per_m = 0.1",
];
const FACE: [&str; 10] = [
    "finish = \"polished\"",
    "finish = \"polished\"\ncoating = \"ar\"",
    "finish = { kind = \"lambert\", reflectance = 0.3 }",
    "finish = \"absorber\"\nemitter = { group = \"a\", flux_lm = 0.1 }",
    "emitter = { group = \"b\", luminance_cd_m2 = 12.5 }",
    "emitter = \"none\"",
    "shape = { kind = \"fit\", tolerance_um = 1 }",
    "shape = \"mesh\"",
    "finish = \"polished\"\ncoating = { stack = [{ n = 2.1, thickness_nm = 50.5 }] }",
    "finish = \"mirror\"\nfinish_ = 1",
];

fn row(part: bool, which: usize) -> &'static str {
    if part { PART[which % PART.len()] } else { FACE[which % (FACE.len() - 1)] }
}

fn table(text: &str) -> Value {
    toml::parse(text, Path::new("a.glb")).unwrap()
}

/// (kind of place, number of it, part or face, row, faces)
type Said = (u8, usize, bool, usize, usize);

/// Parts below parts, a mesh that two nodes share, rows of nodes, materials and faces.
fn random(rows: &[Said], nest: &[usize]) -> Assembly {
    let mut all = assembly(&["A", "B", "C", "D"]);
    for (index, above) in nest.iter().enumerate() {
        let index = index + 2;
        let parent = above % index;
        let frame = all.nodes[parent].to_world;
        let path = format!("{}/{}", all.nodes[parent].path, all.nodes[index].name);
        let node = &mut all.nodes[index];
        (node.parent, node.to_world, node.path) = (Some(parent), frame * node.local, path);
    }
    all.nodes[4].mesh = Some(0);
    // Fewer faces than the others.
    all.meshes[1].mesh.faces.truncate(3);
    all.meshes[1].materials.truncate(3);
    all.meshes[1].attributes.truncate(3);
    all.optics = Some(table(
        "version = 1\nmedia = [{ name = \"oil\", ior = 1.6 }]\ncoatings = [{ name = \"ar\", stack = [{ n = 1.5, thickness_nm = 90 }] }]",
    ));
    let add = |place: &mut Option<Value>, text: &str| {
        let text = text.replace("\"ar\"", "0").replace("\"oil\"", "0");
        *place = Some(table(&text));
    };
    for (kind, number, part, which, faces) in rows {
        let text = row(*part, *which);
        match kind % 4 {
            0 => {
                let node = &mut all.nodes[number % 5];
                let text = match (part, faces % 3) {
                    (true, _) | (false, 0) => text.to_owned(),
                    (false, 1) => format!("[[faces]]\nfaces = [{}]\n{text}", faces % 2),
                    (false, _) => format!("[[faces]]\nnormal = \"+z\"\n{text}"),
                };
                add(&mut node.attributes, &text);
            }
            1 => add(&mut all.materials[0].attributes, text),
            2 if !part => {
                let mesh = &mut all.meshes[number % 4];
                let face = faces % mesh.attributes.len();
                add(&mut mesh.attributes[face], text);
            }
            _ => {}
        }
    }
    all
}

fn binds(rows: &[Said], defines: bool) -> String {
    let mut text = BASE.to_owned();
    if defines {
        text += "[coating.ar]\nstack = [{ n = 1.38, thickness_nm = 99.638 }]\n[medium.oil]\nior = 1.4\npriority = 2\n";
    }
    for (kind, number, part, which, faces) in rows {
        let name = ["A", "B", "C", "D"][number % 4];
        let selector = match kind % 4 {
            0 => format!("name = \"{name}\""),
            1 => "path = \"**\"".to_owned(),
            2 => "material = \"GLASS\"".to_owned(),
            _ => format!("path = \"**/{name}\""),
        };
        let some = match (part, faces % 3) {
            (true, _) | (false, 0) => String::new(),
            (false, 1) => format!("faces = [{}]\n", faces % 3),
            (false, _) => "normal = \"+z\"\n".to_owned(),
        };
        text += &format!("[[bind]]\n{selector}\n{some}{}\n", row(*part, *which));
    }
    text
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, max_global_rejects: 200_000, ..ProptestConfig::default() })]
    #[test]
    fn random_assets_and_sidecars(
        carried in proptest::collection::vec(any::<Said>(), 0..6),
        bound in proptest::collection::vec(any::<Said>(), 0..6),
        nest in proptest::collection::vec(any::<usize>(), 3),
        defines in any::<bool>(),
    ) {
        let asset = random(&carried, &nest);
        let sidecar = toml::parse(&binds(&bound, defines), Path::new("a.optics.toml")).unwrap();
        // The hash wants files that are there.
        let Ok(together) = build(asset.clone(), Some(&sidecar), &[]) else { return Err(TestCaseError::reject("a fault")) };
        let alone = alone(&asset, &sidecar, Path::new("."));
        prop_assert_eq!(said(&build(alone, None, &[]).unwrap().scene), said(&together.scene));
    }
}
