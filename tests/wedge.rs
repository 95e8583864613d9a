//! `eyebox scan` with a wedge plate between the eye and a grating: its faces, one after the other, send a second picture.

use crate::common::{add_group, add_part, face, lamp, mesh, quad, scene};
use crate::scan::fresnel;
use eyebox::base::ids::GratingId;
use eyebox::plan::scan::{ScanAsked, scan};
use eyebox::scene::{Finish, Grating, Order, Scene};
use glam::{DVec2, DVec3};

const N: f64 = 2.0;
const LINES_PER_MM: f64 = 200.0;
const SHARE: f64 = 0.6;
/// The plate's thickness in its middle, its half size and the slope of its front, which is thicker above: in f32 exactly.
const THICK: f64 = 1.0 / 128.0;
const HALF: f64 = 0.25;
const SLOPE: f64 = 1.0 / 64.0;
/// Where the plate's back, the grating and the lamp are, m before the eye.
const BACK: f64 = -0.125;
const LINES: f64 = -0.3;
const LAMP: f64 = -0.6;

fn wedge() -> Scene {
    let mut scene = scene();
    let [x, y] = [DVec3::X * HALF, DVec3::Y * HALF];
    let [low, high] = [THICK - SLOPE * HALF, THICK + SLOPE * HALF].map(|thick| DVec3::Z * thick);
    let (a, b, c, d) = (-x - y, x - y, x + y, y - x);
    let faces = [
        vec![a + low, b + low, c + high, d + high],
        vec![d, c, b, a],
        vec![a, b, b + low, a + low],
        vec![c, d, d + high, c + high],
        vec![b, c, c + high, b + low],
        vec![d, a, a + low, d + high],
    ];
    let at = DVec3::Z * BACK;
    add_part(&mut scene, "plate", mesh(&faces), at, Some(N), vec![face(Finish::Polished); 6]);
    let orders = vec![Order { order: 1, transmittance: SHARE, reflectance: 0.0 }].into();
    scene.gratings.push(Grating { direction: DVec3::Y, lines_per_mm: LINES_PER_MM, orders, rest_in_zero_order: false });
    let pane = mesh(&[quad(DVec3::ZERO, DVec3::X * 0.3, DVec3::Y * 0.3)]);
    let lines = face(Finish::Grating { grating: GratingId::from_index(0) });
    add_part(&mut scene, "hologram", pane, DVec3::Z * LINES, None, vec![lines]);
    let group = add_group(&mut scene, "led");
    let mut shining = face(Finish::Absorber);
    shining.emitter = lamp(group, 1000.0);
    let panel = mesh(&[quad(DVec3::ZERO, DVec3::X * 0.02, DVec3::Y * 0.01)]);
    add_part(&mut scene, "lamp", panel, DVec3::Z * LAMP, None, vec![shining]);
    scene.eye.resolution = [24, 24];
    scene
}

/// Snell's law: a direction behind a plane with this normal, towards which the light does not come.
fn refracted(dir: DVec3, normal: DVec3, ratio: f64) -> DVec3 {
    let cos = -dir.dot(normal);
    let along = ratio * (dir + cos * normal);
    along - (1.0 - along.length_squared()).sqrt() * normal
}

/// Where the ray that leaves `eye` with these tangents is in the lamp's plane after as many reflections at both of the plate's faces,
/// and the share of s and p that the plate lets through of it, where it stays in the plane of both normals.
fn traced(eye: DVec3, tangents: DVec2, reflections: usize) -> (DVec2, [f64; 2]) {
    let front = DVec3::new(0.0, -SLOPE, 1.0).normalize();
    let on_front = |from: DVec3, dir: DVec3| {
        let middle = DVec3::Z * (BACK + THICK);
        from + dir * ((middle - from).dot(front) / dir.dot(front))
    };
    let on = |z: f64, from: DVec3, dir: DVec3| from + dir * ((z - from.z) / dir.z);
    let mirrored = |dir: DVec3, normal: DVec3| dir - 2.0 * dir.dot(normal) * normal;
    // At a face from inside light is reflected as from outside at the angle in air.
    let reflectances = |dir: DVec3, normal: DVec3| {
        let inside = dir.dot(normal).abs().min(1.0).acos();
        fresnel((N * inside.sin()).asin(), N)
    };
    let dir = tangents.extend(-1.0).normalize();
    let mut at = on_front(eye, dir);
    let mut shares = fresnel((-dir.dot(front)).acos(), N).map(|r| 1.0 - r);
    let mut dir = refracted(dir, front, 1.0 / N);
    let mut times = |by: [f64; 2]| shares = [shares[0] * by[0], shares[1] * by[1]];
    for _ in 0..reflections {
        at = on(BACK, at, dir);
        times(reflectances(dir, DVec3::Z));
        dir = mirrored(dir, DVec3::Z);
        at = on_front(at, dir);
        times(reflectances(dir, front));
        dir = mirrored(dir, front);
    }
    at = on(BACK, at, dir);
    times(reflectances(dir, DVec3::Z).map(|r| 1.0 - r));
    dir = refracted(dir, DVec3::Z, N);
    at = on(LINES, at, dir);
    // s' = s + λ/d along y (Born and Wolf, 8.6.1).
    let y = dir.y + 550e-6 * LINES_PER_MM;
    dir = DVec3::new(dir.x, y, -(1.0 - dir.x * dir.x - y * y).sqrt());
    (on(LAMP, at, dir).truncate(), shares)
}

/// In which tangents `eye` sees a place of the lamp, by a secant for each axis in turn.
fn seen(eye: DVec3, place: DVec2, reflections: usize) -> DVec2 {
    let mut tangents = DVec2::ZERO;
    for _ in 0..200 {
        for axis in 0..2 {
            let off = |t: DVec2| (traced(eye, t, reflections).0 - place)[axis];
            let mut aside = tangents;
            aside[axis] += 1e-6;
            let (here, there) = (off(tangents), off(aside));
            if there != here {
                tangents[axis] -= here * 1e-6 / (there - here);
            }
        }
    }
    assert!((traced(eye, tangents, reflections).0 - place).length() < 1e-13);
    tangents
}

/// The picture is the lamp over the grating's order through the plate, the ghost the same after a reflection at the plate's back and one
/// at its front. The grating is met once by either, so the ghost is no other way of the picture, as it would be behind the
/// grating. Directions by Snell's law and the grating equation, the ratio by Fresnel's equations in the plane of both normals.
#[test]
fn a_wedge_before_a_grating_shows_the_picture_twice() {
    let asked = ScanAsked {
        positions: [3, 3],
        size_m: [Some(0.02); 2],
        ipd_m: 0.06,
        points: [3, 3],
        target: None,
        light: None,
        edges: false,
    };
    let found = scan(&wedge(), &asked, &|| false, |_| {}).expect("it can be scanned").expect("nobody stopped it");
    assert_eq!(found.part, "lamp");
    assert_eq!(found.by, "hologram, plate; orders +1");
    let (mut separations, mut ratios, mut skew, mut compared, mut least) = (0f64, 0f64, 0f64, 0, f64::INFINITY);
    let mut places: [[Option<DVec2>; 3]; 3] = Default::default();
    let mut moved = 0f64;
    for position in &found.positions {
        let eye = DVec3::new(position.x_m, position.y_m, 0.0);
        let by: Vec<&str> = position.ghosts.iter().map(|ghost| ghost.by.as_str()).collect();
        assert_eq!(by, ["hologram, inside plate ×2; orders +1", "hologram, inside plate ×4 or more; orders +1"]);
        for (k, ghost) in position.ghosts.iter().enumerate() {
            let reflections = k + 1;
            for point in &ghost.points {
                let main = position.points.iter().find(|line| line.cell == point.cell).unwrap().direction_deg.unwrap();
                let main: DVec2 = main.map(|angle| angle.to_radians().tan()).into();
                let (place, own) = traced(eye, main, 0);
                // From everywhere each point of the picture is the same place on the lamp.
                let [column, row] = point.cell;
                moved = moved.max(places[column][row].get_or_insert(place).distance(place));
                let tangents = seen(eye, place, reflections);
                let [dir, second] = [main, tangents].map(|t| t.extend(-1.0).normalize());
                let right = (DVec3::X - dir.x * dir).normalize();
                let want = [second.dot(right), second.dot(right.cross(dir))]
                    .map(|side| side.atan2(second.dot(dir)).to_degrees() * 60.0);
                for (got, want) in point.separation_arcmin.into_iter().zip(want) {
                    separations = separations.max((got - want).abs());
                }
                least = least.min(want[1].abs());
                let (_, other) = traced(eye, tangents, reflections);
                let off = (point.ratio / ((other[0] + other[1]) / (own[0] + own[1])) - 1.0).abs();
                let flat = dir.x.abs() < 1e-9;
                if flat {
                    ratios = ratios.max(off)
                } else {
                    skew = skew.max(off)
                }
                compared += 1;
            }
        }
    }
    println!(
        "{compared} points: places off by {moved:.1e} m, separations by {separations:.1e}′ of {least:.1}′ or more, ratios by \
         {ratios:.1e}, {skew:.1e} where rays leave the plane of the normals"
    );
    assert!(compared > 100 && least > 60.0 && moved < 1e-9, "{compared} {least} {moved}");
    // Where rays leave it s and p of the two faces are not the same, which matters by the square of how far they differ.
    assert!(separations < 1e-6 && ratios > 0.0 && ratios < 1e-9 && skew < 2e-4, "{separations} {ratios} {skew}");
}
