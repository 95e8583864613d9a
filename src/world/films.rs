//! A coating at one wavelength: films, measured shares or ideal ones, and what they do with light from either side.

use super::fresnel::{PowerSp, fresnel, fresnel_turning, normal_sq};
use super::stokes::{Amount, Turning};
use super::thinfilm::{Film, stack, stack_turning};
use eyebox_base::Complex;
use eyebox_scene::coating::at_angle;
use eyebox_scene::{Coating, CoatingLaw};

/// What lies on a face at one wavelength; a bare interface is a stack without films.
#[derive(Debug, Clone)]
pub enum Films {
    /// In both orders, so that neither side costs a reversal per ray.
    Stack { inwards: Vec<Film>, outwards: Vec<Film> },
    /// At every angle from both sides.
    Ideal { reflectance: f64, transmittance: f64 },
    /// By the angle (rad): R_s, R_p, T_s, T_p from outside, R_s, R_p from inside if they are known.
    Table { outside: Vec<(f64, [f64; 4])>, inside: Option<Vec<(f64, [f64; 2])>> },
}

impl Films {
    /// Whether there are no films.
    pub fn is_bare(&self) -> bool {
        match self {
            Films::Stack { inwards, .. } => inwards.is_empty(),
            Films::Ideal { .. } | Films::Table { .. } => false,
        }
    }

    /// A coating at `nm`; none of it is a bare interface.
    pub fn at(coating: Option<&Coating>, nm: f64) -> Films {
        match coating.map(|coating| &coating.law) {
            None => Films::Stack { inwards: Vec::new(), outwards: Vec::new() },
            Some(CoatingLaw::Stack(layers)) => {
                let film = |layer: &eyebox_scene::FilmLayer| Film {
                    n: layer.index.index(nm),
                    thickness_nm: layer.thickness_nm,
                };
                let inwards: Vec<Film> = layers.iter().map(film).collect();
                let outwards = inwards.iter().rev().copied().collect();
                Films::Stack { inwards, outwards }
            }
            Some(CoatingLaw::Ideal { reflectance, transmittance }) => {
                Films::Ideal { reflectance: *reflectance, transmittance: *transmittance }
            }
            Some(CoatingLaw::Table(table)) => Films::Table {
                outside: table.outside.at_nm(nm),
                inside: table.inside.as_ref().map(|inside| inside.at_nm(nm)),
            },
        }
    }

    /// What happens to light in `n1` that meets the face under `cos_i`; `entering` the solid or leaving it. The phases
    /// are worked out for amounts that have a polarisation; of shares that are not computed from films they are taken to be
    /// those of light that falls straight on: π between s and p where it is reflected, 0 where it goes through.
    pub fn turning<A: Amount>(&self, n1: f64, n2: f64, cos_i: f64, entering: bool, wavelength_nm: f64) -> Turning {
        match self {
            Films::Stack { inwards, outwards } => {
                let films = if entering { inwards } else { outwards };
                let n2 = Complex { re: n2, im: 0.0 };
                match (A::POLARISED, films.is_empty()) {
                    (false, true) => Turning::without_phases(fresnel(n1, n2, cos_i)),
                    (false, false) => Turning::without_phases(stack(n1, films, n2, cos_i, wavelength_nm)),
                    (true, true) => fresnel_turning(n1, n2, cos_i),
                    (true, false) => stack_turning(n1, films, n2, cos_i, wavelength_nm),
                }
            }
            Films::Ideal { reflectance, transmittance } => {
                let shares = [*reflectance, *reflectance, *transmittance, *transmittance];
                straight(if is_total(n1, n2, cos_i) { returned(shares) } else { shares })
            }
            Films::Table { outside, inside } => {
                straight(measured(outside, inside.as_deref(), (n1, n2), cos_i, entering))
            }
        }
    }
}

/// R_s, R_p, T_s, T_p of a table (see [`eyebox_scene::coating::CoatingTable`]).
fn measured(
    outside: &[(f64, [f64; 4])],
    inside: Option<&[(f64, [f64; 2])]>,
    (n1, n2): (f64, f64),
    cos_i: f64,
    entering: bool,
) -> [f64; 4] {
    let angle = cos_i.clamp(0.0, 1.0).acos();
    let total = is_total(n1, n2, cos_i);
    if entering {
        let shares = at_angle(outside, angle);
        return if total { returned(shares) } else { shares };
    }
    let [_, _, t_s, t_p] = if total { [1.0, 1.0, 0.0, 0.0] } else { at_angle(outside, conjugate(n1, n2, cos_i)) };
    match inside {
        // Measured apart, both may add up to a little more than there is.
        Some(inside) => {
            let [r_s, r_p] = at_angle(inside, angle);
            [r_s.min(1.0 - t_s), r_p.min(1.0 - t_p), t_s, t_p]
        }
        None if total => [1.0, 1.0, 0.0, 0.0],
        None => at_angle(outside, conjugate(n1, n2, cos_i)),
    }
}

/// Beyond the critical angle.
fn is_total(n1: f64, n2: f64, cos_i: f64) -> bool {
    normal_sq(n1, n2, n1 * cos_i.clamp(0.0, 1.0)) <= 0.0
}

/// Angle of refraction, rad.
fn conjugate(n1: f64, n2: f64, cos_i: f64) -> f64 {
    let q1 = n1 * cos_i.clamp(0.0, 1.0);
    let (q2, s) = (normal_sq(n1, n2, q1).max(0.0).sqrt(), ((n1 - q1) * (n1 + q1)).max(0.0).sqrt());
    s.atan2(q2)
}

/// What cannot go through comes back.
fn returned([r_s, r_p, t_s, t_p]: [f64; 4]) -> [f64; 4] {
    [r_s + t_s, r_p + t_p, 0.0, 0.0]
}

fn straight([r_s, r_p, t_s, t_p]: [f64; 4]) -> Turning {
    let power = PowerSp { r_s, r_p, t_s, t_p, a_s: 1.0 - r_s - t_s, a_p: 1.0 - r_p - t_p };
    Turning { power, reflected: -Complex::ONE, transmitted: Complex::ONE }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyebox_scene::coating::{CoatingTable, SpectralAngular};
    use eyebox_scene::{Dispersion, FilmLayer};
    use proptest::prelude::*;

    /// A table made from Fresnel's equations of n = 1.5, at every degree.
    fn glass() -> Coating {
        let rows = (0..=90).flat_map(|degree| {
            let angle = f64::from(degree).to_radians();
            let p = fresnel(1.0, Complex::real(1.5), angle.cos());
            [400.0, 700.0].map(|nm| (nm, angle, [p.r_s, p.r_p, p.t_s, p.t_p]))
        });
        let outside = SpectralAngular::from_rows(rows.collect()).unwrap();
        Coating { name: "glass".into(), law: CoatingLaw::Table(CoatingTable { outside, inside: None }) }
    }

    /// A table of bare glass does what bare glass does, from both sides and beyond the critical angle.
    #[test]
    fn a_table_of_fresnel_is_fresnel() {
        let films = Films::at(Some(&glass()), 550.0);
        for degree in 0..60 {
            let cos = (f64::from(degree) + 0.5).to_radians().cos();
            for (n1, n2, entering) in [(1.0, 1.5, true), (1.5, 1.0, false)] {
                let got = films.turning::<f64>(n1, n2, cos, entering, 550.0).power;
                let want = fresnel(n1, Complex::real(n2), cos);
                // Linear between whole degrees, outside; next to the critical angle a degree inside is many there.
                let near = if entering || degree < 38 {
                    2e-4
                } else if degree > 41 {
                    1e-15
                } else {
                    5e-3
                };
                for (a, b) in [(got.r_s, want.r_s), (got.r_p, want.r_p), (got.t_s, want.t_s), (got.t_p, want.t_p)] {
                    assert!((a - b).abs() < near, "{degree} {entering}: {got:?} {want:?}");
                }
            }
        }
    }

    #[test]
    fn what_is_measured_inside_holds_there() {
        let CoatingLaw::Table(mut table) = glass().law else { panic!("a table") };
        table.inside = Some(SpectralAngular::from_rows(vec![(550.0, 0.0, [0.5, 0.99])]).unwrap());
        let films = Films::at(Some(&Coating { name: "x".into(), law: CoatingLaw::Table(table) }), 550.0);
        let p = films.turning::<f64>(1.5, 1.0, 1.0, false, 550.0).power;
        // T is 0.96 from either side, and no more than the rest comes back.
        assert!((p.t_s - 0.96).abs() < 1e-12 && (p.r_s - 0.04).abs() < 1e-12 && (p.r_p - 0.04).abs() < 1e-12);
        let p = films.turning::<f64>(1.5, 1.0, 0.5, false, 550.0).power;
        assert_eq!((p.r_s, p.r_p, p.t_s), (0.5, 0.99, 0.0), "beyond the critical angle");
        assert!((p.a_s - 0.5).abs() < 1e-15);
    }

    proptest! {
        /// 64 dispersive films from 0 nm to 1 mm, some of them absorbing: shares that add up, from both sides.
        #[test]
        fn any_stack_keeps_account(
            layers in prop::collection::vec(
                (1.2..3.0f64, prop_oneof![Just(0.0), Just(1e-9), 0.0..6.0f64], prop_oneof![Just(0.0), 0.0..500.0f64, Just(1e6)]),
                1..=64,
            ),
            n in 1.0..2.0f64, cos in prop_oneof![Just(0.0), Just(1e-9), 0.0..1.0f64], nm in 360.0..830.0f64,
        ) {
            let films = layers.iter().map(|&(n, k, thickness_nm)| {
                let index = Dispersion::Table(vec![(360.0, n + 0.1, k), (830.0, n, 0.5 * k)]);
                FilmLayer { index, thickness_nm }
            });
            let films = Films::at(Some(&Coating::stack("x", films.collect())), nm);
            for (n1, n2, entering) in [(1.0, n, true), (n, 1.0, false)] {
                let p = films.turning::<f64>(n1, n2, cos, entering, nm).power;
                for [r, t, a] in [[p.r_s, p.t_s, p.a_s], [p.r_p, p.t_p, p.a_p]] {
                    prop_assert!(r >= 0.0 && t >= 0.0 && a >= -1e-12 && (r + t + a - 1.0).abs() < 1e-12, "{p:?}");
                }
                let polarised = films.turning::<crate::stokes::Stokes>(n1, n2, cos, entering, nm);
                prop_assert!(polarised.reflected.re.is_finite() && polarised.transmitted.re.is_finite());
            }
        }

        /// Ideal shares: all accounted for at every angle, and T the same from both sides where there is any.
        #[test]
        fn ideal_shares(r in 0.0..1.0f64, t in 0.0..1.0f64, cos in 0.0..1.0f64, n in 1.0..2.0f64) {
            prop_assume!(r + t <= 1.0);
            let law = CoatingLaw::Ideal { reflectance: r, transmittance: t };
            let films = Films::at(Some(&Coating { name: "x".into(), law }), 550.0);
            for (n1, n2, entering) in [(1.0, n, true), (n, 1.0, false)] {
                let p = films.turning::<f64>(n1, n2, cos, entering, 550.0).power;
                prop_assert!((p.r_s + p.t_s + p.a_s - 1.0).abs() < 1e-12);
                prop_assert!(p.t_s == t && p.r_s == r || p.t_s == 0.0 && (p.r_s - r - t).abs() < 1e-15);
            }
        }
    }
}
