//! Rough panes: what the plan's estimators bring together, against rays from the eye alone.

use super::kit;
use eyebox_base::stats::{Moments, sidak_z};
use eyebox_check::{Checked, check};
use eyebox_estimate::run::begin;
use eyebox_film::layer::Layer;
use eyebox_film::plan::{Estimator, Plan};
use eyebox_plan::selection::Handicap;
use eyebox_plan::{Choice, plan, plan_handicapped};
use eyebox_scene::{Face, Finish, Scene};
use eyebox_world::World;
use glam::{DAffine3, DVec3};

const SIZE: [usize; 2] = [12, 8];
/// Blocks of the picture, along and across.
const BLOCKS: [usize; 2] = [2, 2];

/// A lamp behind a pane with a rough front, and behind it a bright wall; the pane's glass sends the front's light back to
/// it, and so does the wall.
fn pane(alpha: f64) -> Scene {
    let mut scene = kit::scene(20.0, 1);
    scene.eye.resolution = SIZE;
    scene.eye.pupil_diameter_m = 4e-3;
    scene.eye.focus_distance_m = 0.3;
    let group = kit::group(&mut scene, "lamp");
    let mut sheet = |z: f64, half: f64, face: Face| {
        let square = kit::mesh(&[kit::quad(DVec3::Z * z, DVec3::X * half, DVec3::Y * half)]);
        kit::add(&mut scene, square, DAffine3::IDENTITY, None, vec![face]);
    };
    sheet(-0.34, 0.03, kit::shining(group, 1e4));
    sheet(-0.36, 0.2, kit::face(Finish::Lambert { reflectance: 0.8, transmittance: 0.0 }));
    let mut faces: Vec<Face> = (0..6).map(|_| kit::face(Finish::Absorber)).collect();
    (faces[4], faces[5]) = (kit::face(Finish::Polished), kit::face(Finish::Rough { alpha }));
    let glass = kit::mesh(&kit::cuboid(DVec3::new(0.06, 0.06, 2e-3)));
    kit::add(&mut scene, glass, DAffine3::from_translation(DVec3::Z * -0.3), Some(1.8), faces);
    scene
}

/// Mean luminance that was scattered more than once, and its error, of each block; errors are by the spread over runs,
/// whose pixels share photons. Of it, what photons have brought.
fn scattered(
    scene: &Scene,
    plan: impl Fn(&Checked<'_>, &World) -> Plan,
    (runs, passes): (u64, u64),
) -> (Vec<Moments>, f64) {
    let checked = check(scene).unwrap();
    let world = World::freeze(scene).unwrap();
    let plan = plan(&checked, &world);
    let mut blocks = vec![Moments::default(); BLOCKS[0] * BLOCKS[1]];
    let (mut all, mut by_photons) = (0.0, 0.0);
    for seed in 0..runs {
        let mut tracing = begin(&world, &plan, 1, SIZE, seed);
        tracing.step(passes);
        let mut sums = vec![0.0; blocks.len()];
        for (estimator, film, _) in &tracing.films().films {
            for plane in (0..film.planes.len()).filter(|plane| film.planes[*plane].layer == Layer::Secondary) {
                for pixel in 0..SIZE[0] * SIZE[1] {
                    let (x, y) = (pixel % SIZE[0] * BLOCKS[0] / SIZE[0], pixel / SIZE[0] * BLOCKS[1] / SIZE[1]);
                    let value = film.mean(pixel, plane).value;
                    sums[y * BLOCKS[0] + x] += value;
                    all += value;
                    by_photons += if *estimator == Estimator::Photon { value } else { 0.0 };
                }
            }
        }
        blocks.iter_mut().zip(sums).for_each(|(block, sum)| block.add(sum));
    }
    (blocks, by_photons / all)
}

/// A narrow lobe of an interface goes on to the next scatterer, a wide one does not: either way each path counts once.
#[test]
fn light_that_a_rough_pane_scatters_again_counts_once() {
    // So large a lamp is better found from the eye, which is what makes it an oracle.
    let mut handicap = Handicap::default();
    handicap.work[Estimator::Backward as usize] = 1e6;
    for alpha in [0.15, 0.7] {
        let scene = pane(alpha);
        let (eye, _) =
            scattered(&scene, |checked, world| plan(checked, world, Choice::Only(Estimator::Backward)), (16, 300));
        let (photons, by_photons) =
            scattered(&scene, |checked, world| plan_handicapped(checked, world, &handicap), (16, 6));
        assert!(by_photons > 0.99, "α = {alpha}: {by_photons}");
        for (block, (want, got)) in eye.iter().zip(&photons).enumerate() {
            let error = want.stderr().hypot(got.stderr());
            let z = (got.mean - want.mean) / error;
            assert!(error < 0.05 * want.mean, "α = {alpha}, block {block}: ± {error} of {}", want.mean);
            assert!(z.abs() < sidak_z(0.001, 2 * eye.len()), "α = {alpha}, block {block}: {z} errors");
        }
    }
}
