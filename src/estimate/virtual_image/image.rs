//! What directions say of the virtual image: distortion, distance, disparity of two eyes. Definitions and their sources
//! are in `docs/scan.md`.

use super::tuning::image::FEWEST;
use glam::{DMat2, DMat3, DVec2, DVec3};

/// Deviation from the best affine picture.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Distortion {
    pub max_arcmin: f64,
    pub rms_arcmin: f64,
    /// Of half the diagonal of the fitted picture.
    pub max_percent: f64,
    pub rms_percent: f64,
}

/// Axes to the right, up and ahead of an eye that has turned to `ahead` with its head as it was.
pub(super) fn turned(ahead: DVec3, right: DVec3) -> Option<DMat3> {
    let right = (right - ahead * ahead.dot(right)).try_normalize()?;
    Some(DMat3::from_cols(right, right.cross(ahead), ahead))
}

/// The best affine picture of points: from places in the picture (m) to tangents of an eye turned to some direction, by least
/// squares. Scale, rotation, shear and shift are no distortion.
struct Affine {
    /// From the head's axes to the turned eye's.
    axes: DMat3,
    /// Mean place and mean tangents.
    place: DVec2,
    tangent: DVec2,
    map: DMat2,
}

impl Affine {
    /// None of fewer than six points ahead, or where they lie on a line. With it those points: place and tangents.
    fn fit(points: &[(DVec2, DVec3)], middle: DVec3, right: DVec3) -> Option<(Affine, Vec<(DVec2, DVec2)>)> {
        let axes = turned(middle, right)?.transpose();
        let tangents: Vec<(DVec2, DVec2)> = points
            .iter()
            .map(|(place, dir)| (*place, axes * *dir))
            .filter(|(_, dir)| dir.z > 0.0)
            .map(|(place, dir)| (place, dir.truncate() / dir.z))
            .collect();
        if tangents.len() < FEWEST {
            return None;
        }
        let count = tangents.len() as f64;
        let mean = |of: fn(&(DVec2, DVec2)) -> DVec2| tangents.iter().map(of).sum::<DVec2>() / count;
        let (place, tangent) = (mean(|p| p.0), mean(|p| p.1));
        let outer = |a: DVec2, b: DVec2| DMat2::from_cols(a * b.x, a * b.y);
        let (mut own, mut both) = (DMat2::ZERO, DMat2::ZERO);
        for (p, t) in &tangents {
            own += outer(*p - place, *p - place);
            both += outer(*t - tangent, *p - place);
        }
        // On a line the determinant is rounding.
        let spread = own.x_axis.x + own.y_axis.y;
        if own.determinant() <= 1e-12 * spread * spread {
            return None;
        }
        Some((Affine { axes, place, tangent, map: both * own.inverse() }, tangents))
    }

    fn at(&self, place: DVec2) -> DVec2 {
        self.tangent + self.map * (place - self.place)
    }
}

/// Where the best affine picture has points (place in the picture, m; direction, unit): unit. As for [`distortion`].
pub fn ideal(points: &[(DVec2, DVec3)], middle: DVec3, right: DVec3) -> Option<Vec<DVec3>> {
    let (fit, _) = Affine::fit(points, middle, right)?;
    let back = fit.axes.transpose();
    Some(points.iter().map(|(place, _)| (back * fit.at(*place).extend(1.0)).normalize()).collect())
}

/// The distortion of points (place in the picture, m; direction, unit), for an eye turned to the direction `middle`;
/// `right`: the head's. The fit is by least squares in the tangents of the directions: scale, rotation, shear and shift are
/// no distortion. None of fewer than six points, or where they lie on a line.
pub fn distortion(points: &[(DVec2, DVec3)], middle: DVec3, right: DVec3) -> Option<Distortion> {
    let (fit, tangents) = Affine::fit(points, middle, right)?;
    let count = tangents.len() as f64;
    let half = tangents.iter().map(|(p, _)| (fit.at(*p) - fit.tangent).length()).fold(0.0, f64::max);
    let (mut max, mut sum, mut max_off, mut sum_off) = (0f64, 0.0, 0f64, 0.0);
    for (p, t) in &tangents {
        let want = fit.at(*p);
        let angle = angle(want.extend(1.0).normalize(), t.extend(1.0).normalize());
        let off = (*t - want).length();
        max = max.max(angle);
        sum += angle * angle;
        max_off = max_off.max(off);
        sum_off += off * off;
    }
    let percent = |off: f64| 100.0 * off / half;
    Some(Distortion {
        max_arcmin: arcmin(max),
        rms_arcmin: arcmin((sum / count).sqrt()),
        max_percent: percent(max_off),
        rms_percent: percent((sum_off / count).sqrt()),
    })
}

/// The angle between unit vectors, exact for small ones too.
fn angle(a: DVec3, b: DVec3) -> f64 {
    2.0 * (a - b).length().atan2((a + b).length())
}

pub fn arcmin(radians: f64) -> f64 {
    radians.to_degrees() * 60.0
}

/// How light from a point of the image spreads at the pupil, dioptres (1/m): the inverse of the distance from which it
/// seems to come; negative where it converges, so that the image would be behind the eye.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Vergence {
    /// By shifts of the eye to its right.
    pub horizontal_per_m: f64,
    /// By shifts up.
    pub vertical_per_m: f64,
}

impl Vergence {
    pub fn mean_per_m(self) -> f64 {
        0.5 * (self.horizontal_per_m + self.vertical_per_m)
    }
}

/// The vergence along `dir`, from the directions in which the point is seen from `step` metres to the left and right of the
/// pupil's middle, and below and above. An image point at distance s along `dir` moves by −o⊥/s for a shift o of the eye,
/// of which o⊥ is across `dir`; the central difference is exact to (step/s)².
pub fn vergence(dir: DVec3, shifted: [[DVec3; 2]; 2], axes: [DVec3; 2], step: f64) -> Option<Vergence> {
    let along = |[before, after]: [DVec3; 2], axis: DVec3| {
        let across = axis - dir * dir.dot(axis);
        let value = -(after - before).dot(across) / (2.0 * step * across.length_squared());
        value.is_finite().then_some(value)
    };
    let [horizontal, vertical] = shifted;
    Some(Vergence { horizontal_per_m: along(horizontal, axes[0])?, vertical_per_m: along(vertical, axes[1])? })
}

/// What two eyes have to do to see one point, rad.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Disparity {
    /// Turn towards each other; negative: apart.
    pub convergence_rad: f64,
    /// The left eye higher than the right one: dipvergence.
    pub dipvergence_rad: f64,
}

/// The disparity of the directions of the left and the right eye, in Helmholtz's coordinates: the elevation about the line
/// through both eyes (`right`), and the azimuth in the plane through it that is so high. A point in space has the same
/// elevation for both.
pub fn disparity(left: DVec3, right_eye: DVec3, [right, up, look]: [DVec3; 3]) -> Disparity {
    let place = |dir: DVec3| {
        let (x, y, z) = (dir.dot(right), dir.dot(up), dir.dot(look));
        (x.atan2(y.hypot(z)), y.atan2(z))
    };
    let ((left_azimuth, left_elevation), (azimuth, elevation)) = (place(left), place(right_eye));
    Disparity { convergence_rad: left_azimuth - azimuth, dipvergence_rad: left_elevation - elevation }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AXES: [DVec3; 3] = [DVec3::X, DVec3::Y, DVec3::NEG_Z];

    /// Points of a plane at distance 1 through a pinhole, moved by `bend`.
    fn grid(bend: impl Fn(DVec2) -> DVec2) -> Vec<(DVec2, DVec3)> {
        (0..81)
            .map(|i| {
                let p = DVec2::new((i % 9) as f64 - 4.0, (i / 9) as f64 - 4.0) / 40.0;
                let t = bend(p);
                // Turned by some angle, mirrored, sheared and shifted: no distortion.
                let t = DVec2::new(-0.8 * t.x + 0.3 * t.y + 0.01, 0.3 * t.x + 0.9 * t.y - 0.02);
                (p, DVec3::new(t.x, t.y, -1.0).normalize())
            })
            .collect()
    }

    #[test]
    fn an_affine_picture_has_no_distortion() {
        let middle = DVec3::new(0.0, 0.0, -1.0);
        let got = distortion(&grid(|p| p), middle, DVec3::X).unwrap();
        assert!(got.max_arcmin < 1e-9 && got.max_percent < 1e-9, "{got:?}");
        // Five points and a line are no picture.
        assert!(distortion(&grid(|p| p)[..5], middle, DVec3::X).is_none());
        assert!(distortion(&grid(|p| p)[..9], middle, DVec3::X).is_none());
    }

    /// t = p(1 + k p²): of the cubic the fit takes its linear part away, which by symmetry is the same in x and y:
    /// Σx²(x² + y²)/Σx² over the grid.
    #[test]
    fn a_cubic_picture() {
        let k = 0.5;
        let plain: Vec<(DVec2, DVec3)> = grid(|p| p)
            .into_iter()
            .map(|(p, _)| (p, (p * (1.0 + k * p.length_squared())).extend(-1.0).normalize()))
            .collect();
        let got = distortion(&plain, DVec3::NEG_Z, DVec3::X).unwrap();
        let (sum2, sum4) =
            plain.iter().fold((0.0, 0.0), |(a, b), (p, _)| (a + p.x * p.x, b + p.x * p.x * p.length_squared()));
        let linear = k * sum4 / sum2;
        let off = |p: DVec2| p.length() * (k * p.length_squared() - linear).abs();
        let half = DVec2::splat(0.1).length() * (1.0 + linear);
        let want = plain.iter().map(|(p, _)| off(*p)).fold(0.0, f64::max) / half * 100.0;
        assert!((got.max_percent / want - 1.0).abs() < 1e-9, "{} {want}", got.max_percent);
    }

    #[test]
    fn a_point_in_space() {
        let eye = DVec3::new(0.01, -0.02, 0.0);
        let point = DVec3::new(0.05, 0.12, -0.8);
        let seen = |shift: DVec3| (point - eye - shift).normalize();
        let step = 1e-3;
        let shifted = [DVec3::X, DVec3::Y].map(|axis| [seen(-axis * step), seen(axis * step)]);
        let got = vergence(seen(DVec3::ZERO), shifted, [DVec3::X, DVec3::Y], step).unwrap();
        let want = 1.0 / (point - eye).length();
        assert!((got.horizontal_per_m / want - 1.0).abs() < 1e-5 && (got.vertical_per_m / want - 1.0).abs() < 1e-5);
        // Two eyes: no dipvergence, whatever the point; convergence 2 atan(ipd/2D) for a point straight ahead.
        let ipd = 0.063;
        let both = |point: DVec3| {
            let from = |side: f64| (point - DVec3::X * (side * ipd / 2.0)).normalize();
            disparity(from(-1.0), from(1.0), AXES)
        };
        assert!(both(point).dipvergence_rad.abs() < 1e-15);
        let ahead = both(DVec3::new(0.0, 0.0, -2.0));
        assert!((ahead.convergence_rad - 2.0 * (ipd / 4.0f64).atan()).abs() < 1e-15);
        // The left eye's image higher by a mrad.
        let lifted = disparity(DVec3::new(0.0, 1e-3, -1.0).normalize(), DVec3::NEG_Z, AXES);
        assert!((lifted.dipvergence_rad - 1e-3f64.atan()).abs() < 1e-15);
        assert!((arcmin(1e-3) - 3.437_746_77).abs() < 1e-7);
    }
}
