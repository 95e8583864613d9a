//! What is said about an asset as a whole: the sidecar and the asset's own root attributes, side by side. The sidecar wins.

use super::binding_slots::Slot;
use super::optics;
use super::value::{Data, Value};
use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Where};

/// Everything said at the top level.
#[derive(Debug, Clone)]
pub struct AssetAttributes {
    pub unit: Option<Value>,
    pub wavelengths: Option<Value>,
    /// `[default]`: what holds where nothing else binds; the sidecar's replaces the asset's.
    pub default: Option<Value>,
    pub coatings: Library,
    pub media: Library,
    pub emitters: Library,
    pub slides: Library,
    /// `[[bind]]`, in order.
    pub binds: Vec<Value>,
    pub sky: Option<Value>,
    pub sun: Option<Value>,
    pub eye: Option<Value>,
}

/// Named things of one noun, and the asset's own by index.
#[derive(Debug, Clone)]
pub struct Library {
    pub noun: &'static str,
    /// The sidecar's first.
    pub named: Vec<(String, Value)>,
    /// The asset's root array.
    pub indexed: Vec<Value>,
}

const SIDECAR: [&str; 10] =
    ["schema", "asset", "unit", "wavelengths", "default", "coating", "medium", "bind", "sky", "sun"];
const ROOT: [&str; 10] =
    ["version", "unit", "wavelengths", "default", "media", "coatings", "emitters", "slides", "sky", "sun"];

impl AssetAttributes {
    /// Faults: unknown keys, wrong versions, tables that are none.
    pub fn new(sidecar: Option<&Value>, asset: Option<&Value>) -> Result<Self> {
        if let Some(sidecar) = sidecar {
            keys(sidecar, "a sidecar", SIDECAR.iter().copied().chain(["eye"]))?;
            optics::version(sidecar, "schema")?;
        }
        if let Some(asset) = asset {
            keys(asset, "the asset's EYEBOX_optics", ROOT.iter().copied().chain(["eye"]))?;
            optics::version(asset, "version")?;
        }
        let of = |from: Option<&Value>, key: &str| from.and_then(|table| table.get(key)).cloned();
        let either = |key: &str| of(sidecar, key).or_else(|| of(asset, key));
        let merged = |key: &str| -> Result<Option<Value>> {
            Ok(match (of(sidecar, key), of(asset, key)) {
                (Some(over), Some(under)) => Some(merge(over, under, key)?),
                (over, under) => over.or(under),
            })
        };
        let library = |noun: &'static str, table: Option<&str>, array: &str| -> Result<Library> {
            let mut named = Vec::new();
            if let Some(value) = table.and_then(|key| of(sidecar, key)) {
                named.extend(entries(&value, &format!("`{noun}`"))?.to_vec());
            }
            let indexed = match of(asset, array) {
                Some(value) => list(&value, array)?.to_vec(),
                None => Vec::new(),
            };
            for item in &indexed {
                if let Some(name) = item.get("name").and_then(Value::text) {
                    named.push((name.to_owned(), item.clone()));
                }
            }
            Ok(Library { noun, named, indexed })
        };
        let default = either("default");
        if let Some(default) = &default {
            entries(default, "`default`")?;
        }
        Ok(AssetAttributes {
            unit: either("unit"),
            wavelengths: either("wavelengths"),
            default,
            coatings: library("coating", Some("coating"), "coatings")?,
            media: library("medium", Some("medium"), "media")?,
            emitters: library("emitter", None, "emitters")?,
            slides: library("slide", None, "slides")?,
            binds: match of(sidecar, "bind") {
                Some(value) => list(&value, "bind")?.to_vec(),
                None => Vec::new(),
            },
            sky: merged("sky")?,
            sun: merged("sun")?,
            eye: merged("eye")?,
        })
    }
}

impl AssetAttributes {
    /// What a value of `slot` leads to, if it is a name or an index.
    pub fn followed<'a>(&'a self, slot: Slot, value: &'a Value) -> Result<&'a Value> {
        match slot {
            Slot::Coating => self.coatings.follow(value),
            Slot::Emitter => self.emitters.follow(value),
            Slot::Slide => self.slides.follow(value),
            Slot::Index | Slot::Absorption | Slot::Priority | Slot::Finish | Slot::Shape | Slot::Sensor => Ok(value),
        }
    }
}

impl Library {
    /// The sidecar's, by name; the asset's own stand in `indexed` too.
    pub fn own(&self) -> impl Iterator<Item = &(String, Value)> {
        self.named.iter().filter(|(_, value)| !self.indexed.contains(value))
    }
    pub fn names(&self) -> impl Iterator<Item = &str> + Clone {
        self.named.iter().map(|(name, _)| name.as_str())
    }
    pub fn by_name(&self, name: &str) -> Option<&Value> {
        self.named.iter().find(|(own, _)| own == name).map(|(_, value)| value)
    }
    /// What a reference (a name or an index) leads to; anything else is meant itself. Faults: an index beyond the array.
    pub fn follow<'a>(&'a self, value: &'a Value) -> Result<&'a Value> {
        match &value.data {
            Data::Text(name) => Ok(self.by_name(name).unwrap_or(value)),
            Data::Number(index) => {
                let whole = *index as usize;
                let found = if whole as f64 == *index { self.indexed.get(whole) } else { None };
                found.ok_or_else(|| {
                    let count = self.indexed.len();
                    let expected = match count {
                        0 => format!("the asset to have {}s; it has none", self.noun),
                        _ => format!("an index from 0 to {}", count - 1),
                    };
                    Error::new(value.at.clone(), format!("{} {index} does not exist", self.noun)).expected(expected)
                })
            }
            Data::Bool(_) | Data::List(_) | Data::Table(_) => Ok(value),
        }
    }
}

/// `over`'s entries, then those of `under` that it lacks.
fn merge(over: Value, under: Value, key: &str) -> Result<Value> {
    let mut all = entries(&over, key)?.to_vec();
    // Another kind of sky leaves what goes with the asset's own behind.
    let kind = optics::kind_of_sky(all.iter().map(|(name, _)| name.as_str())).filter(|_| key == "sky");
    for (name, value) in entries(&under, key)? {
        if over.get(name).is_none() && kind.is_none_or(|kind| optics::goes_with_sky(kind, name)) {
            all.push((name.clone(), value.clone()));
        }
    }
    Ok(Value::new(Data::Table(all), over.at))
}

fn keys<'a>(table: &Value, what: &str, valid: impl Iterator<Item = &'a str> + Clone) -> Result<()> {
    for (key, value) in entries(table, what)? {
        if !valid.clone().any(|name| name == key) {
            return Err(Error::new(value.at.clone(), format!("unknown key `{key}` of {what}"))
                .expected(format!("one of {}", valid.clone().collect::<Vec<_>>().join(", ")))
                .nearest(key, valid)
                .code(Code::AttributeUnknown));
        }
    }
    Ok(())
}

pub fn entries<'a>(value: &'a Value, what: &str) -> Result<&'a [(String, Value)]> {
    value.table().ok_or_else(|| {
        Error::new(value.at.clone(), format!("{what} is {} ({value})", value.kind())).expected("a table")
    })
}

fn list<'a>(value: &'a Value, what: &str) -> Result<&'a [Value]> {
    value.list().ok_or_else(|| {
        Error::new(value.at.clone(), format!("`{what}` is {}", value.kind())).expected("a list of tables")
    })
}

/// The place of the sheet itself, for a fault that something is missing from it.
pub fn place(sidecar: Option<&Value>, file: &std::path::Path) -> Where {
    match sidecar.map(|value| &value.at) {
        Some(Where::Line { file, .. }) => Where::file(file),
        Some(at) => at.clone(),
        None => Where::file(file),
    }
}
