//! Luminance of a frame's pixels, cd/m², whatever colour space it is stored in.

use crate::exr::WHITE_LUMINANCE;
use eyebox_film::colours::Colours;
use eyebox_film::frame::Frame;

/// How the three channels of a frame's pictures become a luminance and a colour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Luminance {
    pub space: Colours,
    /// cd/m² of the value (1, 1, 1): 1 in our own frames.
    pub white_cd_m2: f64,
}

impl Luminance {
    /// As the frame's header says.
    pub fn in_frame(frame: &Frame) -> Luminance {
        let space = Colours::of(frame);
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
    use crate::exr::COLOR_INTEROP_ID;
    use eyebox_base::colour::ColourSpace;
    use eyebox_film::frame::Meta;

    /// Files of others that name no space but their primaries: AP1, which we write ourselves, and AP0, which we do not. Written
    /// again they are what they were.
    #[test]
    fn primaries_of_foreign_files() {
        use ::exr::prelude::*;
        let colour = [120.0, 300.0, 80.0];
        let primaries = |all: [[f32; 2]; 4]| {
            let [red, green, blue, white] = all.map(|[x, y]| Vec2(x, y));
            attribute::Chromaticities { red, green, blue, white }
        };
        let white = [0.32168, 0.33767];
        let ap1 = primaries([[0.713, 0.293], [0.165, 0.830], [0.128, 0.044], white]);
        let ap0 = primaries([[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.077], white]);
        let read = |own: Option<attribute::Chromaticities>, id: Option<&str>| {
            let [r, g, b] = colour.map(|value| value as f32);
            let mut image = Image::from_channels((1, 1), SpecificChannels::rgb(move |_| (r, g, b)));
            image.attributes.chromaticities = own;
            let named = id.map(|id| (Text::from(COLOR_INTEROP_ID), AttributeValue::Text(Text::from(id))));
            image.layer_data.attributes.other.extend(named);
            let mut bytes = std::io::Cursor::new(Vec::new());
            image.write().to_buffered(&mut bytes).unwrap();
            eyebox_film::exr::decode(&bytes.into_inner()).unwrap()
        };
        let of = |frame: &Frame| layer_luminance(frame, "").unwrap()[0];
        let (by_primaries, by_name) = (read(Some(ap1), None), read(None, Some("lin_ap1_scene")));
        assert_eq!(of(&by_primaries), ColourSpace::AcesCg.luminance(colour));
        assert_eq!(of(&by_name), of(&by_primaries));
        let alike = crate::compare::compare(&by_primaries, &by_name, 3.0);
        assert_eq!(alike.verdict, crate::compare::Verdict::Identical, "{alike:?}");
        let shown = |frame: &Frame| crate::view::render_view(frame, &Default::default()).unwrap().0;
        assert_eq!(shown(&by_primaries), shown(&by_name));
        let (by_primaries, by_name) = (read(Some(ap0), None), read(None, Some("lin_ap0_scene")));
        assert_eq!(of(&by_primaries), of(&by_name));
        assert!((of(&by_primaries) / ColourSpace::Rec709.luminance(colour) - 1.0).abs() > 0.01);
        let folder = tempfile::tempdir().unwrap();
        for frame in [&by_primaries, &by_name] {
            let path = folder.path().join("again.exr");
            crate::exr::write_exr(&path, frame).unwrap();
            let again = crate::exr::read_exr(&path).unwrap();
            assert_eq!((of(&again), again.text(COLOR_INTEROP_ID)), (of(frame), frame.text(COLOR_INTEROP_ID)));
        }
    }

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
