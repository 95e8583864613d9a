//! Our own attributes, `eyebox:…`, on the stage, on prims and on subsets.

use super::attribute::PrimView;
use super::reader::Reader;
use crate::value::{Data, Value};
use eyebox_base::error::Result;
use eyebox_base::relative_path::{folder_of, relative, slashed};
use eyebox_scene::attribute::usd::{NAMESPACE, UsdProperty, UsdValue, gather};
use openusd::sdf;
use std::path::Path;

/// What the default prim says of the whole asset.
const ROOT: [&str; 7] = ["version", "unit", "wavelengths", "sky", "sun", "eye", "default"];

/// Of the whole asset.
pub(super) fn root(reader: &mut Reader) -> Result<Option<Value>> {
    let absolute = sdf::Path::abs_root();
    let failed = |error| reader.moment.failed(&absolute, error);
    let Some(name) = reader.stage.stage_metadata("defaultPrim").map_err(failed)? else { return Ok(None) };
    let Some(path) = super::value::text(&name).and_then(sdf::default_prim_path) else { return Ok(None) };
    let prim = reader.prim(&path)?;
    let view = PrimView::new(prim, &reader.moment)?;
    let Some(all) = said(&view)? else { return Ok(None) };
    Ok(keep(all, true))
}

/// Of a prim that becomes a node.
pub(super) fn node(_reader: &mut Reader, view: &PrimView) -> Result<Option<Value>> {
    Ok(said(view)?.and_then(|all| keep(all, false)))
}

/// Of a GeomSubset that is a face.
pub(super) fn face(_reader: &mut Reader, subset: &PrimView) -> Result<Option<Value>> {
    said(subset)
}

/// Of a Material.
pub(super) fn material(_reader: &mut Reader, view: &PrimView) -> Result<Option<Value>> {
    said(view)
}

fn keep(all: Value, root: bool) -> Option<Value> {
    let Data::Table(entries) = all.data else { return None };
    let entries: Vec<_> = entries.into_iter().filter(|(key, _)| ROOT.contains(&key.as_str()) == root).collect();
    (!entries.is_empty()).then(|| Value::new(Data::Table(entries), all.at))
}

fn said(view: &PrimView) -> Result<Option<Value>> {
    let mut properties = Vec::new();
    for name in view.property_names().iter().filter(|name| name.starts_with(NAMESPACE)) {
        let Some(found) = view.get(name)? else { continue };
        let Some(value) = convert(found, &view.moment.file) else {
            return Err(view.fault_in(name, "a value of a type that none of our attributes has"));
        };
        properties.push(UsdProperty { name: name.clone(), value, at: view.at_property(name) });
    }
    gather(&properties)
}

fn convert(value: sdf::Value, file: &Path) -> Option<UsdValue> {
    use sdf::Value as V;
    Some(match value {
        V::Double(x) => UsdValue::Double(x),
        V::Float(x) => UsdValue::Double(f64::from(x)),
        V::Vec2d(p) => UsdValue::Double2([p.x, p.y]),
        V::Vec3d(p) => UsdValue::Double3([p.x, p.y, p.z]),
        V::DoubleVec(x) => UsdValue::Doubles(x),
        V::Vec2dVec(x) => UsdValue::Double2s(x.into_iter().map(|p| [p.x, p.y]).collect()),
        V::Vec3dVec(x) => UsdValue::Double3s(x.into_iter().map(|p| [p.x, p.y, p.z]).collect()),
        V::Int(x) => UsdValue::Int(x),
        V::Vec2i(p) => UsdValue::Int2([p.x, p.y]),
        V::IntVec(x) => UsdValue::Ints(x),
        V::Token(x) => UsdValue::Token(x.as_str().to_owned()),
        V::String(x) => UsdValue::Token(x),
        V::TokenVec(x) => UsdValue::Tokens(x.iter().map(|token| token.as_str().to_owned()).collect()),
        V::StringVec(x) => UsdValue::Tokens(x),
        V::AssetPath(path) => UsdValue::Asset(match path.resolved_path().filter(|path| !path.is_empty()) {
            Some(found) => slashed(&relative(&folder_of(file), Path::new(found))),
            None => super::normalise::meant(path.as_str()).into_owned(),
        }),
        _ => return None,
    })
}
