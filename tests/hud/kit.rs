//! Takes a sample HUD through the corridor, with the eye turned to a small patch so that a test is cheap.

use crate::common::image;
use eyebox::base::ids::GroupId;
use eyebox::check::check;
use eyebox::estimate::run::{Limits, Outcome, run};
use eyebox::film::plan::Plan;
use eyebox::import::{ImportOptions, Set, import};
use eyebox::plan::{Choice, plan};
use eyebox::scene::Scene;
use eyebox::world::World;
use std::path::Path;
use std::sync::Arc;

/// The direct HUD with its middle LED alone.
pub const ONE_LED: [&str; 2] = ["led.flux_lm=0", "LED_DIE_5.flux_lm=0.45"];

/// Imports `samples/hud-NAME` with `--set`s.
pub fn import_hud(name: &str, sets: &[&str]) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("samples/hud-{name}/hud.optics.toml"));
    let sets = sets.iter().map(|text| Set::parse(text).expect("a `--set`")).collect();
    import(&path, &ImportOptions { sets, ..ImportOptions::default() }).expect("the sample is sound").scene
}

/// The same in the dark: no sky, nor its light group.
pub fn hud(name: &str, sets: &[&str]) -> Scene {
    let mut scene = import_hud(name, sets);
    let gone = scene.sky.take().expect("the samples have a sky").group.index();
    scene.groups.remove(gone);
    for face in scene.parts.iter_mut().flat_map(|part| &mut part.faces) {
        if let Some(emitter) = &mut face.emitter {
            let index = emitter.group.index();
            emitter.group = GroupId::from_index(index - usize::from(index > gone));
        }
    }
    scene
}

/// Every pixel of the slide becomes `s`.
pub fn fill(mut scene: Scene, s: f32) -> Scene {
    let slide = &mut scene.slides[0];
    slide.pixels = Arc::new(vec![s; slide.width * slide.height]);
    scene
}

/// Turns the eye to a patch about the field angles `right` and `up` (degrees, the tangents of the eye's own picture).
pub fn gaze(mut scene: Scene, [right, up]: [f64; 2], fov_deg: f64, resolution: [usize; 2]) -> Scene {
    let eye = &mut scene.eye;
    let look = eye.look + eye.right() * right.to_radians().tan() + eye.up * up.to_radians().tan();
    let look = look.normalize();
    eye.up = (eye.up - look * look.dot(eye.up)).normalize();
    eye.look = look;
    eye.fov_deg = fov_deg;
    eye.resolution = resolution;
    scene
}

/// A scene that is planned and can be traced with several seeds.
pub struct Ready<'s> {
    pub scene: &'s Scene,
    pub world: World,
    pub plan: Plan,
}

impl<'s> Ready<'s> {
    pub fn new(scene: &'s Scene, choice: Choice) -> Self {
        let checked = check(scene).expect("the scene is sound");
        let world = World::freeze(scene).expect("the scene can be traced");
        let plan = plan(&checked, &world, choice);
        Ready { scene, world, plan }
    }

    pub fn run(&self, passes: u64, seed: u64) -> Outcome {
        let limits = Limits { passes: Some(passes), ..Limits::default() };
        let (groups, size) = (self.scene.groups.len(), self.scene.eye.resolution);
        run(&self.world, &self.plan, groups, size, seed, &limits, &mut ())
    }

    pub fn image(&self, passes: u64, seed: u64) -> Vec<(f64, f64)> {
        image(&self.run(passes, seed).films)
    }
}

/// Value and standard error.
pub type Measured = (f64, f64);

/// Mean luminance of a scene's picture.
pub fn luminance(scene: &Scene, choice: Choice, passes: u64) -> Measured {
    crate::common::mean(&Ready::new(scene, choice).image(passes, 1))
}

/// Mean of independent runs and its standard error from their scatter: pixels that gather the same photons are not
/// independent, so their own variances would say too little.
pub fn of_runs(values: &[f64]) -> Measured {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let square: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
    (mean, (square / (n * (n - 1.0))).sqrt())
}

/// Asserts `got` = `want` within `relative`, and that the statistics can tell: 3σ fit into the tolerance.
#[track_caller]
pub fn assert_close(what: &str, (got, sigma): Measured, want: f64, relative: f64) {
    let off = got / want - 1.0;
    eprintln!(
        "{what}: {got:.3} ± {sigma:.3}, expected {want:.3}: {:+.3} % ± {:.3} %",
        100.0 * off,
        100.0 * sigma / want
    );
    assert!(3.0 * sigma / want < relative, "{what}: σ {sigma} is too much to judge {relative}");
    assert!(off.abs() < relative, "{what}: {got} ± {sigma}, expected {want}");
}
