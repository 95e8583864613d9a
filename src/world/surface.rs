//! What a face does with light at the traced wavelength: the finish, the coating and the slide of a face, resolved once,
//! and the interaction with a ray that meets it.

use super::fresnel::{PowerSp, fresnel};
use super::scatter::Scatter;
use super::thinfilm::{Film, stack};
use crate::base::complex::Complex;
use crate::base::{Fault, Result, Where};
use crate::scene::{Face, Finish, Part, Scene};
use arrayvec::ArrayVec;

/// Most films that a coating may have; more is a fault.
pub const MAX_FILMS: usize = 64;

/// A face at the traced wavelength.
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
    /// A dielectric interface with films from outside the solid inwards.
    Interface(Box<Films>),
    Scatter(Box<Scatter>),
}

#[derive(Debug, Clone, Copy)]
pub enum Mirror {
    Ideal(f64),
    Metal(Complex),
}

/// A stack in both orders, so that neither side costs a reversal per ray.
#[derive(Debug, Clone, Default)]
pub struct Films {
    inwards: Vec<Film>,
    outwards: Vec<Film>,
}

impl Films {
    /// Power coefficients for light in `n1` that meets the face under `cos_i`; `entering` the solid or leaving it.
    pub fn power(&self, n1: f64, n2: f64, cos_i: f64, entering: bool, wavelength_nm: f64) -> PowerSp {
        let films = if entering { &self.inwards } else { &self.outwards };
        let n2 = Complex { re: n2, im: 0.0 };
        if films.is_empty() { fresnel(n1, n2, cos_i) } else { stack(n1, films, n2, cos_i, wavelength_nm) }
    }
}

impl Mirror {
    pub fn power(self, n1: f64, cos_i: f64) -> PowerSp {
        match self {
            Mirror::Ideal(r) => PowerSp { r_s: r, r_p: r, t_s: 0.0, t_p: 0.0, a_s: 1.0 - r, a_p: 1.0 - r },
            Mirror::Metal(n) => {
                let sp = fresnel(n1, n, cos_i);
                // What crosses into the metal stays there.
                PowerSp { t_s: 0.0, t_p: 0.0, a_s: sp.t_s, a_p: sp.t_p, ..sp }
            }
        }
    }
}

/// Resolves every face of a scene. Errors: a polished face of a part without a medium, a coating that is too long.
pub fn optics_of(scene: &Scene, wavelength_nm: f64) -> Result<Vec<Vec<FaceOptics>>> {
    scene
        .parts
        .iter()
        .map(|part| (0..part.faces.len()).map(|face| resolve(scene, part, face, wavelength_nm)).collect())
        .collect()
}

fn resolve(scene: &Scene, part: &Part, index: usize, wavelength_nm: f64) -> Result<FaceOptics> {
    let face = &part.faces[index];
    let at = || Where::Part { path: part.path.clone(), face: Some(index) };
    let surface = match (face.slide, face.finish) {
        (Some(slide), _) => Surface::Slide(slide.index()),
        (None, Finish::None) => Surface::Absent,
        (None, Finish::Absorber) => Surface::Absorber,
        (None, Finish::MirrorIdeal { reflectance }) => Surface::Mirror(Mirror::Ideal(reflectance)),
        (None, Finish::MirrorMetal { n, k }) => Surface::Mirror(Mirror::Metal(Complex { re: n, im: k })),
        (None, Finish::Polished) => {
            if part.medium.is_none() {
                return Err(Fault::new(at(), "a polished face needs a medium on its part")
                    .expected("`ior`, `glass` or another medium attribute, or the finish `mirror`"));
            }
            Surface::Interface(Box::new(films(scene, face, wavelength_nm, at)?))
        }
        (None, Finish::Lambert { .. } | Finish::Gauss { .. }) => match Scatter::from_finish(&face.finish) {
            Some(scatter) => Surface::Scatter(Box::new(scatter)),
            None => Surface::Absorber,
        },
    };
    Ok(FaceOptics { surface, lamp: face.emitter.is_some() })
}

fn films(scene: &Scene, face: &Face, wavelength_nm: f64, at: impl Fn() -> Where) -> Result<Films> {
    let Some(id) = face.coating else { return Ok(Films::default()) };
    let coating = scene.coating(id);
    let mut inwards: ArrayVec<Film, MAX_FILMS> = ArrayVec::new();
    for layer in &coating.films {
        let film = Film { n: layer.index.index(wavelength_nm), thickness_nm: layer.thickness_nm };
        inwards.try_push(film).map_err(|_| {
            Fault::new(at(), format!("coating `{}` has {} films", coating.name, coating.films.len()))
                .expected(format!("at most {MAX_FILMS}"))
        })?;
    }
    let inwards = inwards.to_vec();
    let outwards = inwards.iter().rev().copied().collect();
    Ok(Films { inwards, outwards })
}
