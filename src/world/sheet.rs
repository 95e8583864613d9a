//! Thin sheets that act on polarisation and bend nothing.

use super::fresnel::PowerSp;
use super::stokes::Turning;
use crate::base::complex::Complex;
use glam::DVec3;

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
    pub fn polariser(axis: DVec3, transmittance: f64, extinction: f64) -> Sheet {
        let kind = SheetKind::Polariser { along: transmittance, across: transmittance * extinction };
        Sheet { axis: axis.normalize_or_zero(), kind }
    }

    pub fn retarder(axis: DVec3, retardance_nm: f64) -> Sheet {
        Sheet { axis: axis.normalize_or_zero(), kind: SheetKind::Retarder { retardance_nm } }
    }

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

/// A sheet that lets the polarisation along its axis through and reflects the one across it.
#[derive(Debug, Clone, Copy)]
pub struct ReflectivePolariser {
    /// Unit, mesh units.
    pub axis: DVec3,
    /// Reflected and transmitted share of the polarisation along the axis, and of the other one.
    along: [f64; 2],
    across: [f64; 2],
}

impl ReflectivePolariser {
    /// `along` and `across` the axis: reflectance and transmittance.
    pub fn new(axis: DVec3, along: [f64; 2], across: [f64; 2]) -> ReflectivePolariser {
        ReflectivePolariser { axis: axis.normalize_or_zero(), along, across }
    }

    /// What it does, with s along its axis; for what is reflected the axis is mirrored at the face, too. What is known are
    /// shares: the phases are those of a mirror, which reflects both polarisations alike, and of a clear sheet.
    pub fn turning(&self) -> Turning {
        let ([r_s, t_s], [r_p, t_p]) = (self.along, self.across);
        let power = PowerSp { r_s, r_p, t_s, t_p, a_s: 1.0 - r_s - t_s, a_p: 1.0 - r_p - t_p };
        Turning { power, reflected: -Complex::ONE, transmitted: Complex::ONE }
    }
}
