//! Time against error: several estimators trace the same scene in turn, and each point of their curves is measured
//! against two independent references. docs/bench.md defines the figures.

pub mod asset;
pub mod bias;
pub mod cells;
pub mod csv;
pub mod error;
pub mod fit;
pub mod picture;
pub mod race;
pub mod reference;
pub mod svg;
pub mod table;

use error::Error;
use eyebox_base::document::document;
use eyebox_film::plan::Estimator;
use eyebox_plan::Choice;
use fit::Reach;

/// Errors whose seconds are told.
pub const LEVELS: [f64; 3] = [1e-2, 1e-3, 1e-4];

/// The automatic choice and each estimator on its own.
pub fn contenders() -> Vec<Choice> {
    std::iter::once(Choice::Auto).chain(Estimator::ALL.map(Choice::Only)).collect()
}

/// What a choice is called on the command line.
pub fn name(choice: Choice) -> &'static str {
    match choice {
        Choice::Auto => "auto",
        Choice::Only(estimator) => estimator.name(),
    }
}

/// A picture on the way.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Point {
    pub passes: u64,
    /// CPU seconds of tracing, without the setup.
    pub seconds: f64,
    /// Eye and lamp paths.
    pub paths: u64,
    pub error: Error,
}

/// What one choice of estimator did.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Curve {
    pub estimator: &'static str,
    /// The estimators that had work.
    pub runs: Vec<&'static str>,
    /// CPU seconds of import, freezing, plan and pilots: the curve's offset.
    pub setup_seconds: f64,
    pub points: Vec<Point>,
    pub paths_per_second: f64,
    /// Of log relMSE over log seconds of tracing, where the references can tell the error.
    pub slope: Option<f64>,
    /// CPU seconds, setup included, to each of [`LEVELS`].
    pub reach: Vec<Reach>,
    /// The same for the trimmed error.
    pub reach_trimmed: Vec<Reach>,
    /// The same for the error over flat pixels; empty where there are none.
    pub reach_flat: Vec<Reach>,
}

/// Where the references come from, and what they are worth.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ReferenceFacts {
    /// The estimator, or the two files.
    pub from: String,
    /// Passes of each; none for files.
    pub passes: Option<[u64; 2]>,
    /// CPU seconds of both together.
    pub seconds: f64,
    /// Mean luminance, cd/m².
    pub mean: f64,
    /// relMSE of either.
    pub noise: f64,
    /// The smallest relMSE that they can tell from none.
    pub resolution: f64,
    /// Pixels whose neighbours are alike, and all.
    pub flat_pixels: [usize; 2],
    /// Blocks in which a bias is looked for; none if the references don't know the light of the whole to a tenth.
    pub known_blocks: Option<usize>,
    /// What a sound picture's worst block may deviate, in standard errors.
    pub most_sigma: f64,
}

/// The curves of one asset.
#[derive(Debug, Clone, serde::Serialize)]
pub struct AssetReport {
    pub asset: String,
    pub scene: String,
    pub scene_hash: String,
    /// Pixels.
    pub resolution: [usize; 2],
    pub reference: ReferenceFacts,
    pub curves: Vec<Curve>,
}

/// The whole measurement.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Report {
    /// Of the program, as every document of it says.
    #[serde(rename = "eyebox")]
    pub version: &'static str,
    pub processor: String,
    pub threads: usize,
    pub seed: u64,
    pub assets: Vec<AssetReport>,
}

/// The report for programs; numbers that are none are `null`.
pub fn json(report: &Report) -> String {
    document(serde_json::json!(report)) + "\n"
}

#[cfg(test)]
mod tests;
