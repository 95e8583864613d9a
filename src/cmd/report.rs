//! `eyebox report`: a frame as one page.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::{Format, print};
use crate::base::atomic::{check_writable, write_atomic};
use crate::base::error::{Error, Result, Where};
use crate::film::frame::Frame;
use crate::output::exr::read_exr;
use crate::output::report::{Page, page_with};
use crate::plan::scan::{Scan, charts};

/// Make one page of a frame: pictures that recombine live, measurements, light paths, plan, convergence.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = "\
The page is one file that loads nothing: it can be mailed, kept beside the frame or shown by a CI job. Further frames of the \
same scene, with more or fewer passes, add their errors to the convergence plot; so does a frame rendered with --convergence.

Examples:
  eyebox report hud.exr -o report.html
  eyebox report hud.exr hud_16.exr hud_64.exr -o report.html
  eyebox scan hud.optics.toml --eyebox 3x3 -o eyebox.json; eyebox report hud.exr --scan eyebox.json -o report.html")]
pub struct ReportArgs {
    /// The frame to show, and further frames of the same scene
    #[arg(value_name = "FRAME.exr", required = true)]
    pub frames: Vec<PathBuf>,
    /// A scan of the same display (`eyebox scan -o SCAN.json`): distortion grids, maps of distance and ghosts are drawn from each of its
    /// positions
    #[arg(long, value_name = "SCAN.json")]
    pub scan: Option<PathBuf>,
    /// The page to write
    #[arg(short, long, value_name = "OUT.html")]
    pub output: PathBuf,
    /// How to print what was written
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Runs the command.
pub fn run(args: &ReportArgs) -> Result<ExitCode> {
    let is_html = |end: &std::ffi::OsStr| end.eq_ignore_ascii_case("html") || end.eq_ignore_ascii_case("htm");
    if !args.output.extension().is_some_and(is_html) {
        return Err(Error::new(Where::Option(format!("--output {}", args.output.display())), "not a page's name")
            .expected("a name that ends in .html"));
    }
    check_writable(&args.output)?;
    let name = |path: &PathBuf| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    let read = |path: &PathBuf| Ok((name(path), read_exr(path)?));
    let frames = args.frames.iter().map(read).collect::<Result<Vec<(String, Frame)>>>()?;
    let frames: Vec<(String, &Frame)> = frames.iter().map(|(name, frame)| (name.clone(), frame)).collect();
    let more = args.scan.as_deref().map(scanned).transpose()?.unwrap_or_default();
    let made = page_with(&frames, &more).map_err(|mut fault| {
        if let (Where::Nowhere, Some(first)) = (&fault.at, args.frames.first()) {
            fault.at = Where::file(first);
        }
        fault
    })?;
    write_atomic(&args.output, made.html.as_bytes())?;
    let json = || {
        serde_json::json!({
            "output": args.output, "bytes": made.html.len(), "size": made.size, "factor": made.factor, "layers": made.layers,
            "unmixed": made.unmixed,
        })
    };
    print(args.format, || text(args, &made), json)?;
    Ok(ExitCode::SUCCESS)
}

/// The section of a scan's file.
fn scanned(path: &Path) -> Result<String> {
    /// What `eyebox scan` writes, as far as it is drawn.
    #[derive(serde::Deserialize)]
    struct File {
        scan: Scan,
    }
    let at = || Where::file(path);
    let bytes = std::fs::read(path).map_err(|fault| Error::new(at(), format!("can't be read: {fault}")))?;
    let file: File = serde_json::from_slice(&bytes).map_err(|fault| {
        let place = Where::Line { file: path.to_owned(), line: fault.line() };
        // Names of the file's own may be in it, on several lines.
        let why: String = fault.to_string().chars().map(|c| if c.is_control() { ' ' } else { c }).take(200).collect();
        Error::new(place, format!("is no scan: {why}")).expected("a file of `eyebox scan -o SCAN.json`")
    })?;
    charts::section(&file.scan).map_err(|mut fault| {
        fault.at = at();
        fault
    })
}

fn text(args: &ReportArgs, made: &Page) -> String {
    let Page { html, size: [width, height], factor, layers, unmixed } = made;
    let mut lines: Vec<String> =
        unmixed.iter().map(|why| format!("warning: the page has no sliders for its light: {why}")).collect();
    let reduced = if *factor > 1 { format!(", each the mean of {factor} × {factor}") } else { String::new() };
    let megabytes = html.len() as f64 / 1e6;
    let output = args.output.display();
    lines.push(format!("{output}: {width} × {height} pixels{reduced}, {layers} layers, {megabytes:.1} MB"));
    lines.join("\n")
}
