//! File names as URI references (RFC 3986).

use eyebox_base::relative_path::{relative, slashed};
use std::path::Path;

/// What stands before a URI that is relative to the folder `from` to make it relative to `to`: `../models/`, or nothing.
pub fn prefix(from: &Path, to: &Path) -> String {
    let way = relative(to, from);
    if way.as_os_str().is_empty() { String::new() } else { format!("{}/", encoded(&slashed(&way))) }
}

/// A file name with everything percent-encoded that must not stand in a path of a URI.
pub fn encoded(name: &str) -> String {
    let mut out = String::new();
    for byte in name.bytes() {
        if byte.is_ascii_alphanumeric() || b"-._~/!$&'()*+,;=@".contains(&byte) {
            out.push(char::from(byte));
        } else {
            out.push_str(&format!("%{byte:02X}"));
        }
    }
    out
}

/// Whether the URI names a file beside the asset.
pub fn is_relative(uri: &str) -> bool {
    let head = uri.split(['/', '?', '#']).next().unwrap_or("");
    !uri.is_empty() && !uri.starts_with('/') && !head.contains(':')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_encoded_and_schemes_seen() {
        assert_eq!(encoded("a b/ü%.bin"), "a%20b/%C3%BC%25.bin");
        assert!(is_relative("a/b:c.bin") && !is_relative("data:;base64,") && !is_relative("/x") && !is_relative(""));
    }
}
