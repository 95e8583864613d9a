use super::rectangle::Rectangle;
use glam::DVec3;
use std::f64::consts::PI;

fn turned(points: &[[f64; 2]], angle: f64) -> Vec<DVec3> {
    let (sin, cos) = angle.sin_cos();
    points.iter().map(|[x, y]| DVec3::new(cos * x - sin * y, sin * x + cos * y, 3.0)).collect()
}

/// A rectangle is found however it lies, its longer side to the right, towards x; u × v is the normal.
#[test]
fn the_smallest_rectangle() {
    let corners = [[-3.0, -1.0], [3.0, -1.0], [3.0, 1.0], [-3.0, 1.0], [0.2, 0.3]];
    for angle in [0.0, 0.3, 1.2, 1.5, 2.0, 3.0, -0.7] {
        for normal in [DVec3::Z, -DVec3::Z] {
            let found = Rectangle::about(turned(&corners, angle), normal, None, DVec3::X).unwrap();
            assert!((found.half[0] - 3.0).abs() < 1e-12 && (found.half[1] - 1.0).abs() < 1e-12, "{found:?}");
            assert!(found.u.x > -1e-9 && (found.u.x - angle.cos().abs()).abs() < 1e-9, "{angle} {found:?}");
            assert!((found.u.cross(found.v) - normal).length() < 1e-12);
            assert!((found.centre - DVec3::new(0.0, 0.0, 3.0)).length() < 1e-12);
        }
    }
    // What is asked for holds, laid across the normal.
    let asked = Rectangle::about(turned(&corners, 0.0), DVec3::Z, Some(DVec3::new(0.0, 2.0, 5.0)), DVec3::X).unwrap();
    assert!((asked.u - DVec3::Y).length() < 1e-12 && (asked.half[0] - 1.0).abs() < 1e-12);
    assert!(Rectangle::about(turned(&corners, 0.0), DVec3::Z, Some(DVec3::Z), DVec3::X).is_none());
}

/// Pixels share out the area of any triangle without loss, a tilted one's own area; an L in a square leaves a corner empty.
#[test]
fn areas_by_pixel() {
    let square = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]];
    let map = Rectangle::about(turned(&square, 0.0), DVec3::Z, None, DVec3::X).unwrap();
    let l = [
        [[0.0, 0.0], [4.0, 0.0], [4.0, 2.0]],
        [[0.0, 0.0], [4.0, 2.0], [0.0, 2.0]],
        [[0.0, 2.0], [2.0, 2.0], [2.0, 4.0]],
        [[0.0, 2.0], [2.0, 4.0], [0.0, 4.0]],
    ];
    let mut areas = vec![0.0; 16];
    l.iter().for_each(|t| map.share_out([0, 1, 2].map(|k| DVec3::new(t[k][0], t[k][1], 3.0)), [4, 4], &mut areas));
    for (pixel, area) in areas.iter().enumerate() {
        let empty = pixel / 4 < 2 && pixel % 4 >= 2;
        assert!((area - if empty { 0.0 } else { 1.0 }).abs() < 1e-12, "{pixel}: {area}");
    }
    // Tilted by an angle, a face has 1/cos of its shadow; upright, it is still all there.
    for angle in [0.3, 1.0, PI / 2.0] {
        let (sin, cos) = f64::sin_cos(angle);
        let corners = [[0.1, 0.2], [3.7, 0.4], [1.3, 3.9]].map(|[x, y]| DVec3::new(cos * x, y, sin * x));
        let whole = 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]).length();
        let mut areas = vec![0.0; 35];
        map.share_out(corners, [7, 5], &mut areas);
        assert!((areas.iter().sum::<f64>() - whole).abs() < 1e-12 * whole, "{angle}");
    }
}
