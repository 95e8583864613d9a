//! Values each nm from 360 to 830 nm: the range and the step in which the CIE defines its sums.

/// The first wavelength, nm.
pub const FIRST_NM: usize = 360;
/// The last wavelength, nm.
pub const LAST_NM: usize = 830;
/// How many wavelengths there are.
pub const COUNT: usize = LAST_NM - FIRST_NM + 1;

/// A value for each nm.
pub type Grid = [f64; COUNT];

/// The wavelengths of a [`Grid`], nm.
pub fn nanometres() -> impl Iterator<Item = f64> {
    (FIRST_NM..=LAST_NM).map(|nm| nm as f64)
}

/// The grid of a function of the wavelength in nm.
pub fn grid(mut value: impl FnMut(f64) -> f64) -> Grid {
    std::array::from_fn(|i| value((FIRST_NM + i) as f64))
}

/// The cell of `nm` and where in it, 0–1; none outside the range.
#[inline]
pub(super) fn cell(nm: f64) -> Option<(usize, f64)> {
    let at = nm - FIRST_NM as f64;
    if !(at >= 0.0 && at <= (COUNT - 1) as f64) {
        return None;
    }
    let i = (at as usize).min(COUNT - 2);
    Some((i, at - i as f64))
}

/// The value at `nm`: linear between the wavelengths of the grid, 0 outside.
#[inline]
pub fn lookup(grid: &Grid, nm: f64) -> f64 {
    cell(nm).map_or(0.0, |(i, t)| grid[i] + (grid[i + 1] - grid[i]) * t)
}

/// ∫ over the whole range by the trapezoidal rule, per nm.
pub fn integral(grid: &Grid) -> f64 {
    grid.iter().sum::<f64>() - (grid[0] + grid[COUNT - 1]) / 2.0
}

/// Rows (λ nm, value) by rising λ on the grid: linear between the rows, 0 outside of them.
pub fn tabulated(rows: &[(f64, f64)]) -> Grid {
    grid(|nm| {
        let after = rows.partition_point(|row| row.0 < nm);
        match (after.checked_sub(1).and_then(|i| rows.get(i)), rows.get(after)) {
            (_, Some(&(at, value))) if at == nm => value,
            (Some(&(below, low)), Some(&(above, high))) => low + (high - low) * ((nm - below) / (above - below)),
            (Some(_) | None, Some(_) | None) => 0.0,
        }
    })
}

/// The columns of an embedded CSV file after the first one, with the first: comments start with `#`, one line of names
/// follows, empty fields say nothing. Only for this module's own files, whose contents its tests check.
pub(super) fn columns<const N: usize>(csv: &str) -> [Vec<(f64, f64)>; N] {
    let mut columns = [const { Vec::new() }; N];
    for line in csv.lines().filter(|line| !line.starts_with('#')).skip(1) {
        let mut fields = line.split(',').map(|field| field.trim().parse::<f64>().ok());
        let Some(nm) = fields.next().flatten() else { continue };
        for (column, value) in columns.iter_mut().zip(fields) {
            column.extend(value.map(|value| (nm, value)));
        }
    }
    columns
}
