//! A train of mirrors that is symmetric about the plane x = 0, followed from the eye: where its mirrors stand, and what
//! their curvature must be for the eye to see a display at a distance.

use super::build::frame;
use glam::{DAffine3, DQuat, DVec3};

/// A narrow pencil about the axis in one plane: height over the axis and slope, each of a ray that leaves the eye at height 1
/// or with slope 1.
#[derive(Debug, Clone, Copy)]
pub struct Pencil {
    /// Height and slope of the ray from height 1.
    of_height: [f64; 2],
    /// Of the ray with slope 1.
    of_slope: [f64; 2],
}

impl Pencil {
    const START: Pencil = Pencil { of_height: [1.0, 0.0], of_slope: [0.0, 1.0] };

    fn each(&mut self, change: impl Fn(&mut [f64; 2])) {
        change(&mut self.of_height);
        change(&mut self.of_slope);
    }

    /// How far off the axis light is here that leaves the eye at most at `height` and with at most `slope`.
    pub fn reach(&self, height: f64, slope: f64) -> f64 {
        (self.of_height[0] * height).abs() + (self.of_slope[0] * slope).abs()
    }

    /// Height here of a ray of slope 1 through the middle of the pupil.
    pub fn per_slope(&self) -> f64 {
        self.of_slope[0]
    }

    /// 1/f of a mirror here for which the eye sees at `image` m what is `object` m behind the mirror: rays from all over
    /// the pupil that aim at one point at `image` meet at `object`.
    pub fn power(&self, image: f64, object: f64) -> f64 {
        let [height, slope] = [0, 1].map(|i| self.of_height[i] - self.of_slope[i] / image);
        (slope + height / object) / height
    }
}

/// The axis as far as it has been followed.
#[derive(Debug, Clone, Copy)]
pub struct Train {
    pub at: DVec3,
    pub dir: DVec3,
    /// In the plane of x.
    pub sagittal: Pencil,
    /// In the plane x = 0.
    pub tangential: Pencil,
}

/// Radii of a mirror, positive if it is hollow: along x, and along y in the plane of incidence.
#[derive(Debug, Clone, Copy)]
pub struct Radii {
    pub x: f64,
    pub y: f64,
}

impl Radii {
    pub const FLAT: Radii = Radii { x: f64::INFINITY, y: f64::INFINITY };
}

impl Train {
    pub fn new(at: DVec3, dir: DVec3) -> Train {
        Train { at, dir, sagittal: Pencil::START, tangential: Pencil::START }
    }

    pub fn travel(&mut self, distance: f64) {
        self.at += distance * self.dir;
        for pencil in [&mut self.sagittal, &mut self.tangential] {
            pencil.each(|[height, slope]| *height += distance * *slope);
        }
    }

    /// Radii that a mirror under this angle of incidence needs here: Coddington's equations, 1/f = 2 cos θ/R across the plane
    /// of incidence and 2/(R cos θ) in it (W. T. Welford, Aberrations of Optical Systems, 1986, ch. 9).
    pub fn radii(&self, turn: f64, image: f64, object: f64) -> Radii {
        let [x, y] = [self.sagittal, self.tangential].map(|pencil| pencil.power(image, object));
        Radii { x: 2.0 * turn.cos() / x, y: 2.0 / (y * turn.cos()) }
    }

    /// Reflects at a mirror whose normal is turned about x by `turn` from the way that light comes; its frame, z towards the
    /// light.
    pub fn reflect(&mut self, turn: f64, radii: Radii) -> DAffine3 {
        let normal = (DQuat::from_rotation_x(turn) * -self.dir).normalize();
        self.dir = (self.dir - 2.0 * self.dir.dot(normal) * normal).normalize();
        let (x, y) = (2.0 * turn.cos() / radii.x, 2.0 / (radii.y * turn.cos()));
        self.sagittal.each(|[height, slope]| *slope -= x * *height);
        self.tangential.each(|[height, slope]| *slope -= y * *height);
        frame(self.at, normal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Through a windshield under 60° and a mirror under 18°: rays from all over the pupil that aim at one point of the image
    /// meet at one point of the display, in both planes.
    #[test]
    fn the_eye_sees_the_display_at_the_image_distance() {
        let mut train = Train::new(DVec3::ZERO, DVec3::NEG_Z);
        train.travel(0.8);
        train.reflect(60f64.to_radians(), Radii { x: 2.5, y: 5.0 });
        train.travel(0.3);
        let turn = 18f64.to_radians();
        let radii = train.radii(turn, 3.0, 0.2);
        assert!(radii.x > 0.0 && radii.y > 0.0, "{radii:?}");
        train.reflect(turn, radii);
        train.travel(0.2);
        for pencil in [train.sagittal, train.tangential] {
            // (1, −1/3) leads to the axis of the image, and of the display.
            let missed = pencil.of_height[0] - pencil.of_slope[0] / 3.0;
            assert!(missed.abs() < 1e-12, "{missed}");
        }
        assert!((train.dir.length() - 1.0).abs() < 1e-12 && train.at.x == 0.0);
    }
}
