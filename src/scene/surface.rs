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
    /// 0 to 1, of the diffuse base: EON's (Portsmouth, Kutz and Hill 2025). 0 scatters as Lambert says.
    pub diffuse_roughness: Scalar,
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
    /// What the reflectance of a metal is multiplied by at 82°, and so all the way to where light grazes.
    pub metal_edge: Colour,
    /// Facets longer one way than the other; none where they are alike all round.
    pub anisotropy: Option<Anisotropy>,
    /// A thin film between the dielectric or metal and what is above it.
    pub film: Option<Film>,
    /// A layer on top: its weight, the index of its boundary (at least 1), and what of light that falls straight on is left on its way
    /// in and out again.
    pub coat: Scalar,
    pub coat_ior: f64,
    pub coat_color: Colour,
    pub coat_roughness: Scalar,
    pub coat_normal: CoatNormal,
    /// Fibres on top: reflectance at grazing incidence.
    pub sheen_color: Colour,
    pub sheen_roughness: Scalar,
    /// Tangent-space normals, each component 2 · texel − 1, x and y times the number.
    pub normal: Option<(TextureInput, f64)>,
    /// What each place has of the light of a face that emits; it is no part of how light is scattered.
    pub emission: Option<TextureInput>,
    pub opacity: Opacity,
}

/// Facets that are longer along a direction of the surface.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Anisotropy {
    /// 0 to 1.
    pub strength: Scalar,
    pub law: AnisotropyLaw,
    /// From the direction in which a picture's columns follow each other, towards the one against its rows.
    pub rotation_rad: f64,
    /// Directions in that frame: red and green, turned by the rotation besides.
    pub direction: Option<TextureInput>,
}

/// What a strength makes of the α of the facets along the direction and across it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum AnisotropyLaw {
    /// KHR_materials_anisotropy: along α + (1 − α)·s², across α.
    Gltf,
    /// OpenPBR 1.1: the mean of both squares is α².
    OpenPbr,
    /// MaterialX, `roughness_anisotropy`: α/√(1 − s) and α·√(1 − s).
    MaterialX,
}

/// α of the smoothest facets that are told from a mirror.
pub const LEAST_ALPHA: f64 = 1e-4;

impl AnisotropyLaw {
    /// α along the direction and across it, of facets of this α and a strength of 0 to 1.
    pub fn alphas(self, alpha: f64, strength: f64) -> [f64; 2] {
        let both = match self {
            AnisotropyLaw::Gltf => [alpha + (1.0 - alpha) * strength * strength, alpha],
            AnisotropyLaw::OpenPbr => {
                let across = 1.0 - strength;
                let along = alpha * (2.0 / (1.0 + across * across)).sqrt();
                [along, across * along]
            }
            AnisotropyLaw::MaterialX => {
                let aspect = (1.0 - strength).max(LEAST_ALPHA).sqrt();
                [alpha / aspect, alpha * aspect]
            }
        };
        both.map(|alpha| alpha.clamp(LEAST_ALPHA, 1.0))
    }
}

/// A thin film.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Film {
    /// 0 to 1: how much of the surface is under it.
    pub weight: Scalar,
    pub ior: f64,
    pub thickness_nm: Scalar,
}

/// What normals a coat has.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CoatNormal {
    /// Those of the base, with its map.
    Base,
    /// Those of the mesh.
    Smooth,
    /// By a map of its own, as for the base.
    Map(TextureInput, f64),
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
            diffuse_roughness: Scalar::new(0.0),
            metallic: Scalar::new(0.0),
            roughness: Scalar::new(1.0),
            ior: 1.5,
            specular: Scalar::new(1.0),
            specular_color: WHITE,
            transmission: Scalar::new(0.0),
            diffuse_transmission: Scalar::new(0.0),
            diffuse_transmission_color: WHITE,
            metal_edge: WHITE,
            anisotropy: None,
            film: None,
            coat: Scalar::new(0.0),
            coat_ior: 1.5,
            coat_color: WHITE,
            coat_roughness: Scalar::new(0.0),
            coat_normal: CoatNormal::Base,
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
        let film = self.film.as_ref().is_some_and(|film| film.weight.factor > 0.0);
        film || self.colours().into_iter().any(|colour| !colour.is_grey())
            || self.emission.as_ref().is_some_and(|input| !input.is_grey())
    }

    fn colours(&self) -> [&Colour; 6] {
        [
            &self.base_color,
            &self.specular_color,
            &self.diffuse_transmission_color,
            &self.metal_edge,
            &self.coat_color,
            &self.sheen_color,
        ]
    }

    /// Every reading of a texture by what scatters.
    pub fn textures(&self) -> impl Iterator<Item = &TextureInput> {
        let scalars = [
            &self.diffuse_roughness,
            &self.metallic,
            &self.roughness,
            &self.specular,
            &self.transmission,
            &self.diffuse_transmission,
            &self.coat,
            &self.coat_roughness,
            &self.sheen_roughness,
        ];
        let film = self.film.iter().flat_map(|film| [&film.weight, &film.thickness_nm]);
        let anisotropy = self.anisotropy.iter();
        let scalars = scalars.into_iter().chain(self.opacity.alpha()).chain(film);
        let scalars = scalars.chain(anisotropy.clone().map(|found| &found.strength));
        self.colours()
            .into_iter()
            .filter_map(|colour| colour.texture.as_ref())
            .chain(scalars.filter_map(|scalar| scalar.texture.as_ref().map(|(input, _)| input)))
            .chain(anisotropy.filter_map(|found| found.direction.as_ref()))
            .chain(self.normal.as_ref().map(|(input, _)| input))
            .chain(self.coat_normal.map())
    }

    /// Every reading of a texture, to be changed, the emission's too.
    pub fn textures_mut(&mut self) -> impl Iterator<Item = &mut TextureInput> {
        let colours = [
            &mut self.base_color,
            &mut self.specular_color,
            &mut self.diffuse_transmission_color,
            &mut self.metal_edge,
            &mut self.coat_color,
            &mut self.sheen_color,
        ];
        let scalars = [
            &mut self.diffuse_roughness,
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
        let film = self.film.iter_mut().flat_map(|film| [&mut film.weight, &mut film.thickness_nm]);
        let (strength, direction) = match &mut self.anisotropy {
            Some(found) => (Some(&mut found.strength), found.direction.as_mut()),
            None => (None, None),
        };
        let coat = match &mut self.coat_normal {
            CoatNormal::Map(input, _) => Some(input),
            CoatNormal::Base | CoatNormal::Smooth => None,
        };
        let scalars = scalars.into_iter().chain(alpha).chain(film).chain(strength);
        colours
            .into_iter()
            .filter_map(|colour| colour.texture.as_mut())
            .chain(scalars.filter_map(|scalar| scalar.texture.as_mut().map(|(input, _)| input)))
            .chain(direction)
            .chain(self.normal.as_mut().map(|(input, _)| input))
            .chain(coat)
            .chain(self.emission.as_mut())
    }

    /// Whether light may pass some of it unbent: cut out, blended, or a smooth sheet that transmits.
    pub fn lets_through(&self) -> bool {
        self.opacity != Opacity::Opaque || self.transmission.factor > 0.0
    }
}

impl Opacity {
    fn alpha(&self) -> Option<&Scalar> {
        match self {
            Opacity::Opaque => None,
            Opacity::Mask { alpha, .. } | Opacity::Blend { alpha } => Some(alpha),
        }
    }
}

impl CoatNormal {
    /// Its own map, if it has one.
    pub fn map(&self) -> Option<&TextureInput> {
        match self {
            CoatNormal::Map(input, _) => Some(input),
            CoatNormal::Base | CoatNormal::Smooth => None,
        }
    }
}
