//! How materials look, through `convert`: surfaces, textures, coordinates and colours of vertices come back the same, whatever
//! formats are between.

use super::said::{Said, assert_same, said};
use eyebox::author::{Written, convert};
use eyebox::import::{self, Assembly};
use image::{ImageFormat, Rgba, RgbaImage};
use serde_json::json;
use std::path::Path;

pub fn read(file: &Path) -> Assembly {
    import::asset(file).unwrap_or_else(|fault| panic!("{}: {fault}", file.display()))
}

pub fn write(assembly: &Assembly, file: &Path) -> Written {
    std::fs::create_dir_all(file.parent().expect("a folder")).expect("a folder");
    convert(assembly, file).unwrap_or_else(|fault| panic!("{}: {fault}", file.display()))
}

/// A picture of 4 x 2 texels that are all different, in each channel.
pub fn picture(file: &Path, seed: u8) {
    let format = ImageFormat::from_path(file).expect("a known ending");
    let texel = |x: u32, y: u32| {
        let n = (x + 4 * y) as u8;
        Rgba([20 * n + seed, 255 - 30 * n, (7 * n).wrapping_mul(seed | 1), 100 + 15 * n])
    };
    let picture = RgbaImage::from_fn(4, 2, texel);
    std::fs::create_dir_all(file.parent().expect("a folder")).expect("a folder");
    picture.save_with_format(file, format).expect("it is written");
}

/// Two triangles for each of `materials`, with two sets of coordinates and, if `painted`, colours.
fn rich(folder: &Path) -> std::path::PathBuf {
    for (file, seed) in [("a b.png", 1), ("mr.png", 2), ("normal.png", 3), ("glow.png", 4), ("lay.webp", 5)] {
        picture(&folder.join("tex").join(file), seed);
    }
    let f32s = |list: &[f32]| list.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let positions = f32s(&[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.]);
    let normals = f32s(&[0., 0., 1.].repeat(4));
    let first = f32s(&[0.1, 0.2, 2.3, 0.25, 2.1, -1.7, 0.05, 0.9]);
    let second = f32s(&[0.0, 0.0, 0.5, 0.0, 0.5, 0.75, 0.0, 0.75]);
    let colors = f32s(&[1., 0.5, 0.25, 1., 0., 1., 1., 0.5, 0.125, 1., 0., 0.75, 1., 1., 1., 1.]);
    let indices: Vec<u8> = [0u32, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()).collect();
    let (mut buffer, mut views) = (Vec::new(), Vec::new());
    for part in [&positions, &normals, &first, &second, &colors, &indices] {
        views.push(json!({ "buffer": 0, "byteOffset": buffer.len(), "byteLength": part.len() }));
        buffer.extend_from_slice(part);
    }
    std::fs::write(folder.join("rich.bin"), &buffer).expect("it is written");
    let accessor = |view: usize, ty: &str| json!({ "bufferView": view, "componentType": 5126, "count": 4, "type": ty });
    let mut place = accessor(0, "VEC3");
    (place["min"], place["max"]) = (json!([0, 0, 0]), json!([1, 1, 0]));
    let accessors = json!([
        place, accessor(1, "VEC3"), accessor(2, "VEC2"), accessor(3, "VEC2"), accessor(4, "VEC4"),
        { "bufferView": 5, "componentType": 5125, "count": 6, "type": "SCALAR" },
    ]);
    let moved = json!({ "KHR_texture_transform": { "offset": [0.25, -0.5], "rotation": 0.7, "scale": [2, 0.5] } });
    let materials = json!([
        {
            "name": "Worn Metal", "doubleSided": true, "alphaMode": "MASK", "alphaCutoff": 0.3,
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.8, 0.7, 0.1, 0.9], "baseColorTexture": { "index": 0, "extensions": moved },
                "metallicFactor": 0.9, "roughnessFactor": 0.35, "metallicRoughnessTexture": { "index": 1, "texCoord": 1 },
            },
            "normalTexture": { "index": 2, "scale": 0.5 },
            "emissiveFactor": [1, 0.5, 0.25], "emissiveTexture": { "index": 3, "texCoord": 1 },
            "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 120 } },
        },
        {
            "name": "layers",
            "pbrMetallicRoughness": { "baseColorFactor": [0.2, 0.3, 0.4, 1], "metallicFactor": 0, "roughnessFactor": 0.1 },
            "extensions": {
                "KHR_materials_ior": { "ior": 1.7 },
                "KHR_materials_iridescence": {
                    "iridescenceFactor": 0.75, "iridescenceIor": 1.375, "iridescenceThicknessMaximum": 250,
                },
                "KHR_materials_specular": {
                    "specularFactor": 0.6, "specularTexture": { "index": 4 }, "specularColorFactor": [1, 0.9, 0.5],
                },
                "KHR_materials_clearcoat": {
                    "clearcoatFactor": 0.5, "clearcoatTexture": { "index": 1 }, "clearcoatRoughnessFactor": 0.2,
                },
                "KHR_materials_sheen": {
                    "sheenColorFactor": [0.1, 0.2, 0.9], "sheenColorTexture": { "index": 0 }, "sheenRoughnessFactor": 0.4,
                },
                "KHR_materials_transmission": { "transmissionFactor": 0.75, "transmissionTexture": { "index": 1 } },
                "KHR_materials_volume": {
                    "thicknessFactor": 0.01, "attenuationDistance": 0.02, "attenuationColor": [0.9, 0.8, 0.7],
                },
                "KHR_materials_dispersion": { "dispersion": 0.3 },
            },
        },
        {
            "name": "painted", "alphaMode": "BLEND",
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.5, 1, 0.25, 0.8], "baseColorTexture": { "index": 4 }, "metallicFactor": 0,
            },
            "emissiveFactor": [0.5, 0.5, 0.5],
        },
        {
            "name": "leaf",
            "pbrMetallicRoughness": { "metallicFactor": 0 },
            "extensions": {
                "KHR_materials_diffuse_transmission": {
                    "diffuseTransmissionFactor": 0.4, "diffuseTransmissionColorFactor": [0.3, 1, 0.2],
                },
            },
        },
    ]);
    let primitive = |material: usize, colors: bool| {
        let mut out = json!({
            "attributes": { "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2, "TEXCOORD_1": 3 }, "indices": 5, "material": material,
        });
        if colors {
            out["attributes"]["COLOR_0"] = json!(4);
        }
        out
    };
    let mesh = |material: usize, colors: bool| json!({ "name": format!("m{material}"), "primitives": [primitive(material, colors)] });
    let document = json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0, 1, 2, 3] }],
        "extensionsUsed": [
            "KHR_texture_transform", "EXT_texture_webp", "KHR_materials_emissive_strength", "KHR_materials_ior",
            "KHR_materials_specular", "KHR_materials_clearcoat", "KHR_materials_sheen", "KHR_materials_transmission",
            "KHR_materials_volume", "KHR_materials_dispersion", "KHR_materials_diffuse_transmission",
        ],
        "extensionsRequired": ["EXT_texture_webp"],
        "nodes": (0..4).map(|i| json!({ "name": format!("n{i}"), "mesh": i })).collect::<Vec<_>>(),
        "meshes": [mesh(0, false), mesh(1, false), mesh(2, true), mesh(3, false)],
        "materials": materials,
        "images": [
            { "uri": "tex/a%20b.png" }, { "uri": "tex/mr.png" }, { "uri": "tex/normal.png" }, { "uri": "tex/glow.png" },
            { "uri": "tex/lay.webp", "mimeType": "image/webp" },
        ],
        "samplers": [{ "wrapS": 33648, "wrapT": 33071 }, { "magFilter": 9728, "minFilter": 9728 }],
        "textures": [
            { "source": 0, "sampler": 0 }, { "source": 1 }, { "source": 2, "sampler": 0 }, { "source": 3 },
            { "sampler": 1, "extensions": { "EXT_texture_webp": { "source": 4 } } },
        ],
        "accessors": accessors, "bufferViews": views,
        "buffers": [{ "uri": "rich.bin", "byteLength": buffer.len() }],
    });
    let file = folder.join("rich.gltf");
    std::fs::write(&file, document.to_string()).expect("it is written");
    file
}

/// Writes `assembly` along the way, reads each file again, and compares what all of them say.
fn along(assembly: &Assembly, wanted: &Said, folder: &Path, way: &[&str]) {
    let mut assembly = assembly.clone();
    for (step, kind) in way.iter().enumerate() {
        let file = folder.join(format!("{}_{step}", way.join("_"))).join(format!("asset.{kind}"));
        write(&assembly, &file);
        assembly = read(&file);
        assert_same(wanted, &said(&assembly), &format!("{way:?}, step {step}"));
    }
}

#[test]
fn a_rich_gltf_comes_back_from_every_way() {
    let folder = tempfile::tempdir().expect("a folder");
    let assembly = read(&rich(folder.path()));
    let wanted = said(&assembly);
    for way in [&["glb", "gltf"][..], &["usda", "gltf", "usdc"], &["usdz", "glb", "usdz"], &["gltf", "usda", "usdz"]] {
        along(&assembly, &wanted, folder.path(), way);
    }
}

#[test]
fn pictures_are_copied_and_nothing_else_is_there() {
    let folder = tempfile::tempdir().expect("a folder");
    let assembly = read(&rich(folder.path()));
    let written = write(&assembly, &folder.path().join("out/x.gltf"));
    assert!(written.notes.is_empty(), "{:?}", written.notes);
    let names = |folder: &Path| -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(folder)
            .expect("a folder")
            .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    };
    assert_eq!(names(&folder.path().join("out")), ["x.bin", "x.gltf", "x_textures"]);
    assert_eq!(
        names(&folder.path().join("out/x_textures")),
        ["a b.png", "glow.png", "lay.webp", "mr.png", "normal.png"]
    );
    let bytes = |file: &str| std::fs::read(folder.path().join(file)).expect("a file");
    assert!(bytes("tex/a b.png") == bytes("out/x_textures/a b.png"));
    // Written to where it came from, it is the same.
    let again = read(&folder.path().join("out/x.gltf"));
    let before = bytes("out/x.gltf");
    write(&again, &folder.path().join("out/x.gltf"));
    assert!(before == bytes("out/x.gltf"));
}

/// glTF's `doubleSided` makes a face glow on both sides; it needs no row of ours, which would be an emitter without a strength.
#[test]
fn what_glows_on_both_sides_still_does() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = rich(folder.path());
    let mut json: serde_json::Value =
        serde_json::from_slice(&std::fs::read(&file).expect("it is there")).expect("JSON");
    let materials = json["materials"].as_array_mut().expect("a list");
    for material in materials.iter_mut() {
        material["doubleSided"] = json!(true);
        material["emissiveFactor"] = json!([0.5, 0.25, 1.0]);
    }
    std::fs::write(&file, json.to_string()).expect("it is written");
    let glowing = |file: &Path| -> Vec<bool> {
        let scene = super::kit::scene(file);
        let faces = scene.parts.iter().flat_map(|part| &part.faces);
        faces.map(|face| face.emitter.as_ref().is_some_and(|emitter| emitter.both_sides)).collect()
    };
    let wanted = glowing(&file);
    assert!(wanted.contains(&true));
    let mut assembly = read(&file);
    for name in ["a/x.usda", "b/x.glb", "c/x.usdz", "d/x.gltf"] {
        let to = folder.path().join(name);
        write(&assembly, &to);
        assert_eq!(glowing(&to), wanted, "{name}");
        assembly = read(&to);
    }
}
