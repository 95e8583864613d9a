//! A Lambertian square as rays of a file against the square that emits, formulas, and sums over the rays of the file.

use super::writer::{Ray, lambertian};
use crate::common::*;
use eyebox::base::ids::PartId;
use eyebox::estimate::run::Films;
use eyebox::film::plan::{Estimator, Plan, Verdict};
use eyebox::plan::sensor::{SensorAsked, measure};
use eyebox::plan::{Asked, Choice, follows_rays};
use eyebox::scene::*;
use glam::{DAffine3, DQuat, DVec3, Vec3};
use std::f64::consts::PI;

const LUMENS: f64 = 3.0;
/// Half side of the square, m, and how many rays its file has.
const HALF: f64 = 0.002;
const COUNT: usize = 100_000;

/// A black square that faces +z at the origin, turned and moved by `to_world`; it emits, or the rays of a file leave it.
fn lamp_of(s: &mut Scene, to_world: DAffine3, rays: Option<&[Ray]>) {
    let group = add_group(s, "led");
    let mut own = face(Finish::Absorber);
    if rays.is_none() {
        own.emitter = lamp(group, LUMENS / (PI * 4.0 * HALF * HALF));
    }
    // In millimetres, so that the part's scale must not count twice.
    let square = mesh(&[quad(DVec3::ZERO, DVec3::X * 1000.0 * HALF, DVec3::Y * 1000.0 * HALF)]);
    let part = add_part(s, "led", square, DVec3::ZERO, None, vec![own]);
    s.parts[part].to_world = to_world * DAffine3::from_scale(DVec3::splat(1e-3));
    if let Some(rays) = rays {
        file_of(s, part, group, rays);
    }
}

fn file_of(s: &mut Scene, part: usize, group: eyebox::base::ids::GroupId, rays: &[Ray]) {
    let as_vec = |x: [f64; 3]| Vec3::from_array(x.map(|x| x as f32));
    let own = rays.iter().map(|(place, dir, flux)| LampRay {
        place_mm: as_vec(*place),
        dir: as_vec(*dir).normalize(),
        flux: *flux as f32,
    });
    let set = RaySet::new("led.tm25ray".to_owned(), own.collect()).expect("rays");
    let flux_lm = rays.iter().map(|ray| ray.2).sum();
    let form = BeaconForm::Rays { rays: set.into(), part: PartId::from_index(part), flux_lm };
    s.lights.push(Beacon { name: "led".to_owned(), group, form, spectrum: None });
}

/// Within three sigma, of which the file's own are `of_file`.
fn agree(what: &str, a: (f64, f64), b: (f64, f64), of_file: f64, noise: f64) {
    let sigma = a.1.hypot(b.1).hypot(of_file);
    println!("{what}: {:.6e} and {:.6e}: {:+.2} sigma of {:.1e}", a.0, b.0, (a.0 - b.0) / sigma, sigma / b.0);
    assert!(sigma <= noise * b.0, "{what}: noise {sigma} of {b:?}");
    assert!((a.0 - b.0).abs() <= 3.0 * sigma, "{what}: {a:?}, {b:?}, {of_file}");
}

fn turned() -> DAffine3 {
    DAffine3::from_rotation_translation(
        DQuat::from_rotation_y(0.4) * DQuat::from_rotation_x(0.3),
        DVec3::new(0.1, 0.2, 0.3),
    )
}

/// A sensor across the square's axis at a distance of 20 mm: the map of the file is that of the emitter, pixel by pixel, and
/// the mean is the configuration factor's of two parallel squares.
#[test]
fn a_sensor_cannot_tell_a_file_from_its_lamp() {
    let maps = [Some(lambertian(COUNT, 1000.0 * HALF, LUMENS)), None].map(|rays| {
        let mut s = scene();
        s.eye.position = DVec3::new(1.0, 1.0, 1.0);
        lamp_of(&mut s, turned(), rays.as_deref());
        let mut own = face(Finish::Absorber);
        own.sensor = Some(Sensor { pixels: [4, 4], u: None });
        let plate = mesh(&[quad(DVec3::ZERO, DVec3::X * 0.01, DVec3::NEG_Y * 0.01)]);
        let part = add_part(&mut s, "sensor", plate, DVec3::ZERO, None, vec![own]);
        s.parts[part].to_world = turned() * DAffine3::from_translation(DVec3::Z * 0.02);
        let asked = SensorAsked { passes: Some(32), seed: 7, ..SensorAsked::default() };
        measure(&s, &asked, &|| false, |_, _| {}).expect("it can be measured").expect("nobody stopped it").remove(0)
    });
    let [file, lamp] = maps.each_ref().map(|map| &map.sides[0]);
    let level = |side: &eyebox::plan::sensor::SideMap| (side.flux_lm.value, side.flux_lm.stderr.unwrap());
    let share = level(lamp).0 / LUMENS;
    let of_file = LUMENS * (share * (1.0 - share) / COUNT as f64).sqrt();
    agree("flux on the sensor", level(file), level(lamp), of_file, 1e-2);
    // A small square and a square of half side a across its axis at h: F = 4 · 1/(2π) · 2 · x/√(1+x²) · atan(x/√(1+x²)),
    // x = a/h, but for the lamp's own size, some (HALF/h)² = 1 %.
    let x = 0.5f64;
    let t = x / (1.0 + x * x).sqrt();
    assert!((share / (4.0 / PI * t * t.atan()) - 1.0).abs() < 0.01, "{share}");
    let worst = (0..16)
        .map(|k| {
            let area = maps[0].area_m2 / 16.0;
            let share = lamp.illuminance_lx[k] * area / LUMENS;
            let of_file = LUMENS / area * (share / COUNT as f64).sqrt();
            let sigma = file.stderr_lx[k].hypot(lamp.stderr_lx[k]).hypot(of_file);
            ((file.illuminance_lx[k] - lamp.illuminance_lx[k]) / sigma).abs()
        })
        .fold(0.0, f64::max);
    assert!(worst < eyebox::base::stats::sidak_z(0.01, 16), "{worst}");
    assert_eq!(file.groups.len(), 1);
}

/// Walls all round take all of the file's flux, also of rays of different flux and of rays that start inside of their part,
/// under its faces, be they black or glass.
#[test]
fn walls_all_round_have_the_flux_of_the_file() {
    let mut under_black = Vec::new();
    for (sunk, uneven, index) in [(0.0, true, None), (-0.5, false, None), (-0.5, false, Some(1.5))] {
        let mut rays = lambertian(5000, 0.4, LUMENS);
        for (k, (place, _, flux)) in rays.iter_mut().enumerate() {
            place[2] = sunk;
            *flux *= if uneven { 0.25 + (k % 7) as f64 } else { 1.0 };
        }
        let total: f64 = rays.iter().map(|ray| ray.2).sum();
        let mut s = scene();
        s.eye.position = DVec3::new(1.0, 1.0, 1.0);
        let group = add_group(&mut s, "led");
        let finish = if index.is_some() { Finish::Polished } else { Finish::Absorber };
        // Its top is in z = 0 of its own frame.
        let body = mesh(&cuboid(DVec3::splat(0.001)).into_iter().map(lowered).collect::<Vec<_>>());
        let led = add_part(&mut s, "led", body, DVec3::ZERO, index, vec![face(finish); 6]);
        file_of(&mut s, led, group, &rays);
        s.parts[led].to_world = DAffine3::from_translation(DVec3::new(0.003, 0.0, -0.002));
        let mut wall = face(Finish::Absorber);
        wall.sensor = Some(Sensor { pixels: [2, 2], u: None });
        add_part(&mut s, "walls", mesh(&cuboid(DVec3::splat(0.05))), DVec3::ZERO, None, vec![wall; 6]);
        let asked = SensorAsked { passes: Some(4), seed: 3, ..SensorAsked::default() };
        let maps = measure(&s, &asked, &|| false, |_, _| {}).expect("it can be measured").expect("nobody stopped it");
        let levels: Vec<(f64, f64)> = maps
            .iter()
            .flat_map(|map| &map.sides)
            .map(|side| (side.flux_lm.value, side.flux_lm.stderr.unwrap()))
            .collect();
        let sum: f64 = levels.iter().map(|level| level.0).sum();
        let sigma = levels.iter().map(|level| level.1.powi(2)).sum::<f64>().sqrt();
        println!("walls have {sum:.6} ± {sigma:.1e} of {total:.6} lm");
        assert!((sum - total).abs() <= 4.0 * sigma + 1e-6 * total, "{sum} ± {sigma}, {total}");
        assert!(sigma < 0.01 * total);
        match index {
            None => under_black = levels,
            // Glass neither bends nor holds back what has left it.
            Some(_) => {
                for (glass, black) in levels.iter().zip(&under_black) {
                    let sigma = glass.1.hypot(black.1);
                    assert!((glass.0 - black.0).abs() <= 4.0 * sigma + 1e-6 * total, "{glass:?} {black:?}");
                }
            }
        }
    }
}

fn lowered(polygon: Vec<DVec3>) -> Vec<DVec3> {
    polygon.into_iter().map(|corner| corner - DVec3::Z * 0.001).collect()
}

/// The square seen by a wide pupil 300 mm away.
fn seen(rays: Option<&[Ray]>) -> Scene {
    let mut s = scene();
    lamp_of(&mut s, turned(), rays);
    let to_world = turned();
    s.eye.position = to_world.transform_point3(DVec3::Z * 0.3);
    s.eye.look = to_world.transform_vector3(DVec3::NEG_Z);
    s.eye.up = to_world.transform_vector3(DVec3::Y);
    s.eye.pupil_diameter_m = 0.1;
    s.eye.focus_distance_m = 0.3;
    s.eye.fov_deg = 2.0;
    s.eye.resolution = [4, 4];
    s
}

fn luminance(s: &Scene, choice: impl Into<Asked>, passes: u64) -> ((f64, f64), Films, Plan) {
    let (films, plan) = render(s, choice, passes, 5);
    (mean(&image(&films)), films, plan)
}

#[test]
fn a_wide_pupil_sees_the_lamp_that_the_file_describes() {
    let rays = lambertian(COUNT, 1000.0 * HALF, LUMENS);
    let ((file, sigma), _, plan) = luminance(&seen(Some(&rays)), Choice::Auto, 32);
    let vision = plan.rows.iter().find(|row| row.class == eyebox::base::path::Class::Vision).unwrap();
    assert!(matches!(vision.verdict, Verdict::Emitted { .. }), "{vision:?}");
    assert!(plan.notes.iter().any(|note| note.contains("100000 rays of files")), "{:?}", plan.notes);
    // The rays that go through the pupil, of which all start in the picture: each has its flux there.
    let through = |ray: &&Ray| {
        let ([x, y, _], [dx, dy, dz], _) = **ray;
        let far = 300.0 / dz;
        (x + far * dx).hypot(y + far * dy) < 50.0
    };
    let count = rays.iter().filter(through).count();
    let of_file = file / (count as f64).sqrt();
    let ((lamp, of_lamp), ..) = luminance(&seen(None), Choice::Only(Estimator::Forward), 32);
    agree("seen by light tracing", (file, sigma), (lamp, of_lamp), of_file, 0.05);
    let ((lamp, of_lamp), ..) = luminance(&seen(None), Choice::Only(Estimator::Backward), 64);
    agree("seen from the eye", (file, sigma), (lamp, of_lamp), of_file, 0.05);
    // Forward alone, photons and connection have the same.
    for only in [Estimator::Forward, Estimator::Photon, Estimator::Manifold] {
        let (other, ..) = luminance(&seen(Some(&rays)), Choice::Only(only), 32);
        agree(only.name(), other, (file, sigma), 0.0, 0.05);
    }
}

/// A white plate across the axis, seen from the side: what photons straight from the file bring, against an emitter that is
/// sampled from the plate.
#[test]
fn a_plate_is_lit_by_the_file_as_by_its_lamp() {
    let lit = |rays: Option<&[Ray]>, glass: bool| {
        let mut s = scene();
        lamp_of(&mut s, DAffine3::IDENTITY, rays);
        let white = face(Finish::Lambert { reflectance: 0.8, transmittance: 0.0 });
        let plate = mesh(&[quad(DVec3::ZERO, DVec3::X * 0.05, DVec3::NEG_Y * 0.05)]);
        add_part(&mut s, "plate", plate, DVec3::Z * 0.05, None, vec![white]);
        if glass {
            let slab = mesh(&cuboid(DVec3::new(0.05, 0.05, 0.002)));
            add_part(&mut s, "slab", slab, DVec3::Z * 0.02, Some(1.5), vec![face(Finish::Polished); 6]);
        }
        s.eye.position = DVec3::new(0.2, 0.0, -0.1);
        // Beside the glass' images of the lamp.
        s.eye.look = (DVec3::new(0.03, 0.0, 0.05) - s.eye.position).normalize();
        s.eye.up = DVec3::Y;
        s.eye.focus_distance_m = 0.25;
        s.eye.fov_deg = 3.0;
        s.eye.resolution = [6, 6];
        s
    };
    let rays = lambertian(COUNT, 1000.0 * HALF, LUMENS);
    for glass in [false, true] {
        let ((file, sigma), films, plan) = luminance(&lit(Some(&rays), glass), Choice::Auto, 12);
        assert!(films.films.iter().any(|(estimator, ..)| *estimator == Estimator::Photon), "{plan:?}");
        let ((lamp, of_lamp), ..) = luminance(&lit(None, glass), Choice::Auto, 24);
        // Some 1300 of the rays come to what is seen of the plate.
        agree(&format!("plate, glass {glass}"), (file, sigma), (lamp, of_lamp), lamp / 1300f64.sqrt(), 0.05);
    }
}

/// A lobe too narrow to gather photons at: light tracing has it. A satin mirror at 45 degrees, seen by a wide pupil.
#[test]
fn a_narrow_lobe_is_lit_by_the_file_as_by_its_lamp() {
    let lit = |rays: Option<&[Ray]>| {
        let mut s = scene();
        lamp_of(&mut s, DAffine3::IDENTITY, rays);
        let satin = face(Finish::Gauss { sigma_deg: 0.5, reflectance: 0.8, transmittance: 0.0 });
        let plate = mesh(&[quad(DVec3::ZERO, DVec3::X * 0.05, DVec3::Y * 0.05)]);
        let part = add_part(&mut s, "mirror", plate, DVec3::ZERO, None, vec![satin]);
        // Its normal is (1, 0, −1)/√2: light along +z leaves along +x.
        s.parts[part].to_world = DAffine3::from_rotation_translation(DQuat::from_rotation_y(0.75 * PI), DVec3::Z * 0.1);
        s.eye.position = DVec3::new(0.2, 0.0, 0.1);
        s.eye.look = DVec3::NEG_X;
        s.eye.up = DVec3::Y;
        s.eye.pupil_diameter_m = 0.1;
        s.eye.focus_distance_m = 0.3;
        s.eye.fov_deg = 2.5;
        s.eye.resolution = [4, 4];
        s
    };
    let rays = lambertian(COUNT, 1000.0 * HALF, LUMENS);
    let ((file, sigma), films, plan) = luminance(&lit(Some(&rays)), Choice::Auto, 16);
    let forward = mean(&image_of(&films, |estimator| estimator == Estimator::Forward));
    assert!(forward.0 > 0.99 * file, "{forward:?} of {file}: {:?}", plan.rows);
    let ((lamp, of_lamp), ..) = luminance(&lit(None), Choice::Only(Estimator::Backward), 1024);
    // Some 2000 of the rays go into the pupil and the picture.
    agree("satin mirror", (file, sigma), (lamp, of_lamp), lamp / 2000f64.sqrt(), 0.05);
}

/// What no path from the eye can find is refused, not black.
#[test]
fn estimators_that_cannot_follow_rays_are_refused() {
    let rays = lambertian(1000, 1000.0 * HALF, LUMENS);
    let refused = |s: &Scene, choice: Choice| {
        let checked = eyebox::check::check(s).expect("sound");
        let world = eyebox::world::World::freeze(s).expect("traceable");
        follows_rays(&checked, &world, choice.into()).err().map(|fault| fault.to_string())
    };
    let mut s = seen(Some(&rays));
    let found = refused(&s, Choice::Only(Estimator::Backward)).expect("a fault");
    assert!(found.contains("--estimator") && found.contains("light group led") && found.contains("forward"), "{found}");
    for choice in [Choice::Auto, Choice::Only(Estimator::Forward), Choice::Only(Estimator::Manifold)] {
        assert_eq!(refused(&s, choice), None);
    }
    s.eye.pupil_diameter_m = 0.0;
    assert!(refused(&s, Choice::Auto).expect("a fault").contains("the pupil is a point"));
    // A part whose axes are mirrored has no frame for rays.
    let mut s = seen(Some(&rays));
    s.parts[0].to_world = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let found = eyebox::world::World::freeze(&s).err().expect("a fault").to_string();
    assert!(found.contains("neither mirrored nor skewed"), "{found}");
}
