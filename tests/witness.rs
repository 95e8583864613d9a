//! The witness bites: faults are planted into what estimators bring, and it has to say which light is off and which way.
//! Sound runs it has to leave alone.

use eyebox::check::check;
use eyebox::estimate::run::{Dealt, Films, begin};
use eyebox::estimate::witness::Witness;
use eyebox::film::plan::{Estimator, Plan};
use eyebox::film::witness::{Judged, Judgement, judge};
use eyebox::import::{ImportOptions, import};
use eyebox::plan::pilots::pupil::survey;
use eyebox::plan::{Asked, Choice, Polarisation, plan};
use eyebox::scene::Scene;
use eyebox::world::World;
use eyebox::world::mode::Mono;
use eyebox_bench::generate::{self, Family};
use std::path::Path;

const SEED: u64 = 5;

fn sample(path: &str, size: [usize; 2]) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples").join(path);
    let mut scene = import(&path, &ImportOptions::default()).expect("the sample imports").scene;
    scene.eye.resolution = size;
    scene.sky = None;
    scene
}

/// A scene with what its plan finds.
struct Ready {
    scene: Scene,
    world: World,
    plan: Plan,
}

const ASKED: Asked = Asked { polarisation: Polarisation::Off, choice: Choice::Auto, guides: eyebox::plan::Guides::On };

impl Ready {
    fn new(scene: Scene) -> Ready {
        let world = World::freeze(&scene).expect("the sample can be traced");
        let plan = plan(&check(&scene).expect("the sample is sound"), &world, ASKED);
        Ready { scene, world, plan }
    }

    fn films(&self, plan: &Plan, passes: u64) -> Films {
        let mut tracing = begin(&self.world, plan, self.scene.groups.len(), self.scene.eye.resolution, SEED);
        tracing.step(passes);
        tracing.into_films()
    }

    /// A witness that has looked beside passes of so much counted work, as in a longer run.
    fn witness(&self, work: u64) -> eyebox::film::witness::Witness {
        self.witness_of(work, SEED)
    }

    fn witness_of(&self, work: u64, seed: u64) -> eyebox::film::witness::Witness {
        let checked = check(&self.scene).expect("the sample is sound");
        let guide = survey(&checked, &self.world, ASKED, &self.plan, &|| false).guide;
        let size = (self.scene.eye.resolution, guide.as_ref());
        let mut witness = Witness::<Mono<f64>>::new(&self.world, &self.plan, self.scene.groups.len(), size, seed)
            .expect("somebody else than naive paths has light");
        let passes: Vec<(u64, u64)> = (0..16).map(|pass| (pass, work / 16)).collect();
        witness.attend(&passes);
        witness.record
    }
}

fn judged(witness: &eyebox::film::witness::Witness, films: &Films) -> Judgement {
    let films: Vec<_> = films.films.iter().map(|(_, film, _)| film).collect();
    judge(witness, &films)
}

fn only(judgement: &Judgement) -> &Judged {
    let by_looks: Vec<&Judged> = judgement.judged.iter().filter(|own| !own.from_lamps).collect();
    assert_eq!(by_looks.len(), 1, "{judgement:?}");
    by_looks[0]
}

/// Less light than there is, by `sigmas` below 0, or more.
fn sigmas(judged: &Judged) -> f64 {
    judged.off.as_ref().map_or(0.0, |off| off.sigmas)
}

/// Films of a plan by connection alone.
fn connected(films: Films) -> Films {
    let own = films.films.into_iter().filter(|(estimator, ..)| *estimator == Estimator::Manifold).collect();
    Films { films: own, ..films }
}

long! {
/// On the direct HUD, whose light comes over two trains: the picture, and a ghost with 7 % of the light.
#[test]
fn planted_faults_of_vision_are_named() {
    let ready = Ready::new(sample("hud-direct/hud.optics.toml", [60, 30]));
    let ghost = &ready.plan.connections[1];
    assert!((0.05..0.1).contains(&ghost.share), "{}", ghost.share);
    // Some 50 000 looks: those of a run of half a minute on two cores.
    let witness = ready.witness(1_600_000_000);
    assert!(witness.looks() < 100_000, "{}", witness.looks());
    let sound = ready.films(&ready.plan, 97);
    let all = judged(&witness, &sound);
    let own = only(&all);
    println!("sound: {own:?}");
    let [ratio, error] = own.ratio.expect("the witness saw light");
    assert!(own.off.is_none() && (ratio - 1.0).abs() < 4.0 * error && error < 0.02, "{own:?}");
    // Three in a hundred lost: as many passes more without light.
    let mut lossy = ready.films(&ready.plan, 97);
    lossy.films.iter_mut().for_each(|(_, film, _)| film.passes = 100);
    let lossy = judged(&witness, &lossy);
    println!("lossy: {:?}", only(&lossy));
    assert!(sigmas(only(&lossy)) < -4.0, "{:?}", only(&lossy));
    // A train that is dropped: nobody has its light.
    let without = Plan { connections: vec![ready.plan.connections[0].clone()], ..ready.plan.clone() };
    let dropped = judged(&witness, &connected(ready.films(&without, 97)));
    println!("dropped: {:?}", only(&dropped));
    assert!(sigmas(only(&dropped)) < -6.0, "{:?}", only(&dropped));
    // The ghost twice.
    let alone = Plan { connections: vec![ghost.clone()], ..ready.plan.clone() };
    let mut doubled = sound;
    doubled.films.extend(connected(ready.films(&alone, 97)).films);
    let doubled = judged(&witness, &doubled);
    println!("doubled: {:?}", only(&doubled));
    assert!(sigmas(only(&doubled)) > 6.0, "{:?}", only(&doubled));
    // Black.
    let black = Films { films: Vec::new(), first: 0, passes: 97, dealt: Dealt::default(), witness: None };
    let black = judged(&witness, &black);
    assert!(sigmas(only(&black)) < -20.0 && only(&black).ratio.is_some_and(|[ratio, _]| ratio == 0.0));
}
}

long! {
/// On the diffuse HUD, whose screen is lit through a lens: it is dark, or twice as bright.
#[test]
fn planted_faults_of_caustics_are_named() {
    let ready = Ready::new(sample("hud-diffuse/hud.optics.toml", [120, 60]));
    let witness = ready.witness(1_600_000_000);
    let films = |times: usize| {
        let mut films = ready.films(&ready.plan, 8);
        for _ in 1..times {
            films.films.extend(ready.films(&ready.plan, 8).films);
        }
        judged(&witness, &films)
    };
    let caustic = |judgement: &Judgement| {
        let own = judgement.judged.iter().find(|own| own.classes.contains(&eyebox::base::path::Class::Caustic));
        own.expect("caustics are watched").clone()
    };
    let (sound, double) = (films(1), films(2));
    println!("{:?}\n{:?}", caustic(&sound), caustic(&double));
    assert!(!sound.is_off(), "{sound:?}");
    assert!(sigmas(&caustic(&double)) > 4.0, "{double:?}");
    let black =
        judged(&witness, &Films { films: Vec::new(), first: 0, passes: 8, dealt: Dealt::default(), witness: None });
    assert!(sigmas(&caustic(&black)) < -6.0, "{black:?}");
}
}

long! {
/// What lands on the diffuse HUD's screen comes from nine lamps, in directions that few photons tell: looks see all of it. With cones about
/// these photons alone they saw 6 % too little in most runs, and far too much in some.
#[test]
fn looks_miss_none_of_what_scatters() {
    let ready = Ready::new(sample("hud-diffuse/hud.optics.toml", [120, 60]));
    let films = ready.films(&ready.plan, 8);
    let open = |seed: u64| {
        let judgement = judged(&ready.witness_of(400_000_000, seed), &films);
        assert!(!judgement.is_off(), "{judgement:?}");
        let own = judgement.judged.iter().find(|own| own.classes.contains(&eyebox::base::path::Class::Caustic));
        own.and_then(|own| own.open).expect("the screen was seen lit")
    };
    let seen: Vec<[f64; 2]> = (1..=12).map(open).collect();
    println!("{seen:.3?}");
    let count = seen.len() as f64;
    let mean = seen.iter().map(|[ratio, _]| ratio).sum::<f64>() / count;
    let sigma = (seen.iter().map(|[ratio, _]| (ratio - mean).powi(2)).sum::<f64>() / (count * (count - 1.0))).sqrt();
    let stated = (seen.iter().map(|[_, error]| error * error).sum::<f64>()).sqrt() / count;
    println!("{mean:.4} ± {sigma:.4}, stated {stated:.4}");
    assert!((mean - 1.0).abs() < 4.0 * sigma && sigma < 0.025 && sigma < 2.0 * stated, "{mean} ± {sigma}, {stated}");
}
}

/// Seeds of each family: `SOUND_SEEDS=15 cargo verify-long --test long witness` asks more than two hundred runs.
fn seeds() -> u64 {
    std::env::var("SOUND_SEEDS").ok().and_then(|text| text.parse().ok()).unwrap_or(2)
}

long! {
/// Sound runs of the generator's scenes: no alarm (one in two hundred runs may be by chance), and looks are a twentieth of the
/// work at most. Pieces of a run see what the whole does.
#[test]
fn sound_runs_are_left_alone() {
    let (mut asked, mut offs, mut work, mut beside) = (0, Vec::new(), 0, 0);
    for (family, seed) in Family::ALL.into_iter().flat_map(|family| (0..seeds()).map(move |seed| (family, seed))) {
        let mut scene = generate::scene_of(family, 700 + seed);
        scene.eye.resolution = [24, 16];
        let ready = Ready::new(scene);
        let (groups, size) = (ready.scene.groups.len(), ready.scene.eye.resolution);
        let checked = check(&ready.scene).expect("the scene is sound");
        let guide = survey(&checked, &ready.world, ASKED, &ready.plan, &|| false).guide;
        let run = |blocks: &[u64]| {
            let mut tracing = begin(&ready.world, &ready.plan, groups, size, seed);
            tracing.watch(guide.as_ref());
            blocks.iter().for_each(|passes| tracing.step(*passes));
            tracing.into_films()
        };
        let films = run(&[12]);
        let Some(judgement) = films.judgement() else { continue };
        asked += 1;
        let record = films.witness.as_ref().expect("it has been judged");
        work += record.work;
        beside += record.beside;
        if judgement.is_off() {
            offs.push((family, seed, judgement));
        }
        if seed == 0 {
            assert_eq!(run(&[5, 1, 6]).witness, films.witness, "{family:?}");
        }
    }
    println!("{asked} runs, {} off, looks {:.4} of the work", offs.len(), work as f64 / beside as f64);
    assert!(asked >= 8 && offs.len() <= asked / 200, "{asked} runs, off: {offs:#?}");
    assert!((work as f64) < 0.05 * beside as f64, "{work} of {beside}");
}
}

long! {
/// Windshields with the eye anywhere in the eyebox: the automatic plan has the light that rays from the eye find.
#[test]
fn no_windshield_comes_out_dark() {
    for seed in 0..3 * seeds() {
        let mut scene = generate::scene_of(Family::Windshield, 300 + seed);
        scene.eye.resolution = [24, 16];
        let ready = Ready::new(scene);
        let checked = check(&ready.scene).expect("the scene is sound");
        let brute = plan(&checked, &ready.world, Asked { choice: Choice::Only(Estimator::Backward), ..ASKED });
        let light = |plan: &Plan| {
            let films = ready.films(plan, 16);
            let pixels = crate::common::image_of(&films, |_| true);
            let variance: f64 = pixels.iter().map(|(_, variance)| variance).sum();
            (pixels.iter().map(|(value, _)| value).sum::<f64>(), variance)
        };
        let (own, brute) = (light(&ready.plan), light(&brute));
        let z = (own.0 - brute.0) / (own.1 + brute.1).sqrt().max(f64::MIN_POSITIVE);
        assert!(brute.0 > 0.0 && z.abs() < 4.0, "seed {seed}: {own:?} for {brute:?}");
    }
}
}
