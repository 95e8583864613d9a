//! The colour of a lamp: how its power is spread over the wavelengths.

use eyebox_base::colour::{
    self, COUNT, FIRST_NM, Grid, K_M, LAST_NM, XYZ_TO_REC709, Xyz, apply, grid, integral, lookup, planck,
};
use std::fmt;
use std::sync::Arc;

/// The LEDs of CIE 015:2018, table 12.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Led {
    B1,
    B2,
    B3,
    B4,
    B5,
    Bh1,
    Rgb1,
    V1,
    V2,
}

impl Led {
    /// In the order of the table.
    pub const ALL: [Led; 9] = [Led::B1, Led::B2, Led::B3, Led::B4, Led::B5, Led::Bh1, Led::Rgb1, Led::V1, Led::V2];

    /// As the attribute `spectrum` names it: `led_b1`.
    pub fn name(self) -> &'static str {
        match self {
            Led::B1 => "led_b1",
            Led::B2 => "led_b2",
            Led::B3 => "led_b3",
            Led::B4 => "led_b4",
            Led::B5 => "led_b5",
            Led::Bh1 => "led_bh1",
            Led::Rgb1 => "led_rgb1",
            Led::V1 => "led_v1",
            Led::V2 => "led_v2",
        }
    }
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|led| led.name() == name)
    }
}

/// A lamp's spectrum, up to its size.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Spectrum {
    /// CIE standard illuminant D65.
    D65,
    /// CIE standard illuminant A.
    A,
    /// The same power at every wavelength.
    Equal,
    /// A correlated colour temperature in K: a black body below 4000 K, the CIE's daylight from 4000 to 25000 K. The two
    /// don't meet: at 4000 K the chromaticity steps by 0.0036 in u'v' from one to the other.
    Cct(f64),
    Led(Led),
    /// (λ nm, relative power) by rising λ: linear between the rows, 0 outside. One row alone is a line.
    Table(Vec<(f64, f64)>),
    /// The smooth spectrum of a linear Rec.709 colour; no component below 0.
    Rgb([f64; 3]),
}

impl Spectrum {
    /// The lowest temperature of [`Spectrum::Cct`] that is daylight, K.
    pub const DAYLIGHT_K: f64 = 4000.0;
    /// The temperatures that [`Spectrum::Cct`] takes, K.
    pub const CCT_K: [f64; 2] = [1000.0, 25_000.0];

    /// The power each nm. Errors: what is wrong with the numbers, in plain words; a spectrum without visible light.
    pub fn resolve(&self) -> Result<PowerDistribution, String> {
        let values = match self {
            Spectrum::D65 => *colour::d65(),
            // CIE 15: the formula with its own c₂ and temperature.
            Spectrum::A => grid(|nm| 100.0 * planck(2848.0, 1.435e7, nm)),
            Spectrum::Equal => [1.0; COUNT],
            Spectrum::Cct(kelvin) => cct(*kelvin)?,
            Spectrum::Led(led) => *colour::led(*led as usize).ok_or("the LED has no table")?,
            Spectrum::Table(rows) => table(rows)?,
            Spectrum::Rgb(rgb) => {
                if !rgb.iter().all(|c| *c >= 0.0 && c.is_finite()) {
                    return Err(format!("the colour {rgb:?} has a component below 0 or not finite"));
                }
                // Scaled first: neither overflow nor underflow.
                let largest = rgb.iter().fold(0.0, |a: f64, b| a.max(*b));
                if largest == 0.0 {
                    return Err("the colour is black".into());
                }
                let rgb = rgb.map(|c| c / largest);
                grid(|nm| colour::uplift_emission(rgb, nm))
            }
        };
        PowerDistribution::new(values)
    }

    /// What is wrong with it, if anything is.
    pub fn problem(&self) -> Option<String> {
        self.resolve().err()
    }
}

/// In few words: `led_b1`, `3000 K`, `table of 81 rows`.
impl fmt::Display for Spectrum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Spectrum::D65 => write!(f, "D65"),
            Spectrum::A => write!(f, "A"),
            Spectrum::Equal => write!(f, "equal"),
            Spectrum::Cct(kelvin) => write!(f, "{kelvin} K"),
            Spectrum::Led(led) => write!(f, "{}", led.name()),
            Spectrum::Table(rows) => write!(f, "table of {} rows", rows.len()),
            Spectrum::Rgb([r, g, b]) => write!(f, "RGB {r:.4} {g:.4} {b:.4}"),
        }
    }
}

fn cct(kelvin: f64) -> Result<Grid, String> {
    let [low, high] = Spectrum::CCT_K;
    if !(low..=high).contains(&kelvin) {
        return Err(format!("the colour temperature is {kelvin} K, not from {low} to {high} K"));
    }
    // CODATA 2018, nm K.
    const C2: f64 = 1.438_776_877e7;
    Ok(if kelvin < Spectrum::DAYLIGHT_K { grid(|nm| planck(kelvin, C2, nm)) } else { colour::daylight(kelvin) })
}

fn table(rows: &[(f64, f64)]) -> Result<Grid, String> {
    if let Some(i) = rows.iter().position(|(nm, power)| !(nm.is_finite() && power.is_finite() && *power >= 0.0)) {
        return Err(format!("row {i} of the spectrum is not a wavelength and a power >= 0"));
    }
    if let Some(i) = rows.windows(2).position(|pair| pair[0].0 >= pair[1].0) {
        return Err(format!("the wavelengths of the spectrum do not rise after row {i}"));
    }
    // Scaled, so that sums stay finite.
    let largest = rows.iter().fold(0.0, |a: f64, row| a.max(row.1));
    let rows: Vec<(f64, f64)> = rows.iter().map(|(nm, power)| (*nm, power / largest)).collect();
    let range = FIRST_NM as f64..=LAST_NM as f64;
    Ok(match rows.as_slice() {
        // Spread over the two neighbours so that its mean wavelength is kept.
        [(line, _)] if range.contains(line) => grid(|nm| (1.0 - (nm - line).abs()).max(0.0)),
        rows if rows.windows(2).all(|pair| pair[1].0 - pair[0].0 >= 1.0) => colour::tabulated(rows),
        // Rows closer than the grid: their mean around each nm, so that a narrow line isn't missed.
        rows => grid(|nm| mean_around(rows, nm)),
    })
}

/// ∫ of the rows' line times the hat that is 1 at `nm` and 0 a nanometre away.
fn mean_around(rows: &[(f64, f64)], nm: f64) -> f64 {
    let inside = |at: f64| rows.partition_point(|row| row.0 <= at);
    let between = rows.get(inside(nm - 1.0)..inside(nm + 1.0)).unwrap_or(&[]);
    let mut borders: Vec<f64> = between.iter().map(|row| row.0).chain([nm - 1.0, nm, nm + 1.0]).collect();
    borders.sort_by(f64::total_cmp);
    let (Some(first), Some(last)) = (rows.first(), rows.last()) else { return 0.0 };
    let value = |at: f64| {
        let after = rows.partition_point(|row| row.0 < at).clamp(1, rows.len() - 1);
        let (a, b) = (rows[after - 1], rows[after]);
        a.1 + (b.1 - a.1) * ((at - a.0) / (b.0 - a.0))
    };
    let hat = |at: f64| 1.0 - (at - nm).abs();
    borders
        .windows(2)
        .map(|pair| (pair[0].max(first.0), pair[1].min(last.0)))
        .filter(|(a, b)| a < b)
        .map(|(a, b)| {
            // Simpson's rule is exact for the product of two lines.
            let mid = 0.5 * (a + b);
            let [fa, fm, fb] = [a, mid, b].map(|at| value(at) * hat(at));
            (b - a) / 6.0 * (fa + 4.0 * fm + fb)
        })
        .sum()
}

/// A relative power for each nm from 360 to 830 nm, with some visible light in it. Cheap to clone.
#[derive(Debug, Clone, PartialEq)]
pub struct PowerDistribution {
    values: Arc<Grid>,
    xyz: Xyz,
    watts: f64,
}

impl PowerDistribution {
    /// `values` in W/nm at each nm. Errors: a value that is negative or not finite; no luminous power.
    pub fn new(values: Grid) -> Result<Self, String> {
        if let Some(i) = values.iter().position(|value| !(*value >= 0.0 && value.is_finite())) {
            return Err(format!("the power at {} nm is {}", FIRST_NM + i, values[i]));
        }
        let (xyz, watts) = (colour::xyz(&values), integral(&values));
        // A line at an end of the range has half of its bin inside: then it is the sum that counts.
        let watts = if watts > 0.0 { watts } else { values.iter().sum() };
        if !(xyz[1] > 0.0 && xyz.iter().all(|x| x.is_finite()) && (1.0 / xyz[1]).is_finite()) {
            return Err("the spectrum has no visible light".into());
        }
        Ok(PowerDistribution { values: Arc::new(values), xyz, watts })
    }

    /// Power at `nm`, W/nm: linear between the nm, 0 outside 360–830 nm.
    #[inline]
    pub fn at(&self, nm: f64) -> f64 {
        lookup(&self.values, nm)
    }
    /// The values at 360, 361, …, 830 nm, W/nm.
    pub fn values(&self) -> &Grid {
        &self.values
    }
    /// The same light in W/nm per lumen: 683 Σ S V = 1.
    pub fn luminous_normalised(&self) -> PowerDistribution {
        let lumens = self.lumens();
        PowerDistribution {
            values: Arc::new(self.values.map(|value| value / lumens)),
            xyz: self.xyz_per_lumen(),
            watts: self.watts / lumens,
        }
    }
    /// Luminous flux, lm: 683 Σ S V.
    pub fn lumens(&self) -> f64 {
        self.xyz[1]
    }
    /// Radiant flux from 360 to 830 nm, W (trapezoidal rule).
    pub fn watts(&self) -> f64 {
        self.watts
    }
    /// Luminous efficacy of the radiation from 360 to 830 nm, lm/W.
    pub fn lumens_per_watt(&self) -> f64 {
        self.lumens() / self.watts
    }
    /// XYZ of one lumen: Y = 1.
    pub fn xyz_per_lumen(&self) -> Xyz {
        self.xyz.map(|x| x / self.lumens())
    }
    /// Linear Rec.709 of one lumen: luminance 1. Components below 0 are colours out of its gamut.
    pub fn rec709_per_lumen(&self) -> [f64; 3] {
        apply(&XYZ_TO_REC709, self.xyz_per_lumen())
    }
    /// Chromaticity (x, y) of CIE 1931.
    pub fn xy(&self) -> [f64; 2] {
        let [x, y, z] = self.xyz_per_lumen();
        [x / (x + y + z), y / (x + y + z)]
    }
    /// 683 lm/W at most.
    pub const MOST_LUMENS_PER_WATT: f64 = K_M;
}

#[cfg(test)]
mod tests;
