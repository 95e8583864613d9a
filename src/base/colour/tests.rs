//! Against the oracle's matrices (tests/data/colour/matrices.json) and the plain facts of each space.

use super::*;

fn oracle() -> serde_json::Value {
    serde_json::from_str(include_str!("../../../tests/data/colour/matrices.json")).unwrap()
}

#[test]
fn matrices_are_the_oracles() {
    let oracle = oracle();
    for (name, matrix) in [
        ("RGB709_to_XYZ", REC709_TO_XYZ),
        ("XYZ_to_RGB709", XYZ_TO_REC709),
        ("ACEScg_to_XYZ", AP1_TO_XYZ),
        ("XYZ_to_ACEScg", XYZ_TO_AP1),
        ("bradford_D65_to_ACES", BRADFORD_D65_TO_ACES),
        ("RGB709_to_ACEScg_bradford", REC709_TO_ACESCG),
    ] {
        for (i, row) in matrix.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                let want = oracle[name][i][j].as_f64().unwrap();
                assert!((value - want).abs() < 1e-10, "{name}[{i}][{j}]: {value} for {want}");
            }
        }
    }
    for c in 0..3 {
        assert!((REC709_TO_XYZ[1][c] - oracle["luminance_709"][c].as_f64().unwrap()).abs() < 1e-10);
        assert!((AP1_TO_XYZ[1][c] - oracle["luminance_ACEScg"][c].as_f64().unwrap()).abs() < 1e-10);
    }
}

#[test]
fn spaces_lead_there_and_back_and_agree_on_white_and_luminance() {
    let xyz = [0.3, 0.7, 0.2];
    for space in ColourSpace::ALL {
        let colour = space.from_xyz(xyz);
        for (got, want) in space.to_xyz(colour).into_iter().zip(xyz) {
            assert!((got - want).abs() < 1e-14, "{space:?}");
        }
        assert!((space.luminance(colour) - 0.7).abs() < 1e-14, "{space:?}");
        let from_rgb = space.from_rec709(apply(&XYZ_TO_REC709, xyz));
        for (got, want) in from_rgb.into_iter().zip(colour) {
            assert!((got - want).abs() < 1e-14, "{space:?}");
        }
        assert!((space.luminance_weights().iter().sum::<f64>() - 1.0).abs() < 1e-14, "{space:?}");
        assert_eq!(ColourSpace::from_name(space.name()), Some(space));
    }
    for (got, want) in ColourSpace::AcesCg.from_rec709([1.0; 3]).into_iter().zip([1.0; 3]) {
        assert!((got - want).abs() < 1e-14);
    }
    assert_eq!(ColourSpace::from_name("srgb"), None);
    assert_eq!(ColourSpace::default().interop_id(), "lin_rec709_scene");
}
