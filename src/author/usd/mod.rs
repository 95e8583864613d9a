//! USD: an [`Assembly`] as a `.usda`, `.usdc` or `.usdz` file.
//!
//! Every node is a prim with one `matrix4d` transform; its mesh is a prim of its own below it, with one GeomSubset for
//! each face. A mesh that several nodes use is a prototype that they refer to, instanceable. What USD has no place for
//! (names that are no identifiers, the exact numbers behind a shader's single precision) stands in
//! `customData["eyebox"]`, see [`stage`], and our reader takes it from there.

pub mod layer; // prims and values as data
pub mod name; // identifiers
pub mod text; // .usda

mod annotate; // rows as a layer over the asset
mod binary; // .usdc and .usdz
mod light; // lights and cameras
mod material; // materials and their bindings
mod mesh; // geometry and faces
mod optics; // attributes as properties
mod pack; // the files that a package holds
mod stage; // the hierarchy
#[cfg(test)]
mod tests;

pub use annotate::annotate;

use super::Written;
use crate::base::atomic::write_atomic;
use crate::base::fault::Result;
use crate::base::relative_path::folder_of;
use crate::base::{Fault, Where};
use crate::scene::assembly::Assembly;
use std::path::Path;

/// Writes `assembly` as the USD file `out`, whose extension says the kind.
///
/// # Errors
/// As [`encode`]; the file cannot be written.
pub fn write(assembly: &Assembly, out: &Path) -> Result<Written> {
    write_atomic(out, &encode(assembly, out)?)?;
    Ok(Written { files: vec![out.to_owned()], notes: Vec::new() })
}

/// The bytes of `assembly` as the USD file `path`, whose name says which kind; relative paths in it start from its folder.
///
/// # Errors
/// An assembly that contradicts itself (indices that lead nowhere, numbers that are not finite), attributes that the
/// vocabulary lacks, hierarchies deeper than USD readers take, files for a `.usdz` that cannot be read, another file name extension.
pub fn encode(assembly: &Assembly, path: &Path) -> Result<Vec<u8>> {
    let kind = Kind::of(path)?;
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let layer = stage::layer(assembly, &name::identifier(&stem, "Asset"), &folder_of(path))?;
    bytes(layer, kind, path)
}

/// The kinds of USD files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Text,
    Crate,
    Package,
}

impl Kind {
    fn of(path: &Path) -> Result<Self> {
        let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
        match extension.as_deref() {
            Some("usda") => Ok(Kind::Text),
            Some("usdc" | "usd") => Ok(Kind::Crate),
            Some("usdz") => Ok(Kind::Package),
            Some(_) | None => {
                Err(Fault::new(Where::file(path), "this is no name of a USD file").expected(".usda, .usdc or .usdz"))
            }
        }
    }
}

fn bytes(mut layer: layer::Layer, kind: Kind, path: &Path) -> Result<Vec<u8>> {
    match kind {
        Kind::Text => Ok(text::text(&layer).into_bytes()),
        Kind::Crate => binary::crate_bytes(&layer, path),
        Kind::Package => {
            let beside = pack::take(&mut layer, path)?;
            let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
            binary::package_bytes(&layer, &beside, path, &name::identifier(&stem, "asset"))
        }
    }
}
