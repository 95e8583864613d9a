//! Shapes without points: a sphere of USD is a sphere again.

use super::layer::{Datum, Prim, Property};
use super::material;
use super::mesh::{Own, extent, material_of};
use super::name::Siblings;
use super::stage::{Writing, named};
use eyebox_base::error::Result;
use eyebox_scene::assembly::MeshSource;

/// Appends the shape that a mesh was made of. False where there is none, or where the mesh is more than that: where it moves, or
/// something is said of its faces.
///
/// # Errors
/// A material that is not there.
pub(super) fn write(
    writing: &Writing<'_>,
    own: Own,
    depth: usize,
    siblings: &mut Siblings,
    prims: &mut Vec<Prim>,
) -> Result<bool> {
    let Some(source) = writing.assembly.meshes.get(own.mesh) else { return Ok(false) };
    let Some(implicit) = source.implicit.as_ref().filter(|_| is_all(writing, own, source)) else { return Ok(false) };
    let mesh = &source.mesh;
    let mut prim = Prim::def(depth, implicit.kind, siblings.name(&mesh.name, implicit.kind));
    named(&mut prim, &mesh.name);
    prim.marks.push(("part", Datum::Bool(true)));
    if let Some(all) = extent(&mesh.positions) {
        prim.push(Property::new("extent", Datum::Float3s(all.to_vec())));
    }
    for (name, length) in &implicit.lengths {
        prim.push(Property::new(*name, Datum::Double(*length)));
    }
    if let Some(axis) = implicit.axis {
        prim.push(Property::new("axis", Datum::Token(axis.to_owned())).uniform());
    }
    let up = |[u, v]: [f32; 2]| if writing.assembly.st_runs_up() { [u, v] } else { [u, 1.0 - v] };
    for (name, set) in [("primvars:st", &mesh.uvs), ("primvars:st1", &mesh.second_uvs)] {
        if let Some(one) = set.first() {
            prim.push(Property::new(name, Datum::Float2s(vec![up(*one)])).typed("texCoord2f[]").per("constant"));
        }
    }
    if let Some([r, g, b, alpha]) = mesh.colors.first() {
        let color = Datum::Float3s(vec![[*r, *g, *b]]);
        prim.push(Property::new("primvars:displayColor", color).typed("color3f[]").per("constant"));
        if *alpha != 1.0 {
            prim.push(Property::new("primvars:displayOpacity", Datum::Floats(vec![*alpha])).per("constant"));
        }
    }
    if let Some(index) = material_of(source, 0) {
        material::bind(writing, index, &mut prim)?;
    }
    prims.push(prim);
    Ok(true)
}

/// Whether the shape is all that there is to say of a mesh.
fn is_all(writing: &Writing<'_>, own: Own, source: &MeshSource) -> bool {
    let moves = writing.assembly.motion.as_ref().is_some_and(|motion| motion.of_mesh(own.mesh).is_some());
    let says_more = source
        .attributes
        .iter()
        .flatten()
        .any(|attributes| !source.is_own_shape(attributes) || attributes.table().is_none_or(|rows| rows.len() > 1));
    let material = |face: usize| material_of(source, face);
    let is_one = (0..source.mesh.faces.len()).all(|face| material(face) == material(0));
    source.rig.is_none() && !moves && !says_more && is_one
}
