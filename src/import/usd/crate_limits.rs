//! Crate files (`.usdc`) that ask for more memory than they can honestly need: their arrays are compressed twice, so that
//! a byte can stand for a thousand integers. The counts are looked at before the library decodes anything.

use openusd::ar::{AssetBuffer, SharedBuffer};
use openusd::usdc::{CrateFile, version};

const MAGIC: &[u8] = b"PXR-USDC";
/// Entries of the tables and elements of an array that any file may have, and how many more for each byte of it. An array
/// of one and the same delta is honest (all polygons have four corners), but other data of its length lie beside it.
const LEAST: u64 = 1 << 22;
const PER_BYTE: u64 = 64;
/// At most 1 GiB of 32-bit integers.
const MOST: u64 = 1 << 28;
/// The type of a value that holds samples (the enumeration of the format: crateDataTypes.h of OpenUSD).
const TIME_SAMPLES: u64 = 46;

/// Looks at each crate file in `bytes`, which may be one or a package of several.
///
/// # Errors
/// A count that is larger than what a file of this size can hold.
pub(super) fn check(whole: &SharedBuffer) -> Result<(), String> {
    let bytes: &[u8] = whole;
    let mut from = 0;
    while let Some(found) = find(bytes.get(from..).unwrap_or_default()) {
        let own = bytes.get(from + found..).unwrap_or_default();
        // In a package the name may be part of other data; its layers are looked at one by one.
        if from + found == 0 {
            is_read(own)?;
        }
        let file =
            Crate { bytes: own, most: (own.len() as u64).saturating_mul(PER_BYTE).saturating_add(LEAST).min(MOST) };
        file.sections()?;
        file.arrays(whole.slice(from + found..bytes.len()))?;
        if from + found == 0 {
            break; // not a package
        }
        from += found + MAGIC.len();
    }
    Ok(())
}

/// The first version with compressed tables, which the library reads from.
const OLDEST: [u8; 3] = [0, 4, 0];

/// Refuses versions that the library would call damaged.
fn is_read(bytes: &[u8]) -> Result<(), String> {
    match bytes.get(MAGIC.len()..MAGIC.len() + OLDEST.len()) {
        Some(own @ [major, minor, patch]) if *own < OLDEST[..] => {
            let [a, b, c] = OLDEST;
            Err(format!(
                "a crate file of version {major}.{minor}.{patch}: expected {a}.{b}.{c} or later; usdcat writes it anew"
            ))
        }
        Some(_) | None => Ok(()),
    }
}

fn find(bytes: &[u8]) -> Option<usize> {
    // The first byte alone is found quickly.
    let mut from = 0;
    loop {
        from += bytes.get(from..)?.iter().position(|&byte| byte == MAGIC[0])?;
        if bytes.get(from..)?.starts_with(MAGIC) {
            return Some(from);
        }
        from += 1;
    }
}

struct Crate<'a> {
    bytes: &'a [u8],
    most: u64,
}

impl Crate<'_> {
    fn word(&self, at: u64) -> Option<u64> {
        let at = usize::try_from(at).ok()?;
        let word = self.bytes.get(at..at.checked_add(8)?)?;
        Some(u64::from_le_bytes(word.try_into().ok()?))
    }

    fn fits(&self, what: &str, count: u64) -> Result<(), String> {
        if count <= self.most {
            return Ok(());
        }
        let (most, bytes) = (self.most, self.bytes.len());
        Err(format!("{what} of {count} entries: expected at most {most} in a file of {bytes} bytes"))
    }

    /// The tables of the file; what cannot be read here is the library's to refuse.
    fn sections(&self) -> Result<(), String> {
        let Some(table) = self.word(16) else { return Ok(()) };
        let count = self.word(table).unwrap_or(0).min(64);
        for entry in (0..count).map(|entry| table.saturating_add(8 + 32 * entry)) {
            let Some(start) = self.word(entry.saturating_add(16)) else { break };
            let name: Vec<u8> =
                self.word(entry).unwrap_or(0).to_le_bytes().into_iter().take_while(|&b| b != 0).collect();
            let name = String::from_utf8_lossy(&name);
            self.fits(&format!("the table {name}"), self.word(start).unwrap_or(0))?;
            if matches!(&*name, "TOKENS" | "PATHS") {
                self.fits(&format!("the table {name}"), self.word(start.saturating_add(8)).unwrap_or(0))?;
            }
        }
        Ok(())
    }

    /// The compressed arrays among the values.
    fn arrays(&self, view: Option<SharedBuffer>) -> Result<(), String> {
        let Some(view) = view else { return Ok(()) };
        // What does not open will not open the second time.
        let Ok(file) = CrateFile::open(AssetBuffer::Shared(view)) else { return Ok(()) };
        let (is_shaped, is_wide) = (file.version() < version(0, 5, 0), file.version() >= version(0, 7, 0));
        let array = |rep: u64| {
            // The layout of a value: array, inlined, compressed, …, type in bits 48 to 55, place in the rest.
            let (is_array, is_compressed, place) = (rep >> 63 == 1, rep >> 61 & 1 == 1, rep & ((1 << 48) - 1));
            if !is_array || !is_compressed {
                return Ok(());
            }
            let count = self.word(place.saturating_add(if is_shaped { 4 } else { 0 })).unwrap_or(0);
            self.fits("an array", if is_wide { count } else { count & u64::from(u32::MAX) })
        };
        for field in &file.fields {
            let rep = field.value_rep.0;
            array(rep)?;
            if rep >> 48 & 0xFF == TIME_SAMPLES {
                let place = rep & ((1 << 48) - 1);
                let Some(times) = self.word(place).and_then(|jump| place.checked_add(jump)) else { continue };
                let place = times.saturating_add(8);
                let Some(values) = self.word(place).and_then(|jump| place.checked_add(jump)) else { continue };
                let count = self.word(values).unwrap_or(0).min(self.bytes.len() as u64 / 8);
                for sample in 1..=count {
                    array(self.word(values.saturating_add(8 * sample)).unwrap_or(0))?;
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file with one section whose table claims `count` entries.
    fn file(name: &[u8; 8], count: u64) -> Vec<u8> {
        let mut out = MAGIC.to_vec();
        // Version 0.9.0, the place of the table of contents, 0; one section.
        for word in [0x0900, 32, 0, 1] {
            out.extend_from_slice(&u64::to_le_bytes(word));
        }
        out.extend_from_slice(name);
        for word in [0, 72, 8, count] {
            out.extend_from_slice(&u64::to_le_bytes(word));
        }
        out
    }

    #[test]
    fn tables_fit_their_file() {
        let check = |bytes: Vec<u8>| check(&AssetBuffer::Owned(bytes).into_shared());
        assert_eq!(check(file(b"SPECS\0\0\0", 1000)), Ok(()));
        let fault = check(file(b"SPECS\0\0\0", 1 << 30)).unwrap_err();
        assert!(fault.starts_with("the table SPECS of 1073741824 entries"), "{fault}");
        let package = [b"PK\x03\x04".as_slice(), &file(b"FIELDS\0\0", 1 << 30)].concat();
        assert!(check(package).unwrap_err().contains("FIELDS"));
        assert_eq!(check(b"PXR-USDC".to_vec()), Ok(()));
        let old = check([MAGIC, &[0, 0, 1, 0, 0]].concat()).unwrap_err();
        assert!(old.starts_with("a crate file of version 0.0.1: expected 0.4.0 or later"), "{old}");
    }
}
