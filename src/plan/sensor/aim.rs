//! Which lamps are traced from a sensor, and where the paths of the others start.

use super::Setting;
use super::tuning::aim::{ENOUGH, MOST_WIDE, NARROW, SEEDED, SEEDS, TRIAL, WIDE};
use crate::pilots::{Look, Narrow, SEED};
use eyebox_base::ids::GroupId;
use eyebox_base::rng::{Rng, Stream};
use eyebox_estimate::ShouldStop;
use eyebox_estimate::sensor::{Backward, Caught, Forward, paths_of_pass};
use eyebox_film::guide::{Even, Guide, Point, Sample};
use eyebox_world::World;
use eyebox_world::mode::Mono;
use eyebox_world::sensor::SensorFace;

/// How a sensor's light is traced.
pub(super) struct Aim {
    /// Per light group: its lamps are looked for from the sensor.
    pub from_sensor: Vec<bool>,
    /// Where paths of the other lamps start; none if none of them is on.
    pub guide: Option<Guide>,
}

/// A pilot's paths to a sensor. Its light groups are all one: what brings light is looked for, whoever sent it.
struct ToSensor<'w>(Forward<'w, Mono>);

impl Look for ToSensor<'_> {
    fn probe(&self, pass: u64, stop: &ShouldStop<'_>) -> Vec<Sample> {
        self.0.probe(pass, stop)
    }
    fn density(&self, lamp: usize, x: &Point) -> f64 {
        self.0.density(lamp, x)
    }
    fn flux(&self) -> &[f64] {
        self.0.flux()
    }
    fn group_of(&self, _: usize) -> GroupId {
        GroupId::from_index(0)
    }
}

/// What the paths of a light group bring in a trial: their sum, and that of their squares, which is the variance of all
/// pixels together.
#[derive(Debug, Clone, Copy, Default)]
struct Brought {
    sum: f64,
    squares: f64,
}

impl Brought {
    /// More than a few paths have brought it.
    fn is_sure(self) -> bool {
        self.sum > 3.0 * self.squares.sqrt()
    }

    /// Whether it is by these paths that the light is to be found: with less noise, and no less of it; or what the others miss.
    fn is_better_than(self, other: Brought) -> bool {
        (self.squares < other.squares && self.sum > 0.5 * other.sum) || (self.is_sure() && self.sum > 2.0 * other.sum)
    }
}

/// Decides for each light group whether its light is found with less noise from its lamps or from the sensor, by a trial of both,
/// and learns where paths from the lamps start.
pub(super) fn aim(setting: &Setting<'_>, sensor: &SensorFace, stop: &ShouldStop<'_>) -> Aim {
    let groups = setting.scene.groups.len();
    let mut from_sensor = vec![false; groups];
    let first = guide(setting, sensor, &from_sensor, stop);
    let open = findable(setting.world, groups);
    if first.is_none() || !open.contains(&true) || stop() {
        return Aim { from_sensor, guide: first };
    }
    let (world, watts, paths) = (setting.world, setting.watts_per_lumen.as_slice(), paths_of_pass(sensor.pixels));
    let forward = Forward::<Mono>::new(world, sensor, (watts, &from_sensor), paths, first.as_ref(), SEED);
    let backward = Backward::<Mono>::new(world, (sensor, &open), watts, paths, SEED);
    let tried = |pass: &dyn Fn(u64) -> Vec<Caught>| {
        let mut brought = vec![Brought::default(); groups];
        for caught in (0..TRIAL).flat_map(pass) {
            let of = &mut brought[caught.group.index()];
            of.sum += caught.lumens;
            of.squares += caught.lumens * caught.lumens;
        }
        brought
    };
    let (by_lamps, by_sensor) = (tried(&|pass| forward.pass(pass)), tried(&|pass| backward.pass(pass)));
    for (group, own) in from_sensor.iter_mut().enumerate() {
        *own = open[group] && by_sensor[group].is_better_than(by_lamps[group]);
    }
    // The guide belongs to the lamps that are left.
    let guide = if from_sensor.contains(&true) { guide(setting, sensor, &from_sensor, stop) } else { first };
    Aim { from_sensor, guide }
}

/// Per light group: all of its lamps can be met by a ray.
fn findable(world: &World, groups: usize) -> Vec<bool> {
    let mut open = vec![false; groups];
    world.lamps.all().iter().for_each(|lamp| open[lamp.group.index()] = true);
    world.lights.all().iter().for_each(|light| open[light.group().index()] = true);
    let sightless = world.lights.all().iter().filter(|light| !light.is_visible());
    sightless.for_each(|light| open[light.group().index()] = false);
    open
}

/// Where paths from lamps have to start to get to a sensor; none if none of them is on.
fn guide(setting: &Setting<'_>, sensor: &SensorFace, left_out: &[bool], stop: &ShouldStop<'_>) -> Option<Guide> {
    let of_groups = (setting.watts_per_lumen.as_slice(), left_out);
    let with =
        |guide: Option<&Guide>, paths| ToSensor(Forward::new(setting.world, sensor, of_groups, paths, guide, SEED));
    let flux = with(None, 1).flux().to_vec();
    if flux.is_empty() {
        return None;
    }
    let wide = Guide::wide(&flux);
    let mut narrow = Narrow::new(&flux, Vec::new());
    // Looks without a guide first: of light that comes by starts all over a lamp, a few among many that bring more, they show
    // enough to tell where it is. In a guided look those would be rare, and each heavy.
    let mut traced = 0;
    while narrow.found() < ENOUGH && traced < MOST_WIDE && !stop() {
        let paths = WIDE.max(traced);
        narrow.look(|_, paths| with(Some(&wide), paths), paths, stop);
        traced += paths;
    }
    let seeds = seeds(setting, sensor, &with(None, 1).0);
    if !seeds.is_empty() && !stop() {
        let seeded = Guide::learn(&flux, &seeds, Even::MANY);
        narrow.look(|_, paths| with(Some(&seeded), paths), SEEDED, stop);
    }
    for paths in NARROW {
        if narrow.found() > 0 && !stop() {
            narrow.look(|guide, paths| with(Some(guide), paths), paths, stop);
        }
    }
    Some(narrow.learn())
}

/// Starts on distant lamps that may lead to a sensor: those whose light passes the places where rays from the sensor leave the
/// scene, the more the nearer their direction is to the lamp's. What they bring is for a look to find out.
fn seeds(setting: &Setting<'_>, sensor: &SensorFace, forward: &Forward<'_, Mono>) -> Vec<Sample> {
    let lights = setting.world.lights.all();
    if lights.iter().all(|light| light.direction().is_none()) {
        return Vec::new();
    }
    let backward = Backward::<Mono>::new(setting.world, (sensor, &[]), &setting.watts_per_lumen, SEEDS, SEED);
    let ways = backward.ways_out(SEEDS);
    let mut rng = Rng::new(SEED, Stream::SensorSky, 1, 0);
    let mut out = Vec::new();
    for (index, light) in lights.iter().enumerate() {
        let (Some(lamp), Some(dir)) = (forward.place_of_light(index), light.direction()) else { continue };
        for (place, leaves) in &ways {
            let Some([u, v]) = light.passing(*place) else { continue };
            let [a, b] = rng.pair();
            let weight = light.flux_lm() * (0.5 - 0.5 * dir.dot(*leaves)).powi(4);
            out.push(Sample { lamp, x: [a, b, u, v], weight });
        }
    }
    out
}
