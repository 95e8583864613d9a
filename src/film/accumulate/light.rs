//! Light as it depends on the slide's contrast, and sums of it.

use eyebox_base::double_double::Sum;

/// Light of one path or pixel, cd/m² (or lm before it is measured), as it depends on the slide's contrast.
///
/// With u = 1 − 1/C a slide transmits T_white·(1 − u·(1 − s)): the light of a path that crosses it n times is a
/// polynomial of degree n in u, and so is any sum. Of light that crosses more often than [`Light::DEGREE`] times `powers`
/// has a polynomial of that degree that is the same at C = 1, at C = ∞ and, unless the crossings lie on both pieces of a
/// joined path, at the scene's own contrast; the frame's maker measures what the last costs.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Light {
    /// At the scene's own contrast.
    pub value: f64,
    /// Coefficients of 1, u, u², …
    pub powers: [f64; Light::DEGREE + 1],
    /// Of paths that cross two slides, once each, the coefficient of u parted between them: each one's part times its
    /// [rank](Light::cross). 0 where slides in series are not told apart.
    pub apart: f64,
}

/// What light is with each of two slides in series, one and the other, open or at C = ∞.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corners {
    pub open_open: f64,
    pub content_open: f64,
    pub open_content: f64,
    pub content_content: f64,
}

impl Corners {
    /// At contrasts of their own. With u = 1 − 1/C each slide transmits T_white·(1 − u·(1 − s)), so light that crosses each of
    /// two once is linear in either's u.
    pub fn at(&self, [one, other]: [f64; 2]) -> f64 {
        let ([u, v], [p, q]) = ([1.0 - 1.0 / one, 1.0 / one], [1.0 - 1.0 / other, 1.0 / other]);
        q * (v * self.open_open + u * self.content_open) + p * (v * self.open_content + u * self.content_content)
    }
}

/// Variances and covariance of the mean `open` and `content` of a pixel's light.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MixError {
    pub open: f64,
    pub content: f64,
    pub covariance: f64,
}

impl Light {
    pub const DEGREE: usize = 4;
    /// One, at every contrast.
    pub const ONE: Light = Light { value: 1.0, powers: [1.0, 0.0, 0.0, 0.0, 0.0], apart: 0.0 };

    /// With the slide fully open, C = 1.
    pub fn open(self) -> f64 {
        self.powers[0]
    }
    /// At C = ∞.
    pub fn content(self) -> f64 {
        self.powers.iter().sum()
    }
    pub fn add(&mut self, other: Light) {
        self.value += other.value;
        self.powers.iter_mut().zip(other.powers).for_each(|(a, b)| *a += b);
        self.apart += other.apart;
    }
    #[must_use]
    pub fn scaled(self, factor: f64) -> Light {
        Light { value: self.value * factor, powers: self.powers.map(|p| p * factor), apart: self.apart * factor }
    }
    /// Crosses a slide: transmittance `t_white` when open, `value` at its contrast, picture value `s`. Where slides in series are
    /// told apart each has a `rank` of its own; elsewhere it is 0.
    pub fn cross(&mut self, t_white: f64, value: f64, s: f64, rank: f64) {
        const D: usize = Light::DEGREE;
        self.value *= value;
        self.apart = t_white * (self.apart - rank * (1.0 - s) * self.powers[0]);
        // Coefficient of −u^(D + 1).
        let beyond = t_white * (1.0 - s) * self.powers[D];
        for k in (0..=Self::DEGREE).rev() {
            let below = if k > 0 { self.powers[k - 1] } else { 0.0 };
            self.powers[k] = t_white * (self.powers[k] - (1.0 - s) * below);
        }
        if beyond != 0.0 {
            // With u₀ = 1 − 1/C of the slide, u^(D + 1) is (1 + u₀)·u^D − u₀·u^(D − 1) at 0, u₀ and 1.
            let own = ((t_white - value) / (t_white * (1.0 - s))).clamp(0.0, 1.0);
            self.powers[D] -= (1.0 + own) * beyond;
            self.powers[D - 1] += own * beyond;
        }
    }
    /// Two pieces of a path one after the other.
    #[must_use]
    pub fn times(self, other: Light) -> Light {
        let mut powers = [0.0; Self::DEGREE + 1];
        // Most pieces cross no slide.
        for (i, a) in self.powers.iter().enumerate().filter(|(_, a)| **a != 0.0) {
            for (j, b) in other.powers.iter().enumerate() {
                powers[(i + j).min(Self::DEGREE)] += a * b;
            }
        }
        let apart = self.apart * other.powers[0] + self.powers[0] * other.apart;
        Light { value: self.value * other.value, powers, apart }
    }
    /// Of paths that cross two slides of these ranks, once each.
    pub fn corners(self, [one, other]: [f64; 2]) -> Corners {
        let [open, both, ..] = self.powers;
        // The coefficients of either's u add up to that of u, and times ranks to `apart`.
        let by_other = (self.apart - one * both) / (other - one);
        Corners {
            open_open: open,
            content_open: open + (both - by_other),
            open_content: open + by_other,
            content_content: self.content(),
        }
    }
    pub fn is_finite(self) -> bool {
        (self.value + self.content()).is_finite()
    }
}

/// Numbers of a [`Light`], of which films hold sums: its `value`, the first two of its `powers`, `apart`, the other powers. The
/// tiles that hold them have the first stand for the second: what crosses no slide is `value` alone.
pub(crate) const COLUMNS: usize = Light::DEGREE + 3;

impl Light {
    /// In the order of [`COLUMNS`].
    pub(crate) fn columns(&self) -> [f64; COLUMNS] {
        let [open, first, others @ ..] = self.powers;
        let [second, third, fourth] = others;
        [self.value, open, first, self.apart, second, third, fourth]
    }

    /// From columns in that order.
    pub(crate) fn of_columns([value, open, first, apart, second, third, fourth]: [f64; COLUMNS]) -> Light {
        Light { value, powers: [open, first, second, third, fourth], apart }
    }
}

/// How many columns a light needs.
pub(super) fn depth(light: &Light) -> usize {
    let columns = light.columns();
    match columns[1..].iter().rposition(|column| *column != 0.0) {
        None => 2 * usize::from(light.value != 0.0),
        Some(0) if light.powers[0].to_bits() == light.value.to_bits() => 1,
        Some(last) => last + 2,
    }
}

pub(super) fn add(columns: &mut [Sum], light: &Light) {
    columns.iter_mut().zip(light.columns()).for_each(|(sum, column)| sum.add(column));
}

pub(super) fn value_of(columns: &[Sum]) -> Light {
    let mut all = [0.0; COLUMNS];
    all.iter_mut().zip(columns).for_each(|(column, sum)| *column = sum.value());
    if columns.len() == 1 {
        all[1] = all[0];
    }
    Light::of_columns(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The polynomial of up to four crossings equals the product of the slide's transmittances at any contrast.
    #[test]
    fn crossings_are_a_polynomial_in_the_contrast() {
        let crossings = [(0.9, 0.0), (0.9, 1.0), (0.9, 0.3), (0.9, 0.75)];
        for count in 0..=4 {
            let mut light = Light::ONE;
            crossings[..count].iter().for_each(|(t, s)| light.cross(*t, 0.5, *s, 0.0));
            for contrast in [1.0, 2.0, 50.0, 300.0, f64::INFINITY] {
                let u: f64 = 1.0 - 1.0 / contrast;
                let want: f64 = crossings[..count].iter().map(|(t, s)| t * (1.0 - u * (1.0 - s))).product();
                let got: f64 = light.powers.iter().rev().fold(0.0, |sum, p| sum * u + p);
                assert!((got - want).abs() < 1e-14, "{count} crossings at {contrast}: {got} {want}");
            }
            assert_eq!(light.times(light).open(), light.open().powi(2));
        }
    }

    /// Light that crosses more often is right where it matters: open, at the slide's own contrast and at none of its light.
    #[test]
    fn many_crossings_are_right_at_three_contrasts() {
        const CONTRAST: f64 = 300.0;
        let at = |contrast: f64, t: f64, s: f64| t * (1.0 - (1.0 - 1.0 / contrast) * (1.0 - s));
        for places in
            [vec![(0.9, 0.0); 5], vec![(0.9, 1.0), (0.8, 0.3), (0.9, 0.75), (0.9, 0.0), (0.7, 0.2), (0.9, 0.5)]]
        {
            let mut light = Light::ONE;
            places.iter().for_each(|(t, s)| light.cross(*t, at(CONTRAST, *t, *s), *s, 0.0));
            for contrast in [1.0, CONTRAST, f64::INFINITY] {
                let u = 1.0 - 1.0 / contrast;
                let want: f64 = places.iter().map(|(t, s)| at(contrast, *t, *s)).product();
                let got: f64 = light.powers.iter().rev().fold(0.0, |sum, p| sum * u + p);
                assert!((got - want).abs() < 1e-14, "{} crossings at {contrast}: {got} {want}", places.len());
            }
        }
    }

    /// Light that crosses two slides once each, on one piece of a path or on two that are joined, is the product of their
    /// transmittances at any two contrasts, and so is a sum of it.
    #[test]
    fn two_slides_have_contrasts_of_their_own() {
        let at = |contrast: f64, t: f64, s: f64| t * (1.0 - (1.0 - 1.0 / contrast) * (1.0 - s));
        let ranks = [2.0, 5.0];
        let paths = [[(0.9, 0.0), (0.8, 0.3)], [(0.9, 1.0), (0.8, 0.75)], [(0.9, 0.4), (0.8, 1.0)]];
        let mut sum = Light::default();
        for (k, [(t, s), (p, q)]) in paths.into_iter().enumerate() {
            let mut first = Light::ONE.scaled(3.0);
            first.cross(t, at(20.0, t, s), s, ranks[0]);
            let mut second = Light::ONE;
            second.cross(p, at(20.0, p, q), q, ranks[1]);
            sum.add(if k == 1 { second.times(first) } else { first.times(second) });
            let mut whole = Light::ONE.scaled(3.0);
            whole.cross(p, at(20.0, p, q), q, ranks[1]);
            whole.cross(t, at(20.0, t, s), s, ranks[0]);
            assert!((whole.apart - first.times(second).apart).abs() < 1e-14);
        }
        for contrasts in [[1.0, 1.0], [20.0, 20.0], [3.0, f64::INFINITY], [f64::INFINITY, 700.0]] {
            let [c, d] = contrasts;
            let want: f64 = paths.iter().map(|[(t, s), (p, q)]| 3.0 * at(c, *t, *s) * at(d, *p, *q)).sum();
            let got = sum.corners(ranks).at(contrasts);
            assert!((got - want).abs() < 1e-14, "{contrasts:?}: {got} {want}");
            assert_eq!(Light::of_columns(sum.columns()), sum);
        }
    }
}
