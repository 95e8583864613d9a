//! A design loop: how far away the virtual image stands as the collimator's glass changes.
//! `cargo run --release --ignore-rust-version --example scan_a_parameter`.

use eyebox::prelude::*;

/// One over the distance of the virtual image at the middle of the eyebox, 1/m, for each glass of the lens.
pub fn dioptres(asset: &str, part: &str, glasses: &[&str]) -> Result<Vec<f64>> {
    let asked = ScanAsked {
        positions: [1, 1],
        size_m: [None; 2],
        ipd_m: 0.064,
        points: [5, 3],
        target: None,
        light: None,
        edges: false,
    };
    let one = |glass: &&str| {
        let scene = open(asset, &[&format!("{part}.glass={glass}")])?;
        let scan = scan(&scene, &asked, &|| false, |_| {})?.expect("nobody stops it");
        let distance = scan.positions[0].distance.as_ref();
        Ok(distance.map_or(f64::NAN, |distance| distance.mean_per_m))
    };
    glasses.iter().map(one).collect()
}

#[allow(dead_code)] // tests run `dioptres`
fn main() -> Result<()> {
    let asset = concat!(env!("CARGO_MANIFEST_DIR"), "/samples/hud-direct/hud.optics.toml");
    let glasses = ["N-BK7", "N-SK16", "N-SF6"];
    for (glass, per_m) in glasses.iter().zip(dioptres(asset, "LENS_02_NBK7", &glasses)?) {
        println!("{glass}: {per_m:+.3} 1/m");
    }
    Ok(())
}
