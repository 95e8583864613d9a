//! Floor 2: from files to a [`Scene`](eyebox_scene::Scene). A format reader fills an [`Assembly`]; the attribute
//! vocabulary, the sidecar and the binding rules turn it into a scene, the same for every format.

pub mod agf; // catalogues of glasses from files
pub mod annotate; // a sidecar as rows of the asset itself
pub mod asset_attributes; // what is said about the asset as a whole
mod asset_rows; // what the asset says of itself
pub mod bind; // which value holds for an attribute of a part or face
pub mod binding_slots; // the places that values are offered for
pub mod build; // assembly + sidecar + sets → scene
mod daylight; // skies by formula, and the sun
mod defaults; // an eye and a sky for assets that have none
pub mod deps; // the files that an asset needs
mod enclosed; // cameras that stand inside of things
pub mod explain; // which line won
mod faces; // parts and their faces from attributes
pub mod files;
pub mod fit; // exact surfaces from the points of a CAD face
mod frames; // frames, the eye, fitted shapes
pub mod gltf; // .gltf and .glb
mod image; // PNG, EXR, HDR → luminance
pub mod json; // attributes that travel inside JSON
mod lamps; // emitters of faces, the sun
mod light_units; // watts in place of lumens
mod lights; // lights that are no geometry in the format
mod material_mapping; // what a format's own material fields mean
mod measure; // normals and bounds of CAD faces
mod moving; // an asset at one frame after the other
pub mod normals; // vertex normals that contradict their triangles
pub mod optics; // readers of the attribute vocabulary
mod outline; // the geometry alone
mod patch; // changing a value in place
pub mod photometric; // IES LM-63 and EULUMDAT
pub mod prescription; // lens files of design programs
pub mod ray_file; // rays of lamps: TM-25 and Zemax binary source files
mod ray_lamps; // lamps that are the rays of a file
mod scene_images; // slides and panoramas
pub mod select; // which parts and faces a selector means
pub mod set; // --set
mod skies; // the sky, read or made
mod skinning; // joints that move vertices
mod surfaces; // how ordinary materials look: their pictures are read
pub mod template; // a sidecar to start from
#[cfg(any(test, feature = "testing"))]
pub mod testing; // assemblies made by hand
#[cfg(test)]
mod tests;
pub(crate) mod text; // text in any encoding
mod texture_file; // the files of those pictures
mod tiles; // pictures in tiles, put together
pub mod toml; // sidecars
pub mod usd; // .usda, .usdc and .usdz
mod variants; // --variant

pub use annotate::annotate;
use build::build_within;
pub use build::{Built, build};
pub use deps::dependencies;
pub use explain::Explained;
pub use eyebox_scene::assembly::{self, Assembly};
pub use eyebox_scene::value::{self, Data, Value};
pub use light_units::LightUnits;
pub use moving::moving;
pub use outline::{geometry, outline};
pub use set::Set;
pub use variants::VariantChoice;

use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Where, weld};
use eyebox_scene::Note;
use std::path::{Path, PathBuf};

/// A format of assemblies. A new one is a module with a reader and a line in [`FORMATS`].
pub struct Format {
    /// Lower-case file name extensions.
    pub extensions: &'static [&'static str],
    pub name: &'static str,
    pub read: fn(&Path, &ReadOptions) -> Result<Assembly>,
}

/// How to read an asset.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ReadOptions {
    /// The time code at which time-sampled values are taken; none takes an attribute's own value, and its earliest
    /// sample where it has none. Of glTF, frame `frame` of an animation; none leaves nodes as they are written.
    pub frame: Option<f64>,
    /// Frames a second of glTF's animations, which count in seconds; 24 if not said.
    pub fps: Option<f64>,
    /// The name or number of glTF's animation; the first if not said.
    pub animation: Option<String>,
    /// Variants of a USD stage, taken in this order, or of the materials of a glTF asset.
    pub variants: Vec<VariantChoice>,
    /// What the strengths of its own lights count in.
    pub light_units: LightUnits,
    /// Whether what moves and bends is read, too.
    pub rigs: Rigs,
}

/// Whether a reader says what moves and bends: `Assembly::clock`, the rigs of meshes. A mesh that a node may bend is this node's
/// alone then.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Rigs {
    #[default]
    No,
    /// Of an asset that was read whole: where joints stand and what weights are is enough, if nothing else can differ.
    Poses,
    Whole,
}

/// What textures may take of memory where nobody says, bytes.
pub const TEXTURE_BYTES: u64 = 4 << 30;

/// What can be imported.
pub const FORMATS: &[Format] = &[
    Format { extensions: &["glb", "gltf"], name: "glTF 2.0", read: gltf::read },
    Format { extensions: &["usda", "usdc", "usdz", "usd"], name: "USD", read: usd::read },
];

/// How to import.
#[derive(Debug, Clone, Default)]
pub struct ImportOptions {
    /// `--set`, in order.
    pub sets: Vec<Set>,
    /// `--frame`, `--fps`, `--animation`.
    pub reading: ReadOptions,
    /// `--texture-memory`: bytes that textures may take; [`TEXTURE_BYTES`] if not said.
    pub texture_bytes: Option<u64>,
}

/// Imports a scene: `path` is an asset, or a sidecar (`.toml`) that names its asset.
///
/// An asset without attributes of its own takes the sidecar `NAME.optics.toml` beside it, with a note, unless that names
/// another asset.
pub fn import(path: &Path, options: &ImportOptions) -> Result<Built> {
    let (mut assembly, sidecar) = read(path, &options.reading)?;
    if let Some((file, _)) = &sidecar {
        assembly.dependencies.push(file.clone());
    }
    let texture_bytes = options.texture_bytes.unwrap_or(TEXTURE_BYTES);
    build_within(assembly, sidecar.as_ref().map(|(_, value)| value), &options.sets, texture_bytes)
}

/// The assembly that `path` means and its sidecar, as they were read.
pub fn read(path: &Path, options: &ReadOptions) -> Result<(Assembly, Option<(PathBuf, Value)>)> {
    if extension(path) == "toml" {
        let sidecar = toml::read(path)?;
        let Some(asset) = sidecar.get("asset") else {
            return Err(Error::new(Where::file(path), "`asset` is missing").expected("asset = \"FILE.glb\""));
        };
        let Some(name) = asset.text() else {
            return Err(Error::new(asset.at.clone(), format!("`asset` is {}", asset.kind())).expected("a file name"));
        };
        let file = files::resolve(name, &asset.at);
        if !file.is_file() {
            return Err(Error::new(
                asset.at.clone(),
                format!("can't read the asset {}: there is no such file", file.display()),
            )
            .code(Code::FileMissing));
        }
        let mut assembly = read_asset(&file, &asset.at, options)?;
        assembly.notes.extend(light_units::note(&assembly, options.light_units));
        return Ok((assembly, Some((path.to_owned(), sidecar))));
    }
    let mut assembly = read_asset(path, &Where::Nowhere, options)?;
    assembly.notes.extend(light_units::note(&assembly, options.light_units));
    let Some((beside, sidecar)) = beside(path, || assembly.carries_optics())? else { return Ok((assembly, None)) };
    let text = format!("the asset carries no optical attributes; {} beside it is used", beside.display());
    assembly.notes.push(Note::info(Where::file(path), text));
    Ok((assembly, Some((beside, sidecar))))
}

/// The sidecar `NAME.optics.toml` beside an asset, if it is meant: the asset says nothing of itself, and the sidecar
/// names no other file. `carries` tells the former, and is asked only if there is a sidecar.
fn beside(path: &Path, carries: impl FnOnce() -> bool) -> Result<Option<(PathBuf, Value)>> {
    let file = path.with_extension("optics.toml");
    if !file.is_file() || carries() {
        return Ok(None);
    }
    let sidecar = toml::read(&file)?;
    let other = sidecar.get("asset").and_then(|value| Some(files::resolve(value.text()?, &value.at)));
    let same = |other: &Path| match (other.canonicalize(), path.canonicalize()) {
        (Ok(other), Ok(own)) => other == own,
        (_, _) => other == path,
    };
    Ok(other.is_none_or(|other| same(&other)).then_some((file, sidecar)))
}

/// The asset `path` as it was read, without any sidecar.
pub fn asset(path: &Path) -> Result<Assembly> {
    read_asset(path, &Where::Nowhere, &ReadOptions::default())
}

fn read_asset(path: &Path, at: &Where, options: &ReadOptions) -> Result<Assembly> {
    let extension = extension(path);
    if let Some(format) = FORMATS.iter().find(|format| format.extensions.contains(&extension.as_str())) {
        let mut assembly = (format.read)(path, options)?;
        light_units::take(&mut assembly, options.light_units);
        return Ok(assembly);
    }
    let known: Vec<String> =
        FORMATS.iter().flat_map(|format| format.extensions).map(|known| format!(".{known}")).collect();
    Err(Error::new(at.clone(), format!("{} is of no format that can be imported", path.display()))
        .expected(format!("{} or a sidecar .toml", known.join(", "))))
}

fn extension(path: &Path) -> String {
    path.extension().map(|extension| extension.to_string_lossy().to_lowercase()).unwrap_or_default()
}
