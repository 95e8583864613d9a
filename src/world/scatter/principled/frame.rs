//! Normals for optics, and the directions of the surface that maps and brushed facets are told in.

use super::Principled;
use super::point::{Weights, between, coordinates, corners, positions};
use crate::geometry::Hit;
use crate::texture::{Coordinates, of_set, read};
use eyebox_scene::{Anisotropy, TextureInput};
use glam::{DAffine3, DVec3};

impl Principled {
    /// What facets are longer along, world.
    pub(super) fn along(
        &self,
        anisotropy: &Anisotropy,
        (hit, (corners, weights)): (&Hit, ([usize; 3], Weights)),
        to_world: &DAffine3,
        uv: &Coordinates,
    ) -> Option<DVec3> {
        let set = anisotropy.direction.as_ref().map_or(0, |input| input.set);
        let own = self.own_tangents((corners, weights), hit, to_world);
        let [tangent, upright] = own.or_else(|| self.tangents(set, None, corners, hit, to_world))?;
        let [x, y] = match &anisotropy.direction {
            None => [1.0, 0.0],
            Some(input) => {
                let [x, y, ..] = read(input, of_set(input, uv));
                [x, y]
            }
        };
        let (sin, cos) = anisotropy.rotation_rad.sin_cos();
        (tangent * (cos * x - sin * y) + upright * (sin * x + cos * y)).try_normalize()
    }

    /// The normal for optics of a ray along `dir`, in the hemisphere of the face's own.
    pub fn shading(&self, hit: &Hit, dir: DVec3, to_world: &DAffine3) -> DVec3 {
        // The cosine of 87°: less of it is seen of no normal.
        const LEAST: f64 = 0.05;
        // Cosine of the lowest direction that is mirrored, and its most of that of the ray.
        const GRAZING: f64 = 0.01;
        const GRAZES: f64 = 0.9;
        let shading = self.bent_normal(hit, to_world).unwrap_or(hit.shading);
        let towards = if dir.dot(hit.normal) < 0.0 { -dir } else { dir };
        let (cos, least) = (shading.dot(towards), LEAST.min(hit.normal.dot(towards)));
        let shading = if cos >= least { shading } else { (shading + towards * (least - cos)).normalize() };
        // What it mirrors must not lie below the face: pulled up to that, the mirrored direction says the normal (Keller et al.,
        // "The Iray Light Transport Simulation and Rendering System", 2017, section on normals).
        let mirrored = shading * (2.0 * shading.dot(towards)) - towards;
        let (up, lowest) = (mirrored.dot(hit.normal), GRAZING.min(GRAZES * hit.normal.dot(towards)));
        if up >= lowest {
            return shading;
        }
        (towards + (mirrored + hit.normal * (lowest - up)).normalize()).normalize()
    }

    /// The normal that a normal map makes of the shading normal, world; none where there is no map. Its x runs with the
    /// picture's columns, its y against its rows.
    pub fn bent_normal(&self, hit: &Hit, to_world: &DAffine3) -> Option<DVec3> {
        let (input, strength) = self.surface.normal.as_ref()?;
        self.mapped(input, *strength, hit, to_world)
    }

    pub(super) fn mapped(&self, input: &TextureInput, strength: f64, hit: &Hit, to_world: &DAffine3) -> Option<DVec3> {
        let (corners, weights) = corners(&self.mesh, hit)?;
        let uv = of_set(input, &coordinates(&self.mesh, corners, weights));
        let [x, y, z, _] = read(input, uv);
        let own = self.own_tangents((corners, weights), hit, to_world);
        let of_picture = || self.tangents(input.set, Some(&input.to_picture), corners, hit, to_world);
        let [tangent, upright] = own.or_else(of_picture)?;
        (tangent * (x * strength) + upright * (y * strength) + hit.shading * z).try_normalize()
    }

    /// What the mesh itself says of these two directions (glTF 2.0, section 3.7.2.1, `TANGENT`); none where it says nothing.
    fn own_tangents(
        &self,
        (corners, weights): ([usize; 3], Weights),
        hit: &Hit,
        to_world: &DAffine3,
    ) -> Option<[DVec3; 2]> {
        let said = corners.map(|corner| self.mesh.tangents.get(corner).copied());
        // Sides that differ over a triangle make no frame.
        let [Some([.., a]), Some([.., b]), Some([.., c])] = said else { return None };
        if a == 0.0 || a != b || a != c {
            return None;
        }
        let [x, y, z, _] = between(&self.mesh.tangents, corners, weights)?;
        let along = to_world.transform_vector3(DVec3::new(x, y, z));
        let tangent = (along - hit.shading * along.dot(hit.shading)).try_normalize()?;
        let side = if to_world.matrix3.determinant() < 0.0 { -f64::from(a) } else { f64::from(a) };
        Some([tangent, hit.shading.cross(tangent) * side])
    }

    /// Along the columns of a picture on this set of coordinates, and against its rows, both at right angles to the shading
    /// normal, world; none where the coordinates say nothing.
    fn tangents(
        &self,
        set: u32,
        to_picture: Option<&[[f64; 3]; 2]>,
        corners: [usize; 3],
        hit: &Hit,
        to_world: &DAffine3,
    ) -> Option<[DVec3; 2]> {
        let set = if set > 0 { &self.mesh.second_uvs } else { &self.mesh.uvs };
        let uvs = corners.map(|corner| set.get(corner).map(|uv| uv.map(f64::from)));
        let [Some(a), Some(b), Some(c)] = uvs else { return None };
        let picture = |[u, v]: [f64; 2]| match to_picture {
            Some(rows) => rows.map(|[p, q, r]| p * u + q * v + r),
            None => [u, v],
        };
        let ([a, b, c], [p, q, r]) = ([a, b, c].map(picture), positions(&self.mesh, corners)?);
        // p(s, t) is linear over the triangle: its derivatives by the picture's axes.
        let (e, f) = (q - p, r - p);
        let ([s1, t1], [s2, t2]) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
        let det = s1 * t2 - s2 * t1;
        let (by_s, by_t) = ((e * t2 - f * t1) / det, (f * s1 - e * s2) / det);
        let normal = hit.shading;
        let across = |by: DVec3| {
            let by = to_world.transform_vector3(by);
            (by - normal * by.dot(normal)).try_normalize()
        };
        let tangent = across(by_s)?;
        // At a right angle, on the side where the rows run the other way.
        let upright = normal.cross(tangent);
        let upright = if upright.dot(across(by_t)?) > 0.0 { -upright } else { upright };
        Some([tangent, upright])
    }
}
