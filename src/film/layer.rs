//! The layers of a picture: which path classes each holds, and how its channels are named.

use super::plan::Estimator;
use eyebox_base::path::Class;

/// A picture layer. [`Layer::SUM_ORDER`] is the order in which `hybrid` adds them up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Layer {
    Direct,
    Caustic,
    Secondary,
    Forward,
}

impl Layer {
    pub const SUM_ORDER: [Layer; 4] = [Layer::Direct, Layer::Caustic, Layer::Secondary, Layer::Forward];

    /// The name in channel names.
    pub fn name(self) -> &'static str {
        match self {
            Layer::Direct => "direct",
            Layer::Caustic => "caustic",
            Layer::Secondary => "secondary",
            Layer::Forward => "forward",
        }
    }

    /// What it holds, for `--help` and the documentation.
    pub fn doc(self) -> &'static str {
        match self {
            Layer::Direct => "vision (E S* L) and primary (E S* D L) paths, minus what `forward` owns",
            Layer::Caustic => "caustics (E S* D S+ L)",
            Layer::Secondary => "light scattered more than once (E S* D … D … L)",
            Layer::Forward => "vision paths of the light groups that are traced from the lamp",
        }
    }

    /// The layer that a path belongs to: its class decides, and for vision who traced it.
    pub fn of(class: Class, owner: Estimator) -> Layer {
        match (class, owner) {
            (Class::Vision, Estimator::Forward | Estimator::Manifold) => Layer::Forward,
            (Class::Vision, Estimator::Backward | Estimator::Photon) | (Class::Primary, _) => Layer::Direct,
            (Class::Caustic, _) => Layer::Caustic,
            (Class::Secondary, _) => Layer::Secondary,
        }
    }
}
