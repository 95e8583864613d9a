//! Emitting faces, their measured distributions, and the sun.

use super::build::{Builder, intern};
use super::measure::FaceMeasure;
use super::optics::{self, EmitterSpec, Spreading, Strength};
use super::select::Candidate;
use super::value::Value;
use super::{files, frames, photometric};
use eyebox_base::colour::{K_M, cmf};
use eyebox_base::error::Result;
use eyebox_base::ids::{GroupId, ProfileId};
use eyebox_base::{Code, Error, Where};
use eyebox_scene::{
    Angular, Beacon, BeaconForm, Emitter, Group, LuminousProfile, Note, Photometry, PolarisedLight, Spectrum,
    Wavelengths,
};
use glam::DVec3;
use std::path::Path;

/// Lumens of a watt: of the scene's one wavelength, else of the spectrum from 360 to 830 nm. Errors: no spectrum, none
/// that can be seen.
pub(super) fn efficacy_lm_per_w(spectrum: Option<&Spectrum>, wavelengths: Wavelengths) -> Result<f64, String> {
    let per_watt = match (wavelengths, spectrum) {
        (Wavelengths::Mono { nm }, _) => K_M * cmf(nm)[1],
        (Wavelengths::Visible, Some(spectrum)) => spectrum.resolve()?.lumens_per_watt(),
        (Wavelengths::Visible, None) => return Err("its spectrum is not said".to_owned()),
    };
    if per_watt > 0.0 && per_watt.is_finite() { Ok(per_watt) } else { Err(format!("its light has {per_watt} lm/W")) }
}

/// The least share of a profile's flux behind a face that is worth a warning.
const BEHIND: f64 = 1e-3;

impl Builder<'_> {
    pub(super) fn emitter(&mut self, part: &Candidate, number: usize, spec: EmitterSpec) -> Result<Emitter> {
        let mesh = self.assembly.meshes.get(part.mesh).map(|source| &source.mesh);
        let normal = mesh.and_then(|mesh| FaceMeasure::new(mesh, number)?.normal());
        let u = spec.u.unwrap_or_else(|| match normal {
            Some(normal) if normal.x.abs() > std::f64::consts::FRAC_1_SQRT_2 => DVec3::Y,
            Some(_) | None => DVec3::X,
        });
        let angular = match spec.angular {
            Spreading::Lambert => Angular::Lambert,
            Spreading::CosN { n } => Angular::CosN { n },
            Spreading::Gauss { fwhm_deg } => Angular::Gauss { fwhm_deg },
            Spreading::Profile { file, at } => {
                let measured = self.measured(&files::resolve(&file, &at), &at)?;
                self.behind(&measured, &at)?;
                Angular::Profile { profile: self.profile(measured), c0: u }
            }
            Spreading::RayFile { at, .. } => return Err(Error::new(at, "the rays of a file are no face")),
        };
        let polarisation = spec.polarisation.map(|(angle, degree)| {
            let normal = normal.unwrap_or(DVec3::Z);
            let along = (u - normal * normal.dot(u)).try_normalize().unwrap_or(u);
            PolarisedLight { axis: along * angle.cos() + normal.cross(along) * angle.sin(), degree }
        });
        let group = GroupId::from_index(intern(&mut self.groups, Group { name: spec.group }));
        let spectrum = spec.spectrum.map(|spectrum| self.spectrum(spectrum)).transpose()?;
        let photometry = match spec.strength {
            Strength::Said(photometry) => photometry,
            Strength::RadiantFluxW { watts, at } => {
                let per_watt = efficacy_lm_per_w(spectrum.as_ref(), self.wavelengths).map_err(|why| {
                    Error::new(at.clone(), format!("`radiant_flux_w` of emitter: {why}"))
                        .expected("a spectrum beside it, or flux_lm")
                })?;
                let flux = watts * per_watt;
                let text = format!("{watts} W are {flux:.6} lm at {per_watt:.4} lm/W");
                self.notes.push(Note::info(at, text));
                Photometry::FluxLm(flux)
            }
        };
        Ok(Emitter { group, photometry, angular, spectrum, polarisation, both_sides: spec.both_sides, pattern: None })
    }

    /// The profile in a file that `at` names.
    pub(super) fn measured(&mut self, file: &Path, at: &Where) -> Result<LuminousProfile> {
        if let Some(known) = self.measured.get(file) {
            return Ok(known.clone());
        }
        let profile = photometric::profile(file, at, &mut self.notes)?;
        if let (Some(lumens), false) = (profile.facts.lamp_lumens, profile.facts.absolute) {
            let text = format!(
                "{}: {:.4} lm of the {:.4} lm of its lamps leave the luminaire; its candela are taken as they are",
                profile.file,
                profile.flux_lm(),
                lumens
            );
            self.notes.push(Note::info(at.clone(), text));
        }
        self.files.push(file.to_owned());
        self.files.extend(photometric::tilt_file(file).filter(|tilt| tilt.is_file()));
        self.measured.insert(file.to_owned(), profile.clone());
        Ok(profile)
    }

    pub(super) fn profile(&mut self, profile: LuminousProfile) -> ProfileId {
        ProfileId::from_index(intern(&mut self.profiles, profile))
    }

    /// A face shines to its front only. Error: the profile does not.
    pub(super) fn behind(&mut self, profile: &LuminousProfile, at: &Where) -> Result<()> {
        let (whole, front) = (profile.flux_lm(), profile.front().flux_lm());
        if front <= 0.0 {
            let what = format!("the light profile {} has no light in front of the face", profile.file);
            return Err(Error::new(at.clone(), what)
                .expected("one that shines about its direction (0, 0)")
                .code(Code::ProfileBehindFace));
        }
        if front < (1.0 - BEHIND) * whole {
            let text = format!(
                "{}: {:.4} of its {:.4} lm go backwards, where a face has no light: left out",
                profile.file,
                whole - front,
                whole
            );
            self.notes.push(Note::warning(at.clone(), text).code(Code::ProfileBehindFace));
        }
        Ok(())
    }

    /// A distant lamp with a disc.
    pub(super) fn sun(&mut self, value: &Value) -> Result<Beacon> {
        let spec = optics::sun(value, &mut self.notes)?;
        let frame = frames::frame_rotation(self.assembly, spec.frame.as_ref())?;
        let group = GroupId::from_index(intern(&mut self.groups, Group { name: spec.group }));
        let form = BeaconForm::Distant {
            dir: -(frame * spec.direction),
            illuminance_lx: spec.illuminance_lx,
            angle_rad: spec.angle_deg.to_radians(),
        };
        // CIE daylight of 5500 K is the sun with its sky; D65, which holds where nothing is said, is near enough to both.
        Ok(Beacon { name: "sun".to_owned(), group, form, spectrum: None })
    }
}
