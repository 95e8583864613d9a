//! Files by name, also those inside of a package: `a.usdz[tex.png]`, `a.usdz[b.usdz[tex.png]]`.

use openusd::usdz::Archive;
use std::io::{Error, ErrorKind, Result};
use std::path::Path;

/// Packages inside of packages.
pub const MOST_NESTED: usize = 8;

/// The bytes of the file `path`.
///
/// # Errors
/// There is no such file, or no such entry in the package; an entry that is compressed; packages nested too deep.
pub fn read(path: &Path) -> Result<Vec<u8>> {
    match split(path) {
        Some((package, entries)) => entry(package, &entries),
        None => std::fs::read(path),
    }
}

/// Whether there is such a file, as a regular one or in a package.
pub fn is_file(path: &Path) -> bool {
    match split(path) {
        Some((package, entries)) => contains(package, &entries).unwrap_or(false),
        None => path.is_file(),
    }
}

/// The package on disk and the entries, outermost first, of a name that leads into a package.
fn split(path: &Path) -> Option<(&Path, Vec<&str>)> {
    if path.is_file() {
        return None;
    }
    let (package, rest) = path.to_str()?.split_once('[')?;
    let entries: Vec<&str> = rest.trim_end_matches(']').split('[').collect();
    // Each bracket that is opened is closed at the end.
    let closed = rest.len() - rest.trim_end_matches(']').len();
    let is_package = Path::new(package).extension().is_some_and(|extension| extension.eq_ignore_ascii_case("usdz"));
    (closed == entries.len() && is_package).then(|| (Path::new(package), entries))
}

/// The package with its names marked as UTF-8, if they are and are not marked: USD's own writer leaves the mark out, and
/// readers of ZIP files then take the first layer's name for code page 437 and do not find it. The layout: PKWARE,
/// APPNOTE.TXT 6.3, 4.3.12 (a header of the directory), 4.3.16 (its end), 4.4.4 (bit 11).
pub fn with_names_in_utf8(package: &[u8]) -> Option<Vec<u8>> {
    let word = |at: usize| Some(u16::from_le_bytes(package.get(at..at.checked_add(2)?)?.try_into().ok()?));
    let long = |at: usize| Some(u32::from_le_bytes(package.get(at..at.checked_add(4)?)?.try_into().ok()?));
    // The end of the directory, with a comment of at most 65,535 bytes behind it.
    let tail = package.len().saturating_sub(22 + usize::from(u16::MAX));
    let end = tail + package.get(tail..)?.windows(4).rposition(|four| four == b"PK\x05\x06")?;
    let (entries, mut at) = (word(end + 10)?, usize::try_from(long(end + 16)?).ok()?);
    let mut marks = Vec::new();
    for _ in 0..entries {
        if package.get(at..at.checked_add(4)?)? != b"PK\x01\x02" {
            break;
        }
        let lengths = [word(at + 28)?, word(at + 30)?, word(at + 32)?].map(usize::from);
        let name = package.get(at + 46..at.checked_add(46 + lengths[0])?)?;
        if !name.is_ascii() && std::str::from_utf8(name).is_ok() && package.get(at + 9)? & 8 == 0 {
            marks.push(at + 9);
        }
        at = at.checked_add(46 + lengths.iter().sum::<usize>())?;
    }
    if marks.is_empty() {
        return None;
    }
    let mut named = package.to_vec();
    for mark in marks {
        *named.get_mut(mark)? |= 8;
    }
    Some(named)
}

fn archive(package: &Path) -> Result<Archive> {
    // A device or a pipe has no end.
    if !std::fs::metadata(package)?.is_file() {
        return Err(Error::new(ErrorKind::InvalidInput, "this is no regular file"));
    }
    Archive::open(package).map_err(broken)
}

fn broken(error: impl std::fmt::Display) -> Error {
    Error::new(ErrorKind::InvalidData, error.to_string())
}

/// The archive that holds the last of `entries`, and its name.
fn innermost<'a>(package: &Path, entries: &[&'a str]) -> Result<(Archive, &'a str)> {
    let (last, between) = entries.split_last().ok_or_else(|| broken("no entry is named"))?;
    if between.len() > MOST_NESTED {
        return Err(broken(format!("packages nested more than {MOST_NESTED} deep")));
    }
    let mut archive = archive(package)?;
    for name in between {
        let bytes = archive.entry(name).map_err(broken)?;
        archive = Archive::from_bytes(bytes).map_err(broken)?;
    }
    Ok((archive, last))
}

fn entry(package: &Path, entries: &[&str]) -> Result<Vec<u8>> {
    let (mut archive, name) = innermost(package, entries)?;
    if !archive.contains(name) {
        return Err(Error::from(ErrorKind::NotFound));
    }
    Ok(archive.entry(name).map_err(broken)?.to_vec())
}

fn contains(package: &Path, entries: &[&str]) -> Result<bool> {
    let (archive, name) = innermost(package, entries)?;
    Ok(archive.contains(name))
}

#[cfg(test)]
mod tests {
    use super::*;
    use openusd::usdz::ArchiveWriter;
    use std::io::Cursor;

    fn package(entries: &[(&str, &[u8])]) -> Vec<u8> {
        let mut archive = ArchiveWriter::new(Cursor::new(Vec::new()));
        entries.iter().for_each(|(name, bytes)| archive.add_layer(name, bytes).unwrap());
        archive.finish().unwrap().into_inner()
    }

    #[test]
    fn entries_are_read_at_any_depth() {
        let folder = tempfile::tempdir().unwrap();
        let mut nested = package(&[("0/deep.png", b"deep")]);
        let inner = package(&[("x.usdz", &nested), ("tex.png", b"tex")]);
        std::fs::write(folder.path().join("a.usdz"), &inner).unwrap();
        std::fs::write(folder.path().join("odd[x].png"), b"odd").unwrap();
        let read = |name: &str| read(&folder.path().join(name)).map_err(|error| error.kind());
        assert_eq!(read("a.usdz[tex.png]").unwrap(), b"tex");
        assert_eq!(read("a.usdz[x.usdz[0/deep.png]]").unwrap(), b"deep");
        assert_eq!(read("odd[x].png").unwrap(), b"odd");
        assert!(is_file(&folder.path().join("a.usdz[tex.png]")));
        assert!(!is_file(&folder.path().join("a.usdz[no.png]")));
        for (name, kind) in [
            ("a.usdz[no.png]", ErrorKind::NotFound),
            ("b.usdz[tex.png]", ErrorKind::NotFound),
            ("a.usdz[tex.png", ErrorKind::NotFound),
            ("a.usdz[x.usdz[no]]", ErrorKind::NotFound),
            ("a.usdz[tex.png[no]]", ErrorKind::InvalidData),
        ] {
            assert_eq!(read(name), Err(kind), "{name}");
        }
        let mut name = "0/deep.png".to_owned();
        for _ in 0..MOST_NESTED + 2 {
            nested = package(&[("x.usdz", &nested)]);
            name = format!("x.usdz[{name}]");
        }
        std::fs::write(folder.path().join("c.usdz"), &nested).unwrap();
        assert_eq!(read(&format!("c.usdz[{name}]")), Err(ErrorKind::InvalidData));
        // Cut anywhere, it ends in an error.
        for length in 0..inner.len() {
            std::fs::write(folder.path().join("cut.usdz"), &inner[..length]).unwrap();
            assert!(read("cut.usdz[tex.png]").is_err(), "{length}");
        }
    }
}
