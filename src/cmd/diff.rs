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
Exit code 0: no difference beyond noise; 1: different, not comparable, or not judged; 2: wrong usage or unreadable. Not \
judged is a picture without standard error in the files, such as one of a single pass; shares of a picture that is judged \
are shown without a verdict, too, unless both files are rendered with --stderr layers. --within asks no errors: it \
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
    let passes = if let Some(tolerance) = args.within {
        let found = within(&a, b, tolerance);
        print(args.format, || deviations(args, &found), || serde_json::json!(found))?;
        !found.different
    } else {
        let found = compare_blocks(&a, b, args.sigma, usize::from(args.blocks));
        print(args.format, || text(args, &found), || serde_json::json!(found))?;
        match found.verdict {
            Verdict::Identical | Verdict::Same => true,
            Verdict::Different | Verdict::Unjudged => false,
        }
    };
    Ok(ExitCode::from(u8::from(!passes)))
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
    let names = format!("{} and {}", args.a.display(), name_of_b(args));
    let blocks = if found.block > 1 { format!(", in blocks of {0} × {0} pixels", found.block) } else { String::new() };
    let of = |verdict: Verdict| found.layers.iter().filter(move |layer| layer.verdict == verdict);
    let identical: Vec<&str> = of(Verdict::Identical).map(|layer| named(&layer.layer)).collect();
    let verdict = match found.verdict {
        Verdict::Identical => match identical.len() {
            1 => "identical, every bit".to_owned(),
            count => format!("identical, every bit of {count} layers"),
        },
        Verdict::Same => format!("the same at {} sigma{blocks}", found.sigma),
        Verdict::Different => format!("different at {} sigma{blocks}", found.sigma),
        Verdict::Unjudged => "not judged, neither the same nor different".to_owned(),
    };
    // What decided, first.
    let decided = match found.verdict {
        Verdict::Identical | Verdict::Same => None,
        Verdict::Different | Verdict::Unjudged => Some(found.verdict),
    };
    let decided = decided.into_iter().flat_map(of).map(|of| format!("{} ({})", named(&of.layer), of.because));
    let decided = decided.collect::<Vec<_>>().join(", ");
    let decided = if decided.is_empty() { decided } else { format!(": {decided}") };
    // Shares without errors of their own in a picture that has them.
    let open = match found.verdict {
        Verdict::Identical | Verdict::Unjudged => 0,
        Verdict::Same | Verdict::Different => of(Verdict::Unjudged).count(),
    };
    let open = if open > 0 { format!("; {open} of {} layers not judged", found.layers.len()) } else { String::new() };
    let mut lines = vec![format!("{names}: {verdict}{decided}{open}")];
    let notes = found.notes.iter().filter(|_| found.verdict != Verdict::Identical);
    lines.extend(notes.map(|note| format!("note: {note}")));
    lines.extend(found.incomparable.iter().map(|why| format!("not comparable: {why}")));
    lines.extend(found.only_in.iter().map(|(layer, which)| format!("{layer}: only in {which}")));
    lines.extend(found.layers.iter().filter_map(layer));
    if !identical.is_empty() && found.verdict != Verdict::Identical {
        lines.push(format!("identical: {}", identical.join(", ")));
    }
    lines.join("\n")
}

fn named(layer: &str) -> &str {
    if layer.is_empty() { "(default)" } else { layer }
}

/// A layer's line, unless it is identical.
fn layer(of: &LayerDifference) -> Option<String> {
    let name = named(&of.layer);
    let verdict = match of.verdict {
        Verdict::Identical => return None,
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
    Some(text)
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

    /// Two frames of one pass, of 100 and 200 cd/m²: nobody knows their errors, so nobody says that they are the same.
    /// A share of a picture that is judged takes nothing from its verdict, a picture beside it does.
    #[test]
    fn what_is_not_judged_does_not_pass() {
        let directory = tempfile::tempdir().unwrap();
        let write = |name: &str, layers: &[(&str, f32)]| {
            let path = directory.path().join(name).to_str().unwrap().to_owned();
            let mut frame = Frame::new(2, 1);
            for (layer, value) in layers {
                ["R", "G", "B"].iter().for_each(|c| frame.push(format!("{layer}{c}"), vec![*value; 2]));
            }
            write_exr(PathBuf::from(&path).as_path(), &frame).unwrap();
            path
        };
        let judged = |a: &str, b: &str| {
            let args = parse(&["diff", a, b]).unwrap();
            let [a, b] = [&args.a, &args.b[0]].map(|path| read_exr(path).unwrap());
            (run(&args).unwrap(), text(&args, &compare_blocks(&a, &b, args.sigma, 1)))
        };
        let (a, b) = (write("a", &[("", 100.0)]), write("b", &[("", 200.0)]));
        let (code, said) = judged(&a, &b);
        assert_eq!(code, ExitCode::from(1), "{said}");
        assert!(said.contains(": not judged, neither the same nor different: (default) (no standard error"), "{said}");
        assert!(!said.contains("the same at"), "{said}");
        assert_eq!(judged(&a, &a).0, ExitCode::SUCCESS);
        let with = |name: &str, other: &str, value: f32| write(name, &[("", 10.0), ("stderr.", 0.5), (other, value)]);
        let (a, b) = (with("c", "direct_led.", 1.0), with("d", "direct_led.", 1.5));
        let (code, said) = judged(&a, &b);
        assert_eq!(code, ExitCode::SUCCESS, "{said}");
        assert!(said.contains("the same at 3 sigma; 1 of 2 layers not judged\n"), "{said}");
        assert!(said.contains("\nidentical: (default)"), "{said}");
        assert_eq!(judged(&with("e", "ghost.", 1.0), &with("f", "ghost.", 1.5)).0, ExitCode::from(1));
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
        assert!(said(&a).ends_with(": identical, every bit"), "{}", said(&a));
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
