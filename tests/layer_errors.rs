//! Standard errors per layer, and of pictures mixed from `open` and `content`, against the scatter of many seeds.

use crate::common::*;
use eyebox::base::colour::ColourSpace;
use eyebox::base::ids::{GroupId, SlideId};
use eyebox::base::stats::Moments;
use eyebox::check::check;
use eyebox::estimate::run::{Limits, run};
use eyebox::film::accumulate::{Film, Together};
use eyebox::film::error_detail::ErrorDetail;
use eyebox::film::finish::{GroupInfo, finish};
use eyebox::film::frame::Frame;
use eyebox::film::layer::Layer;
use eyebox::film::plan::Estimator;
use eyebox::plan::{Choice, plan};
use eyebox::scene::*;
use eyebox::world::World;
use glam::DVec3;

/// A diffuser before a slide before a lamp: every path has its own share of lamp and of picture.
fn diffuser_and_slide() -> Scene {
    let mut s = scene();
    let group = add_group(&mut s, "panel");
    s.eye.resolution = [4, 4];
    s.eye.fov_deg = 4.0;
    let square = |half: f64| mesh(&[quad(DVec3::ZERO, DVec3::X * half, DVec3::Y * half)]);
    let screen = face(Finish::Lambert { reflectance: 0.0, transmittance: 0.8 });
    add_part(&mut s, "screen", square(0.1), DVec3::NEG_Z * 0.5, None, vec![screen]);
    s.slides.push(mottled_slide(50.0));
    let mut slide = face(Finish::None);
    slide.slide = Some(SlideId::from_index(0));
    add_part(&mut s, "slide", square(0.1), DVec3::NEG_Z * 0.55, None, vec![slide]);
    let mut panel = face(Finish::Absorber);
    panel.emitter = lamp(group, 1000.0);
    add_part(&mut s, "panel", square(0.06), DVec3::NEG_Z * 0.6, None, vec![panel]);
    s
}

fn channel<'f>(frame: &'f Frame, name: &str) -> &'f [f32] {
    let found = frame.channels.iter().find(|channel| channel.name == format!("{name}.R"));
    &found.unwrap_or_else(|| panic!("no channel of {name}")).data
}

#[test]
fn the_error_of_a_mixture_is_the_scatter_of_seeds() {
    let s = diffuser_and_slide();
    let checked = check(&s).expect("the scene is sound");
    let world = World::freeze(&s).expect("the scene can be traced");
    let mut plan = plan(&checked, &world, Choice::Only(Estimator::Backward));
    plan.errors = ErrorDetail::Layers;
    let (seeds, passes) = (400u64, 16);
    // A run's passes are even against each other, and its errors are bounds. Here each pass is a run of its own.
    let limits = Limits { passes: Some(1), ..Limits::default() };
    let traced = |seed: u64| {
        let outcome = run(&world, &plan, 1, s.eye.resolution, seed, &limits, &mut ());
        outcome.films.films.into_iter().map(|(_, film, _)| film).collect::<Vec<Film>>()
    };
    let group = GroupInfo { name: "panel".to_owned(), contrast: Some(50.0), slides: None, tint: [1.0; 3] };
    let contrasts = [1.0, 2.0, 5.0, 300.0, f64::INFINITY];
    let pixels = 16;
    let mut seen = vec![[Moments::default(); 5]; pixels];
    let (mut predicted, mut without_covariance, mut of_layer) = ([0.0; 5], [0.0; 5], 0.0);
    for seed in 0..seeds {
        let mut films = traced(passes * seed);
        for pass in 1..passes {
            let others = traced(passes * seed + pass);
            assert!(films.iter_mut().zip(&others).all(|(film, other)| film.merge(other)));
        }
        let films: Vec<&Film> = films.iter().collect();
        let frame = finish(s.eye.resolution, &films, std::slice::from_ref(&group), &[], ColourSpace::Rec709).frame;
        let of = |suffix: &str| channel(&frame, &format!("caustic_panel_{suffix}"));
        let (open, content) = (of("open"), of("content"));
        let (open_error, content_error, covariance) = (of("open_stderr"), of("content_stderr"), of("covariance"));
        assert_eq!(channel(&frame, "caustic_stderr"), channel(&frame, "caustic_panel_stderr"), "one group");
        for pixel in 0..pixels {
            let at = |data: &[f32]| f64::from(data[pixel]);
            of_layer += at(channel(&frame, "caustic_stderr")).powi(2);
            for (k, contrast) in contrasts.into_iter().enumerate() {
                let (u, v) = (1.0 - 1.0 / contrast, 1.0 / contrast);
                seen[pixel][k].add(u * at(content) + v * at(open));
                let apart = (u * at(content_error)).powi(2) + (v * at(open_error)).powi(2);
                without_covariance[k] += apart;
                predicted[k] += apart + 2.0 * u * v * at(covariance);
            }
        }
    }
    let scatter = |k: usize| seen.iter().map(|moments| moments[k].variance()).sum::<f64>() * seeds as f64;
    for (k, contrast) in contrasts.into_iter().enumerate() {
        let ratio = predicted[k] / scatter(k);
        println!("C = {contrast}: predicted over seen variance {ratio:.4}");
        // 6400 values of nearly normal means: their variance is known to √(2/6384) = 1.8 %.
        assert!((ratio - 1.0).abs() < 4.0 * (2.0f64 / 6384.0).sqrt(), "C = {contrast}: {ratio}");
    }
    assert!(without_covariance[1] / scatter(1) < 0.8, "the covariance counts at C = 2");
    // The layer itself was rendered at C = 50.
    let ratio = of_layer / predicted[3];
    assert!((ratio - 1.0).abs() < 0.05, "the layer's own error: {ratio}");
}

#[test]
fn nothing_is_kept_that_was_not_asked_for() {
    let s = diffuser_and_slide();
    let (films, _) = render(&s, Choice::Only(Estimator::Backward), 2, 1);
    let films: Vec<&Film> = films.films.iter().map(|(_, film, _)| film).collect();
    let share = (Layer::Caustic, GroupId(0));
    assert!(films[0].planes_of(Together::Share(share.0, share.1)).next().is_some(), "it is filled");
    assert!(films[0].mix_error(0, share).is_none());
    let group = GroupInfo { name: "panel".to_owned(), contrast: Some(50.0), slides: None, tint: [1.0; 3] };
    let frame = finish(s.eye.resolution, &films, &[group], &[], ColourSpace::Rec709).frame;
    let extra = |name: &str| name.contains("_stderr") || name.contains("covariance");
    assert!(frame.channels.iter().all(|channel| !extra(&channel.name)));
}
