//! What the facets of a curved specular face will do to a picture, foretold from the mesh alone.

use crate::geometry::{corners, triangles};
use crate::subject::{is_mesh, is_specular};
use eyebox_base::Where;
use eyebox_base::units::ARCMIN;
use eyebox_base::weld::{rounding, weld};
use eyebox_scene::{FaceRange, Mesh, Note, Scene};
use glam::DVec3;
use std::collections::HashMap;

/// What a normal eye resolves, arc minutes.
pub const EYE_ARCMIN: f64 = 1.0;

/// By how much mirrored rays miss their directions, arc minutes: root mean squares over the face's area. Refracted rays miss
/// by less.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct Facets {
    /// The flat facet lies beside the true surface, and a ray meets it beside the place where it should.
    pub sag_arcmin: f64,
    /// Neighbouring facets have normals of their own.
    pub steps_arcmin: f64,
    /// The normals at the vertices are not those of the surface on which the vertices lie, or turn unevenly between them.
    pub normals_arcmin: f64,
}

impl Facets {
    /// All together: errors that know nothing of each other.
    pub fn arcmin(self) -> f64 {
        self.sag_arcmin.hypot(self.steps_arcmin).hypot(self.normals_arcmin)
    }

    pub fn text(self) -> String {
        let [all, sag, steps, normals] = [self.arcmin(), self.sag_arcmin, self.steps_arcmin, self.normals_arcmin];
        format!(
            "its facets turn and blur mirrored light by about {all:.2} arcmin (sag {sag:.2}, steps {steps:.2}, vertex normals \
             {normals:.2}); the eye resolves {EYE_ARCMIN:.0}"
        )
    }
}

/// Foretells what a face does. A mirrored ray turns by twice the error of the normal that it meets.
///
/// *Sag.* Let a facet's corners have normals that differ by θ over its length h. Its plane lies under the surface by up to
/// h·θ/8; a ray at 45° meets it as far beside the place where it should, and there the true normal differs by θ²/8.
///
/// *Steps.* Where facets have normals of their own plane, the error is half of the step to the neighbour.
///
/// *Vertex normals.* Along an edge of a smooth surface the chord's slope is the mean of the slopes at its ends, up to h²κ′/12
/// (the trapezoidal rule's error; κ′ is the curvature's change along the edge). So with ends a, b and their normals m, n the
/// angle (b − a)·(m + n)/(2h) is 0 on a surface whose curvature is even, and else as large as what linear interpolation of
/// the normals errs by (h²κ′/8 at most), or as what the normals themselves are off. Rounding of the vertices can feign
/// as much as itself over h; that is taken off.
pub fn of(mesh: &Mesh, range: FaceRange) -> Facets {
    let own = triangles(mesh, range);
    // Only what the face has: a mesh may have many faces.
    let points: Vec<[f32; 3]> =
        own.iter().flatten().map(|v| mesh.positions.get(*v as usize).copied().unwrap_or([f32::NAN; 3])).collect();
    let grain = rounding(&points);
    let place = weld(&points, 4.0 * grain);
    let normal = |vertex: u32| {
        let normal = mesh.normals.get(vertex as usize)?;
        DVec3::from_array(normal.map(f64::from)).try_normalize()
    };
    let angle = |a: DVec3, b: DVec3| a.cross(b).length().atan2(a.dot(b));
    // The first normal seen at each place: what comes later at the same place is compared with it.
    let mut known = HashMap::<usize, DVec3>::new();
    let (mut sums, mut whole) = ([0.0; 3], 0.0);
    for (index, triangle) in own.iter().enumerate() {
        let (Some(ends), [Some(n), Some(o), Some(p)]) = (corners(mesh, *triangle), triangle.map(normal)) else {
            continue;
        };
        let normals = [n, o, p];
        let bend = angle(n, o).max(angle(o, p)).max(angle(p, n));
        let mut step = 0.0_f64;
        for (corner, normal) in normals.into_iter().enumerate() {
            let Some(place) = place.get(3 * index + corner) else { continue };
            let other = *known.entry(*place).or_insert(normal);
            let off = angle(other, normal);
            // A step of 45° and more is an edge that is meant.
            if off < std::f64::consts::FRAC_PI_4 {
                step = step.max(off);
            }
        }
        let slope = |i: usize| {
            let (edge, sum) = (ends[(i + 1) % 3] - ends[i], normals[(i + 1) % 3] + normals[i]);
            let length = edge.length();
            if length > 0.0 { ((0.5 * edge.dot(sum)).abs() - 2.0 * grain).max(0.0) / length } else { 0.0 }
        };
        let [a, b, c] = ends;
        let area = 0.5 * (b - a).cross(c - a).length();
        let slopes = (0..3).map(|i| slope(i).powi(2)).sum::<f64>() / 3.0;
        for (sum, square) in sums.iter_mut().zip([(bend * bend / 8.0).powi(2), (step / 2.0).powi(2), slopes]) {
            *sum += area * square;
        }
        whole += area;
    }
    let [sag_arcmin, steps_arcmin, normals_arcmin] =
        sums.map(|sum| if whole > 0.0 { 2.0 * (sum / whole).sqrt() / ARCMIN } else { 0.0 });
    Facets { sag_arcmin, steps_arcmin, normals_arcmin }
}

/// What each specular face that is traced as a mesh does: number of the part, of the face.
pub fn all(scene: &Scene) -> impl Iterator<Item = (usize, usize, Facets)> + '_ {
    scene.parts.iter().enumerate().flat_map(move |(part, own)| {
        let mesh = scene.mesh(own.mesh);
        let faces = own.faces.iter().zip(&mesh.faces).enumerate();
        let seen = faces.filter(|(_, (face, _))| is_mesh(face) && is_specular(face));
        seen.map(move |(number, (_, range))| (part, number, of(mesh, *range)))
    })
}

/// A warning for each face whose facets an eye sees.
pub fn warnings(scene: &Scene) -> Vec<Note> {
    let seen = all(scene).filter(|(_, _, facets)| facets.arcmin() > EYE_ARCMIN);
    seen.filter_map(|(part, face, facets)| {
        let at = Where::Part { path: scene.parts.get(part)?.path.clone(), face: Some(face) };
        let text = format!("{}: give it a `shape`, or finer facets with the normals of the surface", facets.text());
        Some(Note::warning(at, text))
    })
    .collect()
}

#[cfg(test)]
#[path = "facets_tests.rs"]
mod tests;
