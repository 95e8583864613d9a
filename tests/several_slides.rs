//! Scenes with several slides: the light through each is told apart, and another contrast of one is a new rendering.

use crate::common::*;
use eyebox::base::colour::ColourSpace;
use eyebox::base::ids::SlideId;
use eyebox::base::stats::Moments;
use eyebox::check::check;
use eyebox::estimate::aov::granted;
use eyebox::estimate::finishing::Finishing;
use eyebox::estimate::picture::add_meta;
use eyebox::estimate::run::{Limits, run};
use eyebox::estimate::slides::names;
use eyebox::film::error_detail::ErrorDetail;
use eyebox::film::finish::Split;
use eyebox::film::frame::Frame;
use eyebox::film::plan::Estimator;
use eyebox::output::contrasts::Contrasts;
use eyebox::output::leak::leak_luminance;
use eyebox::output::light_shares::Rendering;
use eyebox::output::mix::{Errors, Recipe, mix};
use eyebox::plan::{Asked, Choice, plan};
use eyebox::scene::*;
use eyebox::world::World;
use glam::DVec3;
use std::sync::Arc;

const PASSES: u64 = 32;

fn square(half: f64) -> Mesh {
    mesh(&[quad(DVec3::ZERO, DVec3::X * half, DVec3::Y * half)])
}

fn add_slide(s: &mut Scene, name: &str, slide: Slide) -> SlideId {
    s.slides.push(Slide { name: name.to_owned(), ..slide });
    SlideId::from_index(s.slides.len() - 1)
}

/// A lamp behind a slide at each side, of one light group, and a display between them, of its own. All three shine at the eye
/// and at a wall below, which shines back on them.
fn three(contrasts: [f64; 3]) -> Scene {
    let mut s = scene();
    let (lamps, oled) = (add_group(&mut s, "lamps"), add_group(&mut s, "oled"));
    s.eye.resolution = [18, 12];
    s.eye.fov_deg = 30.0;
    for (name, x, contrast) in [("left", -0.09, contrasts[0]), ("right", 0.09, contrasts[1])] {
        let picture = Slide { size: [0.08; 2], ..mottled_slide(contrast) };
        let mut slide = face(Finish::None);
        slide.slide = Some(add_slide(&mut s, &format!("hud/{name}"), picture));
        add_part(&mut s, name, square(0.04), DVec3::new(x, 0.0, -0.5), None, vec![slide]);
        let mut panel = face(Finish::Absorber);
        panel.emitter = lamp(lamps, 1000.0);
        add_part(&mut s, "panel", square(0.036), DVec3::new(x, 0.0, -0.51), None, vec![panel]);
    }
    let picture = Slide { size: [0.08; 2], ..mottled_slide(contrasts[2]) };
    let mut display = face(Finish::Absorber);
    display.emitter = lamp(oled, 400.0);
    display.slide = Some(add_slide(&mut s, "hud/oled", picture));
    add_part(&mut s, "oled", square(0.04), DVec3::NEG_Z * 0.5, None, vec![display]);
    let wall = face(Finish::Lambert { reflectance: 0.6, transmittance: 0.0 });
    let floor = mesh(&[quad(DVec3::ZERO, DVec3::Z * 0.2, DVec3::X * 0.2)]);
    add_part(&mut s, "wall", floor, DVec3::new(0.0, -0.06, -0.3), None, vec![wall]);
    s
}

/// Two slides one behind the other before a lamp, at these contrasts, evenly grey.
fn stack(contrasts: [f64; 2], values: [f32; 2]) -> Scene {
    let mut s = scene();
    let group = add_group(&mut s, "lamp");
    for (k, (contrast, value)) in contrasts.into_iter().zip(values).enumerate() {
        let even = Slide { width: 1, height: 1, pixels: Arc::new(vec![value]), ..mottled_slide(contrast) };
        let mut slide = face(Finish::None);
        slide.slide = Some(add_slide(&mut s, ["near", "far"][k], Slide { size: [0.6; 2], ..even }));
        let at = DVec3::NEG_Z * (0.5 + 0.1 * k as f64);
        add_part(&mut s, "slide", square(0.3), at, None, vec![slide]);
    }
    let mut panel = face(Finish::Absorber);
    panel.emitter = lamp(group, 1000.0);
    add_part(&mut s, "panel", square(0.3), DVec3::NEG_Z * 0.7, None, vec![panel]);
    s
}

fn rendered(s: &Scene, asked: impl Into<Asked>, seed: u64) -> (Frame, Vec<Split>) {
    let checked = check(s).expect("the scene is sound");
    let mut world = World::freeze(s).expect("the scene can be traced");
    let mut plan = plan(&checked, &world, asked);
    plan.errors = ErrorDetail::Layers;
    let told = granted(&[], (&[], &[]), s, &world, &plan).expect("nothing is asked");
    world.sieve = told.sieve;
    let limits = Limits { passes: Some(PASSES), ..Limits::default() };
    let outcome = run(&world, &plan, s.groups.len(), s.eye.resolution, seed, &limits, &mut ());
    let mut finishing = Finishing::new(s, &plan, ColourSpace::Rec709, None);
    finishing.tell_slides_apart(s, &told.slides_told.expect("there are several"));
    let finished = finishing.picture(&outcome.films).expect("finite light");
    let mut frame = finished.frame;
    add_meta(&mut frame, s, &plan, &outcome, seed, &finished.splits);
    (frame, finished.splits)
}

fn recipe(slides: &[(&str, f64)]) -> Recipe {
    let slides = slides.iter().map(|(name, contrast)| ((*name).to_owned(), *contrast)).collect();
    Recipe { slides, ..Recipe::default() }
}

/// Every slide is changed alone, and all of them, and all but one: the picture is what another seed renders of the scene with
/// those contrasts, layer by layer. The picture itself has the light of a run that no slide is told in.
#[test]
fn another_contrast_of_one_is_a_new_rendering() {
    for choice in [Choice::Only(Estimator::Backward), Choice::Auto] {
        let (frame, splits) = rendered(&three([50.0, 20.0, 100.0]), choice, 1);
        assert!(splits.iter().all(|split| split.written), "{splits:?}");
        let taken = Rendering::of(&frame).expect("complete");
        assert_eq!(taken.contrast, None);
        let names: Vec<&str> = taken.slides.iter().map(|slide| slide.name.as_str()).collect();
        assert_eq!(names, ["left", "right", "oled"]);
        let by_slide = |group: &str| -> Vec<usize> {
            let own = taken.shares.iter().filter(|share| share.group == group);
            own.flat_map(|share| share.by_slide.iter().map(|(slide, _)| *slide)).collect()
        };
        assert!(by_slide("lamps").iter().all(|slide| *slide < 2) && by_slide("lamps").len() >= 4);
        assert!(by_slide("oled").iter().all(|slide| *slide == 2) && !by_slide("oled").is_empty());
        let most = if choice == Choice::Auto { 2 } else { 5 };
        let recipes = [
            (recipe(&[("left", 2.0)]), [2.0, 20.0, 100.0]),
            (recipe(&[("right", f64::INFINITY)]), [50.0, f64::INFINITY, 100.0]),
            (recipe(&[("oled", 1.0)]), [50.0, 20.0, 1.0]),
            (Recipe { contrast: Some(5.0), ..Recipe::default() }, [5.0; 3]),
            (Recipe { contrast: Some(5.0), ..recipe(&[("right", 20.0)]) }, [5.0, 20.0, 5.0]),
        ];
        // The leak is what each slide lets through where it is dark.
        let leak = leak_luminance(&taken, &["lamps".to_owned()], &Contrasts::default());
        let open = |slide: &str| frame.rgb(&format!("direct_lamps_{slide}_open")).expect("told apart")[0];
        let want = |pixel: usize| f64::from(open("left")[pixel]) / 50.0 + f64::from(open("right")[pixel]) / 20.0;
        let seen = (0..leak.len()).filter(|pixel| pixel / 18 < 7 && want(*pixel) > 0.0);
        assert!(seen.clone().count() > 20 && seen.clone().all(|at| (leak[at] / want(at) - 1.0).abs() < 0.05));
        for (asked, contrasts) in recipes.into_iter().take(most) {
            let mixed = mix(&taken, &asked).expect("they are told apart");
            assert_eq!(mixed.errors, Errors::AtMostOfSlides, "{contrasts:?}");
            let (again, _) = rendered(&three(contrasts), choice, 2);
            let (worst, bound) = far(&frame, &mixed.frame, &again);
            assert!(worst < bound, "{contrasts:?}: {worst} {bound}");
            // A mixture can be mixed again: back.
            let second = Rendering::of(&mixed.frame).expect("complete");
            let found: Vec<f64> = second.slides.iter().map(|slide| slide.contrast).collect();
            assert_eq!(found, contrasts);
            let back = mix(&second, &recipe(&[("left", 50.0), ("right", 20.0), ("oled", 100.0)]));
            let back = back.expect("as rendered").frame;
            let peak = peak(&frame);
            let (a, b) = (back.rgb("").expect("a picture")[0], frame.rgb("").expect("a picture")[0]);
            assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 4e-6 * peak), "{contrasts:?}");
        }
        // What a wrong mixture looks like.
        let wrong = mix(&taken, &recipe(&[("left", 2.0)])).expect("told apart").frame;
        let (worst, bound) = far(&frame, &wrong, &rendered(&three([50.0, 2.0, 100.0]), choice, 2).0);
        assert!(worst > 3.0 * bound, "{worst} {bound}");
    }
}

/// Largest |z| between a mixture of `first` and another rendering, over blocks of pixels of layers and shares, and the bound
/// that it must keep. What the mixture errs by is not in it: its noise is taken for that of `first`, times √2.
fn far(first: &Frame, mixed: &Frame, b: &Frame) -> (f64, f64) {
    let floor = 2e-6 * f64::from(peak(b));
    let mut z = Vec::new();
    for layer in
        ["hybrid", "direct_lamps", "direct_oled", "secondary_lamps", "forward_lamps", "caustic_lamps", "forward_oled"]
    {
        let error = if layer == "hybrid" { "stderr".to_owned() } else { format!("{layer}_stderr") };
        let pixels = |frame: &Frame, errors: &Frame, factor: f64| -> Option<Vec<(f64, f64)>> {
            let ([value, ..], [sigma, ..]) = (frame.rgb(layer)?, errors.rgb(&error)?);
            let variance = |sigma: &f32| factor * f64::from(*sigma).powi(2) + 0.5 * floor * floor;
            Some(value.iter().zip(sigma).map(|(value, sigma)| (f64::from(*value), variance(sigma))).collect())
        };
        let (Some(x), Some(y)) = (pixels(mixed, first, 2.0), pixels(b, b, 1.0)) else {
            assert!(mixed.rgb(layer).is_none() && b.rgb(layer).is_none(), "{layer}");
            continue;
        };
        z.extend(block_z(&x, &y, b.width, 6));
    }
    assert!(z.len() >= 3 * 6, "{}", z.len());
    worst_z(&z, 1e-3)
}

fn peak(frame: &Frame) -> f32 {
    frame.rgb("").map_or(0.0, |[red, ..]| red.iter().copied().fold(0.0, f32::max))
}

/// Telling slides apart changes no light but by rounding.
#[test]
fn the_picture_is_the_same() {
    let s = three([50.0, 20.0, 100.0]);
    let (told, _) = rendered(&s, Choice::Only(Estimator::Backward), 3);
    let plain = image(&render(&s, Choice::Only(Estimator::Backward), PASSES, 3).0);
    let peak = f64::from(peak(&told));
    let red = told.rgb("").expect("a picture")[0];
    assert!(red.iter().zip(plain).all(|(a, (b, _))| (f64::from(*a) - b).abs() < 1e-6 * peak));
}

/// Through two slides in series comes L·T₁·T₂, Tₖ = t·(1/C + s·(1 − 1/C)) each (Beer's law of filters), whatever contrasts they
/// were rendered with and are mixed for, together or one alone.
#[test]
fn slides_in_series() {
    let transmittance = |contrast: f64, s: f32| 0.9 * (1.0 / contrast + f64::from(s) * (1.0 - 1.0 / contrast));
    let values = [0.25, 0.5];
    let through =
        |contrasts: [f64; 2]| 1000.0 * transmittance(contrasts[0], values[0]) * transmittance(contrasts[1], values[1]);
    let near = |frame: &Frame, want: f64| {
        let red = frame.rgb("").expect("a picture")[0];
        assert!(red.iter().all(|value| (f64::from(*value) / want - 1.0).abs() < 1e-6), "{} {want}", red[0]);
    };
    let inf = f64::INFINITY;
    for rendered_at in [[20.0, 20.0], [20.0, 30.0], [1.0, 1.0], [inf, inf], [300.0, 1.0]] {
        for choice in [Choice::Only(Estimator::Backward), Choice::Auto] {
            let (frame, splits) = rendered(&stack(rendered_at, values), choice, 1);
            near(&frame, through(rendered_at));
            assert!(splits.iter().all(|split| split.written), "{splits:?}");
            let taken = Rendering::of(&frame).expect("complete");
            let layers = frame.layer_names();
            let own = |name: &&str| name.contains("_near_") || name.contains("_far_");
            let own: Vec<&str> = layers.into_iter().filter(own).collect();
            let share = taken.shares.first().expect("there is light").name.clone();
            let want = ["_open_open", "_content_open", "_open_content", "_content_content"];
            assert_eq!(own, want.map(|suffix| format!("{share}_near_far{suffix}")));
            for [near_at, far_at] in [[3.0, 500.0], [1.0, inf], [inf, 1.0], [inf, inf], [7.0, 7.0]] {
                let asked = recipe(&[("near", near_at), ("far", far_at)]);
                let mixed = mix(&taken, &asked).expect("they are told apart").frame;
                near(&mixed, through([near_at, far_at]));
                // A mixture can be mixed again.
                let again = Rendering::of(&mixed).expect("complete");
                near(&mix(&again, &recipe(&[("far", 2.0)])).expect("told apart").frame, through([near_at, 2.0]));
                near(&mix(&taken, &recipe(&[("far", far_at)])).expect("told").frame, through([rendered_at[0], far_at]));
            }
            let all = mix(&taken, &Recipe { contrast: Some(4.0), ..Recipe::default() }).expect("told apart");
            near(&all.frame, through([4.0; 2]));
            let mut less = frame.clone();
            less.channels.retain(|channel| !channel.name.contains("_open_content"));
            let said =
                mix(&Rendering::of(&less).expect("complete"), &recipe(&[("near", 3.0)])).unwrap_err().to_string();
            assert!(said.contains("layers of `near_far`, light through both, were left out"), "{said}");
            // What leaks is what comes where both are dark.
            let leak = leak_luminance(&taken, &["lamp".to_owned()], &Contrasts::default());
            let want = 1000.0 * 0.81 / (rendered_at[0] * rendered_at[1]);
            assert!(leak.iter().all(|leak| (leak - want).abs() <= 1e-6 * want), "{} {want}", leak[0]);
        }
    }
}

/// Two slides beside each other, a lamp behind each, and a diffuser before them: all paths have their own share of lamp and picture.
fn diffused() -> Scene {
    let mut s = scene();
    let group = add_group(&mut s, "panel");
    s.eye.resolution = [4, 4];
    s.eye.fov_deg = 4.0;
    let screen = face(Finish::Lambert { reflectance: 0.0, transmittance: 0.8 });
    add_part(&mut s, "screen", square(0.1), DVec3::NEG_Z * 0.5, None, vec![screen]);
    for (name, x, contrast) in [("left", -0.05, 50.0), ("right", 0.05, 20.0)] {
        let picture = Slide { size: [0.08; 2], ..mottled_slide(contrast) };
        let mut slide = face(Finish::None);
        slide.slide = Some(add_slide(&mut s, name, picture));
        add_part(&mut s, name, square(0.04), DVec3::new(x, 0.0, -0.55), None, vec![slide]);
        let mut panel = face(Finish::Absorber);
        panel.emitter = lamp(group, 1000.0);
        add_part(&mut s, "panel", square(0.03), DVec3::new(x, 0.0, -0.56), None, vec![panel]);
    }
    s
}

/// The error of a mixture at other contrasts of single slides is not less than the scatter of 30 seeds, nor far above it, by rays from
/// the eye; and it is still said where the mixture is mixed again. Without the layers' errors none is said.
#[test]
fn the_error_of_one_slide_bounds_the_scatter_of_seeds() {
    let s = diffused();
    let recipes =
        [recipe(&[("left", 2.0)]), recipe(&[("right", f64::INFINITY)]), recipe(&[("left", 1.0), ("right", 3.0)])];
    {
        let choice = Choice::Only(Estimator::Backward);
        let mut seen = vec![[Moments::default(); 16]; recipes.len()];
        let mut said = vec![0.0; recipes.len()];
        for seed in 0..30 {
            let (frame, _) = rendered(&s, choice, seed);
            let taken = Rendering::of(&frame).expect("complete");
            for (k, recipe) in recipes.iter().enumerate() {
                let gain = Recipe { gains: vec![("panel".to_owned(), 2.0)], ..recipe.clone() };
                let mixed = mix(&taken, &gain).expect("they are told apart");
                assert_eq!(mixed.errors, Errors::AtMostOfSlides);
                let [values, sigmas] = ["", "stderr"].map(|layer| mixed.frame.rgb(layer).expect("it is there")[0]);
                seen[k].iter_mut().zip(values).for_each(|(moments, value)| moments.add(f64::from(*value)));
                said[k] += sigmas.iter().map(|sigma| f64::from(*sigma).powi(2)).sum::<f64>() / (30.0 * 16.0);
                let again = Rendering::of(&mixed.frame).expect("complete");
                let back = mix(&again, &recipe_of_two(50.0, 20.0)).expect("told apart");
                assert_eq!(back.errors, Errors::AtMostOfSlides);
                let wider = back.frame.rgb("stderr").expect("it is there")[0];
                assert!(wider.iter().zip(sigmas).all(|(wider, sigma)| wider >= sigma));
            }
        }
        let scatter = |k: usize| seen[k].iter().map(|moments| moments.variance()).sum::<f64>() / 16.0;
        let ratios: Vec<f64> = (0..recipes.len()).map(|k| (said[k] / scatter(k)).sqrt()).collect();
        println!("{choice:?}: stated over seen {ratios:.3?}");
        // The scatter of 480 values is known to 3 %.
        assert!(ratios.iter().all(|ratio| *ratio > 0.95 && *ratio < 3.0), "{ratios:?}");
    }
    let (mut frame, _) = rendered(&s, Choice::Only(Estimator::Backward), 1);
    frame.channels.retain(|channel| !channel.name.contains("_change_stderr"));
    let mixed = mix(&Rendering::of(&frame).expect("complete"), &recipes[0]).expect("told apart");
    assert_eq!(mixed.errors, Errors::UnknownOfSlide);
    assert!(mixed.frame.rgb("stderr").is_none());
}

fn recipe_of_two(left: f64, right: f64) -> Recipe {
    recipe(&[("left", left), ("right", right)])
}

/// A display that shows a slide behind another slide, beside a lamp behind two, with a wall below that they light: any pair of
/// contrasts is what another seed renders of the scene with those, layer by layer, by rays from the eye and as planned.
#[test]
fn any_contrasts_of_slides_in_series_are_a_new_rendering() {
    for choice in [Choice::Only(Estimator::Backward), Choice::Auto] {
        let (frame, splits) = rendered(&twice([20.0, 20.0, 50.0]), choice, 1);
        assert!(splits.iter().all(|split| split.written), "{splits:?}");
        let taken = Rendering::of(&frame).expect("complete");
        let pairs = |group: &str| -> std::collections::BTreeSet<[usize; 2]> {
            let own = taken.shares.iter().filter(|share| share.group == group);
            own.flat_map(|share| share.by_pair.iter().map(|(pair, _)| *pair)).collect()
        };
        assert_eq!(pairs("lamps").into_iter().collect::<Vec<_>>(), [[0, 1]]);
        assert_eq!(pairs("oled").into_iter().collect::<Vec<_>>(), [[1, 2]]);
        let infinite = f64::INFINITY;
        let recipes = [
            (recipe(&[("left", 2.0), ("wide", 100.0)]), [2.0, 100.0, 50.0]),
            (recipe(&[("wide", 3.0), ("oled", infinite)]), [20.0, 3.0, infinite]),
            (recipe(&[("left", infinite), ("wide", 1.0), ("oled", 1.5)]), [infinite, 1.0, 1.5]),
        ];
        for (asked, contrasts) in recipes {
            let mixed = mix(&taken, &asked).expect("they are told apart").frame;
            let (again, _) = rendered(&twice(contrasts), choice, 2);
            let (worst, bound) = far(&frame, &mixed, &again);
            assert!(worst < bound, "{choice:?} {contrasts:?}: {worst} {bound}");
        }
        // What a wrong mixture looks like: the contrasts of the wrong slides.
        let wrong = mix(&taken, &recipe(&[("left", 100.0), ("wide", 2.0)])).expect("told apart").frame;
        let (worst, bound) = far(&frame, &wrong, &rendered(&twice([2.0, 100.0, 50.0]), choice, 2).0);
        assert!(worst > 3.0 * bound, "{worst} {bound}");
    }
}

/// A lamp behind a slide and a display, of light groups of their own, both behind a wide slide, and a wall that they light.
fn twice(contrasts: [f64; 3]) -> Scene {
    let mut s = scene();
    let (lamps, oled) = (add_group(&mut s, "lamps"), add_group(&mut s, "oled"));
    s.eye.resolution = [18, 12];
    s.eye.fov_deg = 30.0;
    let picture = |contrast: f64, size: f64| Slide { size: [size; 2], ..mottled_slide(contrast) };
    let mut left = face(Finish::None);
    left.slide = Some(add_slide(&mut s, "hud/left", picture(contrasts[0], 0.08)));
    add_part(&mut s, "left", square(0.04), DVec3::new(-0.06, 0.0, -0.5), None, vec![left]);
    let mut wide = face(Finish::None);
    wide.slide = Some(add_slide(&mut s, "hud/wide", picture(contrasts[1], 0.24)));
    add_part(&mut s, "wide", square(0.12), DVec3::NEG_Z * 0.45, None, vec![wide]);
    let mut panel = face(Finish::Absorber);
    panel.emitter = lamp(lamps, 1000.0);
    add_part(&mut s, "panel", square(0.036), DVec3::new(-0.06, 0.0, -0.51), None, vec![panel]);
    let mut display = face(Finish::Absorber);
    display.emitter = lamp(oled, 400.0);
    display.slide = Some(add_slide(&mut s, "hud/oled", picture(contrasts[2], 0.08)));
    add_part(&mut s, "oled", square(0.04), DVec3::new(0.06, 0.0, -0.5), None, vec![display]);
    let wall = face(Finish::Lambert { reflectance: 0.6, transmittance: 0.0 });
    let floor = mesh(&[quad(DVec3::ZERO, DVec3::Z * 0.12, DVec3::X * 0.2)]);
    add_part(&mut s, "wall", floor, DVec3::new(0.0, -0.06, -0.3), None, vec![wall]);
    s
}

/// Three slides in series, or one of two that is crossed twice, are refused by name, and nothing else is.
#[test]
fn more_in_series_is_refused() {
    let mut third = stack([20.0, 30.0], [0.25, 0.5]);
    let even = Slide { width: 1, height: 1, pixels: Arc::new(vec![0.5]), ..mottled_slide(40.0) };
    let mut slide = face(Finish::None);
    slide.slide = Some(add_slide(&mut third, "third", Slide { size: [0.6; 2], ..even }));
    add_part(&mut third, "slide", square(0.3), DVec3::NEG_Z * 0.65, None, vec![slide]);
    let (frame, _) = rendered(&third, Choice::Only(Estimator::Backward), 1);
    let said = mix(&Rendering::of(&frame).expect("complete"), &recipe(&[("far", 3.0)])).unwrap_err().to_string();
    assert_eq!(
        said,
        "--contrast: `direct_lamp` is not split by contrast of `far`: light that crosses two slides or more, one after the \
         other, makes up to 1.0e0 of the peak with all of them open; expected `direct_lamp_far_open` and `direct_lamp_far_content` \
         in the frame"
    );
    // A mirror behind both, lit from before them: all of its light crosses each twice.
    let mut back = stack([20.0; 2], [0.25, 0.5]);
    let panel = back.parts.iter().position(|part| part.name == "panel").expect("it is there");
    back.parts[panel].faces[0] = face(Finish::Lambert { reflectance: 0.9, transmittance: 0.0 });
    let mut lit = face(Finish::Absorber);
    lit.emitter = lamp(eyebox::base::ids::GroupId::from_index(0), 1000.0);
    let down = mesh(&[quad(DVec3::ZERO, DVec3::NEG_X * 0.1, DVec3::Y * 0.1)]);
    add_part(&mut back, "lit", down, DVec3::new(0.0, 0.4, -0.2), None, vec![lit]);
    let (frame, splits) = rendered(&back, Choice::Only(Estimator::Backward), 1);
    let refused: Vec<&Split> = splits.iter().filter(|split| !split.written).collect();
    assert!(!refused.is_empty(), "{splits:?}");
    let taken = Rendering::of(&frame).expect("complete");
    let said = mix(&taken, &recipe(&[("far", 3.0)])).unwrap_err().to_string();
    assert!(
        said.contains("of `far`: light that crosses three slides or more, one after the other, or one of two twice"),
        "{said}"
    );
    // All together they can be changed as before.
    assert!(mix(&taken, &Recipe { contrast: Some(3.0), ..Recipe::default() }).is_ok());
}

/// Slides beside each other have no planes for light through two, and their light is told as before.
#[test]
fn slides_beside_each_other_cost_nothing() {
    let s = three([50.0, 20.0, 100.0]);
    let checked = check(&s).expect("the scene is sound");
    let world = World::freeze(&s).expect("the scene can be traced");
    let plan = plan(&checked, &world, Choice::Auto);
    let told = granted(&[], (&[], &[]), &s, &world, &plan).expect("nothing is asked");
    assert_eq!(told.slides_told.expect("there are several").once, []);
    assert!(!told.sieve.expect("slides are told").parts_series());
}

/// Lamps of one group that show different pictures are told to part; wrong names are faults.
#[test]
fn what_cannot_be_told_is_refused() {
    let mut s = three([50.0, 20.0, 100.0]);
    let oled = s.parts.iter().position(|part| part.name == "oled").expect("it is there");
    s.parts[oled].faces[0].emitter = lamp(eyebox::base::ids::GroupId::from_index(0), 400.0);
    let (frame, _) = rendered(&s, Choice::Only(Estimator::Backward), 1);
    let taken = Rendering::of(&frame).expect("complete");
    let fault = |recipe: Recipe| mix(&taken, &recipe).unwrap_err().to_string();
    let mixed = fault(recipe(&[("oled", 3.0)]));
    assert!(
        mixed.contains("its lamps show several pictures, or some show none: give each a light group of its own"),
        "{mixed}"
    );
    let unknown = fault(recipe(&[("olde", 3.0)]));
    assert_eq!(
        unknown,
        "--contrast olde=3: the frame names no slide `olde`; expected one of left, right, oled; did you mean `oled`?"
    );
    assert!(fault(recipe(&[("oled", 0.5)])).starts_with("--contrast oled=0.5: 0.5 is no contrast"));
    assert!(fault(recipe(&[("oled", f64::NAN)])).contains("is no contrast"));
}

/// Names of slides are those of their parts, apart from each other and from light groups.
#[test]
fn slides_have_names_of_their_own() {
    let mut s = three([50.0, 20.0, 100.0]);
    s.slides[1].name = "other/left".to_owned();
    s.slides[2].name = "1st LCD".to_owned();
    assert_eq!(names(&s), ["left", "left2", "layer_1st_LCD"]);
    // `direct_lamps_left_open` would be both.
    s.groups[1].name = "lamps_left".to_owned();
    assert_eq!(names(&s), ["left2", "left3", "layer_1st_LCD"]);
    s.slides.truncate(1);
    assert!(names(&s).is_empty());
}
