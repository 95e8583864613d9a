//! What depends on the wavelength, worked out for the lanes of one pass: a pass's paths share their wavelengths, so that
//! no ray evaluates a dispersion formula, photons and eye paths meet at equal wavelengths, and passes cover the
//! spectrum evenly.

use super::World;
use super::films::Films;
use super::mode::{LaneArray, Mode, Spectral, lanes};
use super::sky::SkyLight;
use super::slide::SlideMap;
use eyebox_film::accumulate::Light;
use eyebox_scene::Medium;
use glam::DVec3;

/// Optical constants of a world in the lanes of a mode.
#[derive(Debug, Clone)]
pub struct Optics<M: Mode> {
    lighting: Lighting<M>,
    /// Per part: real refractive index inside; 1 for a part that is no solid.
    index: Vec<M::Lanes<f64>>,
    /// Per part: Napierian absorption, 1/m, by `absorption_per_m` and by an imaginary index (4πk/λ).
    absorption_per_m: Vec<M::Lanes<f64>>,
    /// `[coating][lane]`
    films: Vec<Films>,
}

/// The wavelengths of the lanes and what they make of light.
#[derive(Debug, Clone)]
pub struct Lighting<M: Mode> {
    /// nm.
    pub nm: M::Lanes<f64>,
    /// Linear Rec.709 per unit of each lane's light.
    pub response: M::Lanes<[f64; 3]>,
    /// What the lanes have of a unit of the light of the lamps, the lights, and of red, green and blue skies.
    pub lamps: Vec<M::Lanes<f64>>,
    pub lights: Vec<M::Lanes<f64>>,
    pub sky: [M::Lanes<f64>; 3],
    /// What the lanes have of red, green and blue pixels of a slide.
    pub slide: [M::Lanes<f64>; 3],
    /// Per lane: the shares of red, green and blue of a colour in its reflectance. They sum to 1.
    pub reflectance: M::Lanes<[f64; 3]>,
}

impl<M: Mode> Optics<M> {
    /// What a world is in the lanes of `lighting`.
    pub fn new(world: &World, lighting: Lighting<M>) -> Self {
        let nm = lighting.nm;
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
            index: per_part(&|medium, nm| medium.index.index(nm).re, 1.0),
            absorption_per_m: (0..world.solids.len())
                .map(|part| {
                    lanes::<M, f64>(|lane| {
                        medium(part).map_or(0.0, |medium| match M::SPECTRAL {
                            Spectral::Rgb => medium.absorption_per_m_of(lane, nm[lane]),
                            Spectral::Mono | Spectral::Hero => medium.absorption_per_m_at(nm[lane]),
                        })
                    })
                })
                .collect(),
            films,
            lighting,
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

    /// Wavelength in vacuum of a lane, nm.
    #[inline]
    pub fn nm(&self, lane: usize) -> f64 {
        self.lighting.nm[lane]
    }

    /// Share that a lane has of a linear Rec.709 colour of 0 to 1.
    #[inline]
    pub fn reflected(&self, rgb: [f64; 3], lane: usize) -> f64 {
        let shares = self.lighting.reflectance[lane];
        shares.iter().zip(rgb).map(|(share, c)| share * c).sum::<f64>().clamp(0.0, 1.0)
    }

    /// Shares of red, green and blue of a surface's colour in its reflectance in a lane.
    #[inline]
    pub fn reflectance(&self, lane: usize) -> [f64; 3] {
        self.lighting.reflectance[lane]
    }

    /// Linear Rec.709 per unit of each lane's light.
    #[inline]
    pub fn response(&self) -> M::Lanes<[f64; 3]> {
        self.lighting.response
    }

    /// What the lanes have of a unit of a lamp's light.
    #[inline]
    pub fn lamp(&self, index: usize) -> M::Lanes<f64> {
        self.lighting.lamps[index]
    }

    /// What the lanes have of a unit of a lamp's light at a place of it, which has `glow` of the whole.
    #[inline]
    pub fn lamp_at(&self, index: usize, glow: Option<[f64; 3]>) -> M::Lanes<f64> {
        let whole = self.lighting.lamps[index];
        let Some(rgb) = glow else { return whole };
        let here = self.glow(rgb);
        lanes::<M, f64>(|lane| whole[lane] * here[lane])
    }

    /// How much of a lamp's mean light the lanes have at a place of it that has so much.
    #[inline]
    pub fn glow(&self, rgb: [f64; 3]) -> M::Lanes<f64> {
        lanes::<M, f64>(|lane| {
            let shares = self.lighting.reflectance[lane];
            shares.iter().zip(rgb).map(|(share, c)| share * c).sum::<f64>().max(0.0)
        })
    }

    /// What the lanes have of a unit of a light's light.
    #[inline]
    pub fn light(&self, index: usize) -> M::Lanes<f64> {
        self.lighting.lights[index]
    }

    /// Luminance of the sky per lane.
    #[inline]
    pub fn sky(&self, sky: &SkyLight, dir: DVec3) -> M::Lanes<f64> {
        sky.pixel(dir).map_or_else(|| lanes::<M, f64>(|_| 0.0), |pixel| self.sky_at(sky, pixel))
    }

    /// The same of a pixel of its picture.
    #[inline]
    pub fn sky_at(&self, sky: &SkyLight, pixel: usize) -> M::Lanes<f64> {
        if M::LANES == 1 {
            let luminance = sky.luminance_of(pixel);
            return lanes::<M, f64>(|_| luminance);
        }
        mixed::<M>(&self.lighting.sky, sky.rgb_of(pixel))
    }

    /// Value s of a slide's picture per lane; none outside the picture.
    #[inline]
    pub fn slide(&self, slide: &SlideMap, local: DVec3) -> Option<M::Lanes<f64>> {
        Some(self.slide_at(slide, slide.pixel(local)?))
    }

    /// Takes light through a slide of this rank where its picture is `s` per lane.
    #[inline]
    pub fn cross_slide(&self, light: &mut M::Lanes<Light>, (slide, rank): (&SlideMap, f64), s: &M::Lanes<f64>) {
        for lane in 0..M::LANES {
            light[lane].cross(slide.t_white(), slide.transmittance(s[lane]), s[lane], rank);
        }
    }

    /// The value of a pixel of the picture per lane.
    #[inline]
    pub fn slide_at(&self, slide: &SlideMap, pixel: usize) -> M::Lanes<f64> {
        if M::LANES == 1 || !slide.is_coloured() {
            let s = slide.s_of(pixel);
            return lanes::<M, f64>(|_| s);
        }
        let (own, rgb) = (&self.lighting.slide, slide.rgb_of(pixel));
        let Some(white) = slide.primaries() else { return mixed::<M>(own, rgb) };
        // The lamp's light is that of all primaries: what these have of it in a lane.
        let all = mixed::<M>(own, white);
        let shown = mixed::<M>(own, std::array::from_fn(|c| white[c] * rgb[c]));
        lanes::<M, f64>(|lane| if all[lane] > 0.0 { (shown[lane] / all[lane]).min(1.0) } else { 0.0 })
    }
}

fn mixed<M: Mode>(primaries: &[M::Lanes<f64>; 3], rgb: [f64; 3]) -> M::Lanes<f64> {
    lanes::<M, f64>(|lane| primaries.iter().zip(rgb).map(|(primary, share)| primary[lane] * share).sum())
}
