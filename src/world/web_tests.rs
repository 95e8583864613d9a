use super::*;
use eyebox_base::rng::{Rng, Stream};
use eyebox_import::photometric;
use std::path::Path;

const GOOD: [&str; 12] = [
    "absolute_2019.ies",
    "axial_2002.ies",
    "bilateral_0_180.ies",
    "bilateral_90_270_1991.ies",
    "full_0_360_irregular.ies",
    "isym0.ldt",
    "isym1.ldt",
    "isym2_absolute.ldt",
    "isym3.ldt",
    "isym4.ldt",
    "quadrant_1995_mult.ies",
    "tilt_include_1986.ies",
];

fn read(name: &str) -> LuminousProfile {
    let file = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("tests/data/07_ies/good").join(name);
    photometric::profile(&file, &eyebox_base::Where::Nowhere, &mut Vec::new()).unwrap()
}

/// chi² of a million samples of each file over 36 × 18 cells that do not follow its grid; expected numbers from a sum of
/// the intensity over 40 × 40 points of each cell. The Wilson–Hilferty z of all twelve, Šidák-corrected: 3.9 is one in
/// twenty thousand.
#[test]
fn samples_follow_the_bilinear_intensity() {
    const COUNT: usize = 1_000_000;
    const FINE: usize = 40;
    let (planes, rings) = (36, 18);
    for (number, name) in GOOD.iter().enumerate() {
        let web = Web::new(read(name)).unwrap();
        let mut want = vec![0.0; planes * rings];
        let (dc, dg) = (std::f64::consts::TAU / planes as f64, std::f64::consts::PI / rings as f64);
        for (cell, want) in want.iter_mut().enumerate() {
            for k in 0..FINE * FINE {
                let at = |index: usize, step: usize| index as f64 + (step as f64 + 0.5) / FINE as f64;
                let (c, gamma) = (dc * at(cell % planes, k % FINE), dg * at(cell / planes, k / FINE));
                let dir = web.profile.direction(c, gamma);
                *want += web.intensity(dir) * gamma.sin() * dc * dg / (FINE * FINE) as f64 / web.flux_lm();
            }
        }
        let whole: f64 = want.iter().sum();
        assert!((whole - 1.0).abs() < 1e-4, "{name}: {whole}");
        let mut seen = vec![0.0; planes * rings];
        let mut rng = Rng::new(7, Stream::Check, 0, number as u64);
        for _ in 0..COUNT {
            let dir = web.sample(rng.pair());
            assert!(web.intensity(dir) >= 0.0 && (dir.length() - 1.0).abs() < 1e-12);
            let (c, gamma) = web.profile.angles(dir);
            let (i, j) = ((c.rem_euclid(std::f64::consts::TAU) / dc) as usize, (gamma / dg) as usize);
            seen[j.min(rings - 1) * planes + i.min(planes - 1)] += 1.0;
        }
        let (mut chi2, mut cells, mut few) = (0.0, 0.0, [0.0, 0.0]);
        for (n, p) in seen.iter().zip(&want) {
            let e = p / whole * COUNT as f64;
            if e >= 20.0 {
                chi2 += (n - e) * (n - e) / e;
                cells += 1.0;
            } else {
                few[0] += n;
                few[1] += e;
            }
        }
        if few[1] >= 20.0 {
            chi2 += (few[0] - few[1]).powi(2) / few[1];
            cells += 1.0;
        } else {
            assert!(few[0] <= few[1] + 8.0 * few[1].sqrt() + 8.0, "{name}: {few:?} where there is little light");
        }
        let k: f64 = cells - 1.0;
        let z = ((chi2 / k).cbrt() - (1.0 - 2.0 / (9.0 * k))) / (2.0 / (9.0 * k)).sqrt();
        assert!(z < 3.9, "{name}: chi² {chi2} of {k}, z {z}");
    }
}

/// The sampler's sums are the closed form of the flux, and its inverse is exact: the share of flux below the γ of u is u.
#[test]
fn sums_and_inverses_are_exact() {
    for name in GOOD {
        let profile = read(name);
        let web = Web::new(profile.clone()).unwrap();
        assert!((web.flux_lm() / profile.flux_lm() - 1.0).abs() < 1e-13, "{name}");
        for step in 0..=1000 {
            let u = f64::from(step) / 1000.0 * (1.0 - f64::EPSILON);
            let (_, gamma) = profile.angles(web.sample([u, 0.37]));
            let mut below = 0.0;
            for (g, r) in profile.gamma_rad.windows(2).zip(web.rings.windows(2)) {
                if gamma >= g[1] {
                    below += band(g[0], g[1], r[0], r[1]);
                } else if gamma > g[0] {
                    below += band(g[0], gamma, r[0], r[0] + (r[1] - r[0]) * (gamma - g[0]) / (g[1] - g[0]));
                }
            }
            assert!((below / web.flux_lm() - u).abs() < 1e-12, "{name} {u}: {}", below / web.flux_lm());
        }
    }
}

/// A dark plane beside a bright one, a dark ring, rings and planes close together.
#[test]
fn edges_of_grids_are_sampled() {
    let profile = LuminousProfile {
        file: "edge".into(),
        axes: LuminousProfile::TYPE_B,
        c_rad: vec![-1.0, -1.0 + 1e-12, 0.0, 1.0],
        gamma_rad: vec![0.5, 0.5 + 1e-13, 1.0, 2.0],
        candela: vec![0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 5.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1e-300, 0.0, 1e6],
        facts: Default::default(),
    };
    let web = Web::new(profile).unwrap();
    let mut rng = Rng::new(8, Stream::Check, 0, 0);
    let ends = [0.0, 1.0 - f64::EPSILON / 2.0];
    let all = (0..20_000).map(|_| rng.pair()).chain(ends.into_iter().flat_map(|a| ends.map(|b| [a, b])));
    for uv in all.collect::<Vec<_>>() {
        let dir = web.sample(uv);
        assert!(dir.is_finite(), "{uv:?}");
        let (c, gamma) = web.profile.angles(dir);
        assert!((-1.0 - 1e-9..=1.0 + 1e-9).contains(&c) && (0.5 - 1e-9..=2.0 + 1e-9).contains(&gamma), "{c} {gamma}");
    }
    let mut dark = web.profile.clone();
    dark.candela.fill(0.0);
    assert!(Web::new(dark).is_none());
}
