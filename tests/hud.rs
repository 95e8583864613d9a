//! The two sample HUDs, from sidecar to frame, against the prescription that they were built from.

mod adaptation;
mod agreement; // estimator against estimator, frames of reference
mod colour; // lateral colour
mod guided; // guided emission, even points
mod invariance; // what must not matter
mod kit;
mod layers; // what the stored layers promise
mod luminance; // flat patches, and what moves them
mod picture; // where the slide's edges are
mod prescription; // the independent calculation
mod sharpness; // the lit part of the pupil, and what diffraction makes of it
