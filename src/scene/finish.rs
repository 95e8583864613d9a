//! What a face does with light that meets it.

use eyebox_base::ids::{GratingId, ScatterId, SurfaceId, WavePlateId};
use glam::DVec3;

/// Finish of a face. A coating, if any, acts on `Polished` faces.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum Finish {
    /// Not there for light: the sides of a thin CAD sheet.
    None,
    /// Refracts and reflects by Fresnel's equations, or by the face's coating.
    Polished,
    /// Reflects specularly: a metal `n + ik`.
    MirrorMetal { n: f64, k: f64 },
    /// Reflects specularly the share `reflectance` (0–1) at every angle and absorbs the rest.
    MirrorIdeal { reflectance: f64 },
    /// Scatters diffusely: shares 0–1 with `reflectance + transmittance <= 1`.
    Lambert { reflectance: f64, transmittance: f64 },
    /// Gaussian lobe about the specular directions (`design/formulas.md` section 10), sigma in degrees.
    Gauss { sigma_deg: f64, reflectance: f64, transmittance: f64 },
    /// Lobe cosᵐ t about the specular directions, shares as for `Gauss`: of light that falls straight on,
    /// share · (m + 2)/2π cosᵐ per steradian.
    CosM { m: f64, reflectance: f64, transmittance: f64 },
    /// A rough interface between the part's medium and what is outside: microfacets of Trowbridge and Reitz (GGX) of
    /// this roughness (1e-4 to 1), which absorb nothing.
    Rough { alpha: f64 },
    /// Polish or blackened metal that scatters A/(B + |β − β₀|^g) per steradian about what it reflects specularly, a share
    /// `reflectance`; absorbs the rest.
    Abg { a: f64, b: f64, g: f64, reflectance: f64 },
    /// As a table says, from both sides alike.
    Measured { table: ScatterId },
    /// A thin sheet that lets linear polarisation along `axis` through with the share `transmittance` (0–1), the other
    /// with `transmittance · extinction`, and bends nothing. Where paths carry no polarisation: the mean of both.
    Polariser { axis: DVec3, projected_axis: ProjectedAxis, transmittance: f64, extinction: f64 },
    /// A thin sheet that delays linear polarisation along `axis` by `retardance_nm` against the other one; loses nothing.
    Retarder { axis: DVec3, retardance_nm: f64 },
    /// Diffracts: the light of each order leaves where its phase along the face has changed by that of so many lines.
    Grating { grating: GratingId },
    /// A thin sheet that delays linear polarisation along `axis` as a plate does of which more is known; loses nothing.
    WavePlate { axis: DVec3, plate: WavePlateId },
    /// A polariser with its pass axis along `axis` on one side of a thin sheet (in `front`, or behind), a wave plate at 45°
    /// to it on the other: what the polariser has let through leaves the plate with this handedness (`right`: clockwise
    /// for those who look against the light), and from that side nothing but light of this handedness gets through.
    CircularPolariser {
        axis: DVec3,
        projected_axis: ProjectedAxis,
        transmittance: f64,
        extinction: f64,
        right: bool,
        front: bool,
        plate: WavePlateId,
    },
    /// A thin sheet that parts linear polarisations and bends nothing: of the one along `axis` (the pass axis) it lets
    /// `transmittance` through and reflects `reflectance_leak`, of the other one it reflects `reflectance` specularly and
    /// lets `transmittance_leak` through. Shares 0–1, of each polarisation together at most 1; the rest is absorbed. Where
    /// paths carry no polarisation: the means of both.
    ReflectivePolariser {
        axis: DVec3,
        projected_axis: ProjectedAxis,
        transmittance: f64,
        transmittance_leak: f64,
        reflectance: f64,
        reflectance_leak: f64,
    },
    /// An ordinary material: layers with colours and textures, from both sides alike.
    Surface { surface: SurfaceId },
    /// Takes everything.
    Absorber,
}

/// Which axis of a linear polariser light at an angle sees projected across itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ProjectedAxis {
    /// That of the molecules or wires, along which the field is taken away: what passes is at right angles to it and to the ray (iodine
    /// films, wire grids).
    #[default]
    Absorption,
    /// The pass axis: what passes vibrates along what is seen of it.
    Pass,
}

impl Finish {
    /// The ordinary material, if it is one.
    pub fn surface(&self) -> Option<SurfaceId> {
        match self {
            Finish::Surface { surface } => Some(*surface),
            Finish::None
            | Finish::Polished
            | Finish::Rough { .. }
            | Finish::Lambert { .. }
            | Finish::Gauss { .. }
            | Finish::CosM { .. }
            | Finish::Abg { .. }
            | Finish::Measured { .. }
            | Finish::MirrorMetal { .. }
            | Finish::MirrorIdeal { .. }
            | Finish::Polariser { .. }
            | Finish::Retarder { .. }
            | Finish::WavePlate { .. }
            | Finish::CircularPolariser { .. }
            | Finish::ReflectivePolariser { .. }
            | Finish::Grating { .. }
            | Finish::Absorber => None,
        }
    }

    /// The grating, if it is one.
    pub fn grating(&self) -> Option<GratingId> {
        match self {
            Finish::Grating { grating } => Some(*grating),
            Finish::None
            | Finish::Polished
            | Finish::Rough { .. }
            | Finish::Lambert { .. }
            | Finish::Gauss { .. }
            | Finish::CosM { .. }
            | Finish::Abg { .. }
            | Finish::Measured { .. }
            | Finish::MirrorMetal { .. }
            | Finish::MirrorIdeal { .. }
            | Finish::Polariser { .. }
            | Finish::ReflectivePolariser { .. }
            | Finish::Retarder { .. }
            | Finish::Surface { .. }
            | Finish::Absorber
            | Finish::WavePlate { .. }
            | Finish::CircularPolariser { .. } => None,
        }
    }

    /// The wave plate, if it has one.
    pub fn wave_plate(&self) -> Option<WavePlateId> {
        match self {
            Finish::WavePlate { plate, .. } | Finish::CircularPolariser { plate, .. } => Some(*plate),
            Finish::None
            | Finish::Polished
            | Finish::Rough { .. }
            | Finish::Lambert { .. }
            | Finish::Gauss { .. }
            | Finish::CosM { .. }
            | Finish::Abg { .. }
            | Finish::Measured { .. }
            | Finish::MirrorMetal { .. }
            | Finish::MirrorIdeal { .. }
            | Finish::Polariser { .. }
            | Finish::ReflectivePolariser { .. }
            | Finish::Retarder { .. }
            | Finish::Surface { .. }
            | Finish::Absorber
            | Finish::Grating { .. } => None,
        }
    }

    /// A Gaussian lobe narrower than this is `G` in event strings: photons are not gathered there, the gathering
    /// waits for the first broad lobe. At 1° a lobe's solid angle 2πσ² is 1.9e-3 sr.
    pub const NARROW_SIGMA_DEG: f64 = 1.0;
}
