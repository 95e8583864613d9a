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

/// `ghosts.rs`
pub(super) mod ghosts {
    /// A second image is followed where a ray from the eye carries this share over all of its train: a ten thousandth beside
    /// a white main image is below what a display's own black (1:1000 to 1:5000) shows.
    pub const LEAST: f64 = 1e-4;
    /// Second images that are looked at, those with most light.
    pub const MOST: usize = 24;
}
