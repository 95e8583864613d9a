//! A tree of values with their places: TOML, JSON and (later) USD attributes look alike to the attribute readers, and
//! every error can say where the value stands.

use eyebox_base::error::Result;
use eyebox_base::{Error, Where};
use std::fmt;

/// A value and where it stands in the user's material.
#[derive(Debug, Clone, PartialEq)]
pub struct Value {
    pub data: Data,
    pub at: Where,
}

#[derive(Debug, Clone, PartialEq)]
pub enum Data {
    Bool(bool),
    Number(f64),
    Text(String),
    List(Vec<Value>),
    /// In the order of the file.
    Table(Vec<(String, Value)>),
}

impl Value {
    pub fn new(data: Data, at: Where) -> Self {
        Value { data, at }
    }
    /// What it is, for messages: "a number", "a table", …
    pub fn kind(&self) -> &'static str {
        match &self.data {
            Data::Bool(_) => "true/false",
            Data::Number(_) => "a number",
            Data::Text(_) => "a text",
            Data::List(_) => "a list",
            Data::Table(_) => "a table",
        }
    }
    /// The entry `key` of a table.
    pub fn get(&self, key: &str) -> Option<&Value> {
        match &self.data {
            Data::Table(entries) => entries.iter().find(|(name, _)| name == key).map(|(_, value)| value),
            Data::Bool(_) | Data::Number(_) | Data::Text(_) | Data::List(_) => None,
        }
    }
}

impl Value {
    pub fn text(&self) -> Option<&str> {
        match &self.data {
            Data::Text(text) => Some(text),
            Data::Bool(_) | Data::Number(_) | Data::List(_) | Data::Table(_) => None,
        }
    }
    pub fn number(&self) -> Option<f64> {
        match &self.data {
            Data::Number(number) => Some(*number),
            Data::Bool(_) | Data::Text(_) | Data::List(_) | Data::Table(_) => None,
        }
    }
    pub fn list(&self) -> Option<&[Value]> {
        match &self.data {
            Data::List(items) => Some(items),
            Data::Bool(_) | Data::Number(_) | Data::Text(_) | Data::Table(_) => None,
        }
    }
    pub fn table(&self) -> Option<&[(String, Value)]> {
        match &self.data {
            Data::Table(entries) => Some(entries),
            Data::Bool(_) | Data::Number(_) | Data::Text(_) | Data::List(_) => None,
        }
    }
    /// An error for a value that is not what it should be; `what` is its name in words.
    pub fn wrong(&self, what: &str, expected: &str) -> Box<Error> {
        Error::new(self.at.clone(), format!("{what} is {} ({self})", self.kind())).expected(expected)
    }
    /// An error for the value of a key that `what` does not have.
    pub fn unknown_key(&self, key: &str, what: &str, valid: &[&str]) -> Box<Error> {
        Error::new(self.at.clone(), format!("unknown key `{key}` of {what}"))
            .expected(format!("one of {}", valid.join(", ")))
            .nearest(key, valid.iter().copied())
    }
    /// Whether two values say the same, wherever they stand; a table's order says nothing.
    pub fn same(&self, other: &Value) -> bool {
        match (&self.data, &other.data) {
            (Data::List(a), Data::List(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.same(b)),
            (Data::Table(a), Data::Table(b)) => {
                a.len() == b.len() && a.iter().all(|(key, value)| other.get(key).is_some_and(|b| value.same(b)))
            }
            (a, b) => a == b,
        }
    }
}

/// As one would write it in TOML, on one line.
impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.data {
            Data::Bool(flag) => write!(f, "{flag}"),
            Data::Number(number) => write!(f, "{number}"),
            Data::Text(text) => write!(f, "{text:?}"),
            Data::List(items) => {
                f.write_str("[")?;
                for (i, item) in items.iter().enumerate() {
                    write!(f, "{}{item}", if i == 0 { "" } else { ", " })?;
                }
                f.write_str("]")
            }
            Data::Table(entries) => {
                f.write_str("{")?;
                for (i, (key, value)) in entries.iter().enumerate() {
                    write!(f, "{} {key} = {value}", if i == 0 { "" } else { "," })?;
                }
                f.write_str(" }")
            }
        }
    }
}

impl Value {
    /// As JSON, which has no infinity: that is the text `"inf"`, as all readers take it. Numbers keep every bit (whole
    /// ones are written without a fraction).
    ///
    /// # Errors
    /// NaN and −∞, which no attribute can mean; none come out of a reader.
    pub fn to_json(&self) -> Result<serde_json::Value> {
        Ok(match &self.data {
            Data::Bool(flag) => (*flag).into(),
            Data::Number(number) if *number == f64::INFINITY => "inf".into(),
            Data::Number(number) => {
                // 2^53: below it every whole number is exact in both; −0 is not whole for JSON.
                let whole = number.fract() == 0.0 && number.abs() < 9_007_199_254_740_992.0;
                if whole && !(*number == 0.0 && number.is_sign_negative()) {
                    return Ok((*number as i64).into());
                }
                let json = serde_json::Number::from_f64(*number).map(serde_json::Value::Number);
                json.ok_or_else(|| Error::new(self.at.clone(), format!("{number} can't be written")))?
            }
            Data::Text(text) => text.as_str().into(),
            Data::List(items) => items.iter().map(Value::to_json).collect::<Result<Vec<_>>>()?.into(),
            Data::Table(entries) => {
                let entries = entries.iter().map(|(key, value)| Ok((key.clone(), value.to_json()?)));
                serde_json::Value::Object(entries.collect::<Result<_>>()?)
            }
        })
    }
}
