//! Which light a plane of a film holds, and how many values of it.

use super::Light;
use crate::layer::Layer;
use eyebox_base::colour::ColourSpace;
use eyebox_base::ids::GroupId;
use eyebox_base::lpe::Takes;

/// Which light a plane of a film holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub struct PlaneKey {
    pub layer: Layer,
    pub group: GroupId,
    /// Which light path expressions take it, of those that part classes: bit [`Aov::part`](crate::aov::Aov::part).
    #[serde(default, skip_serializing_if = "is_none_taken")]
    pub takes: Takes,
}

#[allow(clippy::trivially_copy_pass_by_ref)] // serde asks for it
fn is_none_taken(takes: &Takes) -> bool {
    *takes == 0
}

/// Planes whose light is one picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Together {
    Layer(Layer),
    /// A light group's share of a layer.
    Share(Layer, GroupId),
    /// What the light path expression of this bit takes.
    Taken(u32),
}

impl Together {
    pub fn has(self, key: &PlaneKey) -> bool {
        match self {
            Together::Layer(layer) => key.layer == layer,
            Together::Share(layer, group) => (key.layer, key.group) == (layer, group),
            Together::Taken(bit) => key.takes.checked_shr(bit).unwrap_or(0) & 1 == 1,
        }
    }
}

/// What a plane of a film holds per pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Components {
    Luminance,
    /// Linear Rec.709, whose luminance is Y.
    Rec709,
}

impl Components {
    pub fn count(self) -> usize {
        match self {
            Components::Luminance => 1,
            Components::Rec709 => 3,
        }
    }

    /// The luminance of one plane's entries.
    pub fn luminance(self, entries: &[Light]) -> Light {
        match (self, entries) {
            (Components::Rec709, [r, g, b]) => {
                let [wr, wg, wb] = ColourSpace::Rec709.luminance_weights();
                let mut sum = r.scaled(wr);
                sum.add(g.scaled(wg));
                sum.add(b.scaled(wb));
                sum
            }
            (Components::Luminance | Components::Rec709, entries) => entries.first().copied().unwrap_or_default(),
        }
    }

    /// The value alone of [`Components::luminance`], cd/m².
    pub fn luminance_value(self, entries: &[Light]) -> f64 {
        match (self, entries) {
            (Components::Rec709, [r, g, b]) => {
                let [wr, wg, wb] = ColourSpace::Rec709.luminance_weights();
                wr * r.value + wg * g.value + wb * b.value
            }
            (Components::Luminance | Components::Rec709, entries) => entries.first().map_or(0.0, |light| light.value),
        }
    }
}
