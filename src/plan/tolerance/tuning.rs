//! Numbers of this room that no formula gives, file by file.

/// `mod.rs`
pub(super) mod tolerance {
    /// Draws that are made at least: fewer say nothing of percentiles.
    pub const FEWEST: usize = 16;
    /// Draws that are kept in memory at most.
    pub const MOST: usize = 1 << 20;
    /// The same, of all numbers that are drawn.
    pub const MOST_NUMBERS: usize = 1 << 27;
}

/// `apply.rs`
pub(super) mod apply {
    /// Sine of the angle to the vertical below which a face looks up or down.
    pub const UPRIGHT: f64 = 1e-3;
}

/// `table.rs`
pub(super) mod table {
    /// Parameters that are told of each figure.
    pub const OFFENDERS: usize = 3;
}
