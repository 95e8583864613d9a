//! How far what a pixel shows moves in the picture until the next frame: of the first face that the ray through the middle of
//! the pixel meets, and of the sky.

use super::data::go_straight;
use super::ledger::Ledger;
use eyebox_base::error::Result;
use eyebox_base::parallel;
use eyebox_scene::{Mesh, Scene};
use eyebox_world::World;
use eyebox_world::eye::EyeLens;
use eyebox_world::geometry::Hit;
use eyebox_world::mode::{Mode, Mono};
use glam::DVec3;
use std::collections::HashMap;

/// Pixels to the right and down, row-major. 0 where the next frame has no such part, or has it behind the eye.
///
/// # Errors
/// An eye of the next frame that none can be.
pub fn motion(world: &World, now: &Scene, next: &Scene) -> Result<[Vec<f32>; 2]> {
    let [width, height] = now.eye.resolution;
    let eye = EyeLens::build(&next.eye, world.geometry.origin())?;
    let parts: HashMap<&str, usize> =
        next.parts.iter().enumerate().map(|(index, part)| (part.path.as_str(), index)).collect();
    let optics = Mono::<f64>::optics(world, 0, 0);
    let of = |ledger: &mut Ledger, pixel: usize| {
        let (x, y) = (pixel % width, pixel / width);
        let (origin, dir) = world.eye.ray(x, y, [0.5; 2], [0.5; 2]);
        let mut first: Option<Hit> = None;
        go_straight((world, &optics), (origin, dir), ledger, |vertex| {
            first.get_or_insert(vertex.hit);
        });
        let towards = match first {
            Some(hit) => moved(&hit, world.geometry.origin(), (now, next), &parts).map(|point| point - eye.position()),
            // As far away as can be.
            None => Some(dir),
        };
        let [right, down] =
            towards.and_then(|towards| eye.place_of(towards)).unwrap_or([x as f64 + 0.5, y as f64 + 0.5]);
        [right - (x as f64 + 0.5), down - (y as f64 + 0.5)].map(|pixels| pixels as f32)
    };
    let ledger = || Ledger::new(world.solids.len());
    let both: Vec<[f32; 2]> = parallel::map_init(width * height, &ledger, &of);
    Ok([0, 1].map(|axis| both.iter().map(|pixel| pixel[axis]).collect()))
}

/// Where the point of a face is in the next frame, in the recentred world.
pub(super) fn moved(
    hit: &Hit,
    origin: DVec3,
    (now, next): (&Scene, &Scene),
    parts: &HashMap<&str, usize>,
) -> Option<DVec3> {
    let part = now.parts.get(hit.site.part as usize)?;
    let later = next.parts.get(*parts.get(part.path.as_str())?)?;
    let (mesh, bent) = (now.mesh(part.mesh), next.mesh(later.mesh));
    let local = part.to_world.inverse().transform_point3(hit.point + origin);
    let point = if std::ptr::eq(mesh, bent) || mesh.positions == bent.positions {
        local
    } else {
        let (from, to) = (corners(mesh, hit.site.triangle)?, corners(bent, hit.site.triangle)?);
        let weights = weights(from, local)?;
        // What an exact surface lies beside its triangle, it goes on lying beside it.
        local + (0..3).map(|i| weights[i] * (to[i] - from[i])).sum::<DVec3>()
    };
    let point = later.to_world.transform_point3(point) - origin;
    point.is_finite().then_some(point)
}

fn corners(mesh: &Mesh, triangle: u32) -> Option<[DVec3; 3]> {
    let corner = |index: u32| mesh.positions.get(index as usize).map(|at| DVec3::from_array(at.map(f64::from)));
    let [a, b, c] = *mesh.triangles.get(triangle as usize)?;
    Some([corner(a)?, corner(b)?, corner(c)?])
}

/// Barycentric weights of the point of the triangle's plane that is nearest to `point`.
fn weights([a, b, c]: [DVec3; 3], point: DVec3) -> Option<[f64; 3]> {
    let (e1, e2, to) = (b - a, c - a, point - a);
    let normal = e1.cross(e2);
    let area2 = normal.length_squared();
    let (v, w) = (to.cross(e2).dot(normal) / area2, e1.cross(to).dot(normal) / area2);
    (v.is_finite() && w.is_finite()).then_some([1.0 - v - w, v, w])
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyebox_import::{ImportOptions, ReadOptions, import};

    /// A plate 10 m before an eye that has 10 pixels per metre there, in front of an even sky.
    fn moved(eye: &str, plate: &str, points: &str) -> [Vec<f32>; 2] {
        let stage = format!(
            "#usda 1.0\n(\n metersPerUnit = 1\n upAxis = \"Y\"\n)\ndef DomeLight \"sky\" {{ float inputs:intensity = 100 }}\n\
             def Camera \"eye\" {{\n float horizontalAperture = 40\n float verticalAperture = 10\n float focalLength = 100\n\
             double3 xformOp:translate.timeSamples = {{ 3: (0, 0, 10), 4: {eye} }}\n\
             uniform token[] xformOpOrder = [\"xformOp:translate\"]\n}}\n\
             def Mesh \"plate\" {{\n uniform token subdivisionScheme = \"none\"\n int[] faceVertexCounts = [4]\n\
             int[] faceVertexIndices = [0, 1, 2, 3]\n color3f[] primvars:displayColor = [(0.5, 0.5, 0.5)]\n\
             point3f[] points.timeSamples = {{ 3: [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], 4: {points} }}\n\
             double3 xformOp:translate.timeSamples = {{ 3: (0, 0, 0), 4: {plate} }}\n\
             uniform token[] xformOpOrder = [\"xformOp:translate\"]\n}}\n"
        );
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.usda");
        std::fs::write(&file, stage).unwrap();
        let at = |frame: f64| {
            let reading = ReadOptions { frame: Some(frame), ..ReadOptions::default() };
            let mut scene = import(&file, &ImportOptions { reading, ..ImportOptions::default() }).unwrap().scene;
            scene.eye.resolution = [40, 10];
            scene
        };
        let now = at(3.0);
        motion(&World::freeze(&now).unwrap(), &now, &at(4.0)).unwrap()
    }

    const STILL: &str = "[(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]";

    /// In pixels, of the plate's left and right halves and of the sky beside it.
    fn check(found: &[Vec<f32>; 2], plate: impl Fn(f64, f64) -> [f64; 2], sky: [f64; 2]) {
        for pixel in 0..400 {
            let (x, y) = (f64::from(pixel % 40) + 0.5, f64::from(pixel / 40) + 0.5);
            let want = if (x - 20.0).abs() < 10.0 { plate(x, y) } else { sky };
            for axis in 0..2 {
                let found = f64::from(found[axis][pixel as usize]);
                assert!((found - want[axis]).abs() < 1e-4, "{x} {y}: {found} instead of {}", want[axis]);
            }
        }
    }

    #[test]
    fn a_plate_and_an_eye_that_move_are_told_apart() {
        check(&moved("(0, 0, 10)", "(0.3, 0.1, 0)", STILL), |_, _| [3.0, -1.0], [0.0; 2]);
        check(&moved("(0.2, 0, 10)", "(0, 0, 0)", STILL), |_, _| [-2.0, 0.0], [0.0; 2]);
        // Half as far away, everything is twice as far from the middle.
        check(&moved("(0, 0, 5)", "(0, 0, 0)", STILL), |x, y| [x - 20.0, y - 5.0], [0.0; 2]);
        // Behind the eye.
        check(&moved("(0, 0, -5)", "(0, 0, 0)", STILL), |_, _| [0.0; 2], [0.0; 2]);
    }

    #[test]
    fn a_face_that_is_bent_moves_with_its_triangles() {
        let wide = "[(-2, -1, 0), (2, -1, 0), (2, 1, 0), (-2, 1, 0)]";
        check(&moved("(0, 0, 10)", "(0, 0, 0)", wide), |x, _| [x - 20.0, 0.0], [0.0; 2]);
    }
}
