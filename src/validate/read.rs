//! An asset as far as it can be read: where something is faulty, it is noted, taken away and the rest is looked at.

use super::heal::heal;
use super::missing;
use eyebox_base::{Code, Error, Result, Where};
use eyebox_check::subject::{Needed, Refusal, Stage};
use eyebox_import::{ReadOptions, build, dependencies};
use eyebox_scene::assembly::Assembly;
use eyebox_scene::value::Value;
use eyebox_scene::{Eye, Scene, Wavelengths};
use glam::DVec3;
use std::path::{Path, PathBuf};

/// What became of an asset.
pub struct Examined {
    pub file: PathBuf,
    /// As it was read, faulty attributes included.
    pub assembly: Option<Assembly>,
    pub sheet: Option<Value>,
    pub scene: Option<Scene>,
    pub refusals: Vec<Refusal>,
    pub needed: Vec<Needed>,
}

/// Faults of one asset that are looked for beyond the first: who has more has other worries.
const MOST: usize = 64;

/// Faults: there is no such file, or it is none.
pub fn check_there(path: &Path) -> Result<()> {
    match std::fs::metadata(path) {
        Ok(facts) if facts.is_file() => Ok(()),
        Ok(_) => {
            Err(Error::new(Where::File(path.to_owned()), "this is no regular file").expected("an asset or a sidecar"))
        }
        Err(error) => Err(Error::new(Where::File(path.to_owned()), format!("cannot be read: {error}"))),
    }
}

/// Reads as `reading` has it, binds and builds.
pub fn examine(path: &Path, reading: &ReadOptions) -> Examined {
    let mut out = Examined {
        file: path.to_owned(),
        assembly: None,
        sheet: None,
        scene: None,
        refusals: Vec::new(),
        needed: needed(path),
    };
    let is_toml = |path: &Path| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"));
    let readable = if is_toml(path) { eyebox_import::toml::read(path).err() } else { None };
    if let Some(fault) = readable {
        out.refusals.push(Refusal { stage: Stage::Sidecar, fault });
        return out;
    }
    let (assembly, sidecar) = match eyebox_import::read(path, reading) {
        Ok(read) => read,
        Err(fault) => {
            // Of an asset, only the sidecar beside it is TOML.
            let beside = !is_toml(path) && file_of(&fault.at).is_some_and(is_toml);
            out.refusals.push(Refusal { stage: if beside { Stage::Sidecar } else { Stage::Read }, fault });
            return out;
        }
    };
    if assembly.lights.is_empty() && assembly.nodes.iter().all(|node| node.mesh.is_none()) {
        // Every rule of a sidecar would match nothing.
        let fault = Error::new(Where::file(&assembly.file), "no node has geometry")
            .expected("at least one part")
            .code(Code::NothingToTrace);
        out.refusals.push(Refusal { stage: Stage::Read, fault });
        return out;
    }
    out.sheet = sidecar.as_ref().map(|(_, sheet)| sheet.clone());
    let (mut work, mut sheet) = (assembly.clone(), out.sheet.clone());
    out.assembly = Some(assembly);
    while out.refusals.len() < MOST {
        match build(work.clone(), sheet.as_ref(), &[]).map_err(|fault| missing::as_listed(fault, &out.needed)) {
            Ok(built) => {
                out.scene = Some(built.scene);
                break;
            }
            // What could not be healed comes again.
            Err(fault) if out.refusals.iter().any(|known| known.fault == fault) => break,
            Err(fault) => {
                let healed = heal(&mut work, &mut sheet, &fault);
                out.refusals.push(Refusal { stage: Stage::Build, fault });
                if !healed {
                    break;
                }
            }
        }
    }
    out
}

fn file_of(at: &Where) -> Option<&Path> {
    match at {
        Where::File(file) | Where::Line { file, .. } | Where::Pointer { file, .. } | Where::Prim { file, .. } => {
            Some(file)
        }
        Where::Nowhere | Where::Part { .. } | Where::Option(_) => None,
    }
}

/// The files that an asset names; none if that can't be told.
fn needed(path: &Path) -> Vec<Needed> {
    let all = dependencies(path, &ReadOptions::default()).unwrap_or_default();
    let needed = |d: eyebox_import::deps::Dependency| Needed {
        file: d.file,
        role: d.role,
        at: d.at,
        there: d.there,
        used: d.used,
    };
    missing::once(all.into_iter().map(needed))
}

/// A scene with nothing in it, for an asset that none can be made of.
pub fn no_scene() -> Scene {
    Scene {
        name: String::new(),
        unit_m: 1.0,
        wavelengths: Wavelengths::Visible,
        meshes: Vec::new(),
        parts: Vec::new(),
        media: Vec::new(),
        coatings: Vec::new(),
        slides: Vec::new(),
        scatters: Vec::new(),
        wave_plates: Vec::new(),
        gratings: Vec::new(),
        surfaces: Vec::new(),
        groups: Vec::new(),
        profiles: Vec::new(),
        lights: Vec::new(),
        sky: None,
        eye: Eye {
            position: DVec3::ZERO,
            look: DVec3::NEG_Z,
            up: DVec3::Y,
            pupil_diameter_m: 0.0,
            adapts: false,
            limits: eyebox_scene::BinocularLimits::default(),
            focus_distance_m: f64::INFINITY,
            fov_deg: 1.0,
            resolution: [1, 1],
            age: 45.0,
        },
        notes: Vec::new(),
        hash: String::new(),
    }
}
