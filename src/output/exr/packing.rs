//! How the numbers of a file are stored: as whole floats or halves, and by which compression.

use super::naming::{Part, Stored};
use ::exr::meta::attribute::SampleType;
use ::exr::prelude::{Compression, f16};
use eyebox_film::exr::is_word;
use eyebox_film::frame::{Frame, split_name};

/// A compression of OpenEXR.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Packing {
    /// Deflate over 16 lines.
    #[default]
    Zip,
    /// Deflate line by line: for programs that read single lines.
    Zips,
    /// Wavelets: small for noisy pictures.
    Piz,
    /// Nothing is compressed.
    Uncompressed,
    /// Cosines, with loss: small, for looking at. Data keep every bit, so every layer needs a part of its own.
    Dwaa,
}

impl Packing {
    pub const ALL: [Packing; 5] = [Packing::Zip, Packing::Zips, Packing::Piz, Packing::Uncompressed, Packing::Dwaa];

    pub fn name(self) -> &'static str {
        match self {
            Packing::Zip => "zip",
            Packing::Zips => "zips",
            Packing::Piz => "piz",
            Packing::Uncompressed => "none",
            Packing::Dwaa => "dwaa",
        }
    }

    /// By its name. Errors: the names that there are.
    pub fn parse(text: &str) -> Result<Packing, String> {
        let names = Packing::ALL.map(Packing::name);
        let found = Packing::ALL.into_iter().find(|packing| packing.name() == text);
        found
            .ok_or_else(|| format!("`{text}` is no compression that can be written; write one of {}", names.join(", ")))
    }

    /// Whether numbers change.
    fn is_lossy(self) -> bool {
        match self {
            Packing::Zip | Packing::Zips | Packing::Piz | Packing::Uncompressed => false,
            Packing::Dwaa => true,
        }
    }

    /// Errors: numbers change, and data have no part of their own (`parted`) that could keep theirs.
    pub fn spares_data(self, parted: bool) -> Result<(), String> {
        if parted || !self.is_lossy() {
            return Ok(());
        }
        Err(format!("the compression {} would damage data that are in one part with pictures", self.name()))
    }

    /// Of a part.
    pub(super) fn of_part(self, part: &Part) -> Compression {
        let exact = part.data || part.channels.iter().any(|channel| channel.exact);
        match self {
            Packing::Dwaa if exact => Compression::ZIP16,
            Packing::Dwaa => Compression::DWAA(None),
            Packing::Zip => Compression::ZIP16,
            Packing::Zips => Compression::ZIP1,
            Packing::Piz => Compression::PIZ,
            Packing::Uncompressed => Compression::Uncompressed,
        }
    }
}

/// Whether a channel can be a half: one of red, green and blue whose values halves can hold. Data, identities and depths
/// need every bit.
fn fits(part: &Part, stored: &Stored) -> bool {
    let (layer, component) = split_name(&stored.name);
    let picture = !part.data && ["R", "G", "B"].contains(&component) && (layer.is_empty() || is_word(layer));
    let most = f16::MAX.to_f32();
    picture && !stored.exact && stored.data.iter().all(|value| value.abs() <= most || value.is_nan())
}

/// How a channel is stored.
pub(super) fn sample_type(frame: &Frame, part: &Part, stored: &Stored) -> SampleType {
    let half = frame.integer(super::HALF).is_some_and(|half| half != 0);
    if half && fits(part, stored) { SampleType::F16 } else { SampleType::F32 }
}

/// Layers of pictures that are whole floats although halves were asked for: too bright for them.
pub(super) fn too_bright<'p>(frame: &Frame, parts: &'p [Part]) -> Vec<&'p str> {
    let half = frame.integer(super::HALF).is_some_and(|half| half != 0);
    let most = f16::MAX.to_f32();
    let bright = |stored: &&Stored| !stored.exact && stored.data.iter().any(|value| value.abs() > most);
    let pictures = parts.iter().filter(|part| half && !part.data).flat_map(|part| &part.channels).filter(bright);
    let mut layers: Vec<&str> = pictures.map(|stored| split_name(&stored.name).0).collect();
    layers.dedup();
    layers
}
