//! Floor 1: what is measured: layers, accumulators, frames, and the plan as data.

pub mod accumulate;
pub mod aov; // layers that a user defines
pub mod colours; // how the numbers of pictures are to be read
pub mod control_variates;
pub mod crop; // a part of a picture
pub mod cryptomatte; // Cryptomatte
pub mod diffraction;
pub mod error_detail;
pub mod exr; // a file → a frame
pub mod finish;
pub mod frame;
pub mod glint; // where lamps are seen
pub mod guide;
pub mod jpeg;
pub mod kernel_bias;
pub mod layer;
pub mod layer_moments;
pub mod names; // of all layers, and which clash
pub mod plan;
pub mod pupil;
pub mod radiance; // Radiance HDR
pub mod replicates;
pub mod rqmc_variance;
pub mod sample_map;
pub mod serial;
pub mod sharpness;
pub mod specular_chain;
pub mod still; // pictures made elsewhere: skies, slides, plates
mod tiles; // sums only where there is light
pub mod totals;
pub mod unseen; // what rays may not have met
pub mod variance;
pub mod witness; // what naive paths saw, and what that says of the films
