//! A layer as a `.usdc` crate or inside a `.usdz` package, through `openusd`.

use super::layer::{Body, Datum, Layer, Prim, Property, Specifier};
use eyebox_base::error::Result;
use eyebox_base::{Error, Where};
use openusd::gf;
use openusd::sdf::{self, ChildrenKey, Data, FieldKey, Path as SdfPath, SpecData, SpecType, Value};
use openusd::tf::Token;
use std::collections::HashMap;
use std::io::Cursor;
use std::path::Path;

/// The bytes of `layer` as a crate file.
///
/// # Errors
/// The library refuses something (a defect of ours); `file` is named.
pub fn crate_bytes(layer: &Layer, file: &Path) -> Result<Vec<u8>> {
    let failed = |error: &dyn std::fmt::Display| Error::new(Where::file(file), format!("cannot be written: {error}"));
    let data = data(layer).map_err(|error| failed(&error))?;
    let mut out = Cursor::new(Vec::new());
    openusd::usdc::CrateWriter::write(&data, &mut out).map_err(|error| failed(&error))?;
    Ok(out.into_inner())
}

/// The bytes of a package that holds `layer` as a crate file `NAME.usdc`, and after it the files `beside` it, by their
/// names. Nothing is compressed, and the bytes of each start at a multiple of 64.
///
/// # Errors
/// As [`crate_bytes`].
pub fn package_bytes(layer: &Layer, beside: &[(String, Vec<u8>)], file: &Path, name: &str) -> Result<Vec<u8>> {
    let failed = |error: &dyn std::fmt::Display| Error::new(Where::file(file), format!("cannot be written: {error}"));
    let inner = crate_bytes(layer, file)?;
    let mut archive = openusd::usdz::ArchiveWriter::new(Cursor::new(Vec::new()));
    archive.add_layer(&format!("{name}.usdc"), &inner).map_err(|error| failed(&error))?;
    for (name, bytes) in beside {
        archive.add_layer(name, bytes).map_err(|error| failed(&error))?;
    }
    Ok(archive.finish().map_err(|error| failed(&error))?.into_inner())
}

type Invalid = sdf::PathParseError;

/// The layer in the library's terms.
fn data(layer: &Layer) -> std::result::Result<Data, Invalid> {
    let mut specs = HashMap::new();
    let root = SdfPath::abs_root();
    let mut header = SpecData::new(SpecType::PseudoRoot);
    for (key, value) in &layer.metadata {
        header.add(*key, datum(value));
    }
    if !layer.sublayers.is_empty() {
        header.add(FieldKey::SubLayers, Value::StringVec(layer.sublayers.clone()));
        header.add(FieldKey::SubLayerOffsets, Value::LayerOffsetVec(vec![<_>::default(); layer.sublayers.len()]));
    }
    // The open prims, outermost first, with the names of their children so far.
    let mut open: Vec<(SdfPath, SpecData, Vec<Token>)> = vec![(root, header, Vec::new())];
    for prim in &layer.prims {
        close(&mut open, prim.depth + 1, &mut specs);
        let Some((parent, _, names)) = open.last_mut() else { break };
        let path = parent.append_path(prim.name.as_str())?;
        names.push(prim.name.as_str().into());
        let spec = spec(prim, &path, &mut specs)?;
        open.push((path, spec, Vec::new()));
    }
    close(&mut open, 0, &mut specs);
    Ok(Data::from_specs(specs))
}

fn close(open: &mut Vec<(SdfPath, SpecData, Vec<Token>)>, depth: usize, specs: &mut HashMap<SdfPath, SpecData>) {
    while open.len() > depth {
        let Some((path, mut spec, names)) = open.pop() else { return };
        if !names.is_empty() {
            spec.add(ChildrenKey::PrimChildren, Value::TokenVec(names));
        }
        specs.insert(path, spec);
    }
}

fn spec(prim: &Prim, path: &SdfPath, specs: &mut HashMap<SdfPath, SpecData>) -> std::result::Result<SpecData, Invalid> {
    let mut spec = SpecData::new(SpecType::Prim);
    let specifier = match prim.specifier {
        Specifier::Def => sdf::Specifier::Def,
        Specifier::Over => sdf::Specifier::Over,
        Specifier::Class => sdf::Specifier::Class,
    };
    spec.add(FieldKey::Specifier, Value::Specifier(specifier));
    if !prim.type_name.is_empty() {
        spec.add(FieldKey::TypeName, Value::Token(prim.type_name.into()));
    }
    if !prim.schemas.is_empty() {
        let names: Vec<Token> = prim.schemas.iter().map(|name| name.as_str().into()).collect();
        spec.add(FieldKey::ApiSchemas, Value::TokenListOp(sdf::ListOp::prepended(names)));
    }
    if let Some(name) = &prim.display_name {
        spec.add(FieldKey::DisplayName, Value::String(name.clone()));
    }
    if let Some(instanceable) = prim.instanceable {
        spec.add(FieldKey::Instanceable, Value::Bool(instanceable));
    }
    if let Some(kind) = prim.kind {
        spec.add(FieldKey::Kind, Value::Token(kind.into()));
    }
    if let Some(target) = &prim.reference {
        let reference = sdf::Reference { prim_path: SdfPath::new(target)?, ..Default::default() };
        spec.add(FieldKey::References, Value::ReferenceListOp(sdf::ListOp::prepended(vec![reference])));
    }
    if !prim.marks.is_empty() {
        let marks: sdf::Dictionary = prim.marks.iter().map(|(key, value)| ((*key).to_owned(), datum(value))).collect();
        let data = HashMap::from([("eyebox".to_owned(), Value::Dictionary(marks))]);
        spec.add(FieldKey::CustomData, Value::Dictionary(data));
    }
    let mut names: Vec<Token> = Vec::with_capacity(prim.properties.len());
    for property in &prim.properties {
        names.push(property.name.as_str().into());
        specs.insert(path.append_property(property.name.as_str())?, property_spec(property)?);
    }
    if !names.is_empty() {
        spec.add(ChildrenKey::PropertyChildren, Value::TokenVec(names));
    }
    Ok(spec)
}

fn property_spec(property: &Property) -> std::result::Result<SpecData, Invalid> {
    let variability =
        |uniform: bool| Value::Variability(if uniform { sdf::Variability::Uniform } else { sdf::Variability::Varying });
    let paths = |targets: &[String]| -> std::result::Result<Value, Invalid> {
        let paths = targets.iter().map(|target| SdfPath::new(target)).collect::<std::result::Result<Vec<_>, _>>()?;
        Ok(Value::PathListOp(sdf::ListOp::explicit(paths)))
    };
    Ok(match &property.body {
        Body::Attribute { type_name, uniform, value, samples, interpolation, each } => {
            let mut spec = SpecData::new(SpecType::Attribute);
            spec.add(FieldKey::TypeName, Value::Token((*type_name).into()));
            spec.add(FieldKey::Variability, variability(*uniform));
            if property.custom {
                spec.add(FieldKey::Custom, Value::Bool(true));
            }
            if let Some(value) = value {
                spec.add(FieldKey::Default, datum(value));
            }
            if !samples.is_empty() {
                let samples = samples.iter().map(|(code, value)| (*code, datum(value))).collect();
                spec.add(FieldKey::TimeSamples, Value::TimeSamples(samples));
            }
            if let Some(each) = each.and_then(|each| i32::try_from(each).ok()) {
                spec.add("elementSize", Value::Int(each));
            }
            if let Some(interpolation) = interpolation {
                spec.add("interpolation", Value::Token((*interpolation).into()));
            }
            if let Some(space) = property.color_space {
                spec.add("colorSpace", Value::Token(space.into()));
            }
            spec
        }
        Body::Connected { type_name, source } => {
            let mut spec = SpecData::new(SpecType::Attribute);
            spec.add(FieldKey::TypeName, Value::Token((*type_name).into()));
            spec.add(FieldKey::Variability, variability(false));
            spec.add(FieldKey::ConnectionPaths, paths(std::slice::from_ref(source))?);
            spec
        }
        Body::Relationship { targets } => {
            let mut spec = SpecData::new(SpecType::Relationship);
            spec.add(FieldKey::Variability, variability(true));
            spec.add(FieldKey::TargetPaths, paths(targets)?);
            spec
        }
    })
}

fn datum(value: &Datum) -> Value {
    match value {
        Datum::Bool(x) => Value::Bool(*x),
        Datum::Int(x) => Value::Int(*x),
        Datum::Ints(list) => Value::IntVec(list.clone()),
        Datum::Float(x) => Value::Float(*x),
        Datum::Floats(list) => Value::FloatVec(list.clone()),
        Datum::Double(x) => Value::Double(*x),
        Datum::Doubles(list) => Value::DoubleVec(list.clone()),
        Datum::Text(text) => Value::String(text.clone()),
        Datum::Texts(list) => Value::StringVec(list.clone()),
        Datum::Token(text) => Value::Token(text.as_str().into()),
        Datum::Tokens(list) => Value::TokenVec(list.iter().map(|text| text.as_str().into()).collect()),
        Datum::Asset(path) => Value::AssetPath(path.as_str().into()),
        Datum::Assets(list) => Value::AssetPathVec(list.iter().map(|path| path.as_str().into()).collect()),
        Datum::Int2([x, y]) => Value::Vec2i(gf::Vec2i { x: *x, y: *y }),
        Datum::Float2(p) => Value::Vec2f((*p).into()),
        Datum::Float2s(list) => Value::Vec2fVec(list.iter().map(|p| (*p).into()).collect()),
        Datum::Float3(p) => Value::Vec3f((*p).into()),
        Datum::Float4(p) => Value::Vec4f((*p).into()),
        Datum::Float3s(list) => Value::Vec3fVec(list.iter().map(|p| (*p).into()).collect()),
        Datum::Double2(p) => Value::Vec2d((*p).into()),
        Datum::Double2s(list) => Value::Vec2dVec(list.iter().map(|p| (*p).into()).collect()),
        Datum::Double3(p) => Value::Vec3d((*p).into()),
        Datum::Double3s(list) => Value::Vec3dVec(list.iter().map(|p| (*p).into()).collect()),
        Datum::Half3s(list) => Value::Vec3hVec(list.iter().map(|p| p.map(openusd::gf::f16::from_f32).into()).collect()),
        Datum::Quat([w, x, y, z]) => Value::Quatd(gf::quatd(*w, *x, *y, *z)),
        Datum::Quats(list) => Value::QuatfVec(list.iter().map(|[w, x, y, z]| gf::quatf(*w, *x, *y, *z)).collect()),
        Datum::Matrix(rows) => Value::Matrix4d((*rows).into()),
        Datum::Matrices(list) => Value::Matrix4dVec(list.iter().map(|rows| (*rows).into()).collect()),
        Datum::Blocked(_) => Value::ValueBlock,
    }
}
