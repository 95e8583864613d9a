//! Lights, films and looks.

use crate::Assembly;
use crate::assembly::LightForm;
use crate::assembly::{LightProfile, ProfileSource};
use crate::gltf::testing::Builder;
use crate::value::Value;
use eyebox_base::error::Result;
use eyebox_scene::Severity;
use eyebox_scene::texture::Channel;
use serde_json::{Value as Json, json};

fn lit(light: Json) -> Result<Assembly> {
    let mut builder = Builder::square();
    builder.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
    builder.push("nodes", json!({ "name": "LAMP", "extensions": { "KHR_lights_punctual": { "light": 0 } } }));
    builder.read()
}

#[test]
fn punctual_lights_in_candela_and_lux() {
    let spot = lit(json!({
        "type": "spot", "name": "SPOT", "intensity": 40, "color": [0.5, 0.5, 0.5], "range": 3,
        "spot": { "innerConeAngle": 0.1, "outerConeAngle": 0.2 },
    }));
    let spot = spot.unwrap();
    let light = &spot.lights[0];
    assert_eq!((light.name.as_str(), light.node, spot.nodes[light.node].name.as_str()), ("SPOT", 1, "LAMP"));
    let LightForm::Point { intensity_cd, cone } = light.form else { panic!("{:?}", light.form) };
    assert!((intensity_cd - 20.0).abs() < 1e-12 && cone == Some((0.1, 0.2)));
    assert!(light.color.iter().all(|lane| (lane - 1.0).abs() < 1e-12), "{:?}", light.color);
    assert!(spot.notes.iter().any(|note| note.text.contains("`range`") && note.severity == Severity::Info));

    let red = &lit(json!({ "type": "directional", "intensity": 10, "color": [1, 0, 0] })).unwrap().lights[0];
    let LightForm::Distant { illuminance_lx, angle } = red.form else { panic!("{:?}", red.form) };
    assert!((illuminance_lx - 2.126_390_058_715_103_6).abs() < 1e-12 && angle == 0.0);
    assert!((red.color[0] - 1.0 / 0.212_639_005_871_510_36).abs() < 1e-12 && red.name == "LAMP");

    let default = &lit(json!({ "type": "spot", "spot": {} })).unwrap().lights[0];
    let quarter = std::f64::consts::FRAC_PI_4;
    assert_eq!(default.form, LightForm::Point { intensity_cd: 1.0, cone: Some((0.0, quarter)) });

    for (light, what) in [
        (json!({ "type": "spott" }), "did you mean `spot`?"),
        (json!({ "type": "point", "intensity": -1 }), "out of range"),
        (json!({ "type": "spot" }), "`spot` is missing"),
        (json!({ "type": "spot", "spot": { "innerConeAngle": 1 } }), "inner cone"),
        (json!({ "type": "point", "color": [1, 1] }), "2 numbers"),
    ] {
        let fault = lit(light.clone()).unwrap_err().to_string();
        assert!(fault.contains(what), "{light}: {fault}");
    }
}

#[test]
fn ies_lights_name_their_file() {
    let mut builder = Builder::square();
    builder.json["extensions"] =
        json!({ "EXT_lights_ies": { "lights": [{ "uri": "lamp%201.ies", "mimeType": "application/x-ies-lm-63" }] } });
    builder.json["nodes"][0]["extensions"] = json!({ "EXT_lights_ies": { "light": 0, "multiplier": 2 } });
    let assembly = builder.read().unwrap();
    let light = &assembly.lights[0];
    assert_eq!(light.profile, Some(LightProfile::of(ProfileSource::File("lamp 1.ies".into()), 2.0)));
    assert_eq!(light.form, LightForm::Point { intensity_cd: 2.0, cone: None });
    builder.json["nodes"][0]["extensions"]["EXT_lights_ies"]["light"] = json!(1);
    assert!(builder.read().unwrap_err().what.contains("light 1 does not exist"));
}

/// In a data: URI and in a buffer view: the profile shines, (0, 0) along −z of its node.
#[test]
fn ies_lights_may_be_inside_the_asset() {
    let text = "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 5\n0 90\n0\n8 2\n";
    let uri = format!("data:application/x-ies-lm-63,{}", text.replace('\n', "%0A").replace(' ', "%20"));
    let mut builder = Builder::square();
    builder.json["extensions"] = json!({ "EXT_lights_ies": { "lights": [{ "uri": uri }] } });
    builder.json["nodes"][0]["extensions"] = json!({ "EXT_lights_ies": { "light": 0, "multiplier": 2 } });
    let assembly = builder.read().unwrap();
    let profile = assembly.lights[0].profile.as_ref().unwrap();
    assert_eq!(profile.source, ProfileSource::Embedded(std::sync::Arc::new(text.as_bytes().to_vec())));
    assert_eq!(profile.factor, 2.0);
    builder.json["extensions"] =
        json!({ "EXT_lights_ies": { "lights": [{ "bufferView": 0, "mimeType": "application/x-ies-lm-63" }] } });
    let assembly = builder.read().unwrap();
    assert!(matches!(assembly.lights[0].profile.as_ref().unwrap().source, ProfileSource::Embedded(_)));
    builder.json["extensions"] = json!({ "EXT_lights_ies": { "lights": [{ "name": "x" }] } });
    assert!(builder.read().unwrap_err().what.contains("without data"));
}

fn mapped(material: Json) -> (Vec<String>, Vec<String>, Vec<String>) {
    let mut builder = Builder::square();
    builder.push("materials", material);
    let mut assembly = builder.read().unwrap();
    let material = assembly.materials.remove(0);
    let rows = |rows: &[(String, Value)]| rows.iter().map(|(key, value)| format!("{key} = {value}")).collect();
    let notes = assembly.notes.iter().map(|note| note.text.clone()).collect();
    (rows(&material.mapped), rows(&material.looks), notes)
}

#[test]
fn iridescence_is_one_film() {
    let film = |fields: Json| mapped(json!({ "extensions": { "KHR_materials_iridescence": fields } }));
    let stack = |n: f64, nm: f64| {
        format!("coating = {{ name = \"iridescence\", stack = [{{ n = {n}, thickness_nm = {nm} }}] }}")
    };
    assert_eq!(film(json!({})).0, [] as [&str; 0], "the factor is 0 by default");
    assert_eq!(film(json!({ "iridescenceFactor": 1 })).0, [stack(1.3, 400.0)]);
    let full = json!({ "iridescenceFactor": 0.5, "iridescenceIor": 1.38, "iridescenceThicknessMinimum": 50,
        "iridescenceThicknessMaximum": 99.5, "iridescenceThicknessTexture": { "index": 0 } });
    let mut builder = Builder::square();
    builder.push("images", json!({ "uri": "t.png" }));
    builder.push("textures", json!({ "source": 0 }));
    builder.push("materials", json!({ "extensions": { "KHR_materials_iridescence": full } }));
    let material = builder.read().unwrap().materials.remove(0);
    // On glass it is a coating, as thick as it gets; an ordinary surface has all of it.
    assert_eq!(
        material.mapped.iter().map(|(key, value)| format!("{key} = {value}")).collect::<Vec<_>>(),
        [stack(1.38, 99.5)]
    );
    let film = material.surface.unwrap().film.clone().unwrap();
    let (input, channel) = film.thickness_nm.texture.unwrap();
    assert_eq!((film.weight.factor, film.ior, film.thickness_nm.factor), (0.5, 1.38, 1.0));
    assert_eq!((channel, channel.of(input.scale), channel.of(input.bias)), (Channel::Green, 49.5, 50.0));
}

/// Sheets are how a material looks.
#[test]
fn what_transmits() {
    let material = |transmission: f64, thickness: f64| {
        json!({
            "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.5, 0.5, 1], "roughnessFactor": 0.25, "metallicFactor": 0 },
            "extensions": {
                "KHR_materials_transmission": { "transmissionFactor": transmission },
                "KHR_materials_volume": { "thicknessFactor": thickness },
                "KHR_materials_diffuse_transmission": {
                    "diffuseTransmissionFactor": 0.25, "diffuseTransmissionColorFactor": [0.8, 0.8, 0.8] },
            },
        })
    };
    let mut builder = Builder::square();
    builder.push("materials", material(0.5, 0.0));
    let found = builder.read().unwrap().materials.remove(0);
    let surface = found.surface.unwrap();
    assert_eq!((surface.transmission.factor, surface.diffuse_transmission.factor), (0.5, 0.25));
    assert_eq!((surface.base_color.factor, surface.diffuse_transmission_color.factor), ([0.5; 3], [0.8; 3]));
    assert_eq!((surface.metallic.factor, surface.roughness.factor), (0.0, 0.25));
    let (rows, looks, _) = mapped(material(0.0, 0.0));
    assert!(!rows.iter().any(|row| row.starts_with("finish")), "{rows:?}");
    assert_eq!(looks, ["base_color = [0.5, 0.5, 0.5]", "metallic = 0", "roughness = 0.25"]);
}

#[test]
fn opacity_is_that_of_materials_that_are_not_opaque() {
    let look = |mode: &str| {
        mapped(json!({ "alphaMode": mode, "pbrMetallicRoughness": { "baseColorFactor": [1, 0, 0, 0.5] } })).1
    };
    assert_eq!(look("OPAQUE"), ["base_color = [1, 0, 0]"]);
    assert_eq!(look("BLEND"), ["base_color = [1, 0, 0]", "opacity = 0.5"]);
}

/// A glow has its hue; grey ones say nothing of it. Written and read back it is the same.
#[test]
fn emissive_materials_have_a_hue() {
    let glow = |factor: Json| {
        let mut builder = Builder::square();
        builder.push("materials", json!({ "name": "GLOW", "emissiveFactor": factor }));
        builder.json["meshes"][0]["primitives"][0]["material"] = json!(0);
        let read = builder.read().unwrap();
        read.materials[0].mapped.iter().map(|(key, value)| format!("{key} = {value}")).collect::<Vec<_>>()
    };
    assert_eq!(glow(json!([0.5, 0.5, 0.5])), ["luminance_cd_m2 = 0.5"]);
    let red = glow(json!([1, 0, 0]));
    assert_eq!(red[1..], ["emitter.spectrum = { rgb = [1, 0, 0] }"]);
}
