//! Which of the frames of a motion must be written: both formats go from one key to the next evenly, numbers one by one,
//! quaternions along the shorter way, so that what lies on the way between its neighbours need not be.

use eyebox_scene::motion::{MeshMotion, Motion, Parts, Vertices, kept};
use glam::{DQuat, DVec3};

/// What may be lost by leaving a key out, as a share of the largest number: what single precision rounds.
const NEAR: f64 = 1e-7;

pub fn near(a: f64, b: f64, most: f64) -> bool {
    (a - b).abs() <= NEAR * most
}

fn near_turn(a: DQuat, b: DQuat) -> bool {
    let b = if a.dot(b) < 0.0 { -b } else { b };
    a.abs_diff_eq(b, NEAR)
}

/// A vector of the parts of a transform.
pub type Vector = fn(&Parts) -> DVec3;
pub const TRANSLATION: Vector = |parts| parts.translation;
pub const SCALE: Vector = |parts| parts.scale;

/// The frames of a vector of several transforms together: each of `all` has a value for each frame.
pub fn of_vectors(motion: &Motion, all: &[&[Parts]], of: Vector) -> Vec<usize> {
    let most = all.iter().flat_map(|own| own.iter()).map(|parts| of(parts).abs().max_element()).fold(0.0, f64::max);
    kept(motion.frames.len(), |from, at, to| {
        let share = motion.share(from, at, to);
        all.iter().all(|own| match (own.get(from), own.get(at), own.get(to)) {
            (Some(from), Some(at), Some(to)) => {
                let mixed = of(from).lerp(of(to), share).to_array();
                mixed.into_iter().zip(of(at).to_array()).all(|(a, b)| near(a, b, most))
            }
            (_, _, _) => true,
        })
    })
}

/// The frames of the rotations of several transforms together.
pub fn of_turns(motion: &Motion, all: &[&[Parts]]) -> Vec<usize> {
    kept(motion.frames.len(), |from, at, to| {
        let share = motion.share(from, at, to);
        all.iter().all(|own| match (own.get(from), own.get(at), own.get(to)) {
            (Some(from), Some(at), Some(to)) => near_turn(from.rotation.slerp(to.rotation, share), at.rotation),
            (_, _, _) => true,
        })
    })
}

/// The frames of lists of numbers, one list a frame.
pub fn of_numbers(motion: &Motion, all: &[Vec<f64>]) -> Vec<usize> {
    let most = all.iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
    let own = |at: usize| all.get(at).map_or(&[][..], Vec::as_slice);
    kept(motion.frames.len(), |from, at, to| {
        let share = motion.share(from, at, to);
        let ends = own(from).iter().zip(own(to));
        ends.zip(own(at)).all(|((from, to), at)| near(from * (1.0 - share) + to * share, *at, most))
    })
}

/// Normals that turn by less between two shapes than a mixture of them is off are as good as those: 1e-3 is 0.06°.
const TURNED: f64 = 1e-3;

/// The frames of a mesh that moves by its vertices: positions as near as ever, normals as near as can be seen.
pub fn of_shapes(motion: &Motion, moved: &MeshMotion) -> Vec<usize> {
    let positions = fits(motion, moved, |shape| &shape.positions);
    let normals = within(motion, moved, |shape| &shape.normals, TURNED);
    kept(motion.frames.len(), |from, at, to| positions(from, at, to) && normals(from, at, to))
}

/// The frames of one list of the vertices of a mesh alone.
pub fn of_vertices(motion: &Motion, moved: &MeshMotion, of: fn(&Vertices) -> &Vec<[f32; 3]>) -> Vec<usize> {
    kept(motion.frames.len(), fits(motion, moved, of))
}

fn fits<'a>(
    motion: &'a Motion,
    moved: &'a MeshMotion,
    of: fn(&Vertices) -> &Vec<[f32; 3]>,
) -> impl Fn(usize, usize, usize) -> bool + 'a {
    let all = moved.shapes.iter().flat_map(move |shape| of(shape).as_flattened());
    let most = all.fold(0.0_f64, |most, x| most.max(f64::from(x.abs())));
    within(motion, moved, of, NEAR * most)
}

/// Whether a list of vertices lies on the way between two others but for so much.
fn within<'a>(
    motion: &'a Motion,
    moved: &'a MeshMotion,
    of: fn(&Vertices) -> &Vec<[f32; 3]>,
    off: f64,
) -> impl Fn(usize, usize, usize) -> bool + 'a {
    move |from, at, to| {
        let own = |at: usize| moved.shapes.get(at).map_or(&[][..], |shape| of(shape).as_flattened());
        let share = motion.share(from, at, to);
        let ends = own(from).iter().zip(own(to)).map(|(from, to)| (f64::from(*from), f64::from(*to)));
        ends.zip(own(at)).all(|((from, to), at)| (from * (1.0 - share) + to * share - f64::from(*at)).abs() <= off)
    }
}
