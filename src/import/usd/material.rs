//! Materials: which one is bound to a prim or a subset of its faces, and what its fields mean.

use super::attribute::PrimView;
use super::reader::Reader;
use crate::base::fault::Result;

/// What was read so far, by the path of the material.
#[derive(Debug, Default)]
pub(super) struct Known {}

/// What a prim hands down to the prims below it: bindings. Two instances of a prototype share their meshes only if they
/// hand down the same.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub(super) struct Inherited {}

impl Inherited {
    /// For the prims below `view`.
    pub fn below(&self, _view: &PrimView) -> Result<Inherited> {
        Ok(self.clone())
    }
}

/// The material of a prim: an index of `Assembly::materials`.
pub(super) fn bound(_reader: &mut Reader, _view: &PrimView, _inherited: &Inherited) -> Result<Option<usize>> {
    Ok(None)
}

/// The material of a GeomSubset by its own binding alone; none leaves its faces the mesh's.
pub(super) fn bound_to_subset(_reader: &mut Reader, _subset: &PrimView) -> Result<Option<usize>> {
    Ok(None)
}
