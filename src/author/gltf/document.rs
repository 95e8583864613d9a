//! A whole assembly as a new glTF document.

use super::super::Written;
use super::super::picture::{self, Encoded};
use super::binary::Binary;
use super::light::PUNCTUAL;
use super::texture::{Place, Textures};
use super::value::{self, OPTICS};
use super::{geometry, light, material, node, uri};
use eyebox_base::atomic::write_atomic;
use eyebox_base::error::Result;
use eyebox_base::glb::container;
use eyebox_base::{Error, Where};
use eyebox_scene::Note;
use eyebox_scene::assembly::Assembly;
use eyebox_scene::value::{Data, Value};
use serde_json::{Map, Value as Json, json};
use std::path::{Path, PathBuf};

/// The document while it is written.
#[derive(Debug, Default)]
pub struct Document {
    pub binary: Binary,
    pub textures: Textures,
    pub nodes: Vec<Json>,
    pub cameras: Vec<Json>,
    pub lights: Vec<Json>,
    /// Meshes and materials of lights, after those of the assembly.
    pub lamps: Vec<(Json, Json)>,
    pub skins: Vec<Json>,
    pub animations: Vec<Json>,
    /// The accessor of a single point, which stands for an empty face.
    pub point: Option<usize>,
    /// Whether the assembly's second texture coordinate grows upwards.
    up: bool,
    used: Vec<String>,
    required: Vec<String>,
    notes: Vec<Note>,
}

impl Document {
    /// Lists an extension among those that are used.
    pub fn uses(&mut self, extension: &str) {
        if !self.used.iter().any(|own| own == extension) {
            self.used.push(extension.to_owned());
        }
    }
    /// Lists an extension among those without which the asset is not shown.
    pub fn requires(&mut self, extension: &str) {
        if !self.required.iter().any(|own| own == extension) {
            self.required.push(extension.to_owned());
        }
    }
    /// Texture coordinates of the assembly as glTF has them, whose second one grows downwards (2.0, section 3.8.3). A
    /// transform would do as well, but renderers make the axes of normal maps from the coordinates themselves.
    pub fn down(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        if self.up { [u, 1.0 - v] } else { [u, v] }
    }
    /// A map from the assembly's texture coordinates as one from those of [`Document::down`].
    pub fn reads_down(&self, map: [[f64; 3]; 2]) -> [[f64; 3]; 2] {
        if self.up { map.map(|[a, b, c]| [a, -b, b + c]) } else { map }
    }
    /// Something that glTF can't say.
    pub fn note(&mut self, at: &Where, text: String) {
        self.notes.push(Note::warning(at.clone(), text));
    }
}

/// Writes `assembly` as `.glb`, which holds its pictures, or as `.gltf` with its buffer (`NAME.bin`) and its pictures (in
/// `NAME_textures`) beside it.
///
/// Faults: a mesh whose triangles don't fit its vertices, numbers that JSON has not, a `.glb` above 4 GiB.
pub fn write(assembly: &Assembly, out: &Path) -> Result<Written> {
    let mut document = Document { up: assembly.st_runs_up(), ..Document::default() };
    let document_mut = &mut document;
    let meshes = (0..assembly.meshes.len()).map(|mesh| geometry::mesh(document_mut, assembly, mesh));
    let meshes = meshes.collect::<Result<Vec<_>>>()?;
    let materials = (0..assembly.materials.len()).map(|index| material::material(document_mut, assembly, index));
    let materials = materials.collect::<Result<Vec<_>>>()?;
    let roots = node::nodes(&mut document, assembly)?;
    let optics = root(&mut document, assembly, out);
    if !assembly.layers.is_empty() {
        let text = "the layers that the asset asks for have no form in glTF: not written";
        document.note(&Where::file(&assembly.file), text.into());
    }

    let Document {
        binary, textures, nodes, cameras, lights, lamps, skins, animations, mut used, required, notes, ..
    } = document;
    let (mut meshes, mut materials) = (meshes, materials);
    for (mesh, material) in lamps {
        meshes.push(mesh);
        materials.push(material);
    }
    let (mut bytes, mut views, accessors) = binary.finish();
    let packed = out.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("glb"));
    let folder = format!("{}_textures", out.file_stem().unwrap_or_default().to_string_lossy());
    let place = if packed { Place::Buffer(views.len()) } else { Place::Beside(&folder) };
    let (lists, mut pictures) = textures.finish(place);
    if packed {
        for (_, picture) in pictures.drain(..) {
            // Accessors' data come first: they are of four bytes each, and so is this after them.
            bytes.resize(bytes.len().next_multiple_of(4), 0);
            views.push(json!({ "buffer": 0, "byteOffset": bytes.len(), "byteLength": picture.bytes.len() }));
            bytes.extend(picture.bytes.iter());
        }
    }
    let mut json = Map::new();
    let generator = concat!("eyebox ", env!("CARGO_PKG_VERSION"));
    json.insert("asset".into(), json!({ "version": "2.0", "generator": generator }));
    let mut extensions = Map::new();
    if let Some(optics) = optics {
        if !used.iter().any(|own| own == OPTICS) {
            used.push(OPTICS.into());
        }
        extensions.insert(OPTICS.into(), value::json(&optics)?);
    }
    if !lights.is_empty() {
        extensions.insert(PUNCTUAL.into(), json!({ "lights": lights }));
    }
    used.sort();
    let mut list = |key: &str, items: Vec<Json>| {
        if !items.is_empty() {
            json.insert(key.into(), Json::Array(items));
        }
    };
    list("extensionsUsed", used.into_iter().map(Json::from).collect());
    list("extensionsRequired", required.into_iter().map(Json::from).collect());
    if !roots.is_empty() {
        list("scenes", vec![json!({ "nodes": roots })]);
    }
    list("nodes", nodes);
    list("meshes", meshes);
    list("materials", materials);
    for (key, items) in lists {
        list(key, items);
    }
    list("cameras", cameras);
    list("skins", skins);
    list("animations", animations);
    list("accessors", accessors);
    list("bufferViews", views);
    if !roots.is_empty() {
        json.insert("scene".into(), Json::from(0));
    }
    if !extensions.is_empty() {
        json.insert("extensions".into(), Json::Object(extensions));
    }
    let pictures: Vec<(PathBuf, Encoded)> =
        pictures.into_iter().map(|(file, picture)| (out.with_file_name(&folder).join(file), picture)).collect();
    let files = save(out, json, bytes, &pictures)?;
    Ok(Written { files, notes })
}

/// The root's attributes: those of the assembly, and the sky of a dome light.
fn root(document: &mut Document, assembly: &Assembly, out: &Path) -> Option<Value> {
    let Some(sky) = light::sky(document, assembly, out) else { return assembly.optics.clone() };
    let at = sky.at.clone();
    let version = || ("version".to_owned(), Value::new(Data::Number(1.0), at.clone()));
    let own = assembly.optics.as_ref().and_then(Value::table);
    let mut rows = own.map_or_else(|| vec![version()], <[_]>::to_vec);
    rows.push(("sky".into(), sky));
    Some(Value::new(Data::Table(rows), at))
}

/// Puts the files on disk, pictures and the buffer first. Returns them, the asset first.
fn save(
    out: &Path,
    mut json: Map<String, Json>,
    mut bytes: Vec<u8>,
    pictures: &[(PathBuf, Encoded)],
) -> Result<Vec<PathBuf>> {
    let buffer = |json: &mut Map<String, Json>, bytes: &[u8], uri: Option<String>| {
        if bytes.is_empty() {
            return;
        }
        let mut buffer = json!({ "byteLength": bytes.len() });
        if let Some(uri) = uri {
            buffer["uri"] = Json::from(uri);
        }
        json.insert("buffers".into(), json!([buffer]));
    };
    if out.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("glb")) {
        buffer(&mut json, &bytes, None);
        let mut text = Json::Object(json).to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        let glb = container(&text, &bytes).ok_or_else(|| {
            Error::new(Where::file(out), "the asset is larger than the 4 GiB of a .glb").expected("a .gltf")
        })?;
        write_atomic(out, &glb)?;
        return Ok(vec![out.to_owned()]);
    }
    let beside = out.with_extension("bin");
    let name = beside.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    buffer(&mut json, &bytes, Some(uri::encoded(&name)));
    let mut text = serde_json::to_string_pretty(&json)
        .map_err(|error| Error::new(Where::file(out), format!("cannot be written as JSON: {error}")))?;
    text.push('\n');
    let mut files = vec![out.to_owned()];
    files.extend(picture::save(pictures)?);
    if !bytes.is_empty() {
        write_atomic(&beside, &bytes)?;
        files.push(beside);
    }
    write_atomic(out, text.as_bytes())?;
    Ok(files)
}
