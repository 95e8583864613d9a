//! Light paths as lines that a viewer shows beside the asset, and what became of their light.

mod glb;
mod usda;

use eyebox_base::error::Result;
use eyebox_base::{Error, Where};
use glam::{DMat3, DVec3};
use std::collections::BTreeMap;
use std::path::Path;

/// Where a path, or a share of its light, ended. Names are those of parts.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum End {
    /// In the pupil: in the picture, or from outside of the field of view.
    Arrived,
    PastField,
    /// From the eye: at a face that shines at it, or in the sky.
    Lamp(String),
    Sky,
    Absorbed(String),
    Escaped,
    /// Ended by chance, too faint to matter; light that chance added to the others balances it.
    Faint,
    /// Sent to the wrong side of a face by the interpolated normals of a mesh.
    WrongSide,
    /// Still under way after very many faces.
    Cut,
}

impl End {
    /// The kind, for colours and files.
    pub fn kind(&self) -> &'static str {
        match self {
            End::Arrived => "arrived",
            End::PastField => "arrived outside the field of view",
            End::Lamp(_) => "lamp",
            End::Sky => "sky",
            End::Absorbed(_) => "absorbed",
            End::Escaped => "escaped",
            End::Faint => "faint",
            End::WrongSide => "wrong side",
            End::Cut => "cut",
        }
    }

    pub fn part(&self) -> Option<&str> {
        match self {
            End::Lamp(part) | End::Absorbed(part) => Some(part),
            End::Arrived | End::PastField | End::Sky | End::Escaped | End::Faint | End::WrongSide | End::Cut => None,
        }
    }

    /// `absorbed at HOUSING_TUBE`
    pub fn text(&self) -> String {
        match self {
            End::Absorbed(part) => format!("absorbed at {part}"),
            End::Lamp(part) => format!("met the lamp {part}"),
            End::Sky => "met the sky".to_owned(),
            End::Faint => "too faint to follow".to_owned(),
            End::WrongSide => "sent to the wrong side of a face by a mesh's normals".to_owned(),
            End::Cut => "still under way after very many faces".to_owned(),
            End::Arrived => "arrived in the pupil".to_owned(),
            End::PastField => "arrived in the pupil from outside the field of view".to_owned(),
            End::Escaped => "left the scene".to_owned(),
        }
    }

    /// Linear Rec.709.
    pub fn colour(&self) -> [f32; 3] {
        match self {
            End::Arrived | End::Lamp(_) => [0.05, 0.8, 0.1],
            End::Sky => [0.1, 0.6, 0.9],
            End::PastField => [0.8, 0.75, 0.05],
            End::Absorbed(_) => [0.8, 0.04, 0.03],
            End::Escaped => [0.05, 0.12, 0.9],
            End::Faint => [0.25, 0.25, 0.25],
            End::WrongSide | End::Cut => [0.8, 0.05, 0.7],
        }
    }
}

/// One path.
#[derive(Debug, Clone)]
pub struct Strip {
    /// Start, turns and end.
    pub points: Vec<DVec3>,
    /// Names of the parts that it met, the lamp that it started on first.
    pub met: Vec<String>,
    pub end: End,
    /// Of what it started with, carried when it met its end.
    pub power: f64,
}

/// What became of light: of each end, its share of the power and the paths that ended there.
#[derive(Debug, Clone, Default)]
pub struct Fates {
    pub started: f64,
    /// What chance added to paths that went on.
    pub gained: f64,
    pub paths: u64,
    pub all: BTreeMap<End, Fate>,
}

#[derive(Debug, Clone, Copy, Default)]
pub struct Fate {
    pub power: f64,
    pub paths: u64,
}

impl Fates {
    pub fn merge(&mut self, other: Fates) {
        self.started += other.started;
        self.gained += other.gained;
        self.paths += other.paths;
        for (end, fate) in other.all {
            let own = self.all.entry(end).or_default();
            own.power += fate.power;
            own.paths += fate.paths;
        }
    }

    /// Share of what was started, most first. What chance added to paths is taken off what it took from others, so that the
    /// shares add up to 1 but for the noise of scattering.
    pub fn shares(&self) -> Vec<(&End, f64, u64)> {
        let share = |(end, fate): (&'_ End, &Fate)| {
            let power = if *end == End::Faint { fate.power - self.gained } else { fate.power };
            power / self.started
        };
        let mut shares: Vec<(&End, f64, u64)> =
            self.all.iter().map(|(end, fate)| (end, share((end, fate)), fate.paths)).collect();
        shares.sort_by(|a, b| b.1.total_cmp(&a.1));
        shares
    }

    pub fn text(&self) -> String {
        let line = |(end, share, paths): &(&End, f64, u64)| {
            format!("{:>8.3} %  {paths:>8} paths  {}", 100.0 * share, end.text())
        };
        self.shares().iter().map(line).collect::<Vec<_>>().join("\n")
    }

    pub fn json(&self) -> serde_json::Value {
        let row = |(end, share, paths): &(&End, f64, u64)| serde_json::json!({ "fate": end.kind(), "part": end.part(), "share": share, "paths": paths });
        self.shares().iter().map(row).collect()
    }
}

/// The coordinates of the file: a point p of the scene's world, m, is `turn`·p/`unit_m` there.
#[derive(Debug, Clone, Copy)]
pub struct Space {
    pub unit_m: f64,
    pub turn: DMat3,
    /// The file's up is +z.
    pub z_up: bool,
}

/// Writes paths (m, the scene's world) as lines: glTF (`.glb`) or USD (`.usda`).
///
/// Faults: another extension; coordinates that 32 bits can't hold; a file that can't be written.
pub fn write(out: &Path, strips: &[Strip], space: &Space) -> Result<()> {
    let places = |strip: &Strip| -> Vec<[f32; 3]> {
        let place = |p: &DVec3| (space.turn * *p / space.unit_m).as_vec3().to_array();
        strip.points.iter().map(place).collect()
    };
    let lines: Vec<Line<'_>> = strips.iter().map(|strip| Line { strip, points: places(strip) }).collect();
    if !lines.iter().flat_map(|line| line.points.as_flattened()).all(|x| x.is_finite()) {
        return Err(Error::new(Where::file(out), "coordinates are too large for the file"));
    }
    let bytes = match extension(out).as_str() {
        "glb" => glb::bytes(&lines).ok_or_else(|| {
            Error::new(Where::file(out), "the file would be larger than 4 GiB").expected("fewer rays")
        })?,
        "usda" => usda::text(&lines, space).into_bytes(),
        _ => return Err(unknown(out)),
    };
    eyebox_base::atomic::write_atomic(out, &bytes)
}

/// The fault of a name that no format goes with.
pub fn unknown(out: &Path) -> Box<Error> {
    Error::new(Where::file(out), "is no name for a file of rays").expected("a name that ends in .glb or .usda")
}

pub fn extension(path: &Path) -> String {
    path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

/// A path in the coordinates of the file.
struct Line<'s> {
    strip: &'s Strip,
    points: Vec<[f32; 3]>,
}

/// Lines by their ends, in the order of the ends.
fn by_end<'l, 's>(lines: &'l [Line<'s>]) -> BTreeMap<&'s End, Vec<&'l Line<'s>>> {
    let mut groups: BTreeMap<&End, Vec<&Line<'_>>> = BTreeMap::new();
    for line in lines {
        groups.entry(&line.strip.end).or_default().push(line);
    }
    groups
}
