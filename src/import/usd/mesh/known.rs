//! Which meshes are one and the same: references share nothing in USD, but they do here.

use super::super::attribute::PrimView;
use super::super::caches::Alike;
use super::super::handed::{self, Above};
use super::super::reader::Reader;
use crate::assembly::MeshSource;
use crate::value::Value;
use eyebox_base::error::Result;
use eyebox_scene::Mesh;

/// What building a mesh ends in.
pub(in crate::usd) enum Made {
    Nothing,
    New(Box<MeshSource>),
    /// One that is kept already.
    Known(usize),
}

/// The mesh of a prim, an index of `Assembly::meshes`; built if its source was not met before.
pub(in crate::usd) fn shared(
    reader: &mut Reader,
    view: &PrimView,
    below: &Above,
    build: impl FnOnce(&mut Reader, &PrimView, &Above) -> Result<Made>,
) -> Result<Option<usize>> {
    let key = (handed::shared_path(view, below), below.handed.clone());
    if let Some(&known) = reader.meshes.by_source.get(&key) {
        return Ok(known);
    }
    let (taken, count) = (reader.ledger.taken(), reader.assembly.meshes.len());
    let index = match build(reader, view, below)? {
        Made::Nothing => None,
        Made::New(source) => Some(keep(reader, *source)),
        Made::Known(index) => Some(index),
    };
    if index.is_some_and(|index| index < count) {
        let moment = &reader.moment;
        reader.ledger.give_back(|| moment.at(view.path()), taken)?;
    }
    reader.meshes.by_source.insert(key, index);
    Ok(index)
}

/// Adds a mesh, or finds one that is the same to the last bit.
pub(in crate::usd) fn keep(reader: &mut Reader, source: MeshSource) -> usize {
    let meshes = &mut reader.assembly.meshes;
    let index = meshes.len();
    let size = (source.mesh.positions.len(), source.mesh.triangles.len());
    let alike =
        reader.meshes.by_size.entry(size).or_insert_with(|| Alike { unhashed: Some(index), ..Alike::default() });
    if alike.unhashed == Some(index) {
        meshes.push(source);
        return index;
    }
    if let Some(first) = alike.unhashed.take()
        && let Some(other) = meshes.get(first)
    {
        alike.by_content.insert(content(&other.mesh), vec![first]);
    }
    let found = alike.by_content.entry(content(&source.mesh)).or_default();
    // Looking at a few is enough: many with the same points that differ otherwise are no sharing case.
    let same = |&&known: &&usize| meshes.get(known).is_some_and(|other| is_same(&source, other));
    if let Some(&known) = found.iter().take(16).find(same) {
        return known;
    }
    found.push(index);
    meshes.push(source);
    index
}

/// blake3 of positions and normals.
fn content(mesh: &Mesh) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    let mut block = Vec::with_capacity(1 << 16);
    for values in [&mesh.positions, &mesh.normals] {
        for part in values.as_flattened().chunks(1 << 14) {
            block.clear();
            block.extend(part.iter().flat_map(|value| value.to_bits().to_le_bytes()));
            hasher.update(&block);
        }
    }
    hasher.finalize()
}

fn is_same(one: &MeshSource, other: &MeshSource) -> bool {
    let bits = |a: &[f32], b: &[f32]| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits());
    let attributes = |a: &Option<Value>, b: &Option<Value>| match (a, b) {
        (Some(a), Some(b)) => a.same(b),
        (None, None) => true,
        (Some(_), None) | (None, Some(_)) => false,
    };
    let (a, b) = (&one.mesh, &other.mesh);
    // What bends them may differ where the bent meshes do not.
    one.rig.is_none()
        && other.rig.is_none()
        && a.name == b.name
        && a.triangles == b.triangles
        && a.faces == b.faces
        && bits(a.positions.as_flattened(), b.positions.as_flattened())
        && bits(a.normals.as_flattened(), b.normals.as_flattened())
        && bits(a.uvs.as_flattened(), b.uvs.as_flattened())
        && bits(a.second_uvs.as_flattened(), b.second_uvs.as_flattened())
        && bits(a.colors.as_flattened(), b.colors.as_flattened())
        && one.materials == other.materials
        && one.attributes.len() == other.attributes.len()
        && one.attributes.iter().zip(&other.attributes).all(|(a, b)| attributes(a, b))
}
