//! Films on faces of solids: the glass refracts above them, and where two glasses touch light goes from the one into the other.

use super::{data, is_near, read};
use crate::common::{cuboid, face, image, mean, render, scene};
use eyebox::film::plan::Estimator;
use eyebox::plan::{Asked, Choice};
use eyebox::scene::{Finish, Scene, Slide};
use glam::DVec3;

/// Luminance of a picture, cd/m², and the standard error of its mean; hardly a ray loses track of the solids around it.
fn picture(scene: &Scene, choice: Choice, passes: u64) -> (Vec<f64>, (f64, f64)) {
    let (films, _) = render(scene, Asked { choice, ..Asked::default() }, passes, 7);
    for (estimator, _, ledger) in &films.films {
        // Light of lamps that total reflection and a film keep in a prism meets its edges sooner or later.
        if *estimator == Estimator::Backward {
            assert_eq!(ledger.mismatches, 0);
        }
        assert_eq!(ledger.invalid_paths, 0, "{estimator:?}");
        assert!(ledger.vertex_error < 1e-12, "{estimator:?}: {}", ledger.vertex_error);
    }
    let image = image(&films);
    (image.iter().map(|(value, _)| *value).collect(), mean(&image))
}

/// Where the light of a picture is, in pixels from its left and top.
fn centroid(pixels: &[f64], width: usize) -> [f64; 2] {
    let sum: f64 = pixels.iter().sum();
    let along = |place: &dyn Fn(usize) -> usize| {
        pixels.iter().enumerate().map(|(k, light)| light * (place(k) as f64 + 0.5)).sum::<f64>() / sum
    };
    [along(&|k| k % width), along(&|k| k / width)]
}

/// A wedge of 10° and n = 1.5 shows a mark 4.056° aside (traced by hand by who found the fault), with a wave plate on a face as with a coating
/// that reflects nothing; the plate leaves a surface that reflects ((n − 1)/(n + 1))² = 0.04 of light that meets it straight.
#[test]
fn a_wave_plate_on_a_wedge_refracts() {
    let of = |name: &str| read(&data(&format!("film_on_glass/{name}.optics.toml")), &[]).scene;
    let (bare, film) = (of("pol"), of("ret"));
    assert_eq!(film.parts.len(), bare.parts.len() + 1, "the film is a part");
    for choice in [Choice::Auto, Choice::Only(Estimator::Backward), Choice::Only(Estimator::Forward)] {
        let passes = if choice == Choice::Only(Estimator::Forward) { 128 } else { 64 };
        let [(with, mean), (without, bare_mean)] = [&film, &bare].map(|scene| picture(scene, choice, passes));
        let [with_at, without_at] = [&with, &without].map(|pixels| centroid(pixels, 20));
        println!("{choice:?}: {with_at:?} {without_at:?}, {mean:?} of {bare_mean:?}");
        assert!((with_at[0] - without_at[0]).hypot(with_at[1] - without_at[1]) < 0.1, "{with_at:?} {without_at:?}");
        let error = mean.1.hypot(0.96 * bare_mean.1);
        assert!(is_near((mean.0, error), 0.96 * bare_mean.0, 2e-3), "{choice:?}: {mean:?} of {bare_mean:?}");
    }
    // 20 pixels over 20°, seen as tangents.
    let (pixels, _) = picture(&film, Choice::Auto, 64);
    let [x, y] = centroid(&pixels, 20).map(|at| ((at / 10.0 - 1.0) * 10f64.to_radians().tan()).atan().to_degrees());
    assert!((x.hypot(y) - 4.056).abs() < 0.05, "{x}° {y}°");
}

/// A reflective polariser on one of two prisms that touch: half of the light of a lamp behind goes straight on, half of that of a lamp
/// beside is reflected, and no air is between.
#[test]
fn a_cube_with_a_film_parts_light() {
    for (dark, choice) in [
        ("STRAIGHT", Choice::Auto),
        ("SIDE", Choice::Auto),
        ("STRAIGHT", Choice::Only(Estimator::Forward)),
        ("SIDE", Choice::Only(Estimator::Forward)),
    ] {
        let dim = format!("{dark}.emitter.luminance_cd_m2=1e-9");
        let narrow = ["eye.resolution=[4, 4]", "eye.fov_deg=2", "eye.pupil_diameter=\"3 mm\""];
        let sets: Vec<&str> = std::iter::once(dim.as_str()).chain(narrow).collect();
        let scene = read(&data("pbs_cube/film.optics.toml"), &sets).scene;
        let (_, seen) = picture(&scene, choice, if choice == Choice::Auto { 16 } else { 128 });
        println!("without {dark}, {choice:?}: {seen:?}");
        assert!(seen.1 < 100.0 && is_near(seen, 500.0, 2e-3), "without {dark}, {choice:?}: {seen:?}");
    }
}

/// What would have to refract and does not is refused, with what to do.
#[test]
fn what_cannot_refract_is_refused() {
    let mut glass = scene();
    let plate = cuboid(DVec3::new(0.02, 0.02, 0.002));
    let faces = |last: Finish| [vec![face(Finish::Polished); 5], vec![face(last)]].concat();
    let gauss = Finish::Gauss { sigma_deg: 5.0, reflectance: 0.0, transmittance: 0.9 };
    crate::common::add_part(&mut glass, "plate", crate::common::mesh(&plate), DVec3::ZERO, Some(1.5), faces(gauss));
    let fault = glass.clone().laminate().expect_err("gauss does not refract").to_string();
    assert!(fault.contains("plate") && fault.contains("`rough`"), "{fault}");
    // One that lets nothing through is paint.
    let mut painted = glass.clone();
    painted.parts[0].faces[5].finish = Finish::Gauss { sigma_deg: 5.0, reflectance: 0.5, transmittance: 0.0 };
    painted.laminate().expect("paint");
    assert_eq!(painted.parts.len(), 1);
    let mut mirror = glass.clone();
    mirror.slides.push(Slide { contrast: 100.0, ..crate::common::mottled_slide(100.0) });
    mirror.parts[0].faces[5].finish = Finish::MirrorIdeal { reflectance: 0.9 };
    mirror.parts[0].faces[5].slide = Some(eyebox::base::ids::SlideId(0));
    let fault = mirror.clone().laminate().expect_err("a slide on a mirror").to_string();
    assert!(fault.contains("a slide on a mirror"), "{fault}");
    // The same on a sheet.
    mirror.parts[0].medium = None;
    mirror.parts[0].faces.iter_mut().for_each(|face| {
        if face.finish == Finish::Polished {
            face.finish = Finish::Absorber;
        }
    });
    mirror.laminate().expect_err("a slide on a mirror of its own");
}

/// What moves or bends a face takes its film along.
#[test]
fn films_stay_on_their_faces() {
    let mut glass = scene();
    let plate = crate::common::mesh(&cuboid(DVec3::new(0.02, 0.02, 0.002)));
    let retarder = Finish::Retarder { axis: DVec3::X, retardance_nm: 137.5 };
    let faces = [vec![face(Finish::Polished); 5], vec![face(retarder)]].concat();
    crate::common::add_part(&mut glass, "plate", plate, DVec3::ZERO, Some(1.5), faces);
    glass.laminate().expect("a film on glass");
    let of_face = |scene: &Scene, part: usize, face: usize| -> Vec<[f32; 3]> {
        let mesh = scene.mesh(scene.parts[part].mesh);
        let corners = mesh.triangles[mesh.faces[face].triangles()].as_flattened();
        corners.iter().map(|corner| mesh.positions[*corner as usize]).collect()
    };
    assert_eq!((glass.parts[0].faces[5].finish, glass.parts[1].faces[0].finish), (Finish::Polished, retarder));
    assert_eq!(of_face(&glass, 1, 0), of_face(&glass, 0, 5));
    glass.parts[0].to_world.translation.x = 0.1;
    let mut bent = eyebox::scene::Mesh::clone(glass.mesh(glass.parts[0].mesh));
    bent.positions.iter_mut().for_each(|position| position[2] *= 1.5);
    glass.meshes.push(bent.into());
    glass.parts[0].mesh = eyebox::base::ids::MeshId::from_index(glass.meshes.len() - 1);
    glass.realign_films();
    assert_eq!(glass.parts[1].to_world, glass.parts[0].to_world);
    assert_eq!(of_face(&glass, 1, 0), of_face(&glass, 0, 5));
}
