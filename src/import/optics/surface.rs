//! `finish = { kind = "surface" }`: an ordinary material, each parameter a number or a colour, a picture, or their product.

use super::fields::Fields;
use crate::files;
use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Shared};
use eyebox_scene::texture::{Channel, Encoding, Filter, PictureSource, Texels, Wrap};
use eyebox_scene::{
    Anisotropy, AnisotropyLaw, CoatNormal, Colour, Film, Note, Opacity, Scalar, StandardSurface, Texture, TextureInput,
};

/// The surface that a table of the vocabulary means.
///
/// # Errors
/// Parameters of the wrong form or out of their range.
pub fn surface(fields: &Fields<'_>, notes: &mut Vec<Note>) -> Result<StandardSurface> {
    let read = Reader { fields };
    let unsaid = |name: &str| !fields.has(name) && !fields.has(&format!("{name}_texture"));
    notes
        .extend(["base_color", "roughness"].into_iter().filter(|name| unsaid(name)).map(|name| fields.defaulted(name)));
    let anisotropy = read.number("anisotropy", 0.0)?;
    let film = Film {
        weight: read.number("film", 0.0)?,
        ior: fields.number("film_ior")?.unwrap_or(1.4),
        thickness_nm: Scalar::new(fields.number("film_thickness_nm")?.unwrap_or(500.0)),
    };
    let alpha = read.number("opacity", 1.0)?;
    let opacity = match fields.number("opacity_cutoff")? {
        Some(cutoff) => Opacity::Mask { alpha, cutoff },
        None if alpha.texture.is_none() && alpha.factor >= 1.0 => Opacity::Opaque,
        None => Opacity::Blend { alpha },
    };
    Ok(StandardSurface {
        name: "surface".to_owned(),
        base_color: read.colour("base_color", [0.8; 3])?,
        diffuse_roughness: read.number("diffuse_roughness", 0.0)?,
        metallic: read.number("metallic", 0.0)?,
        roughness: read.number("roughness", 0.3)?,
        ior: fields.number("ior")?.unwrap_or(1.5),
        specular: read.number("specular", 1.0)?,
        specular_color: read.colour("specular_color", [1.0; 3])?,
        transmission: read.number("transmission", 0.0)?,
        diffuse_transmission: read.number("diffuse_transmission", 0.0)?,
        diffuse_transmission_color: read.colour("diffuse_transmission_color", [1.0; 3])?,
        anisotropy: (anisotropy.factor > 0.0).then_some(Anisotropy {
            strength: anisotropy,
            law: AnisotropyLaw::Gltf,
            rotation_rad: fields.number("anisotropy_rotation_deg")?.unwrap_or(0.0).to_radians(),
            direction: None,
        }),
        film: (film.weight.factor > 0.0).then_some(film),
        coat: read.number("coat", 0.0)?,
        coat_roughness: read.number("coat_roughness", 0.0)?,
        coat_normal: CoatNormal::Smooth,
        sheen_color: read.colour("sheen_color", [0.0; 3])?,
        sheen_roughness: read.number("sheen_roughness", 0.3)?,
        normal: read
            .picture("normal_texture", Encoding::Linear)?
            .map(|input| (TextureInput { scale: [2.0, 2.0, 2.0, 1.0], bias: [-1.0, -1.0, -1.0, 0.0], ..input }, 1.0)),
        opacity,
        ..StandardSurface::default()
    })
}

/// A Lambertian scatterer that has a colour: `None` where it is as grey as ever.
///
/// # Errors
/// Colours out of range, a colour or picture that scatters more than it gets.
pub fn coloured_lambert(fields: &Fields<'_>, [back, through]: [f64; 2]) -> Result<Option<StandardSurface>> {
    if !fields.has("color") && !fields.has("color_texture") {
        return Ok(None);
    }
    let color = Reader { fields }.colour("color", [1.0; 3])?;
    let most = back * color.factor.into_iter().fold(0.0, f64::max);
    if most + through > 1.0 {
        let what = format!("reflectance × color {most} + transmittance {through} is above 1");
        let fault = Error::new(fields.at().clone(), what).expected("shares that together are at most 1");
        return Err(fault.code(Code::ScatterGainsEnergy));
    }
    // The body shares what it scatters between its sides; both colours are then at most `most` + `through`.
    let all = most + through;
    let share = if all > 0.0 { through / all } else { 0.0 };
    let scale = if most > 0.0 { back / (1.0 - share) } else { 0.0 };
    Ok(Some(StandardSurface {
        name: "lambert".to_owned(),
        base_color: Colour { factor: color.factor.map(|lane| lane * scale), texture: color.texture },
        specular: Scalar::new(0.0),
        diffuse_transmission: Scalar::new(share),
        diffuse_transmission_color: Colour::new([all; 3]),
        ..StandardSurface::default()
    }))
}

struct Reader<'f, 'a> {
    fields: &'f Fields<'a>,
}

impl Reader<'_, '_> {
    fn number(&self, name: &str, default: f64) -> Result<Scalar> {
        let texture = self.picture(&format!("{name}_texture"), Encoding::Linear)?;
        let default = if texture.is_some() { 1.0 } else { default };
        let factor = self.fields.number(name)?.unwrap_or(default);
        Ok(Scalar { factor, texture: texture.map(|input| (input, Channel::Red)) })
    }

    fn colour(&self, name: &str, default: [f64; 3]) -> Result<Colour> {
        let texture = self.picture(&format!("{name}_texture"), Encoding::Srgb)?;
        let default = if texture.is_some() { [1.0; 3] } else { default };
        Ok(Colour { factor: self.fields.numbers::<3>(name)?.unwrap_or(default), texture })
    }

    /// The picture that a row names, still to be read.
    fn picture(&self, name: &str, encoding: Encoding) -> Result<Option<TextureInput>> {
        if !self.fields.has(name) {
            return Ok(None);
        }
        let file = self.fields.need_text(name)?;
        let at = self.fields.value(name).map_or_else(|| self.fields.at(), |value| &value.at);
        let source = PictureSource::File(files::resolve(file, at));
        let texture = Texture { name: file.to_owned(), width: 0, height: 0, texels: Texels::Encoded(source) };
        let [x, y] = self.fields.numbers::<2>("texture_scale")?.unwrap_or([1.0; 2]);
        let second = self.fields.text("texture_set")? == Some("second");
        Ok(Some(TextureInput {
            texture: Shared::from(texture),
            encoding,
            wrap: [Wrap::Repeat; 2],
            filter: Filter::Linear,
            set: u32::from(second),
            to_picture: [[x, 0.0, 0.0], [0.0, y, 0.0]],
            channels: Channel::ALL,
            scale: [1.0; 4],
            bias: [0.0; 4],
            fallback: None,
        }))
    }
}
