//! The vertices that a rig makes of those at rest, at its own pose.

use crate::gltf::normals::unit;
use crate::skinning::{self, Blend};
use eyebox_scene::motion::{Rig, Vertices};
use glam::{DAffine3, DVec3};

/// None where joints turn most of the mesh inside out: its triangles say so, and a rig says nothing of them.
pub(super) fn vertices(rig: &Rig) -> Option<Vertices> {
    let wide = |all: &[[f32; 3]]| -> Vec<DVec3> { all.iter().map(|v| DVec3::from(v.map(f64::from))).collect() };
    let (mut positions, mut normals) = (wide(&rig.rest.positions), wide(&rig.rest.normals));
    for (target, weight) in rig.targets.iter().zip(&rig.pose.weights) {
        for (all, by) in [(&mut positions, &target.by.positions), (&mut normals, &target.by.normals)] {
            for (own, by) in all.iter_mut().zip(by) {
                *own += DVec3::from(by.map(f64::from)) * *weight;
            }
        }
    }
    let mut mirrored = 0usize;
    if let Some(skin) = &rig.skin {
        let joints: Vec<DAffine3> =
            rig.pose.joints.iter().zip(&skin.binds).map(|(joint, bind)| *joint * *bind).collect();
        let each = skin.each.max(1);
        for (vertex, own) in skin.influences.chunks(each).enumerate() {
            let mut blend = Blend::default();
            for (joint, weight) in own.iter().filter(|(_, weight)| *weight > 0.0) {
                if let Some(matrix) = joints.get(*joint as usize) {
                    blend.add(matrix, f64::from(*weight));
                }
            }
            let Some(mean) = blend.mean() else { continue };
            mirrored += usize::from(mean.matrix3.determinant() < 0.0);
            if let Some(position) = positions.get_mut(vertex) {
                *position = mean.transform_point3(*position);
            }
            if let Some(normal) = normals.get_mut(vertex) {
                *normal = skinning::normal(&mean.matrix3, *normal);
            }
        }
    }
    let positions: Vec<[f32; 3]> = positions.iter().map(|p| p.to_array().map(|x| x as f32)).collect();
    let is_sound = 2 * mirrored <= positions.len() && positions.as_flattened().iter().all(|x| x.is_finite());
    let normals = normals.into_iter().zip(&rig.rest.normals).map(|(bent, rest)| unit(bent).unwrap_or(*rest)).collect();
    is_sound.then_some(Vertices { positions, normals })
}
