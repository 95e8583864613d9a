//! Seams: the lines on a face that scatters where another face crosses it or stands on it. On both sides of one there is
//! light, but not the same, so a point gathers only from what it sees along the face without crossing a line.

use super::contact::{TOUCHING, grain};
use super::geometry::Geometry;
use super::rim::{Edge, Rim};
use super::surface::{FaceOptics, Surface};
use arrayvec::ArrayVec;
use eyebox_scene::{Mesh, Scene};
use glam::{DAffine3, DVec2, DVec3};
use std::f64::consts::TAU;
use std::fmt;

/// Corners of a triangle, recentred world, m.
type Corners = [DVec3; 3];

/// The triangles of a face that light does not simply go through.
struct Obstacle {
    part: usize,
    face: usize,
    lo: DVec3,
    hi: DVec3,
}

/// The triangles of a face of a part, world.
type TrianglesOf = dyn Fn(usize, usize) -> Vec<Corners> + Send + Sync;

/// What may stand on faces.
pub struct Obstacles {
    all: Vec<Obstacle>,
    /// Made where they are looked at, for a mesh may stand in a thousand places.
    triangles: Box<TrianglesOf>,
    /// What f64 may be off by, m.
    grain: f64,
}

impl fmt::Debug for Obstacles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Obstacles").field("count", &self.all.len()).finish_non_exhaustive()
    }
}

fn bounds(triangles: &[Corners]) -> (DVec3, DVec3) {
    let corners = triangles.iter().flatten();
    corners.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), corner| (lo.min(*corner), hi.max(*corner)))
}

/// The triangles of a face of a mesh, world.
fn placed_triangles(mesh: &Mesh, to_world: &DAffine3, face: usize) -> Vec<Corners> {
    let Some(range) = mesh.faces.get(face) else { return Vec::new() };
    let corner = |v: u32| {
        let place = mesh.positions.get(v as usize)?;
        Some(to_world.transform_point3(DVec3::from(place.map(f64::from))))
    };
    let triangles = mesh.triangles.get(range.triangles()).unwrap_or_default();
    triangles.iter().filter_map(|[a, b, c]| Some([corner(*a)?, corner(*b)?, corner(*c)?])).collect()
}

impl Obstacles {
    pub fn new(scene: &Scene, geometry: &Geometry, faces: &[Vec<FaceOptics>]) -> Obstacles {
        let (mut all, mut placed_meshes) = (Vec::new(), Vec::new());
        for (part, (placed, optics)) in scene.parts.iter().zip(faces).enumerate() {
            let mesh = scene.meshes.get(placed.mesh.index());
            let mesh = mesh.zip(u32::try_from(part).ok().map(|number| geometry.part_to_world(number)));
            placed_meshes.push(mesh.map(|(mesh, to_world)| (mesh.clone(), to_world)));
            let Some((mesh, to_world)) = mesh else { continue };
            for (face, optics) in (0..mesh.faces.len()).zip(optics) {
                let is_there = match &optics.surface {
                    Surface::Absent | Surface::Slide(_) | Surface::Sheet(_) => false,
                    Surface::Absorber
                    | Surface::Mirror(_)
                    | Surface::Splitter(_)
                    | Surface::Grating(_)
                    | Surface::Interface(_)
                    | Surface::Scatter(_) => true,
                };
                if !is_there {
                    continue;
                }
                let (lo, hi) = bounds(&placed_triangles(mesh, &to_world, face));
                all.push(Obstacle { part, face, lo, hi });
            }
        }
        let triangles = Box::new(move |part: usize, face| match placed_meshes.get(part) {
            Some(Some((mesh, to_world))) => placed_triangles(mesh, to_world, face),
            Some(None) | None => Vec::new(),
        });
        Obstacles { all, triangles, grain: grain(geometry) }
    }

    /// The seams of a face with this rim; lines along the rim are none.
    pub fn on(&self, (part, face): (usize, usize), rim: &Rim) -> Vec<Edge> {
        let mut seams = Vec::new();
        let is_own = |obstacle: &&Obstacle| (obstacle.part, obstacle.face) == (part, face);
        let Some(own) = self.all.iter().find(is_own) else { return seams };
        let mut of_own: Option<Vec<Corners>> = None;
        for other in self.all.iter().filter(|other| !is_own(other)) {
            let least = (own.hi - own.lo).length().min((other.hi - other.lo).length());
            let reach = TOUCHING * least + self.grain;
            let apart = (other.lo - own.hi).max(own.lo - other.hi).max_element();
            // Not so for what is no number.
            if apart <= reach {
                let of_own = of_own.get_or_insert_with(|| (self.triangles)(own.part, own.face));
                let of_other = (self.triangles)(other.part, other.face);
                pairs((own, of_own), (other, &of_other), reach, |one, two| {
                    let along_rim = |Edge([a, b]): &Edge| {
                        let mut along = false;
                        rim.near(0.5 * (*a + *b), reach, |Edge(ends)| along |= lies_on(&ends, [*a, *b], reach));
                        along
                    };
                    seams.extend(crossing(one, two, reach).filter(|seam| !along_rim(seam)));
                });
            }
        }
        seams
    }
}

/// A triangle's number in its list, and its box.
type Boxed = (usize, DVec3, DVec3);

/// Calls `visit` with the pairs of triangles whose boxes come within `reach` of each other, in a fixed order.
fn pairs(
    (own, of_own): (&Obstacle, &[Corners]),
    (other, of_other): (&Obstacle, &[Corners]),
    reach: f64,
    mut visit: impl FnMut(&Corners, &Corners),
) {
    let boxed = |triangles: &[Corners]| -> Vec<Boxed> {
        let boxes = triangles.iter().enumerate().map(|(index, triangle)| {
            let (low, high) = bounds(std::slice::from_ref(triangle));
            (index, low, high)
        });
        boxes.collect()
    };
    let near = |all: Vec<Boxed>, of: &Obstacle| within(all, (of.lo, of.hi), reach);
    let (first, second) = (near(boxed(of_own), other), near(boxed(of_other), own));
    halve(first, second, reach, &mut |one, two| visit(&of_own[one], &of_other[two]));
}

/// The boxes that come within `reach` of a box.
fn within(mut all: Vec<Boxed>, (lo, hi): (DVec3, DVec3), reach: f64) -> Vec<Boxed> {
    all.retain(|(_, low, high)| (lo - *high).max(*low - hi).max_element() <= reach);
    all
}

/// The pairs of two lists, by halves of the longer one, each with what of the other comes near it: the work is that of sorting
/// and of the pairs that there are, wherever the lists lie.
fn halve(first: Vec<Boxed>, second: Vec<Boxed>, reach: f64, visit: &mut impl FnMut(usize, usize)) {
    /// As many pairs are looked at one by one.
    const FEW: usize = 64;
    if first.is_empty() || second.is_empty() {
        return;
    }
    if first.len() * second.len() <= FEW {
        for (one, low, high) in &first {
            for (two, its_low, its_high) in &second {
                if (*its_low - *high).max(*low - *its_high).max_element() <= reach {
                    visit(*one, *two);
                }
            }
        }
        return;
    }
    let is_first = first.len() >= second.len();
    let (mut longer, other) = if is_first { (first, second) } else { (second, first) };
    let about = |all: &[Boxed]| {
        let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        all.iter().fold(start, |(lo, hi), (_, low, high)| (lo.min(*low), hi.max(*high)))
    };
    let (lo, hi) = about(&longer);
    let axis = (hi - lo).max_position();
    longer.sort_by(|(_, a, b), (_, c, d)| (a[axis] + b[axis]).total_cmp(&(c[axis] + d[axis])));
    let upper = longer.split_off(longer.len() / 2);
    for half in [longer, upper] {
        let near = within(other.clone(), about(&half), reach);
        let (first, second) = if is_first { (half, near) } else { (near, half) };
        halve(first, second, reach, visit);
    }
}

/// Whether both points of a line lie on an edge.
fn lies_on([a, b]: &[DVec3; 2], line: [DVec3; 2], reach: f64) -> bool {
    let along = *b - *a;
    line.iter().all(|point| {
        let t = ((*point - *a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        point.distance(*a + t * along) <= 2.0 * reach
    })
}

/// The line on the first triangle where the second one crosses it, or where an edge of that lies on it.
fn crossing(own: &Corners, its: &Corners, reach: f64) -> Option<Edge> {
    let [a, b, c] = *own;
    let normal = (b - a).cross(c - a).try_normalize()?;
    let heights =
        its.map(|corner| (corner - a).dot(normal)).map(|height| if height.abs() <= reach { 0.0 } else { height });
    let mut ends: ArrayVec<DVec3, 3> = ArrayVec::new();
    for (i, j) in [(0, 1), (1, 2), (2, 0)] {
        if heights[i] == 0.0 {
            ends.push(its[i]);
        } else if heights[i] * heights[j] < 0.0 {
            ends.push(its[i].lerp(its[j], heights[i] / (heights[i] - heights[j])));
        }
    }
    // With three, it lies in the plane: a cover, whose neighbours stand on its edges.
    let [from, to] = ends.as_slice() else { return None };
    clip(own, normal, [*from, *to]).map(Edge)
}

/// What of a line in the plane of a triangle lies in that.
fn clip(triangle: &Corners, normal: DVec3, [from, to]: [DVec3; 2]) -> Option<[DVec3; 2]> {
    let (mut first, mut last) = (0.0f64, 1.0f64);
    for (i, j) in [(0, 1), (1, 2), (2, 0)] {
        let inward = normal.cross(triangle[j] - triangle[i]);
        let [at_from, at_to] = [from, to].map(|end| (end - triangle[i]).dot(inward));
        if at_from < 0.0 && at_to < 0.0 {
            return None;
        }
        let cut = at_from / (at_from - at_to);
        if at_from < 0.0 {
            first = first.max(cut);
        } else if at_to < 0.0 {
            last = last.min(cut);
        }
    }
    (first < last).then(|| [from.lerp(to, first), from.lerp(to, last)])
}

/// Distance of a wall from the origin.
pub fn distance([a, b]: &[DVec2; 2]) -> f64 {
    let along = *b - *a;
    let t = (-a.dot(along) / along.length_squared()).clamp(0.0, 1.0);
    if t.is_nan() { a.length() } else { (*a + t * along).length() }
}

/// Whether a wall hides a place from the origin.
pub fn hides([a, b]: &[DVec2; 2], at: DVec2) -> bool {
    let along = *b - *a;
    let beyond = along.perp_dot(at - *a) * along.perp_dot(-*a) < 0.0;
    beyond && at.perp_dot(*a) * at.perp_dot(*b) < 0.0
}

/// The share of what surrounds the origin that no wall hides. `lost`: the share beyond a wall, in the fan over it.
pub fn seen(walls: &[[DVec2; 2]], lost: impl Fn([DVec2; 2]) -> f64) -> f64 {
    /// With more walls than this, those that cross each other are parted where one of them ends.
    const FEW: usize = 32;
    let mut corners: Vec<DVec2> = walls.iter().flatten().copied().collect();
    if walls.len() <= FEW {
        let crossings =
            walls.iter().enumerate().flat_map(|(i, one)| walls[..i].iter().filter_map(|two| meet(one, two)));
        corners.extend(crossings);
    }
    let mut angles: Vec<f64> = corners.iter().map(|corner| corner.y.atan2(corner.x)).collect();
    angles.sort_by(f64::total_cmp);
    let Some(first) = angles.first().copied() else { return 1.0 };
    let nexts = angles.iter().skip(1).copied().chain([first + TAU]);
    angles.iter().zip(nexts).fold(1.0, |share, (from, to)| {
        let towards = DVec2::from_angle(0.5 * (from + to));
        let nearest =
            walls.iter().filter_map(|wall| Some((along(wall, towards)?, wall))).min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, [a, b])) = nearest else { return share };
        // The part of the wall that is seen between the two directions.
        let end = |angle: f64| {
            let towards = DVec2::from_angle(angle);
            let t = towards.perp_dot(*a) / towards.perp_dot(*a - *b);
            a.lerp(*b, if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) })
        };
        share - lost([end(*from), end(to)])
    })
}

/// How far from the origin a wall is met in a direction.
fn along([a, b]: &[DVec2; 2], towards: DVec2) -> Option<f64> {
    let (left, right) = (towards.perp_dot(*a), towards.perp_dot(*b));
    let distance = a.perp_dot(*b - *a) / towards.perp_dot(*b - *a);
    (left * right < 0.0 && distance > 0.0).then_some(distance)
}

/// Where two walls cross.
fn meet(one: &[DVec2; 2], two: &[DVec2; 2]) -> Option<DVec2> {
    let (u, v) = (one[1] - one[0], two[1] - two[0]);
    let across = u.perp_dot(v);
    let (s, t) = ((two[0] - one[0]).perp_dot(v) / across, (two[0] - one[0]).perp_dot(u) / across);
    let inside = |x: f64| x > 0.0 && x < 1.0;
    (inside(s) && inside(t)).then(|| one[0] + s * u)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The two triangles of a parallelogram.
    fn quad(centre: DVec3, a: DVec3, b: DVec3) -> Vec<Corners> {
        let [p, q, r, s] = [centre - a - b, centre + a - b, centre + a + b, centre - a + b];
        vec![[p, q, r], [p, r, s]]
    }

    /// The first is face 0 of a part.
    fn obstacles(faces: Vec<Vec<Corners>>) -> Obstacles {
        let of = |(face, triangles): (usize, &Vec<Corners>)| {
            let (lo, hi) = bounds(triangles);
            Obstacle { part: 0, face, lo, hi }
        };
        let all = faces.iter().enumerate().map(of).collect();
        Obstacles { all, triangles: Box::new(move |_, face| faces[face].clone()), grain: 1e-14 }
    }

    /// A floor of 2 × 2 with these about it: the length of its seams.
    fn length(faces: Vec<Vec<Corners>>) -> f64 {
        let floor = quad(DVec3::ZERO, DVec3::X, DVec3::Y);
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
        let rim = Rim::new((0..4).map(|i| Edge([corners[i], corners[(i + 1) % 4]])).collect());
        let all = std::iter::once(floor).chain(faces).collect();
        let seams = obstacles(all).on((0, 0), &rim);
        seams.iter().map(|Edge([a, b])| a.distance(*b)).sum()
    }

    /// A wall across the floor leaves one line; one through its corner what lies on the floor of it.
    #[test]
    fn a_wall_across_the_floor() {
        let wall = |y: f64| quad(DVec3::Y * y, DVec3::X * 3.0, DVec3::Z);
        assert!((length(vec![wall(0.3)]) - 2.0).abs() < 1e-12);
        assert_eq!(length(vec![wall(1.2)]), 0.0);
        let aslant = quad(DVec3::new(0.5, 0.5, 0.0), DVec3::new(1.0, -1.0, 0.0), DVec3::Z);
        assert!((length(vec![aslant]) - 2f64.sqrt()).abs() < 1e-12);
    }

    /// A box that stands on the floor, a rounding above or below it, leaves its outline; one in the air nothing, and so do
    /// walls about the floor.
    #[test]
    fn what_stands_on_the_floor() {
        let cube = |z: f64| {
            let side =
                |out: DVec3, a: DVec3, b: DVec3| quad(DVec3::new(0.1, 0.2, z + 0.2) + 0.2 * out, 0.2 * a, 0.2 * b);
            let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
            vec![side(x, y, z), side(-x, z, y), side(y, z, x), side(-y, x, z), side(z, x, y), side(-z, y, x)]
        };
        for z in [0.0, 1e-8, -1e-8] {
            assert!((length(cube(z)) - 1.6).abs() < 1e-6, "{z}");
        }
        assert_eq!(length(cube(0.01)), 0.0);
        let about = [DVec3::X, DVec3::Y, -DVec3::X, -DVec3::Y];
        let room = about.map(|out| quad(out + DVec3::Z * 0.9, out.cross(DVec3::Z), DVec3::Z * 0.9));
        assert_eq!(length(room.to_vec()), 0.0);
    }

    /// A sphere about a place, as triangles.
    fn sphere(centre: DVec3, rings: usize) -> Vec<Corners> {
        let at = |i: usize, j: usize| {
            let (up, round) = (std::f64::consts::PI * i as f64 / rings as f64, TAU * j as f64 / rings as f64);
            centre + DVec3::new(up.sin() * round.cos(), up.sin() * round.sin(), up.cos())
        };
        let both = |k: usize| {
            let (i, j) = (k / rings, k % rings);
            let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            [[a, b, c], [a, c, d]]
        };
        (0..rings * rings).flat_map(both).collect()
    }

    /// Of two lists that lie in one place the pairs are those that all against all finds, each once.
    #[test]
    fn pairs_of_what_overlaps() {
        let lists = [sphere(DVec3::ZERO, 14), sphere(DVec3::new(0.03, 0.01, -0.02), 17), sphere(DVec3::X * 1.9, 9)];
        let boxes = |list: &[Corners]| list.iter().map(|own| bounds(&[*own])).collect::<Vec<_>>();
        for (one, two) in [(0, 1), (1, 0), (0, 2), (2, 2)] {
            let (own, its) = (boxes(&lists[one]), boxes(&lists[two]));
            let reach = 1e-9;
            let mut want = Vec::new();
            for (i, (low, high)) in own.iter().enumerate() {
                let near = |(lo, hi): &(DVec3, DVec3)| (*lo - *high).max(*low - *hi).max_element() <= reach;
                want.extend(its.iter().enumerate().filter(|(_, its)| near(its)).map(|(j, _)| (i, j)));
            }
            let obstacle = |list: &[Corners]| {
                let (lo, hi) = bounds(list);
                Obstacle { part: 0, face: 0, lo, hi }
            };
            let mut found = Vec::new();
            let number = |list: &[Corners], own: &Corners| list.iter().position(|other| other == own).unwrap();
            let (a, b) = (obstacle(&lists[one]), obstacle(&lists[two]));
            pairs((&a, &lists[one]), (&b, &lists[two]), reach, |x, y| {
                found.push((number(&lists[one], x), number(&lists[two], y)));
            });
            found.sort_unstable();
            assert_eq!(found, want, "{one} {two}");
        }
    }

    /// What is seen and what is hidden agree, over a fine raster, with walls that cross, meet, shade each other and end.
    #[test]
    fn what_is_seen_agrees_with_a_raster() {
        let all: [&[[[f64; 2]; 2]]; 4] = [
            &[[[0.3, -2.0], [0.3, 2.0]]],
            &[[[0.2, -0.5], [0.4, 0.6]], [[0.5, -0.9], [0.6, 0.1]], [[-0.3, 0.2], [-0.1, 0.9]]],
            &[[[-0.7, 0.3], [0.9, 0.35]], [[0.2, -0.8], [0.1, 0.8]]],
            &[
                [[0.4, -0.4], [0.4, 0.4]],
                [[0.4, 0.4], [-0.4, 0.4]],
                [[-0.4, 0.4], [-0.4, -0.4]],
                [[-0.4, -0.4], [0.4, -0.4]],
            ],
        ];
        for walls in all {
            let walls: Vec<[DVec2; 2]> = walls.iter().map(|wall| wall.map(DVec2::from)).collect();
            let n = 1200;
            let (mut sum, mut whole) = (0.0, 0.0);
            for i in 0..n * n {
                let at = DVec2::new((i % n) as f64 + 0.5, (i / n) as f64 + 0.5) * (2.0 / n as f64) - 1.0;
                let kernel = (1.0 - at.length_squared()).max(0.0);
                whole += kernel;
                sum += if walls.iter().any(|wall| hides(wall, at)) { 0.0 } else { kernel };
            }
            let got = seen(&walls, |wall| super::super::rim::beyond(wall, 1.0).abs());
            // A row of the raster on the wrong side of a line of length 2 is 0.75 of a cell's width.
            assert!((got - sum / whole).abs() < 1.5 / n as f64, "{walls:?}: {got} {}", sum / whole);
        }
    }
}
