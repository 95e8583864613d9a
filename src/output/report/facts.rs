//! What a frame's header says, as tables: scene and run, plan, ledgers.

use crate::field::Field;
use eyebox_base::ids::GroupId;
use eyebox_film::frame::{Frame, Meta};
use eyebox_film::witness::Judgement;
use serde_json::{Value, json};

/// A header's value for people; none if it is missing or empty.
fn said(frame: &Frame, key: &str) -> Option<String> {
    let text = match frame.meta.get(key)? {
        Meta::Text(text) => text.clone(),
        Meta::Number(number) => number.to_string(),
        Meta::Integer(integer) => integer.to_string(),
    };
    (!text.is_empty()).then_some(text)
}

/// JSON texts without their quotes.
fn unquoted(text: String) -> String {
    serde_json::from_str::<String>(&text).unwrap_or(text)
}

/// Name and value, in the order of the table.
pub fn facts(frame: &Frame) -> Vec<[String; 2]> {
    let mut rows: Vec<[String; 2]> = Vec::new();
    let mut put = |name: &str, value: Option<String>| rows.extend(value.map(|value| [name.to_owned(), value]));
    put("scene", said(frame, "scene"));
    put("hash of the scene", said(frame, "sceneHash"));
    put("hash of the plan", said(frame, "planHash"));
    put("written by eyebox", said(frame, "version"));
    put("seed", said(frame, "seed"));
    put("passes", said(frame, "passes"));
    put("stopped by", said(frame, "stop").map(unquoted));
    for name in estimators(frame, "paths.") {
        put(&format!("paths, {name}"), said(frame, &format!("paths.{name}")));
    }
    put("pixels", Some(format!("{} × {}", frame.width, frame.height)));
    let field = Field::of(frame).map(|field| field.extent_deg());
    put("field of view", field.map(|[width, height]| format!("{width:.3}° × {height:.3}°")));
    let pupil = frame.number("pupilDiameter_m").map(|metres| format!("{} mm", round(1e3 * metres)));
    put("pupil", pupil);
    put("colour space", Some(eyebox_film::colours::Colours::of(frame).name(frame)));
    put("wavelengths", said(frame, "wavelengths").map(wavelengths));
    put("contrast of the slide", frame.number("contrast").map(round));
    put("light groups", list(frame, "groups").map(|groups| groups.join(", ")));
    for line in said(frame, "diffractionReadable").unwrap_or_default().lines() {
        put("sharpness", Some(line.to_owned()));
    }
    put("mixed", said(frame, "mix"));
    rows
}

/// `{"mono":{"nm":550.0}}` is 550 nm; a name is a name.
fn wavelengths(text: String) -> String {
    let record = serde_json::from_str::<Value>(&text).ok();
    let single = record.as_ref().and_then(|value| value.pointer("/mono/nm")).and_then(Value::as_f64);
    single.map_or_else(|| unquoted(text), |nm| format!("{} nm", round(nm)))
}

pub(super) fn round(value: f64) -> String {
    format!("{value:.6}").trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A list of names in the header.
fn list(frame: &Frame, key: &str) -> Option<Vec<String>> {
    serde_json::from_str(frame.text(key)?).ok()
}

/// What follows a prefix in the keys of the header.
fn estimators<'f>(frame: &'f Frame, prefix: &str) -> Vec<&'f str> {
    frame.meta.keys().filter_map(|key| key.strip_prefix(prefix)).collect()
}

/// Decision and reason, line by line of the readable plan.
pub fn plan(frame: &Frame) -> Vec<[String; 2]> {
    let text = said(frame, "planReadable").unwrap_or_default();
    text.lines()
        .map(|line| match line.split_once(" because ") {
            Some((decision, because)) => [decision.to_owned(), because.to_owned()],
            None => [line.to_owned(), String::new()],
        })
        .collect()
}

/// What a witness said of each kind of light: name, run over witness, its standard error, what is off; and a note.
pub fn witness(frame: &Frame) -> Value {
    let judgement =
        frame.text("witness").and_then(|text| serde_json::from_str::<Option<Judgement>>(text).ok()).flatten();
    let groups = list(frame, "groups").unwrap_or_default();
    let name = |group: GroupId| groups.get(group.index()).cloned().unwrap_or_default();
    let Some(judgement) = judgement else {
        let note = said(frame, "witnessReadable").unwrap_or_else(|| "The header holds no witness.".to_owned());
        return json!({ "rows": [], "note": note });
    };
    let rows: Vec<Value> = judgement
        .judged
        .iter()
        .map(|own| {
            let [ratio, error] = own.ratio.map_or([None; 2], |[ratio, error]| [Some(ratio), Some(error)]);
            json!({
                "name": own.name(&name(own.group)), "ratio": ratio, "error": error, "looks": own.looks,
                "off": own.off.as_ref().map_or("no".to_owned(), |off| off.text(own.from_lamps)),
            })
        })
        .collect();
    let share = 100.0 * judgement.share;
    let unwatched = judgement.lines(&name).split_off(rows.len()).join("; ");
    json!({ "rows": rows, "note": format!("Naive paths beside the run, with {share:.1} % of its work. {unwatched}") })
}

/// Fates of light in a ledger, in their order, and what they are called.
const FATES: [(&str, &str); 7] = [
    ("arrived", "arrived in the pupil"),
    ("escaped", "left the scene"),
    ("absorbed", "absorbed by parts"),
    ("roulette_lost", "ended by chance"),
    ("not_owned", "light of another estimator"),
    ("wrong_side", "refused by bent normals of a mesh"),
    ("cut", "cut after too many events"),
];

/// One ledger per estimator. Light traced from the lamps is in lm: the header's sums over all passes, per pass.
pub fn ledgers(frame: &Frame) -> Vec<Value> {
    estimators(frame, "ledger.").into_iter().filter_map(|name| ledger(frame, name)).collect()
}

fn ledger(frame: &Frame, estimator: &str) -> Option<Value> {
    let record: Value = serde_json::from_str(frame.text(&format!("ledger.{estimator}"))?).ok()?;
    let from_lamps = matches!(estimator, "forward" | "photon");
    let passes = frame.integer(&format!("passes.{estimator}")).or_else(|| frame.integer("passes")).unwrap_or(0).max(1);
    let scale = if from_lamps { 1.0 / passes as f64 } else { 1.0 };
    let number = |key: &str| record.get(key).and_then(Value::as_f64).unwrap_or(0.0) * scale;
    let absorbed: Vec<f64> = record
        .get("absorbed")
        .and_then(Value::as_array)
        .map(|parts| parts.iter().map(|part| part.as_f64().unwrap_or(0.0) * scale).collect())
        .unwrap_or_default();
    let emitted = number("emitted");
    let row = |name: &str, amount: f64| {
        let share = (emitted > 0.0).then(|| amount / emitted);
        json!({ "name": name, "amount": amount, "share": share })
    };
    let of = |key: &str| if key == "absorbed" { absorbed.iter().sum() } else { number(key) };
    let gained = number("roulette_gained");
    let balance = emitted + gained - FATES.iter().map(|(key, _)| of(key)).sum::<f64>();
    let mut rows = vec![row("emitted", emitted)];
    // A fate that nothing met is not listed, but arriving and escaping are said always.
    let listed = FATES.iter().filter(|(key, _)| of(key) != 0.0 || ["arrived", "escaped"].contains(key));
    rows.extend(listed.map(|(key, name)| row(name, of(key))));
    if gained != 0.0 {
        rows.push(row("added by chance to survivors", gained));
    }
    rows.push(row("balance: emitted and added, less all the rest", balance));
    let sigma = record.get("imbalance2").and_then(Value::as_f64).map_or(0.0, |square| square.sqrt() * scale);
    rows.push(row("one-sigma error that the balance should have, rounding aside", sigma));
    let names = list(frame, "parts").unwrap_or_default();
    let mut parts: Vec<(String, f64)> = absorbed
        .iter()
        .enumerate()
        .filter(|(_, amount)| **amount != 0.0)
        .map(|(index, amount)| (names.get(index).cloned().unwrap_or_else(|| format!("part {index}")), *amount))
        .collect();
    parts.sort_by(|(_, a), (_, b)| b.total_cmp(a));
    let (unit, note) = match estimator {
        "forward" | "photon" => ("lm", "From the lamps, mean of all passes."),
        "manifold" => ("importance", "Connections found, and what they brought; they lose nothing by chance."),
        _ => ("importance", "From the eye: importance instead of lumens, over all passes."),
    };
    let paths = record.get("paths").and_then(Value::as_u64).unwrap_or(0);
    let odd = |key: &str, what: &str| {
        record.get(key).and_then(Value::as_u64).filter(|count| *count > 0).map(|count| format!(" {count} {what}."))
    };
    let odd =
        [odd("invalid_paths", "paths turned NaN or infinite"), odd("mismatches", "hits met a crack or an open solid")];
    Some(json!({
        "estimator": estimator,
        "unit": unit,
        "note": format!("{note} {paths} paths.{}", odd.into_iter().flatten().collect::<String>()),
        "rows": rows,
        "parts": parts.iter().map(|(name, amount)| row(name, *amount)).collect::<Vec<_>>(),
    }))
}
