//! Sheets that act on polarisation, in every estimator: Malus' law of what a reflective polariser lets through and
//! reflects, and the folded path of a pancake lens against Jones calculus.

use crate::common::*;
use eyebox::base::Complex;
use eyebox::base::ids::{CoatingId, SurfaceId};
use eyebox::film::plan::Estimator;
use eyebox::plan::{Asked, Choice, Guides, Polarisation};
use eyebox::scene::*;
use glam::{DAffine3, DVec3};

const LUMINANCE: f64 = 1000.0;

/// A square of 2 m with this finish at `z`, turned about x.
fn sheet(s: &mut Scene, z: f64, turn_deg: f64, finish: Finish) -> usize {
    let wide = mesh(&[quad(DVec3::ZERO, DVec3::X, DVec3::Y)]);
    let at = DVec3::new(0.0, 0.0, z);
    let part = add_part(s, &format!("sheet at {z}"), wide, at, None, vec![face(finish)]);
    s.parts[part].to_world = DAffine3::from_translation(at) * DAffine3::from_rotation_x(turn_deg.to_radians());
    part
}

/// A panel of 1 m behind the sheets, or above the eye's line of sight, whose light is polarised along x.
fn panel(s: &mut Scene, to_world: DAffine3, half: f64) {
    panel_along(s, DVec3::X, to_world, half);
}

/// The same, polarised along an axis of its own frame.
fn panel_along(s: &mut Scene, axis: DVec3, to_world: DAffine3, half: f64) {
    let group = add_group(s, "panel");
    let mut shining = face(Finish::Absorber);
    let polarisation = Some(PolarisedLight { axis, degree: 1.0 });
    shining.emitter = lamp(group, LUMINANCE).map(|emitter| Emitter { polarisation, ..emitter });
    let square = mesh(&[quad(DVec3::ZERO, DVec3::X * half, DVec3::Y * half)]);
    let part = add_part(s, "panel", square, DVec3::ZERO, None, vec![shining]);
    s.parts[part].to_world = to_world;
}

fn narrow() -> Scene {
    let mut s = scene();
    s.eye.fov_deg = 0.2;
    s.eye.resolution = [2, 2];
    s
}

fn seen(s: &Scene, choice: Choice, polarisation: Polarisation, passes: u64) -> (f64, f64) {
    let (films, _) = render(s, Asked { choice, polarisation, guides: Guides::On }, passes, 7);
    for (_, _, ledger) in &films.films {
        assert!(ledger.vertex_error < 1e-12, "R + T + A misses 1 by {}", ledger.vertex_error);
        assert_eq!((ledger.invalid_paths, ledger.mismatches), (0, 0));
    }
    mean(&image(&films))
}

const BACKWARD: Choice = Choice::Only(Estimator::Backward);

/// Where light along −z that is polarised along x passes an axis at `alpha` in a sheet at 45° about x. Absorption: what the sheet takes
/// lies across the axis in it and is seen projected, and what passes is at right angles to that. Pass: the axis itself is seen projected.
/// Shares along and across.
fn passed_at_45(alpha: f64, projected_axis: ProjectedAxis) -> [f64; 2] {
    let (sin, cos) = alpha.to_radians().sin_cos();
    let beta = match projected_axis {
        ProjectedAxis::Absorption => sin.atan2(cos * 0.5f64.sqrt()),
        ProjectedAxis::Pass => (sin * 0.5f64.sqrt()).atan2(cos),
    };
    [beta.cos().powi(2), beta.sin().powi(2)]
}

/// An absorbing film that is seen from the side: the axis that is projected is what turns.
#[test]
fn a_tilted_polariser_parts_by_malus() {
    let all = [0.0f64, 35.0, 90.0, 120.0].map(|alpha| (alpha, ProjectedAxis::Absorption));
    for (alpha, projected_axis) in all.into_iter().chain([35.0, 120.0].map(|alpha| (alpha, ProjectedAxis::Pass))) {
        let mut s = narrow();
        let (sin, cos) = alpha.to_radians().sin_cos();
        let axis = DVec3::new(cos, sin, 0.0);
        sheet(&mut s, -0.3, -45.0, Finish::Polariser { axis, projected_axis, transmittance: 0.85, extinction: 0.02 });
        panel(&mut s, DAffine3::from_translation(DVec3::new(0.0, 0.0, -0.6)), 0.05);
        let [along, across] = passed_at_45(alpha, projected_axis);
        let want = LUMINANCE * 0.85 * (along + 0.02 * across);
        let (got, sigma) = seen(&s, BACKWARD, Polarisation::Auto, 64);
        println!("{alpha}°: {got} ± {sigma}, want {want}");
        assert!((got - want).abs() < 4.0 * sigma + 2e-3 * want, "{alpha}°: {got} ± {sigma}, {want}");
    }
}

/// A lamp of light polarised along x, by a sheet at 45° whose axis lies at `alpha` in it: the part across what is seen of the
/// axis is reflected, and of a lamp behind the sheet the part along it goes through.
#[test]
fn a_reflective_polariser_parts_by_malus() {
    let (transmittance, transmittance_leak, reflectance, reflectance_leak) = (0.85, 0.02, 0.9, 0.05);
    let all = [(0.0f64, true), (35.0, true), (35.0, false), (90.0, true), (120.0, false)];
    let by_absorption = all.map(|(alpha, above)| (alpha, above, ProjectedAxis::Absorption));
    let by_pass = [(35.0, true), (120.0, false)].map(|(alpha, above)| (alpha, above, ProjectedAxis::Pass));
    for (alpha, above, projected_axis) in by_absorption.into_iter().chain(by_pass) {
        let mut s = narrow();
        let (sin, cos) = alpha.to_radians().sin_cos();
        let axis = DVec3::new(cos, sin, 0.0);
        let finish =
            Finish::ReflectivePolariser { axis, projected_axis, transmittance, transmittance_leak, reflectance, reflectance_leak };
        sheet(&mut s, -0.3, -45.0, finish);
        let place = if above {
            DAffine3::from_translation(DVec3::new(0.0, 0.3, -0.3)) * DAffine3::from_rotation_x(90f64.to_radians())
        } else {
            DAffine3::from_translation(DVec3::new(0.0, 0.0, -0.6))
        };
        panel(&mut s, place, 0.05);
        let [along, across] = passed_at_45(alpha, projected_axis);
        let want = if above {
            LUMINANCE * (reflectance_leak * along + reflectance * across)
        } else {
            LUMINANCE * (transmittance * along + transmittance_leak * across)
        };
        let (got, sigma) = seen(&s, BACKWARD, Polarisation::Auto, 64);
        println!("{alpha}° above {above}: {got} ± {sigma}, want {want}");
        assert!(sigma < 0.03 * LUMINANCE, "noise {sigma}");
        // Rays are up to 0.1° off: a relative 1e-3.
        assert!((got - want).abs() < 4.0 * sigma + 2e-3 * want, "{alpha}° {above}: {got} ± {sigma}, {want}");
        let (got, sigma) = seen(&s, BACKWARD, Polarisation::Off, 64);
        let want =
            0.5 * LUMINANCE * if above { reflectance + reflectance_leak } else { transmittance + transmittance_leak };
        assert!((got - want).abs() < 4.0 * sigma + 1e-6 * want, "unpolarised: {got} ± {sigma}, {want}");
    }
}

/// Light through the sheet to a mirror and back to the eye from the sheet, its polarisation turned by a wave plate on the way:
/// light tracing and connections find the same light as rays from the eye.
#[test]
fn estimators_agree_about_a_reflective_polariser() {
    let mut s = narrow();
    s.eye.fov_deg = 8.0;
    s.eye.resolution = [8, 8];
    s.eye.pupil_diameter_m = 0.02;
    let axis = DVec3::new(40f64.to_radians().cos(), 40f64.to_radians().sin(), 0.0);
    let (transmittance, transmittance_leak, reflectance, reflectance_leak) = (0.85, 0.02, 0.9, 0.05);
    let finish = Finish::ReflectivePolariser { projected_axis: ProjectedAxis::Absorption, axis, transmittance, transmittance_leak, reflectance, reflectance_leak };
    // Lamp above, sheet, mirror below: through, back, and the mirrored light reflected to the eye; and the first reflection.
    sheet(&mut s, -0.3, -45.0, finish);
    let below =
        DAffine3::from_translation(DVec3::new(0.0, -0.2, -0.3)) * DAffine3::from_rotation_x(-90f64.to_radians());
    for (lift, finish) in [
        (0.05, Finish::Retarder { axis: DVec3::new(0.6, 0.8, 0.0), retardance_nm: 120.0 }),
        (0.0, Finish::MirrorIdeal { reflectance: 0.9 }),
    ] {
        let part = sheet(&mut s, -0.2, 0.0, finish);
        s.parts[part].to_world = DAffine3::from_translation(DVec3::Y * lift) * below;
    }
    let above = DAffine3::from_translation(DVec3::new(0.0, 0.3, -0.3)) * DAffine3::from_rotation_x(90f64.to_radians());
    panel(&mut s, above, 0.01);
    let (want, sigma) = seen(&s, BACKWARD, Polarisation::Auto, 256);
    assert!(sigma < 0.03 * want, "noise {sigma} of {want}");
    for choice in [Choice::Only(Estimator::Forward), Choice::Only(Estimator::Manifold), Choice::Auto] {
        let (got, noise) = seen(&s, choice, Polarisation::Auto, 32);
        println!("{choice:?}: {got} ± {noise}, want {want} ± {sigma}");
        assert!(noise < 0.05 * want, "noise {noise} of {want}");
        assert!((got - want).abs() < 4.0 * noise.hypot(sigma), "{choice:?}: {got} ± {noise}, want {want} ± {sigma}");
    }
}

/// An ordinary material as a finish of the scene's.
fn surface(s: &mut Scene, surface: StandardSurface) -> Finish {
    s.surfaces.push(surface.into());
    Finish::Surface { surface: SurfaceId::from_index(s.surfaces.len() - 1) }
}

/// Where what the eye looks at straight ahead, turned by so much, mirrors the line of sight to, in metres from there.
fn mirrored(turn_deg: f64, distance: f64) -> DAffine3 {
    let (sin, cos) = (2.0 * turn_deg).to_radians().sin_cos();
    let turn = DAffine3::from_rotation_x((180.0 - 2.0 * turn_deg).to_radians());
    DAffine3::from_translation(DVec3::new(0.0, sin, cos) * distance - DVec3::Z * 0.3) * turn
}

/// Facets of an ordinary material and of its coat part the polarisations by Fresnel's equations: light polarised across the
/// plane of incidence, and in it.
#[test]
fn glossy_plates_polarise_by_fresnel() {
    let black = StandardSurface {
        base_color: Colour::new([0.0; 3]),
        roughness: Scalar::new(0.0),
        ..StandardSurface::default()
    };
    let coated = StandardSurface { specular: Scalar::new(0.0), coat: Scalar::new(1.0), ..black.clone() };
    for (looks, angle) in [(&black, 30.0f64), (&black, 56.3), (&coated, 45.0), (&coated, 70.0)] {
        let cos = angle.to_radians().cos();
        let inside = (1.0 - angle.to_radians().sin().powi(2) / 2.25).sqrt();
        let r_s = ((cos - 1.5 * inside) / (cos + 1.5 * inside)).powi(2);
        let r_p = ((1.5 * cos - inside) / (1.5 * cos + inside)).powi(2);
        for (axis, share) in [(DVec3::X, r_s), (DVec3::Y, r_p)] {
            let mut s = narrow();
            let finish = surface(&mut s, looks.clone());
            sheet(&mut s, -0.3, -angle, finish);
            panel_along(&mut s, axis, mirrored(angle, 0.3), 0.1);
            let (got, sigma) = seen(&s, BACKWARD, Polarisation::Auto, 64);
            let want = LUMINANCE * share;
            println!("{angle}° {axis}: {got} ± {sigma}, want {want}");
            // Rays are up to 0.1° off, which tells by 2e-3 of the range of 0 to R_s.
            assert!(
                (got - want).abs() < 4.0 * sigma + 3e-3 * LUMINANCE * r_s,
                "{angle}° {axis}: {got} ± {sigma}, {want}"
            );
            let (got, sigma) = seen(&s, BACKWARD, Polarisation::Off, 64);
            let want = LUMINANCE * (r_s + r_p) / 2.0;
            assert!((got - want).abs() < 4.0 * sigma + 3e-3 * want, "unpolarised: {got} ± {sigma}, {want}");
        }
    }
}

/// Polarised light that a mirror sends onto a rough plate: photons bring it as they are polarised, and so find what paths
/// from the eye do; unpolarised it would be less.
#[test]
fn photons_bring_their_polarisation_to_facets() {
    let mut s = narrow();
    (s.eye.fov_deg, s.eye.resolution) = (6.0, [6, 6]);
    let glossy = StandardSurface {
        base_color: Colour::new([0.1; 3]),
        roughness: Scalar::new(0.65),
        ..StandardSurface::default()
    };
    let finish = surface(&mut s, glossy);
    sheet(&mut s, -0.3, -55.0, finish);
    // The mirror lies where the plate mirrors the line of sight to; the lamp shines onto it from the side of the plate.
    let mirror = add_part(
        &mut s,
        "mirror",
        mesh(&[quad(DVec3::ZERO, DVec3::X * 0.1, DVec3::Y * 0.1)]),
        DVec3::ZERO,
        None,
        vec![face(Finish::MirrorIdeal { reflectance: 0.9 })],
    );
    s.parts[mirror].to_world = mirrored(55.0, 0.15);
    // Beside that line, so that it does not stand in the light; its image in the mirror is 19° off it.
    let beside = DAffine3::from_translation(DVec3::new(0.09, 0.0, -0.05));
    let turned = DAffine3::from_rotation_x(180f64.to_radians());
    panel_along(&mut s, DVec3::X, mirrored(55.0, 0.0) * beside * turned, 0.05);
    let (want, sigma) = seen(&s, BACKWARD, Polarisation::Auto, 4096);
    let (plain, _) = seen(&s, BACKWARD, Polarisation::Off, 1024);
    assert!(sigma < 0.02 * want, "noise {sigma} of {want}");
    assert!((want - plain).abs() > 8.0 * sigma, "nothing is to be seen of the polarisation: {want}, {plain}");
    let (got, noise) = seen(&s, Choice::Only(Estimator::Photon), Polarisation::Auto, 64);
    println!("{got} ± {noise}, want {want} ± {sigma}, unpolarised {plain}");
    assert!(noise < 0.03 * want, "noise {noise} of {want}");
    assert!((got - want).abs() < 4.0 * noise.hypot(sigma), "{got} ± {noise}, want {want} ± {sigma}");
}

/// Of two polarisations in the axes of the room.
pub type Jones = [[Complex; 2]; 2];

pub fn times(a: Jones, b: Jones) -> Jones {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j]))
}

/// `along` and `across` of a direction at `degrees` from x.
pub fn jones(degrees: f64, along: Complex, across: Complex) -> Jones {
    let (s, c) = degrees.to_radians().sin_cos();
    let real = |x: f64| Complex { re: x, im: 0.0 };
    let mixed = (along - across) * real(s * c);
    [[along * real(c * c) + across * real(s * s), mixed], [mixed, along * real(s * s) + across * real(c * c)]]
}

pub fn real(x: f64) -> Complex {
    Complex { re: x, im: 0.0 }
}

/// A display's circular light through a half mirror and a wave plate, back from a reflective polariser, back from the half
/// mirror, and out: main image, and the ghosts that a wave plate off a quarter lets through, by Jones calculus in the axes of
/// the room (where a mirror turns the field's sign, and a sheet is the same from both sides).
#[test]
fn the_folded_path_of_a_pancake_lens() {
    for (retardance_deg, rp_axis_deg) in [(90.0f64, 90.0f64), (88.0, 0.0), (70.0, 20.0)] {
        let mut s = narrow();
        let waves = retardance_deg / 360.0;
        let retarder = |degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            Finish::Retarder { axis: DVec3::new(cos, sin, 0.0), retardance_nm: 550.0 * waves }
        };
        let (sin, cos) = rp_axis_deg.to_radians().sin_cos();
        let axis = DVec3::new(cos, sin, 0.0);
        let (t, t_leak, r, r_leak) = (0.9, 0.01, 0.95, 0.02);
        let polariser = Finish::ReflectivePolariser {
            projected_axis: ProjectedAxis::Absorption, axis,
            transmittance: t,
            transmittance_leak: t_leak,
            reflectance: r,
            reflectance_leak: r_leak,
        };
        sheet(&mut s, -0.10, 0.0, polariser);
        sheet(&mut s, -0.15, 0.0, retarder(45.0));
        // The half mirror: a coating on a plate of the index of air.
        let law = CoatingLaw::Ideal { reflectance: 0.5, transmittance: 0.45 };
        s.coatings.push(Coating { name: "half".to_owned(), law });
        let clear = face(Finish::Polished);
        let mut faces = vec![clear.clone(); 6];
        faces[5].coating = Some(CoatingId::from_index(0));
        let body = mesh(&cuboid(DVec3::new(1.0, 1.0, 0.005)));
        add_part(&mut s, "half mirror", body, DVec3::new(0.0, 0.0, -0.2), Some(1.0), faces);
        sheet(&mut s, -0.25, 0.0, retarder(45.0));
        panel(&mut s, DAffine3::from_translation(DVec3::new(0.0, 0.0, -0.3)), 0.1);

        let delta = retardance_deg.to_radians();
        let wave = jones(45.0, Complex { re: delta.cos(), im: delta.sin() }, real(1.0));
        let through = jones(rp_axis_deg, real(t.sqrt()), real(t_leak.sqrt()));
        let back = jones(rp_axis_deg, real(-r_leak.sqrt()), real(-r.sqrt()));
        let mirror = jones(0.0, real(-0.5f64.sqrt()), real(-0.5f64.sqrt()));
        let first = jones(0.0, real(0.45f64.sqrt()), real(0.45f64.sqrt()));
        // Before the reflective polariser after any number of rounds.
        let mut here = times(wave, times(first, wave));
        let mut want = 0.0;
        for _ in 0..40 {
            let out = times(through, here);
            want += LUMINANCE * (out[0][0].norm_sq() + out[1][0].norm_sq());
            here = times(times(wave, times(mirror, wave)), times(back, here));
        }
        let (got, sigma) = seen(&s, BACKWARD, Polarisation::Auto, 4096);
        println!("{retardance_deg}° {rp_axis_deg}°: {got} ± {sigma}, want {want}");
        assert!(sigma < 0.02 * LUMINANCE, "noise {sigma}");
        assert!((got - want).abs() < 4.0 * sigma + 1e-3 * want, "{got} ± {sigma}, want {want}");
    }
}

fn circular(s: &mut Scene, z: f64, waves: f64, right: bool, front: bool) {
    let retardance = Retardance::Waves(vec![[550.0, waves]]);
    s.wave_plates.push(WavePlate { retardance, indices: None });
    let plate = eyebox::base::ids::WavePlateId::from_index(s.wave_plates.len() - 1);
    let finish = Finish::CircularPolariser { axis: DVec3::X, projected_axis: ProjectedAxis::Absorption, transmittance: 1.0, extinction: 0.0, right, front, plate };
    sheet(s, z, 0.0, finish);
}

/// Circular polarisers: what one sends out with its plate ahead passes another of the same hand from the plate's side and no
/// other; linear light behind a plate at −45° turns clockwise for who looks against it, which is right; and a mirror behind a
/// plate of δ shows cos² δ of what the polariser lets through.
#[test]
fn circular_polarisers_know_left_from_right() {
    let close = |s: &Scene, want: f64, what: &str| {
        let (got, sigma) = seen(s, BACKWARD, Polarisation::Auto, 64);
        println!("{what}: {got} ± {sigma}, want {want}");
        assert!((got - want).abs() < 4.0 * sigma + 1e-5 * LUMINANCE, "{what}: {got} ± {sigma}, want {want}");
    };
    for (one, two) in [(true, true), (true, false), (false, true), (false, false)] {
        let mut s = narrow();
        circular(&mut s, -0.2, 0.25, two, true);
        circular(&mut s, -0.3, 0.25, one, false);
        panel(&mut s, DAffine3::from_translation(DVec3::new(0.0, 0.0, -0.4)), 0.1);
        // The panel's light is polarised along the pass axis of the first.
        close(&s, if one == two { LUMINANCE } else { 0.0 }, &format!("right {one}, right {two}"));
        let mut s = narrow();
        circular(&mut s, -0.2, 0.25, two, true);
        let clockwise = DVec3::new(1.0, if one { -1.0 } else { 1.0 }, 0.0);
        sheet(&mut s, -0.3, 0.0, Finish::Retarder { axis: clockwise, retardance_nm: 137.5 });
        panel(&mut s, DAffine3::from_translation(DVec3::new(0.0, 0.0, -0.4)), 0.1);
        close(&s, if one == two { LUMINANCE } else { 0.0 }, &format!("a plate, right {one}, right {two}"));
    }
    for (degrees, right) in [(90.0f64, true), (88.0, false), (60.0, true)] {
        let mut s = narrow();
        uniform_sky(&mut s, LUMINANCE as f32);
        circular(&mut s, -0.2, degrees / 360.0, right, true);
        sheet(&mut s, -0.3, 0.0, Finish::MirrorIdeal { reflectance: 1.0 });
        close(&s, 0.5 * LUMINANCE * degrees.to_radians().cos().powi(2), &format!("a mirror behind {degrees}°"));
    }
}
