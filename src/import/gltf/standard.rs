//! How a material looks: glTF's metallic-roughness model with the extensions that add layers to it, as a
//! [`StandardSurface`]. Sources: glTF 2.0, sections 3.9 and 5.19 to 5.24, and the extensions' own pages.

use super::accessor::Document;
use super::at::At;
use super::notes::Ledger;
use super::picture::{self, Pictures};
use eyebox_base::error::Result;
use eyebox_scene::texture::{Channel, Encoding};
use eyebox_scene::{
    Anisotropy, AnisotropyLaw, CoatNormal, Colour, Film, Opacity, Scalar, StandardSurface, TextureInput,
};

/// One material, and what its parameters are read from.
pub(super) struct Reader<'d, 'a> {
    pub document: &'d Document<'a>,
    pub pictures: &'d mut Pictures,
    pub ledger: &'d mut Ledger,
}

impl Reader<'_, '_> {
    /// The surface of the material at `at`.
    ///
    /// # Errors
    /// Values of the wrong kind or out of range, indices that lead nowhere.
    pub fn surface(&mut self, at: &At<'_>, name: &str) -> Result<StandardSurface> {
        let mut out = StandardSurface { name: name.to_owned(), vertex_colors: true, ..StandardSurface::default() };
        let mut alpha = 1.0;
        let mut alpha_texture = None;
        if let Some(gloss) = at.extension("KHR_materials_pbrSpecularGlossiness")? {
            (alpha, alpha_texture) = self.specular_glossiness(&gloss, &mut out)?;
        } else {
            // What is not said is a rough, white metal.
            (out.metallic, out.roughness) = (Scalar::new(1.0), Scalar::new(1.0));
            if let Some(pbr) = at.get("pbrMetallicRoughness")? {
                (alpha, alpha_texture) = self.metallic_roughness(&pbr, &mut out)?;
            }
        }
        out.normal = self.normal_map(at, "normalTexture")?;
        let alpha = Scalar { factor: alpha, texture: alpha_texture.map(|input| (input, Channel::Alpha)) };
        out.opacity = match at.get("alphaMode")? {
            None => Opacity::Opaque,
            Some(mode) => match mode.text()? {
                "OPAQUE" => Opacity::Opaque,
                "MASK" => {
                    let cutoff =
                        at.get("alphaCutoff")?.map_or(Ok(0.5), |cutoff| cutoff.number_in(0.0, f64::INFINITY))?;
                    Opacity::Mask { alpha, cutoff }
                }
                "BLEND" => Opacity::Blend { alpha },
                other => {
                    let modes = ["OPAQUE", "MASK", "BLEND"];
                    return Err(mode.fault("unknown alpha mode").expected(modes.join(", ")).nearest(other, modes));
                }
            },
        };
        if let Some(ior) = at.extension("KHR_materials_ior")? {
            // 0 reflects everything: specular-glossiness in other words.
            let ior = ior.get("ior")?.map_or(Ok(1.5), |ior| ior.number_in(0.0, f64::INFINITY))?;
            out.ior = if ior == 0.0 { f64::INFINITY } else { ior.max(1.0) };
        }
        out.emission = self.texture_of(at, "emissiveTexture", Encoding::Srgb)?;
        self.layers(at, &mut out)?;
        if at.extension("KHR_materials_unlit")?.is_some() {
            self.ledger.notes.warn(
                at,
                "`KHR_materials_unlit`: the base colour is taken as that of a matt surface in the scene's light",
            );
            (out.metallic, out.specular, out.roughness) = (Scalar::new(0.0), Scalar::new(0.0), Scalar::new(1.0));
        }
        Ok(out)
    }

    fn metallic_roughness(&mut self, pbr: &At<'_>, out: &mut StandardSurface) -> Result<(f64, Option<TextureInput>)> {
        let (colour, alpha) = rgba(pbr, "baseColorFactor")?;
        let texture = self.texture_of(pbr, "baseColorTexture", Encoding::Srgb)?;
        out.base_color = Colour { factor: colour, texture: texture.clone() };
        let both = self.texture_of(pbr, "metallicRoughnessTexture", Encoding::Linear)?;
        let read = |key: &str, channel: Channel| -> Result<Scalar> {
            let factor = number(pbr, key, 1.0)?;
            Ok(Scalar { factor, texture: both.clone().map(|input| (input, channel)) })
        };
        out.metallic = read("metallicFactor", Channel::Blue)?;
        out.roughness = read("roughnessFactor", Channel::Green)?;
        Ok((alpha, texture))
    }

    /// An older model: a dielectric with this diffuse colour that reflects this where light falls straight on.
    fn specular_glossiness(&mut self, at: &At<'_>, out: &mut StandardSurface) -> Result<(f64, Option<TextureInput>)> {
        let (colour, alpha) = rgba(at, "diffuseFactor")?;
        let texture = self.texture_of(at, "diffuseTexture", Encoding::Srgb)?;
        out.base_color = Colour { factor: colour, texture: texture.clone() };
        let gloss = self.texture_of(at, "specularGlossinessTexture", Encoding::Srgb)?;
        // An infinite index reflects all: the colour is the reflectance.
        out.ior = f64::INFINITY;
        out.specular_color = Colour { factor: rgb(at, "specularFactor", [1.0; 3])?, texture: gloss.clone() };
        let factor = number(at, "glossinessFactor", 1.0)?;
        // Roughness = 1 − factor · texel.
        out.roughness = match gloss {
            None => Scalar::new(1.0 - factor),
            Some(input) => {
                let [r, g, b, _] = input.scale;
                let input = TextureInput { scale: [r, g, b, -factor], bias: [0.0, 0.0, 0.0, 1.0], ..input };
                Scalar { factor: 1.0, texture: Some((input, Channel::Alpha)) }
            }
        };
        Ok((alpha, texture))
    }

    fn layers(&mut self, at: &At<'_>, out: &mut StandardSurface) -> Result<()> {
        if let Some(layer) = at.extension("KHR_materials_specular")? {
            out.specular = self.scalar(&layer, "specularFactor", 1.0, "specularTexture", Channel::Alpha)?;
            out.specular_color = self.colour(&layer, "specularColorFactor", [1.0; 3], "specularColorTexture")?;
        }
        if let Some(layer) = at.extension("KHR_materials_transmission")? {
            out.transmission = self.scalar(&layer, "transmissionFactor", 0.0, "transmissionTexture", Channel::Red)?;
        }
        if let Some(layer) = at.extension("KHR_materials_diffuse_transmission")? {
            out.diffuse_transmission =
                self.scalar(&layer, "diffuseTransmissionFactor", 0.0, "diffuseTransmissionTexture", Channel::Alpha)?;
            let (key, texture) = ("diffuseTransmissionColorFactor", "diffuseTransmissionColorTexture");
            out.diffuse_transmission_color = self.colour(&layer, key, [1.0; 3], texture)?;
        }
        if let Some(layer) = at.extension("KHR_materials_clearcoat")? {
            out.coat = self.scalar(&layer, "clearcoatFactor", 0.0, "clearcoatTexture", Channel::Red)?;
            let (key, texture) = ("clearcoatRoughnessFactor", "clearcoatRoughnessTexture");
            out.coat_roughness = self.scalar(&layer, key, 0.0, texture, Channel::Green)?;
            // Without a map of its own the coat is smooth, whatever the base is (KHR_materials_clearcoat).
            out.coat_normal = match self.normal_map(&layer, "clearcoatNormalTexture")? {
                Some((input, strength)) => CoatNormal::Map(input, strength),
                None if out.normal.is_some() => CoatNormal::Smooth,
                None => CoatNormal::Base,
            };
        }
        if let Some(layer) = at.extension("KHR_materials_sheen")? {
            out.sheen_color = self.colour(&layer, "sheenColorFactor", [0.0; 3], "sheenColorTexture")?;
            let (key, texture) = ("sheenRoughnessFactor", "sheenRoughnessTexture");
            out.sheen_roughness = self.scalar(&layer, key, 0.0, texture, Channel::Alpha)?;
        }
        if let Some(layer) = at.extension("KHR_materials_anisotropy")? {
            out.anisotropy = self.anisotropy(&layer)?;
        }
        if let Some(layer) = at.extension("KHR_materials_iridescence")? {
            out.film = self.film(&layer)?;
        }
        Ok(())
    }

    /// `KHR_materials_anisotropy`: red and green of the texture are a direction, blue the strength.
    fn anisotropy(&mut self, layer: &At<'_>) -> Result<Option<Anisotropy>> {
        let factor = number(layer, "anisotropyStrength", 0.0)?;
        let rotation_rad = layer.get("anisotropyRotation")?.map_or(Ok(0.0), |field| field.number())?;
        let texture = self.texture_of(layer, "anisotropyTexture", Encoding::Linear)?;
        let direction = texture.clone().map(|input| TextureInput {
            scale: [2.0, 2.0, 1.0, 1.0],
            bias: [-1.0, -1.0, 0.0, 0.0],
            ..input
        });
        let strength = Scalar { factor, texture: texture.map(|input| (input, Channel::Blue)) };
        Ok((factor > 0.0).then_some(Anisotropy { strength, law: AnisotropyLaw::Gltf, rotation_rad, direction }))
    }

    /// `KHR_materials_iridescence`: the greatest thickness where no texture says otherwise.
    fn film(&mut self, layer: &At<'_>) -> Result<Option<Film>> {
        let weight = self.scalar(layer, "iridescenceFactor", 0.0, "iridescenceTexture", Channel::Red)?;
        let ior = layer.get("iridescenceIor")?.map_or(Ok(1.3), |ior| ior.number_in(1.0, f64::INFINITY))?;
        let nm = |key: &str, default: f64| -> Result<f64> {
            layer.get(key)?.map_or(Ok(default), |field| field.number_in(0.0, f64::INFINITY))
        };
        let (least, most) = (nm("iridescenceThicknessMinimum", 100.0)?, nm("iridescenceThicknessMaximum", 400.0)?);
        let thickness_nm = match self.texture_of(layer, "iridescenceThicknessTexture", Encoding::Linear)? {
            None => Scalar::new(most),
            Some(input) => {
                let input = TextureInput { scale: [most - least; 4], bias: [least; 4], ..input };
                Scalar { factor: 1.0, texture: Some((input, Channel::Green)) }
            }
        };
        Ok((weight.factor > 0.0).then_some(Film { weight, ior, thickness_nm }))
    }

    /// A normal map and its strength.
    fn normal_map(&mut self, at: &At<'_>, key: &str) -> Result<Option<(TextureInput, f64)>> {
        let Some(texture) = at.get(key)? else { return Ok(None) };
        let strength = texture.get("scale")?.map_or(Ok(1.0), |scale| scale.number())?;
        let input = self.texture(&texture, Encoding::Linear)?;
        Ok(input.map(|input| {
            (TextureInput { scale: [2.0, 2.0, 2.0, 1.0], bias: [-1.0, -1.0, -1.0, 0.0], ..input }, strength)
        }))
    }

    fn scalar(&mut self, at: &At<'_>, key: &str, default: f64, texture: &str, channel: Channel) -> Result<Scalar> {
        let input = self.texture_of(at, texture, Encoding::Linear)?;
        Ok(Scalar { factor: number(at, key, default)?, texture: input.map(|input| (input, channel)) })
    }

    fn colour(&mut self, at: &At<'_>, key: &str, default: [f64; 3], texture: &str) -> Result<Colour> {
        Ok(Colour { factor: rgb(at, key, default)?, texture: self.texture_of(at, texture, Encoding::Srgb)? })
    }

    pub fn texture_of(&mut self, at: &At<'_>, key: &str, encoding: Encoding) -> Result<Option<TextureInput>> {
        at.get(key)?.map_or(Ok(None), |texture| self.texture(&texture, encoding))
    }

    fn texture(&mut self, at: &At<'_>, encoding: Encoding) -> Result<Option<TextureInput>> {
        picture::input(self.document, at, encoding, (self.pictures, self.ledger))
    }
}

/// A share of 0 to 1.
fn number(at: &At<'_>, key: &str, default: f64) -> Result<f64> {
    at.get(key)?.map_or(Ok(default), |field| field.number_in(0.0, 1.0))
}

/// Linear Rec.709, each from 0.
fn rgb(at: &At<'_>, key: &str, default: [f64; 3]) -> Result<[f64; 3]> {
    let Some(field) = at.get(key)? else { return Ok(default) };
    let colour = field.numbers::<3>()?;
    if colour.iter().any(|lane| *lane < 0.0) {
        return Err(field.fault("a colour below 0").expected("three numbers from 0"));
    }
    Ok(colour)
}

/// A colour of 0 to 1 and its alpha; white where it is not said.
fn rgba(at: &At<'_>, key: &str) -> Result<([f64; 3], f64)> {
    let Some(field) = at.get(key)? else { return Ok(([1.0; 3], 1.0)) };
    let [r, g, b, a] = field.numbers::<4>()?.map(|lane| lane.clamp(0.0, 1.0));
    Ok(([r, g, b], a))
}
