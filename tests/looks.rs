//! What a USD asset looks like: traced pictures against closed forms. Under an even sky of L, a matt square that scatters ρ
//! shows ρ L.

use crate::common::{image, mean, render};
use eyebox::check::check;
use eyebox::estimate::run::{Limits, run};
use eyebox::film::plan::Estimator;
use eyebox::import::{ImportOptions, import};
use eyebox::plan::{Choice, plan};
use eyebox::world::World;
use std::path::Path;

const SKY: f64 = 100.0;

/// Linear colours of a picture of `width` × 1 pixels.
fn row(asset: &Path, width: usize) -> Vec<[f64; 3]> {
    let mut scene = import(asset, &ImportOptions::default()).unwrap_or_else(|fault| panic!("{fault}")).scene;
    scene.eye.resolution = [width, 1];
    let checked = check(&scene).expect("the scene is sound");
    let world = World::freeze(&scene).expect("the scene can be traced");
    let plan = plan(&checked, &world, Choice::Only(Estimator::Backward));
    let limits = Limits { passes: Some(400), ..Limits::default() };
    let outcome = run(&world, &plan, scene.groups.len(), scene.eye.resolution, 1, &limits, &mut ());
    let frame =
        eyebox::estimate::picture::picture(&scene, &plan, &outcome, Default::default()).expect("a picture").frame;
    let [r, g, b] = ["R", "G", "B"].map(|name| frame.component("hybrid", name).expect("a channel").data.clone());
    (0..width).map(|x| [r[x], g[x], b[x]].map(f64::from)).collect()
}

/// Four squares side by side fill the view: one with a picture of two halves that a network scales, and three with colours.
const STAGE: &str = r#"#usda 1.0
(
    metersPerUnit = 1
    upAxis = "Y"
)
def DomeLight "sky" {
    float inputs:intensity = 100
}
def Camera "eye" {
    float horizontalAperture = 40
    float verticalAperture = 10
    float focalLength = 100
    double3 xformOp:translate = (2, 0.5, 10)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def Mesh "picture" (prepend apiSchemas = ["MaterialBindingAPI"]) {
    uniform token subdivisionScheme = "none"
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    texCoord2f[] primvars:st = [(0, 0), (0, 0), (0, 0), (0, 0)] (interpolation = "vertex")
    texCoord2f[] primvars:map = [(0, 0), (1, 0), (1, 1), (0, 1)] (interpolation = "faceVarying")
    rel material:binding = </M>
}
def Mesh "colours" {
    uniform token subdivisionScheme = "none"
    int[] faceVertexCounts = [4, 4]
    int[] faceVertexIndices = [0, 1, 4, 5, 1, 2, 3, 4]
    point3f[] points = [(1, 0, 0), (2, 0, 0), (3, 0, 0), (3, 1, 0), (2, 1, 0), (1, 1, 0)]
    color3f[] primvars:displayColor = [(0.5, 0.25, 0.75), (0.25, 0.5, 0.125)] (interpolation = "uniform")
}
def Xform "above" {
    color3f[] primvars:displayColor = [(0.625, 0.5, 0.25)]
    def Mesh "inherits" {
        uniform token subdivisionScheme = "none"
        int[] faceVertexCounts = [4]
        int[] faceVertexIndices = [0, 1, 2, 3]
        point3f[] points = [(3, 0, 0), (4, 0, 0), (4, 1, 0), (3, 1, 0)]
    }
}
def Material "M" {
    token outputs:mtlx:surface.connect = </M/S.outputs:out>
    def Shader "S" {
        uniform token info:id = "ND_standard_surface_surfaceshader"
        color3f inputs:base_color.connect = </M/half.outputs:out>
        float inputs:specular = 0
        token outputs:out
    }
    def Shader "half" {
        uniform token info:id = "ND_multiply_color3FA"
        color3f inputs:in1.connect = </M/image.outputs:out>
        float inputs:in2 = 0.5
    }
    def Shader "image" {
        uniform token info:id = "ND_image_color3"
        asset inputs:file = @halves.png@
        string inputs:filtertype = "closest"
        float2 inputs:texcoord.connect = </M/map.outputs:out>
    }
    def Shader "map" {
        uniform token info:id = "ND_geompropvalue_vector2"
        string inputs:geomprop = "map"
    }
}
"#;

#[test]
fn a_stage_shows_its_pictures_and_colours() {
    let folder = tempfile::tempdir().expect("a folder");
    let halves = image::RgbImage::from_fn(2, 1, |x, _| image::Rgb(if x == 0 { [255, 0, 188] } else { [0, 255, 255] }));
    halves.save(folder.path().join("halves.png")).expect("a picture");
    let asset = folder.path().join("stage.usda");
    std::fs::write(&asset, STAGE).expect("a file");
    // IEC 61966-2-1: 188 is 0.502886 of white.
    let want = [
        [0.5, 0.0, 0.251_443],
        [0.0, 0.5, 0.5],
        [0.5, 0.25, 0.75],
        [0.5, 0.25, 0.75],
        [0.25, 0.5, 0.125],
        [0.25, 0.5, 0.125],
        [0.625, 0.5, 0.25],
        [0.625, 0.5, 0.25],
    ];
    for (x, (found, want)) in row(&asset, 8).into_iter().zip(want).enumerate() {
        for (found, want) in found.into_iter().zip(want) {
            // The sky is all that lights them: no noise, but rounding of the film and of the sky's table.
            assert!((found / SKY - want).abs() < 0.02, "{x}: {found} of {SKY}, {want}");
        }
    }
}

/// A MaterialX file, as a reference.
#[test]
fn materialx_files_are_layers() {
    let folder = tempfile::tempdir().expect("a folder");
    let mtlx = r#"<?xml version="1.0"?>
<materialx version="1.39" colorspace="lin_rec709">
  <standard_surface name="S" type="surfaceshader">
    <input name="base_color" type="color3" nodegraph="G" output="colour" />
    <input name="specular" type="float" value="0" />
  </standard_surface>
  <nodegraph name="G">
    <constant name="c" type="color3">
      <input name="value" type="color3" value="1, 188, 0" />
    </constant>
    <multiply name="m" type="color3">
      <input name="in1" type="color3" nodename="c" />
      <input name="in2" type="color3" value="0.25, 0.0026595744680851063, 1" />
    </multiply>
    <output name="colour" type="color3" nodename="m" />
  </nodegraph>
  <surfacematerial name="M" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="S" />
  </surfacematerial>
</materialx>
"#;
    std::fs::write(folder.path().join("m.mtlx"), mtlx).expect("a file");
    let (head, rest) = STAGE.split_once("def Material \"M\"").expect("a material");
    assert!(!rest.is_empty());
    let reference = "def \"M\" (references = @m.mtlx@</MaterialX/Materials/M>) { }\n";
    let asset = folder.path().join("stage.usda");
    std::fs::write(&asset, format!("{head}{reference}")).expect("a file");
    let [r, g, b] = row(&asset, 8)[0].map(|x| x / SKY);
    assert!((r - 0.25).abs() < 0.02 && (g - 0.5).abs() < 0.02 && b.abs() < 0.02, "{r} {g} {b}");
}

/// A normal map leans the normal for optics, not the face: light that comes from behind the face is none of its, whichever
/// way paths are drawn. A matt face that leans by β before an even sky then shows ρ (1 + cos β)/2 of it (the view factor of
/// an inclined plane and the upper half of the sphere; Siegel and Howell, Thermal Radiation Heat Transfer).
#[test]
fn a_mapped_normal_gets_no_light_from_behind_the_face() {
    let folder = tempfile::tempdir().expect("a folder");
    // Upright, and leaning to the right by some 20, 30 and 40 degrees: beyond 45 what it mirrors of a view from above would lie
    // below the face, and the normal is pulled up.
    let lean = [0.0f64, 0.35, 0.5, 0.64];
    let byte = |x: f64| ((x * 0.5 + 0.5) * 255.0).round() as u8;
    let texel = |sin: f64| [byte(sin), byte(0.0), byte((1.0 - sin * sin).sqrt())];
    let map = image::RgbImage::from_fn(4, 1, |x, _| image::Rgb(texel(lean[x as usize])));
    map.save(folder.path().join("lean.png")).expect("a picture");
    let asset = folder.path().join("lean.usda");
    std::fs::write(&asset, LEANING).expect("a file");
    for (x, (found, sin)) in row(&asset, 4).into_iter().zip(lean).enumerate() {
        let normal = texel(sin).map(|value| f64::from(value) / 255.0 * 2.0 - 1.0);
        let cos = normal[2] / normal.map(|component| component * component).iter().sum::<f64>().sqrt();
        let want = 0.5 * (1.0 + cos) / 2.0;
        assert!((found[0] / SKY - want).abs() < 0.01, "{x}: {} of {SKY}, {want}", found[0]);
    }
}

const LEANING: &str = r#"#usda 1.0
(
    metersPerUnit = 1
    upAxis = "Y"
)
def DomeLight "sky" {
    float inputs:intensity = 100
}
def Camera "eye" {
    float horizontalAperture = 40
    float verticalAperture = 10
    float focalLength = 1000
    double3 xformOp:translate = (2, 0.5, 100)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def Mesh "plate" (prepend apiSchemas = ["MaterialBindingAPI"]) {
    uniform token subdivisionScheme = "none"
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(0, 0, 0), (4, 0, 0), (4, 1, 0), (0, 1, 0)]
    texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] (interpolation = "vertex")
    rel material:binding = </M>
}
def Material "M" {
    token outputs:mtlx:surface.connect = </M/S.outputs:out>
    def Shader "S" {
        uniform token info:id = "ND_standard_surface_surfaceshader"
        color3f inputs:base_color = (0.5, 0.5, 0.5)
        float inputs:specular = 0
        float3 inputs:normal.connect = </M/normal.outputs:out>
        token outputs:out
    }
    def Shader "normal" {
        uniform token info:id = "ND_normalmap"
        float3 inputs:in.connect = </M/image.outputs:out>
        float3 outputs:out
    }
    def Shader "image" {
        uniform token info:id = "ND_image_vector3"
        asset inputs:file = @lean.png@
        string inputs:filtertype = "closest"
    }
}
"#;

/// A corner of two matt walls that glow by a picture, in an even sky.
const CORNER: &str = r#"#usda 1.0
(
    metersPerUnit = 1
    upAxis = "Y"
)
def DomeLight "sky" {
    float inputs:intensity = SKY
}
def Camera "eye" {
    float horizontalAperture = 20
    float verticalAperture = 20
    float focalLength = 40
    double3 xformOp:translate = (0, 0.4, 4)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def Mesh "walls" (prepend apiSchemas = ["MaterialBindingAPI"]) {
    uniform token subdivisionScheme = "none"
    int[] faceVertexCounts = [4, 4]
    int[] faceVertexIndices = [0, 1, 2, 3, 3, 2, 4, 5]
    point3f[] points = [(-1, 0, 1), (1, 0, 1), (1, 0, 0), (-1, 0, 0), (1, 1, 0), (-1, 1, 0)]
    texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1), (0, 0), (1, 0), (1, 1), (0, 1)] (interpolation = "faceVarying")
    rel material:binding = </M>
}
def Material "M" {
    token outputs:surface.connect = </M/S.outputs:surface>
    def Shader "S" {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor = (0.6, 0.6, 0.6)
        float inputs:roughness = 1
        color3f inputs:emissiveColor.connect = </M/T.outputs:rgb>
        token outputs:surface
    }
    def Shader "T" {
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @halves.png@
        float4 inputs:scale = (400, 400, 400, 1)
        float2 inputs:st.connect = </M/R.outputs:result>
        float3 outputs:rgb
    }
    def Shader "R" {
        uniform token info:id = "UsdPrimvarReader_float2"
        string inputs:varname = "st"
        float2 outputs:result
    }
}
"#;

/// Light of a large lamp with a picture goes from wall to wall: whoever has it, nobody else would have done it for much less
/// variance × counted work, and both find the same light.
#[test]
fn light_of_large_pictured_lamps_goes_to_who_has_it_for_less() {
    let folder = tempfile::tempdir().expect("a folder");
    let halves = image::RgbImage::from_fn(4, 2, |x, y| image::Rgb(if (x + y) % 4 == 0 { [255; 3] } else { [20; 3] }));
    halves.save(folder.path().join("halves.png")).expect("a picture");
    let asset = folder.path().join("corner.usda");
    for sky in ["1", "1000"] {
        std::fs::write(&asset, CORNER.replace("SKY", sky)).expect("a file");
        let mut scene = import(&asset, &ImportOptions::default()).unwrap_or_else(|fault| panic!("{fault}")).scene;
        scene.eye.resolution = [20, 20];
        let of = |choice: Choice| {
            let (films, _) = render(&scene, choice, 16, 5);
            let found = image(&films);
            let floor = 0.01 * mean(&found).0;
            let variance: f64 = found.iter().map(|(l, v)| v / (l * l + floor * floor)).sum();
            let work: u64 = films.films.iter().map(|(_, _, ledger)| ledger.work).sum();
            (variance * work as f64, mean(&found))
        };
        let [auto, rays, photons] =
            [Choice::Auto, Choice::Only(Estimator::Backward), Choice::Only(Estimator::Photon)].map(of);
        // A pilot is not exact.
        assert!(
            auto.0 < 2.0 * rays.0.min(photons.0),
            "sky {sky}: {:.3e} of {:.3e} and {:.3e}",
            auto.0,
            rays.0,
            photons.0
        );
        for (one, other) in [(auto.1, rays.1), (photons.1, rays.1)] {
            let sigma = one.1.hypot(other.1);
            // What photons gather is blurred by their kernel: 1 %.
            assert!((one.0 - other.0).abs() < 4.0 * sigma + 0.01 * other.0, "sky {sky}: {one:?} {other:?}");
        }
    }
}

/// A white square at z = −1 m that a camera looks at from within the sphere of a light, about it at z = 1: E = π r² L/d² in its middle.
const WITHIN: &str = r#"#usda 1.0
(
    metersPerUnit = 1
    upAxis = "Y"
)
def SphereLight "around" {
    float inputs:intensity = 100
    float inputs:radius = 0.5
    double3 xformOp:translate = (0, 0, 1)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def Camera "eye" {
    float horizontalAperture = 0.1
    float verticalAperture = 0.1
    float focalLength = 100
    double3 xformOp:translate = (0, 0, CAMERA)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def Mesh "plate" {
    uniform token subdivisionScheme = "none"
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1)]
    color3f[] primvars:displayColor = [(0.5, 0.5, 0.5)] (interpolation = "constant")
}
"#;

#[test]
fn a_camera_within_a_light_sees_what_that_lights() {
    let folder = tempfile::tempdir().unwrap();
    for place in ["1.2", "0.2"] {
        let asset = folder.path().join(format!("within{place}.usda"));
        std::fs::write(&asset, WITHIN.replace("CAMERA", place)).unwrap();
        let scene = import(&asset, &ImportOptions::default()).unwrap().scene;
        let told = scene.notes.iter().any(|note| note.text.contains("the eye stands inside of the sphere"));
        assert_eq!(told, place == "1.2");
        let want = 0.5 * 0.5f64.powi(2) * 100.0 / 2f64.powi(2);
        let [got] = row(&asset, 1)[..] else { panic!("one pixel") };
        // The plate is a dielectric of roughness 1, which reflects some per cent more or less than a matt one.
        got.iter().for_each(|got| assert!((got / want - 1.0).abs() < 0.06, "{place}: {got}, want {want}"));
    }
}

/// A camera in a closed box, and one beside it.
const BOXED: &str = r#"#usda 1.0
(
    metersPerUnit = 1
    upAxis = "Y"
)
def Cube "box" {
    double size = 1
}
def Camera "inside" {
}
LAMP
BESIDE
"#;
const BESIDE: &str = r#"def Camera "beside" {
    double3 xformOp:translate = (0, 0, 5)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}"#;
const LAMP: &str = r#"def SphereLight "lamp" {
    float inputs:radius = 0.05
    double3 xformOp:translate = (0, 0, -0.3)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}"#;

#[test]
fn a_camera_that_no_light_comes_to_gives_way() {
    let folder = tempfile::tempdir().unwrap();
    let eye = |lamp: &str, beside: &str| {
        let asset = folder.path().join("boxed.usda");
        std::fs::write(&asset, BOXED.replace("LAMP", lamp).replace("BESIDE", beside)).unwrap();
        let scene = import(&asset, &ImportOptions::default()).unwrap().scene;
        let told =
            scene.notes.iter().any(|note| note.text.contains("`inside` stands inside of box, where no light comes"));
        (told, scene.eye.position)
    };
    assert_eq!(eye("", BESIDE), (true, glam::DVec3::Z * 5.0));
    let (told, framing) = eye("", "");
    assert!(told && framing.length() > 1.0, "{framing}");
    // A room that a lamp lights is looked at from within.
    assert_eq!(eye(LAMP, BESIDE), (false, glam::DVec3::ZERO));
}
