use super::*;
use eyebox_base::rng::{Rng, Stream};
use eyebox_base::stats::{Moments, sidak_z};

fn eye(focus_distance_m: f64) -> Eye {
    let look = DVec3::new(0.6, 0.0, -0.8);
    Eye {
        position: DVec3::new(1.0, 2.0, 3.0),
        look,
        up: DVec3::Y,
        pupil_diameter_m: 0.3,
        adapts: false,
        limits: eyebox_scene::BinocularLimits::default(),
        focus_distance_m,
        fov_deg: 80.0,
        resolution: [4, 3],
        age: 40.0,
    }
}

const ORIGIN: DVec3 = DVec3::new(0.5, 0.5, 0.5);

/// The documented map of scene::Eye: pixel centres look along look + ax·right + ay·up, from every pupil point.
#[test]
fn pixel_centres_look_where_the_scene_says() {
    let eye = eye(f64::INFINITY);
    let lens = EyeLens::build(&eye, ORIGIN).unwrap();
    let tan = 40f64.to_radians().tan();
    for (px, py) in [(0, 0), (3, 0), (2, 1), (1, 2)] {
        let ax = tan * (2.0 * (px as f64 + 0.5) / 4.0 - 1.0);
        let ay = tan * 0.75 * (1.0 - 2.0 * (py as f64 + 0.5) / 3.0);
        let want = (eye.look + eye.right() * ax + eye.up * ay).normalize();
        for u in [[0.5, 0.5], [0.1, 0.9], [0.99, 0.3]] {
            let (origin, dir) = lens.ray(px, py, [0.5; 2], u);
            assert!((dir - want).length() < 1e-14);
            let offset = origin - (eye.position - ORIGIN);
            assert!(offset.dot(eye.look).abs() < 1e-15 && offset.length() <= 0.15);
        }
    }
    // The top left of the picture is up and to the left.
    let (_, dir) = lens.ray(0, 0, [0.0; 2], [0.5; 2]);
    assert!(dir.dot(eye.up) > 0.0 && dir.dot(eye.right()) < 0.0);
}

/// A ray from a pixel is seen by the light that comes back along it at the same point of picture and pupil, with the flux that
/// `arrive` turns into one unit of luminance.
#[test]
fn the_unit_cube_is_that_of_rays_and_arrivals() {
    let lens = EyeLens::build(&eye(2.0), ORIGIN).unwrap();
    let mut rng = Rng::new(8, Stream::Check, 0, 0);
    for _ in 0..100 {
        let [[a, b], [c, d]] = [rng.pair(), rng.pair()];
        let x = [a, b, c, d];
        let (pixel, [film, place]) = lens.pixel_at(&x);
        let (origin, dir) = lens.ray(pixel % 4, pixel / 4, film, place);
        let arrival = lens.arrive(origin + dir, -dir, f64::INFINITY).expect("it comes back");
        assert_eq!(arrival.pixel, Some(pixel));
        let back = lens.unit_of(arrival.film, arrival.pupil);
        assert!((0..4).all(|k| (back[k] - x[k]).abs() < 1e-9), "{x:?} {back:?}");
        assert!((lens.lumens_per_luminance(dir) * arrival.luminance_per_lumen - 1.0).abs() < 1e-9);
    }
}

#[test]
fn finite_focus_meets_in_one_point_of_the_plane_of_focus() {
    let eye = eye(2.0);
    let lens = EyeLens::build(&eye, DVec3::ZERO).unwrap();
    let mut meeting = Vec::new();
    for u in [[0.5, 0.5], [0.1, 0.9], [0.99, 0.3]] {
        let (origin, dir) = lens.ray(3, 2, [0.25, 0.75], u);
        meeting.push(origin + dir * (2.0 / dir.dot(eye.look)));
    }
    assert!(meeting.iter().all(|p| (*p - meeting[0]).length() < 1e-14), "{meeting:?}");
    assert!(((meeting[0] - eye.position).dot(eye.look) - 2.0).abs() < 1e-14);
}

/// Every ray of the eye, turned round, comes back to its own pixel at its own pupil point; none of the others blocks.
#[test]
fn rays_turned_round_arrive_in_their_pixel() {
    let mut rng = Rng::new(21, Stream::Check, 0, 0);
    for focus in [f64::INFINITY, 2.0, 0.25, 1e300] {
        let lens = EyeLens::build(&eye(focus), ORIGIN).unwrap();
        for k in 0..12_000 {
            let (px, py) = (k % 4, k / 4 % 3);
            let jitter = rng.pair().map(|x| 1e-6 + (1.0 - 2e-6) * x);
            let lens_point = rng.pair().map(|x| 1e-6 + (1.0 - 2e-6) * x);
            let (origin, dir) = lens.ray(px, py, jitter, lens_point);
            let from = origin + dir * 7.0;
            let arrival = lens.arrive(from, -dir, 100.0).unwrap();
            assert!((arrival.t - 7.0).abs() < 1e-12 && arrival.pixel == Some(py * 4 + px), "{arrival:?} {px} {py}");
            assert!(lens.blocks(from, -dir, 100.0) && !lens.blocks(from, -dir, 6.9));
            assert_eq!(lens.arrive(from, -dir, 6.9), None);
            // Away from the eye, or from behind it, is no arrival.
            assert_eq!(lens.arrive(from, dir, 100.0), None);
            assert_eq!(lens.arrive(origin - dir, dir, 100.0), None);
            // Against the light: a ray from behind through the pupil is blocked, one that starts on it is not.
            assert!(lens.blocks_reversed(origin - dir, dir, 100.0));
            assert!(!lens.blocks_reversed(origin, dir, 100.0) && !lens.blocks_reversed(from, -dir, 100.0));
        }
    }
}

/// A uniform field of luminance L, sent from an aperture far larger than the field's footprint, gives every pixel L:
/// light sampled uniformly in (pupil point, point of a big window) carries L·cosθ·cosθ'/d² per unit of both areas.
#[test]
fn forward_light_gives_the_backward_luminance() {
    let luminance = 250.0;
    let count = 600_000;
    for focus in [f64::INFINITY, 2.0, 0.4] {
        let eye = eye(focus);
        let lens = EyeLens::build(&eye, ORIGIN).unwrap();
        let distance = 1.5;
        let window = DVec2::new(3.6, 3.0);
        let mut pixels = [Moments::default(); 12];
        let mut rng = Rng::new(22, Stream::Check, 0, focus.to_bits());
        let mut etendue = Moments::default();
        for _ in 0..count {
            let p = warp::disk(rng.pair()) * 0.15;
            let to = eye.position - ORIGIN + eye.right() * p.x + eye.up * p.y;
            let [a, b] = rng.pair();
            let w = (DVec2::new(a, b) * 2.0 - 1.0) * window * 0.5;
            let from = eye.position - ORIGIN + eye.look * distance + eye.right() * w.x + eye.up * w.y;
            let (dir, d) = ((to - from).normalize(), (to - from).length());
            let cos = -dir.dot(eye.look);
            let flux = luminance * cos * cos / (d * d) * lens.pupil_area_m2() * window.x * window.y;
            let arrival = lens.arrive(from, dir, f64::INFINITY).unwrap();
            for (pixel, moments) in pixels.iter_mut().enumerate() {
                moments.add(if arrival.pixel == Some(pixel) { flux * arrival.luminance_per_lumen } else { 0.0 });
            }
            etendue.add(if arrival.pixel.is_some() { flux / luminance } else { 0.0 });
        }
        for (pixel, moments) in pixels.iter().enumerate() {
            let z = (moments.mean - luminance) / moments.stderr();
            assert!(
                z.abs() < sidak_z(0.001, 36),
                "focus {focus}, pixel {pixel}: {} ± {}",
                moments.mean,
                moments.stderr()
            );
        }
        let z = (etendue.mean - lens.etendue_m2_sr()) / etendue.stderr();
        assert!(z.abs() < 4.0, "focus {focus}: {} {}", etendue.mean, lens.etendue_m2_sr());
    }
}

/// Étendue against the mean of cos⁴ over the eye's own rays, and against the closed form for a small field.
#[test]
fn etendue_of_the_rays() {
    for focus in [f64::INFINITY, 2.0, 0.4] {
        let eye = eye(focus);
        let lens = EyeLens::build(&eye, ORIGIN).unwrap();
        let mut rng = Rng::new(23, Stream::Check, 0, 0);
        let mut mean = Moments::default();
        for k in 0..240_000 {
            let (_, dir) = lens.ray(k % 4, k / 4 % 3, rng.pair(), rng.pair());
            mean.add(dir.dot(eye.look).powi(4) * lens.pupil_area_m2() * lens.cell() * 12.0);
        }
        assert!(
            (mean.mean - lens.etendue_m2_sr()).abs() < 4.0 * mean.stderr(),
            "{} {}",
            mean.mean,
            lens.etendue_m2_sr()
        );
    }
    let small = Eye { fov_deg: 0.1, resolution: [1, 1], ..eye(f64::INFINITY) };
    let want = PI * 0.15 * 0.15 * 0.1f64.to_radians().powi(2);
    assert!((EyeLens::build(&small, ORIGIN).unwrap().etendue_m2_sr() / want - 1.0).abs() < 1e-6);
}

#[test]
fn a_pinhole_sees_and_is_never_found() {
    let pinhole = Eye { pupil_diameter_m: 0.0, ..eye(2.0) };
    let lens = EyeLens::build(&pinhole, ORIGIN).unwrap();
    let (origin, dir) = lens.ray(1, 1, [0.5; 2], [0.9, 0.1]);
    assert_eq!(origin, pinhole.position - ORIGIN);
    assert_eq!(lens.arrive(origin + dir, -dir, 10.0), None);
    assert!(!lens.blocks(origin + dir, -dir, 10.0) && lens.etendue_m2_sr() == 0.0);
    assert_eq!(lens.arrive(DVec3::NAN, dir, 10.0), None);
}

#[test]
fn impossible_eyes_are_faults() {
    let good = eye(1.0);
    let bad = [
        Eye { position: DVec3::NAN, ..good.clone() },
        Eye { look: DVec3::ZERO, ..good.clone() },
        Eye { up: good.look, ..good.clone() },
        Eye { pupil_diameter_m: -1.0, ..good.clone() },
        Eye { focus_distance_m: 0.0, ..good.clone() },
        Eye { focus_distance_m: f64::NAN, ..good.clone() },
        Eye { fov_deg: 180.0, ..good.clone() },
        Eye { resolution: [0, 4], ..good.clone() },
        Eye { resolution: [usize::MAX, 4], ..good.clone() },
    ];
    for eye in bad {
        let text = EyeLens::build(&eye, ORIGIN).unwrap_err().to_string();
        assert!(text.starts_with("the eye's ") && text.contains("; expected "), "{text}");
    }
}
