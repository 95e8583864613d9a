//! Every composition arc, instances and instancers.

use super::kit::{Folder, SQUARE, assembly, notes, paths};
use glam::DVec3;

fn part() -> String {
    format!(
        "(\n    defaultPrim = \"P\"\n    metersPerUnit = 0.01\n)\ndef Xform \"P\" {{\n    def Mesh \"Body\" {{ {SQUARE} }}\n}}\n"
    )
}

#[test]
fn arcs_meet_in_one_tree() {
    let root = r#"(
    subLayers = [@./sub/layer.usda@]
    metersPerUnit = 0.001
)
class Xform "_C" { def Xform "inherited" { } }
def Xform "A" (
    inherits = </_C>
    prepend references = @./part.usda@
    variants = { string shape = "b" }
    prepend variantSets = "shape"
) {
    variantSet "shape" = {
        "a" { def Xform "va" { } }
        "b" { def Xform "vb" { } }
    }
}
def Xform "B" ( prepend payload = @sub/../part.usda@</P> ) { }
def Xform "S" ( specializes = </_C> ) { }
def Xform "lost" ( prepend references = @./nowhere.usda@ ) { }
def Xform "round" ( prepend references = </round2> ) { }
def Xform "round2" ( prepend references = </round> ) { }
"#;
    let part = part();
    let folder = Folder::new(&[
        ("a.usda", root),
        ("part.usda", &part),
        ("sub/layer.usda", "def Xform \"L\" { }\nover \"A\" { def Xform \"from_sub\" { } }\n"),
    ]);
    let found = folder.read(None).unwrap();
    let mut all = paths(&found);
    all.sort_unstable();
    let want = [
        "A",
        "A/Body",
        "A/from_sub",
        "A/inherited",
        "A/vb",
        "B",
        "B/Body",
        "L",
        "S",
        "S/inherited",
        "lost",
        "round",
        "round2",
    ];
    assert_eq!(all, want);
    // Two references to the same geometry share it.
    assert_eq!(found.meshes.len(), 1);
    let said = notes(&found);
    assert!(said.contains("nowhere.usda") && said.contains("cycle"), "{said}");
    assert!(said.contains("part.usda is in units of 0.01 m, the root layer in 0.001 m"), "{said}");
    let names: Vec<_> = found.dependencies.iter().map(|path| path.file_name().unwrap().to_str().unwrap()).collect();
    assert_eq!(names[0], "a.usda");
    assert!(names.contains(&"part.usda") && names.contains(&"layer.usda") && names.len() == 3, "{names:?}");
}

#[test]
fn instances_share_their_meshes() {
    let mut root = String::from(
        "def Xform \"R\" {\n    double3 xformOp:translate = (1, 0, 0)\n    uniform token[] xformOpOrder = [\"xformOp:translate\"]\n",
    );
    for i in 0..300 {
        root += &format!(
            "    def Xform \"I{i}\" (\n        instanceable = true\n        prepend references = @./part.usda@\n    ) {{\n        double3 xformOp:translate = (0, {i}, 0)\n        uniform token[] xformOpOrder = [\"xformOp:translate\"]\n    }}\n"
        );
    }
    root += "}\n";
    let part = part();
    let found = Folder::new(&[("a.usda", &root), ("part.usda", &part)]).read(None).unwrap();
    assert_eq!((found.meshes.len(), found.nodes.len()), (1, 601));
    let last = found.nodes.iter().find(|node| node.path == "R/I299/Body").unwrap();
    assert_eq!(last.mesh, Some(0));
    assert_eq!(last.to_world.translation, DVec3::new(1.0, 299.0, 0.0));
    assert!(last.at.to_string().ends_with("a.usda</R/I299/Body>"), "{}", last.at);
    for node in &found.nodes[1..] {
        let above = &found.nodes[node.parent.unwrap()];
        assert_eq!(node.to_world, above.to_world * node.local);
    }
}

#[test]
fn instancers() {
    let found = assembly(&format!(
        r#"def PointInstancer "Pts" (
    inactiveIds = [13]
) {{
    double3 xformOp:translate = (100, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    rel prototypes = [</Pts/Protos/Q>, </Pts/Protos/S>]
    int[] protoIndices = [0, 1, 0, 1, 0]
    int64[] ids = [10, 11, 12, 13, 14]
    int64[] invisibleIds = [12]
    point3f[] positions = [(0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0), (4, 0, 0)]
    quath[] orientations = [(1, 0, 0, 0), (1, 0, 0, 0), (1, 0, 0, 0), (1, 0, 0, 0), (0, 0, 0, 1)]
    float3[] scales = [(1, 1, 1), (2, 2, 2), (1, 1, 1), (1, 1, 1), (3, 3, 3)]
    over "Protos" {{
        def Mesh "Q" {{
            double3 xformOp:translate = (0, 1, 0)
            uniform token[] xformOpOrder = ["xformOp:translate"]
            {SQUARE}
        }}
        def Sphere "S" {{ }}
    }}
}}"#
    ));
    let want = ["Pts", "Pts[0]", "Pts[0]/Q", "Pts[1]", "Pts[1]/S", "Pts[4]", "Pts[4]/Q"];
    assert_eq!(paths(&found), want);
    assert_eq!(found.meshes.len(), 2);
    // Turned by half a turn about z and scaled by 3: (0, 1) → (0, −3).
    let place = found.nodes[6].to_world.translation;
    assert!((place - DVec3::new(104.0, -3.0, 0.0)).length() < 1e-12, "{place}");
}

/// Where a prototype stands says its material, not the instancer (as UsdShadeMaterialBindingAPI computes it).
#[test]
fn prototypes_have_the_materials_of_their_place() {
    let found = assembly(&format!(
        r#"def Material "Out" {{ }}
def Material "In" {{ }}
def Xform "Away" {{
    rel material:binding = </Out>
    def Mesh "Far" {{ {SQUARE} }}
}}
def PointInstancer "Pts" {{
    rel material:binding = </In>
    rel prototypes = [</Pts/Protos/Near>, </Away/Far>, </Plain>]
    int[] protoIndices = [0, 1, 2]
    point3f[] positions = [(0, 0, 0), (1, 0, 0), (2, 0, 0)]
    def "Protos" {{
        rel material:binding = </Out>
        def Mesh "Near" {{ {SQUARE} }}
    }}
}}
def Mesh "Plain" {{ {SQUARE} }}"#
    ));
    let material = |path: &str| {
        let node = found.nodes.iter().find(|node| node.path == path).unwrap();
        found.meshes[node.mesh.unwrap()].materials[0].map(|index| found.materials[index].name.as_str())
    };
    assert_eq!(material("Pts[0]/Near"), Some("Out"));
    assert_eq!(material("Pts[1]/Far"), Some("Out"));
    assert_eq!(material("Pts[2]/Plain"), None);
}

/// A layer in metres, y up, below one in millimetres, z up.
#[test]
fn a_reference_that_scales_and_turns_puts_units_right() {
    let said = |ops: &str| {
        let root = format!(
            "(\n metersPerUnit = 0.001\n upAxis = \"Z\"\n)\ndef Xform \"A\" ( prepend references = @./b.usda@ ) {{\n{ops}\n}}\n"
        );
        let part = "(\n defaultPrim = \"P\"\n metersPerUnit = 1\n upAxis = \"Y\"\n)\ndef Xform \"P\" { }\n";
        notes(&Folder::new(&[("a.usda", &root), ("b.usda", part)]).read(None).unwrap())
    };
    let scale = |by: &str| format!("float3 xformOp:scale = ({by}, {by}, {by})\n");
    let order = "uniform token[] xformOpOrder = [\"xformOp:rotateX\", \"xformOp:scale\"]\n";
    let turn = "float xformOp:rotateX = 90\n";
    let right = said(&format!("{}{turn}{order}", scale("1000")));
    assert!(!right.contains("USD does not"), "{right}");
    let scaled_wrong = said(&format!("{}{turn}{order}", scale("100")));
    assert!(scaled_wrong.contains("USD does not rescale") && !scaled_wrong.contains("turn it"), "{scaled_wrong}");
    let nothing = said("");
    assert!(nothing.contains("USD does not rescale") && nothing.contains("USD does not turn it"), "{nothing}");
}

/// A prim whose variants come from the file that it refers to, one of which has variants of its own.
#[test]
fn variants_are_chosen() {
    let root = "def Xform \"A\" (\n prepend references = @./b.usda@\n variants = { string paint = \"red\" }\n) { }\n";
    let part = "(\n defaultPrim = \"P\"\n)\ndef Xform \"P\" (\n prepend variantSets = [\"paint\", \"size\"]\n variants = { string size = \"small\" }\n) {\n\
         variantSet \"paint\" = { \"red\" { def Xform \"Red\" { } } \"blue\" { def Xform \"Blue\" (\n prepend variantSets = \"tone\"\n) {\n\
         variantSet \"tone\" = { \"light\" { def Xform \"Light\" { } } \"dark\" { def Xform \"Dark\" { } } }\n } } }\n\
         variantSet \"size\" = { \"small\" { def Xform \"Small\" { } } \"large\" { def Xform \"Large\" { } } }\n}\n";
    let folder = Folder::new(&[("a.usda", root), ("b.usda", part)]);
    let read = |choices: &[&str]| {
        let variants = choices.iter().map(|text| crate::VariantChoice::parse(text).unwrap()).collect();
        folder.read_with(&crate::ReadOptions { variants, ..Default::default() })
    };
    let found = |choices: &[&str]| {
        let found = read(choices).unwrap();
        let mut paths = paths(&found);
        paths.sort_unstable();
        paths.join(" ")
    };
    assert_eq!(found(&[]), "A A/Red A/Small");
    assert_eq!(found(&["/A{size=large}"]), "A A/Large A/Red");
    assert_eq!(found(&["A{paint=blue}", "A/Blue{tone=dark}"]), "A A/Blue A/Blue/Dark A/Small");
    let fault = |choice: &str| read(&[choice]).unwrap_err();
    assert_eq!(
        fault("/A{paint=bleu}"),
        "--variant /A{paint=bleu}: the variant set paint of /A has no `bleu`; expected one of blue, red; did you mean `blue`?"
    );
    assert_eq!(
        fault("/A{pain=red}"),
        "--variant /A{pain=red}: /A has no variant set `pain`; expected one of paint (blue, red), size (large, small); did you \
         mean `paint`?"
    );
    for host in ["/A/Small", "/Nobody"] {
        let fault = fault(&format!("{host}{{size=large}}"));
        assert!(fault.contains("is no prim with variants"), "{fault}");
    }
}
