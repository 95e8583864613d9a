//! Wave plates: by how much they delay one polarisation against the other, over wavelength and angle.

/// A thin uniaxial plate with its optic axis in its plane.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct WavePlate {
    pub retardance: Retardance,
    /// Ordinary and extraordinary index, if the retardance is to change with the angle.
    pub indices: Option<[f64; 2]>,
}

/// Path by which light polarised along the optic axis lags behind, straight on: rows with rising wavelengths (nm), linear
/// between them and constant beyond. One row holds at every wavelength.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Retardance {
    /// nm.
    Nm(Vec<[f64; 2]>),
    /// Wavelengths in vacuum.
    Waves(Vec<[f64; 2]>),
}

impl Retardance {
    pub fn rows(&self) -> &[[f64; 2]] {
        match self {
            Retardance::Nm(rows) | Retardance::Waves(rows) => rows,
        }
    }

    /// In wavelengths, at `nm`.
    pub fn waves(&self, nm: f64) -> f64 {
        match self {
            Retardance::Nm(rows) => linear(rows, nm) / nm,
            Retardance::Waves(rows) => linear(rows, nm),
        }
    }
}

fn linear(rows: &[[f64; 2]], x: f64) -> f64 {
    let above = rows.partition_point(|row| row[0] < x).min(rows.len().saturating_sub(1));
    match (rows.get(above.saturating_sub(1)), rows.get(above)) {
        (Some([x0, a]), Some([x1, b])) if x0 < x1 => a + (b - a) * ((x - x0) / (x1 - x0)).clamp(0.0, 1.0),
        (_, Some([_, b])) => *b,
        (_, None) => 0.0,
    }
}

impl WavePlate {
    /// A quarter of every wavelength, at every angle.
    pub fn quarter() -> WavePlate {
        WavePlate { retardance: Retardance::Waves(vec![[Self::ANY_NM, 0.25]]), indices: None }
    }

    /// Wavelength of a row that stands alone.
    pub const ANY_NM: f64 = 550.0;

    /// In wavelengths, for light whose momentum along the plate (index × sine) is `along` the optic axis and `across` it.
    ///
    /// The phase between the extraordinary and the ordinary wave, d (k_ez − k_oz), of a plate of thickness d with
    /// k_oz² = n_o² − s², k_ez² = n_e² − s_y² − (n_e/n_o)² s_x² (P. Yeh and C. Gu, "Optics of Liquid Crystal Displays",
    /// extended Jones matrices; x along the optic axis).
    pub fn waves_at(&self, nm: f64, along: f64, across: f64) -> f64 {
        let straight = self.retardance.waves(nm);
        let Some([o, e]) = self.indices else { return straight };
        let root = |square: f64| square.max(0.0).sqrt();
        let (x2, y2) = (along * along, across * across);
        let (k_o, k_e) = (root(o * o - x2 - y2), root(e * e - y2 - (e / o).powi(2) * x2));
        straight * (k_e - k_o) / (e - o)
    }

    /// What is wrong with the numbers, in plain words, if anything is.
    pub fn problem(&self) -> Option<String> {
        let rows = self.retardance.rows();
        if rows.is_empty() || !rows.iter().flatten().all(|x| x.is_finite()) {
            return Some("a retardance is no finite number".to_owned());
        }
        if let Some(pair) = rows.windows(2).find(|pair| pair[0][0] >= pair[1][0]) {
            return Some(format!("the wavelengths of the retardance do not rise at {} nm", pair[1][0]));
        }
        let [o, e] = self.indices?;
        if !(o >= 1.0 && e >= 1.0 && o.is_finite() && e.is_finite() && o != e) {
            return Some(format!("ordinary_index {o} and extraordinary_index {e}"));
        }
        let turned = rows.iter().any(|row| row[1] * (e - o) < 0.0);
        turned.then(|| format!("the retardance has not the sign of {e} − {o}: its plate has no thickness"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tables, and the plate in its principal planes: in the plane across the optic axis both waves obey Snell's law with their
    /// own index.
    #[test]
    fn tilted_plates() {
        let table = Retardance::Nm(vec![[400.0, 150.0], [600.0, 130.0]]);
        for (nm, want) in [(300.0, 150.0), (450.0, 145.0), (600.0, 130.0), (700.0, 130.0)] {
            assert!((table.waves(nm) * nm - want).abs() < 1e-12);
        }
        let (o, e, nm) = (1.5, 1.6, 500.0);
        let plate = WavePlate { retardance: Retardance::Waves(vec![[550.0, 0.25]]), indices: Some([o, e]) };
        assert!((plate.waves_at(nm, 0.0, 0.0) - 0.25).abs() < 1e-15);
        let thickness = 0.25 / (e - o);
        for s in [0.1, 0.5, 0.9] {
            let angle = |n: f64| f64::asin(s / n).cos();
            let across = thickness * (e * angle(e) - o * angle(o));
            assert!((plate.waves_at(nm, 0.0, s) - across).abs() < 1e-12);
            // In the plane of the optic axis the extraordinary wave's index n(θ) obeys 1/n² = cos²/n_e² + sin²/n_o², with θ to
            // the normal: solved for the angle by bisection.
            let (mut low, mut high) = (0.0, std::f64::consts::FRAC_PI_2);
            let n = |t: f64| (t.cos().powi(2) / (e * e) + t.sin().powi(2) / (o * o)).powf(-0.5);
            for _ in 0..100 {
                let middle = 0.5 * (low + high);
                if n(middle) * middle.sin() < s { low = middle } else { high = middle }
            }
            let along = thickness * (n(low) * low.cos() - o * angle(o));
            assert!((plate.waves_at(nm, s, 0.0) - along).abs() < 1e-12, "{s}");
        }
    }
}
