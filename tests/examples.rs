//! The programs under `examples/` do what they say.

#[path = "../examples/render_to_memory.rs"]
mod render_to_memory;
#[path = "../examples/scan_a_parameter.rs"]
mod scan_a_parameter;
#[path = "../examples/validate_and_print.rs"]
mod validate_and_print;

const HUD: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/samples/hud-direct/hud.optics.toml");

/// The middle of the sample's picture is neither dark nor brighter than its lamps, and the same on every call.
#[test]
fn a_picture_in_memory() {
    let (luminance, error) = render_to_memory::middle_of(HUD).unwrap();
    assert!(luminance > 1.0 && luminance < 1e6, "{luminance}");
    assert!(error.is_some_and(|error| error < 0.5), "{error:?}");
    assert_eq!(render_to_memory::middle_of(HUD).unwrap(), (luminance, error));
}

/// A collimator of glass of a higher index is stronger: the image comes from behind infinity.
#[test]
fn a_design_loop() {
    let found = scan_a_parameter::dioptres(HUD, "LENS_02_NBK7", &["N-BK7", "N-SK16", "N-SF6"]).unwrap();
    assert!(found.iter().all(|per_m| per_m.is_finite()), "{found:?}");
    // n − 1: 0.5187, 0.6229, 0.8127 at 550 nm; a plano-convex lens has a power in proportion.
    assert!(found[0] > found[1] && found[1] > found[2], "{found:?}");
    // The lens stands 0.12 m + 0.08 m before the eye, by way of the combiner; behind it light converges to a point.
    const LENS_M: f64 = 0.2;
    let [first, second, last] = [0, 1, 2].map(|i| 1.0 / (LENS_M - 1.0 / found[i]));
    let ratio = (last - first) / (second - first);
    let want = (0.8127 - 0.5187) / (0.6229 - 0.5187);
    assert!((ratio / want - 1.0).abs() < 0.06, "{found:?}: {ratio} for {want}");
}

#[test]
fn findings_as_lines() {
    // A lens of this CAD export has two vertices whose normals are turned round, which is for the record.
    let found = validate_and_print::lines(HUD);
    assert!(found.iter().all(|line| line.starts_with("Note EB0108 ")), "{found:?}");
    let absent = validate_and_print::lines("no_such.glb");
    assert!(absent.len() == 1 && absent[0].contains("no_such.glb"), "{absent:?}");
}
