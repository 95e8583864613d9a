//! Skeletons: joints by their paths, where they were when meshes were bound, and where they are at the moment.

use super::super::attribute::PrimView;
use super::super::caches::Skeleton;
use super::super::reader::Reader;
use super::super::skel_binding::{Bound, Inherited, name_of};
use super::super::value;
use super::super::xform;
use super::target;
use eyebox_base::error::Result;
use glam::{DAffine3, DMat3, DVec3};
use openusd::sdf::Value;
use std::collections::HashMap;
use std::rc::Rc;

/// Joints deeper than this are no skeleton.
const MOST_DEEP: usize = 512;

/// The skeleton at `view`, which a mesh with `inherited` is bound to.
///
/// # Errors
/// Values of other types than the schema's, other numbers of transforms than of joints, matrices without an inverse.
pub(super) fn posed(reader: &mut Reader, view: &PrimView, inherited: &Inherited) -> Result<Rc<Skeleton>> {
    // The animation is the skeleton's: what it says itself, else what is bound above it.
    let animation = animation_of(reader, view, inherited)?;
    let key = (view.path().as_str().to_owned(), animation.as_ref().map(|view| view.path().as_str().to_owned()));
    if let Some(known) = reader.skeletons.get(&key) {
        return Ok(Rc::clone(known));
    }
    let skeleton = Rc::new(read(reader, view, animation.as_ref())?);
    reader.skeletons.insert(key, Rc::clone(&skeleton));
    Ok(skeleton)
}

/// The blend shapes of a mesh that is bound to an animation and to no skeleton.
pub(super) fn alone(reader: &mut Reader, inherited: &Inherited) -> Result<Rc<Skeleton>> {
    let mut out = Skeleton::default();
    if let Some(animation) = target(reader, inherited, Bound::Animation)? {
        out.shapes = shapes(reader, &animation)?;
    }
    Ok(Rc::new(out))
}

/// `skel:animationSource` of the skeleton or of the nearest prim above it.
fn animation_of(reader: &mut Reader, view: &PrimView, inherited: &Inherited) -> Result<Option<PrimView>> {
    let name = name_of(Bound::Animation);
    let mut above = vec![view.path().clone()];
    above.extend(view.path().strict_ancestors_below_root().take(super::super::handed::MOST_DEEP));
    for path in above {
        let own = PrimView::new(reader.prim(&path)?, &reader.moment)?;
        if own.has(name) {
            return match own.targets(name)?.first() {
                Some(found) => super::view_at(reader, &own, name, found),
                None => Ok(None),
            };
        }
    }
    target(reader, inherited, Bound::Animation)
}

fn read(reader: &mut Reader, view: &PrimView, animation: Option<&PrimView>) -> Result<Skeleton> {
    let joints = view.tokens("joints")?.unwrap_or_default();
    let bytes: usize = joints.iter().map(String::len).sum();
    reader.charge(view.path(), joints.len(), 8 * size_of::<DAffine3>())?;
    reader.charge(view.path(), bytes, 2)?;
    let mut by_path = HashMap::with_capacity(joints.len());
    for (index, joint) in joints.iter().enumerate() {
        by_path.entry(joint.clone()).or_insert(index);
    }
    let mut out = Skeleton { joints, by_path, ..Skeleton::default() };
    let Some(binds) = matrices(view, "bindTransforms", out.joints.len())? else {
        reader.ledger.warn(view.at(), "a skeleton without `bindTransforms`: its joints move nothing");
        return Ok(out);
    };
    let mut locals = matrices(view, "restTransforms", out.joints.len())?;
    if let Some(animation) = animation {
        locals = animated(reader, view, animation, &out, locals)?;
        out.shapes = shapes(reader, animation)?;
    }
    let Some(locals) = locals else {
        reader
            .ledger
            .warn(view.at(), "a skeleton without an animation and `restTransforms`: it stands as it was bound");
        out.skinning = vec![DAffine3::IDENTITY; out.joints.len()];
        (out.worlds, out.binds) = (binds.clone(), binds);
        return Ok(out);
    };
    let worlds = worlds(view, &out, &locals)?;
    for ((world, bind), joint) in worlds.iter().zip(&binds).zip(&out.joints) {
        let skinning = *world * bind.inverse();
        if !skinning.is_finite() {
            let what = format!("the joint `{}` cannot be moved from where it was bound", joint.escape_debug());
            return Err(view.fault_in("bindTransforms", what).expected("finite matrices with an inverse"));
        }
        out.skinning.push(skinning);
    }
    (out.worlds, out.binds) = (worlds, binds);
    Ok(out)
}

/// One matrix a joint; none if nothing is said.
fn matrices(view: &PrimView, name: &str, joints: usize) -> Result<Option<Vec<DAffine3>>> {
    let Some(found) = view.get(name)? else { return Ok(None) };
    let Value::Matrix4dVec(all) = found else {
        return Err(view.fault_in(name, "a value of another type").expected("matrix4d[]"));
    };
    if all.is_empty() && joints > 0 {
        return Ok(None);
    }
    if all.len() != joints {
        let what = format!("{} matrices for {joints} joints", all.len());
        return Err(view.fault_in(name, what).expected("one for each joint"));
    }
    Ok(Some(all.iter().map(|matrix| affine(&matrix.0)).collect()))
}

/// USD writes rows for row vectors, which are our columns.
pub(super) fn affine(m: &[f64; 16]) -> DAffine3 {
    let row = |r: usize| DVec3::new(m[4 * r], m[4 * r + 1], m[4 * r + 2]);
    DAffine3 { matrix3: DMat3::from_cols(row(0), row(1), row(2)), translation: row(3) }
}

/// Joint → parent at the moment: what the animation says of it, else where it rests.
fn animated(
    reader: &mut Reader,
    view: &PrimView,
    animation: &PrimView,
    skeleton: &Skeleton,
    rest: Option<Vec<DAffine3>>,
) -> Result<Option<Vec<DAffine3>>> {
    if animation.type_name()? != "SkelAnimation" {
        let text = format!("<{}> is no SkelAnimation: joints stand where they rest", animation.path().as_str());
        reader.ledger.warn(view.at(), text);
        return Ok(rest);
    }
    let joints = animation.tokens("joints")?.unwrap_or_default();
    let translations = animation.read("translations", "float3[]", value::wide_triples)?.unwrap_or_default();
    let turns = animation.read("rotations", "quatf[]", value::quaternions)?.unwrap_or_default();
    let scales = animation.read("scales", "half3[]", value::wide_triples)?.unwrap_or_default();
    // What half precision lost, if our own writer kept it.
    let exact = animation.read("eyebox:scales", "float3[]", value::wide_triples)?.unwrap_or_default();
    let scales: Vec<[f64; 3]> = match exact.len() == scales.len() {
        true => exact.iter().zip(&scales).map(|(exact, rounded)| unhalved(*exact, *rounded)).collect(),
        false => scales,
    };
    let counts = [("translations", translations.len()), ("rotations", turns.len()), ("scales", scales.len())];
    if let Some((name, count)) = counts.into_iter().find(|(_, count)| *count != joints.len()) {
        if !joints.is_empty() {
            let text = format!("{count} {name} for {} joints: joints stand where they rest, as in USD", joints.len());
            reader.ledger.warn(animation.at_property(name), text);
        }
        return Ok(rest);
    }
    reader.charge(animation.path(), joints.len(), size_of::<DAffine3>())?;
    let had_rest = rest.is_some();
    let mut moved = vec![false; skeleton.joints.len()];
    let mut out = rest.unwrap_or_else(|| vec![DAffine3::IDENTITY; skeleton.joints.len()]);
    for (i, joint) in joints.iter().enumerate() {
        let Some(&place) = skeleton.by_path.get(joint) else { continue };
        let (Some(&shift), Some(&turn), Some(&size)) = (translations.get(i), turns.get(i), scales.get(i)) else {
            continue;
        };
        let turn = xform::rotation(animation, "rotations", turn, &mut reader.ledger)?;
        let local = DAffine3::from_scale_rotation_translation(DVec3::from(size), turn, DVec3::from(shift));
        if let (Some(slot), Some(moved)) = (out.get_mut(place), moved.get_mut(place)) {
            (*slot, *moved) = (local, true);
        }
    }
    if !had_rest && moved.contains(&false) {
        let text = "joints that nothing moves, in a skeleton without `restTransforms`: they stand at their parents";
        reader.ledger.warn(view.at(), text);
    }
    Ok(Some(out))
}

/// The exact numbers, where they are what was rounded to half precision: someone may have changed those since.
fn unhalved(exact: [f64; 3], rounded: [f64; 3]) -> [f64; 3] {
    // Eleven bits, and what is below the smallest normal number.
    let near = |lane: usize| (exact[lane] - rounded[lane]).abs() <= exact[lane].abs() / 1024.0 + 6e-8;
    std::array::from_fn(|lane| if near(lane) { exact[lane] } else { rounded[lane] })
}

/// Joint → skeleton: the product from the root. The parent of a joint is the nearest joint whose path is above its own.
fn worlds(view: &PrimView, skeleton: &Skeleton, locals: &[DAffine3]) -> Result<Vec<DAffine3>> {
    let mut worlds: Vec<Option<DAffine3>> = vec![None; skeleton.joints.len()];
    for start in 0..skeleton.joints.len() {
        // Up to what is known, then down again.
        let (mut chain, mut next) = (Vec::new(), Some(start));
        let mut world = DAffine3::IDENTITY;
        while let Some(joint) = next {
            if let Some(known) = worlds.get(joint).copied().flatten() {
                world = known;
                break;
            }
            chain.push(joint);
            next = parent(view, skeleton, joint)?;
        }
        for joint in chain.into_iter().rev() {
            world *= locals.get(joint).copied().unwrap_or(DAffine3::IDENTITY);
            if let Some(slot) = worlds.get_mut(joint) {
                *slot = Some(world);
            }
        }
    }
    Ok(worlds.into_iter().map(|world| world.unwrap_or(DAffine3::IDENTITY)).collect())
}

pub(super) fn parent(view: &PrimView, skeleton: &Skeleton, joint: usize) -> Result<Option<usize>> {
    let mut path = skeleton.joints.get(joint).map_or("", String::as_str);
    for _ in 0..MOST_DEEP {
        let Some((above, _)) = path.rsplit_once('/') else { return Ok(None) };
        if let Some(&found) = skeleton.by_path.get(above).filter(|found| **found != joint) {
            return Ok(Some(found));
        }
        path = above;
    }
    Err(view.fault_in("joints", "joints nested too deep").expected(format!("at most {MOST_DEEP} levels")))
}

/// The weights of blend shapes that an animation says.
fn shapes(reader: &mut Reader, animation: &PrimView) -> Result<HashMap<String, f64>> {
    let names = animation.tokens("blendShapes")?.unwrap_or_default();
    let weights = animation.read("blendShapeWeights", "float[]", value::wide_numbers)?.unwrap_or_default();
    if names.len() != weights.len() {
        let text = format!("{} weights for {} blend shapes: not used", weights.len(), names.len());
        reader.ledger.warn(animation.at_property("blendShapeWeights"), text);
        return Ok(HashMap::new());
    }
    Ok(names.into_iter().zip(weights).collect())
}
