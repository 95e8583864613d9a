//! `KHR_materials_variants`: which material a primitive has in the variant that was asked for.

use super::accessor::Document;
use super::at::At;
use crate::variants::VariantChoice;
use eyebox_base::error::Result;
use eyebox_base::{Error, Where};

const NAME: &str = "KHR_materials_variants";

/// The names of the asset's variants, in its order.
pub(super) fn names<'a>(root: &At<'a>) -> Result<Vec<&'a str>> {
    let Some(extension) = root.extension(NAME)? else { return Ok(Vec::new()) };
    let mut names = Vec::new();
    for variant in extension.list("variants")? {
        names.push(variant.want("name")?.text()?);
    }
    Ok(names)
}

/// The number of the variant that was asked for; of several choices the last one holds.
///
/// # Errors
/// A choice of a prim, or of a variant that is not there.
pub(super) fn chosen(root: &At<'_>, choices: &[VariantChoice]) -> Result<Option<usize>> {
    let names = names(root)?;
    let mut found = None;
    for choice in choices {
        let fault = |what: String| Error::new(Where::Option(format!("--variant {choice}")), what);
        let name = match choice {
            VariantChoice::Materials(name) => name,
            VariantChoice::Prim { .. } => {
                return Err(fault("is for prims of USD; variants of a glTF asset have names alone".to_owned()));
            }
        };
        if names.is_empty() {
            return Err(fault(format!("the asset has no variants (`{NAME}`)")));
        }
        found = names.iter().position(|other| other == name);
        if found.is_none() {
            return Err(fault("the asset has no such variant".to_owned())
                .expected(format!("one of {}", names.join(", ")))
                .nearest(name, names.iter().copied()));
        }
    }
    Ok(found)
}

/// The material of a primitive: that of the variant, where the primitive has one for it, else its own.
pub(super) fn material(document: &Document<'_>, primitive: &At<'_>) -> Result<Option<usize>> {
    let own = primitive.get("material")?;
    let mapped = match document.variant {
        Some(variant) => mapping(primitive, variant)?,
        None => None,
    };
    let Some(reference) = mapped.or(own) else { return Ok(None) };
    document.find("materials", "material", &reference)?;
    reference.count().map(Some)
}

fn mapping<'a>(primitive: &At<'a>, variant: usize) -> Result<Option<At<'a>>> {
    let Some(extension) = primitive.extension(NAME)? else { return Ok(None) };
    for mapping in extension.list("mappings")? {
        for number in mapping.list("variants")? {
            if number.count()? == variant {
                return mapping.want("material").map(Some);
            }
        }
    }
    Ok(None)
}
