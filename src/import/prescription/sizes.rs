//! Sizes of surfaces where the file gives none: what two paraxial rays need, one through the rim of the pupil and one from the
//! rim of the field; and the field, where the file says it by heights.

use super::sidecar::FIELD_DEG;
use super::{After, Heights, Prescription, pupil, sidecar};
use eyebox_base::Where;
use eyebox_scene::{Dispersion, Note, glass};
use glam::DAffine3;
use std::path::Path;

/// Light at the rim of the field has more to go through than paraxial rays say.
const ROOM: f64 = 1.1;
/// A design for one point has an image that no eye finds; smaller than this share of the field it is made as large as that.
const POINT: f64 = 1e-3;
/// A tilted surface needs more by one over the cosine, until it is seen from its edge.
const EDGE_ON: f64 = 0.1;
/// Where the file has no wavelength, nm.
const NM: f64 = 587.5618;

/// Heights of a ray at the surfaces, and its slope behind the last.
fn traced(prescription: &Prescription, [mut y, mut u]: [f64; 2]) -> (Vec<f64>, f64) {
    let nm = prescription.wavelength_nm.unwrap_or(NM);
    let index = |name: &str| {
        sidecar::find(name, &prescription.catalogues).and_then(glass::find).map(|g| g.dispersion.index(nm).re)
    };
    let mut n = 1.0;
    let mut out = vec![y];
    for surface in prescription.surfaces.iter().skip(1) {
        out.push(y);
        // Behind a mirror the index is negative, as the way is.
        let next = match &surface.after {
            _ if surface.turn.is_some() => n,
            After::Air => f64::signum(n),
            After::Mirror => -n,
            After::Glass { name, model } => {
                let of_model = model.map(|[n, v]| Dispersion::Abbe { n_d: n, v_d: v }.index(nm).re);
                f64::signum(n) * index(name).or(of_model).unwrap_or(1.5)
            }
            After::Private(rows) => {
                let rows = rows.iter().map(|[nm, n]| (*nm, *n, 0.0)).collect();
                f64::signum(n) * Dispersion::Table(rows).index(nm).re
            }
            After::Model([d, 0.0]) => f64::signum(n) * d,
            After::Model([d, v]) => f64::signum(n) * Dispersion::Abbe { n_d: *d, v_d: *v }.index(nm).re,
        };
        let power = surface.profile.curvature * (next - n);
        u = (n * u - y * power) / next;
        n = next;
        if surface.thickness.is_finite() {
            y += u * surface.thickness;
        }
    }
    (out, u)
}

/// Fills in the sizes that are missing, and the field.
pub(super) fn fill(prescription: &mut Prescription, frames: &[DAffine3], path: &Path) {
    let missing = |surface: &super::Surface| surface.turn.is_none() && surface.semi_diameter <= 0.0;
    let ((by_height, leaves), (by_slope, by_slope_leaves)) =
        (traced(prescription, [1.0, 0.0]), traced(prescription, [0.0, 1.0]));
    let stop = prescription.surfaces.iter().position(|surface| surface.stop).unwrap_or(1);
    // The height at which a ray from the field's rim must enter to go through the middle of the stop.
    let enters = by_height.get(stop).zip(by_slope.get(stop)).map_or(0.0, |(y, u)| if *y == 0.0 { 0.0 } else { -u / y });
    let at_image = by_height.last().zip(by_slope.last()).map_or(0.0, |(y, u)| (u + enters * y).abs());
    if let Some(heights) = prescription.heights {
        let from_object = prescription.surfaces.first().map_or(f64::INFINITY, |object| object.thickness);
        let (heights, reach) = match heights {
            Heights::Object(heights) => (heights, (from_object - enters).abs()),
            Heights::Image(heights) => (heights, at_image),
        };
        let angles = heights.map(|height| (height / reach).atan().to_degrees());
        prescription.field_deg = Some(angles).filter(|[x, y]| x.max(*y) > 0.0 && (x + y).is_finite());
    }
    let angle = prescription.field_deg.map(|[x, y]| x.hypot(y).min(80.0));
    let seen = at_image * angle.unwrap_or(0.5 * FIELD_DEG).to_radians().tan();
    if let Some(image) = prescription.surfaces.last_mut()
        && image.semi_diameter > 0.0
        && image.semi_diameter < POINT * seen
        && image.outline.is_none()
    {
        let text = format!("the image is a point of {:.1e}: it is made {seen:.3} large", image.semi_diameter);
        prescription.notes.push(Note::info(Where::Line { file: path.to_owned(), line: image.line }, text));
        image.semi_diameter = seen;
    }
    let at_stop = by_height.get(stop).copied().unwrap_or(0.0);
    pupil::fill(prescription, &pupil::Rays { leaves: [leaves, by_slope_leaves], enters, stop, at_stop }, path);
    let Some(pupil) = prescription.pupil.filter(|_| prescription.surfaces.iter().skip(1).any(missing)) else { return };
    let slope = angle.unwrap_or(0.0).to_radians().tan();
    let mut from = None;
    for (index, (y, u)) in by_height.into_iter().zip(by_slope).enumerate().skip(1) {
        let (surface, frame) = (&mut prescription.surfaces[index], frames[index]);
        let way = from.map_or(frame.matrix3.z_axis, |from| frame.translation - from).normalize_or(frame.matrix3.z_axis);
        if surface.turn.is_none() {
            from = Some(frame.translation);
        }
        if missing(surface) {
            let upright = ROOM * (0.5 * pupil * y.abs() + slope * (u + enters * y).abs());
            let size = upright / frame.matrix3.z_axis.dot(way).abs().max(EDGE_ON);
            surface.semi_diameter = if size.is_finite() { size } else { 0.0 };
        }
    }
    let text = "sizes of surfaces that the file does not give are those that paraxial rays need, and a tenth more";
    prescription.notes.push(Note::info(Where::file(path), text));
}
