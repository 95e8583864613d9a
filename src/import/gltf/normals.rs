//! Vertex normals of one face: flat ones where the file has none, and new ones where the file's have no direction.
//! (Normals that have a direction but contradict their triangles are another matter: see `primitive`.)

use super::accessor::Accessor;
use super::at::At;
use super::notes::Notes;
use super::primitive::FaceMesh;
use eyebox_base::Code;
use glam::DVec3;

/// Used where neither the file nor the triangles give a direction.
const ANY: [f32; 3] = [0.0, 0.0, 1.0];

/// Twice the area of a triangle times its unit normal, by the right-hand rule.
pub(crate) fn area_normal(positions: &[[f32; 3]], triangle: [u32; 3]) -> DVec3 {
    let corner = |i: u32| positions.get(i as usize).map_or(DVec3::ZERO, |p| DVec3::from(p.map(f64::from)));
    let [a, b, c] = triangle.map(corner);
    (b - a).cross(c - a)
}

pub(crate) fn unit(normal: DVec3) -> Option<[f32; 3]> {
    // The length is taken after scaling: neither denormal nor huge vectors lose their direction.
    let largest = normal.abs().max_element();
    let usable = largest > 0.0 && largest.is_finite() && normal.is_finite();
    usable.then(|| (normal / largest).normalize().to_array().map(|x| x as f32))
}

/// Whether every normal is within 20° of every triangle at its vertex: then none contradicts, and the thorough look
/// around each vertex (which costs some microseconds a triangle) can be left out. On a fine tessellation only faces
/// with a wrong normal fail.
pub(crate) fn are_sound(positions: &[[f32; 3]], normals: &[[f32; 3]], triangles: &[[u32; 3]]) -> bool {
    const COS_20: f64 = 0.939_692_620_785_908_4;
    triangles.iter().all(|&triangle| {
        let area = area_normal(positions, triangle);
        let least = COS_20 * area.length();
        let normal = |vertex: u32| normals.get(vertex as usize).map_or(DVec3::ZERO, |n| DVec3::from(n.map(f64::from)));
        triangle.into_iter().all(|vertex| area.dot(normal(vertex)) >= least)
    })
}

/// The face with vertices of its own for each triangle and flat normals.
pub(super) fn flat(face: FaceMesh, at: &At<'_>, notes: &mut Notes) -> FaceMesh {
    let (out, without_area) = flat_shaded(&face);
    if without_area > 0 {
        let text = "a triangle without area and without normals";
        notes.add_many(eyebox_scene::Severity::Info, at.place(), text, without_area);
    }
    out
}

/// The face with vertices of its own for each triangle and flat normals, and how many triangles have no area.
pub(crate) fn flat_shaded(face: &FaceMesh) -> (FaceMesh, usize) {
    let (mut out, mut without_area) = (FaceMesh::default(), 0);
    out.triangles.reserve_exact(face.triangles.len());
    out.positions.reserve_exact(3 * face.triangles.len());
    out.normals.reserve_exact(3 * face.triangles.len());
    for &triangle in &face.triangles {
        let normal = unit(area_normal(&face.positions, triangle)).unwrap_or_else(|| {
            without_area += 1;
            ANY
        });
        let first = out.positions.len() as u32;
        out.triangles.push([first, first + 1, first + 2]);
        for vertex in triangle {
            out.positions.push(face.positions.get(vertex as usize).copied().unwrap_or_default());
            out.normals.push(normal);
            out.uvs.extend(face.uvs.get(vertex as usize));
            out.second_uvs.extend(face.second_uvs.get(vertex as usize));
            out.tangents.extend(face.tangents.get(vertex as usize));
            out.colors.extend(face.colors.get(vertex as usize));
            out.sources.extend(face.sources.get(vertex as usize));
        }
    }
    (out, without_area)
}

/// Normals as [`settle`] leaves them, and what was wrong with how many.
pub(crate) struct Settled {
    pub normals: Vec<[f32; 3]>,
    /// Not of unit length: normalised.
    pub off: usize,
    /// Zero or not finite: computed.
    pub broken: usize,
}

/// The file's normals at unit length; those that are zero or not finite become the area-weighted mean of the
/// triangles around the vertex, with a note.
pub(super) fn settled(
    read: Vec<[f32; 3]>,
    positions: &[[f32; 3]],
    triangles: &[[u32; 3]],
    accessor: &Accessor<'_>,
    notes: &mut Notes,
) -> Vec<[f32; 3]> {
    // Quantized normals are never of unit length; floats are, to rounding.
    let tolerance = if accessor.component == super::accessor::Component::F32 { 1e-3 } else { 0.05 };
    let Settled { normals, off, broken } = settle(read, positions, triangles, tolerance);
    if off > 0 {
        let text = "normals that are not of unit length: normalised";
        notes.add_many(eyebox_scene::Severity::Info, accessor.at.place(), text, off);
    }
    if broken > 0 {
        let text = "a normal that is zero or not finite: computed from the triangles around its vertex";
        notes.add(eyebox_scene::Note::warning(accessor.at.place(), text).code(Code::DataNotFinite), broken);
    }
    normals
}

/// As [`settled`]; lengths off by up to `tolerance` are not counted.
pub(crate) fn settle(read: Vec<[f32; 3]>, positions: &[[f32; 3]], triangles: &[[u32; 3]], tolerance: f64) -> Settled {
    let mut out = Settled { normals: read, off: 0, broken: 0 };
    let mut broken = Vec::new();
    for (vertex, normal) in out.normals.iter_mut().enumerate() {
        let stored = DVec3::from(normal.map(f64::from));
        let off = (stored.length() - 1.0).abs();
        if off <= 1e-6 {
            continue; // unit to rounding: the file's own bits stay
        }
        match unit(stored) {
            Some(unit) => {
                out.off += usize::from(off > tolerance);
                *normal = unit;
            }
            None => {
                broken.push(vertex);
                *normal = ANY;
            }
        }
    }
    out.broken = broken.len();
    if broken.is_empty() {
        return out;
    }
    let mut sums = vec![DVec3::ZERO; out.normals.len()];
    for &triangle in triangles {
        let normal = area_normal(positions, triangle);
        for vertex in triangle {
            if let Some(sum) = sums.get_mut(vertex as usize) {
                *sum += normal;
            }
        }
    }
    for vertex in broken {
        let computed = sums.get(vertex).copied().and_then(unit);
        if let (Some(slot), Some(normal)) = (out.normals.get_mut(vertex), computed) {
            *slot = normal;
        }
    }
    out
}
