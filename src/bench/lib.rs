//! Floor 6: the program measured. [`stress`] traces scenes at the limits of numbers, whose answers are known; [`curve`]
//! takes the time that each estimator needs to an error, [`choice`] holds the plan's choice against every choice by hand on
//! scenes that [`generate`] makes from seeds, [`agreement`] its pictures of them against plain sampling, and [`stated`] the error
//! that a run states against the one it has.

pub mod agreement;
#[cfg(test)]
mod blur_tests;
#[cfg(test)]
mod branching_tests;
pub mod choice;
pub mod clock;
pub mod closed;
#[cfg(test)]
mod covers_tests;
pub mod curve;
#[cfg(test)]
mod forecast_tests;
pub mod generate;
#[cfg(test)]
mod glances_tests;
#[cfg(test)]
mod glints_tests;
pub mod kit;
#[cfg(test)]
mod lamps_tests;
pub mod measure;
#[cfg(test)]
mod memory_tests;
#[cfg(test)]
mod panes_tests;
#[cfg(test)]
mod plan_tests;
#[cfg(test)]
mod rims_tests;
#[cfg(test)]
mod rough_tests;
#[cfg(test)]
mod screens_tests;
pub mod stated;
pub mod stress;
#[cfg(test)]
mod unknown_tests;
#[cfg(test)]
mod windows_tests;
