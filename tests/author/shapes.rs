//! A sphere of USD is a sphere again, and so is every other shape without points: with its size, its axis, its colour and its material.

use super::cameras::convert;
use eyebox::import;

const STAGE: &str = r#"#usda 1.0
(
    defaultPrim = "w"
    metersPerUnit = 0.01
    upAxis = "Z"
)
def Xform "w"
{
    def Sphere "ball" (prepend apiSchemas = ["MaterialBindingAPI"])
    {
        double radius = 50
        rel material:binding = </w/m>
    }
    def Sphere "egg"
    {
        double radius = 2
        double3 xformOp:scale = (1, 2, 1)
        uniform token[] xformOpOrder = ["xformOp:scale"]
    }
    def Cube "box" { double size = 3 }
    def Cylinder "can" { double radius = 0.5
        double height = 4
        uniform token axis = "X"
        color3f[] primvars:displayColor = [(0.25, 0.5, 1)] }
    def Cone "hat" { double radius = 0.75
        double height = 1.5
        uniform token axis = "Y" }
    def Capsule "pill" { double radius = 0.25
        double height = 1.25 }
    def Plane "floor" { double width = 10
        double length = 20 }
    def Material "m"
    {
        token outputs:surface.connect = </w/m/s.outputs:surface>
        def Shader "s" { uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor = (0.25, 0.5, 0.75)
            token outputs:surface }
    }
}
"#;

#[test]
fn shapes_stay_shapes() {
    let place = tempfile::tempdir().unwrap();
    std::fs::write(place.path().join("in.usda"), STAGE).unwrap();
    let out = convert(place.path(), "in.usda", "out.usda");
    assert!(!out.contains("def Mesh"), "{out}");
    for line in [
        "def Sphere \"ball\"",
        "double radius = 50",
        "def Sphere \"egg\"",
        "def Cube \"box\"",
        "double size = 3",
        "def Cylinder \"can\"",
        "uniform token axis = \"X\"",
        "def Cone \"hat\"",
        "def Capsule \"pill\"",
        "def Plane \"floor\"",
        "double length = 20",
    ] {
        assert!(out.contains(line), "no {line} in\n{out}");
    }
    // Light meets the same as before, exact surfaces included.
    let [before, after] = ["in.usda", "out.usda"].map(|name| import::asset(&place.path().join(name)).unwrap());
    let parts = |all: &import::Assembly| -> Vec<_> {
        let of = |node: &import::assembly::Node| {
            let source = all.meshes.get(node.mesh?)?;
            let mesh = eyebox::scene::Mesh { name: String::new(), ..eyebox::scene::Mesh::clone(&source.mesh) };
            let shapes: Vec<bool> = source.attributes.iter().map(Option::is_some).collect();
            let material = source.materials.first().copied().flatten();
            Some((node.path.clone(), node.to_world, mesh, shapes, material.map(|index| all.materials[index].name.clone())))
        };
        all.nodes.iter().filter_map(of).collect()
    };
    assert_eq!(parts(&before).len(), 7);
    assert_eq!(parts(&before), parts(&after));
}

/// What a sidecar says of a sphere's face has its place on a mesh alone.
#[test]
fn a_sphere_of_which_more_is_said_is_a_mesh() {
    let place = tempfile::tempdir().unwrap();
    std::fs::write(place.path().join("in.usda"), STAGE).unwrap();
    let sheet = "schema = 1\nasset = \"in.usda\"\n[[bind]]\npath = \"w/ball\"\nfaces = [0]\nfinish = \"absorber\"\n";
    std::fs::write(place.path().join("in.optics.toml"), sheet).unwrap();
    let out = convert(place.path(), "in.optics.toml", "out.usda");
    assert!(out.contains("absorber"), "{out}");
    assert!(out.contains("def Sphere \"egg\""), "{out}");
}
