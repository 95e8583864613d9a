//! What lamps give: flux, peak intensity, luminance and half angle of every face, light and sky.

use super::face::EmitterReport;
use eyebox_scene::{Beacon, BeaconForm, Scene, SpotCone};
use std::f64::consts::PI;

/// One lamp, or faces of one part that are alike.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct LampReport {
    pub group: String,
    /// `LED_1 face 2`, the name of a light, the file of the sky.
    pub name: String,
    pub kind: &'static str,
    /// None for a distant lamp and the sky, whose flux depends on what they shine on.
    pub flux_lm: Option<f64>,
    /// The greatest intensity; of curved faces that of their light, were they flat.
    pub peak_cd: Option<f64>,
    /// Along the normal of a face; the greatest of a sky. None for points and parallel light.
    pub luminance_cd_m2: Option<f64>,
    /// Angle from the axis up to which the intensity is above half of the peak; of a distant lamp that of its disc.
    pub half_angle_deg: Option<f64>,
    /// Across a distant lamp's light, lx.
    pub illuminance_lx: Option<f64>,
}

/// Of an emitting face.
pub fn of_face(path: &str, number: usize, emitter: &EmitterReport) -> LampReport {
    LampReport {
        group: emitter.group.clone(),
        name: format!("{path} face {number}"),
        kind: "face",
        flux_lm: Some(emitter.flux_lm),
        peak_cd: Some(emitter.peak_cd),
        luminance_cd_m2: Some(emitter.luminance_cd_m2),
        half_angle_deg: emitter.half_angle_deg,
        illuminance_lx: None,
    }
}

/// Of a lamp that is no face.
pub fn of_light(scene: &Scene, light: &Beacon) -> LampReport {
    let mut report = LampReport {
        group: scene.groups.get(light.group.index()).map_or_else(String::new, |group| group.name.clone()),
        name: light.name.clone(),
        kind: "point",
        flux_lm: None,
        peak_cd: None,
        luminance_cd_m2: None,
        half_angle_deg: None,
        illuminance_lx: None,
    };
    match light.form {
        BeaconForm::Point { intensity_cd, spot, .. } => {
            let (sr, half) = spot.map_or((4.0 * PI, None), |spot| {
                report.kind = "spot";
                let (sr, half) = cone(&spot);
                (sr, Some(half))
            });
            report.flux_lm = Some(intensity_cd * sr);
            report.peak_cd = Some(intensity_cd);
            report.half_angle_deg = half;
        }
        BeaconForm::Profile { profile, factor, .. } => {
            report.kind = "measured point";
            let profile = scene.profiles.get(profile.index());
            report.flux_lm = profile.map(|profile| factor * profile.flux_lm());
            report.peak_cd = profile.map(|profile| factor * profile.peak_cd());
            report.half_angle_deg = profile.and_then(|profile| profile.half_angle_rad()).map(f64::to_degrees);
        }
        BeaconForm::Rays { flux_lm, .. } => {
            report.kind = "ray file";
            report.flux_lm = Some(flux_lm);
        }
        BeaconForm::Distant { illuminance_lx, angle_rad, .. } => {
            report.kind = "distant";
            report.illuminance_lx = Some(illuminance_lx);
            report.half_angle_deg = Some((0.5 * angle_rad).to_degrees());
            // E = π L sin² of the half angle.
            report.luminance_cd_m2 = (angle_rad > 0.0).then(|| illuminance_lx / (PI * (0.5 * angle_rad).sin().powi(2)));
        }
    }
    report
}

/// ∫ of a spot's share over directions, sr, and the half angle at half intensity, deg (KHR_lights_punctual, "Inner and
/// Outer Cone Angles", with its narrowest edge of 0.001 in cosines).
fn cone(spot: &SpotCone) -> (f64, f64) {
    let edge = spot.outer_rad.cos();
    let width = (spot.inner_rad.cos() - edge).max(1e-3);
    let full = (1.0 - edge - width).max(0.0);
    let x = ((1.0 - edge) / width).min(1.0);
    let half = (edge + width * 0.5f64.sqrt()).clamp(-1.0, 1.0).acos().to_degrees();
    (2.0 * PI * (full + width * x.powi(3) / 3.0), half)
}
