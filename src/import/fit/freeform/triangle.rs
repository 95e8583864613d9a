//! Least squares with as many columns as it takes, rows rotated into a triangle one by one. What is left of a row by the
//! leading columns gives the fit of every order of a nested basis, and its leave-one-out residuals, from one triangle.

/// The triangle R of a QR factorisation of weighted rows, and Qᵀ of their right-hand sides. Zeros at the ends of rows
/// are not stored, so that the rows of a spline, sorted along it, cost what its band is wide.
#[derive(Debug, Clone)]
pub(super) struct Triangle {
    /// `rows[i][k]` is R at (i, i + k).
    rows: Vec<Vec<f64>>,
    right: Vec<f64>,
    largest: f64,
}

/// A pivot below this share of the largest says nothing but rounding about its unknown.
const RANK: f64 = 1e-12;

impl Triangle {
    pub fn new(columns: usize) -> Triangle {
        Triangle { rows: vec![Vec::new(); columns], right: vec![0.0; columns], largest: 0.0 }
    }

    /// Adds a row by Givens rotations (Golub & Van Loan, Matrix Computations, §5.1.8). `row` is used up.
    pub fn add(&mut self, row: &mut [f64], mut right: f64) {
        let mut end = row.iter().rposition(|x| *x != 0.0).map_or(0, |last| last + 1);
        let columns = self.rows.iter_mut().zip(self.right.iter_mut());
        for (i, (pivot, top)) in columns.enumerate() {
            if i >= end {
                break;
            }
            let b = row[i];
            if b == 0.0 {
                continue;
            }
            let Some(&a) = pivot.first() else {
                *pivot = row[i..end].to_vec();
                *top = right;
                self.largest = self.largest.max(b.abs());
                return;
            };
            if pivot.len() < end - i {
                pivot.resize(end - i, 0.0);
            }
            // A longer pivot row fills the row's zeros.
            end = (i + pivot.len()).min(row.len());
            let length = (a * a + b * b).sqrt();
            if length == 0.0 {
                continue;
            }
            let (cos, sin) = (a / length, b / length);
            for (p, q) in pivot.iter_mut().zip(row.iter_mut().skip(i)) {
                (*p, *q) = (cos * *p + sin * *q, cos * *q - sin * *p);
            }
            (*top, right) = (cos * *top + sin * right, cos * right - sin * *top);
            self.largest = self.largest.max(length);
        }
    }

    fn pivot(&self, i: usize) -> Option<f64> {
        self.rows.get(i)?.first().copied().filter(|p| p.abs() > RANK * self.largest)
    }

    /// The unknowns of the leading `columns`; one that the rows do not determine is zero.
    pub fn solve(&self, columns: usize) -> Vec<f64> {
        let mut x = vec![0.0; columns];
        for i in (0..columns.min(self.rows.len())).rev() {
            let Some(pivot) = self.pivot(i) else { continue };
            let rest: f64 = self.rows[i].iter().zip(x.iter().skip(i)).skip(1).map(|(r, x)| r * x).sum();
            x[i] = (self.right[i] - rest) / pivot;
        }
        x
    }

    /// R^{−T} of a row, entry by entry: the sum of the squares of the first k entries is the share that the row has in
    /// its own fitted value (its leverage) in the fit by k columns, and the sum of `entry · right` that value.
    pub fn shares(&self, row: &mut [f64], mut each: impl FnMut(usize, f64, f64)) {
        for i in 0..row.len().min(self.rows.len()) {
            let share = match self.pivot(i) {
                Some(pivot) if row[i] != 0.0 => row[i] / pivot,
                Some(_) | None => 0.0,
            };
            if share != 0.0 {
                for (r, x) in self.rows[i].iter().zip(row.iter_mut().skip(i)) {
                    *x -= share * r;
                }
            }
            each(i, share, self.right[i]);
        }
    }

    /// The length of R^{−T} of a row: the standard error of the row's value at unit noise.
    pub fn error(&self, row: &mut [f64]) -> f64 {
        let mut sum = 0.0;
        self.shares(row, |_, share, _| sum += share * share);
        sum.sqrt()
    }

    /// The lower right corner from column `from` on: rows and right-hand sides of the problem in which the columns
    /// before are whatever suits best.
    pub fn corner(&self, from: usize) -> Vec<(Vec<f64>, f64)> {
        let width = self.rows.len().saturating_sub(from);
        let row = |k: usize| {
            let mut out = vec![0.0; width];
            let entries = self.rows.get(from + k).map_or(&[][..], |row| row.as_slice());
            out.iter_mut().skip(k).zip(entries).for_each(|(to, x)| *to = *x);
            (out, self.right.get(from + k).copied().unwrap_or(0.0))
        };
        (0..width).map(row).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(i: usize, j: usize) -> f64 {
        ((3 * i + 7 * j * j + 1) as f64).sin()
    }

    /// Leave-one-out by leaving one out.
    #[test]
    fn shares_give_every_orders_leave_one_out() {
        let (n, p) = (12, 4);
        let y = |i: usize| entry(i, 9);
        let all = |left_out: Option<usize>| {
            let mut triangle = Triangle::new(p);
            for i in (0..n).filter(|i| Some(*i) != left_out) {
                triangle.add(&mut (0..p).map(|j| entry(i, j)).collect::<Vec<_>>(), y(i));
            }
            triangle
        };
        let whole = all(None);
        for i in 0..n {
            let mut row: Vec<f64> = (0..p).map(|j| entry(i, j)).collect();
            let (mut value, mut leverage) = (0.0, 0.0);
            let mut found = Vec::new();
            whole.shares(&mut row, |_, share, right| {
                value += share * right;
                leverage += share * share;
                found.push((y(i) - value) / (1.0 - leverage));
            });
            let without = all(Some(i));
            for (k, found) in found.iter().enumerate() {
                let x = without.solve(k + 1);
                let want = y(i) - x.iter().enumerate().map(|(j, x)| x * entry(i, j)).sum::<f64>();
                assert!((found - want).abs() < 1e-11, "{i} {k}: {found} {want}");
            }
        }
    }

    #[test]
    fn bands_are_dense_rows() {
        let (n, p) = (40, 9);
        let band = |i: usize, j: usize| if (i / 6..i / 6 + 4).contains(&j) { entry(i, j) } else { 0.0 };
        let mut triangle = Triangle::new(p);
        for i in 0..n {
            triangle.add(&mut (0..p).map(|j| band(i, j)).collect::<Vec<_>>(), entry(i, 5));
        }
        assert!(triangle.rows.iter().all(|row| row.len() <= 4));
        let x = triangle.solve(p);
        // At the minimum the residuals are orthogonal to every column.
        for j in 0..p {
            let across: f64 =
                (0..n).map(|i| band(i, j) * (entry(i, 5) - (0..p).map(|k| band(i, k) * x[k]).sum::<f64>())).sum();
            assert!(across.abs() < 1e-12, "{j}: {across:e}");
        }
        let mut lost = Triangle::new(3);
        (0..5).for_each(|i| lost.add(&mut [1.0, 2.0, entry(i, 1)], entry(i, 2)));
        assert!(lost.solve(3)[1] == 0.0 && lost.solve(3).iter().all(|x| x.is_finite()));
    }
}
