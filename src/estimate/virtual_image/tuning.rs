//! Numbers of this room that no formula gives, file by file. The commits that are named chose them: their messages tell on
//! which scenes, and what was measured.

/// `aim.rs`
/// - `ad41c42` (eyebox scan: luminance, distortion, image distance and disparity from a grid of eye positions)
pub(super) mod aim {
    /// Least step, of the way from one eye to another, over which a direction is carried: so near to the rim of a face without an
    /// exact shape it is followed
    /// (with 16 even steps a mirror 40 mm wide ended 0.7 mm too early).
    pub const FINEST: f64 = 1.0 / (1u64 << 24) as f64;
    /// How near to its point a ray has to come, of the picture's size.
    pub const NEAR: f64 = 1e-6;
    /// The solver is told of a picture this much smaller, so that it goes on to the last digits.
    pub const FINE: f64 = 1e-3;
}

/// `image.rs`
/// - `ad41c42` (eyebox scan: luminance, distortion, image distance and disparity from a grid of eye positions)
pub(super) mod image {
    /// Fewest points for a fit of six numbers to twelve.
    pub const FEWEST: usize = 6;
}

/// `subject.rs`
/// - `LOOKS`, `FLAT`, `INSET`: `ad41c42` (eyebox scan: luminance, distortion, image distance and disparity from a grid of eye
///   positions)
pub(super) mod subject {
    /// Rays per side of the field of view that look for the picture.
    pub const LOOKS: usize = 48;
    /// Ways on are followed until all that are left carry this share of what the ray started with together. Before that each was left
    /// out that had less than it: of an expander with a fold, where each pupil has less, next to nothing was found.
    pub const LEFT_OUT: f64 = 1.0 / 256.0;
    /// Where nothing was found, until they carry this.
    pub const DEEPER: f64 = 1.0 / 65536.0;
    /// And until they carry this share of what the picture sends a ray, about: the picture may be fainter elsewhere.
    pub const MISSED: f64 = 1.0 / 64.0;
    /// At most so many are followed of one ray.
    pub const MOST_WAYS: usize = 1024;
    /// How far from a plane the picture may be, of its size.
    pub const FLAT: f64 = 1e-4;
    /// How far inside the rim the outermost points are, of the picture's sides.
    pub const INSET: f64 = 0.005;
}

/// `ways.rs`
/// - `MOST_FACES`: `8fef686` (Estimators, plan and EXR)
pub(super) mod ways {
    /// Faces that one way of a ray may meet.
    pub const MOST_FACES: usize = 256;
    /// A way that carries this share of what may still be left out waits for nobody.
    pub const SMALL: f64 = 1.0 / 64.0;
}

/// `extent.rs`
pub(super) mod extent {
    /// Where what is seen of a face comes so near to its rim, in distances between two rays that look for it, it is seen up to there.
    pub const NEAR: f64 = 2.0;
    /// Of rectangles about a face whose areas are alike to this share the one is taken that is most upright as seen: corners are known
    /// to 6e-8 of where they are.
    pub const ALIKE: f64 = 1e-5;
    /// Sides of an outline along which a rectangle may lie, the longest.
    pub const MOST_SIDES: usize = 256;
}

/// `ghosts.rs`
pub(super) mod ghosts {
    /// Ways of one ray: of n uncoated surfaces some n²/2 have a ten thousandth of the light, so that ninety are followed whole.
    pub const MOST_WAYS: usize = 4096;
    /// Trains that may be the picture's main image: those that carry most of unpolarised light.
    pub const MOST_RIVALS: usize = 4;
}
