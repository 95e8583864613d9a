//! Rigs as UsdSkel: one Skeleton for all meshes that the same joints bend, with its SkelAnimation below it; blend shapes below
//! their meshes. The default prim is the SkelRoot, and joints are written in its axes, which are the asset's world.

use super::super::tracks::{self, SCALE, TRANSLATION, Vector};
use super::layer::{Datum, Prim, Property};
use super::name::Siblings;
use super::samples::sampled;
use super::stage::{Writing, rows};
use super::text::half;
use eyebox_scene::assembly::Assembly;
use eyebox_scene::motion::{Joint, Motion, Parts, Rig, is_alike, locals, parts};
use glam::DAffine3;
use std::collections::HashMap;

/// The Skeletons of the layer, and which nodes' meshes they bend.
#[derive(Debug, Default)]
pub(super) struct Skeletons {
    all: Vec<Skeleton>,
    pub bound: HashMap<usize, Bound>,
}

#[derive(Debug)]
struct Skeleton {
    /// Of its prim.
    name: String,
    path: String,
    /// Joints as the skin has them; the layer has them in this order, parents first.
    joints: Vec<Joint>,
    order: Vec<usize>,
    /// By joint of the skin.
    tokens: Vec<String>,
    /// Joint → world when meshes were bound.
    binds: Vec<DAffine3>,
    /// Joint → world, at rest and at each frame.
    worlds: Vec<Vec<DAffine3>>,
    /// Blend shapes with their weights, at rest and at each frame.
    shapes: Vec<(String, Vec<f64>)>,
}

/// A mesh on a Skeleton.
#[derive(Debug)]
pub(super) struct Bound {
    skeleton: usize,
    /// Mesh → world when it was bound.
    geom_bind: DAffine3,
    /// The names of its blend shapes: prims, and in the animation.
    shapes: Vec<(String, String)>,
}

impl Skeletons {
    /// Finds out which Skeletons there must be below the default prim at `root`.
    pub fn of(assembly: &Assembly, root: &str, siblings: &mut Siblings) -> Skeletons {
        let mut out = Skeletons::default();
        for (index, node) in assembly.nodes.iter().enumerate() {
            let Some(mesh) = node.mesh else { continue };
            let Some(rig) = assembly.meshes.get(mesh).and_then(|source| source.rig.as_ref()) else { continue };
            let (joints, binds, worlds) = match assembly.joints(index) {
                Some((skin, worlds)) => {
                    (skin.joints.clone(), skin.binds.iter().map(DAffine3::inverse).collect(), worlds)
                }
                // Blend shapes need a Skeleton, too; one joint makes it one.
                None => (vec![Joint { name: "root".into(), ..Joint::default() }], vec![DAffine3::IDENTITY], Vec::new()),
            };
            let known = out.all.iter().enumerate().find_map(|(number, known)| {
                Some((number, known.bind(&joints, &binds, &worlds).filter(|_| rig.skin.is_some())?))
            });
            let (skeleton, geom_bind) = known.unwrap_or_else(|| {
                let name = siblings.name("Skeleton", "Skeleton");
                let path = format!("{root}/{name}");
                let (order, tokens) = tokens(&joints);
                out.all.push(Skeleton { name, path, joints, order, tokens, binds, worlds, shapes: Vec::new() });
                (out.all.len() - 1, DAffine3::IDENTITY)
            });
            let poses = assembly.motion.as_ref().and_then(|motion| motion.of_rig(mesh)).map(|rig| &rig.poses);
            let mut prims = Siblings::default();
            let mut shapes = Vec::new();
            for (number, target) in rig.targets.iter().enumerate() {
                let weight = |pose: &eyebox_scene::motion::Pose| pose.weights.get(number).copied().unwrap_or(0.0);
                let still = std::iter::once(&rig.pose);
                let weights: Vec<f64> = still.chain(poses.into_iter().flatten()).map(weight).collect();
                let name = prims.name(&target.name, "Shape");
                let said = out.all.get_mut(skeleton).map(|own| own.shape(&name, weights)).unwrap_or_default();
                shapes.push((name, said));
            }
            out.bound.insert(index, Bound { skeleton, geom_bind, shapes });
        }
        out
    }
}

impl Skeleton {
    /// Mesh → world when it was bound to these joints, if they are this one's and there is one such place for all of them.
    fn bind(&self, joints: &[Joint], binds: &[DAffine3], worlds: &[Vec<DAffine3>]) -> Option<DAffine3> {
        let alike = self.joints == joints
            && self.worlds.len() == worlds.len()
            && self.worlds.iter().flatten().zip(worlds.iter().flatten()).all(|(a, b)| is_alike(a, b));
        if !alike {
            return None;
        }
        // bind⁻¹ of the mesh is joint⁻¹ · geometry.
        let mut places = self.binds.iter().zip(binds).map(|(own, other)| *own * other.inverse());
        let first = places.next()?;
        places.all(|place| is_alike(&first, &place)).then_some(first)
    }

    /// The name of a blend shape in the animation: meshes whose weights are the same share it.
    fn shape(&mut self, name: &str, weights: Vec<f64>) -> String {
        let (mut own, mut number) = (name.to_owned(), 1);
        loop {
            match self.shapes.iter().find(|(known, _)| *known == own) {
                Some((_, known)) if *known == weights => return own,
                Some(_) => {
                    own = format!("{name}_{number}");
                    number += 1;
                }
                None => {
                    self.shapes.push((own.clone(), weights));
                    return own;
                }
            }
        }
    }
}

/// The joints' paths, and an order with parents first.
fn tokens(joints: &[Joint]) -> (Vec<usize>, Vec<String>) {
    let mut tokens = vec![String::new(); joints.len()];
    let mut order: Vec<usize> = Vec::with_capacity(joints.len());
    let mut names: HashMap<Option<usize>, Siblings> = HashMap::new();
    let mut is_done = vec![false; joints.len()];
    // Each round takes those whose parents are taken; joints that are above each other are none.
    loop {
        let before = order.len();
        for (index, joint) in joints.iter().enumerate() {
            let parent = joint.parent.filter(|parent| *parent != index && *parent < joints.len());
            if is_done[index] || parent.is_some_and(|parent| !is_done[parent]) {
                continue;
            }
            let name = names.entry(parent).or_default().name(&joint.name, "joint");
            tokens[index] = parent.map_or_else(|| name.clone(), |parent| format!("{}/{name}", tokens[parent]));
            is_done[index] = true;
            order.push(index);
        }
        if order.len() == before {
            return (order, tokens);
        }
    }
}

/// The path of a prim at `depth` that is written next.
pub(super) fn path_below(prims: &[Prim], depth: usize) -> String {
    let (mut names, mut wanted) = (Vec::new(), depth);
    for prim in prims.iter().rev() {
        if wanted > 0 && prim.depth == wanted - 1 {
            names.push(prim.name.as_str());
            wanted -= 1;
        }
    }
    names.iter().rev().map(|name| format!("/{name}")).collect()
}

/// What a mesh says of its joints and blend shapes; `path` is its own.
pub(super) fn bind(writing: &Writing<'_>, (rig, bound): (&Rig, &Bound), path: &str, prim: &mut Prim) {
    let Some(skeleton) = writing.skeletons.all.get(bound.skeleton) else { return };
    prim.apply("SkelBindingAPI");
    prim.push(Property::relationship("skel:skeleton", vec![skeleton.path.clone()]));
    if let Some(skin) = &rig.skin {
        let mut place = vec![0_i32; skeleton.joints.len()];
        for (new, old) in skeleton.order.iter().enumerate() {
            place[*old] = i32::try_from(new).unwrap_or(0);
        }
        let indices =
            skin.influences.iter().map(|(joint, _)| place.get(*joint as usize).copied().unwrap_or(0)).collect();
        let weights = skin.influences.iter().map(|(_, weight)| *weight).collect();
        for (name, list) in [("Indices", Datum::Ints(indices)), ("Weights", Datum::Floats(weights))] {
            prim.push(Property::new(format!("primvars:skel:joint{name}"), list).per("vertex").each(skin.each));
        }
        let place = Datum::Matrix(rows(bound.geom_bind));
        prim.push(Property::new("primvars:skel:geomBindTransform", place));
    }
    if !bound.shapes.is_empty() {
        let names = bound.shapes.iter().map(|(_, said)| said.clone()).collect();
        prim.push(Property::new("skel:blendShapes", Datum::Tokens(names)).uniform());
        let targets = bound.shapes.iter().map(|(name, _)| format!("{path}/{name}")).collect();
        prim.push(Property::relationship("skel:blendShapeTargets", targets));
    }
}

/// The blend shapes of a mesh, below it.
pub(super) fn blend_shapes(rig: &Rig, bound: &Bound, depth: usize, prims: &mut Vec<Prim>) {
    for (target, (name, _)) in rig.targets.iter().zip(&bound.shapes) {
        let mut prim = Prim::def(depth, "BlendShape", name.clone());
        for (name, list) in [("offsets", &target.by.positions), ("normalOffsets", &target.by.normals)] {
            prim.push(Property::new(name, Datum::Float3s(list.clone())).typed("vector3f[]").uniform());
        }
        prims.push(prim);
    }
}

/// The Skeletons with their animations, below the default prim.
pub(super) fn write(writing: &Writing<'_>, prims: &mut Vec<Prim>) {
    for skeleton in &writing.skeletons.all {
        let mut prim = Prim::def(1, "Skeleton", skeleton.name.clone());
        prim.marks.push(("part", Datum::Bool(true)));
        let tokens = |prim: &mut Prim| {
            let names = skeleton.order.iter().filter_map(|joint| skeleton.tokens.get(*joint).cloned()).collect();
            prim.push(Property::new("joints", Datum::Tokens(names)).uniform());
        };
        tokens(&mut prim);
        let in_order = |of: &dyn Fn(usize) -> DAffine3| {
            Datum::Matrices(skeleton.order.iter().map(|joint| rows(of(*joint))).collect())
        };
        let local = |joint: usize| match skeleton.worlds.is_empty() {
            true => vec![DAffine3::IDENTITY],
            false => locals(&skeleton.joints, joint, &skeleton.worlds),
        };
        let locals: Vec<Vec<DAffine3>> = (0..skeleton.joints.len()).map(local).collect();
        let bind = in_order(&|joint| skeleton.binds.get(joint).copied().unwrap_or_default());
        prim.push(Property::new("bindTransforms", bind).uniform());
        let rest = in_order(&|joint| locals.get(joint).and_then(|all| all.first()).copied().unwrap_or_default());
        prim.push(Property::new("restTransforms", rest).uniform());
        let moves = skeleton.worlds.len() > 1;
        if !moves && skeleton.shapes.is_empty() {
            prims.push(prim);
            continue;
        }
        prim.apply("SkelBindingAPI");
        prim.push(Property::relationship("skel:animationSource", vec![format!("{}/Animation", skeleton.path)]));
        prims.push(prim);
        let mut animation = Prim::def(2, "SkelAnimation", "Animation");
        if moves && !skeleton.worlds.iter().all(|all| all == &skeleton.worlds[0]) {
            tokens(&mut animation);
            let poses: Option<Vec<Vec<Parts>>> =
                skeleton.order.iter().map(|joint| parts(locals.get(*joint)?)).collect();
            // Sheared joints have no rig: see `import::moving`.
            if let (Some(poses), Some(motion)) = (poses, &writing.assembly.motion) {
                joints(motion, &poses, &mut animation);
            }
        }
        if !skeleton.shapes.is_empty() {
            shapes(writing.assembly.motion.as_ref(), &skeleton.shapes, &mut animation);
        }
        prims.push(animation);
    }
}

/// Translations, rotations and scales of the joints: `poses` by joint, at rest and then at each frame.
fn joints(motion: &Motion, poses: &[Vec<Parts>], prim: &mut Prim) {
    let frames: Vec<&[Parts]> = poses.iter().filter_map(|joint| joint.get(1..)).collect();
    let three = |of: Vector, moment: usize| -> Vec<[f32; 3]> {
        poses.iter().filter_map(|joint| Some(of(joint.get(moment)?).to_array().map(|x| x as f32))).collect()
    };
    let quats = |moment: usize| -> Datum {
        let single = |q: glam::DQuat| [q.w, q.x, q.y, q.z].map(|x| x as f32);
        Datum::Quats(poses.iter().filter_map(|joint| Some(single(joint.get(moment)?.rotation))).collect())
    };
    let shifts = tracks::of_vectors(motion, &frames, TRANSLATION);
    let shifts = sampled(motion, &shifts, |at| Datum::Float3s(three(TRANSLATION, at + 1)));
    prim.push(Property::new("translations", Datum::Float3s(three(TRANSLATION, 0))).sampled(shifts));
    let turns = sampled(motion, &tracks::of_turns(motion, &frames), |at| quats(at + 1));
    prim.push(Property::new("rotations", quats(0)).sampled(turns));
    let kept = tracks::of_vectors(motion, &frames, SCALE);
    let sizes = sampled(motion, &kept, |at| Datum::Half3s(three(SCALE, at + 1)));
    prim.push(Property::new("scales", Datum::Half3s(three(SCALE, 0))).sampled(sizes));
    let lost = |parts: &Parts| parts.scale.to_array().into_iter().any(|x| half(x as f32) != x as f32);
    if poses.iter().flatten().any(lost) {
        // What half precision loses, for our own reader.
        let sizes = sampled(motion, &kept, |at| Datum::Float3s(three(SCALE, at + 1)));
        let exact = Property::new("eyebox:scales", Datum::Float3s(three(SCALE, 0))).sampled(sizes);
        prim.push(Property { custom: true, ..exact });
    }
}

/// Blend shapes with their weights, at rest and then at each frame.
fn shapes(motion: Option<&Motion>, all: &[(String, Vec<f64>)], prim: &mut Prim) {
    let at = |moment: usize| -> Vec<f64> {
        all.iter().map(|(_, weights)| weights.get(moment).or(weights.first()).copied().unwrap_or(0.0)).collect()
    };
    let single = |all: Vec<f64>| Datum::Floats(all.into_iter().map(|x| x as f32).collect());
    let names = all.iter().map(|(name, _)| name.clone()).collect();
    prim.push(Property::new("blendShapes", Datum::Tokens(names)).uniform());
    let still = Property::new("blendShapeWeights", single(at(0)));
    let moves = all.iter().any(|(_, weights)| weights.iter().any(|weight| Some(weight) != weights.first()));
    let Some(motion) = motion.filter(|_| moves) else { return prim.push(still) };
    let frames: Vec<Vec<f64>> = (0..motion.frames.len()).map(|frame| at(frame + 1)).collect();
    let kept = tracks::of_numbers(motion, &frames);
    prim.push(still.sampled(sampled(motion, &kept, |frame| single(at(frame + 1)))));
}
