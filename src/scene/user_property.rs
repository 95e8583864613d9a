//! What authors say beside the format: a custom attribute of a USD prim, an entry of glTF's `extras`. It means nothing to light, and is
//! written again.

use serde_json::{Map, Number, Value as Json};

/// A property that no schema declares.
#[derive(Debug, Clone, PartialEq)]
pub struct UserProperty {
    /// Without USD's `userProperties:`.
    pub name: String,
    /// What it is in USD, if it comes from there.
    pub usd: Option<UsdProperty>,
    pub value: UserValue,
}

/// How USD writes a property.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UsdProperty {
    /// `float`, `color3f[]`, …
    pub type_name: &'static str,
    /// Its name has no `userProperties:` before it.
    pub bare: bool,
}

/// Any value of JSON, with whole numbers apart from others.
#[derive(Debug, Clone, PartialEq)]
pub enum UserValue {
    Nothing,
    Bool(bool),
    Integer(i64),
    Number(f64),
    Text(String),
    List(Vec<UserValue>),
    Table(Vec<(String, UserValue)>),
}

impl UserProperty {
    /// What it takes of memory, bytes.
    pub fn cost(&self) -> usize {
        size_of::<Self>() + self.name.len() + self.value.cost()
    }
}

impl UserValue {
    /// What it takes of memory, bytes.
    pub fn cost(&self) -> usize {
        size_of::<Self>()
            + match self {
                UserValue::Nothing | UserValue::Bool(_) | UserValue::Integer(_) | UserValue::Number(_) => 0,
                UserValue::Text(text) => text.len(),
                UserValue::List(items) => items.iter().map(UserValue::cost).sum(),
                UserValue::Table(entries) => entries.iter().map(|(key, item)| key.len() + item.cost()).sum(),
            }
    }

    pub fn of_json(json: &Json) -> Self {
        match json {
            Json::Null => UserValue::Nothing,
            Json::Bool(flag) => UserValue::Bool(*flag),
            Json::Number(number) => match number.as_i64() {
                Some(whole) => UserValue::Integer(whole),
                None => number.as_f64().map_or(UserValue::Nothing, UserValue::Number),
            },
            Json::String(text) => UserValue::Text(text.clone()),
            Json::Array(items) => UserValue::List(items.iter().map(UserValue::of_json).collect()),
            Json::Object(entries) => {
                UserValue::Table(entries.iter().map(|(key, item)| (key.clone(), UserValue::of_json(item))).collect())
            }
        }
    }

    /// JSON has no number that is not finite: it is null there.
    pub fn json(&self) -> Json {
        match self {
            UserValue::Nothing => Json::Null,
            UserValue::Bool(flag) => Json::Bool(*flag),
            UserValue::Integer(whole) => Json::from(*whole),
            UserValue::Number(number) => Number::from_f64(*number).map_or(Json::Null, Json::Number),
            UserValue::Text(text) => Json::String(text.clone()),
            UserValue::List(items) => Json::Array(items.iter().map(UserValue::json).collect()),
            UserValue::Table(entries) => {
                Json::Object(entries.iter().map(|(key, item)| (key.clone(), item.json())).collect::<Map<_, _>>())
            }
        }
    }

    pub fn number(&self) -> Option<f64> {
        match self {
            UserValue::Integer(whole) => Some(*whole as f64),
            UserValue::Number(number) => Some(*number),
            UserValue::Nothing | UserValue::Bool(_) | UserValue::Text(_) | UserValue::List(_) | UserValue::Table(_) => {
                None
            }
        }
    }
}
