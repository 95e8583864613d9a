//! Textures of a new document: pictures, samplers and what reads them, each once.

use super::super::picture::{self, Encoded, Kind, Names};
use super::document::Document;
use super::uri;
use super::value;
use eyebox_base::Where;
use eyebox_scene::TextureInput;
use eyebox_scene::assembly::Assembly;
use eyebox_scene::texture::PictureKey;
use eyebox_scene::texture::{Channel, Encoding, Filter, Texture, Wrap};
use serde_json::{Map, Value as Json, json};
use std::collections::HashMap;

const TRANSFORM: &str = "KHR_texture_transform";

/// A picture that goes into the asset.
#[derive(Debug)]
pub struct Image {
    /// The name of its file beside a `.gltf`.
    pub file: String,
    name: String,
    picture: Encoded,
}

#[derive(Debug, Default)]
pub struct Textures {
    images: Vec<Image>,
    samplers: Vec<Json>,
    textures: Vec<Json>,
    /// What became of each picture so far.
    known: HashMap<PictureKey, Option<usize>>,
    /// Files that were read.
    read: HashMap<PictureKey, Result<Encoded, String>>,
    names: Names,
}

/// What reads a texture: for the notes, and for what is asked of its faces.
#[derive(Debug, Clone, Copy)]
pub struct Reading<'a> {
    pub assembly: &'a Assembly,
    pub material: usize,
    pub at: &'a Where,
    /// Which parameter of which material.
    pub what: &'a str,
}

/// The type of a kind of pictures and the extension that allows it, if glTF has it at all (2.0, section 3.8.3).
fn allowed(kind: Kind) -> Option<(&'static str, Option<&'static str>)> {
    match kind {
        Kind::Png => Some(("image/png", None)),
        Kind::Jpeg => Some(("image/jpeg", None)),
        Kind::WebP => Some(("image/webp", Some("EXT_texture_webp"))),
        Kind::Ktx2 => Some(("image/ktx2", Some("KHR_texture_basisu"))),
        Kind::Avif => Some(("image/avif", Some("EXT_texture_avif"))),
        Kind::Exr | Kind::Hdr | Kind::Tiff | Kind::Unknown => None,
    }
}

impl Document {
    /// The reference to a texture that reads `input`; none, with a note, where glTF cannot hold its picture.
    pub fn texture(&mut self, input: &TextureInput, reading: Reading<'_>) -> Option<Json> {
        let image = self.image(&input.texture, reading)?;
        let sampler = self.sampler(input, reading);
        let kind = self.textures.images.get(image)?.picture.kind;
        let mut texture = Map::new();
        match allowed(kind)?.1 {
            None => drop(texture.insert("source".into(), Json::from(image))),
            Some(extension) => {
                self.uses(extension);
                // Nothing else can be shown in its place.
                self.requires(extension);
                texture.insert("extensions".into(), json!({ extension: { "source": image } }));
            }
        }
        if let Some(sampler) = sampler {
            texture.insert("sampler".into(), Json::from(index_of(&mut self.textures.samplers, sampler)));
        }
        let index = index_of(&mut self.textures.textures, Json::Object(texture));
        let mut out = json!({ "index": index });
        if input.set > 0 {
            out["texCoord"] = Json::from(input.set);
        }
        let moved = Moved::of(self.reads_down(input.to_picture));
        if moved.slanted {
            let what =
                format!("{}: a slanted map of texture coordinates has no form in glTF: written square", reading.what);
            self.note(reading.at, what);
        }
        let mut transform = Map::new();
        let mut put = |key: &str, pair: [f64; 2], unsaid: [f64; 2]| {
            if pair != unsaid {
                let pair: Vec<Json> = pair.into_iter().filter_map(value::number).collect();
                transform.insert(key.into(), Json::Array(pair));
            }
        };
        put("offset", moved.offset, [0.0; 2]);
        put("scale", moved.scale, [1.0; 2]);
        if moved.rotation != 0.0 {
            transform.insert("rotation".into(), json!(moved.rotation));
        }
        if !transform.is_empty() {
            self.uses(TRANSFORM);
            out["extensions"] = json!({ TRANSFORM: transform });
        }
        Some(out)
    }

    /// The number of a picture.
    fn image(&mut self, texture: &Texture, reading: Reading<'_>) -> Option<usize> {
        let key = picture::key(texture);
        if let Some(known) = key.as_ref().and_then(|key| self.textures.known.get(key)) {
            return *known;
        }
        let name = &texture.name;
        let image = match self.textures.file(texture) {
            Err(why) => {
                self.note(reading.at, format!("{}: the picture `{name}` is not written: {why}", reading.what));
                None
            }
            Ok(picture) if allowed(picture.kind).is_none() => {
                let is = picture.kind.name();
                let what = format!(
                    "{}: the picture `{name}` is {is}, which glTF does not hold: not written; PNG, JPEG, WebP, KTX2 or AVIF would be",
                    reading.what
                );
                self.note(reading.at, what);
                None
            }
            Ok(picture) => {
                let file = self.textures.names.free(name, picture.kind, false);
                self.textures.images.push(Image { file, name: name.clone(), picture });
                Some(self.textures.images.len() - 1)
            }
        };
        if let Some(key) = key {
            self.textures.known.insert(key, image);
        }
        image
    }

    /// Whether the picture of `input` may have an alpha other than 1.
    pub fn may_have_alpha(&mut self, input: &TextureInput) -> bool {
        self.textures.file(&input.texture).is_ok_and(|own| picture::may_have_alpha(&own))
    }
    /// Whether red, green and blue of the picture of `input` are the same.
    pub fn is_grey(&mut self, input: &TextureInput) -> bool {
        self.textures.file(&input.texture).is_ok_and(|own| picture::is_grey(&own))
    }
    /// The mean of a component of the picture of `input`; 1 where it is not known.
    pub fn mean(&mut self, input: &TextureInput, channel: Channel) -> f64 {
        let file = self.textures.file(&input.texture).ok();
        file.and_then(|own| picture::mean(&own, channel)).unwrap_or(1.0)
    }

    /// Whether the format has pictures of this kind.
    pub fn may_hold(&mut self, input: &TextureInput) -> bool {
        self.textures.file(&input.texture).is_ok_and(|own| allowed(own.kind).is_some())
    }

    /// Whether the colours of `input` are by the curve of sRGB; what is grey and has 8 bits is not, where the file decides.
    pub fn is_srgb(&mut self, input: &TextureInput) -> bool {
        match input.encoding {
            Encoding::Srgb => true,
            Encoding::Linear => false,
            Encoding::OfFile => {
                self.textures.file(&input.texture).is_ok_and(|own| picture::encoding(&own) == Encoding::Srgb)
            }
        }
    }

    /// The sampler; none where it is glTF's own: repeating, filtered as the program likes.
    fn sampler(&mut self, input: &TextureInput, reading: Reading<'_>) -> Option<Json> {
        let mut out = Map::new();
        if input.wrap.contains(&Wrap::Black) && leaves(reading.assembly, reading.material, input) {
            let text = format!(
                "{}: black outside of the picture `{}` has no form in glTF: its edge is written",
                reading.what, input.texture.name
            );
            self.note(reading.at, text);
        }
        for (key, wrap) in ["wrapS", "wrapT"].into_iter().zip(input.wrap) {
            match wrap {
                Wrap::Repeat => {}
                Wrap::Mirror => drop(out.insert(key.into(), Json::from(33648))),
                Wrap::Clamp | Wrap::Black => drop(out.insert(key.into(), Json::from(33071))),
            }
        }
        match input.filter {
            Filter::Linear => {}
            Filter::Nearest => drop(out.insert("magFilter".into(), Json::from(9728))),
        }
        (!out.is_empty()).then_some(Json::Object(out))
    }
}

/// The entry of a list, put there where it is not yet.
fn index_of(list: &mut Vec<Json>, item: Json) -> usize {
    list.iter().position(|own| *own == item).unwrap_or_else(|| {
        list.push(item);
        list.len() - 1
    })
}

/// Whether a face of the material reads outside of the picture.
fn leaves(assembly: &Assembly, material: usize, input: &TextureInput) -> bool {
    // Coordinates are single precision, and turning them over rounds.
    const SLACK: f64 = 1e-5;
    assembly.meshes.iter().any(|source| {
        let mesh = &source.mesh;
        let set = if input.set > 0 { &mesh.second_uvs } else { &mesh.uvs };
        let faces = mesh.faces.iter().zip(&source.materials).filter(|(_, own)| **own == Some(material));
        let mut corners =
            faces.flat_map(|(face, _)| mesh.triangles.get(face.triangles()).into_iter().flatten().flatten());
        corners.any(|corner| {
            let [u, v] = set.get(*corner as usize).copied().unwrap_or_default().map(f64::from);
            let [across, down] = input.to_picture.map(|[a, b, c]| a * u + b * v + c);
            !(-SLACK..=1.0 + SLACK).contains(&across) || !(-SLACK..=1.0 + SLACK).contains(&down)
        })
    })
}

/// `KHR_texture_transform`: scaled, turned, moved.
#[derive(Debug)]
struct Moved {
    offset: [f64; 2],
    rotation: f64,
    scale: [f64; 2],
    /// Whether the map is slanted, which the extension cannot say.
    slanted: bool,
}

impl Moved {
    /// Of an affine map: [cos · sx, sin · sy, x], [−sin · sx, cos · sy, y].
    fn of([[a, b, x], [c, d, y]]: [[f64; 3]; 2]) -> Moved {
        if b == 0.0 && c == 0.0 {
            return Moved { offset: [x, y], rotation: 0.0, scale: [a, d], slanted: false };
        }
        let (across, other) = (a.hypot(c), b.hypot(d));
        let (sin, cos) = if across > 0.0 { (-c / across, a / across) } else { (b / other, d / other) };
        let down = b * sin + d * cos;
        let off = (b - sin * down).hypot(d - cos * down);
        let slanted = off > 1e-6 * (across + down.abs());
        Moved { offset: [x, y], rotation: sin.atan2(cos), scale: [across, down], slanted }
    }
}

impl Textures {
    fn file(&mut self, texture: &Texture) -> Result<Encoded, String> {
        match picture::key(texture) {
            None => picture::read(texture),
            Some(key) => self.read.entry(key).or_insert_with(|| picture::read(texture)).clone(),
        }
    }
}

/// Where the pictures of a document go.
pub enum Place<'a> {
    /// Into the buffer, whose first free view has this number.
    Buffer(usize),
    /// Files of this folder, which is beside the asset.
    Beside(&'a str),
}

/// Lists of the document by their names, and files by theirs.
type Finished = ([(&'static str, Vec<Json>); 3], Vec<(String, Encoded)>);

impl Textures {
    /// `images`, `samplers`, `textures`, and the pictures in the order of `images`.
    pub fn finish(self, place: Place<'_>) -> Finished {
        let image = |(index, image): (usize, &Image)| {
            let mime = allowed(image.picture.kind).map_or("", |(mime, _)| mime);
            match place {
                Place::Buffer(first) => json!({ "name": image.name, "mimeType": mime, "bufferView": first + index }),
                Place::Beside(folder) => json!({ "uri": uri::encoded(&format!("{folder}/{}", image.file)) }),
            }
        };
        let images = self.images.iter().enumerate().map(image).collect();
        let files = self.images.into_iter().map(|image| (image.file, image.picture)).collect();
        ([("images", images), ("samplers", self.samplers), ("textures", self.textures)], files)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transforms_come_back_and_slants_are_seen() {
        let there = |[x, y]: [f64; 2], turn: f64, [sx, sy]: [f64; 2]| {
            let (sin, cos) = turn.sin_cos();
            [[cos * sx, sin * sy, x], [-sin * sx, cos * sy, y]]
        };
        for (offset, turn, scale) in [
            ([0.1, -0.2], 0.0, [2.0, -3.0]),
            ([0.0, 1.0], 0.7, [1.0, 1.0]),
            ([0.5, 0.5], -2.9, [0.25, -4.0]),
            ([0.0, 0.0], 1.3, [0.0, 2.0]),
        ] {
            let map = there(offset, turn, scale);
            let moved = Moved::of(map);
            assert!(!moved.slanted);
            let back = there(moved.offset, moved.rotation, moved.scale);
            for (own, other) in map.as_flattened().iter().zip(back.as_flattened()) {
                assert!((own - other).abs() < 1e-14, "{map:?} {back:?}");
            }
        }
        assert!(Moved::of([[1.0, 0.5, 0.0], [0.0, 1.0, 0.0]]).slanted);
    }
}
