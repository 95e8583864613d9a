//! Floor 7: the library's front: `open → prepare → plan → render → frame → write`, the corridor of the program as functions that
//! can be called again and again. Everything else is public for tests and tools, and may change.
//!
//! ```no_run
//! use eyebox::prelude::*;
//!
//! # fn main() -> eyebox::prelude::Result<()> {
//! let scene = open("hud.optics.toml", &["led.flux_lm=0.5"])?;
//! let ready = prepare(&scene)?;
//! let plan = ready.plan();
//! let limits = Limits { passes: Some(64), ..Limits::default() };
//! let outcome = ready.render(&plan, &limits, 1, |status| status.passes < 1000);
//! let frame = ready.frame(&plan, &outcome, 1)?;
//! write("hud.exr", &frame)?;
//! # Ok(())
//! # }
//! ```

pub use crate::base::error::Result;
pub use crate::base::{Error, Where};
pub use crate::check::finding::{Finding, Level};
pub use crate::estimate::run::{Films, Limits, Outcome, Status, Stop};
pub use crate::film::frame::Frame;
pub use crate::film::plan::Plan;
pub use crate::plan::scan::{Scan, ScanAsked, scan};
pub use crate::plan::{Asked, Choice};
pub use crate::scene::Scene;

use crate::base::colour::ColourSpace;
use crate::check::{Checked, check};
use crate::estimate::data::data_layers;
use crate::estimate::picture::{add_data_layers, add_meta, picture};
use crate::estimate::run::{Observer, run};
use crate::import::{ImportOptions, Set, import};
use crate::output::exr::write_exr;
use crate::plan::plan;
use crate::world::World;
use std::path::Path;

/// Reads an asset (`.glb`, `.gltf`, `.usd`, `.usda`, `.usdc`, `.usdz`) or a sidecar that names one. `sets` are those of `--set`:
/// `TARGET.attribute=VALUE`.
///
/// # Errors
/// A file that cannot be read, an attribute that is wrong or missing, each with its place; a set that fits nothing.
pub fn open(path: impl AsRef<Path>, sets: &[&str]) -> Result<Scene> {
    let sets = sets.iter().map(|text| Set::parse(text)).collect::<Result<Vec<_>>>()?;
    Ok(import(path.as_ref(), &ImportOptions { sets, ..ImportOptions::default() })?.scene)
}

/// What `eyebox validate` finds in an asset, in the order of its rules. An asset that cannot be read is a finding, too.
pub fn findings(path: impl AsRef<Path>) -> Vec<Finding> {
    crate::validate::findings(path.as_ref())
}

/// A scene that can be traced.
pub struct Prepared<'s> {
    checked: Checked<'s>,
    world: World,
}

/// Checks a scene and builds the tables that rays need.
///
/// # Errors
/// Numbers out of range, geometry that cannot be traced, an eye inside glass.
pub fn prepare(scene: &Scene) -> Result<Prepared<'_>> {
    Ok(Prepared { checked: check(scene)?, world: World::freeze(scene)? })
}

impl Prepared<'_> {
    /// The plan that `eyebox render` would make: who traces which paths, decided by pilot runs.
    pub fn plan(&self) -> Plan {
        self.plan_by(Choice::Auto.into())
    }

    /// The plan for a choice of estimator, polarisation and guides.
    pub fn plan_by(&self, asked: Asked) -> Plan {
        plan(&self.checked, &self.world, asked)
    }

    /// Traces until a limit is reached or `progress` says false; it is called between blocks of passes. The same bits for the
    /// same seed and passes, whatever the number of threads.
    pub fn render(&self, plan: &Plan, limits: &Limits, seed: u64, progress: impl FnMut(&Status) -> bool) -> Outcome {
        let scene = self.checked.scene();
        let (groups, size) = (scene.groups.len(), scene.eye.resolution);
        run(&self.world, plan, groups, size, seed, limits, &mut Told(progress))
    }

    /// The layers of a run in linear Rec.709, cd/m², the data layers, and the record of the run. `seed`: that of the run.
    ///
    /// # Errors
    /// Light that is not finite.
    pub fn frame(&self, plan: &Plan, outcome: &Outcome, seed: u64) -> Result<Frame> {
        let scene = self.checked.scene();
        let finished = picture(scene, plan, outcome, ColourSpace::Rec709)?;
        let mut frame = finished.frame;
        let [width, height] = scene.eye.resolution;
        add_data_layers(&mut frame, data_layers(&self.world, width, height));
        add_meta(&mut frame, scene, plan, outcome, seed, &finished.splits);
        Ok(frame)
    }
}

/// Writes a layered EXR under a temporary name and renames it. Returns warnings.
///
/// # Errors
/// A name that does not end in `.exr`, a place that cannot be written, a frame whose layers clash.
pub fn write(path: impl AsRef<Path>, frame: &Frame) -> Result<Vec<String>> {
    write_exr(path.as_ref(), frame)
}

/// A function that watches a run.
struct Told<F>(F);

impl<F: FnMut(&Status) -> bool> Observer for Told<F> {
    fn block(&mut self, status: &Status, _: &Films) -> bool {
        (self.0)(status)
    }
}
