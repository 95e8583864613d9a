//! Numbers of this room that no formula gives, file by file. The commits that are named chose them: their messages tell on
//! which scenes, and what was measured.

/// `mod.rs`
/// - `ad41c42` (eyebox scan: luminance, distortion, image distance and disparity from a grid of eye positions)
pub(super) mod scan {
    /// Most positions, and most points of the picture.
    pub const MOST_POSITIONS: usize = 4096;
    pub const MOST_POINTS: usize = 4096;
    /// Diameter that a pinhole is taken to have for distances, m.
    pub const DEFAULT_PUPIL_M: f64 = 0.004;
}
