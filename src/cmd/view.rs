//! `eyebox view`: a layer of a frame as a PNG to look at.

use std::path::PathBuf;
use std::process::ExitCode;

use super::{Format, print};
use crate::base::atomic::check_writable;
use crate::base::error::{Error, Result, Where};
use crate::film::sharpness::Sharpness;
use crate::output::contact_sheet::write_contact_sheet;
use crate::output::exr::read_exr;
use crate::output::picture_sheet::picture_sheet;
use crate::output::tone::Adaptation;
use crate::output::view::{Shown, ViewInfo, ViewOptions, write_view};

/// Show a layer of an EXR as an 8-bit sRGB PNG.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = "\
Without --exposure a picture is toned so that what an eye adapted to the mean luminance of the default image can just \
see is just visible on a display of 100 cd/m² (Ward 1994). The exposure this amounts to is printed: give it to another \
frame to compare the two. Data layers (Z, normal, position) are scaled to their range; pixels that are not a number \
are magenta.

--glare adds the light that the eye scatters (CIE 135/1:1999, the age of the eye in the header). --false-colour shows \
luminances on a logarithmic scale of four decades, with a legend.

Examples:
  eyebox view frame.exr -o view.png
  eyebox view frame.exr -o seen.png --adaptation foveal --glare
  eyebox view frame.exr -o scale.png --layer forward_led --false-colour
  eyebox view frame.exr -o sheet.png --contact-sheet
  eyebox view frame.exr -o forward.png --layer forward --exposure -3.5
  eyebox view day.exr night.exr -o both.png --caption \"By day\" --caption \"By night\"")]
pub struct ViewArgs {
    /// The frame to show; several go on one sheet
    #[arg(value_name = "FRAME.exr", required = true)]
    pub frames: Vec<PathBuf>,
    /// The PNG to write
    #[arg(short, long, value_name = "VIEW.png")]
    pub output: PathBuf,
    /// The layer, or the full name of one channel [default: the default image]
    #[arg(long)]
    pub layer: Option<String>,
    /// Stops; 0 shows luminances as they are on a display of 100 cd/m² [default: Ward's visibility matching]
    #[arg(long, allow_negative_numbers = true, value_name = "STOPS")]
    pub exposure: Option<f64>,
    /// Which mean luminance of the default image the eye is adapted to
    #[arg(long, value_enum, value_name = "MEAN", default_value_t)]
    pub adaptation: AdaptationArg,
    /// Show pictures as they fall on the retina, with the light that is scattered in the eye
    #[arg(long)]
    pub glare: bool,
    /// Show luminances as colours on a scale, with a legend
    #[arg(long, conflicts_with_all = ["exposure", "adaptation"])]
    pub false_colour: bool,
    /// Show all layers side by side
    #[arg(long, conflicts_with_all = ["layer", "false_colour"])]
    pub contact_sheet: bool,
    /// What to write under a frame of a sheet, once per frame [default: its name]
    #[arg(long, value_name = "TEXT")]
    pub caption: Vec<String>,
    /// Frames of a sheet side by side [default: 2]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=64))]
    pub columns: Option<u16>,
    /// How to print what was done
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum AdaptationArg {
    /// Of all pixels
    #[default]
    Arithmetic,
    /// Of the logarithms of all pixels above 0
    Log,
    /// Within 1° of the middle
    Foveal,
}

impl AdaptationArg {
    fn kind(self) -> Adaptation {
        match self {
            AdaptationArg::Arithmetic => Adaptation::Arithmetic,
            AdaptationArg::Log => Adaptation::Log,
            AdaptationArg::Foveal => Adaptation::Foveal,
        }
    }
}

/// Runs the command.
pub fn run(args: &ViewArgs) -> Result<ExitCode> {
    let (json, text) = view(args)?;
    print(args.format, || text, || json)?;
    Ok(ExitCode::SUCCESS)
}

/// Writes the PNG and says what was done, for programs and for people.
/// Errors: an output that is no `.png`, and those of reading the frame and writing the view.
fn view(args: &ViewArgs) -> Result<(serde_json::Value, String)> {
    if !args.output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png")) {
        return Err(Error::new(Where::Option(format!("--output {}", args.output.display())), "not a PNG's name")
            .expected("a name that ends in .png"));
    }
    check_writable(&args.output)?;
    let defaults = ViewOptions::default();
    let options = ViewOptions {
        layer: args.layer.clone(),
        exposure: args.exposure,
        adaptation: args.adaptation.kind(),
        glare: args.glare,
        false_colour: args.false_colour,
        ..defaults
    };
    let [path] = args.frames.as_slice() else { return sheet(args, &options) };
    if !args.caption.is_empty() || args.columns.is_some() {
        return Err(Error::new(Where::Option("--caption, --columns".to_owned()), "are for sheets of several frames"));
    }
    let frame = read_exr(path)?;
    if args.contact_sheet {
        let [width, height] = write_contact_sheet(&args.output, &frame, &options)?;
        let json = serde_json::json!({
            "frame": path.display().to_string(),
            "output": args.output.display().to_string(),
            "layers": frame.layer_names(),
            "contact_sheet": [width, height],
        });
        let count = frame.layer_names().len();
        return Ok((json, format!("{}: contact sheet of {count} layers, {width} × {height}", args.output.display())));
    }
    let info = write_view(&args.output, &frame, &options)?;
    let json = serde_json::json!({
        "frame": path.display().to_string(),
        "output": args.output.display().to_string(),
        "layers": frame.layer_names(),
        "view": info,
    });
    Ok((json, text(args, &info)))
}

/// Several frames on one sheet.
fn sheet(args: &ViewArgs, options: &ViewOptions) -> Result<(serde_json::Value, String)> {
    if args.contact_sheet {
        return Err(Error::new(Where::Option("--contact-sheet".to_owned()), "shows the layers of one frame"));
    }
    let count = args.frames.len();
    if !args.caption.is_empty() && args.caption.len() != count {
        let what = format!("{} captions for {count} frames", args.caption.len());
        return Err(Error::new(Where::Option("--caption".to_owned()), what).expected("one per frame, or none"));
    }
    let mut frames = Vec::with_capacity(count);
    for (index, path) in args.frames.iter().enumerate() {
        let name = || path.file_stem().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        frames.push((read_exr(path)?, args.caption.get(index).cloned().unwrap_or_else(name)));
    }
    let sheet = picture_sheet(&frames, args.columns.map_or(2, usize::from), options)?;
    sheet.write_png(&args.output)?;
    let json = serde_json::json!({
        "frames": args.frames.iter().map(|path| path.display().to_string()).collect::<Vec<_>>(),
        "output": args.output.display().to_string(),
        "sheet": [sheet.width, sheet.height],
    });
    let (output, [width, height]) = (args.output.display(), [sheet.width, sheet.height]);
    Ok((json, format!("{output}: sheet of {count} frames, {width} × {height}")))
}

/// One line for people.
fn text(args: &ViewArgs, info: &ViewInfo) -> String {
    let layer = if info.layer.is_empty() { "default image" } else { &info.layer };
    let ViewInfo { width, height, nonfinite_pixels, .. } = info;
    let mut text = format!("{}: {layer}, {width} × {height}", args.output.display());
    match info.shown {
        Shown::Picture | Shown::Fraction => {
            if let Some(mean) = info.adaptation_cd_m2 {
                text += &format!(", adapted to {mean:.4} cd/m²");
            }
            if let Some(stops) = info.exposure_stops {
                text += &format!(", --exposure {stops:.4}");
            }
            if let Some([low, high]) = info.range {
                text += &format!(", false colours from {low} to {high} cd/m²");
            }
            if let Some(sharpness) = &info.diffraction {
                text += &limit(sharpness);
            }
        }
        Shown::Vector | Shown::Scalar => {
            if let Some([low, high]) = info.range {
                text += &format!(", values {low} to {high}");
            }
        }
    }
    if *nonfinite_pixels > 0 {
        text += &format!("; {nonfinite_pixels} pixels are not a number (magenta)");
    }
    text
}

/// `, diffraction limit 4.7′ …`: of the group that it blurs most.
fn limit(sharpness: &Sharpness) -> String {
    let Some(worst) = sharpness.worst() else { return String::new() };
    let (limit, width) = (worst.limit_arcmin, worst.lit_width_mm);
    let said = format!(", diffraction limit {limit:.2}′ ({}, lit pupil {width:.2} mm)", worst.group);
    match (&sharpness.applied, sharpness.pixels()) {
        (Some(_), _) => said + ", applied",
        (None, Some(pixels)) if pixels > 1.0 => {
            format!("{said} = {pixels:.1} pixels: the picture is geometric, detail finer than this is not there")
        }
        (None, _) => said,
    }
}

#[cfg(test)]
mod tests {
    use clap::{Args, FromArgMatches};

    use super::*;
    use crate::film::frame::Frame;
    use crate::output::exr::write_exr;

    fn parse(words: &[&str]) -> ViewArgs {
        let command = ViewArgs::augment_args(clap::Command::new("view"));
        ViewArgs::from_arg_matches(&command.try_get_matches_from(words).unwrap()).unwrap()
    }

    #[test]
    fn shows_a_layer_and_says_how() {
        let directory = tempfile::tempdir().unwrap();
        let (exr, png) = (directory.path().join("f.exr"), directory.path().join("v.png"));
        let (exr_text, png_text) = (exr.to_str().unwrap(), png.to_str().unwrap());
        let mut frame = Frame::new(2, 1);
        for name in ["R", "G", "B", "caustic.R", "caustic.G", "caustic.B"] {
            frame.push(name, vec![50.0, 50.0]);
        }
        write_exr(&exr, &frame).unwrap();

        let (json, text) = view(&parse(&["view", exr_text, "-o", png_text])).unwrap();
        assert_eq!(json["layers"], serde_json::json!(["", "caustic"]));
        assert_eq!(json["view"]["exposure_stops"].as_f64().map(f64::round), Some(0.0));
        assert!(text.contains("adapted to 50.0000 cd/m²"), "{text}");
        // 50 of 100 cd/m² at 0 stops is linear 0.5: sRGB 188; one stop down linear 0.25: 137.
        assert_eq!(image::open(&png).unwrap().into_rgb8().into_raw(), [188; 6]);
        view(&parse(&["view", exr_text, "-o", png_text, "--layer", "caustic", "--exposure", "-1"])).unwrap();
        assert_eq!(image::open(&png).unwrap().into_rgb8().into_raw(), [137; 6]);

        let fault = view(&parse(&["view", exr_text, "-o", png_text, "--layer", "causic"])).unwrap_err();
        assert!(fault.to_string().contains("did you mean `caustic`?"), "{fault}");
        assert!(view(&parse(&["view", exr_text, "-o", exr_text])).unwrap_err().to_string().contains(".png"));
        assert!(view(&parse(&["view", png_text, "-o", png_text])).is_err(), "a PNG is no EXR");

        let pair = ["view", exr_text, exr_text, "-o", png_text, "--caption", "one"];
        assert!(view(&parse(&pair)).unwrap_err().to_string().contains("1 captions for 2 frames"));
        let (_, text) = view(&parse(&[&pair[..], &["--caption", "two", "--columns", "1"]].concat())).unwrap();
        assert!(text.contains("sheet of 2 frames"), "{text}");
        assert!(view(&parse(&["view", exr_text, "-o", png_text, "--columns", "3"])).is_err());
    }

    #[test]
    fn says_how_sharp_the_picture_can_be() {
        use crate::film::frame::Meta;
        use crate::film::pupil::Pupil;
        use crate::film::sharpness::{Applied, GroupPupil};

        let directory = tempfile::tempdir().unwrap();
        let (exr, png) = (directory.path().join("f.exr"), directory.path().join("v.png"));
        let words = ["view", exr.to_str().unwrap(), "-o", png.to_str().unwrap()];
        let pupil = GroupPupil { group: "led".into(), pupil: Pupil::full(4e-3), because: "all of it".into() };
        let shown = |sharpness: &Sharpness| {
            let mut frame = Frame::new(1, 1);
            ["R", "G", "B"].iter().for_each(|name| frame.push(*name, vec![50.0]));
            frame.meta.insert(Sharpness::KEY.into(), Meta::Text(serde_json::to_string(sharpness).unwrap()));
            write_exr(&exr, &frame).unwrap();
            view(&parse(&words)).unwrap()
        };
        // λ over the side of the square of the pupil's area: 550 nm/3.545 mm = 0.533′.
        let mut sharpness = Sharpness::new(std::slice::from_ref(&pupil), 550.0, [1e-3; 2]);
        let (json, text) = shown(&sharpness);
        assert!(text.ends_with(", diffraction limit 0.53′ (led, lit pupil 3.54 mm)"), "{text}");
        let limit = json["view"]["diffraction"]["groups"][0]["limit_arcmin"].as_f64().unwrap();
        assert!((limit - 0.5334).abs() < 1e-3, "{limit}");
        // Pixels of 0.17′ are finer than that.
        let (_, text) = shown(&Sharpness::new(&[pupil], 550.0, [5e-5; 2]));
        assert!(text.contains("= 3.1 pixels: the picture is geometric"), "{text}");
        let (layers, stderr) = (Vec::new(), String::new());
        sharpness.applied = Some(Applied { wavelengths_nm: [550.0; 3], layers, stderr });
        assert!(shown(&sharpness).1.ends_with(", applied"));
    }

    #[test]
    fn adaptation_glare_false_colours_and_the_sheet() {
        use crate::film::frame::Meta;
        let directory = tempfile::tempdir().unwrap();
        let (exr, png) = (directory.path().join("f.exr"), directory.path().join("v.png"));
        let words = |more: &[&str]| -> Vec<String> {
            let all = ["view", exr.to_str().unwrap(), "-o", png.to_str().unwrap()];
            all.iter().chain(more).map(|word| (*word).to_owned()).collect()
        };
        let run = |more: &[&str]| {
            let words = words(more);
            view(&parse(&words.iter().map(String::as_str).collect::<Vec<_>>()))
        };
        let mut frame = Frame::new(33, 1);
        let spike: Vec<f32> = (0..33).map(|x| if x == 16 { 10_000.0 } else { 1.0 }).collect();
        ["R", "G", "B"].iter().for_each(|c| frame.push(*c, spike.clone()));
        write_exr(&exr, &frame).unwrap();
        assert!(run(&["--glare"]).unwrap_err().to_string().contains("how wide the eye looks"));
        assert!(run(&["--adaptation", "foveal"]).is_err());
        frame.meta.insert("eye".into(), Meta::Text("{\"fov_deg\":33.0,\"age\":30}".into()));
        write_exr(&exr, &frame).unwrap();
        let adapted =
            |mean: &str| run(&["--adaptation", mean]).unwrap().0["view"]["adaptation_cd_m2"].as_f64().unwrap();
        assert!((adapted("log") - 10_000f64.powf(1.0 / 33.0)).abs() < 1e-9);
        assert!(adapted("foveal") > 3000.0 && (adapted("arithmetic") - 10_032.0 / 33.0).abs() < 1e-9);
        // The neighbours of the bright pixel are veiled.
        let pixel = |more: &[&str], x: u32| {
            run(more).unwrap();
            image::open(&png).unwrap().into_rgb8().get_pixel(x, 0).0[0]
        };
        assert!(pixel(&["--exposure", "2", "--glare"], 15) > pixel(&["--exposure", "2"], 15) + 20);
        let (json, text) = run(&["--false-colour"]).unwrap();
        assert_eq!(json["view"]["range"], serde_json::json!([1.0, 10_000.0]));
        assert!(text.contains("false colours from 1 to 10000 cd/m²"), "{text}");
        assert!(image::open(&png).unwrap().width() > 33);
        assert!(run(&["--contact-sheet"]).unwrap().1.contains("contact sheet of 1 layers"));
    }

    #[test]
    fn help_has_an_example() {
        let help = ViewArgs::augment_args(clap::Command::new("view")).render_long_help().to_string();
        assert!(help.contains("eyebox view frame.exr -o view.png"), "{help}");
    }
}
