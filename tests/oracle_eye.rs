//! Pupil and glare against the tables of `tests/data/eye_*` (made by independent scripts; headers say how), all rows.

use eyebox::base::vision::*;

fn rows(text: &str) -> Vec<Vec<Option<f64>>> {
    let lines = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    lines.map(|line| line.split(',').map(|cell| cell.trim().parse().ok()).collect()).collect()
}

/// The tables have 12 digits.
fn assert_near(what: &str, got: f64, want: Option<f64>) {
    let want = want.unwrap_or_else(|| panic!("{what}: the table has no value"));
    assert!((got - want).abs() <= 1e-9 * want.abs().max(1e-3), "{what}: {got}, want {want}");
}

#[test]
fn pupils() {
    let all = rows(include_str!("data/eye_pupil.csv"));
    assert_eq!(all.len(), 288);
    for row in all {
        let at = |column: usize| row[column].expect("a number");
        let (luminance, area, age) = (at(0), at(1), at(2));
        let eyes = if at(3) == 1.0 { Eyes::One } else { Eyes::Both };
        let diameter = pupil_watson_yellott_mm(luminance, area, age, eyes);
        let name = format!("{luminance} cd/m², {area} deg², {age} years, {eyes:?}");
        assert_near(&name, diameter, row[4]);
        assert_near(&name, pupil_stanley_davies_mm(luminance, area), row[5]);
        assert_near(&name, pupil_barten_mm(luminance, area), row[6]);
        assert_near(&name, std::f64::consts::FRAC_PI_4 * diameter * diameter, row[7]);
        assert_near(&name, trolands(luminance, diameter), row[8]);
    }
    // The check of `design/eye.md`.
    assert!((pupil_watson_yellott_mm(1.0, 900.0, 45.0, Eyes::Both) - 5.2401).abs() < 5e-5);
}

#[test]
fn glare() {
    let all = rows(include_str!("data/eye_glare.csv"));
    assert_eq!(all.len(), 72);
    let (mut small, mut holladay) = (0, 0);
    for row in all {
        let at = |column: usize| row[column].expect("a number");
        let (theta, age, pigment) = (at(0), at(1), at(2));
        let name = format!("{theta}°, {age} years, p = {pigment}");
        assert_near(&name, glare_general(theta, age, pigment), row[3]);
        if row[4].is_some() {
            assert_near(&name, glare_small_angle(theta, age), row[4]);
            small += 1;
        }
        if row[5].is_some() {
            assert_near(&name, glare_stiles_holladay(theta, age), row[5]);
            holladay += 1;
        }
        assert_near(&name, glare_spread(theta, age, pigment), row[6]);
    }
    assert!(small > 40 && holladay > 20, "{small} {holladay}");
}

#[test]
fn glare_of_scenes() {
    let table: serde_json::Value =
        serde_json::from_str(include_str!("data/eye_glare_scenes.json")).expect("the table is JSON");
    let number = |value: &serde_json::Value| value.as_f64().expect("a number");
    for scene in table["scenes"].as_array().expect("scenes") {
        let sources: Vec<(f64, f64)> = scene["sources"]
            .as_array()
            .expect("sources")
            .iter()
            .map(|source| (number(&source["E_lx"]), number(&source["theta_deg"])))
            .collect();
        let veil = veil(&sources, number(&scene["age"]), number(&scene["p"]));
        assert_near("veiling luminance", veil, scene["Lveil_general"].as_f64());
        let background = number(&scene["L_background"]);
        assert_near("contrast", background / (background + veil), scene["contrast_factor"].as_f64());
    }
    // ∫ over the sphere by the midpoint rule in the logarithm of the angle.
    for (key, want) in table["psf_sphere_integral"].as_object().expect("integrals") {
        let (age, pigment) = key.trim_start_matches('A').split_once("_p").expect("AGE_pP");
        let (age, pigment): (f64, f64) = (age.parse().expect("an age"), pigment.parse().expect("a pigment"));
        let (low, high, steps) = (1e-6f64.ln(), 180f64.ln(), 200_000);
        let width = (high - low) / f64::from(steps);
        let sum: f64 = (0..steps)
            .map(|k| {
                let theta = (low + (f64::from(k) + 0.5) * width).exp();
                let solid = std::f64::consts::TAU * theta.to_radians().sin() * theta.to_radians() * width;
                glare_spread(theta, age, pigment) * solid
            })
            .sum();
        assert!((sum - number(want)).abs() < 1e-6, "{key}: {sum}, want {want}");
    }
}
