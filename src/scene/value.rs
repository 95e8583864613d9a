//! A tree of values with their places: TOML, JSON and (later) USD attributes look alike to the attribute readers, and
//! every error can say where the value stands.

use crate::base::Where;
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
