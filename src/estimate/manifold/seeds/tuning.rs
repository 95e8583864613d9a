//! Numbers of this room that no formula gives, file by file. The commits that are named chose them: their messages tell on
//! which scenes, and what was measured.

/// `bands.rs`
/// - `2da12d1` (Connections are solved for in twelve bands of wavelengths)
pub(super) mod bands {
    /// Bands that the range of wavelengths is parted into, with as many passes in each.
    pub const BANDS: usize = 12;
}

/// `connections.rs`
/// - `FULL`, `SELDOM`: `73d3e8a` (Specular connection)
/// - `BRIGHT`: `be3b9f6` (Faint trains without a start at a place are seen from the eye there)
pub(super) mod connections {
    /// A train with this share of its group's light is followed in every pixel and pass, a fainter one with a probability in
    /// proportion, but not less than [`SELDOM`].
    pub const FULL: f64 = 1e-4;
    pub const SELDOM: f64 = 1.0 / 32.0;
    /// Of a train with this share light tracing knows where its light comes from, and finds it where connection has no start.
    pub const BRIGHT: f64 = 1e-2;
}

/// `edge_sampling.rs`
/// - `MOST`, `USUAL`, `DARK`: `9c44ae4` (Connections at the rim of a lamp's picture)
/// - `UNSURE`: `5ae36d5` (Slivers of lamps at the rim of their pictures are looked for)
pub(super) mod edge_sampling {
    /// Most times: what the other two allow is less.
    pub const MOST: f64 = 32.0;
    /// Relative variance of a pixel that sees its lamps whole: it holds edges of the slides' pictures.
    pub const USUAL: f64 = 0.1;
    /// A pixel with less than this share of the light that is there where all lamps are seen whole is dark: its error counts by
    /// that.
    pub const DARK: f64 = 0.01;
    /// Where lamps are seen is foretold roughly: as if a pixel were so many times as wide and high, too. One that is foretold to be
    /// dark may show a sliver of a lamp, a hundred times brighter than its mean.
    pub const UNSURE: f64 = 2.0;
}

/// `extrapolate.rs`
/// - `NEIGHBOURS`: `be4eada` (Photons of two radii that know where faces end)
/// - `TRIES`, `INSIDE`, `OUTSIDE`: `64e5b90` (Connections: lamps at the picture's rim start from nearest neighbours)
pub(super) mod extrapolate {
    /// Neighbours that a lamp is started from, and how many tries each gets.
    pub const NEIGHBOURS: usize = 8;
    pub const TRIES: usize = 16;
    /// How far into the pupil a solution is tried to be brought, and how far outside one may be, in its radii.
    pub const INSIDE: f64 = 0.7;
    pub const OUTSIDE: f64 = 1.5;
}

/// `lamp_visibility.rs`
/// - `9c44ae4` (Connections at the rim of a lamp's picture)
pub(super) mod lamp_visibility {
    /// Boxes that a lamp's points are told apart by, along both of the numbers that they are drawn by. At the rim of seed 409 of
    /// `eyebox bench --generate` the variance for a place is 0.62 of that of even points, and 0.73 with 6 x 4 boxes.
    pub const BOXES: [usize; 2] = [8, 6];
    pub const ALL: usize = BOXES[0] * BOXES[1];
    /// A point that is not foretold to be seen is taken with at most this of the density of one that is; and at most so many of
    /// them, over the others.
    pub const ELSEWHERE: f64 = 0.1;
    pub const SPENT_ELSEWHERE: f64 = 0.25;
    /// How much farther than foretold light may reach, over the radius of the pupil and over the extent of what is foretold.
    pub const MARGIN: f64 = 0.02;
    /// How far from its middle a spread ends, in standard deviations: √3 for a side of the lamp or of the pixel, more for the
    /// corner of both.
    pub const ENDS: f64 = 2.8;
}

/// `mod.rs`
/// - `MOST_SHEETS`: `2da12d1` (Connections are solved for in twelve bands of wavelengths)
/// - `FAR`: `be4eada` (Photons of two radii that know where faces end)
/// - `AIMED`: `98fbeca` (Connections at the rim)
/// - `SAME`: `73d3e8a` (Specular connection)
pub(super) mod seeds {
    /// Sheets of one train and lamp; further branches stay with the estimator that owns the rest.
    pub const MOST_SHEETS: usize = 4;
    /// How far from its middle, in radii of the pupil, the solver looks for solutions.
    pub const FAR: f64 = 1.05;
    /// A train with less of its group's light than this is joined with points from all over its lamps: to look where they are seen
    /// costs more than what its part of the error is worth.
    pub const AIMED: f64 = 1e-2;
    /// Roots nearer to each other than this share of the pupil's radius are one.
    pub const SAME: f64 = 1e-6;
}
