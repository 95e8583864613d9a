//! Numbers of this room that no formula gives, file by file. The commits that are named chose them: their messages tell on
//! which scenes, and what was measured.

/// `glow.rs`
/// - `LEAF`, `GUIDED`, `BY_LIGHT`, `LEAST_COS`, `RIDGE`, `WIDER`, `WIDEST`: `571fd77` (A witness beside every render)
/// - `FAR`, `SHARES`: `9f88c35` (A witness misses no lamp that few photons came from)
/// - `ASIDE`, `MORE`: `1cb931c` (What a fresh reader found: photons set aside by chance)
/// - `FEWEST`: `50c0f63` (Guided aperture: rays from the eye start where lamps light the pupil)
/// - `NARROWEST`: `f839364` (Energy, lights without faces, one lamp walk, standard errors per layer, traced radiometry rows)
pub(super) mod glow {
    /// Most photons of a leaf.
    pub const LEAF: usize = 32;
    /// Fewer tell nothing.
    pub const FEWEST: usize = 64;
    /// Share of the directions that photons choose.
    pub const GUIDED: f64 = 0.75;
    /// Of a photon's weight in its leaf: what it has of the light, the rest in equal shares.
    pub const BY_LIGHT: f64 = 0.5;
    /// Cosine with the mean direction below which tangents are of no use.
    pub const LEAST_COS: f64 = 0.2;
    /// Share of the places' spread that is added to it.
    pub const RIDGE: f64 = 1e-4;
    /// Half angle of a photon's cone, in median angles between nearest photons, and its narrowest and widest, rad.
    pub const WIDER: f64 = 3.0;
    pub const NARROWEST: f64 = 1e-3;
    pub const WIDEST: f64 = 1.0;
    /// Half angle of the wider cones, in those of the cones,
    pub const FAR: f64 = 4.0;
    /// and how photons' choices are shared between cones, the wider ones, and the one about all.
    pub const SHARES: [f64; 3] = [0.625, 0.25, 0.125];
    /// One photon in so many makes no cone, but tells what the cones miss: so many more than did may do so. (Of what none of n has
    /// shown it is surely, by 95 %, less than 3/n.)
    pub const ASIDE: f64 = 4.0;
    pub const MORE: f64 = 3.0;
}

/// `probe.rs`
/// - `1acf642` (Guided sky: scatterers look for daylight where it comes in)
pub(super) mod probe {
    /// Scatterers on a path that are asked: what later ones bring is little.
    pub const MOST_SCATTERED: u32 = 3;
    /// Faces on the way to them.
    pub const MOST_EVENTS: u32 = 32;
}

/// `over_sky.rs`
/// - `MOST_ALIKE`: `c4c0e05` (What a fresh reader found: errors of mixtures in colour, few pixels that tell too little)
/// - the others: `ac7065b` (Borders between the pixels of a sky's picture are cut out of what the eye's pixels see)
pub(super) mod over_sky {
    /// From the middle of a square of pixels, in its sides to the right and down, the places where four of the paths start by which it
    /// is known what all of it sees; the fifth starts in the middle.
    pub const REACH: f64 = 0.4;
    /// Where in the pupil, in radii: two to the right and two to the left of its middle, below it, and the fifth above.
    pub const UP_AND_DOWN: [f64; 4] = [0.55, -0.55, -0.2, 0.6];
    /// Places of the square and of the pupil where that is tried.
    pub const TRIALS: [[f64; 4]; 3] = [[0.48, 0.46, -0.2, 0.8], [-0.47, 0.05, -0.7, -0.6], [0.05, -0.48, 0.8, -0.1]];
    /// It holds where paths on trial see the sky no farther than this from where it says, in pixels of the eye,
    pub const TOLERANCE: f64 = 0.02;
    /// and have no more or less of its light than by this share.
    pub const STEADY: f64 = 0.05;
    /// Ways with less of the light are not followed, nor for more faces than this, all together;
    pub const LEAST: f64 = 1.0 / 256.0;
    pub const MOST_STEPS: u64 = 96;
    /// and a train with so little of the brightest one's is not what squares are parted for.
    pub const FAINT: f64 = 1.0 / 32.0;
    /// Sides of the squares that are looked at first, and of those that are not parted any more where some paths see another train.
    pub const BLOCK: usize = 8;
    pub const LEAST_PARTED: usize = 2;
    /// So many pixels of the picture are compared for a square; where it may see more they are taken for different.
    pub const MOST_ALIKE: usize = 1 << 16;
    /// Where wavelengths change those of so many passes are looked at.
    pub const PASSES_LOOKED_AT: u64 = 4;
    /// A pixel that sees more of the picture's than this is left to paths.
    pub const MOST_PIXELS: usize = 64;
    /// Pairs of places of the pupil by which a pass knows the mean over all of it: so many for each pixel by which the picture moves from
    /// the middle to the rim, and at most.
    pub const PER_PIXEL: f64 = 4.0;
    pub const MOST_PAIRS: f64 = 8.0;
}
