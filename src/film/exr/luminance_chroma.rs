//! Luminance and chroma become red, green and blue: RY = (R − Y)/Y, BY = (B − Y)/Y, Y by the primaries of the file (OpenEXR,
//! technical introduction, "Luminance/chroma images").

use crate::frame::{Frame, split_name};
use eyebox_base::colour::{Chromaticities, REC709};
use glam::{DMat3, DVec3};

/// In every layer that has all three.
pub(super) fn to_rgb(frame: &mut Frame, chromaticities: Option<&Chromaticities>) {
    let layers: Vec<String> = frame.layer_names().into_iter().map(str::to_owned).collect();
    for layer in layers {
        let find = |component: &str| {
            frame.channels.iter().position(|channel| split_name(&channel.name) == (layer.as_str(), component))
        };
        let (Some(y), Some(ry), Some(by)) = (find("Y"), find("RY"), find("BY")) else { continue };
        let Some([r, g, b]) = luminances(chromaticities.unwrap_or(&REC709)) else { continue };
        for pixel in 0..frame.width * frame.height {
            let value = |index: usize| {
                let channel = frame.channels.get(index);
                channel.and_then(|channel| channel.data.get(pixel)).copied().map_or(0.0, f64::from)
            };
            let (luminance, red, blue) = (value(y), value(ry), value(by));
            let (red, blue) = ((red + 1.0) * luminance, (blue + 1.0) * luminance);
            let green = (luminance - red * r - blue * b) / g;
            for (index, value) in [(ry, red), (y, green), (by, blue)] {
                if let Some(to) = frame.channels.get_mut(index).and_then(|channel| channel.data.get_mut(pixel)) {
                    *to = value as f32;
                }
            }
        }
        for (index, component) in [(ry, "R"), (y, "G"), (by, "B")] {
            if let Some(channel) = frame.channels.get_mut(index) {
                channel.name = if layer.is_empty() { component.to_owned() } else { format!("{layer}.{component}") };
            }
        }
    }
}

/// What each primary has of the luminance of white; none if they span no colours.
fn luminances([red, green, blue, white]: &Chromaticities) -> Option<[f64; 3]> {
    let xyz = |[x, y]: [f64; 2]| DVec3::new(x / y, 1.0, (1.0 - x - y) / y);
    let primaries = DMat3::from_cols(xyz(*red), xyz(*green), xyz(*blue));
    let shares = (primaries.inverse() * xyz(*white)).to_array();
    shares.iter().all(|share| share.is_finite() && *share != 0.0).then_some(shares)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// IEC 61966-2-1: Y = 0.2126 R + 0.7152 G + 0.0722 B.
    #[test]
    fn primaries_have_their_luminances() {
        let found = luminances(&REC709).unwrap();
        for (found, want) in found.iter().zip([0.2126, 0.7152, 0.0722]) {
            assert!((found - want).abs() < 1e-4, "{found} for {want}");
        }
    }
}
