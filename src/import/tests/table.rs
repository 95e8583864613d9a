//! The attribute table against the readers: what the table says is read, what it doesn't say is refused, and a value is
//! read the same after it went through JSON or through USD.

use crate::{json, optics};
use eyebox_base::Where;
use eyebox_base::error::Result;
use eyebox_scene::attribute::arbitrary::{every, named_rows, of, some};
use eyebox_scene::attribute::usd::{flatten, gather};
use eyebox_scene::attribute::{self, EMITTER, Kind, Noun, SLIDE, Support, kinds, own_rows, row, rows};
use eyebox_scene::value::{Data, Value};
use proptest::prelude::*;
use std::path::Path;

fn value(data: Data) -> Value {
    Value::new(data, Where::Nowhere)
}
fn text(text: &str) -> Value {
    value(Data::Text(text.to_owned()))
}
fn list(numbers: &[f64]) -> Value {
    value(Data::List(numbers.iter().map(|x| value(Data::Number(*x))).collect()))
}
fn table_rows(rows: &[[f64; 2]]) -> Value {
    value(Data::List(rows.iter().map(|row| list(row)).collect()))
}
fn table(entries: Vec<(String, Value)>) -> Value {
    value(Data::Table(entries))
}

/// The same value without places.
fn placeless(from: &Value) -> Value {
    value(match &from.data {
        Data::List(items) => Data::List(items.iter().map(placeless).collect()),
        Data::Table(entries) => {
            Data::Table(entries.iter().map(|(key, value)| (key.clone(), placeless(value))).collect())
        }
        Data::Bool(_) | Data::Number(_) | Data::Text(_) => from.data.clone(),
    })
}

/// What the reader of `key` makes of a value, as text; every bit of every number shows.
fn read(key: &str, value: &Value) -> Result<String> {
    let notes = &mut Vec::new();
    Ok(match key {
        "finish" => format!("{:?}", optics::finish(value, notes)?),
        "coating" => format!("{:?}", optics::coating(value, "x", notes)?),
        "shape" => format!("{:?}", optics::shape(value, notes)?),
        "emitter" => format!("{:?}", optics::emitter(value, notes)?),
        "slide" => format!("{:?}", optics::slide(value, notes)?),
        "sensor" => format!("{:?}", optics::sensor(value)?),
        "sky" => format!("{:?}", optics::sky(value, notes)?),
        "sun" => format!("{:?}", optics::sun(value, notes)?),
        "eye" => format!("{:?}", optics::eye(value, optics::Lens::default(), notes)?),
        "wavelengths" => format!("{:?}", optics::wavelengths(Some(value), notes)?),
        "unit" => format!("{:?}", optics::unit(value)?),
        "absorption_per_m" => format!("{:?}", optics::absorption(value, 550.0)?),
        "priority" => format!("{:?}", optics::priority(value)?),
        "medium" => format!("{:?}", optics::medium_entries(value)?),
        index => format!("{:?}", optics::index(index, value, 550.0)?),
    })
}

/// Through JSON text and back.
fn through_json(from: &Value) -> Value {
    let text = from.to_json().unwrap().to_string();
    placeless(&json::value(&serde_json::from_str(&text).unwrap(), Path::new("a.gltf"), "").unwrap())
}

/// Through USD properties and back.
fn through_usd(key: &str, from: &Value) -> Value {
    let properties = flatten(&table(vec![(key.to_owned(), from.clone())])).unwrap();
    gather(&properties).unwrap().unwrap().get(key).unwrap().clone()
}

/// Tables with every row that the readers render, those of a noun's own table.
fn whole(noun: Noun, fields: &[&str]) -> BoxedStrategy<Value> {
    every(named_rows(noun, fields).into_iter().filter(|row| row.support != Support::NotYet).collect())
}

fn rendered(noun: Noun, attribute: &str) -> BoxedStrategy<Value> {
    let one = move |kind: &'static Kind| {
        let tag = ("kind".to_owned(), text(kind.name));
        whole(noun, kind.parameters)
            .prop_map(move |v| table([tag.clone()].into_iter().chain(v.table().unwrap().to_vec()).collect()))
            .boxed()
    };
    let all = kinds(attribute).filter(|kind| kind.rendered).map(one);
    proptest::strategy::Union::new(all).boxed()
}

/// Makes what the table allows row by row fit together, where rows have to.
fn mended(key: &str, from: Value, turn: f64, pick: usize) -> Value {
    let Data::Table(mut all) = from.data else { return from };
    let kind = all.iter().find(|(key, _)| key == "kind").and_then(|(_, v)| v.text().map(str::to_owned));
    let mut put =
        |name: &str, value: Value| all.iter_mut().filter(|(own, _)| own == name).for_each(|e| e.1 = value.clone());
    let across = (list(&[turn.cos(), turn.sin(), 0.0]), list(&[-turn.sin(), turn.cos(), 0.0]));
    match key {
        "emitter" => {
            put("group", text("led_1"));
            put("u", across.0);
            put("v", across.1);
            let n = table(vec![("kind".to_owned(), text("cos_n")), ("n".to_owned(), value(Data::Number(turn)))]);
            let gauss = table(vec![(
                "gauss".to_owned(),
                table(vec![("fwhm_deg".to_owned(), value(Data::Number(1.0 + turn)))]),
            )]);
            let web = table(vec![("kind".to_owned(), text("profile")), ("file".to_owned(), text("a.ies"))]);
            put("angular", [text("lambert"), n.clone(), gauss, web, n, text("lambert")][pick % 6].clone());
            // Powers and colours that the table allows may all be 0.
            let hue = |name: &str, numbers: Value| table(vec![(name.to_owned(), numbers)]);
            let rows = table_rows(&[[400.0, 0.0], [500.0 + turn, 1.0]]);
            let spectra = [
                text("led_rgb1"),
                hue("cct", value(Data::Number(1000.0 + 4000.0 * turn))),
                hue("rgb", list(&[turn, 0.0, 1.0])),
                hue("table", rows),
                hue("csv", text("a/led.csv")),
            ];
            put("spectrum", spectra[pick % spectra.len()].clone());
        }
        "sky" => {
            put("group", text("led_1"));
            // A colour is not black, and a group has a name for layers.
            put("rgb", list(&[turn, 0.0, 1.0]));
            let number = |name: &str, x: f64| (name.to_owned(), value(Data::Number(x)));
            let mut sun = vec![number("elevation_deg", 15.0 * turn), number("turbidity", 2.0 + turn)];
            if pick.is_multiple_of(2) {
                sun.extend([number("azimuth_deg", -turn), ("sun_group".to_owned(), text("sun_1"))]);
            }
            put("sun_sky", table(sun));
        }
        "sun" => {
            put("group", text("led_1"));
            put("direction", across.0);
        }
        "slide" => {
            put("u", across.0);
            put("v", across.1);
        }
        "sensor" => put("u", across.0),
        "eye" => {
            put("look", across.0);
            put("up", across.1);
        }
        "finish" => {
            // Three numbers may all be 0, and then they're no direction.
            put("axis", across.0.clone());
            put("direction", across.0);
            put("ordinary_index", value(Data::Number(1.5)));
            put("extraordinary_index", value(Data::Number(1.5 + 0.01 * (1.0 + turn))));
            let retardance = if pick < 3 {
                value(Data::Number(1.0 + turn))
            } else {
                table_rows(&[[400.0, 1.0], [500.0 + turn, 2.0]])
            };
            put("retardance_nm", retardance.clone());
            put("retardance_waves", retardance);
            let order = |m: f64, side: &str| {
                table([("order", m), (side, 0.25)].map(|(k, x)| (k.to_owned(), value(Data::Number(x)))).to_vec())
            };
            // −1 is an order, too.
            let orders = [order(1.0, "T"), order(-1.0, "R"), order(2.0, "T")];
            put("orders", value(Data::List(orders[..1 + pick % 3].to_vec())));
        }
        "shape" => {
            put("axis", across.0);
            put("x", list(&[1.0, turn, 5.0]));
        }
        _ => {}
    }
    match (key, kind.as_deref()) {
        // Shares in the sidecar or in a file.
        ("finish", Some("grating")) => {
            let other = if pick.is_multiple_of(2) { "efficiencies" } else { "orders" };
            all.retain(|(key, _)| key != other)
        }
        // Shares that together are at most 1; a metal or a reflectance.
        ("finish", Some("mirror")) => {
            all.retain(|(key, _)| (key == "reflectance") == pick.is_multiple_of(2) || key == "kind")
        }
        ("finish", Some("reflective_polariser")) => {
            all.retain(|(key, _)| !["transmittance", "transmittance_leak"].contains(&key.as_str()))
        }
        // One retardance.
        ("finish", Some("retarder" | "circular_polariser")) => {
            let other = ["retardance_nm", "retardance_waves"][pick % 2];
            all.retain(|(key, _)| key != other)
        }
        ("finish", _) => all.retain(|(key, _)| key != "transmittance"),
        ("emitter", _) => {
            let strengths = ["flux_lm", "luminance_cd_m2", "intensity_cd", "radiant_flux_w", "primaries_cd_m2"];
            let strength = strengths[pick % strengths.len()];
            all.retain(|(key, _)| !optics::STRENGTHS.contains(&key.as_str()) || key == strength);
            // Primaries say their colour.
            all.retain(|(key, _)| key != "spectrum" || strength != "primaries_cd_m2");
        }
        ("sky", _) => all.retain(|(key, _)| optics::goes_with_sky(attribute::SKIES[pick % 4].0, key)),
        ("coating", Some("ideal")) => all.retain(|(key, _)| key != "T"),
        ("coating", Some("table")) => {
            let line = |nm: f64, side: &str| {
                let number = |name: &str, x: f64| (name.to_owned(), value(Data::Number(x)));
                let mut line =
                    vec![("side".to_owned(), text(side)), number("wavelength_nm", nm), number("angle_deg", turn)];
                line.extend([("R_s", 0.25), ("R_p", 0.125), ("T_s", 0.5), ("T_p", 0.75)].map(|(k, x)| number(k, x)));
                table(line)
            };
            let lines = [line(400.0, "outside"), line(500.0 + turn, "outside"), line(450.0, "inside")];
            let lines = value(Data::List(lines[..2 + pick % 2].to_vec()));
            all.iter_mut().filter(|(own, _)| own == "table").for_each(|entry| entry.1 = lines.clone());
        }
        ("coating", Some("stack")) => {
            for (_, films) in all.iter_mut().filter(|(key, _)| key == "stack") {
                let Data::List(films) = &mut films.data else { continue };
                for (i, film) in films.iter_mut().enumerate() {
                    let Data::Table(film) = &mut film.data else { continue };
                    film.retain(|(key, _)| key != "material" && (key != "n" || (i + pick).is_multiple_of(2)));
                    film.retain(|(key, _)| key != "k" || (i + pick).is_multiple_of(2));
                    let index =
                        if (i + pick).is_multiple_of(2) { ("n", list(&[])) } else { ("material", text("N-BK7")) };
                    if index.0 == "material" || !film.iter().any(|(key, _)| key == "n") {
                        let n = value(Data::Number(1.38));
                        film.push((index.0.to_owned(), if index.0 == "n" { n } else { index.1 }));
                    }
                    if !film.iter().any(|(key, _)| key == "thickness_nm") {
                        film.push(("thickness_nm".to_owned(), value(Data::Number(turn))));
                    }
                }
            }
        }
        _ => {}
    }
    table(all)
}

/// The readers that take a whole attribute, with values that must be read.
fn good(key: &'static str) -> BoxedStrategy<Value> {
    let all = match key {
        "finish" => rendered(Noun::Finish, key),
        "coating" => rendered(Noun::Coating, key),
        "shape" => rendered(Noun::Shape, key),
        "wavelengths" => rendered(Noun::Asset, key),
        "emitter" => whole(Noun::Emitter, &EMITTER),
        "slide" => whole(Noun::Slide, &SLIDE),
        "sensor" => whole(Noun::Sensor, &SENSOR),
        "sky" => every(own_rows(Noun::Sky).collect()),
        "sun" => every(rows(Noun::Sun).collect()),
        _ => every(rows(Noun::Eye).collect()),
    };
    (all, 0.0..6.0, 0..6usize).prop_map(move |(v, turn, pick)| mended(key, v, turn, pick)).boxed()
}

/// Anything that the table allows, sense or not.
fn raw(key: &'static str) -> BoxedStrategy<Value> {
    match key {
        "emitter" => some(named_rows(Noun::Emitter, &EMITTER)),
        "slide" => some(named_rows(Noun::Slide, &SLIDE)),
        "sensor" => some(named_rows(Noun::Sensor, &SENSOR)),
        "sky" => some(own_rows(Noun::Sky).collect()),
        "sun" => some(rows(Noun::Sun).collect()),
        "eye" => some(rows(Noun::Eye).collect()),
        key => {
            let nouns = [Noun::Medium, Noun::Finish, Noun::Coating, Noun::Shape, Noun::Asset];
            of(nouns.into_iter().find_map(|noun| row(noun, key)).unwrap())
        }
    }
}

const WHOLE: [&str; 10] =
    ["finish", "coating", "shape", "wavelengths", "emitter", "slide", "sensor", "sky", "sun", "eye"];
/// The rows of a sensor's table.
const SENSOR: [&str; 2] = ["pixels", "u"];
const SINGLE: [&str; 9] =
    ["ior", "glass", "sellmeier", "cauchy", "abbe", "index_table", "absorption_per_m", "priority", "unit"];

fn any_of(
    keys: Vec<&'static str>,
    values: fn(&'static str) -> BoxedStrategy<Value>,
) -> BoxedStrategy<(&'static str, Value)> {
    proptest::strategy::Union::new(keys.into_iter().map(|key| values(key).prop_map(move |v| (key, v)).boxed())).boxed()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, ..ProptestConfig::default() })]

    #[test]
    fn what_the_table_says_is_read((key, value) in any_of(WHOLE.to_vec(), good)) {
        let direct = read(key, &value).map_err(|fault| TestCaseError::fail(format!("{key} = {value}: {fault}")))?;
        prop_assert_eq!(&direct, &read(key, &through_json(&value)).unwrap());
        prop_assert_eq!(&direct, &read(key, &through_usd(key, &value)).unwrap());
    }

    #[test]
    fn what_the_table_does_not_say_is_refused((key, from) in any_of(WHOLE.to_vec(), good)) {
        let Data::Table(mut all) = from.data else { return Ok(()) };
        all.push(("flux".to_owned(), value(Data::Number(1.0))));
        let fault = read(key, &table(all)).unwrap_err().to_string();
        prop_assert!(fault.contains("unknown attribute `flux`") || fault.contains("takes no `flux`"), "{fault}");
    }

    #[test]
    fn carriers_agree_on_anything((key, value) in any_of([&WHOLE[..], &SINGLE[..]].concat(), raw)) {
        let direct = read(key, &value);
        for (carrier, carried) in [("json", through_json(&value)), ("usd", through_usd(key, &value))] {
            match (&direct, read(key, &carried)) {
                (Ok(a), Ok(b)) => prop_assert_eq!(a, &b, "{} {}", carrier, key),
                (Err(_), Err(_)) => {}
                (a, b) => prop_assert!(false, "{carrier} {key} = {value}: {a:?} {b:?}"),
            }
        }
        // Whatever is wrong with it, the form isn't, and every name is known.
        if let Err(fault) = &direct {
            let text = fault.to_string();
            prop_assert!(!text.contains("unknown attribute") && !text.contains("takes no"), "{text}");
        }
    }

    #[test]
    fn single_rows_are_read((key, value) in any_of(SINGLE.to_vec(), raw)) {
        // What the index is at one wavelength is beyond the table.
        const BEYOND: [&str; 7] =
            ["unknown glass", "impossible index", "does not cover", "do not rise", "is not", "Sellmeier", "index table"];
        if let Err(fault) = read(key, &value) {
            let text = fault.to_string();
            prop_assert!(BEYOND.iter().any(|why| text.contains(why)), "{key} = {value}: {text}");
        }
    }
}

#[test]
fn every_attribute_that_can_be_bound_is_walked() {
    let walked = |key: &str| WHOLE.contains(&key) || SINGLE.contains(&key) || key == "medium";
    for key in crate::bind::BINDABLE {
        assert!(walked(key), "{key}");
    }
    for kind in attribute::KINDS {
        assert!(walked(kind.attribute) || ["angular", "spectrum"].contains(&kind.attribute), "{}", kind.attribute);
    }
}
