//! What an asset holds before any optics: parts with their sizes, materials, lights, cameras, and totals to compare with
//! what other programs count.

use eyebox_base::Where;
use eyebox_scene::assembly::{Assembly, LightForm, LightSource, MeshSource};
use eyebox_scene::{Note, Severity};
use glam::{DAffine3, DMat3, DVec3};
use serde::Serialize;
use std::collections::BTreeMap;

/// Corners of an axis-parallel box in metres, in the scene's world (+y up).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Bounds {
    pub low: [f64; 3],
    pub high: [f64; 3],
}

/// A node with a mesh.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PartFacts {
    /// Root-relative path of names.
    pub path: String,
    /// Where the file has it: a prim path, a JSON pointer.
    pub at: String,
    /// Name of the mesh and its place in the asset.
    pub mesh: String,
    pub mesh_index: usize,
    pub faces: usize,
    pub triangles: usize,
    pub vertices: usize,
    /// Around the vertices where they stand; none without vertices.
    pub bounds_m: Option<Bounds>,
    /// Names of the materials of its faces, each once.
    pub materials: Vec<String>,
    /// How much of it each material has, those without one last.
    pub bound: Vec<BoundFacts>,
}

/// What a material covers of a part.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BoundFacts {
    /// Where the file has the material; none for what has none.
    pub at: Option<String>,
    pub faces: usize,
    pub triangles: usize,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LightFacts {
    pub name: String,
    /// Path of the node that holds it.
    pub node: String,
    /// Where the file has it: a prim path, a JSON pointer.
    pub at: String,
    pub kind: &'static str,
    /// Its strength, and its sizes in asset units in its own axes.
    pub form: LightForm,
    /// Linear Rec.709 with luminance 1.
    pub color: [f64; 3],
    /// Columns: its axes and its origin in the scene's world (+y up), in metres per asset unit and metres.
    pub to_world_m: [[f64; 3]; 4],
}

#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Totals {
    pub nodes: usize,
    pub parts: usize,
    pub meshes: usize,
    pub faces: usize,
    /// Of all meshes, each once, used or not.
    pub mesh_triangles: usize,
    pub mesh_vertices: usize,
    /// Of all parts: a mesh counts as often as it stands somewhere.
    pub triangles: usize,
    pub materials: usize,
    pub lights: usize,
    pub cameras: usize,
    pub bounds_m: Option<Bounds>,
}

/// The geometry of an asset.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GeometryFacts {
    pub file: String,
    /// Metres per unit.
    pub unit_m: f64,
    pub totals: Totals,
    pub parts: Vec<PartFacts>,
    pub materials: Vec<String>,
    pub lights: Vec<LightFacts>,
    pub cameras: Vec<String>,
    pub notes: Vec<Note>,
}

impl GeometryFacts {
    pub fn new(assembly: &Assembly) -> Self {
        let name = |index: usize| assembly.materials.get(index).map(|material| material.name.clone());
        let mut parts = Vec::new();
        let mut whole = None;
        for node in &assembly.nodes {
            let Some((index, source)) = node.mesh.and_then(|mesh| Some((mesh, assembly.meshes.get(mesh)?))) else {
                continue;
            };
            let bounds = bounds(assembly, source, &node.to_world);
            whole = join(whole, bounds);
            let mut used: Vec<usize> = source.materials.iter().flatten().copied().collect();
            used.sort_unstable();
            used.dedup();
            parts.push(PartFacts {
                path: node.path.clone(),
                at: address(&node.at),
                mesh: source.mesh.name.clone(),
                mesh_index: index,
                faces: source.mesh.faces.len(),
                triangles: source.mesh.triangles.len(),
                vertices: source.mesh.positions.len(),
                bounds_m: bounds,
                materials: used.into_iter().filter_map(name).collect(),
                bound: bound(assembly, source),
            });
        }
        let totals = Totals {
            nodes: assembly.nodes.len(),
            parts: parts.len(),
            meshes: assembly.meshes.len(),
            faces: parts.iter().map(|part| part.faces).sum(),
            mesh_triangles: assembly.meshes.iter().map(|source| source.mesh.triangles.len()).sum(),
            mesh_vertices: assembly.meshes.iter().map(|source| source.mesh.positions.len()).sum(),
            triangles: parts.iter().map(|part| part.triangles).sum(),
            materials: assembly.materials.len(),
            lights: assembly.lights.len(),
            cameras: assembly.cameras.len(),
            bounds_m: whole,
        };
        let node = |index: usize| assembly.nodes.get(index).map(|node| node.path.clone()).unwrap_or_default();
        let light = |light: &LightSource| LightFacts {
            name: light.name.clone(),
            node: node(light.node),
            at: address(&light.at),
            kind: kind(&light.form),
            form: light.form.clone(),
            color: light.color,
            to_world_m: frame(assembly, light.node),
        };
        GeometryFacts {
            file: assembly.file.display().to_string(),
            unit_m: assembly.unit_m,
            totals,
            parts,
            materials: assembly.materials.iter().map(|material| material.name.clone()).collect(),
            lights: assembly.lights.iter().map(light).collect(),
            cameras: assembly.cameras.iter().map(|camera| camera.name.clone()).collect(),
            notes: assembly.notes.clone(),
        }
    }

    /// One line per part, then the totals and the notes, warnings first.
    pub fn text(&self) -> String {
        let mut lines = vec![format!("{} (1 unit = {} m)", self.file, self.unit_m)];
        for part in &self.parts {
            let counts = format!("{} faces, {} triangles", part.faces, part.triangles);
            let materials = match part.materials.as_slice() {
                [] => String::new(),
                names => format!(", material {}", names.join(", ")),
            };
            lines.push(format!("  {}: {counts}, {}{materials}", part.path, size(part.bounds_m)));
        }
        for light in &self.lights {
            lines.push(format!("  light {} at {}: {}", light.name, light.node, light.kind));
        }
        for camera in &self.cameras {
            lines.push(format!("  camera {camera}"));
        }
        let t = &self.totals;
        lines.push(format!(
            "{} parts of {} meshes, {} triangles, {} materials, {} lights, {} cameras, {}",
            t.parts,
            t.meshes,
            t.triangles,
            t.materials,
            t.lights,
            t.cameras,
            size(t.bounds_m)
        ));
        for (severity, word) in [(Severity::Warning, "warning"), (Severity::Info, "info")] {
            for note in self.notes.iter().filter(|note| note.severity == severity) {
                lines.push(format!("{word}: {}: {}", note.at, note.text));
            }
        }
        lines.join("\n")
    }
}

/// A place without the file.
fn address(at: &Where) -> String {
    match at {
        Where::Prim { prim, .. } => prim.clone(),
        Where::Pointer { pointer, .. } => pointer.clone(),
        Where::Nowhere | Where::File(_) | Where::Line { .. } | Where::Part { .. } | Where::Option(_) => at.to_string(),
    }
}

/// Faces and triangles by material, in the order of the materials.
fn bound(assembly: &Assembly, source: &MeshSource) -> Vec<BoundFacts> {
    let mut counts: BTreeMap<usize, (usize, usize)> = BTreeMap::new();
    for (face, material) in source.mesh.faces.iter().zip(&source.materials) {
        let (faces, triangles) = counts.entry(material.unwrap_or(usize::MAX)).or_default();
        (*faces, *triangles) = (*faces + 1, *triangles + face.count as usize);
    }
    let place = |index: usize| assembly.materials.get(index).map(|material| address(&material.at));
    counts.into_iter().map(|(index, (faces, triangles))| BoundFacts { at: place(index), faces, triangles }).collect()
}

/// A node's axes and origin in the scene's world.
fn frame(assembly: &Assembly, node: usize) -> [[f64; 3]; 4] {
    let to_asset = assembly.nodes.get(node).map_or(DAffine3::IDENTITY, |node| node.to_world);
    let DMat3 { x_axis, y_axis, z_axis } = to_asset.matrix3;
    [x_axis, y_axis, z_axis, to_asset.translation].map(|v| (assembly.axes * v * assembly.unit_m).to_array())
}

/// Extent in mm.
fn size(bounds: Option<Bounds>) -> String {
    let Some(Bounds { low, high }) = bounds else { return "no extent".to_owned() };
    let [x, y, z] = [0, 1, 2].map(|axis| (high[axis] - low[axis]) * 1e3);
    format!("{x:.3} x {y:.3} x {z:.3} mm")
}

fn bounds(assembly: &Assembly, source: &MeshSource, to_world: &DAffine3) -> Option<Bounds> {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for position in &source.mesh.positions {
        let point = assembly.axes * to_world.transform_point3(DVec3::from(position.map(f64::from))) * assembly.unit_m;
        (low, high) = (low.min(point), high.max(point));
    }
    (low.is_finite() && high.is_finite()).then(|| Bounds { low: low.to_array(), high: high.to_array() })
}

fn join(a: Option<Bounds>, b: Option<Bounds>) -> Option<Bounds> {
    let (Some(one), Some(other)) = (a, b) else { return a.or(b) };
    Some(Bounds {
        low: [0, 1, 2].map(|axis| one.low[axis].min(other.low[axis])),
        high: [0, 1, 2].map(|axis| one.high[axis].max(other.high[axis])),
    })
}

fn kind(form: &LightForm) -> &'static str {
    match form {
        LightForm::Point { cone: None, .. } => "point",
        LightForm::Point { cone: Some(_), .. } => "spot",
        LightForm::Distant { .. } => "distant",
        LightForm::Rect { .. } => "rect",
        LightForm::Disk { .. } => "disk",
        LightForm::Sphere { .. } => "sphere",
        LightForm::Cylinder { .. } => "cylinder",
        LightForm::Dome { .. } => "dome",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyebox_scene::Mesh;
    use eyebox_scene::assembly::Node;
    use glam::DQuat;

    /// A tetrahedron's corner points, turned by 45° about z, in cm, z up: the box is around the points, not around the
    /// turned box.
    #[test]
    fn bounds_are_those_of_the_points() {
        let mesh = Mesh {
            positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0]],
            ..Mesh::default()
        };
        let source = MeshSource {
            mesh: mesh.into(),
            materials: vec![None],
            attributes: vec![None],
            rig: None,
            implicit: None,
            at: Where::Nowhere,
        };
        let turned = DAffine3::from_quat(DQuat::from_rotation_z(std::f64::consts::FRAC_PI_4));
        let node = Node {
            name: "A".into(),
            path: "A".into(),
            parent: None,
            local: turned,
            to_world: turned,
            mesh: Some(0),
            attributes: None,
            user: Vec::new(),
            at: Where::Nowhere,
        };
        let up = DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y);
        let assembly =
            Assembly { unit_m: 0.01, axes: up, nodes: vec![node], meshes: vec![source], ..Assembly::default() };
        let facts = GeometryFacts::new(&assembly);
        let bounds = facts.totals.bounds_m.expect("bounds");
        let s = 0.5f64.sqrt() * 0.01;
        let near = |found: [f64; 3], want: [f64; 3]| {
            assert!((0..3).all(|axis| (found[axis] - want[axis]).abs() < 1e-17), "{found:?} {want:?}");
        };
        near(bounds.low, [-s, 0.0, -s]);
        near(bounds.high, [s, 0.02, 0.0]);
        assert_eq!((facts.totals.parts, facts.parts[0].vertices), (1, 4));
    }
}
