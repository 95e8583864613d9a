//! How an assembly moves: where its nodes stand and how its meshes are bent at each of some frames. Readers say what bends a
//! mesh ([`Rig`]); everything else is what they read at one frame after the other.

use super::assembly::{Assembly, Node};
use glam::{DAffine3, DMat3, DQuat, DVec3};

/// When something happens in an asset, as its reader finds it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Clock {
    /// Frames (USD: time codes) a second.
    pub rate: f64,
    /// Of glTF's animation.
    pub name: String,
    /// Frames at which a value is written, increasing. Between two of them nothing jumps.
    pub keys: Vec<f64>,
}

/// What moves. Each list has a value for each of `frames`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Motion {
    pub rate: f64,
    pub name: String,
    pub frames: Vec<f64>,
    pub nodes: Vec<NodeMotion>,
    pub meshes: Vec<MeshMotion>,
    pub rigs: Vec<RigMotion>,
}

/// A node that moves in its parent.
#[derive(Debug, Clone, PartialEq)]
pub struct NodeMotion {
    /// An index of `Assembly::nodes`.
    pub node: usize,
    /// Node → parent.
    pub locals: Vec<DAffine3>,
}

/// A mesh whose vertices move by nothing but what is written for them.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshMotion {
    /// An index of `Assembly::meshes`.
    pub mesh: usize,
    pub shapes: Vec<Vertices>,
}

/// The vertices of a mesh, in its units.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Vertices {
    pub positions: Vec<[f32; 3]>,
    pub normals: Vec<[f32; 3]>,
}

/// How the rig of a mesh moves.
#[derive(Debug, Clone, PartialEq)]
pub struct RigMotion {
    /// An index of `Assembly::meshes`.
    pub mesh: usize,
    pub poses: Vec<Pose>,
}

/// A rig at a moment.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Pose {
    /// Of the targets.
    pub weights: Vec<f64>,
    /// Joint → the axes of the node that has the mesh.
    pub joints: Vec<DAffine3>,
}

/// What bends a mesh: v = Σⱼ wⱼ · jointⱼ · bindⱼ · (rest + Σₜ weightₜ · targetₜ), linear blend skinning after morph targets (glTF
/// 2.0, sections 3.7.2.2 and 3.7.3; UsdSkel).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Rig {
    /// The mesh as nothing bends it.
    pub rest: Vertices,
    pub targets: Vec<Target>,
    pub skin: Option<Skin>,
    pub pose: Pose,
}

/// Differences of vertices.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Target {
    pub name: String,
    pub by: Vertices,
}

/// Joints, and how much each of them moves each vertex.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Skin {
    pub joints: Vec<Joint>,
    /// Mesh at rest → joint.
    pub binds: Vec<DAffine3>,
    /// Joint and weight, `each` of them a vertex; they add up to 1, no joint counts twice.
    pub influences: Vec<(u32, f32)>,
    pub each: usize,
}

#[derive(Debug, Clone, Default, PartialEq)]
pub struct Joint {
    pub name: String,
    /// Among the joints.
    pub parent: Option<usize>,
    /// The node of the assembly that it is, if it is one.
    pub node: Option<usize>,
}

impl Rig {
    /// Whether it says no more than where its joints stand and what its weights are.
    pub fn is_pose(&self) -> bool {
        self.rest.positions.is_empty()
    }
}

impl Skin {
    /// The influences of each vertex, brought to the sum 1; `each` becomes the largest number of them.
    pub fn new(joints: Vec<Joint>, binds: Vec<DAffine3>, all: &[Vec<(u32, f64)>]) -> Skin {
        let each = all.iter().map(Vec::len).max().unwrap_or(0).max(1);
        let mut influences = Vec::with_capacity(all.len() * each);
        for own in all {
            let sum: f64 = own.iter().map(|(_, weight)| weight).sum();
            let scaled = own.iter().map(|(joint, weight)| (*joint, (weight / sum) as f32));
            influences.extend(scaled.chain(std::iter::repeat((0, 0.0))).take(each));
        }
        Skin { joints, binds, influences, each }
    }
}

/// A transform in parts: scaled, then turned, then shifted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parts {
    pub translation: DVec3,
    pub rotation: DQuat,
    pub scale: DVec3,
}

impl Parts {
    pub fn affine(&self) -> DAffine3 {
        DAffine3::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
    }
    /// Between two of them: numbers one by one, rotations evenly along the shorter way, as glTF's LINEAR and USD do.
    pub fn mix(&self, other: &Parts, share: f64) -> Parts {
        Parts {
            translation: self.translation.lerp(other.translation, share),
            rotation: self.rotation.slerp(other.rotation, share),
            scale: self.scale.lerp(other.scale, share),
        }
    }
}

/// A matrix with a shear beyond this share of its largest entry is no product of scale, rotation and translation: more than the
/// products of single precision leave.
const SHEAR: f64 = 1e-5;

/// Each of `all` in parts, signs of rotations from one to the next so that neighbours are near; none if one is sheared.
/// A rotation that a scale of 0 hides is that of the nearest moment before, else after.
pub fn parts(all: &[DAffine3]) -> Option<Vec<Parts>> {
    let turns: Vec<Option<DQuat>> = all.iter().map(turn).collect();
    let first = turns.iter().flatten().next().copied().unwrap_or(DQuat::IDENTITY);
    let mut last = first;
    let mut out = Vec::with_capacity(all.len());
    for (affine, turn) in all.iter().zip(turns) {
        let near = turn.unwrap_or(last);
        last = if near.dot(last) < 0.0 { -near } else { near };
        let axes = DMat3::from_quat(last);
        let m = affine.matrix3;
        let scale = DVec3::new(axes.x_axis.dot(m.x_axis), axes.y_axis.dot(m.y_axis), axes.z_axis.dot(m.z_axis));
        let own = Parts { translation: affine.translation, rotation: last, scale };
        let found = own.affine().matrix3.to_cols_array();
        let largest = m.to_cols_array().into_iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let near = |(a, b): (&f64, f64)| (a - b).abs() <= SHEAR * largest;
        if !found.iter().zip(m.to_cols_array()).all(near) {
            return None;
        }
        out.push(own);
    }
    Some(out)
}

/// The rotation of a transform that has one; x is turned round where it mirrors.
fn turn(affine: &DAffine3) -> Option<DQuat> {
    let m = affine.matrix3;
    let lengths = DVec3::new(m.x_axis.length(), m.y_axis.length(), m.z_axis.length());
    let axes = DMat3::from_cols(m.x_axis / lengths.x, m.y_axis / lengths.y, m.z_axis / lengths.z);
    let side = axes.determinant();
    if !side.is_finite() || side.abs() < 0.5 {
        return None;
    }
    let axes = DMat3::from_cols(axes.x_axis * side.signum(), axes.y_axis, axes.z_axis);
    Some(DQuat::from_mat3(&axes).normalize())
}

/// Values between two that are written: to look at all of more than that takes long, and would save little.
const LONGEST: usize = 240;

/// The indices of the values that must be written so that all others lie on the way between their neighbours: `fits(from, at, to)`
/// says whether the value `at` does. The first and the last one are always among them, but for values that are all the same.
pub fn kept(count: usize, fits: impl Fn(usize, usize, usize) -> bool) -> Vec<usize> {
    if count == 0 {
        return Vec::new();
    }
    if count > 2 && (1..count - 1).all(|at| fits(0, at, count - 1)) {
        return vec![0, count - 1];
    }
    let mut out = vec![0];
    let mut from = 0;
    while from + 1 < count {
        let mut to = from + 1;
        // Only as far as all of those in between fit.
        while to + 1 < count && to - from < LONGEST && (from + 1..=to).all(|at| fits(from, at, to + 1)) {
            to += 1;
        }
        out.push(to);
        from = to;
    }
    out
}

impl Motion {
    /// Where nodes stand at frame number `at`: node → asset world.
    pub fn worlds(&self, nodes: &[Node], at: usize) -> Vec<DAffine3> {
        let mut locals: Vec<DAffine3> = nodes.iter().map(|node| node.local).collect();
        for own in &self.nodes {
            if let (Some(slot), Some(local)) = (locals.get_mut(own.node), own.locals.get(at)) {
                *slot = *local;
            }
        }
        let mut out: Vec<DAffine3> = Vec::with_capacity(nodes.len());
        for (node, local) in nodes.iter().zip(locals) {
            let above = node.parent.and_then(|parent| out.get(parent)).copied().unwrap_or(DAffine3::IDENTITY);
            out.push(above * local);
        }
        out
    }
    pub fn of_node(&self, node: usize) -> Option<&NodeMotion> {
        self.nodes.iter().find(|own| own.node == node)
    }
    pub fn of_mesh(&self, mesh: usize) -> Option<&MeshMotion> {
        self.meshes.iter().find(|own| own.mesh == mesh)
    }
    pub fn of_rig(&self, mesh: usize) -> Option<&RigMotion> {
        self.rigs.iter().find(|own| own.mesh == mesh)
    }
    /// How far frame number `at` is on the way from `from` to `to`.
    pub fn share(&self, from: usize, at: usize, to: usize) -> f64 {
        let frame = |i: usize| self.frames.get(i).copied().unwrap_or(0.0);
        let share = (frame(at) - frame(from)) / (frame(to) - frame(from));
        if share.is_finite() { share } else { 0.0 }
    }
}

/// Joint number `joint` in its parent, of joints in the world as [`Assembly::joints`] gives them.
pub fn locals(joints: &[Joint], joint: usize, worlds: &[Vec<DAffine3>]) -> Vec<DAffine3> {
    let parent = joints.get(joint).and_then(|joint| joint.parent);
    let local = |all: &Vec<DAffine3>| {
        let own = all.get(joint).copied().unwrap_or_default();
        parent.and_then(|parent| all.get(parent)).map_or(own, |parent| parent.inverse() * own)
    };
    worlds.iter().map(local).collect()
}

/// Whether only rounding tells two transforms apart.
pub fn is_alike(a: &DAffine3, b: &DAffine3) -> bool {
    let (a, b) = (a.to_cols_array(), b.to_cols_array());
    let most = a.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-9 * most)
}

impl Assembly {
    /// The skin of a node's mesh, and its joints in the asset's world: as they stand without a frame, then at each frame.
    pub fn joints(&self, node: usize) -> Option<(&Skin, Vec<Vec<DAffine3>>)> {
        let own = self.nodes.get(node)?;
        let mesh = own.mesh?;
        let rig = self.meshes.get(mesh)?.rig.as_ref()?;
        let skin = rig.skin.as_ref()?;
        let placed = |world: DAffine3, pose: &Pose| pose.joints.iter().map(|joint| world * *joint).collect();
        let mut out: Vec<Vec<DAffine3>> = vec![placed(own.to_world, &rig.pose)];
        if let Some(motion) = &self.motion {
            let poses = motion.of_rig(mesh).map(|rig| &rig.poses);
            for frame in 0..motion.frames.len() {
                let world = motion.worlds(&self.nodes, frame).get(node).copied().unwrap_or_default();
                out.push(placed(world, poses.and_then(|poses| poses.get(frame)).unwrap_or(&rig.pose)));
            }
        }
        Some((skin, out))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_make_the_transform_again() {
        let turn = DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -1.2, 2.0);
        let shift = DVec3::new(1.0, -2.0, 3.0);
        for scale in [DVec3::ONE, DVec3::new(2.0, 0.5, 1.0), DVec3::new(1.0, 1.0, -1.0), DVec3::splat(-3.0)] {
            let all = [DAffine3::from_scale_rotation_translation(scale, turn, shift)];
            let found = parts(&all).unwrap();
            assert!(found[0].affine().abs_diff_eq(all[0], 1e-14), "{scale}");
        }
        let sheared = DAffine3::from_scale(DVec3::new(1.0, 2.0, 1.0)) * DAffine3::from_quat(turn);
        assert!(parts(&[sheared]).is_none());
    }

    #[test]
    fn what_a_scale_of_0_hides_is_what_was_before() {
        let turn = DQuat::from_rotation_y(1.0);
        let of = |scale: f64| DAffine3::from_scale_rotation_translation(DVec3::splat(scale), turn, DVec3::X);
        let found = parts(&[of(0.0), of(1.0), of(0.0)]).unwrap();
        assert!(found.iter().all(|own| own.rotation.angle_between(turn) < 1e-7));
        assert_eq!([found[0].scale, found[2].scale], [DVec3::ZERO; 2]);
    }

    #[test]
    fn only_corners_are_kept() {
        let values = [0.0, 1.0, 2.0, 3.0, 2.0, 1.0, 1.0, 1.0_f64];
        let fits = |from: usize, at: usize, to: usize| {
            let share = (at - from) as f64 / (to - from) as f64;
            (values[from] * (1.0 - share) + values[to] * share - values[at]).abs() < 1e-12
        };
        assert_eq!(kept(values.len(), fits), [0, 3, 5, 7]);
        assert_eq!(kept(1, fits), [0]);
    }
}
