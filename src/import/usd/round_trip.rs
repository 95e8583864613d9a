//! What our own writer leaves in `customData["eyebox"]` (see `author::usd::stage`): names that prims cannot have, the
//! exact numbers behind single precision, and which prims are no nodes of their own.

use super::attribute::PrimView;
use super::value;
use crate::assembly::Assembly;
use eyebox_base::error::Result;
use glam::DAffine3;
use openusd::sdf::{Dictionary, Value};
use std::collections::HashMap;

/// The marks of one prim; empty for anyone else's.
#[derive(Debug, Clone, Default)]
pub(super) struct RoundTrip(Dictionary);

impl RoundTrip {
    pub fn of(view: &PrimView) -> Result<Self> {
        Ok(match view.metadata("customData")? {
            Some(Value::Dictionary(mut all)) => match all.remove("eyebox") {
                Some(Value::Dictionary(own)) => RoundTrip(own),
                Some(_) | None => RoundTrip::default(),
            },
            Some(_) | None => RoundTrip::default(),
        })
    }
    pub fn text(&self, key: &str) -> Option<&str> {
        self.0.get(key).and_then(value::text)
    }
    pub fn texts(&self, key: &str) -> Vec<String> {
        self.0.get(key).cloned().and_then(value::texts).unwrap_or_default()
    }
    /// A finite number.
    pub fn number(&self, key: &str) -> Option<f64> {
        self.0.get(key).and_then(value::number).filter(|x| x.is_finite())
    }
    pub fn triple(&self, key: &str) -> Option<[f64; 3]> {
        self.0.get(key).and_then(value::triple).filter(|lanes| lanes.iter().all(|x| x.is_finite()))
    }
    pub fn flag(&self, key: &str) -> bool {
        self.0.get(key).and_then(value::flag) == Some(true)
    }
    pub fn fold(&self) -> Option<Fold> {
        match (self.flag("part"), self.flag("wrapper")) {
            (true, _) => Some(Fold::Part),
            (false, true) => Some(Fold::Wrapper),
            (false, false) => None,
        }
    }
}

/// How a node stops being one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Fold {
    /// What it holds belongs to the node above it.
    Part,
    /// It only holds several roots together.
    Wrapper,
}

/// Takes the nodes in `folds` out of the assembly. One that has become more than its mark says (edited by someone: with
/// children, a transform, a second mesh) stays.
pub(super) fn fold(assembly: &mut Assembly, folds: &HashMap<usize, Fold>) {
    if folds.is_empty() {
        return;
    }
    let mut children = vec![0usize; assembly.nodes.len()];
    for parent in assembly.nodes.iter().filter_map(|node| node.parent) {
        children[parent] += 1;
    }
    // Where each node went.
    let mut into: Vec<Option<usize>> = (0..assembly.nodes.len()).map(Some).collect();
    for index in (0..assembly.nodes.len()).rev() {
        let node = &assembly.nodes[index];
        let (local, mesh) = (node.local, node.mesh);
        match (folds.get(&index), node.parent) {
            (Some(Fold::Part), Some(parent)) if children[index] == 0 => {
                let above = &assembly.nodes[parent];
                let clash = mesh.is_some() && (above.mesh.is_some() || local != DAffine3::IDENTITY)
                    || node.attributes.is_some() && above.attributes.is_some();
                if clash {
                    continue;
                }
                let attributes = assembly.nodes[index].attributes.take();
                let user = std::mem::take(&mut assembly.nodes[index].user);
                let above = &mut assembly.nodes[parent];
                above.user.extend(user);
                above.mesh = mesh.or(above.mesh);
                above.attributes = attributes.or(above.attributes.take());
                children[parent] -= 1;
                into[index] = Some(parent);
            }
            (Some(Fold::Wrapper), None)
                if mesh.is_none()
                    && node.attributes.is_none()
                    && node.user.is_empty()
                    && local == DAffine3::IDENTITY =>
            {
                into[index] = None;
            }
            (Some(Fold::Part | Fold::Wrapper), _) | (None, _) => {}
        }
    }
    renumber(assembly, &into);
}

/// `into`: each node's own index if it stays, another one's that takes its place, or none.
fn renumber(assembly: &mut Assembly, into: &[Option<usize>]) {
    let mut new: Vec<Option<usize>> = Vec::with_capacity(into.len());
    let mut count = 0;
    for (index, target) in into.iter().enumerate() {
        new.push(match target {
            Some(target) if *target == index => {
                count += 1;
                Some(count - 1)
            }
            // Nodes above stand before.
            Some(target) => new.get(*target).copied().flatten(),
            None => None,
        });
    }
    let mut index = 0;
    assembly.nodes.retain(|_| {
        index += 1;
        into[index - 1] == Some(index - 1)
    });
    for index in 0..assembly.nodes.len() {
        let parent = assembly.nodes[index].parent.and_then(|parent| new.get(parent).copied().flatten());
        let path = match parent.and_then(|parent| assembly.nodes.get(parent)) {
            Some(above) if !above.path.is_empty() => format!("{}/{}", above.path, assembly.nodes[index].name),
            Some(_) | None => assembly.nodes[index].name.clone(),
        };
        let node = &mut assembly.nodes[index];
        (node.parent, node.path) = (parent, path);
    }
    for light in &mut assembly.lights {
        light.node = new.get(light.node).copied().flatten().unwrap_or(0);
    }
    for camera in &mut assembly.cameras {
        camera.node = camera.node.and_then(|node| new.get(node).copied().flatten());
    }
}

/// The exact number, if it is what was rounded to single precision; `rounded` if someone changed that since.
pub(super) fn refined(exact: Option<f64>, rounded: f64) -> f64 {
    // Two roundings of 2^-24 each, and what a tangent makes of them.
    exact.filter(|exact| (exact - rounded).abs() <= 1e-6 * rounded.abs()).unwrap_or(rounded)
}
