//! Skins: joints that move vertices (glTF 2.0, section 3.7.3). The node of a skinned mesh does not move it: its vertices are
//! where their joints take them, written here in the node's own axes so that the node keeps its place in the hierarchy.

use super::accessor::{Accessor, Component, Document};
use super::at::At;
use super::deform::{Bent, Target};
use super::notes::Ledger;
use super::pose::Pose;
use super::primitive::{open, same_count};
use crate::skinning::{self, Blend};
use eyebox_base::error::Result;
use glam::{DAffine3, DMat3, DVec3};

/// The matrices of a skin: mesh → the axes in which the bent mesh is written.
#[derive(Debug)]
pub(super) struct Bones {
    matrices: Vec<DAffine3>,
    /// Joint → the axes in which the bent mesh is written, and mesh → joint: the matrices in two parts.
    pub places: Vec<DAffine3>,
    pub binds: Vec<DAffine3>,
    /// Nodes of the file.
    pub joints: Vec<usize>,
    /// The skin.
    pointer: String,
}

impl Bones {
    /// The joints of the skin that `reference` names, where `pose` has them; `from_world` is what the mesh is written in.
    ///
    /// # Errors
    /// No joints, joints that are no nodes, too few matrices, matrices that are not affine or overflow.
    pub fn read(
        document: &Document<'_>,
        reference: &At<'_>,
        from_world: DAffine3,
        pose: &mut Pose<'_>,
        ledger: &mut Ledger,
    ) -> Result<Bones> {
        let at = document.find("skins", "skin", reference)?;
        let joints_at = at.want("joints")?;
        let joints = joints_at.items()?;
        if joints.is_empty() {
            return Err(joints_at.fault("a skin without joints").expected("at least 1"));
        }
        ledger.budget.charge(&joints_at, joints.len(), 3 * size_of::<DAffine3>())?;
        let binds = match at.get("inverseBindMatrices")? {
            Some(reference) => Some(matrices(document, &reference, joints.len(), ledger)?),
            None => None,
        };
        let mut bones = Bones {
            matrices: Vec::with_capacity(joints.len()),
            places: Vec::with_capacity(joints.len()),
            binds: Vec::with_capacity(joints.len()),
            joints: Vec::with_capacity(joints.len()),
            pointer: at.pointer.clone(),
        };
        for (number, joint) in joints.iter().enumerate() {
            let node = joint.index(pose.count(), "node")?;
            let world = pose.world(node, ledger)?;
            let bind = binds.as_ref().map_or(Ok(DAffine3::IDENTITY), |binds| affine(binds, number, ledger))?;
            let matrix = from_world * (world * bind);
            if !matrix.is_finite() {
                return Err(joint.fault("the joint's matrix overflows").expected("finite numbers"));
            }
            bones.matrices.push(matrix);
            bones.places.push(from_world * world);
            bones.binds.push(bind);
            bones.joints.push(node);
        }
        Ok(bones)
    }
}

fn matrices<'d>(
    document: &'d Document<'_>,
    reference: &At<'_>,
    joints: usize,
    ledger: &mut Ledger,
) -> Result<Accessor<'d>> {
    let accessor = open(document, reference, &[16], ledger)?;
    if accessor.component != Component::F32 {
        let fault = accessor.at.want("componentType")?.fault("inverse bind matrices of this component type");
        return Err(fault.expected("5126 (float)"));
    }
    if accessor.count < joints {
        let what = format!("{} inverse bind matrices for {joints} joints", accessor.count);
        return Err(reference.fault(what).expected("one for each"));
    }
    Ok(accessor)
}

/// One matrix, column by column. Its last row is 0, 0, 0, 1 by the specification; what a writer's rounding left there is
/// nobody's loss.
fn affine(binds: &Accessor<'_>, number: usize, ledger: &mut Ledger) -> Result<DAffine3> {
    let m = binds.floats::<16>(number).map(f64::from);
    if !m.iter().all(|x| x.is_finite()) {
        return Err(binds.at.fault(format!("inverse bind matrix {number} is not finite")).expected("finite numbers"));
    }
    let last = [m[3], m[7], m[11], m[15] - 1.0];
    if last.iter().any(|x| x.abs() > 1e-4) {
        let text = "an inverse bind matrix whose last row is not 0, 0, 0, 1: read as if it were";
        ledger.notes.warn(&binds.at, text);
    }
    let column = |c: usize| DVec3::new(m[4 * c], m[4 * c + 1], m[4 * c + 2]);
    Ok(DAffine3 { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) })
}

/// One set of four joints and weights a vertex.
struct Influences<'d> {
    joints: Accessor<'d>,
    weights: Accessor<'d>,
}

/// Moves the vertices of a face; which of them were mirrored.
///
/// # Errors
/// Joints that the skin does not have, weights that are negative or not finite, wrong counts and types.
pub(super) fn apply(target: &Target<'_>, bones: &Bones, bent: &mut Bent<'_>, ledger: &mut Ledger) -> Result<Vec<bool>> {
    let sets = influences(target, ledger)?;
    let mut is_mirrored = vec![false; bent.positions.len()];
    if sets.is_empty() {
        ledger.notes.warn(target.at, "a node with a skin, and a primitive without joints: it stands with its node");
        return Ok(is_mirrored);
    }
    let (mut unbound, mut off) = (0usize, 0usize);
    for (place, &vertex) in target.used.iter().enumerate() {
        let blend = blend(&sets, bones, vertex as usize)?;
        // Weights in bytes are good to a step of 1/255 each.
        off += usize::from(blend.weight() > 0.0 && (blend.weight() - 1.0).abs() > 4.0 / 255.0);
        let matrix = match blend.mean() {
            Some(mean) => mean,
            None => {
                unbound += 1;
                first(&sets, bones, vertex as usize)?
            }
        };
        if let Some(position) = bent.positions.get_mut(place) {
            *position = matrix.transform_point3(*position);
        }
        if let Some(normal) = bent.normals.get_mut(place) {
            *normal = skinning::normal(&matrix.matrix3, *normal);
        }
        if let Some([x, y, z, side]) = bent.face.tangents.get_mut(place) {
            let along = matrix.matrix3 * DVec3::new((*x).into(), (*y).into(), (*z).into());
            [*x, *y, *z] = super::normals::unit(along).unwrap_or_default();
            *side *= if matrix.matrix3.determinant() < 0.0 { -1.0 } else { 1.0 };
        }
        if let Some(mirrored) = is_mirrored.get_mut(place) {
            *mirrored = matrix.matrix3.determinant() < 0.0;
        }
    }
    if unbound > 0 {
        let text = format!("{unbound} vertices without weights: they stand with the first joint that they name");
        ledger.notes.warn(target.at, text);
    }
    if off > 0 {
        let text = format!("the weights of {off} vertices do not add up to 1: taken in proportion");
        ledger.notes.warn(target.at, text);
    }
    Ok(is_mirrored)
}

/// Joints and weights of each vertex.
pub(super) type Weighed = Vec<Vec<(u32, f64)>>;

/// Joints and weights of the used vertices, each joint once; none for a primitive without joints.
///
/// # Errors
/// As [`apply`].
pub(super) fn weighed(target: &Target<'_>, bones: &Bones, ledger: &mut Ledger) -> Result<Option<Weighed>> {
    let sets = influences(target, ledger)?;
    if sets.is_empty() {
        return Ok(None);
    }
    ledger.budget.charge(target.at, target.used.len(), sets.len() * 4 * size_of::<(u32, f64)>())?;
    let mut out = Vec::with_capacity(target.used.len());
    for &vertex in target.used {
        // Also proves the joints.
        let has_weight = blend(&sets, bones, vertex as usize)?.mean().is_some();
        let mut own: Vec<(u32, f64)> = Vec::new();
        for set in &sets {
            let (joints, weights) = (set.joints.floats::<4>(vertex as usize), set.weights.floats::<4>(vertex as usize));
            for (joint, weight) in joints.into_iter().zip(weights).filter(|(_, weight)| *weight > 0.0) {
                match own.iter_mut().find(|(known, _)| *known == joint as u32) {
                    Some((_, sum)) => *sum += f64::from(weight),
                    None => own.push((joint as u32, f64::from(weight))),
                }
            }
        }
        if !has_weight {
            first(&sets, bones, vertex as usize)?;
            own =
                sets.first().map(|set| (set.joints.floats::<4>(vertex as usize)[0] as u32, 1.0)).into_iter().collect();
        }
        out.push(own);
    }
    Ok(Some(out))
}

/// `JOINTS_0` and `WEIGHTS_0`, `JOINTS_1` and `WEIGHTS_1`, as far as they go.
fn influences<'d>(target: &'d Target<'_>, ledger: &mut Ledger) -> Result<Vec<Influences<'d>>> {
    let attributes = target.at.want("attributes")?;
    let mut sets = Vec::new();
    while let Some(reference) = attributes.get(&format!("JOINTS_{}", sets.len()))? {
        let name = format!("WEIGHTS_{}", sets.len());
        let joints = open(target.document, &reference, &[4], ledger)?;
        same_count(&reference, &joints, target.positions)?;
        if !matches!(joints.component, Component::U8 | Component::U16) || joints.normalized {
            let fault = joints.at.want("componentType")?.fault("joints of this component type");
            return Err(fault.expected("5121 or 5123 (unsigned), not normalised"));
        }
        let reference = attributes.want(&name)?;
        let weights = open(target.document, &reference, &[4], ledger)?;
        same_count(&reference, &weights, target.positions)?;
        let whole = matches!(weights.component, Component::U8 | Component::U16) && weights.normalized;
        if !whole && weights.component != Component::F32 {
            let fault = weights.at.want("componentType")?.fault("weights of this component type");
            return Err(fault.expected("5126 (float), or 5121 or 5123 normalised"));
        }
        // Time more than memory: all sets of a file may be one and the same array.
        ledger.budget.charge(&reference, target.used.len(), 4)?;
        sets.push(Influences { joints, weights });
    }
    if let Some(weights) = attributes.get(&format!("WEIGHTS_{}", sets.len()))? {
        return Err(weights.fault(format!("weights without joints: `JOINTS_{}` is missing", sets.len())));
    }
    Ok(sets)
}

fn blend(sets: &[Influences<'_>], bones: &Bones, vertex: usize) -> Result<Blend> {
    let mut blend = Blend::default();
    for set in sets {
        let (joints, weights) = (set.joints.floats::<4>(vertex), set.weights.floats::<4>(vertex).map(f64::from));
        // What has no weight may name any joint.
        for (joint, weight) in joints.into_iter().zip(weights).filter(|(_, weight)| *weight != 0.0) {
            if !(weight > 0.0 && weight.is_finite()) {
                let what = format!("vertex {vertex} has a weight of {weight}");
                return Err(set.weights.at.fault(what).expected("finite weights from 0"));
            }
            blend.add(matrix(set, bones, vertex, joint)?, weight);
        }
    }
    Ok(blend)
}

/// The matrix of the joint that a vertex names first.
fn first(sets: &[Influences<'_>], bones: &Bones, vertex: usize) -> Result<DAffine3> {
    let Some(set) = sets.first() else { return Ok(DAffine3::IDENTITY) };
    let [joint, ..] = set.joints.floats::<4>(vertex);
    matrix(set, bones, vertex, joint).copied()
}

fn matrix<'b>(set: &Influences<'_>, bones: &'b Bones, vertex: usize, joint: f32) -> Result<&'b DAffine3> {
    bones.matrices.get(joint as usize).ok_or_else(|| {
        let what = format!("vertex {vertex} names joint {joint} of {}", bones.pointer);
        set.joints.at.fault(what).expected(format!("0 to {}", bones.matrices.len() - 1))
    })
}
