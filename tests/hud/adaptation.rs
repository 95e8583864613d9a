//! The pupil of an eye that is adapted to its picture.

use super::kit::hud;
use crate::common::{add_group, add_part, face, mesh, quad, scene};
use eyebox::base::vision::{Eyes, pupil_watson_yellott_mm};
use eyebox::plan::Asked;
use eyebox::plan::adaptation::adapt;
use eyebox::scene::{Finish, Sky};
use glam::{DMat3, DVec3};
use std::sync::Arc;

/// A uniform sky: the pupil is the formula's for its luminance and the field, whatever the search began with.
#[test]
fn a_uniform_sky_tells_the_pupil() {
    for (luminance, begin) in [(10.0f32, 4e-3), (5000.0, 7e-3)] {
        let mut s = scene();
        let group = add_group(&mut s, "sky");
        // Something behind the eye.
        let square = mesh(&[quad(DVec3::ZERO, DVec3::X, DVec3::Y)]);
        add_part(&mut s, "wall", square, DVec3::Z, None, vec![face(Finish::Absorber)]);
        s.sky = Some(Sky {
            group,
            width: 2,
            height: 1,
            luminance: Arc::new(vec![luminance; 2]),
            rgb: None,
            to_world: DMat3::IDENTITY,
            file: String::new(),
        });
        (s.eye.fov_deg, s.eye.resolution, s.eye.age) = (40.0, [300, 200], 30.0);
        (s.eye.adapts, s.eye.pupil_diameter_m) = (true, begin);
        let found = adapt(&mut s, Asked::default(), &|| false).expect("it can be traced").expect("nobody stops it");
        // A rectangle of half tangents a and b covers 4 asin(a b/√((1 + a²)(1 + b²))).
        let (a, b) = (20f64.to_radians().tan(), 20f64.to_radians().tan() / 1.5);
        let field = 4.0 * (a * b / ((1.0 + a * a) * (1.0 + b * b)).sqrt()).asin() * 1f64.to_degrees().powi(2);
        let want = 1e-3 * pupil_watson_yellott_mm(f64::from(luminance), field, 30.0, Eyes::Both);
        assert!((found.field_deg2 / field - 1.0).abs() < 1e-3, "{} for {field}", found.field_deg2);
        assert!((s.eye.pupil_diameter_m / want - 1.0).abs() < 1e-3, "{found:?} for {want}");
        assert!(!s.eye.adapts && s.eye.resolution == [300, 200]);
    }
}

long! {
/// A display that does not fill the pupil is dimmer for a wider one: where the search ends, the picture that the pupil sees
/// asks for this pupil, wherever the search began.
#[test]
fn pupil_and_picture_agree_where_lamps_do_not_fill_it() {
    let pupil = |begin_mm: f64| {
        let mut s = hud("direct", &[]);
        (s.eye.adapts, s.eye.pupil_diameter_m) = (true, 1e-3 * begin_mm);
        let found = adapt(&mut s, Asked::default(), &|| false).expect("it can be traced").expect("nobody stops it");
        (s.eye.pupil_diameter_m, found.luminance_cd_m2)
    };
    let ((narrow, brighter), (wide, dimmer)) = (pupil(2.0), pupil(7.0));
    assert!((narrow / wide - 1.0).abs() < 0.01, "{narrow} m for {brighter} cd/m², {wide} m for {dimmer} cd/m²");
}
}
