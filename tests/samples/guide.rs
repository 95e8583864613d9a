//! `samples/guide`: parallel mirrors send light on as it came, and each takes its share.

use super::{as_brute_force, sample, scanned, seen_at, straight_ahead};

/// How far a mirror reaches along the slab of 3 mm, mm: 3 mm/tan 30°.
const REACH: f64 = 3.0 * 1.732_050_807_568_877_2;
/// m
const FOCAL_LENGTH: f64 = 0.030;

/// From under each mirror by itself: they are faces of other parts, and so the ways to them.
#[test]
fn each_mirror_shows_the_display_at_infinity_with_its_share() {
    for crossed in 0..3 {
        let eye = format!("eye.position=[\"{} mm\", \"0 mm\", \"0 mm\"]", 2.0 * REACH * f64::from(crossed - 1));
        let near = scanned(&sample("guide", &["DISPLAY.size=[0.6, 0.34]", &eye]), [1, 1], [0.0, 0.0], None);
        let position = &near.positions[0];
        seen_at(&near, position, |place| place.map(|at| at / FOCAL_LENGTH));
        let per_m = position.distance.unwrap().centre_per_m.unwrap();
        assert!(per_m.abs() < 1e-3, "{per_m} 1/m");
        straight_ahead("guide", &eye, (64, 1e-3), 3000.0 * 0.95 * 0.8f64.powi(crossed) * 0.2);
    }
}

#[test]
fn as_planned_it_is_what_plain_paths_see() {
    as_brute_force("guide", &[], [16, 64]);
}
