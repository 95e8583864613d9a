//! `eyebox job`: a rendering for a farm.

use super::frames::{Frames, Pattern, named, parse_frames};
use super::render_args::RenderArgs;
use super::{Format, print};
use crate::base::atomic::write_atomic;
use crate::base::relative_path::placed;
use crate::base::{Error, Result, Where};
use crate::import::ReadOptions;
use crate::import::deps::dependencies;
use crate::output::job::{Job, yaml};
use clap::Args;
use std::path::{Component, Path, PathBuf};
use std::process::ExitCode;

/// Write an Open Job Description template that renders an asset in shards and merges them.
#[derive(Args, Debug)]
#[command(after_help = "\
`openjd run job.yaml` runs it on this machine, farm engines that know the form run it on many. Each frame has a plan, N \
shards under it, and a merge; a shard that is stopped goes on from its checkpoint.

Examples:
  eyebox job hud.optics.toml --shards 7 -o job.yaml
  eyebox job hud.usda --shards 4 --frames 1-48 --output 'hud.####.exr' -o job.yaml
  eyebox job hud.optics.toml --shards 16 --samples 1024 --set led.flux_lm=0.5 -o job.yaml -- --stderr layers")]
pub struct JobArgs {
    /// Sidecar (*.optics.toml) or asset (.glb, .gltf, .usda, .usdc, .usdz).
    asset: PathBuf,
    /// Pieces that the passes of a frame are cut into.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=10_000))]
    shards: u64,
    /// Time codes of a USD asset or frames of a glTF one: A-B, or A-BxS for every S-th.
    #[arg(long, value_name = "A-B[xS],…", value_parser = parse_frames, allow_hyphen_values = true)]
    frames: Option<Frames>,
    /// The template to write: YAML, or JSON if the name says so.
    #[arg(short = 'o', long = "job", value_name = "JOB.yaml")]
    job: PathBuf,
    /// The merged picture, beside the template if no folder is named; `#` stands for the digits of the frame.
    #[arg(long, value_name = "OUT.exr")]
    output: Option<PathBuf>,
    /// Passes of all shards together.
    #[arg(long, value_name = "PASSES", default_value_t = 64, value_parser = clap::value_parser!(u64).range(1..))]
    samples: u64,
    /// Seed of the random numbers.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Width and height in pixels, instead of the eye's.
    #[arg(long, value_name = "WxH")]
    resolution: Option<String>,
    /// Which way of tracing light to use, as for `render`.
    #[arg(long, value_name = "ESTIMATOR")]
    estimator: Option<String>,
    /// Whether polarisation is traced, as for `render`.
    #[arg(long, value_name = "WHEN")]
    polarisation: Option<String>,
    /// Start and aim paths without what pilots learned, as for `render`.
    #[arg(long)]
    unguided: bool,
    /// Change an attribute: PART-OR-GROUP.ATTRIBUTE=VALUE.
    #[arg(long = "set", value_name = "TARGET.ATTRIBUTE=VALUE")]
    sets: Vec<String>,
    /// Further options of `render`, after `--`.
    #[arg(last = true, value_name = "OPTIONS")]
    render: Vec<String>,
    /// How the summary is printed.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Runs the command.
pub fn run(args: &JobArgs) -> Result<ExitCode> {
    // openjd takes a template by its name for YAML or JSON.
    let ends = |wanted: &str| args.job.extension().is_some_and(|e| e.eq_ignore_ascii_case(wanted));
    if !["yaml", "yml", "json"].into_iter().any(ends) {
        return Err(Error::new(Where::Option(format!("--job {}", args.job.display())), "is no name for a template")
            .expected("a name that ends in .yaml, .yml or .json"));
    }
    // What workers would find missing one by one.
    if let Err(error) = std::fs::metadata(&args.asset) {
        return Err(Error::new(Where::file(&args.asset), format!("cannot be read: {error}")));
    }
    let files: Vec<PathBuf> = dependencies(&args.asset, &ReadOptions::default())?
        .into_iter()
        .filter(|file| file.there)
        .map(|file| placed(&file.file))
        .collect();
    let asset = placed(&args.asset);
    let folder = files.iter().fold(parent(&asset), |common, file| shared(&common, &parent(file)));
    let stem = asset.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let stem = stem.split('.').next().unwrap_or("frame");
    let default = if args.frames.is_some() { format!("{stem}.####.exr") } else { format!("{stem}.exr") };
    let output = args.output.clone().unwrap_or_else(|| parent(&args.job).join(default));
    let output = if output.components().count() == 1 { parent(&args.job).join(output) } else { output };
    // A template without a place for the frame's digits would write all frames to one file.
    let text = output.to_string_lossy();
    if Pattern::has_place(&output) != args.frames.is_some() {
        let what = format!("`{text}` and the frames do not fit each other");
        return Err(Error::new(Where::Option("--output".to_owned()), what)
            .expected("hud.####.exr with --frames, hud.exr without"));
    }
    named(&output, args.frames.as_ref().map(|_| 0.0))?;
    // Names of shards are made of it, so there is one way to write it.
    let output = if args.frames.is_some() { Pattern::of(&output)?.hashed() } else { output };
    let output = placed(&output);
    let mut plan_options = Vec::new();
    let mut option = |name: &str, value: &Option<String>| {
        if let Some(value) = value {
            plan_options.extend([name.to_owned(), value.clone()]);
        }
    };
    option("--resolution", &args.resolution);
    option("--estimator", &args.estimator);
    option("--polarisation", &args.polarisation);
    args.sets.iter().for_each(|set| option("--set", &Some(set.clone())));
    plan_options.extend(args.unguided.then(|| "--unguided".to_owned()));
    let words = plan_options.iter().chain(&args.render);
    if let Some(word) = words.clone().find(|word| word.contains("{{")) {
        let what = format!("`{word}` would be read as a format string by the farm");
        return Err(Error::new(Where::Option(word.clone()), what).expected("no {{ in options"));
    }
    of_render_alone(&args.render)?;
    check_options(&plan_options, &args.render)?;
    if folder.parent().is_none() {
        let what = "and its files have no folder in common";
        return Err(Error::new(Where::file(&asset), what).expected("files below one folder, which workers get"));
    }
    let home = parent(&placed(&args.job));
    let job = Job {
        name: stem.to_owned(),
        asset: below(&asset, &home)?,
        asset_folder: below(&folder, &home)?,
        output_folder: below(&parent(&output), &home)?,
        output: output.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default(),
        shards: args.shards,
        samples: args.samples,
        seed: args.seed,
        frames: args
            .frames
            .as_ref()
            .map(|frames| frames.ranges().iter().map(|range| (range.first, range.last, range.step)).collect()),
        plan_options,
        render_options: args.render.clone(),
        checkpoint_s: 60,
    };
    let template = job.template();
    let text = if ends("json") { format!("{template:#}\n") } else { yaml(&template) };
    write_atomic(&args.job, text.as_bytes())?;
    let tasks = args.frames.as_ref().map_or(1, Frames::count);
    let places = [("Asset", &job.asset, &asset), ("AssetFolder", &job.asset_folder, &folder)];
    let output_folder = parent(&output);
    let places = places.into_iter().chain([("OutputFolder", &job.output_folder, &output_folder)]);
    let missing = places.filter(|(_, default, _)| default.is_none());
    let parameters: Vec<String> = missing.map(|(name, _, path)| format!("{name}={}", path.display())).collect();
    let said = || {
        let given: Vec<String> = parameters.iter().map(|parameter| format!(" -p '{parameter}'")).collect();
        let frames = if tasks == 1 { "1 frame".to_owned() } else { format!("{tasks} frames") };
        let job = args.job.display();
        format!("{job}: {frames} of {} shards; openjd run {job}{}", args.shards, given.concat())
    };
    let json =
        || serde_json::json!({ "job": args.job, "frames": tasks, "shards": args.shards, "parameters": parameters });
    print(args.format, said, json)?;
    Ok(ExitCode::SUCCESS)
}

/// What the plan depends on, too, is no option of `render` alone: workers would refuse a plan that was made without it.
fn of_render_alone(render: &[String]) -> Result<()> {
    const OF_BOTH: [&str; 5] = ["--resolution", "--estimator", "--polarisation", "--unguided", "--set"];
    let of_both = |word: &&String| OF_BOTH.contains(&word.split('=').next().unwrap_or_default());
    render.iter().find(of_both).map_or(Ok(()), |word| {
        Err(Error::new(Where::Option(word.clone()), "is for the plan, too").expected("it before `--`"))
    })
}

/// Whether `render` takes these options: better now than on every worker.
fn check_options(plan: &[String], render: &[String]) -> Result<()> {
    let own = ["--shard", "1/1", "--checkpoint", "60s", "--resume", "-o", "out.exr", "--samples", "1", "--seed", "0"];
    let words = own.into_iter().chain(["asset"]).map(str::to_owned).chain(plan.iter().chain(render).cloned());
    let command = RenderArgs::augment_args(clap::Command::new("render").no_binary_name(true));
    command
        .try_get_matches_from(words)
        .map(drop)
        .map_err(|error| Error::new(Where::Option("options of render".to_owned()), super::one_line(&error.to_string())))
}

fn parent(path: &Path) -> PathBuf {
    path.parent().map(Path::to_owned).unwrap_or_default()
}

/// The folder that holds both.
fn shared(a: &Path, b: &Path) -> PathBuf {
    a.components().zip(b.components()).take_while(|(a, b)| a == b).map(|(a, _): (Component<'_>, _)| a).collect()
}

/// A path from the template's folder, if it lies below; a template can hold no other.
fn below(path: &Path, home: &Path) -> Result<Option<String>> {
    let Ok(path) = path.strip_prefix(home) else { return Ok(None) };
    match path.to_str() {
        Some("") => Ok(Some(".".to_owned())),
        Some(text) if !text.contains("{{") => Ok(Some(text.to_owned())),
        Some(_) | None => {
            Err(Error::new(Where::file(path), "cannot stand in a job template").expected("a Unicode path without {{"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::FromArgMatches;

    #[test]
    fn what_no_worker_could_run_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let sample = concat!(env!("CARGO_MANIFEST_DIR"), "/samples/hud-direct/hud.optics.toml");
        let fault_of = |asset: &str, job: &str, render: &[&str]| {
            let job = folder.path().join(job);
            let words = ["job", asset, "--shards", "2", "-o", job.to_str().unwrap(), "--"];
            let words = words.iter().chain(render);
            let matches = JobArgs::augment_args(clap::Command::new("job")).get_matches_from(words);
            let ended = run(&JobArgs::from_arg_matches(&matches).unwrap());
            assert_eq!(ended.is_ok(), job.is_file());
            ended.err().map(|fault| fault.to_string())
        };
        let fault = |asset: &str, job: &str| fault_of(asset, job, &[]);
        assert_eq!(fault(sample, "job.yaml"), None);
        assert_eq!(fault_of(sample, "matte.yaml", &["--cryptomatte"]), None);
        for option in ["--resolution=48x24", "--resolution", "--set"] {
            let said = fault_of(sample, "b.yaml", &[option, "48x24"]).unwrap();
            assert_eq!(said, format!("{option}: is for the plan, too; expected it before `--`"));
        }
        assert!(fault("nothing.glb", "a.yaml").unwrap().starts_with("nothing.glb: cannot be read: "));
        assert!(fault(sample, "job.txt").unwrap().ends_with("expected a name that ends in .yaml, .yml or .json"));
    }
    /// A sidecar whose sky stands in a folder beside its own: workers get the folder that holds both.
    #[test]
    fn the_folder_of_the_asset_holds_every_file() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir_all(folder.path().join("hud")).unwrap();
        std::fs::create_dir_all(folder.path().join("panorama")).unwrap();
        std::fs::write(folder.path().join("panorama/day.hdr"), "#?RADIANCE").unwrap();
        let sidecar = "schema = 1\nasset = \"hud.gltf\"\n[sky]\nimage = \"../panorama/day.hdr\"\n";
        std::fs::write(folder.path().join("hud/hud.optics.toml"), sidecar).unwrap();
        let gltf = r#"{ "asset": { "version": "2.0" }, "scenes": [{ "nodes": [] }], "scene": 0 }"#;
        std::fs::write(folder.path().join("hud/hud.gltf"), gltf).unwrap();
        let [asset, job] = ["hud/hud.optics.toml", "job.json"].map(|name| folder.path().join(name));
        let words = ["job", asset.to_str().unwrap(), "--shards", "2", "-o", job.to_str().unwrap()];
        let matches = JobArgs::augment_args(clap::Command::new("job")).get_matches_from(words);
        run(&JobArgs::from_arg_matches(&matches).unwrap()).unwrap();
        let template: serde_json::Value = serde_json::from_slice(&std::fs::read(&job).unwrap()).unwrap();
        let default = |name: &str| {
            let all = template["parameterDefinitions"].as_array().unwrap();
            all.iter().find(|one| one["name"] == name).unwrap()["default"].clone()
        };
        assert_eq!([default("Asset"), default("AssetFolder")], ["hud/hud.optics.toml", "."]);
    }
}
