//! What sidecars and scenes say of sensors.

use super::{asked, empty, flat, maps, sun};
use crate::common::{add_part, ball_shape, face, sphere_mesh};
use eyebox::film::exr::decode;
use eyebox::import::{ImportOptions, Set, import};
use eyebox::output::exr::write_exr;
use eyebox::plan::sensor::frame::frame;
use eyebox::plan::sensor::table::lines;
use eyebox::plan::sensor::{SensorAsked, measure};
use eyebox::scene::{Finish, Scene, Sensor};
use glam::DVec3;
use std::path::Path;

fn sample(set: &str) -> Result<Scene, String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples/hud-direct/hud.optics.toml");
    let sets = vec![Set::parse(set).map_err(|fault| fault.to_string())?];
    let built = import(&path, &ImportOptions { sets, ..ImportOptions::default() });
    built.map(|built| built.scene).map_err(|fault| fault.to_string())
}

#[test]
fn what_is_no_sensor_is_said_in_one_line() {
    for (value, said) in [
        ("{ pixels = [0, 5] }", "a number from 1 to 2048"),
        ("{ pixels = [-1, 5] }", "a number from 1 to 2048"),
        ("{ pixels = [1e9, 5] }", "a number from 1 to 2048"),
        ("{ pixels = [2.5, 5] }", "two whole numbers"),
        ("{ pixels = [nan, 5] }", "a number from 1 to 2048"),
        ("{ pixels = [64] }", "a list of 2 whole numbers"),
        ("{ pixels = 64 }", "a list of 2 whole numbers"),
        ("{ }", "no `pixels`"),
        ("{ pixel = [4, 4] }", "did you mean `pixels`?"),
        ("{ pixels = [4, 4], u = [0, 0, 0] }", "the zero vector"),
        ("{ pixels = [4, 4], u = [0, inf, 0] }", "a finite number"),
        ("\"none\"", "a table"),
        ("7", "a table"),
    ] {
        let fault = sample(&format!("LCD*.sensor={value}")).expect_err(value);
        assert!(fault.contains(said) && !fault.contains('\n'), "{value}: {fault}");
    }
    let scene = sample("LCD*.sensor={ pixels = [6, 4] }").expect("sound");
    assert!(scene.parts.iter().flat_map(|part| &part.faces).any(|face| face.sensor.is_some()));
}

#[test]
fn faces_without_a_plane_and_scenes_without_a_sensor() {
    let said = |scene: &Scene, asked: &SensorAsked| {
        measure(scene, asked, &|| false, |_, _| {}).map(drop).unwrap_err().to_string()
    };
    let mut scene = empty();
    sun(&mut scene, DVec3::Z, 0.0);
    let mut ball = face(Finish::Absorber);
    ball.shape = ball_shape(0.01);
    add_part(&mut scene, "ball", sphere_mesh(0.01, 12, 24), DVec3::ZERO, None, vec![ball]);
    assert!(said(&scene, &asked(1)).contains("the scene has no sensor"));
    scene.parts[0].faces[0].sensor = Some(Sensor { pixels: [4, 4], u: None });
    assert!(said(&scene, &asked(1)).contains("closed and has no mean plane"));
    let mut scene = empty();
    flat(&mut scene, [0.01, 0.01], [4, 4]);
    sun(&mut scene, DVec3::Z, 0.0);
    let other = SensorAsked { only: Some("sensr".to_owned()), ..asked(1) };
    assert!(said(&scene, &other).contains("did you mean `sensor`?"), "{}", said(&scene, &other));
    scene.parts[0].faces[0].sensor = Some(Sensor { pixels: [4, 4], u: Some(DVec3::Z) });
    assert!(said(&scene, &asked(1)).contains("`u` of the sensor is along the face's normal"));
}

/// No light is told as none, with no error; a stopped run has no result.
#[test]
fn in_the_dark() {
    let mut scene = empty();
    flat(&mut scene, [0.01, 0.01], [4, 4]);
    let map = maps(&scene, &SensorAsked { error: Some(0.01), ..SensorAsked::default() }).remove(0);
    assert_eq!((map.paths, map.error), (0, None));
    assert!(map.sides.iter().all(|side| side.peak.is_none() && side.mean_lx.value == 0.0));
    assert!(lines(std::slice::from_ref(&map)).concat().contains("front: no light arrived"));
    // Light that never arrives does not keep a run that waits for its error.
    sun(&mut scene, DVec3::Z, 0.0);
    let mut lid = face(Finish::Absorber);
    lid.sensor = None;
    for z in [-0.002, 0.002] {
        let cover = crate::common::mesh(&[crate::common::quad(DVec3::ZERO, DVec3::X * 0.5, DVec3::Y * 0.5)]);
        add_part(&mut scene, "lid", cover, DVec3::Z * z, None, vec![lid.clone()]);
    }
    let map = maps(&scene, &SensorAsked { error: Some(0.01), ..SensorAsked::default() }).remove(0);
    assert!(map.error.is_none() && map.paths > 0);
    assert!(measure(&scene, &asked(4), &|| true, |_, _| {}).unwrap().is_none());
}

/// The file holds what was measured.
#[test]
fn a_map_as_a_file() {
    let mut scene = empty();
    flat(&mut scene, [0.03, 0.01], [6, 2]);
    sun(&mut scene, DVec3::Z, 0.0);
    let map = maps(&scene, &asked(4)).remove(0);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.exr");
    write_exr(&path, &frame(&map, 7)).unwrap();
    let read = decode(&std::fs::read(&path).unwrap()).unwrap();
    assert_eq!((read.width, read.height), (6, 2));
    let layer = |name: &str| read.get(name).unwrap_or_else(|| panic!("{name}")).data.to_vec();
    for (pixel, light) in map.sides[0].illuminance_lx.iter().enumerate() {
        assert_eq!(layer("illuminance_front.Y")[pixel], *light as f32);
        assert_eq!(layer("illuminance_front_stderr.Y")[pixel], map.sides[0].stderr_lx[pixel] as f32);
        assert_eq!(layer("illuminance_back.Y")[pixel], 0.0);
    }
    let told: serde_json::Value = serde_json::from_str(read.text("sensor").unwrap()).unwrap();
    assert_eq!(told["part"], "sensor");
    assert!((told["size_m"][0].as_f64().unwrap() - 0.06).abs() < 1e-8);
    // With one pass alone there is no error, and none is made up.
    let one = maps(&scene, &asked(1)).remove(0);
    assert!(one.error.is_none() && one.sides[0].mean_lx.stderr.is_none());
    write_exr(&path, &frame(&one, 7)).unwrap();
}
