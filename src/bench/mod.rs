//! Floor 6: the program measured. [`stress`] traces scenes at the limits of numbers, whose answers are known.

pub mod closed;
pub mod kit;
pub mod measure;
pub mod stress;
