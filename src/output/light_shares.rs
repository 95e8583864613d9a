//! A rendering as the shares that it is the sum of: one per layer and light group, with what tells its dependence on the
//! slide's contrast and its standard error. Names and formulas: `docs/layers.md`.

use super::compare::is_data;
use super::contrasts::Contrasts;
use super::luminance::Luminance;
use eyebox_base::error::{Error, Result, Where};
use eyebox_film::accumulate::light::Corners;
use eyebox_film::aov::{self, CHANGE_ERROR, OF_SERIES};
use eyebox_film::cryptomatte::Matte;
use eyebox_film::finish::slides::{self, SlideInfo};
use eyebox_film::frame::Frame;
use eyebox_film::layer::Layer;
use eyebox_film::names;

/// Three channels of a layer, `width × height` each, in the frame's colour space, cd/m².
pub type Picture<'f> = [&'f [f32]; 3];

/// The layer of an artist's plate as it is seen behind the optics; it counts as a light group of this name.
pub const PLATE: &str = "plate";
/// A sum of stored layers may miss the stored sum by this share of its peak: f32 sums of a few terms.
const SUM_TOLERANCE: f64 = 1e-5;
/// The same where values were stored as half floats, of 11 bits: four terms of a split.
const HALF_SUM_TOLERANCE: f64 = 4.0 / 2048.0;
/// Suffixes of the corrections for light that crosses the slide more than once, in their order.
const CROSSES: [&str; 3] = ["_cross", "_cross2", "_cross3"];

/// The pictures that give a share for every contrast.
#[derive(Debug, Clone, PartialEq)]
pub struct Split<'f> {
    pub open: Picture<'f>,
    pub content: Picture<'f>,
    /// `_cross`, `_cross2`, `_cross3`; what is not stored is black.
    pub cross: [Option<Picture<'f>>; 3],
    /// One-sigma errors of `open` and `content`, and their covariance in (cd/m²)²; kept by `--stderr layers`.
    pub errors: Option<[&'f [f32]; 3]>,
    /// One-sigma error of `content` − `open`, of the light of one slide among several; kept by `--stderr layers`.
    pub change_error: Option<&'f [f32]>,
}

/// The pictures that give light through two slides in series for any contrasts of theirs.
#[derive(Debug, Clone, PartialEq)]
pub struct Series<'f> {
    pub open_open: Picture<'f>,
    pub content_open: Picture<'f>,
    pub open_content: Picture<'f>,
    pub content_content: Picture<'f>,
}

/// One light group's share of a layer.
#[derive(Debug, Clone, PartialEq)]
pub struct Share<'f> {
    /// `direct`, `caustic`, `secondary`, `forward` or `plate`; or a layer by light path expression that parts classes.
    pub layer: String,
    pub group: String,
    /// `forward_led`; the plate's is `plate`.
    pub name: String,
    pub picture: Picture<'f>,
    /// None: the light does not depend on the slide, or the split was refused.
    pub split: Option<Split<'f>>,
    /// Why the split was refused.
    pub refused: Option<String>,
    /// Of several slides, by number: the light that crosses it and no other.
    pub by_slide: Vec<(usize, Split<'f>)>,
    /// Of two slides, by number: the light that crosses both, once each, and no other.
    pub by_pair: Vec<([usize; 2], Series<'f>)>,
    /// Those, by name, whose split was refused, and why.
    pub refused_by_slide: Vec<(String, String)>,
    /// One-sigma standard error of its luminance.
    pub error: Option<&'f [f32]>,
}

/// A frame with its shares.
#[derive(Debug, Clone)]
pub struct Rendering<'f> {
    pub frame: &'f Frame,
    /// Light groups in the order in which their shares are added up, the plate's last.
    pub groups: Vec<String>,
    pub shares: Vec<Share<'f>>,
    /// Those of layers by light path expression: their light is in `shares`, too.
    pub taken: Vec<Share<'f>>,
    /// Contrast of the only slide, or of several that have the same.
    pub contrast: Option<f64>,
    /// If there are several, those slides.
    pub slides: Vec<SlideInfo>,
}

/// Reads the list of light groups that a frame's header has.
/// Errors: no list, or none that can be read.
pub fn groups_of(frame: &Frame) -> Result<Vec<String>> {
    let listed = frame.text("groups").and_then(|json| serde_json::from_str(json).ok());
    listed.ok_or_else(|| {
        Error::new(Where::Nowhere, "the header has no list of light groups (`eyebox.groups`)")
            .expected("a frame that `eyebox render` wrote")
    })
}

impl<'f> Rendering<'f> {
    /// Takes a frame apart.
    ///
    /// Errors: a frame without list of light groups, channels of another size, a value that is not finite, shares that
    /// do not add up to their layer or layers to the picture (some were left out by `--layers`), a split that does not
    /// give its share at the rendered contrast.
    pub fn of(frame: &'f Frame) -> Result<Rendering<'f>> {
        check_data(frame)?;
        let mut groups = groups_of(frame)?;
        let contrast = frame.number("contrast");
        let slides = slides_of(frame)?;
        let splits = refusals(frame);
        let share = |layer: &str, group: &str| -> Result<Option<Share<'f>>> {
            let name = format!("{layer}_{group}");
            let Some(picture) = frame.rgb(&name) else { return Ok(None) };
            let split = Split::of(frame, &name);
            if let (Some(split), Some(contrast)) = (&split, contrast) {
                split.check(&name, contrast, picture, tolerance(frame))?;
            }
            let own = || splits.iter().filter(|refusal| refusal.layer == layer && refusal.group == group);
            let named = |slide: &SlideInfo| Split::of(frame, &format!("{name}_{}", slide.name));
            Ok(Some(Share {
                layer: layer.to_owned(),
                group: group.to_owned(),
                picture,
                split,
                refused: own().find(|own| own.slide.is_none()).map(|own| own.because.clone()),
                by_slide: slides.iter().enumerate().filter_map(|(k, slide)| Some((k, named(slide)?))).collect(),
                by_pair: Series::all(frame, &name, &slides),
                refused_by_slide: own()
                    .flat_map(|own| own.slide.iter().chain(&own.with).map(|slide| (slide.clone(), own.because.clone())))
                    .collect(),
                error: grey(frame, &format!("{name}_stderr")),
                name,
            }))
        };
        let (mut shares, mut taken) = (Vec::new(), Vec::new());
        for layer in Layer::SUM_ORDER {
            for group in &groups {
                shares.extend(share(layer.name(), group)?);
            }
        }
        for aov in aov::listed(frame) {
            for (_, group) in aov.groups().filter(|(_, group)| groups.iter().any(|own| own == group)) {
                let own = share(&aov.name, group)?;
                // A header may lie: what is a share already is scaled once.
                taken.extend(own.filter(|own| shares.iter().chain(&taken).all(|share: &Share| share.name != own.name)));
            }
        }
        if let Some(picture) = frame.rgb(PLATE) {
            let (group, name) = (PLATE.to_owned(), PLATE.to_owned());
            groups.push(group.clone());
            let layer = PLATE.to_owned();
            let (by_slide, by_pair, refused_by_slide) = (Vec::new(), Vec::new(), Vec::new());
            let (split, refused, error) = (None, None, None);
            shares.push(Share {
                layer,
                group,
                name,
                picture,
                split,
                refused,
                by_slide,
                by_pair,
                refused_by_slide,
                error,
            });
        }
        let rendering = Rendering { frame, groups, shares, taken, contrast, slides };
        rendering.check_sums()?;
        Ok(rendering)
    }

    /// Shares of one layer, in the order in which they are added up.
    pub fn of_layer<'r>(&'r self, layer: &'r str) -> impl Iterator<Item = &'r Share<'f>> {
        self.shares.iter().filter(move |share| share.layer == layer)
    }

    fn check_sums(&self) -> Result<()> {
        let frame = self.frame;
        let incomplete = |what: String, missing: String| {
            Error::new(Where::Nowhere, what).expected(format!(
                "all shares of the light, of which {missing} is missing or damaged: render without --layers"
            ))
        };
        for layer in Layer::SUM_ORDER.map(Layer::name) {
            let Some(picture) = frame.rgb(layer) else { continue };
            if !adds_up(picture, self.of_layer(layer).map(|share| share.picture), tolerance(frame)) {
                let there: Vec<&str> = self.of_layer(layer).map(|share| share.group.as_str()).collect();
                let missing = self.groups.iter().filter(|group| *group != PLATE && !there.contains(&group.as_str()));
                let missing: Vec<String> = missing.map(|group| format!("`{layer}_{group}`")).collect();
                let missing = if missing.is_empty() { format!("`{layer}`") } else { missing.join(" or ") };
                return Err(incomplete(format!("the shares of the light groups do not add up to `{layer}`"), missing));
            }
        }
        let Some(picture) = frame.rgb("") else {
            return Err(Error::new(Where::Nowhere, "the frame has no default image").expected("channels R, G and B"));
        };
        if !adds_up(picture, self.shares.iter().map(|share| share.picture), tolerance(frame)) {
            let missing = Layer::SUM_ORDER.map(Layer::name).into_iter().filter(|layer| frame.rgb(layer).is_none());
            let missing: Vec<String> = missing.map(|layer| format!("`{layer}_GROUP`")).collect();
            let missing = if missing.is_empty() { "the default image".to_owned() } else { missing.join(" or ") };
            return Err(incomplete("the layers do not add up to the default image".to_owned(), missing));
        }
        Ok(())
    }
}

impl<'f> Share<'f> {
    /// The split by one of several slides.
    pub fn of_slide(&self, slide: usize) -> Option<&Split<'f>> {
        self.by_slide.iter().find(|(own, _)| *own == slide).map(|(_, split)| split)
    }
}

impl<'f> Series<'f> {
    /// Of every two slides that a share is split by.
    fn all(frame: &'f Frame, share: &str, slides: &[SlideInfo]) -> Vec<([usize; 2], Series<'f>)> {
        let pairs = (0..slides.len()).flat_map(|one| (one + 1..slides.len()).map(move |other| [one, other]));
        pairs
            .filter_map(|[one, other]| {
                let name = format!("{share}_{}_{}", slides[one].name, slides[other].name);
                let [a, b, c, d] = OF_SERIES.map(|suffix| frame.rgb(&format!("{name}{suffix}")));
                let series = Series { open_open: a?, content_open: b?, open_content: c?, content_content: d? };
                Some(([one, other], series))
            })
            .collect()
    }

    /// One channel for contrasts of the one and the other slide, at one pixel.
    pub fn value(&self, contrasts: [f64; 2], channel: usize, pixel: usize) -> f64 {
        let at = |picture: Picture| picture[channel].get(pixel).map_or(0.0, |value| f64::from(*value));
        let corners = Corners {
            open_open: at(self.open_open),
            content_open: at(self.content_open),
            open_content: at(self.open_content),
            content_content: at(self.content_content),
        };
        corners.at(contrasts)
    }
}

/// The slides that a header lists, if there are several. Errors: a list that cannot be read.
fn slides_of(frame: &Frame) -> Result<Vec<SlideInfo>> {
    let Some(json) = frame.text(slides::KEY) else { return Ok(Vec::new()) };
    let read = serde_json::from_str::<Vec<SlideInfo>>(json).ok();
    read.filter(|slides| slides.iter().all(|slide| slide.contrast >= 1.0)).ok_or_else(|| {
        Error::new(Where::Nowhere, "the header's list of slides (`eyebox.slides`) cannot be read")
            .expected("a name, a part and a contrast of 1 or more of each")
    })
}

impl<'f> Split<'f> {
    fn of(frame: &'f Frame, name: &str) -> Option<Split<'f>> {
        let one = |suffix: &str| frame.rgb(&format!("{name}{suffix}"));
        let error = |suffix: &str| grey(frame, &format!("{name}{suffix}"));
        let errors = (error("_open_stderr"), error("_content_stderr"), error("_covariance"));
        Some(Split {
            open: one("_open")?,
            content: one("_content")?,
            cross: CROSSES.map(one),
            errors: match errors {
                (Some(open), Some(content), Some(covariance)) => Some([open, content, covariance]),
                (_, _, _) => None,
            },
            change_error: error(CHANGE_ERROR),
        })
    }

    /// One channel of the share for a contrast, at one pixel.
    pub fn value(&self, contrast: f64, channel: usize, pixel: usize) -> f64 {
        let at = |picture: Picture| picture[channel].get(pixel).map_or(0.0, |value| f64::from(*value));
        let (u, v) = (1.0 - 1.0 / contrast, 1.0 / contrast);
        let crossings = self.cross.iter().rev().fold(0.0, |sum, cross| sum * u + cross.map_or(0.0, at));
        at(self.content) * u + at(self.open) * v + crossings * u * v
    }

    /// Variance of the share's luminance for a contrast, if its errors were kept. Light that crosses the slide more than
    /// once has no part in it.
    pub fn variance(&self, contrast: f64, pixel: usize) -> Option<f64> {
        let [open, content, covariance] =
            self.errors?.map(|data| data.get(pixel).map_or(0.0, |value| f64::from(*value)));
        let (u, v) = (1.0 - 1.0 / contrast, 1.0 / contrast);
        Some(not_negative((u * content).powi(2) + (v * open).powi(2) + 2.0 * u * v * covariance))
    }

    /// The split at the rendered contrast is the share as it was rendered.
    fn check(&self, name: &str, contrast: f64, picture: Picture, tolerance: f64) -> Result<()> {
        for (channel, stored) in picture.into_iter().enumerate() {
            let peak = peak(stored).max(peak(self.open[channel]));
            let miss = |(pixel, stored): (usize, &f32)| {
                (self.value(contrast, channel, pixel) - f64::from(*stored)).abs() > tolerance * peak
            };
            if stored.iter().enumerate().any(miss) {
                return Err(Error::new(
                    Where::Nowhere,
                    format!(
                        "`{name}_open` and `{name}_content` do not give `{name}` at the rendered contrast {contrast}"
                    ),
                )
                .expected(format!("all of `{name}_open`, `_content`, `_cross`, … as they were rendered")));
            }
        }
        Ok(())
    }
}

/// One channel of a layer that is the same in all, such as a standard error.
fn grey<'f>(frame: &'f Frame, layer: &str) -> Option<&'f [f32]> {
    frame.rgb(layer).map(|[first, _, _]| first)
}

/// A split that was refused, and why.
#[derive(serde::Deserialize)]
struct Record {
    layer: String,
    group: String,
    slide: Option<String>,
    with: Option<String>,
    written: bool,
    because: String,
}

fn refusals(frame: &Frame) -> Vec<Record> {
    let records: Vec<Record> =
        frame.text("splits").and_then(|json| serde_json::from_str(json).ok()).unwrap_or_default();
    // What was written once and is not there any more was left out.
    let gone = |record: &Record| {
        let share = format!("{}_{}", record.layer, record.group);
        match (&record.slide, &record.with) {
            (Some(slide), Some(with)) => {
                let there = |suffix: &str| frame.rgb(&format!("{share}_{slide}_{with}{suffix}")).is_some();
                !OF_SERIES.into_iter().all(there)
            }
            (Some(slide), None) => frame.rgb(&format!("{share}_{slide}_open")).is_none(),
            (None, _) => frame.rgb(&format!("{share}_open")).is_none(),
        }
    };
    let because = |record: &Record| match (record.written, &record.slide, &record.with) {
        (true, Some(slide), Some(with)) => format!("layers of `{slide}_{with}`, light through both, were left out"),
        (true, _, _) => "its layers were left out".to_owned(),
        (false, _, _) => record.because.clone(),
    };
    let refused = records.into_iter().filter(|record| !record.written || gone(record));
    refused.map(|record| Record { because: because(&record), ..record }).collect()
}

/// Channels fill the frame and hold finite values.
pub fn check_data(frame: &Frame) -> Result<()> {
    let pixels = frame.width.checked_mul(frame.height).filter(|pixels| *pixels > 0);
    for channel in &frame.channels {
        let name = &channel.name;
        if Some(channel.data.len()) != pixels {
            return Err(Error::new(Where::Nowhere, format!("channel `{name}` has {} values", channel.data.len()))
                .expected(format!("{} × {}", frame.width, frame.height)));
        }
        // What is nowhere is infinitely far, as other programs write it: that says nothing of light.
        let data = is_data(channel.layer()) || is_data(name) || Matte::of_layer(channel.layer()).is_some();
        let free = data && !["seethrough", "alpha"].contains(&channel.layer());
        let bad = |value: &f32| !(free || names::may_hold(channel.layer(), *value));
        if let Some(pixel) = channel.data.iter().position(bad) {
            let (x, y) = (pixel % frame.width, pixel / frame.width);
            let value = channel.data.get(pixel).copied().unwrap_or(f32::NAN);
            return Err(Error::new(Where::Nowhere, format!("channel `{name}` is {value} at pixel ({x}, {y})"))
                .expected("finite values"));
        }
    }
    Ok(())
}

/// By what share of the peak a sum of stored layers may miss the stored sum.
fn tolerance(frame: &Frame) -> f64 {
    if frame.half { HALF_SUM_TOLERANCE } else { SUM_TOLERANCE }
}

/// A variance that rounding has made negative is none; one that is unknown (NaN) stays so.
pub fn not_negative(variance: f64) -> f64 {
    if variance < 0.0 { 0.0 } else { variance }
}

fn peak(data: &[f32]) -> f64 {
    data.iter().fold(0.0, |peak, value| peak.max(f64::from(value.abs())))
}

/// Whether pictures add up to another, as far as f32 can tell.
fn adds_up<'f>(sum: Picture<'f>, terms: impl Iterator<Item = Picture<'f>>, tolerance: f64) -> bool {
    let terms: Vec<Picture> = terms.collect();
    (0..3).all(|channel| {
        let largest = terms.iter().fold(peak(sum[channel]), |largest, term| largest.max(peak(term[channel])));
        sum[channel].iter().enumerate().all(|(pixel, want)| {
            let got: f64 = terms.iter().filter_map(|term| term[channel].get(pixel)).map(|v| f64::from(*v)).sum();
            (got - f64::from(*want)).abs() <= tolerance * largest
        })
    })
}

/// The luminance of a share for other contrasts, pixel by pixel, cd/m².
pub fn luminance_of(share: &Share, contrasts: &Contrasts, weigh: &Luminance, pixels: usize) -> Vec<f64> {
    let value = |pixel: usize| [0, 1, 2].map(|channel| share.value(contrasts, channel, pixel));
    (0..pixels).map(|pixel| weigh.of(value(pixel))).collect()
}
