//! A sidecar to start from: everything that can be seen in a bare asset, guesses from names, and TODOs for the rest.

mod around;
mod guess;
mod kinds;
mod looks;
mod write;

#[cfg(test)]
mod tests;

use super::{Assembly, Built, build, gltf, toml};
use eyebox_base::error::Result;
use eyebox_base::{Error, Where};
use std::path::{Component, Path};

/// A sidecar as text.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Template {
    #[serde(skip)]
    pub text: String,
    pub parts: usize,
    /// Distinct parts: copies count once.
    pub kinds: usize,
    /// What the author has to say, in the order of the text.
    pub todos: Vec<String>,
    /// Why the text can't be imported as it is, if so.
    pub fault: Option<Box<Error>>,
}

/// Largest distance of a face's points from a surface that is called its shape, µm.
const TOLERANCE_UM: f64 = 0.05;

/// The sidecar of `asset` that is to stand at `sidecar` (nothing is written).
///
/// Faults: the asset can't be read, or is no asset.
pub fn skeleton(asset: &Path, sidecar: &Path) -> Result<Template> {
    if super::extension(asset) == "toml" {
        return Err(Error::new(Where::file(asset), "this is a sidecar already").expected("an asset: .gltf or .glb"));
    }
    let assembly = super::read_asset(asset, &Where::Nowhere, &super::ReadOptions::default())?;
    of(assembly, &relative(asset, sidecar), sidecar)
}

/// The sidecar of `assembly`, whose asset it names `asset`.
fn of(assembly: Assembly, asset: &str, sidecar: &Path) -> Result<Template> {
    let millimetres = gltf::looks_like_millimetres(&assembly).is_some();
    let unit_m = if millimetres { 1e-3 } else { assembly.unit_m };
    let kinds = kinds::kinds(&assembly, unit_m)?;
    let head = write::Head { asset, sidecar, unit_m, millimetres };
    let written = match as_it_looks(&assembly, &kinds) {
        Some(bare) => looks::write(&assembly, &kinds, &head, bare.assumed, &bare.scene.eye),
        None => write::write(&assembly, &kinds, &head),
    };
    let parts = kinds.iter().map(|kind| kind.members.len()).sum();
    let fault = toml::parse(&written.text, sidecar).and_then(|value| build(assembly, Some(&value), &[])).err();
    Ok(Template { text: written.text, parts, kinds: kinds.len(), todos: written.todos, fault })
}

/// What the asset is without a sidecar, if it is a picture: nothing of it is optics by its name or by what it says.
fn as_it_looks(assembly: &Assembly, kinds: &[kinds::Kind]) -> Option<Built> {
    let optical = assembly.carries_optics() || kinds.iter().any(|kind| kind.role != guess::Role::Mechanics);
    if optical { None } else { build(assembly.clone(), None, &[]).ok() }
}

/// The name of `asset` as seen from the folder of `sidecar`.
fn relative(asset: &Path, sidecar: &Path) -> String {
    let folder = sidecar.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let (Ok(asset_full), Ok(folder)) = (asset.canonicalize(), folder.canonicalize()) else {
        return asset.to_string_lossy().into_owned();
    };
    let (asset, folder): (Vec<Component<'_>>, Vec<_>) =
        (asset_full.components().collect(), folder.components().collect());
    let common = asset.iter().zip(&folder).take_while(|(a, b)| a == b).count();
    // Nothing in common but the root: the full name says more than a row of dots.
    if common <= 1 {
        return asset_full.to_string_lossy().into_owned();
    }
    let up = folder.iter().skip(common).map(|_| "..".into());
    let down = asset.iter().skip(common).map(|part| part.as_os_str().to_string_lossy());
    up.chain(down).collect::<Vec<_>>().join("/")
}
