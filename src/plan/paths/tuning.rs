//! Numbers of this room that no formula gives, file by file. The commits that are named chose them: their messages tell on
//! which scenes, and what was measured.

/// `chain_sampling.rs`
/// - `ebe1c22` (eyebox paths, eyebox rays, render --chain)
pub(super) mod chain_sampling {
    /// Paths that learn where the light of a chain starts: first from both sides, then by longer and longer looks from the better
    /// one, as long as there are fewer than those that measure it and they bring something: paths whose spread falls by `GAIN`,
    /// or is above `WILD` anyway.
    pub const FIRST: u64 = 512;
    pub const LONGER: [u64; 4] = [1024, 2048, 4096, 8192];
    pub const GAIN: f64 = 0.8;
    pub const WILD: f64 = 8.0;
    /// Error that the paths along a chain aim at: of a chain with this share of its group's light or more, of a fainter one more by its root.
    pub const ERROR: f64 = 0.01;
    pub const BRIGHT: f64 = 1e-4;
    /// Paths along a chain.
    pub const PATHS: [f64; 2] = [512.0, 32_768.0];
    /// The eye as the one lamp of a guide.
    pub const EYE: [f64; 1] = [1.0];
}

/// `discover.rs`
/// - `ebe1c22` (eyebox paths, eyebox rays, render --chain)
pub(super) mod discover {
    /// Paths of a look from either side, and looks.
    pub const LOOKS: u64 = 1 << 11;
    pub const LEAST_LOOKS: u64 = 4;
    pub const MOST_LOOKS: u64 = 16;
    /// There are more looks until chains with this share of the light have been found this often.
    pub const WORTH: f64 = 1e-5;
    pub const ENOUGH: usize = 32;
    /// Chains that get paths of their own, and these times lamps; the light of all others is found by the survey.
    pub const MOST: usize = 384;
    pub const MOST_STARTS: usize = 1 << 18;
    /// What is kept of the looks: chains, and starts of each. Among a hundred plates of glass there would be no end.
    pub const KEPT_CHAINS: usize = 1 << 14;
    pub const KEPT_STARTS: usize = 1 << 12;
}

/// `mod.rs`
/// - `ebe1c22` (eyebox paths, eyebox rays, render --chain)
pub(super) mod paths {
    /// Passes, over which wavelengths are spread.
    pub const PASSES: u64 = 16;
    /// Photons for each path from the eye that looks for them.
    pub const PHOTONS: u64 = 8;
    /// A path is followed both ways down to this share of what it started with, in units of the least share that is shown:
    /// the main image itself has lost light on the way.
    pub const DEEPER: f64 = 0.1;
    /// Rows that are kept apart; what comes after is one row `…` of its group.
    pub const MOST_ROWS: usize = 1 << 14;
}

/// `rays.rs`
/// - `ebe1c22` (eyebox paths, eyebox rays, render --chain)
pub(super) mod rays {
    /// Points of a path that are kept.
    pub const MOST_POINTS: usize = 512;
}

/// `scattered.rs`
/// - `8fef686` (Estimators, plan and EXR)
pub(super) mod scattered {
    /// A path that splits at combiners alone: where both ways carry this share.
    pub const SPLIT_FROM: f64 = 0.1;
}
