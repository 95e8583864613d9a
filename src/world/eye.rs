//! The eye as the tracer uses it, both ways: rays from the pupil, and light that arrives at it (`design/eye.md`).

use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Where, warp};
use eyebox_film::crop::Crop;
use eyebox_scene::Eye;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// A thin lens in the recentred world frame.
///
/// A pixel is a cell of the tangent plane (ax, ay). With a pupil point o (in the lens plane, from its centre) and the
/// plane of focus at distance f, the ray runs along `look + ax·right + ay·up − o/f`: one formula for every f, infinite
/// included.
#[derive(Debug, Clone, PartialEq)]
pub struct EyeLens {
    position: DVec3,
    look: DVec3,
    up: DVec3,
    right: DVec3,
    radius: f64,
    /// 1/focus distance, 1/m; 0 for focus at infinity.
    per_focus: f64,
    half: DVec2,
    size: [usize; 2],
    /// The part of the picture that is wanted; all of it without one.
    pub crop: Option<Crop>,
}

/// Light that crossed the pupil.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arrival {
    /// Distance along the ray, m.
    pub t: f64,
    /// Row-major index of the pixel whose footprint the light came through; none outside the field of view.
    pub pixel: Option<usize>,
    /// What one lumen adds to the luminance of that pixel, (cd/m²)/lm.
    pub luminance_per_lumen: f64,
    /// Place in the picture, in tangents: right and up.
    pub film: DVec2,
    /// Place in the pupil, m to the right and up.
    pub pupil: DVec2,
}

impl EyeLens {
    /// `origin`: offset of the recentred frame, m, subtracted from the eye's position.
    /// Errors: numbers outside the ranges that [`Eye`] states.
    pub fn build(eye: &Eye, origin: DVec3) -> Result<EyeLens> {
        let fault = |what: &str, value: String, range: &str| {
            Err(Error::new(Where::Nowhere, format!("the eye's {what} is {value}"))
                .expected(range)
                .code(Code::EyeImpossible))
        };
        let position = eye.position - origin;
        if !position.is_finite() {
            return fault("position", eye.position.to_string(), "finite metres");
        }
        let Some(look) = eye.look.try_normalize() else {
            return fault("viewing direction", eye.look.to_string(), "a direction");
        };
        let Some(up) = (eye.up - look * look.dot(eye.up)).try_normalize() else {
            return fault("up direction", eye.up.to_string(), "a direction across the viewing direction");
        };
        if !(eye.pupil_diameter_m >= 0.0 && eye.pupil_diameter_m.is_finite()) {
            return fault("pupil diameter", format!("{} m", eye.pupil_diameter_m), "0 m or more");
        }
        if eye.focus_distance_m.is_nan() || eye.focus_distance_m <= 0.0 {
            return fault("focus distance", format!("{} m", eye.focus_distance_m), "more than 0 m; `inf` is allowed");
        }
        if !(eye.fov_deg > 0.0 && eye.fov_deg < 180.0) {
            return fault("field of view", format!("{}°", eye.fov_deg), "between 0° and 180°");
        }
        let [width, height] = eye.resolution;
        if width == 0 || height == 0 || width.checked_mul(height).is_none() {
            return fault("resolution", format!("{width} × {height}"), "1 × 1 or more");
        }
        let half = DVec2::from_array(eye.half_tangents());
        let right = look.cross(up);
        let (radius, per_focus) = (0.5 * eye.pupil_diameter_m, 1.0 / eye.focus_distance_m);
        Ok(EyeLens { position, look, up, right, radius, per_focus, half, size: eye.resolution, crop: None })
    }

    /// Area of the pupil, m².
    pub fn pupil_area_m2(&self) -> f64 {
        PI * self.radius * self.radius
    }
    /// Centre of the pupil in the recentred frame, m.
    pub fn position(&self) -> DVec3 {
        self.position
    }
    pub fn look(&self) -> DVec3 {
        self.look
    }
    /// Whether a pixel is wanted. What is not wanted is not looked at; everything else is as it is in the whole picture.
    pub fn wants(&self, [x, y]: [usize; 2]) -> bool {
        self.crop.is_none_or(|crop| crop.holds([x, y]))
    }
    /// The same of a pixel's number.
    pub fn wants_index(&self, pixel: usize) -> bool {
        let width = self.size[0];
        self.wants([pixel % width, pixel / width])
    }
    /// Width and height in pixels.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// A point of the pupil's plane, recentred frame: m to the right and up from the pupil's centre.
    pub fn on_pupil(&self, point: DVec3) -> [f64; 2] {
        let offset = point - self.position;
        [offset.dot(self.right), offset.dot(self.up)]
    }
    /// Width and height of a pixel in tangents.
    pub fn pixel(&self) -> [f64; 2] {
        [2.0 * self.half.x / self.size[0] as f64, 2.0 * self.half.y / self.size[1] as f64]
    }
    /// Area of a pixel in tangents.
    fn cell(&self) -> f64 {
        4.0 * self.half.x / self.size[0] as f64 * (self.half.y / self.size[1] as f64)
    }

    /// A ray from the pupil, origin in the recentred frame and unit direction: `jitter` is the place in the pixel's
    /// footprint (right, down), `lens` becomes a uniform point of the pupil.
    pub fn ray(&self, px: usize, py: usize, jitter: [f64; 2], lens: [f64; 2]) -> (DVec3, DVec3) {
        let (origin, (_, dir), ..) = self.ray_of(self.film_of(px, py, jitter), self.radius * warp::disk(lens));
        (origin, dir)
    }

    /// The ray through a place of the picture (tangents) and of the pupil (m to the right and up): its origin, its
    /// direction's length before normalisation and the unit direction, the axes that both places count along, and
    /// 1/focus distance.
    pub fn ray_of(&self, film: DVec2, pupil: DVec2) -> (DVec3, (f64, DVec3), [DVec3; 2], f64) {
        let a = film - pupil * self.per_focus;
        let origin = self.position + self.right * pupil.x + self.up * pupil.y;
        let long = self.look + self.right * a.x + self.up * a.y;
        let length = long.length();
        (origin, (length, long / length), [self.right, self.up], self.per_focus)
    }

    /// The place in the picture, in tangents, of a point of a pixel (right, down from its corner).
    pub fn film_of(&self, px: usize, py: usize, jitter: [f64; 2]) -> DVec2 {
        let ax = self.half.x * (2.0 * (px as f64 + jitter[0]) / self.size[0] as f64 - 1.0);
        let ay = self.half.y * (1.0 - 2.0 * (py as f64 + jitter[1]) / self.size[1] as f64);
        DVec2::new(ax, ay)
    }

    /// The place in the picture, in tangents, at which a place of the pupil (m) sees a point, and the unit direction to it; none behind
    /// the eye.
    pub fn towards(&self, point: DVec3, pupil: DVec2) -> Option<(DVec2, DVec3)> {
        let way = point - (self.position + self.right * pupil.x + self.up * pupil.y);
        let along = way.dot(self.look);
        let film = DVec2::new(way.dot(self.right), way.dot(self.up)) / along + pupil * self.per_focus;
        (along > 0.0 && film.is_finite()).then(|| (film, way.normalize()))
    }

    /// The point of the unit cube (right and down over the picture, then what [`EyeLens::ray`] takes to the place in the
    /// pupil) of a place in the picture (tangents) and in the pupil (m).
    pub fn unit_of(&self, film: DVec2, pupil: DVec2) -> [f64; 4] {
        let lens = warp::disk_inverse(if self.radius > 0.0 { pupil / self.radius } else { DVec2::ZERO });
        let film = [0.5 + 0.5 * film.x / self.half.x, 0.5 - 0.5 * film.y / self.half.y];
        [film[0], film[1], lens[0], lens[1]].map(|x| x.clamp(0.0, warp::BELOW_ONE))
    }

    /// The pixel of a point of that cube, and what [`EyeLens::ray`] wants to know: place in the pixel, place in the pupil.
    pub fn pixel_at(&self, [right, down, u, v]: &[f64; 4]) -> (usize, [[f64; 2]; 2]) {
        let along = |at: f64, count: usize| {
            let x = at * count as f64;
            let index = (x as usize).min(count.saturating_sub(1));
            (index, x - index as f64)
        };
        let ((px, fx), (py, fy)) = (along(*right, self.size[0]), along(*down, self.size[1]));
        (py * self.size[0] + px, [[fx, fy], [*u, *v]])
    }

    /// Flux into the pupil, lm, that a luminance of 1 cd/m² sends through one pixel along `dir` (unit, from the eye).
    pub fn lumens_per_luminance(&self, dir: DVec3) -> f64 {
        dir.dot(self.look).powi(4) * self.pupil_area_m2() * self.cell()
    }

    /// Half the picture's width and height in tangents.
    pub fn half(&self) -> DVec2 {
        self.half
    }
    /// 1/focus distance, 1/m.
    pub fn per_focus(&self) -> f64 {
        self.per_focus
    }
    /// m
    pub fn pupil_radius_m(&self) -> f64 {
        self.radius
    }

    /// The pixel of a place in the picture; none outside of it.
    pub fn pixel_of(&self, film: DVec2) -> Option<usize> {
        let place = |tangent: f64, half: f64, count: usize| {
            let x = (0.5 + 0.5 * tangent / half) * count as f64;
            (x >= 0.0 && x < count as f64).then_some(x as usize)
        };
        let px = place(film.x, self.half.x, self.size[0])?;
        let py = place(-film.y, self.half.y, self.size[1])?;
        Some(py * self.size[0] + px)
    }

    /// The place in the picture, in pixels from its corner to the right and down, at which the middle of the pupil sees what
    /// lies in a direction; none behind the eye.
    pub fn place_of(&self, towards: DVec3) -> Option<[f64; 2]> {
        let along = towards.dot(self.look);
        let film = DVec2::new(towards.dot(self.right), towards.dot(self.up)) / along;
        let place = |tangent: f64, half: f64, count: usize| (0.5 + 0.5 * tangent / half) * count as f64;
        let found = [place(film.x, self.half.x, self.size[0]), place(-film.y, self.half.y, self.size[1])];
        (along > 0.0 && found.iter().all(|x| x.is_finite())).then_some(found)
    }

    /// Where a ray crosses the pupil: distance along it and the offset from the pupil's centre. `facing` is 1 if the
    /// ray must run with the viewing direction and −1 if against it.
    fn cross(&self, origin: DVec3, dir: DVec3, t_max: f64, facing: f64) -> Option<(f64, DVec2)> {
        let along = facing * dir.dot(self.look);
        let height = facing * (self.position - origin).dot(self.look);
        // A ray that starts on the pupil has already crossed it, whatever rounding says.
        let rounding = 64.0 * f64::EPSILON * (self.position.length() + origin.length());
        if !(along > 0.0 && height > rounding) {
            return None;
        }
        let t = height / along;
        let point = origin + dir * t - self.position;
        let offset = DVec2::new(point.dot(self.right), point.dot(self.up));
        (t < t_max && offset.length_squared() <= self.radius * self.radius).then_some((t, offset))
    }

    /// Light along a ray (unit direction) that crosses the pupil from the front before `t_max`.
    ///
    /// A lumen adds 1/(cos⁴θ · A_pupil · Δax·Δay): with d = f/cosθ and the footprint f²·Δax·Δay this is
    /// d²/(cosθp·cosθf·A_pupil·A_footprint), and with ΔΩ = cos³θ·Δax·Δay it is 1/(cosθ·A_pupil·ΔΩ).
    pub fn arrive(&self, origin: DVec3, dir: DVec3, t_max: f64) -> Option<Arrival> {
        if self.radius <= 0.0 {
            return None; // no light finds a pinhole
        }
        let (t, offset) = self.cross(origin, dir, t_max, -1.0)?;
        let cos = -dir.dot(self.look);
        let a = DVec2::new(dir.dot(self.right), dir.dot(self.up)) / -cos + offset * self.per_focus;
        let cos2 = cos * cos;
        let luminance_per_lumen = 1.0 / (cos2 * cos2 * self.pupil_area_m2() * self.cell());
        Some(Arrival { t, pixel: self.pixel_of(a), luminance_per_lumen, film: a, pupil: offset })
    }

    /// Whether the pupil swallows light along a ray before `t_max`, seen or not.
    pub fn blocks(&self, origin: DVec3, dir: DVec3, t_max: f64) -> bool {
        self.radius > 0.0 && self.cross(origin, dir, t_max, -1.0).is_some()
    }

    /// The same for a ray traced against the light: whether the light that comes back along it would have been
    /// swallowed by the pupil. A ray that starts on the pupil does not cross it.
    pub fn blocks_reversed(&self, origin: DVec3, dir: DVec3, t_max: f64) -> bool {
        self.radius > 0.0 && self.cross(origin, dir, t_max, 1.0).is_some()
    }

    /// Étendue of pupil × field of view, m²·sr: the flux that a uniform luminance of 1 cd/m² sends through both.
    pub fn etendue_m2_sr(&self) -> f64 {
        // Pupil points on rings of equal area and evenly spaced spokes: the field's projected solid angle changes
        // smoothly and little over the pupil, and not at all with focus at infinity.
        const RINGS: usize = 16;
        const SPOKES: usize = 24;
        let mut sum = 0.0;
        for k in 0..RINGS * SPOKES {
            let radius = self.radius * ((((k / SPOKES) as f64) + 0.5) / RINGS as f64).sqrt();
            let phi = 2.0 * PI * ((k % SPOKES) as f64 + 0.5) / SPOKES as f64;
            let shift = radius * self.per_focus * DVec2::new(phi.cos(), phi.sin());
            let (low, high) = (-self.half - shift, self.half - shift);
            sum += corner(high.x, high.y) - corner(low.x, high.y) - corner(high.x, low.y) + corner(low.x, low.y);
        }
        self.pupil_area_m2() * sum / (RINGS * SPOKES) as f64
    }
}

/// ∫∫ cos⁴θ da db over 0..a × 0..b in tangents, odd in both: the projected solid angle of a rectangle seen from above
/// its corner (formula sheet, section 5).
fn corner(a: f64, b: f64) -> f64 {
    let (ra, rb) = (a.hypot(1.0), b.hypot(1.0));
    0.5 * (a / ra * (b / ra).atan() + b / rb * (a / rb).atan())
}

#[cfg(test)]
#[path = "eye_tests.rs"]
mod tests;
