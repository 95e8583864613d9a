//! Small scenes made in code, for tests of the physics.

pub mod mutate;
pub mod pixels;

use eyebox::base::ids::{GroupId, MediumId, MeshId};
use eyebox::check::check;
use eyebox::estimate::run::{Films, Limits, run};
use eyebox::film::plan::{Estimator, Plan};
use eyebox::plan::{Asked, plan};
use eyebox::scene::*;
use eyebox::world::World;
use glam::{DAffine3, DMat3, DVec3};
use std::sync::Arc;

/// An empty scene in metres at 550 nm, with an eye at the origin that looks along −z.
pub fn scene() -> Scene {
    Scene {
        name: "test".to_owned(),
        unit_m: 1.0,
        wavelengths: Wavelengths::Mono { nm: 550.0 },
        meshes: Vec::new(),
        parts: Vec::new(),
        media: Vec::new(),
        coatings: Vec::new(),
        slides: Vec::new(),
        surfaces: Vec::new(),
        scatters: Vec::new(),
        wave_plates: Vec::new(),
        gratings: Vec::new(),
        profiles: Vec::new(),
        groups: Vec::new(),
        lights: Vec::new(),
        sky: None,
        eye: Eye {
            position: DVec3::ZERO,
            look: DVec3::NEG_Z,
            up: DVec3::Y,
            pupil_diameter_m: 0.004,
            adapts: false,
            limits: eyebox::scene::BinocularLimits::default(),
            focus_distance_m: f64::INFINITY,
            fov_deg: 20.0,
            resolution: [8, 8],
            age: 30.0,
        },
        notes: Vec::new(),
        hash: String::new(),
    }
}

pub fn face(finish: Finish) -> Face {
    Face { finish, coating: None, shape: Shape::Mesh, emitter: None, tint: None, slide: None, sensor: None }
}

/// One mesh face per polygon given (fan-triangulated, flat normals).
pub fn mesh(polygons: &[Vec<DVec3>]) -> Mesh {
    let mut mesh = Mesh { name: "m".to_owned(), ..Mesh::default() };
    for polygon in polygons {
        let normal = (polygon[1] - polygon[0]).cross(polygon[2] - polygon[0]).normalize();
        let base = mesh.positions.len() as u32;
        let first = mesh.triangles.len() as u32;
        for p in polygon {
            mesh.positions.push(p.as_vec3().to_array());
            mesh.normals.push(normal.as_vec3().to_array());
        }
        for i in 1..polygon.len() as u32 - 1 {
            mesh.triangles.push([base, base + i, base + i + 1]);
        }
        mesh.faces.push(FaceRange { first, count: polygon.len() as u32 - 2 });
    }
    mesh
}

/// A rectangle about `centre`, spanned by half sides `a` and `b`, facing a × b.
pub fn quad(centre: DVec3, a: DVec3, b: DVec3) -> Vec<DVec3> {
    vec![centre - a - b, centre + a - b, centre + a + b, centre - a + b]
}

/// The six faces of a box, outwards: −x, +x, −y, +y, −z, +z.
pub fn cuboid(half: DVec3) -> Vec<Vec<DVec3>> {
    let (x, y, z) = (DVec3::X * half.x, DVec3::Y * half.y, DVec3::Z * half.z);
    vec![quad(-x, z, y), quad(x, y, z), quad(-y, x, z), quad(y, z, x), quad(-z, y, x), quad(z, x, y)]
}

/// A closed sphere as one face.
pub fn sphere_mesh(radius: f64, rings: usize, sectors: usize) -> Mesh {
    let mut mesh = Mesh { name: "ball".to_owned(), ..Mesh::default() };
    let mut put = |v: DVec3| {
        mesh.positions.push((v * radius).as_vec3().to_array());
        mesh.normals.push(v.as_vec3().to_array());
        mesh.positions.len() as u32 - 1
    };
    let top = put(DVec3::Z);
    let bottom = put(DVec3::NEG_Z);
    let grid: Vec<Vec<u32>> = (1..rings)
        .map(|i| {
            let (s, c) = (std::f64::consts::PI * i as f64 / rings as f64).sin_cos();
            (0..sectors)
                .map(|j| {
                    let (sp, cp) = (2.0 * std::f64::consts::PI * j as f64 / sectors as f64).sin_cos();
                    put(DVec3::new(s * cp, s * sp, c))
                })
                .collect()
        })
        .collect();
    for j in 0..sectors {
        let k = (j + 1) % sectors;
        mesh.triangles.push([top, grid[0][j], grid[0][k]]);
        for rows in grid.windows(2) {
            mesh.triangles.push([rows[0][j], rows[1][j], rows[1][k]]);
            mesh.triangles.push([rows[0][j], rows[1][k], rows[0][k]]);
        }
        mesh.triangles.push([bottom, grid[rings - 2][k], grid[rings - 2][j]]);
    }
    mesh.faces.push(FaceRange { first: 0, count: mesh.triangles.len() as u32 });
    mesh
}

pub fn ball_shape(radius: f64) -> Shape {
    Shape::Sphere { vertex: DVec3::new(0.0, 0.0, -radius), axis: DVec3::Z, radius }
}

pub fn add_part(scene: &mut Scene, name: &str, mesh: Mesh, at: DVec3, medium: Option<f64>, faces: Vec<Face>) -> usize {
    let id = MeshId::from_index(scene.meshes.len());
    scene.meshes.push(mesh.into());
    let medium = medium.map(|n| {
        scene.media.push(Medium {
            name: format!("n={n}"),
            index: Dispersion::Constant(n),
            absorption: Absorption::Constant(0.0),
        });
        MediumId::from_index(scene.media.len() - 1)
    });
    scene.parts.push(Part {
        name: name.to_owned(),
        path: name.to_owned(),
        mesh: id,
        to_world: DAffine3::from_translation(at),
        medium,
        priority: 0,
        materials: Vec::new(),
 film_in: None,
        faces,
    });
    scene.parts.len() - 1
}

pub fn add_group(scene: &mut Scene, name: &str) -> GroupId {
    scene.groups.push(Group { name: name.to_owned() });
    GroupId::from_index(scene.groups.len() - 1)
}

/// A sky of uniform luminance, group `sky`.
pub fn uniform_sky(scene: &mut Scene, luminance: f32) {
    let group = add_group(scene, "sky");
    let (width, height) = (16, 8);
    let luminance = Arc::new(vec![luminance; width * height]);
    scene.sky =
        Some(Sky { group, width, height, luminance, rgb: None, to_world: DMat3::IDENTITY, file: "uniform".to_owned() });
}

pub fn lamp(group: GroupId, luminance: f64) -> Option<Emitter> {
    let photometry = Photometry::LuminanceCdM2(luminance);
    Some(Emitter {
        group,
        photometry,
        angular: Angular::Lambert,
        spectrum: None,
        polarisation: None,
        both_sides: false,
        pattern: None,
    })
}

/// A slide with a picture of 16 × 16 values without a pattern.
pub fn mottled_slide(contrast: f64) -> Slide {
    let side = 16;
    Slide {
        name: "slide".to_owned(),
        file: "none".to_owned(),
        width: side,
        height: side,
        pixels: Arc::new((0..side * side).map(|i| ((i * 37 + 11) % 101) as f32 / 100.0).collect()),
        rgb: None,
        centre: DVec3::ZERO,
        u: DVec3::X,
        v: DVec3::Y,
        size: [0.2, 0.2],
        transmittance: 0.9,
        contrast,
        polarisation: None,
        primaries: None,
    }
}

/// Checks, freezes, plans and traces.
pub fn render(scene: &Scene, asked: impl Into<Asked>, passes: u64, seed: u64) -> (Films, Plan) {
    let checked = check(scene).expect("the scene is sound");
    let world = World::freeze(scene).expect("the scene can be traced");
    let plan = plan(&checked, &world, asked);
    let limits = Limits { passes: Some(passes), ..Limits::default() };
    let outcome = run(&world, &plan, scene.groups.len(), scene.eye.resolution, seed, &limits, &mut ());
    (outcome.films, plan)
}

/// Value and variance of each pixel, summed over all films and planes.
pub fn image(films: &Films) -> Vec<(f64, f64)> {
    image_of(films, |_| true)
}

/// The same of some estimators.
pub fn image_of(films: &Films, keep: impl Fn(Estimator) -> bool) -> Vec<(f64, f64)> {
    let pixels = films.films[0].1.width * films.films[0].1.height;
    (0..pixels)
        .map(|pixel| {
            let kept = films.films.iter().filter(|(estimator, ..)| keep(*estimator));
            kept.fold((0.0, 0.0), |(value, variance), (_, film, _)| {
                let sum: f64 = (0..film.planes.len()).map(|plane| film.mean(pixel, plane).value).sum();
                (value + sum, variance + film.variance(pixel, film.planes.len()))
            })
        })
        .collect()
}

/// Mean over pixels with its standard error.
pub fn mean(image: &[(f64, f64)]) -> (f64, f64) {
    let n = image.len() as f64;
    let value: f64 = image.iter().map(|p| p.0).sum::<f64>() / n;
    let variance: f64 = image.iter().map(|p| p.1).sum::<f64>() / (n * n);
    (value, variance.sqrt())
}

/// z per block of pixels between two images of equal size.
pub fn block_z(a: &[(f64, f64)], b: &[(f64, f64)], width: usize, block: usize) -> Vec<f64> {
    let height = a.len() / width;
    let mut out = Vec::new();
    for by in (0..height).step_by(block) {
        for bx in (0..width).step_by(block) {
            let (mut difference, mut variance) = (0.0, 0.0);
            for y in by..(by + block).min(height) {
                for x in bx..(bx + block).min(width) {
                    let (p, q) = (a[y * width + x], b[y * width + x]);
                    difference += p.0 - q.0;
                    variance += p.1 + q.1;
                }
            }
            if variance > 0.0 {
                out.push(difference / variance.sqrt());
            }
        }
    }
    out
}

/// Largest |z|, and the bound it must keep for a family-wise error of `alpha` (Šidák).
pub fn worst_z(z: &[f64], alpha: f64) -> (f64, f64) {
    (z.iter().fold(0.0f64, |worst, z| worst.max(z.abs())), eyebox::base::stats::sidak_z(alpha, z.len()))
}
