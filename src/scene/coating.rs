//! What lies on a polished face: thin films, or what they were measured to do.

use super::Dispersion;

/// A coating of a polished face. Optical thicknesses never scale with the asset.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Coating {
    pub name: String,
    pub law: CoatingLaw,
}

/// How a coating's shares are known.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CoatingLaw {
    /// Films from outside the solid inwards.
    Stack(Vec<FilmLayer>),
    /// The same shares at every angle and wavelength from both sides; where light cannot go through, both come back.
    Ideal {
        reflectance: f64,
        transmittance: f64,
    },
    Table(CoatingTable),
}

/// One film of a stack.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct FilmLayer {
    pub index: Dispersion,
    pub thickness_nm: f64,
}

/// Measured shares of light that arrives from outside the solid. What arrives from inside under the angle of refraction is
/// transmitted alike (reciprocity), and reflected as `inside` says, or else alike, too (which takes the same to be
/// absorbed); beyond the critical angle all of it comes back, or what `inside` says.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct CoatingTable {
    /// R_s, R_p, T_s, T_p by the angle outside.
    pub outside: SpectralAngular<4>,
    /// R_s, R_p by the angle inside.
    pub inside: Option<SpectralAngular<2>>,
}

/// Values over wavelength and angle: linear in both, constant beyond.
#[derive(Debug, Clone, PartialEq)]
pub struct SpectralAngular<const N: usize> {
    /// Rising.
    pub nm: Vec<f64>,
    /// Rising, rad.
    pub angle: Vec<f64>,
    /// `[wavelength][angle]`
    pub values: Vec<[f64; N]>,
}

impl Coating {
    pub fn stack(name: impl Into<String>, films: Vec<FilmLayer>) -> Coating {
        Coating { name: name.into(), law: CoatingLaw::Stack(films) }
    }

    /// The films; none of a coating that is known by its shares.
    pub fn films(&self) -> &[FilmLayer] {
        match &self.law {
            CoatingLaw::Stack(films) => films,
            CoatingLaw::Ideal { .. } | CoatingLaw::Table(_) => &[],
        }
    }
}

impl<const N: usize> SpectralAngular<N> {
    /// Rows (nm, rad, values) that fill a grid. Errors: a point twice, a grid with holes.
    pub fn from_rows(mut rows: Vec<(f64, f64, [f64; N])>) -> Result<Self, String> {
        rows.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let sorted = |of: fn(&(f64, f64, [f64; N])) -> f64| {
            let mut all: Vec<f64> = rows.iter().map(of).collect();
            all.sort_by(f64::total_cmp);
            all.dedup();
            all
        };
        let (nm, angle) = (sorted(|row| row.0), sorted(|row| row.1));
        if let Some(pair) = rows.windows(2).find(|pair| pair[0].0 == pair[1].0 && pair[0].1 == pair[1].1) {
            return Err(format!("two lines for {} nm, {}°", pair[0].0, pair[0].1.to_degrees()));
        }
        if rows.len() != nm.len().saturating_mul(angle.len()) || rows.is_empty() {
            let (lines, nms, angles) = (rows.len(), nm.len(), angle.len());
            return Err(format!("{lines} lines do not fill a grid of {nms} wavelengths × {angles} angles"));
        }
        Ok(SpectralAngular { nm, angle, values: rows.into_iter().map(|row| row.2).collect() })
    }

    /// The values over the angle (rad) at a wavelength.
    pub fn at_nm(&self, nm: f64) -> Vec<(f64, [f64; N])> {
        let above = self.nm.partition_point(|x| *x < nm).min(self.nm.len().saturating_sub(1));
        let below = above.saturating_sub(1);
        let part = match (self.nm.get(below), self.nm.get(above)) {
            (Some(a), Some(b)) if a < b => ((nm - a) / (b - a)).clamp(0.0, 1.0),
            (Some(_) | None, _) => 0.0,
        };
        let at = |row: usize, k: usize| self.values.get(row * self.angle.len() + k).copied().unwrap_or([0.0; N]);
        let mixed = |k: usize| {
            let (a, b) = (at(below, k), at(above, k));
            std::array::from_fn(|i| if part == 0.0 { a[i] } else { (1.0 - part) * a[i] + part * b[i] })
        };
        self.angle.iter().enumerate().map(|(k, angle)| (*angle, mixed(k))).collect()
    }

    /// The same at every wavelength.
    pub fn is_grey(&self) -> bool {
        let first = self.values.get(..self.angle.len()).unwrap_or(&[]);
        self.values.chunks(self.angle.len().max(1)).all(|row| row == first)
    }
}

impl<const N: usize> serde::Serialize for SpectralAngular<N> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let values: Vec<&[f64]> = self.values.iter().map(<[f64; N]>::as_slice).collect();
        (&self.nm, &self.angle, values).serialize(serializer)
    }
}

/// The values at an angle, linear between the rows of [`SpectralAngular::at_nm`], constant beyond.
pub fn at_angle<const N: usize>(rows: &[(f64, [f64; N])], angle: f64) -> [f64; N] {
    let above = rows.partition_point(|row| row.0 < angle).min(rows.len().saturating_sub(1));
    match (rows.get(above.saturating_sub(1)), rows.get(above)) {
        (Some((x0, a)), Some((x1, b))) if x0 < x1 => {
            let part = ((angle - x0) / (x1 - x0)).clamp(0.0, 1.0);
            std::array::from_fn(|i| (1.0 - part) * a[i] + part * b[i])
        }
        (_, Some((_, b))) => *b,
        (_, None) => [0.0; N],
    }
}
