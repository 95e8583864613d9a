//! Two references that share no randomness, with each other or with what they judge.

use super::cells::Batches;
use super::error::References;
use super::picture::Picture;
use super::race::Ready;
use super::{ReferenceFacts, name};
use crate::clock::cpu_seconds;
use eyebox_base::Result;
use eyebox_estimate::ShouldStop;
use eyebox_estimate::run::begin;
use eyebox_plan::{Choice, plan};
use std::path::PathBuf;

/// How references are made.
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// Two EXR files in linear Rec.709.
    Files([PathBuf; 2]),
    /// Traced here, with seeds that no contender has, until either limit is reached.
    Traced { choice: Choice, passes: Option<u64>, seconds: f64 },
}

/// What sets the references' seeds apart from the contenders' (any bits would do).
const APART: [u64; 2] = [0x5265_6665_7265_6e31, 0x5265_6665_7265_6e32];

/// Makes the references of a scene; if `stop` says true they end after the pass at hand.
///
/// Errors: those of the files.
pub fn references(
    ready: &Ready<'_>,
    source: &Source,
    seed: u64,
    stop: &ShouldStop<'_>,
) -> Result<(References, ReferenceFacts)> {
    let start = cpu_seconds();
    let size = ready.scene().eye.resolution;
    let (pictures, from, passes) = match source {
        Source::Files([first, second]) => {
            let pictures = [Picture::of_file(first, size)?, Picture::of_file(second, size)?];
            (pictures, format!("{} and {}", first.display(), second.display()), None)
        }
        Source::Traced { choice, passes, seconds } => {
            let plan = plan(&ready.checked, &ready.world, *choice);
            let groups = ready.scene().groups.len();
            let trace = |apart: u64| {
                let start = cpu_seconds();
                let mut tracing = begin(&ready.world, &plan, groups, size, seed ^ apart);
                let mut batches = Batches::default();
                while !tracing.films().films.is_empty() {
                    tracing.step(1);
                    if tracing.films().passes == batches.next() {
                        Picture::of_batches(tracing.films(), size, &mut batches);
                    }
                    let enough = passes.is_some_and(|most| tracing.films().passes >= most);
                    if enough || cpu_seconds() - start >= *seconds || stop() {
                        break;
                    }
                }
                (Picture::of_batches(tracing.films(), size, &mut batches), tracing.films().passes)
            };
            let [(first, n1), (second, n2)] = APART.map(trace);
            ([first, second], name(*choice).to_owned(), Some([n1, n2]))
        }
    };
    let [first, second] = pictures;
    let references = References::new(first, second);
    let facts = ReferenceFacts {
        from,
        passes,
        seconds: cpu_seconds() - start,
        mean: references.mean(),
        noise: references.noise(),
        resolution: references.resolution(),
        flat_pixels: references.flat_pixels(),
        known_blocks: references.known_blocks(),
        most_sigma: references.most_sigma(),
    };
    Ok((references, facts))
}
