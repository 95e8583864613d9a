//! Vertex normals that contradict the triangles around them. Exporters write some at the poles of revolved faces,
//! where one wrong normal among thousands bends light into a ghost; the rest of a face's normals are left exactly as
//! they came.

use super::weld::{rounding, weld};
use glam::DVec3;

/// What was found in the normals of one face, and what was done.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct Repair {
    /// Normals that pointed the opposite way, and were turned round.
    pub flipped: usize,
    /// Normals that were no direction (zero, NaN) or pointed aside, and were replaced.
    pub replaced: usize,
    /// Normals with a length off by more than 1 %, brought to unit length.
    pub rescaled: usize,
    /// Vertices that came without a normal, and were given one.
    pub missing: usize,
    /// Largest angle between a given normal and the mean of its triangles before the repair, degrees (0 where none was
    /// given).
    pub worst_deg: f64,
    /// Nine in ten normals or more oppose the winding of their triangles: which of the two is wrong cannot be told from
    /// here. The normals still point as they came; the few that contradicted the others were made to agree with them.
    pub inverted: bool,
    /// No two triangles that share an edge meet at more than 30°. Where normals are missing and this is false, the
    /// computed ones hide an edge, and glTF asks for flat shading (glTF 2.0 §3.7.2.1) anyway.
    pub smooth: bool,
}

/// Directions that differ by less belong to one smooth surface: half the step of the coarsest cylinder with eight
/// sides, doubled.
const CREASE_DEG: f64 = 45.0;
const SMOOTH_DEG: f64 = 30.0;
/// Corners and vertices that are looked at around one place. A pole has some hundreds; a hostile file could put all its
/// vertices there, and looking at each from each would take for ever.
const MOST_AROUND: usize = 512;

/// Checks the vertex normals of one face against its triangles and mends those that contradict them.
///
/// A normal contradicts if it is farther from the angle-weighted mean of the triangles at its place (coincident
/// vertices count as one place; triangles across a crease do not count) than 45° or twice the spread of those
/// triangles, whichever is more, but at most 90°. One whose opposite does not contradict is turned round, which keeps
/// the exact direction of an exporter that lost a sign; any other becomes the mean of the sound normals at its place,
/// else of the triangles there. `normals` shorter than `positions` is filled up, longer is cut. Triangles with indices
/// out of range or without an area say nothing.
pub fn repair(positions: &[[f32; 3]], normals: &mut Vec<[f32; 3]>, triangles: &[[u32; 3]]) -> Repair {
    let given = normals.len().min(positions.len());
    normals.resize(positions.len(), [0.0; 3]);
    let around = Around::new(positions, triangles);
    let mut out = Repair { missing: positions.len() - given, smooth: around.smooth(), ..Repair::default() };

    let direction = |n: &[f32; 3]| DVec3::from_array(n.map(f64::from)).try_normalize();
    let means: Vec<Option<Mean>> = (0..positions.len()).map(|vertex| around.mean(vertex)).collect();
    let (mut opposed, mut judged) = (0usize, 0usize);
    for (normal, mean) in normals.iter().zip(&means).take(given) {
        if let (Some(n), Some(mean)) = (direction(normal), mean) {
            judged += 1;
            opposed += usize::from(n.dot(mean.direction) < 0.0);
            out.worst_deg = out.worst_deg.max(degrees(n, mean.direction));
        }
    }
    out.inverted = judged > 0 && opposed >= judged - judged / 10;
    let side = if out.inverted { -1.0 } else { 1.0 };

    // Sound normals by place first: they are the best model for the unsound ones beside them.
    let sound =
        |vertex: usize, n: DVec3| means[vertex].as_ref().is_none_or(|m| degrees(side * n, m.direction) <= m.limit);
    let mut kept: Vec<Option<DVec3>> = vec![None; positions.len()];
    for (vertex, normal) in normals.iter_mut().enumerate().take(given) {
        let Some(n) = direction(normal) else { continue };
        if sound(vertex, n) {
            kept[vertex] = Some(n);
            let length = DVec3::from_array(normal.map(f64::from)).length();
            if (length - 1.0).abs() > 0.01 {
                *normal = n.as_vec3().to_array();
                out.rescaled += 1;
            }
        } else if sound(vertex, -n) {
            kept[vertex] = Some(-n);
            *normal = normal.map(|x| -x);
            out.flipped += 1;
        }
    }
    for vertex in (0..positions.len()).filter(|&vertex| kept[vertex].is_none()) {
        let mean = means[vertex].as_ref().map(|m| side * m.direction);
        let beside = around.place(vertex).iter().filter_map(|&other| kept.get(other).copied().flatten());
        let beside =
            beside.filter(|n| mean.is_none_or(|m| degrees(*n, m) <= CREASE_DEG)).sum::<DVec3>().try_normalize();
        normals[vertex] = beside.or(mean).unwrap_or(DVec3::Z).as_vec3().to_array();
        out.replaced += usize::from(vertex < given);
    }
    out
}

/// Angle between unit vectors, exact for small ones.
fn degrees(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b)).to_degrees()
}

/// The mean direction of the triangles at a vertex and how far from it a normal may be.
struct Mean {
    direction: DVec3,
    limit: f64,
}

/// Triangles by the place of their corners.
struct Around {
    /// The place of each vertex: the first vertex that coincides with it.
    first: Vec<usize>,
    /// Vertices and triangle corners at each place, indexed by its first vertex.
    vertices: Vec<Vec<usize>>,
    corners: Vec<Vec<Corner>>,
    /// Unit normals of the triangles that have one, with the places of their corners.
    faces: Vec<([usize; 3], DVec3)>,
}

struct Corner {
    vertex: usize,
    normal: DVec3,
    angle: f64,
}

impl Around {
    fn new(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Self {
        let first = weld(positions, rounding(positions));
        let mut vertices = vec![Vec::new(); positions.len()];
        for (vertex, &place) in first.iter().enumerate() {
            vertices[place].push(vertex);
        }
        let mut corners: Vec<Vec<Corner>> = (0..positions.len()).map(|_| Vec::new()).collect();
        let mut faces = Vec::new();
        for triangle in triangles {
            let index = triangle.map(|i| usize::try_from(i).unwrap_or(usize::MAX));
            let [Some(a), Some(b), Some(c)] = index.map(|i| positions.get(i)) else { continue };
            let at = [a, b, c].map(|p| DVec3::from_array(p.map(f64::from)));
            let places = index.map(|i| first[i]);
            if places[0] == places[1] || places[1] == places[2] || places[2] == places[0] {
                continue; // collapsed by coincident corners: its normal would be made of rounding
            }
            let Some(normal) = (at[1] - at[0]).cross(at[2] - at[0]).try_normalize() else { continue };
            for corner in 0..3 {
                let (p, q) = (at[(corner + 1) % 3] - at[corner], at[(corner + 2) % 3] - at[corner]);
                let angle = p.cross(q).length().atan2(p.dot(q));
                corners[places[corner]].push(Corner { vertex: index[corner], normal, angle });
            }
            faces.push((places, normal));
        }
        Around { first, vertices, corners, faces }
    }

    /// The vertices at the place of `vertex`, itself included (but [`MOST_AROUND`] at most).
    fn place(&self, vertex: usize) -> &[usize] {
        let vertices = &self.vertices[self.first[vertex]];
        &vertices[..vertices.len().min(MOST_AROUND)]
    }

    /// None where no triangle with an area touches the place.
    fn mean(&self, vertex: usize) -> Option<Mean> {
        let corners = &self.corners[self.first[vertex]];
        let corners = &corners[..corners.len().min(MOST_AROUND)];
        // What lies on the vertex's own side of a crease: near the mean of its own triangles, if it has any.
        let sum = |only: &dyn Fn(&Corner) -> bool| {
            corners.iter().filter(|c| only(c)).map(|c| c.angle * c.normal).sum::<DVec3>().try_normalize()
        };
        let own = sum(&|c| c.vertex == vertex).or_else(|| sum(&|_| true))?;
        let near = |c: &Corner| c.vertex == vertex || degrees(c.normal, own) <= CREASE_DEG;
        let direction = sum(&near).unwrap_or(own);
        let spread = corners.iter().filter(|c| near(c)).map(|c| degrees(c.normal, direction)).fold(0.0, f64::max);
        Some(Mean { direction, limit: (2.0 * spread).clamp(CREASE_DEG, 90.0) })
    }

    fn smooth(&self) -> bool {
        let mut edges: Vec<(usize, usize, usize)> = Vec::with_capacity(3 * self.faces.len());
        for (face, ([a, b, c], _)) in self.faces.iter().enumerate() {
            edges.extend([(a, b), (b, c), (c, a)].map(|(p, q)| (*p.min(q), *p.max(q), face)));
        }
        edges.sort_unstable();
        edges.windows(2).all(|w| {
            let ((a, b, one), (c, d, other)) = (w[0], w[1]);
            (a, b) != (c, d) || degrees(self.faces[one].1, self.faces[other].1) <= SMOOTH_DEG
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::fit::cad::{find, primitives};
    use super::*;

    type Points = Vec<[f32; 3]>;

    /// A fan of eight triangles about a pole that is written twice, as exporters of revolved faces do; half side 1,
    /// sag 0.1.
    fn fan() -> (Points, Points, Vec<[u32; 3]>) {
        let mut positions = vec![[0.0, 0.0, 0.0]; 2];
        let mut normals = vec![[0.0, 0.0, -1.0]; 2];
        for i in 0..8 {
            let (y, x) = (f64::from(i) * std::f64::consts::FRAC_PI_4).sin_cos();
            positions.push([x as f32, y as f32, 0.1]);
            let n = DVec3::new(0.2 * x, 0.2 * y, -1.0).normalize();
            normals.push(n.as_vec3().to_array());
        }
        let triangles = (0..8).map(|i| [u32::from(i >= 4), 2 + (i + 1) % 8, 2 + i]).collect();
        (positions, normals, triangles)
    }

    #[test]
    fn sound_normals_are_left_as_they_are() {
        let (positions, mut normals, triangles) = fan();
        let before = normals.clone();
        let found = repair(&positions, &mut normals, &triangles);
        assert_eq!(
            (found.flipped, found.replaced, found.missing, found.inverted, found.smooth),
            (0, 0, 0, false, true)
        );
        assert!(found.worst_deg < 12.0);
        assert_eq!(normals, before);
    }

    #[test]
    fn an_opposite_a_zero_a_nan_and_a_long_one() {
        let (positions, sound, triangles) = fan();
        let mut normals = sound.clone();
        normals[1] = [0.0, 0.0, 1.0];
        normals[3] = [0.0; 3];
        normals[4] = [f32::NAN, 0.0, 1.0];
        normals[5] = sound[5].map(|x| 3.0 * x);
        let found = repair(&positions, &mut normals, &triangles);
        assert_eq!((found.flipped, found.replaced, found.rescaled, found.inverted), (1, 2, 1, false));
        assert_eq!(found.worst_deg.round(), 180.0);
        assert_eq!(normals[1], sound[1]);
        for (n, want) in normals.iter().zip(&sound) {
            let angle = degrees(
                DVec3::from_array(n.map(f64::from)).normalize(),
                DVec3::from_array(want.map(f64::from)).normalize(),
            );
            assert!(angle < 7.0, "{n:?} {want:?}"); // a replaced one is the mean of its two facets: off by their slope
        }
        // Beside a sound normal at the same place, that one is taken.
        let mut normals = sound.clone();
        normals[0] = [1.0, 0.0, 0.0];
        assert_eq!(repair(&positions, &mut normals, &triangles).replaced, 1);
        assert_eq!(normals[0], sound[1]);
    }

    #[test]
    fn an_inverted_face_is_reported_and_not_turned() {
        let (positions, sound, triangles) = fan();
        let mut normals: Vec<_> = sound.iter().map(|n| n.map(|x| -x)).collect();
        let before = normals.clone();
        let found = repair(&positions, &mut normals, &triangles);
        assert!(found.inverted && found.flipped == 0 && normals == before);
        // One that agrees with the winding is then the odd one.
        normals[1] = sound[1];
        let found = repair(&positions, &mut normals, &triangles);
        assert!(found.inverted && found.flipped == 1 && normals == before, "{found:?}");
    }

    #[test]
    fn missing_normals_are_computed_and_an_edge_is_called_one() {
        let (positions, sound, triangles) = fan();
        let mut normals = Vec::new();
        let found = repair(&positions, &mut normals, &triangles);
        assert!(found.missing == 10 && found.replaced == 0 && found.smooth && normals.len() == 10);
        assert!(degrees(DVec3::from_array(normals[0].map(f64::from)), DVec3::NEG_Z) < 1e-3, "{:?}", normals[0]);
        assert!(normals.iter().zip(&sound).all(|(n, s)| (0..3).all(|i| (n[i] - s[i]).abs() < 0.15)));
        // Two squares at a right angle, corners shared.
        let positions =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0]];
        let triangles = [[0, 1, 2], [0, 2, 3], [1, 0, 4], [1, 4, 5]];
        assert!(!repair(&positions, &mut Vec::new(), &triangles).smooth);
    }

    #[test]
    fn hostile_input_is_survived() {
        let positions = [[f32::NAN; 3], [0.0; 3], [f32::MAX; 3], [1.0, 0.0, 0.0]];
        let mut normals = vec![[f32::INFINITY; 3]; 9];
        repair(&positions, &mut normals, &[[0, 1, 2], [1, 1, 1], [7, 8, u32::MAX], [1, 2, 3]]);
        assert!(normals.len() == 4 && normals.iter().flatten().all(|x| x.is_finite()));
        repair(&[], &mut Vec::new(), &[[0, 1, 2]]);
    }

    /// A disc of 60 000 triangles, each with a centre of its own: quadratic work would take minutes.
    #[test]
    fn many_vertices_at_one_place_take_linear_time() {
        let count = 60_000u32;
        let rim = |i: u32| (f64::from(i) / f64::from(count) * std::f64::consts::TAU).sin_cos();
        let mut positions: Points = (0..count).map(|i| [rim(i).1 as f32, rim(i).0 as f32, 0.0]).collect();
        positions.extend((0..count).map(|_| [0.0; 3]));
        let triangles: Vec<[u32; 3]> = (0..count).map(|i| [count + i, i, (i + 1) % count]).collect();
        let mut normals = vec![[0.0, 0.0, 1.0]; positions.len()];
        normals[count as usize + 7] = [0.0, 0.0, -1.0];
        let start = std::time::Instant::now();
        let found = repair(&positions, &mut normals, &triangles);
        assert_eq!((found.flipped, found.replaced), (1, 0));
        assert!(normals.iter().all(|&normal| normal == [0.0, 0.0, 1.0]));
        assert!(start.elapsed().as_secs() < 60, "{:?}", start.elapsed());
    }

    /// The CAD files as they came had three normals of poles the wrong way; the samples have them mended.
    #[test]
    fn the_normals_of_the_cad_samples_are_sound_and_wrong_ones_are_found() {
        for file in ["hud-direct/hud_direct.glb", "hud-diffuse/hud_diffuse.glb"] {
            let all = primitives(file);
            for face in &all {
                let mut normals = face.normals.clone();
                let found = repair(&face.positions, &mut normals, &face.triangles);
                assert_eq!(
                    (found.flipped, found.replaced, found.rescaled, found.missing),
                    (0, 0, 0, 0),
                    "{}",
                    face.part
                );
                assert!(!found.inverted && normals == face.normals);
            }
            // After the repair the pole normal is the one of the surface, ±z of the part.
            for (name, face, z, wrong) in [("LENS_01_PMMA", 0, -1.0, &[0, 1][..]), ("LENS_04_F2", 2, 1.0, &[263])] {
                if name == "LENS_04_F2" && !file.contains("diffuse") {
                    continue;
                }
                let cap = find(&all, name, face);
                let mut normals = cap.normals.clone();
                wrong.iter().for_each(|vertex| normals[*vertex] = normals[*vertex].map(|x| -x));
                let found = repair(&cap.positions, &mut normals, &cap.triangles);
                assert_eq!((found.flipped, found.replaced), (wrong.len(), 0));
                assert_eq!(normals, cap.normals);
                let pole = |p: &[f32; 3]| p[0].hypot(p[1]) < 1e-6;
                let at_pole: Vec<_> = cap.positions.iter().zip(&normals).filter(|(p, _)| pole(p)).collect();
                assert!(at_pole.len() == 2 && at_pole.iter().all(|(_, n)| (n[2] - z).abs() < 1e-6), "{at_pole:?}");
            }
        }
    }
}
