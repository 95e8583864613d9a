//! Which face is the picture that an eye sees as a virtual image, over which train of specular faces, and a grid of points
//! on it.

use super::ghosts;
use super::look::{Effort, Found, Landed, Way, look_around};
use super::tuning::subject::{FLAT, INSET, LEAST, LOOKS, MOST_BRANCHES};
use eyebox_base::error::Result;
use eyebox_base::{Error, Where};
use eyebox_film::specular_chain::SpecularChain;
use eyebox_scene::Scene;
use eyebox_world::World;
use eyebox_world::mode::Mono;
use eyebox_world::optics::Optics;
use glam::{DAffine3, DVec2, DVec3};

/// What kind of face is looked at. A slide goes before a lamp or a screen that is seen through specular faces, and that
/// before what is seen without any.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    Slide,
    /// A lamp or a scatterer, behind specular faces.
    Image,
    /// One that is seen directly.
    Object,
}

/// A point of the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Column and row from the upper left of the picture as it is authored (slides), or as the face lies.
    pub cell: [usize; 2],
    /// Place in the picture from its middle, m: to the right and up.
    pub picture: DVec2,
    /// World, m.
    pub place: DVec3,
    /// A direction in which the middle of the eye sees something near it, world.
    pub near: DVec3,
}

/// What is looked at, and how.
#[derive(Debug, Clone)]
pub struct Subject {
    pub kind: Kind,
    pub part: u32,
    pub face: u32,
    /// From the eye to the face.
    pub train: SpecularChain,
    /// Unit, world.
    pub normal: DVec3,
    /// Width and height of what is scanned, m.
    pub size: [f64; 2],
    pub points: Vec<Point>,
    /// The eye's middle from which it was found, world, m.
    pub from: DVec3,
    /// Other trains that show the same image, those with most light first: of light guides with gratings.
    pub ways: Vec<Subject>,
}

const EFFORT: Effort = Effort { least: LEAST, most_branches: MOST_BRANCHES };

impl Subject {
    /// Finds the picture that the eye of `world` sees, and `cells` (columns, rows; at least 2 each) points on it. Of several
    /// trains the one that carries most light counts. `target`: path of the part to look at.
    /// Errors: no such part, nothing to look at, a face that is not flat.
    pub fn find(
        scene: &Scene,
        tracing: (&World, &Optics<Mono>),
        target: Option<&str>,
        cells: [usize; 2],
    ) -> Result<Subject> {
        let world = tracing.0;
        let wanted = target.map(|path| part_of(scene, path)).transpose()?;
        // Twice: over all of the field of view, and over the part of it that the picture fills.
        let (half, cell) = (world.eye.half(), world.eye.half() * (2.0 / LOOKS as f64));
        let mut best = brightest(look_around(tracing, [-half, half], (wanted, EFFORT)));
        if let Some((_, hits)) = &best {
            let low = hits.iter().map(|hit| hit.film).fold(half, DVec2::min) - cell;
            let high = hits.iter().map(|hit| hit.film).fold(-half, DVec2::max) + cell;
            best = brightest(look_around(tracing, [low.max(-half), high.min(half)], (wanted, EFFORT))).or(best);
        }
        let Some(((kind, part, face, _), hits)) = best else {
            let at = target.map_or(Where::Nowhere, Where::part);
            return Err(Error::new(at, "is not seen from the middle of the eyebox: there is nothing to scan").expected(
                "a slide, a lamp or a scatterer in the eye's field of view, with or without specular faces before it",
            ));
        };
        let path = scene.parts.get(part as usize).map_or("", |part| part.path.as_str());
        let face_fault =
            |what: &str| Error::new(Where::Part { path: path.to_owned(), face: Some(face as usize) }, what);
        let Some(first) = hits.first() else { return Err(face_fault("is not seen")) };
        let normal = first.normal;
        let (corner, sides) = match slide_of(scene, world, part, face) {
            Some(placed) => placed,
            None => bounds(&hits, normal, world.eye.look().cross(normal)),
        };
        let size = sides.map(DVec3::length);
        let extent = size[0].max(size[1]);
        if !(size[0] > 0.0 && size[1] > 0.0 && extent.is_finite()) {
            return Err(face_fault("is seen edge-on or in one point only").expected("a face with an area"));
        }
        if hits.iter().any(|hit| (hit.place - first.place).dot(normal).abs() > FLAT * extent) {
            return Err(face_fault("is not flat; scan reads virtual images of flat pictures").expected("a flat face"));
        }
        let mut points = Vec::with_capacity(cells[0].saturating_mul(cells[1]).min(1 << 16));
        for row in 0..cells[1] {
            for column in 0..cells[0] {
                let (u, v) = (share(column, cells[0]), share(row, cells[1]));
                let place = corner + sides[0] * u + sides[1] * v;
                let place = place - normal * (place - first.place).dot(normal);
                let near = hits.iter().min_by(|a, b| a.place.distance(place).total_cmp(&b.place.distance(place)));
                let picture = DVec2::new((u - 0.5) * size[0], (0.5 - v) * size[1]);
                let near = near.map_or(first.dir, |hit| hit.dir);
                points.push(Point { cell: [column, row], picture, place, near });
            }
        }
        let middle = corner + 0.5 * (sides[0] + sides[1]);
        let nearest = hits.iter().min_by(|a, b| a.place.distance(middle).total_cmp(&b.place.distance(middle)));
        let train = nearest.map_or_else(|| first.train.clone(), |hit| hit.train.clone());
        let from = world.eye.position() + world.geometry.origin();
        Ok(Subject { kind, part, face, train, normal, size, points, from, ways: Vec::new() })
    }
}

impl Subject {
    /// The same picture after its part has moved (world, m). What is near it is seen about where it was.
    #[must_use]
    pub fn moved(&self, motion: &DAffine3) -> Subject {
        let place = |point: &Point| Point { place: motion.transform_point3(point.place), ..*point };
        let normal = motion.transform_vector3(self.normal).normalize_or(self.normal);
        let ways = self.ways.iter().map(|way| way.moved(motion)).collect();
        Subject { normal, points: self.points.iter().map(place).collect(), ways, ..self.clone() }
    }

    /// The point of this column and row.
    pub fn point(&self, cell: [usize; 2]) -> Option<&Point> {
        self.points.iter().find(|point| point.cell == cell)
    }

    /// The same with the other ways over which the eye of this world sees the image.
    #[must_use]
    pub fn stitched(&self, tracing: (&World, &Optics<Mono>)) -> Subject {
        Subject { ways: ghosts::ways(tracing, self, LEAST), ..self.clone() }
    }

    /// The same as polarised light shows it: over the brightest of the trains that carry as much as this one had to.
    #[must_use]
    pub fn polarised(self, tracing: (&World, &Optics<Mono>)) -> Subject {
        ghosts::main_image(tracing, self, LEAST)
    }

    /// The point nearest to the picture's middle.
    pub fn middle(&self) -> Option<&Point> {
        self.points.iter().min_by(|a, b| a.picture.length().total_cmp(&b.picture.length()))
    }
}

/// Where the point with this number of `count` along a side is, 0–1.
fn share(index: usize, count: usize) -> f64 {
    INSET + (1.0 - 2.0 * INSET) * index as f64 / (count.max(2) - 1) as f64
}

/// The number, with a fraction, that a point at this share of a side would have: what `share` undoes.
pub fn on_grid(share: f64, count: usize) -> f64 {
    (share - INSET) / (1.0 - 2.0 * INSET) * (count.max(2) - 1) as f64
}

/// The best kind, and of it what carries most light.
fn brightest(found: Found) -> Option<(Way, Vec<Landed>)> {
    let light = |hits: &[Landed]| hits.iter().map(|hit| hit.carried).sum::<f64>();
    found.into_iter().min_by(|((a, ..), p), ((b, ..), q)| a.cmp(b).then(light(q).total_cmp(&light(p))))
}

fn part_of(scene: &Scene, path: &str) -> Result<u32> {
    let names = || scene.parts.iter().map(|part| part.path.as_str());
    let found = scene.parts.iter().position(|part| part.path == path || part.name == path);
    found.and_then(|index| u32::try_from(index).ok()).ok_or_else(|| {
        Error::new(Where::Option(format!("--target {path}")), "no such part")
            .expected("the path or the name of a part")
            .nearest(path, names().chain(scene.parts.iter().map(|part| part.name.as_str())))
    })
}

/// The upper left corner of a slide's picture and its sides to the right and down, world.
fn slide_of(scene: &Scene, world: &World, part: u32, face: u32) -> Option<(DVec3, [DVec3; 2])> {
    let slide = scene.parts.get(part as usize)?.faces.get(face as usize)?.slide?;
    let slide = scene.slides.get(slide.index())?;
    let to_world = world.geometry.part_to_world(part);
    let sides = [slide.u * slide.size[0], -slide.v * slide.size[1]];
    let corner = to_world.transform_point3(slide.centre - 0.5 * (sides[0] + sides[1])) + world.geometry.origin();
    Some((corner, sides.map(|side| to_world.transform_vector3(side))))
}

/// The box about what was met of a flat face, with sides along `across` and square to it.
fn bounds(hits: &[Landed], normal: DVec3, across: DVec3) -> (DVec3, [DVec3; 2]) {
    let a = across.try_normalize().unwrap_or_else(|| normal.any_orthonormal_vector());
    let b = a.cross(normal);
    let origin = hits.first().map_or(DVec3::ZERO, |hit| hit.place);
    let (mut low, mut high) = (DVec2::ZERO, DVec2::ZERO);
    for hit in hits {
        let at = DVec2::new((hit.place - origin).dot(a), (hit.place - origin).dot(b));
        (low, high) = (low.min(at), high.max(at));
    }
    (origin + a * low.x + b * low.y, [a * (high.x - low.x), b * (high.y - low.y)])
}
