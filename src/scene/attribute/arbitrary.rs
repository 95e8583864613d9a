//! Random values drawn from the table, for property tests: each row in every form that it allows, numbers from the whole
//! range with its ends. Values are as [`gather`](super::usd::gather) writes them.

use super::{Form, Kind, Noun, Range, Row, kinds, named, own_rows, row};
use crate::value::{Data, Value};
use eyebox_base::Where;
use proptest::prelude::*;

pub type Values = BoxedStrategy<Value>;

fn value(data: Data) -> Value {
    Value::new(data, Where::Nowhere)
}

fn list(items: Vec<Value>) -> Value {
    value(Data::List(items))
}

/// Numbers that the range allows, its ends and extremes among them.
pub fn number(range: Range) -> BoxedStrategy<f64> {
    let finite = proptest::num::f64::NORMAL | proptest::num::f64::SUBNORMAL | proptest::num::f64::ZERO;
    match range {
        Range::Any => prop_oneof![-1e3..1e3, finite].boxed(),
        Range::AtLeast(min) => prop_oneof![Just(min), min..min + 10.0, Just(f64::MAX)].boxed(),
        Range::AtLeastOrInfinite(min) => prop_oneof![Just(min), min..min + 1e3, Just(f64::INFINITY)].boxed(),
        Range::Positive => prop_oneof![Just(f64::MIN_POSITIVE), 1e-3..1e3, Just(f64::MAX)].boxed(),
        Range::PositiveOrInfinite => prop_oneof![1e-3..1e3, Just(f64::INFINITY)].boxed(),
        Range::NonZero => prop_oneof![1e-3..1e3, -1e3..-1e-3].boxed(),
        Range::Within(low, high) => prop_oneof![Just(low), Just(high), low..high].boxed(),
        Range::Above(low, high) => prop_oneof![Just(high), low.next_up()..high].boxed(),
        Range::Between(low, high) => (low.next_up()..high).boxed(),
    }
}

fn numbers(range: Range, count: impl Into<proptest::collection::SizeRange>) -> Values {
    let item = number(range).prop_map(|x| value(Data::Number(x)));
    proptest::collection::vec(item, count).prop_map(list).boxed()
}

/// Rows whose first column rises.
fn lines(range: Range, columns: usize) -> Values {
    let row = (1.0..50.0, proptest::collection::vec(number(range), columns - 1));
    proptest::collection::vec(row, 1..5)
        .prop_map(|rows| {
            let mut at = 360.0;
            let line = |(step, rest): (f64, Vec<f64>)| {
                at += step;
                list([at].into_iter().chain(rest).map(|x| value(Data::Number(x))).collect())
            };
            list(rows.into_iter().map(line).collect())
        })
        .boxed()
}

fn text(text: impl Into<String>) -> Value {
    value(Data::Text(text.into()))
}

fn name() -> BoxedStrategy<String> {
    "[A-Za-z][A-Za-z0-9_ .µ-]{0,8}".boxed()
}

fn length(range: Range) -> Values {
    let one = move |x: f64, unit: &str| {
        let metres = format!("{x} {unit}");
        text(if x == f64::INFINITY { "inf".to_owned() } else { metres })
    };
    let range = match range {
        // Huge numbers of metres overflow in other units.
        Range::Any => Range::Within(-1e6, 1e6),
        Range::AtLeast(_) | Range::Positive => Range::Within(1e-3, 1e6),
        Range::AtLeastOrInfinite(_)
        | Range::PositiveOrInfinite
        | Range::NonZero
        | Range::Within(..)
        | Range::Above(..)
        | Range::Between(..) => range,
    };
    (number(range), prop::sample::select(vec!["mm", "m", "um", "nm", "cm", "in"]))
        .prop_map(move |(x, u)| one(x, u))
        .boxed()
}

/// A table of some of the rows, at least one.
pub fn some(fields: Vec<&'static Row>) -> Values {
    let each: Vec<BoxedStrategy<Option<(String, Value)>>> = fields
        .iter()
        .map(|row| proptest::option::of(of(row)).prop_map(|v| v.map(|v| (row.name.to_owned(), v))).boxed())
        .collect();
    let first = fields[0];
    (each, of(first))
        .prop_map(|(all, first_value)| {
            let mut all: Vec<_> = all.into_iter().flatten().collect();
            if all.is_empty() {
                all.push((first.name.to_owned(), first_value.clone()));
            }
            value(Data::Table(all))
        })
        .boxed()
}

pub fn named_rows(noun: Noun, fields: &[&str]) -> Vec<&'static Row> {
    fields.iter().filter_map(|name| row(noun, name)).collect()
}

/// All of the rows in a table.
pub fn every(fields: Vec<&'static Row>) -> Values {
    let each: Vec<_> = fields.iter().map(|row| of(row).prop_map(|v| (row.name.to_owned(), v))).collect();
    each.prop_map(|all| value(Data::Table(all))).boxed()
}

/// A kind with some of its parameters; a text if it has none.
pub fn kind(noun: Noun, kind: &'static Kind) -> Values {
    if kind.parameters.is_empty() {
        return Just(text(kind.name)).boxed();
    }
    some(named_rows(noun, kind.parameters))
        .prop_map(|table| {
            let mut all = vec![("kind".to_owned(), text(kind.name))];
            all.extend(table.table().unwrap_or(&[]).iter().cloned());
            value(Data::Table(all))
        })
        .boxed()
}

/// A value of the row.
pub fn of(row: &'static Row) -> Values {
    match row.form {
        Form::Number => number(row.range).prop_map(|x| value(Data::Number(x))).boxed(),
        Form::Integer => any::<i32>().prop_map(|x| value(Data::Number(f64::from(x)))).boxed(),
        Form::Text => name().prop_map(text).boxed(),
        Form::File => "[a-z0-9_]{1,8}(/[a-z]{1,4})?\\.(png|exr)".prop_map(text).boxed(),
        Form::Word(words) => prop::sample::select(words).prop_map(text).boxed(),
        Form::Length => length(row.range),
        Form::LengthOr(words) => {
            let word = prop::sample::select(words).prop_map(text);
            prop_oneof![3 => length(row.range), 1 => word].boxed()
        }
        Form::Numbers(count) => numbers(row.range, count),
        Form::Integers(count) => {
            let range = row.range;
            let fits = (1..65536).prop_filter("out of range", move |x| range.holds(f64::from(*x)));
            let bounded = match range {
                // Rejecting most of them would take for ever.
                Range::Within(low, high) => (low.max(1.0) as i32..=high.min(65535.0) as i32).boxed(),
                Range::Any
                | Range::AtLeast(_)
                | Range::AtLeastOrInfinite(_)
                | Range::Positive
                | Range::PositiveOrInfinite
                | Range::NonZero
                | Range::Above(..)
                | Range::Between(..) => fits.boxed(),
            };
            let item = bounded.prop_map(|x| value(Data::Number(f64::from(x))));
            proptest::collection::vec(item, count).prop_map(list).boxed()
        }
        Form::Place => proptest::collection::vec(length(row.range), 3).prop_map(list).boxed(),
        Form::Coefficients { least, most } => numbers(row.range, least..=most.min(40)),
        Form::Rows(columns) => lines(row.range, columns.len()),
        Form::NumberOrRows(columns) => {
            prop_oneof![number(row.range).prop_map(|x| value(Data::Number(x))), lines(row.range, columns.len())].boxed()
        }
        Form::Record(fields) => every(named_rows(row.noun, fields)),
        Form::Records(fields) => {
            proptest::collection::vec(some(named_rows(row.noun, fields)), 1..4).prop_map(list).boxed()
        }
        Form::Thing(fields) => {
            // A medium without a name stands bare.
            let table = some(named_rows(row.noun, fields)).prop_map(|table| match table.data {
                Data::Table(mut all) if !all.iter().any(|(key, _)| key == "name") => {
                    all.insert(0, ("name".to_owned(), text("a thing")));
                    value(Data::Table(all))
                }
                data => value(data),
            });
            prop_oneof![name().prop_map(text), table].boxed()
        }
        Form::Kind => {
            let mut all: Vec<Values> = kinds(row.name).map(|own| kind(row.noun, own)).collect();
            if named(row.noun) && row.name == row.noun.to_string() {
                all.push(name().prop_map(text).boxed());
            }
            proptest::strategy::Union::new(all).boxed()
        }
    }
}

/// What a node, a face or a material may say: some of the attributes that can be bound, a medium as rows or as a whole.
pub fn bindable() -> BoxedStrategy<Vec<(String, Value)>> {
    let bare: Vec<&'static Row> =
        super::MEDIUM.iter().filter(|name| **name != "name").filter_map(|name| row(Noun::Medium, name)).collect();
    let medium = prop_oneof![
        some(bare).prop_map(|table| table.table().unwrap_or(&[]).to_vec()),
        row(Noun::Medium, "medium")
            .map_or(Just(value(Data::List(Vec::new()))).boxed(), of)
            .prop_map(|medium| vec![("medium".to_owned(), medium)]),
        Just(Vec::new()),
    ];
    let faces: Vec<&'static Row> = [Noun::Finish, Noun::Coating, Noun::Shape, Noun::Emitter, Noun::Slide, Noun::Sensor]
        .into_iter()
        .filter_map(|noun| row(noun, &noun.to_string()))
        .collect();
    (medium, some(faces))
        .prop_map(|(mut medium, faces)| {
            medium.extend(faces.table().unwrap_or(&[]).iter().cloned());
            medium
        })
        .boxed()
}

/// Everything that a prim may say: what can be bound, for itself, for some faces and by default, and the asset's rows.
pub fn prim() -> Values {
    let entry = |noun: Noun, name: &str| row(noun, name).map_or(Just(text("")).boxed(), of);
    let table = |rows: Vec<(String, Value)>| value(Data::Table(rows));
    let selector = prop_oneof![
        proptest::collection::vec(0..100_000, 1..4).prop_map(|n| (
            "faces".to_owned(),
            list(n.into_iter().map(|n| value(Data::Number(f64::from(n)))).collect())
        )),
        prop::sample::select(vec!["+x", "-x", "+y", "-y", "+z", "-z"]).prop_map(|n| ("normal".to_owned(), text(n))),
    ];
    let face = (selector, bindable()).prop_map(move |(selector, rows)| {
        let rows = rows.into_iter().filter(|(key, _)| row(Noun::Medium, key).is_none());
        table([selector].into_iter().chain(rows).collect())
    });
    let root: Vec<BoxedStrategy<(String, Value)>> = vec![
        entry(Noun::Asset, "unit").prop_map(|v| ("unit".to_owned(), v)).boxed(),
        entry(Noun::Asset, "wavelengths").prop_map(|v| ("wavelengths".to_owned(), v)).boxed(),
        some(own_rows(Noun::Sky).collect()).prop_map(|v| ("sky".to_owned(), v)).boxed(),
        some(own_rows(Noun::Sun).collect()).prop_map(|v| ("sun".to_owned(), v)).boxed(),
        some(own_rows(Noun::Eye).collect()).prop_map(|v| ("eye".to_owned(), v)).boxed(),
        bindable().prop_map(move |rows| ("default".to_owned(), table(rows))).boxed(),
    ];
    let root = proptest::sample::subsequence(root, 0..=6).prop_flat_map(|chosen| chosen);
    (root, bindable(), proptest::collection::vec(face, 0..12))
        .prop_map(move |(mut all, own, faces)| {
            all.extend(own);
            if !faces.is_empty() {
                all.push(("faces".to_owned(), list(faces)));
            }
            table(all)
        })
        .boxed()
}
