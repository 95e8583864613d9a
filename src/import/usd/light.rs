//! UsdLux lights.

use super::attribute::PrimView;
use super::reader::Reader;
use crate::base::fault::Result;

/// Appends the light of a prim whose type is one, for `node` of the assembly.
pub(super) fn read(reader: &mut Reader, view: &PrimView, node: usize, type_name: &str) -> Result<()> {
    let _ = node;
    reader.ledger.warn(view.at(), format!("lights of type {type_name} are not used"));
    Ok(())
}

/// After all prims are known.
pub(super) fn finish(_reader: &mut Reader) -> Result<()> {
    Ok(())
}
