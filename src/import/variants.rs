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
        // A name of glTF is any text, a path of USD starts with a slash, or has the whole form.
        let plain = || {
            let is_name = !text.trim().is_empty() && !text.trim_start().starts_with('/');
            if is_name { Ok(VariantChoice::Materials(text.trim().to_owned())) } else { Err(bad()) }
        };
        let inner = text.split_once('{').and_then(|(prim, rest)| {
            let (set, name) = rest.strip_suffix('}')?.split_once('=')?;
            Some([prim.trim().trim_start_matches('/'), set.trim(), name.trim()])
        });
        let whole = |words: &[&str; 3]| !words.iter().any(|word| word.is_empty() || word.contains(['{', '}', '=']));
        let Some([prim, set, name]) = inner.filter(whole) else { return plain() };
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
        assert_eq!(VariantChoice::parse("paint=red {2}"), Ok(VariantChoice::Materials("paint=red {2}".to_owned())));
        for bad in ["", " ", "/a", "/a{b}", "/a{=c}", "/a{b=}", "/a{b=c", "/a{b=c}{d=e}", "/a{b=c=d}"] {
            assert!(VariantChoice::parse(bad).unwrap_err().contains("PRIM{SET=NAME}"), "{bad}");
        }
    }
}
