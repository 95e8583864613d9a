//! Two frames compared value by value, without statistics: relations that hold to rounding.

use super::header;
use super::names::{belongs, common, is_data, is_light};
use eyebox_base::error::{Error, Result, Where};
use eyebox_film::frame::Frame;
use eyebox_film::names::is_error;

/// The value of a layer at which A and B differ most.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Deviation {
    /// Empty for the default image.
    pub layer: String,
    /// Largest value of the layer in A and B, without sign.
    pub peak: f64,
    pub channel: String,
    pub x: usize,
    pub y: usize,
    pub a: f64,
    pub b: f64,
    /// |B − A| over the peak; infinite where one of both is no number.
    pub relative: f64,
    pub different: bool,
}

/// The comparison of two frames.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Deviations {
    pub different: bool,
    pub tolerance: f64,
    /// Why the frames cannot be compared at all; then nothing below was compared.
    pub incomparable: Vec<String>,
    /// Layers that only one has, with whose it is.
    pub only_in: Vec<(String, char)>,
    pub layers: Vec<Deviation>,
}

/// Compares every value of every layer but the errors: none may differ by more than `tolerance` times the layer's peak.
/// A share of light that only one frame has is black in the other.
pub fn within(a: &Frame, b: &Frame, tolerance: f64) -> Deviations {
    let incomparable = header::incomparable(a, b);
    if !incomparable.is_empty() {
        return Deviations { different: true, tolerance, incomparable, only_in: Vec::new(), layers: Vec::new() };
    }
    let (names, only_in) = common(a, b);
    let layers: Vec<Deviation> = names.iter().map(|name| deviation(a, b, name, tolerance)).collect();
    let different = !only_in.is_empty() || layers.iter().any(|layer| layer.different);
    Deviations { different, tolerance, incomparable, only_in, layers }
}

fn deviation(a: &Frame, b: &Frame, name: &str, tolerance: f64) -> Deviation {
    let mut found = Deviation {
        layer: name.to_owned(),
        peak: 0.0,
        channel: String::new(),
        x: 0,
        y: 0,
        a: 0.0,
        b: 0.0,
        relative: 0.0,
        different: false,
    };
    let mut channels: Vec<&str> = Vec::new();
    for channel in a.channels.iter().chain(&b.channels).filter(|channel| belongs(channel, name)) {
        // Depth is 1e10 m where nothing is hit: that is no range.
        let usual = channel.data.iter().map(|v| f64::from(v.abs())).filter(|v| *v < 1e10);
        found.peak = usual.fold(found.peak, f64::max);
        if !channels.contains(&channel.name.as_str()) {
            channels.push(&channel.name);
        }
    }
    let mut most = 0.0;
    for channel in channels {
        let stored = [a, b].map(|frame| frame.get(channel).map_or(&[][..], |channel| channel.data.as_slice()));
        for pixel in 0..a.width * a.height {
            let [one, other] = stored.map(|data| data.get(pixel).copied().unwrap_or(0.0));
            let off = if one.to_bits() == other.to_bits() {
                0.0
            } else if one.is_finite() && other.is_finite() {
                (f64::from(other) - f64::from(one)).abs()
            } else {
                f64::INFINITY
            };
            if off > most {
                most = off;
                (found.x, found.y) = (pixel % a.width, pixel / a.width);
                (found.a, found.b) = (f64::from(one), f64::from(other));
                channel.clone_into(&mut found.channel);
            }
        }
    }
    found.relative = if most == 0.0 { 0.0 } else { most / found.peak };
    found.different = found.relative.is_nan() || found.relative > tolerance;
    found
}

/// The sum of multiples of frames, one weight each: their light, summed as f64. A share that a frame has not is black in it.
/// Data layers and header come from the first; standard errors are left out.
///
/// Faults: no frame, another number of weights, weights that are not finite, frames that cannot be compared.
pub fn weighted_sum(frames: &[Frame], weights: &[f64]) -> Result<Frame> {
    let at = || Where::Option("--weights".to_owned());
    let Some(first) = frames.first().filter(|_| frames.len() == weights.len()) else {
        let what = format!("{} weights for {} frames", weights.len(), frames.len());
        return Err(Error::new(at(), what).expected("one for each frame after the first"));
    };
    if let Some(bad) = weights.iter().find(|weight| !weight.is_finite()) {
        return Err(Error::new(at(), format!("{bad} is no weight")).expected("a finite number"));
    }
    for (number, frame) in frames.iter().enumerate().skip(1) {
        if let Some(why) = header::incomparable(first, frame).into_iter().next() {
            return Err(Error::new(at(), format!("frame {} cannot be added to the first: {why}", number + 1)));
        }
    }
    let mut out = Frame::new(first.width, first.height);
    out.meta.clone_from(&first.meta);
    for channel in frames.iter().flat_map(|frame| &frame.channels) {
        let name = channel.layer();
        if out.get(&channel.name).is_some() || is_error(name) {
            continue;
        }
        // `Z` stands beside the default image without a layer of its own.
        let picture = match name {
            "" => ["R", "G", "B", "Y"].contains(&channel.name.as_str()),
            _ => is_light(name) || !is_data(name) && first.rgb(name).is_some(),
        };
        if !picture {
            // Those of the first only.
            out.channels.extend(first.get(&channel.name).cloned());
            continue;
        }
        let mut sum = vec![0.0; channel.data.len()];
        for (frame, weight) in frames.iter().zip(weights) {
            let data = frame.get(&channel.name).map_or(&[][..], |channel| &channel.data);
            sum.iter_mut().zip(data).for_each(|(sum, value)| *sum += weight * f64::from(*value));
        }
        out.push(channel.name.clone(), sum.into_iter().map(|value| value as f32).collect());
    }
    Ok(out)
}
