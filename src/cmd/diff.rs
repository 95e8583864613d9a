//! `eyebox diff`: two frames by their standard errors.

use std::path::PathBuf;
use std::process::ExitCode;

use super::{Format, print};
use crate::base::fault::Result;
use crate::output::compare::{Comparison, LayerDifference, Verdict, compare};
use crate::output::exr::read_exr;

/// Compare two frames by their standard errors, layer by layer.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = "\
Exit code 0: no difference beyond noise; 1: different, or not comparable; 2: wrong usage or unreadable. Layers without \
standard error in the files are shown but not judged: render both with --stderr layers. docs/diff.md says what is \
tested and what can be claimed.

Examples:
  eyebox diff before.exr after.exr
  eyebox diff reference.exr frame.exr --sigma 4 --format json")]
pub struct DiffArgs {
    /// A frame
    #[arg(value_name = "A.exr")]
    pub a: PathBuf,
    /// The frame to compare it with
    #[arg(value_name = "B.exr")]
    pub b: PathBuf,
    /// How rare a difference must be, over all pixels and layers together: 3 is a false alarm in 370
    #[arg(long, default_value_t = 3.0, value_parser = parse_sigma)]
    pub sigma: f64,
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

/// Runs the command.
pub fn run(args: &DiffArgs) -> Result<ExitCode> {
    let found = compare(&read_exr(&args.a)?, &read_exr(&args.b)?, args.sigma);
    print(args.format, || text(args, &found), || serde_json::json!(found))?;
    Ok(ExitCode::from(u8::from(found.different)))
}

fn text(args: &DiffArgs, found: &Comparison) -> String {
    let mut lines: Vec<String> = Vec::new();
    lines.extend(found.notes.iter().map(|note| format!("note: {note}")));
    lines.extend(found.incomparable.iter().map(|why| format!("not comparable: {why}")));
    lines.extend(found.only_in.iter().map(|(layer, which)| format!("{layer}: only in {which}")));
    lines.extend(found.layers.iter().map(layer));
    let (a, b) = (args.a.display(), args.b.display());
    let verdict = if found.different { "different" } else { "the same" };
    lines.push(format!("{a} and {b}: {verdict} at {} sigma", found.sigma));
    lines.join("\n")
}

fn layer(of: &LayerDifference) -> String {
    let name = if of.layer.is_empty() { "(default)" } else { &of.layer };
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
            text(&args, &compare(&read_exr(&args.a).unwrap(), &read_exr(&args.b).unwrap(), args.sigma))
        };
        assert!(said(&c).contains("(default): DIFFERENT, pixel (0, 0) is 14.14 standard errors off"), "{}", said(&c));
        assert!(said(&d).contains("not comparable: size: 3 × 1 and 2 × 1"), "{}", said(&d));
        assert!(said(&a).contains("identical"));
        assert!(run(&parse(&["diff", &a, "gone.exr"]).unwrap()).is_err());
        for bad in ["0", "-1", "x", "NaN", "11"] {
            assert!(parse(&["diff", &a, &b, "--sigma", bad]).is_err(), "{bad}");
        }
        let help = DiffArgs::augment_args(clap::Command::new("diff")).render_long_help().to_string();
        assert!(help.contains("eyebox diff before.exr after.exr"), "{help}");
    }
}
