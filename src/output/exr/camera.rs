//! Where the picture was taken from, as compositing programs read it: `worldToCamera` and `worldToNDC` of OpenEXR, from the eye
//! that the header tells of.
//!
//! After `ImfStandardAttributes.h` of OpenEXR 3: points are rows, p′ = p M. Camera space is left-handed as RenderMan's: x to the right, y up,
//! z along the line of sight, what is seen has z > 0. NDC has (0, 0) at the upper left and (1, 1) at the lower right corner of the
//! display window.

use eyebox_film::crop::Window;
use eyebox_film::frame::Frame;
use glam::{DMat4, DVec3, DVec4};

/// Both matrices, row by row, in metres of the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Matrices {
    pub world_to_camera: [f32; 16],
    pub world_to_ndc: [f32; 16],
}

/// What of the eye in the header is needed here.
#[derive(serde::Deserialize)]
struct EyeRecord {
    position: [f64; 3],
    look: [f64; 3],
    up: [f64; 3],
    fov_deg: f64,
}

/// None where the header does not tell of an eye.
pub fn matrices(frame: &Frame) -> Option<Matrices> {
    /// The plane that has the depth 0 in NDC, m: it lies before all that an eye sees. Depth goes to 1 far away.
    const NEAR: f64 = 1e-3;
    let eye: EyeRecord = serde_json::from_str(frame.text("eye")?).ok()?;
    let [position, look, up] = [eye.position, eye.look, eye.up].map(DVec3::from);
    let look = look.try_normalize()?;
    let right = look.cross(up).try_normalize()?;
    let up = right.cross(look);
    let [width, height] = match frame.window {
        Some(Window { picture, .. }) => picture,
        None => [frame.width, frame.height],
    };
    let half = (0.5 * eye.fov_deg.to_radians()).tan();
    let half = [half, half * height as f64 / width as f64];
    // Columns of glam's matrices are images of the axes, which are the rows here.
    let row = |axis: DVec3, w: f64| DVec4::new(axis.dot(right), axis.dot(up), axis.dot(look), w);
    let camera = DMat4::from_cols(row(DVec3::X, 0.0), row(DVec3::Y, 0.0), row(DVec3::Z, 0.0), row(-position, 1.0));
    let ndc = DMat4::from_cols(
        DVec4::new(0.5 / half[0], 0.0, 0.0, 0.0),
        DVec4::new(0.0, -0.5 / half[1], 0.0, 0.0),
        DVec4::new(0.5, 0.5, 1.0, 1.0),
        DVec4::new(0.0, 0.0, -NEAR, 0.0),
    );
    let both = [camera, ndc * camera].map(|matrix| matrix.to_cols_array().map(|x| x as f32));
    let [world_to_camera, world_to_ndc] = both;
    both.iter().flatten().all(|x| x.is_finite()).then_some(Matrices { world_to_camera, world_to_ndc })
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyebox_film::frame::Meta;

    /// A row times a matrix, divided by its last component.
    fn times(point: [f64; 3], matrix: &[f32; 16]) -> [f64; 3] {
        let row = [point[0], point[1], point[2], 1.0];
        let out: [f64; 4] = std::array::from_fn(|j| (0..4).map(|i| row[i] * f64::from(matrix[4 * i + j])).sum::<f64>());
        [out[0] / out[3], out[1] / out[3], out[2] / out[3]]
    }

    fn is_near(found: [f64; 3], right: [f64; 3]) -> bool {
        found.iter().zip(right).all(|(a, b)| (a - b).abs() < 1e-5)
    }

    /// The definition of the attributes: axes of the camera, and corners of the display window, of a part of the picture, too.
    #[test]
    fn points_land_where_the_definition_says() {
        // At (1, 2, 3), looks along −x with +z up: to the right is +y.
        let eye = r#"{"position":[1,2,3],"look":[-1,0,0],"up":[0,0,1],"fov_deg":90}"#;
        let mut frame = Frame::new(200, 100);
        assert_eq!(matrices(&frame), None);
        frame.meta.insert("eye".into(), Meta::Text(eye.into()));
        for window in [None, Some(Window { corner: [50, 20], picture: [200, 100] })] {
            frame.window = window;
            let Matrices { world_to_camera, world_to_ndc } = matrices(&frame).expect("an eye");
            assert!(is_near(times([1.0, 2.0, 3.0], &world_to_camera), [0.0; 3]));
            // 5 m ahead, 1 m to the right, 2 m up.
            assert!(is_near(times([-4.0, 3.0, 5.0], &world_to_camera), [1.0, 2.0, 5.0]));
            // At 90° across, the tangents are 1 and, of a picture half as high, 1/2.
            let at = |right: f64, up: f64| times([1.0 - 5.0, 2.0 + 5.0 * right, 3.0 + 5.0 * up], &world_to_ndc);
            for (right, up, [x, y]) in
                [(0.0, 0.0, [0.5, 0.5]), (-1.0, 0.5, [0.0, 0.0]), (1.0, -0.5, [1.0, 1.0]), (0.5, 0.25, [0.75, 0.25])]
            {
                let [found_x, found_y, depth] = at(right, up);
                assert!(is_near([found_x, found_y, 0.0], [x, y, 0.0]), "{right} {up}: {found_x} {found_y}");
                assert!((0.0..1.0).contains(&depth));
            }
        }
    }
}
