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
/// - `LOOKS`, `LEAST`, `MOST_BRANCHES`, `FLAT`, `INSET`: `ad41c42` (eyebox scan: luminance, distortion, image distance and
///   disparity from a grid of eye positions)
/// - `MOST_FACES`: `8fef686` (Estimators, plan and EXR)
pub(super) mod subject {
    /// Rays per side of the field of view that look for the picture.
    pub const LOOKS: usize = 48;
    /// A way on is followed where it carries this share of what the ray started with.
    pub const LEAST: f64 = 1.0 / 256.0;
    /// Faces that one branch of a ray may meet.
    pub const MOST_FACES: usize = 256;
    /// Branches of one ray: between two mirrors there would be no end.
    pub const MOST_BRANCHES: usize = 64;
    /// How far from a plane the picture may be, of its size.
    pub const FLAT: f64 = 1e-4;
    /// How far inside the rim the outermost points are, of the picture's sides.
    pub const INSET: f64 = 0.005;
}

/// `ghosts.rs`
pub(super) mod ghosts {
    /// Branches of one ray: of n uncoated surfaces some n²/2 have a ten thousandth of the light, so that ninety are followed whole.
    pub const MOST_BRANCHES: usize = 4096;
    /// Trains that may be the picture's main image: those that carry most of unpolarised light.
    pub const MOST_RIVALS: usize = 4;
    /// Ways of one image that are tried: a slab of which each point of the picture is seen after another number of reflections, over
    /// this face or the next, has some dozen of them.
    pub const MOST_WAYS: usize = 64;
}
