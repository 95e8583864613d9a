//! The vertices of a face: points where all values follow points, else each different combination of values.

use super::super::polygons::{Corners, Polygons};
use super::super::primvar::Primvar;
use super::carried::{Carried, Held};
use super::cut::{self, Own};
use crate::gltf::primitive::FaceMesh;
use std::rc::Rc;

/// A mesh as it is in the file.
#[derive(Debug, Clone)]
pub(in crate::usd) struct Data {
    pub polygons: Polygons,
    pub normals: Option<Primvar<[f32; 3]>>,
    /// Of the face that is made.
    pub carried: Carried,
    /// Whether faces are to say which points their vertices are.
    pub is_traced: bool,
}

/// Tables over all points, kept from face to face.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    /// Per point: the number of the face that last used it, and its first vertex there.
    used: Vec<(u32, u32)>,
    /// Per vertex: the next vertex of the same point.
    next: Vec<u32>,
}

/// The face number `number` of the mesh, made of the polygons `own`, and how many of them cross themselves. If the face
/// is `alone`, the arrays of the file become its own where they can, and `data` is left without them.
pub(super) fn face(
    data: &mut Data,
    own: &Own,
    alone: bool,
    number: usize,
    triangles: usize,
    scratch: &mut Scratch,
) -> (FaceMesh, usize) {
    let follows = data.normals.as_ref().is_none_or(Primvar::follows_points) && data.carried.follows_points();
    let plain = alone && *own == Own::All && cut::is_plain(&data.polygons);
    let taken = match &mut data.polygons.corners {
        Corners::Triangles(triangles) if plain => Some(std::mem::take(triangles)),
        Corners::Triangles(_) | Corners::Mixed { .. } => None,
    };
    match (follows, taken) {
        (true, Some(mut all)) => {
            if data.polygons.left_handed {
                all.iter_mut().for_each(|three| three.swap(1, 2));
            }
            (by_points(data, all, alone), 0)
        }
        (true, None) => {
            let points = data.polygons.corners.points();
            let point = |corner: usize| points.get(corner).copied().unwrap_or(0);
            let mut all = Vec::with_capacity(triangles);
            let ragged = cut::triangles(&data.polygons, own, |_, three| all.push(three.map(point)));
            (by_points(data, all, alone), ragged)
        }
        (false, Some(mut all)) => {
            let mut welder = Welder::new(data, number as u32, triangles, scratch);
            for (polygon, three) in all.iter_mut().enumerate() {
                let mut corners = [0, 1, 2];
                if data.polygons.left_handed {
                    corners.swap(1, 2);
                }
                let points = *three;
                *three = corners.map(|i| welder.vertex(polygon, 3 * polygon + i, points[i] as usize));
            }
            (FaceMesh { triangles: all, ..welder.out }, 0)
        }
        (false, None) => {
            let points = data.polygons.corners.points();
            let point = |corner: usize| points.get(corner).map_or(0, |&point| point as usize);
            let mut welder = Welder::new(data, number as u32, triangles, scratch);
            let mut all = Vec::with_capacity(triangles);
            let ragged = cut::triangles(&data.polygons, own, |polygon, three| {
                all.push(three.map(|corner| welder.vertex(polygon, corner, point(corner))));
            });
            (FaceMesh { triangles: all, ..welder.out }, ragged)
        }
    }
}

/// Vertices are points, in the order of the points; those that no triangle uses are left out. `triangles` are of
/// points.
fn by_points(data: &mut Data, mut triangles: Vec<[u32; 3]>, alone: bool) -> FaceMesh {
    let all = data.polygons.points.len();
    // A table of all points is quicker; a small face of a large mesh is better sorted.
    let used: Vec<u32> = if all / 4 <= 3 * triangles.len() {
        let mut is_used = vec![false; all];
        for &point in triangles.as_flattened() {
            if let Some(is_used) = is_used.get_mut(point as usize) {
                *is_used = true;
            }
        }
        if alone && is_used.iter().all(|&used| used) {
            return whole(data, triangles);
        }
        let used: Vec<u32> = (0..all as u32).filter(|&point| is_used.get(point as usize) == Some(&true)).collect();
        drop(is_used);
        let mut table = vec![0u32; all];
        for (new, &point) in used.iter().enumerate() {
            if let Some(slot) = table.get_mut(point as usize) {
                *slot = new as u32;
            }
        }
        for point in triangles.as_flattened_mut() {
            *point = table.get(*point as usize).copied().unwrap_or(0);
        }
        used
    } else {
        let mut used = triangles.as_flattened().to_vec();
        used.sort_unstable();
        used.dedup();
        for point in triangles.as_flattened_mut() {
            *point = used.partition_point(|other| other < point) as u32;
        }
        used
    };
    let points = || used.iter().map(|&point| point as usize);
    // Values that follow points need neither polygon nor corner.
    FaceMesh {
        positions: points().map(|point| data.polygons.position(point)).collect(),
        normals: data.normals.as_ref().map_or_else(Vec::new, |normals| {
            points().map(|point| normals.at(0, 0, point).unwrap_or_default()).collect()
        }),
        uvs: of_points(&data.carried.uvs, points()),
        second_uvs: of_points(&data.carried.second_uvs, points()),
        colors: if data.carried.has_colors() {
            points().map(|point| data.carried.colour(0, 0, point)).collect()
        } else {
            Vec::new()
        },
        triangles,
        sources: if data.is_traced { used } else { Vec::new() },
        ..FaceMesh::default()
    }
}

fn of_points(uvs: &Held<[f32; 2]>, points: impl Iterator<Item = usize>) -> Vec<[f32; 2]> {
    let Some(uvs) = uvs else { return Vec::new() };
    points.map(|point| uvs.at(0, 0, point).unwrap_or_default()).collect()
}

/// All points are vertices: nothing is copied that need not be.
fn whole(data: &mut Data, triangles: Vec<[u32; 3]>) -> FaceMesh {
    let positions = std::mem::take(&mut data.polygons.points);
    let count = positions.len();
    let moved = |uvs: Held<[f32; 2]>| {
        uvs.map_or_else(Vec::new, |uvs| match Rc::try_unwrap(uvs) {
            Ok(uvs) => uvs.into_points(count),
            Err(shared) => of_points(&Some(shared), 0..count),
        })
    };
    let mut carried = std::mem::take(&mut data.carried);
    FaceMesh {
        positions,
        normals: data.normals.take().map_or_else(Vec::new, |normals| normals.into_points(count)),
        uvs: moved(carried.uvs.take()),
        second_uvs: moved(carried.second_uvs.take()),
        colors: if carried.has_colors() {
            (0..count).map(|point| carried.colour(0, 0, point)).collect()
        } else {
            Vec::new()
        },
        triangles,
        sources: if data.is_traced { (0..count as u32).collect() } else { Vec::new() },
        ..FaceMesh::default()
    }
}

const NONE: u32 = u32::MAX;

/// Whether a vertex has this to the last bit; what is not carried is the same.
#[inline]
fn is_same<const N: usize>(value: &Option<[f32; N]>, all: &[[f32; N]], at: usize) -> bool {
    let bits = |x: &[f32; N]| x.map(f32::to_bits);
    value.as_ref().is_none_or(|value| all.get(at).map(bits) == Some(bits(value)))
}

/// Makes a vertex for each different (point, normal, texture coordinates, colour), in the order of first use.
struct Welder<'a> {
    data: &'a Data,
    number: u32,
    scratch: &'a mut Scratch,
    /// No more vertices than this.
    most: usize,
    out: FaceMesh,
}

impl<'a> Welder<'a> {
    /// More different values at one point are not searched through: a hostile file could ask for all pairs.
    const MOST: usize = 64;

    fn new(data: &'a Data, number: u32, triangles: usize, scratch: &'a mut Scratch) -> Self {
        let points = data.polygons.points.len();
        scratch.next.clear();
        scratch.used.resize(points, (NONE, 0));
        let mut out = FaceMesh::default();
        // As many as points is what a smooth mesh has.
        let likely = points.min(3 * triangles);
        out.positions.reserve_exact(likely);
        out.normals.reserve_exact(if data.normals.is_some() { likely } else { 0 });
        out.uvs.reserve_exact(if data.carried.uvs.is_some() { likely } else { 0 });
        out.second_uvs.reserve_exact(if data.carried.second_uvs.is_some() { likely } else { 0 });
        out.colors.reserve_exact(if data.carried.has_colors() { likely } else { 0 });
        scratch.next.reserve(likely);
        Welder { data, number, scratch, most: 3 * triangles, out }
    }

    #[inline]
    fn vertex(&mut self, polygon: usize, corner: usize, point: usize) -> u32 {
        let normal = self.data.normals.as_ref().map(|all| all.at(polygon, corner, point).unwrap_or_default());
        let carried = &self.data.carried;
        let of = |all: &Held<[f32; 2]>| all.as_ref().map(|all| all.at(polygon, corner, point).unwrap_or_default());
        let (uv, second) = (of(&carried.uvs), of(&carried.second_uvs));
        let color = carried.has_colors().then(|| carried.colour(polygon, corner, point));
        let (face, mut known) = self.scratch.used.get(point).copied().unwrap_or((NONE, 0));
        if face != self.number {
            known = NONE;
        }
        let first = known;
        let mut last = NONE;
        let out = &mut self.out;
        for _ in 0..Self::MOST {
            if known == NONE {
                break;
            }
            let at = known as usize;
            let same = is_same(&normal, &out.normals, at)
                && is_same(&uv, &out.uvs, at)
                && is_same(&second, &out.second_uvs, at)
                && is_same(&color, &out.colors, at);
            if same {
                return known;
            }
            last = known;
            known = self.scratch.next.get(at).copied().unwrap_or(NONE);
        }
        let new = out.positions.len() as u32;
        if out.positions.len() == out.positions.capacity() {
            // Twice as much each time, but never more than there can be.
            let more = out.positions.len().max(64).min(self.most.saturating_sub(out.positions.len()));
            out.positions.reserve_exact(more);
            out.normals.reserve_exact(if normal.is_some() { more } else { 0 });
            out.uvs.reserve_exact(if uv.is_some() { more } else { 0 });
            out.second_uvs.reserve_exact(if second.is_some() { more } else { 0 });
            out.colors.reserve_exact(if color.is_some() { more } else { 0 });
        }
        out.positions.push(self.data.polygons.position(point));
        out.normals.extend(normal);
        out.uvs.extend(uv);
        out.second_uvs.extend(second);
        out.colors.extend(color);
        if self.data.is_traced {
            out.sources.push(point as u32);
        }
        self.scratch.next.push(NONE);
        if first == NONE {
            if let Some(used) = self.scratch.used.get_mut(point) {
                *used = (self.number, new);
            }
        } else if known == NONE
            && let Some(next) = self.scratch.next.get_mut(last as usize)
        {
            *next = new;
        }
        new
    }
}
