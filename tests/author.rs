//! `annotate` and `convert`: what comes out means what went in, bit for bit.

mod broken;
mod bytes;
mod cameras;
mod kit;
mod looks;
mod looks_usd;
mod motion;
mod motion_kept;
mod random;
mod said;
mod samples;
mod shapes;
mod user;
