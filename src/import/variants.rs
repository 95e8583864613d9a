//! `--variant`: which of the variants of a prim is taken.

/// `PRIM{SET=NAME}`, as USD writes the paths of variants.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VariantChoice {
    /// An absolute path.
    pub prim: String,
    pub set: String,
    pub name: String,
}

impl VariantChoice {
    /// The slash before the path may be left out.
    pub fn parse(text: &str) -> Result<Self, String> {
        let bad = || format!("`{text}` names no variant; write PRIM{{SET=NAME}}, e.g. /car{{paint=red}}");
        let (prim, rest) = text.split_once('{').ok_or_else(bad)?;
        let (set, name) = rest.strip_suffix('}').and_then(|inner| inner.split_once('=')).ok_or_else(bad)?;
        let (prim, set, name) = (prim.trim().trim_start_matches('/'), set.trim(), name.trim());
        if [prim, set, name].iter().any(|word| word.is_empty() || word.contains(['{', '}', '='])) {
            return Err(bad());
        }
        Ok(VariantChoice { prim: format!("/{prim}"), set: set.to_owned(), name: name.to_owned() })
    }
}

impl std::fmt::Display for VariantChoice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}{{{}={}}}", self.prim, self.set, self.name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn choices_are_written_as_paths() {
        let found = VariantChoice::parse("a/b{ paint = red }").unwrap();
        assert_eq!(found.to_string(), "/a/b{paint=red}");
        assert_eq!(VariantChoice::parse("/a/b{paint=red}"), Ok(found));
        for bad in ["", "a", "a{b}", "{b=c}", "a{=c}", "a{b=}", "a{b=c", "a{b=c}{d=e}", "a{b=c=d}"] {
            assert!(VariantChoice::parse(bad).unwrap_err().contains("PRIM{SET=NAME}"), "{bad}");
        }
    }
}
