//! Pictures on surfaces: texels, and how a parameter of a surface reads them.

use eyebox_base::Shared;
use std::path::PathBuf;
use std::sync::Arc;

/// A picture as its file has it, with alpha (1 where the file has none), row by row from the top left.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Texture {
    /// For people: the file's name, or that of the picture inside of the asset.
    pub name: String,
    pub width: usize,
    pub height: usize,
    #[serde(skip)]
    pub texels: Texels,
}

/// Where the file of a picture is.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum PictureSource {
    File(PathBuf),
    /// In the asset.
    Embedded(Arc<Vec<u8>>),
    /// Tiles, each of a unit of texture coordinates, and where it lies: columns from the left, rows from the bottom.
    Tiles(Vec<(PathBuf, [u32; 2])>),
}

/// Which picture it is: its file, or where its bytes are in memory. Two materials that show one picture have one of these.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum PictureKey {
    File(PathBuf),
    Embedded(usize),
    /// Tiles, by the file of the first.
    Tiles(PathBuf),
}

impl PictureSource {
    pub fn key(&self) -> PictureKey {
        match self {
            PictureSource::File(file) => PictureKey::File(file.clone()),
            PictureSource::Embedded(bytes) => PictureKey::Embedded(Arc::as_ptr(bytes) as usize),
            PictureSource::Tiles(tiles) => {
                PictureKey::Tiles(tiles.first().map_or_else(PathBuf::new, |(file, _)| file.clone()))
            }
        }
    }
}

/// Texels in the precision of their file.
#[derive(Debug, Clone, PartialEq)]
pub enum Texels {
    /// Not read yet: only what a face shows is, when a scene is built. Width and height are 0 until then.
    Encoded(PictureSource),
    /// Of 255.
    Bytes(Arc<Vec<[u8; 4]>>),
    Floats(Arc<Vec<[f32; 4]>>),
}

impl Texels {
    pub fn len(&self) -> usize {
        match self {
            Texels::Encoded(_) => 0,
            Texels::Bytes(texels) => texels.len(),
            Texels::Floats(texels) => texels.len(),
        }
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Bytes of memory.
    pub fn size(&self) -> usize {
        match self {
            Texels::Encoded(_) => 0,
            Texels::Bytes(texels) => 4 * texels.len(),
            Texels::Floats(texels) => 16 * texels.len(),
        }
    }
}

impl Texture {
    /// Whether red, green and blue are the same all over.
    pub fn is_grey(&self) -> bool {
        match &self.texels {
            Texels::Encoded(_) => false,
            Texels::Bytes(texels) => texels.iter().all(|[r, g, b, _]| r == g && r == b),
            Texels::Floats(texels) => texels.iter().all(|[r, g, b, _]| r == g && r == b),
        }
    }
}

/// What the numbers of a picture stand for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Encoding {
    /// Colours by the curve of IEC 61966-2-1; alpha is linear.
    Srgb,
    Linear,
    /// What the file says or, where it says nothing, its kind: bytes of three or four channels are `Srgb`, all else is `Linear`
    /// (UsdPreviewSurface 2.6, `sourceColorSpace = "auto"`). Known when the picture is read: a scene holds none of these.
    OfFile,
}

/// What is outside of the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Wrap {
    Repeat,
    Mirror,
    Clamp,
    Black,
}

/// Between texels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Filter {
    Nearest,
    Linear,
}

/// How a parameter reads a picture.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct TextureInput {
    pub texture: Shared<Texture>,
    pub encoding: Encoding,
    /// Across and down.
    pub wrap: [Wrap; 2],
    pub filter: Filter,
    /// Number of the mesh's set of texture coordinates.
    pub set: u32,
    /// Rows of the affine map from the mesh's coordinates to the picture's, whose (0, 0) is its top left corner and (1, 1)
    /// the bottom right one.
    pub to_picture: [[f64; 3]; 2],
    /// Which component of the texel each of the four is.
    pub channels: [Channel; 4],
    /// What becomes of a texel: texel · scale + bias, by component.
    pub scale: [f64; 4],
    pub bias: [f64; 4],
    /// The texel that stands for a picture which cannot be read, where the format has one.
    pub fallback: Option<[f64; 4]>,
}

impl TextureInput {
    /// Whether what is read has the same of all primaries everywhere.
    pub fn is_grey(&self) -> bool {
        let same = |[r, g, b, _]: [f64; 4]| r == g && r == b;
        let [r, g, b, _] = self.channels;
        same(self.scale) && same(self.bias) && (r == g && r == b || self.texture.is_grey())
    }
}

/// A component of a texel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Channel {
    Red,
    Green,
    Blue,
    Alpha,
}

impl Channel {
    /// Each where it is.
    pub const ALL: [Channel; 4] = [Channel::Red, Channel::Green, Channel::Blue, Channel::Alpha];

    pub fn of(self, texel: [f64; 4]) -> f64 {
        self.pick(texel)
    }

    /// The one of four that stands in its place.
    pub fn pick<T>(self, four: [T; 4]) -> T {
        let [r, g, b, a] = four;
        match self {
            Channel::Red => r,
            Channel::Green => g,
            Channel::Blue => b,
            Channel::Alpha => a,
        }
    }
}

/// A number of a surface: factor · texel.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Scalar {
    pub factor: f64,
    pub texture: Option<(TextureInput, Channel)>,
}

impl Scalar {
    pub const fn new(factor: f64) -> Scalar {
        Scalar { factor, texture: None }
    }
}

/// A colour of a surface, linear Rec.709: factor · texel.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Colour {
    pub factor: [f64; 3],
    pub texture: Option<TextureInput>,
}

impl Colour {
    /// Whether it has the same of all primaries everywhere.
    pub fn is_grey(&self) -> bool {
        let [r, g, b] = self.factor;
        r == g && r == b && self.texture.as_ref().is_none_or(TextureInput::is_grey)
    }

    pub const fn new(factor: [f64; 3]) -> Colour {
        Colour { factor, texture: None }
    }
}
