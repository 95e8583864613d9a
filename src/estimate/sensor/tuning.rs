//! Numbers of this room that no formula gives, file by file. The commits that are named chose them: their messages tell on
//! which scenes, and what was measured.

/// `../sensor.rs`, `arrivals.rs`
/// - with this room (Irradiance on parts): the windshield HUD's LCD under the sun, 60 × 20 pixels
pub(super) mod sensor {
    /// Paths of a pass per pixel of the map, and the fewest.
    pub const PER_PIXEL: u64 = 8;
    pub const FEWEST: u64 = 1 << 13;
    /// A path is split where both ways on carry this share.
    pub const SPLIT_FROM: f64 = 0.01;
}

/// `backward.rs`
/// - with this room (Irradiance on parts)
pub(super) mod backward {
    /// Paths that one thread traces before it hands over what it found.
    pub const CHUNK: u64 = 1 << 12;
    /// Events after which a ray that is to leave the scene is given up.
    pub const MOST_EVENTS: u32 = 32;
    /// How far from the face, in the root of its area, it is asked which solids are there: beyond what single precision leaves.
    pub const OFF: f64 = 1e-6;
}
