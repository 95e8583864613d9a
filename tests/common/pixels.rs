//! What pixels have to show, in closed form and by plain sampling, where what they see is cut by their footprints.

use super::{add_part, block_z, cuboid, face, image, mean, mesh, quad, worst_z};
use eyebox::base::rng::{Rng, Stream};
use eyebox::check::check;
use eyebox::estimate::run::{Films, Limits, run};
use eyebox::film::plan::{Estimator, Spectral};
use eyebox::plan::{Asked, Choice, Polarisation, plan};
use eyebox::scene::{Dispersion, Finish, Scene};
use eyebox::world::World;
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::PI;

/// The integral over a unit square of what depends on the place along a unit vector alone, at `x` in its middle. `twice`: what has it for its
/// second derivative, 0 up to 0 (x²/2 for a step). Across the vector a square is the convolution of two boxes.
pub fn over_square(along: DVec2, x: f64, twice: impl Fn(f64) -> f64) -> f64 {
    let (a, b) = (along.x.abs(), along.y.abs());
    let ends = [(a + b, 1.0), (a - b, -1.0), (b - a, -1.0), (-a - b, 1.0)];
    ends.iter().map(|(end, sign)| sign * twice((x + 0.5 * end).max(0.0))).sum::<f64>() / (a * b)
}

/// The mean over a disc of what depends on the place along one direction alone: chords at the cosines of even angles, x = r cos t, of length
/// 2 r sin t.
pub fn over_disc(radius: f64, of: impl Fn(f64) -> f64) -> f64 {
    if radius == 0.0 {
        return of(0.0);
    }
    let steps = 2000;
    let chord = |k: u32| {
        let t = (f64::from(k) + 0.5) / f64::from(steps) * PI;
        of(radius * t.cos()) * 2.0 * t.sin().powi(2) / f64::from(steps)
    };
    (0..steps).map(chord).sum()
}

/// Numbers in [0, 1) by design and parameter.
pub fn draws(seed: u64) -> impl Fn(usize, u64) -> f64 {
    move |design, parameter| Rng::new(seed, Stream::Tolerance, parameter, design as u64).uniform()
}

/// Of numbers that are drawn, and its standard error.
pub fn mean_drawn(drawn: &[f64]) -> (f64, f64) {
    let runs = drawn.len() as f64;
    let mean = drawn.iter().sum::<f64>() / runs;
    let variance = drawn.iter().map(|own| (own - mean).powi(2)).sum::<f64>() / (runs - 1.0);
    (mean, (variance / runs).sqrt())
}

/// A plate of glass 0.3 m before the eye, turned to its gaze. `half`: of its sides, m.
pub fn add_plate(s: &mut Scene, half: f64, index: &Dispersion) {
    let faces = (0..6).map(|_| face(Finish::Polished)).collect();
    let polygons = cuboid(DVec3::new(half, half, 0.003));
    let plate = add_part(s, "plate", mesh(&polygons), DVec3::NEG_Z * 0.3, Some(1.5), faces);
    s.media.last_mut().unwrap().index = index.clone();
    s.parts[plate].to_world.matrix3 = DMat3::from_rotation_y(0.8);
}

/// A mirror there, turned by so many radians.
pub fn add_mirror(s: &mut Scene, half: f64, turn: f64) {
    let square = mesh(&[quad(DVec3::ZERO, DVec3::X * half, DVec3::Y * half)]);
    let finish = Finish::MirrorIdeal { reflectance: 0.9 };
    let mirror = add_part(s, "mirror", square, DVec3::NEG_Z * 0.3, None, vec![face(finish)]);
    s.parts[mirror].to_world.matrix3 = DMat3::from_rotation_y(turn);
}

/// Of plain sampling from the eye, or of what the estimator does by itself.
pub fn traced(scene: &Scene, polarisation: Polarisation, (passes, seed): (u64, u64), plain: bool) -> (Films, Spectral) {
    let checked = check(scene).expect("the scene is sound");
    let mut world = World::freeze(scene).expect("the scene can be traced");
    world.plain = plain;
    let asked = Asked { choice: Choice::Only(Estimator::Backward), polarisation, ..Asked::default() };
    let plan = plan(&checked, &world, asked);
    let limits = Limits { passes: Some(passes), ..Limits::default() };
    let outcome = run(&world, &plan, scene.groups.len(), scene.eye.resolution, seed, &limits, &mut ());
    (outcome.films, plan.mode.spectral)
}

/// A scene to be seen by both.
pub struct Both<'s> {
    pub what: &'s str,
    pub scene: Scene,
    pub polarised: bool,
    pub mode: Spectral,
    /// Passes of plain sampling and of ours that must agree, and those after which squared errors are compared.
    pub passes: [u64; 3],
}

impl Both<'_> {
    /// By how many times ours has less squared error. They must agree.
    pub fn gain(&self) -> f64 {
        let Both { what, scene, passes: [many, some, few], .. } = self;
        let polarisation = if self.polarised { Polarisation::On } else { Polarisation::Off };
        let of = |passes: u64, seed: u64, plain: bool| {
            let (films, mode) = traced(scene, polarisation, (passes, seed), plain);
            assert_eq!(mode, self.mode, "{what}");
            image(&films)
        };
        let (many, ours) = (of(*many, 7, true), of(*some, 8, false));
        let (z, bound) = worst_z(&block_z(&ours, &many, scene.eye.resolution[0], 4), 1e-3);
        let ((a, da), (b, db)) = (mean(&ours), mean(&many));
        let of_means = (a - b) / da.hypot(db);
        // With what is left of noise in the reference.
        let off = |seen: &[(f64, f64)]| {
            seen.iter().zip(&many).map(|(own, many)| (own.0 - many.0).powi(2)).sum::<f64>() / seen.len() as f64
        };
        let (own, chance) = (off(&of(*few, 9, false)), off(&of(*few, 9, true)));
        let gain = chance / own;
        println!(
            "{what}: blocks {z:.2} of {bound:.2} σ, mean {of_means:.2} σ ({a:.2} {b:.2}), squared error {own:.2}, by chance \
             {chance:.2}: {gain:.1} times"
        );
        assert!(z < bound, "{what}: {z} {bound}");
        assert!(of_means.abs() < 3.0, "{what}: {of_means}");
        gain
    }
}
