//! Numbers of this room that no formula gives, file by file. The commits that are named chose them: their messages tell on
//! which scenes, and what was measured.

/// `at_edges.rs`
/// - `POINTS`: `a0ea753` (Sixteen points of a lamp a pass)
/// - `EDGE_POINTS`, `PLACES`, `NEAREST`, `ANYWHERE`, `OF_A_CUT`: `5133a49` (Edges that connection sees)
pub(super) mod at_edges {
    /// Points of a lamp that tables are asked about in a pass where an outline hides some of them, of those that are seen; up to the
    /// square of it in all.
    pub const POINTS: u64 = 16;
    /// And where a slide's picture has an edge: a power of two, so that three of its steps reach all rows.
    pub const EDGE_POINTS: u64 = 8;
    /// At edges the solver is asked at one of so many places of a pixel, the nearer to an edge the more often: by one over the
    /// distance and this much, in pixels, and so often wherever it is, for outlines are not known as well as slides.
    pub const PLACES: usize = 64;
    pub const NEAREST: f64 = 1e-3;
    pub const ANYWHERE: f64 = 8.0;
    /// Places that take as long as a piece that is cut.
    pub const OF_A_CUT: u64 = 8;
}

/// `eye_subpath.rs`
/// - `OF_PAIR`: `063e72c` (A combiner's ghost is followed, not drawn by lot)
/// - `AT_EDGES`, `WIDER`: `398aab7` (Edges on screens are read at many places of the pupil and lamps in a pass)
/// - `PER_PIXEL`, `MOST_PAIRS`: `1df8fcb` (Edges on screens: half as many places a pass, for runs that end early)
/// - `BLOCK`: `fc84797` (Edges on screens are looked for in blocks first)
pub(super) mod eye_subpath {
    /// What each path of a pair starts with.
    pub const OF_PAIR: f64 = 0.5;
    /// Where a pixel sees an edge of a slide's picture a ray itself is followed so often at least.
    pub const AT_EDGES: f64 = 0.125;
    /// Pairs of places of the pupil and lamps by which tables tell of such a pixel in a pass: so many for each pixel by which the edge
    /// moves from their middles to their rims, and at most.
    pub const PER_PIXEL: f64 = 4.0;
    pub const MOST_PAIRS: u64 = 8;
    /// First in blocks of so many pixels along both sides.
    pub const BLOCK: usize = 4;
    /// Edges are looked for in a square so many times as wide as the pixel, besides how far they move.
    pub const WIDER: f64 = 1.25;
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
pub(super) mod vision {
    /// The sides of a pixel, within it: on the line itself rounding would say that it reaches into the next cell.
    pub const INSIDE: [f64; 2] = [1e-9, 1.0 - 1e-9];
}
