//! What moves, as time samples.

use super::super::tracks::{self, SCALE, TRANSLATION, Vector};
use super::layer::{Datum, Property};
use super::stage::matrix;
use eyebox_scene::motion::{MeshMotion, Motion, Parts, Vertices, parts};
use glam::DAffine3;

/// Values at these frames.
pub(super) fn sampled(motion: &Motion, kept: &[usize], value: impl Fn(usize) -> Datum) -> Vec<(f64, Datum)> {
    kept.iter().filter_map(|at| Some((*motion.frames.get(*at)?, value(*at)))).collect()
}

/// Transform ops that move a prim: translation, rotation and scale, or whole matrices of what is sheared. `still` is where it
/// stands without a time.
pub(super) fn transform(motion: &Motion, still: DAffine3, locals: &[DAffine3]) -> Vec<Property> {
    let order = |names: &[&str]| {
        let names = names.iter().map(|name| (*name).to_owned()).collect();
        Property::new("xformOpOrder", Datum::Tokens(names)).uniform()
    };
    let all: Vec<DAffine3> = std::iter::once(still).chain(locals.iter().copied()).collect();
    let all = parts(&all);
    let Some((still_parts, all)) = all.as_ref().and_then(|all| all.split_first()) else {
        let every: Vec<usize> = (0..motion.frames.len()).collect();
        let samples = sampled(motion, &every, |at| matrix(locals.get(at).copied().unwrap_or(still)));
        let name = "xformOp:transform";
        return vec![Property::new(name, matrix(still)).sampled(samples), order(&[name])];
    };
    let own = |at: usize| all.get(at).unwrap_or(still_parts);
    let vector = |name: &str, of: Vector| {
        let value = |parts: &Parts| Datum::Double3(of(parts).to_array());
        let samples = sampled(motion, &tracks::of_vectors(motion, &[all], of), |at| value(own(at)));
        Property::new(name, value(still_parts)).sampled(samples)
    };
    let turn = |parts: &Parts| {
        let q = parts.rotation;
        Datum::Quat([q.w, q.x, q.y, q.z])
    };
    let turns = sampled(motion, &tracks::of_turns(motion, &[all]), |at| turn(own(at)));
    let names = ["xformOp:translate", "xformOp:orient", "xformOp:scale"];
    vec![
        vector(names[0], TRANSLATION),
        Property::new(names[1], turn(still_parts)).sampled(turns),
        vector(names[2], SCALE),
        order(&names),
    ]
}

/// A list of the vertices of a mesh that moves by them, as `value` says it.
pub(super) fn vertices(
    moved: Option<(&Motion, &MeshMotion)>,
    of: fn(&Vertices) -> &Vec<[f32; 3]>,
    value: impl Fn(&[[f32; 3]]) -> Datum,
) -> Vec<(f64, Datum)> {
    let Some((motion, moved)) = moved else { return Vec::new() };
    let kept = tracks::of_vertices(motion, moved, of);
    sampled(motion, &kept, |at| value(moved.shapes.get(at).map_or(&[][..], |shape| of(shape))))
}
