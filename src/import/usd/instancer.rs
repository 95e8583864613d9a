//! PointInstancer: many copies of a few prototypes.

use super::attribute::PrimView;
use super::binding::Inherited;
use super::handed::{Above, Handed, MOST_DEEP, Template};
use super::hierarchy;
use super::reader::Reader;
use super::skel_binding;
use super::value;
use super::xform::{self, Local};
use eyebox_base::error::Result;
use glam::{DAffine3, DQuat, DVec3};
use openusd::sdf;
use std::collections::HashSet;

/// Appends a node `NAME[i]` beside the instancer's own for each instance, and the prototype below it.
///
/// # Errors
/// Values of other types than the schema's.
pub(super) fn read(reader: &mut Reader, view: &PrimView, below: &Above) -> Result<()> {
    let prototypes = view.targets("prototypes")?;
    let indices = view.read("protoIndices", "int[]", value::ints)?.unwrap_or_default();
    let positions = view.read("positions", "point3f[]", value::wide_triples)?.unwrap_or_default();
    let scales = view.read("scales", "float3[]", value::wide_triples)?.unwrap_or_default();
    let turns = match view.read("orientationsf", "quatf[]", value::quaternions)? {
        Some(turns) if !turns.is_empty() => turns,
        Some(_) | None => view.read("orientations", "quath[]", value::quaternions)?.unwrap_or_default(),
    };
    let count = indices.len();
    for (name, length) in [("positions", positions.len()), ("scales", scales.len()), ("orientations", turns.len())] {
        if length != count && (length != 0 || name == "positions") {
            // USD draws nothing then.
            let text = format!("{length} {name} for {count} entries of protoIndices: no instances");
            reader.ledger.warn(view.at_property(name), text);
            return Ok(());
        }
    }
    let hidden = hidden(view, count)?;
    for name in ["velocities", "angularVelocities", "accelerations"] {
        if view.moment.frame.is_some() && view.has(name) {
            reader.ledger.info(view.at_property(name), "motion between samples is not used");
        }
    }
    let Some(own) = below.node else { return Ok(()) };
    let (base, parent) = (reader.assembly.nodes[own].local, reader.assembly.nodes[own].parent);
    let resets = reader.placed_afresh(own).then(|| reader.assembly.nodes[own].to_world);
    let mut templates: Vec<Option<Template>> = vec![None; prototypes.len()];
    for (i, &index) in indices.iter().enumerate() {
        if hidden.contains(&i) {
            continue;
        }
        let Some(prototype) = usize::try_from(index).ok().filter(|&index| index < prototypes.len()) else {
            reader
                .ledger
                .warn(view.at_property("protoIndices"), format!("no prototype has the number {index}: left out"));
            continue;
        };
        let shift = positions.get(i).map_or(DVec3::ZERO, |&p| DVec3::from(p));
        let size = scales.get(i).map_or(DVec3::ONE, |&s| DVec3::from(s));
        let turn = match turns.get(i) {
            Some(&xyzw) => xform::rotation(view, "orientations", xyzw, &mut reader.ledger)?,
            None => DQuat::IDENTITY,
        };
        let transform = DAffine3::from_scale_rotation_translation(size, turn, shift);
        let local = match resets {
            Some(world) => Local { transform: world * transform, resets: true },
            None => Local { transform: base * transform, resets: false },
        };
        let node = hierarchy::place(reader, view, local, parent, &format!("{}[{i}]", view.name()))?;
        match templates[prototype].clone() {
            Some(template) => hierarchy::copy(reader, view, &template, node)?,
            None => {
                let start = hierarchy::marks(reader);
                walk(reader, view, &prototypes[prototype], node, below)?;
                templates[prototype] = Some(hierarchy::template(reader, node, start));
            }
        }
    }
    Ok(())
}

/// Walks a prototype for the first time.
fn walk(reader: &mut Reader, view: &PrimView, path: &sdf::Path, node: usize, below: &Above) -> Result<()> {
    let prim = reader.prim(path)?;
    if !prim.is_valid().map_err(|error| view.moment.failed(view.path(), error))? {
        let text = format!("the prototype <{}> does not exist: its instances are empty", path.as_str());
        reader.ledger.warn(view.at_property("prototypes"), text);
        return Ok(());
    }
    // What stands inside the instance that holds the instancer is shared as the instancer is.
    let inside = below.instance.clone().filter(|(from, _)| path.has_prefix(from));
    let (material, skel) = inherited(reader, path)?;
    let handed = Handed { shown: below.handed.shown, material, painted: below.handed.painted, skel };
    let above = Above { node: Some(node), instance: inside, depth: below.depth + 1, may_be_over: true, handed };
    hierarchy::prim(reader, prim, &above)
}

/// What the prims above a prototype bind: materials and skeletons go by where it stands on the stage, not by who repeats it.
fn inherited(reader: &mut Reader, path: &sdf::Path) -> Result<(Inherited, skel_binding::Inherited)> {
    let mut above: Vec<sdf::Path> = path.strict_ancestors_below_root().take(MOST_DEEP).collect();
    above.reverse();
    let (mut out, mut bound) = (Inherited::default(), skel_binding::Inherited::default());
    for path in above {
        let prim = reader.stage.prim(path.clone()).map_err(|error| reader.moment.failed(&path, error))?;
        let failed = |error| reader.moment.failed(&path, error);
        if !prim.is_valid().map_err(failed)? {
            continue;
        }
        let is_instance = prim.is_instance().map_err(failed)?;
        let view = PrimView::new(prim, &reader.moment)?;
        out = out.below(reader, &view)?;
        bound = bound.below(&view, &view.type_name()?);
        if is_instance {
            out.inside(&view);
            bound.inside(&view);
        }
    }
    Ok((out, bound))
}

/// The instances that are not there: `invisibleIds` and the metadata `inactiveIds`, by `ids` (or by position).
fn hidden(view: &PrimView, count: usize) -> Result<HashSet<usize>> {
    let mut out: HashSet<i64> = HashSet::new();
    out.extend(view.read("invisibleIds", "int64[]", value::integers)?.unwrap_or_default());
    match view.metadata("inactiveIds")? {
        Some(sdf::Value::Int64ListOp(ids)) => out.extend(ids.flatten()),
        Some(sdf::Value::IntListOp(ids)) => out.extend(ids.flatten().into_iter().map(i64::from)),
        // The library does not know the field's type in text layers.
        Some(sdf::Value::UnregisteredValue(text)) => {
            let numbers = text.split(|c: char| !c.is_ascii_digit() && c != '-');
            out.extend(numbers.filter_map(|number| number.parse::<i64>().ok()));
        }
        Some(other) => out.extend(value::integers(other).unwrap_or_default()),
        None => {}
    }
    if out.is_empty() {
        return Ok(HashSet::new());
    }
    let ids = view.read("ids", "int64[]", value::integers)?.unwrap_or_default();
    let id = |i: usize| ids.get(i).copied().unwrap_or(i as i64);
    Ok((0..count).filter(|&i| out.contains(&id(i))).collect())
}
