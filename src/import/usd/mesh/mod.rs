//! UsdGeomMesh into a mesh with CAD faces.

mod carried; // what vertices have beside position and normal
mod cut; // polygons → faces → triangles
mod known; // which meshes are one and the same
mod posed; // what a rig makes of vertices
mod varied; // what is refined with a subdivision surface
mod vertices; // points → vertices

#[cfg(test)]
mod tests;

use super::attribute::PrimView;
use super::faces::Partition;
use super::handed::Above;
use super::polygons::{self, Polygons};
use super::reader::Reader;
use super::{binding, faces, optics, paint, primvar, skel, subdivide};
use crate::Rigs;
use crate::assembly::MeshSource;
use crate::gltf::mesh::append;
use crate::gltf::normals::{Settled, are_sound, flat_shaded, settle};
use crate::gltf::primitive::FaceMesh;
use crate::normals::repair;
use carried::{Carried, Shelf};
use cut::Own;
use eyebox_base::Code;
use eyebox_base::error::Result;
use eyebox_scene::motion::Vertices;
use eyebox_scene::{Mesh, Note, Severity};
use varied::Varied;
use vertices::Scratch;

pub(super) use known::{Made, keep, shared};
use vertices::Data;

/// Bytes of a vertex with normal, and of a triangle.
const VERTEX: usize = 24;
const TRIANGLE: usize = 12;

/// The mesh of a prim, an index of `Assembly::meshes`; none if it has no surface.
pub(super) fn of(reader: &mut Reader, view: &PrimView, below: &Above) -> Result<Option<usize>> {
    shared(reader, view, below, |reader, view, below| {
        Ok(build(reader, view, below)?.map_or(Made::Nothing, |source| Made::New(Box::new(source))))
    })
}

fn build(reader: &mut Reader, view: &PrimView, below: &Above) -> Result<Option<MeshSource>> {
    let Some(mut out) = made(reader, view, below, true)? else { return Ok(None) };
    if reader.rigs != Rigs::No && subdivide::scheme(view)?.0.is_none() {
        // What is wrong was said.
        let said = std::mem::take(&mut reader.ledger.notes);
        let rigged = rigged(reader, view, below, &out.source);
        reader.ledger.notes = said;
        if let Some(rigged) = rigged? {
            out.source = rigged;
        }
    }
    Ok(Some(out.source))
}

/// The mesh with what bends it, as data; none, where only its bent vertices say it.
fn rigged(reader: &mut Reader, view: &PrimView, below: &Above, bent: &MeshSource) -> Result<Option<MeshSource>> {
    let Some(polygons) = polygons::read(reader, view)? else { return Ok(None) };
    let Some(rig) = skel::rig(reader, view, &below.handed.skel, polygons.points.len())? else { return Ok(None) };
    let Some(still) = made(reader, view, below, false)? else { return Ok(None) };
    let mesh = &still.source.mesh;
    let rest = Vertices { positions: mesh.positions.clone(), normals: mesh.normals.clone() };
    let rig = rig.of_vertices(rest, &still.sources);
    // Joints may turn triangles round, or make polygons hollow so that they are cut another way, and normals that differ at rest
    // may fall together; what bends them is the same. At a frame that alone counts.
    let fits = mesh.triangles == bent.mesh.triangles && still.sources.len() == bent.mesh.positions.len();
    if fits || reader.rigs == Rigs::Poses {
        return Ok(Some(MeshSource { rig: Some(Box::new(rig)), ..bent.clone() }));
    }
    reader.charge(view.path(), still.sources.len(), 2 * VERTEX)?;
    let Some(Vertices { positions, normals }) = posed::vertices(&rig) else { return Ok(None) };
    let mesh = Mesh { positions, normals, ..Mesh::clone(mesh) };
    Ok(Some(MeshSource { mesh: mesh.into(), rig: Some(Box::new(rig)), ..still.source.clone() }))
}

/// What all vertices of an implicit shape carry for its material: texture coordinates of two sets, and a colour.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct AllOver {
    pub uvs: [Option<[f32; 2]>; 2],
    pub color: Option<[f32; 4]>,
}

/// What an implicit shape carries for its material. It has neither points nor polygons: primvars are the same all over it.
///
/// # Errors
/// Primvars with an interpolation that there is none of.
pub(super) fn all_over(
    reader: &mut Reader,
    view: &PrimView,
    below: &Above,
    material: Option<usize>,
) -> Result<AllOver> {
    let one = primvar::Sizes { points: 1, polygons: 1, corners: 1 };
    let carried = carried_by(reader, view, below, one, &[material])?.pop().unwrap_or_default();
    let at = |uvs: &carried::Held<[f32; 2]>| uvs.as_ref().and_then(|uvs| uvs.at(0, 0, 0));
    Ok(AllOver {
        uvs: [at(&carried.uvs), at(&carried.second_uvs)],
        color: carried.has_colors().then(|| paint::clamped(carried.colour(0, 0, 0))),
    })
}

/// A mesh, and the point that each vertex is, where the reader asks for that.
struct Traced {
    source: MeshSource,
    sources: Vec<u32>,
}

/// The mesh, bent or as nothing bends it.
fn made(reader: &mut Reader, view: &PrimView, below: &Above, bends: bool) -> Result<Option<Traced>> {
    let Some(mut polygons) = polygons::read(reader, view)? else { return Ok(None) };
    let sizes = polygons.sizes();
    let mut normals = primvar::normals(view, sizes, &mut reader.ledger)?;
    let Polygons { points, corners, .. } = &mut polygons;
    let mut shape = skel::Shape { points, corners, normals: &mut normals };
    let is_mirrored = bends && skel::bend(reader, view, &below.handed.skel, &mut shape)?;
    polygons.left_handed ^= is_mirrored;
    let mut partition = faces::partition(reader, view, sizes.polygons)?;
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
    let mut carried = carried_by(reader, view, below, sizes, &materials)?;
    let data = Data { polygons, normals, carried: Carried::default(), is_traced: !bends };
    let mut data = shaped(reader, view, data, &mut partition, &mut carried)?;
    let own = cut::grouped(&partition, &data.polygons);
    let (alone, mut scratch) = (own.len() == 1, Scratch::default());
    let mut sources = Vec::new();
    for (number, own) in own.iter().enumerate() {
        data.carried = carried.get_mut(number).map(std::mem::take).unwrap_or_default();
        let face = face(reader, view, &mut data, own, Place { number, alone }, &mut scratch)?;
        sources.extend_from_slice(&face.sources);
        append(&mut mesh, face).ok_or_else(|| view.fault("the mesh has more than 4294967295 vertices or triangles"))?;
    }
    let source = MeshSource { mesh: mesh.into(), materials, attributes, rig: None, implicit: None, at: view.at() };
    Ok(Some(Traced { source, sources }))
}

/// What the vertices of each face carry for its material.
fn carried_by(
    reader: &mut Reader,
    view: &PrimView,
    below: &Above,
    sizes: primvar::Sizes,
    materials: &[Option<usize>],
) -> Result<Vec<Carried>> {
    let Reader { materials: known, assembly, ledger, .. } = reader;
    let mut shelf = Shelf::new(view, sizes, below.handed.painted);
    let reads = |material: &Option<usize>| {
        let index = (*material)?;
        let looks = assembly.materials.get(index).is_some_and(|material| material.surface.is_some());
        known.reads.get(index).filter(|_| looks)
    };
    materials.iter().map(|material| shelf.face(reads(material), ledger)).collect()
}

/// A mesh as it is cut into faces, with what they carry.
fn shaped(
    reader: &mut Reader,
    view: &PrimView,
    data: Data,
    partition: &mut Partition,
    carried: &mut [Carried],
) -> Result<Data> {
    let (Some(scheme), is_said) = subdivide::scheme(view)? else { return Ok(data) };
    let varied = Varied::of(carried);
    let Some(fine) = subdivide::limit(
        reader,
        view,
        (scheme, is_said),
        (&data.polygons, data.normals.is_some()),
        &varied.channels(),
    )?
    else {
        return Ok(data);
    };
    varied.replace(carried, fine.primvars);
    if !partition.of.is_empty() {
        let face = |parent: &u32| partition.of.get(*parent as usize).copied().unwrap_or(0);
        partition.of = fine.parents.iter().map(face).collect();
    }
    Ok(Data { polygons: fine.polygons, normals: Some(fine.normals), carried: Carried::default(), is_traced: false })
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
    reader.charge(view.path(), triangles, 3 * (VERTEX + data.carried.bytes()) + 2 * TRIANGLE)?;
    let has_normals = data.normals.is_some();
    let (mut face, ragged) = vertices::face(data, own, place.alone, place.number, triangles, scratch);
    if ragged > 0 {
        let text = "a polygon that crosses itself: cut as a fan";
        reader.ledger.notes.add_many(Severity::Warning, view.at(), text, ragged);
    }
    for uv in face.uvs.iter_mut().chain(&mut face.second_uvs).filter(|uv| !uv.iter().all(|x| x.is_finite())) {
        reader.ledger.warn_of(Code::DataNotFinite, view.at(), "texture coordinates that are not finite: set to 0");
        *uv = [0.0; 2];
    }
    for color in face.colors.iter_mut().filter(|color| !color.iter().all(|x| (0.0..=1.0).contains(x))) {
        let text = "colours of vertices outside 0 to 1: brought there";
        reader.ledger.warn_of(Code::DataNotFinite, view.at(), text);
        *color = paint::clamped(*color);
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
