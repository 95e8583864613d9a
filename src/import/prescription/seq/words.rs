//! Commands of a sequence and the words that are in them.

use super::private::Private;
use crate::prescription::After;
use eyebox_base::error::Result;
use eyebox_base::{Error, Where};

/// Commands with their lines: comments left out, a line that ends in `&` goes on in the next, `;` parts them outside of quotes.
pub(super) fn commands(text: &str) -> Vec<(usize, String)> {
    let mut out: Vec<(usize, String)> = Vec::new();
    let (mut command, mut start) = (String::new(), 1);
    for (index, line) in text.lines().enumerate() {
        let mut quote = None;
        if command.is_empty() {
            start = index + 1;
        }
        for c in line.chars() {
            match (c, quote) {
                ('!', None) => break,
                (';', None) => {
                    out.push((start, std::mem::take(&mut command)));
                    start = index + 1;
                    continue;
                }
                ('"' | '\'', None) => quote = Some(c),
                (c, Some(open)) if c == open => quote = None,
                (_, _) => {}
            }
            command.push(c);
        }
        match command.trim_end().strip_suffix('&').map(str::to_owned) {
            Some(part) => command = part + " ",
            None => out.push((start, std::mem::take(&mut command))),
        }
    }
    out.push((start, command));
    out.retain(|(_, command)| !command.trim().is_empty());
    out
}

/// The surface that `S3`, `SO`, `SI` or `SS` (the stop is not asked) means, among so many.
pub(super) fn qualifier(word: &str, count: usize) -> Option<usize> {
    let upper = word.to_uppercase();
    match upper.strip_prefix('S')? {
        "O" | "0" => Some(0),
        "I" => count.checked_sub(1),
        number => number.parse().ok().filter(|index| *index < count),
    }
}

/// A name without its quotes.
pub(super) fn bare(word: &str) -> String {
    word.replace(['\'', '"'], "")
}

/// What a word behind a surface means: REFL, AIR, a glass with its maker, six digits and more of n and V, or both with a colon.
pub(super) fn glass(word: &str, known: &Private, at: &Where) -> Result<After> {
    let upper = bare(&word.to_uppercase());
    if let Some(own) = known.glass(&upper, at)? {
        return Ok(own);
    }
    match upper.as_str() {
        "AIR" => return Ok(After::Air),
        "REFL" => return Ok(After::Mirror),
        _ => {}
    }
    if word.starts_with(|c: char| c.is_ascii_digit()) && !word.contains(|c: char| c.is_ascii_alphabetic()) {
        // Both numbers whole, as some programs write them: 1.5168:64.17.
        if let Some((n, v)) = word.split_once(':')
            && let (Ok(n), Ok(v)) = (n.parse::<f64>(), v.parse::<f64>())
            && n >= 1.0
            && v > 0.0
        {
            return Ok(After::Model([n, v]));
        }
        let (n, v) = word.split_once('.').or_else(|| word.split_at_checked(3)).unwrap_or((word, ""));
        let digits = |text: &str, head: &str, whole: usize| {
            let (before, after) = text.split_at_checked(whole)?;
            format!("{head}{before}.{after}").parse::<f64>().ok()
        };
        return match (digits(n, "1", 0), digits(v, "", 2)) {
            (Some(n), Some(v)) if v > 0.0 => Ok(After::Model([n, v])),
            (_, _) => {
                Err(Error::new(at.clone(), format!("`{word}` is no glass")).expected("a name, or digits like 517.642"))
            }
        };
    }
    Ok(After::Glass { name: bare(word), model: None })
}
