//! The container of a binary glTF.

/// A `.glb` (glTF 2.0, section 4.4) of its JSON and its buffer, both padded to four bytes already; no buffer if that is
/// empty. None if the file would pass the 4 GiB of the format.
pub fn container(text: &[u8], bytes: &[u8]) -> Option<Vec<u8>> {
    let binary = if bytes.is_empty() { 0 } else { bytes.len().checked_add(8)? };
    let length = text.len().checked_add(20)?.checked_add(binary)?;
    let mut out = Vec::with_capacity(length);
    out.extend(b"glTF");
    for word in [2, u32::try_from(length).ok()?, u32::try_from(text.len()).ok()?] {
        out.extend(word.to_le_bytes());
    }
    out.extend(b"JSON");
    out.extend(text);
    if !bytes.is_empty() {
        out.extend(u32::try_from(bytes.len()).ok()?.to_le_bytes());
        out.extend(b"BIN\0");
        out.extend(bytes);
    }
    Some(out)
}
