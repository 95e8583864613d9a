//! What paths from the eye bring in a pilot, by two of them in each of some pixels, and what they cost.

use super::Backward;
use super::over_sky::OverSky;
use crate::ShouldStop;
use crate::ledger::Ledger;
use crate::pixel::Pixel;
use eyebox_base::lattice::lattice;
use eyebox_base::parallel;
use eyebox_film::accumulate::Light;
use eyebox_world::mode::{Mode, Mono};

/// Light and counted work of paths, two to a pixel.
#[derive(Debug)]
pub struct Trial {
    /// Luminance by each path, cd/m².
    light: Vec<[f64; 2]>,
    work: u64,
}

impl Trial {
    /// Counted work of a path.
    pub fn work_of_a_path(&self) -> f64 {
        self.work as f64 / (2 * self.light.len()).max(1) as f64
    }

    /// Variance of a path relative to the squares of these luminances and a tenth of their mean, as a pixel that is dark by
    /// chance would count for too much; infinite where all are black.
    pub fn variance(&self, pixels: &[f64]) -> f64 {
        let count = pixels.len().max(1) as f64;
        let floor = (0.1 * pixels.iter().sum::<f64>() / count).powi(2);
        if floor.is_nan() || floor <= 0.0 {
            return f64::INFINITY;
        }
        let of = |([a, b], mean): (&[f64; 2], &f64)| 0.5 * (a - b).powi(2) / (mean * mean + floor);
        self.light.iter().zip(pixels).map(of).sum::<f64>() / count
    }

    /// Mean of each pixel's paths, cd/m².
    pub fn means(&self) -> Vec<f64> {
        self.light.iter().map(|[a, b]| 0.5 * (a + b)).collect()
    }
}

impl Backward<'_, Mono> {
    /// Follows a path of each of two passes in each of `count` pixels spread over the picture, without those to lamps over
    /// specular faces alone, and with borders in the sky's picture cut as the passes will. Once `stop` says true the rest is left
    /// out, and the result is worthless.
    pub fn trial(mut self, count: u64, passes: [u64; 2], stop: &ShouldStop<'_>) -> Trial {
        let [width, height] = self.world.eye.size();
        let optics = Mono::<f64>::optics(self.world, self.seed, 0);
        let place = |k: u64| {
            let [x, y]: [f64; 2] = lattice([0; 2], k);
            [((x * width as f64) as usize).min(width - 1), ((y * height as f64) as usize).min(height - 1)]
        };
        let places: Vec<[usize; 2]> = (0..count).map(place).collect();
        self.over_sky = OverSky::find(self.world, &self.route, self.seed, Some(&places));
        let one = |&[x, y]: &[usize; 2]| {
            let mut work = 0;
            let light = passes.map(|pass| {
                if stop() {
                    return 0.0;
                }
                let mut ledgers = [Ledger::new(self.world.solids.len()), Ledger::new(self.world.solids.len())];
                let mut light = vec![Light::default(); self.route.planes.len()];
                let pixel = Pixel::new((x, y), width, pass);
                self.paths_of(&optics, pixel, &mut light, &mut ledgers);
                work += ledgers.iter().map(|ledger| ledger.work).sum::<u64>();
                light.iter().map(|light| light.value).sum()
            });
            (light, work)
        };
        let all: Vec<([f64; 2], u64)> = parallel::map_all(&places, &one);
        Trial { light: all.iter().map(|(light, _)| *light).collect(), work: all.iter().map(|(_, work)| work).sum() }
    }
}
