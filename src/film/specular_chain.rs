//! Trains: chains of specular faces as a plan keeps them, with what a solver needs to follow them without asking what
//! else is in the way.

use eyebox_base::chain::{Chain, Link};
use eyebox_base::ids::GroupId;

/// One face on the way from the eye (or from a scatterer) to a lamp.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Lens {
    pub link: Link,
    /// A point of the face that light of this chain crosses, mesh units.
    pub about: [f64; 3],
    /// The part that fills the space before the face and behind it (where the ray goes on); none: air.
    pub before: Option<u32>,
    pub after: Option<u32>,
}

/// The faces from the eye or a scatterer to a lamp, in that order.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct SpecularChain(pub Vec<Lens>);

impl SpecularChain {
    pub fn chain(&self) -> Chain {
        Chain(self.0.iter().map(|lens| lens.link).collect())
    }
}

/// A path that a pilot found.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Seed {
    /// Emitting face, by its number among the world's lamps.
    pub lamp: u32,
    /// Place in the picture, in tangents.
    pub film: [f64; 2],
    /// Place in the pupil, m.
    pub pupil: [f64; 2],
}

/// Specular connection of a light group's lamps with the pupil over one train.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Connection {
    pub group: GroupId,
    pub train: SpecularChain,
    pub seeds: Vec<Seed>,
    /// Share of the group's vision light that the pilot found on it.
    pub share: f64,
    /// The pilot's paths from the lamps brought what its rays from the eye saw of this train: light tracing has what the solver
    /// does not return. Else rays from the eye have it. Plans without it read as they always did.
    #[serde(default = "reached", skip_serializing_if = "is_reached")]
    pub reached: bool,
}

fn reached() -> bool {
    true
}

#[allow(clippy::trivially_copy_pass_by_ref)] // as serde wants it
fn is_reached(reached: &bool) -> bool {
    *reached
}

/// A path that a pilot found between a scatterer and a lamp.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ScreenSeed {
    /// Emitting face, by its number among the world's lamps.
    pub lamp: u32,
    /// Place on the scatterer, recentred world, m.
    pub place: [f64; 3],
    /// Unit direction from there.
    pub dir: [f64; 3],
}

/// Specular connection of a light group's lamps with a face that scatters, over one train from the face.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Screen {
    pub group: GroupId,
    pub part: u32,
    pub face: u32,
    pub train: SpecularChain,
    pub seeds: Vec<ScreenSeed>,
    /// Lower and upper corner of a box about all the places that the pilot found, recentred world, m.
    pub bounds: [[f64; 3]; 2],
    /// Share of the group's light on this face that the pilot found to come this way.
    pub share: f64,
}
