//! Cryptomatte layers: which parts, optical roles and materials a pixel shows, and how much of it each covers.
//!
//! Format: "Cryptomatte Specification version 1.2.0" (Psyop, github.com/Psyop/Cryptomatte): names are hashed with
//! MurmurHash3_x86_32, the hash's bits are an f32, and `NAME00`, `NAME01`, … hold (identity, coverage) pairs of the
//! ranks 0 and 1, 2 and 3, … in the channels r, g, b, a.

use super::frame::{Channel, Frame, Meta};
use eyebox_base::murmur3::murmur3_32;
use std::collections::BTreeMap;

/// A Cryptomatte of ours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Matte {
    Part,
    Role,
    Material,
    PartSeen,
    RoleSeen,
    MaterialSeen,
}

/// What a matte tells apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MatteBy {
    Part,
    /// What a face is optically.
    Role,
    /// The asset's material of a face.
    Material,
}

impl Matte {
    pub const ALL: [Matte; 6] =
        [Matte::Part, Matte::Role, Matte::Material, Matte::PartSeen, Matte::RoleSeen, Matte::MaterialSeen];

    /// The name before the number in layer names.
    pub fn name(self) -> &'static str {
        match self {
            Matte::Part => "CryptoPart",
            Matte::Role => "CryptoRole",
            Matte::Material => "CryptoMaterial",
            Matte::PartSeen => "CryptoPartSeen",
            Matte::RoleSeen => "CryptoRoleSeen",
            Matte::MaterialSeen => "CryptoMaterialSeen",
        }
    }

    /// The matte that a layer such as `CryptoPart01` belongs to, or that is called so itself.
    pub fn of_layer(layer: &str) -> Option<Matte> {
        let name = layer.trim_end_matches(|c: char| c.is_ascii_digit());
        Matte::ALL.into_iter().find(|matte| matte.name() == name)
    }

    /// Whether it shows what is behind specular faces.
    pub fn is_seen(self) -> bool {
        match self {
            Matte::Part | Matte::Role | Matte::Material => false,
            Matte::PartSeen | Matte::RoleSeen | Matte::MaterialSeen => true,
        }
    }

    /// What it tells apart.
    pub fn by(self) -> MatteBy {
        match self {
            Matte::Part | Matte::PartSeen => MatteBy::Part,
            Matte::Role | Matte::RoleSeen => MatteBy::Role,
            Matte::Material | Matte::MaterialSeen => MatteBy::Material,
        }
    }
}

/// Names that a pixel can hold: the specification's suggested default, three layers.
pub const RANKS: usize = 6;
/// Looks per pixel; a power of two, so that coverages are exact and add up to 1.
pub const POINTS: usize = 16;
/// Where nothing is hit (the specification's section "Hash").
pub const NOTHING: u32 = 0;

/// The bits of a name's identity: its hash with one bit of the exponent turned where it would be no ordinary number
/// (section "Floating point conversion").
pub fn identity(name: &str) -> u32 {
    let hash = murmur3_32(name.as_bytes());
    match hash >> 23 & 0xff {
        0 | 0xff => hash ^ 1 << 23,
        _ => hash,
    }
}

/// Identities and coverages of one pixel, the largest coverage first and the smaller identity among equals; what has
/// no rank left is not told.
pub type Ranked = [[f32; 2]; RANKS];

/// Ranks what the looks at a pixel met.
pub fn rank(mut met: [u32; POINTS]) -> Ranked {
    met.sort_unstable();
    let mut counts = [(0u32, NOTHING); POINTS];
    let mut used = 0;
    for (index, identity) in met.iter().enumerate() {
        if index > 0 && counts[used].1 == *identity {
            counts[used].0 += 1;
        } else {
            used += usize::from(index > 0);
            counts[used] = (1, *identity);
        }
    }
    counts.sort_by_key(|(count, identity)| (std::cmp::Reverse(*count), *identity));
    std::array::from_fn(|rank| {
        let (count, identity) = counts[rank];
        [f32::from_bits(identity), count as f32 / POINTS as f32]
    })
}

/// Adds the layers of a matte, `ranked` row by row from the top left, and what decoders need to know of it: `names` are
/// all that may occur.
pub fn add(frame: &mut Frame, matte: Matte, ranked: &[Ranked], names: &[&str]) {
    for layer in 0..RANKS / 2 {
        for (component, (rank, which)) in ["r", "g", "b", "a"].into_iter().zip([(0, 0), (0, 1), (1, 0), (1, 1)]) {
            let data = ranked.iter().map(|pixel| pixel[2 * layer + rank][which]).collect();
            frame.channels.push(Channel { name: format!("{}{layer:02}.{component}", matte.name()), data });
        }
    }
    frame.meta.extend(header(matte, names));
}

/// The attributes of a matte, under the names that the specification gives them.
fn header(matte: Matte, names: &[&str]) -> Vec<(String, Meta)> {
    let manifest: BTreeMap<&str, String> =
        names.iter().map(|name| (*name, format!("{:08x}", identity(name)))).collect();
    // Keys that are texts always serialise.
    let manifest = serde_json::to_string(&manifest).unwrap_or_else(|_| "{}".to_owned());
    let at = |what: &str| key(matte.name(), what);
    let text = |text: &str| Meta::Text(text.to_owned());
    vec![
        (at("name"), text(matte.name())),
        (at("hash"), text("MurmurHash3_32")),
        (at("conversion"), text("uint32_to_float32")),
        (at("manifest"), Meta::Text(manifest)),
    ]
}

/// The attribute of a matte that layers are called by: the first seven digits of its name's hash, as the specification suggests.
pub fn key(name: &str, what: &str) -> String {
    let hash = format!("{:08x}", identity(name));
    format!("{KEYS}{}/{what}", &hash[..7])
}

/// The attribute `own`, if it is one of the matte `from`, as that of the matte `to`.
pub fn renamed(own: &str, from: &str, to: &str) -> Option<String> {
    let what = own.strip_prefix(KEYS)?.split_once('/')?.1;
    (key(from, what) == own).then(|| key(to, what))
}

/// Metadata that begins so is an attribute of this name in a file, without a prefix of ours.
pub const KEYS: &str = "cryptomatte/";

/// Takes the layers of a matte out, with what was said of it.
pub fn remove(frame: &mut Frame, matte: Matte) {
    frame.channels.retain(|channel| Matte::of_layer(channel.layer()) != Some(matte));
    for (key, _) in header(matte, &[]) {
        frame.meta.remove(&key);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `tests/data/cryptomatte/hashes.tsv`: PyPI mmh3's hashes, and the specification's and its test suite's floats.
    #[test]
    fn identities_are_the_published_ones() {
        let table = include_str!("../../tests/data/cryptomatte/hashes.tsv");
        let mut rows = 0;
        for line in table.lines().filter(|line| !line.starts_with('#')) {
            let [name, hash, bits, float] = line.split('\t').collect::<Vec<_>>()[..] else { panic!("{line}") };
            assert_eq!(murmur3_32(name.as_bytes()), hash.parse::<u32>().unwrap(), "{name}");
            assert_eq!(format!("{:08x}", identity(name)), bits, "{name}");
            let value = f32::from_bits(identity(name));
            assert!(value.is_normal(), "{name}");
            if !float.is_empty() {
                assert_eq!(value, float.parse::<f32>().unwrap(), "{name}");
            }
            rows += 1;
        }
        assert!(rows > 25, "{rows} rows");
    }

    #[test]
    fn ranks_by_coverage_and_then_by_identity() {
        let mut met = [7; POINTS];
        met[..4].fill(9);
        met[4..8].fill(3);
        met[8] = NOTHING;
        let ranked = rank(met).map(|[identity, coverage]| (identity.to_bits(), coverage * POINTS as f32));
        assert_eq!(ranked, [(7, 7.0), (3, 4.0), (9, 4.0), (0, 1.0), (0, 0.0), (0, 0.0)]);
        let each: [u32; POINTS] = std::array::from_fn(|i| 100 - i as u32);
        let ranked = rank(each).map(|[identity, _]| identity.to_bits());
        assert_eq!(ranked, [85, 86, 87, 88, 89, 90]);
        assert_eq!(rank([5; POINTS])[0][1], 1.0);
    }

    #[test]
    fn layers_and_attributes() {
        let mut frame = Frame::new(1, 1);
        frame.push("R", vec![0.0]);
        let names = ["bunny", "default", "a \"quoted\" name"];
        for matte in [Matte::Part, Matte::PartSeen] {
            add(&mut frame, matte, &[rank([identity("bunny"); POINTS])], &names);
        }
        assert_eq!(frame.layer_names()[..5], ["", "CryptoPart00", "CryptoPart01", "CryptoPart02", "CryptoPartSeen00"]);
        assert_eq!(frame.get("CryptoPart00.g").unwrap().data, [1.0]);
        let key = frame.meta.keys().next().unwrap().clone();
        assert!(key.len() == "cryptomatte/3201c4f/".len() + "conversion".len(), "{key}");
        let manifest: serde_json::Value =
            serde_json::from_str(frame.text("cryptomatte/3201c4f/manifest").unwrap()).unwrap();
        assert_eq!(manifest["bunny"], "13851a76", "the specification's example");
        assert_eq!(manifest.as_object().unwrap().len(), 3);
        assert_eq!(frame.text("cryptomatte/3201c4f/name"), Some("CryptoPart"));
        remove(&mut frame, Matte::Part);
        assert_eq!(frame.layer_names()[1], "CryptoPartSeen00");
        assert_eq!(frame.meta.len(), 4);
        assert_eq!(Matte::of_layer("CryptoRoleSeen02"), Some(Matte::RoleSeen));
        assert_eq!(Matte::of_layer("CryptoRoles"), None);
    }
}
