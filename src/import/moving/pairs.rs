//! Which thing of an asset at a frame is which of those without a frame: what blinks must not shift its neighbours.

use eyebox_base::Where;
use eyebox_scene::assembly::{Assembly, Camera, LightSource, Material};
use eyebox_scene::value::Value;
use std::collections::{HashMap, VecDeque};
use std::hash::Hash;

/// Things by their places in the file; of several at one place, the first is the first.
#[derive(Debug, Default)]
pub(super) struct Pairs {
    /// Of each thing without a frame, its index at the frame.
    pub of: Vec<Option<usize>>,
    /// Things that are there only at the frame.
    pub new: Vec<usize>,
}

impl Pairs {
    pub fn new<K: Hash + Eq>(still: impl Iterator<Item = K>, now: impl Iterator<Item = K>) -> Pairs {
        let mut places: HashMap<K, VecDeque<usize>> = HashMap::new();
        for (index, key) in now.enumerate() {
            places.entry(key).or_default().push_back(index);
        }
        let of = still.map(|key| places.get_mut(&key).and_then(VecDeque::pop_front)).collect();
        let mut new: Vec<usize> = places.into_values().flatten().collect();
        new.sort_unstable();
        Pairs { of, new }
    }
    pub fn of(&self, still: usize) -> Option<usize> {
        self.of.get(still).copied().flatten()
    }
}

/// The pairs of nodes.
pub(super) fn nodes(still: &Assembly, now: &Assembly) -> Pairs {
    // Instances of one prim have its place and paths of their own.
    fn keys(assembly: &Assembly) -> impl Iterator<Item = (&Where, &str)> {
        assembly.nodes.iter().map(|node| (&node.at, node.path.as_str()))
    }
    Pairs::new(keys(still), keys(now))
}

/// The pairs of meshes, which are those that the same node shows: a file may hold a mesh once for many nodes, or for all that
/// look alike at the moment.
pub(super) fn meshes(still: &Assembly, now: &Assembly, nodes: &Pairs) -> Vec<Option<usize>> {
    let mut of = vec![None; still.meshes.len()];
    for (index, node) in still.nodes.iter().enumerate() {
        let is = nodes.of(index).and_then(|index| now.nodes.get(index)?.mesh);
        let (Some(was), Some(is)) = (node.mesh, is) else { continue };
        let named = |assembly: &Assembly, mesh: usize| assembly.meshes.get(mesh).map(|source| source.mesh.name.clone());
        if named(still, was) == named(now, is)
            && let Some(slot @ None) = of.get_mut(was)
        {
            *slot = Some(is);
        }
    }
    of
}

pub(super) fn materials(still: &Assembly, now: &Assembly) -> Pairs {
    fn keys(assembly: &Assembly) -> impl Iterator<Item = (&Where, &str)> {
        assembly.materials.iter().map(|material| (&material.at, material.name.as_str()))
    }
    Pairs::new(keys(still), keys(now))
}

pub(super) fn lights(still: &Assembly, now: &Assembly) -> Pairs {
    fn keys(assembly: &Assembly) -> impl Iterator<Item = (&Where, Option<&str>)> {
        let path = |light: &LightSource| Some(assembly.nodes.get(light.node)?.path.as_str());
        assembly.lights.iter().map(move |light| (&light.at, path(light)))
    }
    Pairs::new(keys(still), keys(now))
}

pub(super) fn cameras(still: &Assembly, now: &Assembly) -> Pairs {
    fn keys(assembly: &Assembly) -> impl Iterator<Item = (Option<(&Where, &str)>, &str)> {
        let node = |camera: &Camera| assembly.nodes.get(camera.node?).map(|node| (&node.at, node.path.as_str()));
        assembly.cameras.iter().map(move |camera| (node(camera), camera.name.as_str()))
    }
    Pairs::new(keys(still), keys(now))
}

pub(super) fn is_same_light(a: &LightSource, b: &LightSource) -> bool {
    a.form == b.form
        && a.color == b.color
        && a.kelvin == b.kelvin
        && a.profile == b.profile
        && is_same(a.attributes.as_ref(), b.attributes.as_ref())
}

/// A camera on a node goes where the node does.
pub(super) fn is_same_camera(a: &Camera, b: &Camera) -> bool {
    a.yfov == b.yfov
        && a.aspect == b.aspect
        && a.pupil == b.pupil
        && a.focus == b.focus
        && a.frustum == b.frustum
        && (a.node.is_some() || a.to_world == b.to_world)
}

pub(super) fn is_same_material(a: &Material, b: &Material) -> bool {
    let rows = |a: &[(String, Value)], b: &[(String, Value)]| {
        a.len() == b.len() && a.iter().zip(b).all(|((a, x), (b, y))| a == b && x.same(y))
    };
    a.surface.as_deref() == b.surface.as_deref()
        && rows(&a.mapped, &b.mapped)
        && rows(&a.looks, &b.looks)
        && is_same(a.attributes.as_ref(), b.attributes.as_ref())
}

/// Whether two things say the same in our vocabulary.
pub(super) fn is_same(a: Option<&Value>, b: Option<&Value>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => a.same(b),
        (None, None) => true,
        (Some(_), None) | (None, Some(_)) => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_blinks_shifts_nobody() {
        let pairs = Pairs::new("abca".chars(), "xcaa".chars());
        assert_eq!(pairs.of, [Some(2), None, Some(1), Some(3)]);
        assert_eq!(pairs.new, [0]);
    }
}
