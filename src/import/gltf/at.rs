//! A cursor into the raw JSON that knows its pointer: every wrong type, missing entry or index out of range becomes a
//! fault at its exact place.

use super::notes::Budget;
use crate::{json, value::Value};
use eyebox_base::{Error, Where, error::Result};
use serde_json::Value as Json;
use std::path::Path;

/// A JSON value and where it stands.
#[derive(Debug, Clone)]
pub(super) struct At<'a> {
    pub file: &'a Path,
    pub json: &'a Json,
    pub pointer: String,
}

impl<'a> At<'a> {
    pub fn root(file: &'a Path, json: &'a Json) -> Self {
        At { file, json, pointer: String::new() }
    }
    pub fn place(&self) -> Where {
        Where::Pointer { file: self.file.to_owned(), pointer: self.pointer.clone() }
    }
    pub fn fault(&self, what: impl Into<String>) -> Box<Error> {
        Error::new(self.place(), what)
    }
    fn wrong(&self, expected: &str) -> Box<Error> {
        let given = match self.json {
            Json::Null => "null".to_owned(),
            Json::Bool(flag) => flag.to_string(),
            Json::Number(number) => number.to_string(),
            Json::String(_) => "a text".to_owned(),
            Json::Array(_) => "a list".to_owned(),
            Json::Object(_) => "an object".to_owned(),
        };
        self.fault(format!("{given} cannot stand here")).expected(expected)
    }

    /// The entry `key` of this object.
    pub fn get(&self, key: &str) -> Result<Option<At<'a>>> {
        let Json::Object(entries) = self.json else { return Err(self.wrong("an object")) };
        let entry = |json| At { file: self.file, json, pointer: json::step(&self.pointer, key) };
        Ok(entries.get(key).map(entry))
    }
    pub fn want(&self, key: &str) -> Result<At<'a>> {
        self.get(key)?.ok_or_else(|| self.fault(format!("`{key}` is missing")))
    }
    /// The object `extensions.NAME` of this object.
    pub fn extension(&self, name: &str) -> Result<Option<At<'a>>> {
        match self.get("extensions")? {
            Some(extensions) => extensions.get(name),
            None => Ok(None),
        }
    }
    /// The attributes that this object carries for us.
    pub fn optics(&self, budget: &mut Budget) -> Result<Option<Value>> {
        let Some(at) = self.extension("EYEBOX_optics")? else { return Ok(None) };
        budget.charge(&at, 1, at.weight())?;
        json::value(at.json, at.file, &at.pointer).map(Some)
    }
    /// About the bytes of this value as a tree of attributes.
    pub fn weight(&self) -> usize {
        json::weight(self.json, self.pointer.len() + self.file.as_os_str().len())
    }
    /// The elements of this list.
    pub fn items(&self) -> Result<Vec<At<'a>>> {
        let Json::Array(items) = self.json else { return Err(self.wrong("a list")) };
        let item = |(i, json)| At { file: self.file, json, pointer: format!("{}/{i}", self.pointer) };
        Ok(items.iter().enumerate().map(item).collect())
    }
    /// The elements of the list `key` of this object; none if it is absent.
    pub fn list(&self, key: &str) -> Result<Vec<At<'a>>> {
        self.get(key)?.map_or(Ok(Vec::new()), |list| list.items())
    }

    pub fn text(&self) -> Result<&'a str> {
        self.json.as_str().ok_or_else(|| self.wrong("a text"))
    }
    pub fn flag(&self) -> Result<bool> {
        self.json.as_bool().ok_or_else(|| self.wrong("true or false"))
    }
    pub fn number(&self) -> Result<f64> {
        self.json.as_f64().filter(|x| x.is_finite()).ok_or_else(|| self.wrong("a number"))
    }
    /// A number between `low` and `high`, both allowed.
    pub fn number_in(&self, low: f64, high: f64) -> Result<f64> {
        let number = self.number()?;
        if (low..=high).contains(&number) {
            return Ok(number);
        }
        let range = if high.is_finite() { format!("{low} to {high}") } else { format!("at least {low}") };
        Err(self.fault(format!("{number} is out of range")).expected(range))
    }
    /// Exactly `N` finite numbers.
    pub fn numbers<const N: usize>(&self) -> Result<[f64; N]> {
        let items = self.items()?;
        if items.len() != N {
            return Err(self.fault(format!("{} numbers", items.len())).expected(format!("{N} numbers")));
        }
        let mut out = [0.0; N];
        for (slot, item) in out.iter_mut().zip(&items) {
            *slot = item.number()?;
        }
        Ok(out)
    }
    /// A whole number from 0; `3.0` is one, too (some writers know only floating-point numbers).
    pub fn count(&self) -> Result<usize> {
        const EXACT: f64 = 9_007_199_254_740_992.0; // 2^53
        let whole = |x: f64| ((0.0..=EXACT).contains(&x) && x.fract() == 0.0).then_some(x as u64);
        let count = self.json.as_u64().or_else(|| self.json.as_f64().and_then(whole));
        count.and_then(|n| usize::try_from(n).ok()).ok_or_else(|| self.wrong("a whole number from 0"))
    }
    /// The count `key` of this object, `default` if it is absent.
    pub fn count_or(&self, key: &str, default: usize) -> Result<usize> {
        self.get(key)?.map_or(Ok(default), |at| at.count())
    }
    /// An index into `length` things called `what`.
    pub fn index(&self, length: usize, what: &str) -> Result<usize> {
        let index = self.count()?;
        if index < length {
            return Ok(index);
        }
        let expected = match length {
            0 => format!("no index: there is no {what}"),
            1 => "0".to_owned(),
            _ => format!("0 to {}", length - 1),
        };
        Err(self.fault(format!("{what} {index} does not exist")).expected(expected))
    }
    /// The name of this object, or `fallback_INDEX` if it has none.
    pub fn name(&self, fallback: &str, index: usize) -> Result<String> {
        match self.get("name")? {
            Some(name) if !name.text()?.is_empty() => Ok(name.text()?.to_owned()),
            Some(_) | None => Ok(format!("{fallback}_{index}")),
        }
    }
}
