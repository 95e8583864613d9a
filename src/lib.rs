//! `eyebox` traces light through head-up-display and AR assemblies into layered EXR in absolute cd/m².
//!
//! The corridor, one function per arrow:
//! `path ─import→ Scene ─check→ Checked ─freeze→ World ─plan→ Plan ─estimate→ Films ─finish→ Frame ─write→ EXR`.
//! (The plan comes after the world is frozen, since its pilots trace.)
//! Modules are floors; a module imports only from lower floors (`tests/floors.rs` enforces it).

pub mod base; // floor 0: units, ids, randomness, statistics, path strings, errors
pub mod film; // floor 1: layers, accumulators, frames, the plan as data
pub mod import; // floor 2: glTF, sidecar → Scene
pub mod scene; // floor 1: plain scene data
pub mod world; // floor 3: what is traced
