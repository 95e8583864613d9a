//! What rules measure on meshes. Indices out of range say nothing; no measure panics.

use crate::base::units::ARCMIN;
use crate::base::weld::{rounding, weld};
use crate::scene::{FaceRange, Mesh, Scene};
use glam::DVec3;
use std::collections::HashMap;

/// Edges of a mesh, vertices at one place taken as one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Edges {
    pub all: usize,
    /// With an odd number of triangles: something ends there.
    pub open: usize,
}

/// Counts edges. Triangles that collapse have none.
pub fn edges(mesh: &Mesh) -> Edges {
    // Faces are rounded apart from each other, each by up to a rounding.
    let place = weld(&mesh.positions, 4.0 * rounding(&mesh.positions));
    let mut count = HashMap::<[usize; 2], usize>::new();
    for triangle in &mesh.triangles {
        let places = triangle.map(|vertex| place.get(vertex as usize).copied());
        let [Some(a), Some(b), Some(c)] = places else { continue };
        if a == b || b == c || c == a {
            continue;
        }
        for [from, to] in [[a, b], [b, c], [c, a]] {
            *count.entry([from.min(to), from.max(to)]).or_default() += 1;
        }
    }
    Edges { all: count.len(), open: count.values().filter(|count| **count % 2 == 1).count() }
}

fn corners(mesh: &Mesh, [a, b, c]: [u32; 3]) -> Option<[DVec3; 3]> {
    let corner = |vertex: u32| Some(DVec3::from_array(mesh.positions.get(vertex as usize)?.map(f64::from)));
    Some([corner(a)?, corner(b)?, corner(c)?])
}

/// Signed volume that the triangles enclose, cubic mesh units: positive if they are counter-clockwise as seen from
/// outside (the divergence theorem over x/3).
pub fn volume(mesh: &Mesh) -> f64 {
    let Some(first) = mesh.triangles.iter().find_map(|triangle| corners(mesh, *triangle)) else { return 0.0 };
    // About a point of the mesh, so that a part far from its origin loses no digits.
    let origin = first[0];
    let all = mesh.triangles.iter().filter_map(|triangle| corners(mesh, *triangle));
    all.map(|[a, b, c]| (a - origin).dot((b - origin).cross(c - origin)) / 6.0).sum()
}

/// Triangles of a face, by their corners; none for a range that the mesh lacks.
fn triangles(mesh: &Mesh, range: FaceRange) -> &[[u32; 3]] {
    let end = (range.first as usize).checked_add(range.count as usize);
    end.and_then(|end| mesh.triangles.get(range.first as usize..end)).unwrap_or(&[])
}

/// How many triangles of a face have no area to `grain`, the [`rounding`] of the mesh, and how many there are.
pub fn without_area(mesh: &Mesh, range: FaceRange, grain: f64) -> (usize, usize) {
    let all = triangles(mesh, range);
    let flat = |triangle: &&[u32; 3]| {
        corners(mesh, **triangle).is_some_and(|[a, b, c]| {
            let longest = (b - a).length().max((c - b).length()).max((a - c).length());
            (b - a).cross(c - a).length() <= grain * longest
        })
    };
    (all.iter().filter(flat).count(), all.len())
}

/// Extents of a face along two unit directions, mesh units; none for a face without triangles.
pub fn extent_along(mesh: &Mesh, face: usize, along: [DVec3; 2]) -> Option<[f64; 2]> {
    let range = mesh.faces.get(face)?;
    let points = || triangles(mesh, *range).iter().filter_map(|triangle| corners(mesh, *triangle)).flatten();
    let extent = |dir: DVec3| {
        let (low, high) = points()
            .map(|p| p.dot(dir))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        high - low
    };
    let extents = along.map(extent);
    extents.iter().all(|extent| *extent > 0.0 && extent.is_finite()).then_some(extents)
}

/// Largest extent of all parts in the world, by their boxes, m; 0 without parts.
pub fn extent_m(scene: &Scene) -> f64 {
    // Once per mesh: many parts may share one.
    let boxes: Vec<[DVec3; 2]> = scene.meshes.iter().map(bounds).collect();
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for part in &scene.parts {
        let Some(own) = boxes.get(part.mesh.index()).filter(|[low, high]| low.cmple(*high).all()) else { continue };
        for corner in 0..8usize {
            let pick = |axis: usize| own[corner >> axis & 1][axis];
            let point = part.to_world.transform_point3(DVec3::new(pick(0), pick(1), pick(2)));
            (low, high) = (low.min(point), high.max(point));
        }
    }
    (high - low).max_element().max(0.0)
}

fn bounds(mesh: &Mesh) -> [DVec3; 2] {
    let points = mesh.positions.iter().map(|point| DVec3::from_array(point.map(f64::from)));
    points.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], point| [low.min(point), high.max(point)])
}

/// Predicted blur of a picture that is mirrored in a meshed face, arc minutes: the root mean square over its area of the
/// error of the mirrored ray.
///
/// Let a facet's corners have normals that differ by θ. The facet's plane lies under the true surface by up to h θ/8, h
/// being the length of the facet; a ray at 45° meets it as far beside the place where it should, and there the true
/// normal differs by θ²/8. Where a facet's normals are those of its plane, the error is half of the step to its
/// neighbour instead. A mirrored ray turns by twice the error of the normal.
pub fn facet_blur_arcmin(mesh: &Mesh, range: FaceRange) -> f64 {
    let own = triangles(mesh, range);
    // Only what the face has: a mesh may have many faces.
    let points: Vec<[f32; 3]> =
        own.iter().flatten().map(|v| mesh.positions.get(*v as usize).copied().unwrap_or([f32::NAN; 3])).collect();
    let place = weld(&points, 4.0 * rounding(&points));
    let normal = |vertex: u32| {
        let normal = mesh.normals.get(vertex as usize)?;
        DVec3::from_array(normal.map(f64::from)).try_normalize()
    };
    let angle = |a: DVec3, b: DVec3| a.cross(b).length().atan2(a.dot(b));
    // The first normal seen at each place: what comes later at the same place is compared with it.
    let mut known = HashMap::<usize, DVec3>::new();
    let (mut sum, mut whole) = (0.0, 0.0);
    for (index, triangle) in own.iter().enumerate() {
        let (Some([a, b, c]), [Some(n), Some(o), Some(p)]) = (corners(mesh, *triangle), triangle.map(normal)) else {
            continue;
        };
        let bend = angle(n, o).max(angle(o, p)).max(angle(p, n));
        let mut step = 0.0_f64;
        for (corner, normal) in [n, o, p].into_iter().enumerate() {
            let Some(place) = place.get(3 * index + corner) else { continue };
            let other = *known.entry(*place).or_insert(normal);
            let off = angle(other, normal);
            // A step of 45° and more is an edge that is meant.
            if off < std::f64::consts::FRAC_PI_4 {
                step = step.max(off);
            }
        }
        let area = 0.5 * (b - a).cross(c - a).length();
        let error = (bend * bend / 8.0).max(step / 2.0);
        sum += area * error * error;
        whole += area;
    }
    if whole > 0.0 { 2.0 * (sum / whole).sqrt() / ARCMIN } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> Mesh {
        let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let faces = vec![FaceRange { first: 0, count: 4 }];
        Mesh { positions, triangles, faces, ..Mesh::default() }
    }

    #[test]
    fn a_closed_solid_has_a_volume_and_no_open_edge() {
        let mesh = tetrahedron();
        assert_eq!(edges(&mesh), Edges { all: 6, open: 0 });
        assert!((volume(&mesh) - 1.0 / 6.0).abs() < 1e-15);
        let mut turned = tetrahedron();
        turned.triangles.iter_mut().for_each(|triangle| triangle.swap(0, 1));
        assert!((volume(&turned) + 1.0 / 6.0).abs() < 1e-15);
        let mut open = tetrahedron();
        open.triangles.pop();
        assert_eq!(edges(&open), Edges { all: 6, open: 3 });
    }

    #[test]
    fn what_is_out_of_range_says_nothing() {
        let mut mesh = tetrahedron();
        mesh.triangles[0] = [9, 9, 9];
        mesh.positions[3] = [f32::NAN; 3];
        let beyond = FaceRange { first: u32::MAX, count: u32::MAX };
        let _ = (edges(&mesh), volume(&mesh), facet_blur_arcmin(&mesh, beyond), without_area(&mesh, beyond, 1e-7));
        assert_eq!(extent_along(&mesh, 7, [DVec3::X, DVec3::Y]), None);
    }

    /// A strip of a cylinder of radius 1 in facets of 2°, with its own normals and with flat ones.
    #[test]
    fn blur_of_a_strip() {
        let step = 2f64.to_radians();
        let (mut smooth, mut flat) = (Mesh::default(), Mesh::default());
        for i in 0..8u32 {
            let at = |k: u32| f64::from(k) * step;
            let side = |angle: f64, z: f32| [angle.cos() as f32, angle.sin() as f32, z];
            let ends = [at(i), at(i + 1)];
            let corners = [side(ends[0], 0.0), side(ends[1], 0.0), side(ends[1], 1.0), side(ends[0], 1.0)];
            for (mesh, normals) in [
                (&mut smooth, [ends[0], ends[1], ends[1], ends[0]].map(|a| side(a, 0.0))),
                (&mut flat, [side(0.5 * (ends[0] + ends[1]), 0.0); 4]),
            ] {
                mesh.positions.extend(corners);
                mesh.normals.extend(normals);
                mesh.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t: [u32; 3]| t.map(|v| v + 4 * i)));
            }
        }
        let range = FaceRange { first: 0, count: 16 };
        let (smooth, flat) = (facet_blur_arcmin(&smooth, range), facet_blur_arcmin(&flat, range));
        assert!((smooth - step * step / 4.0 / ARCMIN).abs() < 1e-3, "{smooth}");
        assert!(flat > 0.8 * 120.0 && flat <= 120.001, "{flat}");
    }
}
