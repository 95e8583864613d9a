//! The modulation transfer function from a slanted edge, after ISO 12233:2017, annex D (edge-based spatial frequency
//! response): line by line the place of the edge, a straight line through them, all pixels by their distance to it in
//! quarter pixels, the derivative, its Fourier transform.

use std::f64::consts::{PI, TAU};

/// Bins per pixel.
const OVERSAMPLING: usize = 4;
/// Passes of finding the edge: the window of the second is centred by the first.
const PASSES: usize = 2;
/// Steps of frequency up to one cycle per pixel.
const STEPS: usize = 100;

/// The response along the normal of the edge.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    /// (cycles per pixel along the normal, modulation).
    pub curve: Vec<(f64, f64)>,
    /// Angle of the edge against the lines or columns of pixels, degrees.
    pub slant_deg: f64,
}

impl Response {
    /// The first frequency, cycles per pixel, at which the modulation has fallen to `level`.
    pub fn falls_to(&self, level: f64) -> Option<f64> {
        self.curve.windows(2).find_map(|pair| match pair {
            [(f0, m0), (f1, m1)] if *m0 >= level && *m1 < level => Some(f0 + (f1 - f0) * (m0 - level) / (m0 - m1)),
            _ => None,
        })
    }

    /// The modulation at a frequency, cycles per pixel.
    pub fn at(&self, frequency: f64) -> Option<f64> {
        self.curve.windows(2).find_map(|pair| match pair {
            [(f0, m0), (f1, m1)] if (*f0..=*f1).contains(&frequency) => {
                Some(m0 + (m1 - m0) * (frequency - f0) / (f1 - f0))
            }
            _ => None,
        })
    }
}

/// A piece of a picture, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    pub width: usize,
    pub height: usize,
    pub values: Vec<f64>,
}

/// The response of the one edge in a region, or why there is none.
pub fn response(region: &Region) -> Result<Response, &'static str> {
    if region.width < 8 || region.height < 8 || region.values.len() != region.width * region.height {
        return Err("an edge needs at least 8 × 8 pixels");
    }
    // The edge runs along the columns if the picture changes more across them.
    let along_columns = change(region) >= change(&transposed(region));
    let turned = if along_columns { region.clone() } else { transposed(region) };
    let (places, slope) = line(&turned)?;
    if slope.abs() * (turned.height as f64) < 1.0 {
        return Err("the edge does not cross a column of pixels: it is not slanted");
    }
    if slope.abs() > 1.0 {
        return Err("the edge is not straight enough");
    }
    let spread = edge_spread(&turned, places, slope)?;
    let curve = transform(&spread, slope)?;
    Ok(Response { curve, slant_deg: slope.atan().to_degrees() })
}

/// Sum of the absolute differences between neighbouring columns.
fn change(region: &Region) -> f64 {
    region.values.chunks_exact(region.width).flat_map(|row| row.windows(2)).map(|pair| (pair[1] - pair[0]).abs()).sum()
}

fn transposed(region: &Region) -> Region {
    let (width, height) = (region.height, region.width);
    let values = (0..width * height).map(|i| region.values[(i % width) * region.width + i / width]).collect();
    Region { width, height, values }
}

/// Where the edge is in the first row, and how far it moves per row, pixels.
fn line(region: &Region) -> Result<(f64, f64), &'static str> {
    let width = region.width as f64;
    let mut guess: Option<(f64, f64)> = None;
    for _ in 0..PASSES {
        let mut points = Vec::new();
        for (y, row) in region.values.chunks_exact(region.width).enumerate() {
            let middle = guess.map_or(width / 2.0, |(at, slope)| at + slope * y as f64);
            let (mut sum, mut moment) = (0.0, 0.0);
            for (x, pair) in row.windows(2).enumerate() {
                // The difference stands between two pixels' centres.
                let place = x as f64 + 1.0;
                let weighted = (pair[1] - pair[0]) * hamming(place - middle, width);
                sum += weighted;
                moment += weighted * place;
            }
            let place = moment / sum;
            if sum != 0.0 && (0.0..=width).contains(&place) {
                points.push((y as f64, place));
            }
        }
        if points.len() < region.height / 2 {
            return Err("no edge was found in most of the rows");
        }
        guess = Some(fit(&points).ok_or("no edge was found")?);
    }
    guess.ok_or("no edge was found")
}

/// 1 in the middle, 0.08 at half a width from it, and on.
fn hamming(offset: f64, width: f64) -> f64 {
    0.54 + 0.46 * (TAU * (offset / width).clamp(-0.5, 0.5)).cos()
}

/// The straight line of least squares: its value at 0 and its slope.
fn fit(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    let count = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |(x, y), point| (x + point.0 / count, y + point.1 / count));
    let (mut xx, mut xy) = (0.0, 0.0);
    for point in points {
        xx += (point.0 - x).powi(2);
        xy += (point.0 - x) * (point.1 - y);
    }
    let slope = xy / xx;
    slope.is_finite().then_some((y - slope * x, slope))
}

/// Means of pixels by their distance to the edge along the row, in quarter pixels.
fn edge_spread(region: &Region, first: f64, slope: f64) -> Result<Vec<f64>, &'static str> {
    let reach = region.width / 2;
    let bins = 2 * reach * OVERSAMPLING;
    let (mut sums, mut counts) = (vec![0.0; bins], vec![0u32; bins]);
    for (index, value) in region.values.iter().enumerate() {
        let (x, y) = (index % region.width, index / region.width);
        let distance = x as f64 + 0.5 - (first + slope * y as f64);
        let bin = ((distance + reach as f64) * OVERSAMPLING as f64).floor();
        if bin >= 0.0 && (bin as usize) < bins {
            sums[bin as usize] += value;
            counts[bin as usize] += 1;
        }
    }
    // A bin that no pixel falls into takes the mean of its neighbours; the ends that the edge's drift leaves out are cut.
    let from = counts.iter().position(|count| *count > 0).ok_or("no edge was found")?;
    let to = counts.iter().rposition(|count| *count > 0).map_or(from, |last| last + 1);
    let means: Vec<Option<f64>> =
        (from..to).map(|bin| (counts[bin] > 0).then(|| sums[bin] / f64::from(counts[bin]))).collect();
    let mut spread = Vec::with_capacity(means.len());
    for (bin, mean) in means.iter().enumerate() {
        let filled = mean.or_else(|| {
            let before = means[..bin].iter().rev().flatten().next();
            let after = means[bin..].iter().flatten().next();
            before.zip(after).map(|(a, b)| 0.5 * (a + b))
        });
        spread.push(filled.ok_or("the edge is too short for its slant")?);
    }
    Ok(spread)
}

/// The transform of the derivative, 1 at frequency 0.
fn transform(spread: &[f64], slope: f64) -> Result<Vec<(f64, f64)>, &'static str> {
    let line: Vec<f64> = spread.windows(3).map(|three| 0.5 * (three[2] - three[0])).collect();
    let (mut sum, mut moment) = (0.0, 0.0);
    for (bin, value) in line.iter().enumerate() {
        sum += value.abs();
        moment += value.abs() * bin as f64;
    }
    let middle = moment / sum;
    if !middle.is_finite() {
        return Err("there is no edge: all is the same");
    }
    let width = line.len() as f64;
    let windowed: Vec<f64> = line.iter().enumerate().map(|(b, v)| v * hamming(b as f64 - middle, width)).collect();
    let modulation = |per_bin: f64| {
        let (mut re, mut im) = (0.0, 0.0);
        for (bin, value) in windowed.iter().enumerate() {
            let (sin, cos) = (TAU * per_bin * bin as f64).sin_cos();
            re += value * cos;
            im += value * sin;
        }
        re.hypot(im)
    };
    let whole = modulation(0.0);
    if whole.is_nan() || whole <= 0.0 {
        return Err("there is no edge: all is the same");
    }
    // Distances along the row are longer than across the edge by 1/cos of its angle.
    let cosine = 1.0 / (1.0 + slope * slope).sqrt();
    let curve = (0..=STEPS).map(|step| {
        let per_pixel = step as f64 / STEPS as f64;
        let per_bin = per_pixel / OVERSAMPLING as f64;
        // What the difference over two bins and the mean over one take away.
        let sinc = |x: f64| if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) };
        let taken = sinc(2.0 * per_bin) * sinc(per_bin);
        (per_pixel / cosine, modulation(per_bin) / whole / taken)
    });
    Ok(curve.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distribution function of the normal distribution.
    fn step(x: f64) -> f64 {
        1.0 - eyebox_base::stats::normal_tail(x)
    }

    fn edge(width: usize, height: usize, slope: f64, sigma: f64, upright: bool) -> Region {
        let cosine = 1.0 / (1.0 + slope * slope).sqrt();
        let value = |x: f64, y: f64| {
            let along = x - (width as f64 / 2.0 + slope * (y - height as f64 / 2.0));
            10.0 + 90.0 * step(along * cosine / sigma)
        };
        let at = |i: usize| value((i % width) as f64 + 0.5, (i / width) as f64 + 0.5);
        let region = Region { width, height, values: (0..width * height).map(at).collect() };
        if upright { region } else { transposed(&region) }
    }

    /// A Gaussian of σ pixels has the transfer function exp(−2π²σ²f²).
    #[test]
    fn a_gaussian_blur_in_closed_form() {
        for (sigma, slope, upright) in [(0.8, 0.087, true), (1.5, -0.1, true), (1.0, 0.2, false), (2.0, 0.05, false)] {
            let found = response(&edge(60, 80, slope, sigma, upright)).unwrap();
            let half = (2f64.ln() / 2.0).sqrt() / (PI * sigma);
            let got = found.falls_to(0.5).unwrap();
            assert!((got / half - 1.0).abs() < 0.02, "σ {sigma}, slope {slope}: MTF50 {got}, closed form {half}");
            for frequency in [0.05, 0.1, 0.2] {
                let want = (-2.0 * (PI * sigma * frequency).powi(2)).exp();
                let got = found.at(frequency).unwrap();
                assert!((got - want).abs() < 0.02, "σ {sigma}, slope {slope} at {frequency}: {got} {want}");
            }
            assert!((found.slant_deg.abs() - slope.abs().atan().to_degrees()).abs() < 0.1, "{}", found.slant_deg);
        }
    }

    #[test]
    fn what_is_no_slanted_edge_is_said() {
        assert!(response(&edge(60, 40, 0.0, 1.0, true)).unwrap_err().contains("not slanted"));
        let flat = Region { width: 20, height: 20, values: vec![1.0; 400] };
        assert!(response(&flat).is_err());
        assert!(response(&Region { width: 4, height: 4, values: vec![0.0; 16] }).unwrap_err().contains("8 × 8"));
        assert!(response(&Region { width: 20, height: 20, values: vec![f64::NAN; 400] }).is_err());
    }
}
