//! A film's means and variances against values worked out by hand.

use super::*;

const KEY: PlaneKey = PlaneKey { layer: Layer::Direct, group: GroupId(0), takes: 0 };

fn light(value: f64) -> Light {
    Light::ONE.scaled(value)
}

#[test]
fn mean_and_variance_per_pass() {
    let mut film = Film::new(1, 1, vec![KEY], Components::Luminance, Sampling::PerPass);
    for x in [1.0, 2.0, 4.0, 5.0] {
        film.rows().for_each(|(_, mut row)| row.add_pass(0, 0, &[light(x)]));
        film.passes += 1;
    }
    assert_eq!(film.mean(0, 0).value, 3.0);
    // Unbiased variance 10/3 of one value, /4 for the mean.
    assert!((film.variance(0, 0) - 10.0 / 12.0).abs() < 1e-15);
    assert_eq!(film.variance(0, 0), film.variance(0, 1));
}

/// Two pixels with alike paths lean on each other, and the variance of both together stays what the scrambles say.
#[test]
fn pixels_lean_on_their_plane() {
    let mut film = Film::new(2, 1, vec![KEY], Components::Luminance, Sampling::PerScramble { paths: 64 });
    (0..8).for_each(|s| film.splat(0, 0, s, &[light(1.0)]));
    (0..4).for_each(|s| (0..2).for_each(|_| film.splat(1, 0, s, &[light(1.0)])));
    film.passes = 1;
    let alone = [0, 1].map(|pixel| film.variance(pixel, 0));
    assert!(alone[0] < 1e-12 && (alone[1] - 64.0 / 7.0).abs() < 1e-12, "{alone:?}");
    film.settle();
    let [quiet, loud] = [0, 1].map(|pixel| film.variance(pixel, 0));
    assert!((quiet + loud - alone[1]).abs() < 1e-12 && (quiet - 0.375 * alone[1]).abs() < 1e-12);
}

/// Eight scrambles that brought 0 to 7 in one pass: their sum has the variance 8·6, and the last counts twice if it has
/// two of nine paths.
#[test]
fn variance_by_scrambles() {
    let mut film = Film::new(1, 1, vec![KEY], Components::Luminance, Sampling::PerScramble { paths: 64 });
    (0..8).for_each(|s| film.splat(0, 0, s, &[light(s as f64)]));
    film.passes = 1;
    assert_eq!(film.mean(0, 0).value, 28.0);
    assert!((film.variance(0, 0) - 8.0 * 6.0).abs() < 1e-12);
    assert_eq!(film.variance(0, 0), film.variance(0, 1));
    film.passes = 2;
    assert!((film.variance(0, 0) - 2.0 * 6.0).abs() < 1e-12);
    let mut even = Film::new(1, 1, vec![KEY], Components::Luminance, Sampling::PerScramble { paths: 9 });
    (0..8).for_each(|s| even.splat(0, 0, s, &[light(if s == 0 { 2.0 } else { 1.0 })]));
    even.passes = 1;
    assert!(even.variance(0, 0) < 1e-12);
}

/// A film takes the memory of its light: 16 bytes a sum and pixel, for tiles of 16 pixels that have any.
#[test]
fn memory_follows_the_light() {
    let (width, height, lit) = (256, 8, 3);
    let other = PlaneKey { group: GroupId(1), ..KEY };
    let bytes = |film: &Film, name: &str| -> usize {
        film.tables().iter().filter(|table| table.name == name).map(crate::serial::Table::bytes).sum()
    };
    let film = || Film::new(width, height, vec![KEY, other], Components::Luminance, Sampling::PerPass);
    let (mut filled, empty) = (film(), film());
    let mut crossing = light(2.0);
    crossing.cross(0.9, 0.5, 0.25, 0.0);
    for (y, mut row) in filled.rows() {
        for x in 0..width {
            let led = if y < lit { crossing } else { Light::default() };
            row.add_pass(x, 0, &[light(1.0), led]);
        }
    }
    filled.close(0, 1);
    let grown = |name: &str| bytes(&filled, name) - bytes(&empty, name);
    // The sky's value stands for its light with the slide open; the LEDs' is value, open and once crossed.
    assert_eq!(grown("light"), 16 * width * (height + 3 * lit));
    assert_eq!(grown("squares"), 16 * width * (2 * height + lit));
    let pixel = |y: usize| y * width + 7;
    assert_eq!([filled.mean(pixel(lit), 0), filled.mean(pixel(lit), 1)], [light(1.0), Light::default()]);
    assert_eq!([filled.mean(pixel(0), 0), filled.mean(pixel(0), 1)], [light(1.0), crossing]);
}
