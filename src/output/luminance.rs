//! Luminance of a frame's pixels, cd/m², whatever colour space it is stored in.

use crate::base::colour::ColourSpace;
use crate::film::frame::Frame;
use crate::output::exr::{COLOR_INTEROP_ID, WHITE_LUMINANCE};

/// How the three channels of a frame's pictures become a luminance and a colour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Luminance {
    pub space: ColourSpace,
    /// cd/m² of the value (1, 1, 1): 1 in our own frames.
    pub white_cd_m2: f64,
}

impl Luminance {
    /// As the frame's header says.
    pub fn in_frame(frame: &Frame) -> Luminance {
        let space = ColourSpace::from_interop_id(frame.text(COLOR_INTEROP_ID));
        let white = frame.number(WHITE_LUMINANCE).filter(|white| *white > 0.0 && white.is_finite());
        Luminance { space, white_cd_m2: white.unwrap_or(1.0) }
    }

    /// cd/m² of one pixel's three values.
    pub fn of(&self, colour: [f64; 3]) -> f64 {
        self.white_cd_m2 * self.space.luminance(colour)
    }

    /// cd/m² of all pixels.
    pub fn image(&self, channels: [&[f32]; 3]) -> Vec<f64> {
        let [r, g, b] = channels;
        // One channel shown three times is a luminance already: its three weights add up to 1 but for rounding.
        let grey = std::ptr::eq(r, g);
        let pixels = r.iter().zip(g).zip(b);
        pixels
            .map(|((r, g), b)| {
                let colour = [f64::from(*r), f64::from(*g), f64::from(*b)];
                if grey { self.white_cd_m2 * colour[0] } else { self.of(colour) }
            })
            .collect()
    }
}

/// The luminance of a layer (the empty name is the default image), cd/m², row by row; none if there is no such picture.
pub fn layer_luminance(frame: &Frame, layer: &str) -> Option<Vec<f64>> {
    frame.rgb(layer).map(|channels| Luminance::in_frame(frame).image(channels))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::frame::Meta;

    #[test]
    fn luminance_in_every_space() {
        for space in ColourSpace::ALL {
            let colour = space.from_rec709([0.5, 0.25, 2.0]);
            let mut frame = Frame::new(1, 1);
            for (name, value) in ["R", "G", "B"].iter().zip(colour) {
                frame.push(*name, vec![value as f32]);
            }
            frame.push("stderr.Y", vec![3.0]);
            frame.meta.insert(COLOR_INTEROP_ID.into(), Meta::Text(space.interop_id().into()));
            let want = 0.5 * 0.212_639_005_9 + 0.25 * 0.715_168_678_8 + 2.0 * 0.072_192_315_4;
            let got = layer_luminance(&frame, "").unwrap()[0];
            assert!((got / want - 1.0).abs() < 1e-6, "{space:?}: {got} {want}");
            assert_eq!(layer_luminance(&frame, "stderr"), Some(vec![3.0]));
            frame.meta.insert(WHITE_LUMINANCE.into(), Meta::Number(80.0));
            assert!((layer_luminance(&frame, "").unwrap()[0] / want / 80.0 - 1.0).abs() < 1e-6);
        }
    }
}
