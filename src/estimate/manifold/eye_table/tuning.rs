//! Numbers of this room that no formula gives, file by file. The commits that are named chose them: their messages tell on
//! which scenes, and what was measured.

/// `eye_hit.rs`
/// - `1317c09` (Tables: what is blended lies in fours, and four numbers at a time are blended)
pub(super) mod eye_hit {
    /// Nodes over the pupil: three along both axes.
    pub const OVER_PUPIL: usize = 9;
    /// Most quads of a landing.
    pub const QUADS: usize = 3;
}

/// `make.rs`
/// - `LOOKS`, `SHARP`: `7f3a5c7` (Where rays from the eye land on a lit screen is read from tables, as control variates)
/// - `MOST`, `WORTH`, `LITTLE`, `POOR`: `abfdbf4` (Diffuse: lens ghosts are found by photons that part, connected where they
///   matter, and seen without spikes)
/// - `LEAST`: `0c9594a` (Photons' pilot takes half the paths)
pub(super) mod make {
    /// Rays from the eye that look for trains, along both axes of the picture.
    pub const LOOKS: usize = 12;
    /// Most trains, and the least light of one over that of the best.
    pub const MOST: usize = 8;
    pub const WORTH: f64 = 1e-6;
    /// Trains with less than this share are done without where they end, or can't be kept in a table.
    pub const LITTLE: f64 = 0.02;
    /// The ray itself is followed with this probability where the tables did well on trial, and always where they were off by
    /// this share. A place that is off by a pixel counts as this much.
    pub const LEAST: f64 = 1.0 / 32.0;
    pub const POOR: f64 = 0.02;
    pub const SHARP: f64 = 0.2;
}

/// `mod.rs`
/// - `OF_DIFFERENCES`: `1cb931c` (What a fresh reader found: pixels that tables know but in part)
/// - `OUTER`: `7f3a5c7` (Where rays from the eye land on a lit screen is read from tables, as control variates)
/// - `FAINT`, `SELDOM`: `abfdbf4` (Diffuse: lens ghosts are found by photons that part, connected where they matter, and seen
///   without spikes)
/// - `SELDOM_OF_LITTLE`: `e230f63` (Screens are blended row by row, and little light follows rays more seldom)
/// - `OFTEN`: `7aa97e5` (Glances: faint trains are looked at by every eighth look at least, not by every fourth)
pub(super) mod eye_table {
    /// The outer nodes over the pupil, in radii.
    pub const OUTER: f64 = 0.8;
    /// Rays with all their branches hardly ever find trains with less than this of what the best brings.
    pub const FAINT: f64 = 1e-3;
    /// Of the looks at a train by itself so many are by the ray itself.
    pub const SELDOM: f64 = 1.0 / 16.0;
    /// So much more seldom it is followed for light that is little.
    pub const SELDOM_OF_LITTLE: f64 = 1.0 / 4.0;
    /// Where rays and tables both stand for all of a pixel tables may be off by so much of what has rays always followed: by a fiftieth
    /// of a pixel. Where something covers a part of a pixel they hide so much of an edge in it.
    pub const OF_DIFFERENCES: f64 = 0.2;
    /// Least share of the looks in which a train is looked at by itself, where its light is all that a pixel may have: a ghost of
    /// 10⁻⁵ of a symbol is some hundredths of the black beside it. By every fourth look the flat pixels of the diffuse HUD have 4.6e-5
    /// after a pass, by every eighth 5.2e-5 (eight seeds).
    pub const OFTEN: f64 = 1.0 / 8.0;
}
