//! USD: an [`Assembly`] as a `.usda`, `.usdc` or `.usdz` file.
//!
//! Every node is a prim with one `matrix4d` transform; its mesh is a prim of its own below it, with one GeomSubset for
//! each face. A mesh that several nodes use is a prototype that they refer to, instanceable. What USD has no place for
//! (names that are no identifiers, the exact numbers behind a shader's single precision) stands in
//! `customData["eyebox"]`, see `stage`, and our reader takes it from there.

pub mod layer; // prims and values as data
pub mod name; // identifiers
pub mod text; // .usda

mod annotate; // rows as a layer over the asset
mod binary; // .usdc and .usdz
mod implicit; // shapes without points
mod light; // lights and cameras
mod material; // materials and their bindings
mod mesh; // geometry and faces
mod network; // nodes of shaders
mod open_pbr; // looks that UsdPreviewSurface lacks
mod optics; // attributes as properties
mod pack; // the files that a package holds
mod picture; // the pictures of materials
mod preview; // looks as UsdPreviewSurface
mod samples; // what moves, by time
mod skel; // joints and blend shapes
mod stage; // the hierarchy
#[cfg(test)]
mod tests;
mod user; // what authors say beside the format

pub use annotate::annotate;

use super::Written;
use eyebox_base::atomic::write_atomic;
use eyebox_base::error::Result;
use eyebox_base::relative_path::folder_of;
use eyebox_base::{Error, Where};
use eyebox_scene::assembly::Assembly;
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

/// Writes `assembly` as the USD file `out`, whose extension says the kind, with its pictures in a folder `NAME_textures`
/// beside it, or in the package.
///
/// # Errors
/// As [`encode`]; a file cannot be written.
pub fn write(assembly: &Assembly, out: &Path) -> Result<Written> {
    let kind = Kind::of(out)?;
    let (layer, pictures) = parts(assembly, out, kind)?;
    let known = if kind == Kind::Package { pictures.known() } else { HashMap::new() };
    let bytes = bytes(layer, kind, out, &known)?;
    let mut files = vec![out.to_owned()];
    if kind != Kind::Package {
        files.extend(super::picture::save(&pictures.files(out))?);
    }
    write_atomic(out, &bytes)?;
    Ok(Written { files, notes: pictures.notes })
}

/// The bytes of `assembly` as the USD file `path`, whose name says which kind; relative paths in it start from its folder.
///
/// # Errors
/// An assembly that contradicts itself (indices that lead nowhere, numbers that are not finite), attributes that the
/// vocabulary lacks, hierarchies deeper than USD readers take, files for a `.usdz` that cannot be read, another file name extension.
pub fn encode(assembly: &Assembly, path: &Path) -> Result<Vec<u8>> {
    let kind = Kind::of(path)?;
    let (layer, pictures) = parts(assembly, path, kind)?;
    bytes(layer, kind, path, &pictures.known())
}

fn parts(assembly: &Assembly, path: &Path, kind: Kind) -> Result<(layer::Layer, picture::Pictures)> {
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let mut pictures = picture::Pictures::new(&stem, kind == Kind::Package);
    let layer = stage::layer(assembly, &name::identifier(&stem, "Asset"), &folder_of(path), &mut pictures)?;
    Ok((layer, pictures))
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
                Err(Error::new(Where::file(path), "this is no name of a USD file").expected(".usda, .usdc or .usdz"))
            }
        }
    }
}

/// `known` are files that a package is to hold, by the names that the layer has for them.
fn bytes(mut layer: layer::Layer, kind: Kind, path: &Path, known: &HashMap<String, Arc<Vec<u8>>>) -> Result<Vec<u8>> {
    match kind {
        Kind::Text => Ok(text::text(&layer).into_bytes()),
        Kind::Crate => binary::crate_bytes(&layer, path),
        Kind::Package => {
            let beside = pack::take(&mut layer, path, known)?;
            let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
            binary::package_bytes(&layer, &beside, path, &name::identifier(&stem, "asset"))
        }
    }
}
