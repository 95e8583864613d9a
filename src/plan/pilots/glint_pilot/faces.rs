//! Lamps over specular faces: few rays meet a small lamp in a curved mirror, or a small mirror at all. But rays that pass near a lamp say
//! where Newton's iteration should start, and some of them are aimed at each specular face of the scene.

use super::fit::{Moves, Seen, about, pieces, settle};
use super::{Search, Wants, Way};
use crate::pilots::chains::{SEED, train};
use crate::pilots::tuning::glint_pilot::{
    AIMED, AIMED_AT_FACE, AT_A_TIME, CELLS, CLOSER, FEWEST, GROWN, IN_VAIN, KEPT, LEAST, MANY_LAMPS, MANY_MET,
    MOST_LAMPS, MOST_SEGMENTS, MOST_WAYS, RAYS, ROOM, STARTS, STEP, WORTH,
};
use eyebox_base::chain::Chain;
use eyebox_base::lattice::lattice;
use eyebox_base::parallel;
use eyebox_base::rng::{Rng, Stream};
use eyebox_base::warp::{disk, triangle};
use eyebox_estimate::ShouldStop;
use eyebox_estimate::ledger::Ledger;
use eyebox_estimate::manifold::solver::newton::{Family, Target, newton};
use eyebox_estimate::vision::is_looked_about;
use eyebox_estimate::walk::{Meeting, Met, Travel, Walker};
use eyebox_film::glint::Glint;
use eyebox_scene::Scene;
use eyebox_world::World;
use eyebox_world::geometry::Ray;
use eyebox_world::interior::Interior;
use eyebox_world::lamp::Lamp;
use eyebox_world::mode::{Mode, Mono};
use eyebox_world::optics::Optics;
use eyebox_world::surface::Surface;
use glam::{DMat2, DVec2, DVec3};
use std::collections::{BTreeMap, BTreeSet};

/// A ray that goes on towards a lamp.
#[derive(Clone, Copy)]
struct Miss {
    start: Seen,
    /// Sine of the angle by which it misses the sphere about it.
    by: f64,
}

type Ways = BTreeMap<Way, Vec<Miss>>;

/// What a ray and all its branches met.
#[derive(Default)]
struct Looked {
    segments: u32,
    met_specular: bool,
    /// Over a chain: lamps, and the sines of the angles.
    ahead: Vec<(Chain, Vec<(usize, f64)>)>,
    /// Lamps that were met over faces.
    met: Vec<Way>,
}

/// The glints of all lamps by way, by rays through a lattice moved by `shift`.
pub fn find_by_way(
    (world, scene): (&World, &Scene),
    search: Search<'_>,
    shift: [u64; 2],
    stop: &ShouldStop<'_>,
) -> Vec<(Way, Vec<Glint>)> {
    let optics = Mono::<f64>::optics(world, SEED, 0);
    // Rays are about so far apart where there are most, and at first.
    let area = 4.0 * world.eye.half().element_product();
    let [apart, wide] = [RAYS * CLOSER, RAYS].map(|rays| (area / rays as f64).sqrt());
    let Found { mut ways, met, .. } = look((world, scene, &optics), search, (shift, apart), stop);
    nearest_ways(&mut ways, MOST_WAYS);
    let all: Vec<(Way, Vec<Miss>)> = ways.into_iter().collect();
    let solved = |(way, misses): &(Way, Vec<Miss>)| {
        let mut images = images((world, &optics), way, &nearest(misses, apart), wide, stop);
        // A small mirror shows but a part of a lamp, and perhaps not its middle.
        let beside: Vec<Seen> = met.get(way).map_or_else(Vec::new, |rays| {
            rays.iter().filter(|ray| !images.iter().any(|image| image.holds(ray.film, ray.pupil))).copied().collect()
        });
        images.extend(
            around(world, &beside, apart).and_then(|guess| settle((world, &optics), way, guess, Moves::Unknown)),
        );
        let glints = images.iter().flat_map(|image| pieces(world, image)).collect::<Vec<Glint>>();
        (way.clone(), glints)
    };
    parallel::map_all(&all, &solved).into_iter().filter(|(_, glints)| !glints.is_empty()).collect()
}

/// What rays have found.
struct Found {
    /// `[way]`: those that came near a lamp, the nearest and some apart from it, and those that met it.
    ways: Ways,
    met: BTreeMap<Way, Vec<Seen>>,
    /// How far apart those near a lamp are to be.
    apart: f64,
}

impl Found {
    fn add(&mut self, start: Seen, looked: Looked) {
        for way in looked.met {
            let own = self.met.entry(way).or_default();
            if own.len() < MANY_MET {
                own.push(start);
            }
        }
        for (chain, lamps) in looked.ahead {
            for (lamp, by) in lamps {
                let misses = self.ways.entry((chain.clone(), lamp)).or_default();
                misses.push(Miss { start, by });
                if misses.len() >= 4 * KEPT {
                    *misses = nearest(misses, self.apart);
                }
            }
        }
        if self.ways.len() > 8 * MOST_WAYS {
            nearest_ways(&mut self.ways, 4 * MOST_WAYS);
        }
    }

    /// Lamps of which so much was met that a further image of less than a pixel is next to nothing of it.
    fn large(&self) -> BTreeSet<usize> {
        let mut of_lamp: BTreeMap<usize, usize> = BTreeMap::new();
        self.met.iter().for_each(|((_, lamp), rays)| *of_lamp.entry(*lamp).or_default() += rays.len());
        of_lamp.into_iter().filter(|(_, rays)| *rays >= MANY_MET).map(|(lamp, _)| lamp).collect()
    }
}

/// What rays look through.
struct Looking<'l> {
    world: &'l World,
    optics: &'l Optics<Mono>,
    stop: &'l ShouldStop<'l>,
}

impl Looking<'_> {
    /// A place of the pupil by chance, one of a pinhole its middle.
    fn in_pupil(&self, number: u64, k: u64) -> DVec2 {
        let place = Rng::new(SEED, Stream::Pilot, number, k).pair();
        if self.world.eye.pupil_radius_m() > 0.0 { disk(place) } else { DVec2::ZERO }
    }

    fn trace(&self, wants: &Wants<'_>, (k, start): (u64, Seen)) -> Looked {
        let eye = &self.world.eye;
        let (mut looked, mut ledger) = (Looked::default(), Ledger::new(self.world.solids.len()));
        let (origin, (_, dir), ..) = eye.ray_of(start.film, eye.pupil_radius_m() * start.pupil);
        let ray = Ray { origin, dir, from: None };
        let rng = Rng::new(SEED, Stream::Pilot, 3, k);
        let tracing = (self.world, self.optics);
        let walker = Walker::new(tracing, Travel::FromEye, ray, 1.0, Interior::default(), rng).recording();
        follow(walker, wants, &mut looked, &mut ledger);
        looked
    }

    /// Follows numbered rays; returns the numbers of those that met a specular face.
    fn follow_all(&self, wants: &Wants<'_>, rays: &[(u64, Seen)], found: &mut Found) -> Vec<u64> {
        let mut met = Vec::new();
        for rays in rays.chunks(AT_A_TIME) {
            if (self.stop)() {
                break;
            }
            let looked: Vec<Looked> = parallel::map_all(rays, &|ray| self.trace(wants, *ray));
            for ((k, start), looked) in rays.iter().zip(looked) {
                met.extend(looked.met_specular.then_some(*k));
                found.add(*start, looked);
            }
        }
        met
    }
}

/// A few rays through a lattice moved by `shift` all over the picture, the others where those met a specular face, `apart` from
/// each other, and some at each specular face.
fn look(
    (world, scene, optics): (&World, &Scene, &Optics<Mono>),
    Search { wants, takes, .. }: Search<'_>,
    (shift, apart): ([u64; 2], f64),
    stop: &ShouldStop<'_>,
) -> Found {
    let looking = Looking { world, optics, stop };
    let mut found = Found { ways: Ways::new(), met: BTreeMap::new(), apart };
    let [width, height] = world.eye.size().map(|n| n as f64);
    let numbered = |k: u64| {
        let [x, y] = lattice(shift, k);
        (k, Seen { film: world.eye.film_of(0, 0, [x * width, y * height]), pupil: looking.in_pupil(5, k) })
    };
    let cell_of = |k: u64| lattice(shift, k).map(|x| (x * CELLS as f64) as usize);
    let mut beside = vec![false; CELLS * CELLS];
    // Where nothing is looked for those that are aimed at faces will do.
    let first = if (0..world.lamps.all().len()).any(wants) { RAYS } else { 0 };
    for [x, y] in
        looking.follow_all(wants, &(0..first).map(numbered).collect::<Vec<_>>(), &mut found).into_iter().map(cell_of)
    {
        for row in y.saturating_sub(1)..(y + 2).min(CELLS) {
            beside[row * CELLS..][x.saturating_sub(1)..(x + 2).min(CELLS)].fill(true);
        }
    }
    let large = found.large();
    found.ways.retain(|(_, lamp), _| !large.contains(lamp));
    let wants = |lamp: usize| wants(lamp) && !large.contains(&lamp);
    let is_beside = |k: &u64| {
        let [x, y] = cell_of(*k);
        beside[y * CELLS + x]
    };
    // Each ray asks for each lamp.
    let any = (0..world.lamps.all().len()).any(wants);
    let closer = if world.lamps.all().len() > MANY_LAMPS || !any { 1 } else { CLOSER };
    looking.follow_all(&wants, &(RAYS..RAYS * closer).filter(is_beside).map(numbered).collect::<Vec<_>>(), &mut found);
    let aimed = aimed((world, scene), &|k| looking.in_pupil(6, k));
    looking.follow_all(&wants, &(RAYS * CLOSER..).zip(aimed).collect::<Vec<_>>(), &mut found);
    // Images that many rays meet are found by those of the pixels.
    let Found { ways, met, .. } = &mut found;
    ways.retain(|way, _| met.get(way).is_none_or(|rays| rays.len() < MANY_MET));
    met.retain(|way, rays| rays.len() < MANY_MET && (wants(way.1) || takes(way)));
    for way in met.keys() {
        ways.entry(way.clone()).or_default();
    }
    found
}

/// Rays at points of all faces that reflect or bend light, some at each however small it is.
fn aimed((world, scene): (&World, &Scene), pupil: &dyn Fn(u64) -> DVec2) -> Vec<Seen> {
    let is_specular = |surface: &Surface| match surface {
        Surface::Mirror(_) | Surface::Splitter(_) | Surface::Grating(_) | Surface::Interface(_) | Surface::Sheet(_) => {
            true
        }
        Surface::Scatter(scatter) => scatter.specular() > 0.0,
        Surface::Absent | Surface::Absorber | Surface::Slide(_) => false,
    };
    let faces: Vec<(usize, usize)> = (0..world.faces.len())
        .flat_map(|part| (0..world.faces[part].len()).map(move |face| (part, face)))
        .filter(|(part, face)| is_specular(&world.faces[*part][*face].surface))
        .collect();
    // Of very many some.
    let each = (AIMED / faces.len().max(1)).clamp(1, AIMED_AT_FACE);
    let step = faces.len().div_ceil(AIMED).max(1);
    let mut starts = Vec::new();
    for (part, face) in faces.into_iter().step_by(step) {
        let Some(mesh) = scene.parts.get(part).and_then(|part| scene.meshes.get(part.mesh.index())) else { continue };
        let Some(range) = mesh.faces.get(face) else { continue };
        let to_world = world.geometry.part_to_world(part as u32);
        for _ in 0..each {
            let k = starts.len() as u64;
            let mut rng = Rng::new(SEED, Stream::Pilot, 7, k);
            let index = f64::from(range.first) + rng.uniform() * f64::from(range.count);
            let Some(corners) = mesh.triangles.get(index as usize) else { continue };
            let corner = |k: usize| {
                let [x, y, z] = *mesh.positions.get(corners[k] as usize)?;
                Some(to_world.transform_point3(DVec3::new(x.into(), y.into(), z.into())))
            };
            let (Some(a), Some(b), Some(c)) = (corner(0), corner(1), corner(2)) else { continue };
            let [u, v, w] = triangle(rng.pair());
            let pupil = pupil(k);
            let towards = world.eye.towards(a * w + b * u + c * v, world.eye.pupil_radius_m() * pupil);
            let within = towards.map(|(film, _)| film).filter(|film| world.eye.pixel_of(*film).is_some());
            starts.extend(within.map(|film| Seen { film, pupil }));
        }
    }
    starts
}

fn follow(mut walker: Walker<'_, Mono>, wants: &Wants<'_>, looked: &mut Looked, ledger: &mut Ledger) {
    loop {
        looked.segments += 1;
        if looked.segments > MOST_SEGMENTS {
            return;
        }
        if let Some(chain) = walker.chain().filter(|chain| !chain.0.is_empty()) {
            looked.met_specular = true;
            let missed_by = |lamp: &Lamp| {
                let (centre, radius) = lamp.around();
                let towards = centre - walker.ray.origin;
                let by = (towards.cross(walker.ray.dir).length() - radius).max(0.0) / towards.length();
                // However far beside: where one curved mirror shows another, few rays meet both, and their directions lie
                // as far apart as can be. What leads nowhere is tried last.
                (towards.dot(walker.ray.dir) > 0.0 && by <= 1.0).then_some(by)
            };
            let lamps = walker.world.lamps.all().iter().enumerate().filter(|(lamp, _)| wants(*lamp));
            let mut lamps: Vec<(usize, f64)> = lamps.filter_map(|(k, lamp)| Some((k, missed_by(lamp)?))).collect();
            if lamps.len() > MOST_LAMPS {
                lamps.sort_by(|a, b| a.1.total_cmp(&b.1));
                lamps.truncate(MOST_LAMPS);
            }
            if !lamps.is_empty() {
                looked.ahead.push((chain.clone(), lamps));
            }
        }
        let Met::Face(vertex) = walker.advance(ledger) else { return };
        if let (Some(seen), Some(chain)) = (walker.lamp_at(&vertex), walker.chain())
            && !chain.0.is_empty()
            && (wants(seen.index) || walker.share() >= WORTH)
        {
            looked.met.push((chain.clone(), seen.index));
        }
        let share = walker.share();
        if share > LEAST
            && let Some(reflected) = walker.split(&vertex, LEAST / share, u8::MAX, ledger)
        {
            follow(reflected, wants, looked, ledger);
        }
        match walker.meet(&vertex, ledger) {
            Meeting::Went => {}
            Meeting::Ended | Meeting::Scatter(..) => return,
        }
    }
}

/// The nearest misses that are some rays apart, the nearest one first.
fn nearest(misses: &[Miss], apart: f64) -> Vec<Miss> {
    let mut sorted = misses.to_vec();
    sorted.sort_by(|a, b| a.by.total_cmp(&b.by));
    let mut kept: Vec<Miss> = Vec::new();
    for miss in sorted {
        if kept.len() >= KEPT {
            break;
        }
        if kept.iter().all(|other| other.start.film.distance(miss.start.film) > 3.0 * apart) {
            kept.push(miss);
        }
    }
    kept
}

/// A guess at the image that some rays meet, which are about `apart` from others.
fn around(world: &World, met: &[Seen], apart: f64) -> Option<Glint> {
    if met.is_empty() {
        return None;
    }
    let few = met.len() < FEWEST || world.eye.pupil_radius_m() == 0.0;
    let guess = about(world, met, few.then_some(DMat2::ZERO))?;
    let wide = |axis: [f64; 2]| {
        let long = axis[0].hypot(axis[1]);
        let by = if few { (long + apart) / long } else { GROWN };
        axis.map(|x| by * x)
    };
    Some(Glint { axes: guess.axes.map(wide), ..guess })
}

/// Leaves `most` ways, those with the nearest miss.
fn nearest_ways(ways: &mut Ways, most: usize) {
    if ways.len() <= most {
        return;
    }
    let by = |misses: &Vec<Miss>| misses.iter().fold(f64::INFINITY, |least, miss| least.min(miss.by));
    let mut all: Vec<(Way, Vec<Miss>)> = std::mem::take(ways).into_iter().collect();
    all.sort_by_cached_key(|(_, misses)| by(misses).to_bits());
    all.truncate(most);
    ways.extend(all);
}

/// Where the lamp is seen over a chain: images that starts near it lead to. `wide`: how far apart those are after a few in vain.
fn images(
    (world, optics): (&World, &Optics<Mono>),
    way: &Way,
    starts: &[Miss],
    wide: f64,
    stop: &ShouldStop<'_>,
) -> Vec<Glint> {
    let (mut found, mut in_vain): (Vec<Glint>, Vec<DVec2>) = (Vec::new(), Vec::new());
    for Miss { start: Seen { film, pupil }, .. } in starts {
        if found.len() + in_vain.len() == STARTS || stop() {
            break;
        }
        let is_known = |known: &Glint| known.holds(*film, *pupil) && is_looked_about(&world.eye, known);
        let is_left_out = in_vain.len() >= IN_VAIN && in_vain.iter().any(|other| other.distance(*film) <= 3.0 * wide);
        if is_left_out || found.iter().any(is_known) {
            continue;
        }
        let start = Seen { film: *film, pupil: *pupil };
        match solve((world, optics), way, start).and_then(|image| settle((world, optics), way, image, Moves::Known)) {
            Some(glint) if !found.iter().any(|known| known.holds(DVec2::from_array(glint.middle), DVec2::ZERO)) => {
                found.push(glint)
            }
            Some(_) | None => in_vain.push(*film),
        }
    }
    found
}

/// The image that Newton's iteration comes to from a start, as the derivatives there have it. Whether anything stands in the way
/// it does not know.
fn solve((world, optics): (&World, &Optics<Mono>), (chain, lamp): &Way, start: Seen) -> Option<Glint> {
    let radius_m = world.eye.pupil_radius_m();
    let train = train((world, optics), &chain.reversed(), start.film, radius_m * start.pupil)?;
    let lamp = world.lamps.all().get(*lamp)?;
    let (_, radius) = lamp.around();
    let on_lamp = lamp.sample_point([0.5; 2]);
    let target = Target::new(on_lamp.position, on_lamp.normal);
    let index = |part: Option<u32>| optics.index_in(part)[0];
    let from = |pupil: DVec2, near: DVec2| {
        let family = Family::Film { pupil: radius_m * pupil };
        newton(world, &index, &family, near, &train, &target, radius)
    };
    let root = from(start.pupil, start.film)?;
    // How it moves with the pupil, by a step to the nearer side of its middle.
    let step = |axis: DVec2| {
        let by = -STEP * start.pupil.dot(axis).signum();
        Some((from(start.pupil + by * axis, root.u)?.u - root.u) / by)
    };
    let moves = if radius_m > 0.0 { DMat2::from_cols(step(DVec2::X)?, step(DVec2::Y)?) } else { DMat2::ZERO };
    // A box about the lamp's points, as the derivatives by its place have it.
    let by_place: DMat2 = root.slope.inverse();
    let (centre, _) = lamp.around();
    let reach = ROOM * (radius + centre.distance(on_lamp.position));
    let axes = [by_place.x_axis, by_place.y_axis].map(|axis| (axis * reach).to_array());
    let middle = root.u - moves * start.pupil;
    let by_pupil = [moves.x_axis.to_array(), moves.y_axis.to_array()];
    let glint = Glint { middle: middle.to_array(), axes, by_pupil };
    let seen = world.eye.half() + DVec2::from_array(glint.half());
    (seen.is_finite() && glint.is_valid() && middle.abs().cmple(seen).all()).then_some(glint)
}
