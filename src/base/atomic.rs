//! A file is there completely or not at all.

use std::ffi::OsString;
use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

use crate::error::{Error, Result, Where};

/// Writes `bytes` under a temporary name (`NAME.tmpXXXXXX`) beside `path`, flushes them to disk and renames. A reader
/// never sees half a file, an existing file stays whole until the new one is complete, and on an error nothing is
/// left behind.
///
/// Errors: the directory is missing or not writable, the disk is full, `path` is a directory or a read-only file.
pub fn write_atomic(path: &Path, bytes: &[u8]) -> Result<()> {
    write_atomic_by(path, |file| file.write_all(bytes))
}

/// The same with what `fill` writes into the empty file, for what is better not held in memory as a whole. Errors: its own,
/// too.
pub fn write_atomic_by(path: &Path, fill: impl FnOnce(&mut File) -> io::Result<()>) -> Result<()> {
    refuse(path)?;
    try_write(path, fill).map_err(|error| fault(path, &error))
}

/// Says before the work whether [`write_atomic`] can do its part. Leaves no trace; the disk may still fill up later.
///
/// Errors: those of [`write_atomic`].
pub fn check_writable(path: &Path) -> Result<()> {
    refuse(path)?;
    temporary(path).map(drop).map_err(|error| fault(path, &error))
}

/// A rename goes over a directory's owner's rights, not the file's own: those are asked here.
fn refuse(path: &Path) -> Result<()> {
    match path.metadata() {
        Ok(known) if known.is_dir() => Err(Error::new(Where::file(path), "is a folder").expected("a file name")),
        Ok(known) if known.permissions().readonly() => {
            Err(Error::new(Where::file(path), "is a read-only file").expected("another name, or a file to write to"))
        }
        // What can't be looked at is left to the attempt.
        Ok(_) | Err(_) => Ok(()),
    }
}

fn fault(path: &Path, error: &io::Error) -> Box<Error> {
    // `tempfile` adds ` at path "…"` with the temporary name, which nobody has heard of.
    let text = error.to_string();
    let why = text.split(" at path \"").next().unwrap_or(&text);
    Error::new(Where::file(path), format!("cannot be written: {why}")).expected(expected(path))
}

fn try_write(path: &Path, fill: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    let mut file = temporary(path)?;
    fill(file.as_file_mut())?;
    file.as_file().sync_all()?;
    file.persist(path).map_err(|error| error.error)?;
    Ok(())
}

/// An empty file beside `path`, which goes away unless it is renamed.
fn temporary(path: &Path) -> io::Result<tempfile::NamedTempFile> {
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
    builder.tempfile_in(directory)
}

fn directory_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        Some(_) | None => Path::new("."),
    }
}

fn expected(path: &Path) -> String {
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
        assert!(fault.to_string().ends_with("taken: is a folder; expected a file name"), "{fault}");
        let torn = |file: &mut File| file.write_all(b"fi").and_then(|()| Err(io::Error::other("torn off")));
        let fault = write_atomic_by(&path, torn).unwrap_err().to_string();
        assert!(fault.ends_with("a.exr: cannot be written: torn off; expected a writable place with room on the disk"));
        let absent = directory.path().join("absent/a.exr");
        for result in [write_atomic(&absent, b"four"), check_writable(&absent)] {
            let fault = result.unwrap_err().to_string();
            assert!(fault.contains("existing directory") && !fault.contains(".exr.tmp"), "{fault}");
        }
        check_writable(&path).unwrap();
        check_writable(&directory.path().join("new.exr")).unwrap();
        assert!(write_atomic(Path::new("/"), b"five").is_err());
        assert_eq!(entries(directory.path()), ["a.exr", "taken"]);
        assert_eq!(std::fs::read(&path).unwrap(), b"two");
    }

    #[test]
    fn a_read_only_file_is_not_replaced() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("kept.exr");
        std::fs::write(&path, b"kept").unwrap();
        let mut permissions = path.metadata().unwrap().permissions();
        permissions.set_readonly(true);
        std::fs::set_permissions(&path, permissions).unwrap();
        for result in [write_atomic(&path, b"new"), check_writable(&path)] {
            assert!(result.unwrap_err().to_string().contains("is a read-only file"));
        }
        assert_eq!(std::fs::read(&path).unwrap(), b"kept");
    }

    /// A folder that nobody can write to, root included.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_refused_folder_is_said_without_the_temporary_name() {
        let path = Path::new("/proc/a.exr");
        for result in [write_atomic(path, b"x"), check_writable(path)] {
            let fault = result.unwrap_err().to_string();
            assert!(fault.starts_with("/proc/a.exr: cannot be written: ") && !fault.contains(".exr.tmp"), "{fault}");
        }
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
