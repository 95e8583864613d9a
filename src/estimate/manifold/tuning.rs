//! Numbers of this room that no formula gives, file by file. The commits that are named chose them: their messages tell on
//! which scenes, and what was measured.

/// `eye_subpath.rs`
/// - `OF_PAIR`: `063e72c` (A combiner's ghost is followed, not drawn by lot)
/// - `AT_EDGES`: `e69d869` (Rays that see an edge of a slide on a screen are followed every other time)
pub(super) mod eye_subpath {
    /// What each path of a pair starts with.
    pub const OF_PAIR: f64 = 0.5;
    /// Where a pixel sees an edge of a slide's picture a ray itself is followed so often at least: it differs most from tables there.
    pub const AT_EDGES: f64 = 0.5;
}

/// `film_grid.rs`
/// - `91246b4` (Connections with the eye are read from tables, which a few solutions correct)
pub(super) mod film_grid {
    /// Most cells along the picture's longer side.
    pub const CELLS: usize = 48;
    /// A cell should have so many pixels along its sides, or the table costs more than it saves; and a table so many cells.
    pub const PIXELS: usize = 15;
    pub const FEWEST: usize = 8;
}

/// `vision.rs`
/// - `INSIDE`: `e69d869` (Rays that see an edge of a slide on a screen are followed every other time)
/// - `POINTS`: `a0ea753` (Sixteen points of a lamp a pass)
pub(super) mod vision {
    /// The sides of a pixel, within it: on the line itself rounding would say that it reaches into the next cell.
    pub const INSIDE: [f64; 2] = [1e-9, 1.0 - 1e-9];
    /// Points of a lamp that tables are asked about in a pass where what is seen of it changes much from one to the other.
    pub const POINTS: u64 = 16;
}
