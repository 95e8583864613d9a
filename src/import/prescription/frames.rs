//! Where the surfaces of a prescription stand.

use super::{Prescription, Turn};
use glam::{DAffine3, DMat3, DVec3};

/// Axes of each surface, in those of the first one that light meets.
pub(super) fn frames(prescription: &Prescription) -> Vec<DAffine3> {
    let mut at = DAffine3::IDENTITY;
    let mut out = Vec::with_capacity(prescription.surfaces.len());
    for (index, surface) in prescription.surfaces.iter().enumerate() {
        if let Some(turn) = &surface.turn {
            at *= matrix(turn);
        }
        out.push(at);
        // The object may be anywhere, and as far as one likes.
        if index > 0 && surface.thickness.is_finite() {
            at *= DAffine3::from_translation(DVec3::Z * surface.thickness);
        }
    }
    out
}

fn matrix(turn: &Turn) -> DAffine3 {
    let [x, y, z] = turn.tilt_deg.map(f64::to_radians);
    let (x, y, z) = (DMat3::from_rotation_x(x), DMat3::from_rotation_y(y), DMat3::from_rotation_z(z));
    let shift = DAffine3::from_translation(DVec3::from_array(turn.shift));
    let turned = |tilts: DMat3| DAffine3::from_mat3(tilts);
    let whole = if turn.tilts_first { turned(z * y * x) * shift } else { shift * turned(x * y * z) };
    if turn.inverse { whole.inverse() } else { whole }
}
