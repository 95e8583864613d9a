//! What one lane of a path carries: power alone, or the Stokes vector of its polarisation.
//!
//! A Stokes vector belongs to a reference direction `axis` across the ray: with x = axis, y = dir × axis and complex
//! amplitudes E, it is (|Ex|² + |Ey|², |Ex|² − |Ey|², 2 Re Ex Ey*, 2 Im Ex Ey*). At a face the axis is turned into the s
//! direction. Reflection and refraction keep s and are diagonal there, amplitudes a_s and a_p, so that the first pair is
//! mixed by the shares of power and the second is multiplied by a_s a_p* (formula sheet, section 1).
//!
//! A path from the eye carries the row vector that the light's Stokes vector is multiplied by. In the frame that belongs
//! to the direction of the ray, rather than of the light, it transforms by the same rules with a_s a_p* conjugated: the
//! transposed matrix, with the sign of y turned over twice.

use super::fresnel::PowerSp;
use eyebox_base::Complex;
use glam::DVec3;
use std::fmt::Debug;

/// What a face does with both polarisations: shares of power, and the phases of r_s r_p* and t_s t_p* as unit numbers
/// (or 0).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turning {
    pub power: PowerSp,
    pub reflected: Complex,
    pub transmitted: Complex,
}

impl Turning {
    /// Shares of s and p that go one way, with the phases of a clear sheet or a mirror.
    pub fn one_way([s, p]: [f64; 2], through: bool) -> Self {
        let ([r_s, r_p], [t_s, t_p]) = if through { ([0.0; 2], [s, p]) } else { ([s, p], [0.0; 2]) };
        let power = PowerSp { r_s, r_p, t_s, t_p, a_s: 1.0 - s, a_p: 1.0 - p };
        Turning { power, reflected: -Complex::ONE, transmitted: Complex::ONE }
    }

    /// For amounts without polarisation.
    pub fn without_phases(power: PowerSp) -> Self {
        Turning { power, reflected: Complex::ZERO, transmitted: Complex::ZERO }
    }
}

/// What facets of a scatterer do with both polarisations, s being across the plane of both directions: shares of all that
/// goes between them, sums over the lobes, and the sum of a_s a_p*. What is left of 1 is unpolarised.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Facets {
    pub s: f64,
    pub p: f64,
    pub cross: Complex,
}

impl Facets {
    pub const NONE: Facets = Facets { s: 0.0, p: 0.0, cross: Complex::ZERO };

    /// Adds a lobe that reflects `value` of unpolarised light, split as `turning` does.
    pub fn add(&mut self, value: f64, turning: &Turning) {
        let (s, p) = (turning.power.r_s, turning.power.r_p);
        let all = s + p;
        if all > 0.0 && value > 0.0 {
            let [s, p] = [s, p].map(|share| 2.0 * value * share / all);
            self.s += s;
            self.p += p;
            self.cross = self.cross + turning.reflected * (s * p).sqrt();
        }
    }

    #[must_use]
    pub fn scaled(self, by: f64) -> Self {
        Facets { s: self.s * by, p: self.p * by, cross: self.cross * by }
    }
}

/// What becomes of an amount at a face: shares of its power, which add up to 1, and the two amounts that leave.
#[derive(Debug, Clone, Copy)]
pub struct Parted<A> {
    pub shares: [f64; 3],
    pub reflected: A,
    pub transmitted: A,
    /// Power by which the reflected amount departs from what it would be without polarisation.
    pub departs: f64,
}

impl<A: Amount> Parted<A> {
    /// The same where only this share of what gets through goes on.
    pub fn stained(self, share: f64) -> Self {
        let [r, t, a] = self.shares;
        Parted { shares: [r, t * share, a + t * (1.0 - share)], transmitted: self.transmitted.scaled(share), ..self }
    }
}

/// One lane's amount of light or importance.
pub trait Amount: Copy + Debug + Send + Sync + 'static {
    const POLARISED: bool;
    /// The reference direction of a path's amounts.
    type Axis: Copy + Debug + Send + Sync;

    /// Unpolarised.
    fn plain(power: f64) -> Self;
    fn power(self) -> f64;
    #[must_use]
    fn scaled(self, factor: f64) -> Self;
    /// Any reference direction of a ray along `dir`.
    fn any_axis(dir: DVec3) -> Self::Axis;
    /// The direction s at a face with unit normal `normal`; the old axis where light falls straight on.
    fn face_axis(old: Self::Axis, dir: DVec3, normal: DVec3) -> Self::Axis;
    /// The reference direction along `to`, as far as it lies across the ray.
    fn axis_along(old: Self::Axis, dir: DVec3, to: DVec3) -> Self::Axis;
    /// A reference direction mirrored at a face with unit normal `normal`, for what it reflects.
    fn mirrored(axis: Self::Axis, normal: DVec3) -> Self::Axis;
    /// The amount with respect to another reference direction.
    #[must_use]
    fn turned(self, from: Self::Axis, to: Self::Axis, dir: DVec3) -> Self;
    /// Parts an amount given with respect to s. `from_eye`: it is importance.
    fn part(self, turning: &Turning, from_eye: bool) -> Parted<Self>;
    /// What a scatterer sends on of an amount given with respect to s; `from_eye`: it is importance.
    #[must_use]
    fn scattered(self, facets: &Facets, from_eye: bool) -> Self;
    /// How light is polarised, apart from its power; nothing of light without polarisation.
    type State: Copy + Debug + Send + Sync;
    fn state(self) -> Self::State;
    /// The power that importance, along `dir`, has of light in this state that comes the other way.
    #[must_use]
    fn meets(self, axis: Self::Axis, dir: DVec3, state: Self::State, of_state: Self::Axis) -> Self;
    /// Through a slide that ignores the polarisation of what it gets and gives light polarised along its axis to this
    /// degree; its transmittance is not in it.
    #[must_use]
    fn polarised_by_slide(self, degree: f64, from_eye: bool) -> Self;
}

impl Amount for f64 {
    const POLARISED: bool = false;
    type Axis = ();

    #[inline]
    fn plain(power: f64) -> Self {
        power
    }
    #[inline]
    fn power(self) -> f64 {
        self
    }
    #[inline]
    fn scaled(self, factor: f64) -> Self {
        self * factor
    }
    #[inline]
    fn any_axis(_: DVec3) {}
    #[inline]
    fn face_axis((): (), _: DVec3, _: DVec3) {}
    #[inline]
    fn axis_along((): (), _: DVec3, _: DVec3) {}
    #[inline]
    fn mirrored((): (), _: DVec3) {}
    #[inline]
    fn turned(self, (): (), (): (), _: DVec3) -> Self {
        self
    }
    #[inline]
    fn part(self, turning: &Turning, _: bool) -> Parted<Self> {
        let p = &turning.power;
        let shares = [p.reflectance(), p.transmittance(), p.absorptance()];
        Parted { shares, reflected: self * shares[0], transmitted: self * shares[1], departs: 0.0 }
    }
    #[inline]
    fn scattered(self, _: &Facets, _: bool) -> Self {
        self
    }
    type State = ();
    #[inline]
    fn state(self) {}
    #[inline]
    fn meets(self, (): (), _: DVec3, (): (), (): ()) -> Self {
        self
    }
    #[inline]
    fn polarised_by_slide(self, _: f64, _: bool) -> Self {
        self
    }
}

/// Stokes vector; the first entry is the power.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stokes(pub [f64; 4]);

impl Stokes {
    /// Through a face that keeps its axes: shares of the power in s and p, and the unit number of a_s a_p*.
    fn through(self, share_s: f64, share_p: f64, phase: Complex, from_eye: bool) -> Self {
        let [i, q, u, v] = self.0;
        let (mean, half) = (0.5 * (share_s + share_p), 0.5 * (share_s - share_p));
        let phase = if from_eye { phase.conj() } else { phase };
        let z = Complex::new(u, v) * (phase * (share_s * share_p).sqrt());
        Stokes([mean * i + half * q, half * i + mean * q, z.re, z.im])
    }

    /// Share of the power that is polarised.
    pub fn degree(self) -> f64 {
        let [i, q, u, v] = self.0;
        (q * q + u * u + v * v).sqrt() / i
    }
}

impl Amount for Stokes {
    const POLARISED: bool = true;
    type Axis = DVec3;

    fn plain(power: f64) -> Self {
        Stokes([power, 0.0, 0.0, 0.0])
    }
    fn power(self) -> f64 {
        self.0[0]
    }
    fn scaled(self, factor: f64) -> Self {
        Stokes(self.0.map(|x| x * factor))
    }
    fn any_axis(dir: DVec3) -> DVec3 {
        dir.any_orthonormal_vector()
    }
    fn face_axis(old: DVec3, dir: DVec3, normal: DVec3) -> DVec3 {
        // Both are unit vectors. Below this sine the product is mostly rounding, and any axis will do: r_s = −r_p.
        const STRAIGHT: f64 = 1e-7;
        let s = normal.cross(dir);
        if s.length_squared() > STRAIGHT * STRAIGHT { s.normalize() } else { across(old, dir) }
    }
    fn axis_along(old: DVec3, dir: DVec3, to: DVec3) -> DVec3 {
        (to - dir * to.dot(dir)).try_normalize().unwrap_or(old)
    }
    fn mirrored(axis: DVec3, normal: DVec3) -> DVec3 {
        axis - normal * (2.0 * axis.dot(normal))
    }
    fn turned(self, from: DVec3, to: DVec3, dir: DVec3) -> Self {
        let (c, s) = (from.dot(to), dir.dot(from.cross(to)));
        let norm = c * c + s * s;
        // Of twice the angle.
        let (c2, s2) = ((c - s) * (c + s) / norm, 2.0 * s * c / norm);
        let [i, q, u, v] = self.0;
        Stokes([i, q * c2 + u * s2, u * c2 - q * s2, v])
    }
    fn part(self, turning: &Turning, from_eye: bool) -> Parted<Self> {
        let p = &turning.power;
        let q = if self.0[0] == 0.0 { 0.0 } else { (self.0[1] / self.0[0]).clamp(-1.0, 1.0) };
        let share = |s: f64, p: f64| 0.5 * (s + p) + 0.5 * (s - p) * q;
        Parted {
            shares: [share(p.r_s, p.r_p), share(p.t_s, p.t_p), share(p.a_s, p.a_p)],
            reflected: self.through(p.r_s, p.r_p, turning.reflected, from_eye),
            transmitted: self.through(p.t_s, p.t_p, turning.transmitted, from_eye),
            departs: (0.5 * (p.r_s - p.r_p) * self.0[1]).abs(),
        }
    }
    fn scattered(self, facets: &Facets, from_eye: bool) -> Self {
        let [i, q, u, v] = self.0;
        let (mean, half) = (0.5 * (facets.s + facets.p), 0.5 * (facets.s - facets.p));
        let cross = if from_eye { facets.cross.conj() } else { facets.cross };
        let z = Complex::new(u, v) * cross;
        Stokes([i + half * q, half * i + mean * q, z.re, z.im])
    }
    type State = [f64; 3];
    fn state(self) -> [f64; 3] {
        let [i, q, u, v] = self.0;
        [q, u, v].map(|part| if i > 0.0 { part / i } else { 0.0 })
    }
    fn meets(self, axis: DVec3, dir: DVec3, [q, u, v]: [f64; 3], of_state: DVec3) -> Self {
        let Stokes([_, q, u, v]) = Stokes([1.0, q, u, v]).turned(of_state, axis, -dir);
        let own = self.0;
        // y points the other way of light that comes along the ray: U and V change their signs.
        Stokes::plain(own[0] + own[1] * q - own[2] * u - own[3] * v)
    }
    fn polarised_by_slide(self, degree: f64, from_eye: bool) -> Self {
        let [i, q, _, _] = self.0;
        if from_eye { Stokes::plain(i + degree * q) } else { Stokes([i, degree * i, 0.0, 0.0]) }
    }
}

/// `axis` made orthogonal to `dir` again, as a unit vector.
fn across(axis: DVec3, dir: DVec3) -> DVec3 {
    (axis - dir * axis.dot(dir)).try_normalize().unwrap_or_else(|| dir.any_orthonormal_vector())
}

#[cfg(test)]
#[path = "stokes_tests.rs"]
mod tests;
