//! A part in the world: a solid and its transform.

use super::bound::Bounds;
use super::bvh::node::Lanes;
use super::local_ray::{LocalRay, Touch};
use super::prepare::Traced;
use super::solid::Solid;
use super::{Hit, Ray, Site};
use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Where};
use eyebox_scene::{Part, Shape};
use glam::{DAffine3, DMat3, DVec3};

#[derive(Debug, Clone)]
pub struct Instance {
    pub part: u32,
    /// Index into the geometry's solids.
    pub solid: usize,
    /// The part is filled.
    pub medium: bool,
    /// In the recentred world.
    pub bounds: Bounds,
    to_world: DAffine3,
    to_local: DAffine3,
    /// Mesh normals → world directions: the inverse transpose, which keeps outward outward in a mirrored part.
    normals: DMat3,
    /// Mesh units per metre and metres per mesh unit, if they are the same in all directions.
    scale: Option<[f64; 2]>,
    /// World → mesh units, if it is no more than a shift.
    shift: Option<DVec3>,
    /// What f64 rounding may move a point by, in mesh units.
    grain: f64,
}

/// Axes of an exact face's part may differ in length by this share, and lean by this angle: roundings of f32 transforms
/// in files, composed a few times.
const UNEVEN: f64 = 1e-5;

/// Refuses transforms that cannot be traced.
pub fn check(part: &Part, faces: &[Traced]) -> Result<()> {
    let m = part.to_world;
    let inverse = m.inverse();
    if !m.is_finite() || !inverse.is_finite() || m.matrix3.determinant() == 0.0 {
        let what = format!("its transform is not finite or flattens it: {:?}", m.to_cols_array());
        return Err(Error::new(Where::part(&part.path), what).code(Code::PartFlattened));
    }
    let is_exact = |face: &Traced| match face {
        None | Some(Shape::Mesh) => false,
        Some(
            Shape::Plane { .. }
            | Shape::Sphere { .. }
            | Shape::Conic { .. }
            | Shape::Asphere { .. }
            | Shape::Cylinder { .. }
            | Shape::Toroid { .. }
            | Shape::XyPoly { .. }
            | Shape::Zernike { .. }
            | Shape::Bspline { .. },
        ) => true,
    };
    let Some(face) = faces.iter().position(is_exact) else { return Ok(()) };
    let [x, y, z] = [m.matrix3.x_axis, m.matrix3.y_axis, m.matrix3.z_axis];
    let lengths = [x.length(), y.length(), z.length()];
    let largest = lengths.iter().copied().fold(0.0, f64::max);
    let smallest = lengths.iter().copied().fold(f64::INFINITY, f64::min);
    let lean = [x.dot(y), y.dot(z), z.dot(x)].iter().fold(0.0f64, |a, b| a.max(b.abs())) / (largest * largest);
    if !(largest - smallest <= UNEVEN * largest && lean <= UNEVEN) {
        let at = Where::Part { path: part.path.clone(), face: Some(face) };
        let what = format!("its exact shape would be distorted: the part's axes have lengths {lengths:?} m");
        return Err(Error::new(at, what).expected("a uniform scale, or shape mesh").code(Code::UnevenScale));
    }
    Ok(())
}

impl Instance {
    /// `extent` is the largest coordinate of the recentred world.
    pub fn new(part: u32, solid: usize, medium: bool, to_world: DAffine3, local: Bounds, extent: f64) -> Instance {
        let to_local = to_world.inverse();
        let m = to_local.matrix3;
        let per_metre = m.x_axis.length().max(m.y_axis.length()).max(m.z_axis.length());
        let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis];
        let lean = x.dot(y).abs().max(y.dot(z).abs()).max(z.dot(x).abs());
        let shortest = x.length().min(y.length()).min(z.length());
        let even = per_metre - shortest <= UNEVEN * per_metre && lean <= UNEVEN * per_metre * per_metre;
        let scale = even.then(|| [per_metre, per_metre.recip()]);
        // Three products and sums each way, twice over.
        let grain = 16.0 * f64::EPSILON * (extent * per_metre + local.reach());
        let bounds = local.map(&to_world);
        let bounds = bounds.widen(DVec3::splat(4.0 * f64::EPSILON * extent));
        let shift = (m == DMat3::IDENTITY).then_some(to_local.translation);
        Instance { part, solid, medium, bounds, to_world, to_local, normals: m.transpose(), scale, shift, grain }
    }

    /// The ray in mesh units, and mesh units per metre along it.
    #[inline(always)]
    fn line(&self, solid: &Solid, ray: &Ray, beside: Option<Site>, reach: f64) -> Option<(LocalRay, f64)> {
        let (origin, dir, scale) = match self.shift {
            Some(shift) => (ray.origin + shift, ray.dir, 1.0),
            None => self.to_mesh(ray),
        };
        let mut line = LocalRay::new(solid, origin, dir, reach * scale, self.grain)?;
        for site in [&ray.from, &beside] {
            if let Some(site) = site
                && site.part == self.part
            {
                line.leave(solid, site.face, site.triangle);
            }
        }
        Some((line, scale))
    }

    /// A ray's origin and direction (about unit) in mesh units, and mesh units per metre along it.
    #[inline]
    pub fn to_mesh(&self, ray: &Ray) -> (DVec3, DVec3, f64) {
        let origin = self.to_local.transform_point3(ray.origin);
        let along = self.to_local.transform_vector3(ray.dir);
        let [scale, metres] = self.scale.unwrap_or_else(|| {
            let scale = along.length();
            [scale, scale.recip()]
        });
        (origin, along * metres, scale)
    }

    /// Mesh normals → world directions, and world displacements → mesh units.
    pub fn turns(&self) -> (DMat3, DMat3) {
        (self.normals, self.to_local.matrix3)
    }

    /// The nearest touch nearer than `reach` metres, and its distance in metres. `beside`: the origin lies on this
    /// surface too.
    #[inline(always)]
    pub fn nearest(
        &self,
        lanes: Option<Lanes>,
        solid: &Solid,
        ray: &Ray,
        beside: Option<Site>,
        reach: f64,
    ) -> Option<(Touch, f64)> {
        let (line, scale) = self.line(solid, ray, beside, reach)?;
        let touch = solid.nearest(lanes, &line, reach * scale)?;
        Some((touch, touch.t / scale))
    }

    #[cfg(any(test, feature = "testing"))]
    pub fn nearest_of_all(&self, solid: &Solid, ray: &Ray, reach: f64) -> Option<(Touch, f64)> {
        let (line, scale) = self.line(solid, ray, None, reach)?;
        let touch = solid.nearest_of_all(&line, reach * scale)?;
        Some((touch, touch.t / scale))
    }

    #[inline(always)]
    pub fn blocks(
        &self,
        lanes: Option<Lanes>,
        solid: &Solid,
        ray: &Ray,
        [beside, target]: [Option<Site>; 2],
        reach: f64,
    ) -> bool {
        let Some((mut line, scale)) = self.line(solid, ray, beside, reach) else { return false };
        if let Some(site) = target
            && site.part == self.part
        {
            line.skip(site.face);
        }
        solid.blocks(lanes, &line, reach * scale)
    }

    #[inline(always)]
    pub fn hit(&self, solid: &Solid, touch: &Touch, t: f64) -> Option<Hit> {
        let (normal, shading) = solid.normals_at(touch)?;
        let local = solid.settle(touch);
        let normal = (self.normals * normal).try_normalize()?;
        let shading = (self.normals * shading).normalize_or(normal);
        Some(Hit {
            t,
            site: Site { part: self.part, face: touch.triangle.face, triangle: touch.triangle.index },
            point: self.to_world.transform_point3(local),
            local,
            normal,
            shading: if shading.dot(normal) < 0.0 { -shading } else { shading },
        })
    }

    /// Whether most rays from a point of the world leave the solid where they first meet it.
    pub fn contains(&self, solid: &Solid, p: DVec3) -> bool {
        const RAYS: u32 = 9;
        let origin = self.to_local.transform_point3(p);
        let inside = (0..RAYS).filter(|i| {
            // Spiral over the sphere by the golden angle, turned so that no direction is along an axis.
            let z = 1.0 - (2.0 * f64::from(*i) + 1.0) / f64::from(RAYS);
            let (sin, cos) = (0.5 + 2.399_963_229_728_653 * f64::from(*i)).sin_cos();
            let across = (1.0 - z * z).sqrt();
            let dir = DVec3::new(cos * across, sin * across, z);
            let touch = LocalRay::new(solid, origin, dir, f64::INFINITY, self.grain)
                .and_then(|line| solid.nearest(None, &line, f64::INFINITY));
            touch.and_then(|touch| solid.normals_at(&touch)).is_some_and(|(normal, _)| normal.dot(dir) > 0.0)
        });
        2 * inside.count() > RAYS as usize
    }
}
