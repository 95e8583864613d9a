//! The two sample HUDs, from sidecar to frame, against the prescription that they were built from.

#[path = "hud/agreement.rs"]
mod agreement; // estimator against estimator, frames of reference
#[path = "hud/colour.rs"]
mod colour; // lateral colour
mod common;
#[path = "hud/guided.rs"]
mod guided; // guided emission, even points
#[path = "hud/invariance.rs"]
mod invariance; // what must not matter
#[path = "hud/kit.rs"]
mod kit;
#[path = "hud/layers.rs"]
mod layers; // what the stored layers promise
#[path = "hud/luminance.rs"]
mod luminance; // flat patches, and what moves them
#[path = "hud/picture.rs"]
mod picture; // where the slide's edges are
#[path = "hud/prescription.rs"]
mod prescription; // the independent calculation
#[path = "hud/sharpness.rs"]
mod sharpness; // the lit part of the pupil, and what diffraction makes of it
