//! Numbers of this room that no formula gives, file by file. The commits that are named chose them: their messages tell on
//! which scenes, and what was measured.

/// `data.rs`
/// - `FAR_M`, `SIDE`: `8fef686` (Estimators, plan and EXR)
/// - `MOSTLY`: `9264798` (An asset looks as its materials say)
/// - `BAND`: `f099d89` (A pixel takes 240 bytes, not 1200)
/// - `FEW`: `1cb92fb` (Parts found through the wide tree)
/// - `ALIKE`: `be4eada` (Photons of two radii that know where faces end)
pub(super) mod data {
    /// Depth written where nothing is hit, m: what compositing programs take for the background.
    pub const FAR_M: f64 = 1e10;
    /// An ordinary material is there where it hides at least this share of what is behind it.
    pub const MOSTLY: f64 = 0.5;
    /// So many rows are looked at together.
    pub const BAND: usize = 32;
    /// The see-through share is looked for in so many rows and columns of a pixel,
    pub const SIDE: usize = 4;
    /// or only in these four of its places, of which no two share a row or a column,
    pub const FEW: [usize; 4] = [1, 7, 8, 14];
    /// where the shares differ by no more than this of the largest and the same surfaces are seen: what is linear in place
    /// and pupil is exact with four.
    pub const ALIKE: f64 = 0.05;
}

/// `diffraction_event.rs`
/// - `edd5144` (Rays to lamps follow every order of a grating)
pub(super) mod diffraction_event {
    /// A path is split into orders where no more than this of what arrives goes on: more makes branches without an end.
    pub const MOST_MORE: f64 = 1.5;
}

/// `forward.rs`
/// - `8fef686` (Estimators, plan and EXR)
pub(super) mod forward {
    /// A lamp path is split where reflection and transmission both carry this share: at combiners, not at lenses.
    pub const SPLIT_FROM: f64 = 0.1;
    /// Behind such a face the ghost from the next one counts too.
    pub const SPLIT_AGAIN_FROM: f64 = 0.005;
}

/// `outliers.rs`
/// - `TOGETHER`, `SIGMA`: `55c9cd2` (Shards, merge, checkpoints, jobs)
/// - `OF_MAPS`: `9118adb` (Merge: finer maps that come late are no outlier)
pub(super) mod outliers {
    /// Errors of near pixels may go together (photons are gathered over many), which their own variances do not tell: the
    /// root of how many do at most.
    pub const TOGETHER: f64 = 25.0;
    /// Deviations beyond this many standard errors are told.
    pub const SIGMA: f64 = 8.0;
    /// What maps of lit faces may err by, as a share of the light: later passes have finer ones.
    pub const OF_MAPS: f64 = 1e-3;
}

/// `series.rs`
/// - `RAYS`, `PATHS`: `e11f3dc` (Light through two slides in series is rebuilt at any contrasts of both)
pub(super) mod series {
    /// Paths from the eye: slides in series that fill a hundredth of the picture are hardly ever missed.
    pub const RAYS: u64 = 1 << 10;
    /// Paths from all lamps.
    pub const PATHS: u64 = 1 << 10;
}

/// `shard.rs`
/// - `0009a8a` (Shards and checkpoints, read once more)
pub(super) mod shard {
    /// More passes than any run makes.
    pub const MOST_PASSES: u64 = 1 << 53;
}

/// `vision/over_pixel.rs`
/// - `CLOSE`, `MOST_TRAINS`, `PASSES_LOOKED_AT`, `RAYS_TO_CUT`: `edd5144` (Rays to lamps follow every order of a grating)
/// - the others: `01a9142` (Pictures that rays from the eye see are cut by the footprint of each pixel over film and pupil)
pub(super) mod over_pixel {
    /// Where in a pixel, from its middle, and in the pupil, in radii, the five paths start by which all of both is known: the
    /// corners of a simplex,
    pub const STARTS: [[f64; 4]; 5] = [
        [0.4, 0.4, 0.55, -0.2],
        [0.4, -0.4, -0.55, -0.2],
        [-0.4, 0.4, -0.55, -0.2],
        [-0.4, -0.4, 0.55, -0.2],
        [0.0, 0.0, 0.0, 0.6],
    ];
    /// or of one of so much of its size about a corner, where others see less: by so many trains of faces at most.
    pub const CLOSE: f64 = 0.2;
    pub const MOST_TRAINS: usize = 8;
    /// Where wavelengths change edges are looked for at those of so many passes, a power of two.
    pub const PASSES_LOOKED_AT: u64 = 4;
    /// Blocks of so many by so many pixels, and so much more, are looked at for edges of pictures.
    pub const BLOCK: usize = 2;
    pub const WIDER: f64 = 1.1;
    /// Places of a pixel, from its middle, and of the pupil, in radii, where footprints are tried.
    pub const TRIALS: [[f64; 4]; 8] = [
        [-0.375, -0.125, 0.2, 0.8],
        [-0.125, 0.375, -0.8, 0.2],
        [0.125, -0.375, 0.4, -0.4],
        [0.375, 0.125, -0.2, -0.8],
        [-0.46, 0.47, 0.8, -0.2],
        [0.47, 0.46, -0.4, 0.5],
        [0.46, -0.47, 0.5, 0.4],
        [-0.47, -0.46, -0.5, -0.5],
    ];
    /// They are used where they err by no more than this of the variance of paths alone,
    pub const WORTH: f64 = 0.5;
    /// or by this share of what is seen.
    pub const RIGHT: f64 = 1e-2;
    /// Pairs of places of the pupil by which a pass knows the mean over all of it: so many for each pixel by which a picture moves
    /// from the middle to the rim, and at most.
    pub const PER_PIXEL: f64 = 128.0;
    pub const MOST_PAIRS: f64 = 64.0;
    /// And no more than would take as long as so many rays.
    pub const RAYS_TO_CUT: u64 = 8;
    /// So many pieces of pictures are cut for a pixel and pass, about, once across and once for each pair; where one place alone
    /// takes more, none.
    pub const CUTS: u64 = 256;
}

/// `vision.rs`
/// - `PATHS`, `SPLIT_FROM`: `2cd4f12` (Backward: what lamps show through specular faces gets its own evenly spread, split
///   paths)
/// - `PATHS_OF_A_GLINT`, `MOST_PIXELS`: `465a217` (Pinholes: the places where lamps are seen over specular faces are solved
///   for)
/// - `LARGE`: `a605e5f` (Sound shards are told apart from wrong ones by passes that know their error)
/// - `MOST_GLINTS`: `262b087` (What a fresh reader found in the glints)
/// - `WORTH`: `edd5144` (Rays to lamps follow every order of a grating)
pub(super) mod vision {
    /// Paths per pixel and pass, and those about each image of a lamp in the pixel.
    pub const PATHS: u64 = 4;
    pub const PATHS_OF_A_GLINT: u64 = 64;
    /// These are fewer where there are many images, but no fewer than this.
    pub const FEWEST_OF_A_GLINT: u64 = 8;
    /// Glints of more than so many pixels' area are left to the paths of each: there are pixels in the midst of such an image, which
    /// are exact without points about it.
    pub const LARGE: f64 = 4.0;
    /// And those that reach over more pixels than this.
    pub const MOST_PIXELS: usize = 1 << 12;
    /// Of more in a pixel the others are left to these points: work goes with their square.
    pub const MOST_GLINTS: usize = 32;
    /// A path is split where both ways on carry at least this share of what it started with; else chance decides.
    pub const SPLIT_FROM: f64 = 1.0 / 256.0;
    /// Roulette asks of long paths below this share.
    pub const WORTH: f64 = 1.0 / 16.0;
}

/// `walk.rs`
/// - `8fef686` (Estimators, plan and EXR)
pub(super) mod walk {
    /// Paths from the eye are split at the first interfaces they meet: at both faces of a combiner, so that the image from
    /// its front and the ghost from its back are always both there.
    pub const SPLIT_FIRST_EVENTS: u32 = 2;
}

/// `window_visibility.rs`
/// - `abfe65d` (Backward: directions to the sky are followed through panes)
pub(super) mod window_visibility {
    /// Faces that a chosen direction is followed through.
    pub const MOST_FACES: u32 = 8;
}

/// `witness.rs`
/// - `SHARE`, `SELDOM`, `TRIED`, `CHUNK`, `MOST_TIMES`, `BEFORE`: `571fd77` (A witness beside every render)
/// - `PHOTONS`, `ROUNDS`, `ENOUGH`: `63d295f` (A witness has as many photons as it takes to tell where light comes from)
pub(super) mod witness {
    /// Counted work of the looks over that of the passes: below a twentieth, for what a look costs is known by a few of them.
    pub const SHARE: f64 = 0.042;
    /// How many times less often than by chance a guided path goes anywhere, at most: `film::guide` and `glow` keep shares for it.
    pub const SELDOM: f64 = 8.0;
    /// Looks that tell what one costs.
    pub const TRIED: u64 = 64;
    /// Photons that tell where light comes from are traced so many at a time, until so many have landed.
    pub const PHOTONS: u64 = 1 << 10;
    pub const ROUNDS: u64 = 8;
    pub const ENOUGH: usize = 1 << 10;
    /// Looks of a chunk: they share wavelengths.
    pub const CHUNK: u64 = 4;
    /// Times that a pass looks at a pixel, at most.
    pub const MOST_TIMES: u64 = 64;
    /// Of light that is followed from the lamps: the share of the work where nobody else looks, and where others do; the paths of a sample;
    /// samples that tell what one costs, and a pass's most; faces that a path which is aimed at the pupil may meet.
    pub const SHARE_OF_SENT: [f64; 2] = [0.02, 0.006];
    pub const PATHS: u64 = 256;
    pub const TRIED_SAMPLES: u64 = 4;
    pub const MOST_SAMPLES: u64 = 64;
    pub const MOST_FACES: usize = 32;
    /// A pass of no run: that of the looks that tell the cost.
    pub const BEFORE: u64 = u64::MAX / 2;
}
