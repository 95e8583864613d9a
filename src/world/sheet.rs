//! Thin sheets that act on polarisation and bend nothing.

use super::fresnel::PowerSp;
use super::stokes::Turning;
use eyebox_base::complex::Complex;
use eyebox_scene::{ProjectedAxis, WavePlate};
use glam::DVec3;
use std::f64::consts::TAU;

/// A polariser, a wave plate, or both on each other.
#[derive(Debug, Clone)]
pub struct Sheet {
    /// From the front of the face to its back.
    pub films: Vec<SheetFilm>,
}

/// One of the films of a sheet.
#[derive(Debug, Clone)]
pub struct SheetFilm {
    /// Unit, mesh units.
    pub axis: DVec3,
    /// The film's own axis lies at 45° to that, counter-clockwise as seen from the front of the face (1) or clockwise (−1).
    turned: f64,
    kind: FilmKind,
}

#[derive(Debug, Clone)]
enum FilmKind {
    Polariser { projected_axis: ProjectedAxis, along: f64, across: f64 },
    Retarder { retardance_nm: f64 },
    Plate(WavePlate),
}

/// How light meets a sheet: directions in the world.
#[derive(Debug, Clone, Copy)]
pub struct Incidence {
    pub dir: DVec3,
    /// Unit, from the front of the face.
    pub normal: DVec3,
    /// Index of where the light runs.
    pub index: f64,
}

impl Sheet {
    /// `shares`: transmittance and extinction.
    pub fn polariser(axis: DVec3, projected_axis: ProjectedAxis, shares: [f64; 2]) -> Sheet {
        Sheet { films: vec![SheetFilm::polariser(axis, projected_axis, shares)] }
    }

    pub fn retarder(axis: DVec3, retardance_nm: f64) -> Sheet {
        let kind = FilmKind::Retarder { retardance_nm };
        Sheet { films: vec![SheetFilm { axis: axis.normalize_or_zero(), turned: 0.0, kind }] }
    }

    pub fn wave_plate(axis: DVec3, plate: WavePlate) -> Sheet {
        let kind = FilmKind::Plate(plate);
        Sheet { films: vec![SheetFilm { axis: axis.normalize_or_zero(), turned: 0.0, kind }] }
    }

    /// A polariser on a wave plate whose slow axis lies at 45° to the pass axis. `right`: what has gone through both, the
    /// polariser first, turns clockwise for those who look against it; only such light gets through the other way.
    pub fn circular(
        (axis, projected_axis): (DVec3, ProjectedAxis),
        shares: [f64; 2],
        plate: WavePlate,
        right: bool,
        polariser_in_front: bool,
    ) -> Sheet {
        let turned = if right == polariser_in_front { 1.0 } else { -1.0 };
        let plate = SheetFilm { axis: axis.normalize_or_zero(), turned, kind: FilmKind::Plate(plate) };
        let polariser = SheetFilm::polariser(axis, projected_axis, shares);
        Sheet { films: if polariser_in_front { vec![polariser, plate] } else { vec![plate, polariser] } }
    }
}

impl SheetFilm {
    fn polariser(axis: DVec3, projected_axis: ProjectedAxis, [transmittance, extinction]: [f64; 2]) -> SheetFilm {
        let kind = FilmKind::Polariser { projected_axis, along: transmittance, across: transmittance * extinction };
        SheetFilm { axis: axis.normalize_or_zero(), turned: 0.0, kind }
    }

    /// The direction in the world, not across the ray yet, that the film's axis has for light; `axis` is the sheet's there.
    ///
    /// Of a plate with indices it is that of the extraordinary wave inside, whose parts along s and p leave as such: extended
    /// Jones matrices without the losses at the surfaces (see [`WavePlate::waves_at`]).
    pub fn axis_for(&self, axis: DVec3, at: &Incidence) -> DVec3 {
        let own = self.in_plane(axis, at);
        let n_o = match &self.kind {
            FilmKind::Polariser { projected_axis, .. } => return passed((own, *projected_axis), at.dir, at.normal),
            FilmKind::Plate(WavePlate { indices: Some([n_o, _]), .. }) => n_o,
            FilmKind::Retarder { .. } | FilmKind::Plate(WavePlate { indices: None, .. }) => return own,
        };
        let Some(c) = (own - at.normal * own.dot(at.normal)).try_normalize() else { return own };
        let along = at.momentum();
        let Some(s) = at.normal.cross(at.dir).try_normalize() else { return c };
        let depth = (n_o * n_o - along.length_squared()).max(0.0).sqrt() * at.dir.dot(at.normal).signum();
        let Some(inside) = (along + at.normal * depth).try_normalize() else { return c };
        s * c.dot(s) + at.dir.cross(s) * c.dot(inside.cross(s))
    }

    fn in_plane(&self, axis: DVec3, at: &Incidence) -> DVec3 {
        if self.turned == 0.0 {
            return axis;
        }
        let laid = (axis - at.normal * axis.dot(at.normal)).normalize_or_zero();
        laid + self.turned * at.normal.cross(laid)
    }

    /// What it does, with s along its axis, at `nm`.
    pub fn turning(&self, nm: f64, axis: DVec3, at: &Incidence) -> Turning {
        let delayed = |waves: f64| {
            let (sin, cos) = (TAU * waves).sin_cos();
            (1.0, 1.0, Complex::new(cos, sin))
        };
        let (t_s, t_p, phase) = match &self.kind {
            FilmKind::Polariser { along, across, .. } => (*along, *across, Complex::ONE),
            FilmKind::Retarder { retardance_nm } => delayed(retardance_nm / nm),
            FilmKind::Plate(plate) => {
                let own = self.in_plane(axis, at);
                let c = (own - at.normal * own.dot(at.normal)).normalize_or_zero();
                let momentum = at.momentum();
                let along = momentum.dot(c);
                delayed(plate.waves_at(nm, along, (momentum - c * along).length()))
            }
        };
        let power = PowerSp { r_s: 0.0, r_p: 0.0, t_s, t_p, a_s: 1.0 - t_s, a_p: 1.0 - t_p };
        Turning { power, reflected: Complex::ZERO, transmitted: phase }
    }
}

/// The direction of the field that a polariser with this pass axis lets through, for light that runs along `dir`; not across the ray yet.
/// Molecules or wires absorb or reflect the field along themselves, so it is their axis that is seen projected across the ray, and what
/// passes is at right angles to that: k × a, a the axis in the face across the pass axis (an O-type polariser; one of E type has its pass
/// axis projected: C. Gu, P. Yeh, J. Opt. Soc. Am. A 10, 966, 1993).
pub fn passed((axis, projected): (DVec3, ProjectedAxis), dir: DVec3, normal: DVec3) -> DVec3 {
    match projected {
        ProjectedAxis::Absorption => {}
        ProjectedAxis::Pass => return axis,
    }
    let through = dir.cross(normal.cross(axis));
    match through.length_squared() > 0.0 {
        true => through * through.dot(axis).signum(),
        // Light along its molecules meets none.
        false => axis,
    }
}

impl Incidence {
    /// Along the face: index × the part of the direction there.
    fn momentum(&self) -> DVec3 {
        self.index * (self.dir - self.normal * self.dir.dot(self.normal))
    }
}

/// A sheet that lets the polarisation along its axis through and reflects the one across it.
#[derive(Debug, Clone, Copy)]
pub struct ReflectivePolariser {
    /// Unit, mesh units.
    pub axis: DVec3,
    pub projected_axis: ProjectedAxis,
    /// Reflected and transmitted share of the polarisation along the axis, and of the other one.
    along: [f64; 2],
    across: [f64; 2],
}

impl ReflectivePolariser {
    /// `along` and `across` the axis: reflectance and transmittance.
    pub fn new(
        (axis, projected_axis): (DVec3, ProjectedAxis),
        along: [f64; 2],
        across: [f64; 2],
    ) -> ReflectivePolariser {
        ReflectivePolariser { projected_axis, axis: axis.normalize_or_zero(), along, across }
    }

    /// What it does, with s along its axis; for what is reflected the axis is mirrored at the face, too. What is known are
    /// shares: the phases are those of a mirror, which reflects both polarisations alike, and of a clear sheet.
    pub fn turning(&self) -> Turning {
        let ([r_s, t_s], [r_p, t_p]) = (self.along, self.across);
        let power = PowerSp { r_s, r_p, t_s, t_p, a_s: 1.0 - r_s - t_s, a_p: 1.0 - r_p - t_p };
        Turning { power, reflected: -Complex::ONE, transmitted: Complex::ONE }
    }
}
