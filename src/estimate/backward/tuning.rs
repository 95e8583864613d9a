//! Numbers of this room that no formula gives, file by file. The commits that are named chose them: their messages tell on
//! which scenes, and what was measured.

/// `glow.rs`
/// - `LEAF`, `GUIDED`, `BY_LIGHT`, `LEAST_COS`, `RIDGE`, `WIDER`, `WIDEST`: `571fd77` (A witness beside every render)
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
}

/// `probe.rs`
/// - `1acf642` (Guided sky: scatterers look for daylight where it comes in)
pub(super) mod probe {
    /// Scatterers on a path that are asked: what later ones bring is little.
    pub const MOST_SCATTERED: u32 = 3;
    /// Faces on the way to them.
    pub const MOST_EVENTS: u32 = 32;
}
