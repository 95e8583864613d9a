//! The architecture as tests. Each floor is a crate, so cargo keeps what a floor may import; within a floor no circle leads from
//! one room into another, and numbers that somebody chose stand together.

#[path = "floors/rooms.rs"]
mod rooms;
mod tuning;

use std::path::{Path, PathBuf};

fn sources(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("src is readable") {
        let path = entry.expect("src is readable").path();
        if path.is_dir() {
            sources(&path, out);
        } else if path.extension().is_some_and(|e| e == "rs") {
            out.push(path);
        }
    }
}
