//! What the surface shaders that we know say, in our words. Only what the file says is mapped; defaults are ours to
//! choose.

use super::attribute::PrimView;
use super::fold::Lanes;
use super::inputs::Shader;
use super::layered::{OPEN_PBR, STANDARD, layered};
use super::reader::Reader;
use super::shader::{self, End};
use super::{network, standard, value};
use crate::value::{Data, Value};
use eyebox_base::Where;
use eyebox_base::colour::luminance;
use eyebox_base::error::Result;
use eyebox_scene::StandardSurface;
use openusd::sdf;

pub(super) type Row = (String, Value);

/// What of the models may be a picture; `standard` says where one is not used.
const SHOWN: [&str; 35] = [
    "diffuseColor",
    "specularColor",
    "metallic",
    "roughness",
    "opacity",
    "clearcoat",
    "ior",
    "base",
    "base_weight",
    "base_color",
    "metalness",
    "base_metalness",
    "specular",
    "specular_weight",
    "specular_color",
    "specular_IOR",
    "specular_ior",
    "specular_roughness",
    "transmission",
    "transmission_weight",
    "coat",
    "coat_weight",
    "coat_roughness",
    "sheen",
    "sheen_color",
    "sheen_roughness",
    "fuzz_weight",
    "fuzz_color",
    "fuzz_roughness",
    "emission",
    "emission_luminance",
    "emission_color",
    "emissive",
    "emissive_strength",
    "emissiveColor",
];

/// What our writer says in a layered surface where it is so.
pub(super) const SAID: [&str; 3] = ["ior", "luminance_cd_m2", "emitter.spectrum"];

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
/// | `luminance_cd_m2`, `emitter.spectrum` | `emissiveColor` | `emission_luminance` in nit × `emission_color` | `emission` × `emission_color` |
///
/// Emission without a unit is one cd/m² a unit, as glTF's.
///
/// | entry | UsdPreviewSurface | OpenPBR | standard_surface |
/// |---|---|---|---|
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
        name if name.contains("gltf_pbr") => Some(gltf(&mut inputs)?),
        _ => None,
    })
}

/// The inputs of one shader.
pub(super) struct Inputs<'a> {
    pub reader: &'a mut Reader,
    pub view: &'a PrimView,
}

impl Inputs<'_> {
    fn get(&mut self, name: &str) -> Result<Option<(sdf::Value, Where)>> {
        let full = format!("inputs:{name}");
        Ok(match shader::follow(self.reader, self.view, &full)? {
            End::Value(value, at) => Some((value, at)),
            End::Node(node, _) => {
                let folded = network::folded(self.reader, self.view, &full)?;
                if let Some(lanes) = folded.and_then(|folded| folded.lanes()) {
                    return Ok(Some((constant(lanes), self.view.at_property(&full))));
                }
                // How it looks is read beside this.
                if !SHOWN.contains(&name) {
                    let what = if node.has("inputs:file") { "a picture" } else { "the result of a shader network" };
                    let text = format!("{what} as `{name}` of a surface is not used");
                    self.reader.ledger.info(self.view.at_property(&full), text);
                }
                None
            }
            End::Nothing => None,
        })
    }
    pub fn ignored(&mut self, name: &str, at: Where) {
        self.reader.ledger.warn(at, format!("a value of `{name}` that is none it can have: ignored"));
    }
    pub fn number(&mut self, name: &str, low: f64, high: f64) -> Result<Option<(f64, Where)>> {
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
    pub fn color(&mut self, name: &str) -> Result<Option<([f64; 3], Where)>> {
        let Some((found, at)) = self.get(name)? else { return Ok(None) };
        // A number of a network is in all lanes.
        match value::triple(&found).or_else(|| value::number(&found).map(|x| [x; 3])) {
            Some(lanes) if lanes.iter().all(|lane| (0.0..=1.0).contains(lane)) => Ok(Some((lanes, at))),
            _ => {
                self.ignored(name, at);
                Ok(None)
            }
        }
    }
    pub fn flag(&mut self, name: &str) -> Result<bool> {
        Ok(self.get(name)?.and_then(|(found, _)| value::flag(&found)).unwrap_or(false))
    }
}

/// A constant of a network as a value: a number where all lanes are the same.
fn constant([r, g, b, a]: Lanes) -> sdf::Value {
    if r == g && g == b && a == r { sdf::Value::Double(r) } else { sdf::Value::Vec3d([r, g, b].into()) }
}

pub(super) fn row(name: &str, data: Data, at: &Where) -> Row {
    (name.to_owned(), Value::new(data, at.clone()))
}

pub(super) fn color_row(name: &str, lanes: [f64; 3], at: &Where) -> Row {
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
    let share = opacity_mode(inputs)?;
    let clear = |(name, value): &&Row| name == "opacity" && value.number().is_some_and(|opacity| opacity < 1.0);
    if !share
        && let Some((_, value)) = out.looks.iter().find(clear)
        && out.mapped.iter().any(|(name, _)| name == "ior")
    {
        out.glass = Some(value.at.clone());
    }
    out.standard = standard::preview(inputs.reader, inputs.view)?;
    shines(inputs, None, ("emissiveColor", [0.0; 3]), &mut out)?;
    Ok(out)
}

/// Whether an opacity is said to be a share of what is there, rather than glass (UsdPreviewSurface 2.6, `opacityMode`).
fn opacity_mode(inputs: &mut Inputs<'_>) -> Result<bool> {
    let mode = network::text(inputs.reader, inputs.view, "opacityMode")?;
    Ok(match mode.as_deref() {
        None | Some("transparent") => false,
        Some("presence") => true,
        Some(other) => {
            let text = format!("the opacity mode `{other}` is neither transparent nor presence: taken as transparent");
            inputs.reader.ledger.warn(inputs.view.at_property("inputs:opacityMode"), text);
            false
        }
    })
}

/// MaterialX' glTF model: what glTF 2.0 and its extensions of these names say.
fn gltf(inputs: &mut Inputs<'_>) -> Result<Surface> {
    let mut out = Surface::default();
    if let Some((ior, at)) = inputs.number("ior", 1.0, f64::MAX)? {
        out.mapped.push(row("ior", Data::Number(ior), &at));
    }
    if let Some((share, at)) = inputs.number("transmission", 0.0, 1.0)?.filter(|(share, _)| *share > 0.0) {
        out.mapped.push(row("transmission", Data::Number(share), &at));
        if let Some((thickness, at)) = inputs.number("thickness", 0.0, f64::MAX)?.filter(|(x, _)| *x > 0.0) {
            out.mapped.push(row("thickness", Data::Number(thickness), &at));
            attenuation(inputs, "attenuation_distance", "attenuation_color", &mut out)?;
        }
    }
    if let Some((dispersion, at)) = inputs.number("dispersion", 0.0, f64::MAX)?.filter(|(x, _)| *x > 0.0) {
        out.mapped.push(row("dispersion", Data::Number(dispersion), &at));
    }
    if let Some((lanes, at)) = inputs.color("base_color")? {
        out.looks.push(color_row("base_color", lanes, &at));
    }
    for (key, name) in [("opacity", "alpha"), ("metallic", "metallic"), ("roughness", "roughness")] {
        if let Some((x, at)) = inputs.number(name, 0.0, 1.0)? {
            out.looks.push(row(key, Data::Number(x), &at));
        }
    }
    out.standard = standard::gltf(inputs.reader, inputs.view)?;
    shines(inputs, Some(("emissive_strength", 1.0)), ("emissive", [0.0; 3]), &mut out)?;
    Ok(out)
}

/// A face that shines: a weight times a colour in cd/m², as the emission of glTF is read. The picture that it shines through goes
/// with the surface. Names and what they are where nothing is said.
pub(super) fn shines(
    inputs: &mut Inputs<'_>,
    weight: Option<(&str, f64)>,
    color: (&str, [f64; 3]),
    out: &mut Surface,
) -> Result<()> {
    let mut names = weight.iter().map(|(name, _)| *name).chain([color.0]).map(|name| format!("inputs:{name}"));
    let Some(name) = names.find(|name| inputs.view.has(name)) else { return Ok(()) };
    let at = inputs.view.at_property(&name);
    let mut shader = Shader { reader: &mut *inputs.reader, view: inputs.view };
    let Some((rgb, picture)) = shader.light(weight, color)? else { return Ok(()) };
    let luminance = luminance(rgb);
    if !luminance.is_finite() {
        inputs.ignored(color.0, at);
        return Ok(());
    }
    if luminance > 0.0 {
        out.mapped.push(row("luminance_cd_m2", Data::Number(luminance), &at));
        if rgb[0] != rgb[1] || rgb[1] != rgb[2] {
            let most = rgb.iter().copied().fold(1.0, f64::max);
            let rgb = color_row("rgb", rgb.map(|lane| lane / most), &at);
            out.mapped.push(row("emitter.spectrum", Data::Table(vec![rgb]), &at));
        }
        out.standard.emission = picture;
    }
    Ok(())
}

/// What a solid lets through over a distance in scene units.
pub(super) fn attenuation(inputs: &mut Inputs<'_>, distance: &str, color: &str, out: &mut Surface) -> Result<()> {
    let Some((depth, at)) = inputs.number(distance, 0.0, f64::MAX)?.filter(|(depth, _)| *depth > 0.0) else {
        return Ok(());
    };
    let Some((lanes, color_at)) = inputs.color(color)? else { return Ok(()) };
    let metres = depth * inputs.reader.assembly.unit_m;
    if luminance(lanes) > 0.0 && metres.is_finite() && metres > 0.0 {
        out.mapped.push(row("attenuation_distance", Data::Number(metres), &at));
        out.mapped.push(color_row("attenuation_color", lanes, &color_at));
    } else {
        inputs.ignored(color, color_at);
    }
    Ok(())
}
