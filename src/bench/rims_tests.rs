//! Where little of a lamp is seen through the pupil, connection looks for that little: it brings the same light with less noise.

use super::curve::picture::Picture;
use super::curve::race::Ready;
use super::generate;
use eyebox_base::rng::{Rng, Stream};
use eyebox_estimate::manifold::seeds::connections::{Connections, Entry, index_of};
use eyebox_estimate::manifold::seeds::edge_sampling::EdgeSampling;
use eyebox_estimate::manifold::solver::newton::Target;
use eyebox_estimate::run::begin;
use eyebox_film::plan::Estimator;
use eyebox_plan::{Choice, plan};
use eyebox_scene::{FaceRange, Scene};
use eyebox_world::World;
use eyebox_world::lamp::{Lamp, LampPoint};
use eyebox_world::mode::{Mode, Mono};
use eyebox_world::optics::Optics;
use glam::{DVec2, Vec3};

/// Places in each pixel, and points of the lamp for each.
const PLACES: u64 = 24;
const POINTS: u64 = 4000;

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

/// What even points and aimed ones bring: means, variances of a point, how many counted, and the standard error of the
/// means' difference, which is taken place by place.
#[derive(Debug, Default)]
struct Compared {
    means: [f64; 2],
    variances: [f64; 2],
    counted: [u64; 2],
    sigma: f64,
}

/// At the picture's rim, over the train with most of the light.
fn compare(scene: &Scene) -> Compared {
    let ready = Ready::new(scene, 0.0).unwrap();
    let world = &ready.world;
    let plan = plan(&ready.checked, world, Choice::Auto);
    let optics = Mono::<f64>::optics(world, 0, 0);
    let connections = Connections::new(world, &index_of(&optics), &plan.connections);
    let joined = Joined { world, optics: &optics, connections: &connections };
    let (mut out, mut squares, mut places) = (Compared::default(), [0.0; 2], 0.0);
    for [x, y] in [[29, 4], [0, 16], [31, 13], [2, 21]] {
        for place in 0..PLACES {
            let mut rng = Rng::new(3, Stream::Check, (x + 32 * y) as u64, place);
            let film = world.eye.film_of(x, y, rng.pair());
            for (_, entry) in connections.at(film).filter(|(_, entry)| entry.share > 0.5) {
                let lamp = &world.lamps.all()[entry.starts.lamp];
                let mut sums = [[0.0; 2]; 2];
                for _ in 0..POINTS {
                    let (point, density) = entry.starts.aim(lamp, film, world.eye.pupil_radius_m(), rng.pair());
                    let drawn = [(lamp.sample_point(rng.pair()), 1.0), (point, density)];
                    for (k, (point, density)) in drawn.iter().enumerate() {
                        let value = joined.brings(entry, lamp, film, point) / density;
                        sums[k] = [sums[k][0] + value, sums[k][1] + value * value];
                        out.counted[k] += u64::from(value > 0.0);
                    }
                }
                let count = POINTS as f64;
                let variances = sums.map(|[sum, squares]| squares / count - (sum / count).powi(2));
                out.sigma += variances.iter().sum::<f64>() / count;
                for k in 0..2 {
                    out.means[k] += sums[k][0] / count;
                    squares[k] += variances[k];
                }
                places += 1.0;
            }
        }
    }
    assert!(places > 0.0);
    Compared {
        means: out.means.map(|mean| mean / places),
        variances: squares.map(|variance| variance / places),
        sigma: out.sigma.sqrt() / places,
        ..out
    }
}

/// An LED whose picture fills a third of the pupil, and is seen through its edge at the picture's rim. Before, its points were
/// drawn evenly, and the few that were seen made the rim's pixels the error of the picture: `auto` took 2.3 times as long as
/// light tracing.
#[test]
fn points_of_lamps_are_drawn_where_they_are_seen() {
    let of = compare(&generate::scene(409));
    assert!((of.means[0] - of.means[1]).abs() < 4.0 * of.sigma, "{of:?}");
    // The bound bites.
    assert!(of.means[0] > 0.0 && 4.0 * of.sigma < 0.03 * of.means[0], "{of:?}");
    // Within a place: that less is seen from one place than from another is not theirs to mend.
    assert!(10 * of.counted[1] > 13 * of.counted[0] && of.variances[1] < 0.7 * of.variances[0], "{of:?}");
}

/// The same LED as a grid of many triangles: what is not known of where they lie is not taken for dark.
#[test]
fn finely_meshed_lamps_are_no_noisier() {
    const ALONG: u32 = 10;
    let mut scene = generate::scene(409);
    let part = scene.parts.iter().find(|part| part.faces.iter().any(|face| face.emitter.is_some())).unwrap();
    let mesh = &mut scene.meshes[part.mesh.index()];
    assert_eq!((mesh.positions.len(), mesh.faces.len()), (4, 1));
    let [a, b, _, d] = [0, 1, 2, 3].map(|k| Vec3::from_array(mesh.positions[k]));
    let node = |x: u32, y: u32| a + (b - a) * (x as f32 / ALONG as f32) + (d - a) * (y as f32 / ALONG as f32);
    let nodes = (0..=ALONG).flat_map(|y| (0..=ALONG).map(move |x| (x, y)));
    let positions: Vec<[f32; 3]> = nodes.map(|(x, y)| node(x, y).to_array()).collect();
    let cells = (0..ALONG).flat_map(|y| (0..ALONG).map(move |x| y * (ALONG + 1) + x));
    let triangles: Vec<[u32; 3]> =
        cells.flat_map(|at| [[at, at + 1, at + ALONG + 2], [at, at + ALONG + 2, at + ALONG + 1]]).collect();
    mesh.normals = vec![mesh.normals[0]; positions.len()];
    mesh.faces[0] = FaceRange { first: 0, count: triangles.len() as u32 };
    (mesh.positions, mesh.triangles) = (positions, triangles);
    let of = compare(&scene);
    assert!(of.means[0] > 0.0 && (of.means[0] - of.means[1]).abs() < 4.0 * of.sigma, "{of:?}");
    assert!(of.variances[1] < 1.1 * of.variances[0], "{of:?}");
}

/// The density that comes with a point is the one that it is drawn with: weighted by it, the numbers of a fine grid make up
/// the lamp and its moments, also where light is foretold wrongly or not at all.
#[test]
fn weighted_points_make_up_the_lamp() {
    const GRID: usize = 240;
    let scene = generate::scene(409);
    let ready = Ready::new(&scene, 0.0).unwrap();
    let world = &ready.world;
    let plan = plan(&ready.checked, world, Choice::Auto);
    let optics = Mono::<f64>::optics(world, 0, 0);
    let connections = Connections::new(world, &index_of(&optics), &plan.connections);
    let mut aimed = 0;
    for [x, y] in [[29, 4], [0, 16], [31, 13], [2, 21], [16, 12], [30, 5]] {
        let film = world.eye.film_of(x, y, [0.3, 0.6]);
        let Some((_, entry)) = connections.at(film).find(|(_, entry)| entry.share > 0.5) else { continue };
        let lamp = &world.lamps.all()[entry.starts.lamp];
        let (centre, radius) = lamp.around();
        let moments = |point: &LampPoint, weight: f64| {
            let q = (point.position - centre) / radius;
            [1.0, q.x, q.y, q.x * q.x, q.y * q.y, q.x * q.y].map(|moment| weight * moment / (GRID * GRID) as f64)
        };
        let mut sums = [[0.0; 6]; 2];
        for k in 0..GRID * GRID {
            let uv = [k % GRID, k / GRID].map(|i| (i as f64 + 0.5) / GRID as f64);
            let (point, density) = entry.starts.aim(lamp, film, world.eye.pupil_radius_m(), uv);
            aimed += usize::from(density != 1.0);
            for (sum, more) in
                sums.iter_mut().zip([moments(&lamp.sample_point(uv), 1.0), moments(&point, 1.0 / density)])
            {
                sum.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
            }
        }
        for (even, weighted) in sums[0].iter().zip(sums[1]) {
            assert!((even - weighted).abs() < 0.01, "pixel ({x}, {y}): {sums:?}");
        }
    }
    assert!(aimed > GRID * GRID);
}

/// Pixels at the rim of the LED's picture are joined more often than those in its middle.
#[test]
fn rims_are_joined_more_often() {
    let scene = generate::scene(409);
    let ready = Ready::new(&scene, 0.0).unwrap();
    let plan = plan(&ready.checked, &ready.world, Choice::Auto);
    let optics = Mono::<f64>::optics(&ready.world, 0, 0);
    let connections = Connections::new(&ready.world, &index_of(&optics), &plan.connections);
    let rims = EdgeSampling::new(&ready.world, &connections);
    let times = |x: u64, y: u64| rims.times(x + 32 * y);
    assert_eq!([times(16, 12), times(10, 8), times(20, 15)], [1; 3]);
    assert!([times(0, 16), times(31, 16), times(2, 22)].into_iter().all(|times| times > 3));
    // All of them together cost less than what they are for.
    let all: u64 = (0..32 * 24).map(|pixel| rims.times(pixel)).sum();
    assert!((800..2000).contains(&all), "{all} times for 768 pixels");
}

/// No pixel has an error of its own, a twentieth of the picture's at most: one of those that show a sliver of the LED, a hundredth
/// of what others have, had six tenths of it when joined as seldom as it was foretold to be dark.
#[test]
fn slivers_are_looked_for() {
    const RUNS: u64 = 16;
    let scene = generate::scene(409);
    let ready = Ready::new(&scene, 0.0).unwrap();
    let plan = plan(&ready.checked, &ready.world, Choice::Auto);
    let run = |seed: u64, passes: u64| {
        let mut tracing = begin(&ready.world, &plan, scene.groups.len(), scene.eye.resolution, seed);
        tracing.step(passes);
        Picture::of_films(tracing.films(), scene.eye.resolution).values
    };
    let reference = run(1000, 400);
    let all = reference.len() as f64;
    let dark = 0.01 * reference.iter().sum::<f64>() / all;
    let mut errors = vec![0.0; reference.len()];
    for seed in 0..RUNS {
        for ((error, value), r) in errors.iter_mut().zip(run(seed, 24)).zip(&reference) {
            *error += (value - r).powi(2) / (r * r + dark * dark) / RUNS as f64;
        }
    }
    let worst = errors.iter().fold(0.0, |worst: f64, error| worst.max(*error));
    let whole = errors.iter().sum::<f64>();
    assert!(worst < 0.1 * whole, "{worst} of {whole}");
}

/// What `auto` sees in the pixels that it joins more often is what light tracing sees there.
#[test]
fn rims_are_as_bright_as_by_light_tracing() {
    const RUNS: u64 = 6;
    let scene = generate::scene(409);
    let ready = Ready::new(&scene, 0.0).unwrap();
    let world = &ready.world;
    let of = |choice: Choice, passes: u64| {
        let plan = plan(&ready.checked, world, choice);
        let run = |seed: u64| -> Vec<f64> {
            let mut tracing = begin(world, &plan, scene.groups.len(), scene.eye.resolution, 40 + seed);
            tracing.step(passes);
            Picture::of_films(tracing.films(), scene.eye.resolution).values
        };
        (plan.connections.clone(), (0..RUNS).map(run).collect::<Vec<_>>())
    };
    let (connections, auto) = of(Choice::Auto, 64);
    let (_, light) = of(Choice::Only(Estimator::Forward), 192);
    let optics = Mono::<f64>::optics(world, 0, 0);
    let rims = EdgeSampling::new(world, &Connections::new(world, &index_of(&optics), &connections));
    let rim: Vec<usize> = (0..32 * 24).filter(|pixel| rims.times(*pixel as u64) > 2).collect();
    let sums = |runs: &[Vec<f64>]| {
        let sums: Vec<f64> = runs.iter().map(|run| rim.iter().map(|pixel| run[*pixel]).sum()).collect();
        let mean = sums.iter().sum::<f64>() / RUNS as f64;
        let variance = sums.iter().map(|sum| (sum - mean).powi(2)).sum::<f64>() / (RUNS * (RUNS - 1)) as f64;
        (mean, variance)
    };
    let ((a, of_a), (b, of_b)) = (sums(&auto), sums(&light));
    let sigma = (of_a + of_b).sqrt();
    // Of ten degrees of freedom, and the bound bites.
    assert!(rim.len() > 40 && (a - b).abs() < 4.6 * sigma, "{a} and {b} +- {sigma} in {} pixels", rim.len());
    assert!(4.6 * sigma < 0.05 * a, "{a} and {b} +- {sigma}");
}
