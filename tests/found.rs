//! What use has found: assets of others that came out wrong, with the values that are right. Their files are in `tests/data/found`.

mod coats;
mod emission;
mod films;
mod normals;
mod overlap;
mod reading;
mod usd_light;

use crate::common::{image, mean, render};
use eyebox::import::{Built, ImportOptions, Set, import};
use eyebox::plan::Asked;
use std::path::{Path, PathBuf};

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/found").join(name)
}

fn read(path: &Path, sets: &[&str]) -> Built {
    let sets = sets.iter().map(|text| Set::parse(text).unwrap_or_else(|fault| panic!("{fault}"))).collect();
    let options = ImportOptions { sets, ..ImportOptions::default() };
    import(path, &options).unwrap_or_else(|fault| panic!("{}: {fault}", path.display()))
}

/// Mean luminance of a picture and its standard error, cd/m².
fn seen(path: &Path, sets: &[&str], asked: impl Into<Asked>, passes: u64) -> (f64, f64) {
    let mut scene = read(path, sets).scene;
    // A picture of an asset alone is large.
    scene.eye.resolution = scene.eye.resolution.map(|pixels| pixels.min(16));
    mean(&image(&render(&scene, asked, passes, 7).0))
}

fn is_near((found, error): (f64, f64), want: f64, share: f64) -> bool {
    (found - want).abs() < share * want + 4.0 * error
}

/// The texts of an asset's warnings.
fn warnings(built: &Built) -> Vec<String> {
    let warnings = built.scene.notes.iter().filter(|note| note.severity == eyebox::scene::Severity::Warning);
    warnings.map(|note| note.text.clone()).collect()
}
