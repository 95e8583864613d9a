//! The node that our own writer puts above an asset of other units or axes, for programs that know only glTF's. Taken
//! off again, it leaves the asset as it was: no transform is rounded by a product with it.

use super::at::At;
use super::transform;
use eyebox_base::error::Result;
use glam::{DMat3, DVec3};

/// The mark of the node, an entry of its `extras`.
const MARK: &str = "eyebox_world";

/// Axes and metres per unit, if `at` is such a node: marked, with nothing but children and a matrix that turns axes
/// into axes and scales them alike. A marked node of any other kind is a node like others.
pub(super) fn read(at: &At<'_>) -> Result<Option<(DMat3, f64)>> {
    let marked = at.get("extras")?.is_some_and(|extras| extras.json.get(MARK).is_some_and(|mark| mark == true));
    let busy = ["mesh", "camera", "skin", "extensions", "translation", "rotation", "scale"];
    let Some(object) = at.json.as_object().filter(|_| marked) else { return Ok(None) };
    if busy.iter().any(|key| object.contains_key(*key)) {
        return Ok(None);
    }
    let local = transform::local(at, None, &mut super::notes::Notes::default())?;
    let columns = [local.matrix3.x_axis, local.matrix3.y_axis, local.matrix3.z_axis];
    let unit = columns[0].abs().max_element();
    let whole = |x: f64| x == 0.0 || x.abs() == unit;
    let along = |column: DVec3| column.to_array().into_iter().all(whole) && column.abs().element_sum() == unit;
    // Signs of zeros stay, too.
    let axis = |column: DVec3| DVec3::from_array(column.to_array().map(|x| x / unit));
    let axes = DMat3::from_cols(axis(columns[0]), axis(columns[1]), axis(columns[2]));
    let sound = unit > 0.0
        && unit.is_finite()
        && local.translation == DVec3::ZERO
        && columns.into_iter().all(along)
        && axes.determinant().abs() == 1.0;
    Ok(sound.then_some((axes, unit)))
}
