//! Reading the files that a scene is made of, with faults that name who asked for them.

use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Where, package};
use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::{Path, PathBuf};

/// The bytes of `path`, which may lie in a package and is a `kind` (`slide image`, …) that is named at `at`.
pub fn read(path: &Path, at: &Where, kind: &str) -> Result<Vec<u8>> {
    package::read(path).map_err(|error| unreadable(&error, path, at, kind))
}

/// The same of a regular file of at most so many bytes; `code`: of every fault.
pub fn read_at_most(path: &Path, at: &Where, kind: &str, (most, code): (u64, Code)) -> Result<Vec<u8>> {
    if let Ok(facts) = std::fs::metadata(path) {
        let what =
            |why: String| Error::new(at.clone(), format!("can't read the {kind} {}: {why}", path.display())).code(code);
        if !facts.is_file() {
            return Err(what("it is no regular file".into()));
        }
        if facts.len() > most {
            return Err(what(format!("it has {} bytes", facts.len())).expected(format!("at most {most}")));
        }
    }
    read(path, at, kind).map_err(|fault| fault.code(code))
}

fn unreadable(error: &io::Error, path: &Path, at: &Where, kind: &str) -> Box<Error> {
    let why = match error.kind() {
        ErrorKind::NotFound => "there is no such file".to_owned(),
        ErrorKind::PermissionDenied => "it must not be read (permission denied)".to_owned(),
        _ => error.to_string(),
    };
    Error::new(at.clone(), format!("can't read the {kind} {}: {why}", path.display())).code(Code::of_reading(error))
}

/// Adds the length of a file, as eight bytes, and its bytes. Faults: it can't be read.
pub fn hash(hasher: &mut blake3::Hasher, path: &Path, at: &Where, kind: &str) -> Result<()> {
    hashed(hasher, path).map_err(|error| unreadable(&error, path, at, kind))
}

/// Piece by piece: an asset may be large.
fn hashed(hasher: &mut blake3::Hasher, path: &Path) -> io::Result<()> {
    const PIECE: usize = 1 << 17;
    if !path.is_file() && package::is_file(path) {
        let all = package::read(path)?;
        hasher.update(&(all.len() as u64).to_le_bytes()).update(&all);
        return Ok(());
    }
    let mut file = File::open(path)?;
    let metadata = file.metadata()?;
    if !metadata.is_file() {
        // What is no regular file has no length until it was read.
        let mut all = Vec::new();
        file.read_to_end(&mut all)?;
        hasher.update(&(all.len() as u64).to_le_bytes()).update(&all);
        return Ok(());
    }
    let length = metadata.len();
    hasher.update(&length.to_le_bytes());
    let mut piece = vec![0; PIECE];
    let mut left = length;
    loop {
        let count = match file.read(&mut piece) {
            Ok(0) if left == 0 => return Ok(()),
            Ok(count) => count,
            Err(error) if error.kind() == ErrorKind::Interrupted => continue,
            Err(error) => return Err(error),
        };
        left = match left.checked_sub(count as u64) {
            Some(left) if count > 0 => left,
            _ => return Err(io::Error::other("its length changed while it was read")),
        };
        hasher.update(piece.get(..count).unwrap_or_default());
    }
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
