//! A rendering for many machines as an Open Job Description template: a plan per frame, its shards, their merge.
//!
//! Form: Open Job Description, "Template Schemas", version 2023-09. Paths are job parameters with their data flow, so that a
//! farm can carry files to its workers; the shards' outputs are files that the merge names one by one.

use serde_json::{Value, json};
use std::fmt::Write;

/// What a job is made of. Paths are relative to the template's folder: the form knows no other defaults. Without one the
/// path has to be given when the job is submitted.
#[derive(Debug, Clone, PartialEq)]
pub struct Job {
    pub name: String,
    pub asset: Option<String>,
    /// The folder that holds every file that the asset needs.
    pub asset_folder: Option<String>,
    pub output_folder: Option<String>,
    /// File name of the merged picture; with `#` for the digits of the frame.
    pub output: String,
    pub shards: u64,
    pub samples: u64,
    pub seed: u64,
    /// First, last, step of each range; none: one picture without a time code.
    pub frames: Option<Vec<(i64, i64, u64)>>,
    /// Options of `plan` and `render`.
    pub plan_options: Vec<String>,
    /// Options of `render` alone.
    pub render_options: Vec<String>,
    /// Seconds between checkpoints.
    pub checkpoint_s: u64,
}

impl Job {
    /// The template.
    pub fn template(&self) -> Value {
        let frame: Vec<String> = match &self.frames {
            Some(_) => ["--frame", "{{Task.Param.Frame}}"].map(str::to_owned).into(),
            None => Vec::new(),
        };
        let word = |text: &str| Value::from(text);
        let options = |own: &[String]| own.iter().map(|text| Value::from(text.as_str())).collect::<Vec<_>>();
        let frame_args = || options(&frame);
        let plan: Vec<Value> = [
            vec![word("plan"), word("{{Param.Asset}}")],
            options(&self.plan_options),
            frame_args(),
            vec![word("-o"), word(&self.file("plan.json"))],
        ]
        .concat();
        let shard = format!("{{{{Task.Param.Shard}}}}/{}", self.shards);
        let render: Vec<Value> = [
            vec![word("render"), word("{{Param.Asset}}")],
            options(&self.plan_options),
            options(&self.render_options),
            frame_args(),
            ["--plan", &self.file("plan.json"), "--samples", "{{Param.Samples}}", "--seed", "{{Param.Seed}}"]
                .map(word)
                .into(),
            ["--shard", &shard, "--checkpoint", &format!("{}s", self.checkpoint_s), "--resume"].map(word).into(),
            ["--progress", "openjd", "-o", &self.shard_file("{{Task.Param.Shard}}")].map(word).into(),
        ]
        .concat();
        let merge: Vec<Value> = [
            vec![word("merge")],
            (1..=self.shards).map(|index| word(&self.shard_file(&index.to_string()))).collect(),
            frame_args(),
            vec![word("-o"), word("{{Param.OutputFolder}}/{{Param.Output}}")],
        ]
        .concat();
        let step = |name: &str, after: Option<&str>, sharded: bool, args: Vec<Value>| {
            let mut step = json!({ "name": name });
            if let Some(after) = after {
                step["dependencies"] = json!([{ "dependsOn": after }]);
            }
            let mut parameters = Vec::new();
            if self.frames.is_some() {
                parameters.push(json!({ "name": "Frame", "type": "INT", "range": "{{Param.Frames}}" }));
            }
            if sharded {
                parameters.push(json!({ "name": "Shard", "type": "INT", "range": format!("1-{}", self.shards) }));
            }
            if !parameters.is_empty() {
                step["parameterSpace"] = json!({ "taskParameterDefinitions": parameters });
            }
            // A worker that is stopped has time to write a last checkpoint.
            let gently = json!({ "mode": "NOTIFY_THEN_TERMINATE", "notifyPeriodInSeconds": 60 });
            step["script"] = json!({ "actions": { "onRun": {
                "command": "{{Param.Eyebox}}", "args": args, "cancelation": gently
            } } });
            step
        };
        json!({
            "specificationVersion": "jobtemplate-2023-09",
            "name": self.name,
            "parameterDefinitions": self.parameters(),
            "steps": [
                step("Plan", None, false, plan),
                step("Render", Some("Plan"), true, render),
                step("Merge", Some("Render"), false, merge),
            ],
        })
    }

    fn parameters(&self) -> Value {
        let path = |name: &str, of: &str, flow: &str, default: &Option<String>, what: &str| {
            let mut path =
                json!({ "name": name, "type": "PATH", "objectType": of, "dataFlow": flow, "description": what });
            if let Some(default) = default {
                path["default"] = json!(default);
            }
            path
        };
        let mut all = vec![
            path("Asset", "FILE", "IN", &self.asset, "The assembly to render."),
            path("AssetFolder", "DIRECTORY", "IN", &self.asset_folder, "Holds every file that the assembly needs."),
            path("OutputFolder", "DIRECTORY", "INOUT", &self.output_folder, "Plans, shards and the merged pictures."),
            json!({ "name": "Output", "type": "STRING", "default": self.output,
                "description": "Name of the merged picture; # stands for the digits of the frame." }),
            json!({ "name": "Samples", "type": "INT", "minValue": 1, "default": self.samples,
                "description": "Passes of all shards together." }),
            json!({ "name": "Seed", "type": "INT", "minValue": 0, "default": self.seed, "description": "Seed of the random numbers." }),
            json!({ "name": "Eyebox", "type": "STRING", "default": "eyebox", "description": "The program on the worker." }),
        ];
        if let Some(frames) = &self.frames {
            let range = |(first, last, step): &(i64, i64, u64)| match (first == last, step) {
                (true, _) => first.to_string(),
                (false, 1) => format!("{first}-{last}"),
                (false, step) => format!("{first}-{last}:{step}"),
            };
            let ranges = frames.iter().map(range).collect::<Vec<_>>().join(",");
            all.push(json!({ "name": "Frames", "type": "STRING", "default": ranges,
                "description": "Time codes: A-B or A-B:STEP, several with commas between them." }));
        }
        Value::from(all)
    }

    /// A file of one frame's work.
    fn file(&self, kind: &str) -> String {
        // `hud.v1.####.exr` and `hud.v2.####.exr` may lie in one folder.
        let name = self.output.rsplit_once('.').map_or(self.output.as_str(), |(stem, _)| stem);
        let stem = name.replace('#', "").trim_end_matches(['.', '_', '-']).to_owned();
        match &self.frames {
            Some(_) => format!("{{{{Param.OutputFolder}}}}/{stem}.{{{{Task.Param.Frame}}}}.{kind}"),
            None => format!("{{{{Param.OutputFolder}}}}/{stem}.{kind}"),
        }
    }

    fn shard_file(&self, index: &str) -> String {
        self.file(&format!("shard-{index}-of-{}.exr", self.shards))
    }
}

/// A JSON value as YAML 1.2: blocks of two more spaces each, scalars as JSON has them, which YAML includes.
pub fn yaml(value: &Value) -> String {
    let mut out = String::new();
    block(value, 0, &mut out);
    out
}

fn block(value: &Value, depth: usize, out: &mut String) {
    let indent = "  ".repeat(depth);
    match value {
        Value::Object(map) if !map.is_empty() => {
            for (key, value) in map {
                let _ = write!(out, "{indent}{key}:");
                below(value, depth, out);
            }
        }
        Value::Array(list) if !list.is_empty() => {
            for value in list {
                let _ = write!(out, "{indent}-");
                match value {
                    // The first key stands beside the dash.
                    Value::Object(map) if !map.is_empty() => {
                        let mut inner = String::new();
                        block(value, depth + 1, &mut inner);
                        let _ = write!(out, " {}", inner.trim_start());
                    }
                    other => below(other, depth, out),
                }
            }
        }
        scalar => {
            let _ = writeln!(out, "{indent}{scalar}");
        }
    }
}

fn below(value: &Value, depth: usize, out: &mut String) {
    match value {
        Value::Object(map) if !map.is_empty() => {
            out.push('\n');
            block(value, depth + 1, out);
        }
        Value::Array(list) if !list.is_empty() => {
            out.push('\n');
            block(value, depth + 1, out);
        }
        scalar => {
            let _ = writeln!(out, " {scalar}");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn job(frames: Option<Vec<(i64, i64, u64)>>) -> Job {
        Job {
            name: "hud".to_owned(),
            asset: Some("a/hud.usda".to_owned()),
            asset_folder: Some("a".to_owned()),
            output_folder: None,
            output: "hud.####.exr".to_owned(),
            shards: 3,
            samples: 64,
            seed: 1,
            frames,
            plan_options: vec!["--set".to_owned(), "led.flux_lm=1: # \"x\"".to_owned()],
            render_options: Vec::new(),
            checkpoint_s: 60,
        }
    }

    #[test]
    fn steps_follow_each_other_and_name_every_shard() {
        let template = job(Some(vec![(1, 9, 2), (12, 12, 1)])).template();
        let steps = template["steps"].as_array().unwrap();
        let names: Vec<_> = steps.iter().map(|step| step["name"].as_str().unwrap()).collect();
        assert_eq!(names, ["Plan", "Render", "Merge"]);
        assert_eq!(steps[2]["dependencies"][0]["dependsOn"], "Render");
        let merge = steps[2]["script"]["actions"]["onRun"]["args"].to_string();
        (1..=3).for_each(|k| assert!(merge.contains(&format!("shard-{k}-of-3.exr")), "{merge}"));
        let frames = template["parameterDefinitions"].as_array().unwrap().last().unwrap().clone();
        assert_eq!(frames["default"], "1-9:2,12");
        assert!(template["parameterDefinitions"][2].get("default").is_none());
        assert_eq!(template["parameterDefinitions"][1]["default"], "a");
        let still = job(None).template().to_string();
        assert!(!still.contains("Frame"), "{still}");
    }

    #[test]
    fn yaml_is_blocks_with_quoted_texts() {
        let value = json!({ "a": [1, { "b": "x: \"#\"", "c": [] }, ["d"]], "e": {}, "f": true });
        let want = "a:\n  - 1\n  - b: \"x: \\\"#\\\"\"\n    c: []\n  -\n    - \"d\"\ne: {}\nf: true\n";
        assert_eq!(yaml(&value), want);
    }
}
