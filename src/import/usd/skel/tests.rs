//! UsdSkel against closed forms: the bar of the glTF tests, blend shapes as linear combinations.

use super::super::tests::kit::{Folder, notes};
use crate::Assembly;
use glam::DVec3;

/// The bar: a joint at its foot and one at (0, 1, 0) that turns from 0 to 90° about z between 0 and 10. `mesh` and `root`
/// are further properties.
fn bar(root: &str, mesh: &str) -> String {
    format!(
        r#"
def SkelRoot "Root" (prepend apiSchemas = ["SkelBindingAPI"]) {{
    rel skel:skeleton = </Root/Rig>
    {root}
    def Skeleton "Rig" (prepend apiSchemas = ["SkelBindingAPI"]) {{
        uniform token[] joints = ["foot", "foot/upper"]
        uniform matrix4d[] bindTransforms = [
            ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)),
            ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 1, 0, 1))]
        uniform matrix4d[] restTransforms = [
            ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)),
            ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 1, 0, 1))]
        rel skel:animationSource = </Root/Rig/Turn>
        def SkelAnimation "Turn" {{
            uniform token[] joints = ["foot/upper"]
            float3[] translations = [(0, 1, 0)]
            quatf[] rotations.timeSamples = {{
                0: [(1, 0, 0, 0)], 10: [(0.70710678, 0, 0, 0.70710678)], }}
            half3[] scales = [(1, 1, 1)]
            uniform token[] blendShapes = ["out", "up"]
            float[] blendShapeWeights.timeSamples = {{ 0: [0, 0], 10: [0, 1] }}
        }}
    }}
    def Xform "Group" {{
        double3 xformOp:translate = (7, 8, 9)
        uniform token[] xformOpOrder = ["xformOp:translate"]
        def Mesh "Bar" (prepend apiSchemas = ["SkelBindingAPI"]) {{
            uniform token subdivisionScheme = "none"
            int[] faceVertexCounts = [4, 4]
            int[] faceVertexIndices = [0, 1, 3, 2, 2, 3, 5, 4]
            point3f[] points = [(-0.1, 0, 0), (0.1, 0, 0), (-0.1, 1, 0), (0.1, 1, 0), (-0.1, 2, 0), (0.1, 2, 0)]
            normal3f[] normals = [(0, 0, 1), (0, 0, 1), (0, 0, 1), (0, 0, 1), (0, 0, 1), (0, 0, 1)]
            {mesh}
        }}
    }}
}}
"#
    )
}

const INFLUENCES: &str = r#"
            int[] primvars:skel:jointIndices = [0, 0, 0, 0, 0, 1, 0, 1, 1, 0, 1, 0] (
                elementSize = 2
                interpolation = "vertex")
            float[] primvars:skel:jointWeights = [1, 0, 1, 0, 0.5, 0.5, 0.5, 0.5, 1, 0, 1, 0] (
                elementSize = 2
                interpolation = "vertex")
"#;

fn read(body: &str, frame: f64) -> Assembly {
    Folder::new(&[("a.usda", body)]).read(Some(frame)).unwrap()
}

fn fault(body: &str) -> String {
    Folder::new(&[("a.usda", body)]).read(Some(10.0)).unwrap_err()
}

/// The points of the bar in the world.
fn points(assembly: &Assembly) -> Vec<DVec3> {
    let node = assembly.nodes.iter().find(|node| node.name == "Bar").unwrap();
    let mesh = &assembly.meshes[node.mesh.unwrap()].mesh;
    mesh.positions.iter().map(|p| node.to_world.transform_point3(DVec3::from(p.map(f64::from)))).collect()
}

fn is(found: &[DVec3], want: &[[f64; 2]]) -> bool {
    found.len() == want.len()
        && found.iter().zip(want).all(|(found, [x, y])| (*found - DVec3::new(*x, *y, 0.0)).length() < 2e-6)
}

/// The tip turns about (0, 1, 0), the middle is the mean of turned and unturned.
const BENT: [[f64; 2]; 6] = [[-0.1, 0.], [0.1, 0.], [-0.05, 0.95], [0.05, 1.05], [-1., 0.9], [-1., 1.1]];
const STRAIGHT: [[f64; 2]; 6] = [[-0.1, 0.], [0.1, 0.], [-0.1, 1.], [0.1, 1.], [-0.1, 2.], [0.1, 2.]];

#[test]
fn a_bar_bends_by_its_joints_and_not_by_its_own_transform() {
    let stage = bar("", INFLUENCES);
    assert!(is(&points(&read(&stage, 10.0)), &BENT), "{:?}", points(&read(&stage, 10.0)));
    assert!(is(&points(&read(&stage, 0.0)), &STRAIGHT));
    // Halfway, by 45°.
    let tip = points(&read(&stage, 5.0))[4];
    let (sine, cosine) = 45f64.to_radians().sin_cos();
    let want = DVec3::new(-0.1 * cosine - sine, 1.0 - 0.1 * sine + cosine, 0.0);
    assert!((tip - want).length() < 2e-6, "{tip}");
    let normals = &read(&stage, 10.0).meshes[0].mesh.normals;
    assert!(normals.iter().all(|normal| *normal == [0., 0., 1.]));
    // Without the root nothing bends, and that is said.
    let loose = stage.replace("SkelRoot", "Xform");
    let found = read(&loose, 10.0);
    assert!((points(&found)[4] - DVec3::new(6.9, 10., 9.)).length() < 2e-6);
    assert!(notes(&found).contains("without a SkelRoot above"));
}

#[test]
fn bindings_are_inherited_and_counted_anew() {
    // Joints by names of the mesh's own, all influences said by the root.
    let names = "uniform token[] skel:joints = [\"foot/upper\", \"foot\"]";
    let turned = INFLUENCES.replace("[0, 0, 0, 0, 0, 1, 0, 1, 1, 0, 1, 0]", "[1, 1, 1, 1, 1, 0, 1, 0, 0, 1, 0, 1]");
    assert!(is(&points(&read(&bar(&turned, names), 10.0)), &BENT));
    // One joint for all points: rigid; bound one unit lower.
    let rigid = r#"
            int[] primvars:skel:jointIndices = [1] (interpolation = "constant")
            float[] primvars:skel:jointWeights = [1] (interpolation = "constant")
            matrix4d primvars:skel:geomBindTransform = ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 1, 0, 1))
            uniform token primvars:skel:skinningMethod = "dualQuaternion"
"#;
    let found = read(&bar("", rigid), 10.0);
    assert!(is(&points(&found), &[[0., 0.9], [0., 1.1], [-1., 0.9], [-1., 1.1], [-2., 0.9], [-2., 1.1]]));
    assert!(notes(&found).contains("points are blended linearly"));
}

#[test]
fn shapes_without_points_move_as_a_whole() {
    let mesh = bar("", INFLUENCES);
    let start = mesh.find("        def Mesh").unwrap();
    let ball = r#"
        def Sphere "Ball" (prepend apiSchemas = ["SkelBindingAPI"]) {
            double radius = 0.5
            int[] primvars:skel:jointIndices = [1] (interpolation = "constant")
            float[] primvars:skel:jointWeights = [1] (interpolation = "constant")
            matrix4d primvars:skel:geomBindTransform = ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 3, 0, 1))
        }
    }
}
"#;
    let found = read(&format!("{}{ball}", &mesh[..start]), 10.0);
    let node = found.nodes.iter().find(|node| node.name == "Ball").unwrap();
    assert!((node.to_world.translation - DVec3::new(-2., 1., 0.)).length() < 2e-6, "{}", node.to_world);
}

#[test]
fn blend_shapes_are_linear_combinations_with_steps_between() {
    let shapes = r#"
            uniform token[] skel:blendShapes = ["up"]
            rel skel:blendShapeTargets = </Root/Group/Bar/Up>
            def BlendShape "Up" {
                uniform vector3f[] offsets = [(0, 4, 0), (0, 0, 1)]
                uniform vector3f[] normalOffsets = [(1, 0, 0), (0, 0, 0)]
                uniform int[] pointIndices = [5, 0]
                uniform vector3f[] inbetweens:half = [(0, 8, 0), (0, 0, 0)] ( weight = 0.5 )
            }
"#;
    let stage = bar("", shapes);
    let at = |frame: f64| points(&read(&stage, frame))[5] - DVec3::new(7.1, 10., 9.);
    for (frame, y) in [(0.0, 0.0), (2.5, 4.0), (5.0, 8.0), (7.5, 6.0), (10.0, 4.0)] {
        assert!((at(frame) - DVec3::new(0., y, 0.)).length() < 2e-6, "{frame} {}", at(frame));
    }
    let normal = read(&stage, 10.0).meshes[0].mesh.normals[5];
    assert!((normal[0] - 0.5f32.sqrt()).abs() < 1e-6, "{normal:?}");
    // Beyond the full shape the line goes on: 4 − 0.5 · 8.
    let more = stage.replace("10: [0, 1]", "10: [0, 1.5]");
    assert!((points(&read(&more, 10.0))[5].y - 10.0).abs() < 2e-6);
}

#[test]
fn skeletons_that_are_wrong_say_where() {
    let found = fault(&bar("", &INFLUENCES.replace("0, 1, 1, 0, 1, 0]", "0, 1, 7, 0, 1, 0]")));
    assert!(
        found.contains("/Root/Group/Bar.primvars:skel:jointIndices") && found.contains("point 4 names joint 7"),
        "{found}"
    );
    let found = fault(&bar("", &INFLUENCES.replace("0.5, 0.5, 1, 0, 1, 0]", "0.5, 0.5, -1, 0, 1, 0]")));
    assert!(found.contains("point 4 has a weight of -1"), "{found}");
    let found = fault(&bar("", INFLUENCES).replace("[\"foot\", \"foot/upper\"]", "[\"foot\"]"));
    assert!(found.contains("2 matrices for 1 joints"), "{found}");
    let found = fault(&bar("", INFLUENCES).replace(
        "((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)),",
        "((0, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)),",
    ));
    assert!(found.contains("the joint `foot` cannot be moved"), "{found}");
    let said = |body: &str| notes(&read(body, 10.0));
    assert!(
        said(&bar("", &INFLUENCES.replacen("elementSize = 2", "elementSize = 3", 1))).contains("the mesh is not bent")
    );
    let names = format!("{INFLUENCES}\nuniform token[] skel:joints = [\"foot\", \"foot/uper\"]");
    assert!(said(&bar("", &names)).contains("did you mean `foot/upper`?"));
    let few = bar("", INFLUENCES).replace("translations = [(0, 1, 0)]", "translations = []");
    assert!(said(&few).contains("0 translations for 1 joints"));
    let lost = bar("", INFLUENCES).replace("skel:skeleton = </Root/Rig>", "skel:skeleton = </Root/Rug>");
    assert!(said(&lost).contains("</Root/Rug> does not exist"));
}
