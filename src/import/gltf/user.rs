//! `extras`: what authors say of nodes and materials beside the format.

use super::accessor::Document;
use super::at::At;
use super::notes::Ledger;
use eyebox_base::error::Result;
use eyebox_scene::user_property::{UserProperty, UserValue};
use serde_json::Value as Json;

/// The entries of our own writer's begin with this.
const OWN: &str = "eyebox_";
/// An entry of a mesh that means something: the names of its morph targets.
const TARGETS: &str = "targetNames";

/// What the `extras` of an object say; those that are no object are one property of that name.
///
/// # Errors
/// More than the asset can honestly need.
pub(super) fn of(at: &At<'_>, ledger: &mut Ledger) -> Result<Vec<UserProperty>> {
    let Some(extras) = at.get("extras")? else { return Ok(Vec::new()) };
    ledger.budget.charge(&extras, 1, extras.weight())?;
    let property =
        |name: &str, json: &Json| UserProperty { name: name.to_owned(), usd: None, value: UserValue::of_json(json) };
    Ok(match extras.json {
        Json::Object(entries) => {
            let own = |name: &str| name.starts_with(OWN) || name == TARGETS;
            entries.iter().filter(|(name, _)| !own(name)).map(|(name, json)| property(name, json)).collect()
        }
        Json::Null => Vec::new(),
        Json::Bool(_) | Json::Number(_) | Json::String(_) | Json::Array(_) => vec![property("extras", extras.json)],
    })
}

/// What is said of a node, and of its mesh and its camera, which have no prims of their own here: where names are the same, the
/// node's own.
///
/// # Errors
/// Those of [`of`].
pub(super) fn of_node(document: &Document<'_>, at: &At<'_>, ledger: &mut Ledger) -> Result<Vec<UserProperty>> {
    let mut all = of(at, ledger)?;
    for (list, what) in [("meshes", "mesh"), ("cameras", "camera")] {
        let Some(reference) = at.get(what)? else { continue };
        for property in of(&document.find(list, what, &reference)?, ledger)? {
            if all.iter().all(|own| own.name != property.name) {
                all.push(property);
            }
        }
    }
    Ok(all)
}
