//! The pictures of materials for a USD file: which are taken, and under which names.

use super::super::picture::{self, Encoded, Kind, Names};
use eyebox_base::Where;
use eyebox_scene::texture::PictureKey;
use eyebox_scene::texture::{PictureSource, Texels};
use eyebox_scene::{Note, Severity, Texture};
use image::ImageFormat;
use std::collections::HashMap;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Stands for the number of a tile.
pub const TILE: &str = "<UDIM>";

/// The pictures of a file, and what USD cannot say of its materials.
#[derive(Debug, Default)]
pub struct Pictures {
    /// The folder beside the file.
    folder: String,
    packed: bool,
    names: Names,
    taken: Vec<(String, Encoded)>,
    /// The asset path of each picture so far; none for one that is not written.
    paths: HashMap<PictureKey, Option<String>>,
    pub notes: Vec<Note>,
}

impl Pictures {
    /// For a file whose name without its ending is `stem`.
    pub fn new(stem: &str, packed: bool) -> Self {
        Pictures { folder: format!("{stem}_textures"), packed, ..Pictures::default() }
    }

    /// Something that USD cannot say.
    pub fn warn(&mut self, at: &Where, text: String) {
        self.notes.push(Note::warning(at.clone(), text));
    }

    /// How the layer names the picture `texture`, which `what` reads; none, with a note, for one that USD has no place for.
    pub fn path(&mut self, texture: &Texture, at: &Where, what: &str) -> Option<String> {
        let key = picture::key(texture);
        if let Some(known) = key.as_ref().and_then(|key| self.paths.get(key)) {
            return known.clone();
        }
        let name = &texture.name;
        let file = match &texture.texels {
            Texels::Encoded(PictureSource::Tiles(tiles)) => self.tiles(tiles, name),
            Texels::Encoded(PictureSource::File(_) | PictureSource::Embedded(_))
            | Texels::Bytes(_)
            | Texels::Floats(_) => {
                picture::read(texture).and_then(|picture| self.usable(picture)).map(|(picture, remark)| {
                    let file = self.names.free(name, picture.kind, true);
                    self.taken.push((file.clone(), picture));
                    (file, remark)
                })
            }
        };
        let path = match file {
            Ok((file, remark)) => {
                if let Some(remark) = remark {
                    let text = format!("{what}: the picture `{name}` {remark}");
                    self.notes.push(Note::new(Severity::Info, at.clone(), text));
                }
                Some(format!("./{}/{file}", self.folder))
            }
            Err(why) => {
                self.warn(at, format!("{what}: the picture `{name}` is not written: {why}"));
                None
            }
        };
        if let Some(key) = key {
            self.paths.insert(key, path.clone());
        }
        path
    }

    /// Takes tiles, and returns their name with the mark for their numbers (UDIM: 1001 + column + 10 · row).
    fn tiles(&mut self, tiles: &[(PathBuf, [u32; 2])], name: &str) -> Result<(String, Option<String>), String> {
        let mut all = Vec::new();
        for (file, [column, row]) in tiles {
            let (picture, remark) = self.usable(picture::read_file(file)?)?;
            all.push((1001 + column + 10 * row, picture, remark));
        }
        let Some((_, Encoded { kind, .. }, _)) = all.first() else { return Err("it has no tiles".to_owned()) };
        let kind = *kind;
        if all.iter().any(|(_, picture, _)| picture.kind != kind) {
            return Err("its tiles are of several kinds".to_owned());
        }
        let name = self.names.free(&name.replace(TILE, "UDIM"), kind, true);
        let (stem, ending) = name.rsplit_once('.').unwrap_or((&name, ""));
        let mut remark = None;
        for (number, picture, own) in all {
            self.taken.push((format!("{stem}.{number}.{ending}"), picture));
            remark = remark.or(own);
        }
        Ok((format!("{stem}.{TILE}.{ending}"), remark))
    }

    /// The picture's file, in a kind that USD programs read (UsdPreviewSurface 2.6, UsdUVTexture; usdz 1.3, File Types), and
    /// what was done for that.
    fn usable(&self, picture: Encoded) -> Result<(Encoded, Option<String>), String> {
        let is = picture.kind.name();
        match picture.kind {
            Kind::Png | Kind::Jpeg | Kind::Exr | Kind::Avif => Ok((picture, None)),
            Kind::Hdr | Kind::Tiff if self.packed => {
                Err(format!("it is {is}, which a package does not hold; PNG, JPEG, OpenEXR or AVIF would be"))
            }
            Kind::Hdr | Kind::Tiff => Ok((picture, None)),
            Kind::WebP => {
                let kept = || format!("it is {is}, and cannot be made a PNG");
                let decoded = image::load_from_memory_with_format(&picture.bytes, ImageFormat::WebP);
                let mut bytes = Cursor::new(Vec::new());
                decoded.map_err(|_| kept())?.write_to(&mut bytes, ImageFormat::Png).map_err(|_| kept())?;
                let picture = Encoded { bytes: Arc::new(bytes.into_inner()), kind: Kind::Png };
                Ok((picture, Some(format!("is {is}, which USD programs do not read: written as PNG"))))
            }
            Kind::Ktx2 | Kind::Unknown => {
                Err(format!("it is {is}, which USD programs do not read; PNG, JPEG, OpenEXR or AVIF would be"))
            }
        }
    }

    /// The files beside the file `out`.
    pub fn files(&self, out: &Path) -> Vec<(PathBuf, Encoded)> {
        let folder = out.with_file_name(&self.folder);
        self.taken.iter().map(|(file, picture)| (folder.join(file), picture.clone())).collect()
    }

    /// The bytes by the names that the layer has for them.
    pub fn known(&self) -> HashMap<String, Arc<Vec<u8>>> {
        let path = |file: &str| format!("./{}/{file}", self.folder);
        self.taken.iter().map(|(file, picture)| (path(file), picture.bytes.clone())).collect()
    }
}
