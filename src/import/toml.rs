//! TOML text → [`Value`] tree; every value knows its line.

use super::value::{Data, Value};
use eyebox_base::error::Result;
use eyebox_base::{Error, Where};
use std::ops::Range;
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Reads the TOML file `path`. Faults: it can't be read, isn't UTF-8, or isn't TOML (with the line).
pub fn read(path: &Path) -> Result<Value> {
    read_as(path, "sidecar")
}

/// The same for a file that is called something else in faults.
pub fn read_as(path: &Path, what: &str) -> Result<Value> {
    let bytes = super::files::read(path, &Where::Nowhere, what)?;
    let text = String::from_utf8(bytes).map_err(|_| Error::new(Where::file(path), "this file is not UTF-8 text"))?;
    parse(&text, path)
}

/// Parses TOML text that stands in `file`. Entries of a table keep the order of the text.
pub fn parse(text: &str, file: &Path) -> Result<Value> {
    let lines = Lines::new(text);
    let place = |span: Range<usize>| Where::Line { file: file.to_owned(), line: lines.of(span.start) };
    let document = DeTable::parse(text).map_err(|error| {
        let at = error.span().map_or_else(|| Where::file(file), &place);
        Error::new(at, format!("not valid TOML: {}", error.message().replace('\n', " ")))
    })?;
    table(document.get_ref(), place(0..0), &place)
}

/// Parses the text after the `=` of `--set`: a TOML value, or else the text as it stands (`3.6 mm`, `N-SK16`).
pub fn parse_value(text: &str, at: &Where) -> Value {
    let bare = || Value::new(Data::Text(text.trim().to_owned()), at.clone());
    let line = format!("value = {text}");
    let Ok(document) = DeTable::parse(&line) else { return bare() };
    let parsed = table(document.get_ref(), at.clone(), &|_| at.clone());
    match parsed {
        // More than one entry: the text held a line break and looked like TOML again.
        Ok(Value { data: Data::Table(entries), .. }) if entries.len() == 1 => {
            entries.into_iter().next().map_or_else(bare, |(_, value)| value)
        }
        Ok(_) | Err(_) => bare(),
    }
}

type Place<'a> = dyn Fn(Range<usize>) -> Where + 'a;

fn table(entries: &DeTable<'_>, at: Where, place: &Place<'_>) -> Result<Value> {
    let mut rows = Vec::with_capacity(entries.len());
    for (key, entry) in entries {
        // A key's line is where people look for a long value; tables made by headers have no better place either.
        rows.push((key.span().start, key.get_ref().to_string(), value(entry, place(key.span()), place)?));
    }
    rows.sort_by_key(|row| row.0);
    Ok(Value::new(Data::Table(rows.into_iter().map(|(_, key, value)| (key, value)).collect()), at))
}

fn value(entry: &Spanned<DeValue<'_>>, at: Where, place: &Place<'_>) -> Result<Value> {
    let number = |text: &str, parsed: Option<f64>| {
        parsed.ok_or_else(|| Error::new(at.clone(), format!("`{text}` is not a number that can be used")))
    };
    let data = match entry.get_ref() {
        DeValue::String(text) => Data::Text(text.to_string()),
        DeValue::Integer(integer) => {
            let parsed = i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|i| i as f64);
            Data::Number(number(integer.as_str(), parsed)?)
        }
        DeValue::Float(float) => {
            let text = float.as_str();
            // 1e999 is a mistake, `inf` is meant.
            let parsed =
                text.parse::<f64>().ok().filter(|x| x.is_finite() || !text.contains(|c: char| c.is_ascii_digit()));
            Data::Number(number(text, parsed)?)
        }
        DeValue::Boolean(flag) => Data::Bool(*flag),
        DeValue::Datetime(date) => {
            return Err(Error::new(at, format!("a date ({date}) has no meaning here; write it in quotes")));
        }
        DeValue::Array(items) => {
            let items = items.iter().map(|item| value(item, place(item.span()), place));
            Data::List(items.collect::<Result<_>>()?)
        }
        DeValue::Table(entries) => return table(entries, at, place),
    };
    Ok(Value::new(data, at))
}

/// Byte offset → line.
struct Lines(Vec<usize>);

impl Lines {
    fn new(text: &str) -> Self {
        Lines(text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n').map(|(offset, _)| offset).collect())
    }
    /// 1-based.
    fn of(&self, offset: usize) -> usize {
        self.0.partition_point(|end| *end < offset) + 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(value: Option<&Value>) -> String {
        value.map_or_else(|| "nothing".to_owned(), |value| value.at.to_string())
    }

    #[test]
    fn values_keep_their_order_and_their_lines() {
        let text = "schema = 1\nunit = 1e-3 # mm\n\n[eye]\nz = [1,\n 2, inf]\na = { q = true }\n[[bind]]\npath = \"x\"\n[[bind]]\npath = \"y\"\n";
        let tree = parse(text, Path::new("a.toml")).unwrap();
        assert_eq!(tree.get("unit").map(|v| v.data.clone()), Some(Data::Number(1e-3)));
        assert_eq!(line(tree.get("unit")), "a.toml:2");
        let eye = tree.get("eye").unwrap();
        assert_eq!(line(Some(eye)), "a.toml:4");
        assert_eq!(line(eye.get("a").and_then(|a| a.get("q"))), "a.toml:7");
        let Data::Table(entries) = &eye.data else { panic!("{eye:?}") };
        assert_eq!(entries.iter().map(|(key, _)| key.as_str()).collect::<Vec<_>>(), ["z", "a"]);
        let Some(Data::List(z)) = eye.get("z").map(|z| z.data.clone()) else { panic!("{eye:?}") };
        assert_eq!(line(z.get(2)), "a.toml:6");
        assert_eq!(z[2].data, Data::Number(f64::INFINITY));
        let Some(Data::List(binds)) = tree.get("bind").map(|b| b.data.clone()) else { panic!("{tree:?}") };
        assert_eq!((line(binds.first()), line(binds.get(1))), ("a.toml:8".into(), "a.toml:10".into()));
    }

    #[test]
    fn what_is_not_toml_is_a_fault_with_its_line() {
        let fault = |text: &str| parse(text, Path::new("a.toml")).unwrap_err().to_string();
        let texts = [
            "schema = 1\nunit 3\n",
            "a = 1\nb = 2\na = 3\n",
            "a = 1\n[[b\n",
            "c = \"\"\"x",
            "\na = 99999999999999999999",
            "a = 2026-01-01",
            "a = 1e999",
            "a = [1,\n,2]",
        ];
        let expected = [
            "a.toml:2: not valid TOML: key with no value, expected `=`",
            "a.toml:3: not valid TOML: duplicate key",
            "a.toml:2: not valid TOML: unclosed array table, expected `]]`",
            "a.toml:1: not valid TOML: invalid multi-line basic string, expected `\"`",
            "a.toml:2: `99999999999999999999` is not a number that can be used",
            "a.toml:1: a date (2026-01-01) has no meaning here; write it in quotes",
            "a.toml:1: `1e999` is not a number that can be used",
            "a.toml:2: not valid TOML: extra comma in array, expected value",
        ];
        assert_eq!(texts.map(fault), expected);
        // Deep nesting is refused, not followed.
        assert!(parse(&format!("a = {}", "[".repeat(100_000)), Path::new("a.toml")).is_err());
        assert!(parse(&format!("a = {}{}", "[".repeat(100_000), "]".repeat(100_000)), Path::new("a.toml")).is_err());
    }

    #[test]
    fn a_set_value_is_toml_or_else_the_bare_text() {
        let at = Where::Option("--set x.y=…".into());
        let parsed = |text: &str| parse_value(text, &at).data;
        assert_eq!(parsed("0.5"), Data::Number(0.5));
        assert_eq!(parsed("3.6 mm"), Data::Text("3.6 mm".into()));
        assert_eq!(parsed("N-SK16"), Data::Text("N-SK16".into()));
        assert_eq!(parsed("\"none\""), Data::Text("none".into()));
        assert_eq!(parsed("2026-01-01"), Data::Text("2026-01-01".into()));
        assert_eq!(parsed("1\nx = 2"), Data::Text("1\nx = 2".into()));
        assert!(matches!(parsed("[44, 22]"), Data::List(_)));
        assert!(matches!(parsed("{ lambert = { reflectance = 0.5 } }"), Data::Table(_)));
    }
}
