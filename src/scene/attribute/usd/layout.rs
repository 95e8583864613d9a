//! Which USD properties the rows have: for schemas, and to name the nearest valid one.

use super::UsdType;
use crate::attribute::{Form, Noun, Row, kinds, own_rows, row};

/// A property that a noun can have.
#[derive(Debug, Clone, PartialEq)]
pub struct Property {
    /// Without the namespace: `medium:ior`.
    pub name: String,
    pub ty: UsdType,
    pub row: &'static Row,
    /// The tokens that are allowed; empty if any is.
    pub tokens: Vec<&'static str>,
    pub doc: String,
}

/// The properties of a noun, without the namespace; `prefix:` stands before those of faces and of `default`.
pub fn properties(noun: Noun) -> Vec<Property> {
    let mut out: Vec<Property> = Vec::new();
    match noun {
        Noun::Medium | Noun::Finish | Noun::Coating | Noun::Shape | Noun::Emitter | Noun::Slide | Noun::Sensor => {
            if let Some(holder) = row(noun, &noun.to_string()) {
                add(holder, holder.name, &mut out);
            }
        }
        Noun::Sky | Noun::Sun | Noun::Eye => {
            own_rows(noun).for_each(|row| add(row, &format!("{noun}:{}", row.name), &mut out))
        }
        Noun::Asset => {
            for row in ["version", "unit", "wavelengths"].iter().filter_map(|name| row(noun, name)) {
                add(row, &format!("asset:{}", row.name), &mut out);
            }
        }
    }
    out
}

/// The type of a property that holds a value of this form; what takes several properties is a token where it starts.
pub(super) fn of(form: Form) -> UsdType {
    match form {
        Form::Number | Form::NumberOrRows(_) => UsdType::Double,
        Form::Integer => UsdType::Int,
        Form::Text | Form::Length | Form::LengthOr(_) => UsdType::Token,
        Form::Word(_) | Form::Kind | Form::Thing(_) => UsdType::Token,
        Form::Record(_) | Form::Records(_) => UsdType::Token,
        Form::File => UsdType::Asset,
        Form::Numbers(2) => UsdType::Double2,
        Form::Numbers(3) => UsdType::Double3,
        Form::Numbers(_) | Form::Coefficients { .. } => UsdType::Doubles,
        Form::Integers(2) => UsdType::Int2,
        Form::Integers(_) => UsdType::Ints,
        Form::Place => UsdType::Tokens,
        Form::Rows(columns) if columns.len() == 2 => UsdType::Double2s,
        Form::Rows(_) => UsdType::Double3s,
    }
}

fn add(row: &'static Row, name: &str, out: &mut Vec<Property>) {
    if out.iter().any(|own| own.name == name) {
        return;
    }
    let below = |fields: &[&str], out: &mut Vec<Property>| {
        for field in fields.iter().filter_map(|field| self::row(row.noun, field)) {
            add(field, &format!("{name}:{}", field.name), out);
        }
    };
    let property =
        |tokens: Vec<&'static str>, doc: String| Property { name: name.to_owned(), ty: of(row.form), row, tokens, doc };
    match row.form {
        Form::Number
        | Form::Integer
        | Form::Text
        | Form::File
        | Form::Length
        | Form::LengthOr(_)
        | Form::Numbers(_)
        | Form::Integers(_)
        | Form::Place
        | Form::Coefficients { .. }
        | Form::Rows(_) => out.push(property(Vec::new(), row.doc.to_owned())),
        Form::Word(words) => out.push(property(words.to_vec(), row.doc.to_owned())),
        Form::NumberOrRows(columns) => {
            out.push(property(Vec::new(), row.doc.to_owned()));
            let mut table = property(Vec::new(), format!("{}, as rows of {}", row.doc, columns.join(", ")));
            (table.name, table.ty) = (format!("{name}:table"), of(Form::Rows(columns)));
            out.push(table);
        }
        Form::Record(fields) => below(fields, out),
        Form::Records(fields) => {
            for field in fields.iter().filter_map(|field| self::row(row.noun, field)) {
                let unsaid = if field.form == Form::Number { "-1" } else { "\"\"" };
                out.push(Property {
                    name: format!("{name}:{}", field.name),
                    ty: if field.form == Form::Number { UsdType::Doubles } else { UsdType::Tokens },
                    row: field,
                    tokens: Vec::new(),
                    doc: format!("{}, one entry for each of {}; {unsaid} where it isn't said", field.doc, row.name),
                });
            }
        }
        Form::Thing(fields) => {
            let none = if row.noun == Noun::Medium { ", or none" } else { "" };
            out.push(property(Vec::new(), format!("name of a {} that a sidecar defines{none}", row.noun)));
            below(fields, out);
        }
        Form::Kind => {
            let named = crate::attribute::named(row.noun) && row.name == row.noun.to_string();
            let all: Vec<&str> = kinds(row.name).map(|kind| kind.name).collect();
            let also = if named { ", or the name of one that a sidecar defines" } else { "" };
            let doc = format!("{}: {}{also}", row.doc, all.join(", "));
            out.push(property(if named { Vec::new() } else { all }, doc));
            kinds(row.name).for_each(|kind| below(kind.parameters, out));
        }
    }
}

/// Every name that a property can have, without namespace and without the prefix of faces and of `default`.
pub(super) fn known() -> Vec<String> {
    let rows = Noun::ALL.into_iter().flat_map(properties).map(|property| property.name);
    rows.chain(["faces", "normal"].map(str::to_owned)).collect()
}

/// The name without the prefix of faces and of `default`.
pub(super) fn bare(name: &str) -> &str {
    if let Some(rest) = name.strip_prefix("default:") {
        return rest;
    }
    match name.strip_prefix("face:").and_then(|rest| rest.split_once(':')) {
        Some((_, rest)) => rest,
        None => name,
    }
}
