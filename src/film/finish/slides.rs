//! Scenes with several slides: whose light is whose. Paths are told apart by the slide that they cross (bits of
//! [`PlaneKey::takes`](crate::film::accumulate::PlaneKey::takes)), so light that crosses one slide alone depends on that one's
//! contrast alone, as in a scene with one slide.

use crate::base::lpe::Takes;
use crate::film::frame::Meta;

/// Metadata that lists the slides.
pub const KEY: &str = "slides";

/// One of several slides.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct SlideInfo {
    /// In names of layers.
    pub name: String,
    pub part: String,
    /// C = T_white/T_black, 1 to ∞.
    #[serde(with = "contrast")]
    pub contrast: f64,
}

/// JSON has no infinity.
mod contrast {
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<S: Serializer>(contrast: &f64, to: S) -> Result<S::Ok, S::Error> {
        contrast.to_string().serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
        String::deserialize(from)?.parse::<f64>().map_err(D::Error::custom)
    }
}

/// Whose pictures the lamps of a group show: displays are slides before lamps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Shows {
    Nothing,
    Slide(usize),
    /// Some show another slide than others, or none.
    Several,
}

/// How a group's light is told apart by slides.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct BySlide {
    pub slides: Vec<SlideInfo>,
    /// The bit of paths that cross none of them; that of those which cross one and no other comes after it, in their order.
    pub bit: u32,
    pub shows: Shows,
}

/// The slides that light depends on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Crossed {
    Nothing,
    /// One of them, by its place in [`BySlide::slides`].
    One(usize),
    Several,
}

impl BySlide {
    /// What the paths depend on of which expressions take `takes`.
    pub fn crossed(&self, takes: Takes) -> Crossed {
        let has =
            |bit: usize| takes.checked_shr(self.bit.saturating_add(bit as u32)).is_some_and(|takes| takes & 1 == 1);
        let crossed = match (0..=self.slides.len()).find(|bit| has(*bit)) {
            Some(0) => Crossed::Nothing,
            Some(bit) => Crossed::One(bit - 1),
            None => Crossed::Several,
        };
        match (self.shows, crossed) {
            (Shows::Nothing, crossed) => crossed,
            (Shows::Slide(shown), Crossed::Nothing) => Crossed::One(shown),
            (Shows::Slide(_), Crossed::One(_) | Crossed::Several) | (Shows::Several, _) => Crossed::Several,
        }
    }

    /// The slides, as JSON.
    pub(super) fn listed(&self) -> Meta {
        Meta::Text(serde_json::to_string(&self.slides).unwrap_or_default())
    }
}
