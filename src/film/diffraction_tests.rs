use super::*;
use crate::accumulate::{Components, Film, Sampling};
use crate::finish::{GroupInfo, finish_through};
use crate::pupil::{Aperture, Crossing};
use eyebox_base::colour::{REC709_TO_XYZ, apply, cmf};
use eyebox_base::ids::GroupId;

const NM: f64 = 550.0;
/// Pixels per λ/d in the tests of shapes.
const SCALE: f64 = 16.0;

/// J₁ by Bessel's integral, on which the trapezoidal rule converges exponentially.
fn j1(x: f64) -> f64 {
    const STEPS: usize = 256;
    (0..STEPS)
        .map(|k| {
            let tau = PI * (k as f64 + 0.5) / STEPS as f64;
            (tau - x * tau.sin()).cos()
        })
        .sum::<f64>()
        / STEPS as f64
}

/// What a disc spreads to a place (in units of λ/D), per unit of area: the Airy pattern.
fn airy(x: f64, y: f64) -> f64 {
    let v = PI * x.hypot(y);
    let shape = if v < 1e-6 { 0.5 } else { j1(v) / v };
    PI * shape * shape
}

/// What a square spreads, in units of λ/side.
fn sinc2(x: f64, y: f64) -> f64 {
    let one = |x: f64| if x == 0.0 { 1.0 } else { ((PI * x).sin() / (PI * x)).powi(2) };
    one(x) * one(y)
}

/// What pixel (0, 0) gives to pixel (i, j) of `1/SCALE` of the unit: the mean over both, by the product of two midpoint
/// rules.
fn between_pixels(psf: impl Fn(f64, f64) -> f64, i: i64, j: i64) -> f64 {
    const N: i64 = 24;
    let mut sum = 0.0;
    for a in -N + 1..N {
        for b in -N + 1..N {
            let weight = ((N - a.abs()) * (N - b.abs())) as f64 / (N * N * N * N) as f64;
            let at = |pixel: i64, sub: i64| (pixel as f64 + sub as f64 / N as f64) / SCALE;
            sum += weight * psf(at(i, a), at(j, b));
        }
    }
    sum / (SCALE * SCALE)
}

fn index(i: usize, j: usize, width: usize) -> usize {
    j * width + i
}

/// The picture of one bright pixel in the middle.
fn of_a_point(pupil: &Pupil, d_m: f64, size: [usize; 2], scale: f64) -> Vec<f64> {
    let pixel = [1e-9 * NM / d_m / scale; 2];
    let spread = Spread::new(pupil, NM, size, pixel).unwrap();
    let mut picture = vec![0.0; size[0] * size[1]];
    picture[index(size[0] / 2, size[1] / 2, size[0])] = 1.0;
    spread.apply(&mut picture, &mut vec![0.0; size[0] * size[1]]);
    picture
}

#[test]
fn a_disc_makes_the_airy_pattern() {
    let d = 4e-3;
    let n = 256;
    let got = of_a_point(&Pupil::Disc { diameter_m: d }, d, [n, n], SCALE);
    let at = |i: i64, j: i64| got[index((128 + i) as usize, (128 + j) as usize, n)];
    let peak = between_pixels(airy, 0, 0);
    for (i, j) in [(0, 0), (1, 0), (3, 2), (5, 5), (8, 0), (0, 9), (12, 1), (-7, 11), (20, -3), (40, 0)] {
        let want = between_pixels(airy, i, j);
        assert!((at(i, j) - want).abs() < 1e-4 * peak, "({i}, {j}): {} of {want}, peak {peak}", at(i, j));
    }
    // The first dark ring, 1.2197 λ/D.
    let dark = (10..30).min_by(|a, b| at(*a, 0).total_cmp(&at(*b, 0))).unwrap();
    let (before, here, after) = (at(dark - 1, 0), at(dark, 0), at(dark + 1, 0));
    let zero = dark as f64 + 0.5 * (before - after) / (before - 2.0 * here + after);
    assert!((zero / SCALE - 1.2197).abs() < 0.01, "{}", zero / SCALE);
    // Encircled energy: 1 − J₀² − J₁² = 0.838 there (Born & Wolf, section 8.5.2). Pixels on the circle are dark.
    let inside: f64 = (-30..=30i64)
        .flat_map(|j| (-30..=30i64).map(move |i| (i, j)))
        .filter(|(i, j)| (*i as f64).hypot(*j as f64) < 1.2197 * SCALE)
        .map(|(i, j)| at(i, j))
        .sum();
    assert!((inside - 0.838).abs() < 0.004, "{inside}");
}

/// A square of even light, as many paths as a pilot sees.
fn square(side_m: f64, centre: [f64; 2]) -> Vec<Crossing> {
    let steps = 300;
    let place = |k: usize, centre: f64| centre + side_m * ((k as f64 + 0.5) / steps as f64 - 0.5);
    let of = |k: usize| Crossing {
        at: [place(k % steps, centre[0]), place(k / steps, centre[1])],
        field: [(k % 7) as f64 / 7.0, (k % 11) as f64 / 11.0],
        light: 1.0,
        open: 1.0,
    };
    (0..steps * steps).map(of).collect()
}

#[test]
fn a_square_led_makes_the_square_of_sinc() {
    let side = 0.4e-3;
    let region = Aperture::of(&square(side, [0.7e-3, -1.1e-3])).unwrap();
    let pupil = Pupil::Lit(vec![(1.0, region)]);
    // A cell that the edge cuts is even inside: the area is a little too large.
    let area = pupil.area_m2() / (side * side);
    assert!((0.995..1.025).contains(&area), "{area}");
    let rms = pupil.rms_m().map(|rms| rms * 12f64.sqrt() / side - 1.0);
    assert!(rms.iter().all(|off| off.abs() < 0.01), "{rms:?}");
    let n = 256;
    let got = of_a_point(&pupil, side, [n, n], SCALE);
    let at = |i: i64, j: i64| got[index((128 + i) as usize, (128 + j) as usize, n)];
    let peak = between_pixels(sinc2, 0, 0);
    for (i, j) in [(0, 0), (2, 0), (4, 4), (0, 8), (8, 8), (12, 0), (3, -12), (-20, 0)] {
        let want = between_pixels(sinc2, i, j);
        assert!((at(i, j) - want).abs() < 0.02 * peak, "({i}, {j}): {} of {want}, peak {peak}", at(i, j));
    }
    // The first dark line, λ/side, within 2 %.
    let dark = (10..24).min_by(|a, b| at(*a, 0).total_cmp(&at(*b, 0))).unwrap();
    let (before, here, after) = (at(dark - 1, 0), at(dark, 0), at(dark + 1, 0));
    let zero = dark as f64 + 0.5 * (before - after) / (before - 2.0 * here + after);
    assert!((zero / SCALE - 1.0).abs() < 0.02, "{}", zero / SCALE);
}

/// A region that wanders over the pupil as the eye looks around the picture is no larger for that.
#[test]
fn where_the_region_lies_does_not_matter() {
    let side = 0.4e-3;
    let still = Aperture::of(&square(side, [0.0; 2])).unwrap();
    let mut wandering = square(side, [0.0; 2]);
    wandering.iter_mut().for_each(|c| (0..2).for_each(|k| c.at[k] += 0.5 * side * c.field[k]));
    let wandering = Aperture::of(&wandering).unwrap();
    let area = |of: Aperture| Pupil::Lit(vec![(1.0, of)]).area_m2();
    let (still, wandering) = (area(still), area(wandering));
    assert!((wandering / still - 1.0).abs() < 0.06, "{wandering} {still}");
}

/// A wide slit spreads less along its width, and to the same side on which it lies: rows count downwards.
#[test]
fn the_axes_are_those_of_the_picture() {
    let mut slanted = Vec::new();
    for crossing in square(0.4e-3, [0.0; 2]) {
        let [x, y] = crossing.at;
        // A thin ellipse-like band from bottom left to top right.
        if (x - y).abs() < 0.1e-3 {
            slanted.push(crossing);
        }
    }
    let pupil = Pupil::Lit(vec![(1.0, Aperture::of(&slanted).unwrap())]);
    let got = of_a_point(&pupil, 0.4e-3, [128, 128], SCALE);
    let at = |i: i64, j: i64| got[index((64 + i) as usize, (64 + j) as usize, 128)];
    // It spreads across the band: towards top left and bottom right, where row and column count alike.
    assert!(at(8, 8) > 3.0 * at(8, -8), "{} {}", at(8, 8), at(8, -8));
    assert!((at(8, 8) - at(-8, -8)).abs() < 1e-12);
}

#[test]
fn no_light_is_lost_but_over_the_edge() {
    let (d, n) = (4e-3, 128);
    let disc = Pupil::Disc { diameter_m: d };
    for scale in [0.25, 1.0, 3.0] {
        let pixel = [1e-9 * NM / d / scale; 2];
        let spread = Spread::new(&disc, NM, [n, n], pixel).unwrap();
        // The sum of all that a pixel gives.
        assert!((spread.transfer[0] - 1.0).abs() < 1e-12);
        let mut inside = vec![0.0; n * n];
        let mut edge = inside.clone();
        inside[index(n / 2, n / 2, n)] = 1.0;
        edge[index(0, n / 2, n)] = 1.0;
        spread.apply(&mut inside, &mut edge);
        assert!(inside.iter().chain(&edge).all(|v| *v >= 0.0));
        // Beyond r goes 2/(π v) of an Airy pattern, v = π r D/λ; the picture is a square about that circle.
        let outside = 1.0 - inside.iter().sum::<f64>();
        let r = n as f64 / 2.0 / scale;
        let bound = 2.0 / (PI * PI * r);
        assert!(outside < bound && outside > 0.5 * bound, "{scale}: {outside} of {bound}");
        // Half of what does not stay in its column is lost at the edge.
        let column: f64 = (0..n).map(|j| edge[index(0, j, n)]).sum();
        let stays = 0.5 + 0.5 * column;
        let got: f64 = edge.iter().sum();
        assert!((got - stays).abs() < 2.0 * bound, "{scale}: {got} of {stays}");
    }
    // Far from the edges light is kept to 1e-6 of what the tails take: an even picture stays even in its middle.
    let mut even = vec![1.0; n * n];
    Spread::new(&disc, NM, [n, n], [1e-9 * NM / d; 2]).unwrap().apply(&mut even, &mut vec![0.0; n * n]);
    let middle = even[index(n / 2, n / 2, n)];
    assert!((0.99..=1.0).contains(&middle), "{middle}");
}

#[test]
fn what_cannot_be_spread_says_why() {
    let size = [16, 8];
    let because = |pupil: &Pupil, pixel| Spread::new(pupil, NM, size, pixel).err().unwrap();
    assert!(because(&Pupil::Point, [1e-3; 2]).contains("point"));
    assert!(because(&Pupil::Disc { diameter_m: 4e-3 }, [0.1; 2]).contains("eighth of a pixel"));
    assert!(because(&Pupil::Disc { diameter_m: f64::NAN }, [1e-3; 2]).contains("eighth of a pixel"));
    assert_eq!(Aperture::of(&[]), None);
    assert_eq!(Aperture::of(&square(0.0, [0.0; 2])), None);
    let broken = vec![Crossing { at: [f64::NAN; 2], field: [f64::NAN; 2], light: f64::NAN, open: f64::NAN }; 5000];
    assert_eq!(Aperture::of(&broken), None);
}

/// The stored layers keep their promises: `hybrid` is the f32 sum, grey stays grey, the split recombines.
#[test]
fn layers_of_a_spread_picture_add_up() {
    let size = [24, 16];
    let keys = [(Layer::Direct, 1), (Layer::Forward, 0)].map(|(layer, group)| PlaneKey {
        layer,
        group: GroupId(group),
        takes: 0,
    });
    let mut film =
        Film::new(size[0], size[1], keys.to_vec(), Components::Luminance, Sampling::PerScramble { paths: 10 });
    let mut open = Light::ONE.scaled(1000.0);
    open.cross(0.9, 0.003, 0.0, 0.0);
    film.splat(index(12, 8, 24), 1, 0, &[open]);
    open.cross(0.9, 0.9, 1.0, 0.0);
    film.splat(index(13, 8, 24), 1, 0, &[open]);
    (0..24 * 16).for_each(|pixel| film.splat(pixel, 0, 0, &[Light::ONE.scaled(0.3)]));
    film.passes = 1;
    let groups =
        ["led", "sky"].map(|name| GroupInfo { name: name.into(), contrast: Some(300.0), slides: None, tint: [1.0; 3] });
    let full = Pupil::full(4e-3);
    let lit = Pupil::Lit(vec![(1.0, Aperture::of(&square(0.4e-3, [0.0; 2])).unwrap())]);
    let of =
        |group: &str, pupil: &Pupil| GroupPupil { group: group.into(), pupil: pupil.clone(), because: String::new() };
    let diffraction = Diffraction {
        pixel: [5.8e-4; 2],
        wavelengths_nm: [NM; 3],
        pupils: vec![of("led", &lit), of("sky", &full)],
        full,
        only_vision: true,
    };
    let finished = finish_through(size, &[&film], &groups, &[], &[], ColourSpace::Rec709, Some(&diffraction));
    assert!(finished.splits.iter().all(|split| split.written), "{:?}", finished.splits);
    let frame = &finished.frame;
    let [r, g, b] = frame.rgb("hybrid").unwrap();
    assert!(r == g && g == b);
    let (direct, forward) = (frame.rgb("direct").unwrap()[0], frame.rgb("forward_led").unwrap()[0]);
    assert!(r.iter().zip(direct.iter().zip(forward)).all(|(sum, (a, b))| *sum == a + b));
    // A pixel's light is now over λ/d = 2.4 pixels each way.
    assert!(forward[index(12, 7, 24)] > 0.1 * forward[index(12, 8, 24)]);
    let applied = finished.applied.unwrap();
    assert_eq!(applied.layers.len(), 2);
    let led = applied.layers.iter().find(|of| of.group == "led").unwrap();
    let stored: f64 = forward.iter().map(|v| f64::from(*v)).sum();
    let before: f64 = 3.0 + 0.9 * 3.0;
    assert!((stored / before - (1.0 - led.left)).abs() < 1e-6, "{stored} of {before}, {led:?}");
    assert!(led.by.contains("lit part") && led.left > 0.0 && led.left < 0.2, "{led:?}");
}

/// Each wavelength lies on the line from D65 through its primary.
#[test]
fn the_primaries_have_these_dominant_wavelengths() {
    let place = |[x, y, z]: [f64; 3]| [x / (x + y + z), y / (x + y + z)];
    let white = place(apply(&REC709_TO_XYZ, [1.0; 3]));
    for (c, nm) in PRIMARIES_NM.into_iter().enumerate() {
        let mut rgb = [0.0; 3];
        rgb[c] = 1.0;
        let (primary, locus) = (place(apply(&REC709_TO_XYZ, rgb)), place(cmf(nm)));
        let [a, b] = [primary, locus].map(|p| (p[1] - white[1]).atan2(p[0] - white[0]));
        assert!((a - b).abs() < 0.01, "{nm} nm: {a} {b}");
    }
}
