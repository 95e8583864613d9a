//! Lamps that are the rays of a file, in the frame of the part that they leave.

use super::build::{Builder, intern};
use super::files;
use super::lamps::efficacy_lm_per_w;
use super::optics::{EmitterSpec, Strength};
use super::ray_file::{self, Bundle, RayFile};
use super::select::Candidate;
use eyebox_base::error::Result;
use eyebox_base::ids::{GroupId, PartId};
use eyebox_base::{Code, Error, Shared, Where};
use eyebox_scene::{Beacon, BeaconForm, Group, Note, Photometry, RaySet, Spectrum, Wavelengths};
use std::path::Path;

/// A ray file as it was read, once for all parts that it is bound to.
#[derive(Debug, Clone)]
pub(super) struct KnownRays {
    /// In lm, as the header states it.
    lumens: Option<f64>,
    bundles: Vec<(Shared<RaySet>, Bundle)>,
}

/// By how much of it a header's luminous flux may be off from that of the rays by their spectra before that is worth a warning.
const OFF: f64 = 0.01;

/// The light of one bundle, where it is known.
#[derive(Debug, Clone, Copy)]
struct Light {
    lumens: Option<f64>,
    watts: Option<f64>,
}

impl Builder<'_> {
    /// The lamps of a ray file that is bound to part number `index` of the scene: one for each spectrum that the file has.
    pub(super) fn rays(
        &mut self,
        index: usize,
        part: &Candidate,
        spec: EmitterSpec,
        file: (&str, &Where),
    ) -> Result<()> {
        let (name, at) = (files::resolve(file.0, file.1), file.1);
        let known = self.known_rays(&name, at)?;
        let group = GroupId::from_index(intern(&mut self.groups, Group { name: spec.group }));
        let said = spec.spectrum.map(|spectrum| self.spectrum(spectrum)).transpose()?;
        let shown = name.display();
        if said.is_some() && known.bundles.iter().any(|(_, bundle)| bundle.spectrum.is_some()) {
            self.note(Note::info(at.clone(), format!("{shown}: its own spectra are not used beside `spectrum`")));
        }
        let spectrum_of = |bundle: &Bundle| said.clone().or_else(|| bundle.spectrum.clone());
        for (_, bundle) in &known.bundles {
            if let Some(problem) = spectrum_of(bundle).and_then(|spectrum| spectrum.problem()) {
                let what = format!("{shown}: the spectrum of its rays can't be used: {problem}");
                return Err(Error::new(at.clone(), what).expected("visible light").code(Code::SpectrumUnusable));
            }
            if spectrum_of(bundle).is_none() && self.coloured() {
                self.note(Note::info(
                    at.clone(),
                    format!("{shown} does not say its spectrum, nor does `spectrum`: D65"),
                ));
            }
        }
        let lights: Vec<Light> = known
            .bundles
            .iter()
            .map(|(_, bundle)| light(bundle, said.as_ref(), spectrum_of(bundle).as_ref(), self.wavelengths))
            .collect();
        let flux = flux(&lights, known.lumens, &spec.strength).map_err(|why| {
            Error::new(at.clone(), format!("{shown}: {why}"))
                .expected("flux_lm or a spectrum beside it")
                .code(Code::StrengthMissing)
        })?;
        let measured: Option<Vec<f64>> = lights.iter().map(|light| light.lumens).collect();
        let measured = measured.filter(|_| self.coloured()).map(|lumens| lumens.iter().sum::<f64>());
        if let (Some(stated), Some(sum), Strength::Said(Photometry::AsMeasured)) =
            (known.lumens, measured, &spec.strength)
            && (stated - sum).abs() > OFF * stated
        {
            let text = format!(
                "{shown}: its rays have {sum:.6} lm by their spectrum, and its header states {stated:.6} lm, which holds"
            );
            self.note(Note::warning(at.clone(), text));
        }
        self.note(Note::info(
            at.clone(),
            format!("{shown}: its rays are taken for {:.6} lm", flux.iter().sum::<f64>()),
        ));
        for ((rays, bundle), flux_lm) in known.bundles.iter().zip(flux).filter(|(_, flux)| *flux > 0.0) {
            let form = BeaconForm::Rays { rays: rays.clone(), part: PartId::from_index(index), flux_lm };
            let beacon = Beacon { name: part.path.clone(), group, form, spectrum: spectrum_of(bundle) };
            // The rays are the part's, however many of its faces they are bound to.
            if !self.beacons.contains(&beacon) {
                self.beacons.push(beacon);
            }
        }
        Ok(())
    }

    fn note(&mut self, note: Note) {
        if !self.notes.contains(&note) {
            self.notes.push(note);
        }
    }

    fn known_rays(&mut self, file: &Path, at: &Where) -> Result<KnownRays> {
        if let Some(known) = self.ray_files.get(file) {
            return Ok(known.clone());
        }
        let RayFile { format, bundles, lumens, remarks } = ray_file::read(file, at)?;
        let name = file.display().to_string();
        let count: usize = bundles.iter().map(|bundle| bundle.rays.len()).sum();
        self.note(Note::info(at.clone(), format!("{name}: {format}, {count} rays")));
        for remark in remarks {
            self.note(Note::warning(at.clone(), format!("{name}: {remark}")));
        }
        let set = |mut bundle: Bundle| {
            let rays = RaySet::new(name.clone(), std::mem::take(&mut bundle.rays))?;
            Some((Shared::from(rays), bundle))
        };
        let known = KnownRays { lumens, bundles: bundles.into_iter().filter_map(set).collect() };
        self.files.push(file.to_owned());
        self.ray_files.insert(file.to_owned(), known.clone());
        Ok(known)
    }
}

/// What a bundle has of light: as the file measured it, by each ray's wavelength, or by its spectrum; of a scene of one
/// wavelength, as all radiant flux there, at that.
fn light(bundle: &Bundle, said: Option<&Spectrum>, spectrum: Option<&Spectrum>, wavelengths: Wavelengths) -> Light {
    let per_watt = efficacy_lm_per_w(spectrum, wavelengths).ok();
    let by_wavelength = match (wavelengths, said) {
        (Wavelengths::Visible, None) => bundle.by_wavelength,
        (Wavelengths::Visible, Some(_)) | (Wavelengths::Mono { .. }, _) => None,
    };
    let of = |number: Option<f64>, factor: Option<f64>| Some(number? * factor?);
    Light {
        lumens: bundle.lumens.or(by_wavelength).or_else(|| of(bundle.watts, per_watt)),
        watts: bundle.watts.or_else(|| of(bundle.lumens, per_watt.map(f64::recip))),
    }
}

/// The luminous flux of each bundle, lm. `stated`: of all, by the file. Errors: what is missing.
fn flux(lights: &[Light], stated: Option<f64>, strength: &Strength) -> Result<Vec<f64>, String> {
    let all = |of: fn(&Light) -> Option<f64>| lights.iter().map(of).collect::<Option<Vec<f64>>>();
    let (lumens, watts) = (all(|light| light.lumens), all(|light| light.watts));
    let scaled = |shares: &[f64], whole: f64| {
        let sum: f64 = shares.iter().sum();
        shares.iter().map(|share| share * (whole / sum)).collect::<Vec<f64>>()
    };
    let unknown = || "it has radiant flux alone, of a spectrum that nobody says".to_owned();
    // Where nothing tells how bright a watt is, all are as bright.
    let shares = lumens.clone().or_else(|| watts.clone()).ok_or_else(unknown)?;
    match strength {
        Strength::RadiantFluxW { watts: whole, .. } => {
            let (lumens, watts) = lumens.zip(watts).ok_or_else(unknown)?;
            let factor = whole / watts.iter().sum::<f64>();
            Ok(lumens.iter().map(|lumens| lumens * factor).collect())
        }
        Strength::Said(Photometry::FluxLm(whole)) => Ok(scaled(&shares, *whole)),
        Strength::Said(Photometry::AsMeasured | Photometry::LuminanceCdM2(_) | Photometry::IntensityCd(_)) => {
            // What is stated holds, as far as spectra say otherwise.
            match (stated, lumens) {
                (Some(stated), _) => Ok(scaled(&shares, stated)),
                (None, Some(lumens)) => Ok(lumens),
                (None, None) => Err(unknown()),
            }
        }
    }
}
