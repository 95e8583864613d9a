//! Makes passes until a limit is reached.

use super::outlook::Outlook;
use super::tuning::adaptive::BASE;
use super::{Films, Limits, Observer, Outcome, Status, Stop, Tracing, begin};
use eyebox_film::plan::Plan;
use eyebox_world::World;
use std::time::Instant;

/// Traces `world` by `plan` until a limit is reached. `groups`: number of light groups; `size`: picture in pixels.
/// At least one pass is made, unless no estimator owns anything.
pub fn run(
    world: &World,
    plan: &Plan,
    groups: usize,
    size: [usize; 2],
    seed: u64,
    limits: &Limits,
    observer: &mut dyn Observer,
) -> Outcome {
    drive(begin(world, plan, groups, size, seed), limits, observer)
}

/// The same for a run that has begun, perhaps with passes behind it: `limits.passes` counts these, too.
pub fn drive(mut tracing: Box<dyn Tracing + '_>, limits: &Limits, observer: &mut dyn Observer) -> Outcome {
    let start = Instant::now();
    if tracing.films().films.is_empty() {
        // Nothing would change with time.
        return Outcome { films: tracing.into_films(), stop: Stop::Passes, elapsed: start.elapsed() };
    }
    let full = |films: &Films| limits.passes.is_some_and(|passes| films.passes >= passes);
    if full(tracing.films()) {
        return Outcome { films: tracing.into_films(), stop: Stop::Passes, elapsed: start.elapsed() };
    }
    let adaptive = limits.adaptive && limits.passes.is_none() && tracing.films().first == 0;
    if let Some(stop) = first_pass(tracing.as_mut(), (limits, adaptive), start, observer) {
        return Outcome { films: tracing.into_films(), stop, elapsed: start.elapsed() };
    }
    let (mut block, mut doubled_at, mut outlook) = (1u64, 0, Outlook::default());
    let by_error_alone = limits.time.is_none() && limits.passes.is_none();
    loop {
        let before = Instant::now();
        // Every run goes through the state behind this block, wherever clocks end others.
        let dealing = adaptive && tracing.films().passes >= BASE;
        let (count, settled) = if dealing {
            deal(tracing.as_mut(), limits.error, block)
        } else {
            step(tracing.as_mut(), limits.passes, block)
        };
        let films = tracing.films();
        let work = films.films.iter().fold(0u64, |sum, (_, _, ledger)| sum.saturating_add(ledger.work));
        let doubled = settled && (!dealing || work / 2 >= doubled_at);
        let status = Status {
            passes: films.passes,
            elapsed: start.elapsed(),
            error: films.relative_error(),
            paths: films.paths(),
            doubled,
        };
        doubled_at = if doubled { work } else { doubled_at };
        let go_on = observer.block(&status, films);
        let may_end = settled || !adaptive;
        let small = || limits.error.is_some_and(|error| films.passes >= 4 && status.error.is_some_and(|e| e <= error));
        let too_far = limits
            .error
            .filter(|_| by_error_alone && settled)
            .is_some_and(|wanted| outlook.is_too_far(work, status.error, wanted));
        let stop = if limits.passes.is_some_and(|passes| films.passes >= passes) {
            Some(Stop::Passes)
        } else if may_end && small() {
            Some(Stop::Error)
        } else if limits.time.is_some_and(|time| start.elapsed() >= time) {
            Some(Stop::Time)
        } else if !go_on {
            Some(Stop::Asked)
        } else if too_far {
            Some(Stop::TooFar)
        } else {
            None
        };
        if let Some(stop) = stop {
            return Outcome { films: tracing.into_films(), stop, elapsed: start.elapsed() };
        }
        // Blocks of about half a second, so that stopping is prompt and asking for the error costs little.
        let seconds = before.elapsed().as_secs_f64() / count as f64;
        let wanted = (0.5 / seconds.max(1e-6)) as u64;
        let rest = limits
            .time
            .map_or(u64::MAX, |time| (time.saturating_sub(start.elapsed()).as_secs_f64() / seconds.max(1e-6)) as u64);
        block = wanted.min(rest).clamp(1, block.saturating_mul(2));
    }
}

/// Makes the first pass from coarse to fine, where time may end it. Returns why the run is over, if it is.
fn first_pass(
    tracing: &mut dyn Tracing,
    (limits, adaptive): (&Limits, bool),
    start: Instant,
    observer: &mut dyn Observer,
) -> Option<Stop> {
    if !(limits.coarse && adaptive && tracing.films().passes == 0) {
        return None;
    }
    let mut part = 0;
    while tracing.sweep(part) > 0 {
        part += 1;
        let films = tracing.films();
        let status = Status { passes: 0, elapsed: start.elapsed(), error: None, paths: films.paths(), doubled: false };
        if !observer.block(&status, films) {
            return Some(Stop::Asked);
        }
        if limits.time.is_some_and(|time| start.elapsed() >= time) {
            return Some(Stop::Time);
        }
    }
    None
}

/// Makes up to `block` passes of all pixels. Returns how many, and whether so many are reached in every run.
fn step(tracing: &mut dyn Tracing, most: Option<u64>, block: u64) -> (u64, bool) {
    let passes = tracing.films().passes;
    let left = most.unwrap_or(u64::MAX).saturating_sub(passes);
    // Every power of two ends a block, so the errors there are known on any machine.
    let round = passes.saturating_add(1).checked_next_power_of_two().unwrap_or(u64::MAX) - passes;
    let count = block.min(left).min(round).max(1);
    tracing.step(count);
    (count, tracing.films().passes.is_power_of_two())
}

/// Makes up to `block` passes of pixels that are to have more. Returns how many, and whether a round of them is over.
fn deal(tracing: &mut dyn Tracing, error: Option<f64>, block: u64) -> (u64, bool) {
    if tracing.missing().is_none() {
        tracing.aim(error);
    }
    let count = tracing.missing().map_or(1, |missing| missing.min(block).max(1));
    tracing.fill(count);
    (count, tracing.missing().is_none())
}
