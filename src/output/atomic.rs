//! A file is there completely or not at all.

use std::ffi::OsString;
use std::io::{self, Write};
use std::path::Path;

use crate::base::fault::{Fault, Result, Where};

/// Writes `bytes` under a temporary name (`NAME.tmpXXXXXX`) beside `path`, flushes them to disk and renames. A reader
/// never sees half a file, an existing file stays whole until the new one is complete, and on an error nothing is
/// left behind.
///
/// Errors: the directory is missing or not writable, the disk is full, `path` is a directory.
pub fn write_atomic(path: &Path, bytes: &[u8]) -> Result<()> {
    try_write(path, bytes)
        .map_err(|error| Fault::new(Where::file(path), format!("cannot be written: {error}")).expected(expected(path)))
}

fn try_write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let name = path.file_name().ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "no file name"))?;
    let directory = directory_of(path);
    let mut prefix = OsString::from(name);
    prefix.push(".tmp");
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix("");
    #[cfg(unix)]
    {
        // The temporary file becomes the result, so it gets what any new file gets: 0666 less the umask, not 0600.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.tempfile_in(directory)?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    file.persist(path).map_err(|error| error.error)?;
    Ok(())
}

fn directory_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        Some(_) | None => Path::new("."),
    }
}

fn expected(path: &Path) -> String {
    if path.is_dir() {
        return "a file name, not a directory".into();
    }
    let directory = directory_of(path);
    if directory.is_dir() {
        "a writable place with room on the disk".into()
    } else {
        format!("an existing directory, `{}` is none", directory.display())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entries(directory: &Path) -> Vec<String> {
        let mut names: Vec<_> = std::fs::read_dir(directory)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn replaces_whole_files_and_leaves_nothing_behind() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.exr");
        write_atomic(&path, b"one").unwrap();
        write_atomic(&path, b"two").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"two");
        // The rename onto a directory fails after the temporary file was written.
        let taken = directory.path().join("taken");
        std::fs::create_dir(&taken).unwrap();
        let fault = write_atomic(&taken, b"three").unwrap_err();
        assert!(fault.to_string().contains("not a directory"), "{fault}");
        let fault = write_atomic(&directory.path().join("absent/a.exr"), b"four").unwrap_err();
        assert!(fault.to_string().contains("existing directory"), "{fault}");
        assert!(write_atomic(Path::new("/"), b"five").is_err());
        assert_eq!(entries(directory.path()), ["a.exr", "taken"]);
    }

    #[cfg(unix)]
    #[test]
    fn the_file_has_the_permissions_of_a_new_file() {
        use std::os::unix::fs::PermissionsExt;
        let directory = tempfile::tempdir().unwrap();
        let (ours, plain) = (directory.path().join("ours"), directory.path().join("plain"));
        write_atomic(&ours, b"x").unwrap();
        std::fs::write(&plain, b"x").unwrap();
        let mode = |path: &Path| path.metadata().unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&plain));
    }
}
