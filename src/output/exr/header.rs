//! The headers of a file, byte by byte: the `exr` crate writes custom attributes in the order of a hash map,
//! which differs from process to process, and forgets the long-name flag for channels.
//! Layout: openexr.com, "OpenEXR File Layout": magic number (4), version and flags (4, little endian), attributes
//! (name, 0, type, 0, i32 size, value), 0; of several parts one header after the other, then another 0.

/// Bit 10 of the version field: names of attributes and channels may have 255 bytes instead of 31 (OpenEXR File Layout).
/// OpenEXR 3.5 was seen to read long channel names without it; other readers need not.
const LONG_NAMES: u8 = 0b100;
/// Bit 12: several parts.
const SEVERAL: u8 = 0b1_0000;
const VERSION_FLAGS: usize = 5;
const FIRST_ATTRIBUTE: usize = 8;

/// Sorts the attributes of each header by name. Their lengths keep, so the chunk offsets after the headers stay right.
/// `None` if the bytes are no complete headers.
pub fn sort_attributes(bytes: &mut [u8]) -> Option<()> {
    let several = *bytes.get(VERSION_FLAGS)? & SEVERAL != 0;
    let mut at = FIRST_ATTRIBUTE;
    loop {
        at = sort_header(bytes, at)?.checked_add(1)?;
        if !several || *bytes.get(at)? == 0 {
            return Some(());
        }
    }
}

/// Sorts one header that starts at `start`; tells where the 0 is that ends it.
fn sort_header(bytes: &mut [u8], start: usize) -> Option<usize> {
    let mut spans = Vec::new();
    let mut at = start;
    while *bytes.get(at)? != 0 {
        let start = at;
        let name_end = end_of_text(bytes, at)?;
        let type_end = end_of_text(bytes, name_end + 1)?;
        let value = type_end.checked_add(5)?;
        let size = i32::from_le_bytes(bytes.get(type_end + 1..value)?.try_into().ok()?);
        at = value.checked_add(usize::try_from(size).ok()?)?;
        spans.push((bytes.get(start..name_end)?.to_vec(), bytes.get(start..at)?.to_vec()));
    }
    spans.sort();
    let sorted: Vec<u8> = spans.into_iter().flat_map(|(_, attribute)| attribute).collect();
    bytes.get_mut(start..at)?.copy_from_slice(&sorted);
    Some(at)
}

/// Declares that names longer than 31 bytes occur.
pub fn set_long_names(bytes: &mut [u8]) -> Option<()> {
    *bytes.get_mut(VERSION_FLAGS)? |= LONG_NAMES;
    Some(())
}

/// The index of the 0 that ends the text starting at `from`.
fn end_of_text(bytes: &[u8], from: usize) -> Option<usize> {
    bytes.get(from..)?.iter().position(|byte| *byte == 0).map(|length| from + length)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn attribute(name: &str, value: &[u8]) -> Vec<u8> {
        let mut bytes = [name.as_bytes(), b"\0string\0"].concat();
        bytes.extend((value.len() as i32).to_le_bytes());
        bytes.extend(value);
        bytes
    }

    #[test]
    fn sorts_and_survives_any_cut() {
        let (a, b) = (attribute("a.long", b"\0\0zz"), attribute("b", b"1"));
        let head = [0x76, 0x2f, 0x31, 1, 2, 0, 0, 0];
        let make = |first: &[u8], second: &[u8]| [&head, first, second, &[0], b"rest"].concat();
        let mut bytes = make(&b, &a);
        sort_attributes(&mut bytes).unwrap();
        assert_eq!(bytes, make(&a, &b));
        for cut in 0..bytes.len() - 5 {
            assert_eq!(sort_attributes(&mut make(&b, &a)[..cut]), None, "cut at {cut}");
        }
        let mut two =
            [&[0x76, 0x2f, 0x31, 1, 2, SEVERAL, 0, 0], &b[..], &a, &[0], &b, &a, &[0], &[0], b"rest"].concat();
        sort_attributes(&mut two).unwrap();
        assert_eq!(two[8..], [&a[..], &b, &[0], &a, &b, &[0], &[0], b"rest"].concat());
        let mut hostile = make(&attribute("h", b""), &[]);
        let at = hostile.len() - 9;
        hostile[at..at + 4].copy_from_slice(&i32::MIN.to_le_bytes());
        assert_eq!(sort_attributes(&mut hostile), None);
    }
}
