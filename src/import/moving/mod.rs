//! How an asset moves: it is read at one frame after the other, and what differs is what moves. So a format's reader need not
//! tell what a joint, a spline or a blend shape does to a part, and what is written is what a picture of that frame shows.

mod found;
mod pairs;
mod tracks;

use super::{Assembly, ReadOptions, Rigs, Value, read};
use eyebox_base::Where;
use eyebox_base::error::Result;
use eyebox_scene::Note;
use eyebox_scene::motion::{self, Motion};
use found::Found;
use std::collections::BTreeSet;
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
    let at = |frame: &f64| ReadOptions { frame: Some(*frame), rigs: Rigs::Poses, ..options.clone() };
    let mut found = Found::new(frames.len());
    for (number, frame) in frames.iter().enumerate() {
        let (now, _) = read(path, &at(frame))?;
        found.compare(&assembly, &now, number)?;
    }
    let mut motion = Motion { rate: clock.rate, name: clock.name, frames, ..Motion::default() };
    found.settle(&mut motion);
    let mut motion = without_broken(&mut assembly, motion, &mut found.broken);
    if !found.broken.is_empty() {
        // The frames again: vertices of all meshes with rigs would be too much to keep for the few that need them.
        for (number, frame) in motion.frames.iter().enumerate() {
            let (now, _) = read(path, &at(frame))?;
            let pairs = pairs::meshes(&assembly, &now, &pairs::nodes(&assembly, &now));
            for index in found.broken.clone() {
                let Some(was) = assembly.meshes.get(index) else { continue };
                let is = pairs.get(index).copied().flatten().and_then(|index| now.meshes.get(index));
                found.mesh(index, was, is, number)?;
            }
        }
    }
    let (meshes, notes) = found.finish();
    motion.meshes = meshes;
    assembly.notes.extend(notes);
    let moves = !(motion.nodes.is_empty() && motion.meshes.is_empty() && motion.rigs.is_empty());
    assembly.motion = moves.then_some(motion);
    Ok((assembly, sidecar))
}

/// Takes off the rigs that the formats cannot say, sheared joints above all: they give way to their vertices. Adds their meshes
/// to `broken`.
fn without_broken(assembly: &mut Assembly, motion: Motion, broken: &mut BTreeSet<usize>) -> Motion {
    assembly.motion = Some(motion);
    for node in 0..assembly.nodes.len() {
        let Some(mesh) = assembly.nodes.get(node).and_then(|node| node.mesh) else { continue };
        if !is_sound(assembly, node) {
            broken.insert(mesh);
        }
    }
    for index in broken.iter() {
        if let Some(source) = assembly.meshes.get_mut(*index) {
            source.rig = None;
        }
    }
    let mut motion = assembly.motion.take().unwrap_or_default();
    motion.rigs.retain(|rig| !broken.contains(&rig.mesh));
    motion
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The keys of a stage with a triangle at these places in these frames.
    fn keys(samples: &str) -> (Vec<f64>, bool) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.usda");
        let stage = format!(
            "#usda 1.0\n(\n startTimeCode = 1\n endTimeCode = 500\n)\ndef Mesh \"m\"\n{{\n point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]\n \
             int[] faceVertexCounts = [3]\n int[] faceVertexIndices = [0, 1, 2]\n double3 xformOp:translate.timeSamples = {{ {samples} }}\n \
             uniform token[] xformOpOrder = [\"xformOp:translate\"]\n}}\n"
        );
        std::fs::write(&path, stage).unwrap();
        let (assembly, _) = moving(&path, &ReadOptions::default()).unwrap();
        (assembly.clock.unwrap().keys, assembly.motion.is_some())
    }

    /// 500 frames of one place are read once, not 500 times; a place that changes in one of them is read in all.
    #[test]
    fn what_stands_still_has_one_key() {
        let still: Vec<String> = (1..=500).map(|frame| format!("{frame}: (1, 2, 3)")).collect();
        assert_eq!(keys(&still.join(", ")), (vec![1.0], false));
        let (found, moves) = keys("1: (1, 2, 3), 4: (1, 2, 3), 5: (1, 2, 3.5)");
        assert_eq!((found, moves), (vec![1.0, 4.0, 5.0], true));
    }
}
