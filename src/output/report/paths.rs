//! The table of light paths: from the header, or else the shares of the light groups.

use super::Shares;
use eyebox_film::frame::Frame;
use serde_json::{Value, json};

/// Rows, what stands above them, and the unit of their amounts.
pub struct PathTable {
    pub rows: Vec<Value>,
    pub note: &'static str,
    pub unit: &'static str,
}

/// The path table of a frame. `means`: each share's mean luminance, cd/m².
pub fn table(frame: &Frame, shares: &Shares<'_>) -> PathTable {
    let listed = frame.text("paths").and_then(|json| serde_json::from_str::<Value>(json).ok());
    // A table, or its rows alone.
    let listed = listed.and_then(|value| match value {
        Value::Array(rows) => Some(rows),
        Value::Object(mut table) => match table.remove("rows") {
            Some(Value::Array(rows)) => Some(rows),
            Some(_) | None => None,
        },
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => None,
    });
    let rows: Vec<Value> = listed.unwrap_or_default().iter().filter_map(|row| from_header(frame, row)).collect();
    if rows.is_empty() {
        return of_shares(shares);
    }
    PathTable {
        rows,
        note: "Ways of light from lamps to the eye, as the header lists them: light into the pupil. A path with a layer of its \
               own can be shown.",
        unit: "lm",
    }
}

fn from_header(frame: &Frame, row: &Value) -> Option<Value> {
    let text = |key: &str| row.get(key).and_then(Value::as_str);
    let name = text("name").or(text("path"))?;
    let words: Vec<&str> = ["group", "kind"].into_iter().filter_map(text).collect();
    let number = |key: &str| row.get(key).and_then(Value::as_f64);
    Some(json!({
        "name": name,
        "share": number("share"),
        "amount": number("flux_lm"),
        "said": words.join(", "),
        "layer": layer_of(frame, name, text("layer")),
    }))
}

/// The layer that holds a path alone: the one that its row names, or the chain of which it is the only path.
fn layer_of(frame: &Frame, path: &str, named: Option<&str>) -> Option<String> {
    let there = |layer: &str| frame.rgb(layer).is_some() && !layer.is_empty();
    let named = named.map(|named| if there(named) { named } else { named.strip_prefix("chain.").unwrap_or(named) });
    let chains = frame.meta.keys().filter_map(|key| key.strip_prefix("chain."));
    let mut holds = chains.filter(|name| frame.text(&format!("chain.{name}")) == Some(path));
    named.filter(|layer| there(layer)).or_else(|| holds.find(|layer| there(layer))).map(str::to_owned)
}

fn of_shares(shares: &Shares<'_>) -> PathTable {
    let all: f64 = shares.means.iter().sum();
    let rows = shares.rendering.iter().flat_map(|rendering| &rendering.shares).zip(&shares.means);
    let mut rows: Vec<(f64, Value)> = rows
        .map(|(share, mean)| {
            let row = json!({
                "name": share.name,
                "share": (all > 0.0).then(|| mean / all),
                "amount": mean,
                "said": format!("light of {} in {}", share.group, share.layer),
                "layer": share.name,
            });
            (*mean, row)
        })
        .collect();
    rows.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    PathTable {
        rows: rows.into_iter().map(|(_, row)| row).collect(),
        note: "This frame was rendered without --chain, so it has no list of light paths. These are the shares of the light groups, by their mean luminance.",
        unit: "mean, cd/m²",
    }
}
