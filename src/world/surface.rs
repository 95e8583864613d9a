//! What a face does with light: the finish, the coating and the slide of a face, resolved once,
//! and the interaction with a ray that meets it.

use super::fresnel::{PowerSp, fresnel, fresnel_turning};
use super::scatter::Scatter;
use super::stokes::{Amount, Turning};
use super::thinfilm::{Film, stack, stack_turning};
use crate::base::complex::Complex;
use crate::base::{Fault, Result, Where};
use crate::scene::{Coating, Face, Finish, Part, Scene};
use glam::DVec3;

/// Most films that a coating may have; more is a fault.
pub const MAX_FILMS: usize = 64;

/// A face as the tracer asks it.
#[derive(Debug, Clone)]
pub struct FaceOptics {
    pub surface: Surface,
    /// Index into the lamps, if the face emits.
    pub lamp: bool,
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
    /// A dielectric interface; index into the world's coatings.
    Interface(usize),
    Scatter(Box<Scatter>),
}

/// A polariser or a wave plate.
#[derive(Debug, Clone, Copy)]
pub struct Sheet {
    /// Unit, mesh units.
    pub axis: DVec3,
    kind: SheetKind,
}

#[derive(Debug, Clone, Copy)]
enum SheetKind {
    Polariser {
        along: f64,
        across: f64,
    },
    /// nm.
    Retarder {
        retardance_nm: f64,
    },
}

impl Sheet {
    /// What it does, with s along its axis, at `nm`.
    pub fn turning(&self, nm: f64) -> Turning {
        let (t_s, t_p, phase) = match self.kind {
            SheetKind::Polariser { along, across } => (along, across, Complex::ONE),
            SheetKind::Retarder { retardance_nm } => {
                let (sin, cos) = (std::f64::consts::TAU * retardance_nm / nm).sin_cos();
                (1.0, 1.0, Complex::new(cos, sin))
            }
        };
        let power = PowerSp { r_s: 0.0, r_p: 0.0, t_s, t_p, a_s: 1.0 - t_s, a_p: 1.0 - t_p };
        Turning { power, reflected: Complex::ZERO, transmitted: phase }
    }
}

#[derive(Debug, Clone, Copy)]
pub enum Mirror {
    Ideal(f64),
    Metal(Complex),
}

/// A stack at one wavelength in both orders, so that neither side costs a reversal per ray.
#[derive(Debug, Clone, Default)]
pub struct Films {
    inwards: Vec<Film>,
    outwards: Vec<Film>,
}

impl Films {
    /// The films of a coating at `nm`; none of it is a bare interface.
    pub fn at(coating: Option<&Coating>, nm: f64) -> Films {
        let layers = coating.map_or(&[][..], |coating| coating.films.as_slice());
        let inwards: Vec<Film> =
            layers.iter().map(|layer| Film { n: layer.index.index(nm), thickness_nm: layer.thickness_nm }).collect();
        let outwards = inwards.iter().rev().copied().collect();
        Films { inwards, outwards }
    }

    /// What happens to light in `n1` that meets the face under `cos_i`; `entering` the solid or leaving it. The phases
    /// are worked out for amounts that have a polarisation.
    pub fn turning<A: Amount>(&self, n1: f64, n2: f64, cos_i: f64, entering: bool, wavelength_nm: f64) -> Turning {
        let films = if entering { &self.inwards } else { &self.outwards };
        let n2 = Complex { re: n2, im: 0.0 };
        match (A::POLARISED, films.is_empty()) {
            (false, true) => Turning::without_phases(fresnel(n1, n2, cos_i)),
            (false, false) => Turning::without_phases(stack(n1, films, n2, cos_i, wavelength_nm)),
            (true, true) => fresnel_turning(n1, n2, cos_i),
            (true, false) => stack_turning(n1, films, n2, cos_i, wavelength_nm),
        }
    }
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
    let faces = |part: &Part| (0..part.faces.len()).map(|face| resolve(scene, part, face)).collect();
    scene.parts.iter().map(faces).collect()
}

/// Number of a face's coating among the world's: those of the scene, after the bare interface.
fn coating(scene: &Scene, face: &Face, at: impl Fn() -> Where) -> Result<usize> {
    let Some(id) = face.coating else { return Ok(0) };
    let coating = scene.coating(id);
    if coating.films.len() > MAX_FILMS {
        let what = format!("coating `{}` has {} films", coating.name, coating.films.len());
        return Err(Fault::new(at(), what).expected(format!("at most {MAX_FILMS}")));
    }
    Ok(id.index() + 1)
}

fn resolve(scene: &Scene, part: &Part, index: usize) -> Result<FaceOptics> {
    let face = &part.faces[index];
    let at = || Where::Part { path: part.path.clone(), face: Some(index) };
    let surface = match (face.slide, face.finish) {
        (Some(slide), _) => Surface::Slide(slide.index()),
        (None, Finish::None) => Surface::Absent,
        (None, Finish::Absorber) => Surface::Absorber,
        (None, Finish::MirrorIdeal { reflectance }) => Surface::Mirror(Mirror::Ideal(reflectance)),
        (None, Finish::MirrorMetal { n, k }) => Surface::Mirror(Mirror::Metal(Complex { re: n, im: k })),
        (None, Finish::Polariser { axis, transmittance, extinction }) => {
            let kind = SheetKind::Polariser { along: transmittance, across: transmittance * extinction };
            Surface::Sheet(Sheet { axis: axis.normalize_or_zero(), kind })
        }
        (None, Finish::Retarder { axis, retardance_nm }) => {
            Surface::Sheet(Sheet { axis: axis.normalize_or_zero(), kind: SheetKind::Retarder { retardance_nm } })
        }
        (None, Finish::Polished) => {
            if part.medium.is_none() {
                return Err(Fault::new(at(), "a polished face needs a medium on its part")
                    .expected("`ior`, `glass` or another medium attribute, or the finish `mirror`"));
            }
            Surface::Interface(coating(scene, face, at)?)
        }
        (None, Finish::Lambert { .. } | Finish::Gauss { .. }) => match Scatter::from_finish(&face.finish) {
            Some(scatter) => Surface::Scatter(Box::new(scatter)),
            None => Surface::Absorber,
        },
    };
    Ok(FaceOptics { surface, lamp: face.emitter.is_some() })
}
