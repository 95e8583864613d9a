//! Specular connection: derivatives against differences, the solver's answers against light tracing path by path, and
//! its share and the rest's against the estimators that do without.

use crate::common::{add_part, block_z, cuboid, face, image_of, mesh, render, worst_z};
use eyebox::base::path::{Event, Trail};
use eyebox::base::stats::Moments;
use eyebox::check::check;
use eyebox::estimate::manifold::solver::newton::{Family, Target, newton, trace};
use eyebox::estimate::photon::Landing;
use eyebox::estimate::photon::visible_receivers::VisibleReceivers;
use eyebox::estimate::run::Films;
use eyebox::film::plan::{Estimator, Plan};
use eyebox::import::{ImportOptions, import};
use eyebox::plan::{Asked, Choice, Polarisation, plan};
use eyebox::scene::{Finish, Scene};
use eyebox::world::World;
use eyebox::world::mode::{Mode, Mono};
use eyebox_bench::generate;
use glam::{DVec2, DVec3};
use std::path::Path;
use std::sync::Arc;

fn sample(path: &str, size: [usize; 2]) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples").join(path);
    let mut scene = import(&path, &ImportOptions::default()).expect("the sample imports").scene;
    scene.eye.resolution = size;
    scene.sky = None;
    scene
}

fn asked(choice: Choice) -> Asked {
    Asked { polarisation: Polarisation::Off, ..choice.into() }
}

fn planned(scene: &Scene, choice: Choice) -> (World, Plan) {
    let checked = check(scene).expect("the sample is sound");
    let world = World::freeze(scene).expect("the sample can be traced");
    let plan = plan(&checked, &world, asked(choice));
    (world, plan)
}

/// On every train of both HUDs and of a ball the derivatives are those of central differences, and Newton's iteration
/// comes back to a place from which it was sent away.
#[test]
fn derivatives_and_roots() {
    let mut trains = 0;
    for (path, size) in [
        ("hud-direct/hud.optics.toml", [60, 30]),
        ("hud-diffuse/hud.optics.toml", [60, 30]),
        ("peers/a1/a1.optics.toml", [32, 32]),
    ] {
        let (world, plan) = planned(&sample(path, size), Choice::Auto);
        let optics = Mono::<f64>::optics(&world, 0, 0);
        let index = |part: Option<u32>| optics.index_in(part)[0];
        let mut check = |family: Family, train, target: Target, reach: f64, scale: f64| {
            let at = |u: DVec2| trace(&world, &index, &family, u, train, &target);
            let Some(end) = at(DVec2::ZERO) else { return };
            let h = 1e-4 * scale;
            for (axis, got) in [(DVec2::X, end.slope.x_axis), (DVec2::Y, end.slope.y_axis)] {
                let off = |k: f64| at(axis * (k * h)).expect("a neighbouring ray goes the same way").off;
                let want = (8.0 * (off(1.0) - off(-1.0)) - (off(2.0) - off(-2.0))) / (12.0 * h);
                assert!((got - want).length() < 1e-6 * want.length(), "{path}: {got} {want}");
            }
            // The lamp's point that the middle ray meets, from a start that is off by a tenth.
            let middle =
                Target { point: target.point + target.across[0] * end.off.x + target.across[1] * end.off.y, ..target };
            let root = newton(&world, &index, &family, DVec2::new(0.05, -0.08) * scale, train, &middle, reach);
            let root = root.expect("the solver comes back");
            assert!(root.u.length() < 1e-7 * scale, "{path}: {}", root.u);
            trains += 1;
        };
        for connection in &plan.connections {
            for seed in connection.seeds.iter().take(4) {
                let lamp = &world.lamps.all()[seed.lamp as usize];
                let (centre, radius) = lamp.around();
                let target = Target::new(centre, lamp.sample_point([0.5, 0.5]).normal);
                let (origin, (_, dir), across, _) =
                    world.eye.ray_of(DVec2::from_array(seed.film), DVec2::from_array(seed.pupil));
                let family = Family::Shifted { origin, from: None, dir, across };
                check(family, &connection.train, target, radius, world.eye.pupil_radius_m());
            }
        }
        for screen in &plan.screens {
            for seed in screen.seeds.iter().take(4) {
                let lamp = &world.lamps.all()[seed.lamp as usize];
                let (centre, radius) = lamp.around();
                let target = Target::new(centre, lamp.sample_point([0.5, 0.5]).normal);
                let axis = DVec3::from_array(seed.dir);
                let (a, b) = axis.any_orthonormal_pair();
                let site = eyebox::world::geometry::Site { part: screen.part, face: screen.face, triangle: u32::MAX };
                let family =
                    Family::Point { origin: DVec3::from_array(seed.place), from: Some(site), axis, across: [a, b] };
                check(family, &screen.train, target, radius, 1e-3);
            }
        }
    }
    assert!(trains > 20, "{trains}");
}

/// Sum over the picture of what each estimator brought, cd/m².
fn total(films: &Films, only: Option<Estimator>) -> f64 {
    let own = films.films.iter().filter(|(estimator, ..)| only.is_none_or(|only| only == *estimator));
    own.map(|(_, film, _)| {
        let planes = film.planes.len();
        (0..film.width * film.height)
            .flat_map(|p| (0..planes).map(move |k| (p, k)))
            .map(|(p, k)| film.mean(p, k).value)
            .sum::<f64>()
    })
    .sum()
}

fn moments(scene: &Scene, choice: Choice, passes: u64, seeds: u64, only: Option<Estimator>) -> Moments {
    let mut out = Moments::default();
    for seed in 0..seeds {
        let (films, _) = render(scene, asked(choice), passes, seed);
        out.add(total(&films, only));
    }
    out
}

long! {
/// Connection and what light tracing keeps are together what light tracing alone finds; what it keeps is little, so a path
/// that both had would show.
#[test]
fn what_connection_leaves_is_kept_by_light_tracing() {
    for (path, passes) in [("hud-direct/hud.optics.toml", 8), ("peers/b/b.optics.toml", 8)] {
        let scene = sample(path, [48, 24]);
        let all = moments(&scene, Choice::Only(Estimator::Manifold), 2, 6, None);
        let rest = moments(&scene, Choice::Only(Estimator::Manifold), 2, 6, Some(Estimator::Forward));
        let forward = moments(&scene, Choice::Only(Estimator::Forward), passes, 6, None);
        let z = (all.mean - forward.mean) / all.stderr().hypot(forward.stderr());
        println!(
            "{path}: {} ± {}, of which rest {}; forward {} ± {}",
            all.mean,
            all.stderr(),
            rest.mean,
            forward.mean,
            forward.stderr()
        );
        assert!(z.abs() < 4.0, "{path}: z = {z}");
        assert!(forward.stderr() < 0.02 * forward.mean, "{path}: too noisy to tell");
        assert!(rest.mean < 0.02 * all.mean, "{path}: {} of {}", rest.mean, all.mean);
    }
}
}

long! {
/// Faces joined with lamps, and the photons that they leave, are together what photons alone bring.
#[test]
fn what_connection_leaves_is_kept_by_photons() {
    for (path, size) in [("hud-diffuse/hud.optics.toml", [48, 24]), ("peers/a1/a1.optics.toml", [48, 48])] {
        let scene = sample(path, size);
        let all = moments(&scene, Choice::Only(Estimator::Manifold), 4, 4, None);
        let rest = moments(&scene, Choice::Only(Estimator::Manifold), 4, 4, Some(Estimator::Photon));
        let photon = moments(&scene, Choice::Only(Estimator::Photon), 10, 4, None);
        let z = (all.mean - photon.mean) / all.stderr().hypot(photon.stderr());
        println!(
            "{path}: {} ± {}, of which rest {}; photons {} ± {}",
            all.mean,
            all.stderr(),
            rest.mean,
            photon.mean,
            photon.stderr()
        );
        assert!(z.abs() < 4.0, "{path}: z = {z}");
        assert!(photon.stderr() < 0.02 * photon.mean, "{path}: too noisy to tell");
    }
}
}

long! {
/// LEDs behind a pane whose front is rough and whose back is polished: the front is lit through the back, which stands
/// before it for whoever looks from the lamps. Nearly all of what photons alone bring is connected.
#[test]
fn a_rough_pane_is_connected_through_its_back() {
    let scene = generate::scene(18);
    let all = moments(&scene, Choice::Auto, 16, 6, None);
    let rest = moments(&scene, Choice::Auto, 16, 6, Some(Estimator::Photon));
    let photon = moments(&scene, Choice::Only(Estimator::Photon), 32, 6, None);
    let z = (all.mean - photon.mean) / all.stderr().hypot(photon.stderr());
    println!("{} ± {}, of which {}; photons {} ± {}", all.mean, all.stderr(), rest.mean, photon.mean, photon.stderr());
    assert!(z.abs() < 4.0, "z = {z}");
    assert!(photon.stderr() < 0.005 * photon.mean, "too noisy to tell");
    assert!(rest.mean < 0.02 * all.mean, "{} of {}", rest.mean, all.mean);
}
}

/// A hair between the nodes of the tables that connections are read from is seen as in a picture that is too small to have
/// tables, column by column; and it takes enough light to be missed. Where the display ends is left out: few passes state too little of
/// their error where an edge crosses a pixel, and tables, which cut it exactly, show that. `pupil_m`: diameter, if not the sample's. `passes`: of the
/// picture with tables, of the others.
fn a_hair_is_seen(name: &str, pupil_m: Option<f64>, passes: [u64; 2]) {
    const SMALL: [usize; 2] = [100, 50];
    const TIMES: usize = 3;
    let mut dark = sample(name, SMALL);
    dark.eye.pupil_diameter_m = pupil_m.unwrap_or(dark.eye.pupil_diameter_m);
    dark.slides[0].pixels = Arc::new(vec![1.0; dark.slides[0].width * dark.slides[0].height]);
    let with_hair = |size: [usize; 2]| {
        let mut scene = dark.clone();
        scene.eye.resolution = size;
        let [right, up, look] = [scene.eye.right(), scene.eye.up, scene.eye.look];
        // 20 cells over the picture: a quarter past the first node of the 13th.
        let aside = scene.eye.half_tangents()[0] * (12.25 / 20.0 * 2.0 - 1.0);
        // Before the combiner, which is 0.12 m away. Blurred by the lit pupil it stays clear of nodes and of middles of cells.
        let (far, thin, long) = (0.1, 5e-5, 5e-3);
        let centre = scene.eye.position + far * (look + right * aside);
        let turned = |polygon: Vec<DVec3>| polygon.into_iter().map(|p| right * p.x + up * p.y - look * p.z).collect();
        let hair: Vec<Vec<DVec3>> = cuboid(DVec3::new(thin, long, thin)).into_iter().map(turned).collect();
        let faces = hair.iter().map(|_| face(Finish::Absorber)).collect();
        add_part(&mut scene, "hair", mesh(&hair), centre, None, faces);
        scene
    };
    let columns = |scene: &Scene, passes: u64, seed: u64, times: usize| {
        let [width, height] = scene.eye.resolution;
        let (films, plan) = render(scene, asked(Choice::Auto), passes, seed);
        // Without photons: one lights many pixels, whose errors are not their own. Beside the display theirs is all light.
        let pixels = image_of(&films, |estimator| estimator != Estimator::Photon);
        let followed = films.ledger(Estimator::Manifold).map_or(0, |ledger| ledger.paths);
        let followed = followed as f64 / (passes as usize * width * height) as f64;
        // The same part of pictures of both sizes.
        let aside = times * (height / times / 10);
        let rows = aside..height - aside;
        let count = (times * rows.len()) as f64;
        let mean = |column: usize| {
            let own =
                (0..times * rows.len()).map(|k| pixels[(rows.start + k / times) * width + times * column + k % times]);
            let (sum, variance) = own.fold((0.0, 0.0), |(sum, variance), p| (sum + p.0, variance + p.1));
            (sum / count, variance / (count * count))
        };
        let owned = (plan.photons_part, plan.connections.len(), plan.screens.len());
        let columns = width / times / 5..width / times - width / times / 5;
        (columns.map(mean).collect::<Vec<(f64, f64)>>(), followed, owned)
    };
    let (tables, seldom, owned) = columns(&with_hair(SMALL.map(|side| TIMES * side)), passes[0], 1, TIMES);
    let (solved, always, as_owned) = columns(&with_hair(SMALL), passes[1], 2, 1);
    let (without, ..) = columns(&dark, passes[1], 3, 1);
    let z = |a: &[(f64, f64)], b: &[(f64, f64)]| worst_z(&block_z(a, b, a.len(), 1), 1e-3);
    let ((worst, bound), (hair, _)) = (z(&tables, &solved), z(&tables, &without));
    println!("worst z {worst:.2} of {bound:.2}; without the hair {hair:.0}; paths {seldom:.2} and {always:.2} a pixel");
    assert_eq!(owned, as_owned, "what photons keep is not the same");
    assert!(seldom < 0.5 * always, "tables are not used: {seldom} and {always} paths a pixel");
    assert!(worst < bound, "{worst} of {bound}");
    assert!(hair > 2.0 * bound, "the hair is not seen: {hair}");
}

long! {
#[test]
fn tables_hide_nothing() {
    a_hair_is_seen("hud-direct/hud.optics.toml", None, [16, 16]);
}
}

long! {
/// The same for tables of where rays from the eye land on a lit screen: its light fills the pupil, which has to be small for
/// the hair to stay clear of nodes.
#[test]
fn glances_hide_nothing() {
    a_hair_is_seen("hud-diffuse/hud.optics.toml", Some(3e-4), [12, 6]);
}
}

/// What photons bring counts as the eye sees it: a matt face shows what arrives on its own side, ρ/π of it wherever it
/// comes from, and nothing of what arrives behind.
#[test]
fn photons_behind_a_wall_are_not_seen() {
    let scene = generate::scene(5);
    let world = World::freeze(&scene).expect("the scene can be traced");
    let seen = VisibleReceivers::look(&world, 1e-2, &|| false);
    assert!(!seen.points().is_empty());
    for sight in seen.points().iter().step_by(100) {
        let face = &scene.parts[sight.site.part as usize].faces[sight.site.face as usize];
        let Finish::Lambert { reflectance, .. } = face.finish else { panic!("{face:?}") };
        let sees = |outside: bool, dir: DVec3| {
            let (site, position) = (sight.site, sight.point);
            let trail = Trail::START.then(Event::Specular);
            let landing = Landing { site, position, dir, outside, lumens: 1.0, connected: false, trail };
            let [first, second] = seen.brightness(&world, &landing);
            assert!(second == 0.0, "nothing here asks for final gathering");
            first
        };
        for dir in [DVec3::new(0.1, -1.0, -0.5).normalize(), DVec3::new(-0.6, -0.5, -1.0).normalize()] {
            let mut both = [false, true].map(|outside| sees(outside, dir) * std::f64::consts::PI);
            both.sort_by(f64::total_cmp);
            assert!(both[0] == 0.0 && (both[1] - reflectance).abs() < 1e-12, "{both:?} {reflectance}");
        }
    }
}
