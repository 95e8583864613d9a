//! A good small asset made in code, as a .gltf with a buffer, a sidecar, a slide and a photometric file: an eye looks
//! through a lens and two plates at a slide with a lamp behind it; another lamp stands beside the lens. Millimetres.

use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

type Face = (Vec<[f32; 3]>, Vec<[f32; 3]>, Vec<[u32; 3]>);

/// The asset, to be changed before it is written.
pub struct Bench {
    pub gltf: Value,
    pub sheet: String,
    /// Beside them: the buffer `bench.bin`, `slide.png`, `lamp.ies`.
    pub files: BTreeMap<String, Vec<u8>>,
}

pub const SHEET: &str = r#"schema = 1
asset = "bench.gltf"
unit = 0.001
wavelengths = { mono_nm = 550 }

[default]
finish = "absorber"

[coating.ar]
stack = [{ n = 1.38, thickness_nm = 99.6 }]

[coating.half]
ideal = { R = 0.5, T = 0.5 }

[[bind]]
path = "LENS"
glass = "N-BK7"

[[bind]]
path = "LENS"
faces = [0]
finish = "polished"
shape = { kind = "sphere", vertex = [0, 0, 4], axis = [0, 0, 1], radius = -60 }

[[bind]]
path = "LENS"
normal = "-z"
finish = "polished"

[[bind]]
path = "PLATE_A"
glass = "N-BK7"

[[bind]]
path = "PLATE_B"
glass = "PMMA"

[[bind]]
path = "PLATE_*"
normal = "+z"
finish = "polished"

[[bind]]
path = "PLATE_*"
normal = "-z"
finish = "polished"

[[bind]]
path = "PLATE_A"
normal = "-z"
coating = "ar"

[[bind]]
path = "PLATE_A"
normal = "+z"
coating = "half"

[[bind]]
path = "LCD"
finish = "none"

[[bind]]
path = "LCD"
normal = "+z"
slide = { image = "slide.png", size = [24, 24], u = [1, 0, 0], v = [0, 1, 0], transmittance = 0.9, contrast = 300 }

[[bind]]
path = "LED"
faces = [5]
emitter = { group = "led", luminance_cd_m2 = 5000, angular = "lambert", spectrum = "led_b1" }

[[bind]]
path = "LAMP"
normal = "+z"
emitter = { group = "lamp", angular = { kind = "profile", file = "lamp.ies" }, spectrum = "D65" }

[eye]
frame = "asset"
position = ["0 mm", "0 mm", "0 mm"]
look = [0, 0, -1]
up = [0, 1, 0]
pupil_diameter = "4 mm"
focus_distance = "inf"
fov_deg = 40
resolution = [32, 32]
age = 30
"#;

pub const IES: &str = "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 3 1 1 2 0 0 0\n1 1 5\n0 45 90\n0\n10 7 0\n";

/// Faces −x, +x, −y, +y, −z, +z of a box about its origin.
fn cuboid(half: [f32; 3]) -> Vec<Face> {
    let mut faces = Vec::new();
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for side in [-1.0f32, 1.0] {
            let (mut positions, mut normal) = (Vec::new(), [0.0; 3]);
            normal[axis] = side;
            for (a, b) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                let mut corner = [0.0; 3];
                (corner[axis], corner[u], corner[v]) = (side * half[axis], a * half[u], b * half[v]);
                positions.push(corner);
            }
            let triangles = if side > 0.0 { vec![[0, 1, 2], [0, 2, 3]] } else { vec![[0, 2, 1], [0, 3, 2]] };
            faces.push((positions, vec![normal; 4], triangles));
        }
    }
    faces
}

/// A plano-convex lens: a cap of radius 60 about z = −56 with its pole at z = 4, a rim of radius 10, a plane z = 0.
fn lens() -> Vec<Face> {
    const SECTORS: u32 = 24;
    const RINGS: u32 = 3;
    let circle = |i: u32| (f64::from(i) / f64::from(SECTORS) * std::f64::consts::TAU).sin_cos();
    let height = |r: f64| (3600.0 - r * r).sqrt() - 56.0;
    let at = |r: f64, i: u32, z: f64| [(r * circle(i).1) as f32, (r * circle(i).0) as f32, z as f32];
    let (mut cap, mut cap_normals, mut cap_triangles) = (vec![[0.0, 0.0, 4.0]], vec![[0.0, 0.0, 1.0]], Vec::new());
    for ring in 1..=RINGS {
        let r = 10.0 * f64::from(ring) / f64::from(RINGS);
        for i in 0..SECTORS {
            cap.push(at(r, i, height(r)));
            let n = [r * circle(i).1 / 60.0, r * circle(i).0 / 60.0, (height(r) + 56.0) / 60.0];
            cap_normals.push(n.map(|x| x as f32));
            let (j, own) = ((i + 1) % SECTORS, 1 + (ring - 1) * SECTORS);
            if ring == 1 {
                cap_triangles.push([0, own + i, own + j]);
            } else {
                let inner = own - SECTORS;
                cap_triangles.extend([[inner + i, own + i, own + j], [inner + i, own + j, inner + j]]);
            }
        }
    }
    let (mut rim, mut rim_normals, mut rim_triangles) = (Vec::new(), Vec::new(), Vec::new());
    let (mut back, mut back_triangles) = (vec![[0.0; 3]], Vec::new());
    for i in 0..SECTORS {
        let j = (i + 1) % SECTORS;
        rim.extend([at(10.0, i, 0.0), at(10.0, i, height(10.0))]);
        rim_normals.extend([[circle(i).1 as f32, circle(i).0 as f32, 0.0]; 2]);
        rim_triangles.extend([[2 * i, 2 * j, 2 * j + 1], [2 * i, 2 * j + 1, 2 * i + 1]]);
        back.push(at(10.0, i, 0.0));
        back_triangles.push([0, 1 + j, 1 + i]);
    }
    let back_normals = vec![[0.0, 0.0, -1.0]; back.len()];
    vec![(cap, cap_normals, cap_triangles), (rim, rim_normals, rim_triangles), (back, back_normals, back_triangles)]
}

impl Bench {
    pub fn new() -> Bench {
        let parts = [
            ("LENS", lens(), [0.0, 0.0, -80.0], 0),
            ("PLATE_A", cuboid([12.0, 12.0, 1.5]), [0.0, 0.0, -100.0], 0),
            ("PLATE_B", cuboid([12.0, 12.0, 1.5]), [0.0, 0.0, -104.0], 0),
            ("LCD", cuboid([12.0, 12.0, 0.25]), [0.0, 0.0, -130.0], 2),
            ("LED", cuboid([20.0, 20.0, 0.5]), [0.0, 0.0, -150.0], 1),
            ("LAMP", cuboid([1.0, 1.0, 0.5]), [13.0, 0.0, -50.0], 1),
            ("BAFFLE", cuboid([30.0, 30.0, 0.5]), [80.0, 0.0, -140.0], 2),
            ("STOP", cuboid([5.0, 5.0, 0.5]), [-80.0, 0.0, -140.0], 2),
        ];
        let (mut bin, mut views, mut accessors) = (Vec::new(), Vec::new(), Vec::new());
        let (mut meshes, mut nodes) = (Vec::new(), vec![json!({ "name": "BENCH", "children": [] })]);
        for (index, (name, faces, place, material)) in parts.into_iter().enumerate() {
            let primitives: Vec<Value> = faces
                .into_iter()
                .map(|(positions, normals, triangles)| {
                    let mut put = |bytes: Vec<u8>, count: usize, component: u32, kind: &str| {
                        views.push(json!({ "buffer": 0, "byteOffset": bin.len(), "byteLength": bytes.len() }));
                        bin.extend(bytes);
                        let view = views.len() - 1;
                        accessors.push(json!({ "bufferView": view, "componentType": component, "count": count, "type": kind }));
                        accessors.len() - 1
                    };
                    let floats = |all: &[[f32; 3]]| all.iter().flatten().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
                    let count = positions.len();
                    let low = |axis: usize| positions.iter().map(|p| p[axis]).fold(f32::INFINITY, f32::min);
                    let high = |axis: usize| positions.iter().map(|p| p[axis]).fold(f32::NEG_INFINITY, f32::max);
                    let (least, most) = ([low(0), low(1), low(2)], [high(0), high(1), high(2)]);
                    let position = put(floats(&positions), count, 5126, "VEC3");
                    let normal = put(floats(&normals), count, 5126, "VEC3");
                    let indices = triangles.iter().flatten().flat_map(|i| i.to_le_bytes()).collect();
                    let indices = put(indices, 3 * triangles.len(), 5125, "SCALAR");
                    accessors[position]["min"] = json!(least);
                    accessors[position]["max"] = json!(most);
                    json!({ "attributes": { "POSITION": position, "NORMAL": normal }, "indices": indices, "material": material })
                })
                .collect();
            meshes.push(json!({ "name": name, "primitives": primitives }));
            nodes.push(json!({ "name": name, "mesh": index, "translation": place }));
            nodes[0]["children"].as_array_mut().unwrap().push(json!(index + 1));
        }
        let gltf = json!({
            "asset": { "version": "2.0" },
            "scene": 0,
            "scenes": [{ "nodes": [0] }],
            "nodes": nodes,
            "meshes": meshes,
            "materials": [{ "name": "GLASS" }, { "name": "DIE" }, { "name": "BLACK" }],
            "accessors": accessors,
            "bufferViews": views,
            "buffers": [{ "uri": "bench.bin", "byteLength": bin.len() }],
        });
        let mut png = std::io::Cursor::new(Vec::new());
        image::GrayImage::from_pixel(8, 8, image::Luma([255])).write_to(&mut png, image::ImageFormat::Png).unwrap();
        let files = BTreeMap::from([
            ("bench.bin".to_owned(), bin),
            ("slide.png".to_owned(), png.into_inner()),
            ("lamp.ies".to_owned(), IES.as_bytes().to_vec()),
        ]);
        Bench { gltf, sheet: SHEET.to_owned(), files }
    }

    /// Replaces a text of the sidecar, which must be there.
    pub fn swap(&mut self, from: &str, to: &str) {
        assert!(self.sheet.contains(from), "{from} is not in the sidecar");
        self.sheet = self.sheet.replacen(from, to, 1);
    }

    pub fn append(&mut self, text: &str) {
        self.sheet += text;
    }

    /// The node of a part.
    pub fn node(&mut self, name: &str) -> &mut Value {
        let nodes = self.gltf["nodes"].as_array_mut().unwrap();
        nodes.iter_mut().find(|node| node["name"] == name).unwrap()
    }

    pub fn shift(&mut self, name: &str, axis: usize, to: f64) {
        self.node(name)["translation"][axis] = json!(to);
    }

    /// The bytes behind `POSITION`, `NORMAL` or `indices` of a face.
    pub fn data(&mut self, part: &str, face: usize, what: &str) -> &mut [u8] {
        let mesh = self.gltf["meshes"].as_array().unwrap().iter().find(|mesh| mesh["name"] == part).unwrap();
        let primitive = &mesh["primitives"][face];
        let accessor = if what == "indices" { &primitive["indices"] } else { &primitive["attributes"][what] };
        let view = &self.gltf["accessors"][accessor.as_u64().unwrap() as usize]["bufferView"];
        let view = &self.gltf["bufferViews"][view.as_u64().unwrap() as usize];
        let (start, length) =
            (view["byteOffset"].as_u64().unwrap() as usize, view["byteLength"].as_u64().unwrap() as usize);
        &mut self.files.get_mut("bench.bin").unwrap()[start..start + length]
    }

    /// Changes the floats behind an attribute.
    pub fn floats(&mut self, part: &str, face: usize, what: &str, change: impl Fn(usize, f32) -> f32) {
        for (index, four) in self.data(part, face, what).chunks_exact_mut(4).enumerate() {
            let x = f32::from_le_bytes(four.try_into().unwrap());
            four.copy_from_slice(&change(index, x).to_le_bytes());
        }
    }

    /// Writes everything into a folder; returns the sidecar.
    pub fn write(&self, folder: &Path) -> PathBuf {
        for (name, bytes) in &self.files {
            std::fs::write(folder.join(name), bytes).unwrap();
        }
        std::fs::write(folder.join("bench.gltf"), serde_json::to_string_pretty(&self.gltf).unwrap()).unwrap();
        let sheet = folder.join("bench.optics.toml");
        std::fs::write(&sheet, &self.sheet).unwrap();
        sheet
    }
}
