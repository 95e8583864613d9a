//! Broken assets in small number: always a result or a fault. `benches/hostile.rs` does the same to whole corpora.

use crate::common::mutate;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// A triangle with a light, a camera, a film and instances, its buffer inside.
const SMALL: &str = r#"{
  "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0, 1] }],
  "nodes": [
    { "name": "T", "mesh": 0, "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0.5,0,0,1],
      "extensions": { "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": 0 } } } },
    { "camera": 0, "rotation": [0, 0, 0, 1], "extensions": { "KHR_lights_punctual": { "light": 0 } } }
  ],
  "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.8, "znear": 0.1 } }],
  "extensions": { "KHR_lights_punctual": { "lights": [
    { "type": "spot", "intensity": 20, "range": 5, "spot": { "outerConeAngle": 0.4 } }] } },
  "materials": [{ "emissiveFactor": [1, 0.5, 0], "extensions": {
    "KHR_materials_ior": { "ior": 1.49 }, "KHR_materials_transmission": { "transmissionFactor": 1 },
    "KHR_materials_iridescence": { "iridescenceFactor": 1, "iridescenceIor": 1.38 },
    "EYEBOX_optics": { "finish": "polished" } } }],
  "meshes": [{ "primitives": [
    { "attributes": { "POSITION": 0, "NORMAL": 1 }, "indices": 2, "material": 0 },
    { "attributes": { "POSITION": 0 }, "mode": 5 }] }],
  "accessors": [
    { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
      "sparse": { "count": 1, "indices": { "bufferView": 2, "componentType": 5123 }, "values": { "bufferView": 1 } } },
    { "bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3" },
    { "bufferView": 2, "componentType": 5123, "count": 3, "type": "SCALAR" }],
  "bufferViews": [
    { "buffer": 0, "byteLength": 36 }, { "buffer": 0, "byteOffset": 36, "byteLength": 36 },
    { "buffer": 0, "byteOffset": 72, "byteLength": 6 }],
  "buffers": [{ "byteLength": 78, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/AAABAAIA" }]
}"#;

#[test]
fn broken_assets_end_in_a_result_or_a_fault() {
    let sample = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples/hud-direct/hud_direct.glb");
    let glb = std::fs::read(&sample).expect("the sample");
    let assets: [(PathBuf, &[u8], u64); 2] = [("small.gltf".into(), SMALL.as_bytes(), 800), (sample, &glb, 60)];
    for (file, bytes, rounds) in assets {
        eyebox::import::gltf::read_bytes(&file, bytes, &eyebox::import::ReadOptions::default())
            .expect("sound before it is broken");
        let mut opened = 0;
        for seed in 0..rounds {
            let start = Instant::now();
            opened += u64::from(
                eyebox::import::gltf::read_bytes(
                    &file,
                    &mutate::mutated(bytes, seed),
                    &eyebox::import::ReadOptions::default(),
                )
                .is_ok(),
            );
            assert!(start.elapsed() < Duration::from_secs(20), "{} broken with seed {seed} hangs", file.display());
        }
        // Most of a large file is coordinates, which may be anything; of the small one most is structure.
        assert!(opened < rounds, "{} of {rounds} opened", opened);
    }
}
