//! Directions to the sky: by its luminance, and where a pilot has seen through which windows its light gets in, by these,
//! too.

use eyebox_film::guide::Portals;
use eyebox_world::sky::SkyLight;
use glam::DVec3;

/// How a scatterer chooses directions to the sky.
#[derive(Debug, Clone)]
pub(super) struct SkySampling {
    windows: Option<Portals>,
}

impl SkySampling {
    pub fn new(windows: Option<&Portals>) -> SkySampling {
        SkySampling { windows: windows.cloned() }
    }

    /// A unit direction at a point, and its density per steradian, which is 0 only if the sky is black. Both ways are chosen
    /// between by a part of `u`, so numbers that are even stay so.
    pub fn sample(&self, sky: &SkyLight, point: DVec3, [u, v]: [f64; 2]) -> (DVec3, f64) {
        let Some(windows) = &self.windows else { return sky.sample([u, v]) };
        let aimed = windows.aimed_from(point);
        let dir = if u < aimed {
            windows.direction(point, [u / aimed, v])
        } else {
            sky.sample([(u - aimed) / (1.0 - aimed), v]).0
        };
        (dir, self.pdf(sky, point, dir))
    }

    /// Density of [`SkySampling::sample`] in a unit direction at a point, 1/sr.
    pub fn pdf(&self, sky: &SkyLight, point: DVec3, dir: DVec3) -> f64 {
        let by_sky = sky.pdf(dir);
        self.windows.as_ref().map_or(by_sky, |windows| windows.among(point, dir, by_sky))
    }
}
