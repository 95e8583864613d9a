//! `eyebox merge`: shards as one frame.

use super::ending::{ending, stated};
use super::{Format, print};
use crate::base::Result;
use crate::base::atomic::check_writable;
use crate::base::ids::GroupId;
use crate::estimate::picture::{add_sharpness, add_stated_error, add_sums, add_witness};
use crate::estimate::run::Stop;
use crate::estimate::shard::merge;
use crate::film::sharpness::Sharpness;
use crate::output::exr::write_exr;
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    eyebox render hud.optics.toml -o hud.1.exr --samples 64 --shard 1/2\n  \
    eyebox render hud.optics.toml -o hud.2.exr --samples 64 --shard 2/2\n  \
    eyebox merge hud.1.exr hud.2.exr -o hud.exr")]
pub struct MergeArgs {
    /// What `render --shard` wrote, in any order.
    #[arg(required = true, value_name = "SHARD.exr")]
    shards: Vec<PathBuf>,
    /// The EXR to write: to the bit the one that a run without shards writes.
    #[arg(short, long, value_name = "OUT.exr")]
    output: PathBuf,
    /// Make a picture of the shards that are there although passes are missing.
    #[arg(long)]
    partial: bool,
    /// The number that takes the place of `####` in OUT.
    #[arg(long, value_name = "TIME", value_parser = super::parse_frame, allow_negative_numbers = true)]
    frame: Option<f64>,
    /// How the summary is printed.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Runs the command.
pub fn run(args: &MergeArgs) -> Result<ExitCode> {
    let output = super::frames::named(&args.output, args.frame)?;
    check_writable(&output)?;
    let merged = merge(&args.shards, args.partial)?;
    let finishing = &merged.head.finishing;
    let finished = finishing.picture(&merged.films)?;
    let mut frame = merged.picture;
    frame.channels.retain(|channel| !finishing.wanted.is_light(channel));
    frame.channels.extend(finished.frame.channels);
    let whole = merged.head.total == Some(merged.films.passes) || merged.films.films.is_empty();
    let stop = if whole { Stop::Passes } else { Stop::Asked };
    add_sums(&mut frame, &merged.films, stop, &finished.splits);
    add_stated_error(&mut frame, merged.films.relative_error());
    let sharpness = frame.text(Sharpness::KEY).and_then(|text| serde_json::from_str::<Sharpness>(text).ok());
    if let Some(mut sharpness) = sharpness {
        sharpness.applied = finished.applied;
        add_sharpness(&mut frame, &sharpness);
    }
    finishing.wanted.keep(&mut frame);
    finishing.wanted.cut(&mut frame);
    let error = merged.films.relative_error();
    let (judgement, films) = (merged.films.judgement(), &merged.films);
    let name = |group: GroupId| finishing.groups.get(group.index()).map_or(String::new(), |group| group.name.clone());
    // Where nothing is lit there are no films.
    let asked = (merged.head.total == Some(1), !films.films.is_empty());
    let ending = ending(films, judgement.as_ref(), &name, error, asked);
    let watched = frame.text("witnessReadable").is_none_or(|said| said != "switched off");
    add_witness(&mut frame, judgement.as_ref(), watched, &ending.lines);
    let warnings: Vec<String> = ending.warnings.iter().cloned().chain(write_exr(&output, &frame)?).collect();
    let text = || {
        let said = merged.outliers.iter().chain(&warnings).map(|w| format!("warning: {w}"));
        let mut lines: Vec<String> = ending.lines.iter().cloned().chain(said).collect();
        let error = stated(error, merged.films.passes);
        let (shards, passes) = (args.shards.len(), merged.films.passes);
        lines.push(format!("{}: {passes} passes of {shards} shards, {error}", output.display()));
        lines.join("\n")
    };
    let json = || {
        serde_json::json!({
            "output": output,
            "shards": args.shards,
            "passes": merged.films.passes,
            "relative_error": error,
            "outliers": merged.outliers,
            "witness": judgement,
            "warnings": warnings,
        })
    };
    print(args.format, text, json)?;
    Ok(ExitCode::from(u8::from(!merged.outliers.is_empty() || ending.finding)))
}
