//! Which face is the picture that an eye sees as a virtual image, over which train of specular faces, and a grid of points
//! on it.

use super::extent::seen_of;
use super::ghosts;
use super::look::{Found, Landed, Look, look_around};
use super::same_image::image;
use super::tuning::subject::{DEEPER, FLAT, INSET, LEFT_OUT, LOOKS, MISSED, MOST_WAYS};
use super::ways::Effort;
use eyebox_base::chain::{Chain, Link, Step};
use eyebox_base::error::Result;
use eyebox_base::{Error, Where};
use eyebox_film::specular_chain::SpecularChain;
use eyebox_scene::Scene;
use eyebox_world::World;
use eyebox_world::mode::Mono;
use eyebox_world::optics::Optics;
use glam::{DAffine3, DVec2, DVec3};
use std::collections::BTreeMap;

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
    /// Column and row from the upper left of the picture: of a slide as it is authored, of a lamp or a screen as the eye sees it.
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
    /// What a ray that lands on it brings from all of it, over all trains that show it, of what it started with: on average.
    pub light: f64,
    /// How far its ways are followed.
    pub(super) effort: Effort,
    /// What ways that were not followed carry of a ray, at most, over that light.
    pub left_out: f64,
}

/// More than should have been left out ([`Subject::left_out`]).
pub fn is_too_much(left_out: f64) -> bool {
    // Quotients are rounded.
    left_out > MISSED * (1.0 + 1e-9)
}

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
        let mut effort = Effort { least: 0.0, left_out: LEFT_OUT, most_ways: MOST_WAYS };
        let look = |effort, corners: [DVec2; 2]| look_around(tracing, corners, (wanted, effort));
        let Look { found, mut left_out, cell: mut apart } = look(effort, [-half, half]);
        let mut best = brightest(found);
        // A faint picture, or one of which little else may have been met: ways are followed farther.
        let is_faint = best.as_ref().is_none_or(|image| MISSED.sqrt() * image.light() < effort.left_out);
        if is_faint {
            let own = best.as_ref().map_or(DEEPER, |image| MISSED * image.light());
            effort.left_out = own.min(LEFT_OUT);
            let again = look(effort, [-half, half]);
            left_out = again.left_out;
            best = brightest(again.found).or(best);
        }
        let light = best.as_ref().map_or(1.0, Image::light);
        effort.left_out = effort.left_out.min(MISSED * light);
        if let Some(image) = &best {
            let low = image.hits().map(|hit| hit.film).fold(half, DVec2::min) - cell;
            let high = image.hits().map(|hit| hit.film).fold(-half, DVec2::max) + cell;
            let near = look(effort, [low.max(-half), high.min(half)]);
            if let Some(image) = brightest(near.found) {
                (best, left_out, apart) = (Some(image), near.left_out, near.cell);
            }
        }
        let Some(Image { face: (kind, part, face), hits, others }) = best else {
            let at = target.map_or(Where::Nowhere, Where::part);
            let wanted =
                "a slide, a lamp or a scatterer in the eye's field of view, with or without specular faces before it";
            let mut what = "is not seen from the middle of the eyebox: there is nothing to scan".to_owned();
            if left_out > effort.left_out {
                what += &format!(
                    " (up to {:.1} % of a ray's light went ways that were not followed, there are so many)",
                    100.0 * left_out
                );
            }
            return Err(Error::new(at, what).expected(wanted));
        };
        let left_out = left_out / light;
        let path = scene.parts.get(part as usize).map_or("", |part| part.path.as_str());
        let face_fault =
            |what: &str| Error::new(Where::Part { path: path.to_owned(), face: Some(face as usize) }, what);
        let Some(first) = hits.first() else { return Err(face_fault("is not seen")) };
        let normal = first.normal;
        let (corner, sides) = match slide_of(scene, world, part, face) {
            Some(placed) => placed,
            None => {
                let all: Vec<&Landed> = hits.iter().chain(&others).collect();
                seen_of((scene, world), (part, face), &all, apart).ok_or_else(|| face_fault("is not seen"))?
            }
        };
        let size = sides.map(DVec3::length);
        let extent = size[0].max(size[1]);
        if !(size[0] > 0.0 && size[1] > 0.0 && extent.is_finite()) {
            return Err(face_fault("is seen edge-on or in one point only").expected("a face with an area"));
        }
        if hits.iter().chain(&others).any(|hit| (hit.place - first.place).dot(normal).abs() > FLAT * extent) {
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
        Ok(Subject { kind, part, face, train, normal, size, points, from, ways: Vec::new(), light, effort, left_out })
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
        let ghosts::Trains { images, left_out } = ghosts::ways(tracing, self);
        Subject { ways: images, left_out, ..self.clone() }
    }

    /// The same as polarised light shows it: over the brightest of the trains that were followed as far as this one.
    #[must_use]
    pub fn polarised(self, tracing: (&World, &Optics<Mono>)) -> Subject {
        ghosts::main_image(tracing, self)
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

/// What is seen of one face as one image.
struct Image {
    /// Kind, part, face.
    face: (Kind, u32, u32),
    /// Over the train that carries most light.
    hits: Vec<Landed>,
    /// Over other trains that show the same.
    others: Vec<Landed>,
}

impl Image {
    fn hits(&self) -> impl Iterator<Item = &Landed> {
        self.hits.iter().chain(&self.others)
    }

    /// What a ray that landed brings, on average: many ways of one ray may lead to it.
    fn light(&self) -> f64 {
        let mut films: Vec<[u64; 2]> = self.hits().map(|hit| hit.film.to_array().map(f64::to_bits)).collect();
        films.sort_unstable();
        films.dedup();
        self.hits().map(|hit| hit.carried).sum::<f64>() / films.len().max(1) as f64
    }
}

/// How an image is told from others of the same face: by what trains over gratings have alike, else by the train.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
enum By {
    Orders(Vec<(u32, Step, i32)>),
    Train(Vec<Link>),
}

/// Kind, part and face that are seen, and in which of their images.
type ImageKey = ((Kind, u32, u32), By);

/// The best kind, and of it the image that carries most light.
fn brightest(found: Found) -> Option<Image> {
    let light = |hits: &[Landed]| hits.iter().map(|hit| hit.carried).sum::<f64>();
    let mut images: BTreeMap<ImageKey, Vec<Vec<Landed>>> = BTreeMap::new();
    for ((kind, part, face, Chain(links)), hits) in found {
        let by = image(&links).map_or(By::Train(links), By::Orders);
        images.entry(((kind, part, face), by)).or_default().push(hits);
    }
    let all = |trains: &[Vec<Landed>]| trains.iter().map(|hits| light(hits)).sum::<f64>();
    let best = images.into_iter().min_by(|(a, p), (b, q)| a.0.0.cmp(&b.0.0).then(all(q).total_cmp(&all(p))));
    let ((face, _), mut trains) = best?;
    // Of trains as bright the first.
    let (main, _) = trains.iter().enumerate().rev().max_by(|(_, p), (_, q)| light(p).total_cmp(&light(q)))?;
    let hits = trains.swap_remove(main);
    Some(Image { face, hits, others: trains.into_iter().flatten().collect() })
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
