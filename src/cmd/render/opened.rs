//! The first step of a rendering: from the files to what can be traced.

use super::Run;
use crate::base::{Error, Result, Where};
use crate::check::check;
use crate::estimate::picture::check_layers;
use crate::estimate::slides;
use crate::import::Built;
use crate::plan::{Asked, Guides};
use crate::scene::Scene;
use crate::scene::assembly::RequestedLayer;
use crate::world::World;

/// What was opened.
pub struct Opened {
    pub scene: Scene,
    pub world: World,
    /// The asset's own resolution: the path table has it, so that its numbers are those of `eyebox paths`.
    pub own: [usize; 2],
    /// Layers that the asset asks for, where the command line asks for none.
    pub wishes: Vec<RequestedLayer>,
    pub asked: Asked,
    /// The scene one frame later, for `--motion`.
    pub later: Option<Scene>,
}

impl Run<'_> {
    pub fn open(&self) -> Result<Opened> {
        let args = &self.args;
        let Built { mut scene, layers, .. } = args.source.import()?;
        let own = scene.eye.resolution;
        if let Some(resolution) = args.resolution {
            scene.eye.resolution = resolution;
        }
        let polarisation = args.polarisation.asked();
        self.pool.install(|| args.source.adapt_eye(&mut scene, polarisation, &|| self.is_stopped()))?;
        self.check_crop(scene.eye.resolution)?;
        check(&scene)?;
        check_layers(&args.layers, &scene.groups, &slides::names(&scene))?;
        let world = World::freeze(&scene)?;
        let guides = if args.unguided { Guides::Off } else { Guides::On };
        let asked = Asked { choice: args.estimator.choice(), polarisation: args.polarisation.asked(), guides };
        let wishes = if args.layers.is_empty() { layers } else { Vec::new() };
        let later = args.motion.then(|| self.later(scene.eye.resolution)).transpose()?;
        Ok(Opened { scene, world, own, wishes, asked, later })
    }

    fn check_crop(&self, [width, height]: [usize; 2]) -> Result<()> {
        match self.args.crop {
            Some(crop) if !crop.fits([width, height]) => {
                let at = Where::Option(format!("--crop {crop}"));
                Err(Error::new(at, "reaches out of the picture")
                    .expected(format!("a part of {width} x {height} pixels")))
            }
            Some(_) | None => Ok(()),
        }
    }

    fn later(&self, resolution: [usize; 2]) -> Result<Scene> {
        let args = &self.args;
        let Some(frame) = args.source.moment.frame else {
            let at = Where::Option("--motion".to_owned());
            return Err(Error::new(at, "without a frame there is no next one").expected("--frame or --frames with it"));
        };
        let mut scene = args.of_frame(args.output.clone(), frame + 1.0).source.import()?.scene;
        scene.eye.resolution = resolution;
        // Where things are is asked of it, not how they look.
        scene.eye.adapts = false;
        Ok(scene)
    }
}
