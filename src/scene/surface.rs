//! The standard surface: how ordinary materials look, after glTF 2.0 and OpenPBR 1.1 (`design/looks.md`).

use super::texture::{Colour, Scalar, TextureInput};

/// Layers from the base up. A layer whose weight is 0 everywhere costs nothing.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct StandardSurface {
    pub name: String,
    /// Albedo of the diffuse base, or reflectance of the metal at normal incidence.
    pub base_color: Colour,
    /// Whether the colours of the mesh's vertices multiply the base colour and the opacity.
    pub vertex_colors: bool,
    /// 0 dielectric to 1 metal.
    pub metallic: Scalar,
    /// 0 to 1; its square is the α of Trowbridge and Reitz's distribution.
    pub roughness: Scalar,
    /// Index of the dielectric's boundary, at least 1.
    pub ior: f64,
    /// Of the dielectric's reflection: weight of all, and colour where light falls straight on.
    pub specular: Scalar,
    pub specular_color: Colour,
    /// Share of what enters the dielectric that goes straight through the sheet, tinted by the base colour.
    pub transmission: Scalar,
    /// Share of what is scattered that leaves on the other side, and its colour.
    pub diffuse_transmission: Scalar,
    pub diffuse_transmission_color: Colour,
    /// A clear layer on top, of index 1.5.
    pub coat: Scalar,
    pub coat_roughness: Scalar,
    /// Fibres on top: reflectance at grazing incidence.
    pub sheen_color: Colour,
    pub sheen_roughness: Scalar,
    /// Tangent-space normals, each component 2 · texel − 1, x and y times the number.
    pub normal: Option<(TextureInput, f64)>,
    /// What each place has of the light of a face that emits; it is no part of how light is scattered.
    pub emission: Option<TextureInput>,
    pub opacity: Opacity,
}

/// Where a surface is there.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Opacity {
    Opaque,
    /// Where the alpha is at least `cutoff`.
    Mask {
        alpha: Scalar,
        cutoff: f64,
    },
    /// As a share: light passes the rest unbent.
    Blend {
        alpha: Scalar,
    },
}

impl Default for StandardSurface {
    /// As glTF 2.0 has it, but a dielectric, rough surface where nothing is said: OpenPBR's base.
    fn default() -> Self {
        const WHITE: Colour = Colour::new([1.0; 3]);
        const BLACK: Colour = Colour::new([0.0; 3]);
        StandardSurface {
            name: String::new(),
            base_color: WHITE,
            vertex_colors: false,
            metallic: Scalar::new(0.0),
            roughness: Scalar::new(1.0),
            ior: 1.5,
            specular: Scalar::new(1.0),
            specular_color: WHITE,
            transmission: Scalar::new(0.0),
            diffuse_transmission: Scalar::new(0.0),
            diffuse_transmission_color: WHITE,
            coat: Scalar::new(0.0),
            coat_roughness: Scalar::new(0.0),
            sheen_color: BLACK,
            sheen_roughness: Scalar::new(0.0),
            normal: None,
            emission: None,
            opacity: Opacity::Opaque,
        }
    }
}

impl StandardSurface {
    /// Whether any texture says how light is scattered.
    pub fn is_textured(&self) -> bool {
        self.textures().next().is_some()
    }

    /// Whether it reflects, lets through or emits any colour, apart from those of vertices.
    pub fn is_coloured(&self) -> bool {
        let colours = [&self.base_color, &self.specular_color, &self.diffuse_transmission_color, &self.sheen_color];
        colours.iter().any(|colour| !colour.is_grey()) || self.emission.as_ref().is_some_and(|input| !input.is_grey())
    }

    /// Every reading of a texture by what scatters.
    pub fn textures(&self) -> impl Iterator<Item = &TextureInput> {
        let colours = [&self.base_color, &self.specular_color, &self.diffuse_transmission_color, &self.sheen_color];
        let scalars = [
            &self.metallic,
            &self.roughness,
            &self.specular,
            &self.transmission,
            &self.diffuse_transmission,
            &self.coat,
            &self.coat_roughness,
            &self.sheen_roughness,
        ];
        let alpha = match &self.opacity {
            Opacity::Opaque => None,
            Opacity::Mask { alpha, .. } | Opacity::Blend { alpha } => Some(alpha),
        };
        colours
            .into_iter()
            .filter_map(|colour| colour.texture.as_ref())
            .chain(
                scalars.into_iter().chain(alpha).filter_map(|scalar| scalar.texture.as_ref().map(|(input, _)| input)),
            )
            .chain(self.normal.as_ref().map(|(input, _)| input))
    }

    /// Every reading of a texture, to be changed, the emission's too.
    pub fn textures_mut(&mut self) -> impl Iterator<Item = &mut TextureInput> {
        let colours = [
            &mut self.base_color,
            &mut self.specular_color,
            &mut self.diffuse_transmission_color,
            &mut self.sheen_color,
        ];
        let scalars = [
            &mut self.metallic,
            &mut self.roughness,
            &mut self.specular,
            &mut self.transmission,
            &mut self.diffuse_transmission,
            &mut self.coat,
            &mut self.coat_roughness,
            &mut self.sheen_roughness,
        ];
        let alpha = match &mut self.opacity {
            Opacity::Opaque => None,
            Opacity::Mask { alpha, .. } | Opacity::Blend { alpha } => Some(alpha),
        };
        colours
            .into_iter()
            .filter_map(|colour| colour.texture.as_mut())
            .chain(
                scalars.into_iter().chain(alpha).filter_map(|scalar| scalar.texture.as_mut().map(|(input, _)| input)),
            )
            .chain(self.normal.as_mut().map(|(input, _)| input))
            .chain(self.emission.as_mut())
    }

    /// Whether light passes some of it unbent: cut out, blended, or a sheet that transmits.
    pub fn lets_through(&self) -> bool {
        self.opacity != Opacity::Opaque || self.transmission.factor > 0.0
    }
}
