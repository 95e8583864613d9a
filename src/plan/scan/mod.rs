//! The virtual image over an eyebox: from every position of a grid its luminance, distortion, distance, and what two eyes
//! see of it. Definitions are in `docs/scan.md`.

pub mod charts;
pub mod edges;
pub mod ghosts;
pub mod light;
pub mod limits;
pub mod lines;
mod patch;
pub mod places;
pub mod table;
mod tuning;

use edges::{Edges, edges};
use eyebox_base::error::Result;
use eyebox_base::{Error, Where};
use eyebox_estimate::ShouldStop;
use eyebox_estimate::virtual_image::aim::{Sight, aim, aim_alone, aim_over};
use eyebox_estimate::virtual_image::image::{Disparity, Distortion, Vergence, arcmin, disparity, distortion, vergence};
use eyebox_estimate::virtual_image::subject::{Kind, Point, Subject, is_too_much};
use eyebox_scene::{Eye, Scene};
use eyebox_world::World;
use eyebox_world::mode::{Mode, Mono};
use eyebox_world::optics::Optics;
use ghosts::Ghost;
use glam::DVec3;
use light::{LightAsked, White, white};
use places::Places;
use tuning::scan::DEFAULT_PUPIL_M;
pub use tuning::scan::{MOST_POINTS, MOST_POSITIONS};

/// What is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanAsked {
    /// Columns and rows of eye positions.
    pub positions: [usize; 2],
    /// Width and height of the eyebox, m; twice the pupil's diameter if none.
    pub size_m: [Option<f64>; 2],
    /// Interpupillary distance, m.
    pub ipd_m: f64,
    /// Columns and rows of points of the picture, at least 3 each.
    pub points: [usize; 2],
    /// Path of the part that is looked at.
    pub target: Option<String>,
    /// None: geometry alone.
    pub light: Option<LightAsked>,
    /// Whether the eyebox's edges are looked for.
    pub edges: bool,
}

/// What was found. Lengths in m.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Scan {
    /// Path of the part that is looked at, its face, how it is seen, and its size.
    pub part: String,
    pub face: u32,
    pub kind: Kind,
    /// The parts between it and the eye, as `eyebox paths` names them.
    pub by: String,
    pub picture_m: [f64; 2],
    pub eyebox_m: [f64; 2],
    pub ipd_m: f64,
    /// Row by row from the upper left as the eye looks.
    pub positions: Vec<Position>,
    /// The largest share of a ray's light whose ways were not followed when ghosts were looked for, though each carries as much as a
    /// ghost has to.
    #[serde(default)]
    pub ghosts_left_out: f64,
    /// If they were asked for.
    #[serde(default)]
    pub edges: Option<Edges>,
}

/// What is seen from one position.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Position {
    /// To the right and up from the scene's eye, m.
    pub x_m: f64,
    pub y_m: f64,
    /// Share of the picture's points that the middle of the pupil sees.
    pub seen: f64,
    /// Share of what is seen that lies outside of the eye's own field of view: `render` cuts it off from here.
    pub cut: f64,
    /// What ways that were not followed carry of a ray, at most, over what a ray brings from the picture: a 64th at most where there were
    /// not too many of them.
    #[serde(default)]
    pub left_out: f64,
    /// Why nothing was scanned from here.
    pub why: Option<String>,
    /// What is suspicious about what was found.
    pub warning: Option<String>,
    pub luminance: Option<White>,
    pub distortion: Option<Distortion>,
    pub distance: Option<Distances>,
    pub disparity: Option<Disparities>,
    /// Second images, those with most light first.
    pub ghosts: Vec<Ghost>,
    pub points: Vec<Line>,
}

/// Vergences of the points that are seen by the whole pupil's cross, dioptres.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Distances {
    /// At the middle of the picture, if it is seen.
    pub centre_per_m: Option<f64>,
    pub mean_per_m: f64,
    pub least_per_m: f64,
    pub most_per_m: f64,
    /// Largest |horizontal − vertical|.
    pub astigmatism_per_m: f64,
}

/// Over the points that both eyes see.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Disparities {
    /// Share of the points that both eyes see.
    pub seen: f64,
    pub mean_convergence_arcmin: f64,
    pub least_convergence_arcmin: f64,
    pub most_convergence_arcmin: f64,
    /// Largest |dipvergence|.
    pub dipvergence_arcmin: f64,
}

/// One point of the picture.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Line {
    /// Column and row.
    pub cell: [usize; 2],
    pub seen: bool,
    /// From the viewing axis to the right and up as a picture has it, degrees: atan(x/z) and atan(y/z) of the direction (x right, y up, z ahead);
    /// also where something hides it.
    pub direction_deg: Option<[f64; 2]>,
    pub vergence: Option<Vergence>,
    pub disparity: Option<Disparity>,
}

/// Scans. None if `stop` said true. `each` is told how many positions are done.
/// Errors: nothing to look at, numbers out of range, a scene that cannot be traced.
pub fn scan(
    scene: &Scene,
    asked: &ScanAsked,
    stop: &ShouldStop<'_>,
    mut each: impl FnMut(usize),
) -> Result<Option<Scan>> {
    let eyebox_m = checked(scene, asked)?;
    let mut scene = scene.clone();
    let half = scene.eye.half_tangents();
    if let Some(light) = &asked.light {
        // The display alone: what is behind it is no business of the eyebox.
        scene.sky = None;
        scene.eye.resolution = light.resolution;
    }
    let world = World::freeze(&scene)?;
    let optics = Mono::<f64>::optics(&world, 0, 0);
    let subject = Subject::find(&scene, (&world, &optics), asked.target.as_deref(), asked.points)?;
    let subject = subject.polarised((&world, &optics)).stitched((&world, &optics));
    let (doubled, ghosts_left_out) = ghosts::trains(&scene, (&world, &optics), &subject);
    let by = ghosts::name(&scene, &world, &subject);
    let (middle, [columns, rows]) = (scene.eye.position, asked.positions);
    let mut positions = Vec::with_capacity(columns * rows);
    for index in 0..columns * rows {
        let x_m = place(index % columns, columns) * eyebox_m[0];
        let y_m = place(rows - 1 - index / columns, rows) * eyebox_m[1];
        scene.eye.position = middle + scene.eye.right() * x_m + scene.eye.up * y_m;
        let mut position = Position { x_m, y_m, ..Position::nowhere() };
        match World::freeze(&scene) {
            Ok(world) => {
                let optics = Mono::<f64>::optics(&world, 0, 0);
                let subject = subject.stitched((&world, &optics));
                position.left_out = subject.left_out;
                lines::fill(&mut position, (&world, &optics), &scene.eye, &subject, asked.ipd_m);
                position.ghosts = ghosts::seen((&world, &optics), &subject, &doubled, &scene.eye);
                let places = Places::new(&position.points, asked.points);
                position.cut = places.cut(half);
                if let Some(light) = &asked.light {
                    let blur = blur(&scene.eye, &position);
                    match white(&mut scene, light, (&places, blur), asked.points, stop) {
                        Ok(found) => position.luminance = found,
                        Err(fault) => position.why = Some(fault.to_string()),
                    }
                }
                position.warning = match position.luminance {
                    Some(white) if white.black => Some(black(&position)),
                    Some(_) | None => missed(&position),
                };
            }
            // The eye is inside of something, most likely.
            Err(fault) => position.why = Some(fault.to_string()),
        }
        if stop() {
            return Ok(None);
        }
        positions.push(position);
        each(positions.len());
    }
    scene.eye.position = middle;
    let mut ends = None;
    if asked.edges {
        let light = asked.light.as_ref();
        let found = edges(&mut scene, (&world, &optics), &subject, (eyebox_m, asked.points), light, stop)?;
        let Some(found) = found else { return Ok(None) };
        ends = Some(found);
    }
    let part = scene.parts.get(subject.part as usize).map_or_else(String::new, |part| part.path.clone());
    let (face, kind, picture_m) = (subject.face, subject.kind, subject.size);
    let ipd_m = asked.ipd_m;
    Ok(Some(Scan { part, face, kind, by, picture_m, eyebox_m, ipd_m, positions, ghosts_left_out, edges: ends }))
}

impl Position {
    /// One from which nothing was looked at yet.
    pub fn nowhere() -> Position {
        Position {
            x_m: 0.0,
            y_m: 0.0,
            seen: 0.0,
            cut: 0.0,
            left_out: 0.0,
            why: None,
            warning: None,
            luminance: None,
            distortion: None,
            distance: None,
            disparity: None,
            ghosts: Vec::new(),
            points: Vec::new(),
        }
    }
}

/// Radius of the spot that the pupil makes of a point that is farthest out of its focus, tangents.
fn blur(eye: &Eye, position: &Position) -> f64 {
    let off = |per_m: f64| (per_m - 1.0 / eye.focus_distance_m).abs();
    0.5 * eye.pupil_diameter_m * position.distance.map_or(0.0, |d| off(d.least_per_m).max(off(d.most_per_m)))
}

/// What is said of a picture without light.
fn black(position: &Position) -> String {
    format!(
        "from x {:.2} mm, y {:.2} mm {:.0} % of the picture's points are seen, and no light comes from them though lamps are \
         on: something between lamps and picture is wrong, or the paths were not found (look with `eyebox rays`)",
        1e3 * position.x_m,
        1e3 * position.y_m,
        100.0 * position.seen
    )
}

/// What is said where not all is seen of a picture to which not all ways were followed.
fn missed(position: &Position) -> Option<String> {
    (position.seen < 1.0 && is_too_much(position.left_out)).then(|| {
        format!(
            "from x {:.2} mm, y {:.2} mm {:.0} % of the picture's points are seen, and more may be seen over ways that were not \
             followed, there are so many: they have up to {:.1} % of the light that the picture has",
            1e3 * position.x_m,
            1e3 * position.y_m,
            100.0 * position.seen,
            100.0 * position.left_out
        )
    })
}

/// Of `count` positions over −½ … ½ the one with this number; one alone is in the middle.
fn place(index: usize, count: usize) -> f64 {
    if count < 2 { 0.0 } else { index as f64 / (count - 1) as f64 - 0.5 }
}

/// The eyebox's size, m. Errors: numbers out of range.
fn checked(scene: &Scene, asked: &ScanAsked) -> Result<[f64; 2]> {
    let option = |text: &str| Where::Option(text.to_owned());
    let product = |[a, b]: [usize; 2]| a.saturating_mul(b);
    if !(1..=MOST_POSITIONS).contains(&product(asked.positions)) {
        let [columns, rows] = asked.positions;
        return Err(Error::new(option("--eyebox"), format!("{columns} × {rows} eye positions"))
            .expected(format!("1 to {MOST_POSITIONS} in all")));
    }
    if asked.points.iter().any(|n| *n < 3) || product(asked.points) > MOST_POINTS {
        let [columns, rows] = asked.points;
        return Err(Error::new(option("--points"), format!("{columns} × {rows} points of the picture"))
            .expected(format!("at least 3 each way and at most {MOST_POINTS} in all")));
    }
    if !(asked.ipd_m > 0.0 && asked.ipd_m.is_finite()) {
        return Err(Error::new(option("--ipd"), format!("{} m between the eyes", asked.ipd_m)).expected("above 0"));
    }
    let mut size = [0.0; 2];
    for (axis, name) in ["--width", "--height"].into_iter().enumerate() {
        let default = 2.0 * scene.eye.pupil_diameter_m;
        size[axis] = asked.size_m[axis].unwrap_or(default);
        if !(size[axis] >= 0.0 && size[axis].is_finite()) {
            return Err(Error::new(option(name), format!("{} m", size[axis])).expected("0 or more"));
        }
        if asked.positions[axis] > 1 && size[axis] == 0.0 {
            return Err(Error::new(option(name), "all eye positions would be one")
                .expected("a size above 0 (the default is two pupil diameters, and this pupil is a point)"));
        }
    }
    Ok(size)
}

/// Half the distance over which the vergence is taken, m: the root of the mean square of a disc's points along an axis.
fn step_m(eye: &Eye) -> f64 {
    let diameter = if eye.pupil_diameter_m > 0.0 { eye.pupil_diameter_m } else { DEFAULT_PUPIL_M };
    diameter / 4.0
}
