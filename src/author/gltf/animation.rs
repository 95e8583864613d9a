//! What moves, as one animation: a channel for each translation, rotation, scale and list of weights, with LINEAR keys.

use super::super::tracks::{self, SCALE, TRANSLATION};
use super::document::Document;
use eyebox_base::Where;
use eyebox_scene::assembly::Assembly;
use eyebox_scene::motion::{Motion, Parts, parts};
use glam::DAffine3;
use serde_json::{Map, Value as Json, json};

/// The animation under construction.
#[derive(Debug, Default)]
pub struct Animation {
    samplers: Vec<Json>,
    channels: Vec<Json>,
    /// What the first key is moved by, so that none is before 0 (2.0, section 3.11: glTF has no negative times).
    shift: f64,
}

impl Animation {
    pub fn of(document: &mut Document, assembly: &Assembly) -> Animation {
        let first = assembly.motion.as_ref().and_then(|motion| motion.frames.first()).copied().unwrap_or(0.0);
        if first < 0.0 {
            let text = format!("frames before 0: the animation starts at 0 instead of frame {first}");
            document.note(&Where::file(&assembly.file), text);
        }
        Animation { shift: first.min(0.0), ..Animation::default() }
    }

    /// `translation`, `rotation` and `scale` of a node that stands as `still` and moves; none, if glTF cannot say it.
    pub fn node(
        &mut self,
        document: &mut Document,
        motion: &Motion,
        node: usize,
        (still, locals): (DAffine3, &[DAffine3]),
    ) -> Option<Map<String, Json>> {
        let all: Vec<DAffine3> = std::iter::once(still).chain(locals.iter().copied()).collect();
        let all = parts(&all)?;
        let (still, all) = all.split_first()?;
        for (path, of) in [("translation", TRANSLATION), ("scale", SCALE)] {
            let kept = tracks::of_vectors(motion, &[all], of);
            let values = self.picked(&kept, |at| all.get(at).map(|parts| of(parts).to_array().map(|x| x as f32)));
            if values.iter().any(|value| *value != of(still).to_array().map(|x| x as f32)) {
                let output = document.binary.vectors(&values);
                self.channel(document, motion, &kept, output, (node, path));
            }
        }
        let turn = |parts: &Parts| parts.rotation.to_array().map(|x| x as f32);
        let kept = tracks::of_turns(motion, &[all]);
        let values = self.picked(&kept, |at| all.get(at).map(turn));
        if values.iter().any(|value| *value != turn(still)) {
            let output = document.binary.quaternions(&values);
            self.channel(document, motion, &kept, output, (node, "rotation"));
        }
        Some(entries(still))
    }

    /// The weights of the mesh of `node`, a list for each frame.
    pub fn weights(&mut self, document: &mut Document, motion: &Motion, node: usize, all: &[Vec<f64>]) {
        let kept = tracks::of_numbers(motion, all);
        let numbers = kept.iter().filter_map(|at| all.get(*at)).flatten().map(|x| *x as f32);
        let output = document.binary.numbers(&numbers.collect::<Vec<_>>(), false);
        self.channel(document, motion, &kept, output, (node, "weights"));
    }

    fn picked<T>(&self, kept: &[usize], value: impl Fn(usize) -> Option<T>) -> Vec<T> {
        kept.iter().filter_map(|at| value(*at)).collect()
    }

    fn channel(
        &mut self,
        document: &mut Document,
        motion: &Motion,
        kept: &[usize],
        output: usize,
        (node, path): (usize, &str),
    ) {
        let frames = kept.iter().filter_map(|at| motion.frames.get(*at));
        let mut times: Vec<f32> = frames.map(|frame| ((frame - self.shift) / motion.rate) as f32).collect();
        // Moments that single precision does not tell apart must be told apart.
        for at in 1..times.len() {
            if times[at] <= times[at - 1] {
                times[at] = times[at - 1].next_up();
            }
        }
        let input = document.binary.numbers(&times, true);
        self.channels.push(json!({ "sampler": self.samplers.len(), "target": { "node": node, "path": path } }));
        self.samplers.push(json!({ "input": input, "output": output, "interpolation": "LINEAR" }));
    }

    /// The entry of `animations`, if anything moves.
    pub fn finish(self, motion: Option<&Motion>) -> Option<Json> {
        let motion = motion.filter(|_| !self.channels.is_empty())?;
        let mut out = json!({ "samplers": self.samplers, "channels": self.channels });
        if !motion.name.is_empty() {
            out["name"] = Json::from(motion.name.as_str());
        }
        Some(out)
    }
}

/// The entries of a node that stands so and that an animation may move.
pub fn entries(parts: &Parts) -> Map<String, Json> {
    let Parts { translation, rotation, scale } = parts;
    let mut out = Map::new();
    out.insert("translation".into(), json!(translation.to_array()));
    out.insert("rotation".into(), json!(rotation.to_array()));
    out.insert("scale".into(), json!(scale.to_array()));
    out
}
