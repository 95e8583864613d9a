//! Implicit shapes (UsdGeomSphere, …): a mesh fine enough to show them and, where the vocabulary has it, the exact
//! surface.

use super::attribute::PrimView;
use super::handed::Above;
use super::mesh::{AllOver, Made};
use super::reader::Reader;
use super::{binding, mesh, tessellate};
use crate::assembly::{ImplicitShape, MeshSource};
use crate::frames::uniform_scale;
use crate::value::{Data, Value};
use eyebox_base::Where;
use eyebox_base::error::Result;
use eyebox_scene::Mesh;
use glam::DVec3;
use std::collections::HashMap;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Sphere,
    Cube,
    Cylinder,
    Cylinder1,
    Cone,
    Capsule,
    Capsule1,
    Plane,
}

impl Kind {
    /// By the type of the prim.
    pub fn of(type_name: &str) -> Option<Self> {
        Some(match type_name {
            "Sphere" => Kind::Sphere,
            "Cube" => Kind::Cube,
            "Cylinder" => Kind::Cylinder,
            "Cylinder_1" => Kind::Cylinder1,
            "Cone" => Kind::Cone,
            "Capsule" => Kind::Capsule,
            "Capsule_1" => Kind::Capsule1,
            "Plane" => Kind::Plane,
            _ => return None,
        })
    }

    fn type_name(self) -> &'static str {
        match self {
            Kind::Sphere => "Sphere",
            Kind::Cube => "Cube",
            Kind::Cylinder => "Cylinder",
            Kind::Cylinder1 => "Cylinder_1",
            Kind::Cone => "Cone",
            Kind::Capsule => "Capsule",
            Kind::Capsule1 => "Capsule_1",
            Kind::Plane => "Plane",
        }
    }
}

/// The axis of a shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Axis {
    X,
    Y,
    Z,
}

impl Axis {
    /// Turns a shape about z into one about this axis.
    pub fn turn(self, v: DVec3) -> DVec3 {
        match self {
            Axis::X => DVec3::new(v.z, v.x, v.y),
            Axis::Y => DVec3::new(v.y, v.z, v.x),
            Axis::Z => v,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Axis::X => "X",
            Axis::Y => "Y",
            Axis::Z => "Z",
        }
    }
}

/// The mesh of an implicit shape, an index of `Assembly::meshes`.
pub(super) fn of(reader: &mut Reader, view: &PrimView, kind: Kind, below: &Above) -> Result<Option<usize>> {
    mesh::shared(reader, view, below, |reader, view, below| {
        let material = binding::bound(reader, view, &below.handed.material);
        let carried = mesh::all_over(reader, view, below, material)?;
        let look = look(view, kind, (material, &carried))?;
        if let Some(known) = reader.meshes.shapes.get(&look) {
            return Ok(Made::Known(*known));
        }
        let Shape { mut mesh, exact, implicit } = shape(reader, view, kind)?;
        let [first, second] = carried.uvs.map(|uvs| 8 * usize::from(uvs.is_some()));
        let each = 24 + first + second + 16 * usize::from(carried.color.is_some());
        let bytes = 12 * mesh.triangles.len() + each * mesh.positions.len();
        // A line of text honestly means thousands of triangles.
        reader.ledger.allow_fine(bytes);
        reader.charge(view.path(), 1, bytes)?;
        let all = mesh.positions.len();
        mesh.uvs = carried.uvs[0].map_or_else(Vec::new, |uv| vec![uv; all]);
        mesh.second_uvs = carried.uvs[1].map_or_else(Vec::new, |uv| vec![uv; all]);
        mesh.colors = carried.color.map_or_else(Vec::new, |color| vec![color; all]);
        let materials = vec![material; mesh.faces.len()];
        let mut attributes = vec![None; mesh.faces.len()];
        for (face, shape) in exact {
            if let Some(slot) = attributes.get_mut(face) {
                *slot = Some(shape);
            }
        }
        let (mesh, implicit) = (mesh.into(), Some(implicit));
        let source = MeshSource { mesh, materials, attributes, rig: None, implicit, at: view.at() };
        let index = mesh::keep(reader, source);
        reader.meshes.shapes.insert(look, index);
        Ok(Made::Known(index))
    })
}

/// All that the mesh of a shape depends on. Shapes that are alike share one whatever they are called: the nodes have the names.
fn look(view: &PrimView, kind: Kind, (material, carried): (Option<usize>, &AllOver)) -> Result<String> {
    let mut out = format!("{kind:?} {:?} {material:?} {carried:?}", view.token("axis")?);
    for name in ["radius", "size", "width", "length", "height", "radiusBottom", "radiusTop"] {
        let bits = view.number(name)?.map(f64::to_bits);
        out += &format!(" {bits:?}");
    }
    Ok(out)
}

/// What becomes of a shape.
struct Shape {
    mesh: Mesh,
    /// The exact surfaces of some faces.
    exact: Vec<(usize, Value)>,
    implicit: ImplicitShape,
}

fn shape(reader: &mut Reader, view: &PrimView, kind: Kind) -> Result<Shape> {
    let mut lengths = Vec::new();
    let mut length = |name: &'static str, fallback: f64| -> Result<f64> {
        let x = view.number(name)?.unwrap_or(fallback);
        if x.is_finite() && x > 0.0 && x <= f64::from(f32::MAX) {
            lengths.push((name, x));
            return Ok(x);
        }
        Err(view.fault_in(name, format!("the value {x}")).expected("a finite number > 0"))
    };
    let name = view.name();
    let mut exact = Vec::new();
    let mut turned = None;
    let mut about = || -> Result<Axis> {
        let own = axis(view)?;
        turned = Some(own.name());
        Ok(own)
    };
    let mesh = match kind {
        Kind::Sphere => {
            let radius = length("radius", 1.0)?;
            exact.push((0, sphere(DVec3::ZERO, DVec3::Z, radius, view)));
            tessellate::sphere(name, radius)
        }
        Kind::Cube => tessellate::cube(name, length("size", 2.0)?),
        Kind::Cylinder => {
            inexact(reader, view);
            let radius = length("radius", 1.0)?;
            tessellate::frustum(name, about()?, length("height", 2.0)?, radius, radius)
        }
        Kind::Cylinder1 => {
            inexact(reader, view);
            let radii = [length("radiusBottom", 1.0)?, length("radiusTop", 1.0)?];
            tessellate::frustum(name, about()?, length("height", 2.0)?, radii[0], radii[1])
        }
        Kind::Cone => {
            inexact(reader, view);
            tessellate::frustum(name, about()?, length("height", 2.0)?, length("radius", 1.0)?, 0.0)
        }
        Kind::Capsule | Kind::Capsule1 => {
            inexact(reader, view);
            let (axis, height) = (about()?, length("height", 1.0)?);
            let radius = match kind {
                Kind::Capsule1 => length("radiusBottom", 0.5)?,
                Kind::Sphere
                | Kind::Cube
                | Kind::Cylinder
                | Kind::Cylinder1
                | Kind::Cone
                | Kind::Capsule
                | Kind::Plane => length("radius", 0.5)?,
            };
            if kind == Kind::Capsule1 && length("radiusTop", 0.5)? != radius {
                reader.ledger.warn(view.at(), "a capsule with two radii: taken with the one of its bottom");
            }
            let z = axis.turn(DVec3::Z);
            exact.push((0, sphere(-0.5 * height * z, z, radius, view)));
            exact.push((2, sphere(0.5 * height * z, -z, radius, view)));
            tessellate::capsule(name, axis, height, radius)
        }
        Kind::Plane => tessellate::plane(name, about()?, length("width", 2.0)?, length("length", 2.0)?),
    };
    let implicit = ImplicitShape { kind: kind.type_name(), lengths, axis: turned };
    Ok(Shape { mesh, exact, implicit })
}

fn axis(view: &PrimView) -> Result<Axis> {
    match view.token("axis")?.as_deref() {
        None | Some("Z") => Ok(Axis::Z),
        Some("X") => Ok(Axis::X),
        Some("Y") => Ok(Axis::Y),
        Some(other) => Err(view.fault_in("axis", format!("the axis `{other}`")).expected("X, Y or Z")),
    }
}

fn inexact(reader: &mut Reader, view: &PrimView) {
    let text = "the curved side of a cylinder, cone or capsule is traced as a mesh with exact normals";
    reader.ledger.info(view.at(), text);
}

/// `shape = { kind = "sphere", … }` for a sphere about `centre`, its vertex on the side of −axis.
fn sphere(centre: DVec3, axis: DVec3, radius: f64, view: &PrimView) -> Value {
    let at = view.at();
    let value = |data: Data| Value::new(data, at.clone());
    let three = |v: DVec3| value(Data::List(v.to_array().map(|x| value(Data::Number(x))).to_vec()));
    let shape = vec![
        ("kind".to_owned(), value(Data::Text("sphere".to_owned()))),
        ("vertex".to_owned(), three(centre - radius * axis)),
        ("axis".to_owned(), three(axis)),
        ("radius".to_owned(), value(Data::Number(radius))),
    ];
    value(Data::Table(vec![("shape".to_owned(), value(Data::Table(shape)))]))
}

/// Takes the exact surface from implicit spheres that are scaled unevenly: they are ellipsoids, traced as meshes.
pub(super) fn flatten_stretched(reader: &mut Reader) {
    let mut plain: HashMap<usize, usize> = HashMap::new();
    for index in 0..reader.assembly.nodes.len() {
        let node = &reader.assembly.nodes[index];
        let Some(mesh) = node.mesh.filter(|_| uniform_scale(&node.to_world).is_none()) else { continue };
        let Some(source) = reader
            .assembly
            .meshes
            .get(mesh)
            .filter(|source| source.attributes.iter().flatten().any(|attributes| source.is_own_shape(attributes)))
        else {
            continue;
        };
        let at: Where = node.at.clone();
        let other = match plain.get(&mesh) {
            Some(&other) => other,
            None => {
                let mut source = source.clone();
                source.attributes.iter_mut().for_each(|attributes| *attributes = None);
                reader.assembly.meshes.push(source);
                plain.insert(mesh, reader.assembly.meshes.len() - 1);
                reader.assembly.meshes.len() - 1
            }
        };
        reader.assembly.nodes[index].mesh = Some(other);
        reader.ledger.warn(at, "a sphere that is scaled unevenly: traced as a mesh, not exactly");
    }
}
