//! Polygons, faces, primvars, implicit shapes.

use super::kit::{SQUARE, assembly, fault, notes, paths};
use crate::Assembly;
use eyebox_base::Where;
use eyebox_scene::FaceRange;
use glam::DVec3;

fn mesh(contents: &str) -> Assembly {
    assembly(&format!("def Mesh \"M\" {{\n{contents}\n}}\n"))
}

#[test]
fn a_square_without_normals_is_flat() {
    let found = mesh(SQUARE);
    let mesh = &found.meshes[0].mesh;
    assert_eq!(mesh.triangles, [[0, 1, 2], [3, 4, 5]]);
    assert!(mesh.normals.iter().all(|&normal| normal == [0.0, 0.0, 1.0]));
    assert_eq!(found.nodes[0].at, Where::Prim { file: found.file.clone(), prim: "/M".to_owned() });
}

#[test]
fn left_handed_polygons_are_turned_round() {
    let found = mesh(&format!("{SQUARE}\n    uniform token orientation = \"leftHanded\""));
    assert!(found.meshes[0].mesh.normals.iter().all(|&normal| normal == [0.0, 0.0, -1.0]));
}

#[test]
fn vertex_normals_keep_the_points_one_to_one() {
    let found = mesh(&format!(
        "{SQUARE}\n    normal3f[] normals = [(0, 0, 1), (0, 0.6, 0.8), (0, 0, 1), (0, 0, 1)] (interpolation = \"vertex\")\n    texCoord2f[] primvars:map = [(0, 0), (1, 0), (1, 1), (0, 1)] (interpolation = \"varying\")"
    ));
    let mesh = &found.meshes[0].mesh;
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(mesh.positions[2], [1.0, 1.0, 0.0]);
    assert_eq!((mesh.normals[1], mesh.uvs[2]), ([0.0, 0.6, 0.8], [1.0, 1.0]));
}

#[test]
fn corners_that_differ_are_split_and_no_others() {
    let found = mesh(
        r#"
    uniform token subdivisionScheme = "none"
    int[] faceVertexCounts = [3, 3]
    int[] faceVertexIndices = [0, 1, 2, 2, 1, 3]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)]
    normal3f[] primvars:normals = [(0, 0, 1), (0, 0.28, 0.96)] (interpolation = "faceVarying")
    int[] primvars:normals:indices = [0, 0, 0, 0, 1, 0]
"#,
    );
    let mesh = &found.meshes[0].mesh;
    assert_eq!(mesh.triangles, [[0, 1, 2], [2, 3, 4]]);
    assert_eq!(mesh.positions[3], [1.0, 0.0, 0.0]);
}

#[test]
fn subsets_are_faces_and_the_rest_is_the_last() {
    let found = mesh(
        r#"
    uniform token subdivisionScheme = "none"
    int[] faceVertexCounts = [3, 3, 3]
    int[] faceVertexIndices = [0, 1, 2, 0, 2, 3, 0, 3, 4]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (-1, 1, 0)]
    def GeomSubset "F1" { uniform token elementType = "face"
        uniform token familyName = "cadFace"
        int[] indices = [2] }
    def GeomSubset "F0" { uniform token elementType = "face"
        uniform token familyName = "cadFace"
        int[] indices = [0, 2] }
    def GeomSubset "mat" { uniform token elementType = "face"
        uniform token familyName = "other"
        int[] indices = [1] }
"#,
    );
    let mesh = &found.meshes[0].mesh;
    let ranges: Vec<FaceRange> = (0..3).map(|first| FaceRange { first, count: 1 }).collect();
    assert_eq!(mesh.faces, ranges);
    let first = mesh.triangles[0].map(|i| mesh.positions[i as usize]);
    assert_eq!(first[2], [-1.0, 1.0, 0.0]);
    let said = notes(&found);
    assert!(
        said.contains("earlier subset") && said.contains("outside all subsets") && said.contains("`other`"),
        "{said}"
    );
}

#[test]
fn concave_polygons_and_holes() {
    // A C-shaped octagon of area 5, wound so that a fan about corner 0 would fold back; a hole is left out.
    let found = mesh(
        r#"
    uniform token subdivisionScheme = "none"
    int[] faceVertexCounts = [8, 3]
    int[] faceVertexIndices = [0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2]
    int[] holeIndices = [1]
    point3f[] points = [(1, 1, 0), (3, 1, 0), (3, 0, 0), (0, 0, 0), (0, 3, 0), (3, 3, 0), (3, 2, 0), (1, 2, 0)]
"#,
    );
    let mesh = &found.meshes[0].mesh;
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| DVec3::from(mesh.positions[i as usize].map(f64::from)));
        (b - a).cross(c - a).z / 2.0
    };
    assert_eq!(mesh.triangles.len(), 6);
    // The outline runs clockwise.
    assert!(mesh.triangles.iter().all(|t| area(t) < 0.0));
    assert!((mesh.triangles.iter().map(area).sum::<f64>() + 7.0).abs() < 1e-12);
}

#[test]
fn subdivision_is_said() {
    let found = mesh(&SQUARE.replace("uniform token subdivisionScheme = \"none\"", ""));
    assert!(notes(&found).contains("catmullClark subdivision surface (USD's fallback"), "{}", notes(&found));
}

#[test]
fn implicit_shapes_have_their_areas_and_spheres_are_exact() {
    let found = assembly(
        r#"
def Sphere "S" { double radius = 3 }
def Cube "C" { double size = 4 }
def Cylinder "Y" { double radius = 2
    double height = 5
    uniform token axis = "X" }
def Cone "O" { double radius = 3
    double height = 4 }
def Capsule "K" { double radius = 1
    double height = 3 }
def Plane "P" { double width = 3
    double length = 5
    uniform token axis = "Y" }
"#,
    );
    let pi = std::f64::consts::PI;
    let want = [4.0 * pi * 9.0, 96.0, 2.0 * pi * 4.0 + 20.0 * pi, 9.0 * pi + 15.0 * pi, 4.0 * pi + 6.0 * pi, 15.0];
    let tolerance = [2e-3, 1e-6, 1e-3, 1e-3, 2e-3, 1e-6];
    for ((source, want), tolerance) in found.meshes.iter().zip(want).zip(tolerance) {
        let mesh = &source.mesh;
        let mut area = 0.0;
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|i| DVec3::from(mesh.positions[i as usize].map(f64::from)));
            let normal = (b - a).cross(c - a);
            area += 0.5 * normal.length();
            for i in *t {
                let given = DVec3::from(mesh.normals[i as usize].map(f64::from));
                assert!((given.length() - 1.0).abs() < 1e-6 && normal.normalize().dot(given) > 0.99, "{}", mesh.name);
            }
        }
        assert!((area / want - 1.0).abs() < tolerance, "{}: {area} is not {want}", mesh.name);
    }
    let shape = found.meshes[0].attributes[0].as_ref().and_then(|face| face.get("shape")).unwrap();
    assert_eq!(shape.get("radius").and_then(|x| x.number()), Some(3.0));
    let [plane_low, plane_high] = [0, 1].map(|end| {
        let all = found.meshes[5].mesh.positions.iter();
        let fold =
            |a: [f32; 3], b: &[f32; 3]| [0, 1, 2].map(|i| if end == 0 { a[i].min(b[i]) } else { a[i].max(b[i]) });
        all.fold(if end == 0 { [f32::MAX; 3] } else { [f32::MIN; 3] }, fold)
    });
    assert_eq!((plane_low, plane_high), ([-1.5, 0.0, -2.5], [1.5, 0.0, 2.5]));
    assert_eq!(found.meshes[5].mesh.normals[0], [0.0, 1.0, 0.0]);
}

#[test]
fn an_ellipsoid_is_no_sphere() {
    let found = assembly(
        "def Sphere \"S\" {\n    float3 xformOp:scale = (1, 2, 1)\n    uniform token[] xformOpOrder = [\"xformOp:scale\"]\n}",
    );
    let mesh = found.nodes[0].mesh.unwrap();
    assert!(found.meshes[mesh].attributes[0].is_none() && notes(&found).contains("scaled unevenly"));
}

#[test]
fn what_is_not_there_for_the_eye() {
    let body = format!(
        r#"
def Xform "A" {{
    def Mesh "guide" {{ uniform token purpose = "guide" {SQUARE} }}
    def Mesh "proxy" {{ uniform token purpose = "proxy" {SQUARE} }}
    def Mesh "render" {{ uniform token purpose = "render" {SQUARE} }}
    def Mesh "hidden" {{ token visibility = "invisible" {SQUARE} }}
    def Mesh "off" ( active = false ) {{ {SQUARE} }}
    over Mesh "over" {{ {SQUARE} }}
    def Scope "empty" {{ }}
    def BasisCurves "curves" {{ }}
}}
class Mesh "class" {{ {SQUARE} }}
"#
    );
    let found = assembly(&body);
    assert_eq!(paths(&found), ["A", "A/render", "A/curves"]);
    assert!(notes(&found).contains("BasisCurves is not used"));
}

#[test]
fn broken_meshes_are_faults_with_their_prim() {
    for (change, to, want) in [
        ("[4]", "[5]", "</M.faceVertexIndices>: the polygons have 5 corners, but there are 4 indices"),
        ("1, 2, 3]", "1, 2, 4]", "index 4 is no point; expected 0 to 3"),
        ("(1, 1, 0)", "(1, nan, 0)", "point 2 is at (1, NaN, 0)"),
        ("[4]", "[-4]", "polygon 0 has -4 corners"),
    ] {
        let text = fault(&format!("def Mesh \"M\" {{\n{}\n}}\n", SQUARE.replace(change, to)));
        assert!(text.contains(want), "{text}");
    }
}
