//! Attributes → USD properties.

use super::{Entry, Level, NAMESPACE, UsdProperty, UsdValue, entry, keys, unsaid, whole};
use crate::attribute::{self, Form, Noun, Row, union};
use crate::value::{Data, Value};
use eyebox_base::error::Result;
use eyebox_base::{Code, Error};

/// The USD properties of a table of attributes: of a node, a material, a face, or of the asset's root (with `version`,
/// `unit`, `wavelengths`, `sky`, `eye`, `default`). The asset's lists (`media`, `coatings`, …) have no place in USD.
///
/// # Errors
/// What the table doesn't know, values of the wrong form, references by index. Ranges are the readers' business.
pub fn flatten(attributes: &Value) -> Result<Vec<UsdProperty>> {
    let mut out = Vec::new();
    level(Level::Prim, "", attributes, &mut out)?;
    Ok(out)
}

fn level(level: Level, prefix: &str, table: &Value, out: &mut Vec<UsdProperty>) -> Result<()> {
    for (key, value) in entries(table, "attributes")? {
        let Some(entry) = entry(level, key) else {
            return Err(Error::new(value.at.clone(), format!("unknown attribute `{key}`"))
                .expected(format!("one of {}", keys(level).join(", ")))
                .nearest(key, keys(level))
                .code(Code::AttributeUnknown));
        };
        match entry {
            Entry::Row(name, row) => put(row, &format!("{prefix}{name}"), value, out)?,
            Entry::Noun(noun) => record(noun, &whole(noun), &format!("{prefix}{noun}"), value, out)?,
            Entry::Default => self::level(Level::Default, "default:", value, out)?,
            Entry::Faces => {
                for (index, item) in list(value, "faces")?.iter().enumerate() {
                    self::level(Level::Faces, &format!("face:f{index}:"), item, out)?;
                }
            }
            Entry::Numbers => {
                let numbers = list(value, key)?.iter().map(|item| integer(item, key)).collect::<Result<_>>()?;
                push(out, &format!("{prefix}{key}"), UsdValue::Ints(numbers), value);
            }
            Entry::Direction => {
                let text = text(value, key)?.to_owned();
                push(out, &format!("{prefix}{key}"), UsdValue::Token(text), value);
            }
        }
    }
    Ok(())
}

fn push(out: &mut Vec<UsdProperty>, name: &str, value: UsdValue, from: &Value) {
    out.push(UsdProperty { name: format!("{NAMESPACE}{name}"), value, at: from.at.clone() });
}

/// A value of `row` as the property `name` and those below it.
fn put(row: &Row, name: &str, value: &Value, out: &mut Vec<UsdProperty>) -> Result<()> {
    let one = match row.form {
        Form::Number => UsdValue::Double(number(value, row.name)?),
        Form::Integer => UsdValue::Int(integer(value, row.name)?),
        Form::Text | Form::Word(_) => UsdValue::Token(text(value, row.name)?.to_owned()),
        Form::File => UsdValue::Asset(text(value, row.name)?.to_owned()),
        Form::Length | Form::LengthOr(_) => UsdValue::Token(length(value, row.name)?),
        Form::Numbers(2) => UsdValue::Double2(numbers(value, row)?),
        Form::Numbers(3) => UsdValue::Double3(numbers(value, row)?),
        Form::Numbers(_) | Form::Coefficients { .. } => {
            UsdValue::Doubles(list(value, row.name)?.iter().map(|item| number(item, row.name)).collect::<Result<_>>()?)
        }
        Form::Integers(2) => match list(value, row.name)? {
            [a, b] => UsdValue::Int2([integer(a, row.name)?, integer(b, row.name)?]),
            _ => return Err(wrong(value, row)),
        },
        Form::Integers(_) => {
            UsdValue::Ints(list(value, row.name)?.iter().map(|item| integer(item, row.name)).collect::<Result<_>>()?)
        }
        Form::Place => {
            UsdValue::Tokens(list(value, row.name)?.iter().map(|item| length(item, row.name)).collect::<Result<_>>()?)
        }
        Form::Rows(columns) => lines(row, columns.len(), value)?,
        Form::NumberOrRows(columns) => {
            if value.list().is_some() {
                push(out, &format!("{name}:table"), lines(row, columns.len(), value)?, value);
                return Ok(());
            }
            UsdValue::Double(number(value, row.name)?)
        }
        Form::Record(fields) => return record(row.noun, fields, name, value, out),
        Form::Records(fields) => return columns(row, fields, name, value, out),
        Form::Thing(fields) => match &value.data {
            Data::Text(reference) => UsdValue::Token(reference.clone()),
            Data::Number(_) => return Err(index(value, row.name)),
            Data::Bool(_) | Data::List(_) | Data::Table(_) => return record(row.noun, fields, name, value, out),
        },
        Form::Kind => return kind(row, name, value, out),
    };
    push(out, name, one, value);
    Ok(())
}

fn kind(row: &Row, name: &str, value: &Value, out: &mut Vec<UsdProperty>) -> Result<()> {
    if let (true, Data::Number(_)) = (attribute::named(row.noun), &value.data) {
        return Err(index(value, row.name));
    }
    let read = union::split(row.name, value)?;
    let Some(kind) = read.kind else {
        if let (true, Data::Text(reference)) = (attribute::named(row.noun), &value.data) {
            push(out, name, UsdValue::Token(reference.clone()), value);
            return Ok(());
        }
        return Err(union::unknown(row.name, read.name, read.at));
    };
    push(out, name, UsdValue::Token(kind.name.to_owned()), value);
    for (key, parameter) in read.parameters {
        put(field(row.noun, kind.parameters, key, parameter)?, &format!("{name}:{key}"), parameter, out)?;
    }
    Ok(())
}

fn record(noun: Noun, fields: &[&str], name: &str, value: &Value, out: &mut Vec<UsdProperty>) -> Result<()> {
    for (key, item) in entries(value, name)? {
        put(field(noun, fields, key, item)?, &format!("{name}:{key}"), item, out)?;
    }
    Ok(())
}

/// A list of tables as parallel arrays.
fn columns(row: &Row, fields: &[&str], name: &str, value: &Value, out: &mut Vec<UsdProperty>) -> Result<()> {
    let items = list(value, row.name)?;
    for item in items {
        for (key, value) in entries(item, row.name)? {
            field(row.noun, fields, key, value)?;
        }
    }
    for key in fields {
        if !items.iter().any(|item| item.get(key).is_some()) {
            continue;
        }
        let cells = items.iter().map(|item| item.get(key));
        let own = field(row.noun, fields, key, value)?;
        let column = match own.form {
            Form::Number => UsdValue::Doubles(
                cells.map(|cell| cell.map_or(Ok(unsaid(own)), |value| number(value, key))).collect::<Result<_>>()?,
            ),
            Form::Integer
            | Form::Text
            | Form::File
            | Form::Length
            | Form::LengthOr(_)
            | Form::Word(_)
            | Form::Numbers(_)
            | Form::Integers(_)
            | Form::Place
            | Form::Coefficients { .. }
            | Form::Rows(_)
            | Form::NumberOrRows(_)
            | Form::Record(_)
            | Form::Records(_)
            | Form::Thing(_)
            | Form::Kind => UsdValue::Tokens(
                cells
                    .map(|cell| cell.map_or(Ok(String::new()), |value| text(value, key).map(str::to_owned)))
                    .collect::<Result<_>>()?,
            ),
        };
        push(out, &format!("{name}:{key}"), column, value);
    }
    Ok(())
}

fn lines(row: &Row, columns: usize, value: &Value) -> Result<UsdValue> {
    let items = list(value, row.name)?.iter();
    Ok(if columns == 2 {
        UsdValue::Double2s(items.map(|item| numbers(item, row)).collect::<Result<_>>()?)
    } else {
        UsdValue::Double3s(items.map(|item| numbers(item, row)).collect::<Result<_>>()?)
    })
}

fn field(noun: Noun, fields: &[&str], key: &str, value: &Value) -> Result<&'static Row> {
    attribute::row(noun, key).filter(|_| fields.contains(&key)).ok_or_else(|| {
        Error::new(value.at.clone(), format!("unknown attribute `{key}` of {noun}"))
            .expected(format!("one of {}", fields.join(", ")))
            .nearest(key, fields.iter().copied())
            .code(Code::AttributeUnknown)
    })
}

fn numbers<const N: usize>(value: &Value, row: &Row) -> Result<[f64; N]> {
    let items = list(value, row.name)?;
    let all: Vec<f64> = items.iter().map(|item| number(item, row.name)).collect::<Result<_>>()?;
    all.try_into().map_err(|_| wrong(value, row))
}

fn wrong(value: &Value, row: &Row) -> Box<Error> {
    Error::new(value.at.clone(), format!("`{}` is {} ({value})", row.name, value.kind())).expected(row.expected())
}

fn index(value: &Value, name: &str) -> Box<Error> {
    Error::new(value.at.clone(), format!("{name} {value} is an index, and USD has no list of {name}s"))
        .expected("what it refers to, or a name")
}

fn not(value: &Value, name: &str, expected: &str) -> Box<Error> {
    Error::new(value.at.clone(), format!("`{name}` is {} ({value})", value.kind())).expected(expected)
}

fn entries<'a>(value: &'a Value, name: &str) -> Result<&'a [(String, Value)]> {
    value.table().ok_or_else(|| not(value, name, "a table"))
}

fn list<'a>(value: &'a Value, name: &str) -> Result<&'a [Value]> {
    value.list().ok_or_else(|| not(value, name, "a list"))
}

fn text<'a>(value: &'a Value, name: &str) -> Result<&'a str> {
    value.text().ok_or_else(|| not(value, name, "a text"))
}

fn number(value: &Value, name: &str) -> Result<f64> {
    match value.text() {
        Some("inf" | "infinity") => Ok(f64::INFINITY),
        _ => value.number().ok_or_else(|| not(value, name, "a number")),
    }
}

fn integer(value: &Value, name: &str) -> Result<i32> {
    let number = value.number().ok_or_else(|| not(value, name, "a whole number"))?;
    let whole = number as i32;
    if f64::from(whole) == number { Ok(whole) } else { Err(not(value, name, "a whole number below 2^31")) }
}

/// A length as text; 0 and infinity may stand without a unit.
fn length(value: &Value, name: &str) -> Result<String> {
    match &value.data {
        Data::Text(text) => Ok(text.clone()),
        Data::Number(number) if *number == 0.0 => Ok("0 mm".to_owned()),
        Data::Number(number) if *number == f64::INFINITY => Ok("inf".to_owned()),
        Data::Number(_) | Data::Bool(_) | Data::List(_) | Data::Table(_) => {
            Err(not(value, name, "a length with its unit, e.g. \"4 mm\""))
        }
    }
}
