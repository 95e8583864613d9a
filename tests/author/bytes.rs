//! `annotate` changes what it must and no other byte.

use super::kit::{clean, sample};
use std::path::Path;

/// A triangle, written as no program would.
const ODD: &str = "{ \"asset\" : {\"version\":\"2.0\" , \"generator\":\"by h\\u0061nd\"},\r\n\t\"nodes\":[ { \"name\":\"T\",\"mesh\":0 ,\"translation\":[1.50,0e0, -0.0]} ]\n,\
  \"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}] } ],\"unknown\" : [1E+2,{\"x\":null} ],\n\
  \"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],\
  \"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"buffers\":[{\"byteLength\":36,\"uri\":\"tri%20angle.bin\"}] }\n";

const SIDECAR: &str =
    "schema = 1\n[[bind]]\nname = \"T\"\nfinish = \"absorber\"\nemitter = { group = \"g\", flux_lm = 0.1 }\n";

/// Writes the triangle into `folder`.
fn triangle(folder: &Path) {
    let corners: [f32; 9] = [0., 0., 0., 1., 0., 0., 0., 1., 0.];
    let bytes: Vec<u8> = corners.iter().flat_map(|x| x.to_le_bytes()).collect();
    std::fs::write(folder.join("tri angle.bin"), bytes).expect("a file");
    std::fs::write(folder.join("odd.gltf"), ODD).expect("a file");
    std::fs::write(folder.join("empty.optics.toml"), "schema = 1\nasset = \"odd.gltf\"\n").expect("a file");
    std::fs::write(folder.join("t.optics.toml"), SIDECAR).expect("a file");
}

#[test]
fn an_empty_sidecar_changes_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    triangle(folder.path());
    let at = |file: &str| folder.path().join(file).to_str().expect("UTF-8").to_owned();
    let glb = sample("hud-direct/hud_direct.glb");
    let original = std::fs::read(&glb).expect("the sample");
    // A chunk that nobody knows, and bytes after the end.
    let mut more = original.clone();
    more.extend([4, 0, 0, 0]);
    more.extend(b"XYZW1234");
    let length = more.len() as u32;
    more[8..12].copy_from_slice(&length.to_le_bytes());
    more.extend(b"after");
    for (name, bytes) in [("a.glb", &original), ("b.glb", &more)] {
        std::fs::write(at(name), bytes).expect("a file");
        let out = at(&format!("out_{name}"));
        clean(&["annotate", &at(name), "--optics", &at("empty.optics.toml"), "-o", &out]);
        assert!(std::fs::read(&out).expect("it was written") == *bytes, "{name}");
    }
    clean(&["annotate", &at("odd.gltf"), "--optics", &at("empty.optics.toml"), "-o", &at("out.gltf")]);
    assert_eq!(std::fs::read_to_string(at("out.gltf")).expect("it was written"), ODD);
    // Rows change the JSON chunk; the others stay.
    clean(&[
        "annotate",
        &at("b.glb"),
        "--optics",
        sample("hud-direct/hud.optics.toml").to_str().expect("UTF-8"),
        "-o",
        &at("c.glb"),
    ]);
    let annotated = std::fs::read(at("c.glb")).expect("it was written");
    let json = |bytes: &[u8]| u32::from_le_bytes(bytes[12..16].try_into().expect("four")) as usize;
    assert!(annotated[20 + json(&annotated)..] == more[20 + json(&more)..], "the other chunks");
    let claimed = u32::from_le_bytes(annotated[8..12].try_into().expect("four")) as usize;
    assert_eq!(claimed + 5, annotated.len());
}

#[test]
fn rows_are_put_between_bytes_that_stay() {
    let folder = tempfile::tempdir().expect("a folder");
    triangle(folder.path());
    std::fs::create_dir(folder.path().join("sub dir")).expect("a folder");
    let at = |file: &str| folder.path().join(file).to_str().expect("UTF-8").to_owned();
    clean(&["annotate", &at("odd.gltf"), "--optics", &at("t.optics.toml"), "-o", &at("out.gltf")]);
    let node = ",\"extensions\":{\"EYEBOX_optics\":{\"finish\":\"absorber\",\"emitter\":0}}";
    let root = ",\"extensions\":{\"EYEBOX_optics\":{\"version\":1,\"emitters\":[{\"group\":\"g\",\"flux_lm\":0.1}]}},\"extensionsUsed\":[\"EYEBOX_optics\"]";
    let wanted = ODD.replace("-0.0]", &format!("-0.0]{node}")).replace(".bin\"}]", &format!(".bin\"}}]{root}"));
    assert_eq!(std::fs::read_to_string(at("out.gltf")).expect("it was written"), wanted);
    // Annotated again, the extension is not listed twice, and nothing changes.
    clean(&["annotate", &at("out.gltf"), "--optics", &at("t.optics.toml"), "-o", &at("again.gltf")]);
    assert_eq!(std::fs::read_to_string(at("again.gltf")).expect("it was written"), wanted);
    // Another folder: the buffer is found from there.
    clean(&["annotate", &at("odd.gltf"), "--optics", &at("empty.optics.toml"), "-o", &at("sub dir/out.gltf")]);
    let moved = std::fs::read_to_string(at("sub dir/out.gltf")).expect("it was written");
    assert_eq!(moved, ODD.replace("\"tri%20", "\"../tri%20"));
    assert!(eyebox::import::asset(at("sub dir/out.gltf").as_ref()).is_ok());
}
