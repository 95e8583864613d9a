//! Renders a small picture without writing a file: `cargo run --release --ignore-rust-version --example render_to_memory`.

use eyebox::prelude::*;

/// Luminance of the middle of the picture, cd/m², and the relative error that the run states.
pub fn middle_of(asset: &str) -> Result<(f32, Option<f64>)> {
    let mut scene = open(asset, &[])?;
    scene.eye.resolution = [80, 60];
    let ready = prepare(&scene)?;
    let plan = ready.plan();
    let limits = Limits { passes: Some(16), ..Limits::default() };
    let outcome = ready.render(&plan, &limits, 1, |status| {
        eprint!("\r{} passes", status.passes);
        true
    });
    eprintln!();
    let frame = ready.frame(&plan, &outcome, 1)?;
    let [_, green, _] = frame.rgb("hybrid").expect("every frame has this layer");
    Ok((green[30 * 80 + 40], outcome.films.relative_error()))
}

#[allow(dead_code)] // tests run `middle_of`
fn main() -> Result<()> {
    let asset = concat!(env!("CARGO_MANIFEST_DIR"), "/samples/hud-direct/hud.optics.toml");
    let (luminance, error) = middle_of(asset)?;
    println!("{luminance:.1} cd/m² in the middle, relative error {error:.4?}");
    Ok(())
}
