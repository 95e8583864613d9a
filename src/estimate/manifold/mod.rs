//! Specular connection: paths whose ends are chosen and whose specular faces between them are solved for.

mod at_edges;
mod eye_subpath;
pub mod eye_table;
pub mod film_grid;
pub mod film_table;
pub mod pixel_span;
pub mod receiver;
pub mod seeds;
pub mod solver;
mod tuning;
pub mod vision;
