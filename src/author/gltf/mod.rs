//! glTF 2.0: a whole assembly as `.gltf` or `.glb`, or rows put into a copy of one.

mod animation;
mod annotate;
mod binary;
mod document;
mod geometry;
mod lamp;
mod light;
mod material;
mod node;
mod skin;
mod splice;
mod surface;
mod texture;
mod uri;
mod user;
mod value;

pub use annotate::annotate;
pub use document::write;
