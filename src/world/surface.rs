//! What a face does with light: the finish, the coating and the slide of a face, resolved once,
//! and the interaction with a ray that meets it.

use super::fresnel::{PowerSp, fresnel, fresnel_turning};
use super::grating::Grating;
use super::scatter::{Lost, Measured, Principled, Rough, Scatter};
use super::sheet::{ReflectivePolariser, Sheet};
use super::stokes::{Amount, Turning};
use eyebox_base::complex::Complex;
use eyebox_base::ids::ScatterId;
use eyebox_base::{Code, Error, Result, Where};
use eyebox_scene::{Face, Finish, Medium, Part, Scene, Shape, Wavelengths};
use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

/// Most films that a coating may have; more is a fault.
pub const MAX_FILMS: usize = 64;

/// A face as the tracer asks it.
#[derive(Debug, Clone)]
pub struct FaceOptics {
    pub surface: Surface,
    /// Index into the lamps, if the face emits.
    pub lamp: bool,
    /// Share of what gets through an interface that goes on, linear Rec.709.
    pub tint: Option<[f64; 3]>,
}

#[derive(Debug, Clone)]
pub enum Surface {
    /// Not there for light.
    Absent,
    Absorber,
    /// Index into the slides.
    Slide(usize),
    Mirror(Mirror),
    /// A thin sheet that acts on polarisation and bends nothing.
    Sheet(Sheet),
    /// A thin sheet that lets one polarisation straight through and reflects the other.
    Splitter(ReflectivePolariser),
    /// Diffracts light into orders, through the face and back.
    Grating(Box<Grating>),
    /// A dielectric interface; index into the world's coatings.
    Interface(usize),
    Scatter(Box<Scatter>),
}

#[derive(Debug, Clone, Copy)]
pub enum Mirror {
    Ideal(f64),
    Metal(Complex),
}

impl Mirror {
    /// What happens to light in `n1` that meets the mirror under `cos_i`. What crosses into a metal stays there.
    pub fn turning<A: Amount>(self, n1: f64, cos_i: f64) -> Turning {
        match self {
            Mirror::Ideal(r) => {
                let power = PowerSp { r_s: r, r_p: r, t_s: 0.0, t_p: 0.0, a_s: 1.0 - r, a_p: 1.0 - r };
                // Of a perfect conductor: r_s = −1, r_p = 1.
                Turning { power, reflected: -Complex::ONE, transmitted: Complex::ZERO }
            }
            Mirror::Metal(n) => {
                let turning = if A::POLARISED {
                    fresnel_turning(n1, n, cos_i)
                } else {
                    Turning::without_phases(fresnel(n1, n, cos_i))
                };
                let sp = turning.power;
                Turning { power: PowerSp { t_s: 0.0, t_p: 0.0, a_s: sp.t_s, a_p: sp.t_p, ..sp }, ..turning }
            }
        }
    }
}

/// Resolves every face of a scene. Errors: a polished face of a part without a medium, a coating that is too long.
pub fn optics_of(scene: &Scene) -> Result<Vec<Vec<FaceOptics>>> {
    let mut tables = Tables::default();
    let mut all = Vec::with_capacity(scene.parts.len());
    for part in &scene.parts {
        let faces = (0..part.faces.len()).map(|face| resolve(scene, part, face, &mut tables));
        all.push(faces.collect::<Result<_>>()?);
    }
    Ok(all)
}

/// Tables that faces share.
#[derive(Default)]
struct Tables {
    /// By the bits of the roughness.
    rough: HashMap<u64, Arc<Lost>>,
    measured: HashMap<ScatterId, Arc<Measured>>,
}

impl Tables {
    fn rough(&mut self, scene: &Scene, alpha: f64) -> Rough {
        let lost = self.rough.entry(alpha.to_bits()).or_insert_with(|| Arc::new(Lost::new(alpha, &ratios(scene))));
        Rough::new(lost.clone())
    }
}

/// Ranges of n/n' over the wavelengths: of every medium with a rough face against air and against every other.
fn ratios(scene: &Scene) -> Vec<[f64; 2]> {
    const STEP_NM: usize = 10;
    const MOST: usize = 4096;
    let wavelengths: Vec<f64> = match scene.wavelengths {
        Wavelengths::Mono { nm } => vec![nm],
        Wavelengths::Visible => {
            (360..=830).step_by(STEP_NM).map(f64::from).chain([scene.wavelengths.traced_nm()]).collect()
        }
    };
    let index = |medium: &Medium| -> Vec<f64> { wavelengths.iter().map(|nm| medium.index.index(*nm).re).collect() };
    let all: Vec<Vec<f64>> =
        std::iter::once(vec![1.0; wavelengths.len()]).chain(scene.media.iter().map(index)).collect();
    let rough = |part: &&Part| part.faces.iter().any(|face| matches!(face.finish, Finish::Rough { .. }));
    let own: BTreeSet<usize> =
        scene.parts.iter().filter(rough).filter_map(|part| Some(part.medium?.index() + 1)).collect();
    let mut out = Vec::new();
    for own in own {
        for other in 0..all.len() {
            // Beyond so many pairs the tables cover the whole range anyway.
            if other != own && out.len() < MOST {
                let pairs = all[own].iter().zip(&all[other]).map(|(a, b)| a / b);
                out.push(pairs.fold([f64::INFINITY, 0f64], |[low, high], x| [low.min(x), high.max(x)]));
            }
        }
    }
    out
}

/// Whether places of a face have texture coordinates that differ.
fn is_unrolled(scene: &Scene, part: &Part, face: usize) -> bool {
    let Some(mesh) = scene.meshes.get(part.mesh.index()) else { return false };
    let triangles = mesh.faces.get(face).and_then(|range| mesh.triangles.get(range.triangles())).unwrap_or_default();
    let mut corners = triangles.as_flattened().iter().map(|corner| *corner as usize);
    let Some(first) = corners.next() else { return false };
    corners.any(|corner| [&mesh.uvs, &mesh.second_uvs].iter().any(|set| set.get(corner) != set.get(first)))
}

/// Number of a face's coating among the world's: those of the scene, after the bare interface.
fn coating(scene: &Scene, face: &Face, at: impl Fn() -> Where) -> Result<usize> {
    let Some(id) = face.coating else { return Ok(0) };
    let coating = scene.coating(id);
    if coating.films().len() > MAX_FILMS {
        let what = format!("coating `{}` has {} films", coating.name, coating.films().len());
        return Err(Error::new(at(), what).expected(format!("at most {MAX_FILMS}")));
    }
    Ok(id.index() + 1)
}

fn resolve(scene: &Scene, part: &Part, index: usize, tables: &mut Tables) -> Result<FaceOptics> {
    let face = &part.faces[index];
    let at = || Where::Part { path: part.path.clone(), face: Some(index) };
    // A display shines through its picture; light that meets it finds what it is made of.
    let slide = face.slide.filter(|_| face.emitter.is_none());
    let surface = match (slide, face.finish) {
        (Some(slide), _) => Surface::Slide(slide.index()),
        (None, Finish::None) => Surface::Absent,
        (None, Finish::Absorber) => Surface::Absorber,
        (None, Finish::MirrorIdeal { reflectance }) => Surface::Mirror(Mirror::Ideal(reflectance)),
        (None, Finish::MirrorMetal { n, k }) => Surface::Mirror(Mirror::Metal(Complex { re: n, im: k })),
        (None, Finish::Polariser { axis, projected_axis, transmittance, extinction }) => {
            Surface::Sheet(Sheet::polariser(axis, projected_axis, [transmittance, extinction]))
        }
        (None, Finish::Grating { grating }) => Surface::Grating(Box::new(Grating::new(scene.grating(grating)))),
        (None, Finish::WavePlate { axis, plate }) => {
            Surface::Sheet(Sheet::wave_plate(axis, scene.wave_plate(plate).clone()))
        }
        (None, Finish::CircularPolariser { axis, projected_axis, transmittance, extinction, right, front, plate }) => {
            let plate = scene.wave_plate(plate).clone();
            Surface::Sheet(Sheet::circular((axis, projected_axis), [transmittance, extinction], plate, right, front))
        }
        (None, Finish::Retarder { axis, retardance_nm }) => Surface::Sheet(Sheet::retarder(axis, retardance_nm)),
        (
            None,
            Finish::ReflectivePolariser {
                axis,
                projected_axis,
                transmittance,
                transmittance_leak,
                reflectance,
                reflectance_leak,
            },
        ) => {
            let (along, across) = ([reflectance_leak, transmittance], [reflectance, transmittance_leak]);
            Surface::Splitter(ReflectivePolariser::new((axis, projected_axis), along, across))
        }
        (None, Finish::Polished) => {
            if part.medium.is_none() {
                return Err(Error::new(at(), "a polished face needs a medium on its part")
                    .expected("`ior`, `glass` or another medium attribute, or the finish `mirror`")
                    .code(Code::IndexMissing));
            }
            Surface::Interface(coating(scene, face, at)?)
        }
        (None, Finish::Rough { alpha }) => {
            if part.medium.is_none() {
                return Err(Error::new(at(), "a rough face needs a medium on its part")
                    .expected("`ior`, `glass` or another medium attribute, or the finish `gauss`, `abg` or `measured`")
                    .code(Code::IndexMissing));
            }
            Surface::Scatter(Box::new(Scatter::Rough(tables.rough(scene, alpha))))
        }
        (None, Finish::Measured { table }) => {
            let measured =
                tables.measured.entry(table).or_insert_with(|| Arc::new(Measured::new(scene.scatter(table))));
            Surface::Scatter(Box::new(Scatter::Measured(measured.clone())))
        }
        (None, Finish::Surface { surface }) => {
            let own = &scene.surfaces[surface.index()];
            if face.shape != Shape::Mesh && own.is_textured() && is_unrolled(scene, part, index) {
                return Err(Error::new(at(), "textures on an exact shape, which has no texture coordinates")
                    .expected("`shape = \"mesh\"` there, or a finish without textures"));
            }
            let mesh = scene.meshes[part.mesh.index()].clone();
            Surface::Scatter(Box::new(Scatter::Principled(Box::new(Principled::new(own.clone(), mesh)))))
        }
        (None, Finish::Lambert { .. } | Finish::Gauss { .. } | Finish::CosM { .. } | Finish::Abg { .. }) => {
            match Scatter::from_finish(&face.finish) {
                Some(scatter) => Surface::Scatter(Box::new(scatter)),
                None => Surface::Absorber,
            }
        }
    };
    Ok(FaceOptics { surface, lamp: face.emitter.is_some(), tint: face.tint })
}
