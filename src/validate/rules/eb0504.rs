//! The eye sees no optics.

use super::Frozen;
use crate::check::finding::{Finding, Level};
use crate::check::rule::{Example, Rule, kept, nothing};
use crate::scene::{Face, Finish};
use crate::world::geometry::Ray;

pub const RULE: Rule = Rule {
    code: "EB0504",
    name: "eye-outside",
    level: Level::Warning,
    title: "The eye sees no optical face",
    why: "No ray of a grid over the field of view meets a face that shines, bends, mirrors, shows or scatters: the eye stands outside of the eyebox, or looks the wrong way. A frame that differs by a turn (`frame`) is the usual cause.",
    bad: Example::Code("toml", "[eye]\nframe = \"asset\"       # glTF's axes; the numbers are the CAD frame's"),
    good: Example::Code("toml", "[eye]\nframe = \"HUD_B\""),
    find: nothing,
    grade: kept,
};

/// Rays on each side of the grid.
const SIDE: usize = 48;
/// Faces that are not there for light are passed, so many at most.
const PASSED: usize = 64;

pub fn find(frozen: &Frozen<'_>) -> Vec<Finding> {
    let scene = frozen.subject.scene;
    // A scene without any optics is looked at for its lamps alone.
    let any = scene.parts.iter().flat_map(|part| &part.faces).any(is_optical);
    if sees_optics(frozen) || !any {
        return Vec::new();
    }
    let fov = scene.eye.fov_deg;
    let text = format!("none of {} rays over its {fov}° meets a face that does anything with light", SIDE * SIDE);
    vec![RULE.at(super::place_of_eye(frozen.subject), text)]
}

/// Whether a ray of the grid meets an optical face.
pub fn sees_optics(frozen: &Frozen<'_>) -> bool {
    let eye = &frozen.world.eye;
    let [width, height] = eye.size();
    let at = |step: usize, size: usize| (step * size / SIDE).min(size.saturating_sub(1));
    (0..SIDE * SIDE).any(|cell| {
        let (origin, dir) = eye.ray(at(cell % SIDE, width), at(cell / SIDE, height), [0.5; 2], [0.5; 2]);
        meets_optics(frozen, origin, dir)
    })
}

fn meets_optics(frozen: &Frozen<'_>, origin: glam::DVec3, dir: glam::DVec3) -> bool {
    let mut ray = Ray { origin, dir, from: None };
    for _ in 0..PASSED {
        let Some(hit) = frozen.world.geometry.intersect(&ray, f64::INFINITY) else { return false };
        let part = frozen.subject.scene.parts.get(hit.site.part as usize);
        let Some(face) = part.and_then(|part| part.faces.get(hit.site.face as usize)) else { return false };
        if is_optical(face) {
            return true;
        }
        if face.finish != Finish::None {
            return false;
        }
        ray = Ray { origin: hit.point, dir, from: Some(hit.site) };
    }
    false
}

/// Whether a face does more than take light away.
pub(super) fn is_optical(face: &Face) -> bool {
    face.slide.is_some() || face.emitter.is_some() || !matches!(face.finish, Finish::None | Finish::Absorber)
}
