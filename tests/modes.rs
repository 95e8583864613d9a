//! Spectral modes and polarisation against closed forms and against each other: colours of lamps, skies, films and
//! absorbing glass by integrals over the spectrum, furnaces in every mode, Malus' law.

use crate::common::*;
use eyebox::base::Complex;
use eyebox::base::colour::{self, XYZ_TO_REC709, apply};
use eyebox::base::ids::SlideId;
use eyebox::base::stats::Moments;
use eyebox::check::check;
use eyebox::estimate::run::{Limits, run};
use eyebox::film::plan::{Estimator, Plan, Spectral};
use eyebox::plan::{Asked, Choice, Guides, Polarisation, plan};
use eyebox::scene::*;
use eyebox::world::World;
use eyebox::world::thinfilm::{Film, stack};
use glam::{DAffine3, DVec3};

const BACKWARD: Choice = Choice::Only(Estimator::Backward);
const SEEDS: u64 = 8;

/// Changes the plan before it is traced.
type Force = dyn Fn(&mut Plan);

/// Mean colour of a picture and its standard error from how seeds scatter.
fn colour_of(scene: &Scene, asked: impl Into<Asked>, force: &Force, passes: u64) -> ([f64; 3], [f64; 3]) {
    let checked = check(scene).expect("the scene is sound");
    let world = World::freeze(scene).expect("the scene can be traced");
    let mut plan = plan(&checked, &world, asked);
    force(&mut plan);
    let limits = Limits { passes: Some(passes), ..Limits::default() };
    let mut seeds = [Moments::default(); 3];
    for seed in 0..SEEDS {
        let outcome = run(&world, &plan, scene.groups.len(), scene.eye.resolution, seed, &limits, &mut ());
        for (_, _, ledger) in &outcome.films.films {
            assert!(ledger.vertex_error < 1e-12, "R + T + A misses 1 by {}", ledger.vertex_error);
            assert_eq!(ledger.invalid_paths, 0);
        }
        let frame = eyebox::estimate::picture::picture(scene, &plan, &outcome, Default::default())
            .expect("a sound picture")
            .frame;
        for (moments, name) in seeds.iter_mut().zip(["R", "G", "B"]) {
            let data = &frame.component("hybrid", name).expect("the channel").data;
            moments.add(data.iter().map(|v| f64::from(*v)).sum::<f64>() / data.len() as f64);
        }
    }
    (seeds.map(|m| m.mean), seeds.map(|m| m.stderr()))
}

fn spectral(mode: Spectral) -> impl Fn(&mut Plan) {
    move |plan| plan.mode.spectral = mode
}

/// Each channel within 4 standard errors, which must be below `noise` of the largest channel; f32 rounds the picture.
fn assert_colour(name: &str, (got, sigma): ([f64; 3], [f64; 3]), want: [f64; 3], noise: f64) {
    let largest = want.iter().fold(0.0f64, |a, b| a.max(b.abs()));
    println!("{name}: {got:.5?} ± {sigma:.5?}, want {want:.5?}");
    for c in 0..3 {
        assert!(sigma[c] <= noise * largest, "{name}: noise {sigma:?}");
        let allowed = 4.0 * sigma[c] + 1e-6 * largest;
        assert!((got[c] - want[c]).abs() <= allowed, "{name}: {got:?} ± {sigma:?}, want {want:?}");
    }
}

fn visible() -> Scene {
    let mut s = scene();
    s.wavelengths = Wavelengths::Visible;
    s.eye.fov_deg = 0.5;
    s.eye.resolution = [4, 4];
    s
}

/// A panel of 1000 cd/m² that fills the view.
fn panel(s: &mut Scene, spectrum: Spectrum) {
    let group = add_group(s, "panel");
    let mut face = face(Finish::Absorber);
    face.emitter = lamp(group, 1000.0).map(|emitter| Emitter { spectrum: Some(spectrum), ..emitter });
    let wide = mesh(&[quad(DVec3::ZERO, DVec3::X * 2.0, DVec3::Y * 2.0)]);
    add_part(s, "panel", wide, DVec3::new(0.0, 0.0, -6.0), None, vec![face]);
}

/// A plate across the view, tilted about x.
fn plate(s: &mut Scene, degrees: f64, thickness: f64, face: Face) -> usize {
    let at = DVec3::new(0.0, 0.0, -0.5);
    let body = mesh(&cuboid(DVec3::new(2.0, 2.0, thickness / 2.0)));
    let part = add_part(s, "plate", body, at, Some(1.5), vec![face; 6]);
    s.parts[part].to_world = DAffine3::from_translation(at) * DAffine3::from_rotation_x(degrees.to_radians());
    part
}

/// Rec.709 of `transmittance(nm)` times the panel's light, by the sum over nm.
fn through(spectrum: &Spectrum, transmittance: impl Fn(f64) -> f64) -> [f64; 3] {
    let power = spectrum.resolve().expect("a spectrum").luminous_normalised();
    let filtered = colour::grid(|nm| 1000.0 * power.at(nm) * transmittance(nm));
    apply(&XYZ_TO_REC709, colour::xyz(&filtered))
}

const LED: Spectrum = Spectrum::Led(Led::B3);

/// A display shows each primary of its picture at its share of white's.
#[test]
fn displays_have_the_colours_of_their_pictures() {
    let mut s = visible();
    panel(&mut s, Spectrum::D65);
    let rgb = [0.8f32, 0.3, 0.1];
    let pixels = 4;
    s.slides.push(Slide {
        width: 2,
        height: 2,
        pixels: vec![0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]; pixels].into(),
        rgb: Some(vec![rgb; pixels].into()),
        size: [4.0, 4.0],
        transmittance: 0.5,
        ..mottled_slide(20.0)
    });
    s.parts[0].faces[0].slide = Some(SlideId::from_index(0));
    let white = through(&Spectrum::D65, |_| 1.0);
    let want: [f64; 3] = std::array::from_fn(|c| white[c] * 0.5 * (0.05 + 0.95 * f64::from(rgb[c])));
    assert_colour("display", colour_of(&s, BACKWARD, &spectral(Spectral::Rgb), 16), want, 2e-3);
}

/// A lamp seen directly has its colour, whatever the mode.
#[test]
fn lamps_have_their_colours() {
    for spectrum in [Spectrum::D65, Spectrum::A, LED, Spectrum::Led(Led::Rgb1), Spectrum::Rgb([0.2, 0.9, 0.1])] {
        let mut s = visible();
        panel(&mut s, spectrum.clone());
        let want = through(&spectrum, |_| 1.0);
        for mode in [Spectral::Mono, Spectral::Rgb, Spectral::Hero] {
            let name = format!("{spectrum} {}", mode.name());
            assert_colour(&name, colour_of(&s, BACKWARD, &spectral(mode), 64), want, 2e-3);
        }
        let checked = check(&s).expect("sound");
        let world = World::freeze(&s).expect("sound");
        assert_eq!(plan(&checked, &world, Choice::Auto).mode.spectral, Spectral::Mono, "{spectrum}");
    }
}

/// A coloured sky, straight and by reflection in a grey mirror.
#[test]
fn skies_have_their_colours() {
    let mut s = visible();
    uniform_sky(&mut s, 100.0);
    let rgb = [30.0, 120.0, 60.0];
    if let Some(sky) = &mut s.sky {
        let pixels = sky.luminance.len();
        sky.luminance = std::sync::Arc::new(vec![eyebox::base::colour::luminance(rgb) as f32; pixels]);
        sky.rgb = Some(std::sync::Arc::new(vec![rgb.map(|c| c as f32); pixels]));
    }
    let mirror = mesh(&[quad(DVec3::ZERO, DVec3::X * 2.0, DVec3::Y * 2.0)]);
    let part =
        add_part(&mut s, "mirror", mirror, DVec3::NEG_Z, None, vec![face(Finish::MirrorIdeal { reflectance: 0.5 })]);
    s.parts[part].to_world *= DAffine3::from_rotation_x(0.5);
    for mode in [Spectral::Rgb, Spectral::Hero] {
        let got = colour_of(&s, BACKWARD, &spectral(mode), 64);
        assert_colour(mode.name(), got, rgb.map(|c| 0.5 * c), 2e-3);
    }
    let (checked, world) = (check(&s).expect("sound"), World::freeze(&s).expect("sound"));
    assert_eq!(plan(&checked, &world, Choice::Auto).mode.spectral, Spectral::Rgb);
}

/// Absorbing glass whose absorption depends on the wavelength, and a film, under 40°: s and p apart, averaged last.
#[test]
fn films_and_coloured_glass() {
    let index = 1.5;
    let film = FilmLayer { index: Dispersion::Constant(2.1), thickness_nm: 120.0 };
    let table = vec![[400.0, 50.0], [500.0, 5.0], [600.0, 150.0], [700.0, 100.0]];
    let (degrees, thickness) = (40.0f64, 0.004);
    let mut s = visible();
    panel(&mut s, LED);
    let mut coated = face(Finish::Polished);
    s.coatings.push(Coating::stack("film", vec![film]));
    coated.coating = Some(eyebox::base::ids::CoatingId::from_index(0));
    let part = plate(&mut s, degrees, thickness, coated);
    let absorption = Absorption::Table(table);
    let medium = s.parts[part].medium.expect("glass");
    s.media[medium.index()].absorption = absorption.clone();
    let cos = degrees.to_radians().cos();
    let cos_in = (1.0 - (degrees.to_radians().sin() / index).powi(2)).sqrt();
    let transmittance = |nm: f64| {
        let films = [Film { n: Complex::real(2.1), thickness_nm: 120.0 }];
        let power = stack(1.0, &films, Complex::real(index), cos, nm);
        let inside = (-absorption.per_m(nm) * thickness / cos_in).exp();
        let slab = |r: f64, t: f64| t * t * inside / (1.0 - r * r * inside * inside);
        0.5 * (slab(power.r_s, power.t_s) + slab(power.r_p, power.t_p))
    };
    let want = through(&LED, transmittance);
    let got = colour_of(&s, BACKWARD, &|plan| assert_eq!(plan.mode.spectral, Spectral::Hero), 256);
    assert_colour("coated, coloured", got, want, 3e-3);
    // The test bites: without the film it would be another colour.
    let bare = through(&LED, |nm| transmittance(nm) * 0.99 + 0.01);
    assert!((bare[1] - want[1]).abs() > 3.0 * 4.0 * got.1[1], "{bare:?}");
}

/// A panel behind a plate that disperses, straight and through a green film: which wavelengths a run draws is hardly a doubt, so the
/// stated error is small after few passes, and the mean of each seed is within it.
#[test]
fn wavelengths_that_lead_in_turn_are_no_doubt() {
    let index = |nm: f64| Dispersion::Cauchy([1.5, 0.02, 0.0]).index(nm).re;
    let rows = (360..=830).step_by(5).map(|nm| [f64::from(nm), 100.0 * ((f64::from(nm) - 550.0) / 40.0).powi(2)]);
    let green = Absorption::Table(rows.collect());
    for filtered in [false, true] {
        let mut s = visible();
        s.eye.fov_deg = 0.01;
        panel(&mut s, Spectrum::D65);
        let part = plate(&mut s, 0.0, 0.004, face(Finish::Polished));
        let medium = s.parts[part].medium.expect("glass").index();
        s.media[medium].index = Dispersion::Cauchy([1.5, 0.02, 0.0]);
        if filtered {
            s.media[medium].absorption = green.clone();
        }
        // What is reflected inside is filtered twice more.
        let transmittance = |nm: f64| {
            let inside = if filtered { (-0.004 * green.per_m(nm)).exp() } else { 1.0 };
            let r = ((index(nm) - 1.0) / (index(nm) + 1.0)).powi(2);
            (1.0 - r).powi(2) * inside / (1.0 - (r * inside).powi(2))
        };
        let want = colour::luminance(through(&Spectrum::D65, transmittance));
        let (checked, world) = (check(&s).expect("sound"), World::freeze(&s).expect("sound"));
        let plan = plan(&checked, &world, BACKWARD);
        assert_eq!(plan.mode.spectral, Spectral::Hero);
        assert!(world.disperses);
        for passes in [4, 16, 24] {
            let limits = Limits { passes: Some(passes), ..Limits::default() };
            for seed in 0..SEEDS {
                let outcome = run(&world, &plan, s.groups.len(), s.eye.resolution, seed, &limits, &mut ());
                let stated = outcome.films.relative_error().expect("passes tell");
                let frame = eyebox::estimate::picture::picture(&s, &plan, &outcome, Default::default()).expect("sound");
                let channel = |name: &str| frame.frame.component("hybrid", name).expect("the channel").data[5];
                let off = colour::luminance(["R", "G", "B"].map(|name| f64::from(channel(name)))) / want - 1.0;
                println!("filtered {filtered}, {passes} passes: off by {off:.2e}, states {stated:.2e}");
                assert!(off.abs() < 3.0 * stated + 1e-4, "{passes} passes, seed {seed}: {off} with {stated}");
                let most = if filtered { [0.1, 0.03, 0.02] } else { [0.02, 5e-3, 5e-3] };
                let most = most[if passes < 16 { 0 } else { usize::from(passes > 16) + 1 }];
                assert!(stated < most, "{passes} passes, seed {seed}: states {stated}");
            }
        }
    }
}

/// In a uniform world nothing lossless can be seen: glass that disperses, films, films that split s and p, in all modes.
#[test]
fn furnaces() {
    for (coating, disperses) in [(false, false), (false, true), (true, true)] {
        let mut s = visible();
        s.eye.fov_deg = 20.0;
        uniform_sky(&mut s, 100.0);
        let mut ball = face(Finish::Polished);
        ball.shape = ball_shape(0.1);
        if coating {
            let film = FilmLayer { index: Dispersion::Constant(2.1), thickness_nm: 120.0 };
            s.coatings.push(Coating::stack("film", vec![film]));
            ball.coating = Some(eyebox::base::ids::CoatingId::from_index(0));
        }
        let part =
            add_part(&mut s, "ball", sphere_mesh(0.1, 24, 48), DVec3::new(0.0, 0.0, -0.4), Some(1.5), vec![ball]);
        let medium = s.parts[part].medium.expect("glass");
        if disperses {
            s.media[medium.index()].index = Dispersion::Cauchy([1.5, 0.01, 0.0]);
        }
        for mode in [Spectral::Mono, Spectral::Rgb, Spectral::Hero] {
            for polarised in [false, true] {
                let force = move |plan: &mut Plan| {
                    plan.mode.spectral = mode;
                    plan.mode.polarised = polarised;
                };
                let name = format!("coating {coating}, disperses {disperses}, {} {polarised}", mode.name());
                assert_colour(&name, colour_of(&s, BACKWARD, &force, 64), [100.0; 3], 1e-3);
            }
        }
    }
}

/// Two polarisers at an angle, a wave plate between crossed ones, and a polarised slide behind one: Malus' law and
/// sin² 2θ sin² δ/2.
#[test]
fn malus() {
    let sheet = |s: &mut Scene, z: f64, finish: Finish| {
        let wide = mesh(&[quad(DVec3::ZERO, DVec3::X * 2.0, DVec3::Y * 2.0)]);
        add_part(s, &format!("sheet at {z}"), wide, DVec3::new(0.0, 0.0, z), None, vec![face(finish)]);
    };
    let axis = |degrees: f64| DVec3::new(degrees.to_radians().cos(), degrees.to_radians().sin(), 0.0);
    let polariser = |degrees: f64| Finish::Polariser { axis: axis(degrees), projected_axis: ProjectedAxis::Absorption, transmittance: 0.9, extinction: 0.01 };
    for (one, two) in [(0.0, 0.0), (0.0, 30.0), (20.0, 65.0), (10.0, 100.0)] {
        let mut s = scene();
        s.eye.fov_deg = 0.5;
        s.eye.resolution = [4, 4];
        sheet(&mut s, -0.2, polariser(one));
        sheet(&mut s, -0.3, polariser(two));
        panel(&mut s, Spectrum::D65);
        let (a, b) = (0.9, 0.009);
        let cos2 = f64::cos(2.0 * f64::to_radians(two - one));
        let want = 1000.0 * 0.25 * ((a + b) * (a + b) + (a - b) * (a - b) * cos2);
        let got = colour_of(&s, BACKWARD, &|plan| assert!(plan.mode.polarised), 4);
        assert_colour(&format!("polarisers at {one}° and {two}°"), got, [want; 3], 1e-7);
    }
    let mut s = scene();
    s.eye.fov_deg = 0.5;
    s.eye.resolution = [4, 4];
    let crossed = |degrees: f64| Finish::Polariser { axis: axis(degrees), projected_axis: ProjectedAxis::Absorption, transmittance: 1.0, extinction: 0.0 };
    sheet(&mut s, -0.2, crossed(0.0));
    sheet(&mut s, -0.25, Finish::Retarder { axis: axis(30.0), retardance_nm: 100.0 });
    sheet(&mut s, -0.3, crossed(90.0));
    panel(&mut s, Spectrum::D65);
    let nm = s.wavelengths.traced_nm();
    let delta = std::f64::consts::TAU * 100.0 / nm;
    let want = 500.0 * 60f64.to_radians().sin().powi(2) * (delta / 2.0).sin().powi(2);
    assert_colour("wave plate", colour_of(&s, BACKWARD, &|_| {}, 4), [want; 3], 1e-7);
    let off = Asked { choice: BACKWARD, polarisation: Polarisation::Off, guides: Guides::On };
    assert_colour("wave plate, polarisation off", colour_of(&s, off, &|_| {}, 4), [250.0; 3], 1e-7);
}

/// The same with a rough ball, whose tables are good to about 1e-4 a bounce, and with a coating of which only shares are
/// known: in every mode nothing lossless is seen.
#[test]
fn furnaces_of_rough_glass_and_measured_coatings() {
    for (rough, disperses) in [(true, false), (true, true), (false, false)] {
        let mut s = visible();
        s.eye.fov_deg = 20.0;
        uniform_sky(&mut s, 100.0);
        let mut ball = face(if rough { Finish::Rough { alpha: 0.3 } } else { Finish::Polished });
        ball.shape = ball_shape(0.1);
        if !rough {
            let law = CoatingLaw::Ideal { reflectance: 0.3, transmittance: 0.7 };
            s.coatings.push(Coating { name: "ideal".to_owned(), law });
            ball.coating = Some(eyebox::base::ids::CoatingId::from_index(0));
        }
        let part =
            add_part(&mut s, "ball", sphere_mesh(0.1, 24, 48), DVec3::new(0.0, 0.0, -0.4), Some(1.5), vec![ball]);
        let medium = s.parts[part].medium.expect("glass");
        if disperses {
            s.media[medium.index()].index = Dispersion::Cauchy([1.5, 0.01, 0.0]);
        }
        for mode in [Spectral::Mono, Spectral::Rgb, Spectral::Hero] {
            if disperses && mode == Spectral::Rgb {
                continue;
            }
            let name = format!("rough {rough}, disperses {disperses}, {}", mode.name());
            let passes = if rough { 512 } else { 64 };
            assert_colour(&name, colour_of(&s, BACKWARD, &spectral(mode), passes), [100.0; 3], 1e-2);
        }
    }
}

/// A plate with the attenuation of `KHR_materials_volume` before a white sky: each primary by itself, c^(x/d).
#[test]
fn coloured_volumes_fall_by_their_primaries() {
    let (rgb, distance_m, thickness): ([f64; 3], f64, f64) = ([0.9, 0.5, 0.2], 0.01, 0.004);
    let mut s = visible();
    uniform_sky(&mut s, 100.0);
    let part = plate(&mut s, 0.0, thickness, face(Finish::Polished));
    let medium = s.parts[part].medium.expect("glass");
    s.media[medium.index()].absorption = Absorption::Colour { rgb, distance_m };
    // Straight on, r = 0.04: what comes back and what goes through both show the sky.
    let (r, t) = (0.04, 0.96);
    let want = rgb.map(|c| {
        let inside = c.powf(thickness / distance_m);
        100.0 * (r + t * t * inside * (1.0 + r * inside) / (1.0 - r * r * inside * inside))
    });
    let got = colour_of(&s, BACKWARD, &|plan| assert_eq!(plan.mode.spectral, Spectral::Rgb), 64);
    let (mean, sigma) = got;
    // The rays are up to 0.35° off the normal: a relative 1e-5 of the way.
    assert_colour("volume", (mean, sigma.map(|s| s + 1e-4)), want, 3e-3);
}
