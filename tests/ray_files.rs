//! Rays of files as lamps: what is read, and what becomes of it on sensors and in pictures.

mod carriers;
mod light;
mod reading;
pub mod writer;
