//! Numbers of this room that no formula gives, file by file. The commits that are named chose them: their messages tell on
//! which scenes, and what was measured.

/// `make.rs`
/// - `ASIDE`, `BEYOND`: `6e5a8f1` (The tables over the picture are a room)
/// - `FAR`: `91246b4` (Connections with the eye are read from tables, which a few solutions correct)
pub(super) mod make {
    /// How far from a lamp's middle tables are tried and differences taken, in radii: within a square lamp.
    pub const ASIDE: f64 = 0.6;
    /// Nodes that are added beyond a slide's edge, so that the cells across it have all sixteen.
    pub const BEYOND: usize = 2;
    /// Solutions farther than this from the pupil's middle, in radii, are of no use to a table.
    pub const FAR: f64 = 3.0;
}

/// `masks.rs`
/// - `MASKS`: `afb5450` (A lens's rim cuts a pixel's footprint too, over all of the lamp)
/// - `NEAR`: `628d031` (Borders of connected cells are not seen)
pub(super) mod masks {
    /// Most faces of a train whose outlines are kept.
    pub const MASKS: usize = 2;
    /// An outline that is so near to a pixel, in the pixel's own extent, may cut it.
    pub const NEAR: f64 = 0.25;
}

/// `trial.rs`
/// - `LEAST`, `POOR`, `SHARP`: `91246b4` (Connections with the eye are read from tables, which a few solutions correct)
/// - `RIM_PIXELS`, `RIM_ERRORS`: `2da12d1` (Connections are solved for in twelve bands of wavelengths)
/// - `PUPIL_RIM`: `64c5aba` (Bands, rims and sheets that shine from both sides have tests)
/// - `MASK_PIXELS`: `afb5450` (A lens's rim cuts a pixel's footprint too, over all of the lamp)
/// - `QUARTERS`: `6e5a8f1` (The tables over the picture are a room)
pub(super) mod trial {
    /// The difference from the solved connection is looked at with this probability where the table did well on trial (less
    /// would save little more, and make what no trial saw bright and rare),
    pub const LEAST: f64 = 1.0 / 8.0;
    /// and always where it was off by this share.
    pub const POOR: f64 = 0.01;
    /// A place on a slide that is off by a share of the slide's size counts so many times: pictures have edges.
    pub const SHARP: f64 = 100.0;
    /// So near to the rim of a slide's picture, in pixels, and in errors of the places that a trial has shown, tables are not used.
    pub const RIM_PIXELS: f64 = 0.25;
    pub const RIM_ERRORS: f64 = 4.0;
    /// The same of the pupil's rim, in its radii, at the least.
    pub const PUPIL_RIM: f64 = 0.01;
    /// So near to the outline of a face, in pixels, nodes and solver may differ on whether it is met.
    pub const MASK_PIXELS: f64 = 0.25;
    /// Where a cell at the end of the light is tried beside its middle, in cells from there.
    pub const QUARTERS: [[f64; 2]; 4] = [[-0.4, -0.4], [0.4, -0.4], [-0.4, 0.4], [0.4, 0.4]];
}
