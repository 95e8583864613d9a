//! How the surface shaders that we know look, as a [`StandardSurface`]: their numbers, and the pictures that networks of
//! UsdUVTexture or MaterialX' image nodes read.
//!
//! Sources: the UsdPreviewSurface specification 2.6; OpenPBR Surface 1.1; the Standard Surface paper (Autodesk, 1.0.1).

use super::attribute::PrimView;
use super::reader::Reader;
use super::shader::{self, End};
use super::texture::{self, Picture};
use super::value;
use crate::base::fault::Result;
use crate::scene::texture::{Channel, Encoding};
use crate::scene::{Colour, Opacity, Scalar, StandardSurface};

/// The inputs of one shader.
struct Shader<'a> {
    reader: &'a mut Reader,
    view: &'a PrimView,
}

/// A UsdPreviewSurface; what is not said has the values of its specification.
///
/// # Errors
/// What the library cannot read.
pub(super) fn preview(reader: &mut Reader, view: &PrimView) -> Result<StandardSurface> {
    let mut shader = Shader { reader, view };
    let mut out = StandardSurface {
        name: view.name().to_owned(),
        base_color: shader.colour("diffuseColor", [0.18; 3])?,
        metallic: shader.scalar("metallic", 0.0)?,
        roughness: shader.scalar("roughness", 0.5)?,
        ior: shader.plain("ior", 1.5)?.max(1.0),
        coat: shader.scalar("clearcoat", 0.0)?,
        coat_roughness: shader.scalar("clearcoatRoughness", 0.01)?,
        normal: shader.normal("normal")?,
        ..StandardSurface::default()
    };
    if shader.plain("useSpecularWorkflow", 0.0)? != 0.0 {
        // The colour at normal incidence: where the index gives (1 − n)²/(1 + n)², it is a factor of that.
        out.metallic = Scalar::new(0.0);
        let mut colour = shader.colour("specularColor", [0.0; 3])?;
        let straight = ((out.ior - 1.0) / (out.ior + 1.0)).powi(2);
        if straight > 0.0 {
            colour.factor = colour.factor.map(|c| c / straight);
            out.specular_color = colour;
        }
    }
    let threshold = shader.plain("opacityThreshold", 0.0)?;
    let alpha = shader.scalar("opacity", 1.0)?;
    out.opacity = opacity(alpha, threshold);
    for name in ["displacement", "occlusion"] {
        if let End::Node(..) = shader::follow(shader.reader, view, &format!("inputs:{name}"))? {
            let at = view.at_property(&format!("inputs:{name}"));
            shader.reader.ledger.info(at, format!("`{name}` of a surface is not used"));
        }
    }
    Ok(out)
}

/// An OpenPBR surface (`open_pbr`) or a standard surface.
///
/// # Errors
/// What the library cannot read.
pub(super) fn layered(reader: &mut Reader, view: &PrimView, open_pbr: bool) -> Result<StandardSurface> {
    let names = if open_pbr { &OPEN_PBR } else { &STANDARD };
    let mut shader = Shader { reader, view };
    let weight = shader.plain(names.base, names.base_weight)?;
    let mut base_color = shader.colour(names.base_color, [0.8; 3])?;
    base_color.factor = base_color.factor.map(|c| c * weight);
    let sheen = shader.plain(names.sheen, 0.0)?;
    let mut sheen_color = shader.colour(names.sheen_color, [1.0; 3])?;
    sheen_color.factor = sheen_color.factor.map(|c| c * sheen);
    let alpha = shader.scalar(names.opacity, 1.0)?;
    Ok(StandardSurface {
        name: view.name().to_owned(),
        base_color,
        metallic: shader.scalar(names.metallic, 0.0)?,
        roughness: shader.scalar("specular_roughness", names.roughness)?,
        ior: shader.plain(names.ior, 1.5)?.max(1.0),
        specular: shader.scalar(names.specular, 1.0)?,
        specular_color: shader.colour("specular_color", [1.0; 3])?,
        transmission: shader.scalar(names.transmission, 0.0)?,
        coat: shader.scalar(names.coat, 0.0)?,
        coat_roughness: shader.scalar("coat_roughness", names.coat_roughness)?,
        sheen_color,
        sheen_roughness: shader.scalar(names.sheen_roughness, names.sheen_rough)?,
        normal: shader.normal(names.normal)?,
        opacity: opacity(alpha, 0.0),
        ..StandardSurface::default()
    })
}

/// Where the two layered models differ in names and defaults.
struct Names {
    base: &'static str,
    base_weight: f64,
    base_color: &'static str,
    metallic: &'static str,
    roughness: f64,
    ior: &'static str,
    specular: &'static str,
    transmission: &'static str,
    coat: &'static str,
    coat_roughness: f64,
    sheen: &'static str,
    sheen_color: &'static str,
    sheen_roughness: &'static str,
    sheen_rough: f64,
    normal: &'static str,
    opacity: &'static str,
}

const OPEN_PBR: Names = Names {
    base: "base_weight",
    base_weight: 1.0,
    base_color: "base_color",
    metallic: "base_metalness",
    roughness: 0.3,
    ior: "specular_ior",
    specular: "specular_weight",
    transmission: "transmission_weight",
    coat: "coat_weight",
    coat_roughness: 0.0,
    sheen: "fuzz_weight",
    sheen_color: "fuzz_color",
    sheen_roughness: "fuzz_roughness",
    sheen_rough: 0.5,
    normal: "geometry_normal",
    opacity: "geometry_opacity",
};

const STANDARD: Names = Names {
    base: "base",
    base_weight: 1.0,
    base_color: "base_color",
    metallic: "metalness",
    roughness: 0.2,
    ior: "specular_IOR",
    specular: "specular",
    transmission: "transmission",
    coat: "coat",
    coat_roughness: 0.1,
    sheen: "sheen",
    sheen_color: "sheen_color",
    sheen_roughness: "sheen_roughness",
    sheen_rough: 0.3,
    normal: "normal",
    opacity: "opacity",
};

fn opacity(alpha: Scalar, threshold: f64) -> Opacity {
    if threshold > 0.0 {
        Opacity::Mask { alpha, cutoff: threshold }
    } else if alpha.texture.is_none() && alpha.factor >= 1.0 {
        Opacity::Opaque
    } else {
        Opacity::Blend { alpha }
    }
}

impl Shader<'_> {
    /// A number that is no picture.
    fn plain(&mut self, name: &str, default: f64) -> Result<f64> {
        Ok(match shader::follow(self.reader, self.view, &format!("inputs:{name}"))? {
            End::Value(found, _) => {
                value::flag(&found).map_or(default, |flag| value::number(&found).unwrap_or(f64::from(u8::from(flag))))
            }
            End::Node(..) | End::Nothing => default,
        })
    }

    fn scalar(&mut self, name: &str, default: f64) -> Result<Scalar> {
        let default = Scalar::new(default);
        Ok(match shader::follow(self.reader, self.view, &format!("inputs:{name}"))? {
            End::Value(found, _) => {
                // An opacity of MaterialX' is a colour.
                let number = value::number(&found).or_else(|| value::triple(&found).map(|[r, g, b]| (r + g + b) / 3.0));
                number.filter(|x| x.is_finite()).map_or(default, |x| Scalar::new(x.clamp(0.0, 1.0)))
            }
            End::Node(node, output) => match self.picture(name, &node, Encoding::Linear)? {
                Some(picture) => {
                    let channel = match output.as_str() {
                        "outputs:g" => Channel::Green,
                        "outputs:b" => Channel::Blue,
                        "outputs:a" => Channel::Alpha,
                        _ => Channel::Red,
                    };
                    Scalar { factor: 1.0, texture: Some((picture, channel)) }
                }
                None => default,
            },
            End::Nothing => default,
        })
    }

    fn colour(&mut self, name: &str, default: [f64; 3]) -> Result<Colour> {
        let default = Colour::new(default);
        Ok(match shader::follow(self.reader, self.view, &format!("inputs:{name}"))? {
            End::Value(found, _) => {
                let colour = value::triple(&found).filter(|c| c.iter().all(|c| c.is_finite()));
                colour.map_or(default, |c| Colour::new(c.map(|c| c.max(0.0))))
            }
            End::Node(node, _) => match self.picture(name, &node, Encoding::Srgb)? {
                Some(picture) => Colour { factor: [1.0; 3], texture: Some(picture) },
                None => default,
            },
            End::Nothing => default,
        })
    }

    fn normal(&mut self, name: &str) -> Result<Option<(crate::scene::TextureInput, f64)>> {
        Ok(match shader::follow(self.reader, self.view, &format!("inputs:{name}"))? {
            End::Node(node, _) => {
                // MaterialX has a node that makes normals of the picture's texels, which are 0 to 1.
                let map = shader::id(&node)?.starts_with("ND_normalmap");
                let inner = if map { shader::follow(self.reader, &node, "inputs:in")? } else { End::Nothing };
                let node = match inner {
                    End::Node(inner, _) => inner,
                    End::Value(..) | End::Nothing => node,
                };
                self.picture(name, &node, Encoding::Linear)?.map(|mut picture| {
                    if map {
                        (picture.scale, picture.bias) = ([2.0, 2.0, 2.0, 1.0], [-1.0, -1.0, -1.0, 0.0]);
                    }
                    (picture, 1.0)
                })
            }
            End::Value(..) | End::Nothing => None,
        })
    }

    /// The picture that a node reads; none, with a note, if it is another kind of node.
    fn picture(
        &mut self,
        name: &str,
        node: &PrimView,
        encoding: Encoding,
    ) -> Result<Option<crate::scene::TextureInput>> {
        match texture::read(self.reader, node, encoding)? {
            Picture::Read(input) => Ok(Some(*input)),
            Picture::Missing => Ok(None),
            Picture::Other(kind) => {
                let at = self.view.at_property(&format!("inputs:{name}"));
                let what =
                    if kind.is_empty() { "a node without `info:id`".to_owned() } else { format!("the node `{kind}`") };
                self.reader.ledger.warn(at, format!("{what} as `{name}` of a surface is not used"));
                Ok(None)
            }
        }
    }
}
