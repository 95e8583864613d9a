//! Rows of the table as pictures: the light of chosen ways alone.

use super::chain_sampling::Directed;
use super::lamp_paths::{Split, Way};
use super::start_side::Sides;
use super::{DEEPER, How, Row, Runs, Table, find};
use eyebox_base::ids::GroupId;
use eyebox_base::{Error, Result, Where};
use eyebox_check::Checked;
use eyebox_estimate::ShouldStop;
use eyebox_world::World;

/// A picture that is asked for.
#[derive(Debug, Clone)]
pub struct Wanted {
    /// `[A-Za-z][A-Za-z0-9_]*`, the layer's name.
    pub name: String,
    /// What it holds, as the table has it.
    pub paths: Vec<String>,
    ways: Vec<(GroupId, Way)>,
    /// The least of the rows' shares.
    share: f64,
}

/// The name and what comes after it.
fn named(text: &str) -> Result<(&str, &str)> {
    let at = || Where::Option(format!("--chain {text}"));
    let Some((name, what)) = text.split_once('=') else {
        return Err(Error::new(at(), "has no `=`").expected("NAME=N or NAME=PART:HOW,…"));
    };
    let (name, what) = (name.trim(), what.trim());
    let first = name.chars().next().is_some_and(|c| c.is_ascii_alphabetic());
    if !first || !name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
        return Err(Error::new(at(), format!("`{name}` is no name of a layer")).expected("[A-Za-z][A-Za-z0-9_]*"));
    }
    if what.is_empty() || what.split(',').any(|term| term.trim().is_empty()) {
        return Err(Error::new(at(), "does not say which light").expected("NAME=N or NAME=PART:HOW,…"));
    }
    Ok((name, what))
}

/// The layer that `NAME=…` names. Faults: as [`wanted`], but for what only the table knows.
pub fn layer_name(text: &str) -> Result<&str> {
    named(text).map(|(name, _)| name)
}

/// Reads `NAME=N`, a row of the table, or `NAME=PATTERN`: all rows that have each of PART or PART:HOW, listed with commas,
/// where `*` stands for any letters. Faults: another form, a name that is none of a layer, nothing that fits.
pub fn wanted(table: &Table, text: &str) -> Result<Wanted> {
    let at = || Where::Option(format!("--chain {text}"));
    let (name, what) = named(text)?;
    let rows: Vec<&Row> = match what.parse::<usize>() {
        Ok(number) => table.rows.iter().filter(|row| row.number == number).collect(),
        Err(_) => {
            for term in what.split(',') {
                known(table, term).map_err(|fault| Box::new(Error { at: at(), ..*fault }))?;
            }
            table.rows.iter().filter(|row| what.split(',').all(|term| fits(row, term))).collect()
        }
    };
    let share = rows.iter().map(|row| row.share).fold(f64::INFINITY, f64::min);
    if rows.is_empty() {
        return Err(Error::new(at(), "no row of the path table has all of that")
            .expected(format!("1 to {}, or parts as `eyebox paths` names them", table.rows.len())));
    }
    let paths = rows.iter().map(|row| row.path.clone()).collect();
    Ok(Wanted { name: name.to_owned(), paths, ways: rows.iter().map(|row| row.of.clone()).collect(), share })
}

/// Part and, if it is said, what happens there.
fn term(text: &str) -> (&str, Option<&str>) {
    match text.rsplit_once(':') {
        Some((part, how)) => (part.trim(), Some(how.trim())),
        None => (text.trim(), None),
    }
}

const SCATTERED: &str = "scattered";

/// A misspelt part or word is said so, rather than that nothing fits.
fn known(table: &Table, text: &str) -> Result<()> {
    let (part, how) = term(text);
    let words = || How::WORDS.into_iter().chain([SCATTERED]);
    if let Some(how) = how
        && !words().any(|word| word == how)
    {
        return Err(Error::new(Where::Nowhere, format!("`{how}` is not what happens at a part"))
            .expected(words().collect::<Vec<_>>().join(", "))
            .nearest(how, words()));
    }
    let names = || table.rows.iter().flat_map(|row| row.parts.iter().map(|step| step.part.as_str()));
    if names().any(|name| matches(part, name)) {
        return Ok(());
    }
    Err(Error::new(Where::Nowhere, format!("no row of the path table has a part `{part}`")).nearest(part, names()))
}

fn fits(row: &Row, text: &str) -> bool {
    let (part, how) = term(text);
    row.parts.iter().any(|step| matches(part, &step.part) && how.is_none_or(|how| step.how == how))
}

/// Whether `*` in a pattern can be filled so that it is `name`.
fn matches(pattern: &str, name: &str) -> bool {
    let mut pieces = pattern.split('*');
    let Some(mut rest) = pieces.next().and_then(|first| name.strip_prefix(first)) else { return false };
    let mut pieces: Vec<&str> = pieces.collect();
    let Some(last) = pieces.pop() else { return rest.is_empty() };
    for piece in pieces {
        let Some(at) = rest.find(piece) else { return false };
        rest = rest.get(at + piece.len()..).unwrap_or_default();
    }
    rest.ends_with(last)
}

/// The table for a frame's header, most light first: per row its path, its share of all light, its flux into the pupil and
/// the layer that holds it (null: none).
pub fn header(table: &Table, wanted: &[Wanted]) -> serde_json::Value {
    // A header is read in one piece.
    const MOST: usize = 256;
    let row = |row: &Row| {
        let layer = wanted.iter().find(|wanted| wanted.ways.contains(&row.of)).map(|wanted| &wanted.name);
        serde_json::json!({ "name": row.path, "share": row.share, "flux_lm": row.flux_lm, "layer": layer })
    };
    table.rows.iter().take(MOST).map(row).collect()
}

/// The luminance of each wanted picture, cd/m², by pixel, from `paths` paths of their own. None if `stop` says true.
pub fn pictures(
    (checked, world): (&Checked, &World),
    table: &Table,
    wanted: &[Wanted],
    paths: u64,
    stop: &ShouldStop<'_>,
) -> Option<Vec<Vec<f32>>> {
    // Few enough that what they catch can be held.
    const PER_PASS: u64 = 1 << 13;
    // Of a chain that is faint beside others.
    const FEWEST: u64 = 64;
    let [width, height] = world.eye.size();
    let mut sums = vec![vec![0.0f64; width * height]; wanted.len()];
    let least = wanted.iter().map(|wanted| wanted.share).fold(1.0, f64::min);
    let split = Split { least: least * DEEPER };
    let sides = Sides::new(checked, world, &table.mode, (split, least), stop);
    let shown = sides.directed.chains.iter().filter(|chain| wanted.iter().any(|wanted| chain.is_of(&wanted.ways)));
    let shown: Vec<&Directed> = shown.collect();
    let all: f64 = shown.iter().map(|chain| chain.share).sum();
    let directed: Vec<(&Directed, u64)> =
        shown.into_iter().map(|chain| (chain, ((PER_PASS as f64 * chain.share / all) as u64).max(FEWEST))).collect();
    let runs = Runs { passes: paths.div_ceil(PER_PASS).max(1), per_pass: PER_PASS, split, directed: &directed };
    find(world, &sides, &table.mode, runs, stop, &mut |_, found, _| {
        for caught in found.into_iter().flatten() {
            let of = (caught.group, caught.way);
            for (wanted, sums) in wanted.iter().zip(&mut sums) {
                if wanted.ways.contains(&of)
                    && let Some(sum) = sums.get_mut(caught.pixel as usize)
                {
                    *sum += caught.luminance;
                }
            }
        }
    });
    let mean = |sums: Vec<f64>| sums.into_iter().map(|sum| (sum / runs.passes as f64) as f32).collect();
    (!stop()).then(|| sums.into_iter().map(mean).collect())
}

#[cfg(test)]
mod tests {
    use super::matches;

    #[test]
    fn stars_stand_for_any_letters() {
        for (pattern, name, want) in [
            ("LENS", "LENS", true),
            ("LENS", "LENS_01", false),
            ("LENS*", "LENS_01", true),
            ("*_01", "LENS_01", true),
            ("L*S*1", "LENS_01", true),
            ("L*S*2", "LENS_01", false),
            ("*", "", true),
            ("a*a", "a", false),
        ] {
            assert_eq!(matches(pattern, name), want, "{pattern} {name}");
        }
    }
}
