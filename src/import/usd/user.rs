//! Custom attributes of prims and materials, `userProperties:` above all: what authors say beside the schemas.

use super::attribute::{PrimView, one_line};
use super::reader::Reader;
use super::round_trip::RoundTrip;
use eyebox_base::Error;
use eyebox_base::error::Result;
use eyebox_scene::user_property::{UsdProperty, UserProperty, UserValue};
use openusd::sdf::Value;
use openusd::usd::TimeCode;
use std::collections::{HashMap, HashSet};

/// Where Blender and others put what users say.
const SPACE: &str = "userProperties:";
/// The mark with names that are no USD names: the name in the file, the name as it was, and so on.
const NAMES: &str = "userNames";
/// The mark with the names of those whose value stands there as JSON.
const JSON: &str = "userJson";

/// Namespaces of schemas. What stands there is read elsewhere or means nothing without its schema.
const OF_SCHEMAS: [&str; 14] = [
    "eyebox:",
    "primvars:",
    "xformOp",
    "inputs:",
    "outputs:",
    "info:",
    "material:",
    "collection:",
    "skel:",
    "subsetFamily:",
    "model:",
    "shutter:",
    "ui:",
    "light:",
];
/// Properties that most prims have, of which nobody need ask whether they are custom.
const COMMON: [&str; 12] = [
    "points",
    "normals",
    "faceVertexCounts",
    "faceVertexIndices",
    "extent",
    "visibility",
    "purpose",
    "orientation",
    "subdivisionScheme",
    "doubleSided",
    "velocities",
    "interpolateBoundary",
];

/// The custom attributes of a prim.
///
/// # Errors
/// A value that cannot be read; more than the stage can honestly need.
pub(super) fn of(reader: &mut Reader, view: &PrimView, marks: &RoundTrip) -> Result<Vec<UserProperty>> {
    let names = marks.texts(NAMES);
    let names: HashMap<&str, &str> = names.chunks_exact(2).map(|pair| (pair[0].as_str(), pair[1].as_str())).collect();
    let json: HashSet<String> = marks.texts(JSON).into_iter().collect();
    let mut all = Vec::new();
    for name in view.property_names() {
        let (own, bare) = match name.strip_prefix(SPACE) {
            Some(own) => (own, false),
            None if COMMON.contains(&name.as_str()) || OF_SCHEMAS.iter().any(|own| name.starts_with(own)) => continue,
            None => (name.as_str(), true),
        };
        let attribute = view.prim.attribute(name);
        let failed =
            |error: openusd::Error| Error::new(view.at_property(name), one_line(&format!("cannot be read: {error}")));
        if bare && !attribute.is_custom().map_err(failed)? {
            continue;
        }
        let time = reader.moment.frame.map(TimeCode::new);
        let found = match attribute.get_at::<Value>(time).map_err(failed)? {
            None => attribute.get_at::<Value>(Some(TimeCode::EARLIEST)).map_err(failed)?,
            found => found,
        };
        let Some(found) = found else {
            // A relationship, or an attribute of which nothing is said.
            reader.ledger.info(view.at_property(name), "a custom property without a value: not kept");
            continue;
        };
        let is_json = json.contains(name);
        let declared = attribute.type_name().map_err(failed)?.map(|name| name.to_string()).unwrap_or_default();
        let Some((value, type_name)) = value(&found, &declared) else {
            reader.ledger.warn(view.at_property(name), format!("a custom property of type {declared}: not kept"));
            continue;
        };
        if reader.moment.keys.is_some() && attribute.num_time_samples().map_err(failed)? > 1 {
            reader.ledger.warn(view.at_property(name), "a custom property that changes: it is kept as it is once");
        }
        reader.charge(view.path(), 1, value.cost())?;
        let own = names.get(name.as_str()).copied().unwrap_or(own).to_owned();
        let value = match &value {
            UserValue::Text(text) if is_json => {
                serde_json::from_str(text).map_or(value, |json| UserValue::of_json(&json))
            }
            UserValue::Nothing
            | UserValue::Bool(_)
            | UserValue::Integer(_)
            | UserValue::Number(_)
            | UserValue::Text(_)
            | UserValue::List(_)
            | UserValue::Table(_) => value,
        };
        let usd = (!is_json).then_some(UsdProperty { type_name, bare });
        all.push(UserProperty { name: own, usd, value });
    }
    Ok(all)
}

/// Types with a role, whose numbers are those of a plain type.
const ROLES: [&str; 18] = [
    "color3f",
    "color3f[]",
    "color3d",
    "color3d[]",
    "color4f",
    "point3f",
    "point3f[]",
    "point3d",
    "point3d[]",
    "vector3f",
    "vector3f[]",
    "vector3d",
    "vector3d[]",
    "normal3f",
    "normal3f[]",
    "normal3d",
    "texCoord2f",
    "texCoord2f[]",
];

/// A value, and the type of those that can be written that it has.
fn value(found: &Value, declared: &str) -> Option<(UserValue, &'static str)> {
    let whole = |x: i64| UserValue::Integer(x);
    let single = |x: f32| UserValue::Number(f64::from(x));
    let double = UserValue::Number;
    let role = |plain: &'static str| ROLES.iter().find(|role| **role == declared).copied().unwrap_or(plain);
    fn list<T: Copy>(all: &[T], one: impl Fn(T) -> UserValue) -> UserValue {
        UserValue::List(all.iter().map(|x| one(*x)).collect())
    }
    let text = |text: &str| UserValue::Text(text.to_owned());
    Some(match found {
        Value::Bool(x) => (UserValue::Bool(*x), "bool"),
        Value::Uchar(x) => (whole(i64::from(*x)), "int"),
        Value::Int(x) => (whole(i64::from(*x)), "int"),
        Value::Uint(x) => (whole(i64::from(*x)), "int"),
        Value::Int64(x) => (whole(*x), "int"),
        Value::Uint64(x) => (i64::try_from(*x).map_or(double(*x as f64), whole), "int"),
        Value::Half(x) => (double(x.to_f64()), "float"),
        Value::Float(x) => (single(*x), "float"),
        Value::Double(x) => (double(*x), "double"),
        Value::TimeCode(x) => (double(x.0), "double"),
        Value::String(x) => (text(x), "string"),
        Value::Token(x) => (text(x.as_str()), "token"),
        Value::AssetPath(x) => (text(x.asset_path()), "asset"),
        Value::BoolVec(all) => (list(all, UserValue::Bool), "bool[]"),
        Value::IntVec(all) => (list(all, |x| whole(i64::from(x))), "int[]"),
        Value::Int64Vec(all) => (list(all, whole), "int[]"),
        Value::FloatVec(all) => (list(all, single), "float[]"),
        Value::DoubleVec(all) => (list(all, double), "double[]"),
        Value::StringVec(all) => (UserValue::List(all.iter().map(|own| text(own)).collect()), "string[]"),
        Value::TokenVec(all) => (UserValue::List(all.iter().map(|own| text(own.as_str())).collect()), "token[]"),
        Value::Vec2i(v) => (list(&[v.x, v.y], |x| whole(i64::from(x))), "int2"),
        Value::Vec3i(v) => (list(&[v.x, v.y, v.z], |x| whole(i64::from(x))), "int[]"),
        Value::Vec2f(v) => (list(&[v.x, v.y], single), role("float2")),
        Value::Vec3f(v) => (list(&[v.x, v.y, v.z], single), role("float3")),
        Value::Vec4f(v) => (list(&[v.x, v.y, v.z, v.w], single), role("float4")),
        Value::Vec2d(v) => (list(&[v.x, v.y], double), "double2"),
        Value::Vec3d(v) => (list(&[v.x, v.y, v.z], double), role("double3")),
        Value::Vec4d(v) => (list(&[v.x, v.y, v.z, v.w], double), "double[]"),
        Value::Vec2fVec(all) => {
            (UserValue::List(all.iter().map(|v| list(&[v.x, v.y], single)).collect()), role("float2[]"))
        }
        Value::Vec3fVec(all) => {
            (UserValue::List(all.iter().map(|v| list(&[v.x, v.y, v.z], single)).collect()), role("float3[]"))
        }
        Value::Vec2dVec(all) => (UserValue::List(all.iter().map(|v| list(&[v.x, v.y], double)).collect()), "double2[]"),
        Value::Vec3dVec(all) => {
            (UserValue::List(all.iter().map(|v| list(&[v.x, v.y, v.z], double)).collect()), role("double3[]"))
        }
        _ => return None,
    })
}
