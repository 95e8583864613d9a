//! Specular connection: paths whose ends are chosen and whose specular faces between them are solved for.

pub mod bands; // of wavelengths
pub mod bicubic;
pub mod connections;
pub mod edge_sampling;
mod eye_subpath;
pub mod eye_table;
pub mod film_grid;
pub mod film_table;
pub mod grid;
pub mod newton;
pub mod pixel_span;
pub mod ray_differentials;
pub mod receiver;
pub mod seeds;
pub mod simd_nodes;
pub mod surface_param;
pub mod vision;
