//! One asset from its file to its curves.

use super::race::{Budget, Ready, race};
use super::reference::{Source, references};
use super::{AssetReport, Report, csv, json, svg, table};
use crate::clock::{cpu_seconds, processor};
use eyebox_base::{Error, Result, Where};
use eyebox_estimate::ShouldStop;
use eyebox_import::{ImportOptions, Set, import};
use eyebox_plan::Choice;
use eyebox_scene::Scene;
use std::path::Path;

/// What is measured.
#[derive(Debug, Clone)]
pub struct Task {
    pub contenders: Vec<Choice>,
    pub source: Source,
    pub seed: u64,
    pub budget: Budget,
    /// Width and height in pixels, instead of the eye's.
    pub resolution: Option<[usize; 2]>,
    pub sets: Vec<Set>,
}

/// Imports an asset as the task wants it; also says the CPU seconds that took.
///
/// Errors: those of import, and a picture without pixels.
pub fn open(path: &Path, task: &Task) -> Result<(Scene, f64)> {
    let start = cpu_seconds();
    let mut scene = import(path, &ImportOptions { sets: task.sets.clone(), ..ImportOptions::default() })?.scene;
    if let Some(resolution) = task.resolution {
        scene.eye.resolution = resolution;
    }
    if scene.eye.resolution.contains(&0) {
        return Err(
            Error::new(Where::file(path), "the picture has no pixels").expected("a resolution of 1 × 1 or more")
        );
    }
    Ok((scene, cpu_seconds() - start))
}

/// Imports an asset and lets the contenders trace it. `stop` (Ctrl-C) is asked between turns; the curves then end where
/// they are.
///
/// Errors: those of import, checking, freezing and of reference files.
pub fn measure(path: &Path, task: &Task, stop: &ShouldStop<'_>) -> Result<AssetReport> {
    let (scene, import_seconds) = open(path, task)?;
    let ready = Ready::new(&scene, import_seconds)?;
    let (references, reference) = references(&ready, &task.source, task.seed, stop)?;
    let curves = race(&ready, &task.contenders, &references, task.seed, task.budget, stop);
    Ok(AssetReport {
        asset: path.display().to_string(),
        scene: scene.name.clone(),
        scene_hash: scene.hash.clone(),
        resolution: scene.eye.resolution,
        reference,
        curves,
    })
}

impl Report {
    /// An empty report about this machine.
    pub fn new(threads: usize, seed: u64) -> Report {
        let version = env!("CARGO_PKG_VERSION");
        Report { version, processor: processor(), threads, seed, assets: Vec::new() }
    }

    /// The report in one of its forms.
    pub fn in_form(&self, form: Form) -> String {
        match form {
            Form::Text => table::text(self),
            Form::Json => json(self),
            Form::Csv => csv::csv(self),
            Form::Svg => svg::svg(self),
            Form::Markdown => table::markdown(self),
        }
    }
}

/// How a report is written down.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    Text,
    Json,
    Csv,
    Svg,
    Markdown,
}
