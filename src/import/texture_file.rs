//! Files of textures: PNG, JPEG, WebP, TIFF, Radiance HDR, OpenEXR and KTX2. None is trusted: a header can claim any size.

use basisu::{DecodeFlags, TargetFormat, Transcoder};
use eyebox_base::error::Result;
use eyebox_base::{Error, Where, package};
use eyebox_film::exr::is_exr;
use eyebox_film::jpeg::is_cut_short;
use eyebox_film::radiance::{self, is_radiance};
use eyebox_film::still::{CUT_SHORT, Light, Still, undecoded};
use eyebox_scene::Texture;
use eyebox_scene::texture::{Encoding, Texels};
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, Read, Seek};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;

/// Bytes that one picture may take while it is decoded.
pub(super) const MOST_BYTES: u64 = 1 << 31;
const KNOWN: &str = "PNG, JPEG, WebP, TIFF, KTX2, EXR or Radiance HDR";
const KTX2: &[u8] = b"\xABKTX 20\xBB\r\n\x1A\n";

/// A picture in the precision of its file, what its numbers stand for where nobody says ([`Encoding::OfFile`]), and what was
/// made of it.
///
/// # Errors
/// Formats that are not read, damaged files, values that are not finite, more than 2 GiB of texels.
pub(super) fn decoded(bytes: &[u8], name: &str, at: &Where) -> Result<(Texture, Encoding, Vec<String>)> {
    let broken = |why: String| Error::new(at.clone(), format!("can't read the texture {name}: {why}"));
    let texture =
        |width: usize, height: usize, texels: Texels| Texture { name: name.to_owned(), width, height, texels };
    if is_exr(bytes) || is_radiance(bytes) {
        let still = if is_exr(bytes) { Still::of_exr(bytes, None) } else { Still::of_radiance(bytes) };
        let still = still.map_err(broken)?;
        let floats = match &still.light {
            Light::Grey(grey) => grey.iter().map(|y| [*y, *y, *y, 1.0]).collect(),
            Light::Rgb(rgb) => rgb.iter().map(|[r, g, b]| [*r, *g, *b, 1.0]).collect(),
        };
        let remarks = still.remarks.iter().map(|remark| remark.text.clone()).collect();
        return Ok((texture(still.width, still.height, Texels::Floats(Arc::new(floats))), Encoding::Linear, remarks));
    }
    if bytes.starts_with(KTX2) {
        let (width, height, texels) = basis(bytes).map_err(broken)?;
        return Ok((texture(width, height, Texels::Bytes(Arc::new(texels))), Encoding::Srgb, Vec::new()));
    }
    let format =
        image::guess_format(bytes).map_err(|_| broken("its format is not known".to_owned()).expected(KNOWN))?;
    let format = match format {
        ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP | ImageFormat::Tiff => format,
        other => return Err(broken(format!("{} is not read", other.to_mime_type())).expected(KNOWN)),
    };
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    limits.max_alloc = Some(MOST_BYTES);
    reader.limits(limits);
    let decoded = reader.decode().map_err(|error| broken(undecoded(&error, bytes, format)))?;
    if format == ImageFormat::Jpeg && is_cut_short(bytes) {
        return Err(broken(CUT_SHORT.to_owned()));
    }
    let (width, height) = (decoded.width() as usize, decoded.height() as usize);
    if width == 0 || height == 0 {
        return Err(broken("it has no pixels".to_owned()));
    }
    let is_colour = matches!(decoded, DynamicImage::ImageRgb8(_) | DynamicImage::ImageRgba8(_));
    let texels = match decoded {
        DynamicImage::ImageLuma8(_)
        | DynamicImage::ImageLumaA8(_)
        | DynamicImage::ImageRgb8(_)
        | DynamicImage::ImageRgba8(_) => {
            Texels::Bytes(Arc::new(decoded.into_rgba8().pixels().map(|pixel| pixel.0).collect()))
        }
        deeper => Texels::Floats(Arc::new(deeper.into_rgba32f().pixels().map(|pixel| pixel.0).collect())),
    };
    if let Texels::Floats(floats) = &texels
        && let Some(pixel) = floats.iter().position(|texel| !texel.iter().all(|x| x.is_finite()))
    {
        return Err(broken(format!("pixel {pixel} is not finite")).expected("finite values"));
    }
    let encoding = if is_colour { Encoding::Srgb } else { Encoding::Linear };
    Ok((texture(width, height, texels), encoding, Vec::new()))
}

/// The largest level of a KTX2 file of Basis Universal, the only kind that glTF allows (KHR_texture_basisu).
fn basis(bytes: &[u8]) -> Result<(usize, usize, Vec<[u8; 4]>), String> {
    let (width, height) = ktx2_size(bytes).ok_or("it ends in its header")?;
    if u64::from(width) * u64::from(height) * 4 > MOST_BYTES {
        return Err(format!("it claims {width} × {height} pixels"));
    }
    // The transcoder checks what it reads, but its own arithmetic is not ours to rely on: a file must not end the program.
    let read = || {
        let transcoder = Transcoder::new(bytes).map_err(|_| "it is no KTX2 of Basis Universal".to_owned())?;
        transcoder
            .transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE)
            .map_err(|error| format!("it cannot be decoded, {error:?}"))
    };
    let rgba = catch_unwind(AssertUnwindSafe(read)).unwrap_or_else(|_| Err("its contents are damaged".to_owned()))?;
    let (width, height) = (width as usize, height as usize);
    let (texels, _) = rgba.as_chunks::<4>();
    if texels.len() != width * height {
        return Err("its contents are damaged".to_owned());
    }
    Ok((width, height, texels.to_vec()))
}

/// Width and height of a KTX2 file, at their places in its header (KTX 2.0, section 3).
fn ktx2_size(bytes: &[u8]) -> Option<(u32, u32)> {
    let number = |at: usize| Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?));
    Some((number(20)?, number(24)?.max(1)))
}

/// Bytes of memory that the picture of a file takes once it is decoded; 0 where that cannot be told: whoever needs it says why.
pub(super) fn file_bytes(file: &Path) -> u64 {
    // Of a plain file its header alone is read.
    match File::open(file) {
        Ok(open) => size_bytes(BufReader::new(open)),
        Err(_) => package::read(file).map_or(0, |bytes| size_bytes(Cursor::new(bytes))),
    }
}

/// The same by a header; 0 if that says nothing.
pub(super) fn size_bytes(mut from: impl BufRead + Seek) -> u64 {
    const DEEP: u64 = size_of::<[f32; 4]>() as u64;
    const BEGINNING: u64 = 28;
    let area = |width: u32, height: u32| u64::from(width) * u64::from(height);
    let mut first = Vec::new();
    if from.by_ref().take(BEGINNING).read_to_end(&mut first).and_then(|_| from.rewind()).is_err() {
        return 0;
    }
    if first.starts_with(KTX2) {
        return ktx2_size(&first).map_or(0, |(width, height)| 4 * area(width, height));
    }
    if is_exr(&first) {
        let header = ::exr::meta::MetaData::read_from_buffered(from, false);
        let size = header.ok().and_then(|meta| meta.headers.first().map(|header| header.layer_size.area() as u64));
        return DEEP * size.unwrap_or(0);
    }
    if is_radiance(&first) {
        const LONGEST: u64 = 1 << 16;
        let mut head = Vec::new();
        let read = from.take(LONGEST).read_to_end(&mut head);
        let size = read.ok().and_then(|_| radiance::size(&head));
        return size.map_or(0, |[width, height]| DEEP.saturating_mul((width as u64).saturating_mul(height as u64)));
    }
    let reader = ImageReader::new(from).with_guessed_format().ok();
    let decoder = reader.and_then(|reader| reader.into_decoder().ok());
    decoder.map_or(0, |decoder| {
        let (width, height) = decoder.dimensions();
        let kind = decoder.color_type();
        let is_deep = kind.bytes_per_pixel() > kind.channel_count();
        area(width, height) * if is_deep { DEEP } else { 4 }
    })
}

/// A picture of half the width and height, each texel the mean of what it covers; bytes as they are stored.
pub(super) fn halved(texture: Texture) -> Texture {
    let (width, height) = (texture.width.div_ceil(2), texture.height.div_ceil(2));
    let from = [texture.width, texture.height];
    let texels = match &texture.texels {
        Texels::Encoded(_) => return texture,
        Texels::Bytes(bytes) => Texels::Bytes(Arc::new(mean(bytes, from, |all| {
            std::array::from_fn(|lane| {
                let sum: u32 = all.iter().map(|texel| u32::from(texel[lane])).sum();
                ((2 * sum + all.len() as u32) / (2 * all.len() as u32)) as u8
            })
        }))),
        Texels::Floats(floats) => Texels::Floats(Arc::new(mean(floats, from, |all| {
            std::array::from_fn(|lane| all.iter().map(|texel| texel[lane]).sum::<f32>() / all.len() as f32)
        }))),
    };
    Texture { name: texture.name.clone(), width, height, texels }
}

fn mean<T: Copy>(texels: &[T], [width, height]: [usize; 2], of: impl Fn(&[T]) -> T) -> Vec<T> {
    let mut out = Vec::with_capacity(width.div_ceil(2) * height.div_ceil(2));
    for y in (0..height).step_by(2) {
        for x in (0..width).step_by(2) {
            let mut all = Vec::with_capacity(4);
            for row in y..(y + 2).min(height) {
                all.extend(texels.get(row * width + x..row * width + (x + 2).min(width)).unwrap_or_default());
            }
            if !all.is_empty() {
                out.push(of(&all));
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_means_to_the_last_odd_column() {
        let texels = (0..6u8).map(|i| [10 * i, 0, 0, 255]).collect();
        let texture = Texture { name: "t".into(), width: 3, height: 2, texels: Texels::Bytes(Arc::new(texels)) };
        let half = halved(texture);
        assert_eq!((half.width, half.height), (2, 1));
        // (0 + 10 + 30 + 40)/4 and (20 + 50)/2.
        assert_eq!(half.texels, Texels::Bytes(Arc::new(vec![[20, 0, 0, 255], [35, 0, 0, 255]])));
    }

    #[test]
    fn headers_tell_the_size() {
        let mut png = Vec::new();
        let picture = DynamicImage::new_rgb8(7, 5);
        picture.write_to(&mut Cursor::new(&mut png), ImageFormat::Png).unwrap();
        assert_eq!(size_bytes(Cursor::new(&png)), 7 * 5 * 4);
        assert_eq!(size_bytes(Cursor::new(b"nothing")), 0);
        let mut deep = Vec::new();
        DynamicImage::new_rgb16(3, 2).write_to(&mut Cursor::new(&mut deep), ImageFormat::Png).unwrap();
        assert_eq!(size_bytes(Cursor::new(&deep)), 3 * 2 * 16);
    }

    /// What lies about itself ends in one sentence.
    #[test]
    fn hostile_pictures() {
        let mut bomb = Vec::from(KTX2);
        bomb.extend([0; 8]);
        bomb.extend(60_000u32.to_le_bytes());
        bomb.extend(60_000u32.to_le_bytes());
        for bytes in [bomb.as_slice(), KTX2, b"\x89PNG\r\n\x1a\n", b"", b"\xff\xd8\xff"] {
            let fault = decoded(bytes, "t", &Where::Nowhere).unwrap_err();
            assert!(fault.what.starts_with("can't read the texture t: "), "{}", fault.what);
        }
        let said = |bytes: &[u8]| decoded(bytes, "t", &Where::Nowhere).unwrap_err().what;
        assert!(said(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 0 +X 0\n").ends_with("it has no pixels"));
        let claims = said(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 60000 +X 50000\n");
        assert!(claims.contains("it claims 50000 × 60000 pixels"), "{claims}");
        let mut jpeg = Vec::new();
        DynamicImage::new_rgb8(40, 40).write_to(&mut Cursor::new(&mut jpeg), ImageFormat::Jpeg).unwrap();
        assert!(decoded(&jpeg, "t", &Where::Nowhere).is_ok());
        assert!(said(&jpeg[..jpeg.len() - 20]).contains("cut short"));
    }
}
