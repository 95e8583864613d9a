//! The files that a glTF asset names: buffers, textures, light profiles, and what its optical attributes ask for.

use super::at::At;
use super::buffers::{data_scheme, resolve};
use super::container;
use super::notes::{Budget, Notes};
use crate::deps::{Dependency, named, profile};
use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Where};
use serde_json::Value as Json;
use std::path::Path;

/// Appends what the asset at `path` names. Nothing but the JSON is looked at; buffers may be missing.
///
/// # Errors
/// The file cannot be read or is no glTF; a URI that leads nowhere.
pub fn dependencies(path: &Path, all: &mut Vec<Dependency>) -> Result<()> {
    let failed = |error: std::io::Error| {
        Error::new(Where::file(path), format!("cannot read the asset: {error}")).code(Code::of_reading(&error))
    };
    let bytes = std::fs::read(path).map_err(failed)?;
    let container = container::open(path, &bytes, &mut Notes::default())?;
    let root = At::root(path, &container.json);
    for (list, role) in [("buffers", "buffer"), ("images", "texture")] {
        for at in root.list(list)? {
            file(&at, role, all)?;
        }
    }
    if let Some(lights) = root.extension("EXT_lights_ies")? {
        for at in lights.list("lights")? {
            file(&at, "light profile", all)?;
        }
    }
    let mut budget = Budget::new(bytes.len());
    attributes(&root, &mut budget, all)
}

/// The `uri` of this object, unless it is a `data:` URI.
fn file(at: &At<'_>, role: &str, all: &mut Vec<Dependency>) -> Result<()> {
    if let Some(uri) = at.get("uri")?
        && data_scheme(uri.text()?).is_none()
    {
        profile(resolve(&uri, uri.text()?)?, role, uri.place(), all);
    }
    Ok(())
}

/// The optical attributes of the places that carry some.
fn attributes(root: &At<'_>, budget: &mut Budget, all: &mut Vec<Dependency>) -> Result<()> {
    let mut places = vec![root.clone()];
    places.extend(root.list("materials")?);
    places.extend(root.list("nodes")?);
    for mesh in root.list("meshes")? {
        places.extend(mesh.list("primitives")?);
    }
    for at in places.iter().filter(|at| at.json.get("extensions").is_some_and(Json::is_object)) {
        if let Some(value) = at.optics(budget)? {
            named(&value, all);
        }
    }
    Ok(())
}
