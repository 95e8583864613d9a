//! A pilot's smaller picture of what is planned for.

use eyebox_base::Result;
use eyebox_film::plan::Plan;
use eyebox_scene::Eye;
use eyebox_world::World;

/// The same world in a picture of fewer pixels.
pub(crate) struct PilotResolution {
    pub(crate) world: World,
    pub(crate) size: [usize; 2],
    /// Longer side of the real one, pixels.
    pub(crate) longer: usize,
    /// Of the pixels of the real one.
    pub(crate) share: f64,
}

impl PilotResolution {
    /// `side`: so many pixels along the longer side, or as the real one if that has no more. Errors: as [`World::seen_by`].
    pub(crate) fn new(world: &World, eye: &Eye, side: usize) -> Result<PilotResolution> {
        let [width, height] = eye.resolution;
        let longer = width.max(height);
        let scale = (side as f64 / longer.max(1) as f64).min(1.0);
        let size = eye.resolution.map(|n| ((n as f64 * scale).round() as usize).max(1));
        let world = world.seen_by(&Eye { resolution: size, ..eye.clone() })?;
        let share = (size[0] * size[1]) as f64 / (width * height).max(1) as f64;
        Ok(PilotResolution { world, size, longer, share })
    }

    pub(crate) fn pixels(&self) -> f64 {
        (self.size[0] * self.size[1]) as f64
    }

    /// The plan with fewer paths from lamps as there are fewer pixels, and as many photons within reach of a point.
    pub(crate) fn plan(&self, plan: &Plan) -> Plan {
        let mut own = plan.clone();
        if self.share < 1.0 {
            let fewer = |paths: u64| (paths as f64 * self.share).ceil() as u64;
            (own.forward_paths, own.photons) = (fewer(plan.forward_paths), fewer(plan.photons));
            own.photon_radii_m = plan.photon_radii_m.scaled(self.share.sqrt().recip());
        }
        own
    }
}
