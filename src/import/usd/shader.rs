//! Networks of shaders: from an output or input along its connections to what it comes to.

use super::attribute::{PrimView, one_line};
use super::reader::Reader;
use eyebox_base::Where;
use eyebox_base::error::Result;
use openusd::sdf::Value;

/// Connections in a row; a cycle ends here.
const MOST_HOPS: usize = 64;

/// Where connections end.
pub(super) enum End {
    Value(Value, Where),
    /// A shader, and which of its outputs (`outputs:…`).
    Node(PrimView, String),
    Nothing,
}

/// Follows the property `name` (`inputs:…` or `outputs:…`) of a shader, graph or material. A connection goes before a
/// value.
///
/// # Errors
/// What the library cannot read.
pub(super) fn follow(reader: &mut Reader, start: &PrimView, name: &str) -> Result<End> {
    let mut name = name.to_owned();
    let mut here: Option<PrimView> = None;
    for _ in 0..MOST_HOPS {
        let view = here.as_ref().unwrap_or(start);
        if !view.has(&name) {
            return Ok(End::Nothing);
        }
        let failed = |error| view.fault_in(&name, one_line(&format!("cannot be read: {error}")));
        let sources = view.prim.attribute(name.as_str()).connections().map_err(failed)?;
        if sources.len() > 1 {
            reader.ledger.warn(view.at_property(&name), "several connections: the first is taken");
        }
        let source = sources.first().and_then(|source| {
            let (path, property) = source.split_property()?;
            Some((path, property.to_owned()))
        });
        let next = match source {
            Some((path, property)) => {
                let prim = reader.prim(&path)?;
                let there = prim.is_valid().map_err(failed)?;
                if there { Some((PrimView::new(prim, &reader.moment)?, property)) } else { None }
            }
            None => None,
        };
        let Some((next, property)) = next else {
            let value = view.get(&name)?;
            return Ok(value.map_or(End::Nothing, |value| End::Value(value, view.at_property(&name))));
        };
        if next.type_name()? == "Shader" && property.starts_with("outputs:") {
            if !id(&next)?.starts_with("ND_constant_") {
                return Ok(End::Node(next, property));
            }
            name = "inputs:value".to_owned();
        } else {
            name = property;
        }
        here = Some(next);
    }
    reader.ledger.warn(start.at_property(&name), "connections that go round: not used");
    Ok(End::Nothing)
}

/// The kind of a shader, its node definition's name; empty if it has none.
pub(super) fn id(view: &PrimView) -> Result<String> {
    Ok(view.token("info:id")?.unwrap_or_default())
}
