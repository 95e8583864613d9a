//! A finished picture: named channels of one size, and what is to be known about them.

use super::crop::Window;
use std::collections::{BTreeMap, HashSet};
use std::ops::{Deref, DerefMut};
use std::sync::Arc;

/// One value of the metadata that travels with a frame.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[serde(untagged)]
pub enum Meta {
    Text(String),
    Number(f64),
    Integer(i64),
}

/// The values of a channel. Copies share memory until one of them is changed: most layers are grey, and the same value three
/// times.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Samples(Arc<Vec<f32>>);

impl Samples {
    /// Whether they are one and the same memory.
    pub fn is_shared_with(&self, other: &Samples) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl Deref for Samples {
    type Target = Vec<f32>;
    fn deref(&self) -> &Vec<f32> {
        &self.0
    }
}

impl DerefMut for Samples {
    fn deref_mut(&mut self) -> &mut Vec<f32> {
        Arc::make_mut(&mut self.0)
    }
}

impl From<Vec<f32>> for Samples {
    fn from(values: Vec<f32>) -> Self {
        Samples(Arc::new(values))
    }
}

impl FromIterator<f32> for Samples {
    fn from_iter<I: IntoIterator<Item = f32>>(values: I) -> Self {
        Vec::from_iter(values).into()
    }
}

impl<'s> IntoIterator for &'s Samples {
    type Item = &'s f32;
    type IntoIter = std::slice::Iter<'s, f32>;
    fn into_iter(self) -> Self::IntoIter {
        self.0.iter()
    }
}

impl<S: AsRef<[f32]> + ?Sized> PartialEq<S> for Samples {
    fn eq(&self, other: &S) -> bool {
        self.0.as_slice() == other.as_ref()
    }
}

impl PartialEq<Samples> for Vec<f32> {
    fn eq(&self, other: &Samples) -> bool {
        *self == *other.0
    }
}

/// One channel, row by row from the top left, `width × height` values.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// `R`, `direct.R`, `Z.Z`: the layer, a dot, the component; no dot for the default layer.
    pub name: String,
    pub data: Samples,
}

impl Channel {
    /// The part of the name before the last dot; empty for the default layer.
    pub fn layer(&self) -> &str {
        split_name(&self.name).0
    }
    /// The part of the name after the last dot.
    pub fn component(&self) -> &str {
        split_name(&self.name).1
    }
}

/// `direct.R` → (`direct`, `R`); `R` → (empty, `R`).
pub fn split_name(name: &str) -> (&str, &str) {
    name.rsplit_once('.').unwrap_or(("", name))
}

/// The frame: what is written to an EXR and read from one. Pictures are in cd/m².
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Frame {
    /// Pixels.
    pub width: usize,
    /// Pixels.
    pub height: usize,
    pub channels: Vec<Channel>,
    pub meta: BTreeMap<String, Meta>,
    /// Where it lies in the picture that it is a part of; the whole picture without one.
    pub window: Option<Window>,
    /// Read from half floats, or from what was compressed with loss: values have 11 bits, so that sums of layers are not the stored sums to more than that.
    pub half: bool,
}

impl Frame {
    /// A frame without channels.
    pub fn new(width: usize, height: usize) -> Self {
        Frame { width, height, ..Frame::default() }
    }

    /// Adds a channel; `data` is row by row from the top left. The shape is checked when the frame is written.
    pub fn push(&mut self, name: impl Into<String>, data: Vec<f32>) {
        self.channels.push(Channel { name: name.into(), data: data.into() });
    }

    /// The layers in the order in which they first appear; the default layer is the empty string.
    pub fn layer_names(&self) -> Vec<&str> {
        let mut seen = HashSet::new();
        self.channels.iter().map(Channel::layer).filter(|layer| seen.insert(*layer)).collect()
    }

    /// The channel with this full name.
    pub fn get(&self, name: &str) -> Option<&Channel> {
        self.channels.iter().find(|channel| channel.name == name)
    }

    /// One component of a layer (the empty string is the default layer).
    pub fn component(&self, layer: &str, component: &str) -> Option<&Channel> {
        self.channels.iter().find(|channel| split_name(&channel.name) == (layer, component))
    }

    /// Red, green and blue of a layer. A layer that has `Y` (luminance) and no colour gives `Y` three times, except
    /// where `Y` is the second of the coordinates `X`, `Y`, `Z`.
    pub fn rgb(&self, layer: &str) -> Option<[&[f32]; 3]> {
        let one = |name: &str| self.component(layer, name).map(|channel| channel.data.as_slice());
        match (one("R"), one("G"), one("B")) {
            (Some(r), Some(g), Some(b)) => Some([r, g, b]),
            (None, None, None) if one("X").is_none() => one("Y").map(|y| [y, y, y]),
            _ => None,
        }
    }

    pub fn text(&self, key: &str) -> Option<&str> {
        match self.meta.get(key)? {
            Meta::Text(text) => Some(text),
            Meta::Number(_) | Meta::Integer(_) => None,
        }
    }

    pub fn number(&self, key: &str) -> Option<f64> {
        match self.meta.get(key)? {
            Meta::Number(number) => Some(*number),
            Meta::Integer(integer) => Some(*integer as f64),
            Meta::Text(_) => None,
        }
    }

    /// An integer, also one that was too wide for EXR's 32 bits and travelled as text.
    pub fn integer(&self, key: &str) -> Option<i64> {
        match self.meta.get(key)? {
            Meta::Integer(integer) => Some(*integer),
            Meta::Text(text) => text.parse().ok(),
            Meta::Number(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_layers_and_colours() {
        let mut frame = Frame::new(1, 1);
        for (value, name) in
            ["R", "direct.R", "G", "direct.G", "B", "direct.B", "normal.X", "normal.Y", "normal.Z"].iter().enumerate()
        {
            frame.push(*name, vec![value as f32]);
        }
        frame.push("stderr.Y", vec![9.0]);
        assert_eq!(frame.layer_names(), ["", "direct", "normal", "stderr"]);
        assert_eq!(frame.rgb(""), Some([&[0.0][..], &[2.0], &[4.0]]));
        assert_eq!(frame.rgb("direct"), Some([&[1.0][..], &[3.0], &[5.0]]));
        assert_eq!(frame.rgb("stderr"), Some([&[9.0][..], &[9.0], &[9.0]]));
        assert_eq!(frame.rgb("normal"), None, "the Y of a vector is no luminance");
        assert_eq!(frame.rgb("absent"), None);
        assert_eq!(frame.get("direct.G").map(|c| (c.layer(), c.component())), Some(("direct", "G")));
        assert_eq!(split_name("a.b.C"), ("a.b", "C"));
    }

    /// Changing one copy leaves the others as they were.
    #[test]
    fn copies_share_memory_until_one_is_changed() {
        let mut red = Samples::from(vec![1.0, 2.0]);
        let green = red.clone();
        assert!(red.is_shared_with(&green));
        red[1] = 3.0;
        assert!(!red.is_shared_with(&green));
        assert!(red == [1.0, 3.0] && green == [1.0, 2.0]);
    }

    #[test]
    fn metadata_by_type() {
        let mut frame = Frame::new(1, 1);
        frame.meta.insert("seed".into(), Meta::Text("12345678901234".into()));
        frame.meta.insert("passes".into(), Meta::Integer(7));
        assert_eq!(frame.integer("seed"), Some(12_345_678_901_234));
        assert_eq!((frame.integer("passes"), frame.number("passes")), (Some(7), Some(7.0)));
        assert_eq!((frame.text("passes"), frame.number("seed"), frame.integer("absent")), (None, None, None));
    }
}
