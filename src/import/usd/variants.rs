//! Variants that the command line chooses: written into the root layer as it lies in memory, whose opinions are the strongest.

use super::reader::Reader;
use crate::variants::VariantChoice;
use eyebox_base::error::Result;
use eyebox_base::{Error, Where};
use openusd::sdf::{self, Value};
use openusd::usd::Prim;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Takes them in their order: a variant may bring the next one's prim.
///
/// # Errors
/// A prim, a set or a variant that is not there.
pub(super) fn choose(reader: &mut Reader, choices: &[VariantChoice]) -> Result<()> {
    for choice in choices {
        one(reader, choice)?;
    }
    Ok(())
}

fn one(reader: &mut Reader, choice: &VariantChoice) -> Result<()> {
    let fault = |what: String| Error::new(Where::Option(format!("--variant {choice}")), what);
    let VariantChoice::Prim { prim: host, set, name } = choice else {
        return Err(fault("names no variant of a prim".to_owned()).expected("PRIM{SET=NAME}, e.g. /car{paint=red}"));
    };
    let path = sdf::Path::new(host).map_err(|_| fault(format!("`{host}` is no path of a prim")))?;
    let prim = reader.prim(&path)?;
    let sets = sets_of(reader, &prim);
    if sets.is_empty() {
        return Err(fault(format!("{host} is no prim with variants")).expected("a prim that has some"));
    }
    let listed = |names: &mut dyn Iterator<Item = &String>| names.map(String::as_str).collect::<Vec<_>>().join(", ");
    let Some(names) = sets.get(set) else {
        let all = sets.iter().map(|(set, names)| format!("{set} ({})", listed(&mut names.iter())));
        return Err(fault(format!("{host} has no variant set `{set}`"))
            .expected(format!("one of {}", all.collect::<Vec<_>>().join(", ")))
            .nearest(set, sets.keys().map(String::as_str)));
    };
    if !names.contains(name) {
        return Err(fault(format!("the variant set {set} of {host} has no `{name}`"))
            .expected(format!("one of {}", listed(&mut names.iter())))
            .nearest(name, names.iter().map(String::as_str)));
    }
    let chosen = |kept: Option<Value>| {
        let mut all = match kept {
            Some(Value::VariantSelectionMap(all)) => all,
            // Of another type it chooses nothing.
            Some(_) | None => HashMap::new(),
        };
        all.insert(set.clone(), name.clone());
        Some(Value::VariantSelectionMap(all))
    };
    prim.update_metadata("variantSelection", chosen).map_err(|error| fault(format!("cannot be chosen: {error}")))?;
    Ok(())
}

/// The variants of a prim by their set, of all layers that say something of it.
fn sets_of(reader: &Reader, prim: &Prim) -> BTreeMap<String, BTreeSet<String>> {
    let mut out: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for site in prim.prim_index().prim_stack().unwrap_or_default() {
        let Some(layer) = reader.stage.layer(&site.layer) else { continue };
        for spec in layer.data().spec_paths() {
            let inner = spec.as_str().strip_prefix(site.path.as_str()).and_then(|rest| rest.strip_prefix('{'));
            let Some((set, name)) = inner.and_then(|inner| inner.strip_suffix('}')?.split_once('=')) else { continue };
            if !name.is_empty() && !name.contains(['{', '}']) {
                out.entry(set.to_owned()).or_default().insert(name.to_owned());
            }
        }
    }
    out
}
