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
    let (count, worst) = compare(rows, 1e-10, |name| Some(name.into()));
    assert_eq!(count, 10 * 31);
    println!("worst {worst:e}");
}

/// The last column says whether the row is within the range that the source gives.
#[test]
fn valid_ranges() {
    let mut outside = 0;
    for line in include_str!("data/dispersion_index.csv").lines().filter(|line| !line.starts_with('#')).skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let glass = glass::find(cells[0]).expect("a glass of the catalogue");
        let nm: f64 = cells[1].parse().expect("wavelength");
        assert_eq!(glass.beyond([nm; 2]).is_none(), cells[3] == "1", "{line}");
        outside += usize::from(cells[3] == "0");
    }
    assert!(outside > 0);
}

/// The metals of the thin-film stacks, which the oracle rounds to 10 digits.
#[test]
fn metals_of_the_stacks() {
    let oracle: serde_json::Value = serde_json::from_str(include_str!("data/stacks.json")).expect("stacks.json");
    for name in ["Al", "Cr"] {
        let law = &glass::find(name).expect("a metal of the catalogue").dispersion;
        for (i, nm) in oracle["wavelengths_nm"].as_array().expect("wavelengths").iter().enumerate() {
            let got = law.index(nm.as_f64().expect("nm"));
            let want = |key: &str| oracle["materials"][name][key][i].as_f64().expect("n, k");
            assert!((got.re - want("n")).abs() < 1e-9 && (got.im - want("k")).abs() < 1e-9, "{name} {nm}: {got:?}");
        }
    }
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

/// Entries of the database at random, all nine formulas among them. A table has lost rows (`make_database.py` says which): its
/// n + ik is within 1e-4 of its size over the visible, and within 1e-3 beyond, up to the last digit of what is written.
#[test]
fn entries_of_the_database() {
    let (mut kinds, mut worst) = ([0; 10], [0.0f64; 3]);
    for line in include_str!("data/database_index.csv").lines().filter(|line| !line.starts_with('#')).skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let glass = glass::find(cells[0]).unwrap_or_else(|| panic!("{} is not in the database", cells[0]));
        let [nm, n, k] = [1, 2, 3].map(|i| cells[i].parse::<f64>().expect("a number"));
        let kind: usize = cells[4].parse().expect("a number");
        let got = glass.dispersion.index(nm);
        let off = (got.re - n).abs();
        if kind == 0 {
            let share = (got.re - n).hypot(got.im - k) / n.hypot(k);
            let seen = (360.0..=830.0).contains(&nm);
            worst[if seen { 1 } else { 2 }] = worst[if seen { 1 } else { 2 }].max(share);
            assert!(share < if seen { 1.5e-4 } else { 1.5e-3 }, "{line}: {got:?}");
        } else {
            worst[0] = worst[0].max(off);
            assert!(off < 1e-12 * n.max(1.0), "{line}: {got:?}");
            assert!((got.im - k).abs() <= 2e-3 * k.max(1e-6), "{line}: {got:?}");
        }
        kinds[kind] += 1;
    }
    assert!(kinds.iter().all(|count| *count > 0), "{kinds:?}");
    println!("worst {worst:?}, {kinds:?}");
}

/// n_d and V_d that the makers' own spreadsheets give: they print five digits of n_d, and glasses are sold to 0.01 of V_d.
#[test]
fn glasses_of_six_makers() {
    let mut count = 0;
    for line in include_str!("data/database_makers.csv").lines().filter(|line| !line.starts_with('#')).skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let glass = glass::find(cells[0]).unwrap_or_else(|| panic!("{} is not in the database", cells[0]));
        let (n, v) = (glass.index_d().expect("n_d").re, glass.abbe().expect("V_d"));
        assert!((n - cells[1].parse::<f64>().expect("n_d")).abs() < 1e-5, "{line}: {n}");
        assert!((v - cells[2].parse::<f64>().expect("V_d")).abs() < 1e-2, "{line}: {v}");
        count += 1;
    }
    assert_eq!(count, 24);
}
