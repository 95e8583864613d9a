//! Pictures of USD: UsdUVTexture and MaterialX' image nodes.

use super::attribute::PrimView;
use super::coordinates::{self, SAME, after, scaled, shifted};
use super::fold::{Folded, Lanes};
use super::light::located;
use super::network;
use super::reader::Reader;
use super::shader::{self, End};
use eyebox_base::error::Result;
use eyebox_base::{Shared, package};
use eyebox_scene::texture::{Channel, Encoding, Filter, PictureSource, Texels, Wrap};
use eyebox_scene::{Texture, TextureInput};
use openusd::sdf::Value;
use std::path::{Path, PathBuf};

/// Where the two families of nodes differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Family {
    Preview,
    /// `image` and `tiledimage`.
    MaterialX {
        tiled: bool,
        /// Of colours rather than of numbers.
        color: bool,
    },
}

/// The family of a node, by its kind and name.
pub(super) fn family(kind: &str, id: &str) -> Option<Family> {
    let color = id.contains("_color");
    match kind {
        "UsdUVTexture" => Some(Family::Preview),
        "image" => Some(Family::MaterialX { tiled: false, color }),
        "tiledimage" => Some(Family::MaterialX { tiled: true, color }),
        _ => None,
    }
}

/// What a picture's node reads, all four lanes of it; its fallback, with a note, where it names no file.
///
/// # Errors
/// What the library cannot read.
pub(super) fn read(reader: &mut Reader, node: &PrimView, family: Family) -> Result<Folded> {
    // What stands for a picture that is not there.
    let absent = match family {
        Family::Preview => network::lanes(reader, node, "fallback", [0.0, 0.0, 0.0, 1.0])?,
        Family::MaterialX { .. } => network::lanes(reader, node, "default", [0.0, 0.0, 0.0, 1.0])?,
    };
    let file = match shader::follow(reader, node, "inputs:file")? {
        End::Value(Value::AssetPath(path), at) => located(node, &path).map(|file| (file, at)),
        End::Value(..) | End::Node(..) | End::Nothing => None,
    };
    let Some((file, at)) = file else {
        reader.ledger.warn(node.at(), "a picture without a file: its fallback is taken");
        return Ok(Folded::constant(absent));
    };
    let tiles = tiles_of(&file);
    if tiles.as_ref().is_some_and(Vec::is_empty) {
        let text = format!("{}: there is none of its tiles, 1001 to 1100; its fallback is taken", file.display());
        reader.ledger.warn(at, text);
        return Ok(Folded::constant(absent));
    }
    let (mut to_mesh, set) = match family {
        Family::Preview => coordinates::read(reader, node, "inputs:st")?,
        Family::MaterialX { .. } => coordinates::read(reader, node, "inputs:texcoord")?,
    };
    if let Family::MaterialX { tiled: true, .. } = family {
        to_mesh = after(to_mesh, tiling(reader, node)?);
    }
    let encoding = encoding(reader, node, family)?;
    let mut wrap = wraps(reader, node, family, absent)?;
    let (scale, bias) = match family {
        Family::Preview => {
            (network::lanes(reader, node, "scale", [1.0; 4])?, network::lanes(reader, node, "bias", [0.0; 4])?)
        }
        Family::MaterialX { .. } => ([1.0; 4], [0.0; 4]),
    };
    let mut filter = match network::text(reader, node, "filtertype")?.as_deref() {
        Some("closest") => Filter::Nearest,
        Some(_) | None => Filter::Linear,
    };
    if family == Family::Preview
        && let Some([s, t]) = coordinates::constant(reader, node, "inputs:st")?
    {
        // One texel is all of it; on the edge it is the one inside.
        reader.ledger.info(node.at(), "a picture whose `st` is not connected: one texel of it is seen");
        to_mesh = [[0.0, 0.0, s], [0.0, 0.0, t]];
        filter = Filter::Nearest;
        if [s, t].iter().all(|x| (0.0..=1.0).contains(x)) {
            wrap = [Wrap::Clamp; 2];
        }
    }
    let name = file.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    reader.charge(node.path(), 1, size_of::<Texture>() + name.len() + file.as_os_str().len())?;
    let texels = Texels::Encoded(tiles.map_or(PictureSource::File(file), PictureSource::Tiles));
    // The fallback is neither scaled nor moved: as a texel it is what comes out so.
    let texel = |lane: usize| if scale[lane] == 0.0 { absent[lane] } else { (absent[lane] - bias[lane]) / scale[lane] };
    let input = TextureInput {
        texture: Shared::from(Texture { name, width: 0, height: 0, texels }),
        encoding,
        wrap,
        filter,
        set: 0,
        // USD's t runs up from the bottom row, and so does MaterialX' v.
        to_picture: after(to_mesh, [[1.0, 0.0, 0.0], [0.0, -1.0, 1.0]]),
        channels: Channel::ALL,
        scale,
        bias,
        fallback: Some(std::array::from_fn(texel)),
    };
    Ok(Folded::picture(input, set))
}

/// The tiles of a picture whose name has `<UDIM>` for their numbers, with their places; none of other names.
pub(super) fn tiles_of(file: &Path) -> Option<Vec<(PathBuf, [u32; 2])>> {
    let name = file.to_str().filter(|name| name.contains(TILE))?;
    // UsdUVTexture: the number is 1001 + column + 10 · row, ten columns.
    let all = (0..100).map(|at| (PathBuf::from(name.replace(TILE, &(1001 + at).to_string())), [at % 10, at / 10]));
    Some(all.filter(|(file, _)| package::is_file(file)).collect())
}

/// What stands for the number of a tile.
pub(super) const TILE: &str = "<UDIM>";

/// MaterialX 1.39, tiledimage: coordinates times `uvtiling`, less `uvoffset`, over the size of the picture, times that of a
/// tile.
fn tiling(reader: &mut Reader, node: &PrimView) -> Result<coordinates::Affine> {
    let repeats = network::pair(reader, node, "uvtiling", [1.0; 2])?;
    let offset = network::pair(reader, node, "uvoffset", [0.0; 2])?;
    let image = network::pair(reader, node, "realworldimagesize", [1.0; 2])?;
    let tile = network::pair(reader, node, "realworldtilesize", [1.0; 2])?;
    let steps = [scaled(repeats), shifted(offset.map(|x| -x)), scaled(image.map(f64::recip)), scaled(tile)];
    Ok(steps.into_iter().fold(SAME, after))
}

/// What the numbers of the picture stand for: what is said, else `auto` of the specification; numbers of MaterialX are no
/// colours.
fn encoding(reader: &mut Reader, node: &PrimView, family: Family) -> Result<Encoding> {
    let (space, unsaid) = match family {
        Family::Preview => (network::text(reader, node, "sourceColorSpace")?, Encoding::OfFile),
        Family::MaterialX { color, .. } => {
            let unsaid = if color { Encoding::OfFile } else { Encoding::Linear };
            (node.property_text("inputs:file", "colorSpace")?, unsaid)
        }
    };
    Ok(match space.as_deref() {
        None | Some("auto" | "") => unsaid,
        // The names of UsdUVTexture, of MaterialX 1.39 and of OpenColorIO's and USD's common spaces.
        Some("raw" | "Raw" | "none" | "data" | "linear" | "lin_rec709" | "lin_srgb" | "lin_rec709_scene") => {
            Encoding::Linear
        }
        Some("sRGB" | "srgb" | "srgb_texture" | "srgb_rec709_scene") => Encoding::Srgb,
        Some(other) => {
            let text = format!("the colour space `{other}` of a picture is not known: taken by the kind of its file");
            reader.ledger.warn(node.at(), text);
            unsaid
        }
    })
}

fn wraps(reader: &mut Reader, node: &PrimView, family: Family, absent: Lanes) -> Result<[Wrap; 2]> {
    let names = match family {
        Family::Preview => ["wrapS", "wrapT"],
        Family::MaterialX { .. } => ["uaddressmode", "vaddressmode"],
    };
    let mut out = [Wrap::Repeat; 2];
    for (wrap, name) in out.iter_mut().zip(names) {
        let said = network::text(reader, node, name)?;
        *wrap = match (said.as_deref(), family) {
            // UsdUVTexture's default is what the file says, and files say nothing: black, as its specification has it.
            (None | Some("useMetadata"), Family::Preview) => Wrap::Black,
            (Some("black"), Family::Preview) => Wrap::Black,
            (Some("constant"), Family::MaterialX { .. }) => {
                if absent[..3] != [0.0; 3] {
                    reader
                        .ledger
                        .warn(node.at_property("inputs:default"), "outside of a picture it is black, not this");
                }
                Wrap::Black
            }
            (Some("clamp"), _) => Wrap::Clamp,
            (Some("mirror"), _) => Wrap::Mirror,
            (Some("repeat"), Family::Preview) | (None | Some("periodic"), Family::MaterialX { .. }) => Wrap::Repeat,
            (Some(other), Family::Preview | Family::MaterialX { .. }) => {
                let text = format!("the wrapping mode `{other}` is none of this node: the picture repeats");
                reader.ledger.warn(node.at_property(&format!("inputs:{name}")), text);
                Wrap::Repeat
            }
        };
    }
    Ok(out)
}
