//! Skies without pictures: what they bring by closed forms, where their sun stands, and what they refuse.

use super::{BASE, built, built_on, check};
use crate::testing::assembly;
use eyebox_scene::{BeaconForm, Scene, Sky};
use glam::{DMat3, DVec3};
use std::f64::consts::PI;

const ROOM: &str = "schema = 1\nwavelengths = \"visible\"\n[eye]\nposition = [\"0 mm\", \"0 mm\", \"0 mm\"]\nlook = [0, 0, -1]\nup = [0, 1, 0]\nfov_deg = 12\n[default]\nfinish = \"absorber\"\n";

/// In colour.
fn scene(sky: &str, sets: &[&str]) -> Scene {
    built_on(assembly(&["LENS"]), &format!("{ROOM}[sky]\n{sky}\n"), sets).unwrap().scene
}

/// Luminance in a direction, of the pixel there: rows from the frame's y down, columns from its −z by way of x
/// (`docs/attributes.md`, `[sky]`).
fn luminance(sky: &Sky, dir: DVec3) -> f64 {
    let local = sky.to_world.transpose() * dir;
    let polar = local.x.hypot(local.z).atan2(local.y) / PI;
    let longitude = 0.5 - local.x.atan2(local.z) / (2.0 * PI);
    let cell = |share: f64, count: usize| ((share * count as f64) as usize).min(count - 1);
    f64::from(sky.luminance[cell(polar, sky.height) * sky.width + cell(longitude, sky.width)])
}

/// Illuminance of a plane whose front looks along `normal`, lx, by a sum over directions.
fn illuminance(scene: &Scene, normal: DVec3) -> f64 {
    let sky = scene.sky.as_ref().unwrap();
    let (u, v) = normal.any_orthonormal_pair();
    const RINGS: usize = 200;
    let mut sum = 0.0;
    for ring in 0..RINGS {
        // Rings of the same ∫ cos θ dω.
        let sin = ((ring as f64 + 0.5) / RINGS as f64).sqrt();
        for step in 0..400 {
            let (s, c) = (2.0 * PI * (f64::from(step) + 0.5) / 400.0).sin_cos();
            sum += luminance(sky, sin * c * u + sin * s * v + (1.0 - sin * sin).sqrt() * normal);
        }
    }
    PI * sum / (RINGS * 400) as f64
}

/// The direction towards the sun, and its illuminance.
fn sun(scene: &Scene) -> (DVec3, f64) {
    let [sun] = scene.lights.as_slice() else { panic!("one sun, not {}", scene.lights.len()) };
    match sun.form {
        BeaconForm::Distant { dir, illuminance_lx, angle_rad } => {
            assert!((angle_rad.to_degrees() - 0.533).abs() < 1e-12);
            (-dir, illuminance_lx)
        }
        BeaconForm::Point { .. } | BeaconForm::Profile { .. } | BeaconForm::Rays { .. } => panic!("{:?}", sun.form),
    }
}

fn near(a: DVec3, b: DVec3) -> bool {
    (a - b).length() <= 1e-12
}

#[test]
fn a_uniform_sky_lights_every_plane_alike() {
    let scene = scene("luminance_cd_m2 = 250", &[]);
    for normal in [DVec3::Y, DVec3::NEG_Y, DVec3::new(0.6, 0.0, 0.8)] {
        assert!((illuminance(&scene, normal) / (250.0 * PI) - 1.0).abs() < 1e-9);
    }
    assert_eq!(scene.sky.unwrap().rgb, None);
}

#[test]
fn a_coloured_uniform_sky_keeps_its_luminance() {
    // However large the numbers are, only their ratios count.
    for rgb in ["[1, 2, 4]", "[1e300, 2e300, 4e300]"] {
        let sky = scene(&format!("luminance_cd_m2 = 250\nrgb = {rgb}"), &[]).sky.unwrap();
        let [r, g, b] = sky.rgb.unwrap()[0];
        assert!((g / r - 2.0).abs() < 1e-5 && (b / r - 4.0).abs() < 1e-5, "{r} {g} {b}");
        // Rec.709: 0.2126 R + 0.7152 G + 0.0722 B.
        assert!((0.2126 * r + 0.7152 * g + 0.0722 * b - 250.0).abs() < 0.02);
        assert!((sky.luminance[0] - 250.0).abs() < 1e-3);
    }
}

#[test]
fn an_overcast_sky_lights_a_floor_as_the_uniform_one_and_a_ceiling_by_its_ground() {
    let scene = scene("overcast_cd_m2 = 1000\nground_reflectance = 0.3", &[]);
    let (floor, ceiling) = (illuminance(&scene, DVec3::Y), illuminance(&scene, DVec3::NEG_Y));
    assert!((floor / (1000.0 * PI) - 1.0).abs() < 1e-4, "{floor}");
    assert!((ceiling / (300.0 * PI) - 1.0).abs() < 1e-4, "{ceiling}");
    // Lz = 9/7 of it: E = 7π/9 Lz.
    let sky = scene.sky.as_ref().unwrap();
    assert!((floor / (7.0 * PI / 9.0 * luminance(sky, DVec3::Y)) - 1.0).abs() < 1e-4);
    // A wall gets half of the ground's, and of the sky's Lz (π/6 + 4/9), as L cos integrates over a quarter of the sphere.
    let wall = illuminance(&scene, DVec3::Z);
    let expected = 9000.0 / 7.0 * (PI / 6.0 + 4.0 / 9.0) + 300.0 * PI / 2.0;
    assert!((wall / expected - 1.0).abs() < 1e-3, "{wall} {expected}");
}

#[test]
fn a_clear_sky_stands_in_its_frame() {
    let (az, el) = (30f64.to_radians(), 40f64.to_radians());
    let clear = "sun_sky = { elevation_deg = 40, azimuth_deg = 30, turbidity = 3 }\n";
    let by_y = DVec3::new(az.sin() * el.cos(), el.sin(), az.cos() * el.cos());
    // With z up, 0° is −y.
    let by_z = DVec3::new(az.sin() * el.cos(), -az.cos() * el.cos(), el.sin());
    assert!(near(sun(&scene(clear, &[])).0, by_y));
    assert!(near(sun(&scene(&format!("{clear}up = \"z\""), &[])).0, by_z));
    // The root is turned by −90° about x: its z is the world's y, and what is −y in it is the world's z.
    assert!(near(sun(&scene(&format!("{clear}up = \"z\"\nframe = \"ROOT\""), &[])).0, by_y));
    // An asset whose own z is up needs no word.
    let mut tipped = assembly(&["LENS"]);
    tipped.axes = DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y);
    let built = |sky: &str| built_on(tipped.clone(), &format!("{ROOM}[sky]\n{sky}"), &[]).unwrap().scene;
    assert!(near(sun(&built(clear)).0, by_y));
    assert_eq!(built("overcast_cd_m2 = 1").sky.unwrap().to_world, DMat3::IDENTITY);
    // The sky is brightest about its sun.
    let scene = scene(clear, &[]);
    let sky = scene.sky.as_ref().unwrap();
    assert!(luminance(sky, by_y) > 4.0 * luminance(sky, DVec3::new(-by_y.x, by_y.y, -by_y.z)));
}

#[test]
fn the_sun_has_a_group_and_a_colour_of_its_own() {
    let high = scene("sun_sky = { elevation_deg = 60, turbidity = 3 }", &[]);
    let names: Vec<&str> = high.groups.iter().map(|group| group.name.as_str()).collect();
    assert_eq!(names, ["sky", "sun"]);
    let low = scene(
        "sun_sky = { elevation_deg = 5, turbidity = 3, sun_group = \"glare\" }",
        &["sky.sun_sky.elevation_deg=4"],
    );
    assert_eq!(low.groups[1].name, "glare");
    let redness = |scene: &Scene| {
        let [r, _, b] = scene.lights[0].spectrum.as_ref().unwrap().resolve().unwrap().rec709_per_lumen();
        r / b
    };
    assert!(redness(&high) < 1.6 && redness(&low) > 4.0, "{} {}", redness(&high), redness(&low));
    let ((up, high_lx), (low_up, low_lx)) = (sun(&high), sun(&low));
    assert!((up.y - 60f64.to_radians().sin()).abs() < 1e-12 && (low_up.y - 4f64.to_radians().sin()).abs() < 1e-12);
    assert!((80e3..100e3).contains(&high_lx) && low_lx < 5e3, "{high_lx} {low_lx}");
    // Together a hundred thousand lux on a horizontal plane; the ground gives a fifth of it back.
    let all = illuminance(&high, DVec3::Y) + high_lx * up.y;
    assert!((100e3..112e3).contains(&all), "{all}");
    assert!((illuminance(&high, DVec3::NEG_Y) / (0.2 * all) - 1.0).abs() < 1e-3);
    // At one wavelength luminance counts.
    let mono = built("[sky]\nsun_sky = { elevation_deg = 60, turbidity = 3 }\n", &[]).unwrap().scene;
    assert!(mono.sky.unwrap().rgb.is_none() && mono.lights[0].spectrum.is_none());
}

#[test]
fn a_sky_is_exactly_one_thing() {
    const ONE: &str = "expected one of image, luminance_cd_m2, overcast_cd_m2, sun_sky";
    check(&[
        ("[sky]\nscale_cd_m2 = 1\n", &[], &format!("hud.optics.toml:10: the sky does not say what it is; {ONE}")),
        (
            "[sky]\novercast_cd_m2 = 1\nluminance_cd_m2 = 1\n",
            &[],
            &format!("hud.optics.toml:11: the sky has luminance_cd_m2 and overcast_cd_m2; {ONE}"),
        ),
        (
            "[sky]\nluminance_cd_m2 = 1\nlayer = \"a\"\n",
            &[],
            "hud.optics.toml:12: `layer` means nothing to a sky of luminance_cd_m2; expected it beside image",
        ),
        (
            "[sky]\nimage = \"a.exr\"\nground_reflectance = 0\n",
            &[],
            "hud.optics.toml:12: `ground_reflectance` means nothing to a sky of image; expected it beside overcast_cd_m2 or sun_sky",
        ),
        (
            "[sky]\nturbidity = 3\n",
            &[],
            "hud.optics.toml:11: `turbidity` stands in sky: it is an entry of sun_sky; expected sun_sky = { turbidity = … }",
        ),
        (
            "[sky]\nsun_sky = { elevation_deg = 30, turbidity = 1 }\n",
            &[],
            "hud.optics.toml:11: `turbidity` is 1; expected a number from 2 to 10",
        ),
        (
            "[sky]\nsun_sky = { elevation_deg = -1, turbidity = 3 }\n",
            &[],
            "hud.optics.toml:11: `elevation_deg` is -1; expected a number from 0 to 90 in deg",
        ),
        (
            "[sky]\nsun_sky = { elevation_deg = 30 }\n",
            &[],
            "hud.optics.toml:11: sun_sky has no `turbidity`; expected a number from 2 to 10",
        ),
        (
            "[sky]\nsun_sky = { elevation = 30, turbidity = 3 }\n",
            &[],
            "hud.optics.toml:11: unknown attribute `elevation` of sun_sky; expected one of elevation_deg, azimuth_deg, turbidity, sun_group; did you mean `elevation_deg`?",
        ),
        (
            "[sky]\nsun_sky = { elevation_deg = 30, turbidity = 3, sun_group = \"a sun\" }\n",
            &[],
            "hud.optics.toml:11: group `a sun` can't be part of a layer name; expected letters, digits and _, a letter first",
        ),
        (
            "[sky]\novercast_cd_m2 = 1\nup = \"x\"\n",
            &[],
            "hud.optics.toml:12: `up` of sky is \"x\"; expected one of y, z",
        ),
        (
            "[sky]\nluminance_cd_m2 = 1\nrgb = [0, 0, 0]\n",
            &[],
            "hud.optics.toml:12: `rgb` of sky is black; expected a number above 0 among its three; a sky without light has luminance_cd_m2 = 0",
        ),
        (
            "[sun]\ndirection = [0, 1, 0]\n[sky]\nsun_sky = { elevation_deg = 30, turbidity = 3 }\n",
            &[],
            "hud.optics.toml:10: the sky has a sun already, that of its `sun_sky`; expected one of sun_sky and [sun]",
        ),
    ]);
}

#[test]
fn another_kind_of_sky_takes_the_place_of_the_one_that_is_there() {
    // The image is not even looked for.
    let text = "image = \"none.exr\"\nscale_cd_m2 = 3\nlayer = \"a\"\ngroup = \"day\"";
    let set = scene(text, &["sky.luminance_cd_m2=7"]);
    assert_eq!((set.sky.unwrap().luminance[0], set.groups[0].name.as_str()), (7.0, "day"));
    // So it is where the sidecar says another sky than the asset.
    let mut asset = assembly(&["LENS"]);
    let own = format!("version = 1\n[sky]\n{text}\n");
    asset.optics = Some(crate::toml::parse(&own, std::path::Path::new("a.glb")).unwrap());
    let scene = built_on(asset, &format!("{BASE}[sky]\novercast_cd_m2 = 7\n"), &[]).unwrap().scene;
    assert_eq!((scene.sky.unwrap().file.as_str(), scene.groups[0].name.as_str()), ("overcast", "day"));
}
