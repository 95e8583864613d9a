//! Parts that lie in one place cost what they do to light: the lines where one crosses another are looked for on faces that
//! somebody gathers light on, not among all of them before the first ray.

use super::read;
use eyebox::plan::Choice;
use eyebox::world::World;
use rustix::time::{ClockId, clock_gettime};

/// CPU seconds of this thread.
fn seconds() -> f64 {
    let now = clock_gettime(ClockId::ThreadCPUTime);
    now.tv_sec as f64 + 1e-9 * now.tv_nsec as f64
}

fn spheres(count: usize) -> String {
    let sphere = |i: usize| {
        format!(
            "def Sphere \"S{i}\" {{ double radius = 0.3\n double3 xformOp:translate = ({}, 0, 0)\n\
             uniform token[] xformOpOrder = [\"xformOp:translate\"] }}\n",
            0.01 * i as f64
        )
    };
    let all: String = (0..count).map(sphere).collect();
    format!("#usda 1.0\n(\n metersPerUnit = 1\n upAxis = \"Y\"\n)\n{all}")
}

/// 50 spheres that all overlap: 30 to 50 s before; the pass that was asked for takes about one.
#[test]
fn fifty_spheres_in_one_place() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.usda");
    std::fs::write(&file, spheres(50)).unwrap();
    let mut scene = read(&file, &[]).scene;
    scene.eye.resolution = [8, 8];
    let start = seconds();
    drop(World::freeze(&scene).unwrap());
    let took = seconds() - start;
    assert!(took < 4.0, "{took} s");
    // And a picture of them has light.
    let (mean, _) = super::seen(&file, &[], Choice::Auto, 1);
    assert!(mean > 0.0);
}
