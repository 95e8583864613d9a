//! Where in the text of a JSON document a value stands. The document may be broken: then as far as it can be followed.

/// Byte offset of the value that an RFC 6901 pointer leads to, or of the nearest one above it that is there. None for a
/// document without any value.
pub fn find(text: &[u8], pointer: &str) -> Option<usize> {
    let mut at = Cursor { text, at: 0 };
    at.blank();
    let mut best = at.peek().map(|_| at.at)?;
    for step in pointer.split('/').skip(1) {
        let step = step.replace("~1", "/").replace("~0", "~");
        if at.enter(&step).is_none() {
            break;
        }
        best = at.at;
    }
    Some(best)
}

struct Cursor<'t> {
    text: &'t [u8],
    at: usize,
}

impl Cursor<'_> {
    fn peek(&self) -> Option<u8> {
        self.text.get(self.at).copied()
    }
    fn blank(&mut self) {
        while self.peek().is_some_and(|byte| byte.is_ascii_whitespace()) {
            self.at += 1;
        }
    }
    fn take(&mut self, byte: u8) -> Option<()> {
        self.blank();
        (self.peek() == Some(byte)).then(|| self.at += 1)
    }

    /// Past the string that begins here; what is in it, still escaped.
    fn string(&mut self) -> Option<&[u8]> {
        self.take(b'"')?;
        let start = self.at;
        loop {
            match self.peek()? {
                b'"' => break,
                b'\\' => self.at += 2,
                _ => self.at += 1,
            }
        }
        let found = self.text.get(start..self.at)?;
        self.at += 1;
        Some(found)
    }

    /// Past the value that begins here. Depth is counted, not recursed.
    fn skip(&mut self) -> Option<()> {
        let mut depth = 0usize;
        loop {
            self.blank();
            match self.peek()? {
                b'"' => drop(self.string()?),
                b'{' | b'[' => {
                    depth += 1;
                    self.at += 1;
                }
                b'}' | b']' => {
                    depth = depth.checked_sub(1)?;
                    self.at += 1;
                }
                b',' | b':' if depth > 0 => self.at += 1,
                b',' | b':' => return None,
                _ => {
                    while self.peek().is_some_and(|byte| !b",:]}{[\"".contains(&byte) && !byte.is_ascii_whitespace()) {
                        self.at += 1;
                    }
                }
            }
            if depth == 0 {
                return Some(());
            }
        }
    }

    /// To the entry or the item `step` of the object or the list that begins here.
    fn enter(&mut self, step: &str) -> Option<()> {
        self.blank();
        match self.peek()? {
            b'{' => {
                self.at += 1;
                loop {
                    let key = self.string()?.to_vec();
                    self.take(b':')?;
                    self.blank();
                    if is(&key, step) {
                        return Some(());
                    }
                    self.skip()?;
                    self.take(b',')?;
                }
            }
            b'[' => {
                self.at += 1;
                let index: usize = step.parse().ok()?;
                for _ in 0..index {
                    self.skip()?;
                    self.take(b',')?;
                }
                self.blank();
                self.peek().filter(|byte| *byte != b']').map(|_| ())
            }
            _ => None,
        }
    }
}

/// Whether an escaped key is this text.
fn is(key: &[u8], text: &str) -> bool {
    if !key.contains(&b'\\') {
        return key == text.as_bytes();
    }
    let quoted = [b"\"", key, b"\""].concat();
    serde_json::from_slice::<String>(&quoted).is_ok_and(|key| key == text)
}

#[cfg(test)]
mod tests {
    use super::find;
    use proptest::prelude::*;

    #[test]
    fn values_and_what_is_left_of_them() {
        let text = r#" { "a": [ 1, {"b/c": "x]}\"", "d\u0065": null } , []], "e": {} }"#;
        let at = |pointer: &str| find(text.as_bytes(), pointer).map(|offset| &text[offset..]);
        assert!(at("").unwrap().starts_with("{ \"a\""));
        assert!(at("/a/1/b~1c").unwrap().starts_with("\"x]"));
        assert!(at("/a/1/de").unwrap().starts_with("null"));
        assert!(at("/a/2").unwrap().starts_with("[]]"));
        // The nearest above.
        assert!(at("/a/2/0").unwrap().starts_with("[]]"));
        assert!(at("/e/f/g").unwrap().starts_with("{} }"));
        assert!(at("/nothing").unwrap().starts_with("{ \"a\""));
        assert_eq!(find(b"  ", "/a"), None);
        // As deep as one likes.
        let deep = "[".repeat(1 << 20);
        assert_eq!(find(deep.as_bytes(), "/0/1"), Some(1));
    }

    proptest! {
        /// serde_json finds the same value.
        #[test]
        fn agrees_with_serde(list in prop::collection::vec(any::<(String, i32)>(), 1..6), pick in 0usize..6) {
            let entries: Vec<_> = list.iter().map(|(key, n)| serde_json::json!({ key: n, "z": [n] })).collect();
            let text = serde_json::to_string_pretty(&entries).unwrap();
            let pick = pick % list.len();
            let step = list[pick].0.replace('~', "~0").replace('/', "~1");
            let pointer = format!("/{pick}/{step}");
            let json: serde_json::Value = serde_json::from_str(&text).unwrap();
            let want = serde_json::to_string(json.pointer(&pointer).unwrap()).unwrap();
            let offset = find(text.as_bytes(), &pointer).unwrap();
            let got: String = text[offset..].chars().filter(|c| !c.is_whitespace()).collect();
            prop_assert!(got.starts_with(&want), "{} {}", got, want);
        }

        #[test]
        fn never_panics(bytes in prop::collection::vec(any::<u8>(), 0..64), pointer in "(/[a-c0-2]){0,4}") {
            let _ = find(&bytes, &pointer);
        }
    }
}
