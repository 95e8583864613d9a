//! A slanted edge between black and white on a display, seen by a pinhole and through a pupil, in focus and out of it: what each
//! pixel has of the white is known in closed form.

use crate::common::pixels::{draws, mean_drawn, over_disc, over_square};
use crate::common::*;
use eyebox::base::ids::SlideId;
use eyebox::film::plan::Estimator;
use eyebox::plan::Choice;
use eyebox::scene::*;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;
use std::sync::Arc;

const BACKWARD: Choice = Choice::Only(Estimator::Backward);
const WHITE: f64 = 800.0;
/// From the eye to the display, m.
const FAR: f64 = 0.5;
const PIXELS: [usize; 2] = [16, 12];
/// Of a pixel on the display, m.
const PIXEL: f64 = 1e-3;

/// An edge through `PIXEL` · `at` from the middle of the picture, white on the side of the angle's direction.
struct Edge {
    angle: f64,
    at: f64,
    pupil_m: f64,
    focus_m: f64,
}

impl Edge {
    fn scene(&self) -> Scene {
        let mut s = scene();
        let group = add_group(&mut s, "display");
        let u = DVec3::new(self.angle.cos(), self.angle.sin(), 0.0);
        s.slides.push(Slide {
            name: "edge".to_owned(),
            file: "edge.png".to_owned(),
            width: 2,
            height: 1,
            pixels: Arc::new(vec![0.0, 1.0]),
            rgb: None,
            centre: u * (self.at * PIXEL),
            u,
            v: DVec3::Z.cross(u),
            size: [0.2, 0.2],
            transmittance: 1.0,
            contrast: f64::INFINITY,
            polarisation: None,
            primaries: None,
        });
        let mut shining = face(Finish::Absorber);
        shining.emitter = lamp(group, WHITE);
        shining.slide = Some(SlideId::from_index(0));
        add_part(
            &mut s,
            "display",
            mesh(&[quad(DVec3::ZERO, DVec3::X * 0.3, DVec3::Y * 0.3)]),
            DVec3::ZERO,
            None,
            vec![shining],
        );
        s.eye.position = DVec3::Z * FAR;
        s.eye.focus_distance_m = self.focus_m;
        s.eye.pupil_diameter_m = self.pupil_m;
        s.eye.fov_deg = 2.0 * (0.5 * PIXELS[0] as f64 * PIXEL / FAR).atan().to_degrees();
        s.eye.resolution = PIXELS;
        s
    }

    /// White share of a pixel. Across the edge a square is the convolution of two boxes, so what of it lies beyond a line is a
    /// second difference of x²/2; through a disc of the pupil the line moves by a chord's length at a time.
    fn share(&self, pixel: usize) -> f64 {
        let middle = DVec2::new(
            (pixel % PIXELS[0]) as f64 + 0.5 - 0.5 * PIXELS[0] as f64,
            0.5 * PIXELS[1] as f64 - (pixel / PIXELS[0]) as f64 - 0.5,
        );
        let normal = DVec2::new(self.angle.cos(), self.angle.sin());
        let inside = middle.dot(normal) - self.at;
        let blur = 0.5 * self.pupil_m * (1.0 - FAR / self.focus_m).abs() / PIXEL;
        over_disc(blur, |moved| over_square(normal, inside + moved, |x| 0.5 * x * x))
    }

    /// By how much each pixel is off after so many passes, as a share of white.
    fn off(&self, passes: u64, seed: u64) -> Vec<f64> {
        let image = image(&render(&self.scene(), BACKWARD, passes, seed).0);
        image.iter().enumerate().map(|(pixel, (value, _))| value / WHITE - self.share(pixel)).collect()
    }
}

#[test]
fn each_pixel_has_its_share_of_white_after_one_pass() {
    // Where the picture moves by half a pixel from the middle of the pupil to its rim, a pass's places of the pupil are felt.
    for (what, pupil_m, focus_m, most) in [
        ("pinhole", 0.0, FAR, 1e-9),
        ("in focus", 4e-3, FAR, 1e-9),
        ("a little out of focus", 4e-3, 0.48, 1e-3),
        ("out of focus", 4e-3, 0.7, 2e-3),
    ] {
        for (angle, at) in [(0.35, 0.3), (1.2, -1.7), (-2.8, 2.2)] {
            let edge = Edge { angle, at, pupil_m, focus_m };
            let grey = (0..PIXELS[0] * PIXELS[1]).filter(|pixel| (0.02..0.98).contains(&edge.share(*pixel))).count();
            assert!(grey >= PIXELS[1], "{what}: {grey}");
            let off = edge.off(1, 3);
            let worst = off.iter().fold(0.0, |worst: f64, off| worst.max(off.abs()));
            let rms = (off.iter().map(|off| off * off).sum::<f64>() / grey as f64).sqrt();
            println!("{what} {angle} {at}: worst {worst:.2e}, rms of {grey} grey ones {rms:.2e}");
            assert!(rms < most && worst < 3.0 * most, "{what} {angle} {at}: worst {worst}, rms {rms}");
        }
    }
}

/// Over designs and seeds that are drawn the differences have no mean.
#[test]
fn there_is_no_bias() {
    let draw = draws(11);
    let runs = 100;
    let means: Vec<f64> = (0..runs)
        .map(|k| {
            let edge = Edge {
                angle: 2.0 * PI * draw(k, 0) + 0.01,
                at: 5.0 * (draw(k, 1) - 0.5),
                pupil_m: 5e-3 * draw(k, 2),
                focus_m: 0.4 + 0.4 * draw(k, 3),
            };
            let off = edge.off(1, k as u64);
            off.iter().sum::<f64>() / off.len() as f64
        })
        .collect();
    let (mean, sigma) = mean_drawn(&means);
    println!("{mean:.2e} ± {sigma:.2e}");
    assert!(sigma < 1e-4, "too noisy to tell: {sigma}");
    assert!(mean.abs() < 4.0 * sigma, "{mean} ± {sigma}");
}
