//! Numbers of this room that no formula gives, file by file. The commits that are named chose them: their messages tell on
//! which scenes, and what was measured.

/// `run.rs`
/// - `1de0e15` (A stated error covers runs of which few pixels have most of the error)
pub(super) mod run {
    /// How much larger than `Films::relative_error` a true error may be.
    pub const LEEWAY: f64 = 1.2;
}
