//! What a path carries. The only thing that estimators do with it is to scale it and to ask for its light, so that more
//! wavelengths or Stokes vectors change this file and the vertex step, not the estimators.

use crate::film::accumulate::Light;
use crate::world::slide::SlideMap;

/// Throughput of a path. The slides' factors are kept apart: decisions of the path (roulette) must not depend on the
/// contrast, so that pictures for two contrasts share every path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    /// Everything but the slides.
    pub weight: f64,
    /// Product of the slides' transmittances, at their own contrast and as a polynomial.
    slides: Light,
}

impl Beam {
    pub fn new(weight: f64) -> Self {
        Beam { weight, slides: Light::ONE }
    }

    pub fn scale(&mut self, factor: f64) {
        self.weight *= factor;
    }

    /// Crosses a slide where its picture has the value `s`.
    pub fn cross(&mut self, slide: &SlideMap, s: f64) {
        let dark = 1.0 / slide.contrast();
        self.slides.cross(slide.t_white(), slide.t_white() * (dark + s * (1.0 - dark)), s);
    }

    /// The light of `amount` (luminance or flux) carried along this path.
    pub fn light(&self, amount: f64) -> Light {
        self.slides.scaled(self.weight * amount)
    }

    /// The light of a lamp-side piece `flux`, scaled by `factor` and carried on along this path: slides on both pieces
    /// multiply at each contrast.
    pub fn with_slides_of(&self, flux: Light, factor: f64) -> Light {
        self.slides.times(flux).scaled(factor * self.weight)
    }

    /// What is carried at the scene's own contrast.
    pub fn carried(&self) -> f64 {
        self.weight * self.slides.value
    }
}
