//! UsdGeomMesh into a mesh with CAD faces.

mod cut; // polygons → faces → triangles
mod known; // which meshes are one and the same
mod polygons; // points and topology as the file has them
mod vertices; // points → vertices

#[cfg(test)]
mod tests;

use super::attribute::PrimView;
use super::hierarchy::Above;
use super::reader::Reader;
use super::{binding, faces, optics, primvar};
use crate::base::Code;
use crate::base::fault::Result;
use crate::import::assembly::MeshSource;
use crate::import::gltf::mesh::append;
use crate::import::gltf::normals::{Settled, are_sound, flat_shaded, settle};
use crate::import::gltf::primitive::FaceMesh;
use crate::import::normals::repair;
use crate::scene::{Mesh, Note, Severity};
use cut::Own;
use vertices::{Data, Scratch};

pub(super) use known::{Known, Made, keep, shared};

/// Bytes of a vertex with normal and texture coordinates, and of a triangle.
const VERTEX: usize = 32;
const TRIANGLE: usize = 12;

/// The mesh of a prim, an index of `Assembly::meshes`; none if it has no surface.
pub(super) fn of(reader: &mut Reader, view: &PrimView, below: &Above) -> Result<Option<usize>> {
    shared(reader, view, below, |reader, view, below| {
        Ok(build(reader, view, below)?.map_or(Made::Nothing, |source| Made::New(Box::new(source))))
    })
}

fn build(reader: &mut Reader, view: &PrimView, below: &Above) -> Result<Option<MeshSource>> {
    let Some(polygons) = polygons::read(reader, view)? else { return Ok(None) };
    let sizes = polygons.sizes();
    let normals = primvar::normals(view, sizes, &mut reader.ledger)?;
    let uvs = primvar::uvs(view, sizes, &mut reader.ledger)?;
    subdivision(reader, view, normals.is_some())?;
    let partition = faces::partition(reader, view, sizes.polygons)?;
    let whole = binding::bound(reader, view, &below.handed.material);
    let (mut materials, mut attributes) = (Vec::new(), Vec::new());
    let mut bindings = Vec::new();
    for binding in &partition.bindings {
        bindings.push(binding::bound_to_subset(reader, view, binding, &below.handed.material)?);
    }
    let mut cad = Vec::new();
    for subset in &partition.subsets {
        cad.push((
            binding::bound_to_subset(reader, view, subset, &below.handed.material)?,
            optics::face(reader, subset)?,
        ));
    }
    for face in &partition.faces {
        let (own, said) = face.cad.and_then(|index| cad.get(index).cloned()).unwrap_or_default();
        let bound = face.binding.and_then(|index| bindings.get(index).copied().flatten());
        materials.push(bound.or(own).or(whole));
        attributes.push(said);
    }
    let mut mesh = Mesh { name: view.name().to_owned(), ..Mesh::default() };
    let own = cut::grouped(&partition, &polygons);
    let (alone, mut scratch) = (own.len() == 1, Scratch::default());
    let mut data = Data { polygons, normals, uvs };
    for (number, own) in own.iter().enumerate() {
        let face = face(reader, view, &mut data, own, Place { number, alone }, &mut scratch)?;
        append(&mut mesh, face).ok_or_else(|| view.fault("the mesh has more than 4294967295 vertices or triangles"))?;
    }
    Ok(Some(MeshSource { mesh: mesh.into(), materials, attributes, at: view.at() }))
}

/// Says what becomes of a subdivision surface: we take the polygons of its cage.
fn subdivision(reader: &mut Reader, view: &PrimView, has_normals: bool) -> Result<()> {
    let said = view.token("subdivisionScheme")?;
    let scheme = said.as_deref().unwrap_or("catmullClark");
    match scheme {
        "none" | "bilinear" => {}
        "catmullClark" | "loop" => {
            let by = if said.is_some() { "" } else { " (USD's fallback, nothing is said)" };
            let with = if has_normals { ", with the normals that are given" } else { ", flat" };
            let text = format!(
                "a {scheme} subdivision surface{by}: its polygons are taken as they are{with}; say `subdivisionScheme = \"none\"` if that is meant, else subdivide it before export"
            );
            reader.ledger.warn(view.at(), text);
        }
        other => {
            let fault = view.fault_in("subdivisionScheme", format!("the scheme `{other}`"));
            return Err(fault.expected("none, catmullClark, loop or bilinear"));
        }
    }
    Ok(())
}

/// A face of a mesh.
#[derive(Debug, Clone, Copy)]
struct Place {
    number: usize,
    /// Whether the mesh has no other.
    alone: bool,
}

/// One CAD face.
fn face(
    reader: &mut Reader,
    view: &PrimView,
    data: &mut Data,
    own: &Own,
    place: Place,
    scratch: &mut Scratch,
) -> Result<FaceMesh> {
    let triangles = own.triangles(&data.polygons);
    // At most three vertices a triangle, and the tables of the repair.
    reader.charge(view.path(), triangles, 3 * VERTEX + 2 * TRIANGLE)?;
    let has_normals = data.normals.is_some();
    let (mut face, ragged) = vertices::face(data, own, place.alone, place.number, triangles, scratch);
    if ragged > 0 {
        let text = "a polygon that crosses itself: cut as a fan";
        reader.ledger.notes.add_many(Severity::Warning, view.at(), text, ragged);
    }
    for uv in face.uvs.iter_mut().filter(|uv| !uv.iter().all(|x| x.is_finite())) {
        reader.ledger.warn_of(Code::DataNotFinite, view.at(), "texture coordinates that are not finite: set to 0");
        *uv = [0.0; 2];
    }
    if !has_normals {
        reader.ledger.info(view.at(), "no normals: the faces are flat-shaded");
        let (flat, without_area) = flat_shaded(&face);
        if without_area > 0 {
            let text = "a triangle without area and without normals";
            reader.ledger.notes.add_many(Severity::Info, view.at(), text, without_area);
        }
        return Ok(flat);
    }
    mend(reader, view, &mut face, place.number);
    Ok(face)
}

/// Brings normals to unit length and mends those that contradict their triangles, and says so: as for glTF.
fn mend(reader: &mut Reader, view: &PrimView, face: &mut FaceMesh, number: usize) {
    let given = std::mem::take(&mut face.normals);
    let Settled { normals, off, broken } = settle(given, &face.positions, &face.triangles, 1e-3);
    face.normals = normals;
    let notes = &mut reader.ledger.notes;
    if off > 0 {
        notes.add_many(Severity::Info, view.at(), "normals that are not of unit length: normalised", off);
    }
    if broken > 0 {
        let text = "a normal that is zero or not finite: computed from the triangles around its vertex";
        notes.add(Note::warning(view.at(), text).code(Code::DataNotFinite), broken);
    }
    if are_sound(&face.positions, &face.normals, &face.triangles) {
        return;
    }
    let found = repair(&face.positions, &mut face.normals, &face.triangles);
    if found.flipped + found.replaced > 0 {
        let (flipped, replaced, worst) = (found.flipped, found.replaced, found.worst_deg);
        let name = view.path().as_str().trim_start_matches('/');
        let text = format!(
            "{name} face {number}: normals contradict their triangles by up to {worst:.0}°: {flipped} turned round, {replaced} replaced"
        );
        let note = Note::warning(view.at(), text).code(Code::NormalsContradict).face(number);
        reader.ledger.notes.add(note, 1);
    }
    if found.inverted {
        let text = "the normals of a face point into the side that its winding calls the inside: kept as they are";
        reader.ledger.warn_of(Code::NormalsInsideOut, view.at(), text);
    }
}
