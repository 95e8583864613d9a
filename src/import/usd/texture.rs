//! Textures of USD: UsdUVTexture and MaterialX' image nodes, with what moves their coordinates.

use super::attribute::PrimView;
use super::light::located;
use super::reader::Reader;
use super::shader::{self, End};
use super::value;
use crate::base::Shared;
use crate::base::fault::Result;
use crate::scene::texture::{Encoding, Filter, PictureSource, Texels, Wrap};
use crate::scene::{Texture, TextureInput};
use openusd::sdf::Value;
use std::path::Path;

/// What a node is.
pub(super) enum Picture {
    Read(Box<TextureInput>),
    /// A picture without a file.
    Missing,
    /// A node of another kind.
    Other(String),
}

/// Rows of an affine map of texture coordinates.
type Affine = [[f64; 3]; 2];

const SAME: Affine = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// `first`, then `then`.
fn after(first: Affine, then: Affine) -> Affine {
    then.map(|[a, b, c]| {
        let [p, q] = first;
        [a * p[0] + b * q[0], a * p[1] + b * q[1], a * p[2] + b * q[2] + c]
    })
}

/// Reads a node as a picture; `encoding` is that of a picture which says none itself and has no file ending of linear ones.
///
/// # Errors
/// What the library cannot read.
pub(super) fn read(reader: &mut Reader, node: &PrimView, encoding: Encoding) -> Result<Picture> {
    let id = shader::id(node)?;
    let preview = id == "UsdUVTexture" || id.starts_with("ND_UsdUVTexture");
    let tiled = id.starts_with("ND_tiledimage");
    if !(preview || tiled || id.starts_with("ND_image")) {
        return Ok(Picture::Other(id));
    }
    let file = match shader::follow(reader, node, "inputs:file")? {
        End::Value(Value::AssetPath(path), at) => located(node, &path).map(|file| (file, at)),
        End::Value(..) | End::Node(..) | End::Nothing => None,
    };
    let Some((file, at)) = file else {
        reader.ledger.warn(node.at(), "a picture without a file: not used");
        return Ok(Picture::Missing);
    };
    if file.to_string_lossy().contains("<UDIM>") {
        reader.ledger.warn(at, "a picture in tiles (`<UDIM>`) is not used yet");
        return Ok(Picture::Missing);
    }
    let mut to_mesh = SAME;
    if preview {
        to_mesh = coordinates(reader, node, "inputs:st")?;
    } else {
        to_mesh = after(coordinates(reader, node, "inputs:texcoord")?, to_mesh);
        if tiled {
            let tiling = two(reader, node, "uvtiling")?.unwrap_or([1.0; 2]);
            let offset = two(reader, node, "uvoffset")?.unwrap_or([0.0; 2]);
            to_mesh = after(to_mesh, [[tiling[0], 0.0, -offset[0]], [0.0, tiling[1], -offset[1]]]);
        }
    }
    let space = match preview {
        true => text(reader, node, "sourceColorSpace")?,
        false => node.property_text("inputs:file", "colorSpace")?,
    };
    let linear = file.extension().is_some_and(|end| end.eq_ignore_ascii_case("exr") || end.eq_ignore_ascii_case("hdr"));
    let encoding = match space.as_deref() {
        Some("raw" | "linear" | "lin_rec709" | "Raw") => Encoding::Linear,
        Some("sRGB" | "srgb_texture") => Encoding::Srgb,
        None | Some("auto" | "") => {
            if linear {
                Encoding::Linear
            } else {
                encoding
            }
        }
        Some(other) => {
            let text = format!("the colour space `{other}` of a picture is not known: taken by what it is used for");
            reader.ledger.warn(node.at(), text);
            encoding
        }
    };
    let names = if preview { ["wrapS", "wrapT"] } else { ["uaddressmode", "vaddressmode"] };
    let mut wrap = [Wrap::Repeat; 2];
    for (wrap, name) in wrap.iter_mut().zip(names) {
        *wrap = match text(reader, node, name)?.as_deref() {
            Some("black" | "constant") => Wrap::Black,
            Some("clamp") => Wrap::Clamp,
            Some("mirror") => Wrap::Mirror,
            // UsdUVTexture's default is what the file says, and files say nothing: black, as its specification has it.
            None | Some("useMetadata") if preview => Wrap::Black,
            Some(_) | None => Wrap::Repeat,
        };
    }
    let four = |reader: &mut Reader, name: &str, default: f64| -> Result<[f64; 4]> {
        Ok(match shader::follow(reader, node, &format!("inputs:{name}"))? {
            End::Value(found, _) => value::four(&found).unwrap_or([default; 4]),
            End::Node(..) | End::Nothing => [default; 4],
        })
    };
    let (scale, bias) =
        if preview { (four(reader, "scale", 1.0)?, four(reader, "bias", 0.0)?) } else { ([1.0; 4], [0.0; 4]) };
    let name = file.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    reader.charge(node.path(), 1, size_of::<Texture>() + name.len() + file.as_os_str().len())?;
    let texels = Texels::Encoded(PictureSource::File(Path::new(&file).to_owned()));
    Ok(Picture::Read(Box::new(TextureInput {
        texture: Shared::from(Texture { name, width: 0, height: 0, texels }),
        encoding,
        wrap,
        filter: Filter::Linear,
        set: 0,
        // USD's t runs up from the bottom row.
        to_picture: after(to_mesh, [[1.0, 0.0, 0.0], [0.0, -1.0, 1.0]]),
        scale,
        bias,
    })))
}

/// What becomes of the mesh's texture coordinates on their way to an input.
fn coordinates(reader: &mut Reader, node: &PrimView, input: &str) -> Result<Affine> {
    // Transforms in a row.
    const MOST: usize = 8;
    let mut all = SAME;
    let mut next = shader::follow(reader, node, input)?;
    for _ in 0..MOST {
        let End::Node(here, _) = next else { return Ok(all) };
        let id = shader::id(&here)?;
        match id.as_str() {
            "UsdTransform2d" => {
                let scale = two(reader, &here, "scale")?.unwrap_or([1.0; 2]);
                let translation = two(reader, &here, "translation")?.unwrap_or([0.0; 2]);
                let turn = match shader::follow(reader, &here, "inputs:rotation")? {
                    End::Value(found, _) => value::number(&found).unwrap_or(0.0),
                    End::Node(..) | End::Nothing => 0.0,
                };
                let (sin, cos) = turn.to_radians().sin_cos();
                let own = [
                    [cos * scale[0], -sin * scale[1], translation[0]],
                    [sin * scale[0], cos * scale[1], translation[1]],
                ];
                all = after(own, all);
                next = shader::follow(reader, &here, "inputs:in")?;
            }
            name if name.starts_with("UsdPrimvarReader_float2")
                || name.starts_with("ND_texcoord")
                || name.starts_with("ND_geompropvalue_vector2") =>
            {
                return Ok(all);
            }
            other => {
                reader.ledger.warn(here.at(), format!("the node `{other}` on texture coordinates is not used"));
                return Ok(all);
            }
        }
    }
    Ok(all)
}

fn two(reader: &mut Reader, node: &PrimView, name: &str) -> Result<Option<[f64; 2]>> {
    Ok(match shader::follow(reader, node, &format!("inputs:{name}"))? {
        End::Value(found, _) => value::pair(&found),
        End::Node(..) | End::Nothing => None,
    })
}

fn text(reader: &mut Reader, node: &PrimView, name: &str) -> Result<Option<String>> {
    Ok(match shader::follow(reader, node, &format!("inputs:{name}"))? {
        End::Value(found, _) => value::text(&found).map(str::to_owned),
        End::Node(..) | End::Nothing => None,
    })
}
