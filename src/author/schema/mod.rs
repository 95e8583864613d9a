//! The schemas in `schemas/`, generated from the attribute table. `tests/schemas.rs` fails when a file there is stale.

mod face; // which attributes stand together
mod gltf; // glTF vendor extension
mod json; // a row as JSON Schema
mod readme; // the extension's specification
mod sidecar; // TOML sidecars
mod usd; // codeless applied API schemas

/// Every generated file: its path below the repository's root, with `/`, and its text.
pub fn files() -> Vec<(String, String)> {
    let mut all = gltf::files();
    all.push(("schemas/gltf/EYEBOX_optics/README.md".to_owned(), readme::text()));
    all.push(("schemas/sidecar.schema.json".to_owned(), sidecar::text()));
    all.extend(usd::files());
    all
}
