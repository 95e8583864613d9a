//! The binary buffer of a new asset: one buffer view per kind of data, accessors into them; of a `.glb` one view per picture.

use serde_json::{Value as Json, json};

/// Data of one kind, tightly packed.
#[derive(Debug, Default)]
struct View {
    bytes: Vec<u8>,
}

/// Views in the order of their indices.
const POSITIONS: usize = 0;
const NORMALS: usize = 1;
const UVS: usize = 2;
const COLORS: usize = 3;
const INDICES: usize = 4;
const JOINTS: usize = 5;
const WEIGHTS: usize = 6;
/// What no vertex has: inverse bind matrices and the keys of animations, whose views glTF keeps apart.
const BINDS: usize = 7;
const KEYS: usize = 8;
const TANGENTS: usize = 9;

#[derive(Debug, Default)]
pub struct Binary {
    views: [View; 10],
    /// (view, byte offset, the rest of the accessor)
    accessors: Vec<(usize, usize, Json)>,
}

impl Binary {
    /// An accessor of positions with their bounds.
    pub fn positions(&mut self, values: &[[f32; 3]]) -> usize {
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for value in values {
            low = std::array::from_fn(|i| low[i].min(value[i]));
            high = std::array::from_fn(|i| high[i].max(value[i]));
        }
        let wide = |bound: [f32; 3]| bound.map(f64::from);
        let more = json!({ "min": wide(low), "max": wide(high) });
        self.floats(POSITIONS, "VEC3", values, more)
    }
    pub fn normals(&mut self, values: &[[f32; 3]]) -> usize {
        self.floats(NORMALS, "VEC3", values, json!({}))
    }
    pub fn uvs(&mut self, values: &[[f32; 2]]) -> usize {
        self.floats(UVS, "VEC2", values, json!({}))
    }
    /// Unit directions and their sides.
    pub fn tangents(&mut self, values: &[[f32; 4]]) -> usize {
        self.floats(TANGENTS, "VEC4", values, json!({}))
    }
    /// Linear colours with alpha.
    pub fn colors(&mut self, values: &[[f32; 4]]) -> usize {
        self.floats(COLORS, "VEC4", values, json!({}))
    }
    /// Vertex indices of triangles.
    pub fn indices(&mut self, values: &[[u32; 3]]) -> usize {
        let bytes = values.as_flattened().iter().flat_map(|index| index.to_le_bytes());
        self.add(INDICES, bytes, values.len() * 3, json!({ "componentType": 5125, "type": "SCALAR" }))
    }

    /// Four joints a vertex.
    pub fn joints(&mut self, values: &[[u16; 4]]) -> usize {
        let bytes = values.as_flattened().iter().flat_map(|index| index.to_le_bytes());
        self.add(JOINTS, bytes, values.len(), json!({ "componentType": 5123, "type": "VEC4" }))
    }
    /// The weights of four joints a vertex.
    pub fn weights(&mut self, values: &[[f32; 4]]) -> usize {
        self.floats(WEIGHTS, "VEC4", values, json!({}))
    }
    pub fn matrices(&mut self, values: &[[f32; 16]]) -> usize {
        self.floats(BINDS, "MAT4", values, json!({}))
    }
    /// Animated vectors.
    pub fn vectors(&mut self, values: &[[f32; 3]]) -> usize {
        self.floats(KEYS, "VEC3", values, json!({}))
    }
    /// Animated rotations: x, y, z, w.
    pub fn quaternions(&mut self, values: &[[f32; 4]]) -> usize {
        self.floats(KEYS, "VEC4", values, json!({}))
    }
    /// Single numbers; those of times with their bounds, which glTF wants.
    pub fn numbers(&mut self, values: &[f32], are_times: bool) -> usize {
        let own: Vec<[f32; 1]> = values.iter().map(|x| [*x]).collect();
        let bound = |x: Option<&f32>| x.map_or(0.0, |x| f64::from(*x));
        let more = if are_times {
            json!({ "min": [bound(values.first())], "max": [bound(values.last())] })
        } else {
            json!({})
        };
        self.floats(KEYS, "SCALAR", &own, more)
    }

    fn floats<const N: usize>(&mut self, view: usize, kind: &str, values: &[[f32; N]], more: Json) -> usize {
        let mut rest = json!({ "componentType": 5126, "type": kind });
        if let (Some(rest), Json::Object(more)) = (rest.as_object_mut(), more) {
            rest.extend(more);
        }
        let bytes = values.as_flattened().iter().flat_map(|number| number.to_le_bytes());
        self.add(view, bytes, values.len(), rest)
    }
    fn add(&mut self, view: usize, bytes: impl Iterator<Item = u8>, count: usize, mut rest: Json) -> usize {
        let Some(own) = self.views.get_mut(view) else { return 0 };
        let offset = own.bytes.len();
        own.bytes.extend(bytes);
        rest["count"] = Json::from(count);
        self.accessors.push((view, offset, rest));
        self.accessors.len() - 1
    }

    /// The buffer's bytes, `bufferViews`, `accessors`.
    pub fn finish(self) -> (Vec<u8>, Vec<Json>, Vec<Json>) {
        let (mut bytes, mut views, mut places) = (Vec::new(), Vec::new(), [0; 10]);
        for (index, view) in self.views.into_iter().enumerate().filter(|(_, view)| !view.bytes.is_empty()) {
            places[index] = views.len();
            let mut json = json!({ "buffer": 0, "byteOffset": bytes.len(), "byteLength": view.bytes.len() });
            if !matches!(index, BINDS | KEYS) {
                json["target"] = Json::from(if index == INDICES { 34963 } else { 34962 });
            }
            let stride = match index {
                INDICES | BINDS | KEYS => None,
                UVS | JOINTS => Some(8),
                COLORS | WEIGHTS | TANGENTS => Some(16),
                _ => Some(12),
            };
            if let Some(stride) = stride {
                json["byteStride"] = Json::from(stride);
            }
            views.push(json);
            bytes.extend(view.bytes);
        }
        let accessor = |(view, offset, mut rest): (usize, usize, Json)| {
            rest["bufferView"] = Json::from(places.get(view).copied().unwrap_or_default());
            if offset > 0 {
                rest["byteOffset"] = Json::from(offset);
            }
            rest
        };
        (bytes, views, self.accessors.into_iter().map(accessor).collect())
    }
}
