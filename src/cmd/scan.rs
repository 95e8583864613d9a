//! `eyebox scan`: the virtual image over an eyebox.

use super::progress::Signals;
use super::render_args::{PolarisationArg, parse_resolution};
use super::source::{Source, told};
use super::table_file::TableFile;
use super::threads::Threads;
use super::{Format, print};
use crate::base::atomic::{check_writable, write_atomic};
use crate::base::{Error, Result, Where};
use crate::plan::Asked;
use crate::plan::scan::light::LightAsked;
use crate::plan::scan::limits::{self, Kind, Limits, NAMED, beyond};
use crate::plan::scan::table::{csv, edges_csv, ghosts_csv, lines};
use crate::plan::scan::{ScanAsked, scan};
use crate::scene::{BinocularLimits, Note, Severity};
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

/// Longer side of the short renderings, pixels.
const SIDE: usize = 120;

/// Look from a grid of eye positions: luminance, distortion, distance, disparity of the virtual image.
#[derive(Args, Debug)]
#[command(after_help = "\
The grid is centred on the scene's eye, in the plane of its pupil, and its outermost positions are on the eyebox's rim. \
Directions are found by exact rays through the specular faces, luminances by a short rendering from each position. What \
cannot be seen from a position is said so; a picture without light from some position is a warning, with exit code 1. docs/scan.md has the definitions and their sources.

Examples:
  eyebox scan hud.optics.toml --eyebox 5x3
  eyebox scan hud.optics.toml --eyebox 9x5 --width 130 --height 50 -o eyebox.csv
  eyebox scan hud.optics.toml --eyebox 3x3 --no-luminance --format json --threads 4
  eyebox scan windshield.optics.toml --eyebox 3x3 --no-luminance --ghosts ghosts.csv
  eyebox scan windshield.optics.toml --eyebox 3x3 --width 130 --height 50 --no-luminance --edges=edges.csv
  eyebox scan windshield.optics.toml --eyebox 3x3 --no-luminance --limits gu-2020,dipvergence=1 --image-distance 2.2")]
pub struct ScanArgs {
    /// Columns and rows of eye positions.
    #[arg(long, value_name = "NxM", value_parser = parse_grid)]
    eyebox: [usize; 2],
    /// Width of the eyebox, mm [default: two pupil diameters]
    #[arg(long, value_name = "MM")]
    width: Option<f64>,
    /// Height of the eyebox, mm [default: two pupil diameters]
    #[arg(long, value_name = "MM")]
    height: Option<f64>,
    /// Distance between the two eyes, mm.
    #[arg(long, value_name = "MM", default_value_t = 63.0)]
    ipd: f64,
    /// Columns and rows of points of the picture.
    #[arg(long, value_name = "NxM", value_parser = parse_grid, default_value = "9x9")]
    points: [usize; 2],
    /// The part that is the picture [default: the slide, lamp or screen that most of the field of view shows]
    #[arg(long, value_name = "PART")]
    target: Option<String>,
    /// Geometry alone, without rendering.
    #[arg(long)]
    no_luminance: bool,
    /// Passes of each short rendering.
    #[arg(long, value_name = "PASSES", default_value_t = 16, value_parser = clap::value_parser!(u64).range(1..))]
    samples: u64,
    /// Width and height of the short renderings in pixels [default: the eye's, scaled to a longer side of 120]. The picture fills
    /// them from each position.
    #[arg(long, value_name = "WxH", value_parser = parse_resolution)]
    resolution: Option<[usize; 2]>,
    /// Trace the polarisation of light in the short renderings.
    #[arg(long, value_enum, value_name = "WHEN", default_value_t)]
    polarisation: PolarisationArg,
    /// Seed of the short renderings.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    source: Source,
    #[command(flatten)]
    threads: Threads,
    /// Write the table to this file: .csv (a line per position) or .json (with every point of the picture).
    #[arg(short, long, value_name = "OUT.csv|json")]
    output: Option<PathBuf>,
    /// Write the ghosts to this file: a line per position, ghost and point of the picture.
    #[arg(long, value_name = "OUT.csv")]
    ghosts: Option<PathBuf>,
    /// Look for the eyebox's edges: how far the eye can go from its middle until less than half of the picture is seen, or half
    /// of the luminance left; with a name, write them to that file, too. Luminances take some forty renderings more.
    #[arg(long, value_name = "OUT.csv", num_args = 0..=1, require_equals = true)]
    edges: Option<Option<PathBuf>>,
    /// Hold what two eyes have to do to limits, in mrad: convergence=MRAD, divergence=MRAD, dipvergence=MRAD, or a name that has a source
    /// (genco-1983, gu-2020: see docs/scan.md); of two that limit the same the later one holds, and any before those of the sidecar's eye. What is beyond is a warning, with
    /// exit code 1.
    #[arg(long, value_name = "LIMIT", value_delimiter = ',')]
    limits: Vec<String>,
    /// Distance at which the image is meant to be, m or `inf`: limits of convergence and divergence count from there [default: the eye's].
    #[arg(long, value_name = "M")]
    image_distance: Option<f64>,
    /// No progress.
    #[arg(short, long)]
    quiet: bool,
    /// How the result is printed.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

pub(super) fn parse_grid(text: &str) -> std::result::Result<[usize; 2], String> {
    parse_resolution(text).map_err(|_| format!("`{text}` is no grid; write columns and rows, e.g. 5x3"))
}

/// Runs the command.
pub fn run(args: &ScanArgs) -> Result<ExitCode> {
    args.threads.within(|| traced(args))
}

fn traced(args: &ScanArgs) -> Result<ExitCode> {
    let written = args.output.as_deref().map(TableFile::of).transpose()?;
    let edges = args.edges.as_ref().and_then(Option::as_ref);
    for path in args.ghosts.iter().chain(edges) {
        check_writable(path)?;
    }
    let signals = Signals::install();
    let mut scene = args.source.import()?.scene;
    let limits = limited(args, scene.eye.limits)?;
    let polarisation = args.polarisation.asked();
    args.source.adapt_eye(&mut scene, polarisation, &|| signals.caught().is_some())?;
    let light = LightAsked {
        resolution: args.resolution.unwrap_or_else(|| smaller(scene.eye.resolution)),
        passes: args.samples,
        seed: args.seed,
        asked: Asked { polarisation, ..Asked::default() },
    };
    let asked = ScanAsked {
        positions: args.eyebox,
        size_m: [args.width, args.height].map(|mm| mm.map(|mm| 1e-3 * mm)),
        ipd_m: 1e-3 * args.ipd,
        points: args.points,
        target: args.target.clone(),
        light: (!args.no_luminance).then_some(light),
        edges: args.edges.is_some(),
    };
    let all = args.eyebox[0].saturating_mul(args.eyebox[1]);
    let shows = !args.quiet && !args.no_luminance;
    let stop = || signals.caught().is_some();
    let found = scan(&scene, &asked, &stop, |done| {
        if shows {
            tell!("eyebox: {done} of {all} positions");
        }
    })?;
    let Some(found) = found else {
        tell!("eyebox: stopped; nothing was written");
        return Ok(signals.exit_code());
    };
    let past = limits.map_or_else(Vec::new, |limits| beyond(&found, &limits));
    let warnings: Vec<&Note> = scene.notes.iter().filter(|note| note.severity == Severity::Warning).collect();
    let json = || {
        let held = limits
            .map(|limits| serde_json::json!({ "limits": limits, "positions": limits::held(&found), "beyond": past }));
        serde_json::json!({ "asset": args.source.asset, "scan": found, "limits": held, "warnings": warnings })
    };
    if let Some(file) = written {
        file.write(|| csv(&found), json)?;
    }
    if let Some(path) = &args.ghosts {
        write_atomic(path, ghosts_csv(&found).as_bytes())?;
    }
    if let Some((path, edges)) = edges.zip(found.edges.as_ref()) {
        write_atomic(path, edges_csv(edges).as_bytes())?;
    }
    let held = || limits.iter().flat_map(|limits| limits::lines(limits, &found, &past));
    let text = || told(&scene).into_iter().chain(lines(&found)).chain(held()).collect::<Vec<_>>().join("\n");
    print(args.format, text, json)?;
    // What could not be tested is not kept.
    let untested = limits.is_some() && limits::held(&found) == 0;
    let warned = untested || !past.is_empty() || found.positions.iter().any(|position| position.warning.is_some());
    Ok(ExitCode::from(u8::from(warned)))
}

/// The limits of the scene's eye, with those that were asked for over them.
fn limited(args: &ScanArgs, own: BinocularLimits) -> Result<Option<Limits>> {
    let mut out = Limits::default();
    for (kind, mrad) in Kind::ALL.into_iter().zip([own.convergence_mrad, own.divergence_mrad, own.dipvergence_mrad]) {
        if let Some(mrad) = mrad {
            out.set(kind, 1e-3 * mrad);
        }
    }
    for text in &args.limits {
        let at = || Where::Option(format!("--limits {text}"));
        if let Some((_, named)) = NAMED.iter().find(|(name, _)| name == text) {
            for kind in Kind::ALL {
                if let Some(rad) = named.of(kind) {
                    out.set(kind, rad);
                }
            }
            continue;
        }
        let (name, number) = text.split_once('=').unwrap_or((text, ""));
        let Some(kind) = Kind::ALL.into_iter().find(|kind| kind.name() == name) else {
            let names = NAMED.iter().map(|(name, _)| *name).chain(Kind::ALL.map(Kind::name));
            return Err(Error::new(at(), "no such limit")
                .expected("convergence, divergence or dipvergence = mrad, or genco-1983 or gu-2020")
                .nearest(name, names));
        };
        let Some(mrad) = number.parse::<f64>().ok().filter(|mrad| *mrad > 0.0 && mrad.is_finite()) else {
            return Err(Error::new(at(), format!("`{number}` is no limit")).expected("mrad above 0"));
        };
        out.set(kind, 1e-3 * mrad);
    }
    let across = out.convergence_rad.is_some() || out.divergence_rad.is_some();
    if !across && out.dipvergence_rad.is_none() {
        return match args.image_distance {
            None => Ok(None),
            Some(_) => {
                Err(Error::new(Where::Option("--image-distance".to_owned()), "there is no limit to count from there")
                    .expected("--limits, or limits of the eye in the sidecar"))
            }
        };
    }
    match args.image_distance.or(own.image_distance_m) {
        Some(distance) if distance > 0.0 => out.image_per_m = 1.0 / distance,
        Some(distance) => {
            let what = format!("--image-distance {distance}");
            return Err(Error::new(Where::Option(what), "no distance of an image").expected("metres above 0, or inf"));
        }
        None if across => {
            let what = "limits of convergence and divergence count from where the image is meant to be";
            return Err(Error::new(Where::Option("--limits".to_owned()), what).expected("--image-distance, m or inf"));
        }
        None => {}
    }
    Ok(Some(out))
}

/// The same picture with a longer side of [`SIDE`] pixels at most.
fn smaller(resolution: [usize; 2]) -> [usize; 2] {
    let scale = (SIDE as f64 / resolution[0].max(resolution[1]).max(1) as f64).min(1.0);
    resolution.map(|n| ((n as f64 * scale).round() as usize).max(1))
}
