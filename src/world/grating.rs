//! Diffraction at a face: the phase of the light along the face changes by m times that of the grating's lines.

use eyebox_scene::Orders;
use eyebox_scene::efficiency_table::Incidence;
use glam::DVec3;

/// A grating as the tracer asks it.
#[derive(Debug, Clone)]
pub struct Grating {
    /// Unit, mesh units.
    pub direction: DVec3,
    /// Planes per nm.
    pub per_nm: f64,
    pub orders: Orders,
    pub rest_in_zero_order: bool,
}

impl Grating {
    pub fn new(grating: &eyebox_scene::Grating) -> Grating {
        Grating {
            direction: grating.direction.normalize_or_zero(),
            per_nm: grating.lines_per_mm * 1e-6,
            orders: grating.orders.clone(),
            rest_in_zero_order: grating.rest_in_zero_order,
        }
    }

    /// λ/d of the first order, across the planes in the world.
    pub fn shift(&self, across: DVec3, nm: f64) -> DVec3 {
        across.normalize_or_zero() * (self.per_nm * nm)
    }

    /// How light arrives that goes along `dir` (unit) onto a face with this normal (unit, to either side). `across`: the planes
    /// in the world.
    pub fn incidence(across: DVec3, normal: DVec3, (dir, front): (DVec3, bool), nm: f64) -> Incidence {
        let across = (across - normal * across.dot(normal)).normalize_or_zero();
        Incidence { nm, across: dir.dot(across), along: dir.dot(normal.cross(across)), front }
    }

    /// What the orders leave of light, of s and of p, that arrives in `n1` with `along`, its momentum (index × direction) along
    /// the face; what an evanescent order would have is left, too.
    pub fn rest(
        &self,
        incidence: &Incidence,
        along: DVec3,
        shift: DVec3,
        normal: DVec3,
        (n1, n2): (f64, f64),
    ) -> [f64; 2] {
        if !self.rest_in_zero_order {
            return [0.0; 2];
        }
        let mut taken = [0.0; 2];
        for (place, order) in self.orders.numbers().enumerate() {
            let there = along + f64::from(order) * (shift - normal * shift.dot(normal));
            let leaves = |n: f64| there.length_squared() < n * n;
            let own = self.orders.efficiency(place, incidence);
            for (taken, (through, back)) in taken.iter_mut().zip(own.transmittance.into_iter().zip(own.reflectance)) {
                *taken += if leaves(n2) { through } else { 0.0 };
                *taken += if leaves(n1) { back } else { 0.0 };
            }
        }
        taken.map(|taken| (1.0 - taken).max(0.0))
    }
}

/// The direction of order m of light along `dir` (unit), which arrives at a face in `n1`: on the other side in `n2`
/// (`through`), or back in `n1`. `normal`: unit, on the side where the light arrives; `shift`: m λ/d across the planes. None
/// where the order is evanescent.
///
/// The phase match k_t' = k_t + m G (the grating equation, conical incidence included: M. Born and E. Wolf, "Principles of
/// Optics", 8.6.1; J. J. Braat and others write it n' t' = n t + m λ/d g).
pub fn diffract(dir: DVec3, normal: DVec3, (n1, n2): (f64, f64), shift: DVec3, through: bool) -> Option<DVec3> {
    let sum = n1 * dir + shift;
    let along = sum - normal * sum.dot(normal);
    let n = if through { n2 } else { n1 };
    // With the length of the part along the face, rather than its square: the difference keeps its digits at grazing.
    let length = along.length();
    let left = (n - length) * (n + length);
    if left.is_nan() || left <= 0.0 {
        return None;
    }
    let depth = left.sqrt();
    (along + normal * if through { -depth } else { depth }).try_normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// n₂ sin θ₂ = n₁ sin θ₁ + m λ/d in the plane across the lines; out of it the part along them stays (conical diffraction);
    /// the way back is the same order's; order 0 is Snell's law.
    #[test]
    fn grating_equation() {
        let normal = DVec3::Z;
        for (n1, n2) in [(1.0, 1.0), (1.0, 1.7), (1.5, 1.0), (1.5, 1.9)] {
            for degrees in [-60.0f64, -10.0, 0.0, 25.0, 70.0] {
                for azimuth in [0.0f64, 0.4, 1.2] {
                    let (s, c) = degrees.to_radians().sin_cos();
                    let dir = DVec3::new(s * azimuth.cos(), s * azimuth.sin(), -c);
                    for m in -2..=2 {
                        for through in [true, false] {
                            // 600 lines/mm at 532 nm, and a part along the normal, which does not count.
                            let shift = f64::from(m) * 600e-6 * 532.0 * DVec3::X + 0.3 * DVec3::Z;
                            let n = if through { n2 } else { n1 };
                            let x = (n1 * dir.x + f64::from(m) * 600e-6 * 532.0) / n;
                            let y = n1 * dir.y / n;
                            let got = diffract(dir, normal, (n1, n2), shift, through);
                            if x * x + y * y >= 1.0 {
                                assert_eq!(got, None);
                                continue;
                            }
                            let z = (1.0 - x * x - y * y).sqrt() * if through { -1.0 } else { 1.0 };
                            let got = got.expect("it propagates");
                            assert!(got.distance(DVec3::new(x, y, z)) < 1e-12, "{got} {x} {y} {z}");
                            let (back, indices) = if through { (-normal, (n2, n1)) } else { (normal, (n1, n1)) };
                            let again = diffract(-got, back, indices, shift, through).expect("the way back");
                            assert!(again.distance(-dir) < 1e-12);
                        }
                    }
                }
            }
        }
    }
}
