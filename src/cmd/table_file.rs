//! A table that a command writes beside what it prints: `.csv` or `.json`, by the file's name.

use crate::base::atomic::{check_writable, write_atomic};
use crate::base::document::document;
use crate::base::{Error, Result, Where};
use std::path::Path;

/// A file that a table goes to.
#[derive(Debug, Clone, Copy)]
pub enum TableFile<'p> {
    Csv(&'p Path),
    Json(&'p Path),
}

impl<'p> TableFile<'p> {
    /// By the name of the file. Fails early where it could not be written.
    pub fn of(path: &'p Path) -> Result<Self> {
        let ends = |with: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(with));
        let file = if ends("csv") {
            TableFile::Csv(path)
        } else if ends("json") {
            TableFile::Json(path)
        } else {
            return Err(
                Error::new(Where::file(path), "is no name for a table").expected("a name that ends in .csv or .json")
            );
        };
        check_writable(path)?;
        Ok(file)
    }

    /// Writes what the file's name asks for.
    pub fn write(self, csv: impl FnOnce() -> String, json: impl FnOnce() -> serde_json::Value) -> Result<()> {
        match self {
            TableFile::Csv(path) => write_atomic(path, csv().as_bytes()),
            TableFile::Json(path) => write_atomic(path, (document(json()) + "\n").as_bytes()),
        }
    }
}
