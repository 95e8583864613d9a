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
    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        let held = HELD.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
        PEAK.fetch_max(held, Ordering::Relaxed);
        unsafe { System.alloc_zeroed(layout) }
    }
    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // While it is moved, both are held.
        let held = HELD.fetch_add(size, Ordering::Relaxed) + size;
        PEAK.fetch_max(held, Ordering::Relaxed);
        let moved = unsafe { System.realloc(pointer, layout, size) };
        HELD.fetch_sub(layout.size(), Ordering::Relaxed);
        moved
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

/// The four arrays of each mesh as the `openusd` crate gives them, one at a time.
fn library(path: &std::path::Path) -> usize {
    let stage = openusd::usd::Stage::builder().open(path.to_str().expect("a name")).expect("a stage");
    let root = openusd::sdf::Path::abs_root();
    let roots = stage.root_prims().expect("prims");
    let roots = roots.iter().map(|name| stage.prim(root.append_path(name.as_str()).expect("a path")).expect("a prim"));
    let (mut count, mut rest) = (0, roots.collect::<Vec<_>>());
    while let Some(prim) = rest.pop() {
        if prim.type_name().expect("a type").is_some_and(|name| name.as_str() == "Mesh") {
            for name in ["points", "faceVertexCounts", "faceVertexIndices", "normals"] {
                let value = prim.attribute(name).get_at::<openusd::sdf::Value>(None).expect("a value");
                count += usize::from(std::hint::black_box(&value).is_some());
            }
        }
        rest.extend(prim.children().expect("children"));
    }
    count
}

/// Processor time of all threads so far, ms; in steps of 10 (Linux: proc(5), fields 14 and 15 of `stat`).
fn processor_ms() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks = |at: usize| fields.get(at - 3)?.parse::<f64>().ok();
    Some(10.0 * (ticks(14)? + ticks(15)?))
}

/// What some work cost.
#[derive(Debug, Clone, Copy)]
struct Cost {
    /// Best of ten, ms.
    ms: f64,
    /// Processor time of all threads, mean of ten, ms; NaN where it is not known.
    processor_ms: f64,
    /// The greatest memory beyond what was held before, bytes.
    peak: f64,
}

fn measured(mut work: impl FnMut() -> usize) -> Cost {
    const TIMES: u8 = 10;
    let first = processor_ms();
    let (mut ms, mut peak) = (f64::INFINITY, 0);
    for _ in 0..TIMES {
        let before = HELD.load(Ordering::Relaxed);
        PEAK.store(before, Ordering::Relaxed);
        let start = Instant::now();
        std::hint::black_box(work());
        ms = ms.min(start.elapsed().as_secs_f64() * 1e3);
        peak = peak.max(PEAK.load(Ordering::Relaxed).saturating_sub(before));
    }
    let spent = first.zip(processor_ms()).map_or(f64::NAN, |(from, to)| to - from);
    Cost { ms, processor_ms: spent / f64::from(TIMES), peak: peak as f64 }
}

/// One line for each; `raw` is what the times are compared with.
fn say(rows: &[(&str, Cost)], raw: Cost, size: f64) {
    for (what, Cost { ms, processor_ms, peak }) in rows {
        let (times, processor_times, mb, share) =
            (ms / raw.ms, processor_ms / raw.processor_ms, peak / 1e6, peak / size);
        println!(
            "  {what:13} {ms:7.1} ms = {times:.2} x, processor {processor_ms:6.1} ms = {processor_times:.2} x, {mb:.1} MB = {share:.2} x the file"
        );
    }
}

fn main() {
    let files: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    let scene = |path: &std::path::Path| {
        eyebox::import::outline(path, &eyebox::import::ReadOptions::default()).expect("it imports").meshes.len()
    };
    for file in &files {
        let path = std::path::Path::new(file);
        let size = std::fs::metadata(path).expect("the file").len() as f64;
        let is_usd = path.extension().is_some_and(|extension| extension.to_string_lossy().starts_with("usd"));
        let library = is_usd.then(|| measured(|| library(path)));
        let assembly = measured(|| eyebox::import::asset(path).expect("it reads").meshes.len());
        let rows = [
            library.map(|cost| ("openusd crate", cost)),
            Some(("assembly", assembly)),
            Some(("scene", measured(|| scene(path)))),
        ];
        println!("{file}: {:.1} MB", size / 1e6);
        say(&rows.into_iter().flatten().collect::<Vec<_>>(), library.unwrap_or(assembly), size);
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
    let raw = measured(|| raw(&path));
    let assembly = measured(|| {
        eyebox::import::gltf::read(&path, &eyebox::import::ReadOptions::default()).expect("it reads").meshes.len()
    });
    println!("2 000 000 triangles, {:.1} MB", size / 1e6);
    say(&[("gltf crate", raw), ("assembly", assembly), ("scene", measured(|| scene(&path)))], raw, size);
}
