//! `eyebox scan` through a light guide with three gratings: one lets light in, one folds it, one lets it out, and each pupil that the eye
//! may stand in has only some thousandths of the light.

use crate::common::{add_group, add_part, face, lamp, mesh, quad, scene};
use eyebox::base::ids::GratingId;
use eyebox::plan::scan::table::lines;
use eyebox::plan::scan::{Scan, ScanAsked, scan};
use eyebox::scene::{Finish, Grating, Order, Scene, Shape};
use eyebox_bench::kit;
use glam::{DAffine3, DVec2, DVec3};

/// mm
const FOCAL_LENGTH: f64 = 30.0;
const DISPLAY: [f64; 2] = [5.0, 3.0];
const FRONT: f64 = -18.0;
const LINES_PER_MM: f64 = 2500.0;

/// Its axis.
const LENS: DVec2 = DVec2::new(-13.0, 14.0);

/// Height of a hyperboloid of conic constant −1.5² with this focal length.
fn sag(r: f64) -> f64 {
    let c = 1.0 / (0.5 * FOCAL_LENGTH);
    c * r * r / (1.0 + (1.0 + 1.25 * c * c * r * r).sqrt())
}

/// Shares of light that gratings in, at the fold and out take at a meeting.
struct Shares {
    inside: f64,
    fold: f64,
    outside: f64,
}

/// Rectangles of a plane: from x to x, from y to y.
type Window = [[f64; 2]; 2];

/// A face of a slab in strips about `windows`, which come first, in mm at this depth; towards the eye or away from it.
fn face_of_slab(windows: &[Window], [wide, high]: Window, z: f64, towards: bool) -> Vec<Vec<DVec3>> {
    let mut all = windows.to_vec();
    let mut from = high[0];
    for [x, y] in windows {
        all.extend([[wide, [from, y[0]]], [[wide[0], x[0]], *y], [[x[1], wide[1]], *y]]);
        from = y[1];
    }
    all.push([wide, [from, high[1]]]);
    let rectangle = |[x, y]: Window| {
        let middle = DVec3::new(0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1]), z);
        let (a, b) = (DVec3::X * (0.5 * (x[1] - x[0])), DVec3::Y * (0.5 * (y[1] - y[0])));
        if towards { quad(middle, a, b) } else { quad(middle, b, a) }
    };
    all.into_iter().map(rectangle).collect()
}

/// An eye 18 mm before a slab of index 1.7, `thickness` mm thick. Behind it, left and above, a display in the focus of a lens without
/// spherical aberration (a hyperboloid with its flat side towards the slab). The first grating sends its light to the right, the second
/// one down, the third one out: their vectors add up to nothing, so that all of it goes on as it came.
fn folded(thickness: f64, shares: &Shares) -> Scene {
    let mut scene = scene();
    let millimetres = DAffine3::from_scale(DVec3::splat(1e-3));
    let outline = [[-18.0, 10.0], [-9.0, 21.0]];
    let (out, fold, inside) = ([[-5.0, 5.0], [-5.0, 5.0]], [[-6.0, 6.0], [9.0, 19.0]], [[-16.0, -10.0], [11.0, 17.0]]);
    let back = FRONT - thickness;
    let mut polygons = face_of_slab(&[out, fold], outline, FRONT, true);
    let in_number = polygons.len();
    polygons.extend(face_of_slab(&[inside], outline, back, false));
    let walls = polygons.len();
    let [[left, right], [low, high]] = outline;
    let (x, y, z) = (0.5 * (left + right), 0.5 * (low + high), 0.5 * (FRONT + back));
    let (along, up, deep) = (DVec3::X * (0.5 * (right - left)), DVec3::Y * (0.5 * (high - low)), DVec3::Z * (0.5 * thickness));
    polygons.push(quad(DVec3::new(left, y, z), deep, up));
    polygons.push(quad(DVec3::new(right, y, z), up, deep));
    polygons.push(quad(DVec3::new(x, low, z), along, deep));
    polygons.push(quad(DVec3::new(x, high, z), deep, along));
    let order = |order: i32, transmittance: f64, reflectance: f64| Order { order, transmittance, reflectance };
    for (direction, lines, orders) in [
        (DVec3::Y, 1.0, vec![order(1, shares.outside, 0.0), order(-1, shares.outside, 0.0)]),
        (
            DVec3::new(1.0, 1.0, 0.0),
            2f64.sqrt(),
            vec![order(1, 0.0, shares.fold), order(-1, 0.0, shares.fold)],
        ),
        (DVec3::X, 1.0, vec![order(1, shares.inside, 0.0), order(-1, shares.inside, 0.0)]),
    ] {
        let lines_per_mm = LINES_PER_MM * lines;
        let orders = orders.into();
        scene.gratings.push(Grating { direction, lines_per_mm, orders, rest_in_zero_order: true });
    }
    let grating = |index: usize| face(Finish::Grating { grating: GratingId::from_index(index) });
    let faces = (0..polygons.len()).map(|number| match number {
        0 => grating(0),
        1 => grating(1),
        number if number == in_number => grating(2),
        number if number < walls => face(Finish::Polished),
        _ => face(Finish::Absorber),
    });
    let faces = faces.collect();
    kit::add(&mut scene, kit::mesh(&polygons), millimetres, Some(1.7), faces);
    // The lens about (−13, 14), 3 mm thick, convex towards the display.
    let (flat, vertex) = (back - 2.0, back - 5.0);
    let axis = LENS.extend(0.0);
    let moved = |(corners, triangles): kit::Sheet| (corners.into_iter().map(|p| p + axis).collect(), triangles);
    let low = kit::cap(vertex, sag, 5.0, false, [24, 48]);
    let high = kit::cap(flat, |_| 0.0, 5.0, true, [24, 48]);
    let wall = kit::wall(&low.0, &high.0, 48);
    let shapes = [
        Shape::Conic { vertex: axis + DVec3::Z * vertex, axis: DVec3::Z, radius: 0.5 * FOCAL_LENGTH, conic: -2.25 },
        Shape::Plane { vertex: axis + DVec3::Z * flat, axis: DVec3::Z },
    ];
    let faces = shapes.map(kit::polished).into_iter().chain([kit::face(Finish::Absorber)]).collect();
    kit::add(&mut scene, kit::mesh_of([low, high, wall].map(moved)), millimetres, Some(1.5), faces);
    let group = add_group(&mut scene, "oled");
    let mut shining = face(Finish::Absorber);
    shining.emitter = lamp(group, 20000.0);
    let [a, b] = [DVec3::X * (0.5 * DISPLAY[0]), DVec3::Y * (0.5 * DISPLAY[1])];
    let panel = mesh(&[quad(DVec3::ZERO, 1e-3 * a, 1e-3 * b)]);
    let at = 1e-3 * (axis + DVec3::Z * (vertex - FOCAL_LENGTH));
    add_part(&mut scene, "display", panel, at, None, vec![shining]);
    scene.eye.pupil_diameter_m = 2e-3;
    scene.eye.fov_deg = 12.0;
    scene.eye.resolution = [48, 32];
    scene
}

fn scanned(scene: &Scene, positions: [usize; 2], size_mm: f64) -> Scan {
    let asked = ScanAsked {
        positions,
        size_m: [Some(1e-3 * size_mm); 2],
        ipd_m: 0.063,
        points: [5, 3],
        target: None,
        light: None,
        edges: false,
    };
    let found = scan(scene, &asked, &|| false, |_| {}).expect("the guide can be scanned").expect("nobody stopped it");
    println!("{}", lines(&found).join("\n"));
    found
}

/// Where on the display, mm from its middle, a ray from the eye comes to that crosses the slab so often on its way up and then to the left,
/// by the grating equation (Born and Wolf, 8.6.1), Snell's law and the hyperboloid. None if it misses the grating at the end.
fn on_the_display(eye: DVec2, dir: DVec3, thickness: f64, [up, left]: [i32; 2]) -> Option<DVec2> {
    let to = |from: DVec3, dir: DVec3, z: f64| from + dir * ((z - from.z) / dir.z);
    let bend = 550e-6 * LINES_PER_MM;
    let step = |guided: DVec2| guided * (thickness / (1.7f64 * 1.7 - guided.length_squared()).sqrt());
    let tangential = dir.truncate();
    let moved = f64::from(up) * step(tangential + DVec2::Y * bend) + f64::from(left) * step(tangential - DVec2::X * bend);
    // From the middle of the grating at the end, which is on the lens's axis.
    let at = to(eye.extend(0.0), dir, FRONT).truncate() + moved - LENS;
    if at.abs().max_element() > 3.0 {
        return None;
    }
    let flat = to(at.extend(2.0), dir, 0.0);
    let inside = tangential / 1.5;
    let inside = inside.extend(-(1.0 - inside.length_squared()).sqrt());
    let mut place = to(flat, inside, -3.0);
    for _ in 0..100 {
        place = to(flat, inside, -3.0 + sag(place.truncate().length()));
    }
    let slope = place.truncate().extend(-1.25 * sag(place.truncate().length()) - 0.5 * FOCAL_LENGTH).normalize();
    let leaves = 1.5 * (inside - slope * inside.dot(slope));
    let leaves = leaves + slope * (1.0 - leaves.length_squared()).sqrt();
    Some(to(place, leaves, -3.0 - FOCAL_LENGTH).truncate())
}

/// All of the display is seen, and each direction leads to its point.
fn shows_all(thickness: f64, shares: &Shares, positions: [usize; 2]) {
    let found = scanned(&folded(thickness, shares), positions, 2.0);
    for (side, want) in found.picture_m.into_iter().zip(DISPLAY) {
        assert!((1e3 * side / want - 1.0).abs() < 1e-6, "{side} m of {want} mm");
    }
    let mut worst = 0f64;
    for position in &found.positions {
        assert_eq!((position.seen, position.warning.as_ref()), (1.0, None));
        for line in &position.points {
            let [right, up] = line.direction_deg.expect("it is seen").map(|angle| angle.to_radians().tan());
            let dir = DVec3::new(right, up, -1.0).normalize();
            let [column, row] = line.cell.map(|at| at as f64);
            let want = DVec2::new(DISPLAY[0] * 0.99 * (column / 4.0 - 0.5), DISPLAY[1] * 0.99 * (0.5 - row / 2.0));
            let eye = 1e3 * DVec2::new(position.x_m, position.y_m);
            let ways = (0..20).flat_map(|up| (0..20).map(move |left| [2 * up, 2 * left + 1]));
            let off = ways.filter_map(|way| Some(on_the_display(eye, dir, thickness, way)?.distance(want)));
            let off = off.min_by(f64::total_cmp).expect("it meets the grating");
            worst = worst.max((off / FOCAL_LENGTH).to_degrees() * 60.0);
        }
    }
    println!("off by up to {worst:.1e}′");
    assert!(worst < 0.1, "{worst}′");
}

/// Of what the eye sends out the display has 0.05 × 0.1 × 0.4 at each way, which is less than a 256th.
#[test]
fn a_display_over_a_fold() {
    shows_all(1.5, &Shares { inside: 0.4, fold: 0.1, outside: 0.05 }, [1, 1]);
}

long! {
#[test]
fn a_display_over_a_fold_from_all_of_an_eyebox() {
    for (thickness, shares) in [
        (1.5, Shares { inside: 0.4, fold: 0.3, outside: 0.2 }),
        (1.0, Shares { inside: 0.3, fold: 0.08, outside: 0.05 }),
    ] {
        shows_all(thickness, &shares, [3, 3]);
    }
}
}
