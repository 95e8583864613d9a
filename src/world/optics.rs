//! What depends on the wavelength, worked out for the lanes of one pass: a pass's paths share their wavelengths, so that
//! no ray evaluates a dispersion formula, photons and eye paths meet at equal wavelengths, and passes cover the
//! spectrum evenly.

use super::World;
use super::mode::{LaneArray, Mode, lanes};
use super::sky::SkyLight;
use super::surface::Films;
use crate::scene::Medium;
use glam::DVec3;

/// Optical constants of a world in the lanes of a mode.
#[derive(Debug, Clone)]
pub struct Optics<M: Mode> {
    /// Wavelength in vacuum of each lane, nm.
    pub nm: M::Lanes<f64>,
    /// Per part: real refractive index inside; 1 for a part that is no solid.
    index: Vec<M::Lanes<f64>>,
    /// Per part: Napierian absorption, 1/m, by `absorption_per_m` and by an imaginary index (4πk/λ).
    absorption_per_m: Vec<M::Lanes<f64>>,
    /// `[coating][lane]`
    films: Vec<Films>,
    /// Per lamp and per light: what each lane has of a unit of its light.
    lamps: Vec<M::Lanes<f64>>,
    lights: Vec<M::Lanes<f64>>,
    /// Linear Rec.709 per unit of each lane's light.
    pub response: M::Lanes<[f64; 3]>,
}

impl<M: Mode> Optics<M> {
    /// For lanes at the wavelengths `nm`.
    pub fn at(world: &World, nm: M::Lanes<f64>, response: M::Lanes<[f64; 3]>) -> Self {
        let medium = |part: usize| world.media_of_parts[part].as_ref();
        let parts = 0..world.solids.len();
        let per_part = |value: &dyn Fn(&Medium, f64) -> f64, without: f64| {
            parts
                .clone()
                .map(|part| lanes::<M, f64>(|lane| medium(part).map_or(without, |medium| value(medium, nm[lane]))))
                .collect()
        };
        let films = std::iter::once(None)
            .chain(world.coatings.iter().map(Some))
            .flat_map(|coating| nm.as_slice().iter().map(move |&nm| Films::at(coating, nm)))
            .collect();
        Optics {
            nm,
            index: per_part(&|medium, nm| medium.index.index(nm).re, 1.0),
            absorption_per_m: per_part(&Medium::absorption_per_m_at, 0.0),
            films,
            lamps: vec![lanes::<M, f64>(|_| 1.0); world.lamps.all().len()],
            lights: vec![lanes::<M, f64>(|_| 1.0); world.lights.all().len()],
            response,
        }
    }

    /// Refractive index inside `part`; of air for none.
    #[inline]
    pub fn index_in(&self, part: Option<u32>) -> M::Lanes<f64> {
        part.map_or_else(|| lanes::<M, f64>(|_| 1.0), |part| self.index[part as usize])
    }

    /// Absorption inside `part`, 1/m; none of it where nothing is absorbed.
    #[inline]
    pub fn absorption_in(&self, part: u32) -> Option<M::Lanes<f64>> {
        let absorption = self.absorption_per_m[part as usize];
        absorption.as_slice().iter().any(|a| *a > 0.0).then_some(absorption)
    }

    /// The films of a coating in a lane.
    #[inline]
    pub fn films(&self, coating: usize, lane: usize) -> &Films {
        &self.films[coating * M::LANES + lane]
    }

    /// What the lanes have of a unit of a lamp's light.
    #[inline]
    pub fn lamp(&self, index: usize) -> M::Lanes<f64> {
        self.lamps[index]
    }

    /// What the lanes have of a unit of a light's light.
    #[inline]
    pub fn light(&self, index: usize) -> M::Lanes<f64> {
        self.lights[index]
    }

    /// Luminance of the sky per lane.
    #[inline]
    pub fn sky(&self, sky: &SkyLight, dir: DVec3) -> M::Lanes<f64> {
        let luminance = sky.luminance(dir);
        lanes::<M, f64>(|_| luminance)
    }
}
