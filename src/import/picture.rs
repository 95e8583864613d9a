//! Pictures that a scene is made of: slides (PNG) and panoramas (OpenEXR, Radiance HDR), as luminance and as colour.

use crate::base::fault::Result;
use crate::base::{Fault, Where};
use std::io::Cursor;
use std::path::Path;

/// Pixels, row-major from the top left.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    pub width: usize,
    pub height: usize,
    /// Luminance.
    pub pixels: Vec<f32>,
    /// Linear Rec.709, each component >= 0, if some pixel is not grey; `pixels` is its luminance.
    pub rgb: Option<Vec<[f32; 3]>>,
    /// How many pixels have a component below 0: it became 0 and the others were scaled to keep the luminance.
    pub clipped: usize,
}

/// Luminance of linear Rec.709.
fn luminance(rgb: [f32; 3]) -> f32 {
    crate::base::units::luminance(rgb.map(f64::from)) as f32
}

impl Picture {
    fn grey(width: usize, height: usize, pixels: Vec<f32>) -> Self {
        Picture { width, height, pixels, rgb: None, clipped: 0 }
    }

    fn coloured(width: usize, height: usize, mut rgb: Vec<[f32; 3]>) -> Self {
        let pixels: Vec<f32> = rgb.iter().map(|pixel| luminance(*pixel)).collect();
        let mut clipped = 0;
        for (pixel, own) in rgb.iter_mut().zip(&pixels).filter(|(pixel, _)| pixel.iter().any(|c| *c < 0.0)) {
            clipped += 1;
            let inside = pixel.map(|c| c.max(0.0));
            let whole = luminance(inside);
            *pixel = if whole > 0.0 { inside.map(|c| c * (own / whole)) } else { [0.0; 3] };
        }
        let colour = rgb.iter().any(|[r, g, b]| r != g || g != b);
        Picture { width, height, pixels, rgb: colour.then_some(rgb), clipped }
    }
}

/// More pixels than this are a broken header, not a picture.
const MAX_PIXELS: usize = 1 << 28;

fn broken(path: &Path, at: &Where, why: impl std::fmt::Display) -> Box<Fault> {
    Fault::new(at.clone(), format!("can't read the picture {}: {why}", path.display()))
}

/// A slide: grey PNG of 8 or 16 bits, value/max, values taken as linear; colours as their luminance.
pub fn slide(bytes: &[u8], path: &Path, at: &Where) -> Result<Picture> {
    let reader = image::ImageReader::with_format(Cursor::new(bytes), image::ImageFormat::Png);
    let decoded = reader.decode().map_err(|error| broken(path, at, error).expected("a PNG of 8 or 16 bits"))?;
    if decoded.color().has_alpha() {
        return Err(broken(path, at, "it has an alpha channel").expected("a grey PNG of 8 or 16 bits"));
    }
    let (width, height) = (decoded.width() as usize, decoded.height() as usize);
    let grey = |pixels| Picture::grey(width, height, pixels);
    let picture = match &decoded {
        image::DynamicImage::ImageLuma8(luma) => grey(luma.iter().map(|value| f32::from(*value) / 255.0).collect()),
        image::DynamicImage::ImageLuma16(luma) => grey(luma.iter().map(|value| f32::from(*value) / 65535.0).collect()),
        colour => {
            let shares = colour.to_rgb32f().pixels().map(|pixel| pixel.0.map(|c| c.clamp(0.0, 1.0))).collect();
            let mut picture = Picture::coloured(width, height, shares);
            picture.pixels.iter_mut().for_each(|pixel| *pixel = pixel.clamp(0.0, 1.0));
            picture
        }
    };
    checked(picture, path, at)
}

/// A panorama: OpenEXR with channel Y or R, G, B, or Radiance HDR. Values are linear.
pub fn panorama(bytes: &[u8], path: &Path, at: &Where) -> Result<Picture> {
    let picture = if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        exr_luminance(bytes, path, at)?
    } else if bytes.starts_with(b"#?") {
        let reader = image::ImageReader::with_format(Cursor::new(bytes), image::ImageFormat::Hdr);
        let decoded = reader.decode().map_err(|error| broken(path, at, error))?;
        let (width, height) = (decoded.width() as usize, decoded.height() as usize);
        Picture::coloured(width, height, decoded.to_rgb32f().pixels().map(|pixel| pixel.0).collect())
    } else {
        return Err(broken(path, at, "it is neither OpenEXR nor Radiance HDR").expected("a .exr or .hdr file"));
    };
    checked(picture, path, at)
}

fn exr_luminance(bytes: &[u8], path: &Path, at: &Where) -> Result<Picture> {
    use exr::prelude::{MetaData, ReadChannels, ReadLayers, read};
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|error| broken(path, at, error))?;
    for header in &meta.headers {
        let (w, h) = (header.layer_size.width(), header.layer_size.height());
        if w.checked_mul(h).is_none_or(|pixels| pixels > MAX_PIXELS) {
            return Err(broken(path, at, format!("{w} x {h} pixels are too many")));
        }
    }
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| broken(path, at, error))?;
    let layer = &image.layer_data;
    let (width, height) = (layer.size.width(), layer.size.height());
    let channels = &layer.channel_data.list;
    let samples = |name: &str| -> Option<Vec<f32>> {
        let channel = channels.iter().find(|channel| channel.name.to_string() == name)?;
        let values: Vec<f32> = channel.sample_data.values_as_f32().collect();
        (values.len() == width * height).then_some(values)
    };
    match (samples("Y"), samples("R"), samples("G"), samples("B")) {
        (None, Some(r), Some(g), Some(b)) => {
            let pixels = r.iter().zip(&g).zip(&b).map(|((r, g), b)| [*r, *g, *b]).collect();
            Ok(Picture::coloured(width, height, pixels))
        }
        (Some(y), _, _, _) => Ok(Picture::grey(width, height, y)),
        (None, _, _, _) => {
            let names: Vec<String> = channels.iter().map(|channel| channel.name.to_string()).collect();
            Err(broken(path, at, format!("its channels are {}", names.join(", "))).expected("Y, or R, G and B"))
        }
    }
}

fn checked(picture: Picture, path: &Path, at: &Where) -> Result<Picture> {
    if picture.width == 0 || picture.height == 0 || picture.pixels.len() != picture.width.saturating_mul(picture.height)
    {
        return Err(broken(path, at, "it has no pixels"));
    }
    if let Some(bad) = picture.pixels.iter().position(|value| !value.is_finite() || *value < 0.0) {
        let (x, y) = (bad % picture.width, bad / picture.width);
        let value = picture.pixels[bad];
        return Err(broken(path, at, format!("pixel ({x}, {y}) is {value}")).expected("finite values >= 0"));
    }
    // A luminance may be finite where a component isn't, or where the scaled ones are not.
    let colours = picture.rgb.iter().flatten();
    if let Some(bad) = colours.clone().position(|rgb| !rgb.iter().all(|c| *c >= 0.0 && c.is_finite())) {
        let (x, y) = (bad % picture.width, bad / picture.width);
        return Err(broken(path, at, format!("pixel ({x}, {y}) has no finite colour")).expected("finite values"));
    }
    Ok(picture)
}

#[cfg(test)]
mod tests {
    use super::*;
    use exr::prelude::*;

    fn here() -> (std::path::PathBuf, Where) {
        ("picture".into(), Where::Nowhere)
    }

    fn png(image: image::DynamicImage) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn slides_are_linear_grey() {
        let (path, at) = here();
        let grey8 = image::GrayImage::from_raw(2, 1, vec![0, 51]).unwrap();
        assert_eq!(slide(&png(grey8.into()), &path, &at).unwrap().pixels, [0.0, 0.2]);
        let grey16 = image::ImageBuffer::<image::Luma<u16>, _>::from_raw(1, 2, vec![65535, 13107]).unwrap();
        let picture = slide(&png(grey16.into()), &path, &at).unwrap();
        assert_eq!((picture.width, picture.height, picture.pixels), (1, 2, vec![1.0, 0.2]));
        let colour = image::RgbImage::from_raw(1, 1, vec![0, 255, 0]).unwrap();
        let read = slide(&png(colour.into()), &path, &at).unwrap();
        assert!((read.pixels[0] - 0.715_168_7).abs() < 1e-6);
        assert_eq!(read.rgb, Some(vec![[0.0, 1.0, 0.0]]));
        let grey = image::RgbImage::from_raw(1, 1, vec![7, 7, 7]).unwrap();
        assert_eq!(slide(&png(grey.into()), &path, &at).unwrap().rgb, None);
        let alpha = image::RgbaImage::from_raw(1, 1, vec![0, 255, 0, 7]).unwrap();
        assert_eq!(
            slide(&png(alpha.into()), &path, &at).unwrap_err().to_string(),
            "can't read the picture picture: it has an alpha channel; expected a grey PNG of 8 or 16 bits"
        );
        assert!(slide(b"not a picture", &path, &at).is_err());
    }

    #[test]
    fn panoramas_are_luminance() {
        let (path, at) = here();
        let mut bytes = Cursor::new(Vec::new());
        let rgb = SpecificChannels::rgb(|Vec2(x, y)| (x as f32, 1.0, y as f32));
        Image::from_channels((4, 2), rgb).write().to_buffered(&mut bytes).unwrap();
        let bytes = bytes.into_inner();
        let picture = panorama(&bytes, &path, &at).unwrap();
        assert_eq!((picture.width, picture.height), (4, 2));
        assert!((picture.pixels[7] - (3.0 * 0.212_639 + 0.715_168_7 + 0.072_192_3)).abs() < 1e-6);
        assert_eq!(picture.rgb.map(|rgb| rgb[7]), Some([3.0, 1.0, 1.0]));
        for length in 0..bytes.len() {
            assert!(panorama(&bytes[..length], &path, &at).is_err(), "cut after {length}");
        }
        let mut negative = Cursor::new(Vec::new());
        let grey = SpecificChannels::build().with_channel("Y").with_pixel_fn(|Vec2(x, _)| (-(x as f32),));
        Image::from_channels((2, 1), grey).write().to_buffered(&mut negative).unwrap();
        assert_eq!(
            panorama(&negative.into_inner(), &path, &at).unwrap_err().to_string(),
            "can't read the picture picture: pixel (1, 0) is -1; expected finite values >= 0"
        );
        assert_eq!(
            panorama(b"P6", &path, &at).unwrap_err().to_string(),
            "can't read the picture picture: it is neither OpenEXR nor Radiance HDR; expected a .exr or .hdr file"
        );
    }

    #[test]
    fn colours_out_of_gamut_keep_their_luminance() {
        let read = Picture::coloured(3, 1, vec![[-0.5, 1.0, 0.25], [1.0, 1.0, 1.0], [0.5, 0.0, 0.0]]);
        assert_eq!(read.clipped, 1);
        let rgb = read.rgb.unwrap();
        assert!((luminance(rgb[0]) / read.pixels[0] - 1.0).abs() < 1e-6 && rgb[0][0] == 0.0, "{:?}", rgb[0]);
        assert!((rgb[0][1] / rgb[0][2] - 4.0).abs() < 1e-5);
        assert_eq!(rgb[2], [0.5, 0.0, 0.0]);
        // Dark ones don't become coloured, and nothing becomes NaN.
        let read = Picture::coloured(1, 1, vec![[-1.0, -1.0, -1.0]]);
        assert!(checked(read, &here().0, &here().1).is_err());
        assert!(checked(Picture::coloured(1, 1, vec![[f32::NAN, 0.0, 0.0]]), &here().0, &here().1).is_err());
    }
}
