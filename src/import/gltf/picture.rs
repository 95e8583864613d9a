//! Pictures of materials: how a texture reference becomes a [`TextureInput`]. The picture itself is read when a scene needs it.

use super::accessor::Document;
use super::at::At;
use super::buffers;
use super::notes::Ledger;
use eyebox_base::Shared;
use eyebox_base::error::Result;
use eyebox_scene::texture::{Channel, Encoding, Filter, PictureSource, Texels, Wrap};
use eyebox_scene::{Texture, TextureInput};
use std::collections::HashMap;
use std::sync::Arc;

/// Pictures that some material has named, by their number.
#[derive(Debug, Default)]
pub(super) struct Pictures(HashMap<usize, Shared<Texture>>);

/// What the texture reference `at` reads; none, with a note, where the picture is of a kind that is not known.
///
/// # Errors
/// Indices that lead nowhere, URIs that cannot be read.
pub(super) fn input(
    document: &Document<'_>,
    at: &At<'_>,
    encoding: Encoding,
    (pictures, ledger): (&mut Pictures, &mut Ledger),
) -> Result<Option<TextureInput>> {
    let texture = document.find("textures", "texture", &at.want("index")?)?;
    let mut set = at.count_or("texCoord", 0)?;
    let transform = at.extension("KHR_texture_transform")?;
    let to_picture = match &transform {
        None => [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        Some(transform) => {
            set = transform.count_or("texCoord", set)?;
            moved(transform)?
        }
    };
    if set > 1 {
        ledger.notes.warn(at, "texture coordinates of the third set and beyond are not read: the second is taken");
    }
    let Some(source) = source(&texture)? else {
        ledger.notes.warn(&texture, "a texture without a picture: it is white");
        return Ok(None);
    };
    let (wrap, filter) = sampler(document, &texture)?;
    Ok(Some(TextureInput {
        texture: picture(document, &source, pictures, ledger)?,
        encoding,
        wrap,
        filter,
        set: set.min(1) as u32,
        to_picture,
        channels: Channel::ALL,
        scale: [1.0; 4],
        bias: [0.0; 4],
        fallback: None,
    }))
}

/// The picture of a texture: what all readers know, or what an extension has instead.
fn source<'a>(texture: &At<'a>) -> Result<Option<At<'a>>> {
    if let Some(source) = texture.get("source")? {
        return Ok(Some(source));
    }
    for name in ["EXT_texture_webp", "KHR_texture_basisu", "MSFT_texture_dds", "EXT_texture_avif"] {
        if let Some(extension) = texture.extension(name)? {
            return extension.get("source");
        }
    }
    Ok(None)
}

/// `KHR_texture_transform`: scaled, turned (against the clock as the picture is seen, rows downwards), moved.
fn moved(at: &At<'_>) -> Result<[[f64; 3]; 2]> {
    let pair = |key: &str, default: [f64; 2]| at.get(key)?.map_or(Ok(default), |field| field.numbers::<2>());
    let ([x, y], [sx, sy]) = (pair("offset", [0.0; 2])?, pair("scale", [1.0; 2])?);
    let (sin, cos) = at.get("rotation")?.map_or(Ok(0.0), |field| field.number())?.sin_cos();
    Ok([[cos * sx, sin * sy, x], [-sin * sx, cos * sy, y]])
}

fn sampler(document: &Document<'_>, texture: &At<'_>) -> Result<([Wrap; 2], Filter)> {
    let Some(reference) = texture.get("sampler")? else { return Ok(([Wrap::Repeat; 2], Filter::Linear)) };
    let sampler = document.find("samplers", "sampler", &reference)?;
    let wrap = |key: &str| -> Result<Wrap> {
        Ok(match sampler.get(key)? {
            None => Wrap::Repeat,
            Some(field) => match field.count()? {
                33071 => Wrap::Clamp,
                33648 => Wrap::Mirror,
                10497 => Wrap::Repeat,
                other => {
                    let fault = field.fault(format!("wrapping mode {other}"));
                    return Err(fault.expected("33071 (clamp), 33648 (mirror) or 10497 (repeat)"));
                }
            },
        })
    };
    let filter = match sampler.get("magFilter")? {
        Some(field) if field.count()? == 9728 => Filter::Nearest,
        Some(_) | None => Filter::Linear,
    };
    Ok(([wrap("wrapS")?, wrap("wrapT")?], filter))
}

fn picture(
    document: &Document<'_>,
    reference: &At<'_>,
    pictures: &mut Pictures,
    ledger: &mut Ledger,
) -> Result<Shared<Texture>> {
    let at = document.find("images", "image", reference)?;
    let index = reference.count()?;
    if let Some(known) = pictures.0.get(&index) {
        return Ok(known.clone());
    }
    let source = match (at.get("uri")?, at.get("bufferView")?) {
        (Some(uri), _) => {
            let text = uri.text()?;
            match buffers::data_scheme(text) {
                Some(rest) => PictureSource::Embedded(Arc::new(buffers::data_uri(&uri, rest)?)),
                None => PictureSource::File(buffers::resolve(&uri, text)?),
            }
        }
        (None, Some(view)) => {
            let bytes = document.view(&view)?.bytes;
            ledger.budget.charge(&view, bytes.len(), 1)?;
            PictureSource::Embedded(Arc::new(bytes.to_vec()))
        }
        (None, None) => return Err(at.fault("an image without a place").expected("`uri` or `bufferView`")),
    };
    let name = match &source {
        PictureSource::File(file) => file.file_name().map(|name| name.to_string_lossy().into_owned()),
        PictureSource::Embedded(_) | PictureSource::Tiles(_) => None,
    };
    let name = name.map_or_else(|| at.name("image", index), Ok)?;
    let texture = Shared::from(Texture { name, width: 0, height: 0, texels: Texels::Encoded(source) });
    pictures.0.insert(index, texture.clone());
    Ok(texture)
}
