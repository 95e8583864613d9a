//! `--variant`: which of the variants of a prim is taken, or of the materials of a glTF asset.

/// One choice.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum VariantChoice {
    /// `PRIM{SET=NAME}`, as USD writes the paths of variants; `prim` is an absolute path.
    Prim { prim: String, set: String, name: String },
    /// A name of `KHR_materials_variants`, which holds for the whole asset.
    Materials(String),
}

impl VariantChoice {
    /// The slash before a prim's path may be left out.
    pub fn parse(text: &str) -> Result<Self, String> {
        let bad = || {
            format!(
                "`{text}` names no variant; write PRIM{{SET=NAME}}, e.g. /car{{paint=red}}, or the name of a variant of glTF"
            )
        };
        let Some((prim, rest)) = text.split_once('{') else {
            let name = text.trim();
            let plain = !name.is_empty() && !name.contains(['}', '=']);
            return if plain { Ok(VariantChoice::Materials(name.to_owned())) } else { Err(bad()) };
        };
        let (set, name) = rest.strip_suffix('}').and_then(|inner| inner.split_once('=')).ok_or_else(bad)?;
        let (prim, set, name) = (prim.trim().trim_start_matches('/'), set.trim(), name.trim());
        if [prim, set, name].iter().any(|word| word.is_empty() || word.contains(['{', '}', '='])) {
            return Err(bad());
        }
        Ok(VariantChoice::Prim { prim: format!("/{prim}"), set: set.to_owned(), name: name.to_owned() })
    }
}

impl std::fmt::Display for VariantChoice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            VariantChoice::Prim { prim, set, name } => write!(f, "{prim}{{{set}={name}}}"),
            VariantChoice::Materials(name) => f.write_str(name),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn choices_are_written_as_paths_or_names() {
        let found = VariantChoice::parse("a/b{ paint = red }").unwrap();
        assert_eq!(found.to_string(), "/a/b{paint=red}");
        assert_eq!(VariantChoice::parse("/a/b{paint=red}"), Ok(found));
        assert_eq!(VariantChoice::parse(" street shoe "), Ok(VariantChoice::Materials("street shoe".to_owned())));
        for bad in ["", "a=b", "a{b}", "{b=c}", "a{=c}", "a{b=}", "a{b=c", "a{b=c}{d=e}", "a{b=c=d}"] {
            assert!(VariantChoice::parse(bad).unwrap_err().contains("PRIM{SET=NAME}"), "{bad}");
        }
    }
}
