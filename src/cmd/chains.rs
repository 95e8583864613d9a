//! `render --chain`: layers that hold the light of one way through the faces.

use super::render_args::RenderArgs;
use crate::base::{Error, Result, Where};
use crate::check::{Checked, check};
use crate::estimate::ShouldStop;
use crate::estimate::picture::possible_layers;
use crate::estimate::slides;
use crate::film::frame::{Frame, Meta};
use crate::plan::paths::{self, Table, Wanted};
use crate::scene::Scene;
use crate::world::World;

/// The layers of `--chain`.
pub struct Chains {
    table: Option<Table>,
    wanted: Vec<Wanted>,
}

impl Chains {
    /// Looks them up in the path table; none if `stop` says true.
    /// `taken`: names of layers that the asset asks for.
    pub fn find(
        args: &RenderArgs,
        (scene, resolution): (&Scene, [usize; 2]),
        taken: &[String],
        stop: &ShouldStop<'_>,
    ) -> Result<Option<Chains>> {
        if args.chains.is_empty() {
            return Ok(Some(Chains { table: None, wanted: Vec::new() }));
        }
        let mut names = possible_layers(&scene.groups, &slides::names(scene));
        names.extend(taken.iter().cloned());
        for text in &args.chains {
            let name = paths::layer_name(text)?;
            if !names.insert(name.to_owned()) {
                let at = Where::Option(format!("--chain {text}"));
                return Err(Error::new(at, format!("there is a layer `{name}` already")).expected("another name"));
            }
        }
        let mut scene = scene.clone();
        scene.eye.resolution = resolution;
        let (checked, world) = (&check(&scene)?, &World::freeze(&scene)?);
        let asked = paths::Asked { polarisation: args.polarisation.asked(), ..paths::Asked::default() };
        let Some(table) = paths::table(checked, world, asked, stop) else { return Ok(None) };
        let wanted = args.chains.iter().map(|text| paths::wanted(&table, text)).collect::<Result<Vec<_>>>()?;
        Ok(Some(Chains { table: Some(table), wanted }))
    }

    /// Traces them with as many paths as the picture has pixels times passes; none if `stop` says true.
    pub fn add(
        &self,
        frame: &mut Frame,
        tracing: (&Checked, &World),
        passes: u64,
        stop: &ShouldStop<'_>,
    ) -> Option<()> {
        let Some(table) = &self.table else { return Some(()) };
        let paths = passes.saturating_mul((frame.width * frame.height) as u64);
        let pictures = paths::pictures(tracing, table, &self.wanted, paths, stop)?;
        for (wanted, picture) in self.wanted.iter().zip(pictures) {
            for channel in ["R", "G", "B"] {
                frame.push(format!("{}.{channel}", wanted.name), picture.clone());
            }
            frame.meta.insert(format!("chain.{}", wanted.name), Meta::Text(wanted.paths.join("; ")));
        }
        let json = paths::header(table, &self.wanted).to_string();
        frame.meta.insert("paths".to_owned(), Meta::Text(json));
        Some(())
    }
}
