//! `eyebox diff`: two frames by their standard errors.

use std::path::PathBuf;
use std::process::ExitCode;

use super::{Format, print};
use crate::base::error::{Error, Result, Where};
use crate::film::frame::Frame;
use crate::output::compare::{
    Comparison, Deviation, Deviations, LayerDifference, Verdict, compare_blocks, weighted_sum, within,
};
use crate::output::exr::read_exr;

/// Compare two frames by their standard errors, layer by layer.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = "\
Exit code 0: no difference beyond noise; 1: different, or not comparable; 2: wrong usage or unreadable. Layers without \
standard error in the files are shown but not judged: render both with --stderr layers. --within asks no errors: it \
compares values, for what must agree to rounding. docs/diff.md says what is tested and what can be claimed.

Examples:
  eyebox diff before.exr after.exr
  eyebox diff reference.exr frame.exr --sigma 4 --format json
  eyebox diff path-traced.exr hybrid.exr --blocks 40
  eyebox diff mixed.exr content.exr open.exr --weights 0.99,0.01 --within 1e-6")]
pub struct DiffArgs {
    /// A frame
    #[arg(value_name = "A.exr")]
    pub a: PathBuf,
    /// The frame to compare it with; more than one with --weights
    #[arg(value_name = "B.exr", required = true)]
    pub b: Vec<PathBuf>,
    /// How rare a difference must be, over all pixels and layers together: 3 is a false alarm in 370
    #[arg(long, default_value_t = 3.0, value_parser = parse_sigma)]
    pub sigma: f64,
    /// Judge means of blocks of N × N pixels in place of single pixels: for frames of rare light
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..))]
    pub blocks: u16,
    /// No statistics: no value may differ by more than this share of its layer's peak, e.g. 1e-6
    #[arg(long, value_name = "SHARE", value_parser = parse_share, conflicts_with_all = ["sigma", "blocks"])]
    pub within: Option<f64>,
    /// Compare A with the sum of the frames after it, each times its weight
    #[arg(long, value_name = "W,…", value_delimiter = ',', allow_hyphen_values = true, requires = "within")]
    pub weights: Vec<f64>,
    /// How to print what was found
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

fn parse_sigma(text: &str) -> std::result::Result<f64, String> {
    match text.parse::<f64>() {
        Ok(sigma) if sigma > 0.0 && sigma <= 10.0 => Ok(sigma),
        Ok(_) | Err(_) => Err(format!("`{text}` is no number of sigmas; expected more than 0, at most 10")),
    }
}

fn parse_share(text: &str) -> std::result::Result<f64, String> {
    match text.parse::<f64>() {
        Ok(share) if share >= 0.0 && share.is_finite() => Ok(share),
        Ok(_) | Err(_) => Err(format!("`{text}` is no share; write e.g. 1e-6, or 0 for equal values")),
    }
}

/// Runs the command.
pub fn run(args: &DiffArgs) -> Result<ExitCode> {
    let a = read_exr(&args.a)?;
    let others = args.b.iter().map(|path| read_exr(path)).collect::<Result<Vec<Frame>>>()?;
    let b = match others.as_slice() {
        [b] if args.weights.is_empty() => b,
        [_, _, ..] if args.weights.is_empty() => {
            let at = Where::Option(args.b.get(1).map_or(String::new(), |path| path.display().to_string()));
            return Err(Error::new(at, "two frames are compared, here are more").expected("--weights with --within"));
        }
        _ => &weighted_sum(&others, &args.weights)?,
    };
    let different = if let Some(tolerance) = args.within {
        let found = within(&a, b, tolerance);
        print(args.format, || deviations(args, &found), || serde_json::json!(found))?;
        found.different
    } else {
        let found = compare_blocks(&a, b, args.sigma, usize::from(args.blocks));
        print(args.format, || text(args, &found), || serde_json::json!(found))?;
        found.different
    };
    Ok(ExitCode::from(u8::from(different)))
}

/// What B is called: the frame, or the sum.
fn name_of_b(args: &DiffArgs) -> String {
    let term = |(index, path): (usize, &PathBuf)| match args.weights.get(index) {
        Some(weight) => format!("{weight} × {}", path.display()),
        None => path.display().to_string(),
    };
    args.b.iter().enumerate().map(term).collect::<Vec<_>>().join(" + ")
}

fn deviations(args: &DiffArgs, found: &Deviations) -> String {
    let mut lines: Vec<String> = found.incomparable.iter().map(|why| format!("not comparable: {why}")).collect();
    lines.extend(found.only_in.iter().map(|(layer, which)| format!("{layer}: only in {which}")));
    lines.extend(found.layers.iter().map(|of| {
        let name = if of.layer.is_empty() { "(default)" } else { &of.layer };
        let Deviation { x, y, a, b, relative, peak, .. } = of;
        match (of.different, *relative == 0.0) {
            (_, true) => format!("{name}: equal"),
            (different, false) => format!(
                "{name}: {}, {relative:.3e} of the peak of {peak:.6} at ({x}, {y}): {a} and {b}",
                if different { "DIFFERENT" } else { "the same" },
            ),
        }
    }));
    let verdict = if found.different { "different" } else { "the same" };
    let names = format!("{} and {}", args.a.display(), name_of_b(args));
    lines.push(format!("{names}: {verdict} to {:e} of the peak", found.tolerance));
    lines.join("\n")
}

fn text(args: &DiffArgs, found: &Comparison) -> String {
    let (a, b) = (args.a.display(), name_of_b(args));
    let verdict = if found.different { "different" } else { "the same" };
    let blocks = if found.block > 1 { format!(", in blocks of {0} × {0} pixels", found.block) } else { String::new() };
    // What decided, first.
    let differ = found.layers.iter().filter(|layer| layer.verdict == Verdict::Different);
    let differ: Vec<String> = differ.map(|layer| format!("{} ({})", named(&layer.layer), layer.because)).collect();
    let differ = if differ.is_empty() { String::new() } else { format!(": {}", differ.join(", ")) };
    let mut lines = vec![format!("{a} and {b}: {verdict} at {} sigma{blocks}{differ}", found.sigma)];
    lines.extend(found.notes.iter().map(|note| format!("note: {note}")));
    lines.extend(found.incomparable.iter().map(|why| format!("not comparable: {why}")));
    lines.extend(found.only_in.iter().map(|(layer, which)| format!("{layer}: only in {which}")));
    lines.extend(found.layers.iter().map(layer));
    lines.join("\n")
}

fn named(layer: &str) -> &str {
    if layer.is_empty() { "(default)" } else { layer }
}

fn layer(of: &LayerDifference) -> String {
    let name = named(&of.layer);
    let verdict = match of.verdict {
        Verdict::Identical => return format!("{name}: identical"),
        Verdict::Same => "same",
        Verdict::Different => "DIFFERENT",
        Verdict::Unjudged => "not judged",
    };
    let mut text = format!("{name}: {verdict}, {}; mean {:.6} and {:.6}", of.because, of.mean[0], of.mean[1]);
    if let (Some(independent), Some(most)) = (of.error_if_independent, of.error_at_most) {
        text += &format!(", B − A = {:+.4} ± {independent:.4} (at most ± {most:.4})", of.difference);
    }
    if let Some(pair) = of.largest.filter(|pair| pair.z.is_finite()) {
        text += &format!(", largest z {:+.2} at ({}, {}), p {:.2e}", pair.z, pair.x, pair.y, pair.p);
    }
    if let Some([mean, expected]) = of.mean_z2 {
        text += &format!(", mean z² {mean:.3} (noise alone {expected:.3})");
    }
    text += &format!(", relMSE {:.3e}", of.relative_mse);
    if let Some(noise) = of.relative_mse_of_noise {
        text += &format!(" (noise alone {noise:.3e})");
    }
    text
}

#[cfg(test)]
mod tests {
    use clap::{Args, FromArgMatches};

    use super::*;
    use crate::film::frame::Frame;
    use crate::output::exr::write_exr;

    fn parse(words: &[&str]) -> std::result::Result<DiffArgs, clap::Error> {
        let command = DiffArgs::augment_args(clap::Command::new("diff"));
        command.try_get_matches_from(words).map(|matches| DiffArgs::from_arg_matches(&matches).unwrap())
    }

    #[test]
    fn exit_codes_and_text() {
        let directory = tempfile::tempdir().unwrap();
        let write = |name: &str, width: usize, light: f32| {
            let path = directory.path().join(name).to_str().unwrap().to_owned();
            let mut frame = Frame::new(width, 1);
            for (layer, value) in [("", light), ("stderr.", 0.5)] {
                ["R", "G", "B"].iter().for_each(|c| frame.push(format!("{layer}{c}"), vec![value; width]));
            }
            write_exr(PathBuf::from(&path).as_path(), &frame).unwrap();
            path
        };
        let (a, b, c, d) = (write("a", 3, 10.0), write("b", 3, 10.5), write("c", 3, 20.0), write("d", 2, 10.0));
        let code = |other: &str| run(&parse(&["diff", &a, other]).unwrap()).unwrap();
        assert_eq!(code(&a), ExitCode::SUCCESS);
        assert_eq!(code(&b), ExitCode::SUCCESS, "0.7 standard errors");
        assert_eq!(code(&c), ExitCode::from(1));
        assert_eq!(code(&d), ExitCode::from(1));
        let said = |other: &str| {
            let args = parse(&["diff", &a, other]).unwrap();
            text(&args, &compare_blocks(&read_exr(&args.a).unwrap(), &read_exr(&args.b[0]).unwrap(), args.sigma, 1))
        };
        assert!(said(&c).contains("(default): DIFFERENT, pixel (0, 0) is 14.14 standard errors off"), "{}", said(&c));
        assert!(said(&d).contains("not comparable: size: 3 × 1 and 2 × 1"), "{}", said(&d));
        assert!(said(&a).contains("identical"));
        assert!(run(&parse(&["diff", &a, "gone.exr"]).unwrap()).is_err());
        for bad in ["0", "-1", "x", "NaN", "11"] {
            assert!(parse(&["diff", &a, &b, "--sigma", bad]).is_err(), "{bad}");
        }
        // 20 is twice 10, and 10 + 20 · ½; no error is asked.
        let code = |words: &[&str]| run(&parse(&[&["diff", &c, &a], words].concat()).unwrap());
        assert_eq!(code(&["--within", "1e-6", "--weights", "2"]).unwrap(), ExitCode::SUCCESS);
        assert_eq!(code(&["--within", "1e-6", "--weights", "2.0001"]).unwrap(), ExitCode::from(1));
        assert_eq!(code(&[&c, "--within", "0", "--weights", "1,0.5"]).unwrap(), ExitCode::SUCCESS);
        assert_eq!(code(&["--within", "0.5"]).unwrap(), ExitCode::SUCCESS, "half of the peak");
        assert_eq!(code(&["--within", "0.4"]).unwrap(), ExitCode::from(1));
        assert_eq!(code(&["--blocks", "2"]).unwrap(), ExitCode::from(1));
        assert!(
            code(&["--within", "0", "--weights", "1,2"]).unwrap_err().to_string().contains("2 weights for 1 frames")
        );
        assert!(code(&[&c]).unwrap_err().to_string().contains("here are more"));
        assert!(code(&[&d, "--within", "0", "--weights", "1,2"]).unwrap_err().to_string().contains("size"));
        for bad in
            [&["--weights", "1"][..], &["--within", "-1"], &["--within", "1", "--sigma", "2"], &["--blocks", "0"]]
        {
            assert!(parse(&[&["diff", &a, &b], bad].concat()).is_err(), "{bad:?}");
        }
        let help = DiffArgs::augment_args(clap::Command::new("diff")).render_long_help().to_string();
        assert!(help.contains("eyebox diff before.exr after.exr"), "{help}");
    }
}
