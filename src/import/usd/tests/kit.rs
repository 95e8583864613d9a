//! Stages in a folder of their own.

use crate::usd::read;
use crate::{Assembly, ReadOptions};
use tempfile::TempDir;

/// A folder with files, the first of which is the asset.
pub struct Folder {
    folder: TempDir,
    root: String,
}

impl Folder {
    pub fn new(files: &[(&str, &str)]) -> Self {
        let folder = TempDir::new().unwrap();
        for (name, body) in files {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, format!("#usda 1.0\n{body}")).unwrap();
        }
        Folder { folder, root: files[0].0.to_owned() }
    }
    pub fn read(&self, frame: Option<f64>) -> Result<Assembly, String> {
        self.read_with(&ReadOptions { frame, ..ReadOptions::default() })
    }
    pub fn read_with(&self, options: &ReadOptions) -> Result<Assembly, String> {
        read(&self.folder.path().join(&self.root), options).map_err(|fault| fault.to_string())
    }
}

/// The assembly of one text layer.
pub fn assembly(body: &str) -> Assembly {
    Folder::new(&[("a.usda", body)]).read(None).unwrap()
}

pub fn fault(body: &str) -> String {
    Folder::new(&[("a.usda", body)]).read(None).unwrap_err()
}

pub fn paths(assembly: &Assembly) -> Vec<&str> {
    assembly.nodes.iter().map(|node| node.path.as_str()).collect()
}

pub fn notes(assembly: &Assembly) -> String {
    assembly.notes.iter().map(|note| format!("{}: {}\n", note.at, note.text)).collect()
}

/// A unit square in the plane z = 0 as the contents of a Mesh.
pub const SQUARE: &str = r#"
    uniform token subdivisionScheme = "none"
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
"#;
