//! Ordinary materials of a scene: the pictures that its faces show are read, each once.

use super::binding_slots::{PartBound, Slots};
use super::build::Builder;
use super::files;
use super::optics::{self, FinishSpec};
use super::select::Candidate;
use super::texture_file::{MOST_BYTES, decoded, file_bytes, halved, size_bytes};
use super::tiles;
use eyebox_base::error::Result;
use eyebox_base::ids::SurfaceId;
use eyebox_base::{Code, Error, Shared, Where};
use eyebox_scene::texture::{Encoding, PictureKey, PictureSource, Texels, Wrap};
use eyebox_scene::{Colour, Note, Opacity, Scalar, StandardSurface, Texture};
use std::collections::{HashMap, HashSet};
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What was read so far.
#[derive(Debug, Default)]
pub(super) struct Surfaces {
    by_look: HashMap<Look, SurfaceId>,
    /// With what the file's numbers stand for where the asset leaves that to it.
    pictures: HashMap<PictureKey, (Shared<Texture>, Encoding)>,
    /// Those that could not be read, which is said once.
    unread: HashSet<PictureKey>,
    /// Of meshes that have colours of vertices: whether some of them let light through.
    painted: HashMap<usize, Option<bool>>,
    /// The pictures of finishes that somebody has bound.
    bound: Vec<PictureSource>,
    /// How often each picture is halved, so that all of them stay within the memory that they may take; once it is known.
    halvings: Option<u32>,
}

impl Surfaces {
    /// With what finishes that somebody has bound will ask for.
    pub(super) fn expecting(bound: &[PartBound]) -> Surfaces {
        Surfaces { bound: bound_pictures(bound), ..Surfaces::default() }
    }
}

/// The pictures of all finishes that are bound, before any of them is read. What a finish has wrong is said when it is.
fn bound_pictures(bound: &[PartBound]) -> Vec<PictureSource> {
    let (mut seen, mut out) = (HashSet::new(), Vec::new());
    for (entry, _) in bound.iter().flat_map(|part| &part.faces).filter_map(Slots::finish) {
        if !seen.insert(std::ptr::from_ref(entry)) {
            continue;
        }
        let Ok(FinishSpec::Surface { surface, .. }) = optics::finish(&entry.value, &mut Vec::new()) else { continue };
        out.extend(surface.textures().filter_map(|input| match &input.texture.texels {
            Texels::Encoded(source) => Some(source.clone()),
            Texels::Bytes(_) | Texels::Floats(_) => None,
        }));
    }
    out
}

/// What a face's looks come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Look {
    /// Its material, by its number.
    Material(usize),
    /// The colours of its vertices alone.
    Painted {
        blend: bool,
    },
    Nothing,
}

/// The bytes of a texture's file.
fn bytes_of(file: &Path, at: &Where) -> Result<Vec<u8>> {
    files::read(file, at, "texture").map_err(|fault| match fault.code {
        Some(Code::FileMissing) => fault.code(Code::TextureMissing),
        Some(_) | None => fault,
    })
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
        let look = known.map(|(material, ..)| Look::Material(material));
        let known = known.map(|(_, surface, at)| (surface.clone(), at.clone()));
        let look = look.or_else(|| self.painted(part.mesh)).unwrap_or(Look::Nothing);
        if let Some(surface) = self.read.by_look.get(&look) {
            return Ok(*surface);
        }
        let surface = match (known, look) {
            (Some((surface, at)), _) => self.with_pictures(surface, &at)?,
            (None, Look::Painted { blend }) => painted(blend),
            (None, Look::Material(_) | Look::Nothing) => {
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
        self.read.by_look.insert(look, id);
        Ok(id)
    }

    /// A surface that somebody has bound.
    ///
    /// # Errors
    /// A picture that cannot be read.
    pub(super) fn given_surface(&mut self, surface: StandardSurface, at: &Where) -> Result<SurfaceId> {
        let surface = Shared::from(self.with_pictures(surface, at)?);
        let known = self.surfaces.iter().position(|known| *known == surface);
        let index = known.unwrap_or(self.surfaces.len());
        if known.is_none() {
            self.surfaces.push(surface);
        }
        Ok(SurfaceId::from_index(index))
    }

    /// The look of a mesh whose vertices have colours.
    fn painted(&mut self, mesh: usize) -> Option<Look> {
        let assembly = self.assembly;
        let blend = *self.read.painted.entry(mesh).or_insert_with(|| {
            let colors = &assembly.meshes.get(mesh)?.mesh.colors;
            (!colors.is_empty()).then(|| colors.iter().any(|[.., alpha]| *alpha < 1.0))
        });
        blend.map(|blend| Look::Painted { blend })
    }

    /// The surface with its pictures read.
    fn with_pictures(&mut self, mut surface: StandardSurface, at: &Where) -> Result<StandardSurface> {
        for input in surface.textures_mut() {
            let Texels::Encoded(source) = &input.texture.texels else { continue };
            let key = source.key();
            let grid = match source {
                PictureSource::Tiles(tiles) => Some(tiles::grid(tiles)),
                PictureSource::File(_) | PictureSource::Embedded(_) => None,
            };
            let known = match self.read.pictures.get(&key) {
                Some(known) => Ok(known.clone()),
                None => self.picture(source, &input.texture.name, at),
            };
            let (texture, encoding) = match (known, input.fallback) {
                (Ok(known), _) => {
                    if let Some(grid) = grid {
                        tiles::place(input, grid);
                    }
                    self.read.pictures.insert(key, known.clone());
                    known
                }
                (Err(fault), Some(texel)) => {
                    if self.read.unread.insert(key) {
                        let text = format!("{}; its fallback is taken", fault.what);
                        // A file that is missing is one that the asset needs, of which there is a list.
                        let code = fault.code.filter(|code| *code == Code::TextureMissing);
                        self.notes.push(Note::warning(fault.at.clone(), text).code(code));
                    }
                    input.wrap = [Wrap::Repeat; 2];
                    input.encoding = Encoding::Linear;
                    (flat(&input.texture.name, texel), Encoding::Linear)
                }
                (Err(fault), None) => return Err(fault),
            };
            input.texture = texture;
            if input.encoding == Encoding::OfFile {
                input.encoding = encoding;
            }
        }
        if let Some((normal, _)) = &surface.normal
            && normal.encoding == Encoding::Srgb
        {
            let name = &normal.texture.name;
            let text = format!("the normals of the texture {name} are read as colours: say `raw` as its colour space");
            self.notes.push(Note::warning(at.clone(), text));
        }
        Ok(surface)
    }

    /// Reads a picture, and what its numbers stand for.
    fn picture(&mut self, source: &PictureSource, name: &str, at: &Where) -> Result<(Shared<Texture>, Encoding)> {
        let bytes = match source {
            PictureSource::File(file) => Arc::new(bytes_of(file, at)?),
            PictureSource::Embedded(bytes) => bytes.clone(),
            PictureSource::Tiles(tiles) => return self.tiles(tiles, name, at),
        };
        let (texture, encoding, remarks) = decoded(&bytes, name, at)?;
        let texture = self.fitted(texture);
        if let PictureSource::File(file) = source {
            self.files.push(file.clone());
        }
        self.remark(name, remarks, at);
        Ok((Shared::from(texture), encoding))
    }

    /// Tiles as one picture.
    fn tiles(&mut self, all: &[(PathBuf, [u32; 2])], name: &str, at: &Where) -> Result<(Shared<Texture>, Encoding)> {
        let mut read = Vec::new();
        let mut encoding = Encoding::Linear;
        for (file, place) in all {
            let own = file.file_name().map_or_else(|| name.to_owned(), |own| own.to_string_lossy().into_owned());
            let bytes = bytes_of(file, at)?;
            let (texture, own_encoding, remarks) = decoded(&bytes, &own, at)?;
            let texture = self.fitted(texture);
            self.files.push(file.clone());
            self.remark(&own, remarks, at);
            encoding = own_encoding;
            read.push((texture, *place));
        }
        let joined = tiles::joined(name, &read, MOST_BYTES).ok_or_else(|| {
            let fault = Error::new(at.clone(), format!("the tiles of the texture {name} do not fit into memory"));
            fault.expected(format!("at most {MOST_BYTES} bytes together"))
        })?;
        Ok((Shared::from(joined), encoding))
    }

    fn remark(&mut self, name: &str, remarks: Vec<String>, at: &Where) {
        for remark in remarks {
            self.notes.push(Note::info(at.clone(), format!("the texture {name} {remark}")));
        }
    }

    /// As small as it must be.
    fn fitted(&mut self, texture: Texture) -> Texture {
        let halvings = match self.read.halvings {
            Some(known) => known,
            None => self.halvings(),
        };
        self.read.halvings = Some(halvings);
        (0..halvings).fold(texture, |texture, _| halved(texture))
    }

    /// How often the pictures of all materials and finishes must be halved, both ways, to fit; said where it is at all.
    fn halvings(&mut self) -> u32 {
        let most = self.texture_bytes;
        let mut seen = HashSet::new();
        let surfaces = self.assembly.materials.iter().filter_map(|material| material.surface.as_ref());
        let inputs = surfaces.flat_map(|surface| surface.textures().chain(&surface.emission));
        let sources = inputs.filter_map(|input| match &input.texture.texels {
            Texels::Encoded(source) => Some(source),
            Texels::Bytes(_) | Texels::Floats(_) => None,
        });
        let size = |source: &PictureSource| match source {
            PictureSource::File(file) => file_bytes(file),
            PictureSource::Embedded(bytes) => size_bytes(Cursor::new(bytes.as_slice())),
            PictureSource::Tiles(tiles) => tiles.iter().map(|(file, _)| file_bytes(file)).sum(),
        };
        let total: u64 = sources.chain(&self.read.bound).filter(|source| seen.insert(source.key())).map(size).sum();
        let halvings = (0..u32::BITS / 2).find(|k| total >> (2 * k) <= most).unwrap_or(u32::BITS / 2);
        if halvings > 0 {
            const MIB: u64 = 1 << 20;
            let text = format!(
                "the textures take {} MiB, more than {}: each is read at 1/{} of its width and height; `--texture-memory` allows more",
                total.div_ceil(MIB),
                most / MIB,
                1_u64 << halvings
            );
            self.notes.push(Note::warning(Where::file(&self.assembly.file), text));
        }
        halvings
    }
}

/// A picture that has one texel.
fn flat(name: &str, texel: [f64; 4]) -> Shared<Texture> {
    let texels = Texels::Floats(Arc::new(vec![texel.map(|lane| lane as f32)]));
    Shared::from(Texture { name: name.to_owned(), width: 1, height: 1, texels })
}

/// What only the colours of vertices are said of: they say no gloss.
fn painted(blend: bool) -> StandardSurface {
    let opacity = if blend { Opacity::Blend { alpha: Scalar::new(1.0) } } else { Opacity::Opaque };
    StandardSurface {
        name: "colours of vertices".to_owned(),
        vertex_colors: true,
        specular: Scalar::new(0.0),
        opacity,
        ..StandardSurface::default()
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
