//! The eye: a thin lens with a pupil, focused at a distance (`design/eye.md`).

use glam::DVec3;

/// A thin lens whose image plane is a tangent-plane grid of directions.
///
/// Pixel (px, py) looks along `look + ax·right + ay·up` with ax = tan(fov/2)·(2(px+½)/W − 1),
/// ay = tan(fov/2)·(H/W)·(1 − 2(py+½)/H), the same from every pupil point when focused at infinity.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Eye {
    /// Centre of the pupil, world metres.
    pub position: DVec3,
    /// Unit viewing direction, world.
    pub look: DVec3,
    /// Unit up direction, orthogonal to `look`, world.
    pub up: DVec3,
    /// Diameter of the pupil, m; 0 is a pinhole.
    pub pupil_diameter_m: f64,
    /// The pupil is still to be found: that of an eye which is adapted to the picture (`plan::adaptation`). Until then the diameter
    /// is where the search begins.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub adapts: bool,
    /// Distance of the plane of focus, m; infinite is allowed.
    pub focus_distance_m: f64,
    /// Full horizontal field of view, degrees, in (0, 180).
    pub fov_deg: f64,
    /// Width and height in pixels.
    pub resolution: [usize; 2],
    /// Years; for glare and the adaptive pupil.
    pub age: f64,
    #[serde(skip_serializing_if = "BinocularLimits::is_none")]
    pub limits: BinocularLimits,
}

/// What two eyes may be asked to do by the virtual image, which `eyebox scan` holds it to; none where nothing is limited. mrad,
/// above 0.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct BinocularLimits {
    /// The eyes turn further towards each other than for a point at `image_distance_m`, or less so.
    pub convergence_mrad: Option<f64>,
    pub divergence_mrad: Option<f64>,
    /// One eye higher than the other.
    pub dipvergence_mrad: Option<f64>,
    /// Where the image is meant to be, m; infinite is allowed.
    pub image_distance_m: Option<f64>,
}

impl BinocularLimits {
    pub fn is_none(&self) -> bool {
        *self == BinocularLimits::default()
    }
}

impl Eye {
    /// Unit vector to the right in the picture.
    pub fn right(&self) -> DVec3 {
        self.look.cross(self.up)
    }
    /// Half width and half height of the picture in tangents.
    pub fn half_tangents(&self) -> [f64; 2] {
        let half = (self.fov_deg.to_radians() / 2.0).tan();
        [half, half * self.resolution[1] as f64 / self.resolution[0] as f64]
    }
}
