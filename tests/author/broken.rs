//! Broken assets and wrong requests end in a message.

use super::kit::{eyebox, sample};
use eyebox::import::{annotate, asset, toml};
use std::path::Path;

const SIDECAR: &str = "schema = 1\n[default]\nfinish = \"absorber\"\n[[bind]]\nname = \"T\"\nior = 1.5\n";

#[test]
fn every_truncation_and_many_flips_end_in_a_message_or_an_asset() {
    let folder = tempfile::tempdir().expect("a folder");
    let (file, out) = (folder.path().join("a.glb"), folder.path().join("b.glb"));
    let sidecar = toml::parse(SIDECAR, Path::new("a.optics.toml")).expect("TOML");
    let json = "{\"asset\":{\"version\":\"2.0\"},\"extensions\":{\"EYEBOX_optics\":{\"version\":1,\"coatings\":[{\"name\":\"a\",\"stack\":[{\"n\":2,\"thickness_nm\":5}]}]}},\
         \"nodes\":[{\"name\":\"T\",\"mesh\":0,\"extensions\":{\"EYEBOX_optics\":{\"finish\":\"polished\",\"coating\":0}}}],\
         \"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\
         \"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],\
         \"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"buffers\":[{\"byteLength\":36}]}";
    let mut text = json.as_bytes().to_vec();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut glb = b"glTF".to_vec();
    for word in [2, 28 + text.len() as u32 + 36, text.len() as u32] {
        glb.extend(word.to_le_bytes());
    }
    glb.extend(b"JSON");
    glb.extend(text);
    glb.extend(36u32.to_le_bytes());
    glb.extend(b"BIN\0");
    glb.extend([0f32, 0., 0., 1., 0., 0., 0., 1., 0.].iter().flat_map(|x| x.to_le_bytes()));
    let attempt = |bytes: &[u8]| {
        std::fs::write(&file, bytes).expect("a file");
        let Ok(assembly) = asset(&file) else { return false };
        let annotation = annotate(&assembly, Some(&sidecar), folder.path());
        let written = annotation.and_then(|annotation| eyebox::author::annotate(&assembly, &annotation, &out));
        if written.is_ok() {
            let again = asset(&out);
            assert!(again.is_ok(), "{:?}", again.err());
        }
        eyebox::author::convert(&assembly, &folder.path().join("c.gltf")).is_ok() && written.is_ok()
    };
    assert!(attempt(&glb), "the asset itself is sound");
    for length in 0..glb.len() {
        attempt(&glb[..length]);
    }
    let mut state = 12345u64;
    let mut sound = 0;
    for _ in 0..600 {
        let mut bytes = glb.clone();
        for _ in 0..2 {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            let place = (state >> 33) as usize % bytes.len();
            bytes[place] ^= 1 << (state >> 20 & 7);
        }
        sound += usize::from(attempt(&bytes));
    }
    assert!(sound > 0, "some flips only change names");
}

#[test]
fn wrong_requests_say_what_is_wrong() {
    let folder = tempfile::tempdir().expect("a folder");
    let (asset, sidecar) = (sample("hud-direct/hud_direct.glb"), sample("hud-direct/hud.optics.toml"));
    let out = |name: &str| folder.path().join(name);
    let wrong = out("wrong.optics.toml");
    std::fs::write(&wrong, "schema = 1\n[[bind]]\npath = \"LENS_*\"\nfinish = \"polishd\"\n").expect("a file");
    for (sidecar, to, expected) in [
        (&sidecar, out("a.gltf"), "a name that ends in .glb"),
        (&sidecar, out("a.exr"), "no format that can be written; expected .glb, .gltf"),
        (&sidecar, out("none/a.glb"), "expected an existing directory"),
        (&sidecar, folder.path().to_owned(), "is a folder"),
        (&wrong, out("a.glb"), "wrong.optics.toml:4: unknown finish `polishd`"),
    ] {
        let option = Path::new("--optics");
        let (code, _, errors) = eyebox(&[Path::new("annotate"), &asset, option, sidecar, Path::new("-o"), &to]);
        assert_eq!(code, Some(2));
        assert!(errors.contains(expected) && errors.lines().count() == 1, "{errors}");
        assert!(!to.is_file());
    }
    let (code, _, errors) = eyebox(&[Path::new("convert"), &asset, &out("a.obj")]);
    assert!(code == Some(2) && errors.contains("no format that can be written"), "{errors}");
}
