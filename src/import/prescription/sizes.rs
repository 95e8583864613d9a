//! Sizes of surfaces where the file gives none: what two paraxial rays need, one through the rim of the pupil and one from the
//! rim of the field.

use super::{After, Prescription, sidecar};
use crate::base::Where;
use crate::scene::{Dispersion, Note, glass};
use std::path::Path;

/// Light at the rim of the field has more to go through than paraxial rays say.
const ROOM: f64 = 1.1;
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

/// Fills in the sizes that are missing.
pub(super) fn fill(prescription: &mut Prescription, path: &Path) {
    let missing = |surface: &super::Surface| surface.turn.is_none() && surface.semi_diameter <= 0.0;
    if !prescription.surfaces.iter().skip(1).any(missing) {
        return;
    }
    let ((by_height, leaves), (by_slope, _)) = (traced(prescription, [1.0, 0.0]), traced(prescription, [0.0, 1.0]));
    let stop = prescription.surfaces.iter().position(|surface| surface.stop).unwrap_or(1);
    let by_ratio = || prescription.f_number.map(|ratio| 1.0 / (leaves * ratio).abs()).filter(|pupil| pupil.is_finite());
    let pupil = prescription.pupil.or_else(by_ratio).or_else(|| {
        // Without one, what its stop lets in.
        let own = prescription.surfaces.get(stop)?.semi_diameter / by_height.get(stop)?.abs();
        (own > 0.0 && own.is_finite()).then_some(2.0 * own)
    });
    let Some(pupil) = pupil else { return };
    prescription.pupil = Some(pupil);
    let slope = prescription.field_deg.map_or(0.0, |[x, y]| x.hypot(y).min(80.0).to_radians().tan());
    // The height at which a ray from the field's rim must enter to go through the middle of the stop.
    let enters = by_height.get(stop).zip(by_slope.get(stop)).map_or(0.0, |(y, u)| if *y == 0.0 { 0.0 } else { -u / y });
    for ((surface, y), u) in prescription.surfaces.iter_mut().zip(by_height).zip(by_slope).skip(1) {
        if missing(surface) {
            let size = ROOM * (0.5 * pupil * y.abs() + slope * (u + enters * y).abs());
            surface.semi_diameter = if size.is_finite() { size } else { 0.0 };
        }
    }
    let text = "sizes of surfaces that the file does not give are those that paraxial rays need, and a tenth more";
    prescription.notes.push(Note::info(Where::file(path), text));
}
