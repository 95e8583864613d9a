//! Names that USD takes as prim names.

use std::collections::HashMap;

/// An identifier that looks like `name`: letters that every version of USD knows as such and digits are kept, anything
/// else becomes `_`; a digit does not come first; nothing at all becomes `fallback`.
///
/// ASCII and the letters below are in XID_Start of Unicode (Annex 31), which USD's UTF-8 identifiers are made of; the
/// rest of Unicode's letters is too, but for exceptions that would need the whole table.
pub fn identifier(name: &str, fallback: &str) -> String {
    let mut out: String = name.chars().map(|c| if letter(c) || c.is_ascii_digit() { c } else { '_' }).collect();
    if out.is_empty() {
        out.push_str(fallback);
    }
    if out.starts_with(|c: char| c.is_ascii_digit()) {
        out.insert(0, '_');
    }
    out
}

fn letter(c: char) -> bool {
    let known = matches!(c,
        '\u{aa}'..='\u{24f}'            // Latin
        | '\u{386}'..='\u{52f}'         // Greek, Cyrillic
        | '\u{3041}'..='\u{30ff}'       // Hiragana, Katakana
        | '\u{4e00}'..='\u{9fa5}'       // Chinese characters
        | '\u{ac00}'..='\u{d7a3}'       // Hangul
    );
    c == '_' || c.is_ascii_alphabetic() || known && c.is_alphabetic()
}

/// Names given so far to the children of one prim.
#[derive(Debug, Clone, Default)]
pub struct Siblings {
    /// The next number to try for a name that is taken.
    taken: HashMap<String, usize>,
}

impl Siblings {
    /// [`identifier`], with `_1`, `_2`, … where it is taken.
    pub fn name(&mut self, name: &str, fallback: &str) -> String {
        let wanted = identifier(name, fallback);
        if !self.taken.contains_key(&wanted) {
            self.taken.insert(wanted.clone(), 1);
            return wanted;
        }
        let mut number = self.taken.get(&wanted).copied().unwrap_or(1);
        loop {
            let candidate = format!("{wanted}_{number}");
            number = number.saturating_add(1);
            if !self.taken.contains_key(&candidate) {
                self.taken.insert(wanted, number);
                self.taken.insert(candidate.clone(), 1);
                return candidate;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_identifiers() {
        for (name, identifier_) in [
            ("LENS_01", "LENS_01"),
            ("2nd mirror", "_2nd_mirror"),
            ("", "Node"),
            ("Gehäuse", "Gehäuse"),
            ("レンズ", "レンズ"),
            ("a/b:c.d", "a_b_c_d"),
            ("½²Ⓐ", "___"),
            ("\u{0}\n\"", "___"),
            ("🔆", "_"),
        ] {
            assert_eq!(identifier(name, "Node"), identifier_);
            assert!(openusd::sdf::Path::is_valid_identifier(identifier_));
        }
    }

    #[test]
    fn siblings_differ() {
        let mut siblings = Siblings::default();
        let names: Vec<_> = ["a", "a", "a_1", "a", "a b", "a_b"].iter().map(|n| siblings.name(n, "Node")).collect();
        assert_eq!(names, ["a", "a_1", "a_1_1", "a_2", "a_b", "a_b_1"]);
    }

    #[test]
    fn many_equal_names_take_linear_time() {
        let mut siblings = Siblings::default();
        for _ in 0..200_000 {
            siblings.name("x", "Node");
        }
        assert_eq!(siblings.name("x", "Node"), "x_200000");
    }
}
