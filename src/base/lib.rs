//! Floor 0: units, colour, typed ids, errors with places and codes, random numbers, even points, warps, statistics, event strings,
//! file names, whole files.

pub mod atomic;
pub mod chain;
pub mod code; // what a fault is about
pub mod colour;
pub mod complex;
pub mod document; // JSON that says who made it
pub mod double_double; // sums that do not depend on their pieces
pub mod error;
pub mod glb;
pub mod ids;
pub mod lattice; // points that are even however many there are
pub mod lpe; // light path expressions
pub mod memory; // what the allocator keeps
pub mod murmur3; // the hash of names in Cryptomatte
pub mod package;
pub mod parallel; // loops over all cores
pub mod path;
pub mod relative_path;
pub mod rng;
pub mod shared; // what copies share until they change it
pub mod sobol;
pub mod stats;
pub mod students_t;
pub mod units;
pub mod vision; // the eye as formulas
pub mod warp;
pub mod weld; // which vertices are one point

pub use code::Code;
pub use complex::Complex;
pub use error::{Error, Result, Where, nearest_name};
pub use shared::Shared;
