//! Where little of a lamp is seen through the pupil, connection looks for that little: it brings the same light with less noise.

use super::curve::race::Ready;
use super::generate;
use crate::base::rng::{Rng, Stream};
use crate::estimate::manifold::connections::{Connections, Entry};
use crate::estimate::manifold::rims::Rims;
use crate::estimate::manifold::solve::Target;
use crate::plan::{Choice, plan};
use crate::world::World;
use crate::world::lamp::{Lamp, LampPoint};
use crate::world::mode::{Mode, Mono};
use crate::world::optics::Optics;
use glam::DVec2;

/// Places in each pixel, and points of the lamp for each.
const PLACES: u64 = 24;
const POINTS: u64 = 2000;

struct Joined<'j> {
    world: &'j World,
    optics: &'j Optics<Mono>,
    connections: &'j Connections,
}

impl Joined<'_> {
    /// What a point of a lamp brings to a place in the picture, over what the whole lamp would if its picture filled the pupil.
    fn brings(&self, entry: &Entry, lamp: &Lamp, film: DVec2, point: &LampPoint) -> f64 {
        let eye = &self.world.eye;
        let mut roots = Vec::new();
        let target = Target::new(point.position, point.normal);
        self.connections.roots((self.world, self.optics), entry, film, &target, &mut roots);
        let inside = roots.iter().filter(|root| root.u.length() <= eye.pupil_radius_m());
        inside.map(|root| lamp.area_m2 / (root.slope.determinant().abs() * eye.pupil_area_m2())).sum()
    }
}

/// Sum, sum of squares and how many counted.
#[derive(Default)]
struct Sums([f64; 3]);

impl Sums {
    fn add(&mut self, value: f64) {
        self.0[0] += value;
        self.0[1] += value * value;
        self.0[2] += f64::from(u8::from(value > 0.0));
    }
    /// Mean and its variance, of so many.
    fn mean(&self, count: f64) -> (f64, f64) {
        let mean = self.0[0] / count;
        (mean, (self.0[1] / count - mean * mean) / count)
    }
}

/// An LED that is seen through a third of the pupil, and at the picture's rim through its edge. Before, its points were drawn
/// evenly, and the few that were seen made the rim's pixels the error of the picture: `auto` took 2.3 times as long as light
/// tracing.
#[test]
fn points_of_lamps_are_drawn_where_they_are_seen() {
    let scene = generate::scene(409);
    let ready = Ready::new(&scene, 0.0).unwrap();
    let world = &ready.world;
    let plan = plan(&ready.checked, world, Choice::Auto);
    let optics = Mono::<f64>::optics(world, 0, 0);
    let connections = Connections::new(world, &optics, &plan.connections);
    let joined = Joined { world, optics: &optics, connections: &connections };
    let (mut even, mut aimed) = (Sums::default(), Sums::default());
    for [x, y] in [[29, 4], [0, 16], [31, 13], [2, 21]] {
        for place in 0..PLACES {
            let mut rng = Rng::new(3, Stream::Check, (x + 32 * y) as u64, place);
            let film = world.eye.film_of(x, y, rng.pair());
            for (_, entry) in connections.at(film).filter(|(_, entry)| entry.train == 0) {
                let lamp = &world.lamps.all()[entry.starts.lamp];
                for _ in 0..POINTS {
                    even.add(joined.brings(entry, lamp, film, &lamp.sample_point(rng.pair())));
                    let (point, density) = entry.starts.aim(lamp, film, world.eye.pupil_radius_m(), rng.pair());
                    aimed.add(joined.brings(entry, lamp, film, &point) / density);
                }
            }
        }
    }
    let count = (4 * PLACES * POINTS) as f64;
    let ((a, of_a), (b, of_b)) = (even.mean(count), aimed.mean(count));
    assert!(a > 0.0 && (a - b).abs() < 4.0 * (of_a + of_b).sqrt(), "{a} +- {}, {b} +- {}", of_a.sqrt(), of_b.sqrt());
    // The bound bites: 5 % would be seen.
    assert!(4.0 * (of_a + of_b).sqrt() < 0.05 * a, "{a} +- {}, {b} +- {}", of_a.sqrt(), of_b.sqrt());
    assert!(aimed.0[2] > 1.5 * even.0[2] && of_b < 0.6 * of_a, "{:?} and {:?}", even.0, aimed.0);
}

/// Pixels at the rim of the LED's picture are joined more often than those in its middle.
#[test]
fn rims_are_joined_more_often() {
    let scene = generate::scene(409);
    let ready = Ready::new(&scene, 0.0).unwrap();
    let plan = plan(&ready.checked, &ready.world, Choice::Auto);
    let optics = Mono::<f64>::optics(&ready.world, 0, 0);
    let connections = Connections::new(&ready.world, &optics, &plan.connections);
    let rims = Rims::new(&ready.world, &connections);
    let times = |x: u64, y: u64| rims.times(x + 32 * y);
    assert_eq!([times(16, 12), times(10, 8), times(20, 15)], [1; 3]);
    assert!([times(0, 16), times(31, 16), times(2, 22)].into_iter().all(|times| times > 3));
    // None of them costs as much as all others together.
    let all: u64 = (0..32 * 24).map(|pixel| rims.times(pixel)).sum();
    assert!((800..2000).contains(&all), "{all}");
}
