//! Pictures that a scene is made of: slides (PNG) and panoramas (OpenEXR, Radiance HDR), as luminance and as colour.

use eyebox_base::error::Result;
use eyebox_base::{Error, Where};
use eyebox_film::exr::is_exr;
use eyebox_film::radiance::is_radiance;
use eyebox_film::still::{Light, Remark, Still, is_srgb, undecoded};
use eyebox_scene::{Note, Severity};
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
    /// cd/m² of the value 1, if the file says so.
    pub white_cd_m2: Option<f64>,
    /// What was made of the file.
    pub remarks: Vec<Remark>,
}

/// Luminance of linear Rec.709.
fn luminance(rgb: [f32; 3]) -> f32 {
    eyebox_base::colour::luminance(rgb.map(f64::from)) as f32
}

impl Picture {
    pub(super) fn grey(width: usize, height: usize, pixels: Vec<f32>) -> Self {
        Picture { width, height, pixels, rgb: None, clipped: 0, white_cd_m2: None, remarks: Vec::new() }
    }

    pub(super) fn coloured(width: usize, height: usize, mut rgb: Vec<[f32; 3]>) -> Self {
        let pixels: Vec<f32> = rgb.iter().map(|pixel| luminance(*pixel)).collect();
        let mut clipped = 0;
        for (pixel, own) in rgb.iter_mut().zip(&pixels).filter(|(pixel, _)| pixel.iter().any(|c| *c < 0.0)) {
            clipped += 1;
            let inside = pixel.map(|c| c.max(0.0));
            let whole = luminance(inside);
            *pixel = if whole > 0.0 { inside.map(|c| c * (own / whole)) } else { [0.0; 3] };
        }
        let colour = rgb.iter().any(|[r, g, b]| r != g || g != b);
        let rgb = colour.then_some(rgb);
        Picture { width, height, pixels, rgb, clipped, white_cd_m2: None, remarks: Vec::new() }
    }

    /// Resampling rings: what it has left below 0 becomes 0, which is said.
    fn without_negatives(mut self) -> Self {
        let negative: Vec<usize> = (0..self.pixels.len()).filter(|pixel| self.pixels[*pixel] < 0.0).collect();
        let Some(lowest) = negative.iter().map(|pixel| self.pixels[*pixel]).reduce(f32::min) else { return self };
        for pixel in &negative {
            self.pixels[*pixel] = 0.0;
            if let Some(rgb) = &mut self.rgb {
                rgb[*pixel] = [0.0; 3];
            }
        }
        let text = format!(
            "has a luminance below 0 in {} of its {} pixels, {lowest:e} at the lowest: taken as 0",
            negative.len(),
            self.pixels.len()
        );
        self.remarks.push(Remark { warns: true, text });
        self
    }

    /// The remarks as notes on a picture called so.
    pub fn notes(&mut self, name: &str, at: &Where) -> Vec<Note> {
        let note = |remark: Remark| {
            let severity = if remark.warns { Severity::Warning } else { Severity::Info };
            Note::new(severity, at.clone(), format!("the picture {name} {}", remark.text))
        };
        std::mem::take(&mut self.remarks).into_iter().map(note).collect()
    }
}

fn broken(path: &Path, at: &Where, why: impl std::fmt::Display) -> Box<Error> {
    Error::new(at.clone(), format!("can't read the picture {}: {why}", path.display()))
}

/// A slide: grey PNG of 8 or 16 bits, value/max, values taken as linear, or an EXR (of which `layer`); colours as their
/// luminance. Values above 1 let no more through than 1.
pub fn slide(bytes: &[u8], layer: Option<&str>, path: &Path, at: &Where) -> Result<Picture> {
    if is_exr(bytes) {
        let mut picture = checked(exr(bytes, layer, path, at)?.without_negatives(), path, at)?;
        let above = picture.pixels.iter().filter(|value| **value > 1.0).count();
        if above > 0 {
            let text = format!("has {above} pixels above 1, all light: taken as 1");
            picture.remarks.push(Remark { warns: true, text });
        }
        picture.pixels.iter_mut().for_each(|value| *value = value.min(1.0));
        picture.rgb.iter_mut().flatten().flatten().for_each(|value| *value = value.min(1.0));
        return Ok(picture);
    }
    no_layer(layer, path, at)?;
    let reader = image::ImageReader::with_format(Cursor::new(bytes), image::ImageFormat::Png);
    let why = |error| undecoded(&error, bytes, image::ImageFormat::Png);
    let decoded = reader.decode().map_err(|error| broken(path, at, why(error)).expected("a PNG of 8 or 16 bits"))?;
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

/// Only EXR files have layers.
fn no_layer(layer: Option<&str>, path: &Path, at: &Where) -> Result<()> {
    match layer {
        None => Ok(()),
        Some(layer) => Err(broken(path, at, format!("it can't have the layer `{layer}`")).expected("an .exr file")),
    }
}

/// A panorama: OpenEXR with channel Y or R, G, B (of `layer`, if one is named), or Radiance HDR, whose values are linear; PNG or
/// JPEG, whose values are sRGB.
pub fn panorama(bytes: &[u8], layer: Option<&str>, path: &Path, at: &Where) -> Result<Picture> {
    let picture = if is_exr(bytes) {
        exr(bytes, layer, path, at)?.without_negatives()
    } else if is_radiance(bytes) {
        no_layer(layer, path, at)?;
        still_picture(Still::of_radiance(bytes).map_err(|why| broken(path, at, why))?).without_negatives()
    } else if is_srgb(bytes) {
        no_layer(layer, path, at)?;
        still_picture(Still::of_srgb(bytes).map_err(|why| broken(path, at, why))?)
    } else {
        let fault = broken(path, at, "it is none of OpenEXR, Radiance HDR, PNG and JPEG");
        return Err(fault.expected("a .exr or .hdr file, or a picture whose brightest is 1"));
    };
    checked(picture, path, at)
}

/// The picture of an EXR file, or of one of its layers.
fn exr(bytes: &[u8], layer: Option<&str>, path: &Path, at: &Where) -> Result<Picture> {
    Still::of_exr(bytes, layer).map(still_picture).map_err(|error| broken(path, at, error))
}

fn still_picture(still: Still) -> Picture {
    let picture = match still.light {
        Light::Grey(pixels) => Picture::grey(still.width, still.height, pixels),
        Light::Rgb(pixels) => Picture::coloured(still.width, still.height, pixels),
    };
    Picture { remarks: still.remarks, white_cd_m2: still.white_cd_m2, ..picture }
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
        assert_eq!(slide(&png(grey8.into()), None, &path, &at).unwrap().pixels, [0.0, 0.2]);
        let grey16 = image::ImageBuffer::<image::Luma<u16>, _>::from_raw(1, 2, vec![65535, 13107]).unwrap();
        let picture = slide(&png(grey16.into()), None, &path, &at).unwrap();
        assert_eq!((picture.width, picture.height, picture.pixels), (1, 2, vec![1.0, 0.2]));
        let colour = image::RgbImage::from_raw(1, 1, vec![0, 255, 0]).unwrap();
        let read = slide(&png(colour.into()), None, &path, &at).unwrap();
        assert!((read.pixels[0] - 0.715_168_7).abs() < 1e-6);
        assert_eq!(read.rgb, Some(vec![[0.0, 1.0, 0.0]]));
        let grey = image::RgbImage::from_raw(1, 1, vec![7, 7, 7]).unwrap();
        assert_eq!(slide(&png(grey.into()), None, &path, &at).unwrap().rgb, None);
        let alpha = image::RgbaImage::from_raw(1, 1, vec![0, 255, 0, 7]).unwrap();
        assert_eq!(
            slide(&png(alpha.into()), None, &path, &at).unwrap_err().to_string(),
            "can't read the picture picture: it has an alpha channel; expected a grey PNG of 8 or 16 bits"
        );
        assert!(slide(b"not a picture", None, &path, &at).is_err());
    }

    #[test]
    fn panoramas_are_luminance() {
        let (path, at) = here();
        let mut bytes = Cursor::new(Vec::new());
        let rgb = SpecificChannels::rgb(|Vec2(x, y)| (x as f32, 1.0, y as f32));
        Image::from_channels((4, 2), rgb).write().to_buffered(&mut bytes).unwrap();
        let bytes = bytes.into_inner();
        let picture = panorama(&bytes, None, &path, &at).unwrap();
        assert_eq!((picture.width, picture.height), (4, 2));
        assert!((picture.pixels[7] - (3.0 * 0.212_639 + 0.715_168_7 + 0.072_192_3)).abs() < 1e-6);
        assert_eq!(picture.rgb.map(|rgb| rgb[7]), Some([3.0, 1.0, 1.0]));
        for length in 0..bytes.len() {
            assert!(panorama(&bytes[..length], None, &path, &at).is_err(), "cut after {length}");
        }
        let mut negative = Cursor::new(Vec::new());
        let grey = SpecificChannels::build().with_channel("Y").with_pixel_fn(|Vec2(x, _)| (-(x as f32),));
        Image::from_channels((2, 1), grey).write().to_buffered(&mut negative).unwrap();
        let mut clamped = panorama(&negative.into_inner(), None, &path, &at).unwrap();
        assert_eq!(clamped.pixels, [0.0, 0.0]);
        assert_eq!(
            clamped.notes("p.exr", &at).into_iter().map(|note| note.text).collect::<Vec<_>>(),
            ["the picture p.exr has a luminance below 0 in 1 of its 2 pixels, -1e0 at the lowest: taken as 0"]
        );
        assert_eq!(
            panorama(b"P6", None, &path, &at).unwrap_err().to_string(),
            "can't read the picture picture: it is none of OpenEXR, Radiance HDR, PNG and JPEG; expected a .exr or .hdr file, or a picture whose brightest is 1"
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
