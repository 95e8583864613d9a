//! One mesh primitive, which is one CAD face: its corners, and the vertices they use.

use super::accessor::{Accessor, Component, Document};
use super::at::At;
use super::corners::{self, Shape, compact};
use super::deform::{self, Deform, Target};
use super::normals;
use super::notes::Ledger;
use crate::normals::repair;
use eyebox_base::Code;
use eyebox_base::error::Result;
use eyebox_scene::{Note, Severity};
use glam::DVec3;

/// The geometry of one face, indices from 0.
#[derive(Debug, Default)]
pub(crate) struct FaceMesh {
    pub positions: Vec<[f32; 3]>,
    pub normals: Vec<[f32; 3]>,
    /// One per position, or none.
    pub uvs: Vec<[f32; 2]>,
    /// A second set, one per position, or none.
    pub second_uvs: Vec<[f32; 2]>,
    /// As [`Mesh::tangents`](eyebox_scene::Mesh::tangents).
    pub tangents: Vec<[f32; 4]>,
    /// Linear Rec.709 and alpha, one per position, or none.
    pub colors: Vec<[f32; 4]>,
    pub triangles: Vec<[u32; 3]>,
    /// The vertex of the file (USD: the point) that each is, where somebody asks.
    pub sources: Vec<u32>,
}

/// Mesh and number of a face, for people.
#[derive(Debug, Clone, Copy)]
pub(super) struct FaceName<'a> {
    pub mesh: &'a str,
    pub face: usize,
}

/// Bytes of a vertex with normal, two sets of texture coordinates, a tangent and a colour, and of a triangle.
const VERTEX: usize = 72;
pub(super) const TRIANGLE: usize = 12;

/// Reads the primitive at `at`. Without a surface (points, lines, no positions) the face is empty, with a note, so that
/// the numbers of the other faces stay. Vertices that no triangle uses are left out; the others keep their order.
pub(super) fn read(
    document: &Document<'_>,
    at: &At<'_>,
    name: FaceName<'_>,
    deform: &Deform,
    ledger: &mut Ledger,
) -> Result<FaceMesh> {
    let attributes = at.want("attributes")?;
    let mode = at.count_or("mode", 4)?;
    let shape = match mode {
        0..=3 => {
            ledger.notes.warn(at, "points and lines have no surface: the face is empty");
            return Ok(FaceMesh::default());
        }
        4 => Shape::List,
        5 => Shape::Strip,
        6 => Shape::Fan,
        other => return Err(at.want("mode")?.fault(format!("primitive mode {other}")).expected("0 to 6")),
    };
    let Some(reference) = attributes.get("POSITION")? else {
        ledger.notes.warn(at, "a primitive without positions: the face is empty");
        return Ok(FaceMesh::default());
    };
    let positions = open(document, &reference, &[3], ledger)?;
    if !positions.is_backed() {
        // Zeros, as the specification says; usually a buffer that was lost.
        ledger.notes.warn(&positions.at, "positions without data in the asset: all of them are 0, 0, 0");
    }
    check_type(document, &positions, &[Component::I8, Component::U8, Component::I16, Component::U16], ledger)?;

    let corners = corners::read(document, at, shape, positions.count, ledger)?;
    let (used, triangles) = compact(corners, positions.count);
    ledger.budget.charge(at, used.len(), VERTEX)?;
    let mut face = FaceMesh { triangles, ..FaceMesh::default() };
    face.positions = positions.gather(&used);
    let broken = face.positions.iter().position(|position| !position.iter().all(|x| x.is_finite()));
    if let Some((vertex, [x, y, z])) = broken.and_then(|i| Some((used.get(i)?, face.positions.get(i)?))) {
        return Err(positions
            .at
            .fault(format!("vertex {vertex} is at ({x}, {y}, {z})"))
            .expected("finite positions")
            .code(Code::DataNotFinite));
    }
    face.uvs = coordinates(document, &attributes, "TEXCOORD_0", (&positions, &used), ledger)?;
    face.second_uvs = coordinates(document, &attributes, "TEXCOORD_1", (&positions, &used), ledger)?;
    face.colors = colors(document, &attributes, (&positions, &used), ledger)?;
    let stored = match attributes.get("NORMAL")? {
        Some(reference) => {
            let stored = open(document, &reference, &[3], ledger)?;
            same_count(&reference, &stored, &positions)?;
            check_type(document, &stored, &[Component::I8, Component::I16], ledger)?;
            face.normals = stored.gather(&used);
            face.tangents = tangents(document, &attributes, (&positions, &used), ledger)?;
            Some(stored)
        }
        None => None,
    };
    let target = Target { document, at, positions: &positions, used: &used };
    deform::apply(&target, deform, &mut face, ledger)?;
    if deform.is_traced {
        face.sources = used;
    } else {
        drop(used);
    }
    match stored {
        Some(stored) => {
            let read = std::mem::take(&mut face.normals);
            face.normals = normals::settled(read, &face.positions, &face.triangles, &stored, &mut ledger.notes);
            mend(&mut face, at, name, ledger)?;
        }
        None => {
            ledger.budget.charge(at, face.triangles.len(), 3 * VERTEX)?;
            ledger.notes.info(at, "no normals: the face is flat-shaded, as glTF says");
            face = normals::flat(face, at, &mut ledger.notes);
        }
    }
    Ok(face)
}

/// A set of texture coordinates, one per used vertex; none if there is none.
fn coordinates(
    document: &Document<'_>,
    attributes: &At<'_>,
    key: &str,
    (positions, used): (&Accessor<'_>, &[u32]),
    ledger: &mut Ledger,
) -> Result<Vec<[f32; 2]>> {
    let Some(reference) = attributes.get(key)? else { return Ok(Vec::new()) };
    let accessor = open(document, &reference, &[2], ledger)?;
    same_count(&reference, &accessor, positions)?;
    check_type(document, &accessor, &[Component::I8, Component::I16], ledger)?;
    let mut uvs: Vec<[f32; 2]> = accessor.gather(used);
    for uv in uvs.iter_mut().filter(|uv| !uv.iter().all(|x| x.is_finite())) {
        ledger.notes.warn_of(Code::DataNotFinite, &accessor.at, "texture coordinates that are not finite: set to 0");
        *uv = [0.0; 2];
    }
    Ok(uvs)
}

/// Tangents of the vertices at unit length, 0 where they have no direction; none if there are none.
fn tangents(
    document: &Document<'_>,
    attributes: &At<'_>,
    (positions, used): (&Accessor<'_>, &[u32]),
    ledger: &mut Ledger,
) -> Result<Vec<[f32; 4]>> {
    let Some(reference) = attributes.get("TANGENT")? else { return Ok(Vec::new()) };
    let accessor = open(document, &reference, &[4], ledger)?;
    same_count(&reference, &accessor, positions)?;
    check_type(document, &accessor, &[Component::I8, Component::I16], ledger)?;
    let mut tangents: Vec<[f32; 4]> = accessor.gather(used);
    let mut lost = 0usize;
    for tangent in &mut tangents {
        let [x, y, z, side] = tangent.map(f64::from);
        match normals::unit(DVec3::new(x, y, z)).filter(|_| side.is_finite()) {
            Some([x, y, z]) => *tangent = [x, y, z, if side < 0.0 { -1.0 } else { 1.0 }],
            None => {
                lost += 1;
                *tangent = [0.0; 4];
            }
        }
    }
    // Files of some exporters have all of them 0: texture coordinates say as much.
    if lost > 0 {
        let text = "a tangent that is zero or not finite: computed from the texture coordinates";
        ledger.notes.add_many(Severity::Info, accessor.at.place(), text, lost);
    }
    Ok(tangents)
}

/// Colours of the vertices, linear Rec.709 with alpha (1 where there is none); none if there are none.
fn colors(
    document: &Document<'_>,
    attributes: &At<'_>,
    (positions, used): (&Accessor<'_>, &[u32]),
    ledger: &mut Ledger,
) -> Result<Vec<[f32; 4]>> {
    let Some(reference) = attributes.get("COLOR_0")? else { return Ok(Vec::new()) };
    let accessor = open(document, &reference, &[3, 4], ledger)?;
    same_count(&reference, &accessor, positions)?;
    check_type(document, &accessor, &[], ledger)?;
    let mut colors: Vec<[f32; 4]> = if accessor.lanes == 4 {
        accessor.gather(used)
    } else {
        accessor.gather::<3>(used).into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect()
    };
    for color in colors.iter_mut().filter(|color| !color.iter().all(|x| (0.0..=1.0).contains(x))) {
        ledger.notes.warn_of(Code::DataNotFinite, &accessor.at, "colours of vertices outside 0 to 1: brought there");
        *color = color.map(|x| if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) });
    }
    Ok(colors)
}

/// Mends normals that contradict their triangles, and says so.
fn mend(face: &mut FaceMesh, at: &At<'_>, name: FaceName<'_>, ledger: &mut Ledger) -> Result<()> {
    if normals::are_sound(&face.positions, &face.normals, &face.triangles) {
        return Ok(());
    }
    let found = repair(&face.positions, &mut face.normals, &face.triangles);
    if found.flipped + found.replaced > 0 {
        let (flipped, replaced, worst) = (found.flipped, found.replaced, found.worst_deg);
        let FaceName { mesh, face } = name;
        ledger.budget.charge(at, 2, mesh.len())?;
        let text = format!(
            "{mesh} face {face}: normals contradict their triangles by up to {worst:.0}°: {flipped} turned round, {replaced} replaced"
        );
        ledger.notes.add(Note::warning(at.place(), text).code(Code::NormalsContradict).face(face), 1);
    }
    if found.inverted {
        let text = "the normals of a face point into the side that its winding calls the inside: kept as they are";
        ledger.notes.warn_of(Code::NormalsInsideOut, at, text);
    }
    Ok(())
}

/// Opens an attribute's accessor, which must have one of these numbers of components per element.
pub(super) fn open<'d>(
    document: &'d Document<'_>,
    reference: &At<'_>,
    lanes: &[usize],
    ledger: &mut Ledger,
) -> Result<Accessor<'d>> {
    let accessor = document.accessor(reference)?;
    ledger.budget.charge(reference, accessor.opening_cost(), 8)?;
    if !lanes.contains(&accessor.lanes) {
        let what = format!("the accessor has {} components per element", accessor.lanes);
        let wanted: Vec<String> = lanes.iter().map(usize::to_string).collect();
        let expected = format!("{} (for {})", wanted.join(" or "), reference.pointer);
        return Err(accessor.at.want("type")?.fault(what).expected(expected));
    }
    Ok(accessor)
}

/// Floats always do; `quantized` types with `KHR_mesh_quantization` (if it is not declared, we read them and say so).
/// Texture coordinates may be normalised unsigned integers without it.
pub(super) fn check_type(
    document: &Document<'_>,
    accessor: &Accessor<'_>,
    quantized: &[Component],
    ledger: &mut Ledger,
) -> Result<()> {
    // Texture coordinates and colours.
    let picture = accessor.lanes != 3 || quantized.is_empty();
    let picture = picture && matches!(accessor.component, Component::U8 | Component::U16);
    if accessor.component == Component::F32 || picture && accessor.normalized {
        return Ok(());
    }
    if !quantized.contains(&accessor.component) && !picture {
        let fault = accessor.at.want("componentType")?.fault("this attribute cannot have this component type");
        return Err(fault.expected("5126 (float), or the types of KHR_mesh_quantization"));
    }
    let declared = document.root.list("extensionsUsed")?;
    if !declared.iter().any(|name| name.json == "KHR_mesh_quantization") {
        ledger.notes.warn(&accessor.at, "quantized attributes without KHR_mesh_quantization in extensionsUsed");
    }
    Ok(())
}

pub(super) fn same_count(reference: &At<'_>, accessor: &Accessor<'_>, positions: &Accessor<'_>) -> Result<()> {
    if accessor.count == positions.count {
        return Ok(());
    }
    let what = format!("{} elements for {} positions", accessor.count, positions.count);
    Err(reference.fault(what).expected("one element per position"))
}
