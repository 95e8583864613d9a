//! Shards: runs of disjoint ranges of passes under one plan, and the run that they are together.
//!
//! Randomness is a function of the pass, and sums are carried in two doubles ([`eyebox_base::double_double`]): shards in any
//! number and order add up to the bits of the run that made all passes itself.

use super::finishing::{Finishing, Wanted};
use super::ledger::{Books, Ledger};
use super::run::{Dealt, Films};
use super::tuning::shard::MOST_PASSES;
use eyebox_base::{Error, Result, Where};
use eyebox_film::accumulate::Film;
use eyebox_film::frame::{Channel, Frame};
use eyebox_film::plan::Estimator;
use eyebox_film::witness::Witness;
use eyebox_output::shard::{Shard, read_shard, write_shard};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// What a shard says of itself.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Head {
    /// Version of the program.
    pub eyebox: String,
    /// Hash of the scene.
    pub scene: String,
    /// Number of the scene's parts.
    pub parts: usize,
    /// The frozen plan, as `eyebox plan -o` writes it.
    pub plan: Value,
    pub plan_hash: String,
    pub seed: u64,
    /// The camera.
    pub eye: Value,
    /// I and N of `--shard I/N`; none: a checkpoint.
    pub of: Option<[u64; 2]>,
    /// Passes of all shards together; none: a checkpoint of a run without such a limit.
    pub total: Option<u64>,
    /// Number of the first pass.
    pub first: u64,
    pub passes: u64,
    pub films: Vec<(Estimator, Books)>,
    /// Pixels have passes of their own, dealt out so far.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dealt: Option<Dealt>,
    /// What a witness saw beside these passes; none: it was switched off, or there was nothing to look for.
    #[serde(default)]
    pub witness: Option<Witness>,
    pub finishing: Finishing,
}

/// Passes of shard `index` (from 1) of `count`: its first and how many.
pub fn range([index, count]: [u64; 2], total: u64) -> (u64, u64) {
    let start = |k: u64| (u128::from(total) * u128::from(k) / u128::from(count.max(1))) as u64;
    let (first, end) = (start(index.saturating_sub(1)), start(index));
    (first, end - first)
}

impl Head {
    /// With what the films have by now.
    #[must_use]
    pub fn after(&self, films: &Films) -> Head {
        let books = films.films.iter().map(|(estimator, _, ledger)| (*estimator, ledger.books())).collect();
        let witness = films.witness.clone();
        let dealt = Some(films.dealt).filter(|dealt| dealt.rounds > 0);
        Head { first: films.first, passes: films.passes, films: books, dealt, witness, ..self.clone() }
    }

    fn passes_text(&self) -> String {
        format!("passes {} to {}", self.first + 1, self.first + self.passes)
    }
}

/// Writes films under their head. `picture`: what to show of them; a frame without channels for a checkpoint.
pub fn save(path: &Path, head: &Head, films: &Films, picture: &Frame) -> Result<()> {
    let all: Vec<&Film> = films.films.iter().map(|(_, film, _)| film).collect();
    write_shard(path, &head.after(films), &all, picture)
}

/// Reads a shard or a checkpoint. Errors: those of [`read_shard`], and contents that contradict each other.
pub fn load(path: &Path) -> Result<(Head, Films, Frame)> {
    let Shard { head, films, picture } = read_shard::<Head>(path)?;
    let fault =
        |what: &str| Error::new(Where::file(path), what).expected("what `render --shard` or `--checkpoint` writes");
    let ranged = match (head.of, head.total) {
        (Some([index, count]), Some(total)) => {
            let (first, passes) = range([index, count], total);
            (1..=count).contains(&index) && head.first == first && head.passes <= passes
        }
        (_, _) => head.first == 0,
    };
    let sound = head.films.len() == films.len()
        && ranged
        && head.first.max(head.passes).max(head.total.unwrap_or(0)) < MOST_PASSES
        && films.iter().all(|film| [film.width, film.height] == head.finishing.size)
        && match head.dealt {
            None => films.iter().all(|film| film.passes == head.passes && film.sample_map().is_none()),
            Some(_) => head.of.is_none() && films.iter().map(Film::most_passes).max() == Some(head.passes),
        }
        && head.witness.as_ref().is_none_or(|witness| witness.is_sound() && witness.size == head.finishing.size)
        && films.iter().flat_map(|film| &film.planes).all(|key| key.group.index() < head.finishing.groups.len());
    if !sound || [picture.width, picture.height] != head.finishing.size {
        return Err(fault("contradicts itself: its films are not those that it tells of"));
    }
    for (film, (estimator, _)) in films.iter().zip(&head.films) {
        if let Some((table, pixel)) = film.first_invalid() {
            let what = format!("has NaN or infinite {table} of {} at pixel number {pixel}", estimator.name());
            return Err(Error::new(Where::file(path), what));
        }
    }
    let mut all = Vec::new();
    for ((estimator, books), film) in head.films.iter().zip(films) {
        let ledger = Ledger::of_books(books, head.parts).ok_or_else(|| fault("has a ledger of another scene"))?;
        all.push((*estimator, film, ledger));
    }
    let witness = head.witness.clone();
    let films =
        Films { films: all, first: head.first, passes: head.passes, dealt: head.dealt.unwrap_or_default(), witness };
    Ok((head, films, picture))
}

/// Shards as one run.
pub struct Merged {
    pub head: Head,
    pub films: Films,
    /// The picture of the first passes, for what of it is no light, and its metadata.
    pub picture: Frame,
    /// Shards whose light lies far from the others': one line each.
    pub outliers: Vec<String>,
}

/// Adds up shards in any order. `partial`: passes may be missing at the end or between. Errors, each with the name of the
/// shard: one that cannot be read or is damaged, is of another program, scene, plan, seed, eye or request, holds passes that
/// another holds too, NaN or infinite sums, or is missing.
pub fn merge(paths: &[PathBuf], partial: bool) -> Result<Merged> {
    let mut seen: Vec<(PathBuf, Head)> = Vec::new();
    let mut lights = Vec::new();
    let mut sum: Option<(Films, Frame)> = None;
    for path in paths {
        let (head, films, picture) = load(path)?;
        check(path, &head, &picture, &seen)?;
        lights.push(super::outliers::light(&films));
        sum = Some(match sum {
            None => (films, picture),
            Some((whole, shown)) => {
                same_data((path, &head.finishing.wanted), &picture, &shown)?;
                // The record of the run is that of its first passes, in whatever order they come.
                let first = seen.iter().all(|(_, other)| head.first < other.first);
                (added(path, whole, &films)?, if first { picture } else { shown })
            }
        });
        seen.push((path.clone(), head));
    }
    let Some((mut films, picture)) = sum else {
        return Err(Error::new(Where::Nowhere, "no shard was named").expected("at least one"));
    };
    if !partial {
        complete(&seen)?;
    }
    let names: Vec<&Path> = seen.iter().map(|(path, _)| path.as_path()).collect();
    let outliers = super::outliers::find(&names, &lights);
    let head = seen.swap_remove(0).1;
    films.first = 0;
    Ok(Merged { head, films, picture, outliers })
}

fn added(path: &Path, mut whole: Films, more: &Films) -> Result<Films> {
    for ((_, film, ledger), (_, other, books)) in whole.films.iter_mut().zip(&more.films) {
        if !film.merge(other) {
            return Err(Error::new(Where::file(path), "has films of another kind").expected("shards of one request"));
        }
        ledger.merge(books);
    }
    let seen = match (&mut whole.witness, &more.witness) {
        (Some(own), Some(more)) => own.merge(more),
        (None, None) => true,
        (Some(_), None) | (None, Some(_)) => false,
    };
    if !seen {
        return Err(Error::new(Where::file(path), "has another witness than the shards before it")
            .expected("shards of one request, all with `--no-witness` or none"));
    }
    whole.passes += more.passes;
    Ok(whole)
}

/// Whether a shard belongs to those before it and holds what it should.
fn check(path: &Path, head: &Head, picture: &Frame, seen: &[(PathBuf, Head)]) -> Result<()> {
    let fault = |what: String| Error::new(Where::file(path), what);
    if head.of.is_none() || head.total.is_none() || picture.channels.is_empty() {
        return Err(fault("is a checkpoint, no shard".to_owned()).expected("what `render --shard I/N` writes"));
    }
    let Some((first_path, first)) = seen.first() else { return Ok(()) };
    let estimators =
        |head: &Head| head.films.iter().map(|(estimator, _)| estimator.name()).collect::<Vec<_>>().join(", ");
    let facts = [
        ("the program's version", head.eyebox.clone(), first.eyebox.clone()),
        ("the scene", head.scene.clone(), first.scene.clone()),
        ("the plan", head.plan_hash.clone(), first.plan_hash.clone()),
        ("the seed", head.seed.to_string(), first.seed.to_string()),
        ("the eye", head.eye.to_string(), first.eye.to_string()),
        ("the number of passes", format!("{:?}", head.total), format!("{:?}", first.total)),
        ("the number of parts", head.parts.to_string(), first.parts.to_string()),
        ("the estimators", estimators(head), estimators(first)),
    ];
    for (what, own, other) in facts {
        if own != other {
            return Err(fault(format!("is of another run: {what} is {own}"))
                .expected(format!("{other}, as in {}", first_path.display())));
        }
    }
    if head.finishing != first.finishing || head.plan != first.plan {
        return Err(fault("is of another request: layers, colour space or plan differ".to_owned())
            .expected(format!("the options of {}", first_path.display())));
    }
    match seen.iter().find(|(_, other)| overlap(head, other)) {
        None => Ok(()),
        Some((other, _)) => Err(fault(format!(
            "holds {}, and {} has them or some of them already",
            head.passes_text(),
            other.display()
        ))),
    }
}

fn overlap(a: &Head, b: &Head) -> bool {
    a.first < b.first + b.passes && b.first < a.first + a.passes
}

/// Whether all passes are there.
fn complete(seen: &[(PathBuf, Head)]) -> Result<()> {
    let mut ranges: Vec<&Head> = seen.iter().map(|(_, head)| head).collect();
    ranges.sort_by_key(|head| head.first);
    let total = ranges.first().and_then(|head| head.total).unwrap_or(0);
    if ranges.iter().all(|head| head.films.is_empty()) {
        // Where nothing is lit no pass is made.
        return Ok(());
    }
    let mut next = 0;
    for head in ranges.iter().copied().filter(|head| head.passes > 0) {
        if head.first > next {
            break;
        }
        next = head.first + head.passes;
    }
    if next == total {
        return Ok(());
    }
    let end = ranges.iter().map(|head| head.first).find(|first| *first > next).unwrap_or(total);
    let counts: Vec<u64> = ranges.iter().filter_map(|head| head.of).map(|[_, count]| count).collect();
    // Shards of one job have one N; then the missing one has a name.
    let named = match counts.as_slice() {
        [count, rest @ ..] if rest.iter().all(|other| other == count) => (1..=(*count).min(1 << 20))
            .find(|index| {
                let (first, passes) = range([*index, *count], total);
                first <= next && next < first + passes
            })
            .map(|index| format!("shard {index}/{count}: ")),
        [..] => None,
    };
    let named = named.unwrap_or_default();
    let passes = if next + 1 == end { format!("pass {end}") } else { format!("passes {} to {end}", next + 1) };
    Err(Error::new(Where::Nowhere, format!("{named}{passes} of {total} missing from the shards"))
        .expected("all passes, or `--partial`"))
}

/// Layers that are no light do not depend on passes: all shards have the same.
fn same_data((path, wanted): (&Path, &Wanted), own: &Frame, other: &Frame) -> Result<()> {
    let data = |frame: &Frame| {
        let data = frame.channels.iter().filter(|channel| !wanted.is_light(channel));
        let mut channels: Vec<Channel> = data.cloned().collect();
        channels.sort_by(|a, b| a.name.cmp(&b.name));
        channels
    };
    let (own, other) = (data(own), data(other));
    let bits = |channel: &Channel| channel.data.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
    let differs = own.iter().zip(&other).find(|(a, b)| a.name != b.name || bits(a) != bits(b));
    match differs {
        None if own.len() == other.len() => Ok(()),
        None => Err(Error::new(Where::file(path), "has other layers than the shards before it")),
        Some((channel, _)) => {
            Err(Error::new(Where::file(path), format!("shows another scene: channel {} differs", channel.name)))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_cover_all_passes_once() {
        for total in [0, 1, 6, 64, 1000, u64::MAX] {
            for count in [1, 2, 7, 64, 1001] {
                let mut next = 0;
                for index in 1..=count {
                    let (first, passes) = range([index, count], total);
                    assert_eq!(first, next);
                    next += passes;
                }
                assert_eq!(next, total);
            }
        }
    }
}
