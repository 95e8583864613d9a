//! A prim as the other modules see it: authored values at the chosen time, and a place for messages.

use super::notes::Ledger;
use super::value;
use eyebox_base::error::Result;
use eyebox_base::{Error, Where};
use openusd::sdf::{self, Value};
use openusd::usd::{Prim, ResolveInfoSource, TimeCode};
use std::cell::RefCell;
use std::cmp::Ordering;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// The root layer and the time at which values are taken.
#[derive(Debug, Clone)]
pub(super) struct Moment {
    pub file: PathBuf,
    pub frame: Option<f64>,
    /// When what was read so far has values of its own, if somebody asks.
    pub keys: Option<RefCell<Keys>>,
}

/// Times at which something has a value, in order and each once: a thousand prims that move together have the keys of one.
#[derive(Debug, Clone, Default)]
pub(super) struct Keys(BTreeSet<Key>);

#[derive(Debug, Clone, Copy)]
struct Key(f64);

impl Keys {
    /// Finite ones; USD's values at others are no frames.
    pub fn add(&mut self, times: impl IntoIterator<Item = f64>) {
        self.0.extend(times.into_iter().filter(|time| time.is_finite()).map(Key));
    }
    pub fn times(&self) -> Vec<f64> {
        self.0.iter().map(|key| key.0).collect()
    }
}

impl Ord for Key {
    fn cmp(&self, other: &Self) -> Ordering {
        // −0 is 0.
        (self.0 + 0.0).total_cmp(&(other.0 + 0.0))
    }
}

impl PartialOrd for Key {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Key {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Key {}

impl Moment {
    pub fn at(&self, path: &sdf::Path) -> Where {
        Where::Prim { file: self.file.clone(), prim: path.as_str().to_owned() }
    }
    pub fn fault(&self, path: &sdf::Path, what: impl Into<String>) -> Box<Error> {
        Error::new(self.at(path), what)
    }
    /// A failure inside the USD library while reading at `path`.
    pub fn failed(&self, path: &sdf::Path, error: impl std::fmt::Display) -> Box<Error> {
        self.fault(path, format!("cannot be read: {}", one_line(&error.to_string())))
    }
}

/// The library's parse errors show the line in question on lines of their own.
pub(super) fn one_line(text: &str) -> String {
    let mut out = String::with_capacity(text.len().min(400));
    for word in text.split_whitespace() {
        if out.len() > 300 {
            out.push_str(" …");
            break;
        }
        if !out.is_empty() {
            out.push(' ');
        }
        out.push_str(word);
    }
    out
}

/// A prim with the names of its authored properties.
pub(super) struct PrimView {
    pub prim: Prim,
    pub moment: Rc<Moment>,
    names: Vec<String>,
}

impl PrimView {
    pub fn new(prim: Prim, moment: &Rc<Moment>) -> Result<Self> {
        let names = prim.authored_property_names().map_err(|error| moment.failed(prim.path(), error))?;
        let names = names.iter().map(|name| name.as_str().to_owned()).collect();
        Ok(PrimView { prim, moment: Rc::clone(moment), names })
    }
    pub fn path(&self) -> &sdf::Path {
        self.prim.path()
    }
    pub fn name(&self) -> &str {
        self.path().name().unwrap_or_default()
    }
    pub fn at(&self) -> Where {
        self.moment.at(self.path())
    }
    /// The place of a property.
    pub fn at_property(&self, name: &str) -> Where {
        Where::Prim { file: self.moment.file.clone(), prim: format!("{}.{name}", self.path().as_str()) }
    }
    pub fn fault(&self, what: impl Into<String>) -> Box<Error> {
        self.moment.fault(self.path(), what)
    }
    pub fn fault_in(&self, name: &str, what: impl Into<String>) -> Box<Error> {
        Error::new(self.at_property(name), what)
    }

    /// The composed type name; empty if there is none.
    pub fn type_name(&self) -> Result<String> {
        let name = self.prim.type_name().map_err(|error| self.moment.failed(self.path(), error))?;
        Ok(name.map(|name| name.as_str().to_owned()).unwrap_or_default())
    }
    pub fn property_names(&self) -> &[String] {
        &self.names
    }
    /// Whether anything is authored for a property.
    pub fn has(&self, name: &str) -> bool {
        self.names.iter().any(|known| known == name)
    }

    /// The value of an authored attribute at the moment: with a frame, the one of that time; without, the attribute's
    /// own value, else its earliest sample. `None` if nothing is authored or the value is blocked: the schema's fallback
    /// is the caller's to know.
    pub fn get(&self, name: &str) -> Result<Option<Value>> {
        if !self.has(name) {
            return Ok(None);
        }
        let attribute = self.prim.attribute(name);
        if let Some(keys) = &self.moment.keys {
            let failed = |error| Error::new(self.at_property(name), one_line(&format!("cannot be read: {error}")));
            let mut own = attribute.time_samples_in_interval(f64::NEG_INFINITY..=f64::INFINITY).map_err(failed)?;
            // Exporters write the same value for every frame of a range: one of them says all.
            if let [first, others @ ..] = own.as_slice() {
                let at = |time: &f64| attribute.get_at::<Value>(Some(TimeCode::new(*time))).map_err(failed);
                let value = at(first)?;
                let mut moves = false;
                for time in others {
                    moves |= at(time)? != value;
                    if moves {
                        break;
                    }
                }
                own.truncate(if moves { own.len() } else { 1 });
            }
            keys.borrow_mut().add(own);
        }
        let failed = |error| Error::new(self.at_property(name), one_line(&format!("cannot be read: {error}")));
        let authored = |time: Option<TimeCode>| {
            let found = attribute.get_at::<Value>(time).map_err(failed)?;
            // The library decodes a value once more to say where it comes from. It is asked only where the schema may
            // have said the same.
            if found.is_none() || found != attribute.fallback_value().map_err(failed)? {
                return Ok(found);
            }
            match attribute.resolve_info_at(time).map_err(failed)?.source() {
                ResolveInfoSource::None | ResolveInfoSource::Fallback => Ok(None),
                ResolveInfoSource::Default | ResolveInfoSource::TimeSamples | ResolveInfoSource::ValueClips => {
                    Ok(found)
                }
            }
        };
        let time = self.moment.frame.map(TimeCode::new);
        let found = authored(time)?;
        match (found, self.moment.frame) {
            (Some(found), _) => Ok(Some(found)),
            (None, None) => authored(Some(TimeCode::EARLIEST)),
            // Before a blocked sample USD holds the one before it; the library has none to interpolate with.
            (None, Some(frame)) => {
                let around = attribute.bracketing_time_samples(TimeCode::new(frame)).map_err(failed)?;
                match around.filter(|(lower, upper)| *lower < frame && frame < *upper) {
                    Some((lower, _)) => attribute.get_at::<Value>(Some(TimeCode::new(lower))).map_err(failed),
                    None => Ok(None),
                }
            }
        }
    }

    /// As [`get`](Self::get), read by `convert`; a value of another type is a fault that names what is `expected`.
    pub fn read<T>(&self, name: &str, expected: &str, convert: impl FnOnce(Value) -> Option<T>) -> Result<Option<T>> {
        let Some(found) = self.get(name)? else { return Ok(None) };
        match convert(found) {
            Some(value) => Ok(Some(value)),
            None => Err(self.fault_in(name, "a value of another type").expected(expected)),
        }
    }
    pub fn number(&self, name: &str) -> Result<Option<f64>> {
        self.read(name, "a number", |value| value::number(&value))
    }
    /// A finite number that is not negative.
    pub fn length(&self, name: &str) -> Result<Option<f64>> {
        let Some(x) = self.number(name)? else { return Ok(None) };
        if x.is_finite() && x >= 0.0 {
            return Ok(Some(x));
        }
        Err(self.fault_in(name, format!("the value {x}")).expected("a finite number >= 0"))
    }
    pub fn token(&self, name: &str) -> Result<Option<String>> {
        self.read(name, "a token", |value| value::text(&value).map(str::to_owned))
    }
    /// A token of UsdGeomImageable. A value of another type is none, as in USD, where the schema says the type; with a note.
    pub fn token_of_schema(&self, name: &str, ledger: &mut Ledger) -> Result<Option<String>> {
        let Some(found) = self.get(name)? else { return Ok(None) };
        let token = value::text(&found).map(str::to_owned);
        if token.is_none() {
            ledger.warn(self.at_property(name), format!("`{name}` is no token: not said, as in USD"));
        }
        Ok(token)
    }
    pub fn tokens(&self, name: &str) -> Result<Option<Vec<String>>> {
        self.read(name, "a list of tokens", value::texts)
    }
    /// The paths that a relationship leads to; empty if it is not authored.
    pub fn targets(&self, name: &str) -> Result<Vec<sdf::Path>> {
        if !self.has(name) {
            return Ok(Vec::new());
        }
        let found = self.prim.relationship(name).forwarded_targets();
        found.map_err(|error| self.fault_in(name, one_line(&format!("cannot be read: {error}"))))
    }
    /// Metadata of a property, e.g. `interpolation`.
    pub fn property_text(&self, name: &str, key: &str) -> Result<Option<String>> {
        Ok(self.property_value(name, key)?.as_ref().and_then(value::text).map(str::to_owned))
    }
    /// A whole number in the metadata of a property, e.g. `elementSize`.
    pub fn property_number(&self, name: &str, key: &str) -> Result<Option<usize>> {
        let found = self.property_value(name, key)?.as_ref().and_then(value::number);
        Ok(found.filter(|x| *x >= 0.0 && x.fract() == 0.0).map(|x| x as usize))
    }
    /// Metadata of a property.
    pub fn property_value(&self, name: &str, key: &str) -> Result<Option<Value>> {
        let found = self.prim.attribute(name).get_metadata::<Value>(key);
        found.map_err(|error| self.fault_in(name, one_line(&format!("cannot be read: {error}"))))
    }
    pub fn metadata(&self, key: &str) -> Result<Option<Value>> {
        self.prim.get_metadata::<Value>(key).map_err(|error| self.moment.failed(self.path(), error))
    }
    /// The children on the stage, in its order; those of an instance are its prototype's.
    pub fn children(&self) -> Result<Vec<Prim>> {
        self.prim.children().map_err(|error| self.moment.failed(self.path(), error))
    }
}

/// Where a file of an asset path lies, if the library found it.
pub(super) fn resolved(path: &sdf::AssetPath) -> Option<&Path> {
    path.resolved_path().filter(|path| !path.is_empty()).map(Path::new)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_moves_together_has_the_keys_of_one() {
        let mut keys = Keys::default();
        for shift in [0.0, -0.0, 0.5] {
            keys.add((-2..3).map(|time| f64::from(time) + shift));
        }
        keys.add([f64::NAN, f64::INFINITY]);
        assert_eq!(keys.0.len(), 10);
        assert_eq!(keys.times(), [-2.0, -1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5, 2.0, 2.5]);
    }
}
