//! UsdSkel: blend shapes, then the skeleton, bend the points of a mesh below a SkelRoot. What is bound is inherited down
//! namespace, the nearest wins (UsdSkelBindingAPI). The bent points are written in the mesh's own axes.

mod blend_shape; // offsets of points
mod influences; // joints and weights
mod rig; // all of it as data
mod skeleton; // where joints are at the moment

#[cfg(test)]
mod tests;

use super::attribute::PrimView;
use super::caches::Skeleton;
use super::polygons::Corners;
use super::primvar::Primvar;
use super::reader::Reader;
use super::skel_binding::{Bound, Inherited, name_of};
use super::xform;
use crate::gltf::transform::is_singular;
use crate::skinning::{self, Blend};
use eyebox_base::Code;
use eyebox_base::error::Result;
use glam::{DAffine3, DVec3};
use influences::Influences;
use openusd::sdf;
pub(super) use rig::rig;

/// The prim that says a property for those with `inherited`.
fn saying(reader: &mut Reader, inherited: &Inherited, bound: Bound) -> Result<Option<PrimView>> {
    let Some(path) = inherited.by(bound).cloned() else { return Ok(None) };
    let prim = reader.prim(&path)?;
    PrimView::new(prim, &reader.moment).map(Some)
}

/// The prim that a relationship of `inherited` leads to.
fn target(reader: &mut Reader, inherited: &Inherited, bound: Bound) -> Result<Option<PrimView>> {
    let Some(by) = saying(reader, inherited, bound)? else { return Ok(None) };
    let targets = by.targets(name_of(bound))?;
    let Some(path) = targets.first() else { return Ok(None) };
    view_at(reader, &by, name_of(bound), path)
}

/// The prim at `path`, which `by` names; none with a warning if it does not exist.
fn view_at(reader: &mut Reader, by: &PrimView, name: &str, path: &sdf::Path) -> Result<Option<PrimView>> {
    let prim = reader.prim(path)?;
    if !prim.is_valid().map_err(|error| reader.moment.failed(path, error))? {
        reader.ledger.warn(by.at_property(name), format!("<{}> does not exist: nothing is bent", path.as_str()));
        return Ok(None);
    }
    PrimView::new(prim, &reader.moment).map(Some)
}

/// The shape of a mesh as it is being bent.
pub(super) struct Shape<'a> {
    pub points: &'a mut Vec<[f32; 3]>,
    pub corners: &'a Corners,
    pub normals: &'a mut Option<Primvar<[f32; 3]>>,
}

/// Bends the points and normals of the mesh `view`, if anything is bound to it; whether that mirrors most of it.
///
/// # Errors
/// Values of other types than the schema's, joints that the skeleton does not have, weights that are negative or not finite,
/// points that leave the range of numbers.
pub(super) fn bend(reader: &mut Reader, view: &PrimView, inherited: &Inherited, shape: &mut Shape<'_>) -> Result<bool> {
    let binds = |bound| inherited.by(bound).is_some();
    let is_skinned = binds(Bound::Indices) && binds(Bound::Weights);
    let has_shapes = binds(Bound::BlendShapes) && binds(Bound::BlendShapeTargets);
    if !(is_skinned || has_shapes) || !(binds(Bound::Skeleton) || binds(Bound::Animation)) {
        return Ok(false);
    }
    if !inherited.is_rooted {
        reader.ledger.warn(view.at(), "bound to a skeleton without a SkelRoot above: not bent, as in USD");
        return Ok(false);
    }
    reader.charge(view.path(), shape.points.len(), size_of::<DVec3>() + size_of::<DAffine3>())?;
    let bones = target(reader, inherited, Bound::Skeleton)?;
    let skeleton = match &bones {
        Some(bones) => skeleton::posed(reader, bones, inherited)?,
        None => skeleton::alone(reader, inherited)?,
    };
    let mut points: Vec<DVec3> = shape.points.iter().map(|p| DVec3::from(p.map(f64::from))).collect();
    let mut offsets = None;
    if has_shapes {
        offsets = blend_shape::apply(reader, view, inherited, &skeleton, &mut points)?;
    }
    let matrices = match &bones {
        Some(bones) if is_skinned => matrices(reader, view, bones, inherited, &skeleton, points.len())?,
        Some(_) | None => Vec::new(),
    };
    for (point, matrix) in points.iter_mut().zip(&matrices) {
        *point = matrix.transform_point3(*point);
    }
    bend_normals(shape, offsets.as_deref(), &matrices);
    *shape.points = points.iter().map(|p| p.to_array().map(|x| x as f32)).collect();
    if let Some(bad) = shape.points.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        let fault = view.fault(format!("point {bad} is bent beyond the range of numbers"));
        return Err(fault.expected("finite points").code(Code::DataNotFinite));
    }
    let mirrored = matrices.iter().filter(|matrix| matrix.matrix3.determinant() < 0.0).count();
    Ok(2 * mirrored > points.len())
}

/// The matrix of each point: mesh at rest → mesh, in its own axes.
fn matrices(
    reader: &mut Reader,
    view: &PrimView,
    bones: &PrimView,
    inherited: &Inherited,
    skeleton: &Skeleton,
    points: usize,
) -> Result<Vec<DAffine3>> {
    let own = world(reader, view)?;
    if is_singular(own) {
        reader.ledger.warn_of(Code::PartFlattened, view.at(), "a mesh with a singular transform: no joint moves it");
        return Ok(Vec::new());
    }
    let to_own = own.inverse() * world(reader, bones)?;
    let Some(influences) = Influences::read(reader, view, inherited, skeleton, points)? else { return Ok(Vec::new()) };
    let bind = influences.geom_bind;
    let (mut unbound, mut off, mut out) = (0usize, 0usize, Vec::with_capacity(points));
    for point in 0..points {
        let mut blend = Blend::default();
        for (joint, weight) in influences.of(point) {
            if let Some(matrix) = skeleton.skinning.get(joint) {
                blend.add(matrix, weight);
            }
        }
        unbound += usize::from(blend.weight() == 0.0);
        off += usize::from(blend.weight() > 0.0 && (blend.weight() - 1.0).abs() > 0.01);
        out.push(to_own * blend.mean().unwrap_or(DAffine3::IDENTITY) * bind);
    }
    if let Some(bad) = out.iter().position(|matrix| !matrix.is_finite()) {
        return Err(view.fault(format!("the joints of point {bad} overflow")).expected("finite transforms"));
    }
    if unbound > 0 {
        let text = format!("{unbound} points without weights: they stand with the skeleton");
        reader.ledger.warn(view.at(), text);
    }
    if off > 0 {
        let text = format!("the weights of {off} points do not add up to 1: taken in proportion");
        reader.ledger.warn(view.at(), text);
    }
    Ok(out)
}

/// Normals follow their points: by the offsets of blend shapes, then by the inverse transposes of the matrices.
fn bend_normals(shape: &mut Shape<'_>, offsets: Option<&[DVec3]>, matrices: &[DAffine3]) {
    let Some(normals) = shape.normals.take() else { return };
    let bent = |normal: [f32; 3], point: usize| {
        let mut normal = DVec3::from(normal.map(f64::from));
        if let Some(offset) = offsets.and_then(|offsets| offsets.get(point)) {
            normal += *offset;
        }
        if let Some(matrix) = matrices.get(point) {
            normal = skinning::normal(&matrix.matrix3, normal);
        }
        crate::gltf::normals::unit(normal).unwrap_or_default()
    };
    *shape.normals = Some(normals.with_points(shape.corners, shape.points.len(), bent));
}

/// Prim → parent of a shape without points that joints move as a whole; none if nothing is bound to it.
///
/// # Errors
/// As [`bend`].
pub(super) fn rigid(reader: &mut Reader, view: &PrimView, inherited: &Inherited) -> Result<Option<DAffine3>> {
    let binds = |bound| inherited.by(bound).is_some();
    if !inherited.is_rooted || !binds(Bound::Indices) || !binds(Bound::Weights) || !binds(Bound::Skeleton) {
        return Ok(None);
    }
    let Some(bones) = target(reader, inherited, Bound::Skeleton)? else { return Ok(None) };
    let skeleton = skeleton::posed(reader, &bones, inherited)?;
    let Some(influences) = Influences::read(reader, view, inherited, &skeleton, 1)? else { return Ok(None) };
    let above = above(reader, view, false)?;
    if is_singular(above) {
        return Ok(None);
    }
    let mut blend = Blend::default();
    influences.of(0).for_each(|(joint, weight)| {
        skeleton.skinning.get(joint).into_iter().for_each(|matrix| blend.add(matrix, weight));
    });
    let Some(mean) = blend.mean() else { return Ok(None) };
    let transform = above.inverse() * world(reader, &bones)? * mean * influences.geom_bind;
    if !transform.is_finite() {
        return Err(view.fault("its joints overflow").expected("finite transforms"));
    }
    Ok(Some(transform))
}

/// Where a prim stands on the stage, by its own transform and those of the prims above it.
fn world(reader: &mut Reader, view: &PrimView) -> Result<DAffine3> {
    // What is wrong with transforms is said when their prims are met.
    let local = xform::local(view, &mut super::notes::Ledger::new())?;
    let out = above(reader, view, local.resets)? * local.transform;
    if !out.is_finite() {
        return Err(view.fault("the prim's world transform overflows").expected("finite numbers"));
    }
    Ok(out)
}

/// Where the parent of a prim stands; nowhere but in the world if the prim resets.
fn above(reader: &mut Reader, view: &PrimView, resets: bool) -> Result<DAffine3> {
    let (mut out, mut resets) = (DAffine3::IDENTITY, resets);
    for path in view.path().strict_ancestors_below_root().take(super::handed::MOST_DEEP) {
        if resets {
            break;
        }
        let above = PrimView::new(reader.prim(&path)?, &reader.moment)?;
        let local = xform::local(&above, &mut super::notes::Ledger::new())?;
        out = local.transform * out;
        resets = local.resets;
    }
    Ok(out)
}
