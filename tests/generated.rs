//! The assemblies that `eyebox bench --generate` makes from seeds are sound: no rule of `eyebox validate` finds an error, paths
//! from the eye bring light, and a seed always has the same scene.

use eyebox::base::stats::Moments;
use eyebox::check::finding::{Finding, Level};
use eyebox::check::geometry::EdgesOfMeshes;
use eyebox::check::rules::RULES;
use eyebox::check::subject::Subject;
use eyebox::estimate::run::begin;
use eyebox::film::plan::Estimator;
use eyebox::plan::{Choice, plan};
use eyebox::scene::assembly::Assembly;
use eyebox::scene::{Part, Scene};
use eyebox::validate::rules::{Frozen, TRACED};
use eyebox_bench::curve::picture::Picture;
use eyebox_bench::curve::race::Ready;
use eyebox_bench::generate::{Families, Family, scene, scene_of};
use glam::DVec3;
use std::path::Path;

const SEEDS: u64 = 4;
const SIZE: [usize; 2] = [12, 9];

fn assemblies() -> Vec<Family> {
    (0..7).map(|seed| Families::assemblies().of_seed(seed)).collect()
}

/// What all rules find in a scene that was made in code, those that trace included.
fn findings(scene: &Scene, ready: &Ready<'_>) -> Vec<Finding> {
    let (file, assembly) = (Path::new("made in code"), Assembly::default());
    let subject = Subject {
        file,
        assembly: &assembly,
        sheet: None,
        scene,
        whole: true,
        needed: &[],
        refusals: &[],
        edges: &EdgesOfMeshes::default(),
    };
    let frozen = Frozen { subject: &subject, checked: &ready.checked, world: &ready.world };
    let looked = RULES.iter().flat_map(|rule| (rule.find)(&subject));
    looked.chain(TRACED.iter().flat_map(|traced| (traced.find)(&frozen))).collect()
}

long! {
#[test]
fn no_rule_finds_an_error_in_an_assembly() {
    for family in assemblies() {
        let mut warned = 0;
        for seed in 0..SEEDS {
            let mut scene = scene_of(family, seed);
            scene.eye.resolution = SIZE;
            let name = scene.name.clone();
            let ready = Ready::new(&scene, 0.0).unwrap_or_else(|fault| panic!("{name}: {fault}"));
            let found = findings(&scene, &ready);
            for finding in found.iter().filter(|finding| finding.level != Level::Note) {
                println!("{name}: {} {} {}", finding.code, finding.at, finding.text);
            }
            assert!(found.iter().all(|finding| finding.level != Level::Error), "{name}: {found:?}");
            warned += u64::from(found.iter().any(|finding| finding.level == Level::Warning));
        }
        assert!(2 * warned <= SEEDS, "{}: {warned} of {SEEDS} with a warning", family.name());
    }
}
}

/// Mean luminance by paths from the eye, and the share of pixels with light.
fn seen(scene: &Scene, passes: u64) -> (f64, f64) {
    let ready = Ready::new(scene, 0.0).expect("a sound scene");
    let plan = plan(&ready.checked, &ready.world, Choice::Only(Estimator::Backward));
    let mut tracing = begin(&ready.world, &plan, scene.groups.len(), scene.eye.resolution, 1);
    tracing.step(passes);
    let picture = Picture::of_films(tracing.films(), scene.eye.resolution);
    let mut light = Moments::default();
    picture.values.iter().for_each(|value| light.add(*value));
    let lit = picture.values.iter().filter(|value| **value > 0.0).count();
    (light.mean, lit as f64 / picture.values.len() as f64)
}

long! {
/// The display itself must be seen, so there is no sky.
#[test]
fn the_eye_sees_the_displays_of_nearly_all() {
    for family in assemblies() {
        let mut dark = Vec::new();
        for seed in 0..3 * SEEDS {
            let mut scene = scene_of(family, seed);
            if family != Family::Cabin {
                scene.sky = None;
            }
            scene.eye.resolution = SIZE;
            let (mean, lit) = seen(&scene, 16);
            println!("{}: {mean:.4e} cd/m², {:.0} % lit, {:.1}°", scene.name, 100.0 * lit, scene.eye.fov_deg);
            if lit < 0.25 {
                dark.push(seed);
            }
        }
        assert!(dark.len() <= 1, "{}: seeds {dark:?} are dark", family.name());
    }
}
}

#[test]
fn a_seed_has_one_scene() {
    for family in assemblies() {
        for seed in [0, 1, 12_345, u64::MAX] {
            let text = |seed| format!("{:?}", scene_of(family, seed));
            assert!(text(seed) == text(seed), "{} {seed}", family.name());
            assert!(text(seed) != text(seed.wrapping_add(7)), "{} {seed}", family.name());
        }
    }
}

/// What a seed means without `--families` never changes: parts, the sum of the distances of all vertices from the eye, and the
/// pupil, all of them as they were when there were seven families.
#[test]
fn seeds_of_the_first_families_keep_their_scenes() {
    const WAS: [(usize, f64, f64); 7] = [
        (7, 104.728908497, 0.002190519762),
        (8, 105.726991858, 0.005843337150),
        (3, 254.655951830, 0.003386945540),
        (9, 120.713340678, 0.002196519455),
        (3, 16.008721288, 0.004245505052),
        (3, 24.862891426, 0.000000000000),
        (10, 170.819217729, 0.004092285058),
    ];
    for (seed, (parts, sum, pupil)) in (0..).zip(WAS) {
        let scene = scene(seed);
        let far = |part: &Part| -> f64 {
            let corners = scene.mesh(part.mesh).positions.iter().map(|p| DVec3::from(p.map(f64::from)));
            corners.map(|corner| part.to_world.transform_point3(corner).length()).sum()
        };
        let now: f64 = scene.parts.iter().map(far).sum();
        // Vertices are stored as f32, so sines of another platform may move some by a rounding.
        assert!((now - sum).abs() < 1e-5 * sum && scene.parts.len() == parts, "seed {seed}: {now} from eye, not {sum}");
        assert!((scene.eye.pupil_diameter_m - pupil).abs() < 1e-9, "seed {seed}: pupil {}", scene.eye.pupil_diameter_m);
    }
}
