//! Progress for people: a bar with rate, ETA and the current error on a terminal, heartbeat lines in a pipe.

use crate::estimate::run::{Films, Limits, Observer, Status};
use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Ctrl-C, SIGTERM and SIGHUP: the first asks the run to end after the current block, the second ends the process at once.
#[derive(Clone)]
pub struct Signals(Arc<AtomicUsize>);

impl Signals {
    pub fn install() -> Self {
        use signal_hook::consts::{SIGINT, SIGTERM};
        let caught = Arc::new(AtomicUsize::new(0));
        for signal in [SIGINT, SIGTERM].into_iter().chain(hang_up()) {
            // Registering fails only where the system has no such signal; then it can't arrive either.
            let armed = Arc::new(std::sync::atomic::AtomicBool::new(false));
            let _ = signal_hook::flag::register_conditional_shutdown(signal, 128 + signal, Arc::clone(&armed));
            let _ = signal_hook::flag::register(signal, armed);
            let _ = signal_hook::flag::register_usize(signal, Arc::clone(&caught), signal as usize);
        }
        Signals(caught)
    }

    /// The signal that came, if any.
    pub fn caught(&self) -> Option<usize> {
        match self.0.load(Ordering::SeqCst) {
            0 => None,
            signal => Some(signal),
        }
    }
}

impl Signals {
    /// 128 + the number of the signal that came, as shells report it.
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(self.caught().and_then(|signal| u8::try_from(128 + signal).ok()).unwrap_or(2))
    }
}

/// The signal of a terminal that is gone, unless whoever started the program had it ignored: `nohup` runs go on.
#[cfg(unix)]
fn hang_up() -> Option<i32> {
    use signal_hook::consts::SIGHUP;
    unsafe extern "C" {
        /// signal(2) of the C library that `std` is linked to; SIG_IGN asks for no handler.
        safe fn signal(number: i32, handler: usize) -> usize;
    }
    /// SIG_IGN of <signal.h>, the same on all Unix systems.
    const IGNORED: usize = 1;
    // It says what held before only while it sets something. Until the handler is there nothing would be written anyway.
    (signal(SIGHUP, IGNORED) != IGNORED).then_some(SIGHUP)
}

#[cfg(not(unix))]
fn hang_up() -> Option<i32> {
    None
}

/// Who reads the progress.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum ProgressArg {
    /// People: a bar on a terminal, a line every ten seconds in a pipe.
    #[default]
    Auto,
    /// Open Job Description: `openjd_progress` in percent and `openjd_status`.
    Openjd,
}

/// Shows a run's progress and stops it on a signal.
pub struct Progress {
    bar: Option<ProgressBar>,
    heartbeat: Option<Duration>,
    last: Instant,
    limits: Limits,
    signals: Signals,
    reader: ProgressArg,
    /// The stated error after 2, 4, 8, … passes. A block ends at each of these, so this depends on no clock.
    errors: Vec<(u64, f64)>,
}

impl Progress {
    /// `quiet`: nothing is shown.
    pub fn new(limits: &Limits, (quiet, reader): (bool, ProgressArg), signals: Signals) -> Self {
        let terminal = std::io::stderr().is_terminal() && reader == ProgressArg::Auto;
        let bar = (!quiet && terminal).then(|| {
            let bar = ProgressBar::with_draw_target(Some(1000), ProgressDrawTarget::stderr());
            if let Ok(style) = ProgressStyle::with_template("{bar:32} {msg}") {
                bar.set_style(style.progress_chars("█▉▊▋▌▍▎▏ "));
            }
            bar
        });
        let heartbeat = (!quiet && !terminal).then_some(match reader {
            ProgressArg::Auto => Duration::from_secs(10),
            ProgressArg::Openjd => Duration::from_secs(1),
        });
        let (limits, last) = (limits.clone(), Instant::now());
        Progress { bar, heartbeat, last, limits, signals, reader, errors: Vec::new() }
    }

    /// Passes and stated relative error, for the header of the EXR.
    pub fn errors(&self) -> &[(u64, f64)] {
        &self.errors
    }

    pub fn finish(&self) {
        if self.heartbeat.is_some() && self.reader == ProgressArg::Openjd {
            // Short runs have said nothing yet.
            tell!("openjd_progress: 100.0");
        }
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }

    /// Share of the run that is done by the limit that will be reached first, 0–1.
    fn share(&self, status: &Status) -> f64 {
        let passes = self.limits.passes.map(|limit| status.passes as f64 / limit.max(1) as f64);
        let time = self.limits.time.map(|limit| status.elapsed.as_secs_f64() / limit.as_secs_f64().max(1e-9));
        // Noise falls as one over the root of the work; what photons blur falls more slowly.
        let error = match (self.limits.error, status.error) {
            (Some(limit), Some(error)) if error > 0.0 => Some((limit / error).powi(2)),
            _ => None,
        };
        [passes, time, error].into_iter().flatten().fold(0.0, f64::max).min(1.0)
    }

    fn line(&self, status: &Status) -> String {
        let seconds = status.elapsed.as_secs_f64();
        let share = self.share(status);
        let rate = status.paths as f64 / seconds.max(1e-9) / 1e6;
        let error = status.error.map_or(String::new(), |e| format!(", error {:.2} %", 100.0 * e));
        let eta = if share > 0.0 && share < 1.0 {
            format!(", {:.0} s left", seconds * (1.0 - share) / share)
        } else {
            String::new()
        };
        format!("pass {}, {:.0} %, {rate:.2} Mpaths/s{error}{eta}", status.passes, 100.0 * share)
    }
}

impl Observer for Progress {
    fn block(&mut self, status: &Status, _: &Films) -> bool {
        if status.doubled {
            self.errors.extend(status.error.map(|error| (status.passes, error)));
        }
        if let Some(bar) = &self.bar {
            bar.set_position((1000.0 * self.share(status)) as u64);
            bar.set_message(self.line(status));
        } else if let Some(every) = self.heartbeat
            && self.last.elapsed() >= every
        {
            self.last = Instant::now();
            match self.reader {
                ProgressArg::Auto => tell!("eyebox: {}", self.line(status)),
                ProgressArg::Openjd => {
                    // The engine reads both streams of a task; standard output is the summary's.
                    tell!("openjd_progress: {:.1}", 100.0 * self.share(status));
                    tell!("openjd_status: {}", self.line(status));
                }
            }
        }
        self.signals.caught().is_none()
    }
}
