//! USD, `.usda`, `.usdc` and `.usdz`, into an [`Assembly`].
//!
//! The `openusd` crate reads layers and composes them; what prims mean is decided here. Transforms are multiplied in
//! f64 by the same code as glTF's, so that an asset that was converted from one to the other stays what it was, bit for
//! bit.

mod arcs;
mod attribute;
mod binding;
mod caches;
mod camera;
mod clips;
mod composition_budget;
mod coordinates;
mod crate_limits;
mod faces;
mod fold;
mod handed;
mod hierarchy;
mod implicit;
mod inputs;
mod instancer;
mod layer_units;
mod layered;
mod light;
mod material;
mod mesh;
mod mtlx;
mod network;
mod nodes;
mod normalise;
mod notes;
mod optics;
mod paint;
mod polygons;
mod primvar;
mod reader;
mod reads;
mod render;
mod resolver;
mod round_trip;
mod shader;
mod shape;
mod skel;
mod skel_binding;
mod stage;
mod standard;
mod stranger;
mod subdivide;
mod sublayers;
mod surface;
mod tessellate;
mod texture;
mod triangulate;
mod user;
mod value;
mod variants;
mod walk;
mod xform;
mod xml;

#[cfg(test)]
mod tests;

use super::ReadOptions;
use super::assembly::Assembly;
use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Where};
use eyebox_scene::Note;
use reader::Reader;
use std::path::Path;

/// Composition and the walk recurse over the depth of namespaces, which is bounded (see `hierarchy` and `resolver`);
/// the bound needs more than the 2 MiB that a thread has by default.
const STACK_BYTES: usize = 256 << 20;

/// Reads the stage whose root layer is `path`: one node per prim that places something, one mesh per Mesh prim or
/// implicit shape (instances share it), one face per GeomSubset.
///
/// # Errors
/// The root layer cannot be read; a value contradicts itself, with its prim. What composition could not find is a note.
/// A hostile file gives a fault, too: no panic, no hang, and no more memory than the file can honestly need.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Assembly> {
    let failed = |error: std::io::Error| {
        Error::new(Where::file(path), format!("cannot read the asset: {error}")).code(Code::of_reading(&error))
    };
    if std::fs::metadata(path).map_err(failed)?.is_dir() {
        return Err(Error::new(Where::file(path), "this is a folder").expected("a .usda, .usdc or .usdz file"));
    }
    std::thread::scope(|scope| {
        let builder = std::thread::Builder::new().name("usd".to_owned()).stack_size(STACK_BYTES);
        let reading =
            builder.spawn_scoped(scope, || Reader::open(path, options)?.run(&options.variants)).map_err(failed)?;
        // A panic in the crate is a defect of it, but ends here all the same.
        reading.join().unwrap_or_else(|_| {
            Err(Error::new(Where::file(path), "the USD library failed on this file (a defect in it)"))
        })
    })
    .map(|mut assembly| {
        for (option, is_there) in [("--animation", options.animation.is_some()), ("--fps", options.fps.is_some())] {
            let text = "means nothing to USD: `--frame` is a time code there";
            assembly.notes.extend(is_there.then(|| Note::warning(Where::Option(option.to_owned()), text)));
        }
        assembly
    })
}
