//! Bindings and surfaces.

use super::kit::{Folder, SQUARE, assembly, notes};
use crate::Assembly;
use crate::value::Value;
use eyebox_scene::Opacity;
use eyebox_scene::texture::{Channel, Encoding, Wrap};

/// The material of each face of the node at `path`.
fn bound<'a>(assembly: &'a Assembly, path: &str) -> Vec<&'a str> {
    let node = assembly.nodes.iter().find(|node| node.path == path).unwrap();
    let mesh = &assembly.meshes[node.mesh.unwrap()];
    let name = |index: &Option<usize>| index.map_or("", |index| assembly.materials[index].name.as_str());
    mesh.materials.iter().map(name).collect()
}

fn mesh(name: &str, rest: &str) -> String {
    let api = "prepend apiSchemas = [\"MaterialBindingAPI\"]";
    format!("def Mesh \"{name}\" ({api}) {{ {SQUARE}\n {rest}\n}}\n")
}

const MATERIALS: &str = "def Material \"M1\" { }\ndef Material \"M2\" { }\ndef Material \"M3\" { }\n";

/// Each expectation is what UsdShade.MaterialBindingAPI.ComputeBoundMaterial of usd-core 26.11 gives for the purpose
/// `full`.
#[test]
fn bindings_resolve_as_usd_does() {
    let [plain, two, full, lost, none] = [
        mesh("c", ""),
        mesh("c", "rel material:binding = </M2>"),
        mesh("d", "rel material:binding:full = </M2>"),
        mesh("e", "rel material:binding = </Nope>"),
        mesh("f", "rel material:binding = None"),
    ];
    let text = format!(
        r#"
def Xform "A" {{
    rel material:binding = </M1>
    {two} {full} {lost} {none}
}}
def Xform "B" (prepend apiSchemas = ["MaterialBindingAPI", "CollectionAPI:x"]) {{
    rel material:binding = </M1> ( bindMaterialAs = "strongerThanDescendants" )
    rel collection:x:includes = [</B/c>]
    rel material:binding:collection:x = [</B.collection:x>, </M3>]
    {two} {full}
}}
def Xform "C" (prepend apiSchemas = ["MaterialBindingAPI", "CollectionAPI:x", "CollectionAPI:y"]) {{
    rel material:binding = </M1>
    rel collection:x:includes = [</C/c>]
    rel collection:y:includes = [</C>]
    rel material:binding:collection:zz = [</C.collection:x>, </M3>]
    rel material:binding:collection:b = [</C.collection:y>, </M2>]
    rel material:binding:collection:full:b = [</C.collection:x>, </M1>]
    {plain}
    {}
}}
def Xform "D" {{
    rel material:binding = [</M1>, </M2>]
    {plain}
}}
{MATERIALS}"#,
        mesh("d", "rel material:binding = </M1>")
    );
    let found = assembly(&text);
    for (path, want) in [
        ("A/c", "M2"),
        ("A/d", "M2"),
        ("A/e", ""),
        ("A/f", "M1"),
        ("B/c", "M3"),
        ("B/d", "M2"),
        ("C/c", "M1"),
        ("C/d", "M1"),
        ("D/c", ""),
    ] {
        assert_eq!(bound(&found, path), [want], "{path}\n{}", notes(&found));
    }
    let names: Vec<&str> = found.materials.iter().map(|material| material.name.as_str()).collect();
    assert_eq!(names, ["M1", "M2", "M3"]);
    let notes = notes(&found);
    assert!(notes.contains("/A/e.material:binding>: the binding leads to </Nope>"), "{notes}");
    assert!(notes.contains("2 materials at once"), "{notes}");
}

#[test]
fn collections_expand_exclude_and_nest() {
    let text = format!(
        r#"
def Xform "A" (prepend apiSchemas = ["MaterialBindingAPI", "CollectionAPI:all", "CollectionAPI:only", "CollectionAPI:in"]) {{
    uniform token collection:only:expansionRule = "explicitOnly"
    rel collection:only:includes = [</A/g>]
    rel collection:all:includes = [</A.collection:in>, </A/h>]
    rel collection:all:excludes = [</A/h/no>]
    rel collection:in:includes = [</A/i>]
    rel material:binding:collection:a = [</A.collection:only>, </M1>]
    rel material:binding:collection:b = [</A.collection:all>, </M2>]
    def Xform "g" {{ {m} }}
    def Xform "h" {{ {m} def Xform "no" {{ {m} }} }}
    def Xform "i" {{ {m} }}
}}
{MATERIALS}"#,
        m = mesh("c", "")
    );
    let found = assembly(&text);
    for (path, want) in [("A/g/c", ""), ("A/h/c", "M2"), ("A/h/no/c", ""), ("A/i/c", "M2")] {
        assert_eq!(bound(&found, path), [want], "{path}");
    }
    // A round trip of collections ends.
    let round = format!(
        "def Xform \"A\" (prepend apiSchemas = [\"CollectionAPI:x\"]) {{\n rel collection:x:includes = [</A.collection:x>]\n rel material:binding:collection:x = [</A.collection:x>, </M1>]\n {} }}\n{MATERIALS}",
        mesh("c", "")
    );
    assert_eq!(bound(&assembly(&round), "A/c"), [""]);
}

#[test]
fn instances_share_materials_but_not_what_collections_tell_apart() {
    let part = format!(
        "(\n defaultPrim = \"P\"\n)\ndef Xform \"P\" {{\n def Material \"Own\" {{ }}\n {} {} }}\n",
        mesh("c", "rel material:binding = </P/Own>"),
        mesh("d", "")
    );
    let root = r#"
def Xform "A" (prepend apiSchemas = ["MaterialBindingAPI", "CollectionAPI:x"]) {
    rel collection:x:includes = [</A/one/d>]
    rel material:binding:collection:x = [</A.collection:x>, </hidden/M>]
    def Xform "one" (instanceable = true prepend references = @./part.usda@) { }
    def Xform "two" (instanceable = true prepend references = @./part.usda@) { }
}
def Scope "hidden" {
    token visibility = "invisible"
    def Material "M" { }
}
"#;
    let root =
        root.replace("(instanceable = true prepend", "(\n instanceable = true\n prepend").replace("usda@)", "usda@\n)");
    let found = Folder::new(&[("a.usda", &root), ("part.usda", &part)]).read(None).unwrap();
    assert_eq!(bound(&found, "A/one/c"), ["Own"]);
    assert_eq!(bound(&found, "A/two/c"), ["Own"]);
    assert_eq!(bound(&found, "A/one/d"), ["M"]);
    assert_eq!(bound(&found, "A/two/d"), [""]);
    let names: Vec<&str> = found.materials.iter().map(|material| material.name.as_str()).collect();
    assert_eq!(names, ["Own", "M"]);
}

#[test]
fn subsets_bind_faces() {
    let subset = |name: &str, family: &str, faces: &str, rest: &str| {
        format!(
            "def GeomSubset \"{name}\" (prepend apiSchemas = [\"MaterialBindingAPI\"]) {{\n uniform token elementType = \"face\"\n uniform token familyName = \"{family}\"\n int[] indices = {faces}\n {rest}\n}}\n"
        )
    };
    let two = "uniform token subdivisionScheme = \"none\"\nint[] faceVertexCounts = [3, 3]\nint[] faceVertexIndices = [0, 1, 2, 0, 2, 3]\npoint3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]\n";
    let body = |strength: &str, subsets: &str| {
        format!(
            "def Mesh \"A\" (prepend apiSchemas = [\"MaterialBindingAPI\"]) {{\n{two} rel material:binding = </M1> {strength}\n{subsets}\n}}\n{MATERIALS}"
        )
    };
    // Coinciding with the CAD faces, splitting one, and under a binding that is stronger.
    let coincide = subset("a", "cadFace", "[0]", "")
        + &subset("b", "cadFace", "[1]", "")
        + &subset("m", "materialBind", "[1]", "rel material:binding = </M2>");
    assert_eq!(bound(&assembly(&body("", &coincide)), "A"), ["M1", "M2"]);
    let split =
        subset("a", "cadFace", "[0, 1]", "") + &subset("m", "materialBind", "[1]", "rel material:binding = </M2>");
    assert_eq!(bound(&assembly(&body("", &split)), "A"), ["M2", "M1"]);
    let strong = body("( bindMaterialAs = \"strongerThanDescendants\" )", &coincide);
    assert_eq!(bound(&assembly(&strong), "A"), ["M1", "M1"]);
}

/// The rows of the only material, `key = value`.
fn said(rows: &[(String, Value)]) -> Vec<String> {
    rows.iter().map(|(key, value)| format!("{key} = {value}")).collect()
}

fn surface(id: &str, inputs: &str) -> Assembly {
    assembly(&format!(
        "(\n metersPerUnit = 0.001\n)\ndef Material \"M\" {{\n token outputs:surface.connect = </M/S.outputs:surface>\n def Shader \"S\" {{\n uniform token info:id = \"{id}\"\n {inputs}\n token outputs:surface\n }}\n}}\n"
    ))
}

#[test]
fn preview_surfaces_are_looks_and_an_index() {
    let found = surface(
        "UsdPreviewSurface",
        "color3f inputs:diffuseColor = (0.5, 0.25, 1)\nfloat inputs:opacity = 0.5\nfloat inputs:metallic = 1\nfloat inputs:roughness = 7\nfloat inputs:ior = 1.5\ncolor3f inputs:emissiveColor = (20, 20, 20)",
    );
    let material = &found.materials[0];
    assert_eq!(said(&material.mapped), ["ior = 1.5", "luminance_cd_m2 = 20"]);
    assert_eq!(said(&material.looks), ["base_color = [0.5, 0.25, 1]", "opacity = 0.5", "metallic = 1"]);
    let notes = notes(&found);
    assert!(notes.contains("/M/S.inputs:roughness>: a value of `roughness`"), "{notes}");
}

#[test]
fn layered_surfaces_are_optics() {
    let found = surface(
        "ND_open_pbr_surface_surfaceshader",
        "float inputs:specular_ior = 1.5\nfloat inputs:transmission_weight = 1\nfloat inputs:transmission_depth = 2\ncolor3f inputs:transmission_color = (0.5, 0.5, 0.5)\nfloat inputs:transmission_dispersion_scale = 0.5\nfloat inputs:transmission_dispersion_abbe_number = 25\nfloat inputs:thin_film_weight = 1\nfloat inputs:thin_film_thickness = 0.25\nfloat inputs:thin_film_ior = 1.375\nfloat inputs:emission_luminance = 250\nfloat inputs:subsurface_weight = 1",
    );
    let material = &found.materials[0];
    let want = [
        "ior = 1.5",
        "transmission = 1",
        "thickness = 1",
        "attenuation_distance = 0.002",
        "attenuation_color = [0.5, 0.5, 0.5]",
        "dispersion = 0.4",
        "coating = { name = \"thin film\", stack = [{ n = 1.375, thickness_nm = 250 }] }",
        "luminance_cd_m2 = 250",
    ];
    assert_eq!(said(&material.mapped), want);
    assert!(notes(&found).contains("`subsurface_weight` of a surface is not used"));
    let found = surface(
        "ND_standard_surface_surfaceshader_100",
        "float inputs:base = 0.5\ncolor3f inputs:base_color = (1, 0.5, 0)\nfloat inputs:metalness = 1\nfloat inputs:specular_IOR = 1.25\nfloat inputs:transmission = 1\nbool inputs:thin_walled = 1\nfloat inputs:transmission_dispersion = 40\nfloat inputs:thin_film_thickness = 500\nfloat inputs:emission = 30\ncolor3f inputs:emission_color = (0.5, 0.5, 0.5)",
    );
    let material = &found.materials[0];
    let want = [
        "ior = 1.25",
        "transmission = 1",
        "dispersion = 0.5",
        "coating = { name = \"thin film\", stack = [{ n = 1.5, thickness_nm = 500 }] }",
        "luminance_cd_m2 = 15",
    ];
    assert_eq!(said(&material.mapped), want);
    assert_eq!(said(&material.looks), ["base_color = [0.5, 0.25, 0]", "metallic = 1"]);
}

/// What makes a surface glass elsewhere, and is not read yet, is said by a warning of its own.
#[test]
fn glass_of_others_is_not_lost_without_a_word() {
    let preview = "float inputs:opacity = 0\nfloat inputs:ior = 1.5";
    let clear = "float inputs:transmission_weight = 1\nfloat inputs:specular_roughness = 0\n";
    let tint = "color3f inputs:transmission_color = (0.5, 0.5, 0.5)\nfloat inputs:transmission_depth";
    let open_pbr = "ND_open_pbr_surface_surfaceshader";
    for (kind, inputs, want) in [
        ("UsdPreviewSurface", preview, Some("is how others write glass")),
        ("UsdPreviewSurface", "float inputs:opacity = 1\nfloat inputs:ior = 1.5", None),
        ("ND_gltf_pbr_surfaceshader", "float inputs:transmission = 1", None),
        ("ND_gltf_pbr_surfaceshader", "float inputs:transmission = 0", None),
        (open_pbr, clear, None),
        (
            open_pbr,
            "float inputs:transmission_weight = 1",
            Some("`specular_roughness` of a surface that transmits is not said: polished, not 0.3"),
        ),
        (
            "ND_standard_surface_surfaceshader",
            "float inputs:transmission = 1",
            Some("`specular_roughness` of a surface that transmits is not said: polished, not 0.2"),
        ),
        (open_pbr, &format!("{clear}{tint} = 0"), Some("a `transmission_color` that tints surfaces")),
        (open_pbr, &format!("{clear}{tint} = 2"), None),
        (open_pbr, &format!("{clear}bool inputs:geometry_thin_walled = 1\n{tint} = 2"), Some("that tints surfaces")),
    ] {
        let found = surface(kind, inputs);
        // Nothing stands on this stage but the material.
        let of_material = |note: &&eyebox_scene::Note| {
            note.severity == eyebox_scene::Severity::Warning && note.code != Some(eyebox_base::Code::NothingToTrace)
        };
        let warnings: Vec<_> = found.notes.iter().filter(of_material).collect();
        match want {
            Some(want) => assert!(warnings.len() == 1 && warnings[0].text.contains(want), "{inputs}: {warnings:?}"),
            None => assert!(warnings.is_empty(), "{inputs}: {warnings:?}"),
        }
    }
}

#[test]
fn connections_are_followed_through_graphs() {
    let text = r#"
def Material "M" {
    float inputs:index = 1.75
    token outputs:mtlx:surface.connect = </M/G.outputs:out>
    def NodeGraph "G" {
        float inputs:index.connect = </M.inputs:index>
        token outputs:out.connect = </M/G/S.outputs:out>
        def Shader "S" {
            uniform token info:id = "ND_open_pbr_surface_surfaceshader"
            float inputs:specular_ior.connect = </M/G.inputs:index>
            float inputs:transmission_weight.connect = </M/G/one.outputs:out>
            bool inputs:geometry_thin_walled = 1
            color3f inputs:base_color.connect = </M/G/tex.outputs:out>
            float inputs:specular_roughness.connect = </M/G/S.inputs:specular_roughness>
            float inputs:base_metalness = 0.5
            float inputs:base_metalness.connect = </M/nowhere.outputs:out>
            token outputs:out
        }
        def Shader "one" {
            uniform token info:id = "ND_constant_float"
            float inputs:value = 1
            float outputs:out
        }
        def Shader "tex" {
            uniform token info:id = "ND_image_color3"
            asset inputs:file = @a.png@
            color3f outputs:out
        }
    }
}
"#;
    let found = assembly(text);
    let material = &found.materials[0];
    assert_eq!(said(&material.mapped), ["ior = 1.75", "transmission = 1"]);
    assert_eq!(said(&material.looks), ["metallic = 0.5"]);
    let notes = notes(&found);
    let picture = material.surface.as_ref().and_then(|surface| surface.base_color.texture.as_ref()).unwrap();
    assert_eq!((picture.texture.name.as_str(), picture.encoding), ("a.png", Encoding::OfFile));
    assert!(notes.contains("go round"), "{notes}");
}

#[test]
fn attributes_stand_on_materials() {
    let found = assembly("def Material \"M\" {\n token eyebox:finish = \"absorbing\"\n}\n");
    assert_eq!(found.materials[0].attributes.as_ref().unwrap().to_string(), "{ finish = \"absorbing\" }");
}

/// A mark is believed as long as the shader says the same.
#[test]
fn marks_give_way_to_edits() {
    let text = |ior: &str| {
        format!(
            r#"
def Material "M" (
    customData = {{
        dictionary eyebox = {{
            string mapped = '[["ior",1.1],["thickness",0.3]]'
        }}
    }}
) {{
    token outputs:surface.connect = </M/S.outputs:surface>
    def Shader "S" {{
        uniform token info:id = "UsdPreviewSurface"
        {ior}
        token outputs:surface
    }}
}}
"#
        )
    };
    for (ior, want) in [
        ("float inputs:ior = 1.1", &["ior = 1.1", "thickness = 0.3"][..]),
        ("float inputs:ior = 1.25", &["ior = 1.25", "thickness = 0.3"]),
        ("", &["thickness = 0.3"]),
    ] {
        assert_eq!(said(&assembly(&text(ior)).materials[0].mapped), want);
    }
}

/// UsdUVTexture, UsdTransform2d and UsdPreviewSurface 2.6: t runs up from the bottom row; scaled, turned against the clock,
/// moved.
#[test]
fn preview_surfaces_look_as_they_say() {
    let text = r#"
def Material "M" {
    token outputs:surface.connect = </M/S.outputs:surface>
    def Shader "S" {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor.connect = </M/colour.outputs:rgb>
        float inputs:roughness.connect = </M/rest.outputs:g>
        float inputs:opacity.connect = </M/colour.outputs:a>
        float inputs:opacityThreshold = 0.25
        float inputs:metallic = 0.5
        float inputs:clearcoat = 1
        normal3f inputs:normal.connect = </M/bumps.outputs:rgb>
        token outputs:surface
    }
    def Shader "colour" {
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @wood.png@
        float2 inputs:st.connect = </M/moved.outputs:result>
        token inputs:wrapS = "mirror"
        token inputs:wrapT = "repeat"
        float4 inputs:scale = (0.5, 1, 1, 1)
    }
    def Shader "moved" {
        uniform token info:id = "UsdTransform2d"
        float2 inputs:in.connect = </M/st.outputs:result>
        float2 inputs:scale = (2, 3)
        float inputs:rotation = 90
        float2 inputs:translation = (0.25, 0.5)
    }
    def Shader "st" {
        uniform token info:id = "UsdPrimvarReader_float2"
        string inputs:varname = "st"
    }
    def Shader "rest" {
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @rest.png@
        float2 inputs:st.connect = </M/st.outputs:result>
        token inputs:sourceColorSpace = "raw"
    }
    def Shader "bumps" {
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @bumps.png@
        float4 inputs:scale = (2, 2, 2, 1)
        float4 inputs:bias = (-1, -1, -1, 0)
        token inputs:sourceColorSpace = "raw"
    }
}
"#;
    let found = assembly(text);
    let surface = found.materials[0].surface.as_ref().unwrap();
    let colour = surface.base_color.texture.as_ref().unwrap();
    assert_eq!(
        (colour.wrap, colour.encoding, colour.scale),
        ([Wrap::Mirror, Wrap::Repeat], Encoding::OfFile, [0.5, 1.0, 1.0, 1.0])
    );
    // (u, v) → (2u, 3v) → (−3v, 2u) → (0.25 − 3v, 0.5 + 2u), and from the top: 1 − (0.5 + 2u).
    let place = |u: f64, v: f64| colour.to_picture.map(|[a, b, c]| a * u + b * v + c);
    for (u, v) in [(0.0, 0.0), (1.0, 0.0), (0.3, 0.8)] {
        let [s, t] = place(u, v);
        assert!((s - (0.25 - 3.0 * v)).abs() < 1e-12 && (t - (0.5 - 2.0 * u)).abs() < 1e-12, "{s} {t}");
    }
    let (rest, channel) = surface.roughness.texture.as_ref().unwrap();
    assert_eq!(
        (rest.to_picture, *channel, rest.encoding),
        ([[1.0, 0.0, 0.0], [0.0, -1.0, 1.0]], Channel::Green, Encoding::Linear)
    );
    assert_eq!((surface.metallic.factor, surface.coat.factor, surface.ior), (0.5, 1.0, 1.5));
    let Opacity::Mask { alpha, cutoff } = &surface.opacity else { panic!("{:?}", surface.opacity) };
    assert_eq!((alpha.texture.as_ref().unwrap().1, *cutoff), (Channel::Alpha, 0.25));
    let (bumps, strength) = surface.normal.as_ref().unwrap();
    assert_eq!((bumps.scale, bumps.bias, *strength), ([2.0, 2.0, 2.0, 1.0], [-1.0, -1.0, -1.0, 0.0], 1.0));
    assert!(!notes(&found).contains("not used"), "{}", notes(&found));
}
