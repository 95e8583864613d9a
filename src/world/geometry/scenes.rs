//! Assemblies for tests.

use super::local_ray::Touch;
use super::{Geometry, Hit, Ray, Site};
use eyebox_base::ids::{GroupId, MediumId, MeshId};
use eyebox_base::rng::Rng;
use eyebox_base::warp;
use eyebox_scene::{
    Absorption, Angular, Dispersion, Emitter, Eye, Face, FaceRange, Finish, Medium, Mesh, Part, Photometry, Scene,
    Shape, Wavelengths,
};
use glam::{DAffine3, DVec3};
use std::f64::consts::PI;

/// A mesh from faces, each a list of triangles over its own vertices.
#[derive(Default)]
pub struct Builder {
    pub mesh: Mesh,
}

impl Builder {
    pub fn face(&mut self, vertices: &[(DVec3, DVec3)], triangles: &[[u32; 3]]) -> &mut Self {
        let base = self.mesh.positions.len() as u32;
        for (p, n) in vertices {
            self.mesh.positions.push(p.as_vec3().to_array());
            self.mesh.normals.push(n.as_vec3().to_array());
        }
        let first = self.mesh.triangles.len() as u32;
        self.mesh.triangles.extend(triangles.iter().map(|t| t.map(|v| v + base)));
        self.mesh.faces.push(FaceRange { first, count: triangles.len() as u32 });
        self
    }

    /// A surface of revolution about z: rings of (r, z, slope of the outward normal as a vector in the rz-plane), from
    /// pole or edge to edge, wound so that the normals (nr, nz) are outward for a profile that runs with the solid on
    /// its left seen with r to the right and z up.
    pub fn revolve(&mut self, profile: &[[f64; 4]], around: u32, centre: DVec3) -> &mut Self {
        let mut vertices = Vec::new();
        for [r, z, nr, nz] in profile {
            for i in 0..around {
                let phi = 2.0 * PI * (f64::from(i) + 0.3) / f64::from(around);
                let (sin, cos) = phi.sin_cos();
                vertices.push((centre + DVec3::new(r * cos, r * sin, *z), DVec3::new(nr * cos, nr * sin, *nz)));
            }
        }
        let mut triangles = Vec::new();
        for ring in 1..profile.len() as u32 {
            for i in 0..around {
                let (a, b) = ((ring - 1) * around + i, (ring - 1) * around + (i + 1) % around);
                let (c, d) = (a + around, b + around);
                triangles.extend([[a, b, d], [a, d, c]]);
            }
        }
        self.face(&vertices, &triangles)
    }
}

/// A closed sphere of one face, south pole to north; the triangles at the poles that have no area are kept.
pub fn sphere(radius: f64, rings: u32, around: u32, centre: DVec3) -> Mesh {
    let profile: Vec<[f64; 4]> = (0..=rings)
        .map(|i| {
            let (mut r, z) = (PI * f64::from(i) / f64::from(rings)).sin_cos();
            if i == 0 || i == rings {
                r = 0.0;
            }
            [radius * r, -radius * z, r, -z]
        })
        .collect();
    let mut builder = Builder::default();
    builder.revolve(&profile, around, centre);
    builder.mesh
}

/// The exact surface of [`sphere`], from its south pole.
pub fn sphere_shape(radius: f64, centre: DVec3) -> Shape {
    Shape::Sphere { vertex: centre - DVec3::Z * radius, axis: DVec3::Z, radius }
}

/// A lens along z, mm: entry cap, rim, exit cap; radii as in `Shape`.
pub fn lens(
    radii: [f64; 2],
    conic: [f64; 2],
    aperture: f64,
    thickness: f64,
    rings: u32,
    around: u32,
) -> (Mesh, Vec<Shape>) {
    let shapes: Vec<Shape> = [0, 1]
        .map(|i| Shape::Conic {
            vertex: DVec3::Z * (thickness * i as f64),
            axis: DVec3::Z,
            radius: radii[i],
            conic: conic[i],
        })
        .to_vec();
    let ring = |i: u32, shape: &Shape, sign: f64| {
        let q = super::exact::Quadric::from_shape(shape).expect("a lens");
        let r = aperture * f64::from(i) / f64::from(rings);
        let p = q.vertex + DVec3::new(r, 0.0, q.sag(r * r));
        let n = sign * q.normal(p);
        [r, p.z, n.x, n.z]
    };
    let front: Vec<[f64; 4]> = (0..=rings).map(|i| ring(i, &shapes[0], -1.0)).collect();
    let back: Vec<[f64; 4]> = (0..=rings).rev().map(|i| ring(i, &shapes[1], 1.0)).collect();
    let (edge, other) = (front[rings as usize], back[0]);
    let rim = [[edge[0], edge[1], 1.0, 0.0], [other[0], other[1], 1.0, 0.0]];
    let mut builder = Builder::default();
    builder.revolve(&front, around, DVec3::ZERO).revolve(&rim, around, DVec3::ZERO).revolve(&back, around, DVec3::ZERO);
    (builder.mesh, vec![shapes[0].clone(), Shape::Mesh, shapes[1].clone()])
}

/// Nine coarse caps of conics with leaning axes: more exact faces than are looked up in grids.
pub fn lenslets() -> (Mesh, Vec<Shape>) {
    let mut builder = Builder::default();
    let mut shapes = Vec::new();
    for i in 0..9u32 {
        let (radius, conic) = (if i % 2 == 0 { 5.0 } else { -6.0 } - 0.3 * f64::from(i), 0.6 * f64::from(i) - 3.0);
        let vertex = DVec3::new(f64::from(i % 3) * 6.0 - 6.0, f64::from(i / 3) * 6.0 - 6.0, 0.2 * f64::from(i));
        let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.2 * f64::from(i % 4) - 0.3, 0.1 * f64::from(i), 0.0);
        let shape = Shape::Conic { vertex, axis: turn * DVec3::Z, radius, conic };
        let q = super::exact::Quadric::from_shape(&shape).expect("a cap");
        let ring = |k: u32| {
            let r = 0.5 * f64::from(k);
            [r, q.sag(r * r), 0.0, 1.0]
        };
        builder.revolve(&[ring(3), ring(2), ring(1), ring(0)], 7, DVec3::ZERO);
        let first = builder.mesh.positions.len() - 28;
        for p in &mut builder.mesh.positions[first..] {
            *p = (vertex + turn * super::patch::vertex(*p)).as_vec3().to_array();
        }
        shapes.push(shape);
    }
    (builder.mesh, shapes)
}

/// A box with one flat face per side: −x, +x, −y, +y, −z, +z.
pub fn cuboid(lo: DVec3, hi: DVec3) -> Mesh {
    let mut builder = Builder::default();
    for axis in 0..3 {
        for side in 0..2 {
            let mut corner = [lo, hi][side];
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let mut normal = DVec3::ZERO;
            normal[axis] = [-1.0, 1.0][side];
            let mut vertices = Vec::new();
            for (a, b) in [(0, 0), (1, 0), (1, 1), (0, 1)] {
                corner[u] = [lo, hi][a][u];
                corner[v] = [lo, hi][b][v];
                vertices.push((corner, normal));
            }
            let triangles = if side == 1 { [[0, 1, 2], [0, 2, 3]] } else { [[0, 2, 1], [0, 3, 2]] };
            builder.face(&vertices, &triangles);
        }
    }
    builder.mesh
}

pub fn emitter() -> Emitter {
    Emitter {
        group: GroupId(0),
        photometry: Photometry::FluxLm(1.0),
        angular: Angular::Lambert,
        spectrum: None,
        polarisation: None,
        both_sides: false,
        pattern: None,
    }
}

/// A solid with a medium.
pub fn part(mesh: u32, shapes: &[Shape], to_world: DAffine3) -> Part {
    let face = |shape: &Shape| Face {
        finish: Finish::Polished,
        coating: None,
        shape: shape.clone(),
        emitter: None,
        tint: None,
        slide: None,
        sensor: None,
    };
    Part {
        name: format!("P{mesh}"),
        path: format!("TEST/P{mesh}"),
        mesh: MeshId(mesh),
        to_world,
        medium: Some(MediumId(0)),
        priority: 0,
        materials: Vec::new(),
        film_in: None,
        faces: shapes.iter().map(face).collect(),
    }
}

/// Adds a square about the z axis of `to_world`, `half` its side, in the plane `z`, whose face has its normal along `towards` (±z)
/// and this finish.
pub fn add_square(scene: &mut Scene, (half, z, towards): (f64, f64, DVec3), finish: Finish, to_world: DAffine3) {
    let up = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let corner = |[x, y]: [f64; 2]| (DVec3::new(half * x, half * y, z), towards);
    let triangles = if towards.z < 0.0 { [[0, 2, 1], [0, 3, 2]] } else { [[0, 1, 2], [0, 2, 3]] };
    let mut builder = Builder::default();
    builder.face(&up.map(corner), &triangles);
    scene.meshes.push(builder.mesh.into());
    let mut part = part(scene.meshes.len() as u32 - 1, &[Shape::Mesh], to_world);
    part.medium = None;
    part.faces =
        vec![Face { finish, coating: None, shape: Shape::Mesh, emitter: None, tint: None, slide: None, sensor: None }];
    scene.parts.push(part);
}

pub fn scene(meshes: Vec<Mesh>, parts: Vec<Part>) -> Scene {
    Scene {
        name: "TEST".into(),
        unit_m: 1e-3,
        wavelengths: Wavelengths::Visible,
        meshes: meshes.into_iter().map(Into::into).collect(),
        parts,
        media: vec![Medium {
            name: "glass".into(),
            index: Dispersion::Constant(1.5),
            absorption: Absorption::Constant(0.0),
        }],
        coatings: vec![],
        slides: vec![],
        scatters: vec![],
        wave_plates: vec![],
        gratings: vec![],
        surfaces: vec![],
        profiles: Vec::new(),
        groups: vec![],
        lights: Vec::new(),
        sky: None,
        eye: Eye {
            position: DVec3::ZERO,
            look: DVec3::Z,
            up: DVec3::Y,
            pupil_diameter_m: 0.0,
            adapts: false,
            limits: eyebox_scene::BinocularLimits::default(),
            focus_distance_m: f64::INFINITY,
            fov_deg: 10.0,
            resolution: [4, 4],
            age: 30.0,
        },
        notes: vec![],
        hash: String::new(),
    }
}

/// One part in millimetres at the origin.
pub fn alone(mesh: Mesh, shapes: &[Shape]) -> Geometry {
    let mm = DAffine3::from_scale(DVec3::splat(1e-3));
    Geometry::build(&scene(vec![mesh], vec![part(0, shapes, mm)])).expect("a valid scene")
}

/// Lenses, balls, plates and boxes, some turned, scaled, mirrored or stretched, `place` applied to all.
pub fn assembly(place: DAffine3) -> Scene {
    let mm = DAffine3::from_scale(DVec3::splat(1e-3));
    let (biconvex, biconvex_shapes) = lens([50.0, -40.0], [0.0, -0.6], 15.0, 8.0, 6, 24);
    let (meniscus, meniscus_shapes) = lens([-30.0, -20.0], [-1.5, 0.3], 10.0, 4.0, 5, 16);
    let ball = sphere(7.0, 8, 12, DVec3::new(1.0, 2.0, 3.0));
    let (lenslets, lenslet_shapes) = lenslets();
    let plate = cuboid(DVec3::new(-20.0, -15.0, 0.0), DVec3::new(20.0, 15.0, 2.0));
    let flat = |z: f64| Shape::Plane { vertex: DVec3::Z * z, axis: DVec3::Z };
    let mut plate_shapes = vec![Shape::Mesh; 4];
    plate_shapes.extend([flat(0.0), flat(2.0)]);
    let at = |x: f64, y: f64, z: f64| DAffine3::from_translation(DVec3::new(x, y, z));
    let turn = |a: f64| DAffine3::from_axis_angle(DVec3::new(0.6, 0.48, 0.64), a);
    let mirror = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let stretch = DAffine3::from_scale(DVec3::new(1.0, 0.5, 2.0));
    let ball_shape = [sphere_shape(7.0, DVec3::new(1.0, 2.0, 3.0))];
    let parts = vec![
        part(0, &biconvex_shapes, place * at(0.0, 0.0, 0.05) * mm),
        part(0, &biconvex_shapes, place * at(0.03, 0.01, 0.07) * turn(0.7) * mirror * mm),
        part(1, &meniscus_shapes, place * at(-0.02, 0.0, 0.08) * turn(2.0) * mm),
        part(2, &ball_shape, place * at(0.0, 0.03, 0.06) * turn(1.0) * mm),
        part(2, &[Shape::Mesh], place * at(0.0, -0.03, 0.06) * turn(0.3) * stretch * mm),
        part(3, &plate_shapes, place * at(0.0, 0.0, 0.1) * turn(-0.5) * mm),
        part(4, &lenslet_shapes, place * at(-0.03, 0.03, 0.05) * turn(1.5) * mm),
        part(3, &vec![Shape::Mesh; 6], place * at(0.0, 0.0, 0.03) * turn(0.2) * mm * stretch),
    ];
    let mut scene = scene(vec![biconvex, meniscus, ball, plate, lenslets], parts);
    scene.eye.position = place.transform_point3(DVec3::ZERO);
    scene
}

/// A ray through the bounds of a geometry, from inside them or from up to ten times as far.
pub fn random_ray(geometry: &Geometry, rng: &mut Rng) -> Ray {
    let (lo, hi) = geometry.bounds();
    let mut point = || lo + (hi - lo) * DVec3::new(rng.uniform(), rng.uniform(), rng.uniform());
    let (origin, aim) = (point(), point());
    let dir = (aim - origin).normalize_or(DVec3::X);
    let back = if rng.uniform() < 0.5 { 10.0 * rng.uniform() * (hi - lo).length() } else { 0.0 };
    let dir = if rng.uniform() < 0.1 { warp::sphere([0.0, 0.0]) } else { dir };
    Ray { origin: origin - back * dir, dir, from: None }
}

impl Geometry {
    /// [`Geometry::intersect`] without trees: every triangle of every part is tried.
    pub fn intersect_all(&self, ray: &Ray, t_max: f64) -> Option<Hit> {
        let mut best: Option<(usize, Touch, f64)> = None;
        for (i, instance) in self.instances.iter().enumerate() {
            let reach = best.as_ref().map_or(t_max, |b| b.2);
            if let Some((touch, t)) = instance.nearest_of_all(&self.solids[instance.solid], ray, reach) {
                best = Some((i, touch, t));
            }
        }
        let (i, touch, t) = best?;
        self.instances[i].hit(&self.solids[self.instances[i].solid], &touch, t)
    }

    /// A ray that goes on from a hit.
    pub fn onwards(&self, hit: &Hit, dir: DVec3) -> Ray {
        Ray { origin: hit.point, dir, from: Some(hit.site) }
    }

    /// World position of a vertex of a triangle.
    pub fn corner(&self, scene: &Scene, site: Site, which: usize) -> DVec3 {
        let mesh = scene.mesh(scene.parts[site.part as usize].mesh);
        let v = mesh.triangles[site.triangle as usize][which];
        self.part_to_world(site.part).transform_point3(super::patch::vertex(mesh.positions[v as usize]))
    }
}
