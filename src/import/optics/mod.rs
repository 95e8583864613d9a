//! Readers of the attribute vocabulary: a [`Value`](super::Value) → typed rows, the same for every carrier. They know
//! `scene::attribute`'s rows and nothing about glTF, TOML or where a value is bound.

mod coating;
mod efficiency_table;
mod emitter;
mod eye;
mod fields;
mod finish;
mod grating;
mod klems_bsdf;
mod medium;
mod scatter_table;
mod sensor;
mod shape;
mod sky;
mod slide;
mod spectrum;
mod sun;
mod surface;
mod wave_plate;
mod wavelengths;
mod zemax_bsdf;

pub use coating::{coating, unknown as unknown_coating};
pub use efficiency_table::efficiency_table;
pub use emitter::{ATTRIBUTES as EMITTER, EmitterSpec, STRENGTHS, Spreading, Strength, emitter, group_name, white_of};
pub use eye::{EyeSpec, Lens, Pose, eye};
pub use fields::{Fields, Union, not_yet, number, stray, union};
pub use finish::{FinishSpec, PlateOf, finish};
pub use grating::{GratingSpec, OrdersSpec};
pub use medium::{absorption, entries as medium_entries, index, law, possible, priority};
pub use scatter_table::{MeasuredFile, name_of_table, scatter_table};
pub use sensor::sensor;
pub use shape::{ShapeSpec, shape};
pub use sky::{SkyKind, SkySpec, Up, goes_with as goes_with_sky, kind_of as kind_of_sky, sky};
pub use slide::{ATTRIBUTES as SLIDE, ORTHOGONAL, SlideSpec, slide};
pub use spectrum::{SpectrumSpec, spectrum, spectrum_table};
pub use sun::{SunSpec, sun};
pub use wavelengths::{unit, version, wavelengths};
