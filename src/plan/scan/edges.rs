//! Where the eyebox ends: how far the eye can go from its middle to the right, left, up and down until a half is left of what
//! the middle has. Found by bisection; no chance is in it but that of the short renderings, whose seed is the scan's.

use super::light::{Level, LightAsked, White, white};
use super::places::Places;
use super::tuning::edges::{FIRST, FIRST_LIT, GROWTH, GROWTH_LIT, HALVINGS, HALVINGS_LIT, REACH, SIGMAS};
use super::tuning::scan::DEFAULT_PUPIL_M;
use super::{Position, blur, lines};
use eyebox_base::error::Result;
use eyebox_estimate::ShouldStop;
use eyebox_estimate::virtual_image::aim::{Sight, aim};
use eyebox_estimate::virtual_image::subject::{Point, Subject};
use eyebox_scene::Scene;
use eyebox_world::World;
use eyebox_world::mode::{Mode, Mono};
use eyebox_world::optics::Optics;
use glam::DVec3;

/// What falls off towards the edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Figure {
    /// The number of the picture's points that are seen.
    Seen,
    /// Whether the picture's middle is seen.
    MiddleSeen,
    /// The luminance in the picture's middle.
    CentreLuminance,
    /// The mean luminance of what is seen of the picture.
    MeanLuminance,
}

impl Figure {
    /// As tables have it.
    pub fn name(self) -> &'static str {
        match self {
            Figure::Seen => "picture seen",
            Figure::MiddleSeen => "picture's middle seen",
            Figure::CentreLuminance => "luminance, centre",
            Figure::MeanLuminance => "luminance, mean",
        }
    }
}

/// How far the eyebox reaches. Lengths in m.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Edges {
    /// How far was looked horizontally and vertically.
    pub reach_m: [f64; 2],
    pub figures: Vec<Extent>,
}

/// Of one figure. None where a half and more is left as far as was looked.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Extent {
    pub figure: Figure,
    pub left: Option<Edge>,
    pub right: Option<Edge>,
    pub down: Option<Edge>,
    pub up: Option<Edge>,
}

/// One edge.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Edge {
    /// From the eyebox's middle, m; above 0.
    pub distance_m: f64,
    /// Standard error, m: that of the two luminances over the slope between the last places. None for what geometry says, which
    /// is exact to rounding, and where the luminances have none.
    pub sigma_m: Option<f64>,
}

impl Extent {
    /// From edge to edge, m.
    pub fn width_m(&self) -> Option<f64> {
        Some(self.left?.distance_m + self.right?.distance_m)
    }
    /// From edge to edge, m.
    pub fn height_m(&self) -> Option<f64> {
        Some(self.down?.distance_m + self.up?.distance_m)
    }
}

/// Left, right, down and up: horizontal or vertical, and which way.
const WAYS: [(usize, f64); 4] = [(0, -1.0), (0, 1.0), (1, -1.0), (1, 1.0)];

/// The edges of a scene, seen from its own eye as the eyebox's middle. `eyebox_m`: width and height that were asked for, by which
/// the steps are measured. None if `stop` said true. Errors: those of a rendering from the eyebox's middle.
pub fn edges(
    scene: &mut Scene,
    tracing: (&World, &Optics<Mono>),
    subject: &Subject,
    (eyebox_m, points): ([f64; 2], [usize; 2]),
    light: Option<&LightAsked>,
    stop: &ShouldStop<'_>,
) -> Result<Option<Edges>> {
    let middle = scene.eye.position;
    let axes = [scene.eye.right(), scene.eye.up];
    let half = halves(eyebox_m);
    let mut figures = Vec::new();
    let all: Vec<&Point> = subject.points.iter().collect();
    let centre: Vec<&Point> = subject.middle().into_iter().collect();
    for (figure, points) in [(Figure::Seen, &all), (Figure::MiddleSeen, &centre)] {
        let seen = |eye: DVec3| {
            let is_seen = |point: &&&Point| {
                matches!(aim(tracing, subject, point, (subject.from, point.near), eye), Sight::Seen(_))
            };
            points.iter().filter(is_seen).count() as f64
        };
        let own = seen(middle);
        let found = WAYS.map(|(axis, way)| {
            let share = |x: f64| Some(Level { value: seen(middle + axes[axis] * (way * x)), sigma: None });
            let steps = Steps { first: FIRST * half[axis], growth: GROWTH, halvings: HALVINGS };
            edge(Level { value: own, sigma: None }, &steps, REACH * half[axis], share)
        });
        if stop() {
            return Ok(None);
        }
        figures.extend((own > 0.0).then(|| extent(figure, found)));
    }
    if let Some(light) = light {
        let found = lit(scene, subject, (half, points), light, stop)?;
        let Some(found) = found else { return Ok(None) };
        figures.extend(found);
    }
    Ok(Some(Edges { reach_m: half.map(|half| REACH * half), figures }))
}

fn extent(figure: Figure, [left, right, down, up]: [Option<Edge>; 4]) -> Extent {
    Extent { figure, left, right, down, up }
}

/// Half of what the steps are measured by, m: a side that is nothing is taken from the other one.
fn halves(eyebox_m: [f64; 2]) -> [f64; 2] {
    let most = eyebox_m[0].max(eyebox_m[1]);
    let most = if most > 0.0 { most } else { DEFAULT_PUPIL_M };
    eyebox_m.map(|side| 0.5 * if side > 0.0 { side } else { most })
}

/// The two luminances.
fn lit(
    scene: &mut Scene,
    subject: &Subject,
    (half, points): ([f64; 2], [usize; 2]),
    light: &LightAsked,
    stop: &ShouldStop<'_>,
) -> Result<Option<Vec<Extent>>> {
    let middle = scene.eye.position;
    let axes = [scene.eye.right(), scene.eye.up];
    let mut looked = Looked { subject, points, light, stop, seen: Vec::new() };
    let own = looked.from(scene, middle)?;
    let mut out = Vec::new();
    for (figure, of) in [
        (Figure::CentreLuminance, centre_of as fn(&White) -> Option<Level>),
        (Figure::MeanLuminance, mean_of as fn(&White) -> Option<Level>),
    ] {
        let Some(own) = own.as_ref().and_then(of).filter(|own| own.value > 0.0) else { continue };
        let mut found = [None; 4];
        for ((axis, way), found) in WAYS.into_iter().zip(&mut found) {
            let steps = Steps { first: FIRST_LIT * half[axis], growth: GROWTH_LIT, halvings: HALVINGS_LIT };
            *found = edge(own, &steps, REACH * half[axis], |x| {
                // From within a part there is nothing to see, as behind the edge.
                looked.from(scene, middle + axes[axis] * (way * x)).ok().flatten().as_ref().and_then(of)
            });
        }
        out.push(extent(figure, found));
    }
    scene.eye.position = middle;
    Ok((!stop()).then_some(out))
}

fn centre_of(white: &White) -> Option<Level> {
    white.centre
}

fn mean_of(white: &White) -> Option<Level> {
    white.mean
}

/// Short renderings from places that were looked from already.
struct Looked<'a> {
    subject: &'a Subject,
    points: [usize; 2],
    light: &'a LightAsked,
    stop: &'a ShouldStop<'a>,
    seen: Vec<(DVec3, Option<White>)>,
}

impl Looked<'_> {
    fn from(&mut self, scene: &mut Scene, eye: DVec3) -> Result<Option<White>> {
        if let Some((_, known)) = self.seen.iter().find(|(place, _)| *place == eye) {
            return Ok(*known);
        }
        if (self.stop)() {
            return Ok(None);
        }
        scene.eye.position = eye;
        let world = World::freeze(scene)?;
        let optics = Mono::<f64>::optics(&world, 0, 0);
        let mut position = Position::nowhere();
        // Of one eye: nothing asks for two here.
        lines::fill(&mut position, (&world, &optics), &scene.eye, self.subject, 0.0);
        let places = Places::new(&position.points, self.points);
        let blur = blur(&scene.eye, &position);
        let found = white(scene, self.light, (&places, blur), self.points, self.stop)?;
        self.seen.push((eye, found));
        Ok(found)
    }
}

/// How an edge is looked for.
struct Steps {
    /// The first step out, m.
    first: f64,
    /// Each place lies so many times as far out as the one before.
    growth: f64,
    /// How often the stretch in which the edge lies is halved.
    halvings: u32,
}

/// Where `value` first falls below half of `own`, going out from 0 to `reach`. A value that is none is nothing. Where both ends of
/// the last stretch have a value the edge lies on the line between them, else in its middle.
fn edge(own: Level, steps: &Steps, reach: f64, mut value: impl FnMut(f64) -> Option<Level>) -> Option<Edge> {
    let half = 0.5 * own.value;
    let nothing = Level { value: 0.0, sigma: None };
    let (mut near, mut inside) = (0.0, own);
    let mut far = steps.first;
    let mut outside = loop {
        let found = value(far).unwrap_or(nothing);
        if found.value < half {
            break found;
        }
        if far >= reach {
            return None;
        }
        (near, inside) = (far, found);
        far = (far * steps.growth).min(reach);
    };
    let noise = |a: Level, b: Level| Some((a.sigma?.powi(2) + b.sigma?.powi(2)).sqrt());
    for _ in 0..steps.halvings {
        let middle = 0.5 * (near + far);
        // As near as numbers are, or as their noise lets them be told apart.
        let known = noise(inside, outside).is_some_and(|noise| inside.value - outside.value < SIGMAS * noise);
        if known || middle <= near || middle >= far {
            break;
        }
        let found = value(middle).unwrap_or(nothing);
        if found.value < half { (far, outside) = (middle, found) } else { (near, inside) = (middle, found) }
    }
    let Some(noise) = noise(inside, outside) else {
        return Some(Edge { distance_m: 0.5 * (near + far), sigma_m: None });
    };
    let slope = (inside.value - outside.value) / (far - near);
    let distance_m = near + (inside.value - half) / slope;
    let sigma_m = own.sigma.map(|own| noise.hypot(0.5 * own) / slope);
    Some(Edge { distance_m, sigma_m: sigma_m.filter(|sigma| sigma.is_finite()) })
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEPS: Steps = Steps { first: 0.1, growth: 1.5, halvings: 50 };

    fn exact(value: f64) -> Level {
        Level { value, sigma: None }
    }

    #[test]
    fn a_step_is_found_to_rounding() {
        for at in [0.013_f64, 0.1, 0.7, 5.9] {
            let found = edge(exact(9.0), &STEPS, 6.0, |x| Some(exact(if x < at { 9.0 } else { 4.0 }))).unwrap();
            assert!((found.distance_m / at - 1.0).abs() < 1e-13, "{at}: {found:?}");
            assert_eq!(found.sigma_m, None);
        }
        // A half is not less than a half; nothing below it as far as was looked.
        assert_eq!(edge(exact(8.0), &STEPS, 6.0, |_| Some(exact(4.0))), None);
        // What is not there is nothing.
        let found = edge(exact(8.0), &STEPS, 6.0, |x| (x < 0.4).then_some(exact(8.0))).unwrap();
        assert!((found.distance_m - 0.4).abs() < 1e-12);
    }

    /// A slope with noise: the line between the last places, and its error.
    #[test]
    fn a_slope_is_known_to_its_noise() {
        let sigma = 0.01;
        let slope = |x: f64| Some(Level { value: (10.0 - 2.0 * x).max(0.0), sigma: Some(sigma) });
        let own = Level { value: 10.0, sigma: Some(0.0) };
        let found = edge(own, &STEPS, 6.0, slope).unwrap();
        assert!((found.distance_m - 2.5).abs() < 1e-12, "{found:?}");
        // √2 of one over a slope of 2.
        assert!((found.sigma_m.unwrap() - sigma * 2f64.sqrt() / 2.0).abs() < 1e-12, "{found:?}");
    }
}
