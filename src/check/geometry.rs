//! What rules measure on meshes. Indices out of range say nothing; no measure panics.

use eyebox_base::ids::MeshId;
use eyebox_base::weld::{rounding, weld};
use eyebox_scene::{FaceRange, Mesh, Scene};
use glam::DVec3;
use std::cell::RefCell;
use std::collections::{HashMap, HashSet};

/// Edges of a mesh, vertices at one place taken as one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Edges {
    pub all: usize,
    /// With an odd number of triangles: something ends there.
    pub open: usize,
    /// Triangles that lie where another does, the same way round.
    pub doubled: usize,
}

/// The edges of each mesh of a scene, counted when first asked for.
#[derive(Debug, Default)]
pub struct EdgesOfMeshes(RefCell<HashMap<MeshId, Edges>>);

impl EdgesOfMeshes {
    /// Of a mesh of the scene.
    pub fn of(&self, scene: &Scene, mesh: MeshId) -> Edges {
        *self.0.borrow_mut().entry(mesh).or_insert_with(|| edges(scene.mesh(mesh)))
    }
}

/// Counts edges. Triangles that collapse have none.
pub fn edges(mesh: &Mesh) -> Edges {
    // Faces are rounded apart from each other, each by up to a rounding.
    let place = weld(&mesh.positions, 4.0 * rounding(&mesh.positions));
    let mut count = HashMap::<[usize; 2], usize>::new();
    // One that lies there twice closes what it closes once.
    let mut seen = HashSet::new();
    let mut doubled = 0;
    for triangle in &mesh.triangles {
        let places = triangle.map(|vertex| place.get(vertex as usize).copied());
        let [Some(a), Some(b), Some(c)] = places else { continue };
        if a == b || b == c || c == a {
            continue;
        }
        // From its least corner on: the same triangle, the same way round.
        let least = if a < b && a < c {
            [a, b, c]
        } else if b < c {
            [b, c, a]
        } else {
            [c, a, b]
        };
        if !seen.insert(least) {
            doubled += 1;
            continue;
        }
        for [from, to] in [[a, b], [b, c], [c, a]] {
            *count.entry([from.min(to), from.max(to)]).or_default() += 1;
        }
    }
    Edges { all: count.len(), open: count.values().filter(|count| **count % 2 == 1).count(), doubled }
}

pub fn corners(mesh: &Mesh, [a, b, c]: [u32; 3]) -> Option<[DVec3; 3]> {
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
pub fn triangles(mesh: &Mesh, range: FaceRange) -> &[[u32; 3]] {
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
    let boxes: Vec<[DVec3; 2]> = scene.meshes.iter().map(|mesh| bounds(mesh)).collect();
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
        assert_eq!(edges(&mesh), Edges { all: 6, ..Edges::default() });
        assert!((volume(&mesh) - 1.0 / 6.0).abs() < 1e-15);
        // A triangle that lies there twice, from another corner on.
        let mut doubled = tetrahedron();
        doubled.triangles.push([1, 0, 2]);
        assert_eq!(edges(&doubled), Edges { all: 6, open: 0, doubled: 1 });
        let mut turned = tetrahedron();
        turned.triangles.iter_mut().for_each(|triangle| triangle.swap(0, 1));
        assert!((volume(&turned) + 1.0 / 6.0).abs() < 1e-15);
        let mut open = tetrahedron();
        open.triangles.pop();
        assert_eq!(edges(&open), Edges { all: 6, open: 3, doubled: 0 });
    }

    #[test]
    fn what_is_out_of_range_says_nothing() {
        let mut mesh = tetrahedron();
        mesh.triangles[0] = [9, 9, 9];
        mesh.positions[3] = [f32::NAN; 3];
        let beyond = FaceRange { first: u32::MAX, count: u32::MAX };
        let _ = (edges(&mesh), volume(&mesh), without_area(&mesh, beyond, 1e-7));
        assert_eq!(extent_along(&mesh, 7, [DVec3::X, DVec3::Y]), None);
    }
}
