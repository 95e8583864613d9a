//! The files of an assembly's pictures, taken as they are: encoded bytes, what kind they are, and free names for them.

use eyebox_base::atomic::write_atomic;
use eyebox_base::error::Result;
use eyebox_base::relative_path::folder_of;
use eyebox_base::{Error, Where, package};
use eyebox_scene::Texture;
use eyebox_scene::texture::{Channel, Encoding, PictureKey, PictureSource, Texels};
use image::{ColorType, ImageDecoder, ImageReader};
use std::collections::HashSet;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What the first bytes of a picture say it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Png,
    Jpeg,
    WebP,
    Ktx2,
    Avif,
    Exr,
    Hdr,
    Tiff,
    Unknown,
}

impl Kind {
    /// By the signatures of PNG (ISO 15948, 5.2), JPEG (ITU-T T.81, B.1.1), WebP (RFC 9649, 2.4), KTX 2.0 (3.1), AVIF (1.0,
    /// 6.3), OpenEXR, Radiance HDR and TIFF (6.0, section 2).
    pub fn of(bytes: &[u8]) -> Kind {
        let at = |start: usize, what: &[u8]| bytes.get(start..).is_some_and(|rest| rest.starts_with(what));
        if at(0, b"\x89PNG\r\n\x1a\n") {
            Kind::Png
        } else if at(0, b"\xff\xd8\xff") {
            Kind::Jpeg
        } else if at(0, b"RIFF") && at(8, b"WEBP") {
            Kind::WebP
        } else if at(0, b"\xABKTX 20\xBB\r\n\x1A\n") {
            Kind::Ktx2
        } else if at(4, b"ftypavif") {
            Kind::Avif
        } else if at(0, b"\x76\x2f\x31\x01") {
            Kind::Exr
        } else if at(0, b"#?") {
            Kind::Hdr
        } else if at(0, b"II*\0") || at(0, b"MM\0*") {
            Kind::Tiff
        } else {
            Kind::Unknown
        }
    }

    /// Endings of files of this kind, the usual one first.
    pub fn endings(self) -> &'static [&'static str] {
        match self {
            Kind::Png => &["png"],
            Kind::Jpeg => &["jpg", "jpeg"],
            Kind::WebP => &["webp"],
            Kind::Ktx2 => &["ktx2"],
            Kind::Avif => &["avif"],
            Kind::Exr => &["exr"],
            Kind::Hdr => &["hdr", "pic"],
            Kind::Tiff => &["tif", "tiff"],
            Kind::Unknown => &[],
        }
    }

    /// For people.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Png => "PNG",
            Kind::Jpeg => "JPEG",
            Kind::WebP => "WebP",
            Kind::Ktx2 => "KTX2",
            Kind::Avif => "AVIF",
            Kind::Exr => "OpenEXR",
            Kind::Hdr => "Radiance HDR",
            Kind::Tiff => "TIFF",
            Kind::Unknown => "of an unknown kind",
        }
    }
}

/// The file of a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Encoded {
    pub bytes: Arc<Vec<u8>>,
    pub kind: Kind,
}

/// None for a picture that was decoded already, which has no file any more.
pub fn key(texture: &Texture) -> Option<PictureKey> {
    match &texture.texels {
        Texels::Encoded(source) => Some(source.key()),
        Texels::Bytes(_) | Texels::Floats(_) => None,
    }
}

/// Reads the file of `texture`, which must be one; the text of an error says why it cannot be.
pub fn read(texture: &Texture) -> std::result::Result<Encoded, String> {
    let bytes = match &texture.texels {
        Texels::Encoded(PictureSource::File(file)) => return read_file(file),
        Texels::Encoded(PictureSource::Embedded(bytes)) => bytes.clone(),
        Texels::Encoded(PictureSource::Tiles(_)) => return Err("it is in tiles".to_owned()),
        Texels::Bytes(_) | Texels::Floats(_) => return Err("it is decoded already".to_owned()),
    };
    Ok(Encoded { kind: Kind::of(&bytes), bytes })
}

/// Reads a picture; the text of an error says why it cannot be.
pub fn read_file(file: &Path) -> std::result::Result<Encoded, String> {
    let bytes = package::read(file).map_err(|error| format!("{} cannot be read: {error}", file.display()))?;
    Ok(Encoded { kind: Kind::of(&bytes), bytes: Arc::new(bytes) })
}

/// Whether the picture can have an alpha other than 1, as its header says.
pub fn may_have_alpha(picture: &Encoded) -> bool {
    match picture.kind {
        Kind::Jpeg | Kind::Hdr => false,
        // The type of colour in the first chunk (ISO 15948, 11.2.1): 4 and 6 have alpha, the others may have a chunk tRNS.
        Kind::Png => {
            matches!(picture.bytes.get(25), Some(4 | 6)) || picture.bytes.windows(4).any(|four| four == b"tRNS")
        }
        Kind::WebP | Kind::Ktx2 | Kind::Avif | Kind::Exr | Kind::Tiff | Kind::Unknown => true,
    }
}

/// Puts pictures on disk, each in the folder that it names, and returns their files. One that is there already, with the same
/// bytes, stays: it may be the one that was read.
///
/// # Errors
/// A folder or file that cannot be written.
pub fn save(pictures: &[(PathBuf, Encoded)]) -> Result<Vec<PathBuf>> {
    for (file, picture) in pictures {
        if std::fs::read(file).is_ok_and(|own| own == **picture.bytes) {
            continue;
        }
        let folder = folder_of(file);
        std::fs::create_dir_all(&folder).map_err(|error| {
            Error::new(Where::file(&folder), format!("the folder of the pictures cannot be made: {error}"))
        })?;
        write_atomic(file, &picture.bytes)?;
    }
    Ok(pictures.iter().map(|(file, _)| file.clone()).collect())
}

/// What the samples of a picture are, as its header says: grey ones have the same in red, green and blue.
pub fn is_grey(picture: &Encoded) -> bool {
    color_type(picture).is_some_and(|ty| !ty.has_color())
}

/// What the numbers of a picture stand for where its reader leaves that to the file: see [`Encoding::OfFile`].
pub fn encoding(picture: &Encoded) -> Encoding {
    match color_type(picture) {
        Some(ColorType::Rgb8 | ColorType::Rgba8) => Encoding::Srgb,
        _ => Encoding::Linear,
    }
}

/// The mean of a component over the picture, as the numbers that the file has; none of a kind that is not decoded here.
pub fn mean(picture: &Encoded, channel: Channel) -> Option<f64> {
    let texels = image::load_from_memory(&picture.bytes).ok()?.into_rgba32f();
    let sum: f64 = texels.pixels().map(|texel| f64::from(channel.pick(texel.0))).sum();
    Some(sum / texels.pixels().len() as f64).filter(|mean| mean.is_finite())
}

fn color_type(picture: &Encoded) -> Option<ColorType> {
    let reader = ImageReader::new(Cursor::new(picture.bytes.as_slice())).with_guessed_format().ok()?;
    Some(reader.into_decoder().ok()?.color_type())
}

/// Names given so far to files of one folder; cases are not told apart, as some file systems don't.
#[derive(Debug, Default)]
pub struct Names(HashSet<String>);

impl Names {
    /// A name like `wanted` that ends as files of `kind` do and that no other file has. `plain` alone keeps letters that
    /// every program takes.
    pub fn free(&mut self, wanted: &str, kind: Kind, plain: bool) -> String {
        let kept = |c: char| match plain {
            true => c.is_ascii_alphanumeric() || "._-".contains(c),
            false => !c.is_control() && !"/\\:*?\"<>|[]".contains(c),
        };
        let last = wanted.trim_end_matches(']').rsplit(['/', '\\', '[']).next().unwrap_or_default();
        let mut name: String = last.trim_start_matches('.').chars().map(|c| if kept(c) { c } else { '_' }).collect();
        if name.is_empty() {
            name.push_str("picture");
        }
        let ends = |ending: &&str| name.rsplit_once('.').is_some_and(|(_, own)| own.eq_ignore_ascii_case(ending));
        if let Some(usual) = kind.endings().first().filter(|_| !kind.endings().iter().any(ends)) {
            name = format!("{name}.{usual}");
        }
        let mut free = name.clone();
        let mut number = 1;
        while !self.0.insert(free.to_lowercase()) {
            number += 1;
            free = format!("{number}_{name}");
        }
        free
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_free_and_end_as_their_kind() {
        let mut names = Names::default();
        for (wanted, plain, free) in [
            ("a b.PNG", false, "a b.PNG"),
            ("A b.png", false, "2_A b.png"),
            ("Albedo", false, "Albedo.png"),
            ("x/y:z", false, "y_z.png"),
            ("", false, "picture.png"),
            ("ä ö.png", true, "___.png"),
            ("p.usdz[0/tex.jpg]", true, "tex.jpg.png"),
        ] {
            assert_eq!(names.free(wanted, Kind::Png, plain), free);
        }
        assert_eq!(names.free("what", Kind::Unknown, false), "what");
    }

    #[test]
    fn kinds_are_known_by_their_first_bytes() {
        for (bytes, kind) in [
            (&b"\x89PNG\r\n\x1a\n"[..], Kind::Png),
            (b"\xff\xd8\xff\xe0", Kind::Jpeg),
            (b"RIFF\0\0\0\0WEBPVP8 ", Kind::WebP),
            (b"\0\0\0\x20ftypavif", Kind::Avif),
            (b"#?RADIANCE", Kind::Hdr),
            (b"\x76\x2f\x31\x01", Kind::Exr),
            (b"GIF89a", Kind::Unknown),
            (b"", Kind::Unknown),
        ] {
            assert_eq!(Kind::of(bytes), kind);
        }
    }
}
