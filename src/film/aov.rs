//! Layers that a user defined: sums of stored shares, which the header names, so that they can be summed again after a
//! light group has been dimmed. One that parts the classes of paths has shares of its own, one per light group.

use super::frame::{Channel, Frame, Meta};

/// Metadata `aov.NAME` says what the layer `NAME` is.
pub const KEY: &str = "aov.";

/// A layer of its own.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Aov {
    /// The layer's name.
    pub name: String,
    /// The light path expression that asked for it.
    pub lpe: String,
    /// `LAYER_GROUP`, by layers in the order in which `hybrid` adds them up, then by light groups. Of one that parts classes
    /// `NAME_GROUP`, by light groups.
    pub shares: Vec<String>,
    /// It parts classes: its bit in [`PlaneKey::takes`](super::accumulate::PlaneKey::takes).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<u32>,
    /// Of several slides, what each is called: its shares come for each of them, too.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub slides: Vec<String>,
}

/// What the names of layers that come with a share end with.
pub const OF_SHARE: [&str; 6] = ["", "_open", "_content", "_cross", "_cross2", "_cross3"];
/// The same but for the share itself: what it is split into by a slide.
pub const OF_SPLIT: &[&str] = OF_SHARE.split_at(1).1;
/// What the names of layers end with that tell light through two slides in series: with one and the other open, the one at
/// C = ∞ and the other open, the one open and the other at C = ∞, both at C = ∞.
pub const OF_SERIES: [&str; 4] = ["_open_open", "_content_open", "_open_content", "_content_content"];
/// What the name of the layer ends with that tells by how much `content` − `open` of a slide's light errs.
pub const CHANGE_ERROR: &str = "_change_stderr";
/// The same for a layer of one's own.
const OF_LAYER: [&str; 3] = ["", "_stderr", "_variance"];

/// The layers that come with a share for each of several slides, and for two in series.
pub fn layers_by_slide<'s>(share: &'s str, slides: &'s [String]) -> impl Iterator<Item = String> + 's {
    let alone =
        slides.iter().flat_map(move |slide| OF_SPLIT.iter().map(move |suffix| format!("{share}_{slide}{suffix}")));
    let pairs = slides.iter().enumerate().flat_map(|(k, one)| slides[k + 1..].iter().map(move |other| (one, other)));
    let series = pairs
        .flat_map(move |(one, other)| OF_SERIES.iter().map(move |suffix| format!("{share}_{one}_{other}{suffix}")));
    alone.chain(series)
}

impl Aov {
    /// The names of all layers that it may write.
    pub fn layers(&self) -> impl Iterator<Item = String> + '_ {
        let own: &[&str] = if self.part.is_some() { &OF_LAYER } else { &OF_LAYER[..1] };
        let shares = if self.part.is_some() { self.shares.as_slice() } else { &[] };
        let of_shares = shares.iter().flat_map(|share| OF_SHARE.map(|suffix| format!("{share}{suffix}")));
        let of_slides = shares.iter().flat_map(|share| layers_by_slide(share, &self.slides));
        own.iter().map(|suffix| format!("{}{suffix}", self.name)).chain(of_shares).chain(of_slides)
    }

    /// The light group of each of its shares, where it parts classes; none of others.
    pub fn groups(&self) -> impl Iterator<Item = (&str, &str)> {
        let shares = if self.part.is_some() { self.shares.as_slice() } else { &[] };
        shares.iter().filter_map(|share| {
            let group = share.strip_prefix(self.name.as_str())?.strip_prefix('_')?;
            Some((share.as_str(), group))
        })
    }

    /// The f32 sum of the shares that are stored, layer by layer as `hybrid` is made; a share without light is not there.
    pub fn picture(&self, frame: &Frame) -> [Vec<f32>; 3] {
        let pixels = frame.width.saturating_mul(frame.height);
        let black = || -> [Vec<f32>; 3] { std::array::from_fn(|_| vec![0.0; pixels]) };
        let (mut sum, mut of_layer, mut layer) = (black(), black(), None);
        for share in &self.shares {
            let Some(picture) = frame.rgb(share) else { continue };
            let own = share.split('_').next();
            if layer != own {
                add(&mut sum, &of_layer);
                (of_layer, layer) = (black(), own);
            }
            add(&mut of_layer, &picture);
        }
        add(&mut sum, &of_layer);
        sum
    }

    /// The channels, and what the header says of them.
    pub fn written(&self, frame: &Frame) -> (Vec<Channel>, (String, Meta)) {
        let channel = |(data, component): (Vec<f32>, &str)| Channel {
            name: format!("{}.{component}", self.name),
            data: data.into(),
        };
        let channels = self.picture(frame).into_iter().zip(["R", "G", "B"]).map(channel).collect();
        let said = serde_json::to_string(self).unwrap_or_default();
        (channels, (format!("{KEY}{}", self.name), Meta::Text(said)))
    }
}

fn add<D: AsRef<[f32]>>(sum: &mut [Vec<f32>; 3], picture: &[D; 3]) {
    for (sum, data) in sum.iter_mut().zip(picture) {
        sum.iter_mut().zip(data.as_ref()).for_each(|(sum, value)| *sum += value);
    }
}

/// The layers that a header names.
pub fn listed(frame: &Frame) -> Vec<Aov> {
    let read = |(key, value): (&String, &Meta)| {
        let (name, Meta::Text(said)) = (key.strip_prefix(KEY)?, value) else { return None };
        let aov: Aov = serde_json::from_str(said).ok()?;
        Some(Aov { name: name.to_owned(), ..aov })
    };
    frame.meta.iter().filter_map(read).collect()
}

/// Sums up the layers that the header names, after the shares have changed; one whose shares are not in the frame stays.
pub fn refresh(frame: &mut Frame) {
    for aov in listed(frame) {
        if !aov.shares.iter().any(|share| frame.rgb(share).is_some()) {
            continue;
        }
        let (channels, _) = aov.written(frame);
        for channel in channels {
            if let Some(own) = frame.channels.iter_mut().find(|own| own.name == channel.name) {
                own.data = channel.data;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_layer_by_layer_and_again() {
        let mut frame = Frame::new(1, 1);
        for (name, value) in [("direct_a", 1.0), ("direct_b", 2.0f32.powi(-24)), ("caustic_a", 2.0f32.powi(-24))] {
            for component in ["R", "G", "B"] {
                frame.push(format!("{name}.{component}"), vec![value]);
            }
        }
        let shares = ["direct_a", "direct_b", "direct_dark", "caustic_a"].map(str::to_owned).to_vec();
        let aov = Aov { name: "mine".into(), lpe: "C.*".into(), shares, part: None, slides: Vec::new() };
        // Half a step above 1 is lost twice, not added up first.
        assert_eq!(aov.picture(&frame), [vec![1.0], vec![1.0], vec![1.0]]);
        let (channels, (key, said)) = aov.written(&frame);
        frame.channels.extend(channels);
        frame.meta.insert(key, said);
        assert_eq!(listed(&frame), [aov]);
        frame.channels.iter_mut().filter(|c| c.layer() == "direct_b").for_each(|c| c.data[0] = 4.0);
        refresh(&mut frame);
        assert_eq!(frame.get("mine.G").map(|c| c.data[0]), Some(5.0));
    }
}
