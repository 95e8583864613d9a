use super::*;
use crate::{build, toml};
use profile::Form;

fn made(text: &str) -> Result<Made> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.zmx");
    std::fs::write(&path, text).unwrap();
    make(&path, "x.glb")
}

const SINGLET: &str = "MODE SEQ\nUNIT MM X W X CM MR CPMM\nENPD 8\nFTYP 0 0 1 1 0 0 0\nYFLN 5\nWAVM 1 0.5875618 1\nPWAV 1\n\
    SURF 0\n  TYPE STANDARD\n  DISZ INFINITY\nSURF 1\n  STOP\n  TYPE STANDARD\n  DISZ 20\n  DIAM 4\n\
    SURF 2\n  TYPE STANDARD\n  CURV 0.02\n  DISZ 5\n  GLAS N-BK7 0 0 1.5 40\n  DIAM 10\n\
    SURF 3\n  TYPE EVENASPH\n  CURV -0.02\n  CONI -1.5\n  PARM 2 1e-6\n  DISZ 48\n  DIAM 10\nSURF 4\n  TYPE STANDARD\n  DIAM 5\n";

#[test]
fn a_singlet_becomes_a_scene() {
    let made = made(SINGLET).unwrap();
    let sheet = toml::parse(&made.text, Path::new("x.optics.toml")).unwrap();
    let built = build(made.assembly, Some(&sheet), &[]).unwrap();
    let scene = built.scene;
    assert_eq!(scene.parts.iter().map(|part| part.name.as_str()).collect::<Vec<_>>(), ["L1", "IMAGE"]);
    assert_eq!(scene.medium(scene.parts[0].medium.unwrap()).name, "N-BK7");
    assert_eq!(scene.eye.fov_deg, 10.0);
    assert!((scene.eye.pupil_diameter_m - 8e-3).abs() < 1e-15 && scene.eye.position.length() < 1e-15);
    assert!(made.text.contains("asphere") && made.text.contains("radius = 50"), "{}", made.text);
}

#[test]
fn faults_are_one_line_with_their_place() {
    for (text, said) in [
        (SINGLET.replace("EVENASPH", "USERSURF"), "x.zmx:22: surfaces of type USERSURF are not read"),
        (SINGLET.replace("MODE SEQ", "MODE NSC"), "x.zmx:1: this design is not sequential"),
        (SINGLET.replace("N-BK7 0", "N-BK8 0"), "unknown glass `N-BK8`"),
        (SINGLET.replace("CURV 0.02", "CURV x"), "is no line of CURV"),
        (SINGLET.replace("DIAM 10", "").replace("DIAM 4", "").replace("ENPD 8", ""), "the glass has no size"),
        (SINGLET.replace("DISZ 5\n", "DISZ 0\n"), "cross on the axis"),
        ("MODE SEQ\n".to_owned(), "holds no lens"),
        (String::new(), "holds no lens"),
    ] {
        let fault = made(&text).unwrap_err().to_string();
        assert!(fault.contains(said) && !fault.contains('\n'), "{fault}");
    }
}

/// Cut off anywhere, a file is read or refused.
#[test]
fn half_a_file_is_no_panic() {
    for end in (0..SINGLET.len()).step_by(3) {
        let _ = made(&SINGLET[..end]).map(|made| toml::parse(&made.text, Path::new("x.optics.toml")).map(|_| ()));
    }
}

/// Of n_d alone, the same at all wavelengths.
#[test]
fn a_model_glass_without_dispersion() {
    let made = made(&SINGLET.replace("N-BK7 0 0 1.5 40", "___BLANK 1 0 1.52 0")).unwrap();
    let sheet = toml::parse(&made.text, Path::new("x.optics.toml")).unwrap();
    let scene = build(made.assembly, Some(&sheet), &[]).unwrap().scene;
    let medium = scene.medium(scene.parts[0].medium.unwrap());
    assert_eq!([400.0, 700.0].map(|nm| medium.index.index(nm).re), [1.52; 2]);
}

/// OSA's numbers and Noll's, by their first ten terms (n, m).
#[test]
fn zernike_numbers() {
    let osa: Vec<(i32, i32)> = (0..6).map(profile::osa).collect();
    assert_eq!(osa, [(0, 0), (1, -1), (1, 1), (2, -2), (2, 0), (2, 2)]);
}

/// Commands of CODE V in their forms: qualifiers, continuation, comments, glasses of the file's own, no sizes.
#[test]
fn a_sequence_in_its_spellings() {
    let text = "rdm;len ! a comment; with a semicolon\ntit 'a; b'\nfno 5; wl 587.6\nprv\npwl 650 &\n 500\n'ABC' 1.50 1.52\nend\n\
                so 0 1e13\ns 50 4 'ABC'\nsto\ns -50 3 517.642\ns -200 90\nsi 0 0\nk s2 -1; thi s3 91\ngo\n";
    let read = seq::read(text, Path::new("x.seq")).unwrap();
    assert_eq!(read.surfaces.len(), 5);
    assert_eq!(read.surfaces[1].after, After::Private(vec![[500.0, 1.52], [650.0, 1.50]]));
    assert_eq!(read.surfaces[2].after, After::Model([1.517, 64.2]));
    assert_eq!((read.surfaces[2].profile.conic, read.surfaces[3].thickness, read.surfaces[1].stop), (-1.0, 91.0, true));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.seq");
    std::fs::write(&path, text).unwrap();
    let made = make(&path, "x.glb").unwrap();
    let sheet = toml::parse(&made.text, Path::new("x.optics.toml")).unwrap();
    let scene = build(made.assembly, Some(&sheet), &[]).unwrap_or_else(|fault| panic!("{fault}\n{}", made.text)).scene;
    // f/5 at a focal length of some 100 mm.
    assert!((0.015..0.03).contains(&scene.eye.pupil_diameter_m), "{}", scene.eye.pupil_diameter_m);
    for bad in ["so 0 1\ns x 1\nsi", "so 0 1\ns 0 1\nsps xyp\nsi", "dim q", "s", ""] {
        let fault = seq::read(bad, Path::new("x.seq")).unwrap_err().to_string();
        assert!(fault.starts_with("x.seq") && !fault.contains('\n'), "{fault}");
    }
}

/// A private glass by Laurent's formula: NOA61, whose maker gives n = 1.5375 + 0.0082904/λ² − 0.000211046/λ⁴ (λ in µm; Norland,
/// "Norland Optical Adhesive 61"), squared. Formulas that are not read are refused where such a glass is used.
#[test]
fn private_glasses_by_formula() {
    let of = |glass: &str| {
        let text = format!(
            "RDM\nDIM M\nWL 587.5618\nEPD 10\nPRV\n PWL 550.0\n {glass}\nEND\nSO 0 0.1e14\nS 50 5 'NOA61'\nSTO\nCIR 6\n\
             S -50 40\nCIR 6\nSI 0 0\n"
        );
        seq::read(&text, Path::new("x.seq")).map_err(|fault| fault.to_string())
    };
    let read = of("'NOA61' LAU 2.36390625 0.0 0.025493134 -0.000580235 -0.349933e-5 0.445404e-7").unwrap();
    let After::Private(rows) = &read.surfaces[1].after else { panic!("{:?}", read.surfaces[1].after) };
    for [nm, n] in rows {
        let um = nm / 1e3;
        let want = 1.5375 + 0.0082904 / um.powi(2) - 0.000211046 / um.powi(4);
        assert!((n - want).abs() < 1e-6, "{nm}: {n} for {want}");
    }
    assert!(rows.first().is_some_and(|row| row[0] <= 360.0) && rows.last().is_some_and(|row| row[0] >= 830.0));
    let fault = of("'NOA61' HAR 1.5 0.1 0.2").unwrap_err();
    assert!(
        fault.starts_with("x.seq:10: the private glass `NOA61` is by the formula HAR, which is not read"),
        "{fault}"
    );
    for bad in ["'NOA61' LAU -9", "'NOA61' LAU x", "'NOA61' 1.5 1.6", "'NOA61'", "'NOA61' LAU 2 0 0 0 0 0 7"] {
        let fault = of(bad).unwrap_err();
        assert!(fault.contains("expected an index at each wavelength of PWL") && !fault.contains('\n'), "{fault}");
    }
    // Nobody uses this one.
    let unused = of("'OTHER' HAR 1").unwrap();
    assert_eq!(unused.surfaces[1].after, After::Glass { name: "NOA61".to_owned(), model: None });
}

/// The entrance pupil by each of the words that say an aperture, against the thick lens's formula 1/f = (n − 1)(2/R − (n − 1)d/nR²)
/// and, from the near side, by the angle of the light from the axis.
#[test]
fn pupils_of_every_aperture() {
    let n = eyebox_scene::glass::find("N-BK7").unwrap().dispersion.index(587.5618).re;
    let focal = 1.0 / ((n - 1.0) * (2.0 / 50.0 - (n - 1.0) * 5.0 / (n * 2500.0)));
    let pupil = |aperture: &str, distance: &str| {
        let text = SINGLET.replace("ENPD 8", aperture).replacen("DISZ INFINITY", &format!("DISZ {distance}"), 1);
        let made = made(&text).unwrap();
        let sheet = toml::parse(&made.text, Path::new("x.optics.toml")).unwrap();
        let told: Vec<String> = made.notes.iter().map(|note| note.text.clone()).collect();
        let scene = build(made.assembly, Some(&sheet), &[]).unwrap().scene;
        (1e3 * scene.eye.pupil_diameter_m, told)
    };
    let near = |got: f64, want: f64| assert!((got / want - 1.0).abs() < 1e-9, "{got} for {want}");
    near(pupil("FNUM 2.5 0", "INFINITY").0, focal / 2.5);
    near(pupil("FNUM 2.5 1", "INFINITY").0, focal / 2.5);
    near(pupil("FLOA", "INFINITY").0, 8.0);
    // The stop is the first surface, so that the pupil stands in it.
    near(pupil("OBNA 0.04 0", "100").0, 200.0 * 0.04f64.asin().tan());
    near(pupil("OBNA 3 1", "100").0, 200.0 * 3f64.to_radians().tan());
    // A paraxial ray by hand: over the air before the lens, its front, the glass, its back.
    let (slope, at_lens) = (1.0, 100.0 + 20.0);
    let inside = (slope - at_lens * 0.02 * (n - 1.0)) / n;
    let leaves = n * inside - (at_lens + 5.0 * inside) * -0.02 * (1.0 - n);
    near(pupil("FNUM 4 1", "100").0, 2.0 * 100.0 / (8.0 * f64::abs(leaves)));
    let (_, told) = pupil("FNUM 2.5 0", "INFINITY");
    assert!(
        told.iter().any(|text| text.starts_with("the pupil of 19.68") && text.ends_with("ratio of 2.5")),
        "{told:?}"
    );
    let (default, told) = pupil("OBNA 0.04 0", "INFINITY");
    assert!(
        default == 4.0
            && told.iter().any(|text| text.ends_with("gives no pupil: one of 4 mm, as of an eye by room light"))
    );
}

/// Fringe terms against their polynomials as they are printed (Wyant and Creath 1992, table III), on the sag of a plane that has
/// one of them.
#[test]
fn fringe_terms() {
    type Polynomial = fn(f64, f64) -> f64;
    let radius = 20.0;
    let printed: [(usize, Polynomial); 9] = [
        (2, |r, t| r * t.cos()),
        (3, |r, t| r * t.sin()),
        (4, |r, _| 2.0 * r * r - 1.0),
        (5, |r, t| r * r * (2.0 * t).cos()),
        (8, |r, t| (3.0 * r * r - 2.0) * r * t.sin()),
        (9, |r, _| 6.0 * r.powi(4) - 6.0 * r * r + 1.0),
        (12, |r, t| (4.0 * r * r - 3.0) * r * r * (2.0 * t).cos()),
        (16, |r, _| 20.0 * r.powi(6) - 30.0 * r.powi(4) + 12.0 * r * r - 1.0),
        (37, |r, _| {
            924.0 * r.powi(12) - 2772.0 * r.powi(10) + 3150.0 * r.powi(8) - 1680.0 * r.powi(6) + 420.0 * r.powi(4)
                - 42.0 * r * r
                + 1.0
        }),
    ];
    for (number, polynomial) in printed {
        let mut terms = format!("  XDAT 1 {number}\n  XDAT 2 {radius}\n");
        terms += &format!("  XDAT {} 0.25\n", number + 2);
        let text = SINGLET.replacen("TYPE EVENASPH", &format!("TYPE FZERNSAG\n{terms}"), 1);
        let text: String = text.lines().filter(|line| !line.contains("PARM")).map(|line| format!("{line}\n")).collect();
        let read = super::zmx::read(&text, Path::new("x.zmx")).unwrap();
        let surface = read.surfaces.iter().find(|own| matches!(own.profile.form, profile::Form::Zernike { .. }));
        let profile = surface.unwrap_or_else(|| panic!("no Zernike surface: {text}")).profile.clone();
        let flat = profile::Profile { curvature: 0.0, conic: 0.0, ..profile };
        for (x, y) in [(3.0f64, 4.0f64), (-7.0, 2.0), (10.0, -12.0)] {
            let want = 0.25 * polynomial(x.hypot(y) / radius, y.atan2(x));
            let got = flat.sag(x, y).unwrap();
            assert!((got - want).abs() < 1e-12, "{number} at {x}, {y}: {got} for {want}");
        }
    }
}

/// Of a fringe sag that has the terms of an even asphere too, and beyond its norm radius.
#[test]
fn powers_beside_fringe_terms() {
    let terms = "FZERNSAG\n  PARM 0 1\n  PARM 1 2e-4\n  PARM 2 3e-7\n  PARM 5 -4e-15\n  PARM 8 5e-24\n  XDAT 1 1\n  XDAT 2 12\n  XDAT 3 0.25";
    let text = SINGLET.replacen("EVENASPH\n  CURV -0.02\n  CONI -1.5\n  PARM 2 1e-6", terms, 1);
    let read = super::zmx::read(&text, Path::new("x.zmx")).unwrap();
    for (x, y) in [(0.0f64, 0.0f64), (3.0, 4.0), (-7.0, 2.0), (10.0, -12.0)] {
        let r2 = x * x + y * y;
        let want = 0.25 + 2e-4 * r2 + 3e-7 * r2.powi(2) - 4e-15 * r2.powi(5) + 5e-24 * r2.powi(8);
        let got = read.surfaces[3].profile.sag(x, y).unwrap();
        assert!((got - want).abs() < 1e-13, "at {x}, {y}: {got} for {want}");
    }
    let shifted = text.replace("PARM 8 5e-24", "PARM 9 1");
    assert!(super::zmx::read(&shifted, Path::new("x.zmx")).unwrap_err().to_string().contains("beside its own terms"));
}

/// Extended aspheres are even ones over a norm radius; odd ones without odd powers are such. Others are refused by name.
#[test]
fn aspheres_by_other_numbers() {
    let text = |kind: &str, numbers: &str| SINGLET.replace("EVENASPH", kind).replace("  PARM 2 1e-6\n", numbers);
    let of = |text: &str| super::zmx::read(text, Path::new("x.zmx")).map(|read| read.surfaces[3].profile.clone());
    let even = of(&text("EVENASPH", "  PARM 1 1e-4\n  PARM 2 -3e-6\n  PARM 3 2e-9\n")).unwrap();
    let extended = "  XDAT 1 3\n  XDAT 2 5\n  XDAT 3 2.5e-3\n  XDAT 4 -1.875e-3\n  XDAT 5 3.125e-5\n  XDAT 6 9\n";
    let odd = "  PARM 2 1e-4\n  PARM 4 -3e-6\n  PARM 6 2e-9\n";
    for other in [of(&text("XASPHERE", extended)).unwrap(), of(&text("ODDASPHE", odd)).unwrap()] {
        let (Form::Even(a), Form::Even(b)) = (&even.form, &other.form) else { panic!("{other:?}") };
        assert!(a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 4e-16 * a.abs()), "{a:?} {b:?}");
    }
    let fault = |kind: &str, numbers: &str| of(&text(kind, numbers)).unwrap_err().to_string();
    assert!(
        fault("ODDASPHE", "  PARM 3 1e-6\n").contains("an asphere with the power 3 of the radius cannot be traced")
    );
    assert!(fault("XASPHERE", "  PARM 1 1\n").contains("XASPHERE with numbers beside its own terms"));
    assert!(fault("XASPHERE", "  XDAT 1 2\n  XDAT 2 1e-200\n  XDAT 3 1\n  XDAT 4 1\n").contains("are no numbers"));
    assert_eq!(of(&text("XASPHERE", "  XDAT 1 1e30\n")).unwrap().form, Form::Conic);
}

/// Obscurations in air are dark sheets, of the size and place that the file says; on glass they are told.
#[test]
fn obscurations_are_dark() {
    const BAFFLE: &str =
        "SURF 1\n  STOP\n  TYPE STANDARD\n  DISZ 20\n  DIAM 4\nSURF 1\n  TYPE STANDARD\n  DISZ 10\n  DIAM 9\n";
    let with = |words: &str| {
        SINGLET.replace("SURF 1\n  STOP\n  TYPE STANDARD\n  DISZ 20\n  DIAM 4\n", &format!("{BAFFLE}{words}"))
    };
    for (words, [x, y], inner) in [
        ("  OBSC 1 2.5 0\n", [[-2.5, 2.5], [-2.5, 2.5]], 1.0),
        ("  OBSC 0 2.5 0\n", [[-2.5, 2.5], [-2.5, 2.5]], 0.0),
        ("  SQOB 2 3 0\n  OBDC 1 -1 0\n", [[-1.0, 3.0], [-4.0, 2.0]], 0.0),
        ("  ELOB 2 3 0\n", [[-2.0, 2.0], [-3.0, 3.0]], 0.0),
    ] {
        let made = made(&with(words)).unwrap_or_else(|fault| panic!("{words}: {fault}"));
        let node = made.assembly.nodes.iter().find(|node| node.name == "OBSCURATION1").unwrap();
        assert!((node.to_world.translation.z - 20.0).abs() < 1e-12);
        let places = &made.assembly.meshes[node.mesh.unwrap()].mesh.positions;
        let ends = |axis: usize| {
            let all = places.iter().map(|place| f64::from(place[axis]));
            all.fold([f64::MAX, f64::MIN], |[low, high], v| [low.min(v), high.max(v)])
        };
        assert_eq!([ends(0), ends(1)], [x, y], "{words}");
        let least = places.iter().map(|[x, y, _]| f64::from(x.hypot(*y))).fold(f64::MAX, f64::min);
        assert!(inner == 0.0 || (least - inner).abs() < 1e-6, "{words}: {least}");
        let sheet = toml::parse(&made.text, Path::new("x.optics.toml")).unwrap();
        let scene = build(made.assembly, Some(&sheet), &[]).unwrap().scene;
        let dark = scene.parts.iter().find(|part| part.name == "OBSCURATION1").unwrap();
        assert_eq!(dark.faces[0].finish, eyebox_scene::Finish::Absorber);
    }
    let on_glass = made(&SINGLET.replace("  CURV 0.02\n", "  CURV 0.02\n  OBSC 0 2 0\n")).unwrap();
    assert!(on_glass.notes.iter().any(|note| format!("{note:?}").contains("the obscuration of a glass or a mirror")));
    // The eye's pupil and a sheet in the same place would be met by chance.
    let at_eye = made(&SINGLET.replace("  DISZ 20\n  DIAM 4\n", "  DISZ 20\n  DIAM 4\n  OBSC 0 1 0\n")).unwrap();
    assert!(at_eye.assembly.nodes.iter().all(|node| node.name != "OBSCURATION1"));
    assert!(at_eye.notes.iter().any(|note| format!("{note:?}").contains("of the entrance stop is not taken over")));
    for nothing in ["  OBSC 0 0 0\n", "  OBSC 3 2 0\n", "  SQOB 0 3 0\n"] {
        assert!(made(&with(nothing)).unwrap().assembly.nodes.iter().all(|node| node.name != "OBSCURATION1"));
    }
    assert!(made(&with("  OBSC x 2 0\n")).unwrap_err().to_string().contains("is no line of OBSC"));
}

/// What of a mirror is there: the part of a paraboloid off its axis, a rectangle, a ring; the image is turned by itself.
#[test]
fn apertures_end_mirrors() {
    const MIRROR: &str = "MODE SEQ\nUNIT MM X W X CM MR CPMM\nENPD 8\nSURF 0\n  DISZ INFINITY\nSURF 1\n  STOP\n  DISZ 200\n\
        SURF 2\n  CURV -0.005\n  CONI -1\n  DISZ -100\n  GLAS MIRROR\n  DIAM 20 1 0 0 1 \"\"\nSURF 3\n  DIAM 4\n";
    let spread = |text: &str| {
        let made = made(text).unwrap_or_else(|fault| panic!("{fault}"));
        let mirror = made.assembly.nodes.iter().find(|node| node.name == "M1").unwrap();
        let places = &made.assembly.meshes[mirror.mesh.unwrap()].mesh.positions;
        let ends = |axis: usize| {
            places
                .iter()
                .map(|place| f64::from(place[axis]))
                .fold([f64::MAX, f64::MIN], |[low, high], v| [low.min(v), high.max(v)])
        };
        let inner = places.iter().map(|[x, y, _]| f64::from(x.hypot(*y))).fold(f64::MAX, f64::min);
        (ends(0), ends(1), inner)
    };
    let near = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).abs() < 1e-5 && (a[1] - b[1]).abs() < 1e-5;
    let (x, y, inner) = spread(MIRROR);
    assert!(near(x, [-20.0, 20.0]) && near(y, [-20.0, 20.0]) && inner == 0.0, "{x:?} {y:?} {inner}");
    let (x, y, _) = spread(&MIRROR.replace("  DIAM 20", "  OBDC 5 100\n  CLAP 0 12.5 0\n  DIAM 20"));
    assert!(near(x, [-7.5, 17.5]) && near(y, [87.5, 112.5]), "{x:?} {y:?}");
    let (x, y, _) = spread(&MIRROR.replace("  DIAM 20", "  SQAP 30 10 0\n  OBDC 0 -50\n  DIAM 60"));
    assert!(near(x, [-30.0, 30.0]) && near(y, [-60.0, -40.0]), "{x:?} {y:?}");
    let (_, y, inner) = spread(&MIRROR.replace("  DIAM 20", "  CLAP 6 18 0\n  DIAM 20"));
    assert!(near(y, [-20.0, 20.0]) && (inner - 6.0).abs() < 1e-5, "{y:?} {inner}");
    let turned = MIRROR.replace("SURF 3\n", "SURF 3\n  SCBD 1 0 0 0 0 90 0 0\n");
    let image = made(&turned).unwrap().assembly.nodes.iter().find(|node| node.name == "IMAGE").unwrap().to_world;
    assert!((image.matrix3.z_axis - glam::DVec3::NEG_Y).length() < 1e-15, "{image}");
    let fault = made(&MIRROR.replace("SURF 2\n", "SURF 2\n  SCBD 1 0 0 0 0 1 0 0\n")).unwrap_err().to_string();
    assert!(fault.starts_with("x.zmx:10: ") || fault.contains(":10: a surface that is tilted"), "{fault}");
}

/// Fields by heights: those of an image in focus are f tan, and a mirror at 60° is twice as long as what it reflects.
#[test]
fn fields_and_sizes_follow_from_rays() {
    let text = "rdm;dim m\nepd 2;wl 550\nyim 0 10\nso 0 1e13\ns 0 10\nsto\ns 0 -20 refl\nade 60; ben\ns -100 -4 nbk7_schott\ns 0 -190\nsi 0 0\ngo";
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.seq");
    std::fs::write(&path, text).unwrap();
    let mut read = read(&path).unwrap();
    let frames = frames::frames(&read);
    sizes::fill(&mut read, &frames, &path);
    let n = eyebox_scene::glass::find("SCHOTT N-BK7").unwrap().dispersion.index(550.0).re;
    // The thin end of a plano-convex lens: f = R/(n − 1), and the focus is f − d/n behind its plane.
    let f = 100.0 / (n - 1.0);
    let out_of_focus = 190.0 - (f - 4.0 / n);
    let [_, y] = read.field_deg.unwrap();
    // A ray through the stop's middle meets the lens 30 away from it.
    let at_image = f - out_of_focus * (30.0 / f - 1.0);
    assert!((y.to_radians().tan() * at_image.abs() - 10.0).abs() < 1e-9, "{y} {at_image}");
    let [stop, mirror] = [1, 3].map(|index| read.surfaces[index].semi_diameter);
    let slope = y.to_radians().tan();
    assert!((stop - 1.1).abs() < 1e-12 && (mirror - 2.0 * 1.1 * (1.0 + 10.0 * slope)).abs() < 1e-9, "{stop} {mirror}");
}
