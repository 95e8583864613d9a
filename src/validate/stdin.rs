//! An asset on standard input. Readers open files, some of them more than once and some through a library; so it lies in a
//! file of the working directory while it is looked at, where its relative references lead, and is told by its content.
//! No report names that file.

use eyebox_base::{Error, Result, Where};
use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

/// What stands for standard input among the assets.
pub const NAMED: &str = "-";
/// How reports call it.
pub const SHOWN: &str = "<stdin>";
/// What its file's name begins with; no folder's asset.
pub const PREFIX: &str = ".eyebox-stdin-";

/// As much as a USD layer may have.
const MOST_BYTES: u64 = 4 << 30;

/// Standard input as a file, which goes away with this.
#[derive(Debug)]
pub struct Piped {
    file: tempfile::NamedTempFile,
    path: PathBuf,
    /// What its name is without an extension: names of scenes and parts come from it.
    stem: String,
}

impl Piped {
    /// Reads all of `from` into a file of the working directory, piece by piece.
    ///
    /// # Errors
    /// There is nothing to read, more than 4 GiB, or the working directory can't be written.
    pub fn read(from: &mut dyn Read) -> Result<Piped> {
        Piped::read_into(Path::new("."), from, MOST_BYTES)
    }

    fn read_into(folder: &Path, from: &mut dyn Read, most: u64) -> Result<Piped> {
        const PIECE: usize = 1 << 17;
        let failed = |error: std::io::Error| fault(format!("can't be read: {error}"));
        let mut piece = vec![0; PIECE];
        let mut filled = 0;
        // The first bytes tell the format, and a pipe gives as few as it likes.
        while filled < PIECE {
            match from.read(piece.get_mut(filled..).unwrap_or_default()) {
                Ok(0) => break,
                Ok(count) => filled += count,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(failed(error)),
            }
        }
        let first = piece.get(..filled).unwrap_or_default();
        if first.is_empty() {
            return Err(fault("is empty").expected("an asset (glTF, GLB, USD) or a sidecar"));
        }
        let unwritten = |error: std::io::Error| {
            let text = error.to_string();
            let why = text.split(" at path \"").next().unwrap_or(&text);
            fault(format!("can't be kept in the working directory, where its references lead: {why}"))
                .expected("a working directory that can be written")
        };
        let suffix = extension(first);
        let made = tempfile::Builder::new().prefix(PREFIX).suffix(suffix).tempfile_in(folder);
        let mut file = made.map_err(unwritten)?;
        file.write_all(first).map_err(unwritten)?;
        let room = most.saturating_sub(filled as u64);
        let copied = std::io::copy(&mut from.take(room.saturating_add(1)), &mut file).map_err(unwritten)?;
        if copied > room || filled as u64 > most {
            return Err(fault("is larger than 4 GiB").expected("an asset of at most 4 GiB"));
        }
        file.flush().map_err(unwritten)?;
        let name = file.path().file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let stem = name.strip_suffix(suffix).unwrap_or(&name).to_owned();
        let path = if folder == Path::new(".") { PathBuf::from(name) } else { file.path().to_owned() };
        Ok(Piped { file, path, stem })
    }

    /// The file that it lies in.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// `text` about the file as a text about standard input.
    pub fn unnamed(&self, text: &str) -> String {
        let name = self.file.path().file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let whole = std::env::current_dir().map(|folder| folder.join(&name).to_string_lossy().into_owned());
        let text = whole.map_or_else(|_| text.to_owned(), |whole| text.replace(&whole, SHOWN));
        text.replace(&name, SHOWN).replace(&self.stem, SHOWN)
    }
}

fn fault(what: impl Into<String>) -> Box<Error> {
    Error::new(Where::Option("standard input".to_owned()), what)
}

/// The file name extension of what begins like this; none for what is neither an asset nor text, as a sidecar is.
fn extension(first: &[u8]) -> &'static str {
    let text = first.strip_prefix("\u{feff}".as_bytes()).unwrap_or(first);
    let is_text = match std::str::from_utf8(text) {
        Ok(_) => true,
        // Cut off within a letter.
        Err(error) => error.error_len().is_none(),
    };
    match first {
        _ if first.starts_with(b"glTF") => ".glb",
        _ if first.starts_with(b"PXR-USDC") => ".usdc",
        _ if first.starts_with(b"PK\x03\x04") => ".usdz",
        _ if text.starts_with(b"#usda") || text.starts_with(b"#sdf") => ".usda",
        _ if text.trim_ascii_start().starts_with(b"{") => ".gltf",
        _ if is_text && !text.contains(&0) => ".optics.toml",
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pipe that gives a byte at a time.
    struct Drops<'a>(&'a [u8]);

    impl Read for Drops<'_> {
        fn read(&mut self, to: &mut [u8]) -> std::io::Result<usize> {
            self.0.read(to.get_mut(..1).unwrap_or_default())
        }
    }

    #[test]
    fn formats_are_told_by_their_content() {
        for (bytes, wanted) in [
            (&b"glTF\x02\0\0\0"[..], ".glb"),
            (b"PXR-USDC\0\x08", ".usdc"),
            (b"PK\x03\x04\n\0", ".usdz"),
            (b"#usda 1.0\n", ".usda"),
            (b" \n{ \"asset\": {} }", ".gltf"),
            ("\u{feff}{}".as_bytes(), ".gltf"),
            ("# µ\nschema = 1\n".as_bytes(), ".optics.toml"),
            // A letter that the piece cuts.
            (b"# \xc2", ".optics.toml"),
            (b"\x89PNG\r\n\x1a\n", ""),
            (b"a\0b", ""),
        ] {
            assert_eq!(extension(bytes), wanted, "{bytes:?}");
        }
    }

    #[test]
    fn it_is_a_file_for_a_while_and_has_a_limit() {
        let folder = tempfile::tempdir().unwrap();
        let files = || std::fs::read_dir(folder.path()).unwrap().count();
        let text = b"{ \"asset\": { \"version\": \"2.0\" } }";
        let piped = Piped::read_into(folder.path(), &mut Drops(text), text.len() as u64).unwrap();
        assert_eq!((std::fs::read(piped.path()).unwrap(), files()), (text.to_vec(), 1));
        let name = piped.path().file_name().unwrap().to_string_lossy().into_owned();
        assert!(name.starts_with(PREFIX) && name.ends_with(".gltf"), "{name}");
        let said = format!("./{name}: part {}/LENS", name.trim_end_matches(".gltf"));
        assert_eq!(piped.unnamed(&said), "./<stdin>: part <stdin>/LENS");
        drop(piped);
        let fault = |bytes: &[u8], most| {
            Piped::read_into(folder.path(), &mut Drops(bytes), most).map(drop).unwrap_err().to_string()
        };
        assert!(fault(text, text.len() as u64 - 1).starts_with("standard input: is larger"));
        assert!(fault(b"", 9).starts_with("standard input: is empty; expected an asset"));
        assert_eq!(files(), 0);
    }
}
