//! Networks of nodes: what folds, and what is said of the rest.

use super::kit::{assembly, notes};
use crate::Assembly;
use eyebox_base::Shared;
use eyebox_scene::texture::{Channel, Encoding, Filter, Wrap};
use eyebox_scene::{Opacity, StandardSurface};

/// A material with a MaterialX shader of this kind.
fn shader(kind: &str, inputs: &str, nodes: &str) -> Assembly {
    assembly(&format!(
        r#"def Material "M" {{
    token outputs:mtlx:surface.connect = </M/S.outputs:out>
    def Shader "S" {{
        uniform token info:id = "{kind}"
        {inputs}
        token outputs:out
    }}
{nodes}
}}
"#
    ))
}

fn standard(inputs: &str, nodes: &str) -> Assembly {
    shader("ND_standard_surface_surfaceshader", inputs, nodes)
}

fn surface(found: &Assembly) -> &StandardSurface {
    found.materials[0].surface.as_ref().unwrap()
}

fn node(name: &str, id: &str, inputs: &str) -> String {
    format!("    def Shader \"{name}\" {{\n uniform token info:id = \"{id}\"\n {inputs}\n }}\n")
}

const BASE: &str = "color3f inputs:base_color.connect = </M/n.outputs:out>";

#[test]
fn arithmetic_on_constants_folds() {
    for (id, inputs, want) in [
        (
            "ND_multiply_color3",
            "color3f inputs:in1 = (0.5, 0.25, 1)\ncolor3f inputs:in2 = (0.5, 0.5, 0.5)",
            [0.25, 0.125, 0.5],
        ),
        ("ND_multiply_color3FA", "color3f inputs:in1 = (0.5, 0.25, 1)\nfloat inputs:in2 = 0.5", [0.25, 0.125, 0.5]),
        ("ND_divide_color3FA", "color3f inputs:in1 = (0.5, 0.25, 1)\nfloat inputs:in2 = 2", [0.25, 0.125, 0.5]),
        (
            "ND_add_color3",
            "color3f inputs:in1 = (0.5, 0.25, 0)\ncolor3f inputs:in2 = (0.125, 0, 0)",
            [0.625, 0.25, 0.0],
        ),
        ("ND_subtract_color3FA", "color3f inputs:in1 = (0.5, 0.25, 1)\nfloat inputs:in2 = 0.25", [0.25, 0.0, 0.75]),
        ("ND_invert_color3", "color3f inputs:in = (0.5, 0.25, 1)", [0.5, 0.75, 0.0]),
        (
            "ND_mix_color3",
            "color3f inputs:fg = (1, 1, 1)\ncolor3f inputs:bg = (0, 0.5, 0)\nfloat inputs:mix = 0.25",
            [0.25, 0.625, 0.25],
        ),
        ("ND_convert_float_color3", "float inputs:in = 0.5", [0.5; 3]),
        ("ND_clamp_color3", "color3f inputs:in = (2, 0.5, -1)", [1.0, 0.5, 0.0]),
        (
            "ND_remap_color3FA",
            "color3f inputs:in = (2, 3, 4)\nfloat inputs:inlow = 2\nfloat inputs:inhigh = 4",
            [0.0, 0.5, 1.0],
        ),
        ("ND_power_color3FA", "color3f inputs:in1 = (0.5, 1, 0)\nfloat inputs:in2 = 2", [0.25, 1.0, 0.0]),
        (
            "ND_swizzle_color3_color3",
            "color3f inputs:in = (0.5, 0.25, 0.75)\nstring inputs:channels = \"br1\"",
            [0.75, 0.5, 1.0],
        ),
        (
            "ND_combine3_color3",
            "float inputs:in1 = 0.5\nfloat inputs:in2 = 0.25\nfloat inputs:in3 = 1",
            [0.5, 0.25, 1.0],
        ),
        (
            "ND_ifgreater_color3",
            "float inputs:value1 = 2\nfloat inputs:value2 = 1\ncolor3f inputs:in1 = (0.5, 0.5, 0.5)",
            [0.5; 3],
        ),
        ("ND_switch_color3", "float inputs:which = 1\ncolor3f inputs:in2 = (0.5, 0.25, 0.5)", [0.5, 0.25, 0.5]),
    ] {
        let found = standard(BASE, &node("n", id, inputs));
        let colour = &surface(&found).base_color;
        assert_eq!((colour.factor, colour.texture.is_none()), (want, true), "{id}");
        assert_eq!(notes(&found).matches("not used").count(), 0, "{id}: {}", notes(&found));
    }
}

const IMAGE: &str = "asset inputs:file = @a.png@ (colorSpace = \"srgb_texture\")";

#[test]
fn arithmetic_on_a_picture_scales_and_moves_it() {
    let image = node("i", "ND_image_color3", IMAGE);
    let read = "color3f inputs:in1.connect = </M/i.outputs:out>\ncolor3f inputs:in.connect = </M/i.outputs:out>\ncolor3f inputs:bg.connect = </M/i.outputs:out>";
    for (id, inputs, scale, bias) in [
        ("ND_multiply_color3", "color3f inputs:in2 = (0.5, 0.25, 1)", [0.5, 0.25, 1.0], [0.0; 3]),
        ("ND_add_color3FA", "float inputs:in2 = 0.25", [1.0; 3], [0.25; 3]),
        ("ND_subtract_color3FA", "float inputs:in2 = 0.25", [1.0; 3], [-0.25; 3]),
        ("ND_invert_color3", "", [-1.0; 3], [1.0; 3]),
        ("ND_mix_color3", "color3f inputs:fg = (1, 0, 0)\nfloat inputs:mix = 0.25", [0.75; 3], [0.25, 0.0, 0.0]),
    ] {
        let found = standard(BASE, &(node("n", id, &format!("{read}\n{inputs}")) + &image));
        let input = surface(&found).base_color.texture.as_ref().unwrap();
        assert_eq!((input.scale[..3].to_vec(), input.bias[..3].to_vec()), (scale.to_vec(), bias.to_vec()), "{id}");
        assert_eq!((input.encoding, input.wrap), (Encoding::Srgb, [Wrap::Repeat; 2]));
        assert!(!notes(&found).contains("not used"), "{id}: {}", notes(&found));
    }
}

/// A mask between two constants, by one channel of a picture.
#[test]
fn masks_and_channels_are_pictures() {
    let nodes = node(
        "n",
        "ND_mix_color3",
        "color3f inputs:fg = (1, 0.5, 0)\ncolor3f inputs:bg = (0, 0.5, 1)\nfloat inputs:mix.connect = </M/m.outputs:outg>",
    ) + &node("m", "ND_separate3_color3", "color3f inputs:in.connect = </M/i.outputs:out>")
        + &node("i", "ND_image_color3", IMAGE);
    let found = standard(&format!("{BASE}\nfloat inputs:metalness.connect = </M/m.outputs:outb>"), &nodes);
    let (base, metal) = (surface(&found).base_color.texture.as_ref().unwrap(), &surface(&found).metallic);
    assert_eq!(base.channels, [Channel::Green; 4]);
    assert_eq!((base.scale[..3].to_vec(), base.bias[..3].to_vec()), (vec![1.0, 0.0, -1.0], vec![0.0, 0.5, 1.0]));
    let (input, channel) = metal.texture.as_ref().unwrap();
    assert_eq!((*channel, input.channels, input.scale), (Channel::Blue, Channel::ALL, [1.0; 4]));
}

#[test]
fn what_does_not_fold_is_said_with_its_node() {
    let nodes = node(
        "n",
        "ND_multiply_color3",
        "color3f inputs:in1.connect = </M/i.outputs:out>\ncolor3f inputs:in2.connect = </M/j.outputs:out>",
    ) + &node("i", "ND_image_color3", IMAGE)
        + &node("j", "ND_image_color3", "asset inputs:file = @b.png@");
    let found = standard(BASE, &nodes);
    assert_eq!(surface(&found).base_color.texture.as_ref().unwrap().texture.name, "a.png");
    let said = notes(&found);
    assert!(
        said.contains("</M/n>: what the node `ND_multiply_color3` makes of its inputs is not used: `in1` alone"),
        "{said}"
    );
    let found = standard(BASE, &node("n", "ND_fractal3d_color3", ""));
    assert_eq!(surface(&found).base_color.factor, [0.8; 3]);
    assert!(notes(&found).contains("</M/n>: the node `ND_fractal3d_color3` is not used"), "{}", notes(&found));
}

/// Nodes that read themselves, and nodes that double: neither hangs.
#[test]
fn networks_end() {
    let found = standard(BASE, &node("n", "ND_multiply_color3", "color3f inputs:in1.connect = </M/n.outputs:out>"));
    assert!(surface(&found).base_color.texture.is_none());
    let mut nodes = node("n0", "ND_constant_color3", "color3f inputs:value = (1, 1, 1)");
    for i in 1..60 {
        let both = format!(
            "color3f inputs:in1.connect = </M/n{0}.outputs:out>\ncolor3f inputs:in2.connect = </M/n{0}.outputs:out>",
            i - 1
        );
        nodes += &node(&format!("n{i}"), "ND_multiply_color3", &both);
    }
    let found = standard("color3f inputs:base_color.connect = </M/n59.outputs:out>", &nodes);
    assert_eq!(surface(&found).base_color.factor, [1.0; 3]);
}

/// MaterialX 1.39, place2d and tiledimage: the closed forms of their node graphs.
#[test]
fn coordinates_are_placed_as_materialx_does() {
    let place = |order: &str| {
        let moved = "float2 inputs:texcoord.connect = </M/u.outputs:out>\nfloat2 inputs:pivot = (0.5, 0.25)\nfloat2 inputs:scale = (2, 4)\nfloat inputs:rotate = 30\nfloat2 inputs:offset = (0.125, 0.0625)";
        let nodes =
            node("n", "ND_image_color3", &format!("{IMAGE}\nfloat2 inputs:texcoord.connect = </M/p.outputs:out>"))
                + &node("p", "ND_place2d_vector2", &format!("{moved}\n{order}"))
                + &node("u", "ND_texcoord_vector2", "int inputs:index = 1");
        let found = standard(BASE, &nodes);
        surface(&found).base_color.texture.as_ref().unwrap().to_picture
    };
    let (sin, cos) = 30f64.to_radians().sin_cos();
    let rotate = |[x, y]: [f64; 2]| [cos * x + sin * y, cos * y - sin * x];
    for (u, v) in [(0.0, 0.0), (0.3, 0.9), (2.0, -1.0)] {
        let from = [u - 0.5, v - 0.25];
        let [x, y] = rotate([from[0] / 2.0, from[1] / 4.0]);
        let srt = [x - 0.125 + 0.5, y - 0.0625 + 0.25];
        let [x, y] = rotate([from[0] - 0.125, from[1] - 0.0625]);
        let trs = [x / 2.0 + 0.5, y / 4.0 + 0.25];
        for (map, [s, t]) in [(place(""), srt), (place("int inputs:operationorder = 1"), trs)] {
            let [across, down] = map.map(|[a, b, c]| a * u + b * v + c);
            assert!((across - s).abs() < 1e-12 && (1.0 - down - t).abs() < 1e-12, "{across} {down}: {s} {t}");
        }
    }
    let tiled = "float2 inputs:uvtiling = (4, 6)\nfloat2 inputs:uvoffset = (1, 2)\nfloat2 inputs:realworldimagesize = (2, 2)\nfloat2 inputs:realworldtilesize = (1, 3)";
    let found = standard(BASE, &node("n", "ND_tiledimage_color3", &format!("{IMAGE}\n{tiled}")));
    let [across, down] = surface(&found).base_color.texture.as_ref().unwrap().to_picture;
    // ((4u − 1)/2, 3(6v − 2)/2), and from the top.
    assert_eq!((across, down), ([2.0, 0.0, -0.5], [0.0, -9.0, 4.0]));
}

#[test]
fn pictures_have_the_spaces_wraps_and_fallbacks_of_their_nodes() {
    let found = shader(
        "ND_UsdPreviewSurface_surfaceshader",
        "color3f inputs:diffuseColor.connect = </M/a.outputs:rgb>\nfloat inputs:roughness.connect = </M/b.outputs:b>\nfloat inputs:metallic.connect = </M/none.outputs:g>",
        &(node(
            "a",
            "UsdUVTexture",
            "asset inputs:file = @a.png@\ntoken inputs:wrapS = \"useMetadata\"\ntoken inputs:wrapT = \"clamp\"\nfloat4 inputs:fallback = (0.5, 0.25, 1, 1)\nfloat4 inputs:scale = (2, 1, 1, 1)\nfloat2 inputs:st.connect = </M/uv.outputs:result>",
        ) + &node(
            "b",
            "UsdUVTexture",
            "asset inputs:file = @b.png@\ntoken inputs:sourceColorSpace = \"sRGB\"\ntoken inputs:wrapS = \"black\"\nfloat2 inputs:st.connect = </M/uv.outputs:result>",
        ) + &node("none", "UsdUVTexture", "float4 inputs:fallback = (0, 0.75, 0, 1)")
            + &node("uv", "UsdPrimvarReader_float2", "string inputs:varname = \"st\"")),
    );
    let surface = surface(&found);
    let base = surface.base_color.texture.as_ref().unwrap();
    assert_eq!((base.encoding, base.wrap), (Encoding::OfFile, [Wrap::Black, Wrap::Clamp]));
    // What comes out of it is the fallback as it is.
    assert_eq!(base.fallback, Some([0.25, 0.25, 1.0, 1.0]));
    let (rough, channel) = surface.roughness.texture.as_ref().unwrap();
    assert_eq!((rough.encoding, rough.wrap[0], *channel), (Encoding::Srgb, Wrap::Black, Channel::Blue));
    assert_eq!(surface.metallic.factor, 0.75);
    assert!(notes(&found).contains("</M/none>: a picture without a file"), "{}", notes(&found));
    let number = node(
        "n",
        "ND_image_float",
        "asset inputs:file = @a.png@\nstring inputs:filtertype = \"closest\"\nstring inputs:uaddressmode = \"mirror\"",
    );
    let found = standard("float inputs:metalness.connect = </M/n.outputs:out>", &number);
    let (metal, channel) = self::surface(&found).metallic.texture.clone().unwrap();
    assert_eq!(
        (metal.encoding, metal.wrap, metal.filter, channel),
        (Encoding::Linear, [Wrap::Mirror, Wrap::Repeat], Filter::Nearest, Channel::Red)
    );
}

#[test]
fn normals_are_stretched_by_their_node() {
    let nodes =
        node("n", "ND_normalmap_float", "vector3f inputs:in.connect = </M/i.outputs:out>\nfloat inputs:scale = 0.5")
            + &node("i", "ND_image_vector3", "asset inputs:file = @a.png@");
    let found = standard("vector3f inputs:normal.connect = </M/n.outputs:out>", &nodes);
    let (input, strength) = surface(&found).normal.clone().unwrap();
    assert_eq!((input.scale[..3].to_vec(), input.bias[..3].to_vec(), strength), (vec![2.0; 3], vec![-1.0; 3], 0.5));
    assert_eq!(input.encoding, Encoding::Linear);
}

#[test]
fn colours_of_vertices_are_read_by_networks() {
    let nodes = node(
        "n",
        "ND_multiply_color3",
        "color3f inputs:in1.connect = </M/v.outputs:out>\ncolor3f inputs:in2 = (0.5, 0.5, 0.25)",
    ) + &node("v", "ND_geompropvalue_color3", "string inputs:geomprop = \"displayColor\"");
    let found = standard(BASE, &nodes);
    assert_eq!((surface(&found).vertex_colors, surface(&found).base_color.factor), (true, [0.5, 0.5, 0.25]));
    let found = standard("color3f inputs:specular_color.connect = </M/v.outputs:out>", &nodes);
    assert!(!surface(&found).vertex_colors);
    assert!(
        notes(&found).contains("the colours of the primvar `displayColor` as `specular_color`"),
        "{}",
        notes(&found)
    );
}

#[test]
fn models_have_their_own_defaults() {
    let plain = |kind: &str| Shared::clone(shader(kind, "", "").materials[0].surface.as_ref().unwrap());
    let standard = plain("ND_standard_surface_surfaceshader");
    assert_eq!((standard.base_color.factor, standard.roughness.factor, standard.ior), ([0.8; 3], 0.2, 1.5));
    assert_eq!((standard.coat_roughness.factor, standard.sheen_roughness.factor), (0.1, 0.3));
    let open_pbr = plain("ND_open_pbr_surface_surfaceshader");
    assert_eq!((open_pbr.base_color.factor, open_pbr.roughness.factor), ([0.8; 3], 0.3));
    assert_eq!((open_pbr.coat_roughness.factor, open_pbr.sheen_roughness.factor), (0.0, 0.5));
    let gltf = plain("ND_gltf_pbr_surfaceshader");
    assert_eq!((gltf.base_color.factor, gltf.metallic.factor, gltf.roughness.factor), ([1.0; 3], 1.0, 1.0));
}

#[test]
fn the_specular_workflow_says_what_is_reflected() {
    let found = shader(
        "UsdPreviewSurface",
        "int inputs:useSpecularWorkflow = 1\ncolor3f inputs:specularColor = (0.25, 0.5, 1)\nfloat inputs:metallic = 1\nfloat inputs:opacity = 0.5\ntoken inputs:opacityMode = \"presence\"\nfloat inputs:ior = 1.5\nfloat inputs:displacement = 1\nfloat inputs:occlusion = 0.5",
        "",
    );
    let surface = surface(&found);
    assert_eq!((surface.ior, surface.specular_color.factor), (f64::INFINITY, [0.25, 0.5, 1.0]));
    assert_eq!((surface.metallic.factor, matches!(surface.opacity, Opacity::Blend { .. })), (0.0, true));
    let said = notes(&found);
    // Presence is no glass, and occlusion is for others.
    assert!(!said.contains("glass") && !said.contains("occlusion"), "{said}");
    assert!(said.contains("`displacement` of a surface is not used"), "{said}");
}

#[test]
fn emission_of_openpbr_may_be_a_picture() {
    let found = shader(
        "ND_open_pbr_surface_surfaceshader",
        "float inputs:emission_luminance = 200\ncolor3f inputs:emission_color.connect = </M/n.outputs:out>",
        &node("n", "ND_image_color3", IMAGE),
    );
    let mapped: Vec<String> = found.materials[0].mapped.iter().map(|(key, value)| format!("{key} = {value}")).collect();
    assert_eq!(mapped, ["luminance_cd_m2 = 200"]);
    assert_eq!(surface(&found).emission.as_ref().unwrap().texture.name, "a.png");
}
