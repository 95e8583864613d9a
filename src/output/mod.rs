//! Floor 2: what leaves the program: layered EXR and pictures to look at, and what is made of a rendered frame.

pub mod assembly_tree;
pub mod average;
pub mod canvas;
pub mod compare;
pub mod contact_sheet;
pub mod exr;
pub mod false_colour;
pub mod field;
pub mod fit;
pub mod geometry;
pub mod glare;
pub mod job;
pub mod leak;
pub mod light_shares;
pub mod luminance;
pub mod measure;
pub mod mix;
mod mix_errors;
pub mod picture_sheet;
pub mod plate;
pub mod rays;
pub mod report;
pub mod shard;
pub mod solve;
pub mod sum_frames;
pub mod tone;
pub mod view;
