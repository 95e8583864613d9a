//! USD properties → attributes.

use super::{Entry, Level, NAMESPACE, UsdProperty, UsdType, UsdValue, entry, keys, layout, unsaid, whole};
use crate::attribute::{self, Form, Noun, Row, kinds};
use crate::value::{Data, Value};
use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Where};
use std::cell::Cell;
use std::collections::BTreeMap;

/// The attributes that `properties` of one prim amount to, all of our namespace; none if there are none. Kinds without
/// parameters are texts, the others tables with `kind`; a medium that has no name is not nested.
///
/// # Errors
/// Unknown properties (with the nearest name), wrong types, parameters of another kind, arrays of different lengths.
/// Ranges are the readers' business.
pub fn gather(properties: &[UsdProperty]) -> Result<Option<Value>> {
    let Some(first) = properties.first() else { return Ok(None) };
    let pool = Pool {
        all: properties
            .iter()
            .map(|property| {
                let name = property.name.strip_prefix(NAMESPACE).unwrap_or(&property.name);
                (name, (property, Cell::new(false)))
            })
            .collect(),
    };
    let table = level(Level::Prim, "", &pool)?;
    pool.settled(&table)?;
    Ok(Some(Value::new(Data::Table(table), first.at.clone())))
}

/// What is there to be taken.
struct Pool<'a> {
    all: BTreeMap<&'a str, (&'a UsdProperty, Cell<bool>)>,
}

impl<'a> Pool<'a> {
    fn take(&self, name: &str) -> Option<&'a UsdProperty> {
        let (property, taken) = self.all.get(name)?;
        taken.set(true);
        Some(property)
    }

    /// Error: something was left.
    fn settled(&self, table: &[(String, Value)]) -> Result<()> {
        let Some((name, (property, _))) = self.all.iter().find(|(_, (_, taken))| !taken.get()) else { return Ok(()) };
        let known = layout::known();
        let bare = layout::bare(name);
        let at = property.at.clone();
        if known.iter().any(|own| own == bare) {
            let head = bare.split(':').next().unwrap_or(bare);
            let beside = table.iter().find(|(key, _)| key == head).map(|(_, value)| format!("{head} = {value}"));
            return Err(Error::new(at, format!("`{}` means nothing here", property.name)).expected(match beside {
                Some(beside) => format!("a parameter of {beside}"),
                None => format!("`{NAMESPACE}{head}` beside it, of a kind that takes it"),
            }));
        }
        let prefix = name.strip_suffix(bare).unwrap_or("");
        let nearest = eyebox_base::error::nearest_name(bare, known.iter().map(String::as_str));
        let mut fault = Error::new(at, format!("unknown property `{}`", property.name)).code(Code::AttributeUnknown);
        fault.nearest = nearest.map(|name| format!("{NAMESPACE}{prefix}{name}"));
        Err(fault)
    }

    /// The names of the instances of `face:`, as people count: f2 before f10.
    fn faces(&self) -> Vec<&'a str> {
        let mut names: Vec<&str> =
            self.all.keys().filter_map(|name| Some(name.strip_prefix("face:")?.split_once(':')?.0)).collect();
        names.sort_by_key(|name| (name.len(), *name));
        names.dedup();
        names
    }
}

fn level(level: Level, prefix: &str, pool: &Pool) -> Result<Vec<(String, Value)>> {
    let mut table: Vec<(String, Value)> = Vec::new();
    // A medium with a name is a thing; the rows of one without stand bare.
    let named = pool.all.contains_key(format!("{prefix}medium:name").as_str());
    for key in keys(level) {
        let Some(entry) = entry(level, key) else { continue };
        let value = match entry {
            Entry::Row(name, row) => match (row.form, row.noun, named) {
                (Form::Thing(_), Noun::Medium, false) => text(&format!("{prefix}{name}"), pool)?,
                (_, Noun::Medium, true) if key != "medium" => None,
                _ => pull(row, &format!("{prefix}{name}"), pool)?,
            },
            Entry::Noun(noun) => record(noun, &whole(noun), &format!("{prefix}{noun}"), pool)?,
            Entry::Default => {
                let inner = self::level(Level::Default, "default:", pool)?;
                inner.first().map(|(_, first)| first.at.clone()).map(|at| Value::new(Data::Table(inner), at))
            }
            Entry::Faces => {
                let mut all = Vec::new();
                for face in pool.faces() {
                    let inner = self::level(Level::Faces, &format!("face:{face}:"), pool)?;
                    if let Some(at) = inner.first().map(|(_, first)| first.at.clone()) {
                        all.push(Value::new(Data::Table(inner), at));
                    }
                }
                all.first().map(|first| first.at.clone()).map(|at| Value::new(Data::List(all), at))
            }
            Entry::Numbers => match pool.take(&format!("{prefix}{key}")) {
                Some(UsdProperty { value: UsdValue::Ints(numbers), at, .. }) => {
                    Some(list(numbers.iter().map(|n| f64::from(*n)), at))
                }
                Some(other) => return Err(wrong(other, UsdType::Ints)),
                None => None,
            },
            Entry::Direction => text(&format!("{prefix}{key}"), pool)?,
        };
        if let Some(value) = value {
            table.push((key.to_owned(), value));
        }
    }
    Ok(table)
}

/// The value of `row` from the property `name` and those below it.
fn pull(row: &Row, name: &str, pool: &Pool) -> Result<Option<Value>> {
    match row.form {
        Form::Record(fields) => return record(row.noun, fields, name, pool),
        Form::Records(fields) => return records(row, fields, name, pool),
        Form::Kind => return kind(row, name, pool),
        Form::Thing(fields) => {
            let (reference, table) = (text(name, pool)?, record(row.noun, fields, name, pool)?);
            return match (reference, table) {
                (Some(reference), Some(table)) => {
                    let what = format!("`{NAMESPACE}{name}` is {reference} and yet says what it is");
                    Err(Error::new(table.at, what).expected("one of them"))
                }
                (reference, table) => Ok(reference.or(table)),
            };
        }
        Form::NumberOrRows(_) => {
            let below = format!("{name}:table");
            if let Some(table) = pool.take(&below) {
                if pool.all.contains_key(name) {
                    return Err(Error::new(
                        table.at.clone(),
                        format!("both `{NAMESPACE}{name}` and `{NAMESPACE}{below}`"),
                    )
                    .expected("one of them"));
                }
                return single(table, UsdType::Double2s).map(Some);
            }
        }
        Form::Number
        | Form::Integer
        | Form::Text
        | Form::File
        | Form::Length
        | Form::LengthOr(_)
        | Form::Word(_)
        | Form::Numbers(_)
        | Form::Integers(_)
        | Form::Place
        | Form::Coefficients { .. }
        | Form::Rows(_) => {}
    }
    pool.take(name).map(|property| single(property, layout::of(row.form))).transpose()
}

/// A property of type `want` as a value. Ints pass as doubles, tokens as asset paths.
fn single(property: &UsdProperty, want: UsdType) -> Result<Value> {
    let at = &property.at;
    Ok(match (want, &property.value) {
        (UsdType::Double, UsdValue::Double(number)) => Value::new(Data::Number(*number), at.clone()),
        (UsdType::Double | UsdType::Int, UsdValue::Int(number)) => {
            Value::new(Data::Number(f64::from(*number)), at.clone())
        }
        (UsdType::Double2, UsdValue::Double2(numbers)) => list(*numbers, at),
        (UsdType::Double3, UsdValue::Double3(numbers)) => list(*numbers, at),
        (UsdType::Doubles, UsdValue::Doubles(numbers)) => list(numbers.iter().copied(), at),
        (UsdType::Double2s, UsdValue::Double2s(rows)) => lines(rows, at),
        (UsdType::Double3s, UsdValue::Double3s(rows)) => lines(rows, at),
        (UsdType::Int2, UsdValue::Int2(numbers)) => list(numbers.map(f64::from), at),
        (UsdType::Ints, UsdValue::Ints(numbers)) => list(numbers.iter().map(|n| f64::from(*n)), at),
        (UsdType::Token, UsdValue::Token(text)) => Value::new(Data::Text(text.clone()), at.clone()),
        (UsdType::Asset, UsdValue::Asset(text) | UsdValue::Token(text)) => {
            Value::new(Data::Text(text.clone()), at.clone())
        }
        (UsdType::Tokens, UsdValue::Tokens(texts)) => {
            let texts = texts.iter().map(|text| Value::new(Data::Text(text.clone()), at.clone()));
            Value::new(Data::List(texts.collect()), at.clone())
        }
        (want, _) => return Err(wrong(property, want)),
    })
}

fn text(name: &str, pool: &Pool) -> Result<Option<Value>> {
    pool.take(name).map(|property| single(property, UsdType::Token)).transpose()
}

fn kind(row: &Row, name: &str, pool: &Pool) -> Result<Option<Value>> {
    let Some(tag) = text(name, pool)? else { return Ok(None) };
    let Some(kind) = kinds(row.name).find(|kind| tag.text() == Some(kind.name)) else { return Ok(Some(tag)) };
    let Some(Value { data: Data::Table(mut table), .. }) = record(row.noun, kind.parameters, name, pool)? else {
        return Ok(Some(tag));
    };
    let at = tag.at.clone();
    table.insert(0, ("kind".to_owned(), tag));
    Ok(Some(Value::new(Data::Table(table), at)))
}

fn record(noun: Noun, fields: &[&str], name: &str, pool: &Pool) -> Result<Option<Value>> {
    let mut table = Vec::new();
    for field in fields {
        let Some(row) = attribute::row(noun, field) else { continue };
        if let Some(value) = pull(row, &format!("{name}:{field}"), pool)? {
            table.push(((*field).to_owned(), value));
        }
    }
    Ok(table.first().map(|(_, first)| first.at.clone()).map(|at| Value::new(Data::Table(table), at)))
}

/// Parallel arrays as a list of tables.
fn records(row: &Row, fields: &[&str], name: &str, pool: &Pool) -> Result<Option<Value>> {
    type Tables = Vec<Vec<(String, Value)>>;
    let mut tables: Option<(&UsdProperty, Tables)> = None;
    for field in fields {
        let Some(property) = pool.take(&format!("{name}:{field}")) else { continue };
        let at = &property.at;
        let own = attribute::row(row.noun, field);
        let cells: Vec<Option<Data>> = match (own.filter(|own| own.form == Form::Number), &property.value) {
            (Some(own), UsdValue::Doubles(numbers)) => {
                numbers.iter().map(|n| (*n != unsaid(own)).then_some(Data::Number(*n))).collect()
            }
            (Some(_), _) => return Err(wrong(property, UsdType::Doubles)),
            (_, UsdValue::Tokens(texts)) => {
                texts.iter().map(|text| (!text.is_empty()).then(|| Data::Text(text.clone()))).collect()
            }
            (_, _) => return Err(wrong(property, UsdType::Tokens)),
        };
        let (first, tables) = tables.get_or_insert_with(|| (property, vec![Vec::new(); cells.len()]));
        if tables.len() != cells.len() {
            let what =
                format!("`{}` has {} entries and `{}` has {}", first.name, tables.len(), property.name, cells.len());
            return Err(Error::new(at.clone(), what).expected("arrays of one length, an entry for each"));
        }
        for (table, cell) in tables.iter_mut().zip(cells) {
            table.extend(cell.map(|data| ((*field).to_owned(), Value::new(data, at.clone()))));
        }
    }
    let Some((first, tables)) = tables else { return Ok(None) };
    let tables = tables.into_iter().map(|table| Value::new(Data::Table(table), first.at.clone()));
    Ok(Some(Value::new(Data::List(tables.collect()), first.at.clone())))
}

fn list(numbers: impl IntoIterator<Item = f64>, at: &Where) -> Value {
    let items = numbers.into_iter().map(|number| Value::new(Data::Number(number), at.clone()));
    Value::new(Data::List(items.collect()), at.clone())
}

fn lines<const N: usize>(rows: &[[f64; N]], at: &Where) -> Value {
    Value::new(Data::List(rows.iter().map(|row| list(*row, at)).collect()), at.clone())
}

fn wrong(property: &UsdProperty, want: UsdType) -> Box<Error> {
    let what = format!("`{}` is of type {}", property.name, property.value.ty().name());
    Error::new(property.at.clone(), what).expected(want.name())
}
