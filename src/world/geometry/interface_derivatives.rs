//! One known face, met as if it went on beyond its rim, and how it bends there: for those who look for a path along a
//! given sequence of faces and need its derivatives.

use super::curved::Curved;
use super::instance::Instance;
use super::local_ray::Touch;
use super::patch::{Projection, vertex};
use super::solid::Solid;
use super::surface::Surface;
use super::triangle::{Triangle, winding};
use super::{Geometry, Ray, Site};
use glam::{DMat3, DVec3};

/// Faces of the same solid that may stand before the one that is asked for.
const MOST_BEFORE: usize = 16;

/// A point of a face, with first derivatives of what is there.
#[derive(Debug, Clone, Copy)]
pub struct Meet {
    /// m along the ray.
    pub t: f64,
    /// Recentred world, m.
    pub point: DVec3,
    /// Unit normal of the surface, outward of the solid.
    pub normal: DVec3,
    /// Unit normal for optics, in the hemisphere of `normal`.
    pub shading: DVec3,
    bend: Bend,
    /// Mesh normals → world directions over the length of what they become, and world displacements → mesh units.
    turns: (DMat3, DMat3),
    /// In mesh units.
    pub local: DVec3,
    /// A triangle of the face.
    pub triangle: u32,
}

/// How a unit normal changes along the surface, mesh units.
#[derive(Debug, Clone, Copy)]
enum Bend {
    Flat,
    /// −`strength` (1 − n nᵀ)(1 + k a aᵀ): strength, k and the axis a.
    Quadric(f64, f64, DVec3),
    Matrix(DMat3),
}

impl Meet {
    /// Change of `shading` with a displacement along the surface, m; zero on what is flat.
    #[inline]
    pub fn turn(&self, moved: DVec3) -> DVec3 {
        let bent = match self.bend {
            Bend::Flat => return DVec3::ZERO,
            // The part along the normal is taken away in the world.
            Bend::Quadric(strength, k, axis) => {
                let moved = self.turns.1 * moved;
                -strength * (moved + k * moved.dot(axis) * axis)
            }
            Bend::Matrix(matrix) => matrix * (self.turns.1 * moved),
        };
        let turned = self.turns.0 * bent;
        turned - self.shading * self.shading.dot(turned)
    }
}

impl Geometry {
    /// Where the ray meets a face of a part, whatever stands before it and (on exact quadrics) however far beyond the rim:
    /// the place ahead that is nearest to `about` (mesh units). None if the ray misses, or the part has no such face.
    pub fn meet(&self, part: u32, face: u32, ray: &Ray, about: DVec3) -> Option<Meet> {
        let slot = *self.slots.get(part as usize)?;
        let instance = self.instances.get(slot as usize)?;
        let solid = self.solids.get(instance.solid)?;
        match self.before_pile(part, face, ray) {
            None => instance.meet(solid, face, ray, about),
            Some((before, back)) => {
                let meet = instance.meet(solid, face, &before, about)?;
                Some(Meet { t: (meet.t - back).max(0.0), ..meet })
            }
        }
    }

    /// A ray that starts on a film, or on the face that one lies in, and looks for the other of the two is there already: the same from
    /// a little before, and how much, m.
    fn before_pile(&self, part: u32, face: u32, ray: &Ray) -> Option<(Ray, f64)> {
        /// Of the size of what the ray starts on.
        const BACK: f64 = 1e-4;
        let from = ray.from.filter(|_| !self.has_no_films())?;
        let to = self.below_film(Site { part, face, triangle: 0 });
        if from.part == part || !self.below_film(from).is_on_face_of(to) {
            return None;
        }
        let instance = self.instances.get(*self.slots.get(part as usize)? as usize)?;
        let back = BACK * instance.bounds.half().length();
        Some((Ray { origin: ray.origin - back * ray.dir, dir: ray.dir, from: None }, back))
    }

    /// The same, of a flat face on its plane where the ray passes beside it.
    pub fn meet_past_rim(&self, part: u32, face: u32, ray: &Ray, about: DVec3) -> Option<Meet> {
        self.meet(part, face, ray, about).or_else(|| {
            let instance = self.instances.get(*self.slots.get(part as usize)? as usize)?;
            instance.meet_plane(self.solids.get(instance.solid)?, face, ray)
        })
    }
}

impl Instance {
    fn meet(&self, solid: &Solid, face: u32, ray: &Ray, about: DVec3) -> Option<Meet> {
        let sheet = solid.faces.get(face as usize)?;
        match &sheet.surface {
            Surface::Absent => None,
            Surface::Exact { quadric, projection, outward } => {
                let (origin, dir, scale) = self.to_mesh(ray);
                let leaves = ray.from.is_some_and(|from| {
                    from.part == self.part
                        && solid.faces.get(from.face as usize).is_some_and(|other| other.identity == sheet.identity)
                });
                if leaves && sheet.surface.is_plane() {
                    return None;
                }
                let valid = |t: &f64| match projection {
                    Projection::Axial(_) => quadric.branch(origin + *t * dir) > 0.0,
                    Projection::Central(_) => true,
                };
                let ahead = quadric.intersect(origin, dir, leaves).into_iter();
                let ahead = ahead.filter(|t| *t > 0.0 && *t < f64::INFINITY).filter(valid);
                let distance = |t: &f64| (origin + *t * dir).distance_squared(about);
                let t = match projection {
                    Projection::Axial(_) => ahead.min_by(|a, b| distance(a).total_cmp(&distance(b)))?,
                    // A ball has a near and a far side, which are two different faces of a chain.
                    Projection::Central(_) => ahead.min_by(f64::total_cmp)?,
                };
                let local = quadric.settle(origin + t * dir);
                // g = a − c (w + k (w·a) a), dg = −c (1 + k a aᵀ) dp.
                let w = local - quadric.vertex;
                let (a, c, k) = (quadric.axis, quadric.curvature, quadric.conic);
                let g = a - c * (w + k * w.dot(a) * a);
                let length = g.length();
                let normal = g * (*outward / length);
                let bend = if c == 0.0 { Bend::Flat } else { Bend::Quadric(*outward * c / length, k, a) };
                self.met(t / scale, local, normal, normal, bend, ray, u32::MAX)
            }
            Surface::Flat | Surface::Faceted | Surface::Curved { .. } => {
                let (touch, t) = self.nearest_of(solid, face, ray)?;
                let triangle = solid.triangles.get(touch.slot as usize)?;
                let (normal, shading) = solid.normals_at(&touch)?;
                let local = solid.settle(&touch);
                let bend = match &sheet.surface {
                    Surface::Curved { curved, outward } => Bend::Matrix(*outward * bend_of(curved, local)?),
                    Surface::Faceted => Bend::Matrix(of_corners(solid, &touch, triangle)?),
                    Surface::Absent | Surface::Flat | Surface::Exact { .. } => Bend::Flat,
                };
                self.met(t, local, normal, shading, bend, ray, triangle.index)
            }
        }
    }

    /// Where the ray meets the plane of a flat face; none of a face that is not flat, or that the ray leaves.
    fn meet_plane(&self, solid: &Solid, face: u32, ray: &Ray) -> Option<Meet> {
        let leaves = ray.from.is_some_and(|from| (from.part, from.face) == (self.part, face));
        if leaves || !matches!(solid.faces.get(face as usize)?.surface, Surface::Flat) {
            return None;
        }
        // The largest triangle knows the plane best.
        let own = solid.triangles.iter().enumerate().filter(|(_, triangle)| triangle.face == face);
        let area = |triangle: &Triangle| winding(&triangle.corners).length_squared();
        let (slot, triangle) = own.max_by(|(_, a), (_, b)| area(a).total_cmp(&area(b)))?;
        let normal = winding(&triangle.corners);
        let (origin, dir, scale) = self.to_mesh(ray);
        let t = normal.dot(vertex(triangle.corners[0]) - origin) / normal.dot(dir);
        if !(t > 0.0 && t.is_finite()) {
            return None;
        }
        let shading = vertex(solid.normals.get(slot)?[0]);
        self.met(t / scale, origin + t * dir, normal, shading, Bend::Flat, ray, triangle.index)
    }

    /// The nearest touch of a face, and its distance in metres; other faces of the solid do not hide it: a pane's front is
    /// met from behind, too.
    fn nearest_of(&self, solid: &Solid, face: u32, ray: &Ray) -> Option<(Touch, f64)> {
        let (mut ray, mut behind) = (*ray, 0.0);
        for _ in 0..MOST_BEFORE {
            let (touch, t) = self.nearest(None, solid, &ray, None, f64::INFINITY)?;
            if touch.triangle.face == face {
                return Some((touch, behind + t));
            }
            let hit = self.hit(solid, &touch, t)?;
            behind += t;
            ray = Ray { origin: hit.point, from: Some(hit.site), ..ray };
        }
        None
    }

    /// What was found in mesh units, in the world.
    #[allow(clippy::too_many_arguments)]
    fn met(
        &self,
        t: f64,
        local: DVec3,
        normal: DVec3,
        shading: DVec3,
        bend: Bend,
        ray: &Ray,
        triangle: u32,
    ) -> Option<Meet> {
        let (to_normal, to_mesh) = self.turns();
        let unit = (to_normal * normal).try_normalize()?;
        // N = M n/|M n|: dN = (1 − N Nᵀ) M dn/|M n|.
        let long = to_normal * shading;
        let length = long.length();
        let side = if long.dot(unit) < 0.0 { -1.0 } else { 1.0 };
        let (shading, scaled) = (long * (side / length), to_normal * (side / length));
        let point = ray.origin + t * ray.dir;
        (point.is_finite() && shading.is_finite()).then_some(Meet {
            t,
            point,
            normal: unit,
            shading,
            bend,
            turns: (scaled, to_mesh),
            local,
            triangle,
        })
    }
}

/// 1 − n nᵀ.
fn across(n: DVec3) -> DMat3 {
    DMat3::IDENTITY - outer(n, n)
}

/// a bᵀ.
fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

fn bend_of(curved: &Curved, p: DVec3) -> Option<DMat3> {
    let gradient = curved.gradient(p);
    let length = gradient.vector.length();
    let n = gradient.vector / length;
    let bend = across(n) * gradient.change * length.recip();
    bend.is_finite().then_some(bend)
}

/// Of a triangle's interpolated normals: Σ wᵢ nᵢ, whose weights change as the dual basis of the edges says.
fn of_corners(solid: &Solid, touch: &Touch, triangle: &Triangle) -> Option<DMat3> {
    let [a, b, c] = triangle.corners.map(vertex);
    let [na, nb, nc] = solid.normals.get(touch.slot as usize)?.map(vertex);
    let (e1, e2) = (b - a, c - a);
    let normal = e1.cross(e2);
    let n2 = normal.length_squared();
    let (by_b, by_c) = (e2.cross(normal) / n2, normal.cross(e1) / n2);
    let sum = na * touch.weights[0] + nb * touch.weights[1] + nc * touch.weights[2];
    let length = sum.length();
    let bend = across(sum / length) * (outer(nb - na, by_b) + outer(nc - na, by_c)) * length.recip();
    bend.is_finite().then_some(bend)
}

/// The same place on a face for both directions of travel.
pub fn site_of(part: u32, face: u32, meet: &Meet) -> Site {
    Site { part, face, triangle: meet.triangle }
}
