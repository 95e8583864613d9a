//! Node transforms in f64, straight from the JSON (glTF 2.0, section 3.5.3).

use super::at::At;
use super::notes::Notes;
use super::pose::Moved;
use eyebox_base::Code;
use eyebox_base::error::Result;
use glam::{DAffine3, DMat3, DQuat, DVec3};

/// The local transform of a node: a matrix, or translation · rotation · scale, where what an animation moves takes the place
/// of what is written.
///
/// # Errors
/// Both forms at once, or a matrix that an animation would move the parts of; a matrix whose last row is not (0, 0, 0, 1); a rotation of length 0; numbers that overflow.
pub(super) fn local(at: &At<'_>, moved: Option<&Moved>, notes: &mut Notes) -> Result<DAffine3> {
    let (translation, rotation, scale) = (at.get("translation")?, at.get("rotation")?, at.get("scale")?);
    let transform = if let Some(matrix) = at.get("matrix")? {
        if translation.is_some() || rotation.is_some() || scale.is_some() {
            return Err(matrix
                .fault("a node with both a matrix and translation, rotation or scale")
                .expected("one form"));
        }
        if moved.is_some_and(|moved| moved.translation.is_some() || moved.rotation.is_some() || moved.scale.is_some()) {
            let fault = matrix.fault("an animation moves a node that has a matrix");
            return Err(fault.expected("translation, rotation and scale"));
        }
        // Column by column.
        let m: [f64; 16] = matrix.numbers()?;
        let last = [m[3], m[7], m[11], m[15] - 1.0];
        // A writer that multiplied in f32 leaves some units in the last place there.
        if last.iter().any(|x| x.abs() > 1e-6) {
            return Err(matrix.fault("the matrix is not affine").expected("a last row of 0, 0, 0, 1"));
        }
        let column = |c: usize| DVec3::new(m[4 * c], m[4 * c + 1], m[4 * c + 2]);
        DAffine3 { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) }
    } else {
        let scale = DVec3::from(scale.map_or(Ok([1.0; 3]), |at| at.numbers())?);
        let translation = DVec3::from(translation.map_or(Ok([0.0; 3]), |at| at.numbers())?);
        let rotation = match rotation {
            Some(at) => unit_rotation(&at, at.numbers()?, 1e-3, notes)?,
            None => DQuat::IDENTITY,
        };
        let moved = moved.cloned().unwrap_or_default();
        DAffine3::from_scale_rotation_translation(
            moved.scale.unwrap_or(scale),
            moved.rotation.unwrap_or(rotation),
            moved.translation.unwrap_or(translation),
        )
    };
    if !transform.is_finite() {
        return Err(at.fault("the node's transform overflows").expected("finite numbers"));
    }
    if is_singular(transform) {
        notes.warn_of(Code::PartFlattened, at, "a singular transform: it flattens whatever is below the node");
    }
    Ok(transform)
}

/// The quaternion (x, y, z, w) at unit length; a note if it is off by more than `tolerance`.
pub(super) fn unit_rotation(at: &At<'_>, xyzw: [f64; 4], tolerance: f64, notes: &mut Notes) -> Result<DQuat> {
    let quaternion = DQuat::from_array(xyzw);
    let largest = xyzw.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    if !(largest > 0.0 && quaternion.is_finite()) {
        return Err(at.fault("a rotation of length 0").expected("a unit quaternion x, y, z, w"));
    }
    if (quaternion.length() - 1.0).abs() > tolerance {
        notes.warn(at, "a rotation that is not a unit quaternion: normalised");
    }
    Ok((quaternion / largest).normalize())
}

/// Whether the volume of the transformed unit cube is rounding noise, compared with a box of its edges.
pub(crate) fn is_singular(transform: DAffine3) -> bool {
    let m = transform.matrix3;
    let edges = DVec3::new(m.x_axis.length(), m.y_axis.length(), m.z_axis.length());
    // Edge by edge, so that neither a scale of 1e-120 nor one of 1e120 leaves the range of f64.
    let unit = DMat3::from_cols(m.x_axis / edges.x, m.y_axis / edges.y, m.z_axis / edges.z);
    let volume = unit.determinant().abs();
    edges.min_element() == 0.0 || volume <= 1e-12 || volume.is_nan()
}
