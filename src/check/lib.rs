//! Floor 2: the proof that a scene can be planned and traced, and the facts that the plan decides by; and the rules that
//! an asset is validated by.

pub mod facets; // what a mesh does to light
pub mod finding;
pub mod geometry; // what rules measure on meshes
pub mod lamps; // what rules measure on lamps
pub mod rule;
pub mod rules; // one file each
pub mod subject; // what rules look at

use eyebox_base::ids::WavePlateId;
use eyebox_base::{Code, Error, Result, Where};
use eyebox_film::names::{self, Clash};
use eyebox_scene::{AbgLaw, Finish, Scene};
use glam::DVec3;

/// What a scene has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct Facts {
    /// Some face scatters light (not a delta).
    pub scatters: bool,
    /// Some face is specular: polished, a mirror or a slide.
    pub specular: bool,
    /// Some face sends light on in a bundle: light that scatterers are lit by over it may come from where nobody looks.
    pub bundles: bool,
    /// The pupil has no area.
    pub pinhole: bool,
    /// Nothing emits.
    pub no_light: bool,
}

/// A scene that passed the checks. Only [`check`] makes one, so later steps can demand it.
#[derive(Debug)]
pub struct Checked<'s> {
    scene: &'s Scene,
    facts: Facts,
}

impl<'s> Checked<'s> {
    pub fn scene(&self) -> &'s Scene {
        self.scene
    }
    pub fn facts(&self) -> Facts {
        self.facts
    }
}

/// Checks what every later step relies on. Errors: numbers that are not finite or out of range, faces that contradict
/// their part.
pub fn check(scene: &Scene) -> Result<Checked<'_>> {
    check_eye(scene)?;
    check_groups(scene)?;
    for part in &scene.parts {
        let mesh = scene.mesh(part.mesh);
        if part.faces.len() != mesh.faces.len() {
            let text = format!("{} faces are bound but the mesh has {}", part.faces.len(), mesh.faces.len());
            return Err(Error::new(Where::part(&part.path), text));
        }
        for (index, face) in part.faces.iter().enumerate() {
            check_face(scene, part, index, face)?;
        }
        if let Some(id) = part.medium {
            let medium = scene.medium(id);
            let n = medium.index.index(scene.wavelengths.traced_nm());
            if !(n.re.is_finite() && n.re >= 1.0 && n.re <= 10.0 && n.im >= 0.0) {
                let nm = scene.wavelengths.traced_nm();
                let text = format!("impossible refractive index {} of `{}` at {nm} nm", n.re, medium.name);
                return Err(Error::new(Where::part(&part.path), text).expected("1 to 10").code(Code::IndexImpossible));
            }
        }
    }
    if let Some(sky) = &scene.sky
        && let Some(part) =
            scene.parts.iter().find(|p| p.faces.iter().flat_map(|f| &f.emitter).any(|e| e.group == sky.group))
    {
        let text = format!("its emitter has the light group `{}` of the sky", scene.group(sky.group).name);
        return Err(Error::new(Where::part(&part.path), text).expected("a group of its own").code(Code::GroupUnusable));
    }
    if let Some(sky) = &scene.sky
        && let Some(light) = scene.lights.iter().find(|light| light.group == sky.group)
    {
        let text = format!("the light has the light group `{}` of the sky", scene.group(sky.group).name);
        return Err(Error::new(Where::part(&light.name), text)
            .expected("a group of its own")
            .code(Code::GroupUnusable));
    }
    let faces = || scene.parts.iter().flat_map(|part| &part.faces);
    let facts = Facts {
        scatters: faces().any(|f| !f.is_slide() && Ways::of(f.finish).scatters),
        specular: faces().any(|f| f.is_slide() || Ways::of(f.finish).specular),
        bundles: faces().any(|f| f.is_slide() || Ways::of(f.finish).bundles),
        pinhole: scene.eye.pupil_diameter_m == 0.0,
        no_light: scene.sky.is_none() && faces().all(|f| f.emitter.is_none()) && scene.lights.is_empty(),
    };
    Ok(Checked { scene, facts })
}

/// How a finish sends light on.
struct Ways {
    /// Out of the specular directions.
    scatters: bool,
    /// In them.
    specular: bool,
    /// In a bundle: it is neither matt nor black.
    bundles: bool,
}

impl Ways {
    fn of(finish: Finish) -> Ways {
        let [scatters, specular, bundles] = match finish {
            Finish::None | Finish::Absorber => [false; 3],
            Finish::Lambert { .. } => [true, false, false],
            Finish::Gauss { .. }
            | Finish::CosM { .. }
            | Finish::Rough { .. }
            | Finish::Measured { .. }
            | Finish::Surface { .. } => [true, false, true],
            Finish::Abg { .. } => [true; 3],
            Finish::Polished
            | Finish::MirrorMetal { .. }
            | Finish::MirrorIdeal { .. }
            | Finish::Polariser { .. }
            | Finish::Retarder { .. }
            | Finish::WavePlate { .. }
            | Finish::CircularPolariser { .. }
            | Finish::ReflectivePolariser { .. }
            | Finish::Grating { .. } => [false, true, true],
        };
        Ways { scatters, specular, bundles }
    }
}

fn wave_plate(scene: &Scene, axis: DVec3, plate: WavePlateId, at: impl Fn() -> Where) -> Result<()> {
    let problem = match scene.wave_plates.get(plate.index()) {
        None => Some("a wave plate without its retardance".to_owned()),
        Some(plate) => plate.problem(),
    };
    let problem = problem.or_else(|| axis.try_normalize().is_none().then(|| format!("a wave plate about {axis}")));
    match problem {
        Some(text) => Err(Error::new(at(), text).expected("a direction, and finite numbers with rising wavelengths")),
        None => Ok(()),
    }
}

/// Light groups are parts of layers' names, so no two things may be written under one.
fn check_groups(scene: &Scene) -> Result<()> {
    match names::clash(scene.groups.iter().map(|group| group.name.as_str()), &[]) {
        None => Ok(()),
        Some(Clash { layer, causes: [one, other] }) => {
            let text = format!("the layer `{layer}` would be {one} and {other}");
            Err(Error::new(Where::Option("light groups".to_owned()), text)
                .expected("another name for one of the groups")
                .code(Code::GroupUnusable))
        }
    }
}

fn check_eye(scene: &Scene) -> Result<()> {
    let eye = &scene.eye;
    let fault = |what: String| Error::new(Where::Option("eye".to_owned()), what).code(Code::EyeImpossible);
    if !(eye.position.is_finite() && eye.look.is_finite() && eye.up.is_finite()) {
        return Err(fault("the eye's position or directions are not finite".to_owned()));
    }
    let straight = eye.look.is_normalized() && eye.up.is_normalized() && eye.look.dot(eye.up).abs() < 1e-9;
    if !straight {
        return Err(fault("the eye's `look` and `up` are not orthogonal unit vectors".to_owned()));
    }
    if !(eye.fov_deg > 0.0 && eye.fov_deg < 180.0) {
        return Err(fault(format!("fov_deg = {}", eye.fov_deg)).expected("more than 0, less than 180"));
    }
    if !(eye.pupil_diameter_m >= 0.0 && eye.pupil_diameter_m.is_finite()) {
        return Err(fault(format!("pupil diameter {} m", eye.pupil_diameter_m)).expected("0 or more"));
    }
    if eye.focus_distance_m.is_nan() || eye.focus_distance_m <= 0.0 {
        return Err(fault(format!("focus distance {} m", eye.focus_distance_m)).expected("more than 0, or inf"));
    }
    let [width, height] = eye.resolution;
    if width == 0 || height == 0 || width.saturating_mul(height) > 1 << 25 {
        return Err(fault(format!("resolution {width} × {height}")).expected("at most 2^25 pixels"));
    }
    Ok(())
}

fn check_face(scene: &Scene, part: &eyebox_scene::Part, index: usize, face: &eyebox_scene::Face) -> Result<()> {
    let at = || Where::Part { path: part.path.clone(), face: Some(index) };
    match face.finish {
        Finish::Lambert { reflectance, transmittance }
        | Finish::Gauss { reflectance, transmittance, .. }
        | Finish::CosM { reflectance, transmittance, .. } => {
            let sum = reflectance + transmittance;
            if !(reflectance >= 0.0 && transmittance >= 0.0 && sum <= 1.0 + 1e-12) {
                let text = format!("reflectance {reflectance} + transmittance {transmittance} gains energy");
                return Err(Error::new(at(), text)
                    .expected("each 0 to 1, the sum at most 1")
                    .code(Code::ScatterGainsEnergy));
            }
        }
        Finish::Polariser { axis, transmittance, extinction, .. } => {
            let shares = [transmittance, extinction].iter().all(|share| (0.0..=1.0).contains(share));
            if !shares || axis.try_normalize().is_none() {
                let text = format!("a polariser about {axis} with T {transmittance} and extinction {extinction}");
                return Err(Error::new(at(), text).expected("a direction, and shares of 0 to 1"));
            }
        }
        Finish::Retarder { axis, retardance_nm } => {
            if axis.try_normalize().is_none() || !retardance_nm.is_finite() {
                let text = format!("a retarder about {axis} of {retardance_nm} nm");
                return Err(Error::new(at(), text).expected("a direction, and a finite path"));
            }
        }
        Finish::Grating { grating } => {
            let Some(grating) = scene.gratings.get(grating.index()) else {
                return Err(Error::new(at(), "a grating without its lines"));
            };
            if let Some(text) = grating.problem() {
                return Err(Error::new(at(), text).expected("finite numbers, shares of 0 to 1, each order once"));
            }
            if let Some(total) = grating.gains() {
                return Err(Error::new(at(), format!("the orders of a grating have {total} of the light"))
                    .expected("shares that together are at most 1")
                    .code(Code::ScatterGainsEnergy));
            }
        }
        Finish::WavePlate { axis, plate } => wave_plate(scene, axis, plate, at)?,
        Finish::CircularPolariser { axis, transmittance, extinction, plate, .. } => {
            if ![transmittance, extinction].iter().all(|share| (0.0..=1.0).contains(share)) {
                let text = format!("a circular polariser with T {transmittance} and extinction {extinction}");
                return Err(Error::new(at(), text).expected("shares of 0 to 1"));
            }
            wave_plate(scene, axis, plate, at)?;
        }
        Finish::ReflectivePolariser {
            axis, transmittance, transmittance_leak, reflectance, reflectance_leak, ..
        } => {
            let shares = [transmittance, transmittance_leak, reflectance, reflectance_leak];
            if !shares.iter().all(|share| (0.0..=1.0).contains(share)) || axis.try_normalize().is_none() {
                let text = format!("a reflective polariser about {axis} with shares {shares:?}");
                return Err(Error::new(at(), text).expected("a direction, and shares of 0 to 1"));
            }
            for (what, sum) in
                [("along", transmittance + reflectance_leak), ("across", reflectance + transmittance_leak)]
            {
                if sum > 1.0 + 1e-12 {
                    let text = format!("a reflective polariser sends out {sum} of the light polarised {what} its axis");
                    return Err(Error::new(at(), text)
                        .expected("transmittance + reflectance_leak and reflectance + transmittance_leak at most 1")
                        .code(Code::ScatterGainsEnergy));
                }
            }
        }
        Finish::MirrorIdeal { reflectance } => {
            if !(0.0..=1.0).contains(&reflectance) {
                return Err(Error::new(at(), format!("reflectance {reflectance}")).expected("0 to 1"));
            }
        }
        Finish::MirrorMetal { n, k } => {
            if !(n > 0.0 && k >= 0.0 && n.is_finite() && k.is_finite()) {
                return Err(Error::new(at(), format!("metal index {n} + {k}i"))
                    .expected("n > 0, k ≥ 0")
                    .code(Code::IndexImpossible));
            }
        }
        Finish::Rough { alpha } => {
            if !(1e-4..=1.0).contains(&alpha) {
                return Err(Error::new(at(), format!("roughness {alpha}")).expected("1e-4 to 1"));
            }
        }
        Finish::Abg { a, b, g, reflectance } => {
            let Some(law) = AbgLaw::new([a, b, g]).filter(|_| (0.0..=1.0).contains(&reflectance)) else {
                let text = format!("ABg with A {a}, B {b}, g {g}, R {reflectance}");
                return Err(Error::new(at(), text).expected("A >= 0, B > 0, g >= 0, A/B finite, R 0 to 1"));
            };
            // Straight on, the whole of the lobe is above the horizon: nowhere is it more.
            let total = law.total(0.0) + reflectance;
            if total.is_nan() || total > 1.0 + 1e-9 {
                let text = format!("ABg with A {a}, B {b}, g {g}, R {reflectance} sends out {total:.6} of the light");
                return Err(Error::new(at(), text)
                    .expected("at most 1, by a smaller A or R or a larger B")
                    .code(Code::ScatterGainsEnergy));
            }
        }
        Finish::Measured { table } => {
            if scene.scatters.get(table.index()).is_none() {
                return Err(Error::new(at(), "measured scattering without its table"));
            }
        }
        Finish::Surface { surface } => {
            if scene.surfaces.get(surface.index()).is_none() {
                return Err(Error::new(at(), "a standard surface without its parameters"));
            }
        }
        Finish::None | Finish::Polished | Finish::Absorber => {}
    }
    if face.coating.is_some() && face.finish != Finish::Polished {
        return Err(Error::new(at(), "a coating needs a polished face")
            .expected("finish = \"polished\"")
            .code(Code::CoatingNotPolished));
    }
    if let Some(id) = face.slide {
        let slide = scene.slide(id);
        let sound = slide.size.iter().all(|s| *s > 0.0 && s.is_finite())
            && (0.0..=1.0).contains(&slide.transmittance)
            && slide.contrast >= 1.0
            && slide.pixels.len() == slide.width * slide.height;
        if !sound {
            return Err(Error::new(at(), format!("slide `{}` has an impossible size or transmittance", slide.name))
                .code(Code::SlideWithoutSize));
        }
    }
    Ok(())
}
