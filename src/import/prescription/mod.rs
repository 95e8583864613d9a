//! Prescriptions: sequential lens files of design programs, as surfaces one after the other.
//!
//! A reader (`zmx`, `seq`) fills a [`Prescription`]; `frames` says where its surfaces stand, `solids` makes parts of the spaces
//! between them, and `sidecar` the text that says what those are.

mod frames;
mod mesh;
mod profile;
mod pupil;
mod seq;
mod sidecar;
mod sizes;
mod solids;
#[cfg(test)]
mod tests;
mod zmx;

use super::{Assembly, files, text};
use eyebox_base::error::Result;
use eyebox_base::{Error, Where};
use eyebox_scene::Note;
use std::path::Path;

pub use profile::Profile;

/// A sequential design, in the order in which light meets its surfaces; the first is the object, the last the image.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Prescription {
    /// Metres per unit.
    pub unit_m: f64,
    pub surfaces: Vec<Surface>,
    /// Diameter of the entrance pupil, if the file says it.
    pub pupil: Option<f64>,
    /// What the file says instead.
    pub aperture: Option<Aperture>,
    /// Largest field in x and y, degrees.
    pub field_deg: Option<[f64; 2]>,
    /// What the file says instead of angles.
    pub heights: Option<Heights>,
    /// nm
    pub wavelength_nm: Option<f64>,
    /// Makers whose glasses it names, the first first.
    pub catalogues: Vec<String>,
    pub notes: Vec<Note>,
}

/// What the diameter of the entrance pupil follows from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Aperture {
    /// Focal length over it.
    Ratio(f64),
    /// 1/(2 tan u'), u' the paraxial angle of the light from the axis of the object at the image.
    WorkingRatio(f64),
    /// Sine of the angle of that light at the object.
    ObjectNa(f64),
    /// The same at the image.
    ImageNa(f64),
    /// The size of the stop.
    Stop,
}

/// Largest heights of a field in x and y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Heights {
    Object([f64; 2]),
    Image([f64; 2]),
}

/// A surface, and what comes after it.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// Line of the file.
    pub line: usize,
    pub comment: String,
    /// Turns and shifts the axes for itself and for all surfaces after it; such a surface is not met.
    pub turn: Option<Turn>,
    pub profile: Profile,
    /// Lines per mm along y, and the order that all light takes.
    pub grating: Option<[f64; 2]>,
    /// To the next surface along z.
    pub thickness: f64,
    pub after: After,
    /// Half of the diameter that light uses; 0 if the file does not say.
    pub semi_diameter: f64,
    /// Where the surface ends, if that is no circle about its axis.
    pub outline: Option<Outline>,
    /// Radius of the hole in it.
    pub hole: f64,
    /// Where light ends at it, without this share in the middle.
    pub dark: Option<(Outline, f64)>,
    pub stop: bool,
}

/// An ellipse or a rectangle in the plane of x and y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outline {
    pub centre: [f64; 2],
    /// Half of its size along x and y.
    pub half: [f64; 2],
    /// It is a rectangle.
    pub corners: bool,
}

impl Outline {
    fn round(radius: f64) -> Outline {
        Outline { centre: [0.0; 2], half: [radius; 2], corners: false }
    }
}

impl Surface {
    /// Where it ends; none if the file does not say.
    fn ends(&self) -> Option<Outline> {
        self.outline.or((self.semi_diameter > 0.0).then(|| Outline::round(self.semi_diameter)))
    }
}

/// What is behind a surface.
#[derive(Debug, Clone, PartialEq)]
pub enum After {
    Air,
    /// It reflects; the medium goes on.
    Mirror,
    /// A glass by its name, with n_d and V_d if the file says them.
    Glass {
        name: String,
        model: Option<[f64; 2]>,
    },
    /// n_d and V_d alone; V_d 0: the same at all wavelengths.
    Model([f64; 2]),
    /// A glass that the file itself defines: rows of nm and n, rising.
    Private(Vec<[f64; 2]>),
}

/// Axes turned and shifted.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Turn {
    pub shift: [f64; 3],
    /// About x, y, z, right-handed: a plane that is tilted about x by 45° sends light along z towards +y.
    pub tilt_deg: [f64; 3],
    /// Tilts about z, y, x come before the shift, instead of the shift before those about x, y, z.
    pub tilts_first: bool,
    /// Undoes all of that.
    pub inverse: bool,
}

/// What a prescription becomes.
#[derive(Debug, Clone)]
pub struct Made {
    /// Solids, mirrors and the image as meshes.
    pub assembly: Assembly,
    /// The sidecar that says what they are; the asset is called as asked.
    pub text: String,
    pub notes: Vec<Note>,
}

/// Whether a file is called as prescriptions are.
pub fn is_prescription(path: &Path) -> bool {
    matches!(super::extension(path).as_str(), "zmx" | "seq")
}

/// Reads the prescription at `path`.
///
/// # Errors
/// It can't be read, or has what can't be traced: one line, with the line of the file.
pub fn read(path: &Path) -> Result<Prescription> {
    let bytes = files::read(path, &Where::Nowhere, "prescription")?;
    let text = text::decoded(&bytes);
    match super::extension(path).as_str() {
        "zmx" => zmx::read(&text, path),
        "seq" => seq::read(&text, path),
        other => Err(Error::new(Where::file(path), format!("prescriptions in .{other} are not read"))
            .expected("a lens file of Zemax OpticStudio (.zmx) or CODE V (.seq)")),
    }
}

/// Parts and sidecar of the prescription at `path`; `asset` is what the sidecar calls the asset.
///
/// # Errors
/// Those of [`read`]; surfaces that do not make up solids.
pub fn make(path: &Path, asset: &str) -> Result<Made> {
    let mut prescription = read(path)?;
    let frames = frames::frames(&prescription);
    sizes::fill(&mut prescription, &frames, path);
    let design = solids::design(&prescription, &frames, path)?;
    let text = sidecar::write(&prescription, &design, &frames, (path, asset))?;
    let mut notes = prescription.notes;
    notes.extend(design.notes);
    Ok(Made { assembly: design.assembly, text, notes })
}
