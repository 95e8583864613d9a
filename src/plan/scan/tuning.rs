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

/// `patch.rs`
pub(super) mod patch {
    /// Side of a patch, degrees, as `eyebox measure` has it.
    pub const SIDE_DEG: f64 = 0.5;
    /// And so many pixels at least, where the picture has room for it: its noise would be that of one or two.
    pub const FEWEST_PIXELS: f64 = 3.0;
    /// Pixels of the longer side of a film of which a picture aside fills a small part.
    pub const MOST_PIXELS: usize = 1024;
    /// But no more than this of the lesser side of what is seen: nine of them, at its sixths, do not hang over its rim.
    pub const MOST_OF_SIDE: f64 = 0.95 / 3.0;
}

/// `ghosts.rs`
pub(super) mod ghosts {
    /// A second image is followed where a ray from the eye carries this share of the main image's light over all of its train: a ten
    /// thousandth is below what a display's own black (1:1000 to 1:5000) shows.
    pub const LEAST: f64 = 1e-4;
    /// A main image that carries less of a ray is taken for one that carries this: the ways of a light guide, which has a thousandth,
    /// would have no end.
    pub const FAINT: f64 = 1.0 / 16.0;
    /// Second images that are looked at, those with most light.
    pub const MOST: usize = 24;
}

/// `edges.rs`
/// - chosen with `scan --edges`, whose commit says what they cost
pub(super) mod edges {
    /// How far out is looked, in halves of the eyebox that was asked for.
    pub const REACH: f64 = 64.0;
    /// First step out in the same halves, and how many times as far out the next place lies: a gap in what is seen that is
    /// narrower than a fifth of its distance from the middle may be stepped over.
    pub const FIRST: f64 = 1.0 / 16.0;
    pub const GROWTH: f64 = 1.2;
    /// Halvings of the stretch that holds the edge: to rounding.
    pub const HALVINGS: u32 = 52;
    /// The same for luminances, each of which is a rendering.
    pub const FIRST_LIT: f64 = 0.25;
    pub const GROWTH_LIT: f64 = 1.5;
    pub const HALVINGS_LIT: u32 = 10;
    /// Two luminances that differ by less than so many standard errors of their difference are not parted further: a line between
    /// them is known better than the next one would be.
    pub const SIGMAS: f64 = 16.0;
}

/// `charts.rs` and what is below it
/// - chosen with `report --scan`: what can be read on a page 1000 pixels wide
pub(super) mod charts {
    /// Most points over all positions: pages stay below some 10 MB.
    pub const MOST_DRAWN: usize = 16_384;
    /// Width of a panel, pixels, and of all together at most.
    pub const PANEL: f64 = 300.0;
    pub const WIDEST: f64 = 1600.0;
    /// Between panels, above them, and around what is seen (of its larger side).
    pub const GAP: f64 = 10.0;
    pub const LABEL: f64 = 18.0;
    pub const MARGIN: f64 = 0.08;
    /// Deviations are enlarged until the largest has this share of the distance between two points.
    pub const SHARE: f64 = 0.6;
    /// The longest ghost, pixels.
    pub const LONGEST: f64 = 40.0;
    /// Radius of a point, and width of a line of a ghost as bright as the image, pixels.
    pub const DOT: f64 = 4.0;
    pub const THICKEST: f64 = 2.5;
}
