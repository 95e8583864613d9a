//! What the names of channels and layers say: which layers two frames have in common, which hold light, data or errors.

use eyebox_film::frame::{Channel, Frame};
use eyebox_film::layer::Layer;
use eyebox_film::names::is_error;

/// The layers to compare, and those that only one frame has. A share of light without light is not written, so where only
/// one frame has it the other is black.
pub fn common(a: &Frame, b: &Frame) -> (Vec<String>, Vec<(String, char)>) {
    let names = |frame: &Frame| -> Vec<String> {
        let bare = |channel: &&Channel| channel.layer().is_empty() && !["R", "G", "B"].contains(&channel.component());
        let lone = frame.channels.iter().filter(bare).map(|channel| channel.name.clone());
        // Layers that tell errors of others are used, not compared.
        frame.layer_names().into_iter().map(str::to_owned).chain(lone).filter(|name| !is_error(name)).collect()
    };
    let (of_a, of_b) = (names(a), names(b));
    let light = |name: &str| is_light(name);
    let only = |own: &[String], other: &[String], which: char| -> Vec<(String, char)> {
        own.iter().filter(|name| !other.contains(name) && !light(name)).map(|name| (name.clone(), which)).collect()
    };
    let only_in = only(&of_a, &of_b, 'A').into_iter().chain(only(&of_b, &of_a, 'B')).collect();
    let mut all: Vec<String> = of_a.iter().filter(|name| of_b.contains(name) || light(name)).cloned().collect();
    all.extend(of_b.into_iter().filter(|name| !of_a.contains(name) && light(name)));
    (all, only_in)
}

/// Light: layers and shares. Not the data.
pub fn is_light(name: &str) -> bool {
    Layer::SUM_ORDER
        .iter()
        .any(|layer| name.strip_prefix(layer.name()).is_some_and(|rest| rest.is_empty() || rest.starts_with('_')))
}

/// What has no noise: the data layers, also behind specular faces, with any prefix. All other layers with colours are
/// pictures, whatever they are called.
pub fn is_data(name: &str) -> bool {
    let base = name.strip_suffix("_seen").unwrap_or(name);
    // With a prefix it could be the light of a group of that name.
    let is_alpha = ["alpha", "alpha.A"].contains(&name);
    let with_prefix =
        ["Z", "normal", "position", "albedo", "id", "normal_geometric", "uv", "opacity", "motion", "seethrough"]
            .iter()
            .any(|data| base.strip_suffix(data).is_some_and(|before| before.is_empty() || before.ends_with('_')));
    is_alpha || with_prefix
}

/// Whether a channel is one of a layer's; a lone channel such as `Z` is a layer of its own.
pub fn belongs(channel: &Channel, name: &str) -> bool {
    if name.is_empty() {
        ["R", "G", "B"].contains(&channel.name.as_str())
    } else {
        channel.layer() == name || channel.name == name
    }
}
