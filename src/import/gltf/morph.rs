//! Morph targets: weighted differences that are added to the vertices (glTF 2.0, section 3.7.2.2).

use super::accessor::{Accessor, Component};
use super::at::At;
use super::deform::{Bent, Target};
use super::notes::Ledger;
use super::primitive::{check_type, open, same_count};
use eyebox_base::Code;
use eyebox_base::error::Result;
use glam::DVec3;

/// How many targets the mesh `at` has, as its first primitive says.
pub(super) fn count(mesh: &At<'_>) -> usize {
    let targets = mesh.json.pointer("/primitives/0/targets");
    targets.and_then(|targets| targets.as_array()).map_or(0, Vec::len)
}

/// Whether targets of the mesh `at` change texture coordinates or colours.
pub(super) fn changes_more(mesh: &At<'_>) -> bool {
    let primitives = mesh.json.get("primitives").and_then(|list| list.as_array()).into_iter().flatten();
    let mut targets = primitives.filter_map(|primitive| primitive.get("targets")?.as_array()).flatten();
    targets.any(|target| ["TEXCOORD_0", "TEXCOORD_1", "COLOR_0"].iter().any(|key| target.get(key).is_some()))
}

/// Weights as a mesh or node says them; empty if all are 0, which bends nothing.
///
/// # Errors
/// What is no list of numbers.
pub(super) fn weights(owner: &At<'_>) -> Result<Option<Vec<f64>>> {
    let Some(list) = owner.get("weights")? else { return Ok(None) };
    list.items()?.iter().map(|weight| weight.number()).collect::<Result<_>>().map(Some)
}

/// Adds the differences of positions, normals, tangents, texture coordinates and colours.
///
/// # Errors
/// Other numbers of weights than of targets, or of differences than of vertices.
pub(super) fn apply(target: &Target<'_>, weights: &[f64], bent: &mut Bent<'_>, ledger: &mut Ledger) -> Result<()> {
    let morphs = target.at.list("targets")?;
    if morphs.is_empty() {
        ledger.notes.warn(target.at, "a mesh with weights, and a primitive without morph targets: it keeps its shape");
        return Ok(());
    }
    if morphs.len() != weights.len() {
        let what = format!("{} morph targets for {} weights", morphs.len(), weights.len());
        return Err(target.at.fault(what).expected("one weight for each"));
    }
    for (morph, &weight) in morphs.iter().zip(weights).filter(|(_, weight)| **weight != 0.0) {
        if let Some(deltas) = differences(target, morph, "POSITION", &[3], ledger)? {
            moved(&mut bent.positions, &deltas, target.used, weight);
        }
        if !bent.normals.is_empty()
            && let Some(deltas) = differences(target, morph, "NORMAL", &[3], ledger)?
        {
            moved(&mut bent.normals, &deltas, target.used, weight);
        }
        let face = &mut *bent.face;
        let deltas = differences(target, morph, "TANGENT", &[3], ledger)?.filter(|_| !face.tangents.is_empty());
        if let Some(deltas) = deltas {
            // The side stays.
            let alone: Vec<[f32; 3]> = deltas.gather(target.used);
            let alone: Vec<[f32; 4]> = alone.into_iter().map(|[x, y, z]| [x, y, z, 0.0]).collect();
            added(&mut face.tangents, &alone, weight);
            finite(&mut face.tangents, &deltas, "tangents that are not finite: set to 0", ledger);
        }
        for (key, uvs) in [("TEXCOORD_0", &mut face.uvs), ("TEXCOORD_1", &mut face.second_uvs)] {
            if let Some(deltas) = differences(target, morph, key, &[2], ledger)?.filter(|_| !uvs.is_empty()) {
                added(uvs, &deltas.gather(target.used), weight);
                finite(uvs, &deltas, "texture coordinates that are not finite: set to 0", ledger);
            }
        }
        let deltas = differences(target, morph, "COLOR_0", &[3, 4], ledger)?.filter(|_| !face.colors.is_empty());
        if let Some(deltas) = deltas {
            if deltas.lanes == 4 {
                added(&mut face.colors, &deltas.gather(target.used), weight);
            } else {
                let opaque: Vec<[f32; 3]> = deltas.gather(target.used);
                let opaque: Vec<[f32; 4]> = opaque.into_iter().map(|[r, g, b]| [r, g, b, 0.0]).collect();
                added(&mut face.colors, &opaque, weight);
            }
            finite(&mut face.colors, &deltas, "colours of vertices that are not finite: set to 0", ledger);
        }
    }
    // "Clamped after all morph targets are applied" (section 3.7.2.2).
    bent.face.colors.iter_mut().flatten().for_each(|x| *x = x.clamp(0.0, 1.0));
    Ok(())
}

/// The differences of one attribute, if the target has them.
fn differences<'d>(
    target: &'d Target<'_>,
    morph: &At<'_>,
    key: &str,
    lanes: &[usize],
    ledger: &mut Ledger,
) -> Result<Option<Accessor<'d>>> {
    let Some(reference) = morph.get(key)? else { return Ok(None) };
    let accessor = open(target.document, &reference, lanes, ledger)?;
    same_count(&reference, &accessor, target.positions)?;
    check_type(target.document, &accessor, &[Component::I8, Component::U8, Component::I16, Component::U16], ledger)?;
    // Time more than memory: all targets of a file may be one and the same array.
    ledger.budget.charge(&reference, target.used.len(), 1)?;
    Ok(Some(accessor))
}

fn moved(all: &mut [DVec3], deltas: &Accessor<'_>, used: &[u32], weight: f64) {
    for (own, delta) in all.iter_mut().zip(deltas.gather::<3>(used)) {
        *own += DVec3::from(delta.map(f64::from)) * weight;
    }
}

fn added<const N: usize>(all: &mut [[f32; N]], deltas: &[[f32; N]], weight: f64) {
    for (own, delta) in all.iter_mut().flatten().zip(deltas.as_flattened()) {
        *own = (f64::from(*own) + f64::from(*delta) * weight) as f32;
    }
}

fn finite<const N: usize>(all: &mut [[f32; N]], deltas: &Accessor<'_>, text: &str, ledger: &mut Ledger) {
    for own in all.iter_mut().filter(|own| !own.iter().all(|x| x.is_finite())) {
        ledger.notes.warn_of(Code::DataNotFinite, &deltas.at, text);
        *own = [0.0; N];
    }
}
