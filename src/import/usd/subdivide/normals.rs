//! Normals of the limit surface, from its tangents at the points of the last level: Halstead, Kass and DeRose, "Efficient, Fair
//! Interpolation using Catmull-Clark Surfaces", SIGGRAPH 1993, for smooth points; Biermann, Levin and Zorin, "Piecewise Smooth
//! Subdivision Surfaces with Normal Control", SIGGRAPH 2000, along creases of quads. A point has a normal for each side of its
//! creases, and one for each face where it is pinned: such a point is the tip of a spike or the corner of a sheet.

use super::Scheme;
use crate::gltf::normals::unit;
use glam::DVec3;
use opensubdiv_rs::far::{TopologyLevel, TopologyRefiner};
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

/// The points of a level with what is around them.
pub(super) struct Rings<'a> {
    level: TopologyLevel<'a>,
    scheme: Scheme,
    control: &'a [[f64; 3]],
    limit: &'a [[f64; 3]],
}

/// Faces around a point, counter-clockwise, from crease to crease or all the way round.
#[derive(Debug, Default)]
struct Sector {
    /// Points at the other ends of the edges; one more than faces if the sector is open.
    edges: Vec<DVec3>,
    /// Points across the faces (of quads).
    across: Vec<DVec3>,
    /// The faces, and which of their corners the point is.
    faces: Vec<(usize, usize)>,
    is_closed: bool,
}

/// How a point is subdivided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Rule {
    /// Where one crease ends, too.
    Smooth,
    Crease,
    Corner,
}

impl<'a> Rings<'a> {
    /// `control` are the points of the refiner's last level, `limit` where they go.
    pub fn new(refiner: &'a TopologyRefiner, scheme: Scheme, control: &'a [[f64; 3]], limit: &'a [[f64; 3]]) -> Self {
        Rings { level: refiner.level(refiner.max_level()), scheme, control, limit }
    }

    /// Unit normals, and which of them each corner of the faces that are `drawn` has.
    pub fn normals(&self, drawn: &[(usize, u32)], left_handed: bool) -> (Vec<[f32; 3]>, Vec<i32>) {
        let size = match self.scheme {
            Scheme::CatmullClark => 4,
            Scheme::Loop => 3,
        };
        let mut of_corner = vec![0i32; size * self.level.num_faces()];
        let mut normals = Vec::new();
        for point in 0..self.level.num_vertices() {
            let rule = self.rule(point);
            for sector in self.sectors(point, rule) {
                let found = self.normal(point, rule, &sector).or_else(|| unit(self.area(&sector)));
                let found = found.unwrap_or([0.0, 0.0, 1.0]);
                for (face, corner) in sector.faces {
                    if let Some(slot) = of_corner.get_mut(size * face + corner) {
                        *slot = normals.len() as i32;
                    }
                }
                normals.push(if left_handed { found.map(|x| -x) } else { found });
            }
        }
        let corners = drawn.iter().flat_map(|(face, _)| (0..size).map(move |corner| size * face + corner));
        let indices = corners.map(|corner| of_corner.get(corner).copied().unwrap_or(0)).collect();
        (normals, indices)
    }

    fn is_sharp(&self, edge: u32) -> bool {
        self.level.edge_sharpness(edge as usize) > 0.0
    }

    fn rule(&self, point: usize) -> Rule {
        let sharp = self.level.vertex_edges(point).iter().filter(|edge| self.is_sharp(**edge)).count();
        match sharp {
            _ if self.level.vertex_sharpness(point) > 0.0 => Rule::Corner,
            0 | 1 => Rule::Smooth,
            2 => Rule::Crease,
            _ => Rule::Corner,
        }
    }

    /// The faces around a point, cut where its rule sees a crease.
    fn sectors(&self, point: usize, rule: Rule) -> Vec<Sector> {
        let faces = self.level.vertex_faces(point);
        // By the edge that leads away from the point: the next face, counter-clockwise, is the one whose edge away is this
        // face's edge back.
        let mut by_away: HashMap<u32, usize> = HashMap::with_capacity(faces.len());
        let mut known = Vec::with_capacity(faces.len());
        for face in faces.iter().map(|face| *face as usize) {
            let points = self.level.face_vertices(face);
            let Some(corner) = points.iter().position(|other| *other as usize == point) else { continue };
            let edges = self.level.face_edges(face);
            let (Some(away), Some(back)) = (edges.get(corner), edges.get((corner + points.len() - 1) % points.len()))
            else {
                continue;
            };
            by_away.insert(*away, known.len());
            known.push((face, corner, *away, *back));
        }
        let cuts = |edge: u32| match rule {
            Rule::Smooth => self.level.edge_faces(edge as usize).len() != 2,
            Rule::Crease => self.level.edge_faces(edge as usize).len() != 2 || self.is_sharp(edge),
            Rule::Corner => true,
        };
        let follows = |back: u32| by_away.get(&back).copied().filter(|_| !cuts(back));
        let mut is_followed = vec![false; known.len()];
        for (_, _, _, back) in &known {
            if let Some(next) = follows(*back).and_then(|next| is_followed.get_mut(next)) {
                *next = true;
            }
        }
        let mut is_taken = vec![false; known.len()];
        let mut out = Vec::new();
        // First the sectors that begin somewhere, then the rings.
        let starts = (0..known.len()).filter(|start| !is_followed[*start]).collect::<Vec<_>>();
        for start in starts.into_iter().chain(0..known.len()) {
            let mut sector = Sector::default();
            let mut next = Some(start);
            while let Some(place) = next.filter(|place| !is_taken[*place]) {
                is_taken[place] = true;
                let (face, corner, away, back) = known[place];
                sector.edges.push(self.other(away, point));
                sector.across.push(self.across(face, corner));
                sector.faces.push((face, corner));
                next = follows(back);
                if next.is_none() {
                    sector.edges.push(self.other(back, point));
                }
            }
            sector.is_closed = sector.edges.len() == sector.faces.len();
            if !sector.faces.is_empty() {
                out.push(sector);
            }
        }
        out
    }

    fn point(&self, point: usize) -> DVec3 {
        self.control.get(point).map_or(DVec3::ZERO, |p| DVec3::from(*p))
    }
    fn other(&self, edge: u32, point: usize) -> DVec3 {
        let [a, b] = self.level.edge_vertices(edge as usize);
        self.point(if a as usize == point { b } else { a } as usize)
    }
    fn across(&self, face: usize, corner: usize) -> DVec3 {
        let points = self.level.face_vertices(face);
        points.get((corner + 2) % points.len().max(1)).map_or(DVec3::ZERO, |point| self.point(*point as usize))
    }

    /// The direction of the tangents' cross product; none where they have none.
    fn normal(&self, point: usize, rule: Rule, sector: &Sector) -> Option<[f32; 3]> {
        let own = self.point(point);
        let normal = match rule {
            Rule::Smooth if sector.is_closed => {
                let [along, aside] = match self.scheme {
                    Scheme::CatmullClark => smooth_quads(sector),
                    Scheme::Loop => smooth_triangles(sector),
                };
                along.cross(aside)
            }
            Rule::Crease if !sector.is_closed => {
                let (Some(first), Some(last)) = (sector.edges.first(), sector.edges.last()) else { return None };
                let inward = match (sector.faces.len(), self.scheme) {
                    (1, _) => *first + *last - 2.0 * own,
                    (_, Scheme::CatmullClark) => crease_quads(own, sector),
                    (_, Scheme::Loop) => crease_triangles(own, sector),
                };
                (*first - *last).cross(inward)
            }
            // What is no manifold, too: each face as the corner sees it.
            Rule::Smooth | Rule::Crease | Rule::Corner => {
                let next = sector.edges.iter().cycle().skip(1);
                let sides = sector.edges.iter().zip(next).take(sector.faces.len());
                sides.filter_map(|(a, b)| (*a - own).cross(*b - own).try_normalize()).sum()
            }
        };
        unit(normal)
    }

    /// The area around a point on the limit surface, where its tangents say nothing.
    fn area(&self, sector: &Sector) -> DVec3 {
        let mut sum = DVec3::ZERO;
        for (face, _) in &sector.faces {
            let at = |point: u32| self.limit.get(point as usize).map_or(DVec3::ZERO, |p| DVec3::from(*p));
            let points: Vec<DVec3> = self.level.face_vertices(*face).iter().map(|point| at(*point)).collect();
            if let [a, b, c, rest @ ..] = points.as_slice() {
                // Half the cross product of a quad's diagonals, and of a triangle's sides, is its area.
                sum += rest.first().map_or((*b - *a).cross(*c - *a), |d| (*c - *a).cross(*d - *b));
            }
        }
        sum
    }
}

/// The weighted sums with cosines and sines around a point (Halstead et al., appendix A).
fn smooth_quads(sector: &Sector) -> [DVec3; 2] {
    let count = sector.faces.len() as f64;
    let angle = TAU / count;
    let weight = 1.0 + angle.cos() + (PI / count).cos() * (2.0 * (9.0 + angle.cos())).sqrt();
    let mut out = [DVec3::ZERO; 2];
    for (i, (edge, across)) in sector.edges.iter().zip(&sector.across).enumerate() {
        let (here, next) = ((i as f64 * angle).sin_cos(), ((i + 1) as f64 * angle).sin_cos());
        out[0] += *edge * (weight * here.1) + *across * (here.1 + next.1);
        out[1] += *edge * (weight * here.0) + *across * (here.0 + next.0);
    }
    out
}

fn smooth_triangles(sector: &Sector) -> [DVec3; 2] {
    let angle = TAU / sector.faces.len() as f64;
    let mut out = [DVec3::ZERO; 2];
    for (i, edge) in sector.edges.iter().enumerate() {
        let (sine, cosine) = (i as f64 * angle).sin_cos();
        out[0] += *edge * cosine;
        out[1] += *edge * sine;
    }
    out
}

/// The tangent into a sector of two quads or more (Biermann et al., section 3).
fn crease_quads(own: DVec3, sector: &Sector) -> DVec3 {
    let angle = PI / sector.faces.len() as f64;
    let (sine, cosine) = angle.sin_cos();
    let ratio = (cosine + 1.0) / sine;
    let mut out = own * (4.0 * ratio * (cosine - 1.0));
    let last = sector.edges.len().saturating_sub(1);
    for (i, edge) in sector.edges.iter().enumerate() {
        let weight = if i == 0 || i == last { -ratio * (1.0 + 2.0 * cosine) } else { 4.0 * (i as f64 * angle).sin() };
        out += *edge * weight;
    }
    for (i, across) in sector.across.iter().enumerate() {
        out += *across * ((i as f64 * angle).sin() + ((i + 1) as f64 * angle).sin());
    }
    out
}

/// The tangent into a sector of two triangles or more: the left eigenvector of the crease's own subdivision (ends of the
/// crease halfway, its middle 1/8, 3/4, 1/8, edges between 3/8, 3/8 and 1/8 twice) with sin(i π/k) on the edges between.
fn crease_triangles(own: DVec3, sector: &Sector) -> DVec3 {
    let angle = PI / sector.faces.len() as f64;
    let cosine = angle.cos();
    // All weights add up to nothing: those between to cot(angle / 2), the ends to 2 cos(angle) of the middle's.
    let middle = (1.0 / (angle / 2.0).tan()) / (1.0 + 2.0 * cosine);
    let last = sector.edges.len().saturating_sub(1);
    let mut out = own * -middle;
    for (i, edge) in sector.edges.iter().enumerate() {
        out += *edge * if i == 0 || i == last { -middle * cosine } else { (i as f64 * angle).sin() };
    }
    out
}
