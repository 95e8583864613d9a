//! The glass catalogue against refractiveindex (oracle set 03_dispersion), the lens systems of 04_lens and the two HUDs.

use eyebox::scene::glass;

/// Checks every row whose material is in the catalogue; returns how many rows there were per material.
fn compare(text: &str, tolerance: f64, name_of: impl Fn(&str) -> Option<String>) -> (usize, f64) {
    let (mut count, mut worst) = (0, 0.0f64);
    for line in text.lines().filter(|line| !line.starts_with('#')).skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let Some(name) = name_of(cells[0]) else { continue };
        let row = glass::find(&name).unwrap_or_else(|| panic!("{name} is not in the catalogue"));
        let got = row.dispersion.index(cells[1].parse().expect("wavelength"));
        let error = (got.re - cells[2].parse::<f64>().expect("n")).abs();
        assert!(error <= tolerance && got.im == 0.0, "{line}: {got:?}, off by {error:e}");
        worst = worst.max(error);
        count += 1;
    }
    (count, worst)
}

#[test]
fn index_over_the_visible() {
    let rows = include_str!("data/dispersion_index.csv");
    let (count, worst) = compare(rows, 1e-10, |name| match name {
        "PMMA_Sultanova" => Some("PMMA".into()),
        // Laws the catalogue does not hold: four Sellmeier terms, a power series, and air (which counts as 1).
        "water_20C" | "PMMA_Beadie" | "air_Ciddor" => None,
        name => Some(name.into()),
    });
    assert_eq!(count, 7 * 31);
    println!("worst {worst:e}");
}

/// Holds SF5, N-SK16 and F2, too. The table is rounded to 12 digits.
#[test]
fn index_in_the_lens_systems() {
    let (count, worst) = compare(include_str!("data/dispersion_lens.csv"), 1e-10, |name| Some(name.into()));
    assert_eq!(count, 19);
    println!("worst {worst:e}");
}

/// To one unit in the last place.
#[test]
fn design_index_of_the_two_huds() {
    let rows = include_str!("data/dispersion_prescription.csv");
    assert_eq!(compare(rows, f64::EPSILON, |name| Some(name.into())).0, 4);
}
