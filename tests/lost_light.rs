//! Light that is easy to miss: small lamps beside a large one, straight, through holes, in mirrors, behind plates, from a part of the
//! pupil. Each has a closed form, and whatever passes show the picture has it, within what it states.

use crate::common::*;
use eyebox::base::ids::GroupId;
use eyebox::check::check;
use eyebox::estimate::run::{Films, Limits, begin, drive};
use eyebox::film::plan::{Estimator, Plan};
use eyebox::estimate::witness::Witness;
use eyebox::film::witness;
use eyebox::plan::{Asked, Choice, Guides, plan};
use eyebox::scene::{Face, Finish, Photometry, Scene};
use eyebox::world::World;
use eyebox::world::mode::Mono;
use glam::DVec3;

const SIZE: [usize; 2] = [24, 16];
const RIGHT: usize = SIZE[0] / 2;
const EVEN: f64 = 1000.0;
/// Of all the light, about.
const SHARE: f64 = 0.05;

/// The left half of the picture is an even lamp 0.5 m away, in focus. Returns the sum of all pixels' luminance that the other half is
/// to have, and the area of a pixel in tangents.
fn half() -> (Scene, GroupId, f64, f64) {
    let mut s = scene();
    s.eye.fov_deg = 12.0;
    s.eye.resolution = SIZE;
    s.eye.focus_distance_m = 0.5;
    let group = add_group(&mut s, "main");
    let mut panel = face(Finish::Absorber);
    panel.emitter = lamp(group, EVEN);
    let quad = quad(DVec3::new(-0.5, 0.0, -0.5), DVec3::X * 0.49, DVec3::Y * 0.5);
    add_part(&mut s, "panel", mesh(&[quad]), DVec3::ZERO, None, vec![panel]);
    let pixel = 2.0 * 6f64.to_radians().tan() / SIZE[0] as f64;
    (s, group, SHARE * EVEN * (SIZE[0] * SIZE[1]) as f64 / 2.0, pixel * pixel)
}

fn shines(group: GroupId, luminance: f64) -> Face {
    Face { emitter: lamp(group, luminance), ..face(Finish::Absorber) }
}

/// A rectangle that faces the eye.
fn facing(at: DVec3, half: [f64; 2]) -> Vec<DVec3> {
    quad(at, DVec3::X * half[0], DVec3::Y * half[1])
}

/// A wall with a hole of these half sides.
fn wall(at: DVec3, [a, b]: [f64; 2]) -> [Vec<DVec3>; 4] {
    const WIDE: f64 = 0.03;
    let (w, h) = (0.5 * (WIDE - a), 0.5 * (WIDE - b));
    [
        facing(at + DVec3::X * (a + w), [w, WIDE]),
        facing(at - DVec3::X * (a + w), [w, WIDE]),
        facing(at + DVec3::Y * (b + h), [a, h]),
        facing(at - DVec3::Y * (b + h), [a, h]),
    ]
}

fn absorbers(count: usize) -> Vec<Face> {
    vec![face(Finish::Absorber); count]
}

/// A lamp of a fraction of a pixel in plain view, wide or long, in focus or not.
fn plain(half_m: [f64; 2], distance: f64) -> (Scene, f64) {
    let (mut s, group, want, cell) = half();
    let at = DVec3::new(0.05, 0.013, -1.0) * distance;
    let tangents = 4.0 * half_m[0] * half_m[1] / (distance * distance);
    add_part(
        &mut s,
        "lamp",
        mesh(&[facing(at, half_m)]),
        DVec3::ZERO,
        None,
        vec![shines(group, want * cell / tangents)],
    );
    (s, want)
}

/// A large lamp through a small hole.
fn through_a_hole(half_m: [f64; 2]) -> (Scene, f64) {
    let (mut s, group, want, cell) = half();
    let hole = DVec3::new(0.05, -0.02, -1.0) * 0.3;
    add_part(&mut s, "wall", mesh(&wall(hole, half_m)), DVec3::ZERO, None, absorbers(4));
    let tangents = 4.0 * half_m[0] * half_m[1] / (0.3 * 0.3);
    let lamp = facing(hole * 1.5, [0.008; 2]);
    add_part(&mut s, "lamp", mesh(&[lamp]), DVec3::ZERO, None, vec![shines(group, want * cell / tangents)]);
    (s, want)
}

/// A small flat mirror that shows a lamp beside, larger than it; or a large mirror that shows a small lamp. `apart`: the lamp is a group
/// of its own, and small beside the eye's étendue.
fn in_a_mirror(mirror: f64, lamp_half: f64, apart: bool) -> (Scene, f64) {
    let (mut s, group, want, cell) = half();
    let group = if apart { add_group(&mut s, "other") } else { group };
    let at = DVec3::new(0.05, 0.01, -1.0) * 0.3;
    let out = DVec3::new(1.0, 0.1, 0.5).normalize();
    let normal = (out - at.normalize()).normalize();
    let across = normal.cross(DVec3::Y).normalize();
    let along = normal.cross(across);
    let quad_at = |centre: DVec3, n: DVec3, half: f64| {
        let a = n.cross(DVec3::Y).normalize();
        quad(centre, a.cross(n) * half, a * half)
    };
    let reflector = face(Finish::MirrorIdeal { reflectance: 0.8 });
    add_part(&mut s, "mirror", mesh(&[quad(at, across * mirror, along * mirror)]), DVec3::ZERO, None, vec![reflector]);
    let distance = 0.15;
    let place = at + out * distance;
    // A facet at m looks as large as its area times |n·m|/|m_z|³; the lamp as its mirror image, which stands on the way straight on.
    let tangents = |m: DVec3, n: DVec3, half: f64| 4.0 * half * half * n.dot(m).abs() / m.z.abs().powi(3);
    let image = at + at.normalize() * distance;
    let seen =
        if lamp_half > mirror { tangents(at, normal, mirror) } else { tangents(image, at.normalize(), lamp_half) };
    let lamp = quad_at(place, -out, lamp_half);
    add_part(&mut s, "lamp", mesh(&[lamp]), DVec3::ZERO, None, vec![shines(group, want * cell / (0.8 * seen))]);
    (s, want)
}

/// A small lamp behind a plate, which one half of the pupil sees past a shade. Of n, what all reflections together let through is
/// 2n/(n² + 1).
fn behind_a_plate(apart: bool) -> (Scene, f64) {
    let (mut s, group, want, cell) = half();
    let group = if apart { add_group(&mut s, "other") } else { group };
    let (n, thick, distance, half) = (1.5, 0.006, 0.42, 1e-4);
    let plate = DVec3::new(0.018, 0.014, 0.5 * thick);
    let faces = vec![face(Finish::Absorber); 6];
    let polished = |k: usize| if k >= 4 { face(Finish::Polished) } else { faces[k].clone() };
    let at = DVec3::new(0.02, 0.0, -0.35);
    add_part(&mut s, "plate", mesh(&cuboid(plate)), at, Some(n), (0..6).map(polished).collect());
    let place = DVec3::new(0.02, 0.005, -distance);
    let shade_at = 0.15;
    let edge = place.x * shade_at / (distance - thick * (1.0 - 1.0 / n));
    let shade = quad(DVec3::new(edge + 0.01, 0.0, -shade_at), DVec3::X * 0.01, DVec3::Y * 0.03);
    add_part(&mut s, "shade", mesh(&[shade]), DVec3::ZERO, None, absorbers(1));
    let tangents = 4.0 * half * half / (distance - thick * (1.0 - 1.0 / n)).powi(2);
    let through = 2.0 * n / (n * n + 1.0);
    let luminance = want * cell / (0.5 * through * tangents);
    add_part(&mut s, "lamp", mesh(&[facing(place, [half; 2])]), DVec3::ZERO, None, vec![shines(group, luminance)]);
    (s, want)
}

fn scenes() -> Vec<(&'static str, Scene, f64, f64)> {
    let of = |name, (scene, want): (Scene, f64), by: f64| (name, scene, want, by);
    vec![
        of("small lamp", plain([1e-4, 1e-4], 0.5), 1e-4),
        of("small lamp out of focus", plain([1e-4, 1e-4], 0.25), 1e-4),
        of("line", plain([0.02, 2e-5], 0.5), 1e-3),
        of("hole", through_a_hole([4e-5, 4e-5]), 1e-3),
        of("crack", through_a_hole([1e-5, 3e-3]), 1e-3),
        of("small mirror", in_a_mirror(2e-4, 0.01, false), 2e-3),
        of("small mirror, a group of its own", in_a_mirror(2e-4, 0.01, true), 2e-3),
        of("mirrored lamp", in_a_mirror(5e-3, 1.5e-4, false), 2e-3),
        of("mirrored lamp, a group of its own", in_a_mirror(5e-3, 1.5e-4, true), 2e-3),
        of("plate and half a pupil", behind_a_plate(false), 1e-2),
        of("plate and half a pupil, a group of its own", behind_a_plate(true), 1e-2),
    ]
}

/// Luminance summed over the right half of the picture, and over all of it.
fn sums(films: &Films) -> [f64; 2] {
    let image = image(films);
    let right = (0..image.len()).filter(|pixel| pixel % SIZE[0] > RIGHT);
    [right.map(|pixel| image[pixel].0).sum(), image.iter().map(|(value, _)| value).sum()]
}

struct Judged {
    stated: f64,
    /// Error of the light of the right half, of all light.
    off: f64,
}

/// A run's error. `by`: what the closed form leaves out, of the light that it tells.
fn judged((world, plan, groups): (&World, &Plan, usize), want: f64, limits: &Limits, seed: u64) -> Judged {
    let films = drive(begin(world, plan, groups, SIZE, seed), limits, &mut ()).films;
    let [right, all] = sums(&films);
    let stated = films.relative_error().unwrap_or(f64::INFINITY);
    Judged { stated, off: (right - want) / all.max(want) }
}

/// Whatever is asked for, an error or a number of passes, no picture misses its light, or has more, by more than four of the errors
/// that it states.
#[test]
fn no_light_is_lost_in_silence() {
    let mut faults = Vec::new();
    for (name, scene, want, by) in scenes() {
        let checked = check(&scene).expect("sound");
        let world = World::freeze(&scene).expect("sound");
        let plan = plan(&checked, &world, Choice::Auto);
        for seed in 1..=3 {
            let by_error = Limits { error: Some(0.02), adaptive: true, ..Limits::default() };
            let by_passes = Limits { passes: Some(16), ..Limits::default() };
            for limits in [by_error, by_passes] {
                let Judged { stated, off } = judged((&world, &plan, scene.groups.len()), want, &limits, seed);
                println!("{name}, seed {seed}, {:?}: {off:+.4} of the light, {stated:.4} stated", limits.error);
                if off.abs() > 4.0 * stated.min(0.1) + by * SHARE {
                    faults.push(format!("{name}, seed {seed}, {:?}: {off:+.4}, {stated:.4} stated", limits.error));
                }
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// What the plan knows of small images is worth it: the light of four passes is within a fifth of what it is (eight seeds; a crack of a
/// hundredth of a pixel is the worst, most are within a twentieth). Without, it is
/// missing from some pictures, and what is stated says that it may be.
#[test]
fn images_of_lamps_are_in_the_first_passes() {
    for (name, scene, want, by) in scenes().into_iter().filter(|(name, ..)| !name.contains("group")) {
        let checked = check(&scene).expect("sound");
        let world = World::freeze(&scene).expect("sound");
        let known = plan(&checked, &world, Choice::Auto);
        let blind = plan(&checked, &world, Asked { guides: Guides::Off, ..Asked::default() });
        assert!(!known.glints.is_empty() && blind.glints.is_empty(), "{name}: {}", known.glints.len());
        let limits = Limits { passes: Some(4), ..Limits::default() };
        let (mut worst, mut without) = (0.0f64, 0.0f64);
        for seed in 1..=8 {
            let found = judged((&world, &known, scene.groups.len()), want, &limits, seed);
            worst = worst.max(found.off.abs() / SHARE);
            let found = judged((&world, &blind, scene.groups.len()), want, &limits, seed);
            without = without.max(found.off.abs() / SHARE);
            assert!(
                found.off.abs() < 4.0 * found.stated,
                "{name}, blind: {:+.4}, {:.4} stated",
                found.off,
                found.stated
            );
        }
        println!("{name}: {} glints, off by {worst:.4} of the light, blind {without:.4}", known.glints.len());
        assert!(worst < 0.2 + by, "{name}: {worst}");
        assert!(without > 2.0 * worst, "{name}: {without} {worst}");
    }
}

/// What rays from the eye trace themselves has a witness, too: light followed from its lamps. It leaves pictures alone that have it, and
/// names the part of one from which a small lamp, or a screen that is lit by one, is missing.
#[test]
fn what_rays_from_the_eye_lose_is_followed_from_the_lamps() {
    followed("small lamp", &plain([1e-4, 1e-4], 0.5).0, 64, 3);
    followed("lit screen", &lit_screen(), 64, 3);
}

long! {
/// The same of a lamp behind a hole, which few of the paths that are aimed get through.
#[test]
fn what_is_lost_behind_a_hole_is_followed_from_the_lamps() {
    followed("hole", &through_a_hole([4e-5, 4e-5]).0, 512, 4);
}
}

fn followed(name: &str, scene: &Scene, passes: u64, seeds: u64) {
    let mut dark = scene.clone();
    let lamp = dark.parts.last_mut().and_then(|part| part.faces.last_mut()).and_then(|face| face.emitter.as_mut());
    lamp.expect("it shines").photometry = Photometry::LuminanceCdM2(1e-9);
    let planned = |scene: &Scene| {
        let world = World::freeze(scene).expect("sound");
        let asked = Asked { choice: Choice::Only(Estimator::Backward), ..Asked::default() };
        let plan = plan(&check(scene).expect("sound"), &world, asked);
        (world, plan)
    };
    let groups = scene.groups.len();
    let [(world, plan), (dark_world, dark_plan)] = [scene, &dark].map(planned);
    for seed in 1..=seeds {
        let mut watching =
            Witness::<Mono<f64>>::new(&world, &plan, groups, (SIZE, None), seed).expect("lamps are followed");
        watching.attend(&(0..passes).map(|pass| (pass, 6_000_000)).collect::<Vec<_>>());
        let judged = |world: &World, plan: &Plan| {
            let mut tracing = begin(world, plan, groups, SIZE, seed);
            tracing.step(32);
            let films = tracing.into_films();
            witness::judge(&watching.record, &films.films.iter().map(|(_, film, _)| film).collect::<Vec<_>>())
        };
        let sound = judged(&world, &plan);
        let own = sound.judged.iter().find(|own| own.from_lamps).expect("lamps are followed");
        let [ratio, error] = own.ratio.expect("they are seen");
        println!("{name}, seed {seed}: {ratio:.4} ± {error:.4}, {} samples", own.looks);
        assert!(!sound.is_off() && (ratio - 1.0).abs() < 4.0 * error, "{name}, seed {seed}: {own:?}");
        assert!(error < 0.2, "{name}, seed {seed}: {own:?}");
        let off = judged(&dark_world, &dark_plan).judged.into_iter().find_map(|own| own.off);
        let off = off.unwrap_or_else(|| panic!("{name}, seed {seed}: nothing is missed"));
        let right = off.columns.is_none_or(|[_, last]| last > RIGHT);
        assert!(off.sigmas < -4.0 && right, "{name}, seed {seed}: {off:?}");
    }
}

/// A white screen in the right half of the picture, lit from the side by a lamp that no ray sees.
fn lit_screen() -> Scene {
    let (mut s, group, ..) = half();
    let screen = face(Finish::Lambert { reflectance: 0.8, transmittance: 0.0 });
    let wide = facing(DVec3::new(0.04, 0.0, -0.5), [0.02, 0.05]);
    add_part(&mut s, "screen", mesh(&[wide]), DVec3::ZERO, None, vec![screen]);
    let lamp = quad(DVec3::new(0.2, 0.0, -0.45), DVec3::Z * 0.01, DVec3::Y * 0.01);
    add_part(&mut s, "lamp", mesh(&[lamp]), DVec3::ZERO, None, vec![shines(group, 1e6)]);
    s
}
