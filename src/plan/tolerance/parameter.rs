//! What may be off in a design, and by how much: the rows of a file of tolerances.

use eyebox_base::error::Result;
use eyebox_base::{Error, Where};
use eyebox_import::select::glob;
use eyebox_scene::value::Value;
use eyebox_scene::{Finish, Scene};
use glam::DVec3;
use std::collections::HashSet;

/// How a parameter is spread about nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Law {
    /// `size` is the standard deviation.
    Normal,
    /// `size` is the half-width: all values from −size to size are as likely.
    Uniform,
}

/// What a parameter changes. Axes are the scene's: x to the right, y up for glTF; USD stages with z up are turned.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Change {
    /// Shifts parts along an axis (0 x, 1 y, 2 z), m.
    Decenter { axis: usize },
    /// Turns parts about an axis through `about` (world, m), rad.
    Tilt { axis: usize, about: DVec3 },
    /// Scales the radius of a face's exact surface; a share of it.
    Radius { face: usize },
    /// Shifts a face along its mean outward normal, m.
    Thickness { face: usize },
    /// Turns a face about its middle, rad: about the horizontal (0) or the other axis (1) across its mean normal. Of a face that
    /// looks up or down the first one is x.
    Wedge { face: usize, axis: usize },
    /// Adds to the refractive index of the parts' medium, at all wavelengths alike.
    Index,
}

/// One number that is drawn.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Parameter {
    /// Part or group, and what changes: unique within a file.
    pub name: String,
    /// Parts that change together.
    pub parts: Vec<usize>,
    pub change: Change,
    pub law: Law,
    /// In the unit of `change`.
    pub size: f64,
    #[serde(skip)]
    pub at: Where,
}

const KEYS: [&str; 11] = [
    "part",
    "group",
    "face",
    "about_mm",
    "distribution",
    "decenter_mm",
    "tilt_arcmin",
    "radius_percent",
    "thickness_mm",
    "wedge_arcmin",
    "index",
];

/// Radians of minutes of arc.
fn radians(arcmin: f64) -> f64 {
    (arcmin / 60.0).to_radians()
}

/// Reads the `[[tolerance]]` tables of a file of tolerances for a scene.
/// Errors: no such table, an unknown key or part, a number out of range, a face without a radius: with the line.
pub fn parameters(root: &Value, scene: &Scene) -> Result<Vec<Parameter>> {
    let mut out: Vec<Parameter> = Vec::new();
    let mut names = HashSet::new();
    let none = || {
        Error::new(root.at.clone(), "no tolerances")
            .expected("[[tolerance]] tables, each with a part and what of it may be off")
    };
    for (key, value) in root.table().ok_or_else(none)? {
        if key != "tolerance" {
            return Err(value.unknown_key(key, "a file of tolerances", &["tolerance"]));
        }
        for row in value.list().ok_or_else(|| value.wrong("`tolerance`", "[[tolerance]] tables"))? {
            for parameter in of_row(row, scene)? {
                if !names.insert(parameter.name.clone()) {
                    let what = format!("{} is there twice", parameter.name);
                    return Err(Error::new(parameter.at, what).expected("each parameter once"));
                }
                out.push(parameter);
            }
        }
    }
    if out.is_empty() { Err(none()) } else { Ok(out) }
}

/// A number of 0 or more.
fn size(value: &Value, what: &str) -> Result<f64> {
    value.number().filter(|n| *n >= 0.0 && n.is_finite()).ok_or_else(|| value.wrong(what, "a number of 0 or more"))
}

/// `count` numbers, each as `one` reads it.
fn several<const N: usize>(value: &Value, what: &str, one: impl Fn(&Value) -> Result<f64>) -> Result<[f64; N]> {
    let list = value.list().filter(|list| list.len() == N);
    let list = list.ok_or_else(|| value.wrong(what, &format!("{N} numbers")))?;
    let mut out = [0.0; N];
    for (out, value) in out.iter_mut().zip(list) {
        *out = one(value)?;
    }
    Ok(out)
}

/// Which parts a row is about: for each the name and the parts that change together.
fn subjects(row: &Value, scene: &Scene) -> Result<Vec<(String, Vec<usize>)>> {
    let (key, value) = match (row.get("part"), row.get("group")) {
        (Some(part), None) => ("part", part),
        (None, Some(group)) => ("group", group),
        (None, None) | (Some(_), Some(_)) => {
            return Err(Error::new(row.at.clone(), "a tolerance is of one part or one group").expected(
                "`part` (a path, name or pattern) or `group` (a node that holds parts which move together)",
            ));
        }
    };
    let text = value.text().ok_or_else(|| value.wrong(&format!("`{key}`"), "a text"))?;
    let parts = || scene.parts.iter().enumerate();
    let found: Vec<(String, Vec<usize>)> = if key == "group" {
        let inside = format!("{text}/");
        let all: Vec<usize> =
            parts().filter(|(_, p)| p.path.starts_with(&inside) || p.path == text).map(|(i, _)| i).collect();
        if all.is_empty() { Vec::new() } else { vec![(text.to_owned(), all)] }
    } else {
        let matches = |path: &str, name: &str| glob(text, path) || glob(text, name);
        parts().filter(|(_, p)| matches(&p.path, &p.name)).map(|(i, p)| (p.path.clone(), vec![i])).collect()
    };
    if found.is_empty() {
        let names = || parts().flat_map(|(_, part)| [part.path.as_str(), part.name.as_str()]);
        return Err(Error::new(value.at.clone(), format!("no {key} `{text}`")).nearest(text, names()));
    }
    Ok(found)
}

fn of_row(row: &Value, scene: &Scene) -> Result<Vec<Parameter>> {
    for (key, value) in row.table().ok_or_else(|| row.wrong("a tolerance", "a table"))? {
        if !KEYS.contains(&key.as_str()) {
            return Err(value.unknown_key(key, "a tolerance", &KEYS));
        }
    }
    let stray = |key: &str, needs: &[&str]| match row.get(key) {
        Some(value) if needs.iter().all(|need| row.get(need).is_none()) => {
            Err(Error::new(value.at.clone(), format!("`{key}` means nothing here"))
                .expected(format!("beside it {}", needs.join(", "))))
        }
        Some(_) | None => Ok(()),
    };
    stray("face", &["radius_percent", "thickness_mm", "wedge_arcmin"])?;
    stray("about_mm", &["tilt_arcmin"])?;
    let law = match row.get("distribution") {
        None => Law::Normal,
        Some(value) => match value.text() {
            Some("normal") => Law::Normal,
            Some("uniform") => Law::Uniform,
            _ => {
                return Err(value
                    .wrong("`distribution`", "normal (numbers are standard deviations) or uniform (half-widths)")
                    .nearest(value.text().unwrap_or_default(), ["normal", "uniform"]));
            }
        },
    };
    let mut out = Vec::new();
    for (name, parts) in subjects(row, scene)? {
        let mut push = |what: &str, change: Change, size: f64, value: &Value| {
            if size > 0.0 {
                let name = format!("{name} {what}");
                out.push(Parameter { name, parts: parts.clone(), change, law, size, at: value.at.clone() });
            }
        };
        if let Some(value) = row.get("decenter_mm") {
            let all = several::<3>(value, "`decenter_mm`", |v| size(v, "a decenter"))?;
            for (axis, mm) in all.into_iter().enumerate() {
                push(&format!("decenter {}", AXES[axis]), Change::Decenter { axis }, 1e-3 * mm, value);
            }
        }
        if let Some(value) = row.get("tilt_arcmin") {
            let about = match row.get("about_mm") {
                Some(at) => {
                    DVec3::from_array(several(at, "`about_mm`", |v| {
                        v.number().filter(|n| n.is_finite()).ok_or_else(|| v.wrong("`about_mm`", "three numbers"))
                    })?) * 1e-3
                }
                None => middle(scene, &parts),
            };
            for (axis, arcmin) in several::<3>(value, "`tilt_arcmin`", |v| size(v, "a tilt"))?.into_iter().enumerate() {
                push(&format!("tilt {}", AXES[axis]), Change::Tilt { axis, about }, radians(arcmin), value);
            }
        }
        if let Some(value) = row.get("index") {
            if parts.iter().any(|part| scene.parts[*part].medium.is_none()) {
                return Err(Error::new(value.at.clone(), format!("{name} has no medium, so no index")));
            }
            push("index", Change::Index, size(value, "`index`")?, value);
        }
        for (key, what) in [("radius_percent", "radius"), ("thickness_mm", "thickness"), ("wedge_arcmin", "wedge")] {
            let Some(value) = row.get(key) else { continue };
            let face = face_of(row, value, scene, &parts, &name)?;
            match what {
                "radius" => {
                    let own = &scene.parts[parts[0]].faces[face];
                    // Lamps are their triangles, and what is not there has no surface.
                    let traced = own.emitter.is_none() && own.finish != Finish::None;
                    let has = traced && own.shape.with_radius(1.0).is_some();
                    if !has {
                        return Err(Error::new(value.at.clone(), format!("face {face} of {name} has no radius"))
                            .expected("a face with an exact surface that is curved"));
                    }
                    push(
                        &format!("face {face} radius"),
                        Change::Radius { face },
                        1e-2 * size(value, "`radius_percent`")?,
                        value,
                    );
                }
                "thickness" => {
                    push(
                        &format!("face {face} thickness"),
                        Change::Thickness { face },
                        1e-3 * size(value, "`thickness_mm`")?,
                        value,
                    );
                }
                _ => {
                    for (axis, arcmin) in
                        several::<2>(value, "`wedge_arcmin`", |v| size(v, "a wedge"))?.into_iter().enumerate()
                    {
                        let word = ["horizontal", "vertical"][axis];
                        push(
                            &format!("face {face} wedge {word}"),
                            Change::Wedge { face, axis },
                            radians(arcmin),
                            value,
                        );
                    }
                }
            }
        }
    }
    if out.is_empty() {
        return Err(Error::new(row.at.clone(), "nothing of this part may be off")
            .expected(format!("one of {} above 0", KEYS[5..].join(", "))));
    }
    Ok(out)
}

const AXES: [&str; 3] = ["x", "y", "z"];

/// The face that a row names.
fn face_of(row: &Value, value: &Value, scene: &Scene, parts: &[usize], name: &str) -> Result<usize> {
    let [part] = parts else {
        return Err(
            Error::new(value.at.clone(), format!("{name} is a group; faces are those of one part")).expected("`part`")
        );
    };
    let faces = scene.parts[*part].faces.len();
    let number = row.get("face").ok_or_else(|| {
        Error::new(value.at.clone(), format!("which face of {name}?"))
            .expected(format!("`face`, 0 to {}", faces.saturating_sub(1)))
    })?;
    let found = number.number().filter(|n| *n >= 0.0 && n.fract() == 0.0 && *n < faces as f64);
    found.map(|n| n as usize).ok_or_else(|| number.wrong("`face`", &format!("0 to {}", faces.saturating_sub(1))))
}

/// The middle of the box about parts, world, m.
fn middle(scene: &Scene, parts: &[usize]) -> DVec3 {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for part in parts.iter().filter_map(|part| scene.parts.get(*part)) {
        for position in scene.meshes.get(part.mesh.index()).iter().flat_map(|mesh| &mesh.positions) {
            let at = part.to_world.transform_point3(DVec3::from_array(position.map(f64::from)));
            (low, high) = (low.min(at), high.max(at));
        }
    }
    if low.cmple(high).all() { 0.5 * (low + high) } else { DVec3::ZERO }
}
