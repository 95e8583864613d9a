//! Numbers of this room that no formula gives, file by file. The commits that are named chose them: their messages tell on
//! which scenes, and what was measured.

/// `mod.rs`
/// - with this room (Irradiance on parts)
pub(super) mod sensor {
    /// Passes where no limit is given.
    pub const PASSES: u64 = 64;
    /// Passes from which on an error is believed.
    pub const FIRST_LOOK: u64 = 16;
}

/// `map.rs`
pub(super) mod map {
    /// Share of a pixel that the face has to cover for it to be the peak: what a sliver of a face gets is noise.
    pub const COVERED: f64 = 0.5;
}

/// `aim.rs`
/// - with this room (Irradiance on parts): the windshield HUD's LCD under the sun, of whose light a twentieth passes beside
///   all optics; a lamp much larger than the sensor that it lights
pub(super) mod aim {
    /// Paths of the first look, which is taken again, twice as large, until so many have arrived, or so many were traced.
    pub const WIDE: u64 = 1 << 16;
    pub const ENOUGH: usize = 1 << 12;
    pub const MOST_WIDE: u64 = 1 << 18;
    /// Rays from a sensor that look where light of distant lamps may get in, and paths of the look from there.
    pub const SEEDS: u64 = 1 << 12;
    pub const SEEDED: u64 = 1 << 16;
    /// Paths of the guided looks after these.
    pub const NARROW: [u64; 2] = [1 << 15, 1 << 16];
    /// Passes by which it is tried from where a group's light is found with less noise.
    pub const TRIAL: u64 = 4;
}
