//! `--frame` against usd-core: samples, held and interpolated, and layer offsets on sublayers, references and payloads.
//!
//! `tests/data/usd_frames/expected.txt` is what usd-core says of `root.usda` there; `tests/interchange/usd_frames.py`
//! made it.

use crate::usd::read;
use crate::{Assembly, ReadOptions};
use eyebox_scene::assembly::LightForm;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

fn data(name: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("tests/data/usd_frames").join(name)
}

/// Single precision, and what usd-core loses by turning quaternions into angles and back.
fn close(a: &[f64], b: &[f64]) -> bool {
    let scale = b.iter().fold(1.0, |most: f64, x| most.max(x.abs()));
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-6 * scale)
}

/// What `assembly` has for a line of the file; none for prims that are not shown.
fn found(assembly: &Assembly, path: &str, what: &str, light: &BTreeMap<String, f64>) -> Option<(Vec<f64>, Vec<f64>)> {
    let index = assembly.nodes.iter().position(|node| node.path == path)?;
    let node = &assembly.nodes[index];
    match what {
        "world" => {
            let m = node.to_world;
            let rows =
                [(m.matrix3.x_axis, 0.0), (m.matrix3.y_axis, 0.0), (m.matrix3.z_axis, 0.0), (m.translation, 1.0)];
            Some((rows.iter().flat_map(|(v, last)| [v.x, v.y, v.z, *last]).collect(), Vec::new()))
        }
        "points" => {
            let mesh = &assembly.meshes[node.mesh?].mesh;
            // Flat shading gives each triangle points of its own.
            let mut points: Vec<[f64; 3]> = mesh.positions.iter().map(|p| p.map(f64::from)).collect();
            points.sort_by(|a, b| a.partial_cmp(b).unwrap());
            points.dedup();
            Some((points.concat(), Vec::new()))
        }
        "normalize" => {
            let own = assembly.lights.iter().find(|light| light.node == index)?;
            let LightForm::Rect { luminance_cd_m2, width, .. } = own.form else { panic!("{:?}", own.form) };
            let at = |name: &str| light[name];
            let area = if at("normalize") != 0.0 { at("width") } else { 1.0 };
            Some((vec![luminance_cd_m2, width], vec![at("intensity") * at("exposure").exp2() / area, at("width")]))
        }
        other => panic!("{other}"),
    }
}

#[test]
fn values_at_a_time_are_usd_cores() {
    let text = std::fs::read_to_string(data("expected.txt")).unwrap();
    let mut by_time: BTreeMap<String, Vec<&str>> = BTreeMap::new();
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let (time, rest) = line.split_once(' ').unwrap();
        by_time.entry(time.to_owned()).or_default().push(rest);
    }
    assert_eq!(by_time.len(), 14);
    let mut wrong = Vec::new();
    for (time, lines) in by_time {
        let options = ReadOptions { frame: Some(time.parse().unwrap()), ..ReadOptions::default() };
        let assembly = read(&data("root.usda"), &options).unwrap();
        let mut light = BTreeMap::new();
        for line in lines {
            let mut words = line.split(' ');
            let (path, what) = (words.next().unwrap(), words.next().unwrap());
            let mut want: Vec<f64> = words.map(|word| word.parse().unwrap()).collect();
            let shown = assembly.nodes.iter().any(|node| node.path == path);
            match what {
                "hidden" if shown => wrong.push(format!("{time} {path}: shown")),
                "hidden" => continue,
                "intensity" | "exposure" | "width" => {
                    light.insert(what.to_owned(), want[0]);
                    continue;
                }
                "normalize" => {
                    light.insert(what.to_owned(), want[0]);
                }
                "points" => {
                    let mut points: Vec<[f64; 3]> = want.chunks(3).map(|p| [p[0], p[1], p[2]]).collect();
                    points.sort_by(|a, b| a.partial_cmp(b).unwrap());
                    want = points.concat();
                }
                _ => {}
            }
            match found(&assembly, path, what, &light) {
                None => wrong.push(format!("{time} {path}: no {what}")),
                Some((own, said)) => {
                    let want = if said.is_empty() { want } else { said };
                    if !close(&own, &want) {
                        wrong.push(format!("{time} {path} {what}: {own:?}, usd-core says {want:?}"));
                    }
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} differ:\n{}", wrong.len(), wrong.join("\n"));
}
