//! Names, the order of triangles and shared vertices are the file's business, not the picture's.

use super::kit::*;
use crate::common::mean;
use eyebox::film::plan::Estimator;
use eyebox::plan::Choice;
use eyebox::scene::{Mesh, Scene};

/// Reverses the triangles of every face and gives each triangle vertices of its own.
fn rebuilt(mesh: &Mesh) -> Mesh {
    let mut out = Mesh { name: format!("{}_renamed", mesh.name), faces: mesh.faces.clone(), ..Mesh::default() };
    for face in &mesh.faces {
        for triangle in mesh.triangles[face.triangles()].iter().rev() {
            // The same triangle, started at another corner.
            let [a, b, c] = *triangle;
            let first = out.positions.len() as u32;
            for vertex in [b, c, a] {
                out.positions.push(mesh.positions[vertex as usize]);
                out.normals.push(mesh.normals[vertex as usize]);
            }
            out.triangles.push([first, first + 1, first + 2]);
        }
    }
    out
}

fn measure(scene: &Scene) -> (f64, f64) {
    mean(&Ready::new(scene, Choice::Only(Estimator::Forward)).image(16, 1))
}

#[test]
fn renaming_shuffling_and_splitting_change_nothing_but_names() {
    let scene = gaze(fill(hud("direct", &ONE_LED), 1.0), [0.0; 2], 6.0, [8, 4]);
    let (value, sigma) = measure(&scene);
    let mut other = scene.clone();
    other.meshes = scene.meshes.iter().map(|mesh| rebuilt(mesh).into()).collect();
    for (index, part) in other.parts.iter_mut().enumerate() {
        part.name = format!("part {index}");
        part.path = format!("root/part {index}");
    }
    let (changed, changed_sigma) = measure(&other);
    assert!(sigma / value < 4e-3, "{value} ± {sigma}");
    let z = (changed - value) / sigma.hypot(changed_sigma);
    assert!(z.abs() < 4.0, "{value} ± {sigma} became {changed} ± {changed_sigma}");
}
