use super::*;
use crate::import::{build, toml};

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
