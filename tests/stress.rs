//! The stress suite finds nothing, and finds what is planted.

use eyebox::scene::{Absorption, Angular, CoatingLaw, Dispersion, Photometry, Scene};
use eyebox_bench::measure::Measured;
use eyebox_bench::stress::{Case, Kind, judge, of_measured, run, table};
use glam::DVec3;
use std::sync::Arc;

/// More standard errors than any run has by chance.
const MOST_SIGMA: f64 = 5.5;

long! {
#[test]
fn the_suite_finds_nothing() {
    println!("{}", table::head());
    let report = run(&Kind::ALL, &mut |row| println!("{}", table::line(row)));
    println!("{}", table::summary(&report));
    let found: Vec<String> = report.rows.iter().filter(|row| !row.findings.is_empty()).map(table::line).collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
    assert!(report.rows.iter().all(|row| row.nan == 0));
}
}

/// What is broken in a scene of each kind: about as little as the kind is there to see.
fn plant(kind: Kind, scene: &mut Scene) {
    let other_index = |scene: &mut Scene, factor: f64| {
        for medium in &mut scene.media {
            if let Dispersion::Constant(n) = &mut medium.index {
                *n *= factor;
            }
        }
    };
    match kind {
        // Of other glass.
        Kind::Scale | Kind::Offset | Kind::Sliver | Kind::Mode => {
            other_index(scene, if kind == Kind::Mode { 1.3 } else { 1.03 });
            if scene.sky.is_some() {
                // A furnace sees no index, but it sees absorption.
                scene.media[0].absorption = Absorption::Constant(2.0);
            }
        }
        Kind::Index => other_index(scene, 1.2),
        Kind::Grazing => other_index(scene, 1.0 + 1e-4),
        // A tenth of the smallest distance from the angle.
        Kind::Critical => other_index(scene, 1.0 - 1e-6),
        // Air between.
        Kind::Gap => {
            let away = scene.parts[0].to_world.transform_vector3(DVec3::Z) * 2e-4;
            scene.parts[0].to_world.translation += away;
        }
        Kind::Coincident => {
            // The solid that fills the space is another one; a sheet is lifted off its plate and has a hole.
            other_index(scene, 1.05);
            let last = scene.parts.len() - 1;
            if scene.parts[last].medium.is_none() {
                scene.parts[last].to_world.translation += DVec3::X * 0.41;
            }
        }
        Kind::Emitter => {
            let emitter =
                scene.parts.iter_mut().flat_map(|part| &mut part.faces).find_map(|face| face.emitter.as_mut());
            let emitter = emitter.expect("a lamp");
            emitter.photometry = Photometry::LuminanceCdM2(1.1e9);
            emitter.angular = Angular::Lambert;
        }
        Kind::Sun => {
            let sky = scene.sky.as_mut().expect("a sky");
            let mut pixels = sky.luminance.to_vec();
            let sun = pixels.iter_mut().find(|pixel| **pixel > 1000.0).expect("a sun");
            *sun *= 1.05;
            sky.luminance = Arc::new(pixels);
        }
        // Half of the light on the way.
        Kind::Guide => scene.media[0].absorption = Absorption::Constant(50.0),
        Kind::Coating => {
            let CoatingLaw::Stack(films) = &mut scene.coatings[0].law else { panic!("a stack of films") };
            films[0].thickness_nm = films[0].thickness_nm * 1.01 + 1.0;
        }
    }
}

/// Kinds whose planted fault does not show in these cases, which have others that do.
fn is_blind(kind: Kind, case: &Case) -> bool {
    match kind {
        // Total reflection stays total; nothing stays nothing.
        Kind::Critical => case.want == 0.0,
        // What crosses is too little to be looked for.
        Kind::Grazing => case.want > 1000.0 * 255.0 / 256.0,
        // An opaque film is as good as twice of it.
        Kind::Coating => ["1e5 nm", "1e6 nm", "3.6i of 1e3 nm"].iter().any(|name| case.name.contains(name)),
        // Air is there already.
        Kind::Gap => case.name.contains("air"),
        Kind::Coincident => case.want == 0.0 && case.name.contains("75"),
        Kind::Scale
        | Kind::Offset
        | Kind::Index
        | Kind::Sliver
        | Kind::Emitter
        | Kind::Sun
        | Kind::Guide
        | Kind::Mode => false,
    }
}

long! {
/// Every case of every kind is turned red by a fault of that kind.
#[test]
fn planted_faults_are_found() {
    let mut missed = Vec::new();
    for kind in Kind::ALL {
        for mut case in kind.cases() {
            if is_blind(kind, &case) {
                continue;
            }
            plant(kind, &mut case.scene);
            let row = judge(kind, &case, MOST_SIGMA);
            if row.findings.is_empty() {
                missed.push(table::line(&row));
            }
        }
    }
    assert!(missed.is_empty(), "{}", missed.join("\n"));
    assert!(Kind::ALL.iter().all(|kind| kind.cases().iter().any(|case| !is_blind(*kind, case))));
}
}

/// Each limit is one.
#[test]
fn each_limit_bites() {
    let case = Kind::Coating.cases().remove(0);
    let sound = Measured {
        mean: case.want,
        sigma: 0.0,
        loss: 0.0,
        loss_sigma: 0.0,
        cut: 0.0,
        nan: 0,
        mismatches: 0.0,
        vertex_error: 0.0,
    };
    let findings = |m: Measured| of_measured(Kind::Coating, &case, &m, MOST_SIGMA).findings;
    assert!(findings(sound).is_empty());
    for (broken, said) in [
        (Measured { mean: case.want * (1.0 + 1e-6), ..sound }, "bias"),
        (Measured { mean: f64::NAN, ..sound }, "bias"),
        (Measured { sigma: 0.1 * case.want, ..sound }, "noise"),
        (Measured { loss: 1e-9, ..sound }, "lost"),
        (Measured { loss: -1e-9, ..sound }, "lost"),
        (Measured { loss_sigma: 1e-3, ..sound }, "lost"),
        (Measured { cut: 1e-5, ..sound }, "cut off"),
        (Measured { nan: 1, ..sound }, "no numbers"),
        (Measured { vertex_error: 1e-9, ..sound }, "R + T + A"),
        (Measured { mismatches: 0.01, ..sound }, "contradict"),
    ] {
        let found = findings(broken);
        assert!(found.iter().any(|finding| finding.contains(said)), "{said}: {found:?}");
    }
}
