//! What is carried through the reading of a stage.

use super::attribute::Moment;
use super::caches::{KnownMeshes, KnownSkeletons};
use super::composition_budget::CompositionBudget;
use super::handed::Placed;
use super::notes::Ledger;
use super::reads::Folding;
use super::resolver::Opened;
use super::{material, render, stage};
use crate::assembly::Assembly;
use crate::{ReadOptions, Rigs};
use eyebox_base::error::Result;
use openusd::sdf;
use openusd::usd::{Prim, Stage};
use std::cell::RefCell;
use std::path::Path;
use std::rc::Rc;

pub(super) struct Reader {
    pub stage: Stage,
    pub moment: Rc<Moment>,
    pub opened: Opened,
    pub ledger: Ledger,
    pub bound: CompositionBudget,
    pub assembly: Assembly,
    pub placed: Placed,
    pub meshes: KnownMeshes,
    pub materials: material::Known,
    pub folding: Folding,
    pub skeletons: KnownSkeletons,
    pub render: render::Known,
    /// Whether the rigs of meshes are read, too.
    pub rigs: Rigs,
}

impl Reader {
    pub fn open(file: &Path, options: &ReadOptions) -> Result<Self> {
        let opened = Opened::default();
        let stage = stage::open(file, &opened)?;
        Ok(Reader {
            bound: CompositionBudget::new(&stage, &opened),
            stage,
            moment: Rc::new(Moment {
                file: file.to_owned(),
                frame: options.frame,
                keys: (options.rigs == Rigs::Whole).then(RefCell::default),
            }),
            opened,
            ledger: Ledger::new(),
            assembly: Assembly { file: file.to_owned(), ..Assembly::default() },
            placed: Placed::default(),
            meshes: KnownMeshes::default(),
            materials: material::Known::default(),
            folding: Folding::default(),
            skeletons: KnownSkeletons::default(),
            render: render::Known::default(),
            rigs: options.rigs,
        })
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
