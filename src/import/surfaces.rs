//! Ordinary materials of a scene: the pictures that its faces show are read, each once.

use super::build::Builder;
use super::files;
use super::select::Candidate;
use crate::base::fault::Result;
use crate::base::ids::SurfaceId;
use crate::base::{Fault, Shared, Where};
use crate::film::exr::is_exr;
use crate::film::still::{Light, Still};
use crate::scene::texture::{PictureSource, Texels};
use crate::scene::{Colour, Note, Scalar, StandardSurface, Texture};
use image::{DynamicImage, ImageFormat, ImageReader, Limits};
use std::collections::HashMap;
use std::io::Cursor;
use std::path::PathBuf;
use std::sync::Arc;

/// Bytes that one picture may take while it is decoded: a header can claim any size.
const MOST_BYTES: u64 = 1 << 31;

/// What was read so far.
#[derive(Debug, Default)]
pub(super) struct Surfaces {
    /// Of the scene, by material of the assembly; the last is that of faces without one.
    by_material: HashMap<Option<usize>, SurfaceId>,
    pictures: HashMap<Key, Shared<Texture>>,
}

/// A picture: its file, or where its bytes are in memory.
#[derive(Debug, PartialEq, Eq, Hash)]
enum Key {
    File(PathBuf),
    Embedded(usize),
}

impl Builder<'_> {
    /// What the material of a face says of its looks: its number, its surface and its place.
    pub(super) fn look_of(&self, part: &Candidate, face: usize) -> Option<(usize, &StandardSurface, &Where)> {
        let index = self.assembly.meshes.get(part.mesh)?.materials.get(face).copied().flatten()?;
        let material = self.assembly.materials.get(index)?;
        Some((index, material.surface.as_ref()?, &material.at))
    }

    /// What a face's own material looks like, where nothing says otherwise.
    ///
    /// # Errors
    /// A picture that cannot be read.
    pub(super) fn own_surface(&mut self, part: &Candidate, face: usize) -> Result<SurfaceId> {
        let known = self.look_of(part, face);
        let key = known.map(|(material, ..)| material);
        let known = known.map(|(_, surface, at)| (surface.clone(), at.clone()));
        if let Some(surface) = self.read.by_material.get(&key) {
            return Ok(*surface);
        }
        let surface = match known {
            Some((surface, at)) => self.with_pictures(surface, &at)?,
            None => {
                let at = Where::file(&self.assembly.file);
                self.notes.push(Note::info(
                    at,
                    "faces without a material, or with one of no look, are grey: they scatter 80 %",
                ));
                grey()
            }
        };
        let id = SurfaceId::from_index(self.surfaces.len());
        self.surfaces.push(surface.into());
        self.read.by_material.insert(key, id);
        Ok(id)
    }

    /// The surface with its pictures read.
    fn with_pictures(&mut self, mut surface: StandardSurface, at: &Where) -> Result<StandardSurface> {
        for input in surface.textures_mut() {
            let Texels::Encoded(source) = &input.texture.texels else { continue };
            let key = match source {
                PictureSource::File(file) => Key::File(file.clone()),
                PictureSource::Embedded(bytes) => Key::Embedded(bytes.as_ptr() as usize),
            };
            let known = match self.read.pictures.get(&key) {
                Some(known) => known.clone(),
                None => {
                    let bytes = match source {
                        PictureSource::File(file) => {
                            let bytes = Arc::new(files::read(file, at, "texture")?);
                            self.files.push(file.clone());
                            bytes
                        }
                        PictureSource::Embedded(bytes) => bytes.clone(),
                    };
                    let (texture, remarks) = decoded(&bytes, &input.texture.name, at)?;
                    for remark in remarks {
                        let text = format!("the texture {} {remark}", input.texture.name);
                        self.notes.push(Note::info(at.clone(), text));
                    }
                    let texture = Shared::from(texture);
                    self.read.pictures.insert(key, texture.clone());
                    texture
                }
            };
            input.texture = known;
        }
        Ok(surface)
    }
}

/// Of what nothing is said.
fn grey() -> StandardSurface {
    StandardSurface {
        name: "grey".to_owned(),
        base_color: Colour::new([0.8; 3]),
        specular: Scalar::new(0.0),
        ..StandardSurface::default()
    }
}

/// A picture in the precision of its file, and what was made of it.
fn decoded(bytes: &[u8], name: &str, at: &Where) -> Result<(Texture, Vec<String>)> {
    const KNOWN: &str = "PNG, JPEG, WebP, EXR or Radiance HDR";
    const KTX2: &[u8] = b"\xABKTX 20\xBB\r\n\x1A\n";
    let broken = |why: String| Fault::new(at.clone(), format!("can't read the texture {name}: {why}"));
    let texture =
        |width: usize, height: usize, texels: Texels| Texture { name: name.to_owned(), width, height, texels };
    if is_exr(bytes) {
        let still = Still::of_exr(bytes, None).map_err(broken)?;
        let floats = match &still.light {
            Light::Grey(grey) => grey.iter().map(|y| [*y, *y, *y, 1.0]).collect(),
            Light::Rgb(rgb) => rgb.iter().map(|[r, g, b]| [*r, *g, *b, 1.0]).collect(),
        };
        let remarks = still.remarks.iter().map(|remark| remark.text.clone()).collect();
        return Ok((texture(still.width, still.height, Texels::Floats(Arc::new(floats))), remarks));
    }
    if bytes.starts_with(KTX2) {
        return Err(broken("it is KTX2, which is not read".to_owned()).expected(KNOWN));
    }
    let format =
        image::guess_format(bytes).map_err(|_| broken("its format is not known".to_owned()).expected(KNOWN))?;
    let format = match format {
        ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP | ImageFormat::Hdr => format,
        other => return Err(broken(format!("{} is not read", other.to_mime_type())).expected(KNOWN)),
    };
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    limits.max_alloc = Some(MOST_BYTES);
    reader.limits(limits);
    let decoded = reader.decode().map_err(|error| broken(error.to_string()))?;
    let (width, height) = (decoded.width() as usize, decoded.height() as usize);
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
    Ok((texture(width, height, texels), Vec::new()))
}
