//! Our attributes as `eyebox:` properties, with the schemas that declare them applied.

use super::layer::{Datum, Prim, Property};
use super::stage::Writing;
use eyebox_base::error::Result;
use eyebox_base::relative_path::{relative, slashed};
use eyebox_base::{Error, Where};
use eyebox_scene::assembly::Assembly;
use eyebox_scene::attribute::usd::{UsdProperty, UsdValue, flatten};
use eyebox_scene::value::{Data, Value};
use std::path::Path;

/// The lists of the asset's root that attributes refer to.
const LISTS: [(&str, &str); 4] =
    [("medium", "media"), ("coating", "coatings"), ("emitter", "emitters"), ("slide", "slides")];

/// Says the asset's root attributes on the default prim.
pub(super) fn root(writing: &Writing<'_>, prim: &mut Prim) -> Result<()> {
    match &writing.assembly.optics {
        Some(root) => say(&of_root(root)?, prim),
        None => Ok(()),
    }
}

/// The properties of the asset's root; its lists have no place in USD, what refers to them is written out.
pub(super) fn of_root(root: &Value) -> Result<Vec<UsdProperty>> {
    let Data::Table(entries) = &root.data else { return flatten(root) };
    let kept = entries.iter().filter(|(key, _)| !LISTS.iter().any(|(_, list)| list == key)).cloned();
    flatten(&inlined(&Value::new(Data::Table(kept.collect()), root.at.clone()), Some(root)))
}

/// Says `attributes` on a prim.
pub(super) fn apply(writing: &Writing<'_>, attributes: &Value, prim: &mut Prim) -> Result<()> {
    say(&of(attributes, writing.assembly.optics.as_ref())?, prim)
}

/// The properties of `attributes`, which may refer to the lists of `root`.
pub(super) fn of(attributes: &Value, root: Option<&Value>) -> Result<Vec<UsdProperty>> {
    flatten(&inlined(attributes, root))
}

/// Puts properties on a prim and applies their schemas.
pub(super) fn say(properties: &[UsdProperty], prim: &mut Prim) -> Result<()> {
    for property in properties {
        prim.apply(&schema(&property.name));
        let mut own = Property::new(property.name.clone(), datum(&property.value, &property.at)?);
        // The asset's schema declares its own properties, not what may stand behind `default`.
        own.custom = property.name.starts_with("eyebox:default:");
        prim.push(own);
    }
    Ok(())
}

/// The schema that declares a property: a face's by the name that it has there, `default`'s is the asset's, any other by
/// its noun.
fn schema(name: &str) -> String {
    let mut words = name.split(':').skip(1);
    match (words.next(), words.next()) {
        (Some("face"), Some(instance)) => format!("EyeboxFaceAPI_1:{instance}"),
        (Some("default"), _) => "EyeboxAssetAPI_1".to_owned(),
        (Some(noun), _) => {
            let mut letters = noun.chars();
            let first = letters.next().map(|letter| letter.to_ascii_uppercase());
            format!("Eyebox{}{}API_1", first.unwrap_or('X'), letters.as_str())
        }
        (None, _) => "EyeboxAPI_1".to_owned(),
    }
}

fn datum(value: &UsdValue, at: &Where) -> Result<Datum> {
    Ok(match value {
        UsdValue::Double(x) => Datum::Double(*x),
        UsdValue::Double2(p) => Datum::Double2(*p),
        UsdValue::Double3(p) => Datum::Double3(*p),
        UsdValue::Doubles(list) => Datum::Doubles(list.clone()),
        UsdValue::Double2s(list) => Datum::Double2s(list.clone()),
        UsdValue::Double3s(list) => Datum::Double3s(list.clone()),
        UsdValue::Int(x) => Datum::Int(*x),
        UsdValue::Int2(p) => Datum::Int2(*p),
        UsdValue::Ints(list) => Datum::Ints(list.clone()),
        UsdValue::Token(text) => Datum::Token(text.clone()),
        UsdValue::Tokens(list) => Datum::Tokens(list.clone()),
        UsdValue::Asset(path) => Datum::Asset(anchored(path, at)?),
    })
}

/// A relative path with `./` before it, so that USD looks for it beside the layer and nowhere else.
///
/// # Errors
/// A name that USD's text cannot hold.
fn anchored(path: &str, at: &Where) -> Result<String> {
    if path.chars().any(char::is_control) {
        return Err(Error::new(at.clone(), format!("the file name {path:?} has control characters")));
    }
    let plain = path.is_empty() || path.starts_with("./") || path.starts_with("../") || Path::new(path).is_absolute();
    Ok(if plain { path.to_owned() } else { format!("./{path}") })
}

/// How a file in `folder` names `target`.
///
/// # Errors
/// A name that USD's text cannot hold.
pub(super) fn asset_path(folder: &Path, target: &Path) -> Result<String> {
    anchored(&slashed(&relative(folder, target)), &Where::file(target))
}

/// Metres per unit, as the asset's own `unit` corrects it.
pub(super) fn unit(assembly: &Assembly) -> f64 {
    let said = assembly.optics.as_ref().and_then(|root| root.get("unit")).and_then(Value::number);
    said.filter(|unit| unit.is_finite() && *unit > 0.0).unwrap_or(assembly.unit_m)
}

/// `value` with everything in it that refers to an entry of the asset's lists, by index or name, replaced by the entry:
/// USD has no such lists. What refers to nothing in them stays, it may be a sidecar's.
pub(super) fn inlined(value: &Value, root: Option<&Value>) -> Value {
    let Data::Table(entries) = &value.data else { return value.clone() };
    let entries = entries.iter().map(|(key, entry)| {
        let new = match (key.as_str(), &entry.data) {
            ("default", Data::Table(_)) => inlined(entry, root),
            ("faces", Data::List(items)) => {
                let items = items.iter().map(|item| inlined(item, root)).collect();
                Value::new(Data::List(items), entry.at.clone())
            }
            _ => referred(key, entry, root).unwrap_or_else(|| entry.clone()),
        };
        (key.clone(), new)
    });
    Value::new(Data::Table(entries.collect()), value.at.clone())
}

fn referred(key: &str, entry: &Value, root: Option<&Value>) -> Option<Value> {
    let (_, list) = LISTS.iter().find(|(noun, _)| *noun == key)?;
    let items = root?.get(list)?.list()?;
    match &entry.data {
        Data::Number(index) => {
            let whole = *index as usize;
            if whole as f64 == *index { items.get(whole).cloned() } else { None }
        }
        Data::Text(name) => items.iter().find(|item| item.get("name").and_then(Value::text) == Some(name)).cloned(),
        Data::Bool(_) | Data::List(_) | Data::Table(_) => None,
    }
}
