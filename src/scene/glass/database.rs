//! The refractiveindex.info database (public domain, CC0) in one compact file, which `make_database.py` makes.
//!
//! Nothing of it is read before a name is looked up: names are sorted in the file, so that a binary search finds one, and the
//! block that holds its entry is inflated then. Little endian, in this order:
//!
//! - number of names, bytes of the pool of names, number of entries, number of blocks: u32 each
//! - per name, by rising letters: where it starts in the pool (u32), its entry (u16); then the pool
//! - per entry: its block (u16), where it starts in it (u32)
//! - where each block starts, and where the last ends (u32); then the blocks (zlib)
//!
//! `entry.rs` says what an entry is.

mod entry;

use super::Glass;
use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::io::Read;
use std::sync::Mutex;

static FILE: &[u8] = include_bytes!("database.bin");

/// Entries that were asked for. They stay for the life of the program, as those of a static catalogue do.
static DECODED: Mutex<BTreeMap<u16, &'static Glass>> = Mutex::new(BTreeMap::new());

/// Where the sections of the file start.
struct Layout {
    names: usize,
    pool: usize,
    pool_end: usize,
    places: usize,
    starts: usize,
    blocks: usize,
    count: usize,
}

fn layout() -> Option<Layout> {
    let [count, pool_bytes, entries, blocks] = [0, 4, 8, 12].map(|at| Some(long(at)? as usize));
    let (count, names) = (count?, 16);
    let pool = names + 6 * count;
    let pool_end = pool + pool_bytes?;
    let starts = pool_end + 6 * entries?;
    Some(Layout { names, pool, pool_end, places: pool_end, starts, blocks: starts + 4 * (blocks? + 1), count })
}

fn short(at: usize) -> Option<u16> {
    FILE.get(at..at + 2)?.try_into().ok().map(u16::from_le_bytes)
}

fn long(at: usize) -> Option<u32> {
    FILE.get(at..at + 4)?.try_into().ok().map(u32::from_le_bytes)
}

impl Layout {
    /// A name and the number of its entry.
    fn name(&self, i: usize) -> Option<(&'static str, u16)> {
        let row = self.names + 6 * i;
        let start = self.pool + long(row)? as usize;
        let end = if i + 1 < self.count { self.pool + long(row + 6)? as usize } else { self.pool_end };
        Some((std::str::from_utf8(FILE.get(start..end)?).ok()?, short(row + 4)?))
    }

    /// The bytes of an entry, and those after it.
    fn entry(&self, number: u16) -> Option<(Vec<u8>, usize)> {
        let place = self.places + 6 * usize::from(number);
        let (block, at) = (usize::from(short(place)?), long(place + 2)? as usize);
        let [start, end] = [block, block + 1].map(|block| Some(self.blocks + long(self.starts + 4 * block)? as usize));
        let mut bytes = Vec::new();
        flate2::read::ZlibDecoder::new(FILE.get(start?..end?)?).read_to_end(&mut bytes).ok()?;
        Some((bytes, at))
    }
}

/// The entry called `name`. Of names with the same letters the one that is spelt so comes first, then the one in the same case
/// (`BaF2` is no `BAF2`), then the one of the maker whom the database lists first.
pub fn find(name: &str) -> Option<&'static Glass> {
    found(name, false)
}

/// The entry that is spelt so.
pub fn exact(name: &str) -> Option<&'static Glass> {
    found(name, true)
}

fn found(name: &str, exact: bool) -> Option<&'static Glass> {
    let layout = layout()?;
    let compare = |i: usize| layout.name(i).map_or(Ordering::Greater, |(own, _)| letters(own).cmp(letters(name)));
    let (mut low, mut high) = (0, layout.count);
    while low < high {
        let middle = low.midpoint(high);
        if compare(middle) == Ordering::Less { low = middle + 1 } else { high = middle }
    }
    let alike: Vec<(&str, u16)> =
        (low..layout.count).take_while(|i| compare(*i) == Ordering::Equal).filter_map(|i| layout.name(i)).collect();
    let spelt = alike.iter().find(|(own, _)| *own == name);
    let same_case = || alike.iter().find(|(own, _)| kept(own).eq(kept(name)));
    let chosen = if exact { spelt } else { spelt.or_else(same_case).or(alike.first()) };
    decoded(chosen?.1)
}

fn decoded(number: u16) -> Option<&'static Glass> {
    let mut known = DECODED.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    if let Some(glass) = known.get(&number) {
        return Some(glass);
    }
    let (bytes, at) = layout()?.entry(number)?;
    let glass: &'static Glass = Box::leak(Box::new(entry::read(bytes.get(at..)?)?));
    known.insert(number, glass);
    Some(glass)
}

/// Every name, sorted.
pub fn names() -> impl Iterator<Item = &'static str> {
    layout().into_iter().flat_map(|layout| (0..layout.count).filter_map(move |i| Some(layout.name(i)?.0)))
}

fn kept(name: &str) -> impl Iterator<Item = char> {
    name.chars().filter(|c| !matches!(c, '-' | '_' | ' ' | '/'))
}

fn letters(name: &str) -> impl Iterator<Item = char> {
    kept(name).map(|c| c.to_ascii_uppercase())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::glass::Kind;

    /// Every name leads to an entry whose law is sound.
    #[test]
    fn every_entry_is_read() {
        let layout = layout().unwrap();
        let mut before: Vec<char> = Vec::new();
        let mut entries = std::collections::BTreeSet::new();
        for i in 0..layout.count {
            let (name, entry) = layout.name(i).unwrap();
            let now: Vec<char> = letters(name).collect();
            assert!(before <= now, "{name}");
            before = now;
            entries.insert(entry);
        }
        assert!(entries.len() > 3400 && entries.iter().copied().eq(0..entries.len() as u16));
        // Inflating a block per entry takes a while where nothing is optimised.
        for number in entries.into_iter().step_by(if cfg!(debug_assertions) { 7 } else { 1 }) {
            let glass = decoded(number).unwrap_or_else(|| panic!("entry {number}"));
            assert_eq!(glass.dispersion.problem(), None, "{}", glass.name);
            assert!(glass.valid_nm[0] < glass.valid_nm[1] && !glass.source.is_empty(), "{}", glass.name);
            assert_eq!(find(glass.name).map(|found| found.name), Some(glass.name));
        }
    }

    #[test]
    fn names_in_every_spelling() {
        for (given, name) in [
            ("SCHOTT N-BK7", "SCHOTT N-BK7"),
            ("schott nbk7", "SCHOTT N-BK7"),
            ("specs/SCHOTT-optical/N-BK7", "SCHOTT N-BK7"),
            ("N-LAK9", "SCHOTT N-LAK9"),
            ("S-LAH79", "OHARA S-LAH79"),
            ("F2", "SCHOTT F2"),
            ("HIKARI F2", "HIKARI F2"),
            ("main/Ag/Johnson", "main/Ag/Johnson"),
            ("Ag Johnson", "main/Ag/Johnson"),
            ("ag_johnson", "main/Ag/Johnson"),
            ("popular_glass/BK7/SCHOTT", "SCHOTT N-BK7"),
        ] {
            assert_eq!(find(given).map(|glass| glass.name), Some(name), "{given}");
        }
        assert_eq!(["BaF2", "BAF2"].map(|name| find(name).unwrap().name), ["CRYSTRAN BaF2", "CDGM BAF2"]);
        assert_eq!(find("CDGM BAF2").unwrap().kind(), Kind::Body);
        for missing in ["", "N-BK77", "Ag/Nobody", "\u{fffd}", "SCHOTT"] {
            assert_eq!(find(missing).map(|glass| glass.name), None, "{missing}");
        }
    }

    #[test]
    fn kinds_are_told_apart() {
        for (name, kind) in [
            ("OHARA S-BSL7", Kind::Body),
            ("main/Ag/Johnson", Kind::Metal),
            ("diamond", Kind::Body),
            ("air", Kind::Gas),
            ("main/Si/Green-2008", Kind::Film),
        ] {
            if let Some(glass) = find(name) {
                assert_eq!(glass.kind(), kind, "{name}: {:?}", glass.dispersion.index(587.56));
            }
        }
    }
}
