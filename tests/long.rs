//! All tests of the crate from outside, those that take long, too: statistics over many seeds, the generated scenes, the stress suite, figures of
//! other renderers, runs that are witnessed. `cargo verify-long` runs them, and `CONTRIBUTING.md` says when.

/// Tests that `cargo verify` leaves out.
macro_rules! long {
    ($($test:item)*) => { $($test)* };
}

include!("modules.rs");
