//! The steps in which a stage becomes an assembly.

use super::reader::Reader;
use super::{hierarchy, implicit, layer_units, material, optics, render, round_trip, stage, variants};
use crate::assembly::Assembly;
use crate::variants::VariantChoice;
use eyebox_base::error::Result;
use eyebox_base::{Code, Where};
use eyebox_scene::motion::Clock;

/// What USD takes where a stage does not say its `timeCodesPerSecond`.
const CODES_PER_SECOND: f64 = 24.0;

impl Reader {
    pub fn run(mut self, variants: &[VariantChoice]) -> Result<Assembly> {
        variants::choose(&mut self, variants)?;
        self.assembly.variants = variants.iter().map(ToString::to_string).collect();
        let Reader { stage, moment, assembly, ledger, .. } = &mut self;
        stage::measures(stage, moment, assembly, ledger)?;
        self.assembly.optics = optics::root(&mut self)?;
        hierarchy::read(&mut self)?;
        implicit::flatten_stretched(&mut self);
        material::sort(&mut self);
        render::read(&mut self)?;
        self.assembly.stage = Some(stage::facts(&self.stage, &mut self.placed.outermost));
        round_trip::fold(&mut self.assembly, &self.placed.folds);
        self.assembly.clock = self.clock();
        let Reader { stage, moment, assembly, ledger, .. } = &mut self;
        layer_units::check(stage, moment, assembly, ledger);
        stage::note_errors(stage, moment, ledger);
        if self.assembly.nodes.is_empty() {
            self.ledger.warn_of(
                Code::NothingToTrace,
                Where::file(&self.moment.file),
                "the stage has no prims that are placed anywhere",
            );
        }
        let mut dependencies = stage::dependencies(&self.moment.file, &self.opened);
        dependencies.append(&mut self.assembly.dependencies);
        self.assembly.dependencies = dependencies;
        self.assembly.notes = self.ledger.notes.finish();
        Ok(self.assembly)
    }

    /// When what was read has values of its own, in time codes.
    fn clock(&self) -> Option<Clock> {
        let keys = self.moment.keys.as_ref()?.borrow().times();
        let times = self.assembly.stage.as_ref().map_or(&[][..], |stage| &stage.times);
        let said = times.iter().find(|(key, _)| *key == "timeCodesPerSecond").map(|(_, rate)| *rate);
        let rate = said.filter(|rate| rate.is_finite() && *rate > 0.0).unwrap_or(CODES_PER_SECOND);
        Some(Clock { rate, name: String::new(), keys })
    }
}
