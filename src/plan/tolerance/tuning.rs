//! Numbers of this room that no formula gives, file by file.

/// `mod.rs`
pub(super) mod tolerance {
    /// Draws that are made at least: fewer say nothing of percentiles.
    pub const FEWEST: usize = 16;
    /// Draws that are kept in memory at most.
    pub const MOST: usize = 1 << 20;
}

/// `table.rs`
pub(super) mod table {
    /// Parameters that are told of each figure.
    pub const OFFENDERS: usize = 3;
}
