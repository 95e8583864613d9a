//! Broken copies of every asset in a folder: each must end in a result or a fault, within 20 s and 4 GiB.
//! `cargo bench --ignore-rust-version --bench hostile -- FOLDER [COUNT] [FIRST SEED]`; 10 000 copies unless said.

#[path = "../tests/common/mutate.rs"]
mod mutate;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

const EXTENSIONS: [&str; 5] = ["glb", "gltf", "usda", "usdc", "usdz"];
const MOST_S: u64 = 20;

fn collect(folder: &Path, out: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    for path in paths {
        let known = path.extension().is_some_and(|own| EXTENSIONS.iter().any(|known| own.eq_ignore_ascii_case(known)));
        if path.is_dir() {
            collect(&path, out);
        } else if known {
            out.push(path);
        }
    }
}

/// Reads `bytes` as if they were the file: glTF from memory, others from a file beside it that is removed again.
fn open(file: &Path, bytes: &[u8]) -> bool {
    let extension = file.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    if extension == "glb" || extension == "gltf" {
        return eyebox::import::gltf::read_bytes(file, bytes, &eyebox::import::ReadOptions::default()).is_ok();
    }
    let broken = file.with_file_name(format!(".broken.{extension}"));
    std::fs::write(&broken, bytes).expect("the folder can be written");
    let opened = eyebox::import::geometry(&broken, &eyebox::import::ReadOptions::default()).is_ok();
    let _ = std::fs::remove_file(&broken);
    opened
}

/// Largest resident size of this process so far, MiB (Linux).
fn peak_mib() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap_or_default();
    line.split_whitespace().next().and_then(|kib| kib.parse::<u64>().ok()).unwrap_or(0) / 1024
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let Some(folder) = arguments.first() else {
        println!("hostile: no folder given, nothing done");
        return;
    };
    let number =
        |index: usize, default: u64| arguments.get(index).and_then(|text| text.parse().ok()).unwrap_or(default);
    let (count, first) = (number(1, 10_000), number(2, 0));
    let mut files = Vec::new();
    collect(Path::new(folder), &mut files);
    let sources: Vec<(PathBuf, Vec<u8>)> =
        files.into_iter().filter_map(|file| std::fs::read(&file).ok().map(|bytes| (file, bytes))).collect();
    if sources.is_empty() {
        println!("hostile: no assets in {folder}");
        return;
    }
    // A watch on the case under way: a hang cannot be ended from inside.
    static STARTED_MS: AtomicU64 = AtomicU64::new(0);
    static CASE: AtomicU64 = AtomicU64::new(0);
    let zero = Instant::now();
    std::thread::spawn(move || {
        loop {
            std::thread::sleep(std::time::Duration::from_millis(200));
            let now = zero.elapsed().as_millis() as u64;
            if now > STARTED_MS.load(Ordering::SeqCst) + MOST_S * 1000 {
                println!("HANG: seed {}", CASE.load(Ordering::SeqCst));
                std::process::exit(1);
            }
        }
    });
    let (mut opened, mut panics, mut slowest) = (0u64, 0u64, (0.0, 0u64));
    for seed in first..first + count {
        let (file, bytes) = &sources[(seed % sources.len() as u64) as usize];
        let broken = mutate::mutated(bytes, seed);
        CASE.store(seed, Ordering::SeqCst);
        let start = zero.elapsed();
        STARTED_MS.store(start.as_millis() as u64, Ordering::SeqCst);
        match std::panic::catch_unwind(|| open(file, &broken)) {
            Ok(fine) => opened += u64::from(fine),
            Err(_) => {
                panics += 1;
                println!("PANIC: seed {seed}, {}", file.display());
            }
        }
        let took = (zero.elapsed() - start).as_secs_f64();
        if took > slowest.0 {
            slowest = (took, seed);
        }
    }
    let peak = peak_mib();
    println!(
        "{folder}: {count} broken copies of {} files: {opened} open, {} faults, {panics} panics, slowest {:.2} s (seed {}), peak {peak} MiB",
        sources.len(),
        count - opened - panics,
        slowest.0,
        slowest.1
    );
    if panics > 0 || peak > 4096 {
        std::process::exit(1);
    }
}
