//! A sidecar turned into the asset's own rows: the winners of asset + sidecar, written where the asset would say them.
//!
//! What a row of the asset beats is not what a row of the sidecar beats (a node's row holds for all parts below it, a
//! face's row loses to the node's for that face). So the rows are written, bound again without the sidecar, and compared
//! with what they must mean; whatever differs is said explicitly, until nothing does.

mod meaning;
mod relocate;
mod root;
mod rows;
#[cfg(test)]
mod tests;

use super::asset_attributes::AssetAttributes;
use super::bind::bind;
use super::binding_slots::{PartBound, Rank, Slot};
use super::optics;
use super::select::{Candidate, candidates};
use eyebox_base::error::Result;
use eyebox_base::{Error, Where};
use eyebox_scene::annotation::Annotation;
use eyebox_scene::assembly::Assembly;
use eyebox_scene::value::Value;
use root::Root;
use rows::Asked;
use std::path::Path;

/// What `assembly` must carry to mean by itself what it means with `sidecar`, for a file in the folder `out`: names of
/// files in its attributes are rewritten, too.
///
/// Faults: whatever is wrong with the attributes (as in [`build`](super::build())); what the asset's rows can't say.
pub fn annotate(assembly: &Assembly, sidecar: Option<&Value>, out: &Path) -> Result<Annotation> {
    let mut moved = assembly.clone();
    relocate::assembly(&mut moved, out);
    let sidecar = sidecar.map(|value| {
        let mut value = value.clone();
        relocate::value(&mut value, out);
        value
    });
    let sheet = AssetAttributes::new(sidecar.as_ref(), moved.optics.as_ref())?;
    let parts = candidates(&moved)?;
    let bound = bind(&sheet, &moved, &parts, &mut Vec::new())?;
    if sidecar.is_some() {
        checked(&sheet, &bound)?;
    }

    let mut asked: Vec<Asked> = bound.iter().map(Asked::by_the_sidecar).collect();
    // Every round asks for more of finitely many things.
    loop {
        let annotation = written(&sheet, &moved, &parts, &bound, &asked)?;
        let differs = differences(&annotation, &moved, &parts, &bound, &sheet)?;
        if differs.is_empty() {
            return Ok(changed(annotation, &moved, assembly));
        }
        let before = asked.clone();
        for difference in &differs {
            if let Some(asked) = asked.get_mut(difference.part) {
                asked.more(difference.slot, difference.face);
            }
        }
        if asked == before {
            let Difference { part, face, slot } = differs[0];
            let path = parts.get(part).map_or_else(String::new, |part| part.path.clone());
            let what = format!("the {slot:?} that the sidecar binds can't be said by the asset itself");
            return Err(
                Error::new(Where::Part { path, face }, what.to_lowercase()).expected("a sidecar beside the asset")
            );
        }
    }
}

/// The rows that say what is asked for.
fn written(
    sheet: &AssetAttributes,
    assembly: &Assembly,
    parts: &[Candidate],
    bound: &[PartBound],
    asked: &[Asked],
) -> Result<Annotation> {
    let mut root = Root::new(sheet);
    let mut annotation = Annotation::default();
    for ((part, bound), asked) in parts.iter().zip(bound).zip(asked) {
        let Some(node) = assembly.nodes.get(part.node).filter(|_| asked.anything()) else { continue };
        if let Some(value) = rows::of_part(&mut root, node, bound, asked)? {
            annotation.nodes.push((part.node, value));
        }
    }
    let rows_below = !annotation.nodes.is_empty();
    annotation.root = root.table(assembly.optics.as_ref(), rows_below)?;
    Ok(annotation)
}

/// The rows of `annotation` and those of `moved` that differ from what `original` says.
fn changed(mut annotation: Annotation, moved: &Assembly, original: &Assembly) -> Annotation {
    let mut whole = moved.clone();
    annotation.apply(&mut whole);
    let new = |new: &Option<Value>, old: &Option<Value>| match (new, old) {
        (Some(new), Some(old)) if new.same(old) => None,
        (new, _) => new.clone(),
    };
    annotation = Annotation { root: new(&whole.optics, &original.optics), ..Annotation::default() };
    for (index, (node, old)) in whole.nodes.iter().zip(&original.nodes).enumerate() {
        annotation.nodes.extend(new(&node.attributes, &old.attributes).map(|value| (index, value)));
    }
    for (index, (material, old)) in whole.materials.iter().zip(&original.materials).enumerate() {
        annotation.materials.extend(new(&material.attributes, &old.attributes).map(|value| (index, value)));
    }
    for (index, (mesh, old)) in whole.meshes.iter().zip(&original.meshes).enumerate() {
        for (face, (value, old)) in mesh.attributes.iter().zip(&old.attributes).enumerate() {
            annotation.faces.extend(new(value, old).map(|value| (index, face, value)));
        }
    }
    annotation
}

/// A slot of a part or of a face that means something else.
#[derive(Debug, Clone, Copy)]
struct Difference {
    part: usize,
    face: Option<usize>,
    slot: Slot,
}

/// Binds what the annotated asset says by itself and compares.
fn differences(
    annotation: &Annotation,
    assembly: &Assembly,
    parts: &[Candidate],
    bound: &[PartBound],
    sheet: &AssetAttributes,
) -> Result<Vec<Difference>> {
    let mut whole = assembly.clone();
    annotation.apply(&mut whole);
    let alone = AssetAttributes::new(None, whole.optics.as_ref())?;
    let after = bind(&alone, &whole, parts, &mut Vec::new())?;
    let mut found = Vec::new();
    for (part, (before, after)) in bound.iter().zip(&after).enumerate() {
        let faces = before.faces.iter().zip(&after.faces).enumerate().map(|(face, pair)| (Some(face), pair));
        for (face, (before, after)) in std::iter::once((None, (&before.part, &after.part))).chain(faces) {
            for slot in if face.is_none() { &Slot::PART[..] } else { &Slot::FACE[..] } {
                let wanted = meaning::of(before, *slot, sheet)?;
                // What can't even be read is different.
                if !meaning::of(after, *slot, &alone).is_ok_and(|now| meaning::same(&wanted, &now)) {
                    found.push(Difference { part, face, slot: *slot });
                }
            }
        }
    }
    Ok(found)
}

/// Reads every value once that the sidecar binds: an asset must not carry what can't be read.
fn checked(sheet: &AssetAttributes, bound: &[PartBound]) -> Result<()> {
    let mut notes = Vec::new();
    let nm = optics::wavelengths(sheet.wavelengths.as_ref(), &mut notes)?.traced_nm();
    if let Some(unit) = &sheet.unit {
        optics::unit(unit)?;
    }
    for (name, value) in &sheet.coatings.named {
        optics::coating(value, name, &mut notes)?;
    }
    if let Some(sky) = &sheet.sky {
        optics::sky(sky, &mut notes)?;
    }
    if let Some(sun) = &sheet.sun {
        optics::sun(sun, &mut notes)?;
    }
    if let Some(eye) = &sheet.eye {
        optics::eye(eye, optics::Lens::default(), &mut notes)?;
    }
    for slots in bound.iter().flat_map(|part| std::iter::once(&part.part).chain(&part.faces)) {
        for won in slots.all().filter(|won| won.rank > Rank::NodeFaces || won.rank == Rank::Default) {
            let value = sheet.followed(won.entry.slot, &won.entry.value)?;
            let none = value.text() == Some("none");
            match won.entry.slot {
                Slot::Index if won.entry.key == "medium" => {}
                Slot::Index => drop(optics::index(&won.entry.key, value, nm)?),
                Slot::Absorption => drop(optics::absorption(value, nm)?),
                Slot::Priority => drop(optics::priority(value)?),
                Slot::Finish => drop(optics::finish(value, &mut notes)?),
                Slot::Shape => {
                    optics::shape(value, &mut Vec::new())?;
                }
                Slot::Coating => match value.text().filter(|_| !none) {
                    Some(name) => return Err(optics::unknown_coating(name, value, sheet.coatings.names())),
                    None => drop(optics::coating(value, "", &mut notes)?),
                },
                Slot::Sensor => drop(optics::sensor(value)?),
                Slot::Emitter if !none => drop(optics::emitter(value, &mut notes)?),
                Slot::Slide if !none => drop(optics::slide(value, &mut notes)?),
                Slot::Emitter | Slot::Slide => {}
            }
        }
        // A million faces must not keep a million notes.
        notes.clear();
    }
    Ok(())
}
