//! Small dense least squares in f64: rows are rotated one by one into a triangle, so that no normal equations (which
//! would square the condition number of weakly curved caps) and no n-row matrix are ever formed.

/// √(a² + b²), by `hypot` (which costs ten times as much) only where a square would leave the range of f64.
pub(super) fn length(a: f64, b: f64) -> f64 {
    let square = a * a + b * b;
    if (1e-280..1e280).contains(&square) { square.sqrt() } else { a.hypot(b) }
}

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

    /// What the rows leave of the right-hand side at `x`, as the sum of squares.
    pub fn left(&self, x: &[f64; N]) -> f64 {
        let miss = |row: &[f64; N]| row[N - 1] - (0..N - 1).map(|j| row[j] * x[j]).sum::<f64>();
        self.r.iter().map(|row| miss(row).powi(2)).sum()
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

/// Rows on their way into a triangle. A block of them is reflected at once (Householder; Golub & Van Loan §5.2), for a
/// third of what it takes to rotate them one by one.
pub(super) struct Rows<const N: usize> {
    triangle: Triangle<N>,
    columns: [[f64; BLOCK]; N],
    held: usize,
}

const BLOCK: usize = 32;

impl<const N: usize> Rows<N> {
    pub fn new() -> Self {
        Rows { triangle: Triangle::new(), columns: [[0.0; BLOCK]; N], held: 0 }
    }

    pub fn add(&mut self, row: [f64; N]) {
        for (column, x) in self.columns.iter_mut().zip(row) {
            column[self.held] = x;
        }
        self.held += 1;
        if self.held == BLOCK {
            self.reflect();
        }
    }

    pub fn triangle(mut self) -> Triangle<N> {
        self.reflect();
        self.triangle
    }

    fn reflect(&mut self) {
        for (i, pivot) in self.triangle.r.iter_mut().enumerate() {
            let Some(([column], others)) = self.columns.get_mut(i..).and_then(|rest| rest.split_at_mut_checked(1))
            else {
                break;
            };
            let below = dot(column, column);
            if below == 0.0 {
                continue;
            }
            // The mirror that takes (pivot, column) to (∓norm, 0), with the sign that does not cancel.
            let norm = (pivot[i] * pivot[i] + below).sqrt();
            let head = pivot[i] + norm.copysign(pivot[i]);
            let share = 1.0 / (norm * head.abs());
            pivot[i] -= head;
            for (top, other) in pivot.iter_mut().skip(i + 1).zip(others) {
                let along = (head * *top + dot(column, other)) * share;
                *top -= along * head;
                other.iter_mut().zip(column.iter()).for_each(|(x, y)| *x -= along * y);
            }
        }
        self.columns = [[0.0; BLOCK]; N];
        self.held = 0;
    }
}

/// In four sums, which the compiler puts side by side.
fn dot(a: &[f64; BLOCK], b: &[f64; BLOCK]) -> f64 {
    let mut sums = [0.0; 4];
    for (a, b) in a.as_chunks::<4>().0.iter().zip(b.as_chunks::<4>().0) {
        sums.iter_mut().zip(a.iter().zip(b)).for_each(|(sum, (a, b))| *sum += a * b);
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3])
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
    fn reflected_rows_are_rotated_rows() {
        let entry = |i: usize, j: usize| ((3 * i + 7 * j * j) as f64).sin() + if i == j { 3.0 } else { 0.0 };
        for count in [1, 5, 32, 33, 100] {
            let (mut rotated, mut reflected) = (Triangle::<5>::new(), Rows::<5>::new());
            for i in 0..count {
                let row = std::array::from_fn(|j| if j == 2 { 0.0 } else { entry(i, j) });
                rotated.add(row);
                reflected.add(row);
            }
            let reflected = reflected.triangle();
            // A triangle is unique but for the signs of its rows.
            for (a, b) in rotated.r.iter().zip(&reflected.r) {
                let sign = a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>().signum();
                let far = a.iter().zip(b).map(|(a, b)| (a - sign * b).abs()).fold(0.0, f64::max);
                assert!(far < 1e-13, "{count}: {a:?} {b:?}");
            }
        }
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
