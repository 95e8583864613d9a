//! Attributes as JSON. Every number comes back with the same bits; whole ones are written as integers.

use eyebox_base::Error;
use eyebox_base::error::Result;
use eyebox_scene::value::{Data, Value};
use serde_json::{Map, Number, Value as Json};

/// The name of our extension.
pub const OPTICS: &str = "EYEBOX_optics";

/// `value` as JSON. JSON has no infinity: it is the text `"inf"`. Faults: a number that is not one.
pub fn json(value: &Value) -> Result<Json> {
    Ok(match &value.data {
        Data::Bool(flag) => Json::Bool(*flag),
        Data::Number(number) if *number == f64::INFINITY => Json::String("inf".into()),
        Data::Number(number) => match self::number(*number) {
            Some(number) => number,
            None => return Err(Error::new(value.at.clone(), format!("{number} can't be written as JSON"))),
        },
        Data::Text(text) => Json::String(text.clone()),
        Data::List(items) => Json::Array(items.iter().map(json).collect::<Result<_>>()?),
        Data::Table(entries) => {
            let entries = entries.iter().map(|(key, item)| Ok((key.clone(), json(item)?)));
            Json::Object(entries.collect::<Result<Map<_, _>>>()?)
        }
    })
}

/// A finite number; −0 keeps its sign.
pub fn number(number: f64) -> Option<Json> {
    // Up to 2^53 every whole number is exact.
    let whole = number.fract() == 0.0 && number.abs() <= 9_007_199_254_740_992.0 && number.to_bits() != 1 << 63;
    if whole { Some(Json::from(number as i64)) } else { Number::from_f64(number).map(Json::Number) }
}
