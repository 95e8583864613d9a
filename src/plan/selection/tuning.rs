//! Numbers of this room that no formula gives, file by file. The commits that are named chose them: their messages tell on
//! which scenes, and what was measured.

/// `facts.rs`
/// - `52ac9ed` (Rooms import each other one way only, and a test sees to it)
pub(super) mod facts {
    /// Ratios of the lamps' etendue to the eye's below which each point of the picture has few ways to a lamp, and above which
    /// rays from the eye can't miss them. Between them a pilot decides.
    pub const OPEN: [f64; 2] = [8.0, 1e5];
}

/// `mod.rs`
/// - `FILLED`: `d8e222a` (Plan: lamps imaged far from the pupil are not connected untried)
/// - `SMALL`: `c7e2c79` (Who traces what facts leave open is decided by a pilot of variance and counted work)
pub(super) mod selection {
    /// How many times denser the light of a lamp may be in the pupil than if it were spread evenly, for a place in the picture, for
    /// it to fill the pupil: the lamp is imaged far from it, and rays from the eye that go its way hardly miss.
    pub const FILLED: f64 = 2.0;
    /// Lamps that fill less than this of the scene's cross-section are too small for rays from the eye, wherever they look.
    pub const SMALL: f64 = 3e-4;
}

/// `pilot_run.rs`
/// - `SIDES`, `WORK`, `TELL_EVEN`, `RUN`, `MOST_EVEN`, `MOST_WORK`, `CLEAR`, `MARGINS`: `1ca908d` (Contest: a rough picture
///   comes first, and even points count)
/// - `PASSES`: `d3eb40a` (Counted work is fitted to measured seconds)
/// - `SURE`: `e244bdf` (measure: a ghost by the least edges, in two dimensions, with an interval; a picture that repeats
///   itself is said to tell nothing)
pub(super) mod pilot_run {
    /// Longer sides of the pilot's pictures, pixels: a rough one, and a fine one for what that leaves open.
    pub const SIDES: [usize; 2] = [12, 32];
    /// Counted work after which a trial has seen enough (some 10 ms and 35 ms), and its fewest and most passes.
    pub const WORK: [u64; 2] = [1 << 18, 1 << 20];
    pub const PASSES: [u64; 2] = [2, 64];
    /// Passes from which on a second trial of as many tells what even points save; of a run for which it is taken, and most of it.
    pub const TELL_EVEN: u64 = 4;
    pub const RUN: f64 = 64.0;
    pub const MOST_EVEN: f64 = 0.125;
    /// Counted work that the fewest passes of a fine picture may be, or the rough one has to do.
    pub const MOST_WORK: f64 = 4.0 * WORK[1] as f64;
    /// How many times the variance × work has to differ in the rough picture for the fine one not to be asked.
    pub const CLEAR: f64 = 8.0;
    /// How much better a rival must be than what facts say, by a fine and by a rough picture: a pilot is not exact.
    pub const MARGINS: [f64; 2] = [1.25, 2.0];
    /// Standard errors in scattered light that rays are sure to find.
    pub const SURE: f64 = 3.0;
}

/// `verdict.rs`
/// - `4b8b162` (A plan that misses light is out whatever it costs, and what connection leaves goes to whoever reaches it)
pub(super) mod verdict {
    /// Standard errors, of either, by which a trial has to find less light than another to be taken for blind.
    pub const SIGMAS: f64 = 3.0;
    /// Share of the mean luminance that counts as full error where the picture is black, as in `eyebox bench`.
    pub const FLOOR: f64 = 0.01;
}
