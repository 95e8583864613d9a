//! The colours of a world's lamps: spectra per lumen, worked out once.

use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Where};
use eyebox_scene::{PowerDistribution, Scene, Spectrum, Wavelengths};

/// Power per nm and lumen of each lamp and light; empty where one wavelength is traced.
#[derive(Debug, Clone, Default)]
pub struct Tints {
    pub lamps: Vec<PowerDistribution>,
    pub lights: Vec<PowerDistribution>,
}

impl Tints {
    /// `lamps`: the spectra of the emitting faces in the order of the world's lamps. What says nothing shines like D65.
    /// Errors: a spectrum that is none.
    pub fn build<'s>(scene: &'s Scene, lamps: impl Iterator<Item = Option<&'s Spectrum>>) -> Result<Tints> {
        match scene.wavelengths {
            Wavelengths::Mono { .. } => Ok(Tints::default()),
            Wavelengths::Visible => {
                let lights = scene.lights.iter().map(|light| light.spectrum.as_ref());
                Ok(Tints {
                    lamps: lamps.map(resolved).collect::<Result<_>>()?,
                    lights: lights.map(resolved).collect::<Result<_>>()?,
                })
            }
        }
    }
}

fn resolved(spectrum: Option<&Spectrum>) -> Result<PowerDistribution> {
    let spectrum = spectrum.unwrap_or(&Spectrum::D65);
    let power = spectrum.resolve().map_err(|what| {
        Error::new(Where::Nowhere, format!("the spectrum {spectrum} of a lamp: {what}")).code(Code::SpectrumUnusable)
    })?;
    Ok(power.luminous_normalised())
}
