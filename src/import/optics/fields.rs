//! Checked access to a table of attributes: unknown names, wrong forms and numbers out of range become faults with the
//! row's range and the nearest name.

use crate::value::{Data, Value};
use eyebox_base::error::Result;
use eyebox_base::units::parse_length_m;
use eyebox_base::{Code, Error, Where};
use eyebox_scene::Note;
use eyebox_scene::attribute::union::split;
use eyebox_scene::attribute::{self, Form, Kind, Noun, Row, Support};
use glam::DVec3;

/// The attributes of one thing.
#[derive(Debug, Clone)]
pub struct Fields<'a> {
    noun: Noun,
    /// What they are attributes of, for messages: `emitter`, `finish gauss`.
    what: String,
    at: &'a Where,
    entries: Vec<(&'a str, &'a Value)>,
}

impl<'a> Fields<'a> {
    /// The table `value`, whose keys must be rows of `noun`, those in `allowed` if that isn't empty.
    /// Faults: not a table, unknown or not yet rendered attributes.
    pub fn of(noun: Noun, what: &str, value: &'a Value, allowed: &[&str]) -> Result<Self> {
        let Some(entries) = value.table() else {
            return Err(Error::new(value.at.clone(), format!("{what} is {} ({value})", value.kind()))
                .expected(format!("a table, e.g. {{ {} = … }}", allowed.first().copied().unwrap_or("name"))));
        };
        Self::from_entries(noun, what, &value.at, entries.iter().map(|(k, v)| (k.as_str(), v)).collect(), allowed)
    }

    fn from_entries(
        noun: Noun,
        what: &str,
        at: &'a Where,
        entries: Vec<(&'a str, &'a Value)>,
        allowed: &[&str],
    ) -> Result<Self> {
        let valid =
            || attribute::rows(noun).map(|row| row.name).filter(|name| allowed.is_empty() || allowed.contains(name));
        for (key, value) in &entries {
            let row = attribute::row(noun, key).filter(|_| valid().any(|name| name == *key));
            let Some(row) = row else {
                if let Some(fault) = stray(key, value, noun, what, &mut valid()) {
                    return Err(fault);
                }
                return Err(Error::new(value.at.clone(), format!("unknown attribute `{key}` of {what}"))
                    .expected(one_of(valid()))
                    .nearest(key, valid())
                    .code(Code::AttributeUnknown));
            };
            if row.support == Support::NotYet {
                return Err(not_yet(&value.at, &format!("`{key}` of {what}")));
            }
        }
        Ok(Fields { noun, what: what.to_owned(), at, entries })
    }

    pub fn at(&self) -> &'a Where {
        self.at
    }
    /// What they are attributes of.
    pub fn what(&self) -> &str {
        &self.what
    }
    pub fn value(&self, name: &str) -> Option<&'a Value> {
        self.entries.iter().find(|(key, _)| *key == name).map(|(_, value)| *value)
    }
    pub fn has(&self, name: &str) -> bool {
        self.value(name).is_some()
    }
    fn row(&self, name: &str) -> Result<&'static Row> {
        attribute::row(self.noun, name)
            .ok_or_else(|| Error::new(self.at.clone(), format!("`{name}` is no attribute of {}", self.what)))
    }
    /// A fault that `name` is missing.
    pub fn missing(&self, name: &str) -> Box<Error> {
        let fault = Error::new(self.at.clone(), format!("{} has no `{name}`", self.what));
        match attribute::row(self.noun, name) {
            Some(row) => fault.expected(row.expected()).code(code(row)),
            None => fault,
        }
    }
    fn get<T>(&self, name: &str, read: impl Fn(&Value, &Row) -> Result<T>) -> Result<Option<T>> {
        let row = self.row(name)?;
        self.value(name).map(|value| read(value, row)).transpose()
    }

    pub fn number(&self, name: &str) -> Result<Option<f64>> {
        self.get(name, number)
    }
    pub fn need_number(&self, name: &str) -> Result<f64> {
        self.number(name)?.ok_or_else(|| self.missing(name))
    }
    /// The number, or the row's default with a note that it was used.
    pub fn number_or(&self, name: &str, default: f64, notes: &mut Vec<Note>) -> Result<f64> {
        Ok(match self.number(name)? {
            Some(number) => number,
            None => {
                notes.push(self.defaulted(name));
                default
            }
        })
    }
    /// The note that the default of `name` was used.
    pub fn defaulted(&self, name: &str) -> Note {
        let default = attribute::row(self.noun, name).and_then(|row| row.default).unwrap_or("nothing");
        Note::info(self.at.clone(), format!("`{name}` of {} is not said: {default}", self.what))
    }
    pub fn text(&self, name: &str) -> Result<Option<&'a str>> {
        let row = self.row(name)?;
        self.value(name).map(|value| value.text().ok_or_else(|| wrong(value, row))).transpose()
    }
    pub fn need_text(&self, name: &str) -> Result<&'a str> {
        self.text(name)?.ok_or_else(|| self.missing(name))
    }
    pub fn numbers<const N: usize>(&self, name: &str) -> Result<Option<[f64; N]>> {
        self.get(name, numbers)
    }
    pub fn need_numbers<const N: usize>(&self, name: &str) -> Result<[f64; N]> {
        self.numbers(name)?.ok_or_else(|| self.missing(name))
    }
    pub fn need_rows<const N: usize>(&self, name: &str) -> Result<Vec<[f64; N]>> {
        self.get(name, rows)?.ok_or_else(|| self.missing(name))
    }
    /// As many numbers as the row allows.
    pub fn need_coefficients(&self, name: &str) -> Result<Vec<f64>> {
        self.get(name, coefficients)?.ok_or_else(|| self.missing(name))
    }
    /// A unit vector.
    pub fn direction(&self, name: &str) -> Result<Option<DVec3>> {
        let Some([x, y, z]) = self.numbers::<3>(name)? else { return Ok(None) };
        let at = self.value(name).map_or(self.at, |value| &value.at);
        // Scaled first, so that squares neither overflow nor vanish.
        let largest = x.abs().max(y.abs()).max(z.abs());
        let scaled = DVec3::new(x, y, z) / largest;
        match scaled.try_normalize() {
            Some(unit) if largest > 0.0 => Ok(Some(unit)),
            Some(_) | None => Err(Error::new(at.clone(), format!("`{name}` of {} is the zero vector", self.what))
                .expected("a direction")
                .code(attribute::row(self.noun, name).and_then(code))),
        }
    }
    pub fn need_direction(&self, name: &str) -> Result<DVec3> {
        self.direction(name)?.ok_or_else(|| self.missing(name))
    }
    /// A length with a unit, m.
    pub fn length_m(&self, name: &str) -> Result<Option<f64>> {
        self.get(name, |value, row| {
            let metres = length(value, row)?;
            if row.range.holds(metres) {
                return Ok(metres);
            }
            Err(Error::new(value.at.clone(), format!("`{name}` is {value}"))
                .expected(format!("a length with its unit: {}", row.range))
                .code(code(row)))
        })
    }
    /// Three lengths with units, m.
    pub fn place_m(&self, name: &str) -> Result<Option<DVec3>> {
        self.get(name, |value, row| match value.list() {
            Some([x, y, z]) => {
                let place = DVec3::new(length(x, row)?, length(y, row)?, length(z, row)?);
                if place.is_finite() { Ok(place) } else { Err(wrong(value, row)) }
            }
            Some(_) | None => Err(wrong(value, row)),
        })
    }
}

/// A number that the row allows.
pub fn number(value: &Value, row: &Row) -> Result<f64> {
    let number = match &value.data {
        Data::Number(number) => *number,
        // JSON has no infinity.
        Data::Text(text) if matches!(text.as_str(), "inf" | "infinity") => f64::INFINITY,
        Data::Bool(_) | Data::Text(_) | Data::List(_) | Data::Table(_) => return Err(wrong(value, row)),
    };
    if row.range.holds(number) {
        return Ok(number);
    }
    let unit = if row.unit.is_empty() { String::new() } else { format!(" in {}", row.unit) };
    Err(Error::new(value.at.clone(), format!("`{}` is {number}", row.name))
        .expected(format!("{}{unit}", row.range))
        .code(code(row)))
}

fn numbers<const N: usize>(value: &Value, row: &Row) -> Result<[f64; N]> {
    let list = value.list().filter(|list| list.len() == N).ok_or_else(|| wrong(value, row))?;
    let mut out = [0.0; N];
    for (out, item) in out.iter_mut().zip(list) {
        *out = number(item, row)?;
    }
    Ok(out)
}

/// A list of numbers, as long as the row allows.
fn coefficients(value: &Value, row: &Row) -> Result<Vec<f64>> {
    let list = value.list().ok_or_else(|| wrong(value, row))?;
    if let Form::Coefficients { least, most } = row.form
        && !(least..=most).contains(&list.len())
    {
        return Err(Error::new(value.at.clone(), format!("`{}` has {} numbers", row.name, list.len()))
            .expected(format!("{least} to {most} numbers")));
    }
    list.iter().map(|item| number(item, row)).collect()
}

/// Rows of N numbers, at least one.
pub fn rows<const N: usize>(value: &Value, row: &Row) -> Result<Vec<[f64; N]>> {
    let items = value.list().filter(|list| !list.is_empty()).ok_or_else(|| wrong(value, row))?;
    items.iter().map(|item| numbers(item, row)).collect()
}

fn length(value: &Value, row: &Row) -> Result<f64> {
    match &value.data {
        Data::Text(text) => parse_length_m(text).map_err(|why| {
            Error::new(value.at.clone(), format!("`{}`: {why}", row.name)).expected(row.expected()).code(code(row))
        }),
        // Zero is the same in every unit, and so is infinity.
        Data::Number(number) if *number == 0.0 || *number == f64::INFINITY => Ok(*number),
        Data::Number(number) => Err(Error::new(value.at.clone(), format!("`{}` is {number} without a unit", row.name))
            .expected(row.expected())
            .code(code(row))),
        Data::Bool(_) | Data::List(_) | Data::Table(_) => Err(wrong(value, row)),
    }
}

/// The fault of a value of the wrong form.
fn wrong(value: &Value, row: &Row) -> Box<Error> {
    Error::new(value.at.clone(), format!("`{}` is {} ({value})", row.name, value.kind()))
        .expected(row.expected())
        .code(code(row))
}

/// What a value is about that a row can't have; none where that is no more than its being wrong.
pub fn code(row: &Row) -> Option<Code> {
    match row.noun {
        Noun::Eye => Some(Code::EyeImpossible),
        Noun::Medium => (row.name == "ior").then_some(Code::IndexImpossible),
        Noun::Finish | Noun::Coating => (row.name == "n").then_some(Code::IndexImpossible),
        Noun::Slide | Noun::Emitter => (row.name == "size").then_some(Code::SlideWithoutSize),
        Noun::Shape | Noun::Sensor | Noun::Sky | Noun::Sun | Noun::Asset => None,
    }
}

/// The fault of a parameter that stands beside its attribute instead of in it: `angular = "cos_n", n = 4`. None if `key` is
/// a parameter of none of `attributes`, rows of `noun`.
pub fn stray(
    key: &str,
    value: &Value,
    noun: Noun,
    what: &str,
    attributes: &mut dyn Iterator<Item = &str>,
) -> Option<Box<Error>> {
    let row = attribute::row(noun, key)?;
    let attributes: Vec<&str> = attributes.collect();
    if let Some(holder) = attribute::holder(row).filter(|holder| attributes.contains(&holder.name)) {
        let text = format!("`{key}` stands in {what}: it is an entry of {}", holder.name);
        return Some(Error::new(value.at.clone(), text).expected(format!("{} = {{ {key} = … }}", holder.name)));
    }
    let takes = |kind: &&Kind| attributes.contains(&kind.attribute) && kind.parameters.contains(&key);
    let kinds: Vec<&Kind> = attribute::KINDS.iter().filter(takes).collect();
    let first = kinds.first()?;
    let Kind { attribute, name, .. } = kinds.iter().find(|kind| kind.rendered).unwrap_or(first);
    if !kinds.iter().any(|kind| kind.rendered) {
        return Some(not_yet(&value.at, &format!("`{key}` of {what}: {attribute} `{name}`")));
    }
    let fault = Error::new(value.at.clone(), format!("`{key}` stands in {what}: it is a parameter of {attribute}"));
    Some(fault.expected(format!("{attribute} = {{ kind = \"{name}\", {key} = … }}")))
}

/// The fault of something that would change the picture and can't be rendered yet.
pub fn not_yet(at: &Where, what: &str) -> Box<Error> {
    Error::new(at.clone(), format!("{what} is not rendered by this version yet"))
}

pub(super) fn one_of<'a>(names: impl Iterator<Item = &'a str>) -> String {
    format!("one of {}", names.collect::<Vec<_>>().join(", "))
}

/// A value that is one of several kinds, with the parameters of that kind.
#[derive(Debug, Clone)]
pub struct Union<'a> {
    pub kind: &'static Kind,
    pub fields: Fields<'a>,
}

/// Reads `"polished"`, `{ kind = "gauss", sigma_deg = 6 }`, `{ gauss = { sigma_deg = 6 } }` or `{ stack = […] }` as a kind
/// of `attribute`. Faults: unknown or not yet rendered kinds, parameters that the kind doesn't take.
pub fn union<'a>(noun: Noun, attribute: &str, value: &'a Value) -> Result<Union<'a>> {
    let read = split(attribute, value)?;
    let kind = read.kind.ok_or_else(|| attribute::union::unknown(attribute, read.name, read.at))?;
    if !kind.rendered {
        return Err(not_yet(read.at, &format!("{attribute} `{}`", kind.name)));
    }
    let what = format!("{attribute} `{}`", kind.name);
    if let (true, Some((key, value))) = (kind.parameters.is_empty(), read.parameters.first()) {
        return Err(Error::new(value.at.clone(), format!("{what} takes no `{key}`")).code(Code::AttributeUnknown));
    }
    Ok(Union { kind, fields: Fields::from_entries(noun, &what, &value.at, read.parameters, kind.parameters)? })
}
