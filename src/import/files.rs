//! Reading the files that a scene is made of, with faults that name who asked for them.

use crate::base::fault::Result;
use crate::base::{Fault, Where};
use std::path::{Path, PathBuf};

/// The bytes of `path`, which is a `kind` (`slide image`, …) that is named at `at`.
pub fn read(path: &Path, at: &Where, kind: &str) -> Result<Vec<u8>> {
    std::fs::read(path).map_err(|error| {
        let why = match error.kind() {
            std::io::ErrorKind::NotFound => "there is no such file".to_owned(),
            std::io::ErrorKind::PermissionDenied => "it must not be read (permission denied)".to_owned(),
            _ => error.to_string(),
        };
        Fault::new(at.clone(), format!("can't read the {kind} {}: {why}", path.display()))
    })
}

/// Where `name` leads, written at `at`: relative names are relative to the file that names them, on the command line to
/// the working directory.
pub fn resolve(name: &str, at: &Where) -> PathBuf {
    let base = match at {
        Where::File(file) | Where::Line { file, .. } | Where::Pointer { file, .. } | Where::Prim { file, .. } => {
            file.parent()
        }
        Where::Nowhere | Where::Part { .. } | Where::Option(_) => None,
    };
    base.map_or_else(|| PathBuf::from(name), |folder| folder.join(name))
}
