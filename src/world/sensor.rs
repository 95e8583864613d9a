//! Sensors: the rectangle about a face in its mean plane that a map of it covers, and how much of the face lies in each of
//! the map's pixels.

mod rectangle;

use super::cdf::Cdf;
use super::geometry::{Geometry, Site};
use super::lamp::{Triangle, world_triangles};
use eyebox_base::error::Result;
use eyebox_base::warp;
use eyebox_base::{Error, Where};
use eyebox_scene::Scene;
use glam::DVec3;
use rectangle::Rectangle;
pub use rectangle::Side;

/// Least length of the sum of a face's areas as vectors, over its area: less is a closed surface, whose mean plane is
/// chance.
const LEAST_PLANE: f64 = 1e-6;

/// A face that measures light, in the recentred world.
#[derive(Debug, Clone)]
pub struct SensorFace {
    pub part: u32,
    pub face: u32,
    /// Columns and rows of the map.
    pub pixels: [usize; 2],
    rectangle: Rectangle,
    triangles: Vec<Triangle>,
    by_area: Cdf,
    /// Of the face in each pixel, m², row by row from the upper left.
    areas_m2: Vec<f64>,
}

/// A place on a sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorPoint {
    /// Recentred world, m.
    pub position: DVec3,
    /// Unit, outward.
    pub normal: DVec3,
    pub site: Site,
}

impl SensorFace {
    /// The sensor of a face; none if it has none. Errors: a face without area or without a mean plane, a `u` along its
    /// normal, each with the part and the face.
    pub fn build(scene: &Scene, geometry: &Geometry, [part, face]: [usize; 2]) -> Result<Option<SensorFace>> {
        let owner = scene.parts.get(part);
        let Some((owner, sensor)) = owner.and_then(|owner| Some((owner, owner.faces.get(face)?.sensor?))) else {
            return Ok(None);
        };
        let fault = |what: &str, expected: &str| {
            let at = Where::Part { path: owner.path.clone(), face: Some(face) };
            Err(Error::new(at, what).expected(expected))
        };
        let index = |number: usize| u32::try_from(number).unwrap_or(u32::MAX);
        let to_world = geometry.part_to_world(index(part));
        let triangles = world_triangles(scene, owner, face, to_world).unwrap_or_default();
        let area = |t: &Triangle| 0.5 * t.edges[0].cross(t.edges[1]).length();
        let Some(by_area) = Cdf::new(triangles.iter().map(area)) else {
            return fault("the sensor's face has no area", "a face with triangles");
        };
        let whole: DVec3 = triangles.iter().map(|t| t.normal * area(t)).sum();
        let Some(normal) = whole.try_normalize().filter(|_| whole.length() > LEAST_PLANE * by_area.total()) else {
            return fault("the sensor's face is closed and has no mean plane", "an open face; of a solid, one side");
        };
        let x = to_world.transform_vector3(DVec3::X);
        let asked = sensor.u.map(|u| to_world.transform_vector3(u));
        let corners = triangles.iter().flat_map(|t| [t.origin, t.origin + t.edges[0], t.origin + t.edges[1]]);
        let Some(rectangle) = Rectangle::about(corners.collect(), normal, asked, x) else {
            return fault("`u` of the sensor is along the face's normal", "a direction across it");
        };
        let pixels = sensor.pixels.map(|n| n as usize);
        if pixels.contains(&0) {
            return fault("the sensor has no pixels", "1 or more columns and rows");
        }
        let mut areas_m2 = vec![0.0; pixels[0] * pixels[1]];
        for triangle in &triangles {
            let Triangle { origin, edges: [a, b], .. } = *triangle;
            rectangle.share_out([origin, origin + a, origin + b], pixels, &mut areas_m2);
        }
        let (part, face) = (index(part), index(face));
        Ok(Some(SensorFace { part, face, pixels, rectangle, triangles, by_area, areas_m2 }))
    }

    /// Of the whole face, m².
    pub fn area_m2(&self) -> f64 {
        self.by_area.total()
    }

    /// Of the face in each pixel, m², row by row from the upper left; 0 where the face is not.
    pub fn areas_m2(&self) -> &[f64] {
        &self.areas_m2
    }

    /// Of a pixel of the rectangle, m².
    pub fn pixel_area_m2(&self) -> f64 {
        let [width, height] = self.size_m();
        width * height / (self.pixels[0] * self.pixels[1]) as f64
    }

    /// Width and height of the rectangle, m.
    pub fn size_m(&self) -> [f64; 2] {
        self.rectangle.half.map(|half| 2.0 * half)
    }

    /// Middle of the rectangle, recentred world, m.
    pub fn centre(&self) -> DVec3 {
        self.rectangle.centre
    }

    /// Unit directions to the right and up in the map, and the face's mean normal, which points from its front.
    pub fn axes(&self) -> [DVec3; 3] {
        [self.rectangle.u, self.rectangle.v, self.rectangle.normal]
    }

    /// The pixel in which a point of the face lies, row by row from the upper left; of one beyond the rectangle, which an
    /// exact surface may have, the nearest.
    pub fn pixel_of(&self, point: DVec3) -> usize {
        let [x, y] = self.rectangle.place(point, self.pixels);
        let cell = |at: f64, count: usize| (at.max(0.0) as usize).min(count - 1);
        cell(y, self.pixels[1]) * self.pixels[0] + cell(x, self.pixels[0])
    }

    /// A point uniform over the face's area.
    pub fn sample(&self, [a, b]: [f64; 2]) -> SensorPoint {
        let (index, a) = self.by_area.sample(a);
        let Triangle { origin, edges, normal, index } = self.triangles[index];
        let [u, v, _] = warp::triangle([a, b]);
        let site = Site { part: self.part, face: self.face, triangle: index };
        SensorPoint { position: origin + edges[0] * u + edges[1] * v, normal, site }
    }
}

#[cfg(test)]
mod tests;
