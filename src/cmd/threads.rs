//! `--threads`: the same argument and the same pool for every command that traces.

use crate::base::{Error, Result, Where};
use clap::Args;

/// Stack of a worker, bytes: what the main thread mostly has, because importing may run on a worker, too.
const STACK: usize = 8 << 20;

// No doc comment: clap would take it for the description of every command that has this argument.
#[derive(Args, Debug, Clone, Default)]
pub struct Threads {
    /// Threads; all cores by default. The result is the same to the bit for any number.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

impl Threads {
    /// Faults: the system gives no such pool.
    pub fn pool(&self) -> Result<rayon::ThreadPool> {
        pool(self.threads)
    }

    /// Does `work` on these threads alone.
    pub fn within<T: Send>(&self, work: impl FnOnce() -> Result<T> + Send) -> Result<T> {
        self.pool()?.install(work)
    }
}

/// A pool of so many threads; of all cores if it is not said.
pub fn pool(threads: Option<u16>) -> Result<rayon::ThreadPool> {
    let built = rayon::ThreadPoolBuilder::new().num_threads(threads.map_or(0, usize::from)).stack_size(STACK).build();
    built.map_err(|error| Error::new(Where::Option("--threads".to_owned()), error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_runs_on_as_many_threads_as_are_asked_for() {
        for asked in [1, 3] {
            let threads = Threads { threads: Some(asked) };
            assert_eq!(threads.within(|| Ok(rayon::current_num_threads())).unwrap(), usize::from(asked));
        }
    }
}
