//! Incoherent rays against a mesh: rays per CPU second on one thread, closest hit, on a bumpy ball of 1e5 and of 1e6
//! triangles and on the sample HUDs as triangles. Origins are uniform in the box of the mesh, directions on the sphere.
//! Run with `cargo bench --ignore-rust-version --bench rays`.
//!
//! `… -- --embree LIBRARY` traces the same rays beside it with Embree 4 through `rtcIntersect1`, batch by batch in turn;
//! the library lies in the PyPI package embreex (`embreex.libs/libembree4-*`).
//!
//! `… -- FOLDER` also writes what was traced there (`*.rays`: three little-endian u32 counts of vertices, triangles and
//! rays, then f32 vertices, u32 triangles, f32 rays as origin and direction), which `tests/python/embree_rays.py` gives to
//! Embree. Files named behind `--` are traced instead, `.rays` or assets.

use eyebox::base::ids::MeshId;
use eyebox::base::rng::{Rng, Stream};
use eyebox::base::warp;
use eyebox::import::{ImportOptions, import};
use eyebox::scene::{Eye, Face, FaceRange, Finish, Mesh, Part, Scene, Shape};
use eyebox::world::geometry::{Geometry, Ray};
use glam::{DAffine3, DVec3};
use std::borrow::Cow;
use std::f64::consts::PI;
use std::io::Write;
use std::path::Path;

#[path = "rays/embree.rs"]
mod embree;
use embree::{Embree, KINDS};

const RAYS: usize = 1_000_000;
/// Each batch of rays is timed this many times, the fastest counts: what else the machine does comes and goes.
const ROUNDS: usize = 7;
const BATCH: usize = 25_000;

/// What is traced: one mesh and rays as origin and direction.
struct Case {
    name: String,
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    rays: Vec<[f32; 6]>,
}

impl Case {
    fn new(name: &str, positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Case {
        let place = |p: &[f32; 3]| DVec3::from(p.map(f64::from));
        let lo = positions.iter().fold(DVec3::INFINITY, |a, p| a.min(place(p)));
        let hi = positions.iter().fold(DVec3::NEG_INFINITY, |a, p| a.max(place(p)));
        let mut rng = Rng::new(5, Stream::Check, 0, 0);
        let ray = |_| {
            let origin = lo + (hi - lo) * DVec3::new(rng.uniform(), rng.uniform(), rng.uniform());
            let dir = warp::sphere(rng.pair());
            [origin, dir].map(|v| v.as_vec3().to_array()).concat().try_into().expect("six numbers")
        };
        let rays = (0..RAYS).map(ray).collect();
        Case { name: name.into(), positions, triangles, rays }
    }

    /// A ball with bumps, of about so many triangles.
    fn ball(name: &str, triangles: f64) -> Case {
        let rings = (triangles / 4.0).sqrt() as u32;
        let around = 2 * rings;
        let mut positions = Vec::new();
        for ring in 0..=rings {
            for i in 0..around {
                let (theta, phi) =
                    (PI * f64::from(ring) / f64::from(rings), 2.0 * PI * f64::from(i) / f64::from(around));
                let r =
                    0.1 * (1.0 + 0.15 * (7.0 * theta).sin() * (9.0 * phi).cos() + 0.01 * (61.0 * (theta + phi)).sin());
                let (sin, cos) = theta.sin_cos();
                positions.push(DVec3::new(r * sin * phi.cos(), r * sin * phi.sin(), r * cos).as_vec3().to_array());
            }
        }
        let mut triangles = Vec::new();
        for ring in 0..rings {
            for i in 0..around {
                let (a, b) = (ring * around + i, ring * around + (i + 1) % around);
                let (c, d) = (a + around, b + around);
                triangles.extend([[a, c, d], [a, d, b]]);
            }
        }
        Case::new(name, positions, triangles)
    }

    /// All parts of an assembly as triangles in world metres.
    fn asset(path: &Path) -> Case {
        let scene = import(path, &ImportOptions::default()).expect("the asset imports").scene;
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for part in &scene.parts {
            let mesh = &scene.meshes[part.mesh.index()];
            let base = positions.len() as u32;
            let place = |p: &[f32; 3]| part.to_world.transform_point3(DVec3::from(p.map(f64::from)));
            positions.extend(mesh.positions.iter().map(|p| place(p).as_vec3().to_array()));
            for (range, _) in mesh.faces.iter().zip(&part.faces).filter(|(_, face)| face.finish != Finish::None) {
                triangles.extend(mesh.triangles[range.triangles()].iter().map(|t| t.map(|v| v + base)));
            }
        }
        let folder = path.parent().and_then(Path::file_name).unwrap_or_default().to_string_lossy();
        let name = if path.ends_with("hud.optics.toml") { folder } else { name_of(path) };
        Case::new(&name, positions, triangles)
    }

    fn write(&self, folder: &Path) -> std::io::Result<()> {
        let file = std::fs::File::create(folder.join(format!("{}.rays", self.name)))?;
        let mut file = std::io::BufWriter::new(file);
        for count in [self.positions.len(), self.triangles.len(), self.rays.len()] {
            file.write_all(&(count as u32).to_le_bytes())?;
        }
        self.positions.iter().flatten().try_for_each(|x| file.write_all(&x.to_le_bytes()))?;
        self.triangles.iter().flatten().try_for_each(|v| file.write_all(&v.to_le_bytes()))?;
        self.rays.iter().flatten().try_for_each(|x| file.write_all(&x.to_le_bytes()))?;
        file.flush()
    }

    fn read(path: &Path) -> Case {
        let bytes = std::fs::read(path).expect("the file is there");
        let mut words = bytes.chunks_exact(4).map(|w| <[u8; 4]>::try_from(w).expect("four bytes"));
        let mut word = || words.next().expect("the file is whole");
        let [vertices, triangles, rays] = [(); 3].map(|()| u32::from_le_bytes(word()));
        Case {
            name: name_of(path).into_owned(),
            positions: (0..vertices).map(|_| [(); 3].map(|()| f32::from_le_bytes(word()))).collect(),
            triangles: (0..triangles).map(|_| [(); 3].map(|()| u32::from_le_bytes(word()))).collect(),
            rays: (0..rays).map(|_| [(); 6].map(|()| f32::from_le_bytes(word()))).collect(),
        }
    }

    fn scene(&self) -> Scene {
        let faces = vec![FaceRange { first: 0, count: self.triangles.len() as u32 }];
        let mesh = Mesh {
            normals: vec![[0.0; 3]; self.positions.len()],
            positions: self.positions.clone(),
            triangles: self.triangles.clone(),
            faces,
            ..Mesh::default()
        };
        let face = Face {
            finish: Finish::Absorber,
            coating: None,
            shape: Shape::Mesh,
            emitter: None,
            tint: None,
            slide: None,
            sensor: None,
        };
        let part = Part {
            name: self.name.clone(),
            path: self.name.clone(),
            mesh: MeshId(0),
            to_world: DAffine3::IDENTITY,
            medium: None,
            priority: 0,
            materials: Vec::new(),
            film_in: None,
            faces: vec![face],
        };
        let eye = Eye {
            position: DVec3::from(self.positions[0].map(f64::from)),
            look: DVec3::Z,
            up: DVec3::Y,
            pupil_diameter_m: 0.0,
            adapts: false,
            limits: eyebox::scene::BinocularLimits::default(),
            focus_distance_m: f64::INFINITY,
            fov_deg: 20.0,
            resolution: [1, 1],
            age: 30.0,
        };
        Scene {
            surfaces: vec![],
            name: self.name.clone(),
            unit_m: 1.0,
            wavelengths: eyebox::scene::Wavelengths::Mono { nm: 555.0 },
            meshes: vec![mesh.into()],
            parts: vec![part],
            media: vec![],
            coatings: vec![],
            slides: vec![],
            scatters: vec![],
            wave_plates: vec![],
            gratings: vec![],
            groups: vec![],
            profiles: vec![],
            lights: vec![],
            sky: None,
            eye,
            notes: vec![],
            hash: String::new(),
        }
    }

    /// Traces it, and beside it with the Embree library at `embree`: rounds take turns.
    fn time(&self, embree: Option<&Path>) {
        let scene = self.scene();
        let start = cpu_seconds();
        let geometry = Geometry::build(&scene).expect("triangles can be traced");
        let build = cpu_seconds() - start;
        let vector = |v: &[f32]| DVec3::new(f64::from(v[0]), f64::from(v[1]), f64::from(v[2]));
        let origin = geometry.origin();
        let ray = |r: &[f32; 6]| Ray { origin: vector(&r[..3]) - origin, dir: vector(&r[3..]), from: None };
        let other = |kind| embree.map(|library| Embree::new(library, &self.positions, &self.triangles, kind));
        let others = KINDS.map(other);
        let (mut total, mut hits, mut sum) = ([0.0; 1 + KINDS.len()], [0; 1 + KINDS.len()], 0.0);
        for rays in self.rays.chunks(BATCH) {
            let mut best = [f64::INFINITY; 1 + KINDS.len()];
            for round in 0..ROUNDS {
                let mut met = [0; 1 + KINDS.len()];
                let start = cpu_seconds();
                for hit in rays.iter().filter_map(|r| geometry.intersect(&ray(r), f64::INFINITY)) {
                    met[0] += 1;
                    sum += if round == 0 { hit.t } else { 0.0 };
                }
                best[0] = best[0].min(cpu_seconds() - start);
                for (i, other) in (1..).zip(&others) {
                    if let Some(other) = other {
                        let start = cpu_seconds();
                        met[i] = rays.iter().filter(|ray| other.intersect(ray).is_finite()).count();
                        best[i] = best[i].min(cpu_seconds() - start);
                    }
                }
                if round == 0 {
                    hits.iter_mut().zip(met).for_each(|(all, met)| *all += met);
                }
            }
            total.iter_mut().zip(best).for_each(|(total, best)| *total += best);
        }
        let count = self.rays.len() as f64;
        println!(
            "{:12} {:8} triangles, build {build:.2} s: {:.3} Mrays/s, {:.0} ns a ray; {} hits, sum of t {sum:.6}",
            self.name,
            self.triangles.len(),
            count / total[0] * 1e-6,
            total[0] / count * 1e9,
            hits[0]
        );
        for (i, kind) in (1..).zip(KINDS).filter(|_| embree.is_some()) {
            println!(
                "{:12} Embree {kind:?}: {:.3} Mrays/s, {:.0} ns a ray; {} hits; we trace {:.3} times as many",
                "",
                count / total[i] * 1e-6,
                total[i] / count * 1e9,
                hits[i],
                total[i] / total[0]
            );
        }
    }
}

fn name_of(path: &Path) -> Cow<'_, str> {
    path.file_stem().unwrap_or_default().to_string_lossy()
}

/// CPU seconds of this thread where the system says them, else of the wall clock.
fn cpu_seconds() -> f64 {
    #[cfg(target_os = "linux")]
    {
        let now = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
        now.tv_sec as f64 + now.tv_nsec as f64 * 1e-9
    }
    #[cfg(not(target_os = "linux"))]
    {
        static START: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
        START.get_or_init(std::time::Instant::now).elapsed().as_secs_f64()
    }
}

fn main() {
    let mut named: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let asked = named.iter().position(|a| a == "--embree");
    let embree =
        asked.map(|at| named.drain(at..(at + 2).min(named.len())).next_back().expect("a path behind --embree"));
    let embree = embree.as_deref().map(Path::new);
    let (folders, files): (Vec<&Path>, Vec<&Path>) = named.iter().map(Path::new).partition(|path| path.is_dir());
    let is_asset = |file: &Path| file.extension().is_none_or(|end| end != "rays");
    let case = |file: &&Path| if is_asset(file) { Case::asset(file) } else { Case::read(file) };
    files.iter().for_each(|file| case(file).time(embree));
    if files.is_empty() {
        let sample = |name: &str| {
            let path = format!("samples/{name}/hud.optics.toml");
            Case::asset(&Path::new(env!("CARGO_MANIFEST_DIR")).join(path))
        };
        let cases = [Case::ball("ball-1e5", 1e5), Case::ball("ball-1e6", 1e6)];
        for case in cases.into_iter().chain(["hud-direct", "hud-diffuse"].map(sample)) {
            folders.iter().for_each(|folder| case.write(folder).expect("the folder can be written"));
            case.time(embree);
        }
    }
}
