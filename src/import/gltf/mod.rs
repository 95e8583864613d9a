//! glTF 2.0, `.gltf` and `.glb`, into an [`Assembly`].
//!
//! Everything is read from the raw JSON and the raw bytes with checked arithmetic; the `gltf` crate is only the second
//! opinion of a test. It types transforms as f32, panics on some indices out of range and knows no quantized positions,
//! so each of its answers would need a check that is as long as the reading itself.

mod accessor;
mod animation;
mod at;
mod buffers;
mod compressed;
mod container;
mod corners;
mod deform;
mod deps;
mod draco;
mod features;
mod hierarchy;
mod light;
mod material;
pub(super) mod mesh;
mod meshopt;
mod morph;
mod node;
pub(super) mod normals;
pub(super) mod notes;
mod picture;
mod pose;
pub(super) mod primitive;
mod rig;
mod sampler;
mod shapes;
mod skin;
mod standard;
mod surface;
pub(super) mod transform;
mod user;
mod variants;
mod world;

#[cfg(test)]
pub(crate) mod testing;
#[cfg(test)]
mod tests;

pub use deps::dependencies;

use super::ReadOptions;
use super::assembly::Assembly;
use accessor::Document;
use at::At;
use buffers::Buffers;
use eyebox_base::{Code, Error, Where, error::Result};
use eyebox_scene::Note;
use glam::DVec3;
use notes::{Budget, Ledger, Notes};
use std::path::Path;

/// Reads the asset at `path` with the buffer files it refers to, at the moment that `options` ask for. One mesh per glTF mesh
/// (and one more for each further way in which nodes bend it), one face per primitive, one node per node of the default
/// scene (all nodes if there is none); `unit_m` is 1, as glTF declares.
///
/// Only what is used is checked: without a frame, an animation may be as broken as it likes.
///
/// # Errors
/// Whatever is wrong in the file, with its JSON pointer. A hostile file gives a fault, too: no panic, no hang, and no
/// more memory than a small multiple of the file.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Assembly> {
    let failed = |error: std::io::Error| {
        Error::new(Where::file(path), format!("cannot read the asset: {error}")).code(Code::of_reading(&error))
    };
    if std::fs::metadata(path).map_err(failed)?.is_dir() {
        return Err(Error::new(Where::file(path), "this is a folder").expected("a .gltf or .glb file"));
    }
    read_bytes(path, &std::fs::read(path).map_err(failed)?, options)
}

/// Reads an asset whose content is `bytes`; `file` says where it would be (other files are looked for beside it).
pub fn read_bytes(file: &Path, bytes: &[u8], options: &ReadOptions) -> Result<Assembly> {
    let mut notes = Notes::default();
    let mut container = container::open(file, bytes, &mut notes)?;
    let root = At::root(file, &container.json);
    check_version(&root, &mut notes)?;
    features::check_required(&root)?;
    let mut buffers = Buffers::load(&root, container.bin)?;
    let budget = Budget::new(bytes.len().saturating_add(buffers.total()));
    let mut ledger = Ledger { notes, budget };
    compressed::decode(file, &mut container.json, &mut buffers, &mut ledger)?;
    let root = At::root(file, &container.json);
    let variant = variants::chosen(&root, &options.variants)?;
    let document = Document { root, buffers, variant };

    let mut assembly = Assembly { file: file.to_owned(), unit_m: 1.0, ..Assembly::default() };
    assembly.dependencies.push(file.to_owned());
    assembly.dependencies.extend(document.buffers.files.iter().cloned());
    assembly.optics = document.root.optics(&mut ledger.budget)?;
    let mut pictures = picture::Pictures::default();
    for (index, at) in document.root.list("materials")?.iter().enumerate() {
        let mut material = material::read(at, index, &mut ledger)?;
        let (document, pictures) = (&document, &mut pictures);
        let mut reader = standard::Reader { document, pictures, ledger: &mut ledger };
        material.surface = Some(reader.surface(at, &material.name)?.into());
        assembly.materials.push(material);
    }
    node::read(&document, options, &mut assembly, &mut ledger)?;
    assembly.variants = options.variants.iter().map(ToString::to_string).collect();
    features::note_unused(&document.root, variant.is_some(), &mut ledger.notes)?;
    assembly.notes = ledger.notes.finish();
    Ok(assembly)
}

/// `asset.version` and `asset.minVersion` must be 2.x; what a later minor version added is not known here, which is said.
fn check_version(root: &At<'_>, notes: &mut Notes) -> Result<()> {
    let asset = root.want("asset")?;
    let version = asset.want("version")?;
    let parse = |text: &str| -> Option<(u32, u32)> {
        let (major, minor) = text.split_once('.')?;
        Some((major.parse().ok()?, minor.parse().ok()?))
    };
    let stated = if version.json.is_number() { version.json.to_string() } else { version.text()?.to_owned() };
    if !matches!(parse(&stated), Some((2, _))) || version.json.is_number() {
        let what = format!("this version of glTF is not read: {}", stated.escape_debug());
        return Err(version.fault(what).expected("\"2.0\" (or a later 2.x)"));
    }
    if let Some(least) = asset.get("minVersion")? {
        match parse(least.text()?) {
            Some((2, 0)) => {}
            Some((2, _)) => {
                let text = format!("the asset asks for a reader of glTF {}: read as 2.0", least.text()?);
                notes.warn(&least, &text);
            }
            Some(_) | None => return Err(least.fault("the asset asks for a newer reader").expected("\"2.0\"")),
        }
    }
    Ok(())
}

/// Largest extent of an honest assembly in metres, and the size of a part, in metres, that no optical part has.
const LARGE_ASSEMBLY_M: f64 = 20.0;
const LARGE_PART_M: f64 = 5.0;

/// A note if the asset, taken in metres, looks like one that a CAD kernel wrote in millimetres without saying so: it is
/// larger than 20 m, and a quarter of its parts are larger than 5 m each (a street that a display is looked at in is large, too, but
/// most things in it are not). Where the sidecar sets `unit`: [`large_by_its_unit`].
pub fn looks_like_millimetres(assembly: &Assembly) -> Option<Note> {
    if assembly.says_unit() {
        return None;
    }
    // What declares millimetres or less does not take them for metres.
    let extent = too_large(assembly, assembly.unit_m).filter(|_| assembly.unit_m > 1e-3 * (1.0 + 1e-9))?;
    let text = format!(
        "largest extent {extent:.0} m: this looks like millimetres; set `unit = 0.001` in the sidecar (or `unit = 1` if it is right)"
    );
    Some(Note::warning(Where::file(&assembly.file), text).code(Code::ScaleSuspicious))
}

/// A note if the asset is as large in a unit that somebody said, at `at`: a unit can be wrong on purpose, too, and light
/// falls with its square.
pub fn large_by_its_unit(assembly: &Assembly, unit_m: f64, at: Where) -> Option<Note> {
    let extent = too_large(assembly, unit_m)?;
    let text =
        format!("largest extent {extent:.0} m by `unit` = {unit_m}: this looks like millimetres in a wrong unit");
    Some(Note::warning(at, text).code(Code::ScaleSuspicious))
}

/// The largest extent, m, if most things are larger than optical parts are.
fn too_large(assembly: &Assembly, unit_m: f64) -> Option<f64> {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let mut sizes = Vec::new();
    let boxes: Vec<Option<(DVec3, DVec3)>> =
        assembly.meshes.iter().map(|source| bounds(source.mesh.positions.iter().copied())).collect();
    for node in &assembly.nodes {
        let Some(&Some((least, most))) = node.mesh.and_then(|mesh| boxes.get(mesh)) else { continue };
        let (mut part_low, mut part_high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for corner in 0..8 {
            let pick = |bit: u32, low: f64, high: f64| if corner >> bit & 1 == 0 { low } else { high };
            let local = DVec3::new(pick(0, least.x, most.x), pick(1, least.y, most.y), pick(2, least.z, most.z));
            let point = node.to_world.transform_point3(local);
            (part_low, part_high) = (part_low.min(point), part_high.max(point));
        }
        sizes.push((part_high - part_low).max_element() * unit_m);
        (low, high) = (low.min(part_low), high.max(part_high));
    }
    let extent = (high - low).max_element() * unit_m;
    sizes.sort_by(f64::total_cmp);
    let upper_quartile = sizes.get(sizes.len() * 3 / 4).copied()?;
    (extent > LARGE_ASSEMBLY_M && extent.is_finite() && upper_quartile > LARGE_PART_M).then_some(extent)
}

/// The corners of the smallest box around some points.
fn bounds(points: impl Iterator<Item = [f32; 3]>) -> Option<(DVec3, DVec3)> {
    points.map(|p| DVec3::from(p.map(f64::from))).fold(None, |found, p| {
        let (low, high) = found.unwrap_or((p, p));
        Some((low.min(p), high.max(p)))
    })
}
