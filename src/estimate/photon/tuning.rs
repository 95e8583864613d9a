//! Numbers of this room that no formula gives, file by file. The commits that are named chose them: their messages tell on
//! which scenes, and what was measured.

/// `photon.rs`
/// - `ALPHA`: `8fef686` (Estimators, plan and EXR)
/// - `ENOUGH`: `496b9b0` (Kernels of crowded photons change by small steps, in boxes that move)
/// - `ENOUGH_AT_LEAST`: `d6a88dd` (Mends a fresh reader asked for)
pub(super) mod photon {
    /// The squared radius falls as (pass + 1)^(α − 1): bias and variance of the mean both vanish for 0 < α < 1.
    pub const ALPHA: f64 = 2.0 / 3.0;
    /// So many photons straight from specular faces in a box of twice the radius need no smaller kernels in pass 0.
    pub const ENOUGH: f64 = 32.0;
    /// In late passes, when radii have shrunk: fewer would make a crowd by chance.
    pub const ENOUGH_AT_LEAST: f64 = 8.0;
}

/// `final_gather.rs`
/// - `f803444` (Photons: light that a rough pane's own glass sends back to it is gathered where it was scattered)
pub(super) mod final_gather {
    /// Paths that go on for one that brings all it started with. On seeds 4, 11, 18 and 32 of `eyebox bench --generate` four
    /// cost 0.32 to 0.39 of the variance × time of one, and eight 0.74 to 1.03 of that of four.
    pub const COPIES: f64 = 4.0;
}

/// `gather.rs`
/// - `343fe0f` (What a fresh reader found)
pub(super) mod gather {
    /// By how much the first ray of a pass lies farther on in a pixel's lattice than that of the last. With 21, passes of 2, 8 and 16
    /// rays are even among each other: from 2 to 16 of them err by 0.35 to 0.67 of the variance that independent ones would have at
    /// edges in any direction. With 16, which is as many rays as there may be, a pass moves on by a tenth of a pixel, and it is up to 1.9.
    pub const STRIDE: u64 = 21;
}

/// `gather_samples.rs`
/// - `d6a88dd` (Mends a fresh reader asked for)
pub(super) mod gather_samples {
    pub const MOST_RAYS: u64 = 16;
}

/// `visible_receivers.rs`
/// - `RAYS`: `224cc50` (Guided emission by trees over place and direction, from even points)
/// - `MOST_EVENTS`: `8e5a7a1` (Colour: spectra, mono, rgb and hero modes; polarisers, wave plates, absorption by wavelength)
pub(super) mod visible_receivers {
    /// Rays from the eye.
    pub const RAYS: u64 = 1 << 11;
    /// Faces that a ray is followed for.
    pub const MOST_EVENTS: u32 = 64;
}
