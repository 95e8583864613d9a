//! Emitters with a measured distribution, Gaussian beams, polarisation, the sun: through the sidecar.

use super::{built, check, fault};
use eyebox_scene::{Angular, BeaconForm, Photometry, Severity};
use glam::DVec3;

/// A folder with a profile, and a `[[bind]]` on the top face of LED_1.
fn bind(emitter: &str) -> String {
    let file = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("tests/data/07_ies");
    let emitter = emitter.replace("DATA", &file.display().to_string());
    format!("[[bind]]\npath = \"LED_1\"\nnormal = \"+z\"\nemitter = {{ group = \"led\", {emitter} }}\n")
}

#[test]
fn a_profile_rules_unless_a_strength_scales_it() {
    let of = |emitter: &str| {
        let scene = built(&bind(emitter), &[]).unwrap().scene;
        let part = scene.parts.iter().find(|part| part.name == "LED_1").unwrap();
        (part.faces[5].emitter.clone().unwrap(), scene.clone())
    };
    let (emitter, scene) = of("angular = { kind = \"profile\", file = \"DATA/good/bilateral_0_180.ies\" }");
    assert_eq!(emitter.photometry, Photometry::AsMeasured);
    assert_eq!(emitter.angular, Angular::Profile { profile: eyebox_base::ids::ProfileId(0), c0: DVec3::X });
    assert!((scene.profiles[0].peak_cd() - 523.8).abs() < 1e-9);
    let warned =
        |what: &str| scene.notes.iter().any(|note| note.severity == Severity::Warning && note.text.contains(what));
    assert!(warned("go backwards"), "{:?}", scene.notes);
    assert!(scene.notes.iter().any(|note| note.text.contains("of the 1809")));
    let scaled = "flux_lm = 3, u = [0, 2, 0], angular = { profile = { file = \"DATA/good/isym1.ldt\" } }";
    let (emitter, _) = of(scaled);
    assert_eq!(emitter.photometry, Photometry::FluxLm(3.0));
    assert!(matches!(emitter.angular, Angular::Profile { c0: DVec3::Y, .. }));

    let (emitter, _) =
        of("flux_lm = 1, angular = { gauss = { fwhm_deg = 12 } }, polarisation = { angle_deg = 90, degree = 0.9 }");
    assert_eq!(emitter.angular, Angular::Gauss { fwhm_deg: 12.0 });
    let polarisation = emitter.polarisation.unwrap();
    assert!(polarisation.axis.abs_diff_eq(DVec3::Y, 1e-12) && polarisation.degree == 0.9);
}

#[test]
fn broken_profiles_and_distant_faces_are_refused() {
    let found = fault(&bind("angular = { kind = \"profile\", file = \"DATA/bad/nan_candela.ies\" }"), &[]);
    assert!(found.contains("nan_candela.ies:") && found.contains("is `"), "{found}");
    let found = fault(&bind("angular = { kind = \"profile\", file = \"none.ies\" }"), &[]);
    assert!(found.starts_with("hud.optics.toml:") && found.contains("there is no such file"), "{found}");
    let found = fault(&bind("illuminance_lx = 5"), &[]);
    assert!(found.contains("is of a distant source") && found.contains("[sun]"), "{found}");
    check(&[(
        "[sun]\ndirection = [0, 0, 0]\n",
        &[],
        "hud.optics.toml:11: `direction` of sun is the zero vector; expected a direction",
    )]);
}

#[test]
fn a_sun_shines_from_where_it_stands() {
    let scene = built("[sun]\ndirection = [0, 0, 2]\n", &["sun.illuminance_lx=120000"]).unwrap().scene;
    let [sun] = scene.lights.as_slice() else { panic!("{:?}", scene.lights) };
    let BeaconForm::Distant { dir, illuminance_lx, angle_rad } = sun.form else { panic!("{:?}", sun.form) };
    assert!(dir.abs_diff_eq(DVec3::NEG_Z, 1e-15), "{dir}");
    assert_eq!((illuminance_lx, angle_rad), (120_000.0, 0.533f64.to_radians()));
    assert_eq!(scene.group(sun.group).name, "sun");
    // In the axes of the root, which is turned by −90° about x: its z is our y.
    let scene = built("[sun]\ndirection = [0, 0, 1]\nframe = \"ROOT\"\nangle_deg = 0\n", &[]).unwrap().scene;
    let BeaconForm::Distant { dir, illuminance_lx, angle_rad } = scene.lights[0].form else { panic!() };
    assert!(dir.abs_diff_eq(DVec3::NEG_Y, 1e-12) && illuminance_lx == 100_000.0 && angle_rad == 0.0, "{dir}");
}

/// 683 lm/W at 555 nm by definition; CIE A has 15.5 lm/W over the whole of a black body, 2856 K, more in the visible.
#[test]
fn watts_become_lumens_by_the_spectrum() {
    let lit = |more: &str, sets: &[&str]| {
        let text = format!("[[bind]]\npath = \"LED_1\"\nnormal = \"+z\"\nemitter = {{ radiant_flux_w = 2{more} }}\n");
        built(&text, sets).map(|built| {
            let scene = built.scene;
            let part = scene.parts.iter().find(|part| part.name == "LED_1").unwrap();
            let Photometry::FluxLm(flux) = part.faces[5].emitter.as_ref().unwrap().photometry else { panic!() };
            flux
        })
    };
    let flux = lit("", &["wavelengths.mono_nm=555"]).unwrap();
    assert!((flux / (2.0 * 683.0) - 1.0).abs() < 1e-4, "{flux}");
    let equal = lit(", spectrum = \"equal\"", &["wavelengths=visible"]).unwrap();
    // ∫V dλ = 106.857 nm (CIE 018.2) over 470 nm.
    assert!((equal / (2.0 * 683.002 * 106.857 / 470.0) - 1.0).abs() < 1e-4, "{equal}");
    let fault = lit("", &["wavelengths=visible"]).unwrap_err().to_string();
    assert!(fault.contains("its spectrum is not said") && fault.starts_with("hud.optics.toml:13"), "{fault}");
}
