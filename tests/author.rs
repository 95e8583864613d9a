//! `annotate` and `convert`: what comes out means what went in, bit for bit.

mod common;

#[path = "author/broken.rs"]
mod broken;
#[path = "author/bytes.rs"]
mod bytes;
#[path = "author/kit.rs"]
mod kit;
#[path = "author/random.rs"]
mod random;
#[path = "author/samples.rs"]
mod samples;
