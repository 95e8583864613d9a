//! What the reader makes of files: good ones of both formats, those that others wrote, and broken ones.

use super::writer::{Ray, Tm25, lambertian, luminous, row, tm25, zemax};
use eyebox::import::ray_file::{RayFile, parse};
use eyebox::scene::Spectrum;
use glam::Vec3;
use proptest::prelude::*;
use std::path::Path;

fn read(bytes: &[u8]) -> RayFile {
    parse(Path::new("led.tm25ray"), bytes).unwrap_or_else(|fault| panic!("{fault}"))
}

fn fault(bytes: &[u8]) -> String {
    let text = parse(Path::new("led.tm25ray"), bytes).expect_err("a broken file").to_string();
    assert!(!text.contains('\n') && text.starts_with("led.tm25ray: "), "{text}");
    text
}

const RAYS: [Ray; 3] = [
    ([1.0, 2.0, 3.0], [0.0, 0.0, 1.0], 1.0),
    ([-1.0, 0.5, 0.0], [0.6, 0.0, 0.8], 2.0),
    ([0.0, 0.0, 0.25], [0.0, -1.0, 0.0], 4.0),
];

#[test]
fn tm25_of_every_kind_of_spectrum() {
    let file = read(&luminous(&RAYS));
    assert_eq!((file.format, file.lumens, file.bundles.len()), ("IES TM-25-13", Some(7.0), 1));
    let own = &file.bundles[0];
    assert_eq!((own.lumens, own.watts, &own.spectrum), (Some(7.0), None, &None));
    assert_eq!(own.rays[1].place_mm, Vec3::new(-1.0, 0.5, 0.0));
    assert!(own.rays[1].dir.abs_diff_eq(Vec3::new(0.6, 0.0, 0.8), 1e-6) && own.rays[1].flux == 2.0);

    let watts = [true, false, false, false, false, false];
    let rows = |rest: &dyn Fn(usize) -> Vec<f32>| -> Vec<Vec<f32>> {
        RAYS.iter().enumerate().map(|(k, ray)| row(ray, &rest(k))).collect()
    };
    let line = Tm25 { spectral: 1, line_nm: 532.0, flags: watts, text: 64, ..Tm25::default() };
    let file = read(&tm25(&line, &rows(&|k| vec![k as f32 + 1.0])));
    assert_eq!((file.lumens, file.bundles[0].watts), (None, Some(6.0)));
    assert_eq!(file.bundles[0].spectrum, Some(Spectrum::Table(vec![(532.0, 1.0)])));

    let spectra = vec![vec![(450.0, 1.0), (460.0, 0.5), (470.0, 0.0)], vec![(600.0, 1.0)]];
    let shared = Tm25 { spectral: 3, spectra: spectra[..1].to_vec(), flags: watts, names: 2, ..Tm25::default() };
    let file = read(&tm25(&shared, &rows(&|_| vec![1.0, 7.0, 8.0])));
    assert_eq!(file.bundles[0].spectrum, Some(Spectrum::Table(vec![(450.0, 1.0), (460.0, 0.5), (470.0, 0.0)])));
    assert!(file.remarks.iter().any(|text| text.contains("further columns")), "{:?}", file.remarks);

    // Of a box from 260 to 460 nm half lies from 360 nm on.
    let half = Tm25 { spectral: 3, spectra: vec![vec![(260.0, 1.0), (460.0, 1.0)]], flags: watts, ..Tm25::default() };
    assert_eq!(read(&tm25(&half, &rows(&|_| vec![1.0]))).bundles[0].watts, Some(1.5));

    let indexed = Tm25 { spectral: 4, spectra, flags: [true, false, false, false, false, true], ..Tm25::default() };
    let file = read(&tm25(&indexed, &rows(&|k| vec![1.0, [1.0, 2.0, 1.0][k]])));
    assert_eq!(file.bundles.iter().map(|own| own.rays.len()).collect::<Vec<_>>(), [2, 1]);
    assert_eq!(file.bundles[1].spectrum, Some(Spectrum::Table(vec![(600.0, 1.0)])));
    assert!(fault(&tm25(&indexed, &rows(&|_| vec![1.0, 3.0]))).contains("the spectrum 3; expected 1 to 2"));

    // V(555) = 1 and V(450) = 0.038 (CIE 1931): each ray by its own wavelength.
    let of_ray = Tm25 { spectral: 2, flags: [true, true, false, false, false, false], ..Tm25::default() };
    let file = read(&tm25(&of_ray, &rows(&|k| vec![1.0, [555.0, 450.0, 900.0][k]])));
    let lumens: Vec<f64> = file.bundles.iter().map(|own| own.by_wavelength.unwrap()).collect();
    assert!((lumens[0] - 683.002 * 0.038).abs() < 1e-2 && (lumens[1] - 683.002).abs() < 1e-1, "{lumens:?}");
    assert!(file.remarks[0].contains("1 of its 3 rays have wavelengths outside"), "{:?}", file.remarks);

    // Polarised rays have six columns more by one reader, three by the other; both are told by their length.
    for columns in [6, 3] {
        let stokes = Tm25 { flags: [true, false, false, true, false, false], ..Tm25::default() };
        let file = read(&tm25(&stokes, &rows(&|_| vec![1.5; 1 + columns])));
        assert_eq!(file.bundles[0].watts, Some(4.5));
        assert!(file.remarks.iter().any(|text| text.contains("polarisation")), "{:?}", file.remarks);
    }
    let colours = Tm25 { flags: [true, false, true, false, true, false], ..Tm25::default() };
    let file = read(&tm25(&colours, &rows(&|_| vec![0.5, 2.0, 9.0, 9.0])));
    assert_eq!((file.bundles[0].watts, file.bundles[0].lumens), (Some(1.5), Some(6.0)));
    assert!(file.remarks.iter().any(|text| text.contains("tristimulus")), "{:?}", file.remarks);
}

#[test]
fn zemax_files_in_their_units() {
    for (unit, mm) in [(0, 1000.0), (1, 25.4), (2, 10.0), (3, 304.8), (4, 1.0)] {
        let rows: Vec<Vec<f32>> = RAYS.iter().map(|ray| row(ray, &[1.0])).collect();
        let file = read(&zemax([unit, 0, 1], &rows));
        assert_eq!((file.format, file.bundles[0].lumens), ("Zemax binary source file", Some(3.0)));
        assert_eq!(file.bundles[0].rays[0].place_mm, mm * Vec3::new(1.0, 2.0, 3.0));
    }
    // A file that TM25RaySetTools has converted from LightTools' (RayFileConverter/ThreeRays_Wavelength_ZMX.ray), whose text
    // says: -0.6668399 -0.3333333 0.0001, -0.8660254 0 0.5, 0.003106601 W at 550 nm; …
    let file = read(&std::fs::read("tests/data/ray_files/three_rays.dat").unwrap());
    let lines = [(450.0, 0.004_659_902), (550.0, 0.003_106_601), (620.0, 0.001_553_301)];
    assert_eq!(file.bundles.len(), 3);
    for (own, (nm, watts)) in file.bundles.iter().zip(lines) {
        let Some(Spectrum::Table(rows)) = &own.spectrum else { panic!("{own:?}") };
        assert!(rows.len() == 1 && (rows[0].0 - nm).abs() < 1e-3, "{rows:?}");
        assert!((own.watts.unwrap() / watts - 1.0).abs() < 1e-6);
    }
    let green = file.bundles[1].rays[0];
    assert!(green.place_mm.abs_diff_eq(Vec3::new(-0.666_839_9, -0.333_333_3, 0.0001), 1e-6));
    assert!(green.dir.abs_diff_eq(Vec3::new(-0.866_025_4, 0.0, 0.5), 1e-6));
}

#[test]
fn broken_files_are_one_line() {
    let good = luminous(&RAYS);
    let rays_at = 36_288;
    let with = |at: usize, bytes: &[u8]| {
        let mut out = good.clone();
        out[at..at + bytes.len()].copy_from_slice(bytes);
        out
    };
    for (bytes, want) in [
        (Vec::new(), "no ray file that is known"),
        (good[..100].to_vec(), "is cut off: it has 100 bytes; expected 36288 bytes"),
        (good[..good.len() - 1].to_vec(), "is cut off: it has 36371 bytes; expected 36372 bytes"),
        ([good.clone(), vec![0; 5]].concat(), "has 36377 bytes, and 3 rays; expected 36372 bytes"),
        (with(4, &2020i32.to_le_bytes()), "is of version 2020 of TM-25; expected 2013"),
        (with(20, &0u64.to_le_bytes()), "has no rays"),
        (with(20, &u64::MAX.to_le_bytes()), "is cut off"),
        (with(60, &7i32.to_le_bytes()), "says spectral data 7; expected 0 to 4"),
        (with(60, &2i32.to_le_bytes()), "lacks a wavelength"),
        (with(76, &(-1i32).to_le_bytes()), "has -1 spectra"),
        (with(76, &i32::MAX.to_le_bytes()), "in spectrum 1"),
        (with(80, &i32::MAX.to_le_bytes()), "is cut off"),
        (with(80, &(-3i32).to_le_bytes()), "has -3 further columns"),
        (with(84, &i32::MAX.to_le_bytes()), "is cut off"),
        (with(256, &0i32.to_le_bytes()), "without a place"),
        (with(272, &0i32.to_le_bytes()), "or a flux"),
        (with(264, &9i32.to_le_bytes()), "has the flag 9 of data 3; expected 0 or 1"),
        (with(rays_at, &f32::NAN.to_le_bytes()), "has in ray 0 the place"),
        (with(rays_at + 20, &f32::INFINITY.to_le_bytes()), "a direction of length inf"),
        (with(rays_at + 20, &0f32.to_le_bytes()), "a direction of length 0; expected unit directions"),
        (with(rays_at + 20, &3f32.to_le_bytes()), "a direction of length 3"),
        (with(rays_at + 24, &(-1f32).to_le_bytes()), "a flux of -1 lm; expected 0 or more"),
        (with(rays_at + 24, &f32::NAN.to_le_bytes()), "a flux of NaN lm"),
        (luminous(&RAYS.map(|(place, dir, _)| (place, dir, 0.0))), "has no light: 3 rays"),
    ] {
        let found = fault(&bytes);
        assert!(found.contains(want), "{found}, not {want}");
    }
    let rows: Vec<Vec<f32>> = RAYS.iter().map(|ray| row(ray, &[1.0])).collect();
    let good = zemax([4, 0, 0], &rows);
    for (bytes, want) in [
        (good[..50].to_vec(), "is cut off"),
        (good[..good.len() - 4].to_vec(), "is cut off: it has 288 bytes; expected 292 bytes"),
        (zemax([5, 0, 0], &rows), "has the unit of lengths 5"),
        (zemax([4, 1, 0], &rows), "has rays of format 1"),
        (zemax([4, 0, 2], &rows), "has flux of kind 2; expected 0, watts, or 1, lumens"),
        (zemax([4, 2, 1], &rows), "has flux of kind 1; expected 0, watts, of rays with wavelengths"),
        (zemax([4, 0, 0], &[]), "has no light: 0 rays"),
    ] {
        let found = fault(&bytes);
        assert!(found.contains(want), "{found}, not {want}");
    }
    // Directions of few decimals are put right, and said.
    let file = read(&luminous(&[([0.0; 3], [0.0, 0.001, 1.0005], 1.0)]));
    assert!((file.bundles[0].rays[0].dir.length() - 1.0).abs() < 1e-6);
    assert!(file.remarks[0].contains("not unit"), "{:?}", file.remarks);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Whatever bytes of the header are changed and wherever the file ends: rays or one line.
    #[test]
    fn no_bytes_cause_a_panic(
        changes in prop::collection::vec((0usize..400, any::<u8>()), 0..12),
        keep in 0.0f64..1.2,
        zemaxes in any::<bool>(),
    ) {
        let rows: Vec<Vec<f32>> = lambertian(20, 1.0, 1.0).iter().map(|ray| row(ray, &[1.0])).collect();
        let mut bytes = if zemaxes { zemax([4, 0, 0], &rows) } else { luminous(&lambertian(20, 1.0, 1.0)) };
        for (at, byte) in changes {
            let at = if zemaxes || at < 288 { at } else { at - 288 + 36_288 };
            if let Some(place) = bytes.get_mut(at.max(4)) {
                *place = byte;
            }
        }
        bytes.truncate((bytes.len() as f64 * keep) as usize);
        if let Err(fault) = parse(Path::new("a.dat"), &bytes) {
            prop_assert!(!fault.to_string().contains('\n'));
        }
    }
}
