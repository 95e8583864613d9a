//! Borders between the pixels of a sky's picture, seen straight, through a plate, in a mirror: closed forms, and plain sampling that
//! leaves them to chance.

use crate::common::pixels::{Both, add_mirror, add_plate, mean_drawn, over_disc, over_square, traced};
use crate::common::*;
use eyebox::film::plan::Spectral;
use eyebox::plan::Polarisation;
use eyebox::scene::*;
use glam::{DMat3, DQuat, DVec2, DVec3};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

const BRIGHT: f64 = 5000.0;
const DARK: f64 = 200.0;

/// Puts a sky behind a scene: luminance and, if any, colour by column and row.
fn sky(s: &mut Scene, [width, height]: [usize; 2], of: impl Fn(usize, usize) -> [f64; 3], colour: bool) {
    let group = add_group(s, "sky");
    // Without a surface there is nothing to trace: one too small to be seen.
    let speck = mesh(&[quad(DVec3::ZERO, DVec3::X * 1e-6, DVec3::Y * 1e-6)]);
    add_part(s, "speck", speck, DVec3::Z * 5.0, None, vec![face(Finish::Absorber)]);
    let pixels: Vec<[f64; 3]> = (0..width * height).map(|k| of(k % width, k / width)).collect();
    let y = |[r, g, b]: [f64; 3]| (0.212_639 * r + 0.715_169 * g + 0.072_192 * b) as f32;
    s.sky = Some(Sky {
        group,
        width,
        height,
        luminance: Arc::new(pixels.iter().map(|rgb| y(*rgb)).collect()),
        rgb: colour.then(|| Arc::new(pixels.iter().map(|rgb| rgb.map(|c| c as f32)).collect())),
        to_world: DMat3::from_quat(DQuat::from_rotation_z(0.2) * DQuat::from_rotation_x(-0.15)),
        file: "sky.exr".to_owned(),
    });
}

const PIXELS: [usize; 2] = [16, 12];
const COLUMNS: usize = 16;

/// A border before a column of the sky's picture, seen at a height (rad) by an eye that is rolled (rad) and has it `shift` pixels to the
/// left of its middle. A meridian is a straight line in the eye's picture, however much of it that shows.
struct Meridian {
    column: usize,
    height: f64,
    roll: f64,
    shift: f64,
    /// Side of a pixel, tangents.
    pixel: f64,
    pupil_m: f64,
    focus_m: f64,
}

impl Meridian {
    /// The scene, and the direction across the border to its own right: to the right and down in the eye's picture.
    fn scene(&self) -> (Scene, DVec2) {
        let mut s = scene();
        sky(&mut s, [COLUMNS, 1], |column, _| [if column.is_multiple_of(2) { BRIGHT } else { DARK }; 3], false);
        let to_world = s.sky.as_ref().unwrap().to_world;
        let longitude = PI - TAU * self.column as f64 / COLUMNS as f64;
        let at = |height: f64| {
            let (sin, cos) = longitude.sin_cos();
            to_world * DVec3::new(sin * height.cos(), height.sin(), cos * height.cos())
        };
        let (look, north) = (at(self.height), at(self.height + 0.5 * PI));
        let up = DQuat::from_axis_angle(look, self.roll) * north;
        let (right, east) = (look.cross(up), look.cross(north));
        let normal = DVec2::new(east.dot(right), -east.dot(up));
        let look = (look + right * (self.shift * self.pixel)).normalize();
        let up = (up - look * look.dot(up)).normalize();
        s.eye = Eye {
            look,
            up,
            pupil_diameter_m: self.pupil_m,
            focus_distance_m: self.focus_m,
            fov_deg: 2.0 * (0.5 * PIXELS[0] as f64 * self.pixel).atan().to_degrees(),
            resolution: PIXELS,
            ..s.eye
        };
        // The line seen by the eye that has turned.
        let line = DVec3::new(east.dot(look), east.dot(look.cross(up)), -east.dot(up));
        let across = DVec2::new(line.y, line.z);
        assert!((across.normalize() - normal).length() < 0.3);
        (s, DVec2::from_array([line.x / self.pixel / across.length(), across.to_angle()]))
    }

    /// What each pixel has of the bright side, and is to be seen at.
    fn want(&self, line: DVec2) -> Vec<(f64, f64)> {
        let normal = DVec2::from_angle(line.y);
        let (a, b) = (normal.x.abs(), normal.y.abs());
        let beyond = |x: f64| {
            if a.min(b) < 1e-9 {
                return (x + 0.5).clamp(0.0, 1.0);
            }
            over_square(normal, x, |x| 0.5 * x * x)
        };
        // The picture moves by the place in the pupil over the focus distance: chords of a disc.
        let blur = 0.5 * self.pupil_m / self.focus_m / self.pixel;
        let share = |k: usize| {
            let middle = DVec2::new((k % PIXELS[0]) as f64 - 7.5, (k / PIXELS[0]) as f64 - 5.5);
            let inside = middle.dot(normal) + line.x;
            let right = over_disc(blur, |moved| beyond(inside + moved));
            if self.column.is_multiple_of(2) { right } else { 1.0 - right }
        };
        (0..PIXELS[0] * PIXELS[1]).map(share).map(|share| (share, DARK + (BRIGHT - DARK) * share)).collect()
    }

    /// By how much each pixel is off after one pass, as a share of the bright side, and how many see both.
    fn off(&self, seed: u64, plain: bool) -> (Vec<f64>, usize) {
        let (s, line) = self.scene();
        let want = self.want(line);
        let grey = want.iter().filter(|(share, _)| (0.02..0.98).contains(share)).count();
        let image = image(&traced(&s, Polarisation::Off, (1, seed), plain).0);
        (image.iter().zip(want).map(|((got, _), (_, want))| (got - want) / BRIGHT).collect(), grey)
    }
}

/// So small a picture that the way from pixels to the sky's columns is linear to rounding.
#[test]
fn pixels_have_their_shares_of_both_sides_after_one_pass() {
    for (column, height, roll, shift) in
        [(6, 0.0, 0.0, 0.3), (0, 0.3, 0.35, -1.7), (9, -0.9, 1.2, 2.2), (15, 0.5, -2.8, 0.45)]
    {
        let meridian = Meridian { column, height, roll, shift, pixel: 1e-8, pupil_m: 0.0, focus_m: f64::INFINITY };
        let worst = |plain: bool| {
            let (off, grey) = meridian.off(5, plain);
            assert!(grey >= PIXELS[1], "{grey}");
            off.iter().fold(0.0, |worst: f64, off| worst.max(off.abs()))
        };
        let (ours, plain) = (worst(false), worst(true));
        println!("column {column}, height {height}, roll {roll}: worst pixel {ours:.1e}, by chance {plain:.1e}");
        assert!(ours < 1e-6 && plain > 0.1, "{ours} {plain}");
    }
}

/// In pictures of some degrees, through pupils, what is foretold is off by a hair; the mean is not.
#[test]
fn there_is_no_bias() {
    let draw =
        |k: u64, which: u64| eyebox::base::rng::Rng::new(12, eyebox::base::rng::Stream::Tolerance, which, k).uniform();
    let runs = 200;
    let of = |plain: bool| {
        let own = (0..runs).map(|k| {
            let meridian = Meridian {
                column: (draw(k, 0) * COLUMNS as f64) as usize,
                height: 1.2 * draw(k, 1) - 0.6,
                roll: TAU * draw(k, 2) + 0.01,
                shift: 6.0 * draw(k, 3) - 3.0,
                pixel: 0.016 * draw(k, 4),
                pupil_m: if k % 2 == 0 { 0.0 } else { 5e-3 * draw(k, 5) },
                focus_m: 0.3 + draw(k, 6),
            };
            let (off, _) = meridian.off(k, plain);
            off.iter().sum::<f64>() / off.len() as f64
        });
        let own: Vec<f64> = own.collect();
        mean_drawn(&own)
    };
    let ((mean, sigma), (_, chance)) = (of(false), of(true));
    println!("{mean:.2e} ± {sigma:.2e}, by chance ± {chance:.2e}");
    assert!(mean.abs() < 4.0 * sigma, "{mean} ± {sigma}");
    assert!(3.0 * sigma < chance, "too noisy to tell: {sigma} {chance}");
}

/// A sky of 200 × 100 fields that change, seen by 24 × 16 pixels of about half as much.
struct Case {
    what: &'static str,
    pupil_m: f64,
    colour: bool,
    polarised: bool,
    /// What stands before the eye.
    before: Option<Before>,
    mode: Spectral,
    /// After so many passes the squared error has to be so many times less.
    passes: u64,
    gain: f64,
}

enum Before {
    Plate(Dispersion),
    Mirror,
}

impl Case {
    fn scene(&self) -> Scene {
        let mut s = scene();
        let value = |x: usize, y: usize| {
            let levels = [BRIGHT, DARK, 1500.0];
            [0, 1, 2].map(|c| levels[(x + (c + 1) * y + c) % 3])
        };
        let grey = |x: usize, y: usize| [if (x + y).is_multiple_of(2) { BRIGHT } else { DARK }; 3];
        if self.colour {
            s.wavelengths = Wavelengths::Visible;
            sky(&mut s, [200, 100], value, true);
        } else {
            sky(&mut s, [200, 100], grey, false);
        }
        match &self.before {
            None => {}
            Some(Before::Plate(index)) => add_plate(&mut s, 0.6, index),
            Some(Before::Mirror) => add_mirror(&mut s, 0.6, 0.5),
        }
        let look = DVec3::new(0.1, 0.3, -1.0).normalize();
        s.eye = Eye {
            look,
            up: (DVec3::Y - look * look.y).normalize(),
            pupil_diameter_m: self.pupil_m,
            focus_distance_m: 0.4,
            fov_deg: 24.0,
            resolution: [24, 16],
            ..s.eye
        };
        s
    }

    fn holds(&self) {
        let Case { what, polarised, mode, .. } = *self;
        let gain = Both { what, scene: self.scene(), polarised, mode, passes: [1024, 64, self.passes] }.gain();
        assert!(gain > self.gain, "{what}: {gain}");
    }
}

const STRAIGHT: Case = Case {
    what: "straight",
    pupil_m: 0.0,
    colour: false,
    polarised: false,
    before: None,
    mode: Spectral::Mono,
    passes: 4,
    gain: 10.0,
};

#[test]
fn straight() {
    STRAIGHT.holds();
    Case { what: "through a pupil", pupil_m: 4e-3, ..STRAIGHT }.holds();
    Case { what: "in colour", colour: true, mode: Spectral::Rgb, ..STRAIGHT }.holds();
}

/// Wavelengths are new in each pass; four colours leave noise of their own.
#[test]
fn where_wavelengths_change() {
    let glass = Dispersion::Cauchy([1.5, 0.005, 0.0]);
    Case {
        what: "glass",
        before: Some(Before::Plate(glass)),
        colour: true,
        mode: Spectral::Hero,
        passes: 32,
        gain: 3.0,
        ..STRAIGHT
    }
    .holds();
}

#[test]
fn by_a_mirror() {
    Case { what: "mirror", before: Some(Before::Mirror), pupil_m: 4e-3, ..STRAIGHT }.holds();
}

#[test]
fn through_a_plate() {
    let plate = || Some(Before::Plate(Dispersion::Constant(1.5)));
    Case { what: "plate", before: plate(), ..STRAIGHT }.holds();
    Case { what: "plate, polarised", before: plate(), polarised: true, ..STRAIGHT }.holds();
    Case { what: "plate in colour", before: plate(), colour: true, mode: Spectral::Rgb, ..STRAIGHT }.holds();
}
