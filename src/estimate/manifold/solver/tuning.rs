//! Numbers of this room that no formula gives, file by file. The commits that are named chose them: their messages tell on
//! which scenes, and what was measured.

/// `grid.rs`
/// - `CELLS`: `73d3e8a` (Specular connection)
/// - `FEWEST`: `91246b4` (Connections with the eye are read from tables, which a few solutions correct)
/// - `PIXELS`: `5564627` (Light tracing for the rest of vision is as much as is left to it)
pub(super) mod grid {
    /// Most cells of the grid along the picture's longer side, and fewest. A small picture is asked less often than a fine grid
    /// of its own costs: a cell has so many of its pixels along its sides.
    pub const CELLS: usize = 24;
    pub const FEWEST: usize = 8;
    pub const PIXELS: usize = 3;
}

/// `newton.rs`
/// - `73d3e8a` (Specular connection)
pub(super) mod newton {
    /// Most steps of Newton's iteration, and most halvings of one.
    pub const STEPS: u32 = 16;
    pub const HALVINGS: u32 = 5;
}
