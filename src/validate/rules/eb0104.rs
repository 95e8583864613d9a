//! Two solids overlap and none has priority.

use super::Frozen;
use eyebox_check::finding::{Finding, Level};
use eyebox_check::rule::{Example, Rule, kept, nothing};
use eyebox_check::subject::is_solid;
use glam::DVec3;
use std::collections::BTreeSet;

pub const RULE: Rule = Rule {
    code: "EB0104",
    name: "solids-overlap",
    level: Level::Warning,
    title: "Two solids overlap and none has priority",
    why: "Where two media are at one place, the one with the higher `priority` fills it. Without one, the order of the parts in the file decides, and a new export may turn it round.",
    bad: Example::Words("A lens that reaches a tenth of a millimetre into its neighbour, both with priority 0."),
    good: Example::Code("toml", "[[bind]]\npath = \"LENS_03\"\npriority = 1"),
    find: nothing,
    grade: kept,
};

/// Triangles of a part that are looked at: its corners are inside of what it overlaps.
const PLACES: usize = 512;
/// The same for all parts together, so that thousands of solids take no minutes.
const PLACES_OF_ALL: usize = 1 << 16;
/// How far a place lies under the surface, as a share of the part's size: faces that touch do not overlap.
const UNDER: f64 = 1e-3;

pub fn find(frozen: &Frozen<'_>) -> Vec<Finding> {
    let scene = frozen.subject.scene;
    let solids = scene.parts.iter().filter(|part| is_solid(part)).count().max(1);
    let places = (PLACES_OF_ALL / solids).clamp(1, PLACES);
    let mut pairs = BTreeSet::new();
    for (index, part) in scene.parts.iter().enumerate().filter(|(_, part)| is_solid(part)) {
        for place in under_surface(frozen, index, places) {
            let inside = frozen.world.geometry.solids_containing(place);
            // Of a place that is not inside its own part nothing can be said.
            if !inside.contains(&(index as u32)) {
                continue;
            }
            for other in inside.iter().map(|other| *other as usize).filter(|other| *other != index) {
                let Some(second) = scene.parts.get(other) else { continue };
                let differ = second.medium.map(|id| scene.medium(id)) != part.medium.map(|id| scene.medium(id));
                if differ && second.priority == part.priority {
                    pairs.insert([index.min(other), index.max(other)]);
                }
            }
        }
    }
    let finding = |[first, second]: [usize; 2]| {
        let (first, second) = (&scene.parts[first], &scene.parts[second]);
        let text = format!("overlaps {}, and both have priority {}", second.path, first.priority);
        RULE.at(frozen.subject.part(&first.path, None), text)
    };
    pairs.into_iter().map(finding).collect()
}

/// Places a little under the surface of a part, recentred world.
fn under_surface(frozen: &Frozen<'_>, index: usize, places: usize) -> Vec<DVec3> {
    let scene = frozen.subject.scene;
    let Some(part) = scene.parts.get(index) else { return Vec::new() };
    let mesh = scene.mesh(part.mesh);
    let to_world = frozen.world.geometry.part_to_world(index as u32);
    let corner = |vertex: u32| {
        let point = mesh.positions.get(vertex as usize)?;
        Some(to_world.transform_point3(DVec3::from_array(point.map(f64::from))))
    };
    let (low, high) = mesh.positions.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), point| {
        let point = to_world.transform_point3(DVec3::from_array(point.map(f64::from)));
        (low.min(point), high.max(point))
    });
    let depth = UNDER * (high - low).min_element().max(0.0);
    let mirrored = if to_world.matrix3.determinant() < 0.0 { -1.0 } else { 1.0 };
    let stride = mesh.triangles.len().div_ceil(places).max(1);
    let place = |triangle: &[u32; 3]| {
        let [a, b, c] = [corner(triangle[0])?, corner(triangle[1])?, corner(triangle[2])?];
        let normal = mirrored * (b - a).cross(c - a).try_normalize()?;
        // Near a corner and in the middle: long thin triangles have their middle elsewhere.
        let middle = (a + b + c) / 3.0;
        Some([middle, 0.9 * a + 0.1 * middle].map(|p| p - depth * normal))
    };
    mesh.triangles.iter().step_by(stride).filter_map(place).flatten().collect()
}
