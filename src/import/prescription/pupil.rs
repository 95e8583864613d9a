//! The entrance pupil of a lens file that says an aperture in other words: a ratio, a numerical aperture, the size of its stop.

use super::{Aperture, Prescription};
use eyebox_base::Where;
use eyebox_scene::Note;
use std::path::Path;

/// What two paraxial rays tell, one of height 1 along the axis and one of slope 1 through the middle of the first surface.
pub(super) struct Rays {
    /// Their slopes behind the last surface.
    pub leaves: [f64; 2],
    /// Where the entrance pupil stands before the first surface.
    pub enters: f64,
    /// Which surface is the stop, and how high the first ray is there.
    pub stop: usize,
    pub at_stop: f64,
}

/// Finds the diameter of the pupil, and says what it is of.
pub(super) fn fill(prescription: &mut Prescription, rays: &Rays, path: &Path) {
    if prescription.pupil.is_some() {
        return;
    }
    // Without a word of it, what the stop lets in.
    let said = prescription.aperture;
    let of = said.unwrap_or(Aperture::Stop);
    let found = diameter(prescription, rays, of).filter(|pupil| *pupil > 0.0 && pupil.is_finite());
    let unit = 1e3 * prescription.unit_m;
    let name = match of {
        Aperture::Ratio(ratio) => format!("an aperture ratio of {ratio}"),
        Aperture::WorkingRatio(ratio) => format!("a working ratio of {ratio}"),
        Aperture::ObjectNa(na) => format!("a numerical aperture of {na:.4} at the object"),
        Aperture::ImageNa(na) => format!("a numerical aperture of {na:.4} at the image"),
        Aperture::Stop => "its stop".to_owned(),
    };
    let text = match (found, said) {
        (Some(pupil), _) => format!("the pupil of {:.4} mm is that of {name}", unit * pupil),
        (None, Some(_)) => format!("{name} gives no pupil: one of 4 mm, as of an eye by room light"),
        (None, None) => "no pupil is said: one of 4 mm, as of an eye by room light".to_owned(),
    };
    prescription.pupil = found;
    prescription.notes.push(Note::info(Where::file(path), text));
}

/// Of the entrance pupil, in the file's unit.
fn diameter(prescription: &Prescription, rays: &Rays, of: Aperture) -> Option<f64> {
    let from_object = prescription.surfaces.first().map_or(f64::INFINITY, |object| object.thickness);
    // The slope at the object of light that has the slope 1 at the image; in the limit of a far object, its height instead.
    let [of_height, of_slope] = rays.leaves;
    let at_image = |slope: f64| {
        if from_object.is_finite() {
            (slope / (of_height * from_object + of_slope)).abs() * (from_object - rays.enters).abs()
        } else {
            (slope / of_height).abs()
        }
    };
    let slope = |sine: f64| (sine > 0.0 && sine < 1.0).then(|| sine.asin().tan());
    Some(match of {
        Aperture::Ratio(ratio) => 1.0 / (of_height * ratio).abs(),
        Aperture::WorkingRatio(ratio) => 2.0 * at_image(0.5 / ratio),
        Aperture::ObjectNa(sine) => 2.0 * slope(sine)? * (from_object - rays.enters).abs(),
        Aperture::ImageNa(sine) => 2.0 * at_image(slope(sine)?),
        Aperture::Stop => 2.0 * prescription.surfaces.get(rays.stop)?.semi_diameter / rays.at_stop.abs(),
    })
}
