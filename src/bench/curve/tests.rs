//! Reports of made-up and of real curves.

use super::asset::Form;
use super::cells::Batches;
use super::error::Error;
use super::fit::reach;
use super::picture::Picture;
use super::race::{Budget, Ready, race};
use super::reference::{Source, references};
use super::*;
use crate::kit;
use eyebox_estimate::run::begin;
use glam::DVec3;

fn error(relmse: f64) -> Error {
    Error {
        relmse,
        trimmed: 0.5 * relmse,
        flat: Some(relmse),
        edges: None,
        energy: 1.0,
        energy_sigma: 0.01,
        worst_sigma: 2.0,
    }
}

fn curve(estimator: &'static str, factor: f64) -> Curve {
    let point = |k: i32| {
        let seconds = 0.1 * 2f64.powi(k);
        Point { passes: 1 << k, seconds, paths: 1000 << k, error: error(factor / seconds) }
    };
    let points: Vec<Point> = (0..8).map(point).collect();
    let pairs: Vec<[f64; 2]> = points.iter().map(|p| [p.seconds, p.error.relmse]).collect();
    let reach_all = LEVELS.map(|level| reach(&pairs, 0.2, level)).to_vec();
    Curve {
        estimator,
        runs: vec![estimator],
        setup_seconds: 0.2,
        paths_per_second: 1e4,
        slope: fit::slope(&pairs),
        reach: reach_all.clone(),
        reach_trimmed: reach_all.clone(),
        reach_flat: reach_all,
        points,
    }
}

fn report() -> Report {
    let mut report = Report::new(1, 1);
    report.assets.push(AssetReport {
        asset: "a \"<&>\", b.glb".to_owned(),
        scene: "made up".to_owned(),
        scene_hash: String::new(),
        resolution: [36, 18],
        reference: ReferenceFacts {
            from: "auto".to_owned(),
            passes: Some([9, 9]),
            seconds: 3.0,
            mean: 20.0,
            noise: 1e-3,
            resolution: 1e-6,
            flat_pixels: [300, 648],
            known_blocks: Some(36),
            most_sigma: 3.2,
        },
        curves: vec![curve("auto", 0.01), curve("backward", 1.0), Curve { points: Vec::new(), ..curve("photon", 1.0) }],
    });
    report
}

/// Each element is closed in turn, and text holds no bare `<` or `&`.
fn assert_well_formed(text: &str) {
    let mut open: Vec<&str> = Vec::new();
    for piece in text.split('<').skip(1) {
        let (tag, rest) = piece.split_once('>').expect("a tag ends");
        assert!(!rest.contains('>'), "{rest}");
        let entities = rest.matches('&').count();
        let known = ["&amp;", "&lt;", "&gt;", "&quot;"].iter().map(|e| rest.matches(e).count()).sum::<usize>();
        assert_eq!(entities, known, "{rest}");
        assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
        match tag.strip_prefix('/') {
            Some(name) => assert_eq!(open.pop(), Some(name)),
            None if tag.ends_with('/') => {}
            None => open.push(tag.split(' ').next().unwrap()),
        }
    }
    assert!(open.is_empty(), "{open:?}");
}

#[test]
fn the_picture_is_well_formed_and_holds_every_curve() {
    let svg = report().in_form(Form::Svg);
    assert_well_formed(&svg);
    assert_eq!(svg.matches("<polyline").count(), 2);
    assert_eq!(svg.matches("<circle").count(), 16);
    for text in ["auto, slope -1.00", "backward, slope -1.00", "photon, has no work", "&lt;&amp;&gt;", ">relMSE<"] {
        assert!(svg.contains(text), "{text}: {svg}");
    }
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    let nothing = Report::new(1, 1);
    assert_well_formed(&nothing.in_form(Form::Svg));
}

/// Numbers survive both ways to other programs.
#[test]
fn csv_and_json_can_be_read_back() {
    let report = report();
    let csv = report.in_form(Form::Csv);
    let rows: Vec<&str> = csv.lines().collect();
    assert_eq!(rows.len(), 17);
    let columns = rows[0].split(',').count();
    for (row, point) in rows[1..9].iter().zip(&report.assets[0].curves[0].points) {
        // The name is quoted and its quotes are doubled.
        let rest = row.strip_prefix("\"a \"\"<&>\"\", b.glb\",").expect(row);
        let cells: Vec<&str> = rest.split(',').collect();
        assert_eq!(cells.len() + 1, columns);
        assert_eq!(cells[4].parse::<u64>().unwrap(), point.paths);
        assert_eq!(cells[5].parse::<f64>().unwrap(), point.error.relmse);
    }
    let value: serde_json::Value = serde_json::from_str(&report.in_form(Form::Json)).unwrap();
    let curve = &value["assets"][0]["curves"][0];
    assert_eq!(curve["points"][3]["error"]["relmse"].as_f64(), Some(report.assets[0].curves[0].points[3].error.relmse));
    assert_eq!(curve["reach"][0]["level"].as_f64(), Some(1e-2));
}

/// 0.01/s: 1 s to 1e-2, 10 s to 1e-3, and 100 s to 1e-4 by extrapolation, each after 0.2 s of setup.
#[test]
fn tables_tell_the_seconds() {
    let report = report();
    for form in [Form::Text, Form::Markdown] {
        let text = report.in_form(form);
        let line = text.lines().find(|line| line.contains("auto (auto)")).expect(&text);
        for cell in ["1.20", "10.2", "~100", "-1.00", "1.0000 ± 0.0100"] {
            assert!(line.contains(cell), "{cell}: {line}");
        }
    }
    let markdown = report.in_form(Form::Markdown);
    let tables: Vec<&str> = markdown.lines().filter(|line| line.starts_with('|')).collect();
    assert_eq!(tables.len(), 10);
}

/// A panel before a pinhole: exact and without chance, so nothing differs but by rounding; a matt wall in its light: the
/// error is no more than the variance that the film states.
#[test]
fn a_race_measures_what_the_film_states() {
    let mut scene = kit::scene(60.0, 12);
    kit::panel(&mut scene, 50.0, kit::quad(DVec3::new(0.0, 2.0, 0.0), DVec3::X * 0.7, DVec3::Z * 0.7));
    let matt = eyebox_scene::Finish::Lambert { reflectance: 0.5, transmittance: 0.0 };
    let wall = kit::mesh(&[kit::quad(DVec3::new(0.0, 0.0, -2.0), DVec3::X * 3.0, DVec3::Y * 3.0)]);
    kit::add(&mut scene, wall, glam::DAffine3::IDENTITY, None, vec![kit::face(matt)]);
    let ready = Ready::new(&scene, 0.0).unwrap();
    let source = Source::Traced { choice: Choice::Only(Estimator::Backward), passes: Some(200), seconds: 1e9 };
    let (references, facts) = references(&ready, &source, 7, &|| false).unwrap();
    assert_eq!(facts.passes, Some([200, 200]));
    let budget = Budget { seconds: 1e9, passes: Some(20) };
    let choices = [Choice::Auto, Choice::Only(Estimator::Backward)];
    let curves = race(&ready, &choices, &references, 7, budget, &|| false);
    for curve in &curves {
        let passes: Vec<u64> = curve.points.iter().map(|point| point.passes).collect();
        assert_eq!(passes, [1, 2, 4, 8, 16, 20], "{}", curve.estimator);
        let last = curve.points.last().unwrap();
        assert!(last.error.relmse > 2.0 * facts.resolution && facts.mean > 0.5, "{last:?} {facts:?}");
        // Ten times as many passes: a tenth of the error of independent points, a hundredth of what even ones could reach.
        let ratio = last.error.relmse / facts.noise;
        assert!((1.0..100.0).contains(&ratio), "{ratio} {last:?} {facts:?}");
        assert!((last.error.energy - 1.0).abs() < 4.0 * last.error.energy_sigma, "{last:?}");
        assert!(last.error.worst_sigma.abs() < facts.most_sigma + 1.0, "{last:?}");
    }
    // The same seed gives the same picture.
    assert_eq!(curves[1].points.last().map(|p| p.error), {
        let again = race(&ready, &choices[1..], &references, 7, budget, &|| false);
        again[0].points.last().map(|p| p.error)
    });
    // Told to stop at once it makes no pass.
    assert!(race(&ready, &choices, &references, 7, budget, &|| true).iter().all(|curve| curve.points.is_empty()));
}

/// Neighbouring pixels gather the same photons: what batches of passes say of a cell's light is what comes again with other
/// seeds, and what the pixels' variances add up to is half of it.
#[test]
fn photons_that_pixels_share() {
    let scene = crate::generate::scene(5);
    let ready = Ready::new(&scene, 0.0).unwrap();
    let (size, choice) = (scene.eye.resolution, Choice::Only(Estimator::Photon));
    let plan = eyebox_plan::plan(&ready.checked, &ready.world, choice);
    let pictures: Vec<Picture> = (0..24)
        .map(|seed| {
            let mut tracing = begin(&ready.world, &plan, scene.groups.len(), size, seed);
            let mut batches = Batches::default();
            (0..15).for_each(|_| {
                tracing.step(1);
                Picture::of_batches(tracing.films(), size, &mut batches);
            });
            Picture::of_batches(tracing.films(), size, &mut batches)
        })
        .collect();
    let grid = pictures[0].cells();
    let cells = grid.blocks(8).len();
    let lights: Vec<Vec<f64>> = pictures.iter().map(|picture| grid.sums(picture.values.iter().copied())).collect();
    let (mut real, mut of_batches, mut of_pixels) = (0.0, 0.0, 0.0);
    for (seed, picture) in pictures.iter().enumerate() {
        let pixels = grid.sums(picture.variances.iter().copied());
        for cell in 0..cells {
            let mean = lights.iter().map(|light| light[cell]).sum::<f64>() / lights.len() as f64;
            real += (lights[seed][cell] - mean).powi(2) / (lights.len() - 1) as f64;
            of_batches += picture.batches.worth(&[cell]).unwrap().variance / lights.len() as f64;
            of_pixels += pixels[cell] / lights.len() as f64;
        }
    }
    assert!((0.75..1.33).contains(&(real / of_batches)), "{real} {of_batches}");
    assert!(of_pixels < 0.6 * of_batches, "{of_batches} {of_pixels}");
}
