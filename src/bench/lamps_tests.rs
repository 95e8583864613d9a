//! Lamps that only a corner of the picture shows are connected as the others are.

use super::curve::race::Ready;
use super::generate;
use eyebox_base::rng::{Rng, Stream};
use eyebox_estimate::ledger::Ledger;
use eyebox_estimate::manifold::seeds::connections::{Connections, index_of};
use eyebox_estimate::manifold::solver::newton::Target;
use eyebox_estimate::walk::{Meeting, Met, Travel, Walker};
use eyebox_plan::{Choice, plan};
use eyebox_world::World;
use eyebox_world::geometry::Ray;
use eyebox_world::interior::Interior;
use eyebox_world::mode::{Mode, Mono};
use eyebox_world::optics::Optics;
use glam::DVec2;

/// Rays of a pixel.
const RAYS: u64 = 3000;

/// The light of lamps that rays from a pixel find, and what connections own of it.
fn light(world: &World, optics: &Optics<Mono>, connections: &Connections, [x, y]: [usize; 2]) -> [f64; 2] {
    let mut sums = [0.0; 2];
    for ray in 0..RAYS {
        let mut rng = Rng::new(7, Stream::Pilot, (x + 1000 * y) as u64, ray);
        let (film, [u, v]) = (world.eye.film_of(x, y, rng.pair()), rng.pair());
        let pupil = DVec2::from_angle(v * std::f64::consts::TAU) * (u.sqrt() * world.eye.pupil_radius_m());
        let (origin, (_, dir), ..) = world.eye.ray_of(film, pupil);
        let start = Ray { origin, dir, from: None };
        let mut walker =
            Walker::new((world, optics), Travel::FromEye, start, 1.0, Interior::default(), rng).recording();
        let mut ledger = Ledger::new(world.solids.len());
        while let Met::Face(vertex) = walker.advance(&mut ledger) {
            if let Some(seen) = walker.lamp_at(&vertex) {
                let found = walker.seen(&seen).0[0].open();
                let chain = walker.chain().unwrap().clone().reversed();
                let lamp = &world.lamps.all()[seen.index];
                let target = Target::new(vertex.hit.point, lamp.sample_point([0.5, 0.5]).normal);
                let owned = connections.owns((world, optics), &chain, (seen.index, &target), (film, pupil), &mut 0);
                sums[0] += found;
                sums[1] += if owned { found } else { 0.0 };
            }
            if !matches!(walker.meet(&vertex, &mut ledger), Meeting::Went) {
                break;
            }
        }
    }
    sums
}

/// Forty LEDs behind a lens; no pilot's path comes from those at its rim. Before they were started from their neighbours,
/// connection owned 0.3 of the light of the first of these pixels, and rare paths of great weight had the rest.
#[test]
fn lamps_at_the_rim_are_connected() {
    for (seed, pixels) in [(119, [[0, 0], [1, 0], [31, 0], [30, 23]]), (7, [[31, 0], [0, 0], [31, 23], [16, 12]])] {
        let scene = generate::scene(seed);
        let ready = Ready::new(&scene, 0.0).unwrap();
        let plan = plan(&ready.checked, &ready.world, Choice::Auto);
        let optics = Mono::<f64>::optics(&ready.world, 0, 0);
        let connections = Connections::new(&ready.world, &index_of(&optics), &plan.connections);
        for pixel in pixels {
            let [all, owned] = light(&ready.world, &optics, &connections, pixel);
            assert!(all > 0.0 && owned >= 0.98 * all, "seed {seed}, pixel {pixel:?}: {owned} of {all}");
        }
    }
}
