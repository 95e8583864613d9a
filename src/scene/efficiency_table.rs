//! Diffraction efficiencies of a grating over wavelength, direction and polarisation.

/// Light as it arrives at a grating.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Incidence {
    pub nm: f64,
    /// Component of its unit direction of travel across the lines, along the grating's `direction` projected on the face.
    pub across: f64,
    /// The same along the lines; its sign does not count, since straight lines are the same from both ends.
    pub along: f64,
    /// It arrives on the side to which the face's normal points.
    pub front: bool,
}

/// What one order has of the light that arrives, 0–1: of s (electric field along the lines) and of p.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Efficiency {
    pub transmittance: [f64; 2],
    pub reflectance: [f64; 2],
}

/// Efficiencies from a file, linear in wavelength and both angles, constant beyond the outermost.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct EfficiencyTable {
    pub file: String,
    pub orders: Vec<i32>,
    /// Of light that arrives at the front.
    pub front: EfficiencyGrid,
    /// None: as at the front.
    pub back: Option<EfficiencyGrid>,
}

/// Efficiencies at every pair of a wavelength and a direction.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct EfficiencyGrid {
    /// Rising.
    pub nm: Vec<f64>,
    /// Rising, rad: sines are [`Incidence::across`].
    pub angle: Vec<f64>,
    /// Rising, rad, from 0: sines are the size of [`Incidence::along`].
    pub conical: Vec<f64>,
    /// `[order][nm][angle][conical]`
    pub values: Vec<Efficiency>,
}

impl Efficiency {
    pub const NONE: Efficiency = Efficiency { transmittance: [0.0; 2], reflectance: [0.0; 2] };

    /// The same of both polarisations.
    pub fn even(transmittance: f64, reflectance: f64) -> Self {
        Efficiency { transmittance: [transmittance; 2], reflectance: [reflectance; 2] }
    }

    fn add(&mut self, other: &Efficiency, weight: f64) {
        for k in 0..2 {
            self.transmittance[k] += weight * other.transmittance[k];
            self.reflectance[k] += weight * other.reflectance[k];
        }
    }

    fn is_possible(&self) -> bool {
        self.transmittance.iter().chain(&self.reflectance).all(|share| (0.0..=1.0).contains(share))
    }
}

impl EfficiencyTable {
    /// Of the order at this place in [`EfficiencyTable::orders`].
    pub fn at(&self, order: usize, incidence: &Incidence) -> Efficiency {
        self.grid(incidence.front).at(order, incidence)
    }

    fn grid(&self, front: bool) -> &EfficiencyGrid {
        if front { &self.front } else { self.back.as_ref().unwrap_or(&self.front) }
    }

    fn grids(&self) -> impl Iterator<Item = &EfficiencyGrid> {
        std::iter::once(&self.front).chain(&self.back)
    }

    /// Whether s and p differ anywhere.
    pub fn parts_polarisations(&self) -> bool {
        let differs = |[s, p]: [f64; 2]| s != p;
        let values = self.grids().flat_map(|grid| &grid.values);
        values.into_iter().any(|value| differs(value.transmittance) || differs(value.reflectance))
    }

    /// The most that all orders have together of one polarisation. Between the lines it is no more.
    pub fn most(&self) -> f64 {
        let sums = self.grids().flat_map(|grid| (0..grid.points()).map(|point| grid.sums(point)));
        sums.flatten().fold(0.0, f64::max)
    }

    /// What is wrong with it, in plain words, if anything is.
    pub fn problem(&self) -> Option<String> {
        let rises = |axis: &[f64]| axis.windows(2).all(|pair| pair[0] < pair[1]) && axis.iter().all(|x| x.is_finite());
        for grid in self.grids() {
            let axes = [&grid.nm, &grid.angle, &grid.conical];
            let whole = grid.values.len() == self.orders.len() * grid.points() && !grid.values.is_empty();
            if !whole || !axes.iter().all(|axis| rises(axis)) {
                return Some(format!("the table {} is no grid", self.file));
            }
            if !grid.values.iter().all(Efficiency::is_possible) {
                return Some(format!("the table {} has an efficiency that is no share", self.file));
            }
        }
        None
    }
}

impl EfficiencyGrid {
    /// Of one order.
    pub fn points(&self) -> usize {
        self.nm.len().saturating_mul(self.angle.len()).saturating_mul(self.conical.len())
    }

    /// What all orders have together at a point, of s and of p.
    pub fn sums(&self, point: usize) -> [f64; 2] {
        let mut sum = Efficiency::NONE;
        self.values.iter().skip(point).step_by(self.points().max(1)).for_each(|value| sum.add(value, 1.0));
        [0, 1].map(|k| sum.transmittance[k] + sum.reflectance[k])
    }

    fn at(&self, order: usize, incidence: &Incidence) -> Efficiency {
        // A sine may be rounded to more than 1.
        let angle = |sine: f64| sine.clamp(-1.0, 1.0).asin();
        let nm = between(&self.nm, incidence.nm);
        let across = between(&self.angle, angle(incidence.across));
        let along = between(&self.conical, angle(incidence.along).abs());
        let mut sum = Efficiency::NONE;
        for (i, of_nm) in nm {
            for (j, of_angle) in across {
                for (k, of_conical) in along {
                    let weight = of_nm * of_angle * of_conical;
                    let place = ((order * self.nm.len() + i) * self.angle.len() + j) * self.conical.len() + k;
                    if let Some(value) = self.values.get(place).filter(|_| weight > 0.0) {
                        sum.add(value, weight);
                    }
                }
            }
        }
        sum
    }
}

/// The neighbours of `x` on a rising axis, and their weights.
fn between(axis: &[f64], x: f64) -> [(usize, f64); 2] {
    let above = axis.partition_point(|at| *at < x).min(axis.len().saturating_sub(1));
    let below = above.saturating_sub(1);
    let part = match (axis.get(below), axis.get(above)) {
        (Some(a), Some(b)) if a < b => ((x - a) / (b - a)).clamp(0.0, 1.0),
        (Some(_) | None, _) => 1.0,
    };
    [(below, 1.0 - part), (above, part)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn even(transmittance: f64) -> Efficiency {
        Efficiency::even(transmittance, 0.0)
    }

    /// Linear functions are met exactly, in all three directions, and held beyond the outermost lines.
    #[test]
    fn tables_are_linear_and_held() {
        let law = |nm: f64, angle: f64, conical: f64| 0.1 + 1e-4 * nm + 0.2 * angle + 0.1 * conical;
        let (nm, angle, conical) = (vec![400.0, 500.0, 700.0], vec![-0.5, 0.1, 0.6], vec![0.0, 0.7]);
        let mut values = Vec::new();
        for of_order in [1.0, 0.5] {
            for nm in &nm {
                for angle in &angle {
                    values.extend(conical.iter().map(|conical| even(of_order * law(*nm, *angle, *conical))));
                }
            }
        }
        let front = EfficiencyGrid { nm, angle, conical, values };
        let table = EfficiencyTable { file: "a.csv".to_owned(), orders: vec![0, 1], front, back: None };
        assert_eq!(table.problem(), None);
        for (nm, angle, conical, held) in [
            (440.0, -0.3, 0.2, [440.0, -0.3, 0.2]),
            (500.0, 0.1, 0.7, [500.0, 0.1, 0.7]),
            (900.0, 0.9, 0.9, [700.0, 0.6, 0.7]),
            (300.0, -1.0, 0.0, [400.0, -0.5, 0.0]),
        ] {
            let [a, b, c] = held;
            for (front, sign) in [(true, 1.0), (false, -1.0)] {
                let along = sign * f64::sin(conical);
                let at = table.at(1, &Incidence { nm, across: f64::sin(angle), along, front });
                assert!((at.transmittance[0] - 0.5 * law(a, b, c)).abs() < 1e-14, "{nm} {angle} {conical}");
            }
        }
        assert!((table.most() - 1.5 * law(700.0, 0.6, 0.7)).abs() < 1e-14);
        assert!(!table.parts_polarisations());
    }

    /// One line holds everywhere.
    #[test]
    fn a_table_of_one_line() {
        let value = Efficiency { transmittance: [0.5, 0.25], reflectance: [0.0; 2] };
        let front = EfficiencyGrid { nm: vec![550.0], angle: vec![0.2], conical: vec![0.0], values: vec![value] };
        let back = EfficiencyGrid { values: vec![even(0.125)], ..front.clone() };
        let table = EfficiencyTable { file: String::new(), orders: vec![-1], front, back: Some(back) };
        let at = |front: bool| table.at(0, &Incidence { nm: 400.0, across: -0.9, along: 0.1, front });
        assert_eq!((at(true), at(false)), (value, even(0.125)));
        assert!(table.parts_polarisations());
    }
}
