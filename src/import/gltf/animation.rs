//! Animations: what moves at the moment of `--frame` (glTF 2.0, section 3.11). glTF counts in seconds, frames are counted in
//! frames a second: [`DEFAULT_FPS`] of them unless `--fps` says another number.

use super::accessor::Document;
use super::at::At;
use super::morph;
use super::notes::Ledger;
use super::pose::Moved;
use super::sampler::{self, Checked, Kind};
use super::transform::unit_rotation;
use crate::{ReadOptions, Rigs};
use eyebox_base::error::Result;
use eyebox_base::{Error, Where};
use eyebox_scene::motion::Clock;
use glam::DVec3;
use std::collections::{HashMap, HashSet};

/// What films have, and what USD takes where a stage does not say its `timeCodesPerSecond`.
pub(super) const DEFAULT_FPS: f64 = 24.0;

/// What moves, by node. Nothing without `--frame`.
///
/// # Errors
/// `--animation` names none; whatever is wrong in the one that is used.
pub(super) fn moved(
    document: &Document<'_>,
    nodes: &[At<'_>],
    options: &ReadOptions,
    ledger: &mut Ledger,
) -> Result<HashMap<usize, Moved>> {
    let animations = document.root.list("animations")?;
    let Some(frame) = options.frame else {
        if options.rigs != Rigs::No {
            return Ok(HashMap::new());
        }
        needs_frame(options)?;
        if let Some(first) = animations.first() {
            ledger.notes.info(first, "animations: nodes stand as they are written; `--frame` takes them at a time");
        }
        return Ok(HashMap::new());
    };
    let fps = options.fps.unwrap_or(DEFAULT_FPS);
    let time_s = frame / fps;
    let chosen = chosen(&animations, options)?;
    let Some(first) = chosen.first() else {
        ledger.notes.info(&document.root, "no animations: the asset is the same at every `--frame`");
        return Ok(HashMap::new());
    };
    let by = if options.fps.is_some() { "" } else { " (`--fps`)" };
    let of = match chosen.len() {
        1 => format!("the animation `{}`", name(first)?.escape_debug()),
        count => format!("all {count} animations at once (`--animation` takes one)"),
    };
    ledger.notes.info(first, format!("frame {frame} is {time_s} s at {fps} frames/s{by} of {of}"));
    channels(document, &chosen, nodes, time_s, ledger)
}

fn name<'d>(animation: &At<'d>) -> Result<&'d str> {
    match animation.get("name")? {
        Some(name) => name.text(),
        None => Ok(""),
    }
}

/// When the animations that `options` ask for have their keys; none without animations. Steps jump: the last moment before one is a
/// key, too.
///
/// # Errors
/// As [`moved`].
pub(super) fn clock(
    document: &Document<'_>,
    nodes: &[At<'_>],
    options: &ReadOptions,
    ledger: &mut Ledger,
) -> Result<Option<Clock>> {
    let animations = document.root.list("animations")?;
    let chosen = chosen(&animations, options)?;
    let Some(first) = chosen.first() else { return Ok(None) };
    // Several become one, which has no name of theirs.
    let name = if chosen.len() == 1 { name(first)?.to_owned() } else { String::new() };
    if options.frame.is_none() && chosen.len() > 1 {
        let text = format!("{} animations: all move at once (`--animation` takes one)", chosen.len());
        ledger.notes.info(first, text);
    }
    let rate = options.fps.unwrap_or(DEFAULT_FPS);
    let mut keys = Vec::new();
    for animation in chosen {
        let (samplers, mut seen) = (animation.want("samplers")?.items()?, HashSet::new());
        for channel in animation.want("channels")?.items()? {
            if target(&channel.want("target")?, nodes, ledger)?.is_none() {
                continue;
            }
            let number = channel.want("sampler")?.index(samplers.len(), "sampler")?;
            let Some(sampler) = samplers.get(number).filter(|_| seen.insert(number)) else { continue };
            keys.extend(sampler::moments(document, sampler, ledger)?.into_iter().map(|time_s| frame_at(time_s, rate)));
        }
    }
    keys.sort_by(f64::total_cmp);
    keys.dedup();
    Ok(Some(Clock { rate, name, keys }))
}

/// The frame that is at `time_s`: the first that is not before it when it becomes a time again.
fn frame_at(time_s: f64, rate: f64) -> f64 {
    let frame = time_s * rate;
    if frame / rate < time_s { frame.next_up() } else { frame }
}

/// # Errors
/// Options that say nothing without a frame.
fn needs_frame(options: &ReadOptions) -> Result<()> {
    for (option, is_there) in [("--animation", options.animation.is_some()), ("--fps", options.fps.is_some())] {
        if is_there {
            let what = "says nothing without a frame";
            return Err(Error::new(Where::Option(option.to_owned()), what).expected("`--frame`, too"));
        }
    }
    Ok(())
}

/// The animation of this name, else of this number; all of them, which move at once, if none is asked for: exporters write one for
/// each thing that moves.
fn chosen<'d, 'a>(animations: &'d [At<'a>], options: &ReadOptions) -> Result<Vec<&'d At<'a>>> {
    let Some(asked) = &options.animation else { return Ok(animations.iter().collect()) };
    let mut names = Vec::new();
    for animation in animations {
        let name = name(animation)?;
        if name == asked {
            return Ok(vec![animation]);
        }
        names.push(name);
    }
    if let Some(found) = asked.parse::<usize>().ok().and_then(|number| animations.get(number)) {
        return Ok(vec![found]);
    }
    let expected = match animations.len() {
        0 => "an asset with animations: this one has none".to_owned(),
        1 => "its name, or 0".to_owned(),
        count => format!("one of the names, or 0 to {}", count - 1),
    };
    let at = Where::Option(format!("--animation {asked}"));
    Err(Error::new(at, "the asset has no such animation").expected(expected).nearest(asked, names))
}

/// What of a node is animated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Property {
    Translation,
    Rotation,
    Scale,
    Weights,
}

impl Property {
    fn of(text: &str) -> Option<Self> {
        Some(match text {
            "translation" => Property::Translation,
            "rotation" => Property::Rotation,
            "scale" => Property::Scale,
            "weights" => Property::Weights,
            _ => return None,
        })
    }
}

fn channels(
    document: &Document<'_>,
    animations: &[&At<'_>],
    nodes: &[At<'_>],
    time_s: f64,
    ledger: &mut Ledger,
) -> Result<HashMap<usize, Moved>> {
    let (mut out, mut of, mut checked) = (HashMap::new(), HashMap::new(), Checked::default());
    let lists = |key: &str| -> Result<Vec<Vec<At<'_>>>> {
        animations.iter().map(|animation| animation.want(key)?.items()).collect()
    };
    let (all, samplers) = (lists("channels")?, lists("samplers")?);
    let channels = all.iter().zip(&samplers).enumerate();
    let channels = channels.flat_map(|(number, (own, samplers))| own.iter().map(move |own| (number, own, samplers)));
    for (number, channel, samplers) in channels {
        let Some((node, property)) = target(&channel.want("target")?, nodes, ledger)? else { continue };
        if let Some(first) = of.get(&(node, property)) {
            let text = if *first == number {
                "a second channel for the same property of a node: the first one holds"
            } else {
                "several animations move the same property of a node: the first one holds (`--animation` takes one)"
            };
            ledger.notes.warn(channel, text);
            continue;
        }
        of.insert((node, property), number);
        let reference = channel.want("sampler")?;
        let Some(sampler) = samplers.get(reference.index(samplers.len(), "sampler")?) else { continue };
        let mut value = |kind, width| sampler::value(document, sampler, (kind, width, time_s), &mut checked, ledger);
        let moved: &mut Moved = out.entry(node).or_default();
        let three = |all: Vec<f64>| all.try_into().map_or(DVec3::ZERO, |three: [f64; 3]| DVec3::from(three));
        match property {
            Property::Translation => moved.translation = Some(three(value(Kind::Vector, 3)?)),
            Property::Scale => moved.scale = Some(three(value(Kind::Vector, 3)?)),
            Property::Rotation => {
                let xyzw: [f64; 4] = value(Kind::Rotation, 4)?.try_into().unwrap_or([0.0, 0.0, 0.0, 1.0]);
                // Splines leave the unit sphere between their keys (appendix C.5).
                moved.rotation = Some(unit_rotation(sampler, xyzw, f64::INFINITY, &mut ledger.notes)?);
            }
            Property::Weights => {
                let mesh = nodes.get(node).map_or(Ok(None), |node| node.get("mesh"))?;
                let count = match mesh {
                    Some(mesh) => morph::count(&document.find("meshes", "mesh", &mesh)?),
                    None => 0,
                };
                if count == 0 {
                    ledger.notes.warn(channel, "animated weights for a node without morph targets: not used");
                    continue;
                }
                moved.weights = Some(value(Kind::Weights, count)?);
            }
        }
    }
    Ok(out)
}

/// The node and the property that a channel moves; none, with a note, if it moves something else.
fn target(at: &At<'_>, nodes: &[At<'_>], ledger: &mut Ledger) -> Result<Option<(usize, Property)>> {
    let path = at.want("path")?;
    let text = path.text()?;
    if text == "pointer" {
        let pointer = match at.extension("KHR_animation_pointer")? {
            Some(extension) => extension.want("pointer")?.text()?,
            None => "",
        };
        let found = pointer.strip_prefix("/nodes/").and_then(|rest| rest.split_once('/'));
        let found = found.and_then(|(node, name)| Some((node.parse::<usize>().ok()?, Property::of(name)?)));
        if let Some((node, property)) = found.filter(|(node, _)| *node < nodes.len()) {
            return Ok(Some((node, property)));
        }
        let text = format!("an animation of `{}` is not applied: it holds as it is written", pointer.escape_debug());
        ledger.notes.warn(at, text);
        return Ok(None);
    }
    let Some(property) = Property::of(text) else {
        let names = ["translation", "rotation", "scale", "weights"];
        return Err(path.fault("unknown property of a node").expected(names.join(", ")).nearest(text, names));
    };
    match at.get("node")? {
        Some(node) => Ok(Some((node.index(nodes.len(), "node")?, property))),
        None => {
            ledger.notes.info(at, "an animation of no node: nothing moves by it");
            Ok(None)
        }
    }
}
