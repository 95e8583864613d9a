//! How an asset moves: it is read at one frame after the other, and what differs is what moves. So a format's reader need not
//! tell what a joint, a spline or a blend shape does to a part, and what is written is what a picture of that frame shows.

use super::{Assembly, ReadOptions, Rigs, Value, read};
use crate::base::Where;
use crate::base::error::Result;
use crate::scene::Note;
use crate::scene::assembly::{Camera, LightSource, MeshSource};
use crate::scene::motion::{self, MeshMotion, Motion, NodeMotion, Pose, RigMotion, Vertices};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// More frames than that are a film, not a motion of an assembly: memory is for each of them.
const MOST_FRAMES: usize = 4096;

/// The assembly that `path` means and its sidecar, as [`read`], with what moves between the first and the last key of its time:
/// at each key and at each whole frame. At the moment that a frame of `options` names, nothing moves.
///
/// # Errors
/// As [`read`], at any of the frames.
pub fn moving(path: &Path, options: &ReadOptions) -> Result<(Assembly, Option<(PathBuf, Value)>)> {
    if options.frame.is_some() {
        return read(path, options);
    }
    let options = ReadOptions { rigs: Rigs::Whole, ..options.clone() };
    let (mut assembly, sidecar) = read(path, &options)?;
    let clock = assembly.clock.clone().unwrap_or_default();
    let frames = frames(&mut assembly, &clock.keys);
    let mut found = Found::default();
    for (number, frame) in frames.iter().enumerate() {
        let (now, _) = read(path, &ReadOptions { frame: Some(*frame), rigs: Rigs::Poses, ..options.clone() })?;
        found.compare(&assembly, now, number);
    }
    let motion = Motion { rate: clock.rate, name: clock.name, frames, ..Motion::default() };
    found.finish(&mut assembly, motion);
    Ok((assembly, sidecar))
}

/// The keys and the whole frames between them, as far as memory goes.
fn frames(assembly: &mut Assembly, keys: &[f64]) -> Vec<f64> {
    let (Some(first), Some(last)) = (keys.first().copied(), keys.last().copied()) else { return Vec::new() };
    let mut out = keys.to_vec();
    let whole = (last.floor() - first.ceil() + 1.0).max(0.0);
    if whole <= MOST_FRAMES as f64 {
        out.extend((0..whole as usize).map(|number| first.ceil() + number as f64));
        out.sort_by(f64::total_cmp);
        out.dedup();
    } else {
        let text = "so many frames that only those with values of their own are written";
        assembly.notes.push(Note::warning(Where::file(&assembly.file), text));
    }
    if out.len() > MOST_FRAMES {
        let text = format!("{} frames: only the first {MOST_FRAMES} are written", out.len());
        assembly.notes.push(Note::warning(Where::file(&assembly.file), text));
        out.truncate(MOST_FRAMES);
    }
    out
}

/// What differed so far. Each list starts with the frame at which its thing was first seen to move, with what it was before.
#[derive(Default)]
struct Found {
    nodes: BTreeMap<usize, Vec<glam::DAffine3>>,
    meshes: BTreeMap<usize, Vec<Vertices>>,
    rigs: BTreeMap<usize, Vec<Pose>>,
    /// Meshes whose rig does not say all of it.
    broken: Vec<usize>,
    /// What changes and is not carried, each once.
    left: Vec<(Where, String)>,
}

impl Found {
    fn leave(&mut self, at: &Where, text: String) {
        if !self.left.iter().any(|(_, known)| *known == text) {
            self.left.push((at.clone(), text));
        }
    }

    /// Frame number `number`: `now`, of what is written as `still`.
    fn compare(&mut self, still: &Assembly, now: Assembly, number: usize) {
        let file = Where::file(&still.file);
        let same_nodes = still.nodes.len() == now.nodes.len()
            && still.nodes.iter().zip(&now.nodes).all(|(a, b)| a.at == b.at && a.parent == b.parent);
        if !same_nodes {
            let text =
                "parts appear or vanish: they stay as they are without a frame, and nothing moves at those frames";
            self.leave(&file, text.to_owned());
            return self.hold(still, number);
        }
        for (index, (was, is)) in still.nodes.iter().zip(&now.nodes).enumerate() {
            let same = was.local == is.local;
            follow(&mut self.nodes, index, number, same, || was.local, || is.local);
            if was.mesh != is.mesh {
                self.leave(&was.at, "a part that is another mesh at times: it keeps its own".to_owned());
            }
        }
        for (was, is) in still.lights.iter().zip(&now.lights).filter(|(was, is)| !is_same_light(was, is)) {
            self.leave(&is.at, format!("light `{}` changes in time: it is written as it is without a frame", was.name));
        }
        for (was, _) in still.cameras.iter().zip(&now.cameras).filter(|(was, is)| !is_same_camera(was, is)) {
            let at = was.node.and_then(|node| still.nodes.get(node)).map_or(&file, |node| &node.at);
            self.leave(at, format!("the lens of camera `{}` changes in time: only its place moves", was.name));
        }
        for (was, is) in still.materials.iter().zip(&now.materials) {
            let (a, b) = (was.surface.as_deref(), is.surface.as_deref());
            if format!("{a:?}{:?}", was.mapped.iter().map(|(key, value)| (key, &value.data)).collect::<Vec<_>>())
                != format!("{b:?}{:?}", is.mapped.iter().map(|(key, value)| (key, &value.data)).collect::<Vec<_>>())
            {
                self.leave(
                    &is.at,
                    format!("material `{}` changes in time: it is written as it is without a frame", was.name),
                );
            }
        }
        if still.meshes.len() != now.meshes.len() {
            let text = "meshes appear or vanish: they keep their shapes at those frames";
            self.leave(&file, text.to_owned());
            return self.hold(still, number);
        }
        for (index, (was, is)) in still.meshes.iter().zip(now.meshes).enumerate() {
            self.mesh(index, was, is, number);
        }
    }

    fn mesh(&mut self, index: usize, was: &MeshSource, is: MeshSource, number: usize) {
        let (a, b) = (&was.mesh, &is.mesh);
        if a.triangles != b.triangles || a.positions.len() != b.positions.len() || a.normals.len() != b.normals.len() {
            self.leave(&was.at, format!("mesh `{}` has other triangles at times: it keeps its own", a.name));
            let still = || vertices(was);
            return follow(&mut self.meshes, index, number, true, still, still);
        }
        if a.uvs != b.uvs || a.second_uvs != b.second_uvs || a.colors != b.colors {
            let text = format!("texture coordinates or colours of mesh `{}` change in time: they stay", a.name);
            self.leave(&was.at, text);
        }
        let same = a.positions == b.positions && a.normals == b.normals;
        follow(&mut self.meshes, index, number, same, || vertices(was), || vertices(&is));
        if let Some(own) = &was.rig {
            let pose = match &is.rig {
                Some(rig)
                    if rig.is_pose() || rig.rest == own.rest && rig.targets == own.targets && rig.skin == own.skin =>
                {
                    &rig.pose
                }
                Some(_) | None => {
                    self.broken.push(index);
                    &own.pose
                }
            };
            follow(&mut self.rigs, index, number, *pose == own.pose, || own.pose.clone(), || pose.clone());
        }
    }

    /// A frame at which everything stands still.
    fn hold(&mut self, still: &Assembly, number: usize) {
        for (index, locals) in &mut self.nodes {
            locals.resize_with(number + 1, || still.nodes.get(*index).map_or_else(Default::default, |node| node.local));
        }
        for (index, shapes) in &mut self.meshes {
            shapes.resize_with(number + 1, || still.meshes.get(*index).map(vertices).unwrap_or_default());
        }
        for (index, poses) in &mut self.rigs {
            let pose = still.meshes.get(*index).and_then(|mesh| Some(mesh.rig.as_ref()?.pose.clone()));
            poses.resize_with(number + 1, || pose.clone().unwrap_or_default());
        }
    }

    /// Puts together what moves. A rig that the formats cannot say, sheared joints above all, gives way to its vertices.
    fn finish(mut self, assembly: &mut Assembly, mut motion: Motion) {
        let left = self.left.into_iter().map(|(at, text)| Note::warning(at, text));
        assembly.notes.extend(left);
        motion.nodes = self.nodes.into_iter().map(|(node, locals)| NodeMotion { node, locals }).collect();
        motion.rigs = self.rigs.into_iter().map(|(mesh, poses)| RigMotion { mesh, poses }).collect();
        assembly.motion = Some(motion);
        let mut broken = self.broken;
        for node in 0..assembly.nodes.len() {
            let Some(mesh) = assembly.nodes.get(node).and_then(|node| node.mesh) else { continue };
            if !is_sound(assembly, node) {
                broken.push(mesh);
            }
        }
        for (index, source) in assembly.meshes.iter_mut().enumerate() {
            if broken.contains(&index) {
                source.rig = None;
            } else if source.rig.is_some() {
                self.meshes.remove(&index);
            }
        }
        let Some(mut motion) = assembly.motion.take() else { return };
        motion.rigs.retain(|rig| !broken.contains(&rig.mesh));
        motion.meshes = self.meshes.into_iter().map(|(mesh, shapes)| MeshMotion { mesh, shapes }).collect();
        let moves = !(motion.nodes.is_empty() && motion.meshes.is_empty() && motion.rigs.is_empty());
        assembly.motion = moves.then_some(motion);
    }
}

/// Whether the joints of a node's mesh can be written: they move in their parents by rotations, scales and translations alone,
/// from where something was bound to them.
fn is_sound(assembly: &Assembly, node: usize) -> bool {
    let Some((skin, worlds)) = assembly.joints(node) else { return true };
    skin.binds.iter().all(|bind| bind.inverse().is_finite())
        && (0..skin.joints.len()).all(|joint| {
            let locals = motion::locals(&skin.joints, joint, &worlds);
            locals.iter().all(|local| local.is_finite()) && motion::parts(&locals).is_some()
        })
}

/// Notes that a thing `is` so at frame `number`; kept from the first frame on at which it differs from what it `was`.
fn follow<T>(
    all: &mut BTreeMap<usize, Vec<T>>,
    index: usize,
    number: usize,
    same: bool,
    was: impl Fn() -> T,
    is: impl Fn() -> T,
) {
    match all.get_mut(&index) {
        Some(own) => own.push(is()),
        None if same => {}
        None => {
            let mut own = Vec::with_capacity(number + 1);
            own.resize_with(number, was);
            own.push(is());
            all.insert(index, own);
        }
    }
}

fn vertices(source: &MeshSource) -> Vertices {
    Vertices { positions: source.mesh.positions.clone(), normals: source.mesh.normals.clone() }
}

fn is_same_light(a: &LightSource, b: &LightSource) -> bool {
    a.form == b.form && a.color == b.color && a.kelvin == b.kelvin
}

fn is_same_camera(a: &Camera, b: &Camera) -> bool {
    a.yfov == b.yfov && a.aspect == b.aspect && a.pupil == b.pupil && a.focus == b.focus
}
