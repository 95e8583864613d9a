//! The pilot finds where a pinhole sees lamps in mirrors, wherever its rays fall.

use super::kit;
use eyebox_base::rng::{Rng, Stream};
use eyebox_plan::pilots::glint_pilot::{Search, find_by_way};
use eyebox_scene::{Finish, Scene};
use eyebox_world::World;
use glam::{DAffine3, DVec3};
use std::f64::consts::TAU;

const RADIUS_M: f64 = 0.015;

/// A small lamp beside a pinhole that looks at convex mirrors. Each shows it once, and once in each other one.
fn mirrors(at: &[DVec3]) -> Scene {
    let mut scene = kit::scene(40.0, 64);
    let lamp = kit::quad(DVec3::new(0.01, 0.06, 0.0), DVec3::Y * 5e-4, DVec3::X * 5e-4);
    kit::panel(&mut scene, 1e6, lamp);
    for place in at {
        let mut ball = kit::face(Finish::MirrorIdeal { reflectance: 0.9 });
        ball.shape = kit::ball(RADIUS_M);
        kit::add(&mut scene, kit::sphere(RADIUS_M, 32, 64), DAffine3::from_translation(*place), None, vec![ball]);
    }
    scene
}

/// Three mirrors have three images of a lamp and six images of images, wherever they stand and wherever rays fall.
#[test]
fn an_image_in_each_mirror_and_in_each_mirror_of_each() {
    for place in 0..16 {
        let mut rng = Rng::new(1, Stream::Check, place, 0);
        let mut near = |to: f64| to + (rng.uniform() - 0.5) * 0.01;
        let at = [0.0, 1.0, 2.0].map(|third: f64| {
            let (sin, cos) = (third * TAU / 3.0).sin_cos();
            DVec3::new(near(0.035 * cos), near(0.035 * sin), near(-0.25))
        });
        let scene = mirrors(&at);
        let world = World::freeze(&scene).unwrap();
        for _ in 0..4 {
            let shift = [rng.next_u64(), rng.next_u64()];
            let all = Search { wants: &|_| true, takes: &|_| false, over_faces: true };
            let found = find_by_way((&world, &scene), all, shift, &|| false);
            let of = |reflections: usize| -> Vec<usize> {
                let ways = found.iter().filter(|((chain, _), _)| chain.0.len() == reflections);
                ways.map(|(_, glints)| glints.len()).collect()
            };
            assert_eq!([of(1), of(2)], [vec![1; 3], vec![1; 6]], "{at:?} {shift:?}");
        }
    }
}
