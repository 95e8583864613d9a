//! A glTF mesh: one CAD face per primitive, in order.

use super::accessor::Document;
use super::at::At;
use super::deform::Deform;
use super::notes::Ledger;
use super::primitive::{self, FaceMesh, FaceName};
use super::variants;
use crate::assembly::MeshSource;
use eyebox_base::error::Result;
use eyebox_scene::{FaceRange, Mesh};

/// Reads mesh `index`, which stands at `at`, bent as `deform` says. Vertices are not merged between faces.
pub(super) fn read(
    document: &Document<'_>,
    at: &At<'_>,
    index: usize,
    deform: &Deform,
    ledger: &mut Ledger,
) -> Result<MeshSource> {
    let primitives = at.want("primitives")?.items()?;
    if primitives.is_empty() {
        return Err(at.fault("a mesh without primitives").expected("at least 1"));
    }
    let mut mesh = Mesh { name: at.name("mesh", index)?, ..Mesh::default() };
    let (mut materials, mut attributes) = (Vec::new(), Vec::new());
    for (number, at) in primitives.iter().enumerate() {
        let name = FaceName { mesh: &mesh.name, face: number };
        let face = primitive::read(document, at, name, deform, ledger)?;
        append(&mut mesh, face).ok_or_else(|| at.fault("the mesh has more than 4294967295 vertices or triangles"))?;
        materials.push(variants::material(document, at)?);
        attributes.push(at.optics(&mut ledger.budget)?);
    }
    Ok(MeshSource { mesh: mesh.into(), materials, attributes, rig: None, implicit: None, at: at.place() })
}

/// Appends a face; none if its indices do not fit into 32 bits.
pub(crate) fn append(mesh: &mut Mesh, face: FaceMesh) -> Option<()> {
    let base = u32::try_from(mesh.positions.len()).ok()?;
    u32::try_from(mesh.positions.len() + face.positions.len()).ok()?;
    let first = u32::try_from(mesh.triangles.len()).ok()?;
    let count = u32::try_from(face.triangles.len()).ok()?;
    first.checked_add(count)?;
    if mesh.positions.is_empty() && mesh.triangles.is_empty() {
        // Most meshes are one face: nothing is copied.
        (mesh.positions, mesh.normals, mesh.triangles) = (face.positions, face.normals, face.triangles);
        (mesh.uvs, mesh.second_uvs, mesh.colors) = (face.uvs, face.second_uvs, face.colors);
        mesh.tangents = face.tangents;
        mesh.faces.push(FaceRange { first, count });
        return Some(());
    }
    let counts = [mesh.positions.len(), face.positions.len()];
    joined(&mut mesh.uvs, face.uvs, [0.0; 2], counts);
    joined(&mut mesh.second_uvs, face.second_uvs, [0.0; 2], counts);
    joined(&mut mesh.tangents, face.tangents, [0.0; 4], counts);
    joined(&mut mesh.colors, face.colors, [1.0; 4], counts);
    mesh.triangles.extend(face.triangles.iter().map(|triangle| triangle.map(|vertex| base + vertex)));
    mesh.positions.extend(face.positions);
    mesh.normals.extend(face.normals);
    mesh.faces.push(FaceRange { first, count });
    Some(())
}

/// Adds what a face says of its vertices: it is said of all vertices of a mesh or of none.
fn joined<T: Copy>(all: &mut Vec<T>, own: Vec<T>, unsaid: T, [before, count]: [usize; 2]) {
    if own.is_empty() && all.is_empty() {
        return;
    }
    all.resize(before, unsaid);
    all.extend(own);
    all.resize(before + count, unsaid);
}
