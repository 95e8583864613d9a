//! For tests: the faces of the CAD samples, one per mesh primitive, in the part's own frame (mm).

pub(crate) struct Primitive {
    pub part: String,
    pub face: usize,
    pub positions: Vec<[f32; 3]>,
    pub normals: Vec<[f32; 3]>,
    pub triangles: Vec<[u32; 3]>,
}

/// All faces of `samples/<file>`, in file order.
pub(crate) fn primitives(file: &str) -> Vec<Primitive> {
    let path = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("samples").join(file);
    let bytes = std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let glb = gltf::Gltf::from_slice_without_validation(&bytes).expect("the sample is a glb");
    let blob = glb.blob.as_deref().expect("the sample carries its buffer");
    let mut out = Vec::new();
    for mesh in glb.document.meshes() {
        for (face, primitive) in mesh.primitives().enumerate() {
            let reader = primitive.reader(|_| Some(blob));
            let indices: Vec<u32> = reader.read_indices().expect("indices").into_u32().collect();
            out.push(Primitive {
                part: mesh.name().unwrap_or_default().to_owned(),
                face,
                positions: reader.read_positions().expect("positions").collect(),
                normals: reader.read_normals().expect("normals").collect(),
                triangles: indices.as_chunks::<3>().0.to_vec(),
            });
        }
    }
    out
}

pub(crate) fn find<'a>(all: &'a [Primitive], part: &str, face: usize) -> &'a Primitive {
    all.iter().find(|p| p.part == part && p.face == face).unwrap_or_else(|| panic!("no {part} face {face}"))
}
