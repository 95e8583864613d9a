//! The files of `tests/data/07_ies` with the numbers of its generator: flux, peak and probes of good ones, the fate of
//! bad ones; types A and B against closed forms; and whatever bytes.

use super::*;
use proptest::prelude::*;
use serde_json::Value as Json;
use std::f64::consts::{FRAC_PI_2, TAU};

fn folder() -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("tests/data/07_ies")
}

fn table(name: &str) -> Vec<Json> {
    let text = std::fs::read_to_string(folder().join(name)).unwrap();
    let json: Json = serde_json::from_str(&text).unwrap();
    json["files"].as_array().unwrap().clone()
}

fn read(name: &str) -> Result<LuminousProfile> {
    profile(&folder().join(name), &Where::Nowhere, &mut Vec::new())
}

fn agrees(profile: &LuminousProfile, want: &Json) {
    let near = |what: &str, got: f64, want: &Json| {
        let want = want.as_f64().unwrap();
        assert!((got - want).abs() <= 1e-6 * want.abs().max(1e-9), "{}: {what} is {got}, not {want}", profile.file);
    };
    near("flux", profile.flux_lm(), &want["flux_lm_bilinear_exact"]);
    near("peak", profile.peak_cd(), &want["max_candela"]);
    near("scale", profile.facts.scale, &want["candela_scale"]);
    near("mean", profile.flux_lm() / (2.0 * TAU), &want["mean_spherical_candela"]);
    for probe in want["probes"].as_array().unwrap() {
        let (theta, phi) = (probe["theta"].as_f64().unwrap().to_radians(), probe["phi"].as_f64().unwrap().to_radians());
        near("a probe", profile.value(phi, theta), &probe["candela"]);
    }
}

#[test]
fn good_files_have_the_flux_peak_and_probes_of_the_oracle() {
    let mut seen = 0;
    for want in table("expected_good.json") {
        let name = want["file"].as_str().unwrap();
        let profile = read(name).unwrap_or_else(|fault| panic!("{fault}"));
        agrees(&profile, &want);
        let absolute = want["absolute_photometry"].as_bool().unwrap_or(want["number_of_lamps_field"] == -1);
        assert_eq!(profile.facts.absolute, absolute, "{name}");
        let lumens = want.get("declared_lamp_lumens").unwrap_or(&want["total_lamp_flux"]);
        assert_eq!(profile.facts.lamp_lumens, lumens.as_f64(), "{name}");
        seen += 1;
    }
    assert_eq!(seen, 12);
}

/// Spellings met in public bug reports, with the flux of `tests/data/ies_quirks/README`.
#[test]
fn files_as_the_wild_has_them_have_their_flux() {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("tests/data/ies_quirks");
    let table = std::fs::read_to_string(folder.join("README")).unwrap();
    let mut seen = 0;
    for (name, rest) in table.lines().filter_map(|line| line.split_once(": ")) {
        let want = rest.split_once("-> flux ").unwrap().1.strip_suffix(" lm").unwrap();
        let mut notes = Vec::new();
        let read = profile(&folder.join(name), &Where::Nowhere, &mut notes);
        match want.parse::<f64>() {
            // The table has two digits.
            Ok(want) => {
                let flux = read.unwrap_or_else(|fault| panic!("{name}: {fault}")).flux_lm();
                assert!((flux - want).abs() < 0.006, "{name}: {flux}, not {want}");
            }
            Err(_) => assert!(read.is_err(), "{name} was read"),
        }
        seen += 1;
    }
    assert_eq!(seen, 23);
}

#[test]
fn headers_name_their_edition_or_a_note_says_which_is_taken() {
    let read = |header: &str| {
        let text = format!("{header}\nTILT=NONE\n1 1000 1 3 1 1 2 0 0 0\n1 0.5 10\n0 45 90\n0\n100 50 0\n");
        let mut notes = Vec::new();
        let read = parse(Path::new("a.ies"), text.as_bytes(), &small, &mut notes).unwrap();
        (read.facts.format, read.facts.scale, notes.iter().map(|note| note.text.clone()).collect::<Vec<_>>().join("; "))
    };
    for (header, year, scale) in [
        ("IESNA86", "1986", 0.5),
        ("iesna91", "1991", 0.5),
        ("IESNA:LM-63-1995", "1995", 1.0),
        ("  IESNA : LM - 63 - 2002", "2002", 1.0),
        ("\n\nIES LM-63-2002", "2002", 1.0),
        ("ANSI/IES LM-63-19", "2019", 1.0),
    ] {
        assert_eq!(read(header), (format!("IES LM-63-{year}"), scale, String::new()), "{header}");
    }
    for (header, year, scale) in
        [("IESNA:LM-63-2008", "2002", 1.0), ("IES:LM-63", "2019", 1.0), ("IESNA90", "1986", 0.5)]
    {
        let (format, own, notes) = read(header);
        assert_eq!((format, own), (format!("IES LM-63-{year}"), scale), "{header}");
        assert!(notes.ends_with(&format!("names no edition that is known: read as LM-63-{year}")), "{notes}");
    }
    let (format, scale, notes) = read("IES test report 7");
    assert_eq!((format.as_str(), scale), ("IES LM-63-1986", 0.5));
    assert_eq!(notes, "no edition is named: read as LM-63-1986, in which the ballast-lamp factor 0.5 counts");
}

#[test]
fn bad_files_are_refused_by_their_line() {
    let good = table("expected_good.json");
    let mut seen = 0;
    for row in table("expected_bad.json") {
        let name = row["file"].as_str().unwrap();
        let read = read(name);
        match row["expect"].as_str().unwrap() {
            "accept" => {
                let twin = good.iter().find(|good| good["file"] == row["same_values_as"]).unwrap();
                agrees(&read.unwrap_or_else(|fault| panic!("{fault}")), twin);
            }
            "reject" | "reject_or_warn" => {
                let fault = read.map(|_| panic!("{name} was read")).unwrap_err();
                let Where::Line { file, line } = &fault.at else { panic!("{name}: {fault}") };
                assert!(file.ends_with(name) && *line >= 1 && !fault.to_string().contains('\n'), "{fault}");
            }
            other => panic!("{other}"),
        }
        seen += 1;
    }
    assert_eq!(seen, 16);
}

/// A file of type A or B with I = 100 (1 + V/180 + H/360), which is not symmetric.
fn tilted(kind: u32, mirrored: bool) -> LuminousProfile {
    let angles: Vec<i32> =
        if mirrored { (0..=9).map(|k| 10 * k).collect() } else { (-9..=9).map(|k| 10 * k).collect() };
    let list = angles.iter().map(i32::to_string).collect::<Vec<_>>().join(" ");
    let value = |h: i32, v: i32| 100.0 * (1.0 + f64::from(v) / 180.0 + f64::from(h) / 360.0);
    let rows: Vec<String> =
        angles.iter().map(|h| angles.iter().map(|v| value(*h, *v).to_string()).collect::<Vec<_>>().join(" ")).collect();
    let n = angles.len();
    let text = format!(
        "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 {n} {n} {kind} 2 0 0 0\n1 1 5\n{list}\n{list}\n{}\n",
        rows.join("\n")
    );
    parse(Path::new("a.ies"), text.as_bytes(), &small, &mut Vec::new()).unwrap()
}

/// Type A: longitude H about a vertical pole; type B: longitude V about a horizontal one. Where one angle is 0 they agree.
#[test]
fn types_a_and_b_keep_their_poles() {
    use glam::DVec3;
    for (kind, letter) in [(3, "A"), (2, "B")] {
        let profile = tilted(kind, false);
        assert_eq!(profile.facts.photometric_type, letter);
        for (h, v) in [(0.0f64, 0.0f64), (20.0, 0.0), (0.0, 35.0), (-40.0, 25.0), (12.5, -61.0)] {
            let ((sh, ch), (sv, cv)) = (h.to_radians().sin_cos(), v.to_radians().sin_cos());
            let dir = if kind == 3 { DVec3::new(cv * sh, sv, -cv * ch) } else { DVec3::new(sh, ch * sv, -ch * cv) };
            let want = 100.0 * (1.0 + v / 180.0 + h / 360.0);
            assert!((profile.along(dir) - want).abs() < 1e-9, "type {letter} at ({h}, {v}): {}", profile.along(dir));
        }
        assert_eq!(profile.along(DVec3::new(0.1, 0.2, 1.0).normalize()), 0.0);
        // ∫ over a half space of a mean of 100, its slopes cancelling.
        assert!((profile.flux_lm() - 100.0 * TAU).abs() < 1e-9);
        let mirrored = tilted(kind, true);
        let (a, b) = (
            mirrored.along(DVec3::new(0.3, 0.2, -0.8).normalize()),
            mirrored.along(DVec3::new(-0.3, -0.2, -0.8).normalize()),
        );
        assert!((a - b).abs() < 1e-9 && a > 100.0);
    }
}

#[test]
fn a_tilt_file_and_a_turn_that_is_not_closed() {
    let text = |tilt: &str, last: &str| {
        format!(
            "IESNA:LM-63-1995\n[TEST] x\n[MORE] y\nTILT={tilt}\n1 100 1 2 4 1 1 1 2 0\n1 1 5\n0 90\n0 90 180 {last}\n8 0 8 0 8 0 8 0"
        )
    };
    let tilt = |_: &Path, _: &Where| Ok(b"1\n2\n0 90\n0.5 1\n".to_vec());
    let mut notes = Vec::new();
    let read = parse(Path::new("a/b.ies"), text("x.tlt", "270").as_bytes(), &tilt, &mut notes).unwrap();
    assert_eq!((read.facts.scale, read.value(5.5, 0.0), notes.len()), (0.5, 4.0, 1));
    assert!((read.facts.opening_m[1] - 0.6096).abs() < 1e-12);
    assert_eq!(read.facts.keywords, [("TEST".to_owned(), "x\ny".to_owned())]);
    let fault = parse(Path::new("a/b.ies"), text("NONE", "200").as_bytes(), &tilt, &mut notes).unwrap_err();
    assert!(fault.to_string().starts_with("a/b.ies:8: the horizontal angles run from 0 to 200"), "{fault}");
    assert!((read.value(0.1, FRAC_PI_2)).abs() < 1e-12);
}

fn any_file() -> impl Strategy<Value = (String, Vec<u8>)> {
    let token = prop_oneof![
        "[0-9]{1,3}",
        "-?[0-9]{1,4}\\.[0-9]{0,3}",
        Just("TILT=NONE\n1 100 1 3 2 1 2 0 0 0 1 1 1\n".to_owned()),
        Just("TILT=INCLUDE\n".to_owned()),
        Just("1e308".to_owned()),
        Just("nan".to_owned()),
        Just("999999999999".to_owned()),
        Just("0 45 90\n0 360\n1 1 1 1 1 1".to_owned()),
        Just("\r".to_owned()),
        Just("\n".to_owned()),
        Just("\u{1a}".to_owned()),
        Just("IESNA91\n".to_owned()),
        Just("TILT=/dev/zero\n".to_owned()),
        Just("é".to_owned()),
    ];
    let tokens = proptest::collection::vec(token, 0..60).prop_map(|all| all.join(" ").into_bytes());
    let bytes = prop_oneof![tokens, proptest::collection::vec(any::<u8>(), 0..400)];
    (prop_oneof![Just("x.ies".to_owned()), Just("x.ldt".to_owned())], bytes)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn any_bytes_end_in_a_profile_or_a_line((name, bytes) in any_file()) {
        match parse(Path::new(&name), &bytes, &small, &mut Vec::new()) {
            Ok(profile) => prop_assert!(profile.flux_lm() > 0.0 && profile.candela.len() <= 4 * bytes.len()),
            Err(fault) => prop_assert!(matches!(fault.at, Where::Line { .. }), "{}", fault),
        }
    }

    /// Good files cut, and with bytes changed.
    #[test]
    fn damaged_files_end_in_a_profile_or_a_line(which in 0..12usize, cut in 0.0..1.2f64, edits in proptest::collection::vec((0.0..1.0f64, any::<u8>()), 0..4)) {
        let name = table("expected_good.json")[which]["file"].as_str().unwrap().to_owned();
        let mut bytes = std::fs::read(folder().join(&name)).unwrap();
        let whole = bytes.len();
        bytes.truncate((cut * whole as f64) as usize);
        for (place, byte) in edits {
            let place = (place * bytes.len() as f64) as usize;
            if let Some(own) = bytes.get_mut(place) {
                *own = byte;
            }
        }
        if let Ok(profile) = parse(Path::new(&name), &bytes, &small, &mut Vec::new()) {
            prop_assert!(profile.flux_lm() > 0.0 && profile.candela.iter().all(|value| *value >= 0.0 && value.is_finite()));
        }
    }
}

/// Counts beyond the file, and a file of blank lines as large as files may be.
#[test]
fn sizes_bound_memory_and_time() {
    let start = std::time::Instant::now();
    let mut bytes = b"IESNA:LM-63-2002\nTILT=NONE\n1 1 1 8000000 8000000 1 2 0 0 0\n1 1 1\n".to_vec();
    bytes.resize(1 << 25, b'\n');
    assert!(parse(Path::new("x.ies"), &bytes, &small, &mut Vec::new()).is_err());
    assert!(parse(Path::new("x.ldt"), &bytes, &small, &mut Vec::new()).is_err());
    assert!(start.elapsed().as_secs() < 20);
    assert!(profile(Path::new("/dev/zero"), &Where::Nowhere, &mut Vec::new()).is_err());
}
