//! `eyebox validate`: every rule set off by planting its fault into one good asset, and reports that other programs take.

mod action;
mod bench;
mod defaults;
mod missing;
mod mutations;
mod piped;
mod reports;
