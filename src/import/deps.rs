//! Every file that an asset needs, without reading more of it than the names: a missing one is listed, too.

use super::agf::Reference;
use super::value::{Data, Value};
use super::{Assembly, ReadOptions, extension, files, gltf, photometric, toml};
use eyebox_base::error::Result;
use eyebox_base::relative_path::placed;
use eyebox_base::{Where, package};
use eyebox_scene::assembly::LightForm;
use eyebox_scene::attribute::{Form, ROWS};
use serde::Serialize;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// A file that is needed, and who asks for it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Dependency {
    pub file: PathBuf,
    /// `sidecar`, `asset`, `buffer`, `layer`, `image`, `file`, `light profile`, `texture`.
    pub role: String,
    /// Where it is named.
    pub at: Where,
    /// Whether it is there, as a regular file.
    pub there: bool,
    /// Whether it is read; textures are not.
    pub used: bool,
}

impl Dependency {
    pub(super) fn new(file: PathBuf, role: &str, at: Where) -> Self {
        let there = package::is_file(&file);
        Dependency { file, role: role.to_owned(), at, there, used: role != "texture" }
    }
}

/// What `path`, a sidecar or an asset read with `options`, needs: itself first, each file once in the order of its first mention.
///
/// # Errors
/// `path` itself or an asset that it names is there but cannot be understood.
pub fn dependencies(path: &Path, options: &ReadOptions) -> Result<Vec<Dependency>> {
    let mut all = Vec::new();
    if extension(path) == "toml" {
        sidecar(path, Where::Nowhere, options, &mut all)?;
    } else {
        asset(path, Where::Nowhere, options, &mut all)?;
        let read = || super::read_asset(path, &Where::Nowhere, options);
        if let Some((beside, _)) = super::beside(path, || read().is_ok_and(|assembly| assembly.carries_optics()))? {
            sidecar(&beside, Where::file(path), options, &mut all)?;
        }
    }
    let (mut once, mut known) = (Vec::<Dependency>::new(), HashMap::new());
    for dependency in all {
        let index = *known.entry(placed(&dependency.file)).or_insert(once.len());
        match once.get_mut(index) {
            Some(other) => other.used |= dependency.used,
            None => once.push(dependency),
        }
    }
    Ok(once)
}

fn sidecar(path: &Path, at: Where, options: &ReadOptions, all: &mut Vec<Dependency>) -> Result<()> {
    all.push(Dependency::new(path.to_owned(), "sidecar", at));
    let sheet = toml::read(path)?;
    if let Some(value) = sheet.get("asset")
        && let Some(name) = value.text()
    {
        let file = files::resolve(name, &value.at);
        // Found already where the sidecar was found beside its asset.
        if !all.iter().any(|other| other.file == file) {
            asset(&file, value.at.clone(), options, all)?;
        }
    }
    named(&sheet, all);
    Ok(())
}

fn asset(path: &Path, at: Where, options: &ReadOptions, all: &mut Vec<Dependency>) -> Result<()> {
    let itself = Dependency::new(path.to_owned(), "asset", at.clone());
    let there = itself.there;
    all.push(itself);
    if !there {
        return Ok(());
    }
    if matches!(extension(path).as_str(), "gltf" | "glb") {
        return gltf::dependencies(path, all);
    }
    let assembly = super::read_asset(path, &at, options)?;
    let layers = assembly.dependencies.iter().filter(|file| file.as_path() != path);
    all.extend(layers.map(|file| Dependency::new(file.clone(), "layer", Where::file(path))));
    carried(&assembly, all);
    Ok(())
}

/// What an assembly's attributes and lights name.
fn carried(assembly: &Assembly, all: &mut Vec<Dependency>) {
    let materials = assembly.materials.iter().flat_map(|material| &material.attributes);
    let faces = assembly.meshes.iter().flat_map(|mesh| mesh.attributes.iter().flatten());
    let nodes = assembly.nodes.iter().flat_map(|node| &node.attributes);
    for value in assembly.optics.iter().chain(materials).chain(faces).chain(nodes) {
        named(value, all);
    }
    let textures = assembly.textures.iter();
    all.extend(textures.map(|(file, at)| Dependency::new(file.clone(), "texture", at.clone())));
    for light in &assembly.lights {
        if let Some(profile) = light.profile.as_ref().and_then(|profile| profile.source.file()) {
            self::profile(profile.clone(), "light profile", light.at.clone(), all);
        }
        if let LightForm::Dome { image: Some(image), .. } = &light.form {
            all.push(Dependency::new(image.clone(), "image", light.at.clone()));
        }
    }
}

/// A file, and the TILT file that it names if it is a photometric one.
pub(super) fn profile(file: PathBuf, role: &str, at: Where, all: &mut Vec<Dependency>) {
    let tilt = if extension(&file) == "ies" { photometric::tilt_file(&file) } else { None };
    let named = Where::file(&file);
    all.push(Dependency::new(file, role, at));
    all.extend(tilt.map(|tilt| Dependency::new(tilt, "tilt of a light profile", named)));
}

/// Files that attributes name: the entries whose row in the vocabulary is a file, as a text or as `{ uri = … }`.
pub(super) fn named(value: &Value, all: &mut Vec<Dependency>) {
    match &value.data {
        Data::Text(text) => {
            let catalogue =
                |from: Reference| Dependency::new(from.path(&value.at), "catalogue of glasses", value.at.clone());
            all.extend(Reference::of(text).map(catalogue));
        }
        Data::Bool(_) | Data::Number(_) => {}
        Data::List(items) => items.iter().for_each(|item| named(item, all)),
        Data::Table(entries) => {
            for (key, inner) in entries {
                let is_file = ROWS.iter().any(|row| row.name == key && row.form == Form::File) && key != "asset";
                let name = inner.text().or_else(|| inner.get("uri").and_then(Value::text));
                match name.filter(|_| is_file) {
                    Some(name) => profile(files::resolve(name, &inner.at), key, inner.at.clone(), all),
                    None => named(inner, all),
                }
            }
        }
    }
}
