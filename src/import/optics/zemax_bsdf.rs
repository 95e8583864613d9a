//! Measured scattering as Zemax' text files have it: a header of words and lists of angles, then per angle of incidence its
//! total and, per azimuth, the values along the radial angles. Radial angles are those to the specular direction (straight on
//! for what is transmitted), azimuths run about it, 0 being the side of the normal. (Format: Zemax, "BSDF Data Interchange file
//! format specification"; on which side 0 lies is told by measurements of an imaging sphere, whose zeros, below the horizon, are at
//! 180: `ansys/optical-automation`, `test_13_planesymmetric_btdf_zemax.bsdf`.)
//!
//! What is measured is read between its own angles, where a lobe keeps its place, and put on the grid of a
//! [`Measurement`], whose angles are those to the normal.

use eyebox_base::Where;
use eyebox_base::error::{Error, Result};
use eyebox_scene::scatter_table::{Measurement, mix, place};
use std::f64::consts::{FRAC_PI_2, PI};
use std::path::Path;

/// Steps of the grid to the right angle, alike for all files, so that one of each side make one table: the finest that fits.
const STEPS: usize = 90;

/// A file's measurement.
pub struct ZemaxBsdf {
    /// 0 reflected, 1 transmitted.
    pub side: usize,
    pub measurement: Measurement,
    /// Angles of incidence in degrees, and what the file says is scattered of light there.
    pub totals: Vec<[f64; 2]>,
}

/// Whether these are the bytes of such a file: its first words are `Source`.
pub fn is_zemax(text: &str) -> bool {
    let first = text.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with('#'));
    first.and_then(|line| line.split_whitespace().next()).is_some_and(|word| word.eq_ignore_ascii_case("Source"))
}

/// Reads a file's text.
///
/// # Errors
/// By its line: words and numbers that are not those of the format, colours, samples that are measured at several rotations.
pub fn read(text: &str, file: &Path) -> Result<ZemaxBsdf> {
    let mut lines = Lines { all: text.lines().enumerate(), file, last: 0 };
    let (mut side, mut mirrored) = (None, true);
    let [mut rotations, mut incidence, mut azimuth, mut radial] = [(); 4].map(|()| Vec::new());
    loop {
        let line = lines.next("the word DataBegin")?;
        let mut words = line.split_whitespace();
        let (word, value) = (words.next().unwrap_or(""), words.next().unwrap_or(""));
        match word.to_ascii_lowercase().as_str() {
            "source" | "monochrome" => {}
            "symmetry" => match value.to_ascii_lowercase().as_str() {
                "planesymmetrical" => {}
                "asymmetrical" | "asymmetrical4d" => mirrored = false,
                _ => {
                    return Err(lines
                        .fault(format!("symmetry `{value}`"))
                        .expected("PlaneSymmetrical or Asymmetrical"));
                }
            },
            "spectralcontent" => {
                if !value.eq_ignore_ascii_case("Monochrome") {
                    return Err(lines.fault(format!("spectral content `{value}` is not read")).expected("Monochrome"));
                }
            }
            "scattertype" => match value.to_ascii_uppercase().as_str() {
                "BRDF" => side = Some(0),
                "BTDF" => side = Some(1),
                _ => return Err(lines.fault(format!("scatter type `{value}`")).expected("BRDF or BTDF")),
            },
            "samplerotation" => rotations = lines.angles(value, 360.0)?,
            "angleofincidence" => incidence = lines.angles(value, 90.0)?,
            "scatterazimuth" => azimuth = lines.angles(value, 360.0)?,
            "scatterradial" => radial = lines.angles(value, 180.0)?,
            "databegin" => break,
            _ => {
                return Err(lines
                    .fault(format!("`{line}` is no line of a BSDF file"))
                    .expected("a word of its header"));
            }
        }
    }
    let missing = |what: &str| lines.fault(format!("before the values, {what} is not said"));
    let side = side.ok_or_else(|| missing("ScatterType"))?;
    if rotations.len() > 1 {
        let what = format!(
            "measured at {} rotations of the sample, which scatters differently along and across",
            rotations.len()
        );
        return Err(lines.fault(what).expected("one rotation: a finish scatters alike all round"));
    }
    for (name, angles) in [("AngleOfIncidence", &incidence), ("ScatterAzimuth", &azimuth), ("ScatterRadial", &radial)] {
        if angles.is_empty() {
            return Err(missing(name));
        }
    }
    let mut totals = Vec::with_capacity(incidence.len());
    let mut values = Vec::new();
    for _ in &incidence {
        let line = lines.next("the word TIS")?;
        let total = line.strip_prefix("TIS").and_then(|rest| rest.trim().parse::<f64>().ok());
        let Some(total) = total.filter(|total| total.is_finite()) else {
            return Err(lines.fault(format!("`{line}` does not begin a block")).expected("TIS and a number"));
        };
        totals.push(total);
        for _ in &azimuth {
            values.extend(lines.numbers(radial.len(), 1e12)?);
        }
    }
    match lines.next("") {
        Ok(line) if line.eq_ignore_ascii_case("DataEnd") => {}
        Ok(line) => {
            let what = format!("`{line}` stands behind the last block that the header tells of");
            return Err(lines.fault(what).expected("DataEnd"));
        }
        // The end of the file.
        Err(_) => {}
    }
    let totals = incidence.iter().zip(totals).map(|(angle, total)| [*angle, total]).collect();
    let mut own = Own { incidence, azimuth, radial, values, mirrored };
    if !mirrored {
        own.close();
    }
    Ok(ZemaxBsdf { side, measurement: own.resampled(), totals })
}

/// The values between the file's own angles, degrees.
struct Own {
    incidence: Vec<f64>,
    azimuth: Vec<f64>,
    radial: Vec<f64>,
    /// 1/sr, `[incidence][azimuth][radial]`.
    values: Vec<f64>,
    /// Azimuths reach to 180, and the other half is alike.
    mirrored: bool,
}

impl Own {
    /// Goes on round the circle: before the first azimuth stands the last one, behind the last the first.
    fn close(&mut self) {
        let (Some(first), Some(last)) = (self.azimuth.first().copied(), self.azimuth.last().copied()) else { return };
        if last - first >= 360.0 {
            return;
        }
        let (count, radial) = (self.azimuth.len(), self.radial.len());
        let rows = |block: &[f64]| -> Vec<f64> {
            let (head, tail) = (&block[..radial], &block[(count - 1) * radial..]);
            [tail, block, head].concat()
        };
        self.values = self.values.chunks_exact(count * radial).flat_map(rows).collect();
        self.azimuth.insert(0, last - 360.0);
        self.azimuth.push(first + 360.0);
    }

    /// At angles of incidence and of leaving and the azimuth between them (0 onwards), rad: of a sample that scatters alike
    /// on both sides of the plane of incidence, the mean of both.
    fn at(&self, theta_in: f64, theta_out: f64, phi: f64) -> f64 {
        let (sin, cos) = theta_in.sin_cos();
        let (x, y) = (theta_out.sin() * phi.cos(), theta_out.sin() * phi.sin());
        let z = theta_out.cos();
        let radial = (sin * x + cos * z).clamp(-1.0, 1.0).acos().to_degrees();
        let azimuth = y.atan2(sin * z - cos * x).to_degrees();
        let at = |azimuth: f64| {
            let azimuth = if self.mirrored { azimuth } else { azimuth.rem_euclid(360.0) };
            // Constant beyond the ends.
            let places = [
                place(&self.incidence, theta_in.to_degrees()),
                place(&self.azimuth, azimuth),
                place(&self.radial, radial),
            ];
            self.between(places)
        };
        if self.mirrored { at(azimuth.abs()) } else { 0.5 * (at(azimuth) + at(-azimuth)) }
    }

    /// Linear in all three; constant beyond the angles.
    fn between(&self, [i, a, r]: [(usize, f64); 3]) -> f64 {
        let value = |i: usize, a: usize, r: usize| {
            let at = (i * self.azimuth.len() + a) * self.radial.len() + r;
            self.values.get(at).copied().unwrap_or(0.0)
        };
        mix(i, |i| mix(a, |a| mix(r, |r| value(i, a, r))))
    }

    /// On a grid of the angles to the normal.
    fn resampled(&self) -> Measurement {
        let steps =
            |count: usize, end: f64| -> Vec<f64> { (0..=count).map(|i| end * i as f64 / count as f64).collect() };
        let (theta, phi) = (steps(STEPS, FRAC_PI_2), steps(2 * STEPS, PI));
        let mut values = Vec::with_capacity(theta.len() * theta.len() * phi.len());
        for i in &theta {
            for o in &theta {
                values.extend(phi.iter().map(|p| self.at(*i, *o, *p)));
            }
        }
        Measurement { theta_in: theta.clone(), theta_out: theta, phi, values }
    }
}

/// The lines that say something.
struct Lines<'t> {
    all: std::iter::Enumerate<std::str::Lines<'t>>,
    file: &'t Path,
    last: usize,
}

impl<'t> Lines<'t> {
    fn fault(&self, what: String) -> Box<Error> {
        Error::new(Where::Line { file: self.file.to_owned(), line: self.last }, what)
    }

    fn next(&mut self, expected: &str) -> Result<&'t str> {
        for (index, line) in self.all.by_ref() {
            self.last = index + 1;
            let line = line.trim();
            if !line.is_empty() && !line.starts_with('#') {
                return Ok(line);
            }
        }
        Err(self.fault("the file ends here".to_owned()).expected(expected))
    }

    fn numbers(&mut self, count: usize, most: f64) -> Result<Vec<f64>> {
        let line = self.next(&format!("{count} numbers"))?;
        let all: Vec<f64> = line.split_whitespace().map_while(|word| word.parse().ok()).collect();
        let wrong = all.iter().find(|x| !(0.0..=most).contains(*x));
        if let Some(x) = wrong {
            return Err(self.fault(format!("{x} is out of range")).expected(format!("numbers from 0 to {most}")));
        }
        if all.len() != count || line.split_whitespace().count() != count {
            let found = line.split_whitespace().count();
            return Err(self
                .fault(format!("{found} values where there are to be {count}"))
                .expected(format!("{count} numbers")));
        }
        Ok(all)
    }

    /// A list of rising angles, of which the line before has said how many there are.
    fn angles(&mut self, count: &str, most: f64) -> Result<Vec<f64>> {
        // More would not fit any table.
        const MOST: usize = 4096;
        let count = count.parse().ok().filter(|count| (1..=MOST).contains(count));
        let Some(count) = count else {
            return Err(self
                .fault("no number of angles".to_owned())
                .expected(format!("a whole number from 1 to {MOST}")));
        };
        let all = self.numbers(count, most)?;
        if all.windows(2).any(|pair| pair[0] >= pair[1]) {
            return Err(self.fault("the angles do not rise".to_owned()).expected("each larger than the one before"));
        }
        Ok(all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A lobe about the specular direction, as a file: value 0.2 exp(−(radial/20°)²), of azimuth 0 to 180.
    fn lobe(kind: &str, symmetry: &str, azimuths: &[f64]) -> String {
        let list = |all: &[f64]| all.iter().map(f64::to_string).collect::<Vec<_>>().join("\t");
        let radial: Vec<f64> = (0..=60).map(|i| 2.0 * f64::from(i)).collect();
        let incidence = [0.0, 30.0, 60.0];
        let mut out = format!(
            "# by hand\nSource  Measured\nSymmetry  {symmetry}\nSpectralContent  Monochrome\nScatterType  {kind}\nSampleRotation  1\n0\n\
             AngleOfIncidence  3\n{}\nScatterAzimuth {}\n{}\nScatterRadial {}\n{}\n\nMonochrome\nDataBegin\n",
            list(&incidence),
            azimuths.len(),
            list(azimuths),
            radial.len(),
            list(&radial)
        );
        for _ in incidence {
            out.push_str("TIS 0.1\n");
            for azimuth in azimuths {
                // A tenth more on the side of the normal.
                let more = 1.0 + 0.1 * azimuth.to_radians().cos();
                let row: Vec<f64> = radial.iter().map(|r| 0.2 * more * (-(r / 20.0) * (r / 20.0)).exp()).collect();
                out.push_str(&list(&row));
                out.push('\n');
            }
        }
        out + "DataEnd\n"
    }

    #[test]
    fn lobes_lie_about_the_specular_direction() {
        let half: Vec<f64> = (0..=18).map(|i| 10.0 * f64::from(i)).collect();
        // A circle may leave its end to its beginning.
        let whole: Vec<f64> = (0..36).map(|i| 10.0 * f64::from(i)).collect();
        for (kind, side, text) in
            [("BTDF", 1, lobe("BTDF", "PlaneSymmetrical", &half)), ("BRDF", 0, lobe("BRDF", "Asymmetrical", &whole))]
        {
            assert!(is_zemax(&text));
            let found = read(&text, Path::new("a.bsdf")).unwrap();
            assert_eq!(found.side, side, "{kind}");
            let m = &found.measurement;
            let at = |i: f64, o: f64, phi: f64| {
                let index = |all: &[f64], x: f64| {
                    all.iter().position(|a| (a - x.to_radians()).abs() < 1e-9).expect("on the grid")
                };
                m.values[(index(&m.theta_in, i) * m.theta_out.len() + index(&m.theta_out, o)) * m.phi.len()
                    + index(&m.phi, phi)]
            };
            let value = |radial: f64, more: f64| 0.2 * more * (-(radial / 20.0) * (radial / 20.0)).exp();
            // Towards the normal, away from it, and at a right angle to the plane of incidence.
            for (i, o, phi, want) in [
                (30.0, 30.0, 0.0, value(0.0, 1.1)),
                (30.0, 10.0, 0.0, value(20.0, 1.1)),
                (30.0, 50.0, 0.0, value(20.0, 0.9)),
                (60.0, 0.0, 0.0, value(60.0, 1.1)),
            ] {
                let got = at(i, o, phi);
                // At the specular direction itself there is no azimuth: any of them.
                let range = if want == value(0.0, 1.1) { 0.21 } else { 0.005 };
                assert!((got / want - 1.0).abs() < range, "{kind} {i} {o} {phi}: {got} for {want}");
            }
        }
    }

    #[test]
    fn faults_have_their_line() {
        let good = lobe("BTDF", "PlaneSymmetrical", &[0.0, 90.0, 180.0]);
        for (from, to, why) in [
            ("BTDF", "BSDF", "a.bsdf:5: scatter type `BSDF`"),
            ("SpectralContent  Monochrome", "SpectralContent  XYZ", "a.bsdf:4: spectral content `XYZ` is not read"),
            ("SampleRotation  1\n0", "SampleRotation  2\n0 90", "rotations of the sample"),
            ("0\t30\t60", "0\t60\t30", "do not rise"),
            ("0\t90\t180", "0\t90", "2 values where there are to be 3"),
            ("TIS 0.1", "TIS x", "does not begin a block"),
            ("DataBegin", "Data", "`Data` is no line"),
            ("DataEnd", "TIS 0.1", "stands behind the last block"),
        ] {
            let fault = read(&good.replacen(from, to, 1), Path::new("a.bsdf")).err().expect("a fault").to_string();
            assert!(fault.contains(why), "{fault}");
        }
        let cut = &good[..good.len() / 2];
        assert!(read(cut, Path::new("a.bsdf")).is_err());
    }
}
