//! RenderSettings, RenderProduct, RenderVar: which layers the asset asks for, and which camera is meant.

use super::attribute::PrimView;
use super::reader::Reader;
use super::value;
use crate::assembly::RequestedLayer;
use eyebox_base::Where;
use eyebox_base::error::Result;
use openusd::sdf;

/// What the walk met.
#[derive(Debug, Default)]
pub(super) struct Known {
    pub settings: Vec<sdf::Path>,
    /// The cameras of the assembly, by their prims.
    pub cameras: Vec<(sdf::Path, usize)>,
}

/// Fills `assembly.layers` from the settings that the stage names, or from its only ones, and puts their camera first.
///
/// # Errors
/// Values of the wrong type.
pub(super) fn read(reader: &mut Reader) -> Result<()> {
    let Some(settings) = settings(reader)? else { return Ok(()) };
    let mut camera = settings.targets("camera")?.into_iter().next();
    if settings.has("resolution") {
        let text = "the resolution of RenderSettings is not used: `eye.resolution` says it";
        reader.ledger.info(settings.at_property("resolution"), text);
    }
    for path in settings.targets("products")? {
        let Some(product) = typed(reader, &settings, &path, "RenderProduct")? else { continue };
        if product.token("productType")?.as_deref() == Some("deepRaster") {
            reader.ledger.warn(product.at(), "deep pictures are not written: flat ones are");
        }
        camera = camera.or(product.targets("camera")?.into_iter().next());
        for path in product.targets("orderedVars")? {
            let Some(var) = typed(reader, &product, &path, "RenderVar")? else { continue };
            if let Some(wish) = wish(reader, &var)?
                && !reader.assembly.layers.contains(&wish)
            {
                reader.charge(&path, 1, size_of::<RequestedLayer>() + 256)?;
                reader.assembly.layers.push(wish);
            }
        }
    }
    if let Some(camera) = camera {
        first(reader, &settings, &camera);
    }
    Ok(())
}

fn settings(reader: &mut Reader) -> Result<Option<PrimView>> {
    let root = sdf::Path::abs_root();
    let named = reader.stage.stage_metadata("renderSettingsPrimPath");
    let named = named.map_err(|error| reader.moment.failed(&root, error))?;
    let named = named.as_ref().and_then(value::text).filter(|text| !text.is_empty()).map(str::to_owned);
    let path = match (named, reader.render.settings.as_slice()) {
        (Some(named), _) => match sdf::Path::new(&named) {
            Ok(path) if path.is_prim_path() => path,
            Ok(_) | Err(_) => {
                let text = format!("`renderSettingsPrimPath` is no path of a prim: {named}");
                reader.ledger.warn(Where::file(&reader.moment.file), text);
                return Ok(None);
            }
        },
        (None, [only]) => only.clone(),
        (None, []) => return Ok(None),
        (None, [first, ..]) => {
            let text = "several RenderSettings, and no `renderSettingsPrimPath` says which: none is used";
            reader.ledger.warn(reader.moment.at(first), text);
            return Ok(None);
        }
    };
    let prim = reader.prim(&path)?;
    let view = PrimView::new(prim, &reader.moment)?;
    if view.type_name()? != "RenderSettings" {
        let text = format!("`renderSettingsPrimPath` names <{}>, which is no RenderSettings", path.as_str());
        reader.ledger.warn(Where::file(&reader.moment.file), text);
        return Ok(None);
    }
    Ok(Some(view))
}

/// The prim at `path`, if it is what it should be.
fn typed(reader: &mut Reader, from: &PrimView, path: &sdf::Path, type_name: &str) -> Result<Option<PrimView>> {
    let prim = if path.is_prim_path() { Some(reader.prim(path)?) } else { None };
    let view = prim.map(|prim| PrimView::new(prim, &reader.moment)).transpose()?;
    if let Some(view) = view
        && view.type_name()? == type_name
    {
        return Ok(Some(view));
    }
    reader.ledger.warn(from.at(), format!("<{}> is no {type_name}", path.as_str()));
    Ok(None)
}

/// What a RenderVar asks for. Its name: `driver:parameters:aov:channel_prefix`, else `driver:parameters:aov:name`, else
/// the prim's.
fn wish(reader: &mut Reader, var: &PrimView) -> Result<Option<RequestedLayer>> {
    let source = var.token("sourceName")?.unwrap_or_default();
    let expression = match var.token("sourceType")?.as_deref() {
        None | Some("raw" | "intrinsic") => false,
        Some("lpe") => true,
        Some(other) => {
            reader.ledger.warn(var.at(), format!("a RenderVar of the source type `{other}` is not written"));
            return Ok(None);
        }
    };
    if source.is_empty() {
        reader.ledger.warn(var.at(), "a RenderVar without `sourceName` is not written");
        return Ok(None);
    }
    let mut name = var.name().to_owned();
    for key in ["driver:parameters:aov:channel_prefix", "driver:parameters:aov:name"] {
        if let Some(said) = var.token(key)?.filter(|said| !said.is_empty()) {
            name = said;
            break;
        }
    }
    Ok(Some(RequestedLayer { source, expression, name, at: var.at() }))
}

/// Puts the camera of the settings before the others.
fn first(reader: &mut Reader, settings: &PrimView, path: &sdf::Path) {
    let found = reader.render.cameras.iter().find(|(own, _)| own == path).map(|(_, index)| *index);
    match found.filter(|index| *index < reader.assembly.cameras.len()) {
        Some(index) => {
            let camera = reader.assembly.cameras.remove(index);
            reader.assembly.cameras.insert(0, camera);
        }
        None => reader.ledger.warn(settings.at(), format!("its camera <{}> is not on the stage", path.as_str())),
    }
}
