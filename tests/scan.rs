//! `eyebox scan` against closed forms: a lamp in a plane mirror, the display behind a thick lens, what a lens lets through.

use crate::common::{add_group, add_part, cuboid, face, lamp, mesh, quad, scene};
use eyebox::base::ids::{GratingId, MediumId};
use eyebox::estimate::virtual_image::image::distortion;
use eyebox::import::{ImportOptions, Set, import};
use eyebox::plan::scan::edges::Figure;
use eyebox::plan::scan::light::LightAsked;
use eyebox::plan::scan::limits::{Kind, Limits, beyond};
use eyebox::plan::scan::table::{csv, edges_csv, ghosts_csv, lines};
use eyebox::plan::scan::{Line, Position, Scan, ScanAsked, scan};
use eyebox::plan::{Asked, Choice, Guides, Polarisation};
use eyebox::scene::{Absorption, Angular, Dispersion, Emitter, Finish, Grating, Medium, Order, Scene, Shape};
use eyebox_bench::kit;
use glam::{DAffine3, DQuat, DVec2, DVec3};
use std::path::Path;
use std::process::Command;

const IPD_M: f64 = 0.06;
const LAMP_CD_M2: f64 = 1000.0;
const MIRROR: f64 = 0.8;

fn asked(positions: [usize; 2], size_m: [f64; 2]) -> ScanAsked {
    ScanAsked {
        positions,
        size_m: size_m.map(Some),
        ipd_m: IPD_M,
        points: [3, 3],
        target: None,
        light: None,
        edges: false,
    }
}

fn run(scene: &Scene, asked: &ScanAsked) -> Scan {
    scan(scene, asked, &|| false, |_| {}).expect("the scene can be scanned").expect("nobody stopped it")
}

/// A lamp of 40 × 20 mm that faces down, seen in a mirror at 45° that is 300 mm away and `half` wide and high.
pub fn mirrored(half: f64) -> Scene {
    let mut scene = scene();
    let along = DVec3::new(0.0, 1.0, -1.0).normalize();
    let glass = mesh(&[quad(DVec3::ZERO, DVec3::X * half, -along * half)]);
    let finish = Finish::MirrorIdeal { reflectance: MIRROR };
    add_part(&mut scene, "mirror", glass, DVec3::new(0.0, 0.0, -0.3), None, vec![face(finish)]);
    let group = add_group(&mut scene, "led");
    let mut shining = face(Finish::Absorber);
    shining.emitter = lamp(group, LAMP_CD_M2);
    let panel = mesh(&[quad(DVec3::ZERO, DVec3::X * 0.02, DVec3::Z * 0.01)]);
    add_part(&mut scene, "lamp", panel, DVec3::new(0.0, 0.5, -0.3), None, vec![shining]);
    scene.eye.resolution = [24, 24];
    scene
}

#[test]
fn a_lamp_in_a_plane_mirror() {
    let scene = mirrored(0.3);
    let light = LightAsked {
        // Half a degree, the size of a patch, is three pixels.
        resolution: [96, 96],
        passes: 8,
        seed: 1,
        asked: Asked { choice: Choice::Auto, polarisation: Polarisation::Off, guides: Guides::On },
    };
    let wanted = ScanAsked { light: Some(light), ..asked([3, 2], [0.1, 0.04]) };
    let found = run(&scene, &wanted);
    assert_eq!((found.part.as_str(), found.positions.len()), ("lamp", 6));
    let [width, height] = found.picture_m;
    assert!((width / 0.04 - 1.0).abs() < 1e-6 && (height / 0.02 - 1.0).abs() < 1e-6, "{:?}", found.picture_m);
    for position in &found.positions {
        assert_eq!((position.seen, position.points.len()), (1.0, 9));
        let eye = DVec3::new(position.x_m, position.y_m, 0.0);
        let mut images = Vec::new();
        for line in &position.points {
            // Where the line of sight meets the image's plane, 0.8 m away.
            let [x, y] = line.direction_deg.unwrap().map(|angle| angle.to_radians().tan());
            let image = eye + DVec3::new(x, y, -1.0) * 0.8;
            assert!(image.x.abs() <= 0.02 && image.y.abs() <= 0.01, "{image}");
            images.push(image);
            let distance = (image - eye).length();
            let vergence = line.vergence.unwrap();
            for got in [vergence.horizontal_per_m, vergence.vertical_per_m] {
                // (1 mm/0.8 m)²
                assert!((got * distance - 1.0).abs() < 3e-6, "{got} {distance}");
            }
            let disparity = line.disparity.unwrap();
            let tilted = y.hypot(1.0) * 0.8;
            let azimuth = |side: f64| (image.x - eye.x - side * IPD_M / 2.0).atan2(tilted);
            let want = azimuth(-1.0) - azimuth(1.0);
            assert!((disparity.convergence_rad - want).abs() < 1e-9, "{} {want}", disparity.convergence_rad);
            assert!(disparity.dipvergence_rad.abs() < 1e-9, "{}", disparity.dipvergence_rad);
        }
        // One place in space for each point, from wherever it is seen.
        let first = &found.positions[0];
        for (line, image) in first.points.iter().zip(&images) {
            let [x, y] = line.direction_deg.unwrap().map(|angle| angle.to_radians().tan());
            let other = DVec3::new(first.x_m, first.y_m, 0.0) + DVec3::new(x, y, -1.0) * 0.8;
            assert!((other - *image).length() < 1e-9, "{other} {image}");
        }
        // A flat mirror bends nothing: what is left is the view of a plane from the side, as the fit has it.
        let size = found.picture_m;
        let places: Vec<(DVec2, DVec3)> = position
            .points
            .iter()
            .zip(&images)
            .map(|(line, image)| {
                let [u, v] = line.cell.map(|i| 0.005 + 0.99 * i as f64 / 2.0);
                (DVec2::new((u - 0.5) * size[0], (0.5 - v) * size[1]), (*image - eye).normalize())
            })
            .collect();
        let want = distortion(&places, places[4].1, DVec3::X).unwrap();
        let got = position.distortion.unwrap();
        assert!((got.max_arcmin - want.max_arcmin).abs() < 1e-5, "{got:?} {want:?}");
        let white = position.luminance.unwrap();
        let [centre, mean] = [white.centre, white.mean].map(|level| level.unwrap().value);
        // A uniform lamp is uniform: no patch of half a degree hangs over its rim, where it would read less.
        let uniformity = white.uniformity.unwrap().value;
        assert_eq!((white.patches, white.black), (9, false));
        for got in [centre / (MIRROR * LAMP_CD_M2), mean / (MIRROR * LAMP_CD_M2), uniformity] {
            assert!((got - 1.0).abs() < 1e-3, "{white:?}");
        }
    }
    // From the middle, between both rows, all would be square to the axis; here the rows mirror each other.
    let [up, down] = [1, 4].map(|i| found.positions[i].distortion.unwrap().max_arcmin);
    assert!((up - down).abs() < 1e-5, "{up} {down}");
    let table = csv(&found);
    assert_eq!(table.lines().count(), 7);
    assert!(table.lines().all(|line| line.split(',').count() == 24), "{table}");
    assert!(!table.contains("NaN") && !table.contains("inf"), "{table}");
    assert!(lines(&found).iter().any(|line| line.starts_with("convergence, mean")), "{:?}", lines(&found));
}

/// The eye looks 3° wide and the lamp is 2.86°: from 60 mm aside, 4.3°, its picture is outside of that. Luminances are those
/// of the middle all the same, and it is said what `render` would cut off.
#[test]
fn the_field_of_view_moves_with_the_picture() {
    let mut scene = mirrored(0.3);
    scene.eye.fov_deg = 3.0;
    let asked_light = Asked { choice: Choice::Auto, polarisation: Polarisation::Off, guides: Guides::On };
    let light = LightAsked { resolution: [64, 64], passes: 4, seed: 1, asked: asked_light };
    let found = run(&scene, &ScanAsked { light: Some(light), points: [5, 5], ..asked([3, 1], [0.12, 0.0]) });
    for position in &found.positions {
        let white = position.luminance.unwrap();
        let [centre, mean] = [white.centre, white.mean].map(|level| level.unwrap().value);
        assert!((centre / (MIRROR * LAMP_CD_M2) - 1.0).abs() < 1e-3, "{white:?}");
        assert!((mean / (MIRROR * LAMP_CD_M2) - 1.0).abs() < 1e-3, "{white:?}");
    }
    assert_eq!(found.positions.iter().map(|p| p.cut).collect::<Vec<_>>(), [1.0, 0.0, 1.0]);
    let said = lines(&found);
    assert_eq!(said.iter().filter(|line| line.contains("cuts 100 % of the picture off")).count(), 2, "{said:?}");
}

/// A white screen in the place of the lamp is seen from everywhere, but the lamp shines away from it.
#[test]
fn a_picture_without_light_is_a_warning() {
    let mut scene = mirrored(0.3);
    let group = scene.parts[1].faces[0].emitter.take().expect("the lamp").group;
    scene.parts[1].faces[0].finish = Finish::Lambert { reflectance: 0.5, transmittance: 0.0 };
    let mut shining = face(Finish::Absorber);
    shining.emitter = lamp(group, LAMP_CD_M2);
    let panel = mesh(&[quad(DVec3::ZERO, DVec3::X * 0.02, -DVec3::Z * 0.01)]);
    add_part(&mut scene, "away", panel, DVec3::new(0.0, 0.9, -0.3), None, vec![shining]);
    let asked_light = Asked { choice: Choice::Auto, polarisation: Polarisation::Off, guides: Guides::On };
    let light = LightAsked { resolution: [32, 32], passes: 2, seed: 1, asked: asked_light };
    let found = run(&scene, &ScanAsked { light: Some(light), ..asked([2, 1], [0.02, 0.0]) });
    assert_eq!((found.part.as_str(), found.positions[0].seen), ("lamp", 1.0));
    let said = lines(&found);
    for position in &found.positions {
        let place = format!("x {:.2} mm", 1e3 * position.x_m);
        assert!(
            said.iter().any(|l| l.starts_with("warning: ") && l.contains(&place) && l.contains("no light")),
            "{said:?}"
        );
    }
}

/// Beside a small mirror nothing is seen, and it is said so.
#[test]
fn outside_the_eyebox_nothing_is_seen() {
    let found = run(&mirrored(0.02), &asked([3, 1], [0.4, 0.0]));
    let seen: Vec<f64> = found.positions.iter().map(|p| p.seen).collect();
    assert!(seen[1] > 0.9 && seen[0] == 0.0 && seen[2] == 0.0, "{seen:?}");
    let beside = &found.positions[0];
    assert!(beside.distortion.is_none() && beside.distance.is_none() && beside.disparity.is_none());
    assert!(lines(&found).iter().any(|line| line.contains("vignetted")));
    assert!(!csv(&found).contains("NaN"));
    assert!(beside.points.iter().all(|line| !line.seen));
}

#[test]
fn faults() {
    let scene = mirrored(0.3);
    let fault = |asked: &ScanAsked| scan(&scene, asked, &|| false, |_| {}).unwrap_err().to_string();
    let good = asked([1, 1], [0.0, 0.0]);
    assert!(fault(&ScanAsked { target: Some("lam".into()), ..good.clone() }).contains("did you mean `lamp`?"));
    assert!(fault(&ScanAsked { target: Some("mirror".into()), ..good.clone() }).contains("nothing to scan"));
    assert!(fault(&asked([0, 1], [0.1; 2])).contains("1 to 4096"));
    assert!(fault(&asked([usize::MAX, 2], [0.1; 2])).contains("1 to 4096"));
    assert!(fault(&asked([2, 1], [0.0; 2])).contains("all eye positions would be one"));
    assert!(fault(&asked([2, 1], [f64::NAN, 0.0])).contains("0 or more"));
    assert!(fault(&ScanAsked { points: [2, 9], ..good.clone() }).contains("at least 3"));
    assert!(fault(&ScanAsked { ipd_m: f64::INFINITY, ..good }).contains("--ipd"));
}

/// The sample's picture is 200 mm before a lens whose convex face has R = 103.70448 mm, 5 mm thick, 196.707 mm before the
/// eye. Paraxial: the vergence behind the first face is V₁ = (n − 1)/R − 1/l, behind the second V₁/(1 − V₁t/n), and at
/// the eye V/(1 − Vd) (any textbook, e.g. Hecht, Optics, section 6.1).
#[test]
fn the_display_behind_a_thick_lens() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples/hud-direct/hud.optics.toml");
    for (glass, n) in [("N-BK7", 1.518_522_387_620_788), ("N-SK16", 1.622_607_688_060_801)] {
        let sets = ["eye.pupil_diameter=\"0.2 mm\"".to_owned(), format!("LENS_02_NBK7.glass={glass}")];
        let sets = sets.iter().map(|text| Set::parse(text).unwrap()).collect();
        let scene =
            import(&path, &ImportOptions { sets, ..ImportOptions::default() }).expect("the sample imports").scene;
        let found = run(&scene, &asked([3, 1], [0.12, 0.0]));
        assert!(found.part.ends_with("LCD_ACTIVE_AREA"), "{}", found.part);
        assert!((found.picture_m[0] - 0.04).abs() < 1e-9 && (found.picture_m[1] - 0.02).abs() < 1e-9);
        let behind = |v: f64, d: f64| v / (1.0 - v * d);
        let first = (n - 1.0) / 0.103_704_48 - 1.0 / 0.2;
        // Converging is negative here.
        let want = -behind(behind(first, 0.005 / n), 0.196_707);
        let middle = &found.positions[1];
        // The lens of 17 mm hides the sides of a picture of 40 mm behind it.
        assert_eq!(middle.seen, 3.0 / 9.0);
        let got = middle.distance.unwrap().centre_per_m.unwrap();
        assert!((got - want).abs() < 2e-4, "{glass}: {got} {want}");
        // 60 mm beside the axis the lens of 17 mm shows a ray at more than (60 − 17)/196.7, and the picture is within 0.1.
        assert_eq!([0, 2].map(|i| found.positions[i].seen), [0.0, 0.0]);
        // Eyes 60 mm apart: neither sees anything.
        assert!(middle.disparity.is_none());
    }
}

/// Fresnel's power reflectances of s and p from air onto glass (Born and Wolf, 1.5.2, (21a)).
pub fn fresnel(theta: f64, n: f64) -> [f64; 2] {
    let inside = (theta.sin() / n).asin();
    let s = (theta - inside).sin() / (theta + inside).sin();
    let p = (theta - inside).tan() / (theta + inside).tan();
    [s * s, p * p]
}

/// A lamp of 40 × 20 mm that faces down, 0.5 m over a plate at 45° whose front's middle is 300 mm before the eye. The plate's front
/// is its face 0.
pub fn plate(n: f64, thickness: f64) -> Scene {
    let mut scene = mirrored(0.3);
    let normal = DVec3::new(0.0, 1.0, 1.0).normalize();
    let glass = mesh(&cuboid(DVec3::new(0.3, 0.3, 0.5 * thickness)));
    scene.meshes[scene.parts[0].mesh.index()] = glass.into();
    scene.media.push(Medium { name: "glass".into(), index: Dispersion::Constant(n), absorption: Absorption::NONE });
    let part = &mut scene.parts[0];
    part.medium = Some(MediumId::from_index(scene.media.len() - 1));
    part.faces = vec![face(Finish::Polished); 6];
    let turn = DQuat::from_rotation_arc(DVec3::Z, normal);
    let front = DVec3::new(0.0, 0.0, -0.3);
    part.to_world = DAffine3::from_rotation_translation(turn, front - 0.5 * thickness * normal);
    scene
}

/// A lamp in a plane-parallel plate at 45°: its back sends a second image. In the plane of incidence a ray at θ goes
/// (h + h′) tan θ + 2t tan θ′ along the plate from the eye to the lamp, h and h′ above it; sin θ = n sin θ′. Of each
/// polarisation the back has (1 − R)² R where the front has R.
#[test]
fn a_plate_shows_a_lamp_twice() {
    for power in [0.0, 30.0] {
        plate_and_lamp(power);
    }
}

/// The lamp's luminance goes with this power of the cosine: the ratio of luminances has that of both rays at the lamp.
fn plate_and_lamp(power: f64) {
    let (n, thickness) = (1.52, 0.004);
    let mut scene = plate(n, thickness);
    let shining = scene.parts[1].faces[0].emitter.take().expect("it shines");
    scene.parts[1].faces[0].emitter = Some(Emitter { angular: Angular::CosN { n: power + 1.0 }, ..shining });
    let (normal, front) = (DVec3::new(0.0, 1.0, 1.0).normalize(), DVec3::new(0.0, 0.0, -0.3));
    let found = run(&scene, &asked([2, 1], [0.05, 0.0]));
    assert_eq!(found.by, "mirror front");
    let mut compared = 0;
    for position in &found.positions {
        let ghost = &position.ghosts[0];
        assert_eq!((ghost.by.as_str(), ghost.points.len()), ("mirror back", 9));
        assert!(position.ghosts.windows(2).all(|pair| pair[0].mean_ratio >= pair[1].mean_ratio));
        let eye = DVec3::new(position.x_m, position.y_m, 0.0);
        for point in &ghost.points {
            let main = position.points.iter().find(|line| line.cell == point.cell).unwrap().direction_deg.unwrap();
            let [x, y] = main.map(|angle| angle.to_radians().tan());
            let dir = DVec3::new(x, y, -1.0).normalize();
            // The point of the lamp, 0.5 m up, by reflection.
            let on_plate = eye + dir * ((front - eye).dot(normal) / dir.dot(normal));
            let sent = dir - 2.0 * dir.dot(normal) * normal;
            let place = on_plate + sent * ((0.5 - on_plate.y) / sent.y);
            let (to, heights) = (place - eye, (eye - front).dot(normal) + (place - front).dot(normal));
            let tangent = (to - to.dot(normal) * normal).normalize();
            let along = |theta: f64| heights * theta.tan() + 2.0 * thickness * (theta.sin() / n).asin().tan();
            let (mut low, mut high) = (0.0, 1.5);
            for _ in 0..200 {
                let middle: f64 = 0.5 * (low + high);
                if along(middle) < to.dot(tangent) { low = middle } else { high = middle }
            }
            let ghost_dir = low.sin() * tangent - low.cos() * normal;
            let right = (DVec3::X - dir.x * dir).normalize();
            let want = [ghost_dir.dot(right), ghost_dir.dot(right.cross(dir))]
                .map(|side| side.atan2(ghost_dir.dot(dir)).to_degrees() * 60.0);
            for (got, want) in point.separation_arcmin.into_iter().zip(want) {
                assert!((got - want).abs() < 1e-4, "{:?}: {got} {want}", point.cell);
            }
            let own = fresnel((-dir.dot(normal)).acos(), n);
            let second: f64 = fresnel(low, n).map(|r| (1.0 - r).powi(2) * r).iter().sum();
            // The lamp faces down; a plate leaves rays as steep as they were.
            let lobes = ((ghost_dir - 2.0 * ghost_dir.dot(normal) * normal).y / sent.y).powf(power);
            let ratio = lobes * second / (own[0] + own[1]);
            assert!((point.ratio / ratio - 1.0).abs() < 1e-6, "{:?}: {} {ratio}", point.cell, point.ratio);
            compared += 1;
        }
    }
    assert_eq!(compared, 18);
    let rows = ghosts_csv(&found);
    let of_back = rows.lines().filter(|line| line.contains("\"mirror back\"")).count();
    assert_eq!(of_back, 18);
    assert!(lines(&found).iter().any(|line| line.ends_with("mirror back, 2 positions")));
}

/// Straight through a hologram that sends a third of the light elsewhere: what is looked at is not left to chance.
#[test]
fn a_lamp_behind_a_grating() {
    for (orders, rest) in [(vec![(1, 0.3)], true), (vec![(1, 0.3), (0, 0.4)], false), (vec![(1, 0.01)], true)] {
        let orders = orders.into_iter().map(|(order, transmittance)| Order { order, transmittance, reflectance: 0.1 });
        let grating = Grating {
            direction: DVec3::Y,
            lines_per_mm: 600.0,
            orders: orders.collect::<Vec<_>>().into(),
            rest_in_zero_order: rest,
        };
        let scene = lamp_behind(grating);
        let found = run(&scene, &asked([3, 1], [0.05, 0.0]));
        assert_eq!((found.part.as_str(), found.by.as_str()), ("lamp", "hologram"));
        for position in &found.positions {
            assert_eq!(position.seen, 1.0);
            for line in &position.points {
                let [x, y] = line.direction_deg.unwrap().map(|angle| angle.to_radians().tan());
                // The lamp itself, 0.6 m ahead.
                let want = 1.0 / (0.6 * (1.0 + x * x + y * y).sqrt());
                let got = line.vergence.unwrap().mean_per_m();
                assert!((got / want - 1.0).abs() < 1e-4, "{got} {want}");
            }
        }
    }
}

/// Edges of the middle of a lamp's picture in a plane mirror at 45°: by similar triangles. The lamp's image is 0.8 m away; the mirror's
/// points are (x, t, −0.3 − t) with |x| and √2 |t| up to its half side.
#[test]
fn edges_behind_a_small_mirror() {
    let side = 0.02;
    let found = run(&mirrored(side), &ScanAsked { edges: true, ..asked([1, 1], [0.01, 0.01]) });
    let edges = found.edges.as_ref().expect("they were asked for");
    let height = side / 2f64.sqrt();
    // Left, right, down, up: how far the eye can go until the mirror no longer shows it this point.
    let of_point = |line: &Line| {
        let [x, y] = line.direction_deg.expect("it is seen").map(|angle| 0.8 * angle.to_radians().tan());
        let share = 0.3 / (0.8 - y);
        let across = |x: f64| (side - x * share) / (1.0 - share);
        let along = |y: f64, way: f64| (height * (0.8 - y) - way * 0.3 * y) / (0.5 - way * height);
        [across(-x), across(x), along(y, -1.0), along(y, 1.0)]
    };
    let all: Vec<[f64; 4]> = found.positions[0].points.iter().map(of_point).collect();
    assert_eq!(edges.figures.iter().map(|e| e.figure).collect::<Vec<_>>(), [Figure::Seen, Figure::MiddleSeen]);
    for extent in &edges.figures {
        let got = [extent.left, extent.right, extent.down, extent.up].map(|edge| edge.expect("an edge").distance_m);
        for (way, got) in got.into_iter().enumerate() {
            let mut each: Vec<f64> = all.iter().map(|point| point[way]).collect();
            each.sort_by(f64::total_cmp);
            // Less than a half of nine are left when the fifth is gone.
            let want = if extent.figure == Figure::Seen { each[4] } else { all[4][way] };
            assert!((got / want - 1.0).abs() < 1e-6, "{:?} {way}: {got} {want}", extent.figure);
        }
        assert!((extent.width_m().unwrap() - got[0] - got[1]).abs() < 1e-15);
    }
    let said = lines(&found);
    assert!(said.iter().any(|line| line.contains("picture's middle seen") && !line.contains("beyond")), "{said:?}");
    let rows = edges_csv(edges);
    assert!(rows.lines().count() == 3 && rows.lines().all(|line| line.split(',').count() == 11), "{rows}");
    // Behind a mirror that ends farther out than was looked.
    let wide = run(&mirrored(20.0), &ScanAsked { edges: true, ..asked([1, 1], [0.01, 0.01]) });
    assert!(wide.edges.unwrap().figures[0].left.is_none());
}

/// A magnifier with a round rim, the lamp's middle on its axis: the eyebox ends with the ray that the rim of one of its faces
/// lets by, traced by Snell's law through a sphere and a plane.
#[test]
fn edges_behind_a_round_magnifier() {
    // mm: the convex face towards the lamp, the plane one towards the eye.
    let (radius, convex, plane, rim, n) = (50.0_f64, -105.0, -100.0, 12.5, 1.5_f64);
    for object in [-185.0, -205.0, -240.0] {
        let mut scene = scene();
        let low = kit::cap(convex, |r| kit::sag_of_sphere(radius, r), rim, false, [24, 48]);
        let high = kit::cap(plane, |_| 0.0, rim, true, [24, 48]);
        let wall = kit::wall(&low.0, &high.0, 48);
        let shapes = [
            Shape::Sphere { vertex: DVec3::Z * convex, axis: DVec3::Z, radius },
            Shape::Plane { vertex: DVec3::Z * plane, axis: DVec3::Z },
        ];
        let faces = shapes.map(kit::polished).into_iter().chain([kit::face(Finish::Absorber)]).collect();
        let millimetres = DAffine3::from_scale(DVec3::splat(1e-3));
        kit::add(&mut scene, kit::mesh_of([low, high, wall]), millimetres, Some(n), faces);
        let group = add_group(&mut scene, "led");
        let mut shining = face(Finish::Absorber);
        shining.emitter = lamp(group, LAMP_CD_M2);
        let panel = mesh(&[quad(DVec3::ZERO, DVec3::X * 0.002, DVec3::Y * 0.002)]);
        add_part(&mut scene, "lamp", panel, DVec3::new(0.0, 0.0, 1e-3 * object), None, vec![shining]);
        let found = run(&scene, &ScanAsked { target: Some("lamp".into()), edges: true, ..asked([1, 1], [0.01; 2]) });
        // Heights at both faces and at the eye of a ray with this slope from the lamp's middle.
        let heights = |slope: f64| {
            let (sin, cos) = slope.atan().sin_cos();
            // From the sphere's centre, radius behind its vertex.
            let from = object - convex - radius;
            let t = -from * cos - (radius * radius - (from * sin).powi(2)).sqrt();
            let (z, y) = (from + t * cos, t * sin);
            let normal = (y / radius).asin();
            // Outward normals of the near side lean back from the axis.
            let inside = ((slope.atan() + normal).sin() / n).asin() - normal;
            let second = y + inside.tan() * (plane - convex - radius - z);
            let outside = (n * inside.sin()).asin();
            (y, second, second - outside.tan() * plane)
        };
        let (mut low, mut high) = (0.0, 0.3);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            let (first, second, _) = heights(middle);
            if first.max(second) < rim { low = middle } else { high = middle }
        }
        let want = 1e-3 * heights(low).2;
        let extent = found.edges.unwrap().figures[1];
        assert_eq!(extent.figure, Figure::MiddleSeen);
        for edge in [extent.left, extent.right, extent.down, extent.up] {
            let got = edge.expect("an edge").distance_m;
            println!("lamp at {object} mm: {got} m, want {want} m");
            assert!((got / want - 1.0).abs() < 1e-5, "{object}: {got} {want}");
        }
    }
}

/// A lamp whose luminance goes with a power of the cosine, seen directly: it has fallen to a half where cosᵐ θ = ½.
#[test]
fn edges_of_a_narrow_lamp() {
    let (power, away) = (20.0, 0.5);
    let mut scene = scene();
    let group = add_group(&mut scene, "led");
    let mut shining = face(Finish::Absorber);
    let angular = Angular::CosN { n: power + 1.0 };
    shining.emitter = lamp(group, LAMP_CD_M2).map(|emitter| Emitter { angular, ..emitter });
    let panel = mesh(&[quad(DVec3::ZERO, DVec3::X * 0.02, DVec3::Y * 0.02)]);
    add_part(&mut scene, "lamp", panel, DVec3::new(0.0, 0.0, -away), None, vec![shining]);
    let light = LightAsked {
        resolution: [48, 48],
        passes: 2,
        seed: 1,
        asked: Asked { choice: Choice::Auto, polarisation: Polarisation::Off, guides: Guides::On },
    };
    let wanted = ScanAsked { light: Some(light), edges: true, ..asked([1, 1], [0.1, 0.1]) };
    let found = run(&scene, &wanted);
    let edges = found.edges.clone().unwrap();
    assert_eq!(edges.figures.len(), 4);
    let want = away * 0.5f64.powf(1.0 / power).acos().tan();
    for extent in &edges.figures[2..] {
        for edge in [extent.left, extent.right, extent.down, extent.up] {
            let got = edge.expect("an edge").distance_m;
            println!("{:?}: {got} m, want {want} m", extent.figure);
            // A patch of half a degree; the mean is of a lamp that is 4.6° wide.
            let most = if extent.figure == Figure::CentreLuminance { 1e-3 } else { 0.01 };
            assert!((got / want - 1.0).abs() < most, "{:?}: {got} {want}", extent.figure);
        }
    }
    // The same again: no chance.
    assert_eq!(run(&scene, &wanted).edges, Some(edges));
}

/// Limits on both sides of what similar triangles say of a lamp's image 0.8 m away: its points straight ahead of the eyes converge most.
#[test]
fn limits_of_two_eyes() {
    let found = run(&mirrored(0.3), &asked([3, 1], [0.1, 0.0]));
    let worst = |position: &eyebox::plan::scan::Position, per_m: f64| {
        let of = |line: &Line| {
            let [x, y] = line.direction_deg.unwrap().map(|angle| angle.to_radians().tan());
            let azimuth = |side: f64, away: f64| (x * away - side * IPD_M / 2.0).atan2(away * y.hypot(1.0));
            let at = |away: f64| azimuth(-1.0, away) - azimuth(1.0, away);
            // `meant` goes along the line of sight.
            let along = 1.0 / per_m / (1.0 + x * x + y * y).sqrt();
            at(0.8) - if per_m == 0.0 { 0.0 } else { at(along) }
        };
        position.points.iter().map(of).fold(f64::NEG_INFINITY, f64::max)
    };
    for per_m in [0.0, 1.0 / 1.1] {
        for (index, position) in found.positions.iter().enumerate() {
            let want = worst(position, per_m);
            for (share, past) in [(1.0 - 1e-6, true), (1.0 + 1e-6, false)] {
                let limits = Limits { convergence_rad: Some(want * share), image_per_m: per_m, ..Limits::default() };
                let here = beyond(&found, &limits).into_iter().find(|at| at.x_m == position.x_m);
                assert_eq!(here.is_some(), past, "{per_m} {index}: {want}");
                assert!(here.is_none_or(|at| (at.value_rad / want - 1.0).abs() < 1e-6 && at.kind == Kind::Convergence));
            }
        }
    }
    // Nearer than where it is meant to be it never diverges; farther it does.
    let apart = |per_m| Limits { divergence_rad: Some(1e-4), image_per_m: per_m, ..Limits::default() };
    assert!(beyond(&found, &apart(1.0)).is_empty());
    assert_eq!(beyond(&found, &apart(1.0 / 0.7)).len(), 3);
    // A plane mirror shows both eyes the same place.
    let level = Limits { dipvergence_rad: Some(1e-9), ..Limits::default() };
    assert!(beyond(&found, &level).is_empty());
}

#[test]
fn limits_on_the_command_line() {
    let sample = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples/windshield/windshield.optics.toml");
    let run = |more: &[&str]| {
        let fixed = ["--eyebox", "1x1", "--no-luminance", "--points", "3x3", "--quiet"];
        let mut command = Command::new(env!("CARGO_BIN_EXE_eyebox"));
        let out = command.arg("scan").arg(&sample).args(fixed).args(more).output().expect("it runs");
        (out.status.code(), [out.stdout, out.stderr].map(|text| String::from_utf8_lossy(&text).into_owned()))
    };
    let (code, [out, _]) = run(&["--limits", "genco-1983", "--image-distance", "inf"]);
    assert!(code == Some(1) && out.contains("warning: from x 0.00 mm, y 0.00 mm the convergence at column"), "{out}");
    let (code, [out, _]) = run(&["--limits", "dipvergence=5"]);
    assert!(code == Some(0) && out.contains("kept from all 1 of 1 positions"), "{out}");
    // Eyes farther apart than the mirrors are wide see nothing together: what could not be tested is not kept.
    let (code, [out, _]) = run(&["--limits", "dipvergence=5", "--ipd", "900"]);
    assert!(code == Some(1) && out.contains("not tested") && out.contains("nothing was held"), "{out}");
    // The sidecar's own, and the command line before them.
    let own =
        ["--set", "eye.dipvergence_mrad=0.1", "--set", "eye.image_distance=2.2 m", "--set", "eye.convergence_mrad=1"];
    let (code, [out, _]) = run(&own);
    assert!(code == Some(1) && out.contains("dipvergence") && out.contains("at most 0.100"), "{out}");
    assert!(
        out.contains("limits: convergence 1.000 mrad, dipvergence 0.100 mrad, of an image meant to be 2.200 m away"),
        "{out}"
    );
    let (code, [out, _]) = run(&[&own[..], &["--limits", "dipvergence=5,convergence=9"]].concat());
    assert!(code == Some(0) && out.contains("kept from all 1 of 1"), "{out}");
    let (code, [_, said]) = run(&["--set", "eye.convergence_mrad=1"]);
    assert!(
        code == Some(2) && said.contains("expected image_distance") && said.trim_end().lines().count() == 1,
        "{said}"
    );
    for (bad, why) in [
        (vec!["--image-distance", "2"], "there is no limit"),
        (vec!["--limits", "gu-2020"], "--image-distance"),
        (vec!["--limits", "gu-2021"], "did you mean `gu-2020`?"),
        (vec!["--limits", "dipvergence=-1"], "mrad above 0"),
        (vec!["--limits", "convergence=1", "--image-distance", "0"], "or inf"),
    ] {
        let (code, [_, said]) = run(&bad);
        assert!(code == Some(2) && said.trim_end().lines().count() == 1 && said.contains(why), "{code:?} {said}");
    }
}

/// A grating 0.3 m ahead, and a lamp 0.6 m ahead.
fn lamp_behind(grating: Grating) -> Scene {
    let mut scene = scene();
    scene.gratings.push(grating);
    let finish = Finish::Grating { grating: GratingId::from_index(0) };
    let pane = mesh(&[quad(DVec3::ZERO, DVec3::X * 0.3, DVec3::Y * 0.3)]);
    add_part(&mut scene, "hologram", pane, DVec3::new(0.0, 0.0, -0.3), None, vec![face(finish)]);
    let group = add_group(&mut scene, "led");
    let mut shining = face(Finish::Absorber);
    shining.emitter = lamp(group, LAMP_CD_M2);
    let panel = mesh(&[quad(DVec3::ZERO, DVec3::X * 0.02, DVec3::Y * 0.01)]);
    add_part(&mut scene, "lamp", panel, DVec3::new(0.0, 0.0, -0.6), None, vec![shining]);
    scene.eye.resolution = [24, 24];
    scene
}

/// The same of a grating that sends nothing back.
fn behind_lines(orders: &[(i32, f64)]) -> Scene {
    let orders = orders.iter().map(|(order, share)| Order { order: *order, transmittance: *share, reflectance: 0.0 });
    let orders = orders.collect::<Vec<_>>().into();
    lamp_behind(Grating { direction: DVec3::Y, lines_per_mm: LINES_PER_MM, orders, rest_in_zero_order: false })
}

const LINES_PER_MM: f64 = 200.0;

/// Where a ray from `eye` with these tangents is in the lamp's plane, over order m: s' = s + m λ/d along y (Born and Wolf, 8.6.1).
fn over_order(eye: DVec3, tangents: DVec2, order: i32) -> DVec2 {
    let dir = tangents.extend(-1.0).normalize();
    let y = dir.y + f64::from(order) * 550e-6 * LINES_PER_MM;
    let bent = DVec3::new(dir.x, y, -(1.0 - dir.x * dir.x - y * y).sqrt());
    let after = |from: DVec3, dir: DVec3, z: f64| from + dir * ((z - from.z) / dir.z);
    after(after(eye, dir, -0.3), bent, -0.6).truncate()
}

/// In which tangents `eye` sees a place of the lamp: by a secant for each axis in turn, which converges as the axes hardly mix.
fn seen_over(eye: DVec3, place: DVec2, order: i32) -> DVec2 {
    let mut tangents = DVec2::ZERO;
    for _ in 0..200 {
        for axis in 0..2 {
            let off = |t: DVec2| (over_order(eye, t, order) - place)[axis];
            let mut aside = tangents;
            aside[axis] += 1e-6;
            let (here, there) = (off(tangents), off(aside));
            if there != here {
                tangents[axis] -= here * 1e-6 / (there - here);
            }
        }
    }
    assert!((over_order(eye, tangents, order) - place).length() < 1e-13);
    tangents
}

/// A lamp over a diffracted order, which is brighter than what goes straight on: where each point is seen and how far away it is, in both
/// planes, from positions of an eyebox; the ghost is the lamp itself. Then the other way round.
#[test]
fn a_lamp_over_a_diffracted_order() {
    for (orders, main, other) in
        [([(1, 0.6), (0, 0.1)], 1, 0), ([(0, 0.6), (1, 0.1)], 0, 1), ([(-1, 0.5), (1, 0.25)], -1, 1)]
    {
        let scene = behind_lines(&orders);
        let found = run(&scene, &asked([3, 2], [0.04, 0.02]));
        let name = |order: i32| if order == 0 { "hologram".to_owned() } else { format!("hologram; orders {order:+}") };
        assert_eq!((found.part.as_str(), found.by.as_str()), ("lamp", name(main).as_str()));
        let (mut places, mut distances, mut separations) = (0f64, 0f64, 0f64);
        let place = |position: &Position, cell: [usize; 2]| {
            let line = position.points.iter().find(|line| line.cell == cell).unwrap();
            let tangents = line.direction_deg.unwrap().map(|angle| angle.to_radians().tan());
            over_order(DVec3::new(position.x_m, position.y_m, 0.0), tangents.into(), main)
        };
        // Of a lamp that is seen whole all is scanned.
        let first = |cell: [usize; 2]| place(&found.positions[0], cell);
        let middle = first([1, 1]);
        let sides = [first([2, 1]) - first([0, 1]), first([1, 0]) - first([1, 2])];
        assert!(middle.length() < 1e-3 && sides[0].dot(sides[1]).abs() < 1e-9, "{middle} {sides:?}");
        for (side, size) in sides.into_iter().zip(found.picture_m) {
            assert!((side.length() / (0.99 * size) - 1.0).abs() < 1e-9, "{side} {size}");
            let lamp = if side.x.abs() > side.y.abs() { 0.04 } else { 0.02 };
            assert!((size / lamp - 1.0).abs() < 1e-6, "{size}");
        }
        for position in &found.positions {
            assert_eq!(position.seen, 1.0);
            let eye = DVec3::new(position.x_m, position.y_m, 0.0);
            let place = |cell: [usize; 2]| place(position, cell);
            for line in &position.points {
                let at = place(line.cell);
                // From everywhere the same: columns count to the right, rows down.
                let [column, row] = line.cell.map(|at| (at as f64 - 1.0) / 2.0);
                places = places.max((at - middle).distance(column * sides[0] - row * sides[1]));
                let want = seen_over(eye, at, main);
                let step = scene.eye.pupil_diameter_m / 4.0;
                let dir = |t: DVec2| t.extend(-1.0).normalize();
                let seen = |shift: DVec3| dir(seen_over(eye + shift, at, main));
                let vergence = line.vergence.unwrap();
                for (axis, got) in [(DVec3::X, vergence.horizontal_per_m), (DVec3::Y, vergence.vertical_per_m)] {
                    let across = axis - dir(want) * dir(want).dot(axis);
                    let turned = seen(step * axis) - seen(-step * axis);
                    let want = -turned.dot(across) / (2.0 * step * across.length_squared());
                    distances = distances.max((got - want).abs());
                }
            }
            let ghost = position.ghosts.iter().find(|ghost| ghost.by == name(other)).expect("the other order");
            assert_eq!(position.ghosts.len(), 1);
            for point in &ghost.points {
                let at = place(point.cell);
                let [a, b] = [main, other].map(|order| seen_over(eye, at, order).extend(-1.0).normalize());
                let angle = 2.0 * (a - b).length().atan2((a + b).length());
                let [x, y] = point.separation_arcmin;
                let turned = DVec2::new(x, y).map(|side| (side / 60.0).to_radians().tan()).length().atan();
                separations = separations.max((turned - angle).abs().to_degrees() * 60.0);
                let share = |order: i32| orders.iter().find(|own| own.0 == order).unwrap().1;
                assert!((point.ratio / (share(other) / share(main)) - 1.0).abs() < 1e-12, "{}", point.ratio);
            }
            assert!(!ghost.points.is_empty());
        }
        println!(
            "order {main}: places on the lamp off by {places:.1e} m, vergences by {distances:.1e} 1/m, ghosts by {separations:.1e}′"
        );
        assert!(places < 1e-9 && distances < 1e-6 && separations < 1e-6, "{places} {distances} {separations}");
    }
}
