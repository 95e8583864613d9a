//! Meshes: one vertex per position, one GeomSubset per face.

use super::layer::{Datum, Prim, Property};
use super::name::Siblings;
use super::stage::{Writing, named};
use super::{implicit, material, optics, samples, skel};
use eyebox_base::error::Result;
use eyebox_scene::assembly::MeshSource;
use eyebox_scene::motion::Vertices;
use std::collections::BTreeSet;

/// The family of subsets that are CAD faces; where they have materials of their own, USD wants its own word.
const FACES: &str = "cadFace";
const BOUND: &str = "materialBind";

fn positions_of(shape: &Vertices) -> &Vec<[f32; 3]> {
    &shape.positions
}

/// A mesh, and the node that has it; none for a prototype of several.
#[derive(Debug, Clone, Copy)]
pub(super) struct Own {
    pub mesh: usize,
    pub node: Option<usize>,
}

/// Appends a mesh and its faces at `depth`.
///
/// # Errors
/// Positions or normals that are not finite, faces that reach beyond the triangles or share some, more triangles than
/// USD's indices count.
pub(super) fn write(
    writing: &Writing<'_>,
    own: Own,
    depth: usize,
    siblings: &mut Siblings,
    prims: &mut Vec<Prim>,
) -> Result<()> {
    let index = own.mesh;
    let Some(source) = writing.assembly.meshes.get(index) else { return Ok(()) };
    if implicit::write(writing, own, depth, siblings, prims)? {
        return Ok(());
    }
    let mesh = &source.mesh;
    // Joints and blend shapes bend what nothing has bent yet.
    let rest = source.rig.as_ref().map(|rig| &rig.rest);
    let (positions, normals) = rest.map_or((&mesh.positions, &mesh.normals), |rest| (&rest.positions, &rest.normals));
    let motion = writing.assembly.motion.as_ref();
    let moved = motion.and_then(|motion| Some((motion, motion.of_mesh(index)?)));
    let fault = |what: &str| writing.fault(&source.at, format!("mesh `{}`: {what}", mesh.name));
    if positions.iter().flatten().chain(normals.iter().flatten()).any(|x| !x.is_finite()) {
        return Err(fault("positions or normals that are not finite"));
    }
    let count = positions.len();
    let fits = |own: usize| own == 0 || own == count;
    if normals.len() != count || ![mesh.uvs.len(), mesh.second_uvs.len(), mesh.colors.len()].into_iter().all(fits) {
        return Err(fault("not one normal (and texture coordinate, and colour) per position"));
    }
    if i32::try_from(mesh.positions.len()).is_err() || i32::try_from(mesh.triangles.len()).is_err() {
        return Err(fault("more vertices or triangles than USD can count").expected("at most 2147483647"));
    }
    let mut prim = Prim::def(depth, "Mesh", siblings.name(&mesh.name, "Mesh"));
    named(&mut prim, &mesh.name);
    prim.marks.push(("part", Datum::Bool(true)));
    let indices: Vec<i32> = mesh.triangles.iter().flatten().map(|index| i32::try_from(*index).unwrap_or(-1)).collect();
    if mesh.triangles.iter().flatten().any(|index| *index as usize >= mesh.positions.len()) {
        return Err(fault("triangles with vertices that are not there"));
    }
    if let Some(all) = extent(positions) {
        let samples = samples::vertices(moved, positions_of, |all| {
            Datum::Float3s(extent(all).map_or_else(Vec::new, |extent| extent.to_vec()))
        });
        prim.push(Property::new("extent", Datum::Float3s(all.to_vec())).sampled(samples));
    }
    prim.push(Property::new("faceVertexCounts", Datum::Ints(vec![3; mesh.triangles.len()])));
    prim.push(Property::new("faceVertexIndices", Datum::Ints(indices)));
    let points = samples::vertices(moved, positions_of, |all| Datum::Float3s(all.to_vec()));
    let turned = samples::vertices(moved, |shape| &shape.normals, |all| Datum::Float3s(all.to_vec()));
    prim.push(Property::new("points", Datum::Float3s(positions.clone())).typed("point3f[]").sampled(points));
    prim.push(
        Property::new("normals", Datum::Float3s(normals.clone())).typed("normal3f[]").per("vertex").sampled(turned),
    );
    let up = |[u, v]: &[f32; 2]| if writing.assembly.st_runs_up() { [*u, *v] } else { [*u, 1.0 - *v] };
    for (name, set) in [("primvars:st", &mesh.uvs), ("primvars:st1", &mesh.second_uvs)] {
        if !set.is_empty() {
            let set = Datum::Float2s(set.iter().map(up).collect());
            prim.push(Property::new(name, set).typed("texCoord2f[]").per("vertex"));
        }
    }
    if !mesh.colors.is_empty() {
        let colors = Datum::Float3s(mesh.colors.iter().map(|[r, g, b, _]| [*r, *g, *b]).collect());
        prim.push(Property::new("primvars:displayColor", colors).typed("color3f[]").per("vertex"));
    }
    if mesh.colors.iter().any(|[.., alpha]| *alpha != 1.0) {
        let alphas = Datum::Floats(mesh.colors.iter().map(|[.., alpha]| *alpha).collect());
        prim.push(Property::new("primvars:displayOpacity", alphas).per("vertex"));
    }
    prim.push(Property::new("orientation", Datum::Token("rightHanded".to_owned())).uniform());
    prim.push(Property::new("subdivisionScheme", Datum::Token("none".to_owned())).uniform());

    let bound: BTreeSet<Option<usize>> = (0..mesh.faces.len()).map(|face| material_of(source, face)).collect();
    let family = match bound.iter().collect::<Vec<_>>().as_slice() {
        [] | [None] => FACES,
        [Some(material)] => {
            material::bind(writing, *material, &mut prim)?;
            FACES
        }
        _ => BOUND,
    };
    prim.push(
        Property::new(format!("subsetFamily:{family}:familyType"), Datum::Token("partition".to_owned())).uniform(),
    );
    let bound = own.node.and_then(|node| writing.skeletons.bound.get(&node));
    let place = skel::path_below(prims, depth);
    if let (Some(rig), Some(bound)) = (&source.rig, bound) {
        skel::bind(writing, (rig, bound), &format!("{place}/{}", prim.name), &mut prim);
    }
    prims.push(prim);
    subsets(writing, source, family, depth + 1, prims)?;
    if let (Some(rig), Some(bound)) = (&source.rig, bound) {
        skel::blend_shapes(rig, bound, depth + 1, prims);
    }
    Ok(())
}

pub(super) fn material_of(source: &MeshSource, face: usize) -> Option<usize> {
    source.materials.get(face).copied().flatten()
}

fn subsets(
    writing: &Writing<'_>,
    source: &MeshSource,
    family: &str,
    depth: usize,
    prims: &mut Vec<Prim>,
) -> Result<()> {
    let mesh = &source.mesh;
    let width = mesh.faces.len().saturating_sub(1).max(1).to_string().len().max(3);
    let mut next = 0usize;
    for (index, face) in mesh.faces.iter().enumerate() {
        let end = (face.first as usize).checked_add(face.count as usize);
        let Some(end) = end.filter(|end| *end <= mesh.triangles.len() && face.first as usize == next) else {
            let what = format!("face {index} of mesh `{}` does not follow the one before it", mesh.name);
            return Err(writing.fault(&source.at, what).expected("faces that partition the triangles in order"));
        };
        next = end;
        let mut prim = Prim::def(depth, "GeomSubset", format!("Face_{index:0width$}"));
        prim.push(Property::new("elementType", Datum::Token("face".to_owned())).uniform());
        prim.push(Property::new("familyName", Datum::Token(family.to_owned())).uniform());
        let triangles = (face.first..face.first.saturating_add(face.count)).filter_map(|i| i32::try_from(i).ok());
        prim.push(Property::new("indices", Datum::Ints(triangles.collect())));
        if family == BOUND
            && let Some(material) = material_of(source, index)
        {
            material::bind(writing, material, &mut prim)?;
        }
        if let Some(Some(attributes)) = source.attributes.get(index) {
            optics::apply(writing, attributes, &mut prim)?;
        }
        prims.push(prim);
    }
    if next != mesh.triangles.len() {
        return Err(writing.fault(&source.at, format!("mesh `{}` has triangles of no face", mesh.name)));
    }
    Ok(())
}

pub(super) fn extent(positions: &[[f32; 3]]) -> Option<[[f32; 3]; 2]> {
    let first = *positions.first()?;
    let mut out = [first, first];
    for p in positions {
        for axis in 0..3 {
            out[0][axis] = out[0][axis].min(p[axis]);
            out[1][axis] = out[1][axis].max(p[axis]);
        }
    }
    Some(out)
}
