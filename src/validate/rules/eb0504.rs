//! The eye sees no optics.

use super::Frozen;
use eyebox_check::finding::{Finding, Level};
use eyebox_check::geometry::{corners, triangles};
use eyebox_check::rule::{Example, Rule, kept, nothing};
use eyebox_scene::{Face, Finish, Scene};
use eyebox_world::geometry::Ray;
use glam::DVec3;

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
/// Triangles of a face that rays are aimed at, at most.
const AIMS: usize = 64;

pub fn find(frozen: &Frozen<'_>) -> Vec<Finding> {
    let scene = frozen.subject.scene;
    // A scene without any optics is looked at for its lamps alone.
    let any = scene.parts.iter().flat_map(|part| &part.faces).any(is_optical);
    if !any || has_sensors(scene) || sees_optics(frozen) {
        return Vec::new();
    }
    let fov = scene.eye.fov_deg;
    let text = format!("none of {} rays over its {fov}° meets a face that does anything with light", SIDE * SIDE);
    vec![RULE.at(super::place_of_eye(frozen.subject), text)]
}

/// Whether the scene is there for its sensors, too: where its eye stands is then of no meaning that could be known.
pub(super) fn has_sensors(scene: &Scene) -> bool {
    scene.parts.iter().flat_map(|part| &part.faces).any(|face| face.sensor.is_some())
}

/// Whether a ray of the grid meets an optical face, or one that is aimed at a face between them.
pub fn sees_optics(frozen: &Frozen<'_>) -> bool {
    let eye = &frozen.world.eye;
    let [width, height] = eye.size();
    let at = |step: usize, size: usize| (step * size / SIDE).min(size.saturating_sub(1));
    (0..SIDE * SIDE).any(|cell| {
        let (origin, dir) = eye.ray(at(cell % SIDE, width), at(cell / SIDE, height), [0.5; 2], [0.5; 2]);
        first_optics(frozen, origin, dir).is_some()
    }) || sees_straight(frozen, is_optical)
}

/// Whether the middle of the pupil sees a face of this kind before any other that does something with light, by rays at some of
/// its triangles: a slit is narrower than a grid.
pub(super) fn sees_straight(frozen: &Frozen<'_>, kind: impl Fn(&Face) -> bool) -> bool {
    let (scene, eye) = (frozen.subject.scene, &frozen.world.eye);
    let [width, height] = eye.size().map(|count| count as f64);
    scene.parts.iter().zip(0u32..).any(|(part, index)| {
        let mesh = &scene.meshes[part.mesh.index()];
        let to_world = frozen.world.geometry.part_to_world(index);
        part.faces.iter().zip(&mesh.faces).filter(|(face, _)| kind(face)).any(|(_, range)| {
            let all = triangles(mesh, *range);
            let middles =
                all.iter().step_by(all.len().div_ceil(AIMS).max(1)).filter_map(|corner| corners(mesh, *corner));
            middles.map(|corner| corner.iter().sum::<DVec3>() / 3.0).any(|middle| {
                let Some(dir) = (to_world.transform_point3(middle) - eye.position()).try_normalize() else {
                    return false;
                };
                let inside = |[x, y]: [f64; 2]| (0.0..=width).contains(&x) && (0.0..=height).contains(&y);
                eye.place_of(dir).is_some_and(inside) && first_optics(frozen, eye.position(), dir).is_some_and(&kind)
            })
        })
    })
}

/// The first face on the way that does something with light.
fn first_optics<'f>(frozen: &Frozen<'f>, origin: DVec3, dir: DVec3) -> Option<&'f Face> {
    let mut ray = Ray { origin, dir, from: None };
    for _ in 0..PASSED {
        let hit = frozen.world.geometry.intersect(&ray, f64::INFINITY)?;
        let face = frozen.subject.scene.parts.get(hit.site.part as usize)?.faces.get(hit.site.face as usize)?;
        if is_optical(face) {
            return Some(face);
        }
        if face.finish != Finish::None {
            return None;
        }
        ray = Ray { origin: hit.point, dir, from: Some(hit.site) };
    }
    None
}

/// Whether a face does more than take light away.
pub(super) fn is_optical(face: &Face) -> bool {
    face.slide.is_some() || face.emitter.is_some() || !matches!(face.finish, Finish::None | Finish::Absorber)
}
