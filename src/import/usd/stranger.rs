//! Surface shaders of kinds that nobody here knows (hair, a studio's own, another renderer's): their base colour where an input's
//! name says it, and a warning.

use super::attribute::PrimView;
use super::inputs::Shader;
use super::surface::{Surface, color_row};
use super::{reader::Reader, shader};
use eyebox_base::error::Result;
use eyebox_scene::{Scalar, StandardSurface};

/// Names of base colours, without capitals and underscores, the likeliest first.
const BASE: [&str; 11] = [
    "basecolor",
    "diffusecolor",
    "diffusereflectioncolor",
    "diffusecolorconstant",
    "kdcolor",
    "albedo",
    "albedocolor",
    "diffuse",
    "color",
    "surfacecolor",
    "paintcolor",
];

/// Where shaders without `info:id` say what they are.
const SOURCES: [&str; 3] =
    ["info:mdl:sourceAsset:subIdentifier", "info:sourceAsset:subIdentifier", "info:osl:sourceAsset:subIdentifier"];

/// What is known of such a shader; none where no name says a colour.
///
/// # Errors
/// What the library cannot read.
pub(super) fn read(reader: &mut Reader, view: &PrimView) -> Result<Option<Surface>> {
    let what = match kind(view)? {
        Some(kind) => format!("surface shaders of the kind `{kind}` are not known"),
        None => "a surface shader that does not say its kind (`info:id`)".to_owned(),
    };
    let Some(name) = base_color(view)? else {
        reader.ledger.warn(view.at(), format!("{what}: what it is on is grey"));
        return Ok(None);
    };
    reader.ledger.warn(view.at(), format!("{what}: its `{name}` is taken as the colour of a matt surface"));
    let mut out = Surface::default();
    let (base_color, vertex_colors) = Shader { reader: &mut *reader, view }.base(None, (&name, [0.8; 3]))?;
    if base_color.texture.is_none() && base_color.factor.iter().all(|c| (0.0..=1.0).contains(c)) {
        out.looks.push(color_row("base_color", base_color.factor, &view.at_property(&format!("inputs:{name}"))));
    }
    out.standard = StandardSurface {
        name: view.name().to_owned(),
        base_color,
        vertex_colors,
        specular: Scalar::new(0.0),
        ..StandardSurface::default()
    };
    Ok(Some(out))
}

fn kind(view: &PrimView) -> Result<Option<String>> {
    let id = shader::id(view)?;
    if !id.is_empty() {
        return Ok(Some(id));
    }
    for name in SOURCES {
        if let Some(kind) = view.token(name)?.filter(|kind| !kind.is_empty()) {
            return Ok(Some(kind));
        }
    }
    Ok(None)
}

/// The input whose name is that of a base colour.
fn base_color(view: &PrimView) -> Result<Option<String>> {
    let mut found: Option<(usize, &str)> = None;
    for property in view.property_names() {
        let Some(name) = property.strip_prefix("inputs:") else { continue };
        let plain: String = name.chars().filter(|c| *c != '_').map(|c| c.to_ascii_lowercase()).collect();
        let Some(place) = BASE.iter().position(|base| *base == plain) else { continue };
        let type_name = view.property_text(property, "typeName")?.unwrap_or_default();
        let is_colour = ["color", "float3", "vector3"].iter().any(|own| type_name.starts_with(own));
        if is_colour && found.is_none_or(|(best, _)| place < best) {
            found = Some((place, name));
        }
    }
    Ok(found.map(|(_, name)| name.to_owned()))
}
