//! Vertex normals of one face: flat ones where the file has none, and new ones where the file's have no direction.
//! (Normals that have a direction but contradict their triangles are another matter: see `primitive`.)

use super::accessor::Accessor;
use super::at::At;
use super::notes::Notes;
use super::primitive::FaceMesh;
use glam::DVec3;

/// Used where neither the file nor the triangles give a direction.
const ANY: [f32; 3] = [0.0, 0.0, 1.0];

/// Twice the area of a triangle times its unit normal, by the right-hand rule.
fn area_normal(positions: &[[f32; 3]], triangle: [u32; 3]) -> DVec3 {
    let corner = |i: u32| positions.get(i as usize).map_or(DVec3::ZERO, |p| DVec3::from(p.map(f64::from)));
    let [a, b, c] = triangle.map(corner);
    (b - a).cross(c - a)
}

fn unit(normal: DVec3) -> Option<[f32; 3]> {
    // The length is taken after scaling: neither denormal nor huge vectors lose their direction.
    let largest = normal.abs().max_element();
    let usable = largest > 0.0 && largest.is_finite() && normal.is_finite();
    usable.then(|| (normal / largest).normalize().to_array().map(|x| x as f32))
}

/// Whether every normal is within 20° of every triangle at its vertex: then none contradicts, and the thorough look
/// around each vertex (which costs some microseconds a triangle) can be left out. On a fine tessellation only faces
/// with a wrong normal fail.
pub(super) fn are_sound(positions: &[[f32; 3]], normals: &[[f32; 3]], triangles: &[[u32; 3]]) -> bool {
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
    let mut out = FaceMesh::default();
    for &triangle in &face.triangles {
        let normal = unit(area_normal(&face.positions, triangle)).unwrap_or_else(|| {
            notes.info(at, "a triangle without area and without normals");
            ANY
        });
        let first = out.positions.len() as u32;
        out.triangles.push([first, first + 1, first + 2]);
        for vertex in triangle {
            out.positions.push(face.positions.get(vertex as usize).copied().unwrap_or_default());
            out.normals.push(normal);
            out.uvs.extend(face.uvs.get(vertex as usize));
        }
    }
    out
}

/// The file's normals at unit length; those that are zero or not finite become the area-weighted mean of the
/// triangles around the vertex, with a note.
pub(super) fn settled(
    mut normals: Vec<[f32; 3]>,
    positions: &[[f32; 3]],
    triangles: &[[u32; 3]],
    accessor: &Accessor<'_>,
    notes: &mut Notes,
) -> Vec<[f32; 3]> {
    // Quantized normals are never of unit length; floats are, to rounding.
    let tolerance = if accessor.component == super::accessor::Component::F32 { 1e-3 } else { 0.05 };
    let mut broken = Vec::new();
    for (vertex, normal) in normals.iter_mut().enumerate() {
        let stored = DVec3::from(normal.map(f64::from));
        let off = (stored.length() - 1.0).abs();
        if off <= 1e-6 {
            continue; // unit to rounding: the file's own bits stay
        }
        match unit(stored) {
            Some(unit) => {
                if off > tolerance {
                    notes.info(&accessor.at, "normals that are not of unit length: normalised");
                }
                *normal = unit;
            }
            None => {
                broken.push(vertex);
                *normal = ANY;
            }
        }
    }
    if broken.is_empty() {
        return normals;
    }
    let mut sums = vec![DVec3::ZERO; normals.len()];
    for &triangle in triangles {
        let normal = area_normal(positions, triangle);
        for vertex in triangle {
            if let Some(sum) = sums.get_mut(vertex as usize) {
                *sum += normal;
            }
        }
    }
    for vertex in broken {
        notes.warn(&accessor.at, "a normal that is zero or not finite: computed from the triangles around its vertex");
        let computed = sums.get(vertex).copied().and_then(unit);
        if let (Some(slot), Some(normal)) = (normals.get_mut(vertex), computed) {
            *slot = normal;
        }
    }
    normals
}
