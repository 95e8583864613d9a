//! `eyebox mix`: one rendering, recombined.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::{Format, print};
use crate::base::atomic::check_writable;
use crate::base::error::{Error, Result, Where};
use crate::film::exr::is_exr;
use crate::film::frame::Frame;
use crate::film::radiance::is_radiance;
use crate::film::still::{Remark, Still};
use crate::output::exr::{read_exr, write_exr};
use crate::output::fit::{Fit, Resize, fitted};
use crate::output::light_shares::Rendering;
use crate::output::mix::{Mixed, Recipe, Record, add_record, mix};
use crate::output::plate::place;
use crate::output::solve::{Goal, Solved, solve};
use crate::output::sum_frames::join;
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
    /// Contrast T_white/T_black of the slide, 1 to inf; 300:1 is 300. Of several: of all, or of those that are named
    /// [default: as rendered]
    #[arg(long = "contrast", value_name = "[SLIDE=]C,…", value_delimiter = ',', value_parser = parse_contrast)]
    pub contrasts: Vec<(Option<String>, f64)>,
    /// A picture to put behind the optics: EXR in cd/m² (or what its whiteLuminance says), Radiance HDR in cd/m², or PNG or JPEG in sRGB
    #[arg(long, value_name = "BACKGROUND.exr|png|jpg")]
    pub plate: Option<PathBuf>,
    /// The layer of the plate, where it has several
    #[arg(long, value_name = "LAYER", requires = "plate")]
    pub plate_layer: Option<String>,
    /// cd/m² of the plate's value 1 [default: what the file says; 1 for EXR, 80 for PNG and JPEG, as sRGB's display]
    #[arg(long, value_name = "CD/M2", requires = "plate", value_parser = parse_white)]
    pub plate_white: Option<f64>,
    /// How a plate of another size is laid over the frame
    #[arg(long, value_name = "contain|cover|stretch|centre", requires = "plate", value_parser = parse_fit)]
    pub fit: Option<Fit>,
    /// By which filter its pixels are made then
    #[arg(long, value_name = "area|linear", requires = "fit", value_parser = parse_resize, default_value = "area")]
    pub resize: Resize,
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

fn parse_fit(text: &str) -> std::result::Result<Fit, String> {
    let known = Fit::ALL.map(Fit::name);
    let found = Fit::ALL.into_iter().find(|fit| fit.name() == text);
    found.ok_or_else(|| format!("`{text}` is no way to fit; write one of {}", known.join(", ")))
}

fn parse_resize(text: &str) -> std::result::Result<Resize, String> {
    let known = Resize::ALL.map(Resize::name);
    let found = Resize::ALL.into_iter().find(|resize| resize.name() == text);
    found.ok_or_else(|| format!("`{text}` is no filter; write one of {}", known.join(", ")))
}

fn parse_white(text: &str) -> std::result::Result<f64, String> {
    let number = text.trim().parse().ok().filter(|white: &f64| *white > 0.0 && white.is_finite());
    number.ok_or_else(|| format!("`{text}` is no luminance; write cd/m² above 0, e.g. 250"))
}

fn parse_contrast(text: &str) -> std::result::Result<(Option<String>, f64), String> {
    let (slide, number) =
        text.rsplit_once('=').map_or((None, text), |(slide, number)| (Some(slide.trim().to_owned()), number));
    let number = number.trim().strip_suffix(":1").unwrap_or(number.trim());
    let number =
        number.parse().map_err(|_| format!("`{text}` is no contrast; write e.g. 300, 300:1, inf or lcd=300"))?;
    Ok((slide, number))
}

/// Runs the command.
pub fn run(args: &MixArgs) -> Result<ExitCode> {
    let (json, text) = mixed(args)?;
    print(args.format, || text, || json)?;
    Ok(ExitCode::SUCCESS)
}

/// Luminance of white on the display that sRGB is made for, cd/m² (IEC 61966-2-1:1999, table 1).
const SRGB_WHITE: f64 = 80.0;

/// The picture of a plate. Errors: a file that can't be read, or without the layer.
fn plate_of(path: &Path, layer: Option<&str>) -> Result<Still> {
    let broken = |what: String| Error::new(Where::file(path), format!("can't be a plate: {what}"));
    let bytes = std::fs::read(path).map_err(|error| broken(error.to_string()))?;
    if is_exr(&bytes) {
        return Still::of_exr(&bytes, layer).map_err(broken);
    }
    if let Some(layer) = layer {
        return Err(broken(format!("only an EXR has the layer `{layer}`")));
    }
    if is_radiance(&bytes) {
        return Still::of_radiance(&bytes).map_err(broken);
    }
    let read = Still::of_srgb(&bytes);
    let mut still = read.map_err(|error| broken(error).expected("an EXR, Radiance HDR, PNG or JPEG file"))?;
    let text = format!("says no luminance: its white is {SRGB_WHITE} cd/m², or what --plate-white says");
    still.remarks.push(Remark { warns: false, text });
    Ok(Still { white_cd_m2: Some(SRGB_WHITE), ..still })
}

/// Writes the mixture and says what was done, for programs and for people.
fn mixed(args: &MixArgs) -> Result<(serde_json::Value, String)> {
    let ends = |wanted: &str| args.output.extension().is_some_and(|e| e.eq_ignore_ascii_case(wanted));
    if !ends("exr") && !ends("png") {
        return Err(Error::new(Where::Option(format!("--output {}", args.output.display())), "not an EXR's name")
            .expected("a name that ends in .exr or .png"));
    }
    check_writable(&args.output)?;
    let frames = args.frames.iter().map(|path| read_exr(path)).collect::<Result<Vec<Frame>>>()?;
    let first = args.frames.first().map_or(Path::new(""), PathBuf::as_path);
    let mut frame = join(&frames).map_err(|fault| within(fault, first))?;
    drop(frames);
    let (mut warnings, mut notes) = (Vec::new(), Vec::new());
    if let Some(path) = &args.plate {
        let mut plate = plate_of(path, args.plate_layer.as_deref())?;
        for remark in &plate.remarks {
            let said = format!("{} {}", path.display(), remark.text);
            if remark.warns { warnings.push(said) } else { notes.push(said) }
        }
        if let Some(fit) = args.fit {
            plate = fitted(&plate, [frame.width, frame.height], fit, args.resize);
        }
        let white = args.plate_white.or(plate.white_cd_m2).unwrap_or(1.0);
        let (placed, doubled) = place(&frame, &plate, white).map_err(|fault| within(fault, path))?;
        frame = placed;
        // A gain of 0 has answered it.
        let silenced = |group: &String| args.gains.iter().any(|(own, gain)| *gain == 0.0 && own == group);
        warnings.extend(
            doubled
                .filter(|group| !silenced(group))
                .map(|group| format!("light of `{group}` still shines behind the plate; --gain {group}=0 removes it")),
        );
    }
    let mut recipe = recipe(args)?;
    let (mixed, solved) = recombine(args, &frame, &mut recipe).map_err(|fault| within(fault, first))?;
    let mut record = Record {
        frames: args.frames.iter().map(|path| path.display().to_string()).collect(),
        gains: recipe.gains.clone(),
        contrast: None,
        slides: Vec::new(),
        plate: args.plate.as_ref().map(|path| path.display().to_string()),
        solved,
        errors: mixed.errors,
    };
    record.gains.retain(|(_, gain)| *gain != 1.0);
    record.contrast = frame.number("contrast").zip(mixed.frame.number("contrast")).map(|(a, b)| [a, b]);
    record.slides = changed_slides(&frame, &recipe)?;
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
    json["notes"] = serde_json::json!(notes);
    let told = warnings.iter().map(|warning| format!("warning: {warning}"));
    let told = told.chain(notes.iter().map(|note| format!("note: {note}"))).collect();
    Ok((json, text(args, &record, told)))
}

/// What is to be changed of the light. Errors: two contrasts for the same.
fn recipe(args: &MixArgs) -> Result<Recipe> {
    let mut recipe = Recipe { gains: args.gains.clone(), ..Recipe::default() };
    for (at, (slide, contrast)) in args.contrasts.iter().enumerate() {
        if args.contrasts[..at].iter().any(|(other, _)| other == slide) {
            let name = slide.as_ref().map(|slide| format!("{slide}=")).unwrap_or_default();
            return Err(Error::new(
                Where::Option(format!("--contrast {name}{contrast}")),
                "is the second one of the same",
            )
            .expected("one for all slides, and one for each that is named"));
        }
        match slide {
            Some(slide) => recipe.slides.push((slide.clone(), *contrast)),
            None => recipe.contrast = Some(*contrast),
        }
    }
    Ok(recipe)
}

/// Of several slides those that are changed, from and to which contrast.
fn changed_slides(frame: &Frame, recipe: &Recipe) -> Result<Vec<(String, [f64; 2])>> {
    let rendering = Rendering::of(frame)?;
    let contrasts = recipe.contrasts(&rendering);
    let name = |slide: usize| rendering.slides.get(slide).map(|slide| slide.name.clone());
    Ok(contrasts.changed().filter_map(|(slide, both)| Some((name(slide)?, both))).collect())
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
fn within(mut fault: Box<Error>, path: &Path) -> Box<Error> {
    if fault.at == Where::Nowhere {
        fault.at = Where::file(path);
    }
    fault
}

/// What was done, after the lines that come first.
fn text(args: &MixArgs, record: &Record, mut lines: Vec<String>) -> String {
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
    } else {
        done.extend(record.slides.iter().map(|(slide, [a, b])| format!("contrast of {slide} {a} to {b}")));
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
