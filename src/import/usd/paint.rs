//! The colours that a prim has without a material: `primvars:displayColor` and `primvars:displayOpacity`. Constant ones hold
//! for the prims below, too (UsdGeomPrimvarsAPI, inheritance of primvars).

use super::attribute::PrimView;
use super::notes::Ledger;
use super::primvar::{self, Sizes};
use eyebox_base::error::Result;

/// What prims hand down, in bits: meshes that have different ones are different.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub(super) struct Painted {
    color: Option<[u32; 3]>,
    opacity: Option<u32>,
}

impl Painted {
    /// With what `view` says itself: for the prims below it.
    ///
    /// # Errors
    /// An interpolation that there is none of.
    pub fn below(self, view: &PrimView, ledger: &mut Ledger) -> Result<Painted> {
        let mut out = self;
        // What varies over a mesh says nothing of others.
        let is_constant = |name: &str| -> Result<bool> {
            let said = if view.has(name) { view.property_text(name, "interpolation")? } else { return Ok(false) };
            Ok(said.is_none_or(|said| said == "constant"))
        };
        let one = Sizes { points: 1, polygons: 1, corners: 1 };
        if is_constant("primvars:displayColor")? {
            let found = primvar::colors(view, "displayColor", one, ledger)?.and_then(|found| found.at(0, 0, 0));
            out.color = found.map(|found| found.map(f32::to_bits)).or(out.color);
        }
        if is_constant("primvars:displayOpacity")? {
            let found = primvar::numbers(view, "displayOpacity", one, ledger)?.and_then(|found| found.at(0, 0, 0));
            out.opacity = found.map(f32::to_bits).or(out.opacity);
        }
        Ok(out)
    }

    /// By the name of the primvar.
    pub fn color(self, name: &str) -> Option<[f32; 3]> {
        self.color.filter(|_| name == "displayColor").map(|color| color.map(f32::from_bits))
    }
    pub fn opacity(self, name: &str) -> Option<f32> {
        self.opacity.filter(|_| name == "displayOpacity").map(f32::from_bits)
    }
}

/// Brought to what a surface can have.
pub(super) fn clamped(color: [f32; 4]) -> [f32; 4] {
    color.map(|x| if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) })
}
