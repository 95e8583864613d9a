//! The geometry of an asset whose optical attributes can't be used (yet), so that `inspect` can show it all the same.

use super::gltf::looks_like_millimetres;
use super::value::{Data, Value};
use super::{Assembly, ReadOptions, build, optics, toml};
use eyebox_base::error::Result;
use eyebox_scene::Scene;
use std::path::Path;

/// Only what stands in for optics: nothing of it is to be shown.
const STAND_IN: &str = "schema = 1
wavelengths = { mono_nm = 550 }
[default]
finish = \"absorber\"
[eye]
position = [\"0 mm\", \"0 mm\", \"0 mm\"]
look = [0, 0, -1]
up = [0, 1, 0]
pupil_diameter = \"4 mm\"
focus_distance = \"inf\"
fov_deg = 20
resolution = [360, 180]
age = 45
";

/// Names, hierarchy and geometry of the asset that `path` means, in metres by the sidecar's `unit` if that is sound.
/// Finishes, lamps and the eye of this scene mean nothing. Faults: the asset can't be read.
pub fn outline(path: &Path, options: &ReadOptions) -> Result<Scene> {
    let (mut assembly, sidecar) = super::read(path, options)?;
    strip(&mut assembly);
    let mut stand_in = toml::parse(STAND_IN, path)?;
    let unit = sidecar.and_then(|(_, sidecar)| sidecar.get("unit").cloned()).filter(|unit| optics::unit(unit).is_ok());
    if let (Some(unit), Value { data: Data::Table(table), .. }) = (unit, &mut stand_in) {
        table.push(("unit".to_owned(), unit));
    }
    Ok(build(assembly, Some(&stand_in), &[])?.scene)
}

/// The assembly that `path` means, its unit replaced by the sidecar's if that is sound; nothing optical is looked at.
/// Faults: the asset can't be read.
pub fn geometry(path: &Path, options: &ReadOptions) -> Result<Assembly> {
    let (mut assembly, sidecar) = super::read(path, options)?;
    if let Some(unit) = sidecar.and_then(|(_, sidecar)| optics::unit(sidecar.get("unit")?).ok()) {
        assembly.unit_m = unit;
    } else {
        let note = looks_like_millimetres(&assembly);
        assembly.notes.extend(note);
    }
    Ok(assembly)
}

/// Takes all optical attributes away.
fn strip(assembly: &mut Assembly) {
    assembly.optics = None;
    for node in &mut assembly.nodes {
        node.attributes = None;
    }
    for mesh in &mut assembly.meshes {
        mesh.attributes.iter_mut().for_each(|attributes| *attributes = None);
    }
    for material in &mut assembly.materials {
        material.mapped.clear();
        material.attributes = None;
    }
}
