//! `eyebox sensor` against closed forms, the flux that lamps send, and other estimators: paths from the sensor itself, and the
//! picture of a white Lambertian reflector in its place.

mod closed_forms;
mod estimators;
mod input;

use crate::common::{add_group, add_part, face, mesh, quad, scene};
use eyebox::plan::sensor::{SensorAsked, SensorMap, SideMap, measure};
use eyebox::scene::{Beacon, BeaconForm, Finish, Scene, Sensor};
use glam::DVec3;

pub const SUN_LX: f64 = 1e5;

pub fn asked(passes: u64) -> SensorAsked {
    SensorAsked { passes: Some(passes), seed: 7, ..SensorAsked::default() }
}

pub fn maps(scene: &Scene, asked: &SensorAsked) -> Vec<SensorMap> {
    measure(scene, asked, &|| false, |_, _| {}).expect("the scene can be measured").expect("nobody stopped it")
}

/// The front of a scene's first sensor, and its back.
pub fn sides(scene: &Scene, passes: u64) -> [SideMap; 2] {
    maps(scene, &asked(passes)).remove(0).sides.try_into().expect("two sides")
}

/// A black sensor of `half` sides in the plane z = 0 that faces +z.
pub fn flat(scene: &mut Scene, half: [f64; 2], pixels: [u32; 2]) {
    let mut own = face(Finish::Absorber);
    own.sensor = Some(Sensor { pixels, u: None });
    let polygon = mesh(&[quad(DVec3::ZERO, DVec3::X * half[0], DVec3::Y * half[1])]);
    add_part(scene, "sensor", polygon, DVec3::ZERO, None, vec![own]);
}

pub fn sun(scene: &mut Scene, towards: DVec3, angle_rad: f64) {
    let group = add_group(scene, "sun");
    let form = BeaconForm::Distant { dir: -towards.normalize(), illuminance_lx: SUN_LX, angle_rad };
    scene.lights.push(Beacon { name: "sun".to_owned(), group, form, spectrum: None });
}

/// A scene with its eye where it is in nobody's way.
pub fn empty() -> Scene {
    let mut scene = scene();
    scene.eye.position = DVec3::new(0.3, 0.4, 0.5);
    scene
}

/// The value lies within four of its standard errors and a share `rounding` of itself of what is wanted.
pub fn agrees(what: &str, found: eyebox::plan::sensor::Level, want: f64, rounding: f64) {
    let error = found.stderr.expect("several passes");
    let off = (found.value - want).abs();
    assert!(off <= 4.0 * error + rounding * want.abs(), "{what}: {} ± {error}, wanted {want}", found.value);
    // An error that says nothing would let anything pass.
    assert!(error <= 0.02 * want.abs(), "{what}: error {error} of {want}");
}
