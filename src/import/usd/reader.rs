//! What is carried through the reading of a stage.

use super::attribute::Moment;
use super::composition_budget::CompositionBudget;
use super::notes::Ledger;
use super::reads::Folding;
use super::resolver::Opened;
use super::{hierarchy, implicit, material, mesh, optics, render, round_trip, skel, stage};
use crate::base::error::Result;
use crate::base::{Code, Where};
use crate::import::assembly::Assembly;
use openusd::sdf;
use openusd::usd::{Prim, Stage};
use std::path::Path;
use std::rc::Rc;

pub(super) struct Reader {
    pub stage: Stage,
    pub moment: Rc<Moment>,
    pub opened: Opened,
    pub ledger: Ledger,
    pub bound: CompositionBudget,
    pub assembly: Assembly,
    pub placed: hierarchy::Placed,
    pub meshes: mesh::Known,
    pub materials: material::Known,
    pub folding: Folding,
    pub skeletons: skel::Known,
    pub render: render::Known,
}

impl Reader {
    pub fn open(file: &Path, frame: Option<f64>) -> Result<Self> {
        let opened = Opened::default();
        let stage = stage::open(file, &opened)?;
        Ok(Reader {
            bound: CompositionBudget::new(&stage, &opened),
            stage,
            moment: Rc::new(Moment { file: file.to_owned(), frame }),
            opened,
            ledger: Ledger::new(),
            assembly: Assembly { file: file.to_owned(), ..Assembly::default() },
            placed: hierarchy::Placed::default(),
            meshes: mesh::Known::default(),
            materials: material::Known::default(),
            folding: Folding::default(),
            skeletons: skel::Known::default(),
            render: render::Known::default(),
        })
    }

    pub fn run(mut self) -> Result<Assembly> {
        let Reader { stage, moment, assembly, ledger, .. } = &mut self;
        stage::measures(stage, moment, assembly, ledger)?;
        self.assembly.optics = optics::root(&mut self)?;
        hierarchy::read(&mut self)?;
        implicit::flatten_stretched(&mut self);
        material::sort(&mut self);
        render::read(&mut self)?;
        self.assembly.stage = Some(stage::facts(&self.stage, &mut self.placed.outermost));
        round_trip::fold(&mut self.assembly, &self.placed.folds);
        let Reader { stage, moment, assembly, ledger, .. } = &mut self;
        stage::check_layers(stage, moment, assembly, ledger);
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

    /// Whether a node starts afresh from the world.
    pub fn placed_afresh(&self, node: usize) -> bool {
        self.placed.resets.contains(&node)
    }

    /// The prim at `path`, after the work of composing it was taken.
    ///
    /// # Errors
    /// An asset whose arcs multiply.
    pub fn prim(&mut self, path: &sdf::Path) -> Result<Prim> {
        self.bound.check(&self.moment, path)?;
        self.stage.prim(path.clone()).map_err(|error| self.moment.failed(path, error))
    }

    /// Takes memory for `count` things of `size` bytes that are made for the prim at `path`.
    pub fn charge(&mut self, path: &sdf::Path, count: usize, size: usize) -> Result<()> {
        let moment = &self.moment;
        self.ledger.charge(|| moment.at(path), self.opened.bytes(), count, size)
    }
}
