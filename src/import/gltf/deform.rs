//! What a node does to the shape of its mesh: morph targets first, then the skin (glTF 2.0, sections 3.7.2.2 and 3.7.3).
//! In f64 from the file's numbers to the finished vertices; a mesh that nobody bends is never touched.

use super::accessor::{Accessor, Document};
use super::at::At;
use super::notes::Ledger;
use super::primitive::FaceMesh;
use super::skin::Bones;
use super::{morph, skin};
use crate::skinning;
use eyebox_base::Code;
use eyebox_base::error::Result;
use glam::DVec3;

/// How a node bends its mesh.
#[derive(Debug, Default)]
pub(super) struct Deform {
    /// Of the morph targets; empty where all are 0.
    pub weights: Vec<f64>,
    pub bones: Option<Bones>,
    /// Whether faces are to say which vertices of the file theirs are.
    pub is_traced: bool,
}

/// A primitive and the vertices that its triangles use.
pub(super) struct Target<'a> {
    pub document: &'a Document<'a>,
    /// The primitive.
    pub at: &'a At<'a>,
    pub positions: &'a Accessor<'a>,
    pub used: &'a [u32],
}

/// A face being bent.
pub(super) struct Bent<'a> {
    pub positions: Vec<DVec3>,
    pub normals: Vec<DVec3>,
    pub face: &'a mut FaceMesh,
}

impl Deform {
    pub fn is_none(&self) -> bool {
        self.weights.is_empty() && self.bones.is_none()
    }
}

/// Bends a face. Normals come out at unit length, or as zeros where they have no direction.
///
/// # Errors
/// Targets, joints or weights that are wrong, with their place; vertices that leave the range of numbers.
pub(super) fn apply(target: &Target<'_>, deform: &Deform, face: &mut FaceMesh, ledger: &mut Ledger) -> Result<()> {
    if deform.is_none() {
        return Ok(());
    }
    ledger.budget.charge(target.at, target.used.len(), 2 * size_of::<DVec3>())?;
    let wide = |all: &[[f32; 3]]| all.iter().map(|p| DVec3::from(p.map(f64::from))).collect();
    let mut bent = Bent { positions: wide(&face.positions), normals: wide(&face.normals), face };
    if !deform.weights.is_empty() {
        morph::apply(target, &deform.weights, &mut bent, ledger)?;
    }
    if let Some(bones) = &deform.bones {
        let is_mirrored = skin::apply(target, bones, &mut bent, ledger)?;
        skinning::turn_mirrored(&mut bent.face.triangles, &is_mirrored);
    }
    let Bent { positions, normals, face } = bent;
    face.positions = positions.iter().map(|p| p.to_array().map(|x| x as f32)).collect();
    face.normals = normals.into_iter().map(|n| super::normals::unit(n).unwrap_or_default()).collect();
    let broken = face.positions.iter().position(|p| !p.iter().all(|x| x.is_finite()));
    if let Some((vertex, [x, y, z])) = broken.and_then(|i| Some((target.used.get(i)?, face.positions.get(i)?))) {
        let what = format!("vertex {vertex} is bent to ({x}, {y}, {z})");
        return Err(target.at.fault(what).expected("finite positions").code(Code::DataNotFinite));
    }
    Ok(())
}
