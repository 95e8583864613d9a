//! A file that is missing is one finding, however many materials and binds name it.

use super::reports::{eyebox, text};
use std::path::Path;

/// A triangle a material, each with the base colour of the texture of its number; three images, two of them of one name.
fn triangles(folder: &Path) {
    let of = |text: &str| (0..3).map(|i| text.replace('#', &i.to_string())).collect::<Vec<_>>().join(",");
    let gltf = [
        r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1,2]}],"nodes":["#,
        &of(r#"{"name":"N#","mesh":#,"translation":[0,0,-#]}"#),
        r#"],"meshes":["#,
        &of(r#"{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"material":#}]}"#),
        r#"],"materials":["#,
        &of(r#"{"name":"M#","pbrMetallicRoughness":{"baseColorTexture":{"index":#}}}"#),
        r#"],"textures":["#,
        &of(r#"{"source":#}"#),
        r#"],"images":[{"uri":"gone.png"},{"uri":"gone.png"},{"uri":"maps/../gone.png"}],"#,
        r#""accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},"#,
        r#"{"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}],"#,
        r#""bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":24}],"#,
        r#""buffers":[{"byteLength":60,"uri":"data:application/octet-stream;base64,"#,
        "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/",
        r#""}]}"#,
    ]
    .concat();
    std::fs::write(folder.join("a.gltf"), gltf).unwrap();
}

fn findings<'a>(shown: &'a str, of: &str) -> Vec<&'a str> {
    shown.lines().filter(|line| line.contains(of)).collect()
}

#[test]
fn a_texture_of_many_materials() {
    let folder = tempfile::tempdir().unwrap();
    triangles(folder.path());
    let run = eyebox(folder.path(), &["a.gltf"]);
    let shown = text(&run.stdout);
    let [found] = findings(shown, "gone.png")[..] else { panic!("{shown}") };
    assert!(found.contains("error[EB0006]") && found.contains("/images/0"), "{found}");
    // With the picture, and the folder that a name goes through, nothing is left of it.
    std::fs::create_dir(folder.path().join("maps")).unwrap();
    image::RgbImage::from_pixel(1, 1, image::Rgb([255; 3])).save(folder.path().join("gone.png")).unwrap();
    let run = eyebox(folder.path(), &["a.gltf"]);
    assert!(!text(&run.stdout).contains("gone.png"), "{}", text(&run.stdout));
}

#[test]
fn a_texture_of_many_binds() {
    let folder = tempfile::tempdir().unwrap();
    triangles(folder.path());
    let bind = |node: &str| {
        format!(
            "[[bind]]\npath = \"{node}\"\nfinish = {{ kind = \"surface\", base_color_texture = \"lost.png\" }}\n"
        )
    };
    let sheet = format!("schema = 1\nasset = \"a.gltf\"\n{}", ["N0", "N1", "N2"].map(bind).concat());
    std::fs::write(folder.path().join("a.optics.toml"), sheet).unwrap();
    let run = eyebox(folder.path(), &["a.optics.toml"]);
    let shown = text(&run.stdout);
    let [found] = findings(shown, "lost.png")[..] else { panic!("{shown}") };
    assert!(found.contains("error[EB0006]"), "{found}");
}

/// USD says what stands for a picture, so that it renders.
#[test]
fn a_texture_of_many_usd_materials() {
    let folder = tempfile::tempdir().unwrap();
    let of = |text: &str| (0..3).map(|i| text.replace('#', &i.to_string())).collect::<String>();
    let stage = "#usda 1.0\n(\n    metersPerUnit = 1\n    upAxis = \"Y\"\n)\n".to_owned()
        + &of(r#"
def Mesh "P#" (prepend apiSchemas = ["MaterialBindingAPI"]) {
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
    point3f[] points = [(0, 0, -#), (1, 0, -#), (0, 1, -#)]
    texCoord2f[] primvars:st = [(0, 0), (1, 0), (0, 1)] (interpolation = "vertex")
    rel material:binding = </M#>
}
def Material "M#" {
    token outputs:surface.connect = </M#/S.outputs:surface>
    def Shader "S" {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor.connect = </M#/T.outputs:rgb>
        token outputs:surface
    }
    def Shader "T" {
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @gone.png@
        token inputs:wrapS = "repeat"
        float3 outputs:rgb
    }
}
"#);
    std::fs::write(folder.path().join("a.usda"), stage).unwrap();
    let run = eyebox(folder.path(), &["a.usda"]);
    let shown = text(&run.stdout);
    let [found] = findings(shown, "gone.png")[..] else { panic!("{shown}") };
    assert!(found.contains("warning[EB0006]"), "{found}");
}
