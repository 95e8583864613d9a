//! Specular connection: paths whose ends are chosen and whose specular faces between them are solved for.

pub mod bands; // of wavelengths
pub mod bundle;
pub mod connections;
pub mod edge_sampling;
pub mod eye_table;
pub mod face_map;
pub mod film_table;
pub mod grid;
pub mod lean;
mod look;
pub mod nodes;
pub mod over_film;
pub mod receiver;
pub mod seeds;
pub mod solve;
pub mod vision;
