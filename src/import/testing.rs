//! Assemblies made by hand, for tests.

use super::assembly::{Assembly, Material, MeshSource, Node};
use eyebox_base::Where;
use eyebox_scene::{FaceRange, Mesh};
use glam::{DAffine3, DQuat, DVec3};

/// A box with one face each towards −x, +x, −y, +y, −z, +z.
pub fn box_mesh(name: &str, low: [f32; 3], high: [f32; 3]) -> Mesh {
    let mut mesh = Mesh { name: name.into(), ..Mesh::default() };
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for side in [low, high] {
            let first = mesh.positions.len() as u32;
            for (at_u, at_v) in [(low[u], low[v]), (high[u], low[v]), (high[u], high[v]), (low[u], high[v])] {
                let mut corner = [0.0; 3];
                (corner[axis], corner[u], corner[v]) = (side[axis], at_u, at_v);
                mesh.positions.push(corner);
                let mut normal = [0.0; 3];
                normal[axis] = if side == low { -1.0 } else { 1.0 };
                mesh.normals.push(normal);
            }
            let [a, b, c, d] = [0, 1, 2, 3].map(|corner| first + corner);
            let outward = side == high;
            mesh.faces.push(FaceRange { first: mesh.triangles.len() as u32, count: 2 });
            mesh.triangles.extend(if outward { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] });
        }
    }
    mesh
}

fn pointer(pointer: String) -> Where {
    Where::Pointer { file: "a.glb".into(), pointer }
}

/// A root `ROOT` turned by −90° about x as CAD exporters do, with boxes `names` below it, 10 units apart along its x.
/// All faces have material 0, `GLASS`. Millimetres that the asset declares as metres.
pub fn assembly(names: &[&str]) -> Assembly {
    let root = DAffine3::from_quat(DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2));
    let node = |name: &str, path: String, index: usize, parent, (local, to_world), mesh| Node {
        name: name.into(),
        path,
        parent,
        local,
        to_world,
        mesh,
        attributes: None,
        user: Vec::new(),
        at: pointer(format!("/nodes/{index}")),
    };
    let mut nodes = vec![node("ROOT", "ROOT".into(), 0, None, (root, root), None)];
    let mut meshes = Vec::new();
    for (i, name) in names.iter().enumerate() {
        let local = DAffine3::from_translation(DVec3::new(10.0 * i as f64, 0.0, 0.0));
        nodes.push(node(name, format!("ROOT/{name}"), i + 1, Some(0), (local, root * local), Some(i)));
        meshes.push(MeshSource {
            mesh: box_mesh(name, [-2.0, -1.0, 0.0], [2.0, 1.0, 0.5]).into(),
            materials: vec![Some(0); 6],
            attributes: vec![None; 6],
            rig: None,
            implicit: None,
            at: pointer(format!("/meshes/{i}")),
        });
    }
    let material = Material {
        name: "GLASS".into(),
        mapped: Vec::new(),
        attributes: None,
        looks: Vec::new(),
        surface: None,
        user: Vec::new(),
        at: pointer("/materials/0".into()),
    };
    Assembly { file: "a.glb".into(), unit_m: 1.0, nodes, meshes, materials: vec![material], ..Assembly::default() }
}
