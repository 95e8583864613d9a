//! Text layers as usd-core accepts them, in the form that the library's parser accepts. Tried with usd-core 26.11:
//! `.5` and `5.`; `5.0` and `1e3` for integers (cut towards 0); `True`, `yes`, numbers and texts for booleans; `"x.png"`
//! for asset paths, `<path>` for tokens and strings; `//` and `/* */` for comments; `config` before a type; quotes that
//! are escaped in texts of three quotes, `\@@@` in paths of three signs; numbers and texts for the flags of a prim. Lines
//! stay lines, so that messages name the right ones.

use std::borrow::Cow;

/// Stands for three signs within a path of three signs, which the parser has no words for: a code point that no text has
/// (Unicode, noncharacters). [`meant`] takes it back.
const SIGNS: char = '\u{fdd0}';

/// The path that the layer's author wrote.
pub(super) fn meant(path: &str) -> Cow<'_, str> {
    if path.contains(SIGNS) { Cow::Owned(path.replace(SIGNS, "@@@")) } else { Cow::Borrowed(path) }
}

/// Brackets within brackets; a text that goes deeper is no layer of anybody's.
const MOST_DEEP: usize = 1000;

/// The layer with what needs it rewritten.
///
/// # Errors
/// Brackets nested too deep for the parser's recursion.
pub(super) fn layer(bytes: &[u8]) -> Result<Cow<'_, [u8]>, String> {
    let mut scan = Scan { bytes, at: 0, out: Vec::new(), copied: 0 };
    scan.run()?;
    if scan.copied == 0 {
        return Ok(Cow::Borrowed(bytes));
    }
    let Scan { mut out, copied, .. } = scan;
    out.extend_from_slice(bytes.get(copied..).unwrap_or_default());
    Ok(Cow::Owned(out))
}

/// What the values of a property are to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Integer,
    Bool,
    /// A flag of a prim or property, as metadata: its parser wants the word.
    Flag,
    Asset,
    Text,
}

fn kind(type_name: &[u8]) -> Option<Kind> {
    match type_name {
        b"int" | b"int2" | b"int3" | b"int4" | b"uint" | b"int64" | b"uint64" | b"uchar" => Some(Kind::Integer),
        b"bool" => Some(Kind::Bool),
        b"asset" => Some(Kind::Asset),
        b"token" | b"string" => Some(Kind::Text),
        _ => None,
    }
}

/// The flags among metadata.
fn flag(field: &[u8]) -> Option<Kind> {
    matches!(field, b"active" | b"instanceable" | b"hidden").then_some(Kind::Flag)
}

struct Scan<'a> {
    bytes: &'a [u8],
    at: usize,
    out: Vec<u8>,
    /// How much of `bytes` is in `out`.
    copied: usize,
}

impl Scan<'_> {
    fn run(&mut self) -> Result<(), String> {
        // A type that was read, and the statement's values that are being read: their kind, the depth of brackets where
        // they began, whether one was met.
        let mut declared: Option<Kind> = None;
        let mut values: Option<(Kind, usize, bool)> = None;
        let (mut depth, mut line, mut may_be_value) = (0usize, 1usize, false);
        // The brackets that are open: fields of metadata lie directly in round ones.
        let mut open: Vec<u8> = Vec::new();
        while let Some(&byte) = self.bytes.get(self.at) {
            let start = self.at;
            match byte {
                b'\n' | b';' => {
                    line += usize::from(byte == b'\n');
                    if values.is_some_and(|(_, base, met)| met && depth <= base) {
                        values = None;
                    }
                    declared = declared.filter(|_| byte == b'\n' && values.is_some());
                    self.at += 1;
                    continue;
                }
                b'#' => {
                    self.skip_line();
                    continue;
                }
                b'/' if self.bytes.get(start + 1) == Some(&b'/') => {
                    self.skip_line();
                    self.replace(start, b"");
                    continue;
                }
                b'/' if self.bytes.get(start + 1) == Some(&b'*') => {
                    self.skip_to(2, b"*/");
                    let lines = self.lines(start);
                    line += lines;
                    self.replace(start, &vec![b'\n'; lines]);
                    continue;
                }
                b' ' | b'\t' | b'\r' => {
                    self.at += 1;
                    continue;
                }
                b'"' | b'\'' => {
                    let text = self.text(byte);
                    line += self.lines(start);
                    match values {
                        Some((Kind::Asset, ..)) => self.asset(start, text),
                        Some((Kind::Bool | Kind::Flag, ..)) => self.boolean(start, text),
                        Some((Kind::Integer | Kind::Text, ..)) | None => self.quotes(start, byte),
                    }
                    may_be_value = false;
                }
                b'@' => {
                    if self.bytes.get(start..start + 3) == Some(b"@@@") {
                        self.path_of_three_signs();
                    } else {
                        self.skip_to(1, b"@");
                    }
                    line += self.lines(start);
                    may_be_value = false;
                }
                b'<' => {
                    self.skip_to(1, b">");
                    line += self.lines(start);
                    if matches!(values, Some((Kind::Text, ..))) {
                        self.path_as_text(start);
                    }
                    may_be_value = false;
                }
                b'(' | b'[' | b'{' => {
                    // Round brackets after the value hold metadata.
                    if byte == b'(' && values.is_some_and(|(_, base, met)| met && depth <= base) {
                        values = None;
                    }
                    depth += 1;
                    open.push(byte);
                    if depth > MOST_DEEP {
                        return Err(format!("line {line}: brackets nested more than {MOST_DEEP} deep"));
                    }
                    self.at += 1;
                    may_be_value = true;
                    if values.is_none() && byte != b'[' {
                        declared = None;
                    }
                    continue; // a value that spans lines has not been met before its bracket closes
                }
                b')' | b']' | b'}' => {
                    depth = depth.saturating_sub(1);
                    open.pop();
                    self.at += 1;
                    may_be_value = false;
                    if values.is_some_and(|(_, base, _)| depth < base) {
                        values = None;
                    }
                    if values.is_none() && byte != b']' {
                        declared = None;
                        continue;
                    }
                }
                b'=' | b',' | b':' => {
                    self.at += 1;
                    may_be_value = true;
                    if byte == b'=' {
                        values = declared.take().map(|kind| (kind, depth, false));
                    }
                    continue;
                }
                b'0'..=b'9' | b'.' | b'-' | b'+' => {
                    self.number(values.map(|(kind, ..)| kind));
                    may_be_value = false;
                }
                _ if byte.is_ascii_alphabetic() || byte == b'_' || byte >= 0x80 => {
                    self.word();
                    let word = self.bytes.get(start..self.at).unwrap_or_default();
                    if values.is_none() && declared.is_none() && word == b"config" && self.is_word_next() {
                        self.replace(start, b"");
                        continue;
                    }
                    if values.is_none() {
                        let field = if open.last() == Some(&b'(') { flag(word) } else { None };
                        declared = field.or(kind(word)).or(declared).filter(|_| !word.ends_with(b".connect"));
                    }
                    let in_bool = matches!(values, Some((Kind::Bool | Kind::Flag, ..)));
                    // Outside declared booleans only what is no other word of the language.
                    if may_be_value && (in_bool || matches!(word, b"True" | b"False" | b"TRUE" | b"FALSE")) {
                        self.boolean(start, word.to_vec());
                    }
                    may_be_value = false;
                }
                _ => {
                    self.at += 1;
                    may_be_value = false;
                }
            }
            if let Some((_, _, met)) = &mut values {
                *met = true;
            }
        }
        Ok(())
    }

    /// Line ends since `start`.
    fn lines(&self, start: usize) -> usize {
        self.bytes.get(start..self.at).unwrap_or_default().iter().filter(|&&byte| byte == b'\n').count()
    }
    fn skip_line(&mut self) {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        self.at += rest.iter().position(|&byte| byte == b'\n').unwrap_or(rest.len());
    }
    /// Over an opening of `open` bytes and past the next `end`.
    fn skip_to(&mut self, open: usize, end: &[u8]) {
        let from = self.at + open;
        let rest = self.bytes.get(from..).unwrap_or_default();
        let found = rest.windows(end.len()).position(|window| window == end);
        self.at = from + found.map_or(rest.len(), |found| found + end.len());
    }
    fn word(&mut self) {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let inside = |&byte: &u8| byte.is_ascii_alphanumeric() || byte == b'_' || byte >= 0x80;
        let mut length = 0;
        loop {
            length += rest.get(length..).unwrap_or_default().iter().take_while(|byte| inside(byte)).count();
            // Names with namespaces and fields are one word; a colon before a value is not part of one.
            let joins = matches!(rest.get(length), Some(b':' | b'.')) && rest.get(length + 1).is_some_and(inside);
            if !joins {
                break;
            }
            length += 1;
        }
        self.at += length;
    }

    /// Over a quoted text; what is between the quotes.
    fn text(&mut self, quote: u8) -> Vec<u8> {
        let start = self.at;
        let triple = self.bytes.get(start..start + 3) == Some(&[quote; 3]);
        let open = if triple { 3 } else { 1 };
        let mut at = start + open;
        while let Some(&byte) = self.bytes.get(at) {
            match byte {
                b'\\' => at += 2,
                b'\n' if !triple => break,
                _ if byte == quote && (!triple || self.bytes.get(at..at + 3) == Some(&[quote; 3])) => {
                    self.at = at + open;
                    return self.bytes.get(start + open..at).unwrap_or_default().to_vec();
                }
                _ => at += 1,
            }
        }
        self.at = at.min(self.bytes.len());
        Vec::new()
    }

    fn replace(&mut self, start: usize, by: &[u8]) {
        self.out.extend_from_slice(self.bytes.get(self.copied..start).unwrap_or_default());
        self.out.extend_from_slice(by);
        self.copied = self.at;
    }

    /// A quoted path between signs, which know no escapes.
    fn asset(&mut self, start: usize, text: Vec<u8>) {
        let mut plain = Vec::with_capacity(text.len());
        let mut rest = text.iter();
        while let Some(&byte) = rest.next() {
            let byte = if byte == b'\\' { rest.next().copied().unwrap_or(byte) } else { byte };
            plain.push(byte);
        }
        // `\n`, `\x41` and the like have no place in paths; `\\`, `\"` and `\'` have.
        let is_plain = text.windows(2).all(|pair| pair.first() != Some(&b'\\') || !is_code(pair.get(1)));
        if !is_plain || plain.contains(&b'\n') || plain.windows(3).any(|three| three == b"@@@") {
            return;
        }
        let signs: &[u8] = if plain.contains(&b'@') { b"@@@" } else { b"@" };
        // A path that ends with a sign would be one with what closes it.
        if plain.last() != Some(&b'@') {
            self.replace(start, &[signs, plain.as_slice(), signs].concat());
        }
    }

    /// In a text of three quotes the parser takes an escaped quote for the end if two others follow: quotes by number.
    fn quotes(&mut self, start: usize, quote: u8) {
        let text = self.bytes.get(start..self.at).unwrap_or_default();
        let escaped = |pair: &[u8]| pair == [b'\\', quote];
        if !text.starts_with(&[quote; 3]) || text.len() < 6 || !text.windows(2).any(escaped) {
            return;
        }
        let mut plain = Vec::with_capacity(text.len() + 8);
        let mut rest = text.iter();
        while let Some(&byte) = rest.next() {
            match (byte, rest.as_slice().first()) {
                (b'\\', Some(&next)) => {
                    rest.next();
                    if next == quote {
                        plain.extend_from_slice(format!("\\x{quote:02x}").as_bytes());
                    } else {
                        plain.extend_from_slice(&[byte, next]);
                    }
                }
                (_, Some(_) | None) => plain.push(byte),
            }
        }
        self.replace(start, &plain);
    }

    /// Over a path of three signs. `\@@@` in it stands for three signs.
    fn path_of_three_signs(&mut self) {
        let start = self.at;
        let mut plain: Vec<u8> = b"@@@".to_vec();
        self.at += 3;
        let mut is_escaped = false;
        while let Some(&byte) = self.bytes.get(self.at) {
            let rest = self.bytes.get(self.at..).unwrap_or_default();
            if rest.starts_with(b"\\@@@") {
                plain.extend_from_slice(SIGNS.encode_utf8(&mut [0; 4]).as_bytes());
                (self.at, is_escaped) = (self.at + 4, true);
            } else if rest.starts_with(b"@@@") {
                self.at += 3;
                if is_escaped {
                    plain.extend_from_slice(b"@@@");
                    self.replace(start, &plain);
                }
                return;
            } else {
                plain.push(byte);
                self.at += 1;
            }
        }
    }

    /// A path in the place of a text.
    fn path_as_text(&mut self, start: usize) {
        let inside = self.bytes.get(start + 1..self.at.saturating_sub(1)).unwrap_or_default().to_vec();
        if !inside.iter().any(|byte| matches!(byte, b'"' | b'\\' | b'\n')) {
            self.replace(start, &[b"\"", inside.as_slice(), b"\""].concat());
        }
    }

    /// Whether a word follows.
    fn is_word_next(&self) -> bool {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        rest.iter().find(|byte| !matches!(byte, b' ' | b'\t')).is_some_and(u8::is_ascii_alphabetic)
    }

    fn boolean(&mut self, start: usize, word: Vec<u8>) {
        let said: &[u8] = match word.to_ascii_lowercase().as_slice() {
            b"true" | b"yes" | b"on" => b"true",
            b"false" | b"no" | b"off" => b"false",
            _ => return,
        };
        if self.bytes.get(start..self.at) != Some(said) {
            self.replace(start, said);
        }
    }

    /// Over a number, which is rewritten if the parser would not take it.
    fn number(&mut self, kind: Option<Kind>) {
        let start = self.at;
        let get = |at: usize| self.bytes.get(at).copied().unwrap_or(b' ');
        let digits = |mut at: usize| {
            while get(at).is_ascii_digit() {
                at += 1;
            }
            at
        };
        let first = start + usize::from(matches!(get(start), b'-' | b'+'));
        let whole = digits(first);
        let has_dot = get(whole) == b'.';
        let fraction = if has_dot { digits(whole + 1) } else { whole };
        let fraction_digits = fraction.saturating_sub(whole + 1);
        if whole == first && fraction_digits == 0 {
            self.at = start + 1; // a sign or a dot alone
            return;
        }
        let mut end = fraction;
        if matches!(get(end), b'e' | b'E') {
            let sign = end + 1 + usize::from(matches!(get(end + 1), b'-' | b'+'));
            if get(sign).is_ascii_digit() {
                end = digits(sign);
            }
        }
        // `1_name` and the like are not ours to judge.
        if get(end).is_ascii_alphabetic() || get(end) == b'_' {
            self.at = end;
            return;
        }
        self.at = end;
        let is_plain = !has_dot && end == whole;
        let text = std::str::from_utf8(self.bytes.get(start..end).unwrap_or_default()).unwrap_or_default();
        match kind {
            // The time of a sample is no value.
            Some(Kind::Integer) if !is_plain && !self.is_time() => {
                if let Some(number) = text.parse::<f64>().ok().filter(|x| x.abs() < 1e18) {
                    self.replace(start, format!("{}", number.trunc() as i64).as_bytes());
                    return;
                }
            }
            Some(own @ (Kind::Bool | Kind::Flag))
                if !self.is_time() && (own == Kind::Flag || !matches!(text, "0" | "1")) =>
            {
                if let Ok(number) = text.parse::<f64>() {
                    self.replace(start, if number == 0.0 { b"false" } else { b"true" });
                    return;
                }
            }
            Some(Kind::Integer | Kind::Bool | Kind::Flag | Kind::Asset | Kind::Text) | None => {}
        }
        if has_dot && (whole == first || fraction_digits == 0) {
            let part = |range: std::ops::Range<usize>| self.bytes.get(range).unwrap_or_default();
            let zero = |empty: bool| if empty { &b"0"[..] } else { &b""[..] };
            let new = [
                part(start..whole),
                zero(whole == first),
                b".",
                part(whole + 1..fraction),
                zero(fraction_digits == 0),
                part(fraction..end),
            ]
            .concat();
            self.replace(start, &new);
        }
    }

    /// Whether a colon follows.
    fn is_time(&self) -> bool {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        rest.iter().find(|byte| !byte.is_ascii_whitespace()) == Some(&b':')
    }
}

/// Whether a letter after a backslash makes it another character than itself (`TfEscapeString` of OpenUSD).
fn is_code(letter: Option<&u8>) -> bool {
    letter.is_some_and(|letter| matches!(letter, b'a' | b'b' | b'f' | b'n' | b'r' | b't' | b'v' | b'x' | b'0'..=b'7'))
}
