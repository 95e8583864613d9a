//! Floor 2: what leaves the program: layered EXR and pictures to look at.

pub mod assembly_tree;
pub mod exr;
pub mod geometry;
pub mod tone;
pub mod view;
