//! Plates and slabs of `tests/data/radiometry_cases.json` through the whole tracer: transmittance of 1 and 4 plates by
//! Stokes vectors and, with `--polarisation off`, for light whose s and p are averaged at each face
//! (`T_unpolarised_tracer`: wrong, but known to be); tilted and absorbing slabs.

use crate::common::*;
use eyebox::film::plan::Estimator;
use eyebox::plan::{Asked, Choice, Polarisation};
use eyebox::scene::{Absorption, Finish};
use glam::{DAffine3, DVec3};

const PANEL_CD_M2: f64 = 1000.0;

/// Transmittance of `count` plates of index `n`, `thickness` m thick, tilted by `degrees`, seen before a panel.
fn transmittance(
    (n, count): (f64, usize),
    thickness: f64,
    absorption_per_m: f64,
    degrees: f64,
    passes: u64,
    polarisation: Polarisation,
) -> (f64, f64) {
    let mut s = scene();
    let group = add_group(&mut s, "panel");
    // So narrow that the mean over the field is the value in its middle: at 70° 0.5° would already be 1.6e-5 off.
    s.eye.fov_deg = 0.05;
    s.eye.resolution = [4, 4];
    for plate in 0..count {
        let at = DVec3::new(0.0, 0.0, -0.5 - 0.05 * plate as f64);
        let body = mesh(&cuboid(DVec3::new(2.0, 2.0, thickness / 2.0)));
        let part = add_part(&mut s, &format!("plate{plate}"), body, at, Some(n), vec![face(Finish::Polished); 6]);
        s.parts[part].to_world = DAffine3::from_translation(at) * DAffine3::from_rotation_x(degrees.to_radians());
        s.media[plate].absorption = Absorption::Constant(absorption_per_m);
    }
    let mut panel = face(Finish::Absorber);
    panel.emitter = lamp(group, PANEL_CD_M2);
    let wide = mesh(&[quad(DVec3::ZERO, DVec3::X * 0.3, DVec3::Y * 0.3)]);
    add_part(&mut s, "panel", wide, DVec3::new(0.0, 0.0, -6.0), None, vec![panel]);
    let (films, _) = render(&s, Asked { polarisation, ..Choice::Only(Estimator::Backward).into() }, passes, 1);
    let (value, sigma) = mean(&image(&films));
    (value / PANEL_CD_M2, sigma / PANEL_CD_M2)
}

fn cases() -> Vec<serde_json::Value> {
    let text = include_str!("data/radiometry_cases.json");
    let all: serde_json::Value = serde_json::from_str(text).expect("the table is JSON");
    all["cases"].as_array().expect("cases").clone()
}

fn check(what: &str, (got, sigma): (f64, f64), want: f64) {
    println!("{what}: {got:.5} ± {sigma:.5}, expected {want:.5}");
    assert!(sigma < 2e-3 * want.max(0.3), "{what}: σ {sigma}");
    assert!((got - want).abs() < 4.0 * sigma + 1e-6, "{what}: {got} ± {sigma}, expected {want}");
}

long! {
/// Mean reflectance and transmittance of the two polarisations, s and p apart, over what the plan decides by itself, what
/// is asked for, and what a tracer without polarisation makes of it.
#[test]
fn plates() {
    let mut seen = 0;
    for case in cases().iter().filter(|case| case["kind"] == "plates") {
        let number = |value: &serde_json::Value| value.as_f64().expect("a number");
        let (n, count) = (number(&case["params"]["n"]), number(&case["params"]["N"]) as usize);
        let angles = case["params"]["angles"].as_array().expect("angles");
        for (index, angle) in angles.iter().enumerate() {
            for (polarisation, key) in
                [(Polarisation::Auto, "T"), (Polarisation::On, "T"), (Polarisation::Off, "T_unpolarised_tracer")]
            {
                let want = number(&case["result"][key][index]);
                let got = transmittance((n, count), 0.002, 0.0, number(angle), 600, polarisation);
                check(&format!("{count} plates at {angle}°, {polarisation:?}"), got, want);
                seen += 1;
            }
        }
    }
    assert_eq!(seen, 21);
}
}

/// The issue's own figures: one plate of n = 1.5168 at 60°, 0.844.
#[test]
fn one_plate_at_60_degrees() {
    let got = transmittance((1.5168, 1), 0.002, 0.0, 60.0, 6_000, Polarisation::Auto);
    let cos: f64 = 0.5;
    let power = eyebox::world::fresnel::fresnel(1.0, 1.5168.into(), cos);
    let plate = |r: f64| (1.0 - r) / (1.0 + r);
    let want = 0.5 * (plate(power.r_s) + plate(power.r_p));
    assert!((want - 0.844).abs() < 5e-4, "{want}");
    check("n = 1.5168 at 60°", got, want);
}

#[test]
fn absorbing_slabs() {
    let mut seen = 0;
    for case in cases().iter().filter(|case| case["kind"] == "slab") {
        let number = |key: &str| case["params"][key].as_f64().expect("a number");
        let angles = case["params"]["angles"].as_array().expect("angles");
        let of = |key: &str, index: usize| case["result"][key][index].as_f64().expect("a number");
        let alpha = number("alpha_per_mm") * 1e3;
        for (index, angle) in angles.iter().enumerate() {
            let want = 0.5 * (of("Ts", index) + of("Tp", index));
            let degrees = angle.as_f64().expect("an angle");
            let got = transmittance((number("n"), 1), number("d_mm") * 1e-3, alpha, degrees, 1_000, Polarisation::Auto);
            check(&format!("{} at {degrees}°", case["id"].as_str().expect("an id")), got, want);
            seen += 1;
        }
    }
    assert!(seen > 3);
}
