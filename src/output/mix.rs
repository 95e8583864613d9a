//! One rendering, recombined: gains per light group, another contrast of the slide, standard errors carried along.
//! `docs/mix.md` has the formulas.

use super::contrasts::Contrasts;
use super::light_shares::{PLATE, Rendering, Share};
use eyebox_base::error::{Error, Result, Where};
use eyebox_film::aov;
use eyebox_film::finish::slides::{self, SlideInfo};
use eyebox_film::frame::{Frame, Meta, split_name};
use eyebox_film::layer::Layer;
use eyebox_film::names::STATED_ERROR;
use eyebox_film::variance;

/// What the header's entries about layers of `render --chain` begin with, and the path table that comes with them.
const CHAIN: &str = "chain.";
const PATHS: &str = "paths";
/// What the names of the layers of a split end with, and those of its errors.
const OF_ERRORS: [&str; 3] = ["_open_stderr", "_content_stderr", "_covariance"];

/// What is to be changed.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Recipe {
    /// Factors of light groups; a group that is named twice gets both.
    pub gains: Vec<(String, f64)>,
    /// T_white/T_black of the slide, 1 to ∞, or of all of several; as it was rendered if none.
    pub contrast: Option<f64>,
    /// That of single slides among several, by name.
    pub slides: Vec<(String, f64)>,
}

/// How the standard errors of the mixed frame are known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Errors {
    /// Nothing was changed that they depend on, or everything by the same factor, or at most two shares: exact.
    Exact,
    /// From the errors of the shares; how the shares lean on each other is taken to be the same for all pairs.
    FromShares,
    /// The rendered errors times the largest gain of the light in each pixel: not less than the truth unless shares
    /// lean against each other.
    AtMost,
    /// The file doesn't hold what they need: `stderr` was left out.
    Unknown,
    /// The rendered errors, and those of what single slides change, added up: not less than the truth but for light that crosses a
    /// slide more than once.
    AtMostOfSlides,
    /// The file doesn't hold those of the light of one slide among several, or of two in series: `stderr` was left out.
    UnknownOfSlide,
    /// The frame had none.
    Absent,
    /// The frame's passes are too few to tell any (one of rays from the eye): it stays unknown, NaN.
    Untold,
}

impl Errors {
    /// For people.
    pub fn said(self) -> &'static str {
        match self {
            Errors::Exact => "stderr scaled with the light",
            Errors::FromShares => "stderr from the errors of the shares",
            Errors::AtMost => "stderr is an upper bound; render with --stderr layers for a closer one",
            Errors::Unknown => "stderr left out: for another contrast it needs a frame rendered with --stderr layers",
            Errors::AtMostOfSlides => "stderr is an upper bound: the errors of what each slide changes are added up",
            Errors::UnknownOfSlide => {
                "stderr left out: for another contrast of one slide among several it needs a frame rendered with --stderr \
                 layers, and no frame holds the errors of light through two in series"
            }
            Errors::Absent => "no stderr, as in the frame",
            Errors::Untold => "stderr is unknown, as in the frame: its passes are too few to tell it",
        }
    }
}

/// The recombined frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Mixed {
    pub frame: Frame,
    pub errors: Errors,
    /// Layers that were left out, since how they depend on what was changed is not in the file: those of `render --chain`.
    pub left_out: Vec<String>,
}

/// One step of what was done to a frame, for its header (`eyebox.mix`, a JSON list, oldest first).
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Record {
    pub frames: Vec<String>,
    /// Group and gain, those of 1 left out.
    pub gains: Vec<(String, f64)>,
    /// Before and after; infinite is null.
    pub contrast: Option<[f64; 2]>,
    /// The same of each slide among several that was changed.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub slides: Vec<(String, [f64; 2])>,
    pub plate: Option<String>,
    pub solved: Option<super::solve::Solved>,
    pub errors: Errors,
}

impl Recipe {
    /// The factor of a group: the product of its gains.
    pub fn gain(&self, group: &str) -> f64 {
        self.gains.iter().filter(|(name, _)| name == group).map(|(_, gain)| *gain).product()
    }

    /// Errors: a gain that is negative or not finite, an unknown group (with the nearest), a contrast below 1 or without
    /// a slide.
    pub fn check(&self, rendering: &Rendering) -> Result<()> {
        for (group, gain) in &self.gains {
            let at = || Where::Option(format!("--gain {group}={gain}"));
            if !rendering.groups.contains(group) {
                return Err(Error::new(at(), format!("the frame has no light group `{group}`"))
                    .expected(format!("one of {}", rendering.groups.join(", ")))
                    .nearest(group, rendering.groups.iter().map(String::as_str)));
            }
            if !(*gain >= 0.0 && gain.is_finite()) {
                return Err(Error::new(at(), format!("{gain} is no gain")).expected("0 or more, finite"));
            }
        }
        self.check_contrasts(rendering)
    }

    /// What the contrasts of the slides become.
    pub fn contrasts(&self, rendering: &Rendering) -> Contrasts {
        Contrasts::new(rendering, self.contrast, &self.slides)
    }

    fn check_contrasts(&self, rendering: &Rendering) -> Result<()> {
        let all = self.contrast.map(|contrast| (format!("--contrast {contrast}"), contrast));
        let single = self.slides.iter().map(|(slide, contrast)| (format!("--contrast {slide}={contrast}"), *contrast));
        for (option, contrast) in all.iter().cloned().chain(single) {
            if contrast.is_nan() || contrast < 1.0 {
                return Err(Error::new(Where::Option(option), format!("{contrast} is no contrast"))
                    .expected("1 or more; `inf` is allowed"));
            }
        }
        let names = || rendering.slides.iter().map(|slide| slide.name.as_str());
        if let Some((slide, contrast)) = self.slides.iter().find(|(slide, _)| !names().any(|name| name == slide)) {
            let at = Where::Option(format!("--contrast {slide}={contrast}"));
            let fault = Error::new(at, format!("the frame names no slide `{slide}`"));
            return Err(match names().next() {
                Some(_) => {
                    fault.expected(format!("one of {}", names().collect::<Vec<_>>().join(", "))).nearest(slide, names())
                }
                None => fault.expected("a scene with several slides; of one, --contrast C alone"),
            });
        }
        if let Some((option, _)) = &all
            && rendering.contrast.is_none()
            && rendering.slides.is_empty()
        {
            return Err(Error::new(
                Where::Option(option.clone()),
                "the frame has no slide whose contrast could be changed",
            )
            .expected("a scene with a slide"));
        }
        let contrasts = self.contrasts(rendering);
        let changed: Vec<&str> = contrasts.changed().filter_map(|(slide, _)| names().nth(slide)).collect();
        for share in rendering.shares.iter().chain(&rendering.taken) {
            let of_slides = || share.refused_by_slide.iter().find(|(slide, _)| changed.contains(&slide.as_str()));
            let refused = match contrasts.all() {
                Some(_) => share.refused.as_ref().map(|because| (String::new(), because)),
                None => of_slides().map(|(slide, because)| (format!("_{slide}"), because)),
            };
            let Some((slide, because)) = refused else { continue };
            let name = &share.name;
            // One of several is named where it is one.
            let of = slide.strip_prefix('_').map(|slide| format!(" of `{slide}`")).unwrap_or_default();
            let option =
                all.as_ref().filter(|_| self.slides.is_empty() || slide.is_empty()).map(|(option, _)| option.clone());
            let option = option.unwrap_or_else(|| "--contrast".to_owned());
            return Err(Error::new(Where::Option(option), format!("`{name}` is not split by contrast{of}: {because}"))
                .expected(format!("`{name}{slide}_open` and `{name}{slide}_content` in the frame")));
        }
        Ok(())
    }
}

/// Recombines a frame. What is not changed keeps its bits.
///
/// The channels of the result are those of the frame (less errors that cannot be known): shares, their splits and errors
/// times their gains, layers, `hybrid` and the default image as f32 sums of what is stored, `contrast` in the header.
///
/// Errors: those of [`Recipe::check`].
pub fn mix(rendering: &Rendering, recipe: &Recipe) -> Result<Mixed> {
    recipe.check(rendering)?;
    let frame = rendering.frame;
    let pixels = frame.width * frame.height;
    let mut out = frame.clone();
    let contrasts = recipe.contrasts(rendering);
    // Slides at other contrasts than each other have no picture with all of them open or black.
    let apart = contrasts.all().is_none() && contrasts.changed().next().is_some();
    let mut changed = Vec::new();
    let slides: Vec<String> = rendering.slides.iter().map(|slide| slide.name.clone()).collect();
    for share in rendering.shares.iter().chain(&rendering.taken) {
        if apart && share.split.is_some() {
            let name = &share.name;
            let errors = OF_ERRORS.map(|suffix| format!("{name}{suffix}"));
            let together: Vec<String> =
                aov::OF_SPLIT.iter().map(|suffix| format!("{name}{suffix}")).chain(errors).collect();
            out.channels.retain(|channel| !together.iter().any(|layer| layer == channel.layer()));
        }
        let gain = recipe.gain(&share.group);
        if gain == 1.0 && !share.follows(&contrasts) {
            continue;
        }
        let value = |channel: usize, pixel: usize| (gain * share.value(&contrasts, channel, pixel)) as f32;
        let picture: [Vec<f32>; 3] = [0, 1, 2].map(|c| (0..pixels).map(|pixel| value(c, pixel)).collect());
        set_layer(&mut out, &share.name, &picture);
        let together = aov::OF_SPLIT.iter().map(|suffix| format!("{}{suffix}", share.name));
        let errors = slides.iter().map(|slide| format!("{}_{slide}{}", share.name, aov::CHANGE_ERROR));
        for layer in together.chain(aov::layers_by_slide(&share.name, &slides)).chain(errors) {
            scale_layer(&mut out, &layer, gain);
        }
        let [open, content, covariance] = OF_ERRORS.map(|suffix| format!("{}{suffix}", share.name));
        [open, content].iter().for_each(|layer| scale_layer(&mut out, layer, gain));
        scale_layer(&mut out, &covariance, gain * gain);
        changed.push(share.layer.as_str());
    }
    let mut errors = if frame.rgb("stderr").is_some() { Errors::Exact } else { Errors::Absent };
    if !changed.is_empty() {
        errors = super::mix_errors::carry(rendering, recipe, &contrasts, &mut out);
        sum_up(&mut out, rendering, &changed);
        aov::refresh(&mut out);
        variance::refresh(&mut out);
    }
    if apart && errors == Errors::Unknown {
        errors = Errors::UnknownOfSlide;
    }
    if frame.rgb("stderr").is_some_and(|[sigma, ..]| sigma.iter().any(|sigma| sigma.is_nan())) {
        errors = Errors::Untold;
    }
    if let Some(contrast) = contrasts.all() {
        out.meta.insert("contrast".to_owned(), Meta::Number(contrast));
    }
    if contrasts.changed().next().is_some() {
        let of = |(slide, contrast): (&SlideInfo, f64)| SlideInfo { contrast, ..slide.clone() };
        let slides: Vec<SlideInfo> = rendering.slides.iter().zip(contrasts.each()).map(of).collect();
        out.meta.insert(slides::KEY.to_owned(), Meta::Text(serde_json::to_string(&slides).unwrap_or_default()));
        if apart {
            out.meta.remove("contrast");
        }
    }
    let left_out = if changed.is_empty() { Vec::new() } else { leave_out_chains(&mut out) };
    Ok(Mixed { frame: out, errors, left_out })
}

/// Takes the layers of `render --chain` out, which the header names as `chain.NAME`, and the path table: they hold light of
/// any group at the contrast that was rendered.
fn leave_out_chains(out: &mut Frame) -> Vec<String> {
    let named = |key: &String| key.strip_prefix(CHAIN).map(str::to_owned);
    let names: Vec<String> = out.meta.keys().filter_map(named).collect();
    out.channels.retain(|channel| !names.iter().any(|name| name == channel.layer()));
    out.meta.retain(|key, _| !key.starts_with(CHAIN) && key != PATHS && key != STATED_ERROR);
    names
}

/// Adds a record to the header.
pub fn add_record(frame: &mut Frame, record: &Record) {
    let before = frame.text("mix").and_then(|json| serde_json::from_str(json).ok());
    let mut records: Vec<serde_json::Value> = before.unwrap_or_default();
    records.extend(serde_json::to_value(record));
    frame.meta.insert("mix".to_owned(), Meta::Text(serde_json::Value::from(records).to_string()));
}

/// The sums of what is stored: the changed layers of their shares, and the pictures of all layers.
fn sum_up(out: &mut Frame, rendering: &Rendering, changed: &[&str]) {
    let pixels = out.width * out.height;
    let sum = |out: &Frame, names: &[String]| {
        let mut sum: [Vec<f32>; 3] = std::array::from_fn(|_| vec![0.0; pixels]);
        for picture in names.iter().filter_map(|name| out.rgb(name)) {
            for (sum, data) in sum.iter_mut().zip(picture) {
                sum.iter_mut().zip(data).for_each(|(sum, value)| *sum += value);
            }
        }
        sum
    };
    let shares = |layer: &str| -> Vec<String> { rendering.of_layer(layer).map(|share| share.name.clone()).collect() };
    for layer in Layer::SUM_ORDER.map(Layer::name).into_iter().filter(|layer| changed.contains(layer)) {
        let picture = sum(out, &shares(layer));
        set_layer(out, layer, &picture);
    }
    // A layer that was left out is the sum of its shares all the same.
    let layers = Layer::SUM_ORDER.map(Layer::name).into_iter().chain([PLATE]);
    let terms: Vec<String> = layers
        .flat_map(|layer| if out.rgb(layer).is_some() { vec![layer.to_owned()] } else { shares(layer) })
        .collect();
    let picture = sum(out, &terms);
    set_layer(out, "hybrid", &picture);
    set_layer(out, "", &picture);
}

/// Replaces the colours of a layer, where it is there.
pub fn set_layer(frame: &mut Frame, layer: &str, picture: &[Vec<f32>; 3]) {
    for channel in &mut frame.channels {
        let (own, component) = split_name(&channel.name);
        if own != layer {
            continue;
        }
        match component {
            "R" | "Y" => channel.data = picture[0].clone().into(),
            "G" => channel.data = picture[1].clone().into(),
            "B" => channel.data = picture[2].clone().into(),
            _ => {}
        }
    }
}

fn scale_layer(frame: &mut Frame, layer: &str, factor: f64) {
    for channel in frame.channels.iter_mut().filter(|channel| channel.layer() == layer) {
        channel.data.iter_mut().for_each(|value| *value = (f64::from(*value) * factor) as f32);
    }
}

/// Whether a share has any light.
pub fn is_lit(share: &Share) -> bool {
    share.picture.iter().any(|data| data.iter().any(|value| *value != 0.0))
}

#[cfg(test)]
mod tests;
