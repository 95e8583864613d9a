//! Numbers of this room that no formula gives, file by file. The commits that are named chose them: their messages tell on
//! which scenes, and what was measured.

/// `chains.rs`
/// - `PATHS`, `LEAST`, `WORTH`, `SEEDS`, `MOST_SPLITS`, `SCREEN_SEEDS`: `73d3e8a` (Specular connection)
/// - `WORTH_ON_FACE`, `LEAST_ON_FACE`: `abfdbf4` (Diffuse: lens ghosts are found by photons that part, connected where they
///   matter, and seen without spikes)
pub(super) mod chains {
    pub const PATHS: u64 = 1 << 12;
    /// A path is followed both ways where each carries this share of what it started with.
    pub const LEAST: f64 = 1e-6;
    /// Trains with less of a group's light than this stay with the estimator that owns the rest.
    pub const WORTH: f64 = 1e-7;
    /// Seeds kept of a train and lamp.
    pub const SEEDS: usize = 6;
    /// Interfaces at which one path and all its branches may split.
    pub const MOST_SPLITS: u32 = 768;
    /// Trains with less of the light that a face gets from a group over specular faces are left to the photon map.
    pub const WORTH_ON_FACE: f64 = 1e-4;
    /// The same of what one path from the lamp carries, for the path to be followed both ways.
    pub const LEAST_ON_FACE: f64 = 1e-5;
    /// Seeds kept of a screen.
    pub const SCREEN_SEEDS: usize = 48;
}

/// `eye_pilot.rs`
/// - `c7e2c79` (Who traces what facts leave open is decided by a pilot of variance and counted work)
pub(super) mod eye_pilot {
    /// Rays, spread evenly over the picture.
    pub const RAYS: u64 = 1 << 10;
    /// A ray is followed both ways where each carries this share of what it started with.
    pub const LEAST: f64 = 1e-3;
    /// Faces that one ray and all its branches may meet.
    pub const MOST_MET: u32 = 256;
}

/// `mod.rs`
/// - `WIDE`, `MOST_WIDE`, `ENOUGH`: `224cc50` (Guided emission by trees over place and direction, from even points)
/// - `NARROW`: `dd93821` (Guides keep a shell beyond what their pilot saw)
/// - `ENOUGH_OF_REST`: `3429d70` (As a fresh reader asked)
/// - `LEFT`, `OF_LIGHT`, `FEWEST`: `5564627` (Light tracing for the rest of vision is as much as is left to it)
/// - `LAST`, `LITTLE`: `73d3e8a` (Specular connection)
pub(super) mod pilots {
    /// Paths of the first look, which knows nothing; most of them if little is found; and of each look after it.
    pub const WIDE: u64 = 1 << 13;
    pub const MOST_WIDE: u64 = 1 << 16;
    pub const NARROW: [u64; 2] = [1 << 11, 3 << 11];
    /// Paths that have to count before a look can be guided by them, in all and of each group.
    pub const ENOUGH: [usize; 2] = [48, 4];
    /// Effective paths that have shown what connection leaves, before photons are guided by them.
    pub const ENOUGH_OF_REST: f64 = 24.0;
    /// Paths by which it is seen what connection leaves, of a pass that no look has.
    pub const LEFT: u64 = 1 << 11;
    pub const LAST: u64 = 1 << 20;
    /// Lamp paths per pixel for next to none of the light, and for most of it.
    pub const OF_LIGHT: [f64; 2] = [0.25, 4.0];
    /// Share of the light below which a small picture needs no more of them than others for its size; and the fewest in a
    /// pass, below it and above.
    pub const LITTLE: f64 = 0.03;
    pub const FEWEST: [u64; 2] = [1 << 7, 1 << 12];
}

/// `photons.rs`
/// - `PER_PIXEL`, `MOST`: `7d0e0ed` (Photons: twice as many where they carry much of the light)
/// - `FEWEST`, `SOFT`, `SHARP`: `be4eada` (Photons of two radii that know where faces end)
/// - `FEWEST_GUIDED`: `3429d70` (As a fresh reader asked)
/// - `PER_BLUR`: `c7e2c79` (Who traces what facts leave open is decided by a pilot of variance and counted work)
/// - `STRONG`: `abfdbf4` (Diffuse: lens ghosts are found by photons that part, connected where they matter, and seen without
///   spikes)
pub(super) mod photons {
    /// Photons per pixel by the share of the light that connection leaves to them, and their limits: the fewest, as work, and
    /// of those that part and whose guide has learned from the very light that is left.
    pub const PER_PIXEL: f64 = 8.0;
    pub const FEWEST: f64 = 0.125;
    pub const FEWEST_GUIDED: f64 = 0.0625;
    pub const MOST: f64 = 4.0;
    /// Photons to be gathered in the first pass, and the most of the radius in distances between what neighbouring pixels see.
    /// Scattered light is soft: on scene A1 twelve pixels blur it by less than 1 % (5e-5 of relMSE), and four pixels blur its
    /// caustic more than their noise would be.
    pub const SOFT: (f64, f64) = (64.0, 12.0);
    /// Pixels of the longer side for one of blur: what is soft in a large picture is not in a small one.
    pub const PER_BLUR: f64 = 20.0;
    pub const SHARP: (f64, f64) = (16.0, 2.0);
    /// Trains with less of a face's light than this are connected only where almost all else is.
    pub const STRONG: f64 = 2e-3;
}

/// `glint_pilot/`
/// - `CELLS`, `RAYS`, `CLOSER`, `KEPT`, `MOST_WAYS`: `8cef4a0` (Glints do not hang on where the pilot's rays fall)
/// - `AT_A_TIME`, `IN_VAIN`: `262b087` (What a fresh reader found in the glints)
/// - `LEAST`: `c7e2c79` (Who traces what facts leave open is decided by a pilot of variance and counted work)
/// - `MOST_SEGMENTS`, `STARTS`, `MARGIN`: `465a217` (Pinholes: the places where lamps are seen over specular faces are solved
///   for)
/// - `MOST_LAMPS`: `d8e222a` (Plan: lamps imaged far from the pupil are not connected untried)
pub(super) mod glint_pilot {
    /// Cells along each side of the picture; about one ray looks into each at first.
    pub const CELLS: usize = 64;
    pub const RAYS: u64 = (CELLS * CELLS) as u64;
    /// Rays there are for each cell in which one met a specular face, and for those beside it: with one in each of 64 × 64 it hangs
    /// on where they fall whether an image in a rim, or of one mirror in another, is found.
    pub const CLOSER: u64 = 8;
    /// Rays whose finds are held at a time.
    pub const AT_A_TIME: usize = 512;
    /// A ray is followed both ways where each carries this share of what it started with.
    pub const LEAST: f64 = 1e-3;
    /// Segments that one ray and all its branches may have.
    pub const MOST_SEGMENTS: u32 = 256;
    /// Lamps that a ray may lead to over a chain: those that it comes nearest.
    pub const MOST_LAMPS: usize = 64;
    /// Starts from a chain and lamp, and rays that are kept for them. Starts in an image that is known lead to no other; after so
    /// many that lead nowhere those about them are left out.
    pub const STARTS: usize = 6;
    pub const IN_VAIN: usize = 3;
    pub const KEPT: usize = 64;
    /// Chains and lamps that are started from: those that a ray came nearest over.
    pub const MOST_WAYS: usize = 1 << 11;
    /// How much wider than the image of a disc about the lamp, as its derivatives have it, a glint is taken to be at first.
    pub const ROOM: f64 = 1.5;
    /// Rays at all specular faces together, and at one at most.
    pub const AIMED: usize = 1 << 12;
    pub const AIMED_AT_FACE: usize = 64;
    /// With more lamps than this rays are no closer where they met a specular face: each asks for each lamp.
    pub const MANY_LAMPS: usize = 256;
    /// An image that so many rays met is large.
    pub const MANY_MET: usize = 256;
    /// Share of its light that a way to a lamp leaves that nobody looks for, at the least.
    pub const WORTH: f64 = 0.05;
    /// A step in the pupil, in radii, by which an image is seen to move.
    pub const STEP: f64 = 0.25;
    /// Rays over a guess at an image, and how often a better guess is made of those that meet the lamp.
    pub const RAYS_TO_FIT: u64 = 512;
    pub const ROUNDS: u64 = 8;
    /// Fewer rays than this do not tell how an image moves with the pupil, nor that nothing of it lies beyond them.
    pub const FEWEST: usize = 12;
    /// A ray that meets the lamp so far out in a guess, 1 at its rim, says that there may be more; how much wider the next one is.
    pub const AT_RIM: f64 = 0.93;
    pub const GROWN: f64 = 1.6;
    /// By how much wider a glint is for what so many rays do not know of how it moves: over the root of their number.
    pub const ASTRAY: f64 = 2.5;
    /// How much wider than all the rays that met the lamp a glint is.
    pub const MARGIN: f64 = 1.15;
    /// Pixels that it is long and wide at the least, half.
    pub const LEAST_PIXELS: f64 = 0.01;
    /// An image that is wider and higher than so many pixels is left to the paths of each. Else it is cut into pieces so long, into
    /// so many at most.
    pub const THIN: f64 = 2.5;
    pub const LONG: f64 = 2.0;
    pub const MOST_PIECES: usize = 1 << 10;
    /// Ways from points of a lamp to points of the pupil at first; if `ENOUGH` of them are not free more, up to so many, and
    /// `JOINED` of all lamps together.
    pub const FIRST: u64 = 64;
    /// Lamps of more triangles than this are known by points on them alone; how much wider than the others' outlines a glint is.
    pub const MOST_TRIANGLES: usize = 1 << 12;
    pub const ROUNDED: f64 = 1.01;
    pub const ENOUGH: usize = 32;
    pub const MOST_JOINED: u64 = 1 << 16;
    pub const JOINED: u64 = 1 << 17;
    /// Of all lamps.
    pub const MOST_GLINTS: usize = 1 << 14;
}

/// `pupil.rs`
/// - `PATHS`, `OWN`: `224cc50` (Guided emission by trees over place and direction, from even points)
/// - `SPLIT_FROM`: `8fef686` (Estimators, plan and EXR)
pub(super) mod pupil {
    pub const PATHS: u64 = 1 << 13;
    /// A path is split where both ways carry this share: at combiners.
    pub const SPLIT_FROM: f64 = 0.1;
    /// Crossings that a lamp needs for a region of its own; the others of its group share one.
    pub const OWN: usize = 512;
}

/// `pupil_guide.rs`
/// - `LOOK`, `WORTH`: `50c0f63` (Guided aperture: rays from the eye start where lamps light the pupil)
/// - `OF_LAMP`, `MOST_LAMPS`: `d8e222a` (Plan: lamps imaged far from the pupil are not connected untried)
/// - `PATHS`: `224cc50` (Guided emission by trees over place and direction, from even points)
pub(super) mod pupil_guide {
    /// Paths from the lamps, guided to the pupil: a first look, and what the guide is learned from.
    pub const LOOK: u64 = 1 << 11;
    /// For each lamp that is looked at by itself, as many lamps as are.
    pub const OF_LAMP: u64 = 96;
    pub const MOST_LAMPS: usize = 64;
    pub const PATHS: u64 = 1 << 13;
    /// How much denser the points must be where light crosses than if they were spread evenly: below that lamps fill the pupil.
    pub const WORTH: f64 = 1.5;
}

/// `reached.rs`
/// - `4b8b162` (A plan that misses light is out whatever it costs, and what connection leaves goes to whoever reaches it)
pub(super) mod reached {
    /// Paths from the lamps that have to arrive over a train before light tracing is trusted with what the solver does not return.
    pub const FEWEST_ARRIVED: usize = 8;
    /// Standard errors, of either, by which light tracing has to find less than rays from the eye to be taken for blind.
    pub const SIGMAS: f64 = 3.0;
}

/// `shared_faces.rs`
/// - `PATHS`, `MOST_SPLITS`: `88bb13f` (Pilot: light tracing is given up early where lamps and eye share no specular face)
/// - `LEAST`: `c7e2c79` (Who traces what facts leave open is decided by a pilot of variance and counted work)
/// - `POINTS`: `39d8eb3` (As a fresh reader asked)
pub(super) mod shared_faces {
    /// Paths from the lamps, each both ways where either carries this share of it, at so many interfaces.
    pub const PATHS: u64 = 1 << 9;
    pub const LEAST: f64 = 1e-3;
    pub const MOST_SPLITS: u32 = 256;
    /// Points of each lamp that are looked for in plain sight.
    pub const POINTS: u64 = 4;
}

/// `sky_guide.rs`
/// - `WIDE`, `MOST_WIDE`, `NARROW`, `LOOK`, `AIMED`, `TILES`: `1acf642` (Guided sky: scatterers look for daylight where it
///   comes in)
/// - `WORTH`: `50c0f63` (Guided aperture: rays from the eye start where lamps light the pupil)
pub(super) mod sky_guide {
    /// Paths of the first look, which knows nothing, and most of them if little is found; and of each look after it.
    pub const WIDE: u64 = 1 << 9;
    pub const MOST_WIDE: u64 = 1 << 11;
    pub const NARROW: [u64; 2] = [1 << 9, 1 << 10];
    /// Part of the directions to the sky that a look aims, and those that a plan may.
    pub const LOOK: f64 = 0.5;
    pub const AIMED: [f64; 3] = [0.5, 0.75, 0.9];
    /// How many times less variance scatterers must have of aiming: below that the sky is open.
    pub const WORTH: f64 = 1.5;
    /// Tiles along either side of the picture: in each the same light matters relative to what it has.
    pub const TILES: usize = 4;
}

/// `split_threshold.rs`
/// - `PLACES`, `PASSES`, `FAINTEST`, `WORTH`, `LITTLE`: `07e6c4d` (Paths from the eye follow faint branches where a pilot
///   finds that it pays)
/// - `PASSES_OF_SCALE`: `39d8eb3` (As a fresh reader asked)
/// - `MOST`: `ac68b5b` (The manifold estimator and the planner in rooms)
pub(super) mod split_threshold {
    /// Pixels that each trial looks at, by two paths.
    pub const PLACES: u64 = 256;
    /// Passes of the two paths of a trial, and of those that tell how bright pixels are: points that follow each other on a pixel's
    /// lattice are not alike.
    pub const PASSES: [u64; 2] = [0, 5];
    pub const PASSES_OF_SCALE: [u64; 2] = [2, 7];
    /// Shares of a path's light down to which its branches are followed for certain.
    pub const FAINTEST: [f64; 2] = [1.0 / 1024.0, 1.0 / 64.0];
    /// How many times less variance times work has to be to depart from what is simple.
    pub const WORTH: f64 = 1.25;
    /// Most paths per pixel and pass beside dearer estimators, which cost some tens of times as much as a short path and err more at
    /// edges.
    pub const MOST: u32 = 4;
    /// Relative variance of a pass that is little beside that of such an estimator at edges.
    pub const LITTLE: f64 = 1e-3;
}
