//! Opening the stage, and what its layers say as a whole: unit, up axis, what could not be composed.

use super::attribute::{Moment, one_line};
use super::notes::Ledger;
use super::resolver::{Normalising, Opened};
use super::{sublayers, value};
use crate::assembly::{Assembly, StageFacts};
use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Where};
use eyebox_scene::Note;
use glam::{DMat3, DVec3};
use openusd::ar::Resolver;
use openusd::sdf;
use openusd::usd::Stage;
use std::path::{Path, PathBuf};

/// Opens the root layer and what it is composed of.
pub(super) fn open(file: &Path, opened: &Opened) -> Result<Stage> {
    let name = file
        .to_str()
        .ok_or_else(|| Error::new(Where::file(file), "the file's name is not valid UTF-8").expected("a UTF-8 name"))?;
    let resolver = Normalising::new(opened.clone());
    sublayers::gather(&resolver, &resolver.create_identifier(name, None))
        .map_err(|what| Error::new(Where::file(file), what))?;
    let stage = Stage::builder().resolver(resolver).open(name);
    stage.map_err(|error| {
        let at = match parse_line(&error) {
            Some(line) => Where::Line { file: file.to_owned(), line },
            None => Where::file(file),
        };
        Error::new(at, format!("cannot be opened as USD: {}", one_line(&error.to_string())))
    })
}

/// The line of a text layer that does not parse.
fn parse_line(error: &openusd::Error) -> Option<usize> {
    let mut cause: Option<&(dyn std::error::Error + 'static)> = Some(error);
    while let Some(found) = cause {
        if let Some(parse) = found.downcast_ref::<openusd::usda::ParseError>() {
            return Some(parse.line());
        }
        cause = found.source();
    }
    match error {
        openusd::Error::Parse(parse) => Some(parse.line()),
        openusd::Error::Format(sdf::FormatError::Decode(inner)) => {
            inner.downcast_ref::<openusd::usda::ParseError>().map(openusd::usda::ParseError::line)
        }
        _ => None,
    }
}

/// USD's up axes; the fallback is Y.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Up {
    Y,
    Z,
}

pub(super) fn up(text: &str) -> Option<Up> {
    match text {
        "Y" => Some(Up::Y),
        "Z" => Some(Up::Z),
        _ => None,
    }
}

/// What UsdGeom takes where `metersPerUnit` is not said: centimetres.
const FALLBACK_UNIT_M: f64 = 0.01;

/// Sets the assembly's unit and axes from the root layer.
pub(super) fn measures(stage: &Stage, moment: &Moment, assembly: &mut Assembly, ledger: &mut Ledger) -> Result<()> {
    let root = sdf::Path::abs_root();
    let metadata = |key: &str| stage.stage_metadata(key).map_err(|error| moment.failed(&root, error));
    let file = || Where::file(&moment.file);
    assembly.unit_m = match metadata("metersPerUnit")? {
        Some(found) => match value::number(&found) {
            Some(unit) if unit.is_finite() && unit > 0.0 => unit,
            _ => return Err(Error::new(file(), "`metersPerUnit` is no length").expected("a finite number > 0")),
        },
        None => {
            ledger.notes.add(Note::info(file(), "no `metersPerUnit`: 0.01, as USD says").code(Code::UnitUnsaid), 1);
            FALLBACK_UNIT_M
        }
    };
    let axis = match metadata("upAxis")? {
        Some(found) => match value::text(&found).and_then(up) {
            Some(axis) => axis,
            None => {
                ledger.warn(file(), "`upAxis` is no axis that USD knows (\"Y\" or \"Z\"): taken as \"Y\"");
                Up::Y
            }
        },
        None => Up::Y,
    };
    assembly.axes = match axis {
        Up::Y => DMat3::IDENTITY,
        // −90° about x: (x, y, z) → (x, z, −y).
        Up::Z => DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y),
    };
    Ok(())
}

/// What a layer over the stage has to know.
pub(super) fn facts(stage: &Stage, outermost: &mut Vec<String>) -> StageFacts {
    let metadata = |key: &str| stage.stage_metadata(key).ok().flatten();
    let times = ["startTimeCode", "endTimeCode", "timeCodesPerSecond"];
    StageFacts {
        default_prim: metadata("defaultPrim").as_ref().and_then(value::text).map(str::to_owned),
        times: times
            .into_iter()
            .filter_map(|key| Some((key, metadata(key).as_ref().and_then(value::number)?)))
            .collect(),
        instances: std::mem::take(outermost),
    }
}

/// What composition could not do, as warnings.
pub(super) fn note_errors(stage: &Stage, moment: &Moment, ledger: &mut Ledger) {
    const MOST: usize = 200;
    let errors = stage.composition_errors();
    for error in errors.iter().take(MOST) {
        ledger.warn(Where::file(&moment.file), format!("composition: {}", one_line(&error.to_string())));
    }
    if errors.len() > MOST {
        let more = errors.len() - MOST;
        ledger.warn(Where::file(&moment.file), format!("composition: {more} more errors"));
    }
}

/// The last element of a layer identifier: messages should not depend on where the asset lies.
pub(super) fn file_name(identifier: &str) -> &str {
    identifier.rsplit(['/', '\\']).next().unwrap_or(identifier)
}

/// The files that were opened, the asset first, named as the asset was: what lies in or below its folder is given
/// relative to the folder's own name in `file`.
pub(super) fn dependencies(file: &Path, opened: &Opened) -> Vec<PathBuf> {
    let folder = file.parent().unwrap_or(Path::new(""));
    let canonical = if folder.as_os_str().is_empty() { Path::new(".") } else { folder }.canonicalize().ok();
    let own = file.canonicalize().ok();
    let mut out = vec![file.to_owned()];
    for path in opened.files() {
        if own.as_deref() == Some(&path) {
            continue;
        }
        let below = canonical.as_deref().and_then(|canonical| path.strip_prefix(canonical).ok());
        out.push(below.map_or_else(|| path.clone(), |rest| folder.join(rest)));
    }
    out
}
