//! `eyebox mix`: one rendering, recombined.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::{Format, print};
use crate::base::atomic::check_writable;
use crate::base::fault::{Fault, Result, Where};
use crate::film::frame::Frame;
use crate::output::exr::{read_exr, write_exr};
use crate::output::join::join;
use crate::output::mix::{Mixed, Recipe, Record, add_record, mix};
use crate::output::plate::place;
use crate::output::shares::Rendering;
use crate::output::solve::{Goal, Solved, solve};
use crate::output::view::{ViewOptions, write_view};

/// Change lamp levels, the slide's contrast and the background of a rendered frame, without rendering again.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = "\
Several frames are added up: renderings of one assembly with different light groups on. What is not changed keeps its \
bits. --contrast needs the layers GROUP_open and GROUP_content, --plate needs seethrough, another contrast's stderr \
needs a frame rendered with --stderr layers. What was done is in the header of the EXR, eyebox.mix.

Examples:
  eyebox mix hud.exr --gain led=0.25 --contrast 1000 -o dim.exr
  eyebox mix hud.exr --gain sky=0 --plate street.exr --solve contrast=1.5 -o street.png
  eyebox mix hud.exr --solve leak=hidden -o night.exr")]
pub struct MixArgs {
    /// The frames to mix
    #[arg(value_name = "FRAME.exr", required = true)]
    pub frames: Vec<PathBuf>,
    /// The EXR to write, with the layers of the frame, or a PNG as `eyebox view` makes it
    #[arg(short, long, value_name = "OUT.exr|png")]
    pub output: PathBuf,
    /// Factor on the light of a group; `plate` is the group of a plate
    #[arg(long = "gain", value_name = "GROUP=G", value_parser = parse_gain)]
    pub gains: Vec<(String, f64)>,
    /// Contrast T_white/T_black of the slide, 1 to inf; 300:1 is 300 [default: as rendered]
    #[arg(long, value_name = "C", value_parser = parse_contrast)]
    pub contrast: Option<f64>,
    /// A picture in cd/m², as large as the frame, to put behind the optics
    #[arg(long, value_name = "BACKGROUND.exr")]
    pub plate: Option<PathBuf>,
    /// Find the lamp level: contrast=X of the picture against its background, or leak=hidden
    #[arg(long, value_name = "contrast=X|leak=hidden", value_parser = Goal::parse)]
    pub solve: Option<Goal>,
    /// The groups whose level --solve looks for [default: the one that the slide modulates]
    #[arg(long, value_name = "GROUP,…", value_delimiter = ',', requires = "solve")]
    pub solve_for: Vec<String>,
    /// How to print what was done
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

fn parse_gain(text: &str) -> std::result::Result<(String, f64), String> {
    let bad = || format!("`{text}` is no gain; write e.g. led=0.25");
    // A group's name may hold anything, a number holds no `=`.
    let (group, gain) = text.rsplit_once('=').ok_or_else(bad)?;
    Ok((group.trim().to_owned(), gain.trim().parse().map_err(|_| bad())?))
}

fn parse_contrast(text: &str) -> std::result::Result<f64, String> {
    let number = text.trim().strip_suffix(":1").unwrap_or(text.trim());
    number.parse().map_err(|_| format!("`{text}` is no contrast; write e.g. 300, 300:1 or inf"))
}

/// Runs the command.
pub fn run(args: &MixArgs) -> Result<ExitCode> {
    let (json, text) = mixed(args)?;
    print(args.format, || text, || json)?;
    Ok(ExitCode::SUCCESS)
}

/// Writes the mixture and says what was done, for programs and for people.
fn mixed(args: &MixArgs) -> Result<(serde_json::Value, String)> {
    let ends = |wanted: &str| args.output.extension().is_some_and(|e| e.eq_ignore_ascii_case(wanted));
    if !ends("exr") && !ends("png") {
        return Err(Fault::new(Where::Option(format!("--output {}", args.output.display())), "not an EXR's name")
            .expected("a name that ends in .exr or .png"));
    }
    check_writable(&args.output)?;
    let frames = args.frames.iter().map(|path| read_exr(path)).collect::<Result<Vec<Frame>>>()?;
    let first = args.frames.first().map_or(Path::new(""), PathBuf::as_path);
    let mut frame = join(&frames).map_err(|fault| within(fault, first))?;
    drop(frames);
    let mut warnings = Vec::new();
    if let Some(path) = &args.plate {
        let plate = read_exr(path)?;
        let (placed, doubled) = place(&frame, &plate).map_err(|fault| within(fault, path))?;
        frame = placed;
        // A gain of 0 has answered it.
        let silenced =
            |warning: &String| args.gains.iter().any(|(g, gain)| *gain == 0.0 && warning.contains(&format!("`{g}`")));
        warnings.extend(doubled.filter(|warning| !silenced(warning)));
    }
    let mut recipe = Recipe { gains: args.gains.clone(), contrast: args.contrast };
    let (mixed, solved) = recombine(args, &frame, &mut recipe).map_err(|fault| within(fault, first))?;
    let mut record = Record {
        frames: args.frames.iter().map(|path| path.display().to_string()).collect(),
        gains: recipe.gains.clone(),
        contrast: None,
        plate: args.plate.as_ref().map(|path| path.display().to_string()),
        solved,
        errors: mixed.errors,
    };
    record.gains.retain(|(_, gain)| *gain != 1.0);
    record.contrast = frame.number("contrast").zip(mixed.frame.number("contrast")).map(|(a, b)| [a, b]);
    let chain = |layer: &String| format!("`{layer}` was left out: a chain's layer does not say whose light it is");
    warnings.extend(mixed.left_out.iter().map(chain));
    let mut out = mixed.frame;
    add_record(&mut out, &record);
    let mut json = serde_json::json!({ "output": args.output.display().to_string(), "mix": record });
    if ends("png") {
        let info = write_view(&args.output, &out, &ViewOptions::default())?;
        json["view"] = serde_json::json!(info);
    } else {
        warnings.extend(write_exr(&args.output, &out)?);
    }
    json["warnings"] = serde_json::json!(warnings);
    Ok((json, text(args, &record, &warnings)))
}

fn recombine(args: &MixArgs, frame: &Frame, recipe: &mut Recipe) -> Result<(Mixed, Option<Solved>)> {
    let rendering = Rendering::of(frame)?;
    let solved = args.solve.map(|goal| solve(&rendering, recipe, &args.solve_for, goal)).transpose()?;
    if let Some(solved) = &solved {
        recipe.gains.extend(solved.groups.iter().map(|group| (group.clone(), solved.gain)));
    }
    Ok((mix(&rendering, recipe)?, solved))
}

/// A fault of a frame's contents gets the frame's name.
fn within(mut fault: Box<Fault>, path: &Path) -> Box<Fault> {
    if fault.at == Where::Nowhere {
        fault.at = Where::file(path);
    }
    fault
}

fn text(args: &MixArgs, record: &Record, warnings: &[String]) -> String {
    let mut lines: Vec<String> = warnings.iter().map(|warning| format!("warning: {warning}")).collect();
    if let Some(solved) = &record.solved {
        let Solved { picture_cd_m2, background_cd_m2, leak_cd_m2, contrast, visibility, leak_spot_cd_m2, .. } = solved;
        lines.push(format!(
            "--solve {}: {} × {:.6}: picture {picture_cd_m2:.4}, background {background_cd_m2:.4}, leak {leak_cd_m2:.4} \
             cd/m², contrast {contrast:.4}",
            solved.goal,
            solved.groups.join(", "),
            solved.gain
        ));
        if solved.at_every_level {
            lines.push("it holds at every lamp level: the lamps are left as they are".to_owned());
        }
        let seen = if visibility.visible { "visible" } else { "hidden" };
        lines.push(format!(
            "leak: brightest patch {leak_spot_cd_m2:.4} cd/m², {:.3} of the threshold of {:.4} cd/m² at an adaptation to \
             {:.2} cd/m²: {seen}",
            visibility.factor, visibility.threshold_cd_m2, visibility.adaptation_cd_m2
        ));
    }
    let mut done: Vec<String> = record.gains.iter().map(|(group, gain)| format!("{group} × {gain}")).collect();
    if let Some([before, after]) = record.contrast
        && before != after
    {
        done.push(format!("contrast {before} to {after}"));
    }
    done.extend(record.plate.iter().map(|plate| format!("plate {plate}")));
    let unchanged = done.is_empty();
    if unchanged {
        done.push("nothing changed".to_owned());
    }
    let errors = if unchanged { String::new() } else { format!("; {}", record.errors.said()) };
    lines.push(format!("{}: {}{errors}", args.output.display(), done.join(", ")));
    lines.join("\n")
}

#[cfg(test)]
mod tests;
