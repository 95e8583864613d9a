//! Terms that are added to a surface, as they are numbered in lens files and here.

use crate::prescription::profile::Form;

/// Coefficients of x, y, x², xy, … of the places over the norm radius.
pub(super) fn polynomial(given: &[f64], norm_radius: f64) -> Form {
    let mut coeffs = vec![0.0];
    for degree in 1.. {
        for _ in 0..=degree {
            let Some(c) = given.get(coeffs.len() - 1) else { return Form::Polynomial(coeffs) };
            coeffs.push(c / norm_radius.powi(degree));
        }
    }
    Form::Polynomial(coeffs)
}

/// Coefficients by n and m (below 0: sines) of polynomials whose mean square is 1.
pub(super) fn zernike(given: impl Iterator<Item = ([i64; 2], f64)>, norm_radius: f64) -> Form {
    let mut coeffs = Vec::new();
    for ([n, m], c) in given.filter(|(_, c)| *c != 0.0) {
        let Ok(j) = usize::try_from((n * (n + 2) + m) / 2) else { continue };
        if coeffs.len() <= j {
            coeffs.resize(j + 1, 0.0);
        }
        coeffs[j] += c;
    }
    if coeffs.is_empty() { Form::Conic } else { Form::Zernike { norm_radius, coeffs } }
}

/// Standard Zernike coefficients are numbered as Noll does (J. Opt. Soc. Am. 66, 207, 1976): within an order by rising |m|,
/// even numbers are cosines.
pub(super) fn noll(number: usize) -> [i64; 2] {
    let n = (0..).find(|n| (n + 1) * (n + 2) / 2 >= number).unwrap_or(0);
    let k = number - n * (n + 1) / 2 - 1;
    let size = if n % 2 == 0 { 2 * k.div_ceil(2) } else { 2 * (k / 2) + 1 };
    [n as i64, if number.is_multiple_of(2) { size as i64 } else { -(size as i64) }]
}

/// Fringe coefficients go by rising n + |m| and within that by falling |m|, cosine before sine, and their polynomials are 1 at
/// the rim (Wyant and Creath, "Basic Wavefront Aberration Theory", 1992, table III); the thirty-seventh is that of n = 12.
pub(super) fn fringe(number: usize, c: f64) -> ([i64; 2], f64) {
    let side = (1..).find(|side| side * side >= number).unwrap_or(1);
    let behind = side * side - number;
    let m = behind.div_ceil(2) as i64;
    let n = 2 * (side as i64 - 1) - m;
    let [n, m] = if number == 37 { [12, 0] } else { [n, if behind.is_multiple_of(2) { m } else { -m }] };
    let norm = ((2 * n + 2) as f64 / if m == 0 { 2.0 } else { 1.0 }).sqrt();
    ([n, m], c / norm)
}

/// c ρ^(2i) as Zernike terms without an angle: those are Legendre polynomials of 2ρ² − 1, over which a power of ρ² has the
/// coefficients (2k + 1) i!² / ((i − k)! (i + k + 1)!).
pub(super) fn rotational(i: usize, c: f64) -> impl Iterator<Item = ([i64; 2], f64)> {
    let factorial = |n: usize| (1..=n).map(|n| n as f64).product::<f64>();
    (0..=i).map(move |k| {
        let share = factorial(i) / factorial(i - k) * factorial(i) / factorial(i + k + 1);
        ([2 * k as i64, 0], c * share * ((2 * k + 1) as f64).sqrt())
    })
}
