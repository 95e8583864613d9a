//! What bends the mesh of a node, as data: the mesh at rest, its morph targets, its joints with their weights. Nothing here
//! decides what the picture is; `deform` does, with the same numbers.

use super::accessor::Document;
use super::at::At;
use super::deform::{Bent, Deform, Target};
use super::morph;
use super::notes::Ledger;
use super::pose::Pose;
use super::primitive::{self, FaceMesh, FaceName, open};
use super::skin::{self, Bones};
use crate::Rigs;
use eyebox_base::error::Result;
use eyebox_scene::motion::{self, Joint, Rig, Skin, Vertices};
use glam::DVec3;

/// The rig of the mesh at `at`, which `deform` bends at the moment to these triangles; none, where only the bent vertices say it:
/// primitives with and without joints in one mesh, joints that mirror it and so turn its triangles round.
///
/// # Errors
/// As [`primitive::read`].
pub(super) fn read(
    document: &Document<'_>,
    (at, bent): (&At<'_>, &[[u32; 3]]),
    deform: &Deform,
    (pose, rigs): (&Pose<'_>, Rigs),
    ledger: &mut Ledger,
) -> Result<Option<Rig>> {
    if rigs == Rigs::Poses {
        return Ok(Some(Rig { pose: posed(deform, morph::count(at)), ..Rig::default() }));
    }
    // What is wrong with the mesh was said when it was read.
    let said = std::mem::take(&mut ledger.notes);
    let out = unsaid(document, (at, bent), deform, pose, ledger);
    ledger.notes = said;
    if morph::changes_more(at) {
        let text = "morph targets of texture coordinates or colours: only their positions and normals move";
        ledger.notes.warn(at, text);
    }
    out
}

fn unsaid(
    document: &Document<'_>,
    (at, mut bent): (&At<'_>, &[[u32; 3]]),
    deform: &Deform,
    pose: &Pose<'_>,
    ledger: &mut Ledger,
) -> Result<Option<Rig>> {
    let count = morph::count(at);
    let mut rig = Rig { targets: names(at, count)?, ..Rig::default() };
    let mut weighed: Vec<Vec<(u32, f64)>> = Vec::new();
    for (number, at) in at.want("primitives")?.items()?.iter().enumerate() {
        let name = FaceName { mesh: "", face: number };
        let still = Deform { is_traced: true, ..Deform::default() };
        let face = primitive::read(document, at, name, &still, ledger)?;
        if face.positions.is_empty() {
            continue;
        }
        let first = rig.rest.positions.len() as u32;
        let still = face.triangles.iter().map(|triangle| triangle.map(|vertex| vertex + first));
        let Some((own, rest)) = bent.split_at_checked(face.triangles.len()) else { return Ok(None) };
        if !still.eq(own.iter().copied()) {
            return Ok(None);
        }
        bent = rest;
        let reference = at.want("attributes")?.want("POSITION")?;
        let positions = open(document, &reference, &[3], ledger)?;
        let target = Target { document, at, positions: &positions, used: &face.sources };
        let is_flat = at.want("attributes")?.get("NORMAL")?.is_none();
        for (index, out) in rig.targets.iter_mut().enumerate() {
            ledger.budget.charge(at, face.positions.len(), size_of::<[f32; 6]>())?;
            let weights: Vec<f64> = (0..count).map(|other| f64::from(u8::from(other == index))).collect();
            let mut by = differences(&target, &weights, ledger)?;
            if is_flat {
                // Made of the triangles: how they turn with the whole target.
                let bent = Deform { weights, ..Deform::default() };
                let full = primitive::read(document, at, name, &bent, ledger)?;
                by.normals = difference(&full.normals, &face.normals);
            }
            out.by.positions.extend(by.positions);
            out.by.normals.extend(by.normals);
        }
        if let Some(bones) = &deform.bones {
            match skin::weighed(&target, bones, ledger)? {
                Some(own) => weighed.extend(own),
                None => return Ok(None),
            }
        }
        rig.rest.positions.extend(face.positions);
        rig.rest.normals.extend(face.normals);
    }
    if let Some(bones) = &deform.bones {
        rig.skin = Some(Skin::new(joints(bones, pose)?, bones.binds.clone(), &weighed));
    }
    rig.pose = posed(deform, count);
    Ok(Some(rig))
}

/// The weights of so many targets and the joints at the moment.
fn posed(deform: &Deform, count: usize) -> motion::Pose {
    motion::Pose {
        weights: if deform.weights.is_empty() { vec![0.0; count] } else { deform.weights.clone() },
        joints: deform.bones.as_ref().map(|bones| bones.places.clone()).unwrap_or_default(),
    }
}

/// The names of the targets: `extras.targetNames`, which is where everybody looks.
fn names(at: &At<'_>, count: usize) -> Result<Vec<motion::Target>> {
    let said = at.json.pointer("/extras/targetNames").and_then(|names| names.as_array());
    let name = |index: usize| said.and_then(|names| names.get(index)?.as_str()).map(str::to_owned);
    Ok((0..count)
        .map(|index| motion::Target {
            name: name(index).unwrap_or_else(|| format!("target_{index}")),
            ..Default::default()
        })
        .collect())
}

/// What the targets add with these weights.
fn differences(target: &Target<'_>, weights: &[f64], ledger: &mut Ledger) -> Result<Vertices> {
    let zeros = vec![DVec3::ZERO; target.used.len()];
    let mut bent = Bent { positions: zeros.clone(), normals: zeros, face: &mut FaceMesh::default() };
    morph::apply(target, weights, &mut bent, ledger)?;
    let single = |all: Vec<DVec3>| all.into_iter().map(|v| v.to_array().map(|x| x as f32)).collect();
    Ok(Vertices { positions: single(bent.positions), normals: single(bent.normals) })
}

fn difference(to: &[[f32; 3]], from: &[[f32; 3]]) -> Vec<[f32; 3]> {
    from.iter().zip(to).map(|(from, to)| std::array::from_fn(|lane| to[lane] - from[lane])).collect()
}

/// The parent of a joint is the nearest joint above it.
fn joints(bones: &Bones, pose: &Pose<'_>) -> Result<Vec<Joint>> {
    let mut out = Vec::with_capacity(bones.joints.len());
    for &node in &bones.joints {
        let mut above = pose.parent(node);
        let mut parent = None;
        while let Some(next) = above {
            parent = bones.joints.iter().position(|joint| *joint == next);
            if parent.is_some() {
                break;
            }
            above = pose.parent(next);
        }
        let name = pose.node(node).map_or_else(|| Ok(String::new()), |at| at.name("node", node))?;
        out.push(Joint { name, parent, node: Some(node) });
    }
    Ok(out)
}
