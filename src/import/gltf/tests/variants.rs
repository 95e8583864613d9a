//! `KHR_materials_variants`, chosen by name.

use crate::gltf::testing::Builder;
use crate::{ReadOptions, VariantChoice};
use serde_json::json;

/// A square whose own material is 0; 1 in the variants `street` and `night`, none of its own in `beach`.
fn shoe() -> Builder {
    let mut builder = Builder::square();
    builder.json["materials"] = json!([{ "name": "plain" }, { "name": "dark" }]);
    builder.json["extensions"] = json!({ "KHR_materials_variants": { "variants": [{ "name": "beach" }, { "name": "street" }, { "name": "night" }] } });
    let primitive = &mut builder.json["meshes"][0]["primitives"][0];
    primitive["material"] = json!(0);
    primitive["extensions"] =
        json!({ "KHR_materials_variants": { "mappings": [{ "material": 1, "variants": [1, 2] }] } });
    builder
}

fn options(choices: &[&str]) -> ReadOptions {
    let variants = choices.iter().map(|text| VariantChoice::parse(text).unwrap()).collect();
    ReadOptions { variants, ..ReadOptions::default() }
}

#[test]
fn a_variant_brings_its_materials() {
    let builder = shoe();
    for (choices, material) in
        [(&[][..], 0), (&["beach"], 0), (&["street"], 1), (&["night"], 1), (&["street", "beach"], 0)]
    {
        let found = builder.read_at(&options(choices)).unwrap();
        assert_eq!(found.meshes[0].materials, [Some(material)], "{choices:?}");
        assert_eq!(found.variants, choices);
        let told = found.notes.iter().any(|note| note.text.contains("beach, street, night"));
        assert_eq!(told, choices.is_empty());
    }
}

#[test]
fn what_is_no_variant_is_said() {
    let fault = |builder: &Builder, choice: &str| builder.read_at(&options(&[choice])).unwrap_err().to_string();
    let missing = fault(&shoe(), "nigth");
    assert!(missing.contains("--variant nigth") && missing.contains("did you mean `night`?"), "{missing}");
    assert!(fault(&shoe(), "/a{b=c}").contains("prims of USD"));
    assert!(fault(&Builder::square(), "night").contains("no variants"));
    let mut wild = shoe();
    wild.json["meshes"][0]["primitives"][0]["extensions"]["KHR_materials_variants"]["mappings"][0]["material"] =
        json!(7);
    assert!(
        fault(&wild, "night").contains("/meshes/0/primitives/0/extensions/KHR_materials_variants/mappings/0/material")
    );
    // Nobody asked for it.
    assert!(wild.read_at(&ReadOptions::default()).is_ok());
}
