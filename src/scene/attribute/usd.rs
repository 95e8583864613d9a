//! The attribute table as USD properties. Every name is `eyebox:` and the way to the row: `eyebox:medium:ior`,
//! `eyebox:finish` and `eyebox:finish:reflectance`, `eyebox:coating:stack:n`. A value becomes
//!
//! - a kind: a token with its name, and one property for each parameter below it;
//! - a table: one property for each entry below it, nothing for the table itself;
//! - a list of tables: parallel arrays; [`unsaid`] or `""` where a table lacks an entry;
//! - a text, a length with its unit: a token; a file: an asset path; a whole number: an int;
//! - a number that may also be a table of rows: a double, or the rows as `…:table`.
//!
//! [`flatten`] and [`gather`] are inverse to each other for values as `gather` writes them. References by name stay
//! tokens (a sidecar may define the name); those by index mean nothing in USD, so a writer replaces them first.

mod flatten;
mod gather;
mod layout;
#[cfg(test)]
mod tests;

pub use flatten::flatten;
pub use gather::gather;
pub use layout::{Property, properties};

use super::{Noun, Row, own_rows, row};
use eyebox_base::Where;

/// What stands for a number that isn't said in one of several parallel arrays, which the row doesn't allow: −1, or −∞ where it
/// allows all numbers.
pub fn unsaid(row: &Row) -> f64 {
    if row.range.holds(-1.0) { f64::NEG_INFINITY } else { -1.0 }
}

/// The namespace of all our properties.
pub const NAMESPACE: &str = "eyebox:";

/// The value types that we use, by their names in USD.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum UsdType {
    Double,
    Double2,
    Double3,
    Doubles,
    Double2s,
    Double3s,
    Int,
    Int2,
    Ints,
    Token,
    Tokens,
    Asset,
}

impl UsdType {
    pub fn name(self) -> &'static str {
        match self {
            UsdType::Double => "double",
            UsdType::Double2 => "double2",
            UsdType::Double3 => "double3",
            UsdType::Doubles => "double[]",
            UsdType::Double2s => "double2[]",
            UsdType::Double3s => "double3[]",
            UsdType::Int => "int",
            UsdType::Int2 => "int2",
            UsdType::Ints => "int[]",
            UsdType::Token => "token",
            UsdType::Tokens => "token[]",
            UsdType::Asset => "asset",
        }
    }
}

/// A value of a USD property, whatever program reads or writes it.
#[derive(Debug, Clone, PartialEq)]
pub enum UsdValue {
    Double(f64),
    Double2([f64; 2]),
    Double3([f64; 3]),
    Doubles(Vec<f64>),
    Double2s(Vec<[f64; 2]>),
    Double3s(Vec<[f64; 3]>),
    Int(i32),
    Int2([i32; 2]),
    Ints(Vec<i32>),
    Token(String),
    Tokens(Vec<String>),
    Asset(String),
}

impl UsdValue {
    pub fn ty(&self) -> UsdType {
        match self {
            UsdValue::Double(_) => UsdType::Double,
            UsdValue::Double2(_) => UsdType::Double2,
            UsdValue::Double3(_) => UsdType::Double3,
            UsdValue::Doubles(_) => UsdType::Doubles,
            UsdValue::Double2s(_) => UsdType::Double2s,
            UsdValue::Double3s(_) => UsdType::Double3s,
            UsdValue::Int(_) => UsdType::Int,
            UsdValue::Int2(_) => UsdType::Int2,
            UsdValue::Ints(_) => UsdType::Ints,
            UsdValue::Token(_) => UsdType::Token,
            UsdValue::Tokens(_) => UsdType::Tokens,
            UsdValue::Asset(_) => UsdType::Asset,
        }
    }
}

/// A property with its value.
#[derive(Debug, Clone, PartialEq)]
pub struct UsdProperty {
    /// With the namespace.
    pub name: String,
    pub value: UsdValue,
    pub at: Where,
}

/// Where an attribute stands: at the top of what a prim says, in `default`, or in an entry of `faces`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Level {
    Prim,
    Default,
    Faces,
}

/// What a key of a table of attributes means.
enum Entry {
    /// A value of this row, as the property of this name (without prefix).
    Row(String, &'static Row),
    /// A table with any of a noun's rows, below the noun's name.
    Noun(Noun),
    Default,
    Faces,
    /// Which faces: numbers, a direction.
    Numbers,
    Direction,
}

/// The keys of a table of attributes, in the order in which they are written.
fn keys(level: Level) -> Vec<&'static str> {
    let mut keys = Vec::new();
    match level {
        Level::Prim => keys.extend(["version", "unit", "wavelengths", "sky", "sun", "eye", "default"]),
        Level::Default => {}
        Level::Faces => keys.extend(["faces", "normal"]),
    }
    keys.push("medium");
    keys.extend(super::MEDIUM.into_iter().filter(|name| *name != "name"));
    keys.extend(["finish", "coating", "shape", "emitter", "slide", "sensor"]);
    if level == Level::Prim {
        keys.push("faces");
    }
    keys
}

/// What `key` means at `level`; none if nothing.
fn entry(level: Level, key: &str) -> Option<Entry> {
    let own = |noun: Noun| row(noun, key).map(|row| Entry::Row(key.to_owned(), row));
    match (key, level) {
        ("version" | "unit" | "wavelengths", Level::Prim) => {
            row(Noun::Asset, key).map(|row| Entry::Row(format!("asset:{key}"), row))
        }
        ("sky", Level::Prim) => Some(Entry::Noun(Noun::Sky)),
        ("sun", Level::Prim) => Some(Entry::Noun(Noun::Sun)),
        ("eye", Level::Prim) => Some(Entry::Noun(Noun::Eye)),
        ("default", Level::Prim) => Some(Entry::Default),
        ("faces", Level::Prim) => Some(Entry::Faces),
        ("faces", Level::Faces) => Some(Entry::Numbers),
        ("normal", Level::Faces) => Some(Entry::Direction),
        ("medium", _) => own(Noun::Medium),
        ("finish", _) => own(Noun::Finish),
        ("coating", _) => own(Noun::Coating),
        ("shape", _) => own(Noun::Shape),
        ("emitter", _) => own(Noun::Emitter),
        ("slide", _) => own(Noun::Slide),
        ("sensor", _) => own(Noun::Sensor),
        ("name", _) => None,
        (key, _) if super::MEDIUM.contains(&key) => {
            row(Noun::Medium, key).map(|row| Entry::Row(format!("medium:{key}"), row))
        }
        _ => None,
    }
}

/// The rows of a noun that has no attribute of its own name.
fn whole(noun: Noun) -> Vec<&'static str> {
    own_rows(noun).map(|row| row.name).collect()
}
