//! How the surface shaders that we know look, as a [`StandardSurface`]: their numbers, and the pictures and colours of
//! vertices that their networks read.
//!
//! Sources: the UsdPreviewSurface specification 2.6; OpenPBR Surface 1.1; the Standard Surface paper (Autodesk, 1.0.1) with the
//! defaults of MaterialX 1.39; MaterialX' `gltf_pbr`, which is glTF 2.0.

use super::attribute::PrimView;
use super::inputs::Shader;
use super::reader::Reader;
use eyebox_base::error::Result;
use eyebox_scene::{Anisotropy, AnisotropyLaw, CoatNormal, Colour, Film, Opacity, Scalar, StandardSurface};

/// A UsdPreviewSurface; what is not said has the values of its specification.
///
/// # Errors
/// What the library cannot read.
pub(super) fn preview(reader: &mut Reader, view: &PrimView) -> Result<StandardSurface> {
    let mut shader = Shader { reader, view };
    let (base_color, vertex_colors) = shader.base(None, ("diffuseColor", [0.18; 3]))?;
    let mut out = StandardSurface {
        name: view.name().to_owned(),
        base_color,
        vertex_colors,
        metallic: shader.scalar("metallic", 0.0)?,
        roughness: shader.scalar("roughness", 0.5)?,
        ior: shader.plain("ior", 1.5)?.max(1.0),
        coat: shader.scalar("clearcoat", 0.0)?,
        coat_roughness: shader.scalar("clearcoatRoughness", 0.01)?,
        normal: shader.normal("normal")?,
        ..StandardSurface::default()
    };
    if shader.plain("useSpecularWorkflow", 0.0)? != 0.0 {
        // The colour is what it reflects where light falls straight on, whatever the index: all of it, of an infinite one.
        out.metallic = Scalar::new(0.0);
        out.ior = f64::INFINITY;
        out.specular_color = shader.colour("specularColor", [0.0; 3])?;
    }
    let threshold = shader.plain("opacityThreshold", 0.0)?;
    let (alpha, by_vertices) = shader.alpha("opacity")?;
    out.vertex_colors |= by_vertices;
    out.opacity = opacity(alpha, by_vertices, threshold);
    shader.moved("displacement")?;
    Ok(out)
}

/// An OpenPBR surface (`open_pbr`) or a standard surface.
///
/// # Errors
/// What the library cannot read.
pub(super) fn layered(reader: &mut Reader, view: &PrimView, open_pbr: bool) -> Result<StandardSurface> {
    let names = if open_pbr { &OPEN_PBR } else { &STANDARD };
    let mut shader = Shader { reader, view };
    let (base_color, base_vertices) = shader.base(Some((names.base, 1.0)), (names.base_color, [0.8; 3]))?;
    let (alpha, by_vertices) = shader.alpha(names.opacity)?;
    let specular_color = shader.colour("specular_color", [1.0; 3])?;
    let metallic = shader.scalar(names.metallic, 0.0)?;
    let strength = shader.scalar(names.anisotropy, 0.0)?;
    // A turn is 1.
    let turns = if open_pbr { 0.0 } else { shader.plain("specular_rotation", 0.0)? };
    let film = if open_pbr {
        let thickness = shader.scalar("thin_film_thickness", 0.5)?;
        let weight = shader.scalar("thin_film_weight", 0.0)?;
        // In micrometres there.
        film(weight, shader.plain("thin_film_ior", 1.4)?, Scalar { factor: 1000.0 * thickness.factor, ..thickness })
    } else {
        let thickness_nm = shader.scalar("thin_film_thickness", 0.0)?;
        let weight = Scalar::new(if thickness_nm.factor > 0.0 { 1.0 } else { 0.0 });
        film(weight, shader.plain("thin_film_IOR", 1.5)?, thickness_nm)
    };
    let coat = shader.scalar(names.coat, 0.0)?;
    // Without a coat its colour is none of the surface's.
    let (coat_ior, coat_color) = if coat.factor > 0.0 {
        let ior = shader.plain(names.coat_ior.0, names.coat_ior.1)?.max(1.0);
        (ior, shader.colour("coat_color", [1.0; 3])?)
    } else {
        (1.5, Colour::new([1.0; 3]))
    };
    let mut out = StandardSurface {
        name: view.name().to_owned(),
        base_color,
        vertex_colors: base_vertices || by_vertices,
        metal_edge: if metallic.factor > 0.0 { specular_color.clone() } else { Colour::new([1.0; 3]) },
        specular_color,
        anisotropy: anisotropy(strength, names.law, std::f64::consts::TAU * turns),
        film,
        coat_normal: coat_normal(&mut shader, [names.normal, names.coat_normal])?,
        metallic,
        diffuse_roughness: shader.scalar(names.diffuse_roughness, 0.0)?,
        roughness: shader.scalar("specular_roughness", names.roughness)?,
        ior: shader.plain(names.ior, 1.5)?.max(1.0),
        specular: shader.scalar(names.specular, 1.0)?,
        transmission: shader.scalar(names.transmission, 0.0)?,
        coat,
        coat_ior,
        coat_color,
        coat_roughness: shader.scalar("coat_roughness", names.coat_roughness)?,
        sheen_color: shader.product((names.sheen, 0.0), (names.sheen_color, [1.0; 3]))?,
        sheen_roughness: shader.scalar(names.sheen_roughness, names.sheen_rough)?,
        normal: shader.normal(names.normal)?,
        opacity: opacity(alpha, by_vertices, 0.0),
        ..StandardSurface::default()
    };
    if !open_pbr && out.coat.factor > 0.0 {
        coat_affects(&mut shader, &mut out)?;
    }
    Ok(out)
}

/// What a coat of the standard surface makes of what is below it (MaterialX 1.39, `NG_standard_surface_surfaceshader_100`): the
/// base colour to the power of 1 + coat · `coat_affect_color`, the roughness towards 1 by coat · `coat_roughness` ·
/// `coat_affect_roughness`. Of constants: a picture is left as it is, with a warning.
fn coat_affects(shader: &mut Shader<'_>, out: &mut StandardSurface) -> Result<()> {
    let color = shader.plain("coat_affect_color", 0.0)?.clamp(0.0, 1.0);
    let roughness = shader.plain("coat_affect_roughness", 0.0)?.clamp(0.0, 1.0);
    let plain = |scalar: &Scalar| scalar.texture.is_none();
    if color > 0.0 {
        if plain(&out.coat) && out.base_color.texture.is_none() && !out.vertex_colors {
            let power = 1.0 + out.coat.factor * color;
            let body = 1.0 - if plain(&out.metallic) { out.metallic.factor } else { 0.0 };
            // The metal keeps its colour; base and metal share one here.
            out.base_color.factor = out.base_color.factor.map(|c| c + body * (c.powf(power) - c));
        } else {
            shader.unapplied("coat_affect_color", "a picture is not changed by the coat over it");
        }
    }
    if roughness > 0.0 {
        if plain(&out.coat) && plain(&out.coat_roughness) && plain(&out.roughness) {
            let share = out.coat.factor * out.coat_roughness.factor * roughness;
            out.roughness.factor += (1.0 - out.roughness.factor) * share;
        } else {
            shader.unapplied("coat_affect_roughness", "a picture is not changed by the coat over it");
        }
    }
    Ok(())
}

/// MaterialX' glTF model.
///
/// # Errors
/// What the library cannot read.
pub(super) fn gltf(reader: &mut Reader, view: &PrimView) -> Result<StandardSurface> {
    let mut shader = Shader { reader, view };
    let (base_color, base_vertices) = shader.base(None, ("base_color", [1.0; 3]))?;
    let (alpha, by_vertices) = shader.alpha("alpha")?;
    // 0 opaque, 1 cut out, 2 blended.
    let mode = shader.plain("alpha_mode", 0.0)?;
    let opacity = if mode == 1.0 {
        Opacity::Mask { alpha, cutoff: shader.plain("alpha_cutoff", 0.5)? }
    } else if mode == 2.0 {
        Opacity::Blend { alpha }
    } else {
        Opacity::Opaque
    };
    let strength = shader.scalar("anisotropy_strength", 0.0)?;
    let rotation_rad = shader.plain("anisotropy_rotation", 0.0)?;
    let weight = shader.scalar("iridescence", 0.0)?;
    let thickness_nm = shader.scalar("iridescence_thickness", 100.0)?;
    Ok(StandardSurface {
        name: view.name().to_owned(),
        base_color,
        vertex_colors: base_vertices || by_vertices,
        anisotropy: anisotropy(strength, AnisotropyLaw::Gltf, rotation_rad),
        film: film(weight, shader.plain("iridescence_ior", 1.3)?, thickness_nm),
        coat_normal: coat_normal(&mut shader, ["normal", "clearcoat_normal"])?,
        metallic: shader.scalar("metallic", 1.0)?,
        roughness: shader.scalar("roughness", 1.0)?,
        ior: shader.plain("ior", 1.5)?.max(1.0),
        specular: shader.scalar("specular", 1.0)?,
        specular_color: shader.colour("specular_color", [1.0; 3])?,
        transmission: shader.scalar("transmission", 0.0)?,
        coat: shader.scalar("clearcoat", 0.0)?,
        coat_roughness: shader.scalar("clearcoat_roughness", 0.0)?,
        sheen_color: shader.colour("sheen_color", [0.0; 3])?,
        sheen_roughness: shader.scalar("sheen_roughness", 0.0)?,
        normal: shader.normal("normal")?,
        opacity,
        ..StandardSurface::default()
    })
}

/// Facets that are longer along the texture's columns; none where they are not.
fn anisotropy(strength: Scalar, law: AnisotropyLaw, rotation_rad: f64) -> Option<Anisotropy> {
    (strength.factor > 0.0).then_some(Anisotropy { strength, law, rotation_rad, direction: None })
}

fn film(weight: Scalar, ior: f64, thickness_nm: Scalar) -> Option<Film> {
    (weight.factor > 0.0).then_some(Film { weight, ior: ior.max(1.0), thickness_nm })
}

/// The coat is smooth where it has no map of its own, whatever the base is.
fn coat_normal(shader: &mut Shader<'_>, [base, coat]: [&str; 2]) -> Result<CoatNormal> {
    Ok(match shader.normal(coat)? {
        Some((map, strength)) => CoatNormal::Map(map, strength),
        None if shader.normal(base)?.is_some() => CoatNormal::Smooth,
        None => CoatNormal::Base,
    })
}

fn opacity(alpha: Scalar, by_vertices: bool, threshold: f64) -> Opacity {
    if threshold > 0.0 {
        Opacity::Mask { alpha, cutoff: threshold }
    } else if alpha.texture.is_none() && alpha.factor >= 1.0 && !by_vertices {
        Opacity::Opaque
    } else {
        Opacity::Blend { alpha }
    }
}

/// Where the two layered models differ in names and defaults.
struct Names {
    base: &'static str,
    base_color: &'static str,
    diffuse_roughness: &'static str,
    metallic: &'static str,
    roughness: f64,
    ior: &'static str,
    specular: &'static str,
    transmission: &'static str,
    coat: &'static str,
    coat_ior: (&'static str, f64),
    coat_roughness: f64,
    sheen: &'static str,
    sheen_color: &'static str,
    sheen_roughness: &'static str,
    sheen_rough: f64,
    normal: &'static str,
    opacity: &'static str,
    anisotropy: &'static str,
    law: AnisotropyLaw,
    coat_normal: &'static str,
}

const OPEN_PBR: Names = Names {
    base: "base_weight",
    base_color: "base_color",
    diffuse_roughness: "base_diffuse_roughness",
    metallic: "base_metalness",
    roughness: 0.3,
    ior: "specular_ior",
    specular: "specular_weight",
    transmission: "transmission_weight",
    coat: "coat_weight",
    coat_ior: ("coat_ior", 1.6),
    coat_roughness: 0.0,
    sheen: "fuzz_weight",
    sheen_color: "fuzz_color",
    sheen_roughness: "fuzz_roughness",
    sheen_rough: 0.5,
    normal: "geometry_normal",
    opacity: "geometry_opacity",
    anisotropy: "specular_roughness_anisotropy",
    law: AnisotropyLaw::OpenPbr,
    coat_normal: "geometry_coat_normal",
};

const STANDARD: Names = Names {
    base: "base",
    base_color: "base_color",
    diffuse_roughness: "diffuse_roughness",
    metallic: "metalness",
    roughness: 0.2,
    ior: "specular_IOR",
    specular: "specular",
    transmission: "transmission",
    coat: "coat",
    coat_ior: ("coat_IOR", 1.5),
    coat_roughness: 0.1,
    sheen: "sheen",
    sheen_color: "sheen_color",
    sheen_roughness: "sheen_roughness",
    sheen_rough: 0.3,
    normal: "normal",
    opacity: "opacity",
    anisotropy: "specular_anisotropy",
    law: AnisotropyLaw::MaterialX,
    coat_normal: "coat_normal",
};
