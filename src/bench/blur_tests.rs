//! Photons gathered within a radius blur what is sharp, and the error that a run states knows of it.

use super::branching_tests::lamp_on_a_sheet;
use super::curve::picture::Picture;
use super::curve::race::Ready;
use super::curve::reference::{Source, references};
use super::kit;
use eyebox_base::stats::Moments;
use eyebox_estimate::run::{LEEWAY, begin};
use eyebox_film::plan::Estimator;
use eyebox_plan::{Choice, plan};
use eyebox_scene::Scene;

const SIZE: [usize; 2] = [24, 18];

/// The disc is some five pixels wide.
fn disc() -> Scene {
    let mut scene = kit::scene(20.0, 1);
    scene.eye.resolution = SIZE;
    lamp_on_a_sheet(&mut scene, 0.0);
    scene
}

/// With radii of a few pixels, as photons that part keep wherever they are crowded, the noise alone says a fraction of the
/// error. What is connected blurs nothing, and tells.
#[test]
fn blur_is_in_the_stated_error() {
    let scene = disc();
    let ready = Ready::new(&scene, 0.0).unwrap();
    let source =
        Source::Traced { choice: Choice::Only(Estimator::Manifold), passes: Some(300), seconds: f64::INFINITY };
    let references = references(&ready, &source, 1, &|| false).unwrap().0;
    let mut blurred = plan(&ready.checked, &ready.world, Choice::Only(Estimator::Photon));
    blurred.photon_radii_m = blurred.photon_radii_m.scaled(3.0);
    blurred.photons_part = true;
    let (mut honest, mut by_noise, mut far_off) = (0, 0, 0);
    for seed in 0..20 {
        let mut tracing = begin(&ready.world, &blurred, scene.groups.len(), SIZE, seed);
        tracing.step(32);
        let films = tracing.films();
        let real = references.relative_error(&Picture::of_films(films, SIZE));
        let stated = films.relative_error().unwrap();
        honest += u32::from(real <= LEEWAY * stated);
        far_off += u32::from(stated > 1.5 * real);
        by_noise += u32::from(real <= LEEWAY * films.relative_noise().unwrap());
    }
    let told = format!("{honest} of 20 honest, {by_noise} by noise alone, {far_off} stated far too much");
    assert!(honest >= 18 && by_noise <= 2 && far_off <= 2, "{told}");
}

/// Where radii are small beside what they gather, little more than noise is stated. What is found of blur is none in the mean,
/// now more and now less; a run states it where it is more, so up to a tenth more than noise in the mean.
#[test]
fn without_blur_the_noise_is_stated() {
    let scene = disc();
    let ready = Ready::new(&scene, 0.0).unwrap();
    let mut sharp = plan(&ready.checked, &ready.world, Choice::Only(Estimator::Photon));
    sharp.photon_radii_m = sharp.photon_radii_m.scaled(0.2);
    sharp.photons_part = true;
    let (mut more, mut found) = (Moments::default(), Moments::default());
    for seed in 0..20 {
        let mut tracing = begin(&ready.world, &sharp, scene.groups.len(), SIZE, seed);
        tracing.step(32);
        let films = tracing.films();
        let (stated, noise) = (films.relative_error().unwrap(), films.relative_error_of_noise().unwrap());
        more.add(stated / noise);
        let (mut blur2, mut variance) = (0.0, 0.0);
        for (_, film, _) in films.films.iter().filter(|(_, film, _)| film.has_blur()) {
            for pixel in 0..SIZE[0] * SIZE[1] {
                blur2 += film.blur2(pixel);
                variance += film.variance(pixel, film.planes.len());
            }
        }
        found.add(blur2 / variance);
    }
    let told = format!("{} ± {} of the variance, {} times the noise", found.mean, found.stderr(), more.mean);
    assert!(found.mean.abs() < 0.25 && found.mean.abs() < 3.0 * found.stderr() && more.mean < 1.2, "{told}");
}
