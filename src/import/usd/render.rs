//! RenderSettings, RenderProduct, RenderVar: which layers the asset asks for.

use super::reader::Reader;
use crate::base::fault::Result;

/// Fills `assembly.layers`.
pub(super) fn read(_reader: &mut Reader) -> Result<()> {
    Ok(())
}
