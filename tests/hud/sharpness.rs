//! The lit part of the direct HUD's pupil, and what diffraction makes of its picture.

use super::kit::*;
use super::prescription::DIRECT;
use eyebox::check::check;
use eyebox::estimate::picture::{picture, picture_through};
use eyebox::film::diffraction::Diffraction;
use eyebox::film::pupil::Pupil;
use eyebox::film::sharpness::{GroupPupil, Sharpness};
use eyebox::plan::pilots::pupil::survey;
use eyebox::plan::{Asked, Choice};
use eyebox::scene::Scene;

fn pupils(scene: &Scene, choice: Choice) -> (Vec<GroupPupil>, Sharpness) {
    let ready = Ready::new(scene, choice);
    let checked = check(scene).expect("the scene is sound");
    let found = survey(&checked, &ready.world, Asked::from(choice), &ready.plan, &|| false).pupils;
    let sharpness = Sharpness::new(&found, 550.0, ready.world.eye.pixel());
    (found, sharpness)
}

/// Area of the LED's image in the pupil for the tangents `a`, mm²: the LED's 0.04 mm² over ∂LED/∂pupil.
fn image_mm2(a: [f64; 2]) -> f64 {
    let step = 0.02;
    let slope = |along: [f64; 2]| {
        let [plus, minus] = [step, -step].map(|h| DIRECT.trace([h * along[0], h * along[1]], a).1);
        [0, 1].map(|k| (plus[k] - minus[k]) / (2.0 * step))
    };
    let (x, y) = (slope([1.0, 0.0]), slope([0.0, 1.0]));
    0.04 / (x[0] * y[1] - x[1] * y[0]).abs()
}

/// 0.4 mm, λ/d = 4.7′ at 550 nm; and between the mean and the largest of the prescription's images over the picture.
#[test]
fn the_lit_pupil_is_the_leds_image() {
    let scene = hud("direct", &ONE_LED);
    let (_, sharpness) = pupils(&scene, Choice::Auto);
    let led = sharpness.worst().expect("a limit");
    eprintln!("{led:?}");
    assert!(led.measured && led.group == "led");
    assert!((led.limit_arcmin / 4.7 - 1.0).abs() < 0.05, "{led:?}");
    assert!(sharpness.pixels().is_some_and(|pixels| pixels > 2.0));
    let fields: Vec<[f64; 2]> = (0..11 * 11)
        .map(|k| [(k % 11) as f64 - 5.0, (k / 11) as f64 - 5.0])
        .map(|[x, y]| [x * 1.0, y * 0.5].map(|degrees| degrees.to_radians().tan()))
        .filter(|a| {
            let [x, y] = DIRECT.trace([0.0; 2], *a).0;
            x.abs() < 20.0 && y.abs() < 10.0
        })
        .collect();
    let mean = fields.iter().map(|a| image_mm2(*a)).sum::<f64>() / fields.len() as f64;
    // The image shrinks from 0.40 mm in the middle to 0.35 mm in the corners. All of them are laid on each other, and
    // the effective area of that pile is more than their mean, less than the largest.
    let largest = image_mm2([0.0; 2]);
    eprintln!("lit {:.4} mm², prescription {mean:.4} to {largest:.4} mm²", led.lit_area_mm2);
    assert!((mean..largest).contains(&led.lit_area_mm2), "{led:?}, prescription {mean} to {largest}");
}

/// Where a group is lit does not depend on who traces it.
#[test]
fn the_lit_pupil_is_known_to_every_estimator() {
    let scene = gaze(hud("direct", &ONE_LED), [0.0; 2], 12.0, [24, 12]);
    let [forward, backward] = [Choice::Auto, Choice::Only(eyebox::film::plan::Estimator::Backward)].map(|choice| {
        let (_, sharpness) = pupils(&scene, choice);
        sharpness.worst().expect("a limit").clone()
    });
    assert!(forward.measured && backward.measured);
    assert!((forward.lit_width_mm / backward.lit_width_mm - 1.0).abs() < 0.02, "{forward:?} {backward:?}");
}

/// An eye that is a point has no limit, and the light of a sheet that scatters fills the pupil.
#[test]
fn where_nothing_is_measured() {
    let pinhole = hud("direct", &[ONE_LED[0], ONE_LED[1], "eye.pupil_diameter=0 mm"]);
    let (found, sharpness) = pupils(&pinhole, Choice::Auto);
    assert!(found.iter().all(|of| of.pupil == Pupil::Point) && sharpness.groups.is_empty());
    let sky = import_hud("direct", &ONE_LED);
    let (found, _) = pupils(&sky, Choice::Auto);
    let sky = found.iter().find(|of| of.group == "sky").expect("a sky");
    assert_eq!(sky.pupil, Pupil::Disc { diameter_m: 4e-3 });
    assert!(sky.because.starts_with("taken to fill the pupil"), "{}", sky.because);
}

/// Spreading keeps the flux but for what leaves over the edge, and smooths the slide's edges.
#[test]
fn a_spread_picture_keeps_its_light() {
    let scene = hud("direct", &ONE_LED);
    let ready = Ready::new(&scene, Choice::Auto);
    let outcome = ready.run(1, 5);
    let (pupils, _) = pupils(&scene, Choice::Auto);
    let diffraction = Diffraction {
        pixel: ready.world.eye.pixel(),
        wavelengths_nm: [550.0; 3],
        pupils,
        full: Pupil::full(4e-3),
        only_vision: true,
    };
    let space = Default::default();
    let sharp = picture(&scene, &ready.plan, &outcome, space).expect("a sound picture");
    let spread = picture_through(&scene, &ready.plan, &outcome, space, Some(&diffraction)).expect("a sound picture");
    assert!(sharp.applied.is_none());
    let applied = spread.applied.expect("what was done");
    let [led] = applied.layers.as_slice() else { panic!("{applied:?}") };
    let data = |frame: &eyebox::film::frame::Frame| -> Vec<f64> {
        frame.rgb("forward_led").expect("the LED's light")[0].iter().map(|v| f64::from(*v)).collect()
    };
    let (sharp, spread) = (data(&sharp.frame), data(&spread.frame));
    let sum = |data: &[f64]| data.iter().sum::<f64>();
    let kept = sum(&spread) / sum(&sharp);
    assert!((kept + led.left - 1.0).abs() < 1e-6, "{kept} {led:?}");
    assert!(led.left > 0.0 && led.left < 0.02, "{led:?}");
    let steps = |data: &[f64]| data.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum::<f64>();
    assert!(steps(&spread) < 0.5 * steps(&sharp));
}
