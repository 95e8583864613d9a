//! Scenes with several slides: whose light is whose. Paths are told apart by the slide that they cross (bits of
//! [`PlaneKey::takes`](crate::accumulate::PlaneKey::takes)), so light that crosses one slide alone depends on that one's
//! contrast alone, as in a scene with one slide.

use crate::frame::Meta;
use eyebox_base::lpe::Takes;

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
    /// The bits after those are of paths that cross this slide once, and the other once if there is one, and no third.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub once: Vec<(usize, Option<usize>)>,
}

/// The slides that light depends on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Crossed {
    Nothing,
    /// One of them, by its place in [`BySlide::slides`].
    One(usize),
    /// Two of them, once each, the first before the second in [`BySlide::slides`].
    Both([usize; 2]),
    Several,
}

impl BySlide {
    /// What the paths depend on of which expressions take `takes`.
    pub fn crossed(&self, takes: Takes) -> Crossed {
        let has =
            |bit: usize| takes.checked_shr(self.bit.saturating_add(bit as u32)).is_some_and(|takes| takes & 1 == 1);
        let once = self.once.iter().enumerate().find(|(index, _)| has(1 + self.slides.len() + index));
        let once = once.map(|(_, slides)| *slides);
        let alone = (0..=self.slides.len()).find(|bit| has(*bit));
        match (self.shows, alone, once) {
            (Shows::Nothing, Some(0), _) => Crossed::Nothing,
            (Shows::Nothing, Some(bit), _) => Crossed::One(bit - 1),
            (Shows::Nothing, None, Some((one, Some(other)))) => Crossed::Both([one.min(other), one.max(other)]),
            (Shows::Slide(shown), Some(0), _) => Crossed::One(shown),
            (Shows::Slide(shown), Some(_), Some((one, None))) if one != shown => {
                Crossed::Both([one.min(shown), one.max(shown)])
            }
            (Shows::Nothing | Shows::Slide(_) | Shows::Several, _, _) => Crossed::Several,
        }
    }

    /// The slides that light is told to cross one after the other, once each.
    pub fn pairs(&self) -> impl Iterator<Item = [usize; 2]> {
        let pair = |(one, other): &(usize, Option<usize>)| {
            let other = match (self.shows, *other) {
                (Shows::Nothing, Some(other)) => other,
                (Shows::Slide(shown), None) if shown != *one => shown,
                (Shows::Nothing | Shows::Slide(_) | Shows::Several, _) => return None,
            };
            Some([other.min(*one), other.max(*one)])
        };
        self.once.iter().filter_map(pair)
    }

    /// The slides, as JSON.
    pub(super) fn listed(&self) -> Meta {
        Meta::Text(serde_json::to_string(&self.slides).unwrap_or_default())
    }
}
