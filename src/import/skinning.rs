//! Linear blend skinning, the same for glTF and USD: a vertex is moved by the weighted mean of its joints' matrices, a normal
//! by the inverse transpose of that mean. In f64; only the finished vertices are rounded.

use glam::{DAffine3, DMat3, DVec3};

/// The weighted sum of the matrices that move a vertex.
#[derive(Debug, Clone, Copy)]
pub struct Blend {
    sum: DAffine3,
    weight: f64,
}

impl Default for Blend {
    fn default() -> Self {
        Blend { sum: DAffine3 { matrix3: DMat3::ZERO, translation: DVec3::ZERO }, weight: 0.0 }
    }
}

impl Blend {
    pub fn add(&mut self, matrix: &DAffine3, weight: f64) {
        self.sum.matrix3 += matrix.matrix3 * weight;
        self.sum.translation += matrix.translation * weight;
        self.weight += weight;
    }
    /// The sum of the weights so far.
    pub fn weight(&self) -> f64 {
        self.weight
    }
    /// The mean of the matrices; none without weight.
    pub fn mean(&self) -> Option<DAffine3> {
        if !(self.weight > 0.0 && self.weight.is_finite()) {
            return None;
        }
        let DAffine3 { matrix3, translation } = self.sum;
        Some(DAffine3 { matrix3: matrix3 * self.weight.recip(), translation: translation / self.weight })
    }
}

/// A normal where `matrix` takes its surface: the inverse transpose, but for a positive factor. The cofactors are that times
/// the determinant, and there where the determinant is 0, too.
pub fn normal(matrix: &DMat3, normal: DVec3) -> DVec3 {
    let (x, y, z) = (matrix.x_axis, matrix.y_axis, matrix.z_axis);
    let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    let side = if x.dot(y.cross(z)) < 0.0 { -1.0 } else { 1.0 };
    cofactors * normal * side
}

/// Turns the triangles round whose vertices were mirrored: their outside stays the outside.
pub fn turn_mirrored(triangles: &mut [[u32; 3]], is_mirrored: &[bool]) {
    if !is_mirrored.contains(&true) {
        return;
    }
    let mirrored = |vertex: u32| is_mirrored.get(vertex as usize) == Some(&true);
    for triangle in triangles {
        if triangle.iter().filter(|vertex| mirrored(**vertex)).count() >= 2 {
            triangle.swap(1, 2);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    /// Half of a turn by 90° and half of none: the mean of the matrices, not a turn by 45°, which is what linear means.
    #[test]
    fn the_mean_is_linear() {
        let turn = DAffine3::from_rotation_z(std::f64::consts::FRAC_PI_2);
        let mut blend = Blend::default();
        assert!(blend.mean().is_none());
        blend.add(&turn, 1.0);
        blend.add(&DAffine3::IDENTITY, 1.0);
        let point = blend.mean().unwrap().transform_point3(DVec3::X);
        assert!((point - DVec3::new(0.5, 0.5, 0.0)).length() < 1e-15, "{point}");
    }

    #[test]
    fn normals_stay_upright_under_shears_and_mirrors() {
        let turn = DMat3::from_quat(DQuat::from_rotation_y(0.7));
        for matrix in [
            DMat3::from_diagonal(DVec3::new(1.0, 1.0, -2.0)) * turn,
            DMat3::from_cols(DVec3::X, DVec3::new(3.0, 1.0, 0.5), DVec3::Z),
        ] {
            let (a, b) = (DVec3::new(1.0, 2.0, -0.3), DVec3::new(0.2, -1.0, 2.0));
            let found = normal(&matrix, a.cross(b)).normalize();
            assert!(found.dot(matrix * a).abs() < 1e-12 && found.dot(matrix * b).abs() < 1e-12);
            // On the side where what was above the surface is now.
            assert!(found.dot(matrix * a.cross(b)) > 0.0);
        }
    }
}
