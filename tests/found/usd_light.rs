//! Emission of USD's surfaces is light: one cd/m² a unit, as glTF's, with its pictures; and it stays when it is converted.

use super::{data, is_near, read, seen};
use eyebox::author;
use eyebox::import;
use eyebox::plan::Choice;
use std::path::Path;

/// Red, green, blue and white texels fill the view: a quarter of the luminance of each.
#[test]
fn a_picture_shines_as_it_is() {
    let found = seen(&data("U2_r.optics.toml"), &[], Choice::Auto, 64);
    assert!(is_near(found, 0.25 * (0.2126 + 0.7152 + 0.0722 + 1.0), 2e-3), "{found:?}");
}

fn square(shader: &str) -> String {
    format!(
        r#"#usda 1.0
(
    metersPerUnit = 1
    upAxis = "Y"
)
def Camera "eye" {{
    float horizontalAperture = 10
    float verticalAperture = 10
    float focalLength = 100
    double3 xformOp:translate = (0, 0, 3)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}}
def Mesh "square" (prepend apiSchemas = ["MaterialBindingAPI"]) {{
    uniform token subdivisionScheme = "none"
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
    rel material:binding = </M>
}}
def Material "M" {{
    token outputs:surface.connect = </M/S.outputs:surface>
    def Shader "S" {{
        {shader}
        token outputs:surface
    }}
}}
"#
    )
}

fn shown(path: &Path) -> (f64, f64) {
    // Of what reflects the assumed sky nothing is left.
    seen(path, &["sky.luminance_cd_m2=0"], Choice::Auto, 8)
}

#[test]
fn every_model_shines_and_is_written() {
    let preview = "uniform token info:id = \"UsdPreviewSurface\"\ncolor3f inputs:diffuseColor = (0, 0, 0)";
    let standard = "uniform token info:id = \"ND_standard_surface_surfaceshader\"\nfloat inputs:base = 0";
    let open_pbr = "uniform token info:id = \"ND_open_pbr_surface_surfaceshader\"\nfloat inputs:base_weight = 0";
    let gltf = "uniform token info:id = \"ND_gltf_pbr_surfaceshader\"\ncolor3f inputs:base_color = (0, 0, 0)";
    let folder = tempfile::tempdir().expect("a folder");
    for (name, shader, want) in [
        ("preview", format!("{preview}\ncolor3f inputs:emissiveColor = (300, 300, 300)"), 300.0),
        ("red", format!("{preview}\ncolor3f inputs:emissiveColor = (1000, 0, 0)"), 212.6),
        (
            "standard",
            format!("{standard}\nfloat inputs:emission = 50\ncolor3f inputs:emission_color = (2, 2, 2)"),
            100.0,
        ),
        ("open", format!("{open_pbr}\nfloat inputs:emission_luminance = 80"), 80.0),
        ("gltf", format!("{gltf}\ncolor3f inputs:emissive = (3, 3, 3)\nfloat inputs:emissive_strength = 10"), 30.0),
        // Under a coat of index 1.5, which OpenPBR's is not by itself.
        (
            "coat",
            format!(
                "{open_pbr}\nfloat inputs:emission_luminance = 1000\nfloat inputs:coat_weight = 1\nfloat inputs:coat_ior = 1.5"
            ),
            960.0,
        ),
    ] {
        let asset = folder.path().join(format!("{name}.usda"));
        std::fs::write(&asset, square(&shader)).expect("a file");
        let found = shown(&asset);
        assert!(is_near(found, want, 5e-3), "{name}: {found:?} for {want}");
        let assembly = import::asset(&asset).unwrap_or_else(|fault| panic!("{fault}"));
        for kind in ["glb", "usda"] {
            let out = folder.path().join(format!("{name}_out.{kind}"));
            author::convert(&assembly, &out).unwrap_or_else(|fault| panic!("{fault}"));
            let found = shown(&out);
            assert!(is_near(found, want, 5e-3), "{name} as {kind}: {found:?} for {want}");
        }
    }
    let dark = folder.path().join("dark.usda");
    std::fs::write(&dark, square(&format!("{standard}\ncolor3f inputs:emission_color = (2, 2, 2)"))).expect("a file");
    let built = read(&dark, &[]);
    assert!(built.scene.parts.iter().all(|part| part.faces.iter().all(|face| face.emitter.is_none())));
}

/// A light whose number are watts shines 683 times as bright in nit (K_cd of the SI); a dome, a mesh that is a light and glTF's too.
#[test]
fn lights_in_watts() {
    use eyebox::import::{LightUnits, ReadOptions};
    let folder = tempfile::tempdir().unwrap();
    let stage = "#usda 1.0\n(\n metersPerUnit = 1\n upAxis = \"Y\"\n)\n\
                 def SphereLight \"ball\" { float inputs:intensity = 2\n float inputs:radius = 0.1 }\n\
                 def DomeLight \"sky\" { float inputs:intensity = 3 }\n\
                 def Mesh \"sheet\" (prepend apiSchemas = [\"MeshLightAPI\"]) { float inputs:intensity = 5\n\
                 uniform token subdivisionScheme = \"none\"\n int[] faceVertexCounts = [3]\n int[] faceVertexIndices = [0, 1, 2]\n\
                 point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)] }\n";
    let gltf = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"extensionsUsed":["KHR_lights_punctual"],
        "nodes":[{"extensions":{"KHR_lights_punctual":{"light":0}}}],
        "extensions":{"KHR_lights_punctual":{"lights":[{"type":"point","intensity":7}]}}}"#;
    for (name, text) in [("a.usda", stage), ("a.gltf", gltf)] {
        let file = folder.path().join(name);
        std::fs::write(&file, text).unwrap();
        let read = |light_units| {
            let options = ReadOptions { light_units, ..ReadOptions::default() };
            eyebox::import::read(&file, &options).unwrap_or_else(|fault| panic!("{fault}")).0
        };
        let [unsaid, nit, watt] = [LightUnits::Unsaid, LightUnits::Nit, LightUnits::Watt].map(read);
        let strengths = |all: &eyebox::import::Assembly| -> Vec<f64> {
            use eyebox::scene::assembly::LightForm;
            let own = all.lights.iter().map(|light| match light.form {
                LightForm::Point { intensity_cd: own, .. }
                | LightForm::Distant { illuminance_lx: own, .. }
                | LightForm::Rect { luminance_cd_m2: own, .. }
                | LightForm::Disk { luminance_cd_m2: own, .. }
                | LightForm::Sphere { luminance_cd_m2: own, .. }
                | LightForm::Cylinder { luminance_cd_m2: own, .. }
                | LightForm::Dome { scale_cd_m2: own, .. } => own,
            });
            let emitters = all.nodes.iter().filter_map(|node| node.attributes.as_ref()?.get("emitter"));
            own.chain(emitters.filter_map(|emitter| emitter.get("luminance_cd_m2")?.number())).collect()
        };
        let plain = strengths(&unsaid);
        let want: &[f64] = if name == "a.usda" { &[2.0, 3.0, 5.0] } else { &[7.0] };
        assert_eq!(plain, want, "{name}");
        assert_eq!(strengths(&nit), plain, "{name}");
        assert_eq!(strengths(&watt), plain.iter().map(|own| 683.0 * own).collect::<Vec<_>>(), "{name}");
        let tells = |all: &eyebox::import::Assembly| all.notes.iter().filter(|note| note.text.contains("683 lm/W")).count();
        assert_eq!([&unsaid, &nit, &watt].map(tells), [1, 0, 1], "{name}");
    }
}
