//! USD's materials through glTF and back, and what glTF has no form for.

use super::looks::{picture, read, write};
use super::said::{assert_same, said};
use eyebox::scene::Spectrum;
use std::path::{Path, PathBuf};

/// A quad with a material of `shaders`, whose surface is `</a/M/S.outputs:surface>`.
fn stage(folder: &Path, shaders: &str) -> PathBuf {
    for (file, seed) in [("tex/base.png", 1), ("tex/orm.png", 2), ("tex/n.png", 3)] {
        picture(&folder.join(file), seed);
    }
    let grey = image::GrayImage::from_fn(4, 4, |x, y| image::Luma([(16 * x + 50 * y) as u8]));
    grey.save(folder.join("tex/grey.png")).expect("it is written");
    std::fs::write(folder.join("tex/wide.exr"), b"\x76\x2f\x31\x01 no more than its first bytes are asked for")
        .expect("it is written");
    let text = format!(
        r#"#usda 1.0
(
    defaultPrim = "a"
    metersPerUnit = 1
    upAxis = "Y"
)
def Xform "a"
{{
    def Mesh "m" (
        prepend apiSchemas = ["MaterialBindingAPI"]
    )
    {{
        rel material:binding = </a/M>
        int[] faceVertexCounts = [3, 3]
        int[] faceVertexIndices = [0, 1, 2, 0, 2, 3]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
        normal3f[] normals = [(0, 0, 1), (0, 0, 1), (0, 0, 1), (0, 0, 1)] (
            interpolation = "vertex"
        )
        texCoord2f[] primvars:st = [(0, 0), (0.75, 0), (0.75, 1), (0, 1)] (
            interpolation = "vertex"
        )
        texCoord2f[] primvars:st1 = [(0.125, 0.5), (1.5, 0.5), (1.5, -1), (0.125, -1)] (
            interpolation = "vertex"
        )
        color3f[] primvars:displayColor = [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)] (
            interpolation = "vertex"
        )
        uniform token subdivisionScheme = "none"
    }}
    def Material "M"
    {{
        token outputs:surface.connect = </a/M/S.outputs:surface>
{shaders}
    }}
}}
"#
    );
    let file = folder.join("stage.usda");
    std::fs::write(&file, text).expect("it is written");
    file
}

fn shader(name: &str, id: &str, lines: &[&str]) -> String {
    format!("def Shader \"{name}\" {{\nuniform token info:id = \"{id}\"\n{}\n}}\n", lines.join("\n"))
}

fn texture(name: &str, file: &str, lines: &[&str]) -> String {
    let own = format!("asset inputs:file = @./tex/{file}@");
    let rest = [
        own.as_str(),
        "float outputs:r",
        "float outputs:g",
        "float outputs:b",
        "float outputs:a",
        "float3 outputs:rgb",
    ];
    shader(name, "UsdUVTexture", &[&rest[..], lines].concat())
}

#[test]
fn a_preview_surface_comes_back_from_gltf() {
    let folder = tempfile::tempdir().expect("a folder");
    let repeat = ["token inputs:wrapS = \"repeat\"", "token inputs:wrapT = \"mirror\""];
    let shaders = [
        shader(
            "S",
            "UsdPreviewSurface",
            &[
                "color3f inputs:diffuseColor.connect = </a/M/Base.outputs:rgb>",
                "float inputs:opacity.connect = </a/M/Base.outputs:a>",
                "float inputs:opacityThreshold = 0.25",
                "float inputs:metallic.connect = </a/M/Orm.outputs:b>",
                "float inputs:roughness.connect = </a/M/Orm.outputs:g>",
                "float inputs:clearcoat.connect = </a/M/Grey.outputs:r>",
                "float inputs:clearcoatRoughness.connect = </a/M/Grey.outputs:r>",
                "normal3f inputs:normal.connect = </a/M/N.outputs:rgb>",
                "float inputs:ior = 1.75",
                "token outputs:surface",
            ],
        ),
        texture(
            "Base",
            "base.png",
            &[
                "token inputs:sourceColorSpace = \"sRGB\"",
                "float2 inputs:st.connect = </a/M/Place.outputs:result>",
                "float4 inputs:scale = (0.5, 0.75, 1, 0.875)",
                repeat[0],
                repeat[1],
            ],
        ),
        // Black outside, where no face reads.
        texture(
            "Orm",
            "orm.png",
            &[
                "token inputs:sourceColorSpace = \"raw\"",
                "float2 inputs:st.connect = </a/M/st.outputs:result>",
                "float4 inputs:scale = (1, 0.5, 0.25, 1)",
                "token inputs:wrapS = \"clamp\"",
                "token inputs:wrapT = \"clamp\"",
            ],
        ),
        texture("Grey", "grey.png", &["float2 inputs:st.connect = </a/M/st1.outputs:result>", repeat[0], repeat[1]]),
        texture(
            "N",
            "n.png",
            &[
                "token inputs:sourceColorSpace = \"raw\"",
                "float2 inputs:st.connect = </a/M/st.outputs:result>",
                "float4 inputs:scale = (2, 2, 2, 1)",
                "float4 inputs:bias = (-1, -1, -1, 0)",
                repeat[0],
                repeat[1],
            ],
        ),
        shader("st", "UsdPrimvarReader_float2", &["string inputs:varname = \"st\"", "float2 outputs:result"]),
        shader("st1", "UsdPrimvarReader_float2", &["string inputs:varname = \"st1\"", "float2 outputs:result"]),
        shader(
            "Place",
            "UsdTransform2d",
            &[
                "float2 inputs:in.connect = </a/M/st.outputs:result>",
                "float inputs:rotation = 30",
                "float2 inputs:scale = (2, 3)",
                "float2 inputs:translation = (0.5, -0.25)",
                "float2 outputs:result",
            ],
        ),
    ]
    .concat();
    let assembly = read(&stage(folder.path(), &shaders));
    let wanted = said(&assembly);
    for way in [&["usdc", "usdz", "usda"][..], &["usda", "usdc"]] {
        let mut assembly = assembly.clone();
        for kind in way {
            let file = folder.path().join(way.concat()).join(format!("a.{kind}"));
            let written = write(&assembly, &file);
            assert!(written.notes.is_empty(), "{:?}", written.notes);
            assembly = read(&file);
            assert_same(&wanted, &said(&assembly), kind);
        }
    }
    // glTF reads the green channel of what is grey, and says of all how it is read.
    for (first, second) in [("glb", "usda"), ("gltf", "usdz")] {
        let mut assembly = assembly.clone();
        for kind in [first, second] {
            let file = folder.path().join(format!("{first}_")).join(format!("a.{kind}"));
            let written = write(&assembly, &file);
            assert!(written.notes.is_empty(), "{:?}", written.notes);
            assembly = read(&file);
        }
        let plain = |said: &super::said::Said| -> super::said::Said {
            let label =
                |label: &str| label.replace("coat roughness Green", "coat roughness Red").replace("OfFile", "Linear");
            said.iter().map(|(own, numbers)| (label(own), numbers.clone())).collect()
        };
        assert_same(&plain(&wanted), &plain(&said(&assembly)), first);
    }
}

#[test]
fn what_gltf_lacks_is_said_once_each() {
    let folder = tempfile::tempdir().expect("a folder");
    let raw = "token inputs:sourceColorSpace = \"raw\"";
    let shaders = [
        shader(
            "S",
            "UsdPreviewSurface",
            &[
                "color3f inputs:diffuseColor.connect = </a/M/Wide.outputs:rgb>",
                "float inputs:metallic.connect = </a/M/Orm.outputs:r>",
                "float inputs:roughness.connect = </a/M/Other.outputs:g>",
                "float inputs:clearcoat.connect = </a/M/Biased.outputs:r>",
                "float inputs:clearcoatRoughness.connect = </a/M/Outside.outputs:g>",
                "float inputs:opacity.connect = </a/M/Orm.outputs:g>",
                "token outputs:surface",
            ],
        ),
        texture("Wide", "wide.exr", &["token inputs:wrapS = \"repeat\"", "token inputs:wrapT = \"repeat\""]),
        texture("Orm", "orm.png", &[raw, "token inputs:wrapS = \"repeat\"", "token inputs:wrapT = \"repeat\""]),
        texture("Biased", "base.png", &[raw, "float4 inputs:bias = (0.5, 0, 0, 0)"]),
        texture("Outside", "n.png", &[raw, "float2 inputs:st.connect = </a/M/st1.outputs:result>"]),
        texture("Other", "base.png", &[raw, "float2 inputs:st.connect = </a/M/st1.outputs:result>"]),
        shader("st1", "UsdPrimvarReader_float2", &["string inputs:varname = \"st1\"", "float2 outputs:result"]),
    ]
    .concat();
    let assembly = read(&stage(folder.path(), &shaders));
    let written = write(&assembly, &folder.path().join("out/a.gltf"));
    let texts: Vec<&str> = written.notes.iter().map(|note| note.text.as_str()).collect();
    for wanted in [
        "the picture `wide.exr` is OpenEXR, which glTF does not hold",
        "metallic: its picture `orm.png` is not written: it is read from its red channel; glTF reads blue; its mean",
        "roughness: its picture `base.png` is not written: glTF has one picture for it and the metallic; its mean",
        "coat: its picture `base.png` is not written: it is read with a bias",
        "opacity: its picture `orm.png` is not written: it is not the alpha of the base colour's",
        "roughness of the coat: black outside",
    ] {
        assert_eq!(texts.iter().filter(|text| text.contains(wanted)).count(), 1, "{wanted}\n{texts:#?}");
    }
    assert_eq!(texts.len(), 6, "{texts:#?}");
    // Nothing that is not read is there.
    let there: Vec<_> = std::fs::read_dir(folder.path().join("out/a_textures")).expect("a folder").collect();
    assert_eq!(there.len(), 1, "{there:?}");
}

/// glTF has no lights with an extent: they are meshes there that glow as much, where they were.
#[test]
fn lights_with_an_extent_glow_in_gltf() {
    let folder = tempfile::tempdir().expect("a folder");
    let light = |kind: &str, lines: &str| {
        format!("    def {kind} \"{kind}\"\n    {{\n        float inputs:intensity = 500\n        {lines}\n    }}\n")
    };
    let text = [
        "#usda 1.0\n(\n    defaultPrim = \"a\"\n    metersPerUnit = 0.01\n    upAxis = \"Z\"\n)\ndef Xform \"a\"\n{\n"
            .to_owned(),
        "    double3 xformOp:translate = (1, 2, 3)\n    uniform token[] xformOpOrder = [\"xformOp:translate\"]\n"
            .to_owned(),
        "    def Cube \"box\"\n    {\n        double size = 1\n    }\n".to_owned(),
        light("RectLight", "float inputs:width = 4"),
        light("DiskLight", "float inputs:radius = 2"),
        light("SphereLight", "color3f inputs:color = (1, 0.5, 0.25)"),
        light("CylinderLight", "float inputs:length = 3"),
        "}\n".to_owned(),
    ];
    let file = folder.path().join("lights.usda");
    std::fs::write(&file, text.concat()).expect("it is written");
    let to = folder.path().join("lights.glb");
    let written = write(&read(&file), &to);
    assert!(written.notes.is_empty(), "{:?}", written.notes);
    struct Glowing {
        name: String,
        photometry: String,
        both_sides: bool,
        points: Vec<[f32; 3]>,
        spectrum: Option<Spectrum>,
    }
    let glowing = |file: &Path| {
        let scene = super::kit::scene(file);
        let mut out: Vec<Glowing> = Vec::new();
        for part in &scene.parts {
            let Some(emitter) = part.faces.iter().find_map(|face| face.emitter.as_ref()) else { continue };
            let points = &scene.meshes[part.mesh.index()].positions;
            let world =
                points.iter().map(|p| part.to_world.transform_point3(glam::Vec3::from(*p).as_dvec3()).as_vec3());
            out.push(Glowing {
                name: part.name.clone(),
                photometry: format!("{:?}", emitter.photometry),
                both_sides: emitter.both_sides,
                points: world.map(|p| p.to_array()).collect(),
                spectrum: emitter.spectrum.clone(),
            });
        }
        out.sort_by(|a, b| a.name.cmp(&b.name));
        out
    };
    let (was, is) = (glowing(&file), glowing(&to));
    assert_eq!(was.len(), 4);
    assert_eq!(was.len(), is.len());
    for (was, is) in was.iter().zip(&is) {
        assert_eq!((&was.name, was.both_sides), (&is.name, is.both_sides));
        let number = |text: &str| -> f64 {
            let digits = text.split(['(', ')']).nth(1).expect("a number");
            digits.parse().expect("a number")
        };
        assert!(
            (number(&was.photometry) / number(&is.photometry) - 1.0).abs() < 1e-6,
            "{} {}",
            was.photometry,
            is.photometry
        );
        let [a, b] = [&was.spectrum, &is.spectrum].map(|spectrum| match spectrum {
            None | Some(Spectrum::D65) => [1.0; 3],
            Some(Spectrum::Rgb(rgb)) => rgb.map(|x| x / rgb.iter().copied().fold(0.0, f64::max)),
            Some(other) => panic!("{}: {other:?}", was.name),
        });
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6), "{}: {a:?}, {b:?}", was.name);
        assert_eq!(a != [1.0; 3], was.name.contains("Sphere"), "{}: {a:?}", was.name);
        let far = was.points.as_flattened().iter().zip(is.points.as_flattened()).map(|(a, b)| (a - b).abs());
        assert!(was.points.len() == is.points.len() && far.fold(0.0, f32::max) < 1e-7, "{}", was.name);
    }
}
