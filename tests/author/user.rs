//! What authors say beside the format comes out as it went in: custom attributes of USD with their types, `extras` of glTF, and from one
//! to the other in the places where other programs show it.

use super::cameras::convert;
use serde_json::{Value, json};

/// Lines of properties that an author has said, and that no reader of ours knows.
const SAID: [&str; 12] = [
    "custom string userProperties:shot = \"A010\"",
    "custom int userProperties:take = 3",
    "custom double userProperties:weight = 2.5",
    "custom bool userProperties:approved = true",
    "custom float3 userProperties:pivot = (1, 2.5, -3)",
    "custom double[] userProperties:levels = [0.5, 1, 2]",
    "custom string userProperties:odd:name = \"a\\\"b\"",
    "custom token studio:state = \"final\"",
    "custom color3f tint = (0.25, 0.5, 1)",
    "custom int[] ids = [1, 2, 3]",
    "custom asset[] userProperties:unknown = [@a.png@]",
    "custom float gain = 0.1",
];

fn stage() -> String {
    let said = SAID.map(|line| format!("    {line}\n")).concat();
    format!(
        "#usda 1.0\n(\n    defaultPrim = \"w\"\n    metersPerUnit = 1\n    upAxis = \"Y\"\n)\ndef Xform \"w\"\n{{\n{said}\
         def Scope \"empty\" {{ custom string userProperties:why = \"a mark\" }}\n\
         def Sphere \"s\" {{ rel material:binding = </w/m>\n custom string userProperties:owner = \"optics\" }}\n\
         def Material \"m\" {{ custom string userProperties:supplier = \"X\"\n\
         token outputs:surface.connect = </w/m/s.outputs:surface>\n\
         def Shader \"s\" {{ uniform token info:id = \"UsdPreviewSurface\"\n token outputs:surface }} }}\n}}\n"
    )
}

#[test]
fn custom_attributes_of_usd_stay() {
    let place = tempfile::tempdir().unwrap();
    std::fs::write(place.path().join("in.usda"), stage()).unwrap();
    let once = convert(place.path(), "in.usda", "out.usda");
    convert(place.path(), "out.usda", "binary.usdc");
    let again = convert(place.path(), "binary.usdc", "again.usda");
    for (name, text) in [("once", &once), ("by way of a crate", &again)] {
        for line in SAID.iter().filter(|line| !line.contains("asset[]")) {
            assert!(text.contains(line), "{name}: no {line} in\n{text}");
        }
        for line in ["userProperties:why = \"a mark\"", "userProperties:owner = \"optics\"", "userProperties:supplier = \"X\""] {
            assert!(text.contains(line), "{name}: no {line} in\n{text}");
        }
        // Each once, and nothing that a schema declares.
        assert_eq!(text.matches("custom ").count(), SAID.len() - 1 + 3, "{text}");
    }
}

#[test]
fn what_is_not_kept_is_told() {
    let place = tempfile::tempdir().unwrap();
    let [from, to] = ["in.usda", "out.usda"].map(|name| place.path().join(name));
    std::fs::write(&from, stage()).unwrap();
    let (_, out, errors) = super::kit::eyebox(&[std::path::Path::new("convert"), &from, &to]);
    let said = out + &errors;
    assert!(said.contains("userProperties:unknown") && said.contains("not kept"), "{said}");
}

#[test]
fn extras_of_gltf_stay() {
    let place = tempfile::tempdir().unwrap();
    let extras = json!({
        "shot": "A010", "take": 3, "weight": 2.5, "whole": 4.0, "approved": true, "none": null, "large": 5_000_000_000_i64,
        "levels": [0.5, 1.0], "ids": [1, 2], "mixed": [1, "a", { "b": [] }], "table": { "x": { "y": -1 } },
        "with space, ü and :": "odd", "empty": []
    });
    let gltf = json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": "c", "camera": 0, "extras": extras }],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 },
                      "extras": { "operator": "B", "take": 9 } }],
        "materials": [{ "name": "m", "extras": { "supplier": "X" } }]
    });
    std::fs::write(place.path().join("in.gltf"), gltf.to_string()).unwrap();
    let direct = convert(place.path(), "in.gltf", "out.gltf");
    let usd = convert(place.path(), "in.gltf", "way.usda");
    for line in ["custom string userProperties:shot = \"A010\"", "custom int userProperties:take = 3"] {
        assert!(usd.contains(line), "no {line} in\n{usd}");
    }
    let way = convert(place.path(), "way.usda", "back.gltf");
    let mut want = extras;
    // The camera's, which has no node of its own; the node has said `take` itself.
    want["operator"] = json!("B");
    for (name, text) in [("once", direct), ("by way of USD", way)] {
        let found: Value = serde_json::from_str(&text).unwrap();
        let node = found["nodes"].as_array().unwrap().iter().find(|node| node["name"] == "c").unwrap();
        assert_eq!(node["extras"], want, "{name}");
        assert_eq!(found["materials"][0]["extras"], json!({ "supplier": "X" }), "{name}");
    }
}
