//! Rims and seams: the edges where faces that scatter end, and the lines where something else crosses or stands on one. A
//! kernel about a point near a rim lies partly beside the face, where no photon can be; behind a seam there are photons,
//! but of light that need not be the point's. How much of a kernel is left is known in closed form.

use super::geometry::{Geometry, Site};
use super::outline::Outline;
use super::seam;
use super::surface::{FaceOptics, Surface};
use eyebox_scene::Scene;
use eyebox_scene::mesh::{FaceRange, Mesh};
use glam::{DVec2, DVec3};
use std::collections::HashMap;
use std::f64::consts::PI;
use std::sync::OnceLock;

/// Edges that one leaf of a tree holds.
const LEAF: usize = 2;

/// An edge, recentred world, m: of a rim, the face is on its left, seen against the face's normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edge(pub [DVec3; 2]);

/// A box about the edges `first .. end`. Nodes stand in the order of a walk; `next` is where it goes on without this one.
#[derive(Debug, Clone, Copy)]
struct Node {
    lo: DVec3,
    hi: DVec3,
    first: u32,
    end: u32,
    next: u32,
    leaf: bool,
}

/// Edges in a tree of boxes.
#[derive(Debug, Default)]
pub struct Rim {
    edges: Vec<Edge>,
    nodes: Vec<Node>,
}

/// The lines of one face.
#[derive(Debug, Default)]
struct Lines {
    rim: Rim,
    /// Looked for where somebody first gathers light on the face: most faces of a scene in which nobody does have none.
    seams: OnceLock<Rim>,
}

/// The rims and seams of all faces that scatter, and the outlines of those that reflect, refract, show slides or shine.
#[derive(Debug, Default)]
pub struct Rims {
    by_face: HashMap<(u32, u32), Lines>,
    /// What leaves seams on faces, if one of them scatters.
    obstacles: Option<seam::Obstacles>,
    outlines: HashMap<(u32, u32), Outline>,
    /// Of faces that show slides or shine.
    pictures: HashMap<(u32, u32), Outline>,
}

/// What of a kernel about a point counts.
#[derive(Debug, Clone, PartialEq)]
pub struct Around {
    /// The share of the kernel that does.
    pub share: f64,
    /// Where the point has seams near it: what bounds its view, in a plane about it.
    view: Option<View>,
}

/// Lines about a point, in its tangent plane, m.
#[derive(Debug, Clone, PartialEq)]
struct View {
    point: DVec3,
    plane: [DVec3; 2],
    walls: Vec<[DVec2; 2]>,
}

impl View {
    fn flat(&self, at: DVec3) -> DVec2 {
        DVec2::new((at - self.point).dot(self.plane[0]), (at - self.point).dot(self.plane[1]))
    }
}

impl Around {
    /// Whether what lies at a place of the kernel counts.
    pub fn counts(&self, at: DVec3) -> bool {
        self.view.as_ref().is_none_or(|view| {
            let at = view.flat(at);
            !view.walls.iter().any(|wall| seam::hides(wall, at))
        })
    }
}

impl Rims {
    pub fn find(scene: &Scene, geometry: &Geometry, faces: &[Vec<FaceOptics>]) -> Rims {
        let (mut by_face, mut outlines, mut pictures) = (HashMap::new(), HashMap::new(), HashMap::new());
        // Made where a face asks for them: a scene without one that scatters has no seams.
        let mut obstacles: Option<seam::Obstacles> = None;
        for (p, (part, optics)) in scene.parts.iter().zip(faces).enumerate() {
            let (Some(mesh), Ok(number)) = (scene.meshes.get(part.mesh.index()), u32::try_from(p)) else { continue };
            let to_world = geometry.part_to_world(number);
            let mirrored = to_world.matrix3.determinant() < 0.0;
            for (f, (range, optics)) in mesh.faces.iter().zip(optics).enumerate() {
                let shines = part.faces.get(f).is_some_and(|face| face.emitter.is_some());
                let (turns, scatters) = match &optics.surface {
                    Surface::Interface(_) | Surface::Mirror(_) | Surface::Splitter(_) | Surface::Grating(_) => {
                        (true, false)
                    }
                    Surface::Scatter(scatter) => (false, !scatter.is_narrow()),
                    Surface::Absent | Surface::Absorber | Surface::Slide(_) | Surface::Sheet(_) => (false, false),
                };
                let shows = shines || matches!(optics.surface, Surface::Slide(_));
                if !(turns || scatters || shows) {
                    continue;
                }
                let world = |v: [f32; 3]| to_world.transform_point3(DVec3::from(v.map(f64::from)));
                let edges = borders(mesh, *range).into_iter().map(|[a, b]| {
                    let (a, b) = (world(a), world(b));
                    Edge(if mirrored { [b, a] } else { [a, b] })
                });
                let edges: Vec<Edge> = edges.collect();
                if turns || shows {
                    let known = if turns { &mut outlines } else { &mut pictures };
                    known.extend(Outline::new(&edges).map(|outline| ((number, f as u32), outline)));
                }
                if !scatters {
                    continue;
                }
                let rim = Rim::new(edges);
                obstacles.get_or_insert_with(|| seam::Obstacles::new(scene, geometry, faces));
                by_face.insert((number, f as u32), Lines { rim, seams: OnceLock::new() });
            }
        }
        Rims { by_face, obstacles, outlines, pictures }
    }

    /// The seams of a face.
    fn seams<'l>(&self, site: Site, lines: &'l Lines) -> &'l Rim {
        lines.seams.get_or_init(|| {
            let face = (site.part as usize, site.face as usize);
            let seams = self.obstacles.as_ref().map(|obstacles| obstacles.on(face, &lines.rim));
            Rim::new(seams.unwrap_or_default())
        })
    }

    /// The outline of a face that reflects or refracts; none of one without a rim.
    pub fn outline(&self, part: u32, face: u32) -> Option<&Outline> {
        self.outlines.get(&(part, face))
    }

    /// The same of any face that a path to a picture meets: of those that show slides or shine, too.
    pub fn outline_to_picture(&self, part: u32, face: u32) -> Option<&Outline> {
        self.outline(part, face).or_else(|| self.pictures.get(&(part, face)))
    }

    /// What counts of Epanechnikov's kernel about a point of a face, taken as flat there: what lies on the face, so all of it
    /// but near rims, half on a straight one; and near seams what can be seen from the point without crossing a line.
    /// `normal`: of the face there. `radius`: of the kernel, m.
    ///
    /// With K = 2/(πr²)·(1 − ρ²/r²) the part beyond an edge at distance d, seen under the angles θ with ρ = d/cos θ, is
    /// ∫ (1 − ρ²/r²)²/2π dθ, whose parts integrate to θ, tan θ and tan³ θ.
    pub fn around(&self, site: Site, point: DVec3, normal: DVec3, radius: f64) -> Around {
        let Some(lines) = self.by_face.get(&(site.part, site.face)) else { return Around { share: 1.0, view: None } };
        let (x, y) = normal.any_orthonormal_pair();
        let mut view = View { point, plane: [x, y], walls: Vec::new() };
        let mut walls = Vec::new();
        self.seams(site, lines).near(point, radius, |Edge(ends)| walls.push(ends.map(|end| view.flat(end))));
        walls.retain(|wall| seam::distance(wall) < radius);
        if walls.is_empty() {
            let mut share = 1.0;
            lines.rim.near(point, radius, |Edge(ends)| share -= beyond(ends.map(|end| view.flat(end)), radius));
            // A sliver of a face, or a mesh whose rim is not where the face ends: no more than a corner is made up for.
            return Around { share: share.max(MOST_MADE_UP), view: None };
        }
        lines.rim.near(point, radius, |Edge(ends)| walls.push(ends.map(|end| view.flat(end))));
        let share = seam::seen(&walls, |wall| beyond(wall, radius).abs());
        view.walls = walls;
        Around { share: share.max(MOST_MADE_UP), view: Some(view) }
    }
}

const MOST_MADE_UP: f64 = 1.0 / 16.0;

/// The part of a kernel about the origin that an edge with the inside on its left cuts off, as a fan from there; negative for an edge that has
/// the origin on its right.
pub fn beyond([a, b]: [DVec2; 2], radius: f64) -> f64 {
    let along = (b - a).normalize_or_zero();
    let d = along.perp_dot(-a);
    let half = radius * radius - d * d;
    if half <= 0.0 || along == DVec2::ZERO {
        return 0.0;
    }
    let half = half.sqrt();
    let [from, to] = [a, b].map(|end| end.dot(along).clamp(-half, half));
    let r2 = radius * radius;
    let distance = d.abs();
    // Multiples of tan θ = t/d are written so that nothing is divided by a distance of 0.
    let whole = |t: f64| {
        let third = distance * t * t * t / (3.0 * r2 * r2);
        t.atan2(distance) - 2.0 * distance * t / r2 + distance.powi(3) * t / (r2 * r2) + third
    };
    (whole(to) - whole(from)) / (2.0 * PI) * if d < 0.0 { -1.0 } else { 1.0 }
}

/// Ends of an edge, mesh units.
type Ends = [[f32; 3]; 2];

/// The edges that only one triangle of a face has, in its direction. Vertices in the same place are one.
fn borders(mesh: &Mesh, face: FaceRange) -> Vec<Ends> {
    let bits = |v: [f32; 3]| v.map(|x| (x + 0.0).to_bits());
    let mut seen: HashMap<[[u32; 3]; 2], (u32, Ends)> = HashMap::new();
    let mut order = Vec::new();
    for triangle in mesh.triangles.get(face.triangles()).unwrap_or_default() {
        let Some(corners) = corners(mesh, *triangle) else { continue };
        for k in 0..3 {
            let edge = [corners[k], corners[(k + 1) % 3]];
            let mut key = edge.map(bits);
            key.sort_unstable();
            let entry = seen.entry(key).or_insert_with(|| {
                order.push(key);
                (0, edge)
            });
            entry.0 += 1;
        }
    }
    order.iter().filter_map(|key| seen.get(key).filter(|(count, _)| *count == 1).map(|(_, edge)| *edge)).collect()
}

fn corners(mesh: &Mesh, triangle: [u32; 3]) -> Option<[[f32; 3]; 3]> {
    let [a, b, c] = triangle.map(|index| mesh.positions.get(index as usize).copied());
    Some([a?, b?, c?])
}

impl Rim {
    pub fn new(mut edges: Vec<Edge>) -> Rim {
        let mut nodes = Vec::new();
        if !edges.is_empty() && u32::try_from(edges.len()).is_ok() {
            split(&mut edges, 0, &mut nodes);
        }
        Rim { edges, nodes }
    }

    /// Visits the edges whose boxes come within `radius` of a point, in a fixed order.
    pub fn near(&self, point: DVec3, radius: f64, mut visit: impl FnMut(Edge)) {
        self.nearer(point, radius, |edge| {
            visit(edge);
            radius
        });
    }

    /// The same where each visit says how near the next ones have to come.
    pub fn nearer(&self, point: DVec3, mut radius: f64, mut visit: impl FnMut(Edge) -> f64) {
        let mut at = 0;
        while let Some(node) = self.nodes.get(at) {
            let out = (node.lo - point).max(point - node.hi).max(DVec3::ZERO);
            let is_near = out.length_squared() <= radius * radius;
            if is_near && node.leaf {
                for edge in &self.edges[node.first as usize..node.end as usize] {
                    radius = visit(*edge);
                }
            }
            at = if is_near && !node.leaf { at + 1 } else { node.next as usize };
        }
    }
}

/// Adds the nodes over these edges, which it sorts; `first`: number of the first.
fn split(edges: &mut [Edge], first: usize, nodes: &mut Vec<Node>) {
    let (lo, hi) = edges.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), Edge([a, b])| {
        (lo.min(*a).min(*b), hi.max(*a).max(*b))
    });
    let (here, leaf) = (nodes.len(), edges.len() <= LEAF);
    nodes.push(Node { lo, hi, first: first as u32, end: (first + edges.len()) as u32, next: 0, leaf });
    if !leaf {
        let axis = (hi - lo).max_position();
        edges.sort_by(|Edge([a, b]), Edge([c, d])| (a[axis] + b[axis]).total_cmp(&(c[axis] + d[axis])));
        let middle = edges.len() / 2;
        let (low, high) = edges.split_at_mut(middle);
        split(low, first, nodes);
        split(high, first + middle, nodes);
    }
    nodes[here].next = nodes.len() as u32;
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rim(corners: &[[f64; 2]]) -> Rim {
        let at = |[x, y]: [f64; 2]| DVec3::new(x, y, 0.0);
        let next = corners.iter().cycle().skip(1);
        Rim::new(corners.iter().zip(next).map(|(a, b)| Edge([at(*a), at(*b)])).collect())
    }

    fn share(corners: &[[f64; 2]], point: [f64; 2], radius: f64) -> f64 {
        let lines = Lines { rim: rim(corners), seams: OnceLock::new() };
        let rims = Rims { by_face: HashMap::from([((0, 0), lines)]), ..Rims::default() };
        let site = Site { part: 0, face: 0, triangle: 0 };
        rims.around(site, DVec3::new(point[0], point[1], 0.0), DVec3::Z, radius).share
    }

    const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]];

    #[test]
    fn closed_forms_inside_on_an_edge_and_in_a_corner() {
        for (point, want) in [([5.0, 5.0], 1.0), ([5.0, 0.0], 0.5), ([1e-9, 1e-9], 0.25), ([10.0, 3.0], 0.5)] {
            let got = share(&SQUARE, point, 1.0);
            assert!((got - want).abs() < 2e-9, "{point:?}: {got}");
        }
        // Beyond a straight edge at half the radius: 8/3π·∫ cos⁴ from 30° to 90°, cos⁴ = 3/8 + cos 2φ/2 + cos 4φ/8.
        let beyond = 8.0 / (3.0 * PI) * (PI / 8.0 - 9.0 * 3f64.sqrt() / 64.0);
        let got = share(&SQUARE, [5.0, 0.5], 1.0);
        assert!((got - (1.0 - beyond)).abs() < 1e-14, "{got} {}", 1.0 - beyond);
    }

    /// Against sums over a fine raster of the kernel, for a shape with a corner that points inwards.
    #[test]
    fn any_polygon_agrees_with_a_raster() {
        let shape = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.2, 1.5], [0.5, 4.0]];
        let inside = |p: DVec2| {
            let n = shape.len();
            (0..n).fold(false, |odd, k| {
                let (a, b) = (DVec2::from(shape[k]), DVec2::from(shape[(k + 1) % n]));
                let crosses = (a.y > p.y) != (b.y > p.y) && p.x < (b.x - a.x) * (p.y - a.y) / (b.y - a.y) + a.x;
                odd ^ crosses
            })
        };
        for point in [[2.0, 1.2], [2.2, 1.3], [0.4, 0.3], [3.7, 3.0], [2.0, 0.1], [0.7, 2.5]] {
            let (radius, n) = (0.9, 1500);
            let (mut sum, mut all) = (0.0, 0.0);
            for i in 0..n * n {
                let at = DVec2::new((i % n) as f64 + 0.5, (i / n) as f64 + 0.5) * (2.0 / n as f64) - 1.0;
                let kernel = (1.0 - at.length_squared()).max(0.0);
                all += kernel;
                if inside(DVec2::from(point) + at * radius) {
                    sum += kernel;
                }
            }
            let got = share(&shape, point, radius);
            // A row of the raster on the wrong side of an edge is 0.75 of a cell's width.
            assert!((got - sum / all).abs() < 0.75 / n as f64, "{point:?}: {got} {}", sum / all);
        }
    }

    /// A quad of two triangles has four edges, in the direction of its winding; the diagonal is none.
    #[test]
    fn inner_edges_are_no_rim() {
        let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [-0.0, 0.0, 0.0]];
        let triangles = vec![[0, 1, 2], [4, 2, 3]];
        let mesh = Mesh { positions, triangles, ..Mesh::default() };
        let edges = borders(&mesh, FaceRange { first: 0, count: 2 });
        assert_eq!(edges.len(), 4);
        let area: f64 = edges.iter().map(|[a, b]| f64::from(a[0] * b[1] - a[1] * b[0]) / 2.0).sum();
        assert_eq!(area, 1.0);
    }
}
