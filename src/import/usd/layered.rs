//! What the two layered models say, OpenPBR and the standard surface, in our words.

use super::inputs::Shader;
use super::standard;
use super::surface::{Inputs, Surface, attenuation, color_row, row, shines};
use crate::value::{Data, Value};
use eyebox_base::Where;
use eyebox_base::error::Result;

/// The names of the two layered models.
pub(super) struct Model {
    ior: &'static str,
    transmission: &'static str,
    thin: &'static str,
    color: &'static str,
    weight: &'static str,
    metallic: &'static str,
    /// `specular_roughness` where it is not said.
    roughness: f64,
    film_ior: &'static str,
    /// The index of the film where it is not said.
    film_default: f64,
    /// Its thickness in nm per unit.
    film_nm: f64,
    /// Whether the film has a weight of its own; else its thickness says whether it is there.
    film_weight: Option<&'static str>,
    /// What `emission_color` is multiplied by: cd/m².
    emission: &'static str,
    /// Names that mean nothing here, and where they mean nothing anywhere; those of a coat count where there is one.
    other: &'static [(&'static str, f64)],
    of_coat: &'static [(&'static str, f64)],
}

pub(super) const OPEN_PBR: Model = Model {
    ior: "specular_ior",
    transmission: "transmission_weight",
    thin: "geometry_thin_walled",
    color: "base_color",
    weight: "base_weight",
    metallic: "base_metalness",
    roughness: 0.3,
    film_ior: "thin_film_ior",
    film_default: 1.4,
    film_nm: 1000.0,
    film_weight: Some("thin_film_weight"),
    emission: "emission_luminance",
    other: &[("subsurface_weight", 0.0), ("transmission_scatter", 0.0)],
    // Its own is 1, where nothing is said of it.
    of_coat: &[("coat_roughness_anisotropy", 0.0), ("coat_darkening", 0.0)],
};

pub(super) const STANDARD: Model = Model {
    ior: "specular_IOR",
    transmission: "transmission",
    thin: "thin_walled",
    color: "base_color",
    weight: "base",
    metallic: "metalness",
    roughness: 0.2,
    film_ior: "thin_film_IOR",
    film_default: 1.5,
    film_nm: 1.0,
    film_weight: None,
    emission: "emission",
    other: &[("subsurface", 0.0), ("transmission_scatter", 0.0), ("transmission_extra_roughness", 0.0)],
    of_coat: &[("coat_anisotropy", 0.0)],
};

pub(super) fn layered(inputs: &mut Inputs<'_>, model: &Model) -> Result<Surface> {
    let mut out = Surface::default();
    if let Some((ior, at)) = inputs.number(model.ior, 1.0, f64::MAX)? {
        out.mapped.push(row("ior", Data::Number(ior), &at));
    }
    let through = inputs.number(model.transmission, 0.0, 1.0)?;
    if let Some((share, at)) = through.as_ref().filter(|(share, _)| *share > 0.0) {
        out.mapped.push(row("transmission", Data::Number(*share), at));
        rough(inputs, model, at)?;
        let solid = !inputs.flag(model.thin)?;
        if solid {
            volume(inputs, at, &mut out)?;
        }
        tint(inputs, solid)?;
    }
    dispersion(inputs, model, &mut out)?;
    film(inputs, model, &mut out)?;
    looks(inputs, model, &mut out)?;
    out.standard = standard::layered(inputs.reader, inputs.view, model.film_weight.is_some())?;
    shines(inputs, Some((model.emission, 0.0)), ("emission_color", [1.0; 3]), &mut out)?;
    let of_coat = if out.standard.coat.factor > 0.0 { model.of_coat } else { &[] };
    let mut shader = Shader { reader: &mut *inputs.reader, view: inputs.view };
    for (name, neutral) in model.other.iter().chain(of_coat) {
        if shader.differs(name, *neutral)? {
            shader.unapplied(name, "its surface is as it is without");
        }
    }
    Ok(out)
}

fn looks(inputs: &mut Inputs<'_>, model: &Model, out: &mut Surface) -> Result<()> {
    if let Some((lanes, at)) = inputs.color(model.color)? {
        let weight = inputs.number(model.weight, 0.0, 1.0)?.map_or(1.0, |(weight, _)| weight);
        out.looks.push(color_row("base_color", lanes.map(|lane| lane * weight), &at));
    }
    for (key, name) in [("metallic", model.metallic), ("roughness", "specular_roughness")] {
        if let Some((x, at)) = inputs.number(name, 0.0, 1.0)? {
            out.looks.push(row(key, Data::Number(x), &at));
        }
    }
    Ok(())
}

/// A solid: at `transmission_depth` (in scene units; 0: nowhere) it lets `transmission_color` through.
fn volume(inputs: &mut Inputs<'_>, at: &Where, out: &mut Surface) -> Result<()> {
    // Only its being more than 0 counts: the geometry has the thickness.
    out.mapped.push(row("thickness", Data::Number(1.0), at));
    attenuation(inputs, "transmission_depth", "transmission_color", out)
}

/// What transmits is polished where its roughness is not said, which both models then have above 0.
fn rough(inputs: &mut Inputs<'_>, model: &Model, transmits: &Where) -> Result<()> {
    if inputs.number("specular_roughness", 0.0, 1.0)?.is_none() {
        let roughness = model.roughness;
        let text = format!("`specular_roughness` of a surface that transmits is not said: polished, not {roughness}");
        inputs.reader.ledger.warn(transmits.clone(), text);
    }
    Ok(())
}

/// At a depth of 0, and on thin walls, `transmission_color` tints each surface, and not the solid.
fn tint(inputs: &mut Inputs<'_>, solid: bool) -> Result<()> {
    let depth = inputs.number("transmission_depth", 0.0, f64::MAX)?.map_or(0.0, |(depth, _)| depth);
    let Some((color, at)) = inputs.color("transmission_color")? else { return Ok(()) };
    if color != [1.0; 3] && !(solid && depth > 0.0) {
        let text = "a `transmission_color` that tints surfaces (`transmission_depth` 0 or thin walls) is not used yet";
        inputs.reader.ledger.warn(at, text);
    }
    Ok(())
}

/// OpenPBR: V_d = number / scale. Standard surface: V_d itself, 0 for none.
fn dispersion(inputs: &mut Inputs<'_>, model: &Model, out: &mut Surface) -> Result<()> {
    let (abbe, scale) = match model.film_weight {
        Some(_) => {
            let scale = inputs.number("transmission_dispersion_scale", 0.0, 1.0)?;
            let Some(scale) = scale.filter(|(scale, _)| *scale > 0.0) else { return Ok(()) };
            let abbe = inputs.number("transmission_dispersion_abbe_number", 0.0, f64::MAX)?;
            (abbe.map_or(20.0, |(abbe, _)| abbe), scale)
        }
        None => match inputs.number("transmission_dispersion", 0.0, f64::MAX)? {
            Some((abbe, at)) => (abbe, (1.0, at)),
            None => return Ok(()),
        },
    };
    let dispersion = 20.0 * scale.0 / abbe;
    if abbe > 0.0 && dispersion.is_finite() && dispersion > 0.0 {
        out.mapped.push(row("dispersion", Data::Number(dispersion), &scale.1));
    }
    Ok(())
}

/// One film, as `KHR_materials_iridescence` gives it.
fn film(inputs: &mut Inputs<'_>, model: &Model, out: &mut Surface) -> Result<()> {
    let weight = match model.film_weight {
        Some(name) => inputs.number(name, 0.0, 1.0)?.map_or(0.0, |(weight, _)| weight),
        None => 1.0,
    };
    let thickness = inputs.number("thin_film_thickness", 0.0, f64::MAX)?;
    let (thickness, at) = match (thickness, model.film_weight) {
        (Some((thickness, at)), _) => (thickness * model.film_nm, at),
        // OpenPBR's own.
        (None, Some(_)) => (0.5 * model.film_nm, inputs.view.at()),
        (None, None) => return Ok(()),
    };
    if weight == 0.0 || thickness == 0.0 || !thickness.is_finite() {
        return Ok(());
    }
    if weight < 1.0 {
        inputs
            .reader
            .ledger
            .warn(at.clone(), "a `thin_film_weight` below 1 (part of the surface has the film): taken as 1");
    }
    let index = inputs.number(model.film_ior, 1.0, f64::MAX)?.map_or(model.film_default, |(index, _)| index);
    let layer =
        Data::Table(vec![row("n", Data::Number(index), &at), row("thickness_nm", Data::Number(thickness), &at)]);
    let stack = Data::List(vec![Value::new(layer, at.clone())]);
    let name = row("name", Data::Text("thin film".to_owned()), &at);
    out.mapped.push(row("coating", Data::Table(vec![name, row("stack", stack, &at)]), &at));
    Ok(())
}
