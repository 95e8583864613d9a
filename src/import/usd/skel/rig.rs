//! What bends the points of a mesh, as data: blend shapes, joints and weights. What the picture is, `bend` decides.

use super::super::attribute::PrimView;
use super::super::reader::Reader;
use super::super::skel_binding::{Bound, Inherited};
use super::blend_shape::{self, Whole};
use super::influences::Influences;
use super::{skeleton, target, world};
use crate::gltf::transform::is_singular;
use eyebox_base::error::Result;
use eyebox_scene::motion::{Joint, Pose, Rig, Skin, Target, Vertices};
use glam::{DAffine3, DVec3};

/// Of the points of a mesh.
pub(in crate::usd) struct PointRig {
    shapes: Vec<Whole>,
    joints: Vec<Joint>,
    binds: Vec<DAffine3>,
    places: Vec<DAffine3>,
    /// Joints and weights of each point; empty without joints.
    weighed: Vec<Vec<(u32, f64)>>,
}

/// The rig of the mesh `view` with so many points; none if nothing bends it, or some of it stands apart from its joints.
///
/// # Errors
/// As [`super::bend`].
pub(in crate::usd) fn rig(
    reader: &mut Reader,
    view: &PrimView,
    inherited: &Inherited,
    points: usize,
) -> Result<Option<PointRig>> {
    let binds = |bound| inherited.by(bound).is_some();
    let is_skinned = binds(Bound::Indices) && binds(Bound::Weights) && binds(Bound::Skeleton);
    let has_shapes = binds(Bound::BlendShapes) && binds(Bound::BlendShapeTargets);
    if !inherited.is_rooted || !(is_skinned || has_shapes && (binds(Bound::Skeleton) || binds(Bound::Animation))) {
        return Ok(None);
    }
    let bones = target(reader, inherited, Bound::Skeleton)?;
    let skeleton = match &bones {
        Some(bones) => skeleton::posed(reader, bones, inherited)?,
        None => skeleton::alone(reader, inherited)?,
    };
    let mut out = PointRig {
        shapes: if has_shapes { blend_shape::whole(reader, inherited, &skeleton, points)? } else { Vec::new() },
        joints: Vec::new(),
        binds: Vec::new(),
        places: Vec::new(),
        weighed: Vec::new(),
    };
    let Some(bones) = bones.filter(|_| is_skinned) else { return Ok((!out.shapes.is_empty()).then_some(out)) };
    let own = world(reader, view)?;
    if skeleton.worlds.is_empty() || is_singular(own) {
        return Ok(None);
    }
    let to_own = own.inverse() * world(reader, &bones)?;
    let Some(influences) = Influences::read(reader, view, inherited, &skeleton, points)? else { return Ok(None) };
    reader.charge(view.path(), points, 64)?;
    for point in 0..points {
        let mut own: Vec<(u32, f64)> = Vec::new();
        for (joint, weight) in influences.of(point).filter(|(_, weight)| *weight > 0.0) {
            match own.iter_mut().find(|(known, _)| *known as usize == joint) {
                Some((_, sum)) => *sum += weight,
                None => own.push((joint as u32, weight)),
            }
        }
        if own.is_empty() {
            return Ok(None);
        }
        out.weighed.push(own);
    }
    for (index, name) in skeleton.joints.iter().enumerate() {
        let parent = skeleton::parent(&bones, &skeleton, index)?;
        let name = name.rsplit('/').next().unwrap_or(name).to_owned();
        out.joints.push(Joint { name, parent, node: None });
    }
    out.binds = skeleton.binds.iter().map(|bind| bind.inverse() * influences.geom_bind).collect();
    out.places = skeleton.worlds.iter().map(|world| to_own * *world).collect();
    Ok(Some(out))
}

impl PointRig {
    /// The same of vertices: `sources` are their points.
    pub fn of_vertices(self, rest: Vertices, sources: &[u32]) -> Rig {
        let pick = |all: &[DVec3]| -> Vec<[f32; 3]> {
            let of = |point: &u32| all.get(*point as usize).copied().unwrap_or_default();
            sources.iter().map(|point| of(point).to_array().map(|x| x as f32)).collect()
        };
        let targets = self.shapes.iter().map(|shape| Target {
            name: shape.name.clone(),
            by: Vertices { positions: pick(&shape.points), normals: pick(&shape.normals) },
        });
        let skin = (!self.joints.is_empty()).then(|| {
            let of = |point: &u32| self.weighed.get(*point as usize).cloned().unwrap_or_default();
            let all: Vec<Vec<(u32, f64)>> = sources.iter().map(of).collect();
            Skin::new(self.joints, self.binds, &all)
        });
        let pose = Pose { weights: self.shapes.iter().map(|shape| shape.weight).collect(), joints: self.places };
        Rig { rest, targets: targets.collect(), skin, pose }
    }
}
