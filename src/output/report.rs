//! A rendered frame as one page that needs nothing else: pictures that recombine live, what was measured, the plan, the run.
//! `docs/report.md` describes it.

mod convergence;
mod facts;
mod html;
mod paths;
mod planes;
mod slides;

use super::contrasts::Contrasts;
use super::false_colour;
use super::light_shares::{Picture, Rendering, luminance_of};
use super::luminance::Luminance;
use super::measure::{Target, measure};
use super::tone::{Adaptation, adaptation_luminance, ward_scale};
use super::view::{Shown, choose};
use eyebox_base::error::{Error, Result, Where};
use eyebox_film::frame::Frame;
use planes::{Planes, Reduce};
use serde_json::{Value, json};

/// Luminance of the display's white that the exposure counts from, cd/m²: that of `eyebox view`.
const DISPLAY_WHITE: f64 = 100.0;
/// What the names of layers begin with that hold no numbers to look at: hashes (Cryptomatte).
const HASHES: &str = "crypto";

/// A page, and what a caller may want to say about it.
#[derive(Debug, Clone, PartialEq)]
pub struct Page {
    pub html: String,
    /// Pixels of the page's pictures.
    pub size: [usize; 2],
    /// Each of them is the mean of factor × factor pixels of the frame.
    pub factor: usize,
    pub layers: usize,
    /// Why the light groups cannot be mixed, if they cannot.
    pub unmixed: Option<String>,
}

/// A frame's light taken apart, if it can be.
pub struct Shares<'f> {
    pub rendering: Option<Rendering<'f>>,
    /// Mean luminance of each share, cd/m².
    pub means: Vec<f64>,
    pub fault: Option<String>,
}

impl<'f> Shares<'f> {
    fn of(frame: &'f Frame) -> Self {
        let rendering = match Rendering::of(frame) {
            Ok(rendering) => rendering,
            Err(fault) => return Shares { rendering: None, means: Vec::new(), fault: Some(fault.to_string()) },
        };
        let (weigh, pixels) = (Luminance::in_frame(frame), frame.width * frame.height);
        let mean = |values: Vec<f64>| values.iter().sum::<f64>() / pixels.max(1) as f64;
        let means = rendering
            .shares
            .iter()
            .map(|share| mean(luminance_of(share, &Contrasts::default(), &weigh, pixels)))
            .collect();
        Shares { rendering: Some(rendering), means, fault: None }
    }
}

/// The page of a frame. The first is shown; more frames of the same scene add points to the convergence plot. Each comes with
/// its file's name.
///
/// A frame that cannot be mixed or measured still has a page, which says why.
///
/// Errors: no frame, channels that do not fill it, no layer to show, frames of different scenes.
pub fn page(frames: &[(String, &Frame)]) -> Result<Page> {
    page_with(frames, "")
}

/// The same with one more section: HTML without scripts, in which texts that came from files are escaped.
pub fn page_with(frames: &[(String, &Frame)], more: &str) -> Result<Page> {
    let Some((file, frame)) = frames.first() else {
        return Err(Error::new(Where::Nowhere, "there is no frame to report on"));
    };
    check(frames)?;
    let mut planes = Planes::new(frame.width, frame.height);
    let layers = layers(frame, &mut planes);
    if layers.is_empty() {
        return Err(Error::new(Where::Nowhere, "the frame has no layer to show"));
    }
    let shares = Shares::of(frame);
    let mixed = shares.rendering.as_ref().map(|rendering| mixed(rendering, &mut planes)).unwrap_or_default();
    let factor = planes.factor();
    let size = [frame.width.div_ceil(factor), frame.height.div_ceil(factor)];
    let groups = shares.rendering.as_ref().map(|rendering| rendering.groups.clone()).unwrap_or_default();
    let contrast = shares.rendering.as_ref().and_then(|rendering| rendering.contrast);
    let (metrics, unmeasured) = match measure(frame, &Target::default()) {
        Ok(metrics) => (metrics, None),
        Err(fault) => (Vec::new(), Some(fault.to_string())),
    };
    let path_table = paths::table(frame, &shares);
    let mut rows = facts::facts(frame);
    rows.extend(shares.rendering.iter().flat_map(slides::rows));
    let weigh = Luminance::in_frame(frame);
    let unit = |channel: usize| [0, 1, 2].map(|c| f64::from(u8::from(c == channel)));
    let title = frame.text("scene").filter(|scene| !scene.is_empty()).unwrap_or(file);
    let space = weigh.space;
    let columns = [0, 1, 2].map(|channel| space.to_rec709(unit(channel)));
    let to_rec709 = [0, 1, 2].map(|row: usize| columns.map(|column| column[row]));
    let weights = [0, 1, 2].map(|channel| weigh.of(unit(channel)));
    let data = json!({
        "file": file,
        "subtitle": subtitle(file, frame),
        "size": size,
        "full": [frame.width, frame.height],
        "factor": factor,
        "planes": planes.encode(factor)?,
        "layers": layers,
        "shares": mixed,
        "groups": groups,
        // JSON has no infinity.
        "contrast": contrast.map(|contrast| contrast.to_string()),
        "unmixed": shares.fault,
        "white": weigh.white_cd_m2,
        "weights": weights,
        "toRec709": to_rec709,
        "exposure": exposure(frame),
        "displayWhite": DISPLAY_WHITE,
        "falseColour": { "stops": false_colour::STOPS, "decades": false_colour::DECADES },
        "metrics": metrics,
        "unmeasured": unmeasured,
        "paths": path_table.rows,
        "pathsNote": path_table.note,
        "pathsUnit": path_table.unit,
        "plan": facts::plan(frame),
        "witness": facts::witness(frame),
        "facts": rows,
        "ledgers": facts::ledgers(frame),
        "convergence": convergence::points(frames),
    });
    Ok(Page { html: html::page(title, &data, more), size, factor, layers: layers_of(&data), unmixed: shares.fault })
}

fn layers_of(data: &Value) -> usize {
    data.get("layers").and_then(Value::as_array).map_or(0, Vec::len)
}

fn check(frames: &[(String, &Frame)]) -> Result<()> {
    let Some((_, first)) = frames.first() else { return Ok(()) };
    for (name, frame) in frames {
        let pixels = frame.width.checked_mul(frame.height).filter(|pixels| *pixels > 0);
        if let Some(channel) = frame.channels.iter().find(|channel| Some(channel.data.len()) != pixels) {
            let values = format!("{name}: channel `{}` has {} values", channel.name, channel.data.len());
            return Err(Error::new(Where::Nowhere, values).expected(format!("{} × {}", frame.width, frame.height)));
        }
        let (here, there) = (first.text("sceneHash"), frame.text("sceneHash"));
        if here != there {
            return Err(Error::new(
                Where::Nowhere,
                format!("{name} is of another scene ({})", there.unwrap_or("no hash")),
            )
            .expected(format!("the hash of the first frame, {}", here.unwrap_or("none"))));
        }
    }
    Ok(())
}

/// All layers but hashes, the default image first.
fn layers<'f>(frame: &'f Frame, planes: &mut Planes<'f>) -> Vec<Value> {
    let lone = |name: &&str| !name.contains('.') && !["R", "G", "B"].contains(name);
    let channels = frame.channels.iter().map(|channel| channel.name.as_str()).filter(lone);
    let layers = frame.layer_names().into_iter().filter(|layer| !layer.is_empty());
    let hashes = |name: &&str| !name.get(..HASHES.len()).is_some_and(|start| start.eq_ignore_ascii_case(HASHES));
    let names = frame.rgb("").map(|_| "").into_iter().chain(layers).chain(channels).filter(hashes);
    // `hybrid` is the default image, which is shown by that name.
    let names = names.filter(|name| !name.is_empty() || frame.rgb("hybrid").is_none());
    let entry = |name: &str| {
        let (_, kind, channels) = choose(frame, Some(name)).ok()?;
        let reduce = match kind {
            Shown::Picture | Shown::Fraction => Reduce::Mean,
            Shown::Vector | Shown::Scalar => Reduce::First,
        };
        Some(json!({
            "name": if name.is_empty() { "picture" } else { name },
            "kind": kind,
            "grey": std::ptr::eq(channels[0], channels[1]),
            "planes": channels.map(|plane| planes.index(plane, reduce)),
        }))
    };
    names.filter_map(entry).collect()
}

/// The shares that the page recombines.
fn mixed<'f>(rendering: &Rendering<'f>, planes: &mut Planes<'f>) -> Vec<Value> {
    let mut place = |picture: Picture<'f>| picture.map(|plane| planes.index(plane, Reduce::Mean));
    let entry = |share: &super::light_shares::Share<'f>| {
        let split = share.split.as_ref().map(|split| {
            json!({
                "open": place(split.open),
                "content": place(split.content),
                "cross": split.cross.map(|cross| cross.map(&mut place)),
            })
        });
        json!({ "name": share.name, "group": share.group, "picture": place(share.picture), "split": split })
    };
    rendering.shares.iter().map(entry).collect()
}

/// Stops that show the frame as `eyebox view` does, to a tenth.
fn exposure(frame: &Frame) -> f64 {
    let luminance = super::luminance::layer_luminance(frame, "").unwrap_or_default();
    let mean = adaptation_luminance(Adaptation::Arithmetic, &luminance, frame).map_or(0.0, |(mean, _)| mean);
    let stops = (ward_scale(mean, DISPLAY_WHITE) * DISPLAY_WHITE).log2();
    if stops.is_finite() { (10.0 * stops).round() / 10.0 } else { 0.0 }
}

fn subtitle(file: &str, frame: &Frame) -> String {
    let mut parts = vec![file.to_owned(), format!("{} × {} pixels", frame.width, frame.height)];
    parts.extend(frame.integer("passes").map(|passes| format!("{passes} passes")));
    parts.push(match convergence::relative_noise(frame) {
        Some(noise) => format!("relative noise {:.2} %", 100.0 * noise),
        None => "relative noise unknown".to_owned(),
    });
    parts.join(" · ")
}

#[cfg(test)]
mod tests;
