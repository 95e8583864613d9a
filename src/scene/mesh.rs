//! Geometry as it comes from the file: f32 positions in the file's own units, one face per CAD face.

/// A mesh: vertices, triangles, and which triangles make which CAD face.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct Mesh {
    pub name: String,
    /// Vertex positions in mesh units.
    #[serde(skip)]
    pub positions: Vec<[f32; 3]>,
    /// Unit vertex normals, one per position (repaired; flat faces have unshared vertices).
    #[serde(skip)]
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates, one per position, or none.
    #[serde(skip)]
    pub uvs: Vec<[f32; 2]>,
    /// A second set of them, or none.
    #[serde(skip)]
    pub second_uvs: Vec<[f32; 2]>,
    /// Unit directions in which a normal map's x runs, and the side (±1) of its y about normal × direction; one per position, or
    /// none: then texture coordinates say it, as they do where a direction is 0.
    #[serde(skip)]
    pub tangents: Vec<[f32; 4]>,
    /// Linear Rec.709 colours with alpha, one per position, or none.
    #[serde(skip)]
    pub colors: Vec<[f32; 4]>,
    /// Vertex indices of each triangle, counter-clockwise seen from outside the solid.
    #[serde(skip)]
    pub triangles: Vec<[u32; 3]>,
    /// The CAD faces, in file order; they partition `triangles`.
    pub faces: Vec<FaceRange>,
}

/// The triangles `first .. first + count` of a mesh make one CAD face.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct FaceRange {
    pub first: u32,
    pub count: u32,
}

impl FaceRange {
    pub fn triangles(self) -> std::ops::Range<usize> {
        self.first as usize..self.first as usize + self.count as usize
    }
}
