//! A mixed frame is the frame that a new rendering at that contrast and lamp level gives.

use crate::common::*;
use eyebox::base::ids::SlideId;
use eyebox::check::check;
use eyebox::estimate::picture::{add_meta, picture};
use eyebox::estimate::run::{Limits, run};
use eyebox::film::error_detail::ErrorDetail;
use eyebox::film::frame::Frame;
use eyebox::film::plan::Estimator;
use eyebox::output::compare::{Verdict, compare};
use eyebox::output::light_shares::Rendering;
use eyebox::output::mix::{Errors, Recipe, mix};
use eyebox::plan::{Choice, plan};
use eyebox::scene::*;
use eyebox::world::World;
use glam::DVec3;

const PASSES: u64 = 64;

/// A slide before a lamp, and a second lamp beside it whose light never meets the slide, behind a diffuser.
fn lamps_and_slide(contrast: f64, luminance: f64) -> Scene {
    let mut s = scene();
    let (panel, side) = (add_group(&mut s, "panel"), add_group(&mut s, "side"));
    s.eye.resolution = [12, 6];
    s.eye.fov_deg = 4.0;
    let square = |half: f64| mesh(&[quad(DVec3::ZERO, DVec3::X * half, DVec3::Y * half)]);
    let screen = face(Finish::Lambert { reflectance: 0.4, transmittance: 0.5 });
    add_part(&mut s, "screen", square(0.05), DVec3::NEG_Z * 0.5, None, vec![screen]);
    s.slides.push(mottled_slide(contrast));
    let mut slide = face(Finish::None);
    slide.slide = Some(SlideId::from_index(0));
    add_part(&mut s, "slide", square(0.1), DVec3::NEG_Z * 0.55, None, vec![slide]);
    for (name, group, at, value) in
        [("panel", panel, DVec3::NEG_Z * 0.6, luminance), ("side", side, DVec3::new(0.0, 0.2, -0.3), 500.0)]
    {
        let mut lamp_face = face(Finish::Absorber);
        lamp_face.emitter = lamp(group, value);
        // The second lamp shines down on the side of the screen that the eye sees.
        let facing =
            if name == "panel" { square(0.06) } else { mesh(&[quad(DVec3::ZERO, DVec3::X * 0.05, DVec3::Z * 0.05)]) };
        add_part(&mut s, name, facing, at, None, vec![lamp_face]);
    }
    s
}

fn rendered(s: &Scene, seed: u64) -> Frame {
    let checked = check(s).expect("the scene is sound");
    let world = World::freeze(s).expect("the scene can be traced");
    let mut plan = plan(&checked, &world, Choice::Only(Estimator::Backward));
    plan.errors = ErrorDetail::Layers;
    let limits = Limits { passes: Some(PASSES), ..Limits::default() };
    let outcome = run(&world, &plan, s.groups.len(), s.eye.resolution, seed, &limits, &mut ());
    let finished = picture(s, &plan, &outcome, Default::default()).expect("finite light");
    let mut frame = finished.frame;
    add_meta(&mut frame, s, &plan, &outcome, seed, &finished.splits);
    frame
}

#[test]
fn a_mixture_is_a_new_rendering() {
    let rendering = rendered(&lamps_and_slide(50.0, 1000.0), 1);
    let taken = Rendering::of(&rendering).expect("complete");
    assert!(taken.shares.iter().any(|share| share.group == "side" && share.split.is_none()), "{:?}", taken.groups);
    for (contrast, gain) in [(4.0, 1.0), (50.0, 0.25), (1000.0, 3.0), (1.0, 1.0), (f64::INFINITY, 0.5)] {
        let recipe = Recipe { gains: vec![("panel".to_owned(), gain)], contrast: Some(contrast), ..Recipe::default() };
        let mixed = mix(&taken, &recipe).expect("it has a slide");
        assert!(mixed.errors != Errors::Unknown && mixed.errors != Errors::Absent);
        // Another seed: the same but for noise, in every layer, and in the split that the mixture still has.
        let scene = lamps_and_slide(contrast, 1000.0 * gain);
        let found = compare(&mixed.frame, &rendered(&scene, 2), 3.0);
        assert!(!found.different, "C = {contrast}, gain {gain}: {:?}", found.layers);
        assert!(found.layers.iter().any(|layer| layer.verdict == Verdict::Same && layer.layer.is_empty()));
    }
    // What a wrong mixture looks like.
    let wrong = mix(&taken, &Recipe { contrast: Some(2.0), ..Recipe::default() }).expect("it has a slide").frame;
    assert!(compare(&wrong, &rendered(&lamps_and_slide(50.0, 1000.0), 2), 3.0).different);
}
