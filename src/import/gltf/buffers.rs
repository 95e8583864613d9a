//! The bytes behind the buffers: the binary chunk, `data:` URIs, and files beside the asset.

use super::at::At;
use eyebox_base::Code;
use eyebox_base::error::Result;
use std::borrow::Cow;
use std::collections::HashMap;
use std::io::Read;
use std::path::PathBuf;

#[derive(Debug)]
pub(super) struct Buffers<'a> {
    /// The bytes of each buffer, exactly `byteLength` of them; none if the asset says of no place where they are.
    pub data: Vec<Option<Slice>>,
    store: Vec<Cow<'a, [u8]>>,
    /// External files that were read.
    pub files: Vec<PathBuf>,
}

/// The first `length` bytes of a stored block: buffers over the same file share the block.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slice {
    block: usize,
    length: usize,
}

impl<'a> Buffers<'a> {
    pub fn bytes(&self, slice: Slice) -> &[u8] {
        self.store.get(slice.block).and_then(|block| block.get(..slice.length)).unwrap_or_default()
    }
    /// All bytes that were read or decoded.
    pub fn total(&self) -> usize {
        self.store.iter().map(|block| block.len()).sum()
    }

    /// Loads all buffers of the document `root`. No more is read of an external file than the largest `byteLength`
    /// that a buffer claims of it.
    ///
    /// # Errors
    /// A file that is missing, not a regular file, or shorter than claimed; a URI that is not relative; broken base64.
    pub fn load(root: &At<'_>, bin: Option<&'a [u8]>) -> Result<Self> {
        let list = root.list("buffers")?;
        let mut claims: HashMap<PathBuf, usize> = HashMap::new();
        let mut sources = Vec::with_capacity(list.len());
        for (index, at) in list.iter().enumerate() {
            let claim = at.want("byteLength")?;
            let length = claim.count()?;
            let source = match at.get("uri")? {
                Some(uri) => {
                    let text = uri.text()?;
                    match data_scheme(text) {
                        Some(rest) => Source::Data(uri, rest),
                        None => {
                            let path = resolve(&uri, text)?;
                            let most = claims.entry(path.clone()).or_default();
                            *most = length.max(*most);
                            Source::File(uri, path)
                        }
                    }
                }
                None if index == 0 && bin.is_some() => Source::Chunk,
                None => Source::Nowhere,
            };
            sources.push((claim, length, source));
        }
        let mut buffers = Buffers { data: Vec::with_capacity(list.len()), store: Vec::new(), files: Vec::new() };
        let mut loaded: HashMap<PathBuf, usize> = HashMap::new();
        for (claim, length, source) in sources {
            let (block, what) = match source {
                Source::Nowhere => {
                    buffers.data.push(None);
                    continue;
                }
                Source::Chunk => (buffers.keep(Cow::Borrowed(bin.unwrap_or_default())), "the binary chunk".to_owned()),
                Source::Data(uri, rest) => (buffers.keep(Cow::Owned(data_uri(&uri, rest)?)), "the URI".to_owned()),
                Source::File(uri, path) => {
                    let block = match loaded.get(&path) {
                        Some(&block) => block,
                        None => {
                            let most = claims.get(&path).copied().unwrap_or(length);
                            let block = buffers.keep(Cow::Owned(read(&uri, &path, most)?));
                            buffers.files.push(path.clone());
                            loaded.insert(path, block);
                            block
                        }
                    };
                    (block, "the file".to_owned())
                }
            };
            let there = buffers.store.get(block).map_or(0, |block| block.len());
            if length > there {
                return Err(claim.fault(format!("the buffer claims {length} bytes, {what} has {there}")));
            }
            buffers.data.push(Some(Slice { block, length }));
        }
        Ok(buffers)
    }

    /// A further buffer with these bytes; its index.
    pub fn add(&mut self, bytes: Vec<u8>) -> usize {
        let length = bytes.len();
        let block = self.keep(Cow::Owned(bytes));
        self.data.push(Some(Slice { block, length }));
        self.data.len() - 1
    }

    fn keep(&mut self, block: Cow<'a, [u8]>) -> usize {
        self.store.push(block);
        self.store.len() - 1
    }
}

enum Source<'a> {
    Nowhere,
    Chunk,
    Data(At<'a>, &'a str),
    File(At<'a>, PathBuf),
}

/// What follows `data:`, in whatever case (RFC 3986, section 3.1).
pub(super) fn data_scheme(uri: &str) -> Option<&str> {
    let (head, rest) = uri.split_at_checked(5)?;
    head.eq_ignore_ascii_case("data:").then_some(rest)
}

/// The path of a relative URI reference, percent-decoded (RFC 3986), beside the asset. Where no such file is there, and one
/// of the name that its writer may have meant is, that one: the name as it is written (`10%.bin`, `a?.bin`), without what
/// follows a `?` or `#`, with `\` between folders.
pub(super) fn resolve(uri: &At<'_>, text: &str) -> Result<PathBuf> {
    let scheme = text.split(['/', '?', '#']).next().is_some_and(|head| head.contains(':'));
    if text.is_empty() || scheme || text.starts_with('/') {
        return Err(uri.fault("this URI cannot be read").expected("a data: URI or a path relative to the asset"));
    }
    let wrong = || uri.fault("broken percent-encoding in the URI").expected("%XX with two hexadecimal digits, UTF-8");
    let folder = uri.file.parent().map(PathBuf::from).unwrap_or_default();
    let decoded = |text: &str| String::from_utf8(unescape(text)?).ok();
    let beside = |relative: &str| folder.join(relative.trim_start_matches('/'));
    let proper = decoded(text).map(|relative| beside(&relative));
    if let Some(path) = proper.as_ref().filter(|path| path.exists()) {
        return Ok(path.clone());
    }
    let bare = text.split(['?', '#']).next().unwrap_or(text);
    let slashed = decoded(text).map(|relative| relative.replace('\\', "/"));
    // Nobody writes a way out of the folder by mistake.
    let slashed = slashed.filter(|relative| relative.split('/').all(|step| step != ".."));
    let others = [Some(text.to_owned()), decoded(bare), slashed];
    let meant = others.into_iter().flatten().filter(|name| !name.is_empty()).map(|name| beside(&name));
    meant.into_iter().find(|path| path.is_file()).or(proper).ok_or_else(wrong)
}

/// At most `most` bytes of a regular file. (Opening a pipe would wait for ever, a device has no end.)
fn read(uri: &At<'_>, path: &std::path::Path, most: usize) -> Result<Vec<u8>> {
    let failed = |error: std::io::Error| {
        uri.fault(format!("cannot read {}: {error}", path.display())).code(Code::of_reading(&error))
    };
    if !std::fs::metadata(path).map_err(failed)?.is_file() {
        return Err(uri.fault(format!("{} is not a regular file", path.display())));
    }
    let mut bytes = Vec::new();
    let file = std::fs::File::open(path).map_err(failed)?;
    file.take(u64::try_from(most).unwrap_or(u64::MAX)).read_to_end(&mut bytes).map_err(failed)?;
    Ok(bytes)
}

/// The bytes of a `data:` URI (RFC 2397): base64, or percent-encoded.
pub(super) fn data_uri(uri: &At<'_>, rest: &str) -> Result<Vec<u8>> {
    let form = || uri.fault("this data: URI cannot be read").expected("data:application/octet-stream;base64,…");
    let (head, body) = rest.split_once(',').ok_or_else(form)?;
    // Words of media types are the same in whatever case (RFC 2045, section 2).
    let end = head.len().checked_sub(";base64".len()).and_then(|from| head.get(from..));
    if end.is_some_and(|end| end.eq_ignore_ascii_case(";base64")) {
        return base64(body).ok_or_else(|| uri.fault("broken base64 in the data: URI"));
    }
    unescape(body).ok_or_else(form)
}

/// Undoes percent-encoding (RFC 3986, section 2.1).
fn unescape(text: &str) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.bytes();
    while let Some(byte) = rest.next() {
        if byte == b'%' {
            let mut digit = || rest.next().and_then(|c| char::from(c).to_digit(16));
            bytes.push((digit()? * 16 + digit()?) as u8);
        } else {
            bytes.push(byte);
        }
    }
    Some(bytes)
}

/// Decodes base64 with the standard alphabet (RFC 4648, section 4); the padding may be left out.
fn base64(text: &str) -> Option<Vec<u8>> {
    let text = text.trim_end_matches('=').as_bytes();
    let mut out = Vec::with_capacity(text.len() / 4 * 3 + 2);
    for group in text.chunks(4) {
        let mut word = 0u32;
        for &c in group {
            let six = match c {
                b'A'..=b'Z' => c - b'A',
                b'a'..=b'z' => c - b'a' + 26,
                b'0'..=b'9' => c - b'0' + 52,
                b'+' => 62,
                b'/' => 63,
                _ => return None,
            };
            word = word << 6 | u32::from(six);
        }
        // 2, 3, 4 letters hold 1, 2, 3 bytes; a single letter holds none.
        let bits = group.len() * 6;
        let whole = bits / 8;
        if whole == 0 {
            return None;
        }
        let word = word << (24 - bits);
        out.extend_from_slice(word.to_be_bytes().get(1..=whole)?);
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The test vectors of RFC 4648, section 10.
    #[test]
    fn base64_vectors() {
        let vectors =
            [("", ""), ("Zg==", "f"), ("Zm8=", "fo"), ("Zm9v", "foo"), ("Zm9vYg==", "foob"), ("Zm9vYmFy", "foobar")];
        for (text, want) in vectors {
            assert_eq!(base64(text).as_deref(), Some(want.as_bytes()), "{text}");
        }
        assert_eq!(base64("+/+/").unwrap(), [0xFB, 0xFF, 0xBF]);
        assert_eq!(base64("Zg"), Some(b"f".to_vec()));
        for broken in ["Z", "Zm9vY", "Zm 9", "Zm9-", "=Zm9v", "Zm9vé"] {
            assert_eq!(base64(broken), None, "{broken}");
        }
    }

    #[test]
    fn data_uris_without_base64() {
        let json = serde_json::Value::Null;
        let at = At::root(std::path::Path::new("a.gltf"), &json);
        assert_eq!(data_uri(&at, "application/gltf-buffer,0%00%fFa").unwrap(), [b'0', 0, 255, b'a']);
        assert!(data_uri(&at, "application/gltf-buffer").is_err() && data_uri(&at, ",%0").is_err());
    }

    #[test]
    fn schemes_and_encodings_in_capitals() {
        let json = serde_json::Value::Null;
        let at = At::root(std::path::Path::new("a.gltf"), &json);
        let rest = data_scheme("DATA:application/octet-stream;BASE64,Zm9v").unwrap();
        assert_eq!(data_uri(&at, rest).unwrap(), b"foo");
        assert_eq!(data_uri(&at, "base64,Zm9v").unwrap(), b"Zm9v");
        assert_eq!((data_scheme("dat"), data_scheme("data.bin")), (None, None));
    }

    /// Names as exporters write them; each finds its file, and the proper reading is the first.
    #[test]
    fn names_that_are_no_proper_uris_find_their_file() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("sub")).unwrap();
        let json = serde_json::Value::Null;
        let asset = folder.path().join("a.gltf");
        let at = At::root(&asset, &json);
        for name in ["example 10%.bin", "sub/a.bin", "e.bin", "f?1.bin", "g h.bin", "g%20h.bin"] {
            std::fs::write(folder.path().join(name), name).unwrap();
        }
        for (uri, name) in [
            ("example 10%.bin", "example 10%.bin"),
            ("sub\\a.bin", "sub/a.bin"),
            ("sub%5Ca.bin", "sub/a.bin"),
            ("e.bin?v=3", "e.bin"),
            ("e.bin#x", "e.bin"),
            ("f?1.bin", "f?1.bin"),
            ("g%20h.bin", "g h.bin"),
        ] {
            assert_eq!(std::fs::read_to_string(resolve(&at, uri).unwrap()).unwrap(), name, "{uri}");
        }
        assert!(resolve(&at, "11%.bin").is_err());
    }

    #[test]
    fn uris_are_relative_and_decoded() {
        let json = serde_json::Value::Null;
        let at = At::root(std::path::Path::new("models/a.gltf"), &json);
        assert_eq!(resolve(&at, "sub%20dir/b%C3%BC.bin").unwrap(), PathBuf::from("models/sub dir/bü.bin"));
        for wrong in ["", "/etc/passwd", "http://example.org/a.bin", "file:///a.bin", "C:/a.bin", "a%2", "a%zz", "a%FF"]
        {
            assert!(resolve(&at, wrong).is_err(), "{wrong}");
        }
        // An absolute path cannot be smuggled in by percent-encoding its first slash.
        assert_eq!(resolve(&at, "%2Fetc/passwd").unwrap(), PathBuf::from("models/etc/passwd"));
    }
}
