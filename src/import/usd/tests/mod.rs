//! Small stages written on the spot, each with one thing that the reader must get right.

mod compose;
mod frames;
pub(super) mod kit;
mod lights;
mod limits;
mod materials;
mod meshes;
mod networks;
mod packages;
mod paint;
mod renders;
mod text;
mod transforms;
mod twins;
