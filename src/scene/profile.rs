//! A measured luminous intensity distribution: candela over directions, as photometric files state it.

use glam::{DMat3, DVec3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Intensity on a grid of two angles about a pole: γ from the pole, C about it (right-handed, from the grid's +x).
/// Between the grid's lines it is bilinear in (C, γ); outside of the grid there is none.
///
/// The photometric frame is the luminaire's: it shines along −z ("down" of a ceiling luminaire, direction (0, 0)), +x lies
/// in the plane C0 and +y in C90, so that C runs counter-clockwise for who looks down on it. Grids of type C (IES LM-63,
/// EULUMDAT) have their pole at −z; the poles of types A and B lie elsewhere, which `axes` says, so that no type is
/// resampled.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct LuminousProfile {
    /// As it was named.
    pub file: String,
    /// Grid frame → photometric frame: orthogonal; type C's counts the other way round its pole.
    pub axes: DMat3,
    /// Rising, rad; at least two, over at most a full turn.
    pub c_rad: Vec<f64>,
    /// Rising, rad, within 0 … π; at least two.
    pub gamma_rad: Vec<f64>,
    /// cd, `gamma_rad.len()` for each of `c_rad`; not negative, finite, and one above 0.
    #[serde(skip)]
    pub candela: Vec<f64>,
    pub facts: ProfileFacts,
}

/// What the file says beside its candela.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize)]
pub struct ProfileFacts {
    /// `IES LM-63-2002`, `EULUMDAT`, …
    pub format: String,
    /// `A`, `B` or `C`.
    pub photometric_type: String,
    /// Luminous flux of the lamps, lm, if the file states it; none for absolute photometry of LM-63.
    pub lamp_lumens: Option<f64>,
    /// The candela are the luminaire's own, not scaled from its lamps.
    pub absolute: bool,
    /// What the file's numbers were multiplied by to be candela.
    pub scale: f64,
    /// Width, length and height of the luminous opening, m; LM-63 writes round ones as negative.
    pub opening_m: [f64; 3],
    /// Keywords with their values in the order of the file.
    pub keywords: Vec<(String, String)>,
}

impl LuminousProfile {
    /// Type C: the pole is the direction that the lamp shines in.
    pub const TYPE_C: DMat3 = DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::NEG_Z);
    /// Type A: horizontal angles turn about a pole that is up (+y), to the right (+x) of who looks along the beam.
    pub const TYPE_A: DMat3 = DMat3::from_cols(DVec3::NEG_Z, DVec3::X, DVec3::Y);
    /// Type B: vertical angles turn about a horizontal pole; γ is counted from −x.
    pub const TYPE_B: DMat3 = DMat3::from_cols(DVec3::NEG_Z, DVec3::Y, DVec3::NEG_X);

    /// Number of values of γ.
    pub fn rings(&self) -> usize {
        self.gamma_rad.len()
    }

    fn at(&self, plane: usize, ring: usize) -> f64 {
        self.candela.get(plane * self.rings() + ring).copied().unwrap_or(0.0)
    }

    /// Candela at an angle of the grid, rad; 0 outside of it. C is taken within the grid's turn.
    pub fn value(&self, c_rad: f64, gamma_rad: f64) -> f64 {
        let (Some(&first), Some(&last)) = (self.c_rad.first(), self.c_rad.last()) else { return 0.0 };
        let turned = |c: f64| c - TAU * ((c - first) / TAU).floor();
        let c = if (first..=last).contains(&c_rad) { c_rad } else { turned(c_rad) };
        let (Some((i, s)), Some((j, t))) = (place(&self.c_rad, c), place(&self.gamma_rad, gamma_rad)) else {
            return 0.0;
        };
        let mix = |a: f64, b: f64, t: f64| a * (1.0 - t) + b * t;
        mix(mix(self.at(i, j), self.at(i, j + 1), t), mix(self.at(i + 1, j), self.at(i + 1, j + 1), t), s)
    }

    /// Candela along a unit direction of the photometric frame.
    pub fn along(&self, dir: DVec3) -> f64 {
        let (c, gamma) = self.angles(dir);
        self.value(c, gamma)
    }

    /// The grid's angles (C, γ) of a unit direction of the photometric frame, rad.
    pub fn angles(&self, dir: DVec3) -> (f64, f64) {
        let d = self.axes.transpose() * dir;
        (d.y.atan2(d.x), d.x.hypot(d.y).atan2(d.z))
    }

    /// The direction of grid angles, in the photometric frame.
    pub fn direction(&self, c_rad: f64, gamma_rad: f64) -> DVec3 {
        let ((s, c), (sin, cos)) = (c_rad.sin_cos(), gamma_rad.sin_cos());
        self.axes * DVec3::new(sin * c, sin * s, cos)
    }

    /// Greatest intensity, cd.
    pub fn peak_cd(&self) -> f64 {
        self.candela.iter().copied().fold(0.0, f64::max)
    }

    /// ∫ I dC of each ring, cd·rad.
    pub fn rings_cd(&self) -> Vec<f64> {
        let steps = self.c_rad.windows(2).enumerate();
        let mut rings = vec![0.0; self.rings()];
        for (plane, step) in steps {
            let [from, to] = step else { continue };
            for (ring, sum) in rings.iter_mut().enumerate() {
                *sum += 0.5 * (to - from) * (self.at(plane, ring) + self.at(plane + 1, ring));
            }
        }
        rings
    }

    /// Luminous flux, lm: the exact integral of the bilinear intensity over all directions.
    pub fn flux_lm(&self) -> f64 {
        let rings = self.rings_cd();
        let spans = self.gamma_rad.windows(2).zip(rings.windows(2));
        spans.map(|(g, r)| if let ([g0, g1], [r0, r1]) = (g, r) { band(*g0, *g1, *r0, *r1) } else { 0.0 }).sum()
    }

    /// Whether the grid's pole is the direction that the lamp shines in: type C.
    pub fn is_about_axis(&self) -> bool {
        self.axes == Self::TYPE_C
    }

    /// The part in the half space of the axis, which is all that a face can emit; exact, with a line at γ = 90°.
    pub fn front(&self) -> LuminousProfile {
        let inside = self.gamma_rad.partition_point(|gamma| *gamma <= FRAC_PI_2);
        // Types A and B are read from −90° to 90° about the axis.
        if !self.is_about_axis() || inside == self.rings() {
            return self.clone();
        }
        let mut gamma_rad = self.gamma_rad.get(..inside).unwrap_or(&[]).to_vec();
        let cut = gamma_rad.last().is_some_and(|last| *last < FRAC_PI_2);
        if cut {
            gamma_rad.push(FRAC_PI_2);
        }
        let mut candela = Vec::with_capacity(gamma_rad.len() * self.c_rad.len());
        for (plane, c) in self.c_rad.iter().enumerate() {
            candela.extend((0..inside).map(|ring| self.at(plane, ring)));
            if cut {
                candela.push(self.value(*c, FRAC_PI_2));
            }
        }
        LuminousProfile {
            gamma_rad,
            candela,
            c_rad: self.c_rad.clone(),
            file: self.file.clone(),
            facts: self.facts.clone(),
            axes: self.axes,
        }
    }

    /// γ rescaled about 0 (`scale` > 0) or π (`scale` < 0), cut where it leaves 0 … π; 0 changes nothing
    /// (UsdLuxShapingAPI, `inputs:shaping:ies:angleScale`). None if nothing is left.
    pub fn angle_scaled(mut self, scale: f64) -> Option<LuminousProfile> {
        if scale == 0.0 {
            return Some(self);
        }
        let moved = |gamma: f64| if scale > 0.0 { gamma * scale } else { (gamma - PI) * -scale + PI };
        let back = |gamma: f64| if scale > 0.0 { gamma / scale } else { (gamma - PI) / -scale + PI };
        let mut own: Vec<f64> = self.gamma_rad.iter().copied().filter(|g| (0.0..=PI).contains(&moved(*g))).collect();
        // Lines where the grid is cut.
        for edge in [0.0, PI].map(back) {
            if self.gamma_rad.first().is_some_and(|first| *first < edge)
                && self.gamma_rad.last().is_some_and(|last| edge < *last)
                && !own.contains(&edge)
            {
                own.push(edge);
            }
        }
        own.sort_by(f64::total_cmp);
        let candela = self.c_rad.iter().flat_map(|c| own.iter().map(|gamma| self.value(*c, *gamma))).collect();
        self.candela = candela;
        self.gamma_rad = own.into_iter().map(|gamma| moved(gamma).clamp(0.0, PI)).collect();
        let rises = self.gamma_rad.windows(2).all(|pair| pair[0] < pair[1]);
        (rises && self.rings() >= 2 && self.peak_cd() > 0.0).then_some(self)
    }

    /// All candela times `factor`.
    pub fn times(mut self, factor: f64) -> LuminousProfile {
        self.candela.iter_mut().for_each(|value| *value *= factor);
        self
    }

    /// Half the angle within which the intensity along a plane of the grid stays above half of the peak, rad: the mean
    /// over its planes of how far that reaches from the pole. None for types A and B.
    pub fn half_angle_rad(&self) -> Option<f64> {
        if !self.is_about_axis() {
            return None;
        }
        let half = 0.5 * self.peak_cd();
        let (mut sum, mut weight) = (0.0, 0.0);
        for (plane, step) in self.c_rad.windows(2).enumerate() {
            let last = (0..self.rings()).rev().find(|ring| self.at(plane, *ring) >= half);
            let reach = match last {
                None => 0.0,
                Some(ring) => {
                    let (a, b) = (self.at(plane, ring), self.at(plane, ring + 1));
                    match (self.gamma_rad.get(ring), self.gamma_rad.get(ring + 1)) {
                        (Some(g), Some(next)) => g + (next - g) * (a - half) / (a - b),
                        (Some(g), None) => *g,
                        (None, _) => 0.0,
                    }
                }
            };
            let width = step.get(1).zip(step.first()).map_or(0.0, |(to, from)| to - from);
            sum += width * reach;
            weight += width;
        }
        (weight > 0.0).then(|| sum / weight)
    }
}

/// The interval of `lines` that holds `x`, and how far in it; none outside.
fn place(lines: &[f64], x: f64) -> Option<(usize, f64)> {
    let (first, last) = (*lines.first()?, *lines.last()?);
    if !(first..=last).contains(&x) {
        return None;
    }
    let index = lines.partition_point(|line| *line <= x).saturating_sub(1).min(lines.len().checked_sub(2)?);
    let (from, to) = (lines.get(index)?, lines.get(index + 1)?);
    Some((index, (x - from) / (to - from)))
}

/// ∫ of a line from `a` at t0 to `b` at t1, times sin t (formula sheet, section 7): mean · 2 sin m sin q + slope · cos m ·
/// 2 (sin q − q cos q) about the middle m with half width q, which keeps its digits for narrow bands.
pub fn band(t0: f64, t1: f64, a: f64, b: f64) -> f64 {
    let (m, q) = (0.5 * (t0 + t1), 0.5 * (t1 - t0));
    if q <= 0.0 {
        return 0.0;
    }
    let odd = if q < 0.05 {
        let q2 = q * q;
        q * q2 * (1.0 / 3.0 - q2 * (1.0 / 30.0 - q2 * (1.0 / 840.0 - q2 / 45360.0)))
    } else {
        q.sin() - q * q.cos()
    };
    ((a + b) * m.sin() * q.sin() + (b - a) / q * m.cos() * odd).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn uniform() -> LuminousProfile {
        LuminousProfile {
            file: "u".into(),
            axes: LuminousProfile::TYPE_C,
            c_rad: vec![0.0, 1.0, TAU],
            gamma_rad: vec![0.0, 0.3, 2.0, PI],
            candela: vec![2.0; 12],
            facts: ProfileFacts::default(),
        }
    }

    #[test]
    fn a_uniform_lamp_has_4_pi_times_its_intensity() {
        let all = uniform();
        assert!((all.flux_lm() - 8.0 * PI).abs() < 1e-13);
        let front = all.front();
        assert!((front.flux_lm() - 4.0 * PI).abs() < 1e-13 && front.gamma_rad.last() == Some(&FRAC_PI_2));
        assert_eq!((all.along(DVec3::NEG_Z), front.along(DVec3::NEG_Z), front.along(DVec3::Z)), (2.0, 2.0, 0.0));
        // ∫ t sin t from 0 to 1e-3: t³/3 − t⁵/30.
        let narrow = band(0.0, 1e-3, 0.0, 1e-3);
        assert!((narrow / (1e-9 / 3.0 - 1e-15 / 30.0) - 1.0).abs() < 1e-12, "{narrow}");
        for (t0, t1, a, b) in [(0.2, 0.9, 3.0, 1.0), (0.5, 0.55, 1.0, 2.0), (2.0, PI, 1.0, 0.0)] {
            let s = (b - a) / (t1 - t0);
            let primitive = |t: f64| -(a + s * (t - t0)) * t.cos() + s * t.sin();
            assert!((band(t0, t1, a, b) - (primitive(t1) - primitive(t0))).abs() < 1e-14);
        }
    }

    #[test]
    fn directions_and_angles_belong_together_in_all_types() {
        for axes in [LuminousProfile::TYPE_A, LuminousProfile::TYPE_B, LuminousProfile::TYPE_C] {
            assert!((axes.determinant().abs() - 1.0).abs() < 1e-15);
            let profile = LuminousProfile { axes, ..uniform() };
            for (c, gamma) in [(0.3, 0.7), (-1.2, 1.9)] {
                let (c2, g2) = profile.angles(profile.direction(c, gamma));
                assert!((c - c2).abs() < 1e-15 && (gamma - g2).abs() < 1e-15);
            }
        }
        // Types A and B start at the axis: latitude 0 and longitude 0.
        for axes in [LuminousProfile::TYPE_A, LuminousProfile::TYPE_B] {
            let profile = LuminousProfile { axes, ..uniform() };
            assert!(profile.direction(0.0, FRAC_PI_2).abs_diff_eq(DVec3::NEG_Z, 1e-15));
        }
    }

    #[test]
    fn angles_scale_about_their_end() {
        let mut cone = uniform();
        cone.gamma_rad = vec![0.0, 0.5, 1.0, 1.5];
        let wide = cone.clone().angle_scaled(1.5).unwrap();
        assert_eq!(wide.gamma_rad, [0.0, 0.75, 1.5, 2.25]);
        let cut = cone.clone().angle_scaled(3.0).unwrap();
        assert!(cut.gamma_rad.len() == 4 && (cut.gamma_rad[3] - PI).abs() < 1e-15 && cut.along(DVec3::Z) == 2.0);
        let narrow = uniform().angle_scaled(-0.5).unwrap();
        assert!((narrow.gamma_rad[0] - FRAC_PI_2).abs() < 1e-15 && narrow.along(DVec3::NEG_Z) == 0.0);
        // A cone about 0 that is narrowed about π, to where no direction is left.
        assert!(cone.angle_scaled(f64::NAN).is_none());
    }

    #[test]
    fn half_angles() {
        let mut cone = uniform();
        cone.candela = [[4.0, 3.0, 1.0, 0.0]; 3].concat();
        assert!((cone.half_angle_rad().unwrap() - 1.15).abs() < 1e-12);
    }
}
