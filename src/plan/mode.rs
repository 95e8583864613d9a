//! Which spectral mode is the smallest that is exact for a scene, and whether polarisation matters: facts decide where
//! they can, a pilot where they cannot.

use super::Polarisation;
use super::tuning::mode::{MATTERS, PROBES_NM};
use eyebox_base::parallel;
use eyebox_base::rng::{Rng, Stream};
use eyebox_check::Checked;
use eyebox_estimate::ShouldStop;
use eyebox_estimate::ledger::Ledger;
use eyebox_estimate::walk::{Meeting, Met, Travel, Walker};
use eyebox_film::plan::{PathMode, Spectral};
use eyebox_scene::{Absorption, CoatingLaw, Finish, Scene, Wavelengths};
use eyebox_world::World;
use eyebox_world::geometry::Ray;
use eyebox_world::interior::Interior;
use eyebox_world::mode::{Mode, MonoStokes};

/// The mode of a scene, with reasons.
pub fn decide(checked: &Checked, world: &World, asked: Polarisation, stop: &ShouldStop<'_>) -> PathMode {
    let (spectral, spectral_because) = spectral(checked.scene(), world);
    let (polarised, polarised_because) = polarised(checked, world, asked, stop);
    PathMode { spectral, spectral_because, polarised, polarised_because }
}

fn spectral(scene: &Scene, world: &World) -> (Spectral, String) {
    if let Wavelengths::Mono { nm } = scene.wavelengths {
        return (Spectral::Mono, format!("the scene is defined at {nm} nm"));
    }
    if let Some(because) = chromatic(scene, world) {
        return (Spectral::Hero, because);
    }
    let tints = world.tints.lamps.iter().chain(&world.tints.lights);
    let coloured_sky = world.sky.as_ref().is_some_and(|sky| sky.is_coloured());
    let mixed = scene.spectra_of_groups().err();
    let tinted = scene.parts.iter().find_map(|part| {
        let medium = scene.medium(part.medium?);
        matches!(medium.absorption, Absorption::Colour { .. }).then_some((medium, part))
    });
    let painted = painted(scene);
    match (coloured_sky || tinted.is_some() || painted.is_some(), mixed) {
        (false, None) => {
            (Spectral::Mono, "nothing tells wavelengths apart: each group is its luminance times its colour".to_owned())
        }
        (_, mixed) => {
            let what = match (mixed, tinted, painted) {
                _ if coloured_sky => "the sky is coloured".to_owned(),
                (_, Some((medium, part)), _) => format!("the medium {} of {} has a colour", medium.name, part.path),
                (_, None, Some(name)) => format!("the material {name} has a colour"),
                (Some(group), None, None) => format!("the lamps of group {group} differ in colour"),
                (None, None, None) => "something is coloured".to_owned(),
            };
            if tints.clone().all(|power| power.rec709_per_lumen().iter().all(|c| *c >= 0.0)) {
                (Spectral::Rgb, format!("{what}, and nothing tells wavelengths apart"))
            } else {
                (Spectral::Hero, format!("{what}, and a lamp's colour is out of the gamut of Rec.709"))
            }
        }
    }
}

/// An ordinary material of some face, or the part of a stained one, that has a colour.
fn painted(scene: &Scene) -> Option<&str> {
    let coloured: Vec<bool> = scene.surfaces.iter().map(|surface| surface.is_coloured()).collect();
    let grey = |[r, g, b, _]: &[f32; 4]| r == g && r == b;
    scene.parts.iter().find_map(|part| {
        let vertices = scene.meshes.get(part.mesh.index()).is_some_and(|mesh| !mesh.colors.iter().all(grey));
        part.faces.iter().find_map(|face| {
            if face.tint.is_some_and(|[r, g, b]| r != g || r != b) {
                return Some(part.path.as_str());
            }
            let emits = face.emitter.as_ref().and_then(|emitter| emitter.pattern);
            [face.finish.surface(), emits].into_iter().flatten().find_map(|id| {
                let surface = scene.surfaces.get(id.index())?;
                (coloured[id.index()] || vertices && surface.vertex_colors).then_some(surface.name.as_str())
            })
        })
    })
}

/// Whether a face is a wave plate or a grating, which treat wavelengths differently.
fn delays(scene: &Scene, finish: &Finish) -> bool {
    match finish {
        Finish::Retarder { retardance_nm, .. } => *retardance_nm != 0.0,
        // In other directions.
        Finish::Grating { .. } => true,
        Finish::WavePlate { plate, .. } | Finish::CircularPolariser { plate, .. } => {
            let waves = |nm: f64| scene.wave_plate(*plate).retardance.waves(nm);
            PROBES_NM.iter().any(|nm| waves(*nm) != waves(PROBES_NM[0]))
        }
        Finish::None
        | Finish::Polished
        | Finish::MirrorMetal { .. }
        | Finish::MirrorIdeal { .. }
        | Finish::Lambert { .. }
        | Finish::Gauss { .. }
        | Finish::CosM { .. }
        | Finish::Rough { .. }
        | Finish::Abg { .. }
        | Finish::Measured { .. }
        | Finish::Polariser { .. }
        | Finish::ReflectivePolariser { .. }
        | Finish::Surface { .. }
        | Finish::Absorber => false,
    }
}

/// What in the scene treats wavelengths differently, if anything does.
fn chromatic(scene: &Scene, world: &World) -> Option<String> {
    if let Some(slide) = world.slides.iter().position(|slide| slide.is_coloured()) {
        return Some(format!("slide {} is coloured", scene.slides[slide].name));
    }
    for part in &scene.parts {
        if part.faces.iter().any(|face| delays(scene, &face.finish)) {
            return Some(format!("a wave plate or a grating of {} tells wavelengths apart", part.path));
        }
        let Some(medium) = part.medium.map(|id| scene.medium(id)) else { continue };
        let differs = |value: &dyn Fn(f64) -> f64| PROBES_NM.iter().any(|nm| value(*nm) != value(PROBES_NM[0]));
        let seen = |finish: &Finish| !matches!(finish, Finish::Absorber | Finish::None);
        if !part.faces.iter().any(|face| seen(&face.finish)) {
            continue;
        }
        if differs(&|nm| medium.index.index(nm).re) {
            return Some(format!("the medium {} of {} disperses", medium.name, part.path));
        }
        // Of a colour the primaries make an exact account.
        let absorbs = |nm: f64| match &medium.absorption {
            Absorption::Colour { .. } => medium.absorption_by_index(nm),
            Absorption::Constant(_) | Absorption::Table(_) => medium.absorption_per_m_at(nm),
        };
        if differs(&absorbs) {
            return Some(format!("the medium {} of {} is coloured", medium.name, part.path));
        }
        let coated = part.faces.iter().filter(|face| matches!(face.finish, Finish::Polished)).find_map(|face| {
            let coating = scene.coating(face.coating?);
            let tells = match &coating.law {
                CoatingLaw::Stack(films) => films.iter().any(|film| film.thickness_nm > 0.0),
                CoatingLaw::Ideal { .. } => false,
                CoatingLaw::Table(table) => {
                    !table.outside.is_grey() || table.inside.as_ref().is_some_and(|inside| !inside.is_grey())
                }
            };
            tells.then_some(coating)
        });
        if let Some(coating) = coated {
            return Some(format!("the coating {} of {} tells wavelengths apart", coating.name, part.path));
        }
    }
    None
}

fn polarised(checked: &Checked, world: &World, asked: Polarisation, stop: &ShouldStop<'_>) -> (bool, String) {
    let scene = checked.scene();
    match asked {
        Polarisation::On => return (true, "asked for".to_owned()),
        Polarisation::Off => return (false, "asked for".to_owned()),
        Polarisation::Auto => {}
    }
    if let Some(slide) = scene.slides.iter().find(|slide| slide.polarisation.is_some_and(|p| p.degree > 0.0)) {
        return (true, format!("the light that leaves slide {} is polarised", slide.name));
    }
    if let Some(lamp) = world.lamps.all().iter().find(|lamp| lamp.polarisation.is_some_and(|(_, degree)| degree > 0.0))
    {
        return (true, format!("the light of {} is polarised", scene.parts[lamp.part].path));
    }
    let sheet = |finish: &Finish| {
        matches!(
            finish,
            Finish::Polariser { .. }
                | Finish::Retarder { .. }
                | Finish::WavePlate { .. }
                | Finish::CircularPolariser { .. }
                | Finish::ReflectivePolariser { .. }
        )
    };
    if let Some(part) = scene.parts.iter().find(|part| part.faces.iter().any(|face| sheet(&face.finish))) {
        return (true, format!("{} is there to act on it", part.path));
    }
    let parts = |finish: &Finish| finish.grating().is_some_and(|id| scene.grating(id).orders.part_polarisations());
    if let Some(part) = scene.parts.iter().find(|part| part.faces.iter().any(|face| parts(&face.finish))) {
        return (true, format!("the grating of {} tells polarisations apart", part.path));
    }
    if !checked.facts().specular {
        return (false, "no face is specular".to_owned());
    }
    let (most, part) = departure(world, stop);
    match part {
        Some(part) if most > MATTERS => {
            let path = &scene.parts[part as usize].path;
            (true, format!("in a pilot it changed the light at {path} by up to {:.2} %", 100.0 * most))
        }
        Some(_) | None => {
            (false, format!("in a pilot it changed the light at no face by more than {:.2} %", 100.0 * most))
        }
    }
}

/// Largest change that polarisation makes to the share that a face reflects, in units of what left the eye, over paths
/// from the eye; and the part of that face.
fn departure(world: &World, stop: &ShouldStop<'_>) -> (f64, Option<u32>) {
    const PATHS: u64 = 4096;
    const MOST_EVENTS: u32 = 64;
    let optics = MonoStokes::optics(world, 0, 0);
    let [width, height] = world.eye.size();
    let one = |sample: u64| -> (f64, Option<u32>) {
        if stop() {
            return (0.0, None);
        }
        let mut rng = Rng::new(0, Stream::Pilot, 1, sample);
        let [u, v] = rng.pair();
        let (x, y) = ((u * width as f64) as usize, (v * height as f64) as usize);
        let (origin, dir) = world.eye.ray(x, y, rng.pair(), rng.pair());
        let ray = Ray { origin, dir, from: None };
        let mut ledger = Ledger::new(world.solids.len());
        let mut walker =
            Walker::<MonoStokes>::new((world, &optics), Travel::FromEye, ray, 1.0, Interior::default(), rng);
        let mut most = (0.0, None);
        while walker.events < MOST_EVENTS {
            let Met::Face(vertex) = walker.advance(&mut ledger) else { break };
            let departs = walker.departure(&vertex);
            if departs > most.0 {
                most = (departs, Some(vertex.hit.site.part));
            }
            match walker.meet(&vertex, &mut ledger) {
                Meeting::Went => {}
                Meeting::Ended => break,
                Meeting::Scatter(scatter, frame) => {
                    if walker.scatter(&vertex, scatter, &frame, &mut ledger).is_none() {
                        break;
                    }
                }
            }
        }
        most
    };
    let larger = |a: (f64, Option<u32>), b: (f64, Option<u32>)| if b.0 > a.0 { b } else { a };
    // In order, so that equals are settled alike for any number of threads.
    let all: Vec<_> = parallel::map(PATHS as usize, &|sample| one(sample as u64));
    all.into_iter().fold((0.0, None), larger)
}
