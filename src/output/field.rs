//! Where a frame's pixels look: the eye's grid of tangents, from the header (`eyebox.eye`).

use eyebox_film::crop::Window;
use eyebox_film::frame::Frame;
use glam::DVec3;

/// The viewing directions of a picture. x counts to the right and y down, in pixels; the centre of the first is (½, ½).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Field {
    /// Half width and half height in tangents.
    half: [f64; 2],
    size: [f64; 2],
    /// Of the frame's top left pixel in the picture that it is a part of, and the frame's own size.
    corner: [f64; 2],
    own: [f64; 2],
    /// Years.
    pub age: f64,
}

/// What of the eye in the header is needed here.
#[derive(serde::Deserialize)]
struct EyeRecord {
    fov_deg: f64,
    #[serde(default = "middle_age")]
    age: f64,
}

fn middle_age() -> f64 {
    45.0
}

impl Field {
    /// None if the header does not say how wide the eye looks.
    pub fn of(frame: &Frame) -> Option<Field> {
        let eye: EyeRecord = serde_json::from_str(frame.text("eye")?).ok()?;
        let valid = eye.fov_deg > 0.0 && eye.fov_deg < 180.0 && frame.width > 0 && frame.height > 0;
        let half = (eye.fov_deg.to_radians() / 2.0).tan();
        let own = [frame.width as f64, frame.height as f64];
        let (corner, size) = match frame.window {
            Some(Window { corner, picture }) => (corner.map(f64::from), picture.map(|n| n as f64)),
            None => ([0.0; 2], own),
        };
        let valid = valid && size.iter().all(|n| *n > 0.0);
        valid.then_some(Field { half: [half, half * size[1] / size[0]], size, corner, own, age: eye.age })
    }

    /// Unit direction of a place: x to the right, y up, z along the line of sight.
    pub fn direction(&self, place: [f64; 2]) -> DVec3 {
        let [right, up] = self.tangents(place);
        DVec3::new(right, up, 1.0).normalize()
    }

    fn tangents(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let right = self.half[0] * (2.0 * (x + self.corner[0]) / self.size[0] - 1.0);
        let up = self.half[1] * (1.0 - 2.0 * (y + self.corner[1]) / self.size[1]);
        [right, up]
    }

    /// Degrees between two places.
    pub fn angle_deg(&self, from: [f64; 2], to: [f64; 2]) -> f64 {
        let (a, b) = (self.direction(from), self.direction(to));
        a.cross(b).length().atan2(a.dot(b)).to_degrees()
    }

    /// Full width and height, degrees.
    pub fn extent_deg(&self) -> [f64; 2] {
        let ([left, top], [right, bottom]) = (self.tangents([0.0; 2]), self.tangents(self.own));
        [right.atan() - left.atan(), top.atan() - bottom.atan()].map(f64::to_degrees)
    }

    /// Degrees to the right and up of the line of sight.
    pub fn place_deg(&self, place: [f64; 2]) -> [f64; 2] {
        let direction = self.direction(place);
        [direction.x, direction.y].map(|part| part.atan2(direction.z).to_degrees())
    }

    /// Width and height of a pixel in tangents.
    pub fn pixel_tangent(&self) -> [f64; 2] {
        [0, 1].map(|axis| 2.0 * self.half[axis] / self.size[axis])
    }

    /// Width of a pixel in the middle of the picture, degrees.
    pub fn pixel_deg(&self) -> f64 {
        (2.0 * self.half[0] / self.size[0]).atan().to_degrees()
    }

    /// Solid angle of the pixel whose centre is at a place, sr.
    pub fn solid_angle(&self, place: [f64; 2]) -> f64 {
        let cell = 4.0 * self.half[0] / self.size[0] * self.half[1] / self.size[1];
        cell * self.direction(place).z.powi(3)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyebox_film::frame::Meta;

    pub fn looking(width: usize, height: usize, fov_deg: f64) -> Frame {
        let mut frame = Frame::new(width, height);
        frame.meta.insert("eye".into(), Meta::Text(format!("{{\"fov_deg\":{fov_deg},\"age\":30.0}}")));
        frame
    }

    #[test]
    fn the_grid_of_tangents() {
        let field = Field::of(&looking(200, 100, 90.0)).unwrap();
        // tan 45° = 1 to the right edge, ½ to the upper one.
        assert!((field.angle_deg([100.0, 50.0], [200.0, 50.0]) - 45.0).abs() < 1e-12);
        assert!((field.extent_deg()[1] - 2.0 * 0.5f64.atan().to_degrees()).abs() < 1e-12);
        assert!((field.place_deg([100.0, 0.0])[1] - 0.5f64.atan().to_degrees()).abs() < 1e-12);
        // The solid angle of a rectangle 2a × 2b at distance 1: 4·asin(ab/√((1 + a²)(1 + b²))).
        let sum: f64 =
            (0..200 * 100).map(|i| field.solid_angle([(i % 200) as f64 + 0.5, (i / 200) as f64 + 0.5])).sum();
        let want = 4.0 * (0.5 / (2.0f64 * 1.25).sqrt()).asin();
        assert!((sum / want - 1.0).abs() < 1e-4, "{sum} {want}");
        assert!(Field::of(&Frame::new(4, 4)).is_none());
        assert!(Field::of(&looking(4, 4, 180.0)).is_none());
    }
}
