//! Texture coordinates and colours of vertices, by the names of primvars.

use super::kit::{assembly, notes};
use crate::Assembly;
use eyebox_scene::Mesh;

fn only_mesh(found: &Assembly) -> &Mesh {
    assert_eq!(found.meshes.len(), 1, "{}", notes(found));
    &found.meshes[0].mesh
}

/// Two triangles over four points, with normals of points.
fn triangles(rest: &str) -> String {
    format!(
        r#"def Mesh "T" {{
    uniform token subdivisionScheme = "none"
    int[] faceVertexCounts = [3, 3]
    int[] faceVertexIndices = [0, 1, 2, 0, 2, 3]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    normal3f[] normals = [(0, 0, 1), (0, 0, 1), (0, 0, 1), (0, 0, 1)]
    {rest}
}}
"#
    )
}

/// What each corner of the triangles has.
fn corners<T: Copy>(mesh: &Mesh, all: &[T]) -> Vec<T> {
    mesh.triangles.as_flattened().iter().map(|&vertex| all[vertex as usize]).collect()
}

#[test]
fn display_colours_vary_in_every_way() {
    const RED: [f32; 4] = [1.0, 0.0, 0.0, 1.0];
    const BLUE: [f32; 4] = [0.0, 0.0, 1.0, 1.0];
    for (said, want) in [
        ("color3f[] primvars:displayColor = [(1, 0, 0)]", [RED; 6]),
        ("color3f primvars:displayColor = (1, 0, 0)", [RED; 6]),
        (
            "color3f[] primvars:displayColor = [(1, 0, 0), (0, 0, 1)] (interpolation = \"uniform\")",
            [RED, RED, RED, BLUE, BLUE, BLUE],
        ),
        (
            "color3f[] primvars:displayColor = [(1, 0, 0), (1, 0, 0), (0, 0, 1), (1, 0, 0)] (interpolation = \"vertex\")",
            [RED, RED, BLUE, RED, BLUE, RED],
        ),
        (
            "color3f[] primvars:displayColor = [(1, 0, 0), (1, 0, 0), (0, 0, 1), (1, 0, 0)] (interpolation = \"varying\")",
            [RED, RED, BLUE, RED, BLUE, RED],
        ),
        (
            "color3f[] primvars:displayColor = [(0, 0, 1), (1, 0, 0)] (interpolation = \"faceVarying\")\nint[] primvars:displayColor:indices = [0, 1, 1, 1, 0, 0]",
            [BLUE, RED, RED, RED, BLUE, BLUE],
        ),
    ] {
        let found = assembly(&triangles(said));
        let mesh = only_mesh(&found);
        assert_eq!(corners(mesh, &mesh.colors), want, "{said}\n{}", notes(&found));
        assert_eq!(found.meshes[0].materials, [None]);
    }
}

#[test]
fn opacities_go_with_colours_and_alone() {
    let opacity = "float[] primvars:displayOpacity = [0.25, 0.5] (interpolation = \"uniform\")\n";
    let found = assembly(&triangles(&format!("{opacity}color3f[] primvars:displayColor = [(1, 2, 0)]")));
    let mesh = only_mesh(&found);
    assert_eq!(corners(mesh, &mesh.colors)[2..4], [[1.0, 1.0, 0.0, 0.25], [1.0, 1.0, 0.0, 0.5]]);
    assert!(notes(&found).contains("outside 0 to 1"));
    let found = assembly(&triangles(opacity));
    assert_eq!(only_mesh(&found).colors[0], [0.8, 0.8, 0.8, 0.25]);
}

/// UsdGeomPrimvarsAPI: only constants are inherited, the nearest wins; shapes have them, too.
#[test]
fn constant_colours_are_inherited() {
    let text = format!(
        r#"def Xform "A" {{
    color3f[] primvars:displayColor = [(1, 0, 0)]
    {}
    def Sphere "S" {{ }}
    def Xform "B" {{
        color3f[] primvars:displayColor = [(0, 1, 0)]
        float[] primvars:displayOpacity = [0.5]
        def Sphere "S" {{ }}
    }}
    def Cube "C" {{
        color3f[] primvars:displayColor = [(0, 0, 1)]
    }}
}}
def Sphere "S" {{ }}
"#,
        triangles("")
    );
    let found = assembly(&text);
    let color = |path: &str| {
        let node = found.nodes.iter().find(|node| node.path == path).unwrap();
        found.meshes[node.mesh.unwrap()].mesh.colors.first().copied()
    };
    assert_eq!(color("A/T"), Some([1.0, 0.0, 0.0, 1.0]));
    assert_eq!(color("A/S"), Some([1.0, 0.0, 0.0, 1.0]));
    assert_eq!(color("A/B/S"), Some([0.0, 1.0, 0.0, 0.5]));
    assert_eq!(color("A/C"), Some([0.0, 0.0, 1.0, 1.0]));
    assert_eq!(color("S"), None);
}

/// A material that reads `names` as diffuse colour, roughness and opacity.
fn reader(names: [&str; 3]) -> String {
    let [color, rough, opacity] = names;
    format!(
        r#"def Material "M" {{
    token outputs:surface.connect = </M/S.outputs:surface>
    def Shader "S" {{
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor.connect = </M/colour.outputs:rgb>
        float inputs:roughness.connect = </M/rough.outputs:r>
        {opacity}
        token outputs:surface
    }}
    def Shader "colour" {{
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @a.png@
        float2 inputs:st.connect = </M/colour_st.outputs:result>
    }}
    def Shader "colour_st" {{
        uniform token info:id = "UsdPrimvarReader_float2"
        string inputs:varname = "{color}"
        float2 inputs:fallback = (0.25, 0.75)
    }}
    def Shader "rough" {{
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @b.png@
        float2 inputs:st.connect = </M/rough_st.outputs:result>
    }}
    def Shader "rough_st" {{
        uniform token info:id = "UsdPrimvarReader_float2"
        string inputs:varname = "{rough}"
    }}
    def Shader "share" {{
        uniform token info:id = "UsdPrimvarReader_float"
        string inputs:varname = "displayOpacity"
        float inputs:fallback = 0.5
    }}
}}
"#
    )
}

const BOUND: &str = r#"
    rel material:binding = </M>
    texCoord2f[] primvars:UVMap = [(0, 0), (1, 0), (1, 1), (0, 0), (1, 1), (0, 1)] (interpolation = "faceVarying")
    texCoord2f[] primvars:st = [(0.5, 0.5), (0.25, 0.25)] (interpolation = "vertex")
    int[] primvars:st:indices = [0, 1, 0, 1]
    color3f[] primvars:displayColor = [(1, 0, 0)]
"#;

#[test]
fn sets_are_found_by_their_names() {
    let found = assembly(&(triangles(BOUND) + &reader(["UVMap", "st", ""])));
    let mesh = only_mesh(&found);
    assert_eq!(corners(mesh, &mesh.uvs), [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    let (a, b) = ([0.5; 2], [0.25; 2]);
    assert_eq!(corners(mesh, &mesh.second_uvs), [a, b, a, a, a, b]);
    let surface = found.materials[0].surface.as_ref().unwrap();
    let sets = (surface.base_color.texture.as_ref().unwrap().set, surface.roughness.texture.as_ref().unwrap().0.set);
    assert_eq!(sets, (0, 1));
    // The material has a colour of its own.
    assert!(mesh.colors.is_empty());
    assert!(!notes(&found).contains("does not have"), "{}", notes(&found));
}

#[test]
fn a_set_that_is_missing_is_its_readers_fallback() {
    let opacity = "float inputs:opacity.connect = </M/share.outputs:result>";
    let found = assembly(&(triangles(BOUND) + &reader(["UVMap1", "st", opacity])));
    let mesh = only_mesh(&found);
    assert!(mesh.uvs.iter().all(|uv| *uv == [0.25, 0.75]));
    let notes = notes(&found);
    assert!(
        notes.contains("</T>: the material reads the texture coordinates `UVMap1` (the mesh has `UVMap`)"),
        "{notes}"
    );
    // The opacities are not there either.
    assert!(notes.contains("the opacities `displayOpacity`"), "{notes}");
    assert!(mesh.colors.iter().all(|color| *color == [1.0, 1.0, 1.0, 0.5]));
    assert!(found.materials[0].surface.as_ref().unwrap().vertex_colors);
}

/// Faces of one mesh have what their own materials name.
#[test]
fn each_face_has_what_its_material_reads() {
    let subsets = r#"
    texCoord2f[] primvars:st = [(1, 1)] (interpolation = "constant")
    texCoord2f[] primvars:other = [(2, 2)] (interpolation = "constant")
    color3f[] primvars:displayColor = [(1, 0, 0)]
    def GeomSubset "a" {
        uniform token elementType = "face"
        uniform token familyName = "materialBind"
        int[] indices = [0]
        rel material:binding = </M>
    }
    def GeomSubset "b" {
        uniform token elementType = "face"
        uniform token familyName = "materialBind"
        int[] indices = [1]
    }
"#;
    let found = assembly(&(triangles(subsets) + &reader(["other", "other", ""])));
    let mesh = only_mesh(&found);
    let (uvs, colors) = (corners(mesh, &mesh.uvs), corners(mesh, &mesh.colors));
    assert_eq!((uvs[0], uvs[3]), ([2.0; 2], [1.0; 2]));
    assert_eq!((colors[0], colors[3]), ([1.0; 4], [1.0, 0.0, 0.0, 1.0]));
}

/// What vertices carry is refined as the surface is.
#[test]
fn a_subdivision_surface_keeps_its_sets_and_colours() {
    // UVMap is (x, y), st is (y, z), the colours are half of 1 + (x, y, z).
    let cube = r#"def Mesh "C" {
    uniform token subdivisionScheme = "catmullClark"
    uniform token faceVaryingLinearInterpolation = "none"
    point3f[] points = [(-1, -1, -1), (1, -1, -1), (-1, 1, -1), (1, 1, -1), (-1, -1, 1), (1, -1, 1), (-1, 1, 1), (1, 1, 1)]
    int[] faceVertexCounts = [4, 4, 4, 4, 4, 4]
    int[] faceVertexIndices = [0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5]
    texCoord2f[] primvars:UVMap = [(-1, -1), (1, -1), (-1, 1), (1, 1)] (interpolation = "faceVarying")
    int[] primvars:UVMap:indices = [0, 2, 3, 1, 0, 1, 3, 2, 0, 1, 1, 0, 2, 2, 3, 3, 0, 0, 2, 2, 1, 3, 3, 1]
    texCoord2f[] primvars:st = [(-1, -1), (1, -1), (-1, 1), (1, 1)] (interpolation = "vertex")
    int[] primvars:st:indices = [0, 0, 1, 1, 2, 2, 3, 3]
    color3f[] primvars:displayColor = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1), (1, 1, 1)] (interpolation = "vertex")
    float[] primvars:displayOpacity = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6] (interpolation = "uniform")
    def GeomSubset "a" {
        uniform token elementType = "face"
        uniform token familyName = "materialBind"
        int[] indices = [0, 1, 2]
        rel material:binding = </M>
    }
}
"#;
    let found = assembly(&(cube.to_owned() + &reader(["UVMap", "st", ""])));
    let mesh = only_mesh(&found);
    assert!(notes(&found).contains("on its limit surface"), "{}", notes(&found));
    assert!(!notes(&found).contains("outside 0 to 1"), "{}", notes(&found));
    let [bound, rest] = mesh.faces.as_slice() else { panic!("{:?}", mesh.faces) };
    let near = |a: &[f32], b: &[f32]| assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 2e-6), "{a:?} {b:?}");
    for vertex in bound.triangles().flat_map(|i| mesh.triangles[i]).map(|vertex| vertex as usize) {
        let [x, y, z] = mesh.positions[vertex];
        near(&mesh.uvs[vertex], &[x, y]);
        near(&mesh.second_uvs[vertex], &[y, z]);
    }
    let mut of_opacity = [0; 7];
    for three in rest.triangles().map(|i| mesh.triangles[i].map(|vertex| vertex as usize)) {
        let opacity = mesh.colors[three[0]][3];
        for vertex in three {
            let [x, y, z] = mesh.positions[vertex];
            near(&mesh.uvs[vertex], &[y, z]);
            near(&mesh.colors[vertex], &[(1.0 + x) / 2.0, (1.0 + y) / 2.0, (1.0 + z) / 2.0, opacity]);
        }
        of_opacity[(10.0 * opacity).round() as usize] += 1;
    }
    let third = mesh.triangles.len() / 6;
    assert_eq!(of_opacity, [0, 0, 0, 0, third, third, third]);
}
