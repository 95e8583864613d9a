//! Passes where the error is: what pixels hold is what runs of so many passes give, and a run that is asked for an error
//! makes the same file whatever stops it on the way.

use eyebox::check::check;
use eyebox::estimate::run::{Films, Limits, begin, drive};
use eyebox::film::accumulate::Film;
use eyebox::film::plan::{Estimator, Plan};
use eyebox::film::sample_map::COARSE;
use eyebox::import::{ImportOptions, import};
use eyebox::output::exr::read_exr;
use eyebox::plan::{Choice, plan};
use eyebox::world::World;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

const SIZE: [usize; 2] = [120, 60];

fn sample(path: &str) -> (World, Plan, usize) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples").join(path);
    let mut scene = import(&path, &ImportOptions::default()).expect("the sample imports").scene;
    scene.eye.resolution = SIZE;
    let checked = check(&scene).expect("the sample is sound");
    let world = World::freeze(&scene).expect("the sample can be traced");
    let plan = plan(&checked, &world, Choice::Auto);
    (world, plan, scene.groups.len())
}

fn adaptive((world, plan, groups): &(World, Plan, usize), error: f64) -> Films {
    let limits = Limits { error: Some(error), adaptive: true, ..Limits::default() };
    drive(begin(world, plan, *groups, SIZE, 7), &limits, &mut ()).films
}

long! {
/// Each pixel of each film holds the bits of a run of as many passes of all pixels. Several numbers of passes are met, and where
/// lenses and a slide are looked at through, some pixels get eight times the passes of others.
#[test]
fn pixels_hold_what_so_many_passes_give() {
    for (path, error) in [("hud-direct/hud.optics.toml", 0.02), ("hud-diffuse/hud.optics.toml", 0.001)] {
        let traced = sample(path);
        let films = adaptive(&traced, error);
        assert!(films.relative_error().is_some_and(|stated| stated <= error), "{path}");
        let (mut met, most) = (Vec::new(), films.films.iter().map(|(_, film, _)| film.most_passes()).max());
        let mut even = begin(&traced.0, &traced.1, traced.2, SIZE, 7);
        while even.films().passes < most.unwrap_or(0) {
            even.step(even.films().passes.max(1));
            let passes = even.films().passes;
            for ((estimator, own, _), (_, all, _)) in films.films.iter().zip(&even.films().films) {
                let same = |pixel: usize| {
                    let of = |film: &Film, plane: usize| (film.mean(pixel, plane), film.variance(pixel, plane));
                    (0..=own.planes.len()).all(|plane| {
                        let variance = own.variance(pixel, plane) == all.variance(pixel, plane);
                        variance && (plane == own.planes.len() || of(own, plane) == of(all, plane))
                    })
                };
                let own_pixels = (0..SIZE[0] * SIZE[1]).filter(|pixel| own.passes_of(*pixel) == passes);
                let own_pixels: Vec<usize> = own_pixels.collect();
                assert!(own_pixels.iter().all(|pixel| same(*pixel)), "{path} {estimator:?} {passes}");
                met.extend((!own_pixels.is_empty()).then_some((*estimator, passes)));
            }
        }
        let of_connection = met.iter().filter(|(estimator, _)| *estimator == Estimator::Manifold).count();
        assert!(of_connection >= 3, "{path} {met:?}");
    }
}
}

/// A first pass that is made part by part is the first pass, and until it is whole pixels show what near ones have.
#[test]
fn a_first_pass_in_parts_is_the_first_pass() {
    let (world, plan, groups) = sample("hud-direct/hud.optics.toml");
    let begin = || begin(&world, &plan, groups, SIZE, 7);
    let (mut parts, mut even) = (begin(), begin());
    let image = |films: &Films| -> Vec<f64> {
        let of_pixel = |pixel: usize| -> f64 {
            let of_film = |film: &Film| (0..film.planes.len()).map(|plane| film.mean(pixel, plane).value).sum::<f64>();
            films.films.iter().map(|(_, film, _)| of_film(film)).sum()
        };
        (0..SIZE[0] * SIZE[1]).map(of_pixel).collect()
    };
    let count = 1 + parts.sweep(0);
    let coarse = image(parts.films());
    even.step(1);
    let whole = image(even.films());
    for (pixel, shown) in coarse.iter().enumerate() {
        let [x, y] = [pixel % SIZE[0], pixel / SIZE[0]].map(|at| at - at % COARSE);
        // What lamps send to the picture as a whole is in its own pixel at once.
        assert!((shown - whole[y * SIZE[0] + x]).abs() < 0.05 * whole[y * SIZE[0] + x].max(1e3), "{pixel}");
    }
    assert!(parts.films().films.iter().any(|(_, film, _)| film.traced_share() < 0.1));
    (1..count).for_each(|part| {
        parts.sweep(part);
    });
    for passes in [0, 1, 2] {
        if passes > 0 {
            parts.step(passes);
            even.step(passes);
        }
        assert_eq!(image(parts.films()), image(even.films()));
        for ((_, own, books), (_, all, ledger)) in parts.films().films.iter().zip(&even.films().films) {
            assert_eq!((own.passes, own.samples(), books.work), (all.passes, all.samples(), ledger.work));
            for pixel in 0..SIZE[0] * SIZE[1] {
                assert_eq!(own.variance(pixel, own.planes.len()), all.variance(pixel, all.planes.len()));
            }
        }
    }
    assert_eq!(parts.films().relative_error(), even.films().relative_error());
}

long! {
/// Where rounds are cut into blocks is the clock's doing: a witness looks at the same places whatever they are.
#[test]
fn a_witness_knows_nothing_of_blocks() {
    let (world, plan, groups) = sample("hud-direct/hud.optics.toml");
    let looks = |block: u64| {
        let mut tracing = begin(&world, &plan, groups, SIZE, 0);
        tracing.watch(None);
        tracing.step(2);
        let mut rounds = 0;
        while tracing.films().relative_error().is_none_or(|error| error > 0.004) {
            tracing.aim(Some(0.004));
            rounds += 1;
            while tracing.missing().is_some() {
                tracing.fill(block);
            }
        }
        (rounds, format!("{:?}", tracing.films().judgement()))
    };
    let [one, five, all] = [1, 5, u64::MAX].map(looks);
    assert!(one.0 > 0, "no round was made");
    assert!(one == five && one == all, "{one:?}\n{five:?}\n{all:?}");
}
}

long! {
/// Threads, and where a run was killed and taken up again, change no byte of the file; `--adaptive off` does, and so does an
/// asked number of passes, which all pixels get. The layer `work` says where passes went.
#[test]
fn files_are_the_same_whatever_stops_a_run() {
    let folder = tempfile::tempdir().unwrap();
    let asset = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples/hud-direct/hud.optics.toml");
    let render = |output: &str, more: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_eyebox"));
        command.arg("render").arg(&asset).args(["--resolution", "120x60", "--error", "0.01", "-q", "-o"]);
        command.arg(folder.path().join(output)).args(more).stderr(Stdio::null());
        command
    };
    let done = |mut command: Command| assert!(command.status().unwrap().code().is_some_and(|code| code < 2));
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    done(render("one.exr", &["--threads", "1"]));
    done(render("two.exr", &["--threads", "2"]));
    let mut child = render("again.exr", &["--checkpoint", "50ms"]).spawn().unwrap();
    while !folder.path().join("again.checkpoint.exr").exists() && child.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_millis(10));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    done(render("again.exr", &["--checkpoint", "60s", "--resume"]));
    assert!(bytes("one.exr") == bytes("two.exr"));
    assert!(bytes("one.exr") == bytes("again.exr"));
    done(render("even.exr", &["--adaptive", "off"]));
    let [ours, even] = ["one.exr", "even.exr"].map(|name| read_exr(&folder.path().join(name)).unwrap());
    let work = ours.rgb("work").expect("the layer of work")[0];
    let mean = work.iter().map(|own| f64::from(*own)).sum::<f64>() / work.len() as f64;
    assert!((mean - 1.0).abs() < 1e-4, "{mean}");
    assert!(work.iter().any(|own| *own > 4.0) && work.iter().any(|own| *own < 1.0));
    assert!(even.rgb("work").is_none());
    assert!(ours.text("passesMean.manifold").is_some() || ours.number("passesMean.manifold").is_some());
}
}
