//! A layer as `.usda` text. Numbers are the shortest that read back to the same bits, a negative zero included, which
//! `openusd`'s own text writer loses.

use super::layer::{Body, Datum, Layer, Prim, Property, Specifier};
use std::fmt::{Display, Write};

/// The text of `layer`.
pub fn text(layer: &Layer) -> String {
    let mut out = Text { out: String::from("#usda 1.0\n"), depth: 0 };
    out.header(layer);
    let mut open = 0;
    for prim in &layer.prims {
        out.close(&mut open, prim.depth);
        out.prim(prim);
        open = prim.depth + 1;
    }
    out.close(&mut open, 0);
    out.out
}

struct Text {
    out: String,
    depth: usize,
}

impl Text {
    fn line(&mut self, text: impl Display) {
        for _ in 0..self.depth {
            self.out.push_str("    ");
        }
        // Writing to a String does not fail.
        let _ = writeln!(self.out, "{text}");
    }

    fn header(&mut self, layer: &Layer) {
        if layer.metadata.is_empty() && layer.sublayers.is_empty() {
            return;
        }
        self.line("(");
        self.depth += 1;
        for (key, value) in &layer.metadata {
            self.line(format_args!("{key} = {}", Shown(value)));
        }
        if !layer.sublayers.is_empty() {
            self.line("subLayers = [");
            self.depth += 1;
            for (i, path) in layer.sublayers.iter().enumerate() {
                let comma = if i + 1 < layer.sublayers.len() { "," } else { "" };
                self.line(format_args!("{}{comma}", asset(path)));
            }
            self.depth -= 1;
            self.line("]");
        }
        self.depth -= 1;
        self.line(")");
    }

    /// Closes the braces of prims that are at `depth` or below it.
    fn close(&mut self, open: &mut usize, depth: usize) {
        while *open > depth {
            *open -= 1;
            self.depth = *open;
            self.line("}");
        }
        self.depth = depth;
    }

    fn prim(&mut self, prim: &Prim) {
        self.out.push('\n');
        let specifier = match prim.specifier {
            Specifier::Def => "def",
            Specifier::Over => "over",
            Specifier::Class => "class",
        };
        let space = if prim.type_name.is_empty() { "" } else { " " };
        let head = format!("{specifier}{space}{} {}", prim.type_name, quoted(&prim.name));
        let metadata = metadata(prim);
        if metadata.is_empty() && prim.marks.is_empty() {
            self.line(head);
        } else {
            self.line(format_args!("{head} ("));
            self.depth += 1;
            for line in metadata {
                self.line(line);
            }
            self.marks(&prim.marks);
            self.depth -= 1;
            self.line(")");
        }
        self.line("{");
        self.depth += 1;
        for property in &prim.properties {
            self.property(property);
        }
    }

    fn marks(&mut self, marks: &[(&'static str, Datum)]) {
        if marks.is_empty() {
            return;
        }
        self.line("customData = {");
        self.depth += 1;
        self.line("dictionary eyebox = {");
        self.depth += 1;
        for (key, value) in marks {
            self.line(format_args!("{} {key} = {}", value.type_name(), Shown(value)));
        }
        self.depth -= 1;
        self.line("}");
        self.depth -= 1;
        self.line("}");
    }

    fn property(&mut self, property: &Property) {
        let name = &property.name;
        match &property.body {
            Body::Attribute { type_name, uniform, value, samples, interpolation, each } => {
                let uniform = if *uniform { "uniform " } else { "" };
                let custom = if property.custom { "custom " } else { "" };
                let head = format!("{custom}{uniform}{type_name} {name}");
                self.value(&head, value.as_ref(), (*interpolation, property.color_space, *each));
                if !samples.is_empty() {
                    self.line(format_args!("{head}.timeSamples = {{"));
                    self.depth += 1;
                    for (code, value) in samples {
                        self.line(format_args!("{}: {},", double(*code), Shown(value)));
                    }
                    self.depth -= 1;
                    self.line("}");
                }
            }
            Body::Connected { type_name, source } => self.line(format_args!("{type_name} {name}.connect = <{source}>")),
            Body::Relationship { targets } => match targets.as_slice() {
                [] => self.line(format_args!("rel {name}")),
                [one] => self.line(format_args!("rel {name} = <{one}>")),
                many => {
                    let list: Vec<String> = many.iter().map(|target| format!("<{target}>")).collect();
                    self.line(format_args!("rel {name} = [{}]", list.join(", ")));
                }
            },
        }
    }
}

impl Text {
    /// The line of an attribute's own value, with its metadata.
    fn value(
        &mut self,
        head: &str,
        value: Option<&Datum>,
        (interpolation, space, each): (Option<&str>, Option<&str>, Option<usize>),
    ) {
        let Some(value) = value else { return self.line(head) };
        let texts = [("interpolation", interpolation), ("colorSpace", space)];
        let mut more: Vec<String> =
            texts.into_iter().filter_map(|(key, text)| Some(format!("{key} = {}", quoted(text?)))).collect();
        more.extend(each.map(|each| format!("elementSize = {each}")));
        if more.is_empty() {
            return self.line(format_args!("{head} = {}", Shown(value)));
        }
        self.line(format_args!("{head} = {} (", Shown(value)));
        self.depth += 1;
        for line in more {
            self.line(line);
        }
        self.depth -= 1;
        self.line(")");
    }
}

/// Lines of a prim's metadata but for the marks.
fn metadata(prim: &Prim) -> Vec<String> {
    let mut out = Vec::new();
    if !prim.schemas.is_empty() {
        let list: Vec<String> = prim.schemas.iter().map(|schema| quoted(schema)).collect();
        out.push(format!("prepend apiSchemas = [{}]", list.join(", ")));
    }
    if let Some(name) = &prim.display_name {
        out.push(format!("displayName = {}", quoted(name)));
    }
    if let Some(instanceable) = prim.instanceable {
        out.push(format!("instanceable = {instanceable}"));
    }
    if let Some(kind) = prim.kind {
        out.push(format!("kind = {}", quoted(kind)));
    }
    if let Some(path) = &prim.reference {
        out.push(format!("prepend references = <{path}>"));
    }
    out
}

/// A text between quotes, with the escapes that USD reads back.
fn quoted(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + 2);
    out.push('"');
    for c in text.chars() {
        match c {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            '\n' => out.push_str("\\n"),
            '\r' => out.push_str("\\r"),
            '\t' => out.push_str("\\t"),
            c if c.is_ascii_control() => {
                let _ = write!(out, "\\x{:02x}", u32::from(c));
            }
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

/// An asset path between its at signs.
fn asset(path: &str) -> String {
    if path.contains('@') { format!("@@@{}@@@", path.replace("@@@", "\\@@@")) } else { format!("@{path}@") }
}

/// What half precision makes of a number.
pub(super) fn half(x: f32) -> f32 {
    openusd::gf::f16::from_f32(x).to_f32()
}

/// A value as text.
struct Shown<'a>(&'a Datum);

impl Display for Shown<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0 {
            Datum::Bool(flag) => write!(f, "{flag}"),
            Datum::Int(number) => write!(f, "{number}"),
            Datum::Ints(list) => write_list(f, list, |f, x| write!(f, "{x}")),
            Datum::Float(x) => f.write_str(&single(*x)),
            Datum::Floats(list) => write_list(f, list, |f, x| f.write_str(&single(*x))),
            Datum::Double(x) => f.write_str(&double(*x)),
            Datum::Doubles(list) => write_list(f, list, |f, x| f.write_str(&double(*x))),
            Datum::Text(text) | Datum::Token(text) => f.write_str(&quoted(text)),
            Datum::Texts(list) | Datum::Tokens(list) => write_list(f, list, |f, text| f.write_str(&quoted(text))),
            Datum::Asset(path) => f.write_str(&asset(path)),
            Datum::Assets(list) => write_list(f, list, |f, path| f.write_str(&asset(path))),
            Datum::Int2([x, y]) => write!(f, "({x}, {y})"),
            Datum::Float2(p) => singles(f, p),
            Datum::Float2s(list) => write_list(f, list, |f, p| singles(f, p)),
            Datum::Float3(p) => singles(f, p),
            Datum::Float4(p) => singles(f, p),
            Datum::Float3s(list) => write_list(f, list, |f, p| singles(f, p)),
            Datum::Double2(p) => doubles(f, p),
            Datum::Double2s(list) => write_list(f, list, |f, p| doubles(f, p)),
            Datum::Double3(p) => doubles(f, p),
            Datum::Double3s(list) => write_list(f, list, |f, p| doubles(f, p)),
            Datum::Half3s(list) => write_list(f, list, |f, p| singles(f, &p.map(half))),
            Datum::Quat(q) => doubles(f, q),
            Datum::Quats(list) => write_list(f, list, |f, q| singles(f, q)),
            Datum::Matrix(rows) => tuple(f, rows, |f, row| doubles(f, row)),
            Datum::Matrices(list) => write_list(f, list, |f, rows| tuple(f, rows, |f, row| doubles(f, row))),
            Datum::Blocked(_) => f.write_str("None"),
        }
    }
}

type Formatter<'a> = std::fmt::Formatter<'a>;

fn write_list<T>(
    f: &mut Formatter<'_>,
    list: &[T],
    each: impl Fn(&mut Formatter<'_>, &T) -> std::fmt::Result,
) -> std::fmt::Result {
    between(f, list, ('[', ']'), each)
}

fn tuple<T>(
    f: &mut Formatter<'_>,
    list: &[T],
    each: impl Fn(&mut Formatter<'_>, &T) -> std::fmt::Result,
) -> std::fmt::Result {
    between(f, list, ('(', ')'), each)
}

fn between<T>(
    f: &mut Formatter<'_>,
    list: &[T],
    (open, close): (char, char),
    each: impl Fn(&mut Formatter<'_>, &T) -> std::fmt::Result,
) -> std::fmt::Result {
    f.write_char(open)?;
    for (i, item) in list.iter().enumerate() {
        if i > 0 {
            f.write_str(", ")?;
        }
        each(f, item)?;
    }
    f.write_char(close)
}

fn singles(f: &mut Formatter<'_>, list: &[f32]) -> std::fmt::Result {
    tuple(f, list, |f, x| f.write_str(&single(*x)))
}

fn doubles(f: &mut Formatter<'_>, list: &[f64]) -> std::fmt::Result {
    tuple(f, list, |f, x| f.write_str(&double(*x)))
}

fn single(x: f32) -> String {
    plain(format!("{x:?}"), x.is_nan())
}

fn double(x: f64) -> String {
    plain(format!("{x:?}"), x.is_nan())
}

/// Rust's shortest text (`inf`, `-inf` are USD's words, too) without a `.0` that says nothing; −0 keeps it, since
/// `-0` alone might be read as a whole number, which has no sign of zero.
fn plain(text: String, nan: bool) -> String {
    if nan {
        return "nan".to_owned();
    }
    match text.strip_suffix(".0") {
        Some(whole) if whole != "-0" => whole.to_owned(),
        Some(_) | None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_exact() {
        for (x, text) in [
            (0.0, "0"),
            (-0.0, "-0.0"),
            (1.0, "1"),
            (0.1, "0.1"),
            (1e-7, "1e-7"),
            (-553.77865, "-553.77865"),
            (f64::MAX, "1.7976931348623157e308"),
            (5e-324, "5e-324"),
            (f64::INFINITY, "inf"),
            (f64::NEG_INFINITY, "-inf"),
            (f64::NAN, "nan"),
        ] {
            assert_eq!(double(x), text);
        }
        assert_eq!(single(0.1), "0.1");
        assert_eq!(single(f32::MAX), "3.4028235e38");
    }

    #[test]
    fn texts_and_asset_paths_are_delimited() {
        assert_eq!(quoted("a\"b\\c\n\u{1}ü"), r#""a\"b\\c\n\x01ü""#);
        assert_eq!(asset("./a b.usda"), "@./a b.usda@");
        assert_eq!(asset("a@b"), "@@@a@b@@@");
    }
}
