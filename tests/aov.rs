//! Layers by light path expression: sums of stored shares, or of what the paths of a run say to it.

use crate::common::*;
use eyebox::base::Where;
use eyebox::base::colour::ColourSpace;
use eyebox::base::stats::Moments;
use eyebox::check::check;
use eyebox::estimate::aov::{Granted, granted, layers, parse_option};
use eyebox::estimate::finishing::Finishing;
use eyebox::estimate::picture::picture;
use eyebox::estimate::run::{Films, Limits, Start, begin, run};
use eyebox::film::aov::Aov;
use eyebox::film::error_detail::ErrorDetail;
use eyebox::film::frame::{Frame, Meta};
use eyebox::film::plan::{Estimator, Plan};
use eyebox::import::{ImportOptions, import};
use eyebox::output::light_shares::Rendering;
use eyebox::output::mix::{Recipe, mix};
use eyebox::plan::{Choice, plan};
use eyebox::scene::assembly::RequestedLayer;
use eyebox::scene::*;
use eyebox::world::World;
use glam::DVec3;
use std::path::Path;

/// A white wall beside a mirror, lit by a lamp that is seen and by a dim one that is not.
fn room() -> Scene {
    let mut s = scene();
    let (led, back) = (add_group(&mut s, "led"), add_group(&mut s, "back"));
    let square = |half: f64| mesh(&[quad(DVec3::ZERO, DVec3::X * half, DVec3::Y * half)]);
    let wall = face(Finish::Lambert { reflectance: 0.5, transmittance: 0.0 });
    add_part(&mut s, "wall", square(0.4), DVec3::NEG_Z * 2.0, None, vec![wall]);
    let turned = mesh(&[quad(DVec3::ZERO, DVec3::Y * 0.3, DVec3::Z * 0.3)]);
    let mirror = face(Finish::MirrorIdeal { reflectance: 0.9 });
    add_part(&mut s, "mirror", turned, DVec3::new(-0.3, 0.0, -1.5), None, vec![mirror]);
    for (group, place) in [(led, DVec3::new(0.1, 0.0, -1.0)), (back, DVec3::new(0.2, 0.3, 0.5))] {
        let mut panel = face(Finish::Absorber);
        panel.emitter = lamp(group, 100.0);
        let away = mesh(&[quad(DVec3::ZERO, DVec3::Y * 0.08, DVec3::X * 0.08)]);
        add_part(&mut s, "panel", away, place, None, vec![panel]);
    }
    s
}

fn with<T>(f: impl FnOnce(&Scene, &World, &Plan) -> T) -> T {
    let s = room();
    let checked = check(&s).expect("sound");
    let world = World::freeze(&s).expect("traceable");
    let plan = plan(&checked, &world, Choice::Only(Estimator::Backward));
    f(&s, &world, &plan)
}

fn asked(name: &str, lpe: &str) -> Vec<(String, String)> {
    vec![(name.to_owned(), lpe.to_owned())]
}

#[test]
fn sums_of_shares_with_their_bits() {
    let (frame, caustic, led, all) = with(|s, world, plan| {
        let limits = Limits { passes: Some(64), ..Limits::default() };
        let outcome = run(world, plan, 2, s.eye.resolution, 0, &limits, &mut ());
        let frame: Frame = picture(s, plan, &outcome, ColourSpace::Rec709).expect("a picture").frame;
        let one = |lpe: &str| {
            let Granted { aovs, notes, sieve, .. } =
                granted(&asked("mine", lpe), (&[], &[]), s, world, plan).expect(lpe);
            assert!(notes.is_empty() && sieve.is_none());
            let (channels, said) = layers(&frame, &aovs);
            assert_eq!(said[0].0, "aov.mine");
            (aovs[0].shares.clone(), channels[0].data.clone())
        };
        (frame.clone(), one("C<.[Ss]>*<.[DG]><.[Ss]>+[LOB]"), one("C.*<O.'led'>"), one("C.*"))
    });
    let red = |layer: &str| frame.rgb(layer).unwrap_or_else(|| panic!("no {layer}"))[0].to_vec();
    assert!(red("caustic").iter().any(|value| *value > 0.0), "the mirror sends light to the wall");
    assert_eq!(caustic.0, ["caustic_led", "caustic_back"]);
    assert_eq!(caustic.1, red("caustic"));
    assert_eq!(all.1, red("hybrid"));
    assert_eq!(
        led.0,
        ["direct_led", "caustic_led", "secondary_led"].map(str::to_owned).to_vec(),
        "the wall's light comes back by the mirror"
    );
}

#[test]
fn what_cannot_be_had_is_refused() {
    with(|s, world, plan| {
        let refused = |name: &str, lpe: &str| {
            granted(&asked(name, lpe), (&[], &[]), s, world, plan).map(|_| ()).unwrap_err().to_string()
        };
        assert!(refused("mine", "C.*B").contains("takes no path of this scene"));
        assert!(refused("mine", "C(").contains("`)` is missing"));
        assert!(refused("mine", "C.*<RS>.{14}L").contains("cases"));
        // The wall only reflects, and there is no glass.
        let whole = granted(&asked("mine", "C<R.>*L"), (&[], &[]), s, world, plan).expect("all that there is");
        assert!(whole.aovs[0].shares.len() == 6 && whole.sieve.is_none());
        let fault = refused("caustic_led", "C.*");
        assert!(fault.contains("there is a layer `caustic_led` already"), "{fault}");
        // Its share of `led` would be called like that of the layer.
        let fault = refused("direct", "C<RS>L");
        assert!(fault.contains("there is a layer `direct` already"), "{fault}");
        let twice = [("a", "C<RS>L"), ("a_led", "C.*")].map(|(name, lpe)| (name.to_owned(), lpe.to_owned()));
        let fault = granted(&twice, (&[], &[]), s, world, plan).map(|_| ()).unwrap_err().to_string();
        assert!(fault.contains("there is a layer `a_led` already"), "{fault}");
    });
}

/// What an asset wishes is written or noted, never a fault.
#[test]
fn wishes_of_an_asset() {
    with(|s, world, plan| {
        let wish = |source: &str, expression: bool| RequestedLayer {
            source: source.to_owned(),
            expression,
            name: "1 mine".to_owned(),
            at: Where::Nowhere,
        };
        let wishes = [wish("C.*", true), wish("C<TS>L", true), wish("Ci", false), wish("C.*L", true)];
        let Granted { aovs, notes, .. } = granted(&[], (&wishes, &[]), s, world, plan).expect("no fault");
        assert_eq!(aovs.iter().map(|aov| aov.name.as_str()).collect::<Vec<_>>(), ["layer_1_mine"]);
        assert_eq!(notes.len(), 2);
        let parted = granted(&[], (&[wish("C<RS>L", true)], &[]), s, world, plan).expect("no fault");
        assert!(parted.notes.is_empty() && parted.sieve.is_some());
    });
    assert_eq!(parse_option("a = C.*L"), Ok(("a".to_owned(), "C.*L".to_owned())));
    assert!(parse_option("1=C.*").is_err() && parse_option("a").is_err() && parse_option("a=").is_err());
}

/// A run whose paths are told to expressions.
struct Told {
    scene: Scene,
    plan: Plan,
    aovs: Vec<Aov>,
    films: Films,
}

impl Told {
    /// Passes `passes` of a run with these layers besides.
    fn run(scene: Scene, choice: Choice, lpes: &[(&str, &str)], passes: std::ops::Range<u64>) -> Told {
        Told::seeded(scene, choice, lpes, passes, 3)
    }

    fn seeded(scene: Scene, choice: Choice, lpes: &[(&str, &str)], passes: std::ops::Range<u64>, seed: u64) -> Told {
        let checked = check(&scene).expect("sound");
        let mut world = World::freeze(&scene).expect("traceable");
        let mut plan = plan(&checked, &world, choice);
        plan.errors = ErrorDetail::Layers;
        let asked: Vec<_> = lpes.iter().map(|(name, lpe)| ((*name).to_owned(), (*lpe).to_owned())).collect();
        let Granted { aovs, notes, sieve, .. } = granted(&asked, (&[], &[]), &scene, &world, &plan).expect("granted");
        assert!(notes.is_empty() && (lpes.is_empty() || sieve.is_some()));
        world.sieve = sieve;
        let mut tracing = begin(&world, &plan, scene.groups.len(), scene.eye.resolution, seed);
        assert!(tracing.start(Start::Pass(passes.start)));
        tracing.step(passes.end - passes.start);
        let films = tracing.into_films();
        Told { films, scene, plan, aovs }
    }

    fn frame(&self) -> Frame {
        let mut finishing = Finishing::new(&self.scene, &self.plan, ColourSpace::Rec709, None);
        finishing.wanted.aovs.clone_from(&self.aovs);
        let mut frame = finishing.picture(&self.films).expect("finite").frame;
        finishing.wanted.keep(&mut frame);
        let names: Vec<&str> = self.scene.groups.iter().map(|group| group.name.as_str()).collect();
        frame.meta.insert("groups".to_owned(), Meta::Text(format!("{names:?}")));
        frame
    }
}

/// Sum over the picture of a layer, and its standard error from that of the pixels.
fn total(frame: &Frame, layer: &str) -> (f64, f64) {
    let sum = |data: &[f32]| data.iter().map(|value| f64::from(*value)).sum::<f64>();
    let squares = |data: &[f32]| data.iter().map(|value| f64::from(*value).powi(2)).sum::<f64>().sqrt();
    let error = frame.rgb(&format!("{layer}_stderr")).map_or(0.0, |[data, ..]| squares(data));
    (frame.rgb(layer).map_or(0.0, |[data, ..]| sum(data)), error)
}

fn far(a: f32, b: f32, peak: f32) -> bool {
    (a - b).abs() > 4e-6 * peak
}

/// What is first seen by the mirror and what is not are the picture, group by group and pixel by pixel; the layers are those
/// of a run that nobody asked, and a pixel's light comes back when a group is dimmed.
#[test]
fn complements_are_the_picture() {
    let lpes = [("mirrored", "C<RS>.*"), ("others", "C([^S]|<TS>).*"), ("glints", "C<RD><RS><L.'back'>|C<RS>L")];
    let parted = Told::run(room(), Choice::Only(Estimator::Backward), &lpes, 0..32).frame();
    let plain = Told::run(room(), Choice::Only(Estimator::Backward), &[], 0..32).frame();
    let red = |frame: &Frame, layer: &str| frame.rgb(layer).map_or(vec![0.0; 64], |[red, ..]| red.to_vec());
    let peak = red(&plain, "hybrid").into_iter().fold(0.0, f32::max);
    for layer in ["direct", "caustic", "secondary", "hybrid", "direct_led", "caustic_back", "stderr", "caustic_stderr"]
    {
        let (a, b) = (red(&parted, layer), red(&plain, layer));
        assert!(!a.iter().zip(&b).any(|(a, b)| far(*a, *b, peak)), "{layer}: {a:?} {b:?}");
    }
    let groups: [(&str, &[&str]); 3] = [
        ("", &["hybrid"]),
        ("_led", &["direct_led", "caustic_led", "secondary_led"]),
        ("_back", &["direct_back", "caustic_back", "secondary_back"]),
    ];
    for (group, layers) in groups {
        let [a, b] = ["mirrored", "others"].map(|name| red(&parted, &format!("{name}{group}")));
        assert!(a.iter().chain(&b).any(|value| *value > 0.0));
        let layers: Vec<Vec<f32>> = layers.iter().map(|layer| red(&plain, layer)).collect();
        for pixel in 0..64 {
            let want: f32 = layers.iter().map(|data| data[pixel]).sum();
            assert!(!far(a[pixel] + b[pixel], want, peak), "{group} {pixel}: {} + {} = {want}", a[pixel], b[pixel]);
        }
    }
    let [both, caustic, seen] = [red(&parted, "glints"), red(&plain, "caustic_back"), red(&parted, "mirrored")];
    assert!(both.iter().zip(&caustic).all(|(both, caustic)| both >= caustic));
    assert!(total(&parted, "glints").0 < f64::from(caustic.iter().chain(&seen).sum::<f32>()));
    // Another gain of one group.
    let mixed = mix(
        &Rendering::of(&parted).expect("a rendering"),
        &Recipe { gains: vec![("led".to_owned(), 3.0)], ..Recipe::default() },
    )
    .expect("a gain")
    .frame;
    for name in ["mirrored", "glints"] {
        let want = |pixel: usize| {
            3.0 * red(&parted, &format!("{name}_led"))[pixel] + red(&parted, &format!("{name}_back"))[pixel]
        };
        let got = red(&mixed, name);
        assert!((0..64).all(|pixel| !far(got[pixel], want(pixel), peak)), "{name}");
        assert!(mixed.rgb(&format!("{name}_stderr")).is_some());
    }
}

/// A pane of high index before a lamp: what goes straight through it, and what is reflected twice inside of it.
fn pane() -> Scene {
    let mut s = scene();
    let led = add_group(&mut s, "led");
    let mut panel = face(Finish::Absorber);
    panel.emitter = lamp(led, 1000.0);
    let toward = mesh(&[quad(DVec3::ZERO, DVec3::X * 0.02, DVec3::Y * 0.02)]);
    add_part(&mut s, "panel", toward, DVec3::NEG_Z * 0.2, None, vec![panel]);
    let polished = vec![face(Finish::Polished); 6];
    let glass = mesh(&cuboid(DVec3::new(0.05, 0.05, 1e-4)));
    add_part(&mut s, "pane", glass, DVec3::NEG_Z * 0.1, Some(INDEX), polished);
    s.eye.pupil_diameter_m = 0.008;
    s
}

const INDEX: f64 = 4.0;

/// At right angles Fresnel's R = ((n − 1)/(n + 1))² is reflected at each face: of what comes through the share 1 − R² comes
/// straight and (1 − R²)R² after two reflections. Here angles are up to 8° off, which changes R by 1e-4 of itself.
#[test]
fn a_pane_by_fresnel_from_either_end() {
    let lpes = [("straight", "C<TS>{2}O"), ("twice", "C<TS><RS>{2}<TS>O"), ("even", "C<TS>(<RS>{2})*<TS>O")];
    let r2 = ((INDEX - 1.0) / (INDEX + 1.0)).powi(4);
    let mut light = Vec::new();
    for (choice, passes) in [(Estimator::Backward, 64), (Estimator::Forward, 64)] {
        let frame = Told::run(pane(), Choice::Only(choice), &lpes, 0..passes).frame();
        let whole = total(&frame, "hybrid").0;
        let all = total(&frame, "even").0;
        assert!(whole > 0.0 && (all - whole).abs() < 1e-5 * whole, "{choice:?}: {all} of {whole}");
        let parts = ["straight", "twice"].map(|name| total(&frame, name));
        for ((value, error), want) in parts.into_iter().zip([1.0 - r2, (1.0 - r2) * r2]) {
            let (share, sigma) = (value / whole, error / whole);
            // The lamp's image is the same for both but for 0.05 % of its size.
            assert!((share - want).abs() < 4.0 * sigma + 1e-3 * want, "{choice:?}: {share} ± {sigma}, not {want}");
            assert!(sigma < 0.15 * want, "{choice:?}: {share} ± {sigma} says nothing");
        }
        light.push(parts);
    }
    for ((a, sa), (b, sb)) in light[0].into_iter().zip(light[1]) {
        assert!((a - b).abs() < 4.0 * sa.hypot(sb), "{a} ± {sa} {b} ± {sb}");
    }
}

/// Passes in pieces, added up in another order, are the run to the last bit of every channel.
#[test]
fn pieces_are_the_run() {
    let lpes = [("straight", "C<TS>{2}O"), ("twice", "C<TS><RS>{2}<TS>O")];
    for choice in [Estimator::Backward, Estimator::Forward] {
        let piece = |passes| Told::run(pane(), Choice::Only(choice), &lpes, passes);
        let whole = piece(0..7);
        let mut sum = piece(3..7);
        let first = piece(0..3);
        for ((_, own, books), (_, more, others)) in sum.films.films.iter_mut().zip(&first.films.films) {
            assert!(own.merge(more));
            books.merge(others);
        }
        let bits = |frame: &Frame| -> Vec<(String, Vec<u32>)> {
            let bits = |data: &[f32]| data.iter().map(|value| value.to_bits()).collect();
            frame.channels.iter().map(|channel| (channel.name.clone(), bits(&channel.data))).collect()
        };
        let (sum, whole) = (bits(&sum.frame()), bits(&whole.frame()));
        assert!(
            whole.iter().any(|(name, _)| name == "twice_led.R")
                && whole.iter().any(|(name, _)| name == "twice_stderr.R")
        );
        assert_eq!(sum, whole);
    }
}

long! {
/// What the plate's back face shows beside its front face: connection (solved for, and read from tables in the larger
/// picture) knows of the same share as light tracing does of the direct HUD, and photons of the diffuse one.
#[test]
fn a_ghost_is_the_same_for_all_estimators() {
    let lpes = [("front", "C<RS>.*L"), ("ghost", "C<TS><RS><TS>.*L")];
    let ghost = |name: &str, choice: Estimator, size: [usize; 2], passes: u64| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("samples/hud-{name}/hud.optics.toml"));
        let mut share = Moments::default();
        for seed in 0..4 {
            let mut scene = import(&path, &ImportOptions::default()).expect("the sample imports").scene;
            scene.sky = None;
            scene.eye.resolution = size;
            let frame = Told::seeded(scene, Choice::Only(choice), &lpes, 0..passes, seed).frame();
            share.add(total(&frame, "ghost_led").0 / total(&frame, "front_led").0);
        }
        share
    };
    let (small, large) = ([40, 20], [120, 60]);
    for (name, connected, others) in [
        ("direct", [(small, 8), (large, 2)].as_slice(), (Estimator::Forward, 32)),
        ("diffuse", [(small, 4)].as_slice(), (Estimator::Photon, 8)),
    ] {
        let other = ghost(name, others.0, small, others.1);
        for (size, passes) in connected {
            let own = ghost(name, Estimator::Manifold, *size, *passes);
            println!("{name}: {:.5} ± {:.5}, {:.5} ± {:.5}", own.mean, own.stderr(), other.mean, other.stderr());
            let sigma = own.stderr().hypot(other.stderr());
            // Four seeds know their own scatter to a third: Student's t with 3 degrees of freedom is above 10 once in 1000.
            assert!((own.mean - other.mean).abs() < 10.0 * sigma, "{name}");
            assert!(sigma < 0.02 * own.mean && own.mean > 0.02, "{name}: too noisy to tell");
        }
    }
}
}
