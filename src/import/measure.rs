//! What can be measured on a CAD face: its area-weighted normal, its bounds, whether it is flat.

use eyebox_scene::Mesh;
use glam::DVec3;

/// Measures of a face, in mesh units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaceMeasure {
    /// Σ of the triangles' area vectors.
    pub area_vector: DVec3,
    /// Σ of the triangles' areas.
    pub area: f64,
    pub min: DVec3,
    pub max: DVec3,
}

impl FaceMeasure {
    /// None if the face doesn't exist or has no triangle with existing vertices. Never panics.
    pub fn new(mesh: &Mesh, face: usize) -> Option<Self> {
        let mut measure =
            FaceMeasure { area_vector: DVec3::ZERO, area: 0.0, min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };
        let mut any = false;
        for [a, b, c] in corners(mesh, face)? {
            let vector = (b - a).cross(c - a) / 2.0;
            measure.area_vector += vector;
            measure.area += vector.length();
            measure.min = measure.min.min(a).min(b).min(c);
            measure.max = measure.max.max(a).max(b).max(c);
            any = true;
        }
        any.then_some(measure)
    }

    /// The area-weighted unit normal, if the face has a prevailing side at all (a tube has none).
    pub fn normal(&self) -> Option<DVec3> {
        let prevailing = self.area_vector.length() >= 0.1 * self.area;
        if prevailing { self.area_vector.try_normalize() } else { None }
    }
    pub fn centre(&self) -> DVec3 {
        (self.min + self.max) / 2.0
    }
    /// Diagonal of the bounds.
    pub fn extent(&self) -> f64 {
        (self.max - self.min).length()
    }

    /// Greatest distance of the face's vertices from the plane through `centre` across `normal`, if that is what f32
    /// vertices of a plane can have or less, else Err(distance).
    pub fn flat(&self, mesh: &Mesh, face: usize, normal: DVec3) -> Result<f64, f64> {
        let through = self.centre();
        let far = corners(mesh, face)
            .into_iter()
            .flatten()
            .flatten()
            .map(|corner| normal.dot(corner - through).abs())
            .fold(0.0, f64::max);
        // Half an ulp in each coordinate, in the normal's direction, twice (vertex and centre), with room for the normal.
        let rounding = 8.0 * f64::from(f32::EPSILON) * self.min.abs().max(self.max.abs()).length();
        if far <= 1e-6 * self.extent() + rounding { Ok(far) } else { Err(far) }
    }
}

/// Corners of the face's triangles; triangles with vertices that don't exist are left out.
fn corners(mesh: &Mesh, face: usize) -> Option<impl Iterator<Item = [DVec3; 3]>> {
    let range = mesh.faces.get(face)?;
    let end = range.first.checked_add(range.count)?;
    let triangles = mesh.triangles.get(range.first as usize..end as usize)?;
    let vertex = |index: u32| {
        let [x, y, z] = *mesh.positions.get(index as usize)?;
        Some(DVec3::new(f64::from(x), f64::from(y), f64::from(z)))
    };
    Some(triangles.iter().filter_map(move |[a, b, c]| Some([vertex(*a)?, vertex(*b)?, vertex(*c)?])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::box_mesh;

    #[test]
    fn a_box_has_six_flat_faces_with_their_normals() {
        let mesh = box_mesh("BOX", [-1.0, -2.0, 0.0], [1.0, 2.0, 0.5]);
        let normals: Vec<_> = (0..6).map(|face| FaceMeasure::new(&mesh, face).unwrap().normal().unwrap()).collect();
        assert_eq!(normals, [DVec3::NEG_X, DVec3::X, DVec3::NEG_Y, DVec3::Y, DVec3::NEG_Z, DVec3::Z]);
        let top = FaceMeasure::new(&mesh, 5).unwrap();
        assert_eq!((top.area, top.centre()), (8.0, DVec3::new(0.0, 0.0, 0.5)));
        assert_eq!(top.flat(&mesh, 5, DVec3::Z), Ok(0.0));
        assert!(top.flat(&mesh, 5, DVec3::new(1e-3, 0.0, 1.0)).is_err());
        assert_eq!(FaceMeasure::new(&mesh, 6), None);
    }

    #[test]
    fn broken_meshes_are_measured_without_panic() {
        let mut mesh = box_mesh("BOX", [0.0; 3], [1.0; 3]);
        mesh.triangles[0] = [7777, 0, 1];
        mesh.faces[1].count = u32::MAX;
        assert!(FaceMeasure::new(&mesh, 0).is_some());
        assert_eq!(FaceMeasure::new(&mesh, 1), None);
    }
}
