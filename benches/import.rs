//! What import costs: a `.glb` of two million triangles to a scene, against the `gltf` crate's reading of the same arrays,
//! with the most memory that was held at a time. Run with `cargo bench --ignore-rust-version --bench import`; with files
//! named behind `--`, those are imported instead (tests/interchange/usd_speed.py makes some and compares with usd-core).

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// Counts the bytes that are held.
struct Counting;
static HELD: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every call is passed on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let held = HELD.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
        PEAK.fetch_max(held, Ordering::Relaxed);
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size(), Ordering::Relaxed);
        unsafe { System.dealloc(pointer, layout) }
    }
}
#[global_allocator]
static COUNTING: Counting = Counting;

/// A paraboloid of `side`² quads with normals, 32-bit indices; one primitive.
fn asset(side: u32) -> Vec<u8> {
    let vertices = (side + 1) * (side + 1);
    let mut bin = Vec::new();
    let at = |i: u32| f64::from(i) / f64::from(side) - 0.5;
    let grid = || (0..=side).flat_map(|j| (0..=side).map(move |i| (i, j)));
    for (i, j) in grid() {
        let (x, y) = (at(i), at(j));
        for c in [x, y, (x * x + y * y) / 2.0] {
            bin.extend_from_slice(&(c as f32).to_le_bytes());
        }
    }
    for (i, j) in grid() {
        let normal = glam::DVec3::new(-at(i), -at(j), 1.0).normalize();
        for c in normal.to_array() {
            bin.extend_from_slice(&(c as f32).to_le_bytes());
        }
    }
    for j in 0..side {
        for i in 0..side {
            let a = j * (side + 1) + i;
            for v in [a, a + 1, a + side + 2, a, a + side + 2, a + side + 1] {
                bin.extend_from_slice(&v.to_le_bytes());
            }
        }
    }
    let (block, corners) = (vertices * 12, side * side * 6);
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"name":"GRID","mesh":0}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"NORMAL":1}},"indices":2}}]}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":{vertices},"type":"VEC3","min":[-0.5,-0.5,0],"max":[0.5,0.5,0.25]}},
{{"bufferView":1,"componentType":5126,"count":{vertices},"type":"VEC3"}},
{{"bufferView":2,"componentType":5125,"count":{corners},"type":"SCALAR"}}],
"bufferViews":[{{"buffer":0,"byteLength":{block}}},{{"buffer":0,"byteOffset":{block},"byteLength":{block}}},
{{"buffer":0,"byteOffset":{},"byteLength":{}}}],"buffers":[{{"byteLength":{}}}]}}"#,
        2 * block,
        4 * corners,
        bin.len()
    );
    let mut text = json.into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut out = b"glTF".to_vec();
    for word in [2, (28 + text.len() + bin.len()) as u32, text.len() as u32] {
        out.extend_from_slice(&word.to_le_bytes());
    }
    out.extend_from_slice(b"JSON");
    out.extend_from_slice(&text);
    out.extend_from_slice(&(bin.len() as u32).to_le_bytes());
    out.extend_from_slice(b"BIN\0");
    out.extend_from_slice(&bin);
    out
}

/// Positions, normals and indices as the `gltf` crate gives them.
fn raw(path: &std::path::Path) -> usize {
    let file = std::fs::read(path).expect("the file");
    let gltf = gltf::Gltf::from_slice_without_validation(&file).expect("glTF");
    let buffers = gltf::import_buffers(&gltf.document, None, gltf.blob).expect("buffers");
    let mut count = 0;
    for primitive in gltf.document.meshes().flat_map(|mesh| mesh.primitives()) {
        let reader = primitive.reader(|buffer| buffers.get(buffer.index()).map(|data| &data[..]));
        let positions: Vec<[f32; 3]> = reader.read_positions().expect("positions").collect();
        let normals: Vec<[f32; 3]> = reader.read_normals().expect("normals").collect();
        let indices: Vec<u32> = reader.read_indices().expect("indices").into_u32().collect();
        assert!(positions.len() == normals.len());
        count += std::hint::black_box(&indices).len() / 3;
        std::hint::black_box((&positions, &normals));
    }
    count
}

/// Best of five, ms, and the greatest memory beyond what was held before, bytes.
fn measured(mut work: impl FnMut() -> usize) -> (f64, usize) {
    let (mut best, mut most) = (f64::INFINITY, 0);
    for _ in 0..5 {
        let before = HELD.load(Ordering::Relaxed);
        PEAK.store(before, Ordering::Relaxed);
        let start = Instant::now();
        std::hint::black_box(work());
        best = best.min(start.elapsed().as_secs_f64() * 1e3);
        most = most.max(PEAK.load(Ordering::Relaxed).saturating_sub(before));
    }
    (best, most)
}

fn main() {
    let files: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    for file in &files {
        let path = std::path::Path::new(file);
        let size = std::fs::metadata(path).expect("the file").len() as f64;
        let (read_ms, read_peak) = measured(|| eyebox::import::asset(path).expect("it reads").meshes.len());
        let (scene_ms, scene_peak) = measured(|| {
            eyebox::import::outline(path, &eyebox::import::ReadOptions::default()).expect("it imports").meshes.len()
        });
        println!("{file}: {:.1} MB", size / 1e6);
        for (what, ms, peak) in [("assembly", read_ms, read_peak as f64), ("scene", scene_ms, scene_peak as f64)] {
            println!("  {what:10} {ms:7.1} ms, {:.1} MB = {:.2} x the file", peak / 1e6, peak / size);
        }
    }
    if !files.is_empty() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("grid.glb");
    let bytes = asset(1000);
    let size = bytes.len() as f64;
    std::fs::write(&path, &bytes).expect("the file");
    drop(bytes);
    let (raw_ms, raw_peak) = measured(|| raw(&path));
    let (read_ms, read_peak) = measured(|| eyebox::import::gltf::read(&path).expect("it reads").meshes.len());
    let (scene_ms, scene_peak) = measured(|| {
        eyebox::import::outline(&path, &eyebox::import::ReadOptions::default()).expect("it imports").meshes.len()
    });
    println!("2 000 000 triangles, {:.1} MB", size / 1e6);
    for (what, ms, peak) in
        [("gltf crate", raw_ms, raw_peak), ("assembly", read_ms, read_peak), ("scene", scene_ms, scene_peak)]
    {
        let peak = peak as f64;
        println!(
            "  {what:10} {ms:7.1} ms = {:.2} x, {:.1} MB = {:.2} x the file",
            ms / raw_ms,
            peak / 1e6,
            peak / size
        );
    }
}
