//! Small dense least squares in f64: rows are rotated one by one into a triangle, so that no normal equations (which
//! would square the condition number of weakly curved caps) and no n-row matrix are ever formed.

/// The triangle of a QR factorisation of rows `[a_0 … a_{N−2} | y]`; the last column is the right-hand side.
#[derive(Debug, Clone)]
pub(super) struct Triangle<const N: usize> {
    pub r: [[f64; N]; N],
}

impl<const N: usize> Triangle<N> {
    pub fn new() -> Self {
        Triangle { r: [[0.0; N]; N] }
    }

    /// Adds one row by Givens rotations (Golub & Van Loan, Matrix Computations, §5.1.8).
    pub fn add(&mut self, mut row: [f64; N]) {
        for (i, pivot) in self.r.iter_mut().enumerate() {
            let (a, b) = (pivot[i], row[i]);
            // Entries are of order one or rounding of it, so nothing is lost without hypot, which takes most of the time.
            let length = (a * a + b * b).sqrt();
            if b == 0.0 || length == 0.0 {
                continue;
            }
            let (cos, sin) = (a / length, b / length);
            for (p, q) in pivot.iter_mut().zip(row.iter_mut()).skip(i) {
                (*p, *q) = (cos * *p + sin * *q, cos * *q - sin * *p);
            }
        }
    }

    /// Euclidean norm of column `j` of the rows added so far.
    pub fn norm(&self, j: usize) -> f64 {
        self.r.iter().map(|row| row[j] * row[j]).sum::<f64>().sqrt()
    }

    /// Least-squares solution of the rows with each column brought to unit length and pulled to zero with weight
    /// `damping` (Levenberg–Marquardt); columns with `free[j] == false` are held at zero. The last entry returned is
    /// meaningless.
    pub fn solve(&self, damping: f64, free: &[bool; N]) -> [f64; N] {
        let norms: [f64; N] = std::array::from_fn(|j| if j == N - 1 { 1.0 } else { self.norm(j) });
        let used = |j: usize| j == N - 1 || free[j] && norms[j] > 0.0;
        let mut system = Triangle::<N>::new();
        for row in &self.r {
            system.add(std::array::from_fn(|j| if used(j) { row[j] / norms[j] } else { 0.0 }));
        }
        for j in 0..N - 1 {
            let mut pull = [0.0; N];
            pull[j] = if used(j) { damping.max(1e-24).sqrt() } else { 1.0 };
            system.add(pull);
        }
        let mut x = [0.0; N];
        for i in (0..N - 1).rev() {
            let rest: f64 = (i + 1..N - 1).map(|j| system.r[i][j] * x[j]).sum();
            x[i] = (system.r[i][N - 1] - rest) / system.r[i][i];
        }
        std::array::from_fn(|j| if j < N - 1 && used(j) { x[j] / norms[j] } else { 0.0 })
    }

    /// Standard errors of the unknowns for unit noise in each row, other columns free to follow: the root of the
    /// diagonal of (AᵀA)⁻¹. Infinite where the rows do not determine the unknown.
    pub fn errors(&self, free: &[bool; N]) -> [f64; N] {
        // Row j of R⁻¹ by solving with unit right-hand sides: R⁻¹ has columns x_k with R x_k = e_k.
        let norms: [f64; N] = std::array::from_fn(|j| self.norm(j));
        let mut system = Triangle::<N>::new();
        for row in &self.r {
            system.add(std::array::from_fn(|j| {
                if j < N - 1 && free[j] && norms[j] > 0.0 { row[j] / norms[j] } else { 0.0 }
            }));
        }
        let mut sum = [0.0; N];
        for k in (0..N - 1).filter(|&k| free[k]) {
            let mut x = [0.0; N];
            for i in (0..=k).rev().filter(|&i| free[i]) {
                let unit = if i == k { 1.0 } else { 0.0 };
                let rest: f64 = (i + 1..=k).map(|j| system.r[i][j] * x[j]).sum();
                x[i] = (unit - rest) / system.r[i][i];
                sum[i] += x[i] * x[i];
            }
        }
        std::array::from_fn(|j| {
            if j < N - 1 && free[j] && norms[j] > 0.0 { sum[j].sqrt() / norms[j] } else { f64::INFINITY }
        })
    }
}

/// Singular values and right singular vectors of a 3×3 matrix by one-sided Jacobi (Hestenes 1958), largest first.
pub(super) fn singular(a: [[f64; 3]; 3]) -> [(f64, [f64; 3]); 3] {
    // Columns of A and of V side by side: `w[j]` is column j of A·V, `v[j]` column j of V.
    let mut w: [[f64; 3]; 3] = std::array::from_fn(|j| [a[0][j], a[1][j], a[2][j]]);
    let mut v = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let dot = |x: &[f64; 3], y: &[f64; 3]| x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
    // Six sweeps square the off-diagonal below rounding from any start; ten are cheap.
    for _ in 0..10 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let (alpha, beta, gamma) = (dot(&w[p], &w[p]), dot(&w[q], &w[q]), dot(&w[p], &w[q]));
            if gamma == 0.0 {
                continue;
            }
            let zeta = (beta - alpha) / (2.0 * gamma);
            let t = zeta.signum() / (zeta.abs() + zeta.hypot(1.0));
            let cos = 1.0 / t.hypot(1.0);
            let sin = cos * t;
            for m in [&mut w, &mut v] {
                let (one, other) = (m[p], m[q]);
                m[p] = std::array::from_fn(|i| cos * one[i] - sin * other[i]);
                m[q] = std::array::from_fn(|i| sin * one[i] + cos * other[i]);
            }
        }
    }
    let mut out: [(f64, [f64; 3]); 3] = std::array::from_fn(|j| (dot(&w[j], &w[j]).sqrt(), v[j]));
    out.sort_by(|x, y| y.0.total_cmp(&x.0));
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn least_squares_of_a_line_and_its_errors() {
        // y = 2 + 3x with residuals ±1 that are orthogonal to both columns.
        let mut triangle = Triangle::<3>::new();
        for (x, e) in [(-1.0, 1.0), (0.0, -2.0), (1.0, 1.0)] {
            triangle.add([1.0, x, 2.0 + 3.0 * x + e]);
        }
        let x = triangle.solve(0.0, &[true; 3]);
        assert!((x[0] - 2.0).abs() < 1e-14 && (x[1] - 3.0).abs() < 1e-14, "{x:?}");
        let errors = triangle.errors(&[true; 3]);
        assert!((errors[0] - 3f64.powf(-0.5)).abs() < 1e-14 && (errors[1] - 2f64.powf(-0.5)).abs() < 1e-14);
        // A column that repeats another leaves both undetermined, and a held one is held.
        let mut twice = Triangle::<3>::new();
        (0..3).for_each(|i| twice.add([i as f64, 2.0 * i as f64, 1.0]));
        assert!(twice.errors(&[true; 3])[1] > 1e7);
        assert_eq!(twice.solve(0.0, &[true, false, true])[1], 0.0);
    }

    #[test]
    fn singular_values_of_a_rotated_stretch() {
        let (c, s) = (0.6, 0.8);
        let found = singular([[5.0 * c, 5.0 * s, 0.0], [-1e-9 * s, 1e-9 * c, 0.0], [0.0, 0.0, 2.0]]);
        for (value, want) in found.iter().zip([5.0, 2.0, 1e-9]) {
            assert!((value.0 / want - 1.0).abs() < 1e-6, "{found:?}");
        }
        assert!((found[2].1[0].abs() - 0.8).abs() < 1e-12);
    }
}
