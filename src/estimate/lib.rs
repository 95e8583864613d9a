//! Floor 4: the estimators, the vertex step they share, and the ledger that books their light.

pub mod aov; // layers by light path expression
pub mod backward;
pub mod cryptomatte;
pub mod data;
mod diffraction_event;
pub mod emission;
pub mod emitter_hit;
pub mod finishing;
mod follow;
pub mod forward;
mod kernel_bias;
#[cfg(test)]
mod leak_tests;
pub mod ledger;
pub mod manifold;
mod medium_stack;
pub mod motion;
pub mod motion_seen;
mod outgoing;
mod outliers;
pub mod ownership;
pub mod photon;
pub mod photon_map;
pub mod picture;
mod pixel;
pub mod render_vars;
mod rqmc;
pub mod run;
pub mod scatter_event;
pub mod sensor;
mod series; // slides one behind the other
pub mod shard;
pub mod slides; // scenes with several
pub mod specular_event;
pub mod splitting;
pub mod throughput;
mod tuning;
pub mod virtual_image;
pub mod vision;
pub mod walk;
mod window_visibility;
pub mod witness;
pub mod work_layer; // where the work went

/// Asked while something is being done whether to leave it (Ctrl-C); once true, always true.
pub type ShouldStop<'a> = dyn Fn() -> bool + Sync + 'a;
