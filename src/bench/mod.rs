//! Floor 6: the program measured. [`stress`] traces scenes at the limits of numbers, whose answers are known; [`curve`]
//! takes the time that each estimator needs to an error.

pub mod clock;
pub mod closed;
pub mod curve;
pub mod kit;
pub mod measure;
pub mod stress;
