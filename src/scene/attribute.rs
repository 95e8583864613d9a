//! The one table of optical attributes (`design/attributes.md`): importers, writers, schemas and the documentation walk
//! these rows. An attribute is a row here, a field in `scene/<noun>.rs` and its effect in `world/<noun>.rs`.

use std::fmt;

/// What an attribute describes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Noun {
    Medium,
    Finish,
    Coating,
    Shape,
    Emitter,
    Slide,
    Sensor,
    Sky,
    Sun,
    Eye,
    Asset,
}

impl Noun {
    /// In the order of the reference and of the schemas; the asset itself comes last.
    pub const ALL: [Noun; 11] = [
        Noun::Medium,
        Noun::Finish,
        Noun::Coating,
        Noun::Shape,
        Noun::Emitter,
        Noun::Slide,
        Noun::Sensor,
        Noun::Sky,
        Noun::Sun,
        Noun::Eye,
        Noun::Asset,
    ];
}

impl fmt::Display for Noun {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Noun::Medium => "medium",
            Noun::Finish => "finish",
            Noun::Coating => "coating",
            Noun::Shape => "shape",
            Noun::Emitter => "emitter",
            Noun::Slide => "slide",
            Noun::Sensor => "sensor",
            Noun::Sky => "sky",
            Noun::Sun => "sun",
            Noun::Eye => "eye",
            Noun::Asset => "asset",
        })
    }
}

/// The form of an attribute's value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Form {
    Number,
    Integer,
    /// A name or a path.
    Text,
    /// A file name relative to the file that names it.
    File,
    /// A text with a number and its unit: `"4 mm"`.
    Length,
    /// The same, or one of these words.
    LengthOr(&'static [&'static str]),
    /// One of these words.
    Word(&'static [&'static str]),
    /// A list of that many numbers.
    Numbers(usize),
    /// A list of that many whole numbers.
    Integers(usize),
    /// A list of three lengths, each with its unit.
    Place,
    /// A list of numbers, at least and at most so many.
    Coefficients {
        least: usize,
        most: usize,
    },
    /// A list of rows, at least one, each a list of numbers: the columns by their names. The first column rises.
    Rows(&'static [&'static str]),
    /// One number that holds everywhere, or [`Form::Rows`].
    NumberOrRows(&'static [&'static str]),
    /// A table of these rows of the same noun; those with a default may be left out.
    Record(&'static [&'static str]),
    /// A list of tables, at least one, each with some of these rows of the same noun.
    Records(&'static [&'static str]),
    /// The noun itself: a table with some of these rows; also the name of one of the asset's, or its index in the
    /// asset's list.
    Thing(&'static [&'static str]),
    /// One of the [`KINDS`] of this attribute, with its parameters: `"KIND"`, `{ kind = "KIND", PARAMETER = … }`,
    /// `{ KIND = { PARAMETER = … } }`, or `{ PARAMETER = … }` if the parameter has the name of the kind. If the noun
    /// [can be named](named), also a name or an index as for [`Form::Thing`].
    Kind,
}

/// Which numbers are allowed. Every bound also refuses NaN; infinity is allowed only where it is said.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub enum Range {
    /// Any finite number.
    Any,
    /// `>= min`, finite.
    AtLeast(f64),
    /// `>= min` or infinite.
    AtLeastOrInfinite(f64),
    /// `> 0`, finite.
    Positive,
    /// `> 0` or infinite.
    PositiveOrInfinite,
    /// Finite and not 0.
    NonZero,
    /// `low <= x <= high`.
    Within(f64, f64),
    /// `low < x <= high`.
    Above(f64, f64),
    /// `low < x < high`.
    Between(f64, f64),
}

impl Range {
    pub fn holds(self, x: f64) -> bool {
        match self {
            Range::Any => x.is_finite(),
            Range::AtLeast(min) => x >= min && x.is_finite(),
            Range::AtLeastOrInfinite(min) => x >= min,
            Range::Positive => x > 0.0 && x.is_finite(),
            Range::PositiveOrInfinite => x > 0.0,
            Range::NonZero => x != 0.0 && x.is_finite(),
            Range::Within(low, high) => low <= x && x <= high,
            Range::Above(low, high) => low < x && x <= high,
            Range::Between(low, high) => low < x && x < high,
        }
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Range::Any => write!(f, "a finite number"),
            Range::AtLeast(min) => write!(f, "a number >= {min}"),
            Range::AtLeastOrInfinite(min) => write!(f, "a number >= {min}, or inf"),
            Range::Positive => write!(f, "a number > 0"),
            Range::PositiveOrInfinite => write!(f, "a number > 0, or inf"),
            Range::NonZero => write!(f, "a finite number other than 0"),
            Range::Within(low, high) if *high >= 1e9 => write!(f, "a number from {low} to {high:e}"),
            Range::Within(low, high) => write!(f, "a number from {low} to {high}"),
            Range::Above(low, high) => write!(f, "a number above {low} and up to {high}"),
            Range::Between(low, high) => write!(f, "a number above {low} and below {high}"),
        }
    }
}

/// Whether this version of the program acts on an attribute.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Support {
    /// It is rendered.
    Rendered,
    /// It is kept and reported, and changes no picture yet.
    Kept,
    /// It would change the picture and can't be rendered yet: using it is an error.
    NotYet,
}

/// One attribute.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Row {
    pub noun: Noun,
    pub name: &'static str,
    pub form: Form,
    /// Unit of the number, empty for pure numbers and texts. `mesh units` are the part's own.
    pub unit: &'static str,
    /// Of each number of the value.
    pub range: Range,
    /// What holds when it isn't said, in words; none where it must be said or where nothing holds.
    pub default: Option<&'static str>,
    pub support: Support,
    pub doc: &'static str,
}

impl Row {
    /// What a value of this row must be, for messages: `a number >= 0 in lm`.
    pub fn expected(&self) -> String {
        let unit = if self.unit.is_empty() { String::new() } else { format!(" in {}", self.unit) };
        match self.form {
            Form::Number => format!("{}{unit}", self.range),
            Form::Integer => "a whole number".to_owned(),
            Form::Text => "a text".to_owned(),
            Form::File => "a file name".to_owned(),
            Form::Length => "a length with its unit, e.g. \"4 mm\"".to_owned(),
            Form::LengthOr(words) => {
                let words: Vec<String> = words.iter().map(|word| format!("\"{word}\"")).collect();
                format!("a length with its unit, e.g. \"4 mm\", or {}", words.join(", "))
            }
            Form::Numbers(count) => format!("a list of {count} numbers{unit}"),
            Form::Place => "a list of three lengths with their units, e.g. [\"0 mm\", \"0 mm\", \"120 mm\"]".to_owned(),
            Form::Integers(count) => format!("a list of {count} whole numbers{unit}"),
            Form::Word(words) => format!("one of {}", words.join(", ")),
            Form::Coefficients { .. }
            | Form::Rows(_)
            | Form::NumberOrRows(_)
            | Form::Record(_)
            | Form::Records(_)
            | Form::Thing(_) => self.doc.to_owned(),
            Form::Kind => {
                let names: Vec<_> = kinds(self.name).filter(|kind| kind.rendered).map(|kind| kind.name).collect();
                format!("one of {}", names.join(", "))
            }
        }
    }
}

/// One kind of a finish, coating, shape or angular distribution.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct Kind {
    /// The attribute it is a value of.
    pub attribute: &'static str,
    pub name: &'static str,
    /// Rows of the same noun that it takes.
    pub parameters: &'static [&'static str],
    pub rendered: bool,
    pub doc: &'static str,
}

mod rows;
pub use rows::{EMITTER, FILM, KINDS, MEASURED, MEDIUM, ORDER, PICTURE, ROWS, SKIES, SLIDE, SUN_SKY};
#[cfg(any(test, feature = "testing"))]
pub mod arbitrary; // random values of the table
pub mod union; // kinds with parameters
pub mod usd; // the same rows as USD properties

/// The rows of a noun.
pub fn rows(noun: Noun) -> impl Iterator<Item = &'static Row> {
    ROWS.iter().filter(move |row| row.noun == noun)
}

/// The rows that stand in a table of the noun itself: those that are no entries of another row's table.
pub fn own_rows(noun: Noun) -> impl Iterator<Item = &'static Row> {
    rows(noun).filter(|row| holder(row).is_none())
}

/// The row in whose table `row` stands, or in one of whose tables; none if it stands in that of its noun.
pub fn holder(row: &Row) -> Option<&'static Row> {
    let is_own = |form: Form| matches!(form, Form::Thing(_));
    rows(row.noun).find(|holder| !is_own(holder.form) && holder.form.fields().contains(&row.name))
}

impl Form {
    /// The rows of its table or tables; none of a form that is no table.
    pub fn fields(self) -> &'static [&'static str] {
        match self {
            Form::Record(fields) | Form::Records(fields) | Form::Thing(fields) => fields,
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
            | Form::Rows(_)
            | Form::NumberOrRows(_)
            | Form::Kind => &[],
        }
    }
}

/// The row `name` of a noun.
pub fn row(noun: Noun, name: &str) -> Option<&'static Row> {
    rows(noun).find(|row| row.name == name)
}

/// Whether things of this noun can have names that attributes refer to.
pub fn named(noun: Noun) -> bool {
    row(noun, "name").is_some()
}

/// The kinds of `attribute`.
pub fn kinds(attribute: &str) -> impl Iterator<Item = &'static Kind> {
    KINDS.iter().filter(move |kind| kind.attribute == attribute)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_unique_and_kinds_refer_to_rows() {
        for (i, row) in ROWS.iter().enumerate() {
            assert!(!ROWS[..i].iter().any(|other| (other.noun, other.name) == (row.noun, row.name)), "{}", row.name);
            assert!(!row.doc.is_empty(), "{}", row.name);
        }
        for kind in KINDS {
            let holder = ROWS.iter().find(|row| row.name == kind.attribute && row.form == Form::Kind);
            let noun = holder.unwrap_or_else(|| panic!("no row for kind {}", kind.name)).noun;
            for parameter in kind.parameters {
                assert!(row(noun, parameter).is_some(), "{} {parameter}", kind.name);
            }
        }
    }

    #[test]
    fn tables_within_values_are_rows() {
        for holder in ROWS {
            if !matches!(holder.form, Form::Record(_) | Form::Records(_) | Form::Thing(_)) {
                continue;
            }
            let fields = holder.form.fields();
            assert!(!fields.is_empty(), "{}", holder.name);
            for name in fields {
                let field = row(holder.noun, name).unwrap_or_else(|| panic!("{} {name}", holder.name));
                // Lists of tables become parallel arrays in USD: one number or one text a table.
                if let Form::Records(_) = holder.form {
                    assert!(matches!(field.form, Form::Number | Form::Text), "{} {name}", holder.name);
                }
            }
        }
    }

    #[test]
    fn entries_of_a_table_are_not_the_nouns_own() {
        let own: Vec<&str> = own_rows(Noun::Sky).map(|row| row.name).collect();
        assert!(own.contains(&"sun_sky") && own.contains(&"image"), "{own:?}");
        assert!(SUN_SKY.iter().all(|name| !own.contains(name)), "{own:?}");
        // What a sky is made of, and what goes with it, are rows of its own.
        for (kind, beside) in SKIES {
            assert!(own.contains(&kind) && beside.iter().all(|name| own.contains(name)), "{kind}");
        }
        let elevation = row(Noun::Sky, "elevation_deg").and_then(holder);
        assert_eq!(elevation.map(|holder| holder.name), Some("sun_sky"));
    }

    #[test]
    fn every_range_refuses_nan_and_says_its_bounds() {
        let ranges = [
            (Range::Any, -1.0, f64::INFINITY),
            (Range::AtLeast(1.0), 1.0, 0.999),
            (Range::AtLeastOrInfinite(1.0), f64::INFINITY, 0.5),
            (Range::Positive, 1e-300, 0.0),
            (Range::PositiveOrInfinite, f64::INFINITY, 0.0),
            (Range::NonZero, -5.0, 0.0),
            (Range::Within(0.0, 1.0), 1.0, 1.0 + f64::EPSILON),
            (Range::Above(0.0, 1.0), 1.0, 0.0),
            (Range::Between(0.0, 180.0), 179.0, 180.0),
        ];
        for (range, inside, outside) in ranges {
            assert!(range.holds(inside), "{range} {inside}");
            assert!(!range.holds(outside), "{range} {outside}");
            assert!(!range.holds(f64::NAN), "{range}");
        }
        assert_eq!(row(Noun::Emitter, "flux_lm").map(Row::expected).as_deref(), Some("a number from 0 to 1e12 in lm"));
    }
}
