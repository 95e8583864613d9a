//! The plan as an artefact: everything that was decided before pass 0, with a hash, so that shards and later runs share it.

use super::Asked;
use eyebox_base::{Error, Result, Where};
use eyebox_film::plan::Plan;
use eyebox_scene::Scene;
use std::path::Path;

/// A plan and what it was made for.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PlanFile {
    /// Version of the program that made it.
    pub eyebox: String,
    /// Hash of the scene that it is for.
    pub scene: String,
    /// Width and height of the picture, pixels.
    pub resolution: [usize; 2],
    pub asked: Asked,
    pub plan: Plan,
    /// BLAKE3 of all the above as JSON, in hexadecimal digits.
    pub hash: String,
}

impl PlanFile {
    pub fn new(scene: &Scene, asked: Asked, plan: &Plan) -> PlanFile {
        let mut frozen = PlanFile {
            eyebox: env!("CARGO_PKG_VERSION").to_owned(),
            scene: scene.hash.clone(),
            resolution: scene.eye.resolution,
            asked,
            plan: plan.clone(),
            hash: String::new(),
        };
        frozen.hash = frozen.computed();
        frozen
    }

    fn computed(&self) -> String {
        let all = (&self.eyebox, &self.scene, self.resolution, self.asked, &self.plan);
        let bytes = serde_json::to_vec(&all).unwrap_or_default();
        blake3::hash(&bytes).to_hex().to_string()
    }

    /// Reads a plan for a scene. Errors: no such file, no plan, one that was changed after it was made, or one that is for
    /// another scene, resolution, request or version.
    pub fn read(path: &Path, scene: &Scene, asked: Asked) -> Result<PlanFile> {
        let fault = |what: String| Error::new(Where::file(path), what);
        let text = std::fs::read_to_string(path).map_err(|error| fault(format!("cannot be read: {error}")))?;
        let frozen: PlanFile = serde_json::from_str(&text)
            .map_err(|error| fault(format!("is no plan: {error}")).expected("what `eyebox plan -o` writes"))?;
        frozen.fits(path, scene, asked)
    }

    /// A plan that was stored in a file, for a scene. Errors: those of [`PlanFile::read`].
    pub fn of_value(value: &serde_json::Value, path: &Path, scene: &Scene, asked: Asked) -> Result<PlanFile> {
        let frozen: PlanFile = serde_json::from_value(value.clone())
            .map_err(|error| Error::new(Where::file(path), format!("has no plan: {error}")))?;
        frozen.fits(path, scene, asked)
    }

    fn fits(self, path: &Path, scene: &Scene, asked: Asked) -> Result<PlanFile> {
        let fault = |what: String| Error::new(Where::file(path), what);
        let frozen = self;
        let mine = PlanFile { hash: String::new(), ..PlanFile::new(scene, asked, &frozen.plan) };
        let differs = |what: &str, got: String, want: String| Err(fault(format!("is for {what} {got}")).expected(want));
        if frozen.eyebox != mine.eyebox {
            return differs("version", frozen.eyebox, mine.eyebox);
        }
        if frozen.resolution != mine.resolution {
            let text = |[w, h]: [usize; 2]| format!("{w}x{h}");
            return differs("the resolution", text(frozen.resolution), text(mine.resolution));
        }
        if frozen.scene != mine.scene {
            return differs(
                "the scene",
                frozen.scene,
                format!("{}: the asset or its attributes have changed", mine.scene),
            );
        }
        if frozen.asked != mine.asked {
            return differs("the request", format!("{:?}", frozen.asked), format!("{asked:?}"));
        }
        if frozen.computed() != frozen.hash {
            return Err(
                fault("was changed after it was made: its hash does not fit".to_owned()).expected(frozen.computed())
            );
        }
        frozen.plan.check(scene.groups.len(), scene.parts.len()).map_err(fault)?;
        Ok(frozen)
    }
}
