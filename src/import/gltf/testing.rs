//! Small glTF assets made by hand, for tests of this reader and of whatever reads its assemblies.

use crate::{Assembly, ReadOptions};
use eyebox_base::error::Result;
use serde_json::{Value as Json, json};

/// An asset under construction: JSON that a test may edit at will, and one binary buffer.
#[derive(Debug, Clone)]
pub(crate) struct Builder {
    pub json: Json,
    pub bin: Vec<u8>,
}

impl Builder {
    pub fn new() -> Self {
        let json = json!({
            "asset": { "version": "2.0" }, "buffers": [], "bufferViews": [], "accessors": [],
            "meshes": [], "nodes": [],
        });
        Builder { json, bin: Vec::new() }
    }

    /// A unit square in the plane z = 0 (two triangles, counter-clockwise from +z), one node `SQUARE` with it.
    pub fn square() -> Self {
        let mut builder = Self::new();
        let positions = builder.floats("VEC3", &[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.]);
        let normals = builder.floats("VEC3", &[0., 0., 1.].repeat(4));
        let indices = builder.shorts(&[0, 1, 2, 0, 2, 3]);
        let attributes = json!({ "POSITION": positions, "NORMAL": normals });
        let mesh = builder.push("meshes", json!({ "primitives": [{ "attributes": attributes, "indices": indices }] }));
        builder.push("nodes", json!({ "name": "SQUARE", "mesh": mesh }));
        builder
    }

    /// Appends to a root list (made if absent) and returns the index.
    pub fn push(&mut self, list: &str, item: Json) -> usize {
        let list = &mut self.json[list];
        if list.is_null() {
            *list = json!([]);
        }
        let list = list.as_array_mut().expect("a list");
        list.push(item);
        list.len() - 1
    }

    /// A view of `bytes`, aligned to 4.
    pub fn view(&mut self, bytes: &[u8], stride: Option<usize>) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let offset = self.bin.len();
        self.bin.extend_from_slice(bytes);
        let mut view = json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() });
        if let Some(stride) = stride {
            view["byteStride"] = json!(stride);
        }
        self.push("bufferViews", view)
    }
    /// An accessor of packed elements.
    pub fn accessor(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes, None);
        let accessor = json!({ "bufferView": view, "componentType": component, "count": count, "type": kind });
        self.push("accessors", accessor)
    }
    pub fn floats(&mut self, kind: &str, numbers: &[f32]) -> usize {
        let lanes = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            "MAT4" => 16,
            other => panic!("{other}"),
        };
        let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.accessor(kind, 5126, numbers.len() / lanes, &bytes)
    }
    pub fn shorts(&mut self, numbers: &[u16]) -> usize {
        let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.accessor("SCALAR", 5123, numbers.len(), &bytes)
    }

    /// The asset as a `.glb`.
    pub fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"] = json!([{ "byteLength": self.bin.len() }]);
        let mut text = json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut bin = self.bin.clone();
        bin.resize(bin.len().next_multiple_of(4), 0);
        let mut out = b"glTF".to_vec();
        for word in [2, 12 + 8 + text.len() + 8 + bin.len(), text.len()] {
            out.extend_from_slice(&(word as u32).to_le_bytes());
        }
        out.extend_from_slice(b"JSON");
        out.extend_from_slice(&text);
        out.extend_from_slice(&(bin.len() as u32).to_le_bytes());
        out.extend_from_slice(b"BIN\0");
        out.extend_from_slice(&bin);
        out
    }
    /// The asset as a `.gltf` text with its buffer at `uri`, or inside it.
    pub fn gltf(&self, uri: Option<&str>) -> Vec<u8> {
        let mut json = self.json.clone();
        let inside = || format!("data:application/octet-stream;base64,{}", base64(&self.bin));
        let uri = uri.map_or_else(inside, str::to_owned);
        json["buffers"] = json!([{ "byteLength": self.bin.len(), "uri": uri }]);
        serde_json::to_vec_pretty(&json).expect("JSON")
    }
    /// What the reader makes of the `.glb`.
    pub fn read(&self) -> Result<Assembly> {
        self.read_at(&ReadOptions::default())
    }
    pub fn read_at(&self, options: &ReadOptions) -> Result<Assembly> {
        super::read_bytes(std::path::Path::new("test.glb"), &self.glb(), options)
    }
}

fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::new();
    for group in bytes.chunks(3) {
        let word = group.iter().chain(&[0, 0]).take(3).fold(0u32, |word, &byte| word << 8 | u32::from(byte));
        for i in 0..4 {
            let letter = LETTERS[(word >> (18 - 6 * i) & 63) as usize];
            out.push(if i <= group.len() { char::from(letter) } else { '=' });
        }
    }
    out
}
