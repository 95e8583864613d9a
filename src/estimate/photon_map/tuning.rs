//! Numbers of this room that no formula gives, file by file. The commits that are named chose them: their messages tell on
//! which scenes, and what was measured.

/// `adaptive_kernel.rs`
/// - `496b9b0` (Kernels of crowded photons change by small steps, in boxes that move)
pub(super) mod adaptive_kernel {
    /// Steps in which a radius is halved.
    pub const STEPS: usize = 8;
    /// How often it is halved at most: two pixels to a quarter of one, and no picture shows less.
    pub const HALVINGS: usize = 3;
    /// Steps at most.
    pub const MOST: usize = HALVINGS * STEPS;
}
