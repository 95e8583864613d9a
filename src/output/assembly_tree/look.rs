//! How an ordinary material looks: what there is of it, and which pictures say so.

use super::words::{name, number};
use eyebox_scene::{CoatNormal, Colour, Opacity, Scalar, StandardSurface, TextureInput};

/// A surface as people know it. Numbers are factors of the textures beside them.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct LookReport {
    pub material: String,
    /// What it is below its layers.
    pub kind: &'static str,
    /// Linear Rec.709.
    pub base_color: [f64; 3],
    /// Whether the colours of the mesh's vertices multiply it.
    pub vertex_colors: bool,
    pub roughness: f64,
    /// What is there beside the base.
    pub layers: Vec<&'static str>,
    /// In the order of the material's parameters.
    pub textures: Vec<TextureReport>,
}

#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct TextureReport {
    /// The parameter that it says.
    pub of: &'static str,
    pub name: String,
    pub size: [usize; 2],
}

impl LookReport {
    /// `colors`: whether the mesh has colours at its vertices.
    pub fn new(surface: &StandardSurface, colors: bool) -> Self {
        let some = |scalar: &Scalar| scalar.factor > 0.0;
        let lit = |colour: &Colour| colour.factor.iter().any(|c| *c > 0.0);
        let metallic = &surface.metallic;
        let kind = match (metallic.texture.is_some(), metallic.factor) {
            (true, factor) if factor > 0.0 => "metal by texture",
            (_, factor) if factor >= 1.0 => "metal",
            (_, factor) if factor > 0.0 => "part metal",
            (_, _) => "dielectric",
        };
        let opacity = match &surface.opacity {
            Opacity::Opaque => None,
            Opacity::Mask { .. } => Some("cut out"),
            Opacity::Blend { .. } => Some("blended"),
        };
        let tinted = metallic.factor > 0.0 && surface.metal_edge != Colour::new([1.0; 3]);
        let layers = [
            (surface.anisotropy.as_ref().is_some_and(|found| some(&found.strength)), "anisotropy"),
            (some(&surface.diffuse_roughness), "rough base"),
            (tinted, "metal edge"),
            (some(&surface.transmission), "transmission"),
            (some(&surface.diffuse_transmission), "diffuse transmission"),
            (surface.film.as_ref().is_some_and(|film| some(&film.weight)), "film"),
            (some(&surface.coat), "coat"),
            (lit(&surface.sheen_color), "sheen"),
        ];
        let layers = layers.into_iter().filter(|(there, _)| *there).map(|(_, layer)| layer).chain(opacity).collect();
        LookReport {
            material: surface.name.clone(),
            kind,
            base_color: surface.base_color.factor,
            vertex_colors: surface.vertex_colors && colors,
            roughness: surface.roughness.factor,
            layers,
            textures: textures(surface),
        }
    }

    /// `surface Paint: dielectric, base colour (0.8, 0.1, 0.1) x paint.png, roughness 0.4, coat`.
    pub fn text(&self) -> String {
        let [r, g, b] = self.base_color.map(|c| number(c, 3));
        let mut text = format!("surface {}: {}, base colour ({r}, {g}, {b})", name(&self.material), self.kind);
        if self.vertex_colors {
            text += " x colours of vertices";
        }
        let times = |of: &str| {
            let texture = self.textures.iter().find(|texture| texture.of == of);
            texture.map_or_else(String::new, |texture| format!(" x {}", name(&texture.name)))
        };
        text += &times("base colour");
        text += &format!(", roughness {}{}", number(self.roughness, 3), times("roughness"));
        for layer in &self.layers {
            text += &format!(", {layer}");
        }
        let rest = self.textures.iter().filter(|texture| !["base colour", "roughness"].contains(&texture.of));
        for texture in rest {
            text += &format!(", {} {}", texture.of, name(&texture.name));
        }
        text
    }
}

fn textures(surface: &StandardSurface) -> Vec<TextureReport> {
    let input = |of: &'static str, input: Option<&TextureInput>| input.map(|input| report(of, input));
    let colour = |of, colour: &Colour| input(of, colour.texture.as_ref());
    let scalar = |of, scalar: &Scalar| input(of, scalar.texture.as_ref().map(|(input, _)| input));
    let opacity = match &surface.opacity {
        Opacity::Opaque => None,
        Opacity::Mask { alpha, .. } | Opacity::Blend { alpha } => scalar("opacity", alpha),
    };
    let (film, anisotropy) = (surface.film.as_ref(), surface.anisotropy.as_ref());
    let coat_normal = match &surface.coat_normal {
        CoatNormal::Base | CoatNormal::Smooth => None,
        CoatNormal::Map(input, _) => Some(input),
    };
    let all = [
        colour("base colour", &surface.base_color),
        scalar("metallic", &surface.metallic),
        scalar("roughness", &surface.roughness),
        scalar("specular", &surface.specular),
        colour("specular colour", &surface.specular_color),
        colour("metal edge", &surface.metal_edge),
        anisotropy.and_then(|found| scalar("anisotropy", &found.strength)),
        input("anisotropy direction", anisotropy.and_then(|found| found.direction.as_ref())),
        scalar("transmission", &surface.transmission),
        scalar("diffuse transmission", &surface.diffuse_transmission),
        colour("diffuse transmission colour", &surface.diffuse_transmission_color),
        film.and_then(|film| scalar("film", &film.weight)),
        film.and_then(|film| scalar("film thickness", &film.thickness_nm)),
        scalar("coat", &surface.coat),
        colour("coat colour", &surface.coat_color),
        scalar("coat roughness", &surface.coat_roughness),
        input("coat normal", coat_normal),
        colour("sheen", &surface.sheen_color),
        scalar("diffuse roughness", &surface.diffuse_roughness),
        scalar("sheen roughness", &surface.sheen_roughness),
        input("normal", surface.normal.as_ref().map(|(input, _)| input)),
        input("emission", surface.emission.as_ref()),
        opacity,
    ];
    all.into_iter().flatten().collect()
}

fn report(of: &'static str, input: &TextureInput) -> TextureReport {
    let texture = &input.texture;
    TextureReport { of, name: texture.name.clone(), size: [texture.width, texture.height] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyebox_scene::texture::{Channel, Encoding, Filter, Texels, TextureInput, Wrap};
    use eyebox_scene::{Anisotropy, AnisotropyLaw, Film};
    use std::sync::Arc;

    fn input(name: &str) -> TextureInput {
        let texels = Texels::Bytes(Arc::new(vec![[255; 4]; 2]));
        TextureInput {
            texture: eyebox_scene::Texture { name: name.into(), width: 2, height: 1, texels }.into(),
            encoding: Encoding::Srgb,
            wrap: [Wrap::Repeat; 2],
            filter: Filter::Linear,
            set: 0,
            to_picture: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            channels: eyebox_scene::texture::Channel::ALL,
            scale: [1.0; 4],
            bias: [0.0; 4],
            fallback: None,
        }
    }

    #[test]
    fn a_look_says_its_kind_its_colour_and_its_pictures() {
        let plain = StandardSurface { name: "Clay".into(), ..StandardSurface::default() };
        assert_eq!(
            LookReport::new(&plain, true).text(),
            "surface Clay: dielectric, base colour (1, 1, 1), roughness 1"
        );
        let textured = |factor: f64, name: &str| Scalar { factor, texture: Some((input(name), Channel::Green)) };
        let mut rich = StandardSurface {
            name: "Pai\u{7}nt".into(),
            base_color: Colour { factor: [0.5, 0.25, 0.0], texture: Some(input("paint.png")) },
            metallic: textured(1.0, "orm.png"),
            roughness: textured(0.4, "orm.png"),
            coat: Scalar::new(0.8),
            normal: Some((input("bumps.png"), 1.0)),
            opacity: Opacity::Mask { alpha: textured(1.0, "paint.png"), cutoff: 0.5 },
            ..StandardSurface::default()
        };
        let report = LookReport::new(&rich, true);
        assert_eq!(
            report.text(),
            "surface Pai\u{fffd}nt: metal by texture, base colour (0.5, 0.25, 0) x paint.png, roughness 0.4 x orm.png, coat, \
             cut out, metallic orm.png, normal bumps.png, opacity paint.png"
        );
        assert_eq!((report.textures.len(), report.textures[0].size), (5, [2, 1]));
        (rich.metallic, rich.vertex_colors) = (Scalar::new(1.0), true);
        assert!(
            LookReport::new(&rich, true)
                .text()
                .contains(": metal, base colour (0.5, 0.25, 0) x colours of vertices x paint.png")
        );
        rich.metal_edge = Colour { factor: [1.0, 0.5, 0.5], texture: Some(input("edge.png")) };
        rich.film = Some(Film { weight: textured(1.0, "film.png"), ior: 1.3, thickness_nm: textured(400.0, "nm.png") });
        let (law, direction) = (AnisotropyLaw::Gltf, Some(input("brush.png")));
        let strength = textured(0.5, "brush.png");
        rich.anisotropy = Some(Anisotropy { strength, law, rotation_rad: 0.0, direction });
        rich.coat_normal = CoatNormal::Map(input("flakes.png"), 1.0);
        let text = LookReport::new(&rich, true).text();
        let part = ", anisotropy, metal edge, film, coat, cut out, metal edge edge.png, anisotropy brush.png, anisotropy direction \
             brush.png, film film.png, film thickness nm.png, coat normal flakes.png, normal bumps.png";
        assert!(text.contains(part), "{text}");
        // Nothing to multiply with.
        assert!(!LookReport::new(&rich, false).vertex_colors);
    }
}
