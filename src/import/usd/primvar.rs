//! Primvars of a mesh: values that vary over it in one of USD's ways, perhaps through indices.

use super::attribute::PrimView;
use super::notes::Ledger;
use super::value;
use crate::base::fault::Result;
use openusd::sdf::Value;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Interpolation {
    Constant,
    /// One per polygon.
    Uniform,
    /// One per point; `varying` is the same on polygons.
    Vertex,
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
            "vertex" | "varying" => Interpolation::Vertex,
            "faceVarying" => Interpolation::FaceVarying,
            _ => return None,
        })
    }
    pub fn count(self, sizes: Sizes) -> usize {
        match self {
            Interpolation::Constant => 1,
            Interpolation::Uniform => sizes.polygons,
            Interpolation::Vertex => sizes.points,
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

#[cfg(test)]
impl<T> Primvar<T> {
    pub fn new(values: Vec<T>, indices: Option<Vec<i32>>, interpolation: Interpolation) -> Self {
        Primvar { values, indices, interpolation }
    }
}

impl<T: Copy> Primvar<T> {
    /// Whether all corners of a point have the same value by construction.
    pub fn follows_points(&self) -> bool {
        matches!(self.interpolation, Interpolation::Constant | Interpolation::Vertex)
    }
    pub fn at(&self, polygon: usize, corner: usize, point: usize) -> Option<T> {
        let place = match self.interpolation {
            Interpolation::Constant => 0,
            Interpolation::Uniform => polygon,
            Interpolation::Vertex => point,
            Interpolation::FaceVarying => corner,
        };
        let place = match &self.indices {
            Some(indices) => usize::try_from(*indices.get(place)?).ok()?,
            None => place,
        };
        self.values.get(place).copied()
    }
    /// The values of `count` points, moved if they are just that in the file. For those that follow points.
    pub fn into_points(self, count: usize) -> Vec<T>
    where
        T: Default,
    {
        if self.interpolation == Interpolation::Vertex && self.indices.is_none() && self.values.len() == count {
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

/// Texture coordinates: `st`, else the first primvar of type texCoord2f or with one of the usual names.
pub(super) fn uvs(view: &PrimView, sizes: Sizes, ledger: &mut Ledger) -> Result<Option<Primvar<[f32; 2]>>> {
    const USUAL: [&str; 4] = ["primvars:st", "primvars:uv", "primvars:UVMap", "primvars:st0"];
    let mut names: Vec<&str> = USUAL.into_iter().filter(|name| view.has(name)).collect();
    if names.is_empty() {
        for name in view.property_names().iter().filter(|name| name.starts_with("primvars:")) {
            if name.ends_with(":indices") {
                continue;
            }
            let type_name = view.property_text(name, "typeName")?.unwrap_or_default();
            if type_name.starts_with("texCoord2") {
                names.push(name);
                break;
            }
        }
    }
    for name in names {
        let found = read(view, name, sizes, Interpolation::Constant, ledger, value::pairs)?;
        if found.is_some() {
            return Ok(found);
        }
    }
    Ok(None)
}
