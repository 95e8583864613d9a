//! The light of a group does not reach the eye.

use super::Frozen;
use super::eb0504::{has_sensors, sees_optics, sees_straight};
use eyebox_check::finding::{Finding, Level};
use eyebox_check::rule::{Example, Rule, kept, nothing};
use eyebox_estimate::run::begin;
use eyebox_plan::{Choice, plan};
use eyebox_scene::{Face, Scene};
use eyebox_world::World;

pub const RULE: Rule = Rule {
    code: "EB0505",
    name: "light-blocked",
    level: Level::Warning,
    title: "The light of a group does not reach the eye",
    why: "A small picture is traced with the plan that `render` would have. A light group that brings nothing into it is switched on for nothing: something stands in the way, a face that should be polished is black, a slide faces the wrong way, or the eye is beside the beam.",
    bad: Example::Code(
        "toml",
        "[[bind]]\npath = \"LENS_01\"       # without a finish for its caps: [default] makes them absorbers\nglass = \"PMMA\"",
    ),
    good: Example::Code(
        "toml",
        "[[bind]]\npath = \"LENS_01\"\nglass = \"PMMA\"\n\n[[bind]]\npath = \"LENS_01\"\nfaces = [0, 2]\nfinish = \"polished\"",
    ),
    find: nothing,
    grade: kept,
};

/// Longer side of the picture, pixels; passes over it, at least and at most; the paths of a pass.
const SIDE: usize = 64;
const PASSES: [u64; 2] = [2, 32];
const PATHS: u64 = 1 << 14;

pub fn find(frozen: &Frozen<'_>) -> Vec<Finding> {
    let scene = frozen.subject.scene;
    // Of an eye that looks elsewhere, that is what is wrong; and who has sensors may have lamps for them.
    if frozen.checked.facts().no_light || has_sensors(scene) || !sees_optics(frozen) {
        return Vec::new();
    }
    let Some(dark) = dark_groups(scene, frozen.world) else { return Vec::new() };
    let finding = |group: usize| {
        let name = &scene.groups[group].name;
        let text = format!("no light of group {name} arrived in a small picture of {} passes", PASSES[1]);
        RULE.at(place_of_group(frozen, group), text)
    };
    // Lamps that few pixels see.
    let of = |face: &Face, group: usize| face.emitter.as_ref().is_some_and(|lamp| lamp.group.index() == group);
    let dark = dark.into_iter().filter(|group| !sees_straight(frozen, |face| of(face, *group)));
    dark.map(finding).collect()
}

/// Light groups that shine and bring nothing; none if that can't be traced.
fn dark_groups(scene: &Scene, world: &World) -> Option<Vec<usize>> {
    let mut small = scene.clone();
    let longer = scene.eye.resolution[0].max(scene.eye.resolution[1]).max(1);
    let scale = (SIDE as f64 / longer as f64).min(1.0);
    small.eye.resolution = scene.eye.resolution.map(|n| ((n as f64 * scale) as usize).max(1));
    let checked = eyebox_check::check(&small).ok()?;
    let world = world.seen_by(&small.eye).ok()?;
    let mut plan = plan(&checked, &world, Choice::Auto);
    plan.forward_paths = plan.forward_paths.min(PATHS);
    plan.photons = plan.photons.min(PATHS);
    (plan.backward_share, plan.vision_share) = (1.0, 1.0);
    let mut tracing = begin(&world, &plan, small.groups.len(), small.eye.resolution, 0);
    let mut dark: Vec<usize> = (0..small.groups.len()).filter(|group| shines(&world, *group)).collect();
    if tracing.films().films.is_empty() {
        return Some(dark);
    }
    let mut passes = 0;
    while !dark.is_empty() && passes < PASSES[1] {
        tracing.step(PASSES[0]);
        passes += PASSES[0];
        for (_, film, _) in &tracing.films().films {
            for (plane, key) in film.planes.iter().enumerate() {
                let place = dark.iter().position(|group| *group == key.group.index());
                let Some(place) = place else { continue };
                // Behind a slide that is black at this contrast the light still arrives.
                let lit = |pixel: usize| {
                    let light = film.mean(pixel, plane);
                    light.value != 0.0 || light.open() != 0.0
                };
                if (0..film.width * film.height).any(lit) {
                    dark.remove(place);
                }
            }
        }
    }
    Some(dark)
}

/// Whether a lamp or light of the group has any power; the sky is seen or not, which is nobody's fault.
fn shines(world: &World, group: usize) -> bool {
    let lamps = world.lamps.all().iter().any(|lamp| lamp.group.index() == group && lamp.flux_lm > 0.0);
    lamps || world.lights.all().iter().any(|light| light.group().index() == group)
}

/// The first lamp of a group.
fn place_of_group(frozen: &Frozen<'_>, group: usize) -> eyebox_base::Where {
    for part in &frozen.subject.scene.parts {
        for (number, face) in part.faces.iter().enumerate() {
            if face.emitter.as_ref().is_some_and(|emitter| emitter.group.index() == group) {
                return frozen.subject.part(&part.path, Some(number));
            }
        }
    }
    eyebox_base::Where::file(&frozen.subject.assembly.file)
}
