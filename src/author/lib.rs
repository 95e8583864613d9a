//! Floor 2: writers of assets. An [`Assembly`] as a new asset of another format, or an [`Annotation`] put into a copy of
//! the asset that it was made for. And the published schemas of the attribute vocabulary.

pub mod gltf; // .gltf and .glb
mod picture; // the files of pictures
pub mod schema; // JSON and USD schemas from the attribute table
mod tracks; // which frames of a motion are written
pub mod usd; // .usda, .usdc and .usdz

use eyebox_base::error::Result;
use eyebox_base::{Error, Where};
use eyebox_scene::Note;
use eyebox_scene::annotation::Annotation;
use eyebox_scene::assembly::Assembly;
use std::path::{Path, PathBuf};

/// What was written.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize)]
pub struct Written {
    /// The asset first, then what belongs to it.
    pub files: Vec<PathBuf>,
    /// What the format can't say.
    pub notes: Vec<Note>,
}

/// A format that assemblies can be written in. A new one is a module and a line in [`WRITERS`].
pub struct Writer {
    /// Lower-case file name extensions.
    pub extensions: &'static [&'static str],
    pub name: &'static str,
    /// Writes the whole assembly. File names in its attributes are relative to the folder of the new file already.
    pub write: fn(&Assembly, &Path) -> Result<Written>,
    /// Writes a copy of the asset `assembly.file`, which is of this format, with the rows of an annotation.
    pub annotate: fn(&Assembly, &Annotation, &Path) -> Result<Written>,
}

/// What can be written.
pub const WRITERS: &[Writer] = &[
    Writer { extensions: &["glb", "gltf"], name: "glTF 2.0", write: gltf::write, annotate: gltf::annotate },
    Writer { extensions: &["usda", "usdc", "usdz", "usd"], name: "USD", write: usd::write, annotate: usd::annotate },
];

/// Writes `assembly` to `out`, whose extension says the format. Faults: none is known; the file can't be written; what
/// the format can't hold.
pub fn convert(assembly: &Assembly, out: &Path) -> Result<Written> {
    (writer(out)?.write)(assembly, out)
}

/// Writes a copy of the asset `assembly.file` to `out`, with the rows of `annotation`. Faults: as for [`convert`], and
/// where `out` is of another format than the asset.
pub fn annotate(assembly: &Assembly, annotation: &Annotation, out: &Path) -> Result<Written> {
    let (own, new) = (writer(&assembly.file)?, writer(out)?);
    if own.name != new.name {
        let what = format!("an annotated copy of {} is {}, not {}", assembly.file.display(), own.name, new.name);
        return Err(Error::new(Where::file(out), what)
            .expected(format!("one of {}; `eyebox convert` changes the format", dotted(own.extensions))));
    }
    (own.annotate)(assembly, annotation, out)
}

fn writer(file: &Path) -> Result<&'static Writer> {
    let extension = file.extension().map(|extension| extension.to_string_lossy().to_lowercase()).unwrap_or_default();
    WRITERS.iter().find(|writer| writer.extensions.contains(&extension.as_str())).ok_or_else(|| {
        let known: Vec<String> = WRITERS.iter().map(|writer| dotted(writer.extensions)).collect();
        Error::new(Where::file(file), "is of no format that can be written").expected(known.join(", "))
    })
}

fn dotted(extensions: &[&str]) -> String {
    extensions.iter().map(|extension| format!(".{extension}")).collect::<Vec<_>>().join(", ")
}
