//! Numbers of this room that no formula gives, file by file. The commits that are named chose them: their messages tell on
//! which scenes, and what was measured.

/// `adaptation.rs`
/// - `ccd6ce8` (An eye may be adapted to its picture: pupil_diameter = "auto"): the direct HUD without its sky ends within 1 %
///   of the same pupil from 2 mm and from 7 mm (`tests/hud/adaptation.rs`)
pub(super) mod adaptation {
    /// Pixels across of the short renderings, and their passes: the mean of the picture is what counts.
    pub const WIDTH: usize = 48;
    pub const PASSES: u64 = 8;
    /// The diameter goes at most with the seventh root of the luminance, and that at most with its inverse square: a step leaves
    /// at most 0.28 of what is missing, nothing where lamps fill the pupil; eight leave 4e-5.
    pub const MOST_STEPS: usize = 8;
    /// A change of the diameter that is none.
    pub const CLOSE: f64 = 0.005;
}

/// `forecast.rs`
/// - `AIM`, `WORK`: `597532e` (Plan: the forecast goes on until it has seen the error, and knows of pixels' size)
/// - `PASSES`: `73d3e8a` (Specular connection)
/// - `SIDE`: `e2a0ec2` (eyebox bench ASSET: time against error of every estimator, against two independent references)
/// - `LARGER_SIDE`, `MOST_BY_PIXELS`: `ea975f4` (Forecast: how errors fall with the pixels' size is measured nearer to the
///   whole picture)
pub(super) mod forecast {
    /// The relative error that is asked for.
    pub const AIM: f64 = 0.01;
    /// First passes of the pilot.
    pub const PASSES: u64 = 6;
    /// Counted work that the pilot may take, about a second's.
    pub const WORK: u64 = 50_000_000;
    /// Longer side of its picture, pixels, and of the one that tells how errors depend on the pixels' size.
    pub const SIDE: usize = 64;
    pub const LARGER_SIDE: usize = 128;
    /// The error goes as the number of pixels to a power of at least this: that of edges.
    pub const MOST_BY_PIXELS: f64 = -0.25;
}

/// `mode.rs`
/// - `8e5a7a1` (Colour: spectra, mono, rgb and hero modes; polarisers, wave plates, absorption by wavelength)
pub(super) mod mode {
    /// Wavelengths at which media are compared, nm: what is the same at all of them is taken to be achromatic.
    pub const PROBES_NM: [f64; 5] = [420.0, 480.0, 550.0, 620.0, 690.0];
    /// Share of what left the eye by which the light at some face must differ for Stokes vectors to be worth their cost.
    pub const MATTERS: f64 = 1e-3;
}

/// `planner.rs`
/// - `LOOKS`, `SELDOM`: `73d3e8a` (Specular connection)
/// - `UNKNOWN`, `SELDOM_UNKNOWN`, `FEWEST_LOOKS`: `755d6de` (Vision over trains that connection does not know is for rays
///   from the eye)
pub(super) mod planner {
    /// Paths of the pilot that looks whether rays from the eye find anything, and how many pixels are looked at if not.
    pub const LOOKS: u64 = 2048;
    pub const SELDOM: f64 = 1.0 / 64.0;
    /// And where a lamp that they may miss is bright.
    pub const MANY_LOOKS: u64 = 1 << 17;
    /// Looks per pixel and pass for lamps over trains that connection does not know, over their share of the light as far as a
    /// pilot has seen it.
    pub const UNKNOWN: f64 = 64.0;
    /// The least of it, and the fewest pixels of a pass.
    pub const SELDOM_UNKNOWN: f64 = 1.0 / 128.0;
    pub const FEWEST_LOOKS: f64 = 4.0;
    /// Light tracing without connection is given vision only if so many paths of a pilot found the pupil.
    pub const ARRIVED: u64 = 64;
    /// Of a lamp whose images were looked for, or whose caustics a pilot has compared, so much counts as what rays may miss: both may be wrong.
    pub const MISSED: f64 = 1.0 / 64.0;
}
