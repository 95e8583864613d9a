//! Both HUDs through `annotate` and `convert`: the same scenes, the same pictures.

use super::kit::{clean, picture, same, sample, scene};

#[test]
fn both_huds_annotated_and_converted_are_the_same_to_the_last_bit() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, asset) in [("hud-direct", "hud_direct.glb"), ("hud-diffuse", "hud_diffuse.glb")] {
        let at = |file: &str| folder.path().join(format!("{name}{file}")).to_str().expect("UTF-8").to_owned();
        let path = |file: &str| sample(&format!("{name}/{file}")).to_str().expect("UTF-8").to_owned();
        clean(&["annotate", &path(asset), "--optics", &path("hud.optics.toml"), "-o", &at("_annotated.glb")]);
        clean(&["convert", &path("hud.optics.toml"), &at("_from_sidecar.glb")]);
        clean(&["convert", &at("_annotated.glb"), &at("_text.gltf")]);
        clean(&["convert", &at("_text.gltf"), &at("_again.glb")]);
        let wanted = scene(sample(name).join("hud.optics.toml").as_path());
        let pixels = picture(&wanted);
        assert!(pixels.iter().any(|(mean, _)| *mean != 0), "something is seen");
        for file in ["_annotated.glb", "_from_sidecar.glb", "_text.gltf", "_again.glb"] {
            let found = scene(at(file).as_ref());
            same(&wanted, &found, file);
            assert!(picture(&found) == pixels, "{name}{file}: another picture");
        }
        // Written again and again it is the same to the last byte (the node of the units has the asset's name).
        let bytes = |file: &str| std::fs::read(at(file)).expect("it was written");
        for turn in ["_1", "_2", "_3"] {
            std::fs::create_dir(at(turn)).expect("a folder");
        }
        clean(&["convert", &path("hud.optics.toml"), &at(&format!("_1/{asset}"))]);
        clean(&["convert", &at(&format!("_1/{asset}")), &at(&format!("_2/{asset}"))]);
        clean(&["convert", &at(&format!("_2/{asset}")), &at(&format!("_3/{asset}"))]);
        assert!(bytes(&format!("_1/{asset}")) == bytes(&format!("_2/{asset}")), "{name}");
        assert!(bytes(&format!("_2/{asset}")) == bytes(&format!("_3/{asset}")), "{name}");
        let size = std::fs::metadata(path(asset)).expect("the sample").len();
        assert!((bytes("_annotated.glb").len() as u64) < size + 40_000, "rows, not geometry");
    }
}
