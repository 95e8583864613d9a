//! The text of photometric files: lines of bytes in whatever encoding, and numbers with their lines.

use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Where};
use std::borrow::Cow;
use std::path::Path;

/// A file's lines. Nothing is refused here: bytes that are not UTF-8 are Latin-1, a byte-order mark is dropped, lines end
/// with CR, LF or both, and the file ends at DOS' end of file (0x1A).
pub struct Lines<'a> {
    file: &'a Path,
    text: Cow<'a, str>,
}

impl<'a> Lines<'a> {
    pub fn new(file: &'a Path, bytes: &'a [u8]) -> Self {
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let end = bytes.iter().position(|byte| *byte == 0x1a).unwrap_or(bytes.len());
        let bytes = bytes.get(..end).unwrap_or(bytes);
        let text = match std::str::from_utf8(bytes) {
            Ok(text) => Cow::Borrowed(text),
            Err(_) => Cow::Owned(bytes.iter().map(|byte| char::from(*byte)).collect()),
        };
        Lines { file, text }
    }

    /// Each line with its number from 1.
    pub fn iter(&self) -> impl Iterator<Item = (usize, &str)> + Clone {
        let mut rest: &str = &self.text;
        let mut number = 0;
        // `str::lines` does not know a lone CR.
        std::iter::from_fn(move || {
            if rest.is_empty() {
                return None;
            }
            number += 1;
            let Some(end) = rest.find(['\r', '\n']) else {
                return Some((number, std::mem::take(&mut rest)));
            };
            let (line, after) = rest.split_at(end);
            rest = after.strip_prefix("\r\n").or_else(|| after.get(1..)).unwrap_or("");
            Some((number, line))
        })
    }

    pub fn fault(&self, line: usize, what: impl Into<String>) -> Box<Error> {
        Error::new(Where::Line { file: self.file.to_owned(), line }, what).code(Code::ProfileMalformed)
    }
}

/// The most numbers that a distribution may have: far above any goniophotometer's (0.1° in both angles are 6.5 million
/// only over the whole sphere), and a bound to memory.
pub const MOST: usize = 8_000_000;

/// Numbers one after the other, separated by blanks, commas or line ends.
pub struct Numbers<'a, I: Iterator<Item = (usize, &'a str)>> {
    lines: &'a Lines<'a>,
    rest: I,
    /// Of the last number.
    line: usize,
    /// That is read.
    now: usize,
    /// What is left of that line.
    tokens: &'a str,
    /// No more than this many can follow: each takes a character and a separator.
    bound: usize,
}

impl<'a, I: Iterator<Item = (usize, &'a str)> + Clone> Numbers<'a, I> {
    /// `rest`: the lines from which numbers are read; `line` is the one before.
    pub fn new(lines: &'a Lines<'a>, rest: I, line: usize) -> Self {
        let bound = rest.clone().map(|(_, text)| text.len().div_ceil(2)).sum();
        Numbers { lines, rest, line, now: line, tokens: "", bound }
    }

    fn token(&mut self) -> Option<&'a str> {
        let blank = |c: char| c.is_whitespace() || c == ',' || c == '\0';
        loop {
            self.tokens = self.tokens.trim_start_matches(blank);
            if !self.tokens.is_empty() {
                let (token, rest) = self.tokens.split_at(self.tokens.find(blank).unwrap_or(self.tokens.len()));
                self.tokens = rest;
                self.line = self.now;
                return Some(token);
            }
            (self.now, self.tokens) = self.rest.next()?;
        }
    }

    pub fn fault(&self, what: impl Into<String>) -> Box<Error> {
        self.lines.fault(self.line, what)
    }

    /// The next number, which is `what`. Faults: the end of the file, no number, one that is not finite.
    pub fn number(&mut self, what: &str) -> Result<f64> {
        self.number_of(|| what.to_owned())
    }

    /// As [`Numbers::number`], with a name that is made only where it is needed.
    pub fn number_of(&mut self, what: impl Fn() -> String) -> Result<f64> {
        match self.token() {
            Some(token) => parse(token)
                .ok_or_else(|| self.fault(format!("{} is `{}`", what(), shown(token))).expected("a finite number")),
            None => Err(self.fault(format!("the file ends where {} should be", what())).expected("a number")),
        }
    }

    /// The line of the last number.
    pub fn line(&self) -> usize {
        self.line
    }

    /// No more numbers than this can follow.
    pub fn bound(&self) -> usize {
        self.bound.min(MOST)
    }

    /// A number above 0.
    pub fn positive(&mut self, what: &str) -> Result<f64> {
        let number = self.number(what)?;
        if number > 0.0 { Ok(number) } else { Err(self.fault(format!("{what} is {number}")).expected("a number > 0")) }
    }

    /// A whole number from `least` up, which the rest of the file can hold that many numbers of.
    pub fn count(&mut self, what: &str, least: usize) -> Result<usize> {
        let number = self.number(what)?;
        let most = self.bound();
        let whole = number as usize;
        if number.fract() == 0.0 && number >= least as f64 && whole <= most {
            return Ok(whole);
        }
        Err(self.fault(format!("{what} is {number}")).expected(format!("a whole number from {least} to {most}")))
    }

    /// `count` numbers; memory grows with what is there, not with what is said.
    pub fn list(&mut self, count: usize, what: &str) -> Result<Vec<f64>> {
        let mut list = Vec::with_capacity(count.min(1 << 12));
        for index in 0..count {
            list.push(self.number_of(|| format!("{what} {} of {count}", index + 1))?);
        }
        Ok(list)
    }

    /// `count` rising numbers within `low` … `high`.
    pub fn rising(&mut self, count: usize, what: &str, [low, high]: [f64; 2]) -> Result<Vec<f64>> {
        let mut list = Vec::with_capacity(count.min(1 << 12));
        for _ in 0..count {
            let number = self.number(what)?;
            if !(low..=high).contains(&number) {
                return Err(self.fault(format!("{what} is {number}")).expected(format!("{low} to {high} degrees")));
            }
            if let Some(last) = list.last()
                && number <= *last
            {
                return Err(self.fault(format!("{what} {number} follows {last}")).expected("rising angles"));
            }
            list.push(number);
        }
        Ok(list)
    }

    /// Nothing but blanks may follow.
    pub fn end(mut self) -> Result<()> {
        match self.token() {
            None => Ok(()),
            Some(token) => Err(self
                .fault(format!("`{}` follows the last candela value", shown(token)))
                .expected("the end of the file: the numbers of angles and of values must agree")),
        }
    }
}

/// What follows `TILT=`, in whatever case and with blanks about the sign; none on other lines.
pub fn tilt(line: &str) -> Option<&str> {
    let (name, value) = line.split_once('=')?;
    name.trim().eq_ignore_ascii_case("TILT").then(|| value.trim())
}

/// A finite number; photometric files write them in many ways, but not as `nan` or `inf`.
pub fn parse(token: &str) -> Option<f64> {
    token.parse::<f64>().ok().filter(|number| number.is_finite())
}

/// A token for a message: short, without control characters.
pub fn shown(token: &str) -> String {
    token.chars().take(24).map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect()
}
