//! What diffraction makes of a picture's sharpness, as the header holds it and `view` says it.

use super::pupil::Pupil;
use eyebox_base::units::ARCMIN;

/// What a light group has of the pupil, and how that is known.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct GroupPupil {
    pub group: String,
    pub pupil: Pupil,
    pub because: String,
}

/// The diffraction limit of one light group's direct vision.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct GroupLimit {
    pub group: String,
    /// Measured, or taken to be the whole pupil.
    pub measured: bool,
    /// Effective area (∫A)²/∫A² of the amplitude A in the pupil.
    pub lit_area_mm2: f64,
    /// Side of the square of that area.
    pub lit_width_mm: f64,
    /// Diameter of the disc of that area.
    pub lit_diameter_mm: f64,
    /// Standard deviation of the lit places to the right and up.
    pub lit_rms_mm: [f64; 2],
    /// λ/width: the side of the square that a point spreads to, its flux over its peak.
    pub limit_arcmin: f64,
    /// 1.22 λ/diameter: the first dark ring of a disc of the lit area.
    pub rayleigh_arcmin: f64,
    pub because: String,
}

/// The blur that was applied to one layer of one group.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Blurred {
    pub layer: String,
    pub group: String,
    /// The part of the pupil, or `none` with the reason.
    pub by: String,
    /// Share of the luminance that left the picture over its edge.
    pub left: f64,
}

/// What `--diffraction` did.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Applied {
    /// Wavelengths at which R, G and B are spread, nm.
    pub wavelengths_nm: [f64; 3],
    pub layers: Vec<Blurred>,
    /// What the standard errors of the frame are of.
    pub stderr: String,
}

/// The record.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Sharpness {
    /// Wavelength of the limits, nm.
    pub wavelength_nm: f64,
    /// Width and height of the middle pixel.
    pub pixel_arcmin: [f64; 2],
    pub groups: Vec<GroupLimit>,
    /// None: the picture is geometric.
    pub applied: Option<Applied>,
}

impl Sharpness {
    /// The header's entry that holds this as JSON.
    pub const KEY: &str = "diffraction";

    /// `pixel`: width and height of a pixel in tangents.
    pub fn new(pupils: &[GroupPupil], wavelength_nm: f64, pixel: [f64; 2]) -> Sharpness {
        let groups = pupils.iter().filter_map(|of| GroupLimit::of(of, wavelength_nm)).collect();
        let pixel_arcmin = pixel.map(|tangent| tangent.atan() / ARCMIN);
        Sharpness { wavelength_nm, pixel_arcmin, groups, applied: None }
    }

    /// The group with the largest limit. One that was measured goes before those that are taken to fill the pupil.
    pub fn worst(&self) -> Option<&GroupLimit> {
        let measured = self.groups.iter().any(|group| group.measured);
        let groups = self.groups.iter().filter(|group| group.measured == measured);
        groups.max_by(|a, b| a.limit_arcmin.total_cmp(&b.limit_arcmin))
    }

    /// The largest limit in pixels, along the axis where it has more.
    pub fn pixels(&self) -> Option<f64> {
        let pixel = self.pixel_arcmin[0].min(self.pixel_arcmin[1]);
        self.worst().map(|group| group.limit_arcmin / pixel).filter(|pixels| pixels.is_finite())
    }

    /// For people, one line per group and one for what was done.
    pub fn lines(&self) -> Vec<String> {
        let limit = |of: &GroupLimit| {
            format!(
                "diffraction limit of {}: {:.2}′ (lit pupil {:.3} mm); {}",
                of.group, of.limit_arcmin, of.lit_width_mm, of.because
            )
        };
        let mut lines: Vec<String> = self.groups.iter().map(limit).collect();
        match &self.applied {
            None => lines.push("the picture is geometric: diffraction was not applied".to_owned()),
            Some(applied) => lines.extend(applied.layers.iter().map(|of| {
                format!(
                    "{} of {}: spread by {}; {:.3} % of its light left the picture",
                    of.layer,
                    of.group,
                    of.by,
                    100.0 * of.left
                )
            })),
        }
        lines
    }
}

impl GroupLimit {
    /// None for a pinhole.
    fn of(of: &GroupPupil, wavelength_nm: f64) -> Option<GroupLimit> {
        let area = of.pupil.area_m2();
        if !area.is_normal() {
            return None;
        }
        let (width, diameter) = (area.sqrt(), (4.0 * area / std::f64::consts::PI).sqrt());
        let lambda = 1e-9 * wavelength_nm;
        Some(GroupLimit {
            group: of.group.clone(),
            measured: matches!(of.pupil, Pupil::Lit(_)),
            lit_area_mm2: 1e6 * area,
            lit_width_mm: 1e3 * width,
            lit_diameter_mm: 1e3 * diameter,
            lit_rms_mm: of.pupil.rms_m().map(|rms| 1e3 * rms),
            limit_arcmin: lambda / width / ARCMIN,
            rayleigh_arcmin: 1.219_669_9 * lambda / diameter / ARCMIN,
            because: of.because.clone(),
        })
    }
}
