//! Against the oracle (tests/data/colour/spectra_results.json, patches_*.csv) and closed forms.

use super::*;
use eyebox_base::colour::{BRADFORD_D65_TO_ACES, ColourSpace, XYZ_TO_AP1, xyz};

fn near(got: f64, want: f64, tolerance: f64, what: &str) {
    assert!((got - want).abs() <= tolerance * want.abs().max(1.0), "{what}: {got} for {want}");
}

/// The spectra of the oracle's list that are ours, and those that it defines by a formula.
fn of(id: &str) -> Grid {
    let gauss = |peaks: &[(f64, f64, f64)]| {
        grid(|nm| {
            let bell = |&(at, fwhm, a): &(f64, f64, f64)| a * (-4.0 * 2f64.ln() * ((nm - at) / fwhm).powi(2)).exp();
            peaks.iter().map(bell).sum()
        })
    };
    let named = |spectrum: Spectrum| *spectrum.resolve().unwrap().values();
    let black = |kelvin| grid(|nm| planck(kelvin, 1.438776877e7, nm));
    match id {
        "A" => named(Spectrum::A),
        "D65" => named(Spectrum::D65),
        "E" => named(Spectrum::Equal),
        "BB2700" => named(Spectrum::Cct(2700.0)),
        "BB4000" => black(4000.0),
        "BB6500" => black(6500.0),
        "LED-B3" => named(Spectrum::Led(Led::B3)),
        "G450" => gauss(&[(450.0, 20.0, 1.0)]),
        "G525" => gauss(&[(525.0, 35.0, 1.0)]),
        "G625" => gauss(&[(625.0, 18.0, 1.0)]),
        "PCLED" => gauss(&[(450.0, 20.0, 1.0), (560.0, 110.0, 0.6)]),
        "MONO555" => named(Spectrum::Table(vec![(555.0, 1.0)])),
        "MONO633" => named(Spectrum::Table(vec![(633.0, 1.0)])),
        other => panic!("a spectrum that this test doesn't know: {other}"),
    }
}

#[test]
fn spectra_have_the_oracles_colours() {
    let json = include_str!("../../../tests/data/colour/spectra_results.json");
    let oracle: serde_json::Value = serde_json::from_str(json).unwrap();
    let spectra = oracle["spectra"].as_array().unwrap();
    assert_eq!(spectra.len(), 13);
    for want in spectra {
        let id = want["id"].as_str().unwrap();
        let power = PowerDistribution::new(of(id)).unwrap();
        let number = |value: &serde_json::Value| value.as_f64().unwrap();
        near(power.lumens_per_watt(), number(&want["LER_lm_per_W_360_830"]), 1e-6, id);
        let [x, y] = power.xy();
        near(x, number(&want["x"]), 1e-6, id);
        near(y, number(&want["y"]), 1e-6, id);
        let xyz = power.xyz_per_lumen();
        let triples = [
            ("XYZ_norm", xyz),
            ("XYZ_per_watt", xyz.map(|x| x * power.lumens_per_watt())),
            ("RGB709_linear_Y1", power.rec709_per_lumen()),
            ("ACEScg_Y1_no_adaptation", apply(&XYZ_TO_AP1, xyz)),
            ("ACEScg_Y1_bradford_from_D65", apply(&XYZ_TO_AP1, apply(&BRADFORD_D65_TO_ACES, xyz))),
            ("ACEScg_Y1_bradford_from_D65", ColourSpace::AcesCg.from_xyz(xyz)),
        ];
        for (name, got) in triples {
            for (got, want) in got.into_iter().zip(want[name].as_array().unwrap()) {
                near(got, number(want), 1e-6, &format!("{id} {name}"));
            }
        }
        let normalised = power.luminous_normalised();
        near(colour::xyz(normalised.values())[1], 1.0, 1e-14, id);
        near(normalised.lumens(), 1.0, 1e-14, id);
        near(normalised.lumens_per_watt(), power.lumens_per_watt(), 1e-14, id);
    }
}

#[test]
fn reflectances_have_the_oracles_colours() {
    let lines = |text: &'static str| text.lines().filter(|line| !line.starts_with('#')).skip(1);
    let mut count = 0;
    for line in lines(include_str!("../../../tests/data/colour/patches_xyz.csv")) {
        let fields: Vec<&str> = line.split(',').collect();
        let [patch, illuminant, want @ ..] = fields.as_slice() else { panic!("{line}") };
        let rows: Vec<(f64, f64)> = lines(include_str!("../../../tests/data/colour/patches_reflectance.csv"))
            .filter_map(|line| line.strip_prefix(patch)?.strip_prefix(','))
            .map(|line| line.split_once(',').unwrap())
            .map(|(nm, rho)| (nm.parse().unwrap(), rho.parse().unwrap()))
            .collect();
        // The oracle holds reflectances constant outside of their table.
        let reflectance = |nm: f64| lookup(&colour::tabulated(&rows), nm.clamp(rows[0].0, rows[rows.len() - 1].0));
        let light = of(illuminant);
        let mut i = 0;
        let lit = grid(|nm| {
            i += 1;
            light[i - 1] * reflectance(nm)
        });
        let white = xyz(&light)[1];
        for (got, want) in xyz(&lit).into_iter().zip(want) {
            near(got / white, want.parse().unwrap(), 1e-6, line);
            count += 1;
        }
    }
    assert_eq!(count, 54);
}

#[test]
fn leds_have_the_temperatures_of_their_names() {
    // CIE 015:2018, table 12.1: correlated colour temperatures; McCamy's formula is good to some 10 K here.
    for (led, kelvin) in [
        (Led::B1, 2733.0),
        (Led::B2, 2998.0),
        (Led::B3, 4103.0),
        (Led::B4, 5109.0),
        (Led::B5, 6598.0),
        (Led::Bh1, 2851.0),
        (Led::Rgb1, 2840.0),
        (Led::V1, 2724.0),
        (Led::V2, 4070.0),
    ] {
        let [x, y] = Spectrum::Led(led).resolve().unwrap().xy();
        let n = (x - 0.3320) / (0.1858 - y);
        let mccamy = 449.0 * n.powi(3) + 3525.0 * n * n + 6823.3 * n + 5520.33;
        assert!((mccamy / kelvin - 1.0).abs() < 0.01, "{led:?}: {mccamy}");
        assert_eq!(Led::from_name(led.name()), Some(led));
    }
}

#[test]
fn daylight_of_6504_k_is_d65_and_has_the_chromaticity_of_its_formula() {
    // D65's own table was made with rounded factors: 0.05 % is what rounding leaves.
    let (daylight, d65) = (Spectrum::Cct(6500.0 * 1.4388 / 1.4380), Spectrum::D65.resolve().unwrap());
    let daylight = daylight.resolve().unwrap();
    for nm in 360..=780 {
        let nm = f64::from(nm);
        near(daylight.at(nm) / d65.at(nm), 1.0, 1e-3, &format!("{nm} nm"));
    }
    for kelvin in [4000.0, 5000.0, 7000.0, 10_000.0, 25_000.0] {
        let t: f64 = 1000.0 / kelvin;
        let want = if kelvin <= 7000.0 {
            0.244063 + 0.09911 * t + 2.9678 * t.powi(2) - 4.6070 * t.powi(3)
        } else {
            0.237040 + 0.24748 * t + 1.9018 * t.powi(2) - 2.0064 * t.powi(3)
        };
        let [x, y] = Spectrum::Cct(kelvin).resolve().unwrap().xy();
        near(x, want, 2e-4, "x");
        near(y, -3.0 * want * want + 2.870 * want - 0.275, 2e-4, "y");
    }
    // The step that the documentation states.
    let uv = |[x, y, z]: Xyz| [4.0 * x / (x + 15.0 * y + 3.0 * z), 9.0 * y / (x + 15.0 * y + 3.0 * z)];
    let [a, b] =
        [4000.0, 4000f64.next_down()].map(|kelvin| uv(Spectrum::Cct(kelvin).resolve().unwrap().xyz_per_lumen()));
    near((a[0] - b[0]).hypot(a[1] - b[1]), 0.0036, 1e-4, "step at 4000 K");
}

#[test]
fn narrow_lines_keep_their_power_and_place() {
    // A line alone, a line of rows closer than a nanometre, and one that falls between the nanometres.
    let lines = [
        Spectrum::Table(vec![(632.8, 5.0)]),
        Spectrum::Table(vec![(632.7, 0.0), (632.8, 3.0), (632.9, 0.0)]),
        Spectrum::Table(vec![(632.75, 1.0), (632.85, 1.0)]),
    ];
    let v = |nm: f64| eyebox_base::colour::cmf(nm)[1];
    for line in lines {
        let power = line.resolve().unwrap();
        near(power.lumens_per_watt(), 683.0 * v(632.8), 1e-4, "line");
        let mean: f64 =
            colour::nanometres().map(|nm| nm * power.at(nm)).sum::<f64>() / power.values().iter().sum::<f64>();
        near(mean, 632.8, 1e-9, "place");
    }
    // Wide rows are the oracle's: linear between, 0 outside.
    let wide = Spectrum::Table(vec![(500.0, 2.0), (510.0, 4.0)]).resolve().unwrap();
    assert_eq!([499.0, 500.0, 505.0, 510.0, 511.0].map(|nm| wide.at(nm)), [0.0, 0.5, 0.75, 1.0, 0.0]);
}

#[test]
fn colours_are_kept_and_problems_are_named() {
    for rgb in [[1.0, 1.0, 1.0], [0.2, 0.5, 0.0], [1e300, 0.0, 0.0], [0.0, 1e-300, 1e-300]] {
        let power = Spectrum::Rgb(rgb).resolve().unwrap();
        let weights = ColourSpace::Rec709.luminance(rgb.map(|c| c / rgb.iter().sum::<f64>()));
        for (got, c) in power.rec709_per_lumen().into_iter().zip(rgb) {
            near(got, c / rgb.iter().sum::<f64>() / weights, 1e-9, "rgb");
        }
    }
    for (bad, word) in [
        (Spectrum::Rgb([0.0; 3]), "black"),
        (Spectrum::Rgb([1.0, -0.1, 0.0]), "below 0"),
        (Spectrum::Rgb([f64::NAN, 0.0, 0.0]), "below 0"),
        (Spectrum::Cct(999.0), "1000 to 25000"),
        (Spectrum::Cct(f64::NAN), "1000 to 25000"),
        (Spectrum::Table(vec![]), "no visible light"),
        (Spectrum::Table(vec![(900.0, 1.0)]), "no visible light"),
        (Spectrum::Table(vec![(500.0, 0.0), (600.0, 0.0)]), "power"),
        (Spectrum::Table(vec![(900.0, 1.0), (1000.0, 1.0)]), "no visible light"),
        (Spectrum::Table(vec![(500.0, 1.0), (500.0, 1.0)]), "do not rise"),
        (Spectrum::Table(vec![(500.0, -1.0)]), "row 0"),
        (Spectrum::Table(vec![(f64::NAN, 1.0), (500.0, 1.0)]), "row 0"),
    ] {
        assert!(bad.problem().is_some_and(|problem| problem.contains(word)), "{bad:?}: {:?}", bad.problem());
    }
    // The greatest numbers overflow nothing.
    for power in [f64::MAX, f64::MIN_POSITIVE] {
        let rows = vec![(400.0, power), (700.0, power)];
        assert!(Spectrum::Table(rows).resolve().unwrap().lumens_per_watt() > 100.0);
    }
    for spectrum in
        [Spectrum::D65, Spectrum::Cct(3000.0), Spectrum::Led(Led::Rgb1), Spectrum::Table(vec![(500.0, 1.0)])]
    {
        let text = serde_json::to_string(&spectrum).unwrap();
        assert_eq!(serde_json::from_str::<Spectrum>(&text).unwrap(), spectrum, "{text}");
    }
}
