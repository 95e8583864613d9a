//! Small scenes made in code.

use eyebox_base::Shared;
use eyebox_base::ids::{CoatingId, GroupId, MediumId, MeshId};
use eyebox_scene::{
    Absorption, Angular, Coating, CoatingLaw, Dispersion, Emitter, Eye, Face, FaceRange, FilmLayer, Finish, Group,
    Medium, Mesh, Part, Photometry, Scene, Shape, Sky, Wavelengths,
};
use glam::{DAffine3, DMat3, DVec3};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// An empty scene in metres at 550 nm: a pinhole eye at the origin looks along −z, `fov_deg` wide.
pub fn scene(fov_deg: f64, pixels: usize) -> Scene {
    Scene {
        name: "stress".to_owned(),
        unit_m: 1.0,
        wavelengths: Wavelengths::Mono { nm: 550.0 },
        meshes: Vec::new(),
        parts: Vec::new(),
        media: Vec::new(),
        coatings: Vec::new(),
        slides: Vec::new(),
        groups: Vec::new(),
        profiles: Vec::new(),
        scatters: Vec::new(),
        wave_plates: Vec::new(),
        gratings: Vec::new(),
        surfaces: Vec::new(),
        lights: Vec::new(),
        sky: None,
        eye: Eye {
            position: DVec3::ZERO,
            look: DVec3::NEG_Z,
            up: DVec3::Y,
            pupil_diameter_m: 0.0,
            adapts: false,
            limits: eyebox_scene::BinocularLimits::default(),
            focus_distance_m: f64::INFINITY,
            fov_deg,
            resolution: [pixels, pixels],
            age: 30.0,
        },
        notes: Vec::new(),
        hash: String::new(),
    }
}

/// Puts the eye at `from` with its view towards `to`.
pub fn look(scene: &mut Scene, from: DVec3, to: DVec3) {
    scene.eye.position = from;
    scene.eye.look = (to - from).normalize_or(DVec3::NEG_Z);
    scene.eye.up = scene.eye.look.any_orthonormal_vector();
}

/// A face of the triangles themselves.
pub fn face(finish: Finish) -> Face {
    Face { finish, coating: None, shape: Shape::Mesh, emitter: None, tint: None, slide: None, sensor: None }
}

/// A polished face that is exactly this.
pub fn polished(shape: Shape) -> Face {
    Face { shape, ..face(Finish::Polished) }
}

/// Takes everything and shines in front with this luminance, cd/m².
pub fn shining(group: GroupId, luminance: f64) -> Face {
    let photometry = Photometry::LuminanceCdM2(luminance);
    let emitter = Emitter {
        group,
        photometry,
        angular: Angular::Lambert,
        spectrum: None,
        polarisation: None,
        both_sides: false,
        pattern: None,
    };
    Face { emitter: Some(emitter), ..face(Finish::Absorber) }
}

/// One mesh face per polygon, as a fan, with flat normals.
pub fn mesh(polygons: &[Vec<DVec3>]) -> Mesh {
    let fan = |n: usize| (2..n as u32).map(|i| [0, i - 1, i]).collect::<Vec<_>>();
    mesh_of(polygons.iter().map(|polygon| (polygon.clone(), fan(polygon.len()))))
}

/// One flat mesh face per list of corners and triangles over them; the first three corners are not in line.
pub fn mesh_of(faces: impl IntoIterator<Item = Sheet>) -> Mesh {
    let mut mesh = Mesh { name: "mesh".to_owned(), ..Mesh::default() };
    for (corners, triangles) in faces {
        let normal = match corners.as_slice() {
            [a, b, c, ..] => (*b - *a).cross(*c - *a).normalize_or(DVec3::Z),
            _ => DVec3::Z,
        };
        let (base, first) = (mesh.positions.len() as u32, mesh.triangles.len() as u32);
        mesh.positions.extend(corners.iter().map(|p| p.as_vec3().to_array()));
        mesh.normals.extend(corners.iter().map(|_| normal.as_vec3().to_array()));
        mesh.triangles.extend(triangles.iter().map(|t| t.map(|v| v + base)));
        mesh.faces.push(FaceRange { first, count: triangles.len() as u32 });
    }
    mesh
}

/// A rectangle about `centre`, spanned by half sides `a` and `b`, facing a × b.
pub fn quad(centre: DVec3, a: DVec3, b: DVec3) -> Vec<DVec3> {
    vec![centre - a - b, centre + a - b, centre + a + b, centre - a + b]
}

/// The faces of a box about the origin, outwards: −x, +x, −y, +y, −z, +z.
pub fn cuboid(half: DVec3) -> Vec<Vec<DVec3>> {
    let (x, y, z) = (DVec3::X * half.x, DVec3::Y * half.y, DVec3::Z * half.z);
    vec![quad(-x, z, y), quad(x, y, z), quad(-y, x, z), quad(y, z, x), quad(-z, y, x), quad(z, x, y)]
}

/// Corners, and triangles over them.
pub type Sheet = (Vec<DVec3>, Vec<[u32; 3]>);

/// One face of a body of revolution about z, with the height `sag(r)` over the plane at `z`, up to the distance `edge`
/// from the axis; it faces +z or −z.
pub fn cap(z: f64, sag: impl Fn(f64) -> f64, edge: f64, faces_up: bool, [rings, sectors]: [usize; 2]) -> Sheet {
    let mut corners = vec![DVec3::new(0.0, 0.0, z)];
    for ring in 1..=rings {
        let r = edge * ring as f64 / rings as f64;
        corners.extend((0..sectors).map(|j| {
            let (sin, cos) = (TAU * j as f64 / sectors as f64).sin_cos();
            DVec3::new(r * cos, r * sin, z + sag(r))
        }));
    }
    let at = |ring: usize, j: usize| if ring == 0 { 0 } else { (1 + (ring - 1) * sectors + j % sectors) as u32 };
    let mut triangles = Vec::new();
    for ring in 0..rings {
        for j in 0..sectors {
            let (a, b, c, d) = (at(ring, j), at(ring + 1, j), at(ring + 1, j + 1), at(ring, j + 1));
            triangles.push([a, b, c]);
            if ring > 0 {
                triangles.push([a, c, d]);
            }
        }
    }
    if !faces_up {
        triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    (corners, triangles)
}

/// The height of a sphere of this signed radius over the plane of its vertex; 0 if the radius is infinite.
pub fn sag_of_sphere(radius: f64, r: f64) -> f64 {
    let c = 1.0 / radius;
    c * r * r / (1.0 + (1.0 - c * c * r * r).sqrt())
}

/// The wall between two caps of equal edge, `low` facing −z.
pub fn wall(low: &[DVec3], high: &[DVec3], sectors: usize) -> Sheet {
    let ring = |cap: &[DVec3]| cap[cap.len() - sectors..].to_vec();
    let corners = [ring(low), ring(high)].concat();
    let n = sectors as u32;
    let triangles = (0..n).flat_map(|j| {
        let k = (j + 1) % n;
        [[j, k, n + k], [j, n + k, n + j]]
    });
    let triangles = triangles.collect();
    (corners, triangles)
}

/// A closed sphere about the origin as one face of triangles.
pub fn sphere(radius: f64, rings: usize, sectors: usize) -> Mesh {
    let place = |i: usize, j: usize| {
        let (sin, cos) = (PI * i as f64 / rings as f64).sin_cos();
        let (y, x) = (TAU * j as f64 / sectors as f64).sin_cos();
        DVec3::new(sin * x, sin * y, cos)
    };
    let corners: Vec<DVec3> = (0..=rings).flat_map(|i| (0..sectors).map(move |j| place(i, j))).collect();
    let at = |i: usize, j: usize| (i * sectors + j % sectors) as u32;
    let triangles = (0..rings).flat_map(|i| {
        (0..sectors).flat_map(move |j| {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            let upper = (i + 1 < rings).then_some([a, b, c]);
            let lower = (i > 0).then_some([a, c, d]);
            upper.into_iter().chain(lower)
        })
    });
    let mut mesh = mesh_of([(corners.iter().map(|p| *p * radius).collect(), triangles.collect())]);
    mesh.normals = corners.iter().map(|p| p.as_vec3().to_array()).collect();
    mesh
}

/// The exact surface of [`sphere`].
pub fn ball(radius: f64) -> Shape {
    Shape::Sphere { vertex: DVec3::new(0.0, 0.0, -radius), axis: DVec3::Z, radius }
}

/// Adds a part at `to_world`, filled with a medium of this index if there is one.
pub fn add(
    scene: &mut Scene,
    mesh: impl Into<Shared<Mesh>>,
    to_world: DAffine3,
    index: Option<f64>,
    faces: Vec<Face>,
) -> usize {
    let name = format!("part{}", scene.parts.len());
    let id = MeshId::from_index(scene.meshes.len());
    scene.meshes.push(mesh.into());
    let medium = index.map(|n| {
        let (name, index) = (format!("n={n}"), Dispersion::Constant(n));
        scene.media.push(Medium { name, index, absorption: Absorption::NONE });
        MediumId::from_index(scene.media.len() - 1)
    });
    scene.parts.push(Part {
        path: name.clone(),
        name,
        mesh: id,
        to_world,
        medium,
        priority: 0,
        faces,
        materials: Vec::new(),
        film_in: None,
    });
    scene.parts.len() - 1
}

/// Adds a light group.
pub fn group(scene: &mut Scene, name: &str) -> GroupId {
    scene.groups.push(Group { name: name.to_owned() });
    GroupId::from_index(scene.groups.len() - 1)
}

/// Adds a rectangle that shines towards a × b with this luminance, cd/m².
pub fn panel(scene: &mut Scene, luminance: f64, corners: Vec<DVec3>) -> usize {
    let group = group(scene, "panel");
    add(scene, mesh(&[corners]), DAffine3::IDENTITY, None, vec![shining(group, luminance)])
}

/// A sky of these pixels, cd/m², in the place of the one that was there.
pub fn sky(scene: &mut Scene, width: usize, height: usize, luminance: Vec<f32>) {
    let before = scene.sky.take().map(|sky| sky.group);
    let group = before.unwrap_or_else(|| group(scene, "sky"));
    let (luminance, file) = (Arc::new(luminance), "made in code".to_owned());
    scene.sky = Some(Sky { group, width, height, luminance, rgb: None, to_world: DMat3::IDENTITY, file });
}

/// Adds a coating of one film.
pub fn film(scene: &mut Scene, index: Dispersion, thickness_nm: f64) -> CoatingId {
    scene
        .coatings
        .push(Coating { name: "film".to_owned(), law: CoatingLaw::Stack(vec![FilmLayer { index, thickness_nm }]) });
    CoatingId::from_index(scene.coatings.len() - 1)
}
