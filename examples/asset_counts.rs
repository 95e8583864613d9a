//! Prints what the importer finds in assets, before any optics, as one JSON object per line: counts, world bounds in
//! metres, time and peak memory. The corpus scripts compare it with other programs' answers.

use eyebox::import::{Assembly, ReadOptions, read};
use glam::DVec3;
use std::path::PathBuf;
use std::time::Instant;

fn main() {
    let mut options = ReadOptions::default();
    let mut parts = false;
    for argument in std::env::args().skip(1) {
        if let Some(frame) = argument.strip_prefix("--frame=") {
            options.frame = frame.parse().ok();
        } else if argument == "--parts" {
            parts = true;
        } else {
            println!("{}", one(&PathBuf::from(&argument), &options, parts));
        }
    }
}

fn one(path: &PathBuf, options: &ReadOptions, parts: bool) -> serde_json::Value {
    let start = Instant::now();
    let result = read(path, options);
    let seconds = start.elapsed().as_secs_f64();
    let mut out = match result {
        Ok((assembly, _)) => describe(&assembly, parts),
        Err(fault) => serde_json::json!({ "error": fault.to_string() }),
    };
    out["file"] = path.to_string_lossy().into();
    out["seconds"] = seconds.into();
    out["peak_mib"] = peak_mib().into();
    out
}

fn describe(assembly: &Assembly, parts: bool) -> serde_json::Value {
    let (mut low, mut high, mut triangles, mut placed) = (DVec3::INFINITY, DVec3::NEG_INFINITY, 0, 0);
    let mut list = Vec::new();
    for node in &assembly.nodes {
        let Some(source) = node.mesh.and_then(|mesh| assembly.meshes.get(mesh)) else { continue };
        placed += 1;
        triangles += source.mesh.triangles.len();
        let (mut own_low, mut own_high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for p in &source.mesh.positions {
            let p = node.to_world.transform_point3(DVec3::from(p.map(f64::from))) * assembly.unit_m;
            (own_low, own_high) = (own_low.min(p), own_high.max(p));
        }
        (low, high) = (low.min(own_low), high.max(own_high));
        if parts {
            list.push(serde_json::json!({
                "path": node.path, "triangles": source.mesh.triangles.len(), "faces": source.mesh.faces.len(),
                "low": own_low.to_array(), "high": own_high.to_array(),
            }));
        }
    }
    let notes: Vec<String> = assembly.notes.iter().map(|note| format!("{}: {}", note.at, note.text)).collect();
    serde_json::json!({
        "nodes": assembly.nodes.len(), "meshes": assembly.meshes.len(), "placed": placed, "triangles": triangles,
        "materials": assembly.materials.len(), "cameras": assembly.cameras.len(), "lights": assembly.lights.len(),
        "low": low.to_array().map(|x| x.is_finite().then_some(x)), "high": high.to_array().map(|x| x.is_finite().then_some(x)),
        "unit_m": assembly.unit_m, "parts": list, "notes": notes,
        "dependencies": assembly.dependencies,
    })
}

/// The most memory that the process ever held (Linux; 0 elsewhere).
fn peak_mib() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmHWM"));
    let kib = line.and_then(|line| line.split_whitespace().nth(1)).and_then(|kib| kib.parse::<f64>().ok());
    kib.unwrap_or(0.0) / 1024.0
}
