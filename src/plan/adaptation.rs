//! The pupil of an eye that is adapted to what it sees: its diameter follows from the mean luminance of the picture, and the
//! picture, where lamps do not fill the pupil, from its diameter. Short renderings in turn find both.

use super::Asked;
use super::scan::light::{LightAsked, rendered};
use super::tuning::adaptation::{CLOSE, MOST_STEPS, PASSES, WIDTH};
use eyebox_base::Result;
use eyebox_base::vision::{Eyes, pupil_watson_yellott_mm};
use eyebox_estimate::ShouldStop;
use eyebox_film::frame::Frame;
use eyebox_output::luminance::layer_luminance;
use eyebox_scene::{Eye, Scene};

/// A pupil, and what it is adapted to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Adapted {
    pub diameter_m: f64,
    /// Mean of the picture by solid angle.
    pub luminance_cd_m2: f64,
    pub field_deg2: f64,
    /// The formula's range.
    pub age: f64,
}

/// Ages that Watson and Yellott's formula is for.
const AGES: [f64; 2] = [20.0, 83.0];

/// Gives the eye of `scene` the pupil that it has when it is adapted to its picture, both eyes open (Watson and Yellott 2012, as
/// [`pupil_watson_yellott_mm`]): the picture's field and its mean luminance count. None if `stop` said true; the pupil is then
/// where the search began. Errors: a scene that cannot be traced.
pub fn adapt(scene: &mut Scene, asked: Asked, stop: &ShouldStop<'_>) -> Result<Option<Adapted>> {
    scene.eye.adapts = false;
    let own = scene.eye.clone();
    scene.eye.resolution = coarse(own.resolution);
    let found = settle(scene, asked, stop);
    scene.eye = Eye { pupil_diameter_m: scene.eye.pupil_diameter_m, ..own };
    found
}

fn settle(scene: &mut Scene, asked: Asked, stop: &ShouldStop<'_>) -> Result<Option<Adapted>> {
    let light = LightAsked { resolution: scene.eye.resolution, passes: PASSES, seed: 0, asked };
    let age = scene.eye.age.clamp(AGES[0], AGES[1]);
    let mut found = None;
    for _ in 0..MOST_STEPS {
        let Some((frame, _)) = rendered(scene, &light, None, stop)? else { return Ok(None) };
        let (luminance_cd_m2, field_sr) = mean(&frame, &scene.eye);
        let field_deg2 = field_sr * 1f64.to_degrees().powi(2);
        let diameter_m = 1e-3 * pupil_watson_yellott_mm(luminance_cd_m2, field_deg2, age, Eyes::Both);
        let is_close = (diameter_m / scene.eye.pupil_diameter_m - 1.0).abs() < CLOSE;
        scene.eye.pupil_diameter_m = diameter_m;
        found = Some(Adapted { diameter_m, luminance_cd_m2, field_deg2, age });
        if is_close {
            break;
        }
    }
    Ok(found)
}

/// Fewer pixels of the same shape.
fn coarse([width, height]: [usize; 2]) -> [usize; 2] {
    let least = WIDTH.min(width);
    [least, ((least * height) as f64 / width as f64).round().max(1.0) as usize]
}

/// Mean luminance over the solid angle of a picture, and that, sr.
fn mean(frame: &Frame, eye: &Eye) -> (f64, f64) {
    let [half_width, half_height] = eye.half_tangents();
    let size = [frame.width as f64, frame.height as f64];
    let pixel = 4.0 * half_width * half_height / (size[0] * size[1]);
    let (mut sum, mut whole) = (0.0, 0.0);
    for (at, luminance) in layer_luminance(frame, "").unwrap_or_default().into_iter().enumerate() {
        let (column, row) = ((at % frame.width) as f64 + 0.5, (at / frame.width) as f64 + 0.5);
        let x = half_width * (2.0 * column / size[0] - 1.0);
        let y = half_height * (2.0 * row / size[1] - 1.0);
        let solid = pixel * (1.0 + x * x + y * y).powf(-1.5);
        (sum, whole) = (sum + solid * luminance, whole + solid);
    }
    (if whole > 0.0 { sum / whole } else { 0.0 }, whole)
}
