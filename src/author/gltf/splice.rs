//! Edits of JSON text that leave every other byte as it is: where the values stand, and what is put in their place.
//!
//! The text was parsed before, so that it is known to be JSON of at most 128 levels; a scan of anything else ends
//! nowhere rather than in a panic.

use serde_json::Value as Json;
use std::ops::Range;

/// A text with edits to come.
#[derive(Debug)]
pub struct Splice<'a> {
    text: &'a str,
    /// What is replaced by what, in the order of asking.
    edits: Vec<(Range<usize>, String)>,
}

/// The value of an object's entry, or of a list's element.
pub type Span = Range<usize>;

impl<'a> Splice<'a> {
    pub fn new(text: &'a str) -> Self {
        Splice { text, edits: Vec::new() }
    }

    /// The whole document.
    pub fn document(&self) -> Option<Span> {
        let start = self.blank(0);
        Some(start..self.end(start)?)
    }
    pub fn text(&self, span: &Span) -> &'a str {
        self.text.get(span.clone()).unwrap_or("")
    }

    /// The entries of the object at `span`, with their keys unescaped.
    pub fn entries(&self, span: &Span) -> Vec<(String, Span)> {
        let mut all = Vec::new();
        if self.byte(span.start) != Some(b'{') {
            return all;
        }
        let mut at = self.blank(span.start + 1);
        while self.byte(at) == Some(b'"') {
            let Some(end) = self.end(at) else { break };
            let key = serde_json::from_str(self.text(&(at..end))).unwrap_or_default();
            // Past the colon.
            let value = self.blank(self.blank(end) + 1);
            let Some(end) = self.end(value) else { break };
            all.push((key, value..end));
            at = self.blank(self.blank(end) + 1);
        }
        all
    }
    /// The entry `key`; the last of several, which is the one that holds.
    pub fn entry(&self, span: &Span, key: &str) -> Option<Span> {
        self.entries(span).into_iter().rfind(|(own, _)| own == key).map(|(_, span)| span)
    }
    /// The elements of the list at `span`.
    pub fn elements(&self, span: &Span) -> Vec<Span> {
        let mut all = Vec::new();
        if self.byte(span.start) != Some(b'[') {
            return all;
        }
        let mut at = self.blank(span.start + 1);
        while self.byte(at).is_some_and(|byte| byte != b']') {
            let Some(end) = self.end(at) else { break };
            all.push(at..end);
            let comma = self.blank(end);
            if self.byte(comma) != Some(b',') {
                break;
            }
            at = self.blank(comma + 1);
        }
        all
    }

    /// Puts `json` at `span`.
    pub fn replace(&mut self, span: Span, json: String) {
        self.edits.push((span, json));
    }
    /// Adds an entry at the end of the object at `span`.
    pub fn add_entry(&mut self, span: &Span, key: &str, json: &str) {
        let last = self.entries(span).pop().map(|(_, span)| span.end);
        self.add(span, last, format!("{}:{json}", Json::from(key)));
    }
    /// Adds an element at the end of the list at `span`.
    pub fn add_element(&mut self, span: &Span, json: &str) {
        let last = self.elements(span).pop().map(|span| span.end);
        self.add(span, last, json.to_owned());
    }
    fn add(&mut self, span: &Span, last: Option<usize>, json: String) {
        let at = last.unwrap_or(span.start + 1);
        // Something that is added here already makes this one more.
        let first = last.is_none() && !self.edits.iter().any(|(edit, _)| *edit == (at..at));
        self.edits.push((at..at, if first { json } else { format!(",{json}") }));
    }

    /// The text with all edits.
    pub fn finish(mut self) -> String {
        self.edits.sort_by_key(|(span, _)| span.start);
        let mut out =
            String::with_capacity(self.text.len() + self.edits.iter().map(|(_, new)| new.len()).sum::<usize>());
        let mut at = 0;
        for (span, new) in &self.edits {
            out.push_str(self.text.get(at..span.start).unwrap_or(""));
            out.push_str(new);
            at = span.end;
        }
        out.push_str(self.text.get(at..).unwrap_or(""));
        out
    }

    fn byte(&self, at: usize) -> Option<u8> {
        self.text.as_bytes().get(at).copied()
    }
    /// The first byte from `at` that is no white space.
    fn blank(&self, at: usize) -> usize {
        let rest = self.text.as_bytes().get(at..).unwrap_or(&[]);
        at + rest.iter().take_while(|byte| matches!(byte, b' ' | b'\t' | b'\n' | b'\r')).count()
    }
    /// The end of the value that starts at `at`.
    fn end(&self, at: usize) -> Option<usize> {
        let bytes = self.text.as_bytes();
        let (mut at, mut depth) = (at, 0usize);
        loop {
            match bytes.get(at)? {
                b'"' => {
                    at += 1;
                    while *bytes.get(at)? != b'"' {
                        at += if bytes[at] == b'\\' { 2 } else { 1 };
                    }
                    at += 1;
                }
                b'{' | b'[' => {
                    depth += 1;
                    at += 1;
                }
                b'}' | b']' => {
                    depth = depth.checked_sub(1)?;
                    at += 1;
                }
                b',' | b':' | b' ' | b'\t' | b'\n' | b'\r' if depth > 0 => at += 1,
                _ => {
                    let rest = bytes.get(at..)?;
                    let length = rest.iter().take_while(|byte| !b",:]}[{\" \t\n\r".contains(byte)).count();
                    if length == 0 {
                        return None;
                    }
                    at += length;
                }
            }
            if depth == 0 {
                return Some(at);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ODD: &str = " {\"a\" :[ 1.50 ,{}, \"x]\\\"\" ]\r\n, \"b\\u0063\":{ \"k\":\t1e+2 } ,\"e\":{ },\"a2\":[ ]} ";

    #[test]
    fn values_are_found_whatever_stands_between() {
        let splice = Splice::new(ODD);
        let document = splice.document().unwrap();
        let keys: Vec<String> = splice.entries(&document).into_iter().map(|(key, _)| key).collect();
        assert_eq!(keys, ["a", "bc", "e", "a2"]);
        let list = splice.entry(&document, "a").unwrap();
        let texts: Vec<&str> = splice.elements(&list).iter().map(|span| splice.text(span)).collect();
        assert_eq!(texts, ["1.50", "{}", "\"x]\\\"\""]);
    }

    #[test]
    fn only_what_is_edited_changes() {
        let mut splice = Splice::new(ODD);
        let document = splice.document().unwrap();
        let (b, e) = (splice.entry(&document, "bc").unwrap(), splice.entry(&document, "e").unwrap());
        let lists = ["a", "a2"].map(|key| splice.entry(&document, key).unwrap());
        splice.replace(splice.entry(&b, "k").unwrap(), "7".into());
        splice.add_entry(&e, "x", "1");
        splice.add_entry(&e, "y", "2");
        splice.add_entry(&document, "z", "[]");
        splice.add_element(&lists[0], "true");
        splice.add_element(&lists[1], "false");
        let out = splice.finish();
        let wanted = ODD
            .replace("1e+2", "7")
            .replace("{ }", "{\"x\":1,\"y\":2 }")
            .replace("\\\"\" ]", "\\\"\",true ]")
            .replace(":[ ]}", ":[false ],\"z\":[]}");
        assert_eq!(out, wanted);
        assert!(serde_json::from_str::<Json>(&out).is_ok());
    }

    #[test]
    fn broken_text_ends_nowhere() {
        for broken in ["", "{", "{\"a\"", "{\"a\":", "[1,", "\"x", "{\"a\":}", "[\"\\"] {
            let splice = Splice::new(broken);
            let span = splice.document().unwrap_or(0..broken.len());
            let _ = (splice.entries(&span), splice.elements(&span));
        }
    }
}
