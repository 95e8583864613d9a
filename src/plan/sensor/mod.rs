//! Sensors: maps of the light that arrives at faces. Definitions are in `docs/sensor.md`.

mod aim;
pub mod frame;
mod map;
pub mod table;
mod tuning;

use super::{Polarisation, mode};
use aim::{Aim, aim};
use eyebox_base::error::Result;
use eyebox_base::{Error, Where};
use eyebox_check::check;
use eyebox_estimate::ShouldStop;
use eyebox_estimate::sensor::{Backward, Caught, Forward, paths_of_pass};
use eyebox_film::plan::Spectral;
use eyebox_scene::{Eye, Finish, Scene, Spectrum, Wavelengths};
use eyebox_world::World;
use eyebox_world::mode::{Hero, Mode, Mono};
use eyebox_world::sensor::SensorFace;
use eyebox_world::stokes::Stokes;
use glam::DVec3;
use map::Sums;
pub use map::{Level, SensorMap, Share, SideMap};
use std::time::{Duration, Instant};
use tuning::sensor::{FIRST_LOOK, PASSES};

/// What is asked for.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SensorAsked {
    /// Most passes of each sensor; 64 where no limit is given.
    pub passes: Option<u64>,
    /// Most time of each sensor, asked after each pass.
    pub time: Option<Duration>,
    /// The relative error of a map, [`SensorMap::error`], at which it is done.
    pub error: Option<f64>,
    pub seed: u64,
    pub polarisation: Polarisation,
    /// All light is looked for from the sensor, to compare with: what points and parallel light give is not found.
    pub backward: bool,
    /// Parts whose sensors count: a path or a name.
    pub only: Option<String>,
}

/// What all sensors of a scene share.
struct Setting<'s> {
    scene: &'s Scene,
    world: &'s World,
    asked: &'s SensorAsked,
    spectral: Spectral,
    polarised: bool,
    /// Per light group; empty where watts are not told.
    watts_per_lumen: Vec<f64>,
    tells_watts: bool,
}

/// Measures all sensors of a scene, or those of the part that is asked for, in the order of parts and faces; `progress` hears
/// of each that is done, and of how many. None if `stop` said true. The eye is not there: it takes no light. Errors: a scene
/// that cannot be traced, no sensor, a face that has no mean plane.
pub fn measure(
    scene: &Scene,
    asked: &SensorAsked,
    stop: &ShouldStop<'_>,
    mut progress: impl FnMut(usize, usize),
) -> Result<Option<Vec<SensorMap>>> {
    let scene = &with_planes_in_the_air(scene);
    let checked = check(scene)?;
    let world = World::freeze(scene)?.seen_by(&Eye { pupil_diameter_m: 0.0, ..scene.eye.clone() })?;
    let sensors = sensors(scene, &world, asked.only.as_deref())?;
    // Polarisation can matter where light meets two oblique faces; it costs little to be sure.
    let polarised = match asked.polarisation {
        Polarisation::On => true,
        Polarisation::Off => false,
        Polarisation::Auto => checked.facts().specular,
    };
    let (spectral, watts_per_lumen) =
        spectral(scene, mode::decide(&checked, &world, Polarisation::Off, stop).spectral)?;
    let tells_watts = spectral == Spectral::Hero || watts_per_lumen.iter().any(|watts| *watts > 0.0);
    let setting = Setting { scene, world: &world, asked, spectral, polarised, watts_per_lumen, tells_watts };
    let mut maps = Vec::with_capacity(sensors.len());
    for sensor in &sensors {
        let of_sensor = match (setting.spectral, setting.polarised) {
            (Spectral::Mono, false) => run::<Mono<f64>>,
            (Spectral::Mono, true) => run::<Mono<Stokes>>,
            (Spectral::Rgb | Spectral::Hero, false) => run::<Hero<f64>>,
            (Spectral::Rgb | Spectral::Hero, true) => run::<Hero<Stokes>>,
        };
        let Some(map) = of_sensor(&setting, sensor, stop)? else { return Ok(None) };
        maps.push(map);
        progress(maps.len(), sensors.len());
    }
    Ok(Some(maps))
}

/// How wavelengths are traced, and the watts of a lumen of each light group where they are not. Watts are asked for, so three
/// primaries do not do.
fn spectral(scene: &Scene, smallest: Spectral) -> Result<(Spectral, Vec<f64>)> {
    let none = vec![0.0; scene.groups.len()];
    match (scene.wavelengths, smallest) {
        // What the light has beside its one wavelength nobody knows.
        (Wavelengths::Mono { .. }, _) => Ok((Spectral::Mono, none)),
        (Wavelengths::Visible, Spectral::Rgb | Spectral::Hero) => Ok((Spectral::Hero, none)),
        (Wavelengths::Visible, Spectral::Mono) => {
            let Ok(spectra) = scene.spectra_of_groups() else { return Ok((Spectral::Hero, none)) };
            let watts = |spectrum: &Option<Spectrum>| match spectrum {
                None => Ok(0.0),
                Some(spectrum) => spectrum.resolve().map(|power| power.luminous_normalised().watts()),
            };
            let all: std::result::Result<Vec<f64>, String> = spectra.iter().map(watts).collect();
            all.map(|watts| (Spectral::Mono, watts)).map_err(|what| Error::new(Where::Nowhere, what))
        }
    }
}

fn sensors(scene: &Scene, world: &World, only: Option<&str>) -> Result<Vec<SensorFace>> {
    let mut found = Vec::new();
    let mut paths = Vec::new();
    for (index, part) in scene.parts.iter().enumerate() {
        if part.faces.iter().all(|face| face.sensor.is_none()) {
            continue;
        }
        paths.push(part.path.as_str());
        if only.is_some_and(|only| part.path != only && part.name != only) {
            continue;
        }
        for face in 0..part.faces.len() {
            found.extend(SensorFace::build(scene, &world.geometry, [index, face])?);
        }
    }
    match (found.is_empty(), only) {
        (false, _) => Ok(found),
        (true, Some(only)) if !paths.is_empty() => {
            Err(Error::new(Where::Option("--part".to_owned()), format!("no sensor is on `{only}`"))
                .expected(format!("one of {}", paths.join(", ")))
                .nearest(only, paths))
        }
        (true, _) => Err(Error::new(Where::Nowhere, "the scene has no sensor")
            .expected("`sensor = { pixels = [64, 32] }` on a face, e.g. --set 'LCD.sensor={ pixels = [64, 32] }'")),
    }
}

/// What is measured in the air: a face that light does not meet is traced as a sheet that does nothing to it.
fn with_planes_in_the_air(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    for part in &mut scene.parts {
        let mesh = scene.meshes.get(part.mesh.index());
        for (number, face) in part.faces.iter_mut().enumerate() {
            let is_none = face.finish == Finish::None && face.slide.is_none() && face.emitter.is_none();
            if face.sensor.is_some() && is_none {
                let edge = mesh.and_then(|mesh| {
                    mesh.faces.get(number)?.triangles().find_map(|index| {
                        let [a, b, _] = mesh.triangles.get(index)?.map(|vertex| mesh.positions.get(vertex as usize));
                        let ([x, y, z], [u, v, w]) = (a?, b?);
                        DVec3::new(f64::from(u - x), f64::from(v - y), f64::from(w - z)).try_normalize()
                    })
                });
                // A face without a triangle is told where sensors are made.
                face.finish = Finish::Retarder { axis: edge.unwrap_or(DVec3::X), retardance_nm: 0.0 };
            }
        }
    }
    scene
}

/// The map of one sensor. None if `stop` said true.
fn run<M: Mode>(setting: &Setting<'_>, sensor: &SensorFace, stop: &ShouldStop<'_>) -> Result<Option<SensorMap>> {
    let Setting { scene, world, asked, watts_per_lumen, .. } = setting;
    let groups = scene.groups.len();
    let paths = paths_of_pass(sensor.pixels);
    let Aim { from_sensor, guide } =
        if asked.backward { Aim { from_sensor: vec![true; groups], guide: None } } else { aim(setting, sensor, stop) };
    let of_groups = (watts_per_lumen.as_slice(), from_sensor.as_slice());
    let forward = guide.map(|guide| Forward::<M>::new(world, sensor, of_groups, paths, Some(&guide), asked.seed));
    let looks = from_sensor.contains(&true) || world.sky.as_ref().is_some_and(|sky| sky.integral() > 0.0);
    let backward = looks.then(|| Backward::<M>::new(world, (sensor, &from_sensor), watts_per_lumen, paths, asked.seed));
    let unlimited = asked.passes.is_none() && asked.time.is_none() && asked.error.is_none();
    let passes = if unlimited { PASSES } else { asked.passes.unwrap_or(u64::MAX) };
    let (mut sums, begun) = (Sums::new(sensor, groups), Instant::now());
    let dark = forward.is_none() && backward.is_none();
    while sums.passes() < passes && !dark {
        if stop() {
            return Ok(None);
        }
        let pass = sums.passes();
        let from_lamps: Vec<Caught> = forward.iter().flat_map(|forward| forward.pass(pass)).collect();
        let to_sky = backward.iter().flat_map(|backward| backward.pass(pass));
        sums.add(sensor, from_lamps.into_iter().chain(to_sky));
        let late = asked.time.is_some_and(|time| begun.elapsed() >= time);
        // Errors are looked at when passes have doubled: looking at each would stop at lucky ones.
        let looked = sums.passes() >= FIRST_LOOK && sums.passes().is_power_of_two();
        let met = looked && asked.error.zip(sums.error(sensor)).is_some_and(|(asked, error)| error <= asked);
        // Where nothing ever arrives no error is ever known.
        let hopeless = asked.passes.is_none() && asked.time.is_none() && sums.is_black() && sums.passes() >= PASSES;
        if late || met || hopeless {
            break;
        }
    }
    let kinds = u64::from(forward.is_some()) + u64::from(backward.is_some());
    sums.map(setting, sensor, kinds * paths * sums.passes()).map(Some)
}
