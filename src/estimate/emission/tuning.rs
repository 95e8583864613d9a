//! Numbers of this room that no formula gives, file by file. The commits that are named chose them: their messages tell on
//! which scenes, and what was measured.

/// `shots.rs`
/// - `8fef686` (Estimators, plan and EXR)
pub(super) mod shots {
    /// Lamp paths that one thread traces before it hands over what it found; the order of hand-overs is fixed.
    pub const CHUNK: u64 = 1 << 13;
}
