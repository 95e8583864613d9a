//! The solver of one connection: Newton's iteration on a ray with its derivatives, and the grids that keep what it found.

pub mod bicubic;
pub mod grid;
pub mod media;
pub mod newton;
pub mod ray_differentials;
pub mod simd_nodes;
mod tuning;
