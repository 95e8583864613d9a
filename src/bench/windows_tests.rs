//! Rooms that daylight enters by a window: aimed at or not, it is the same light, and there is less noise.

use super::curve::picture::Picture;
use super::curve::race::Ready;
use super::generate;
use eyebox_base::stats::{Moments, sidak_z};
use eyebox_estimate::run::begin;
use eyebox_film::plan::Plan;
use eyebox_plan::{Choice, plan};

const SIZE: [usize; 2] = [16, 12];
/// Blocks of the picture, along and across.
const BLOCKS: [usize; 2] = [4, 3];

/// Mean luminance of each block over runs, and the sum of all pixels' variances over runs, relative to their squares.
fn seen(ready: &Ready<'_>, plan: &Plan, (runs, passes): (u64, u64)) -> (Vec<Moments>, f64) {
    let mut blocks = vec![Moments::default(); BLOCKS[0] * BLOCKS[1]];
    let mut pixels = vec![Moments::default(); SIZE[0] * SIZE[1]];
    for seed in 0..runs {
        let mut tracing = begin(&ready.world, plan, ready.checked.scene().groups.len(), SIZE, seed);
        tracing.step(passes);
        let mut sums = vec![0.0; blocks.len()];
        let picture = Picture::of_films(tracing.films(), SIZE);
        for (pixel, (moments, value)) in pixels.iter_mut().zip(picture.values).enumerate() {
            let (x, y) = (pixel % SIZE[0] * BLOCKS[0] / SIZE[0], pixel / SIZE[0] * BLOCKS[1] / SIZE[1]);
            sums[y * BLOCKS[0] + x] += value;
            moments.add(value);
        }
        blocks.iter_mut().zip(sums).for_each(|(block, sum)| block.add(sum));
    }
    let noise = pixels.iter().filter(|pixel| pixel.mean > 0.0).map(|pixel| pixel.variance() / pixel.mean.powi(2)).sum();
    (blocks, noise)
}

/// The bright spot of the sky of seed 6 falls in by the window: there directions by luminance alone are as good.
#[test]
fn windows_bring_the_same_light_with_less_noise() {
    for (seed, gain) in [(13, 4.0), (20, 1.5), (27, 4.0)] {
        let mut scene = generate::scene(seed);
        scene.eye.resolution = SIZE;
        let ready = Ready::new(&scene, 0.0).unwrap();
        let aimed = plan(&ready.checked, &ready.world, Choice::Auto);
        assert!(aimed.sky_guide.is_some(), "seed {seed}");
        let wide = Plan { sky_guide: None, ..aimed.clone() };
        let ((of_aimed, noise), (of_wide, more)) = (seen(&ready, &aimed, (24, 64)), seen(&ready, &wide, (24, 64)));
        for (block, (got, want)) in of_aimed.iter().zip(&of_wide).enumerate() {
            let error = got.stderr().hypot(want.stderr());
            let z = (got.mean - want.mean) / error;
            assert!(z.abs() < sidak_z(0.001, 2 * of_wide.len()), "seed {seed}, block {block}: {got:?} {want:?}, {z}");
        }
        assert!(gain * noise < more, "seed {seed}: {noise} {more}");
    }
}

/// Where the sky is all around, nothing is learned.
#[test]
fn open_skies_have_no_windows() {
    let scene = generate::scene(2);
    let ready = Ready::new(&scene, 0.0).unwrap();
    assert!(plan(&ready.checked, &ready.world, Choice::Auto).sky_guide.is_none());
}
