//! Primvars of a mesh: values that vary over it in one of USD's ways, perhaps through indices.

use super::attribute::PrimView;
use super::notes::Ledger;
use super::polygons::Corners;
use super::value;
use eyebox_base::error::Result;
use openusd::sdf::Value;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Interpolation {
    Constant,
    /// One per polygon.
    Uniform,
    /// One per point.
    Vertex,
    /// One per point, which a subdivision surface mixes linearly. The same as `Vertex` on polygons.
    Varying,
    /// One per corner.
    FaceVarying,
}

/// Points, polygons and corners of a mesh.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sizes {
    pub points: usize,
    pub polygons: usize,
    pub corners: usize,
}

impl Interpolation {
    fn of(text: &str) -> Option<Self> {
        Some(match text {
            "constant" => Interpolation::Constant,
            "uniform" => Interpolation::Uniform,
            "vertex" => Interpolation::Vertex,
            "varying" => Interpolation::Varying,
            "faceVarying" => Interpolation::FaceVarying,
            _ => return None,
        })
    }
    pub fn count(self, sizes: Sizes) -> usize {
        match self {
            Interpolation::Constant => 1,
            Interpolation::Uniform => sizes.polygons,
            Interpolation::Vertex | Interpolation::Varying => sizes.points,
            Interpolation::FaceVarying => sizes.corners,
        }
    }
}

#[derive(Debug, Clone)]
pub(super) struct Primvar<T> {
    values: Vec<T>,
    indices: Option<Vec<i32>>,
    interpolation: Interpolation,
}

impl<T> Primvar<T> {
    pub fn new(values: Vec<T>, indices: Option<Vec<i32>>, interpolation: Interpolation) -> Self {
        Primvar { values, indices, interpolation }
    }
    pub fn interpolation(&self) -> Interpolation {
        self.interpolation
    }
}

impl<T: Copy> Primvar<T> {
    /// The same all over.
    pub fn constant(value: T) -> Self {
        Primvar { values: vec![value], indices: None, interpolation: Interpolation::Constant }
    }
    /// With other values in the same places.
    pub fn map<U>(&self, other: impl Fn(T) -> U) -> Primvar<U> {
        let values = self.values.iter().map(|value| other(*value)).collect();
        Primvar { values, indices: self.indices.clone(), interpolation: self.interpolation }
    }
    /// Whether all corners of a point have the same value by construction.
    pub fn follows_points(&self) -> bool {
        match self.interpolation {
            Interpolation::Constant | Interpolation::Vertex | Interpolation::Varying => true,
            Interpolation::Uniform | Interpolation::FaceVarying => false,
        }
    }
    pub fn at(&self, polygon: usize, corner: usize, point: usize) -> Option<T> {
        let place = match self.interpolation {
            Interpolation::Constant => 0,
            Interpolation::Uniform => polygon,
            Interpolation::Vertex | Interpolation::Varying => point,
            Interpolation::FaceVarying => corner,
        };
        let place = match &self.indices {
            Some(indices) => usize::try_from(*indices.get(place)?).ok()?,
            None => place,
        };
        self.values.get(place).copied()
    }
    /// The values as `moved` makes them, who is told which point has each: one per point where they are that, else one per
    /// corner.
    pub fn with_points(&self, corners: &Corners, points: usize, moved: impl Fn(T, usize) -> T) -> Primvar<T>
    where
        T: Default,
    {
        let values: Vec<T> = match self.interpolation {
            Interpolation::Vertex | Interpolation::Varying => {
                (0..points).map(|point| moved(self.at(0, 0, point).unwrap_or_default(), point)).collect()
            }
            Interpolation::Constant | Interpolation::Uniform | Interpolation::FaceVarying => {
                let of = |polygon: usize, corner: usize| {
                    let point = corners.points().get(corner).map_or(0, |point| *point as usize);
                    moved(self.at(polygon, corner, point).unwrap_or_default(), point)
                };
                let polygons = 0..corners.polygons();
                polygons
                    .flat_map(|polygon| corners.span(polygon).map(move |corner| (polygon, corner)))
                    .map(|(polygon, corner)| of(polygon, corner))
                    .collect()
            }
        };
        let interpolation = match self.interpolation {
            Interpolation::Vertex | Interpolation::Varying => Interpolation::Vertex,
            Interpolation::Constant | Interpolation::Uniform | Interpolation::FaceVarying => Interpolation::FaceVarying,
        };
        Primvar { values, indices: None, interpolation }
    }
    /// The values of `count` points, moved if they are just that in the file. For those that follow points.
    pub fn into_points(self, count: usize) -> Vec<T>
    where
        T: Default,
    {
        if matches!(self.interpolation, Interpolation::Vertex | Interpolation::Varying)
            && self.indices.is_none()
            && self.values.len() == count
        {
            return self.values;
        }
        (0..count).map(|point| self.at(0, 0, point).unwrap_or_default()).collect()
    }
}

/// A primvar, or none with a note if its count does not fit its interpolation.
fn read<T>(
    view: &PrimView,
    name: &str,
    sizes: Sizes,
    fallback: Interpolation,
    ledger: &mut Ledger,
    convert: impl FnOnce(Value) -> Option<Vec<T>>,
) -> Result<Option<Primvar<T>>> {
    let Some(found) = view.get(name)? else { return Ok(None) };
    let Some(values) = convert(found) else {
        ledger.warn(view.at_property(name), "a value of another type than the name says: not used");
        return Ok(None);
    };
    let interpolation = match view.property_text(name, "interpolation")? {
        None => fallback,
        Some(text) => match Interpolation::of(&text) {
            Some(known) => known,
            None => {
                let fault = view.fault_in(name, format!("the interpolation `{text}`"));
                return Err(fault.expected("constant, uniform, vertex, varying or faceVarying"));
            }
        },
    };
    let indices = view.read(&format!("{name}:indices"), "int[]", value::ints)?;
    let count = indices.as_ref().map_or(values.len(), Vec::len);
    let wanted = interpolation.count(sizes);
    // A constant may come as a longer array; USD takes the first.
    let fits = if interpolation == Interpolation::Constant { count >= 1 } else { count == wanted };
    if !fits {
        let text = format!("{count} values where its interpolation needs {wanted}: not used");
        ledger.warn(view.at_property(name), text);
        return Ok(None);
    }
    let in_range = |&index: &i32| usize::try_from(index).is_ok_and(|index| index < values.len());
    if indices.as_ref().is_some_and(|indices| !indices.iter().all(in_range)) {
        ledger.warn(view.at_property(name), "indices out of range: not used");
        return Ok(None);
    }
    Ok(Some(Primvar { values, indices, interpolation }))
}

/// `primvars:normals`, else `normals` (UsdGeomMesh: the primvar wins).
pub(super) fn normals(view: &PrimView, sizes: Sizes, ledger: &mut Ledger) -> Result<Option<Primvar<[f32; 3]>>> {
    for (name, fallback) in [("primvars:normals", Interpolation::Constant), ("normals", Interpolation::Vertex)] {
        let found = read(view, name, sizes, fallback, ledger, value::triples)?;
        if found.is_some() {
            return Ok(found);
        }
    }
    Ok(None)
}

/// The names that exporters give the first set of texture coordinates.
const FIRST: [&str; 6] = ["st", "uv", "UVMap", "st0", "map1", "st_0"];

/// Texture coordinates by their number: those with one of the usual names, else the primvars of type texCoord2f in order.
pub(super) fn uvs(
    view: &PrimView,
    number: usize,
    sizes: Sizes,
    ledger: &mut Ledger,
) -> Result<Option<Primvar<[f32; 2]>>> {
    let usual: Vec<String> = match number {
        0 => FIRST.iter().map(|name| format!("primvars:{name}")).collect(),
        _ => ["st", "uv", "st_", "map"].iter().map(|name| format!("primvars:{name}{number}")).collect(),
    };
    let mut names: Vec<&str> = usual.iter().map(String::as_str).filter(|name| view.has(name)).collect();
    if names.is_empty() {
        let mut typed = Vec::new();
        for name in view.property_names().iter().filter(|name| name.starts_with("primvars:")) {
            let type_name = view.property_text(name, "typeName")?.unwrap_or_default();
            if type_name.starts_with("texCoord2") {
                typed.push(name.as_str());
            }
        }
        names.extend(typed.get(number));
    }
    for name in names {
        let found = read(view, name, sizes, Interpolation::Constant, ledger, value::pairs)?;
        if found.is_some() {
            return Ok(found);
        }
    }
    Ok(None)
}

/// `primvars:NAME` as texture coordinates.
pub(super) fn pairs(
    view: &PrimView,
    name: &str,
    sizes: Sizes,
    ledger: &mut Ledger,
) -> Result<Option<Primvar<[f32; 2]>>> {
    let single = |found: Value| match value::pair(&found) {
        Some(pair) => Some(vec![pair.map(|x| x as f32)]),
        None => value::pairs(found),
    };
    read(view, &format!("primvars:{name}"), sizes, Interpolation::Constant, ledger, single)
}

/// `primvars:NAME` as colours.
pub(super) fn colors(
    view: &PrimView,
    name: &str,
    sizes: Sizes,
    ledger: &mut Ledger,
) -> Result<Option<Primvar<[f32; 3]>>> {
    let single = |found: Value| match value::triple(&found) {
        Some(color) => Some(vec![color.map(|x| x as f32)]),
        None => value::triples(found),
    };
    read(view, &format!("primvars:{name}"), sizes, Interpolation::Constant, ledger, single)
}

/// `primvars:NAME` as numbers.
pub(super) fn numbers(view: &PrimView, name: &str, sizes: Sizes, ledger: &mut Ledger) -> Result<Option<Primvar<f32>>> {
    let single = |found: Value| match value::number(&found) {
        Some(x) => Some(vec![x as f32]),
        None => value::numbers(found),
    };
    read(view, &format!("primvars:{name}"), sizes, Interpolation::Constant, ledger, single)
}
