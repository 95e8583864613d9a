//! What is scanned of a face that has no picture with sides of its own: a rectangle along the face's sides, up to its rim where what
//! is seen goes so far, with columns to the right and rows down as the eye sees it.

use super::look::Landed;
use super::outline::{bounds, sides_of_smallest};
use super::tuning::extent::NEAR;
use super::tuning::subject::FLAT;
use eyebox_scene::Scene;
use eyebox_world::World;
use glam::{DMat2, DVec2, DVec3};

/// Upper left corner as seen and the sides to the right and down, world. `cell`: from one ray that looked to the next, tangents.
pub(super) fn seen_of(
    (scene, world): (&Scene, &World),
    (part, face): (u32, u32),
    hits: &[&Landed],
    cell: DVec2,
) -> Option<(DVec3, [DVec3; 2])> {
    let first = hits.first()?;
    let (origin, (a, b)) = (first.place, first.normal.any_orthonormal_pair());
    let flat = |place: DVec3| DVec2::new((place - origin).dot(a), (place - origin).dot(b));
    let places: Vec<DVec2> = hits.iter().map(|hit| flat(hit.place)).collect();
    let map = seen_map(hits, &places).unwrap_or_else(|| {
        let across = |axis: DVec3| DVec2::new(axis.dot(a), axis.dot(b));
        let (_, _, axes, _) = world.eye.ray_of(DVec2::ZERO, DVec2::ZERO);
        let [right, up] = axes.map(across);
        DMat2::from_cols(right, up)
    });
    let right = map.x_axis.try_normalize().unwrap_or(DVec2::X);
    let rim = rim(scene, world, (part, face), |place| ((place - origin).dot(first.normal), flat(place)));
    let axis = sides_of_smallest(&rim, right).unwrap_or(right);
    let [mut low, mut high] = bounds(&places, axis);
    if !rim.is_empty() {
        let [least, most] = bounds(&rim, axis);
        let apart = |axis: DVec2| NEAR * (map.transpose() * axis).abs().dot(cell);
        let near = DVec2::new(apart(axis), apart(axis.perp()));
        let up_to = |seen: DVec2, rim: DVec2| DVec2::select((seen - rim).abs().cmple(near), rim, seen);
        (low, high) = (up_to(low, least), up_to(high, most));
    }
    let world_of = |at: DVec2| a * at.x + b * at.y;
    let corner = axis * low.x + axis.perp() * low.y;
    let sides = [axis * (high.x - low.x), axis.perp() * (high.y - low.y)];
    // Where a step along a side leads as seen.
    let seen = sides.map(|side| map.inverse() * side);
    let is_level = |way: DVec2| way.x.abs() / way.length();
    let across = usize::from(is_level(seen[1]) > is_level(seen[0]));
    let down = 1 - across;
    let mut at = corner;
    let mut turned = |side: usize, is_right_way: bool| {
        if is_right_way {
            return sides[side];
        }
        at += sides[side];
        -sides[side]
    };
    let to_the_right = turned(across, seen[across].x >= 0.0);
    let downwards = turned(down, seen[down].y <= 0.0);
    Some((origin + world_of(at), [world_of(to_the_right), world_of(downwards)]))
}

/// The linear map from the eye's film (tangents to the right and up) to a plane, by least squares over what landed there. None where rays
/// landed on a line.
fn seen_map(hits: &[&Landed], places: &[DVec2]) -> Option<DMat2> {
    let count = hits.len() as f64;
    let film = hits.iter().map(|hit| hit.film).sum::<DVec2>() / count;
    let place = places.iter().sum::<DVec2>() / count;
    let outer = |a: DVec2, b: DVec2| DMat2::from_cols(a * b.x, a * b.y);
    let (mut own, mut both) = (DMat2::ZERO, DMat2::ZERO);
    for (hit, at) in hits.iter().zip(places) {
        own += outer(hit.film - film, hit.film - film);
        both += outer(*at - place, hit.film - film);
    }
    let map = both * own.inverse();
    let is_map = map.is_finite() && map.determinant() != 0.0;
    (is_map && own.determinant() > 1e-12 * (own.x_axis.x + own.y_axis.y).powi(2)).then_some(map)
}

/// The corners of a face in its plane; none unless all of it is flat. `to_plane`: height of a place (world) over the plane, and where in the
/// plane it is.
fn rim(scene: &Scene, world: &World, (part, face): (u32, u32), to_plane: impl Fn(DVec3) -> (f64, DVec2)) -> Vec<DVec2> {
    let corners = || {
        let mesh = scene.meshes.get(scene.parts.get(part as usize)?.mesh.index())?;
        let range = mesh.faces.get(face as usize)?;
        let triangles = mesh.triangles.get(range.first as usize..)?.iter().take(range.count as usize);
        let to_world = world.geometry.part_to_world(part);
        let corner = |index: &u32| {
            let [x, y, z] = mesh.positions.get(*index as usize)?.map(f64::from);
            Some(to_world.transform_point3(DVec3::new(x, y, z)) + world.geometry.origin())
        };
        triangles.flatten().map(corner).collect::<Option<Vec<DVec3>>>()
    };
    let corners: Vec<(f64, DVec2)> = corners().unwrap_or_default().into_iter().map(to_plane).collect();
    let [low, high] = bounds(&corners.iter().map(|(_, at)| *at).collect::<Vec<_>>(), DVec2::X);
    let extent = (high - low).max_element();
    if corners.iter().any(|(height, _)| height.abs() > FLAT * extent) {
        return Vec::new();
    }
    corners.into_iter().map(|(_, at)| at).collect()
}
