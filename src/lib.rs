//! `eyebox` traces light through head-up-display and AR assemblies into layered EXR in absolute cd/m².
//!
//! The corridor, one function per arrow:
//! `path ─import→ Scene ─check→ Checked ─freeze→ World ─plan→ Plan ─estimate→ Films ─finish→ Frame ─write→ EXR`.
//! (The plan comes after the world is frozen, since its pilots trace.)
//! Modules are floors; a module imports only from lower floors (`tests/floors.rs` enforces it). [`prelude`] is the front for
//! programs that use the library.

pub use eyebox_author as author; // floor 2: glTF and USD out, and the schemas of the attributes
pub use eyebox_base as base; // floor 0: units, ids, randomness, statistics, path strings, errors
pub use eyebox_check as check; // floor 2: facts of a scene, and the proof that it can be rendered
pub mod cmd; // floor 7: one file per subcommand
pub use eyebox_estimate as estimate; // floor 4: the estimators, the shared vertex step, the energy ledger
pub use eyebox_film as film; // floor 1: layers, accumulators, frames, the plan as data
pub use eyebox_import as import; // floor 2: glTF, sidecar → Scene
pub use eyebox_output as output; // floor 2: EXR, view
pub use eyebox_plan as plan; // floor 5: who owns which paths
pub mod prelude; // floor 7: the library's front
pub use eyebox_scene as scene; // floor 1: plain scene data
pub use eyebox_validate as validate; // floor 6: the rules over an asset, and reports of what they find
pub use eyebox_world as world; // floor 3: what is traced
