//! `eyebox measure`: what a frame measures as a display.

use std::path::PathBuf;
use std::process::ExitCode;

use super::{Format, print};
use crate::base::error::{Result, Where};
use crate::output::exr::read_exr;
use crate::output::measure::{Quantity, Target, measure};

/// Measure a frame as a display: luminances, contrast, leak, ghost, sharpness, colour, field of view.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = "\
Each value has an interval of 95 % from the standard errors in the file, or a sentence why not. Render with --stderr \
layers for those of the display's own light. docs/measure.md has the definitions and their sources.

Examples:
  eyebox measure hud.exr
  eyebox measure hud.exr --edge 120,40,40x30 --format json")]
pub struct MeasureArgs {
    /// The frame to measure
    #[arg(value_name = "FRAME.exr")]
    pub frame: PathBuf,
    /// The display's light groups [default: the one that the slide modulates]
    #[arg(long, value_name = "GROUP,…", value_delimiter = ',')]
    pub display: Vec<String>,
    /// A region with one straight edge, slanted against the pixels: left, top, width, height
    #[arg(long, value_name = "X,Y,WxH", value_parser = parse_region)]
    pub edge: Option<Region>,
    /// How to print the results
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Left, top, width and height, pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Region(pub [usize; 4]);

fn parse_region(text: &str) -> std::result::Result<Region, String> {
    let numbers: Vec<&str> = text.split([',', 'x', 'X', '×']).map(str::trim).collect();
    let bad = || format!("`{text}` is no region; write e.g. 120,40,40x30");
    match numbers.as_slice() {
        [x, y, width, height] => {
            let number = |text: &str| text.parse::<usize>().map_err(|_| bad());
            Ok(Region([number(x)?, number(y)?, number(width)?, number(height)?]))
        }
        _ => Err(bad()),
    }
}

/// Runs the command.
pub fn run(args: &MeasureArgs) -> Result<ExitCode> {
    let found = measured(args)?;
    let json = || serde_json::json!({ "frame": args.frame.display().to_string(), "quantities": found });
    print(args.format, || found.iter().map(line).collect::<Vec<_>>().join("\n"), json)?;
    Ok(ExitCode::SUCCESS)
}

fn measured(args: &MeasureArgs) -> Result<Vec<Quantity>> {
    let frame = read_exr(&args.frame)?;
    let target = Target { groups: args.display.clone(), edge: args.edge.map(|region| region.0) };
    measure(&frame, &target).map_err(|mut fault| {
        if fault.at == Where::Nowhere {
            fault.at = Where::file(&args.frame);
        }
        fault
    })
}

fn line(of: &Quantity) -> String {
    let unit = if of.unit.is_empty() { String::new() } else { format!(" {}", of.unit) };
    let Some(value) = of.value else { return format!("{}: not measured: {}", of.name, of.note) };
    let interval = of.interval.map_or(String::new(), |[low, high]| format!(" [{low:.5}, {high:.5}]"));
    let note = if of.note.is_empty() { String::new() } else { format!(" ({})", of.note) };
    format!("{}: {value:.5}{unit}{interval}{note}", of.name)
}

#[cfg(test)]
mod tests {
    use clap::{Args, FromArgMatches};

    use super::*;
    use crate::film::frame::{Frame, Meta};
    use crate::output::exr::write_exr;

    fn parse(words: &[&str]) -> std::result::Result<MeasureArgs, clap::Error> {
        let command = MeasureArgs::augment_args(clap::Command::new("measure"));
        command.try_get_matches_from(words).map(|matches| MeasureArgs::from_arg_matches(&matches).unwrap())
    }

    #[test]
    fn values_and_sentences() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("f.exr");
        let mut frame = Frame::new(12, 12);
        frame.meta.insert("groups".into(), Meta::Text("[\"led\"]".into()));
        for layer in ["", "forward.", "forward_led."] {
            ["R", "G", "B"].iter().for_each(|c| frame.push(format!("{layer}{c}"), vec![40.0; 144]));
        }
        write_exr(&path, &frame).unwrap();
        let words = ["measure", path.to_str().unwrap()];
        let lines: Vec<String> = measured(&parse(&words).unwrap()).unwrap().iter().map(line).collect();
        assert!(
            lines[0].starts_with("adaptation luminance, arithmetic: 40.00000 cd/m² (mean of all pixels; no interval")
        );
        assert!(lines.iter().any(|line| line.contains("not measured: no light group depends on a slide")), "{lines:?}");
        assert!(lines.iter().any(|line| line.contains("not measured: say where one edge is: --edge")));
        let fault = |more: &[&str]| measured(&parse(&[&words, more].concat()).unwrap()).unwrap_err().to_string();
        assert!(
            fault(&["--edge", "5,5,10x10"]).contains("not inside the picture; expected a region of 12 × 12 pixels")
        );
        assert!(fault(&["--display", "lad"]).contains("did you mean `led`?"));
        assert!(parse(&["measure", "f.exr", "--edge", "1,2,3"]).is_err());
        assert_eq!(parse_region("120,40,40x30"), Ok(Region([120, 40, 40, 30])));
        let help = MeasureArgs::augment_args(clap::Command::new("measure")).render_long_help().to_string();
        assert!(help.contains("eyebox measure hud.exr --edge 120,40,40x30"), "{help}");
    }
}
