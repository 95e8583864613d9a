//! What the surface shaders that we know say, in our words. Only what the file says is mapped; defaults are ours to
//! choose.

use super::attribute::PrimView;
use super::reader::Reader;
use super::shader::{self, End};
use super::{standard, value};
use crate::base::Where;
use crate::base::fault::Result;
use crate::base::units::luminance;
use crate::import::value::{Data, Value};
use crate::scene::StandardSurface;
use openusd::sdf;

pub(super) type Row = (String, Value);

/// What of the models may be a picture.
const SHOWN: [&str; 9] = [
    "diffuseColor",
    "metallic",
    "roughness",
    "opacity",
    "clearcoat",
    "base_color",
    "metalness",
    "base_metalness",
    "specular_roughness",
];

/// How a material looks, without meaning to light.
pub(super) const LOOKS: [&str; 4] = ["base_color", "opacity", "metallic", "roughness"];

#[derive(Default)]
pub(super) struct Surface {
    pub mapped: Vec<Row>,
    pub looks: Vec<Row>,
    pub standard: StandardSurface,
    /// A UsdPreviewSurface.
    pub preview: bool,
    /// Where a UsdPreviewSurface says that it is not opaque, if it has an index, too: how others write glass.
    pub glass: Option<Where>,
}

/// Reads a surface shader; `None` for a kind that is not known.
///
/// | entry | UsdPreviewSurface | OpenPBR | standard_surface |
/// |---|---|---|---|
/// | `ior` | `ior` | `specular_ior` | `specular_IOR` |
/// | `transmission` | – | `transmission_weight` | `transmission` |
/// | `thickness` | – | solid unless `geometry_thin_walled` | solid unless `thin_walled` |
/// | `attenuation_…` | – | `transmission_depth`, `transmission_color` | the same |
/// | `dispersion` (20/V_d) | – | `transmission_dispersion_scale` / `…_abbe_number` | 1 / `transmission_dispersion` |
/// | `coating` | – | `thin_film_thickness` in µm, `thin_film_ior` | `thin_film_thickness` in nm, `thin_film_IOR` |
/// | `luminance_cd_m2`, `emitter.spectrum` | – | `emission_luminance` in nit × `emission_color` | – |
/// | looks | `diffuseColor`, `opacity`, `metallic`, `roughness` | base and specular | base and specular |
///
/// Sources: the UsdPreviewSurface specification 2.6; OpenPBR Surface 1.1; the Standard Surface paper (Autodesk, 1.0.1).
///
/// # Errors
/// What the library cannot read. Values of the wrong kind or out of range are left out, with a note.
pub(super) fn read(reader: &mut Reader, view: &PrimView) -> Result<Option<Surface>> {
    let id = shader::id(view)?;
    let mut inputs = Inputs { reader, view };
    // Names of versions and node definitions: `ND_standard_surface_surfaceshader_100`.
    Ok(match id.as_str() {
        "UsdPreviewSurface" | "ND_UsdPreviewSurface_surfaceshader" => Some(preview(&mut inputs)?),
        name if name.contains("open_pbr_surface") => Some(layered(&mut inputs, &OPEN_PBR)?),
        name if name.contains("standard_surface") => Some(layered(&mut inputs, &STANDARD)?),
        name if name.contains("gltf_pbr") => {
            // Until it is read: what makes it glass, or a lamp, must not be lost without a word.
            for input in ["transmission", "emissive_strength", "iridescence"] {
                inputs
                    .lost(input, "of a surface of MaterialX' glTF model is not used yet: say its finish and medium")?;
            }
            inputs.reader.ledger.info(view.at(), format!("surface shaders of the kind `{name}` are not used"));
            None
        }
        "" => {
            inputs.reader.ledger.info(view.at(), "a surface shader without `info:id` is not used");
            None
        }
        other => {
            inputs.reader.ledger.info(view.at(), format!("surface shaders of the kind `{other}` are not used"));
            None
        }
    })
}

/// The inputs of one shader.
struct Inputs<'a> {
    reader: &'a mut Reader,
    view: &'a PrimView,
}

impl Inputs<'_> {
    fn get(&mut self, name: &str) -> Result<Option<(sdf::Value, Where)>> {
        let full = format!("inputs:{name}");
        Ok(match shader::follow(self.reader, self.view, &full)? {
            End::Value(value, at) => Some((value, at)),
            // How it looks is read beside this.
            End::Node(..) if SHOWN.contains(&name) => None,
            End::Node(node, _) => {
                let what = if node.has("inputs:file") { "a picture" } else { "the result of a shader network" };
                let text = format!("{what} as `{name}` of a surface is not used");
                self.reader.ledger.info(self.view.at_property(&full), text);
                None
            }
            End::Nothing => None,
        })
    }
    fn ignored(&mut self, name: &str, at: Where) {
        self.reader.ledger.warn(at, format!("a value of `{name}` that is none it can have: ignored"));
    }
    fn number(&mut self, name: &str, low: f64, high: f64) -> Result<Option<(f64, Where)>> {
        let Some((found, at)) = self.get(name)? else { return Ok(None) };
        match value::number(&found) {
            Some(x) if x.is_finite() && (low..=high).contains(&x) => Ok(Some((x, at))),
            _ => {
                self.ignored(name, at);
                Ok(None)
            }
        }
    }
    /// 3 numbers from 0 to 1, as the single precision that they have.
    fn color(&mut self, name: &str) -> Result<Option<([f64; 3], Where)>> {
        let Some((found, at)) = self.get(name)? else { return Ok(None) };
        match value::triple(&found) {
            Some(lanes) if lanes.iter().all(|lane| (0.0..=1.0).contains(lane)) => Ok(Some((lanes, at))),
            _ => {
                self.ignored(name, at);
                Ok(None)
            }
        }
    }
    fn flag(&mut self, name: &str) -> Result<bool> {
        Ok(self.get(name)?.and_then(|(found, _)| value::flag(&found)).unwrap_or(false))
    }
    /// What is there, not black, and of no meaning here.
    fn note(&mut self, name: &str, why: &str) -> Result<()> {
        if let Some(at) = self.lit(name)? {
            self.reader.ledger.info(at, format!("`{name}` of a surface {why}"));
        }
        Ok(())
    }
    /// What is there, not black, bears on light and is not used.
    fn lost(&mut self, name: &str, why: &str) -> Result<()> {
        if let Some(at) = self.lit(name)? {
            self.reader.ledger.warn(at, format!("`{name}` {why}"));
        }
        Ok(())
    }
    /// Where an input is said that is not black.
    fn lit(&mut self, name: &str) -> Result<Option<Where>> {
        let Some((found, at)) = self.get(name)? else { return Ok(None) };
        let dark = match value::triple(&found) {
            Some(lanes) => lanes == [0.0; 3],
            None => value::number(&found) == Some(0.0),
        };
        Ok((!dark).then_some(at))
    }
}

fn row(name: &str, data: Data, at: &Where) -> Row {
    (name.to_owned(), Value::new(data, at.clone()))
}

fn color_row(name: &str, lanes: [f64; 3], at: &Where) -> Row {
    let lanes = lanes.iter().map(|&lane| Value::new(Data::Number(lane), at.clone())).collect();
    row(name, Data::List(lanes), at)
}

fn preview(inputs: &mut Inputs<'_>) -> Result<Surface> {
    let mut out = Surface { preview: true, ..Surface::default() };
    if let Some((ior, at)) = inputs.number("ior", 1.0, f64::MAX)? {
        out.mapped.push(row("ior", Data::Number(ior), &at));
    }
    if let Some((lanes, at)) = inputs.color("diffuseColor")? {
        out.looks.push(color_row("base_color", lanes, &at));
    }
    for name in ["opacity", "metallic", "roughness"] {
        if let Some((x, at)) = inputs.number(name, 0.0, 1.0)? {
            out.looks.push(row(name, Data::Number(x), &at));
        }
    }
    let clear = |(name, value): &&Row| name == "opacity" && value.number().is_some_and(|opacity| opacity < 1.0);
    if let Some((_, value)) = out.looks.iter().find(clear)
        && out.mapped.iter().any(|(name, _)| name == "ior")
    {
        out.glass = Some(value.at.clone());
    }
    inputs.note("emissiveColor", "has no unit: it is no light here, say `emitter` for that")?;
    out.standard = standard::preview(inputs.reader, inputs.view)?;
    Ok(out)
}

/// The names of the two layered models.
struct Model {
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
    /// Names that mean nothing here.
    other: &'static [&'static str],
}

const OPEN_PBR: Model = Model {
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
    other: &["subsurface_weight", "specular_roughness_anisotropy", "base_diffuse_roughness"],
};

const STANDARD: Model = Model {
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
    other: &["subsurface", "specular_anisotropy", "transmission_extra_roughness", "diffuse_roughness"],
};

fn layered(inputs: &mut Inputs<'_>, model: &Model) -> Result<Surface> {
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
    if model.film_weight.is_some() {
        if let Some((nit, at)) = inputs.number("emission_luminance", 0.0, f64::MAX)? {
            let color = inputs.color("emission_color")?.map_or([1.0; 3], |(color, _)| color);
            let luminance = nit * luminance(color);
            if luminance > 0.0 {
                out.mapped.push(row("luminance_cd_m2", Data::Number(luminance), &at));
                if color[0] != color[1] || color[1] != color[2] {
                    let rgb = color_row("rgb", color, &at);
                    out.mapped.push(row("emitter.spectrum", Data::Table(vec![rgb]), &at));
                }
            }
        }
    } else {
        inputs.note("emission", "has no unit: it is no light here, say `emitter` for that")?;
    }
    looks(inputs, model, &mut out)?;
    out.standard = standard::layered(inputs.reader, inputs.view, model.film_weight.is_some())?;
    for name in model.other {
        inputs.note(name, "is not used")?;
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
    let Some((depth, at)) = inputs.number("transmission_depth", 0.0, f64::MAX)?.filter(|(depth, _)| *depth > 0.0)
    else {
        return Ok(());
    };
    let Some((color, color_at)) = inputs.color("transmission_color")? else { return Ok(()) };
    let metres = depth * inputs.reader.assembly.unit_m;
    if luminance(color) > 0.0 && metres.is_finite() && metres > 0.0 {
        out.mapped.push(row("attenuation_distance", Data::Number(metres), &at));
        out.mapped.push(color_row("attenuation_color", color, &color_at));
    } else {
        inputs.ignored("transmission_color", color_at);
    }
    Ok(())
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
