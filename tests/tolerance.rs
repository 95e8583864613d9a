//! `eyebox tolerance` against closed forms: a tilted mirror, a decentred lens, a plate whose index and thickness are off.

use crate::common::scene as empty;
use crate::scan::{fresnel, mirrored, plate};
use eyebox::import::{ImportOptions, import, toml};
use eyebox::plan::tolerance::parameter::parameters;
use eyebox::plan::tolerance::table::{csv, lines};
use eyebox::plan::tolerance::{Statistics, ToleranceAsked, Tolerances, tolerance};
use eyebox::scene::Scene;
use std::f64::consts::{FRAC_PI_4, PI};
use std::path::Path;

const ARCMIN: f64 = PI / 10_800.0;

fn asked(draws: usize) -> ToleranceAsked {
    ToleranceAsked { draws, seed: 3, points: [3, 3], target: None, ipd_m: 0.06 }
}

fn run(scene: &Scene, text: &str, draws: usize) -> Tolerances {
    let root = toml::parse(text, Path::new("t.toml")).expect("TOML");
    let all = parameters(&root, scene).expect("these tolerances can be read");
    tolerance(scene, &all, &asked(draws), &|| false, &|_, _| {})
        .expect("the design can be looked at")
        .expect("nobody stopped it")
}

fn figure<'f>(found: &'f Tolerances, name: &str) -> &'f Statistics {
    found.figures.iter().find(|figure| figure.figure.name == name).unwrap_or_else(|| panic!("no {name}"))
}

/// The standard deviation by quadrature, and that of the draws within four of its errors.
fn check(figure: &Statistics, want: f64, precision: f64) {
    let own = figure.shares.iter().map(|share| share.variance.unwrap()).sum::<f64>().sqrt();
    assert!((own / want - 1.0).abs() < precision, "{}: {own} {want}", figure.figure.name);
    assert!(
        (figure.sigma - want).abs() < 4.0 * figure.sigma_error + precision * want,
        "{}: {} {want}",
        figure.figure.name,
        figure.sigma
    );
    assert!((figure.mean - figure.nominal).abs() < 4.0 * want / f64::sqrt(figure.draws as f64) + precision * want);
}

/// A mirror that is tilted by θ about a line in it turns an image about that line by 2θ. The lamp's is 0.5 m behind the line and
/// 0.8 m before the eye.
#[test]
fn a_tilted_mirror_turns_the_image_by_twice_as_much() {
    let text = "[[tolerance]]\npart = 'mirror'\ntilt_arcmin = [2.0, 0, 0]\nabout_mm = [0, 0, -300]\n";
    let found = run(&mirrored(0.3), text, 400);
    assert_eq!((found.part.as_str(), found.by.as_str(), found.failed), ("lamp", "mirror", 0));
    check(figure(&found, "direction up"), 2.0 * 2.0 * 0.5 / 0.8, 1e-4);
    // The other way it does not move to first order.
    assert!(figure(&found, "direction right").sigma < 1e-6);
    let even = run(&mirrored(0.3), &format!("{text}distribution = 'uniform'\n"), 400);
    check(figure(&even, "direction up"), 2.0 * 2.0 * 0.5 / 0.8 / f64::sqrt(3.0), 1e-4);
    // Moved along, the image moves by twice the way along the normal: up by as much as it goes away.
    let shifted = run(&mirrored(0.3), "[[tolerance]]\npart = 'mirror'\ndecenter_mm = [0, 0.1, 0]\n", 400);
    check(figure(&shifted, "direction up"), 1e-4 / 0.8 / ARCMIN, 1e-3);
}

/// A lens that is decentred by δ before a picture in its focus turns its direction by δ/f, f = R/(n − 1) of a plano-convex one.
#[test]
fn a_decentred_lens_turns_the_image_by_its_share_of_the_focal_length() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples/hud-direct/hud.optics.toml");
    let scene = import(&path, &ImportOptions::default()).expect("the sample imports").scene;
    let found = run(&scene, "[[tolerance]]\npart = 'LENS_02_NBK7'\ndecenter_mm = [0.1, 0, 0]\n", 64);
    let f_mm = 103.704_48 / (1.518_522_387_620_788 - 1.0);
    check(figure(&found, "direction right"), 0.1 / f_mm / ARCMIN, 2e-3);
}

/// What a plate's front and back send: luminance by Fresnel's equations of a drawn index, the ghost's distance by the law of
/// refraction with a drawn thickness.
#[test]
fn a_plate_whose_index_and_thickness_are_off() {
    let (n, thickness) = (1.52, 0.004);
    let index = run(&plate(n, thickness), "[[tolerance]]\npart = 'mirror'\nindex = 0.002\n", 400);
    let sent = |n: f64| fresnel(FRAC_PI_4, n).iter().sum::<f64>();
    let slope = (sent(n + 1e-4) - sent(n - 1e-4)) / 2e-4 / sent(n);
    check(figure(&index, "luminance"), 0.002 * slope, 1e-3);
    let scene = plate(n, thickness);
    let text = format!("[[tolerance]]\npart = 'mirror'\nface = {}\nthickness_mm = 0.02\n", back_of(&scene));
    let thick = run(&scene, &text, 400);
    let ghost = figure(&thick, "ghost up: mirror back");
    // The distance of two images of a plate is in proportion to its thickness, but for second orders.
    check(ghost, ghost.nominal.abs() * 0.02 / 4.0, 1e-2);
    let wedge = run(&scene, &text.replace("thickness_mm = 0.02", "wedge_arcmin = [0.5, 0]"), 64);
    // The back turned by α: inside the ray turns by 2α, outside by 2α n cos θ′/cos θ (differential of the law of refraction),
    // seen from 0.3 m before the plate and 0.5 m behind it as 0.5/0.8 of that.
    let inside = (FRAC_PI_4.sin() / n).asin();
    let want = 2.0 * 0.5 * n * inside.cos() / FRAC_PI_4.cos() * 0.5 / 0.8;
    check(figure(&wedge, "ghost up: mirror back"), want, 2e-2);
}

/// The face of the plate whose normal is −z in its own axes.
fn back_of(scene: &Scene) -> usize {
    let mesh = &scene.meshes[scene.parts[0].mesh.index()];
    let is_back = |face: &eyebox::scene::FaceRange| {
        let [a, b, c] = mesh.triangles[face.first as usize].map(|v| glam::Vec3::from_array(mesh.positions[v as usize]));
        (b - a).cross(c - a).normalize().z < -0.9
    };
    mesh.faces.iter().position(is_back).expect("a plate has a back")
}

#[test]
fn draws_hang_on_the_parameter_alone() {
    let one = "[[tolerance]]\npart = 'mirror'\ntilt_arcmin = [2.0, 0, 0]\n";
    let both = format!("[[tolerance]]\npart = 'lamp'\ndecenter_mm = [0, 0, 0.1]\n{one}");
    let (alone, together) = (run(&mirrored(0.3), one, 16), run(&mirrored(0.3), &both, 16));
    let tilt = |found: &Tolerances, at: usize| found.samples.iter().map(|(values, _)| values[at]).collect::<Vec<_>>();
    assert_eq!(tilt(&alone, 0), tilt(&together, 1));
    // A lamp that moves takes its picture with it.
    let seen = figure(&together, "seen");
    assert_eq!((seen.least, seen.most), (1.0, 1.0));
    let table = csv(&together);
    assert_eq!(table.lines().count(), 17);
    assert!(table.starts_with("\"lamp decenter z\",\"mirror tilt x\",\"direction right\""), "{table}");
    assert!(lines(&together).iter().any(|line| line.contains("% mirror tilt x")));
}

#[test]
fn faults_say_where() {
    let fault = |text: &str, scene: &Scene| {
        let root = toml::parse(text, Path::new("t.toml")).expect("TOML");
        parameters(&root, scene).expect_err(text).to_string()
    };
    let scene = plate(1.5, 0.004);
    for (text, said) in [
        ("", "no tolerances"),
        ("tolerances = 1", "did you mean `tolerance`"),
        ("[[tolerance]]\npart = 'miror'\nindex = 1e-3", "mirror"),
        ("[[tolerance]]\npart = 'mirror'\ntilt_arcmn = [1, 1, 1]", "tilt_arcmin"),
        ("[[tolerance]]\npart = 'mirror'\ntilt_arcmin = [1, 1]", "3 numbers"),
        ("[[tolerance]]\npart = 'mirror'\ntilt_arcmin = [1, -1, 1]", "0 or more"),
        ("[[tolerance]]\npart = 'mirror'\ntilt_arcmin = [0, 0, 0]", "nothing of this part"),
        ("[[tolerance]]\npart = 'mirror'\nindex = 1e-3\ndistribution = 'gaussian'", "normal"),
        ("[[tolerance]]\npart = 'mirror'\nradius_percent = 1", "which face"),
        ("[[tolerance]]\npart = 'mirror'\nface = 6\nthickness_mm = 1", "0 to 5"),
        ("[[tolerance]]\npart = 'mirror'\nface = 0\nradius_percent = 1", "no radius"),
        ("[[tolerance]]\npart = 'lamp'\nindex = 1e-3", "no medium"),
        ("[[tolerance]]\npart = 'mirror'\nface = 0\ntilt_arcmin = [1, 1, 1]", "`face` means nothing here"),
        ("[[tolerance]]\npart = 'mirror'\nindex = 1e-3\nabout_mm = [0, 0, 0]", "`about_mm` means nothing here"),
        ("[[tolerance]]\npart = 'mirror'\nindex = 1e-3\n[[tolerance]]\npart = 'mirror'\nindex = 1e-3", "twice"),
    ] {
        let fault = fault(text, &scene);
        assert!(fault.contains(said), "{text}: {fault}");
        assert!(text.is_empty() || fault.contains("t.toml:"), "{fault}");
    }
    let all =
        parameters(&toml::parse("[[tolerance]]\npart = 'mirror'\nindex = 1e-3", Path::new("t.toml")).unwrap(), &scene)
            .unwrap();
    // A group of one part has its faces.
    let group = "[[tolerance]]\ngroup = 'mirror'\nface = 0\nthickness_mm = 1";
    assert!(parameters(&toml::parse(group, Path::new("t.toml")).unwrap(), &scene).is_ok());
    let few = tolerance(&scene, &all, &asked(3), &|| false, &|_, _| {}).expect_err("too few");
    assert!(few.to_string().contains("--draws"), "{few}");
    let even = ToleranceAsked { points: [4, 4], ..asked(16) };
    let even = tolerance(&scene, &all, &even, &|| false, &|_, _| {}).expect_err("no middle");
    assert!(even.to_string().contains("odd numbers"), "{even}");
    // The lamp is the picture.
    let own = toml::parse("[[tolerance]]\npart = 'lamp'\nface = 0\nthickness_mm = 0.1", Path::new("t.toml")).unwrap();
    let own = parameters(&own, &scene).unwrap();
    let own = tolerance(&scene, &own, &asked(16), &|| false, &|_, _| {}).expect_err("the picture's face");
    assert!(own.to_string().contains("t.toml:4") && own.to_string().contains("picture itself"), "{own}");
    assert!(tolerance(&empty(), &[], &asked(16), &|| false, &|_, _| {}).is_err());
    assert!(tolerance(&scene, &all, &asked(16), &|| true, &|_, _| {}).unwrap().is_none());
}
