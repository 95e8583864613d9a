//! Geometry that is packed by the libraries' own encoders and must come back.

use crate::ReadOptions;
use crate::gltf::meshopt::{Filter, Mode, unpacked};
use crate::gltf::testing::Builder;
use draco_core as draco;
use meshoptimizer_rs::{Workspace, codec};
use serde_json::json;

/// A grid of 9 × 9 vertices over the unit square, bent by x²/4: positions, normals of the plane, indices.
fn grid() -> (Vec<[f32; 3]>, Vec<u32>) {
    let at = |i: u32| i as f32 / 8.0;
    let positions = (0..81).map(|i| [at(i % 9), at(i / 9), at(i % 9).powi(2) / 4.0]).collect();
    let quad = |i: u32| [i, i + 1, i + 10, i, i + 10, i + 9];
    let corners = (0..72).filter(|i| i % 9 < 8).flat_map(quad).collect();
    (positions, corners)
}

fn extension(
    name: &str,
    view: usize,
    bytes: usize,
    stride: usize,
    count: usize,
    mode: &str,
    filter: &str,
) -> serde_json::Value {
    json!({ name: {
        "buffer": 0, "byteOffset": view, "byteLength": bytes, "byteStride": stride, "count": count, "mode": mode,
        "filter": filter,
    } })
}

/// Vertices of `stride` bytes, packed.
fn vertices<T: Copy, const N: usize>(values: &[T], bytes: fn(T) -> [u8; N], stride: usize) -> Vec<u8> {
    let plain: Vec<u8> = values.iter().flat_map(|value| bytes(*value)).collect();
    let (count, level) = (plain.len() / stride, codec::VertexEncoding::DEFAULT);
    codec::encode_vertex_buffer(&plain, count, stride, level, &mut Workspace::default()).unwrap()
}

/// The grid with all of its views compressed; the buffer that they stand for has no bytes.
fn meshopt_asset(name: &str) -> Builder {
    let (positions, indices) = grid();
    let mut builder = Builder::new();
    let packed = vertices(positions.as_flattened(), f32::to_le_bytes, 12);
    // Normals of the octahedral filter: +z is (0, 0, 127, 0) after decoding.
    let normals = vec![[0i8, 0, 127, 0]; positions.len()];
    let normals = vertices(normals.as_flattened(), i8::to_le_bytes, 4);
    let corners =
        codec::encode_index_buffer(&indices, codec::IndexEncoding::DEFAULT, &mut Workspace::default()).unwrap();
    for (bytes, stride, count, mode, filter) in [
        (&packed, 12, 81, "ATTRIBUTES", "NONE"),
        (&normals, 4, 81, "ATTRIBUTES", "OCTAHEDRAL"),
        (&corners, 4, indices.len(), "TRIANGLES", "NONE"),
    ] {
        builder.bin.resize(builder.bin.len().next_multiple_of(4), 0);
        let offset = builder.bin.len();
        builder.bin.extend_from_slice(bytes);
        let extensions = extension(name, offset, bytes.len(), stride, count, mode, filter);
        builder.push("bufferViews", json!({ "buffer": 1, "byteLength": stride * count, "extensions": extensions }));
    }
    builder.push("accessors", json!({ "bufferView": 0, "componentType": 5126, "count": 81, "type": "VEC3" }));
    builder.push(
        "accessors",
        json!({ "bufferView": 1, "componentType": 5120, "normalized": true, "count": 81, "type": "VEC3" }),
    );
    builder
        .push("accessors", json!({ "bufferView": 2, "componentType": 5125, "count": indices.len(), "type": "SCALAR" }));
    let attributes = json!({ "POSITION": 0, "NORMAL": 1 });
    builder.push("meshes", json!({ "primitives": [{ "attributes": attributes, "indices": 2 }] }));
    builder.push("nodes", json!({ "mesh": 0 }));
    builder.json["extensionsUsed"] = json!([name, "KHR_mesh_quantization"]);
    builder.json["extensionsRequired"] = json!([name, "KHR_mesh_quantization"]);
    builder
}

/// The `.glb` of `builder` with a second buffer that has a length only.
fn with_placeholder(builder: &Builder) -> Vec<u8> {
    let mut bytes = builder.clone();
    bytes.json["buffers"] = json!([]);
    let glb = bytes.glb();
    let size = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let mut json: serde_json::Value = serde_json::from_slice(&glb[20..20 + size]).unwrap();
    json["buffers"].as_array_mut().unwrap().push(json!({ "byteLength": 100_000 }));
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut out = glb[..8].to_vec();
    out.extend(((glb.len() - size + text.len()) as u32).to_le_bytes());
    out.extend((text.len() as u32).to_le_bytes());
    out.extend(b"JSON");
    out.extend(text);
    out.extend(&glb[20 + size..]);
    out
}

#[test]
fn meshopt_streams_come_back_exactly() {
    let (positions, indices) = grid();
    for name in ["EXT_meshopt_compression", "KHR_meshopt_compression"] {
        let glb = with_placeholder(&meshopt_asset(name));
        let assembly = crate::gltf::read_bytes(std::path::Path::new("a.glb"), &glb, &ReadOptions::default()).unwrap();
        let mesh = &assembly.meshes[0].mesh;
        assert_eq!(mesh.positions, positions);
        assert_eq!(mesh.triangles.len() * 3, indices.len());
        // The encoder may turn a triangle's corners round, not over.
        let turned = |t: [u32; 3]| {
            let least = (0..3).min_by_key(|&i| t[i]).unwrap();
            [t[least], t[(least + 1) % 3], t[(least + 2) % 3]]
        };
        let mut found: Vec<_> = mesh.triangles.iter().map(|&t| turned(t)).collect();
        let mut want: Vec<_> = indices.chunks(3).map(|c| turned([c[0], c[1], c[2]])).collect();
        found.sort_unstable();
        want.sort_unstable();
        assert_eq!(found, want);
        assert!(mesh.normals.iter().all(|n| n[2] > 0.99), "{:?}", mesh.normals[0]);
    }
}

/// Streams of the C++ library that defines the format come back as that decodes them, bit for bit; but for what filters make of
/// unit vectors by square roots of f32, which that library itself rounds otherwise with SIMD than without: the last bit.
#[test]
fn streams_of_the_reference_library() {
    let bytes = |hex: &serde_json::Value| -> Vec<u8> {
        let hex = hex.as_str().unwrap().as_bytes();
        hex.as_chunks::<2>()
            .0
            .iter()
            .map(|pair| u8::from_str_radix(str::from_utf8(pair).unwrap(), 16).unwrap())
            .collect()
    };
    let table: serde_json::Value =
        serde_json::from_str(include_str!("../../../../tests/data/meshopt_streams.json")).unwrap();
    let streams = table["streams"].as_array().unwrap();
    assert!(streams.len() > 10);
    for row in streams {
        let size = |key: &str| row[key].as_u64().unwrap() as usize;
        let (count, stride, stream) = (size("count"), size("byteStride"), bytes(&row["stream"]));
        let mode = match row["mode"].as_str().unwrap() {
            "ATTRIBUTES" => Mode::Attributes(Filter::parse(row["filter"].as_str().unwrap(), stride).unwrap()),
            "TRIANGLES" => Mode::Triangles,
            other => {
                assert_eq!(other, "INDICES");
                Mode::Indices
            }
        };
        let (found, plain) = (unpacked(mode, count, stride, &stream).unwrap(), bytes(&row["plain"]));
        match mode {
            Mode::Attributes(Filter::Octahedral | Filter::Quaternion) => {
                let numbers = |bytes: &[u8]| -> Vec<i32> {
                    let wide = stride == 8;
                    let short = |b: &[u8]| i32::from(i16::from_le_bytes([b[0], b[1]]));
                    if wide {
                        bytes.chunks(2).map(short).collect()
                    } else {
                        bytes.iter().map(|b| i32::from(*b as i8)).collect()
                    }
                };
                let (found, plain) = (numbers(&found), numbers(&plain));
                assert_eq!(found.len(), plain.len(), "{}", row["what"]);
                assert!(found.iter().zip(&plain).all(|(a, b)| (a - b).abs() <= 1), "{}", row["what"]);
            }
            Mode::Attributes(Filter::None | Filter::Exponential | Filter::Color) | Mode::Triangles | Mode::Indices => {
                assert_eq!(found, plain, "{}", row["what"]);
            }
        }
        // Cut short it is refused, and nothing panics.
        assert!((0..stream.len()).all(|length| unpacked(mode, count, stride, &stream[..length]).is_err()));
    }
}

#[test]
fn broken_meshopt_streams_are_faults() {
    let sound = meshopt_asset("EXT_meshopt_compression");
    for (view, key, value, what) in [
        (0, "byteStride", json!(13), "byteStride 13"),
        (0, "byteStride", json!(16), "stream is broken"),
        (0, "count", json!(4_000_000_000u64), "more memory"),
        (0, "mode", json!("ATRIBUTES"), "unknown mode"),
        (0, "filter", json!("OCTAHEDRAL"), "filter `OCTAHEDRAL` with byteStride 12"),
        (2, "count", json!(385), "385 indices"),
        (2, "byteLength", json!(20), "stream is broken"),
        (2, "byteOffset", json!(100_000), "compressed bytes from byte 100000"),
    ] {
        let mut broken = sound.clone();
        broken.json["bufferViews"][view]["extensions"]["EXT_meshopt_compression"][key] = value;
        let found =
            crate::gltf::read_bytes(std::path::Path::new("a.glb"), &with_placeholder(&broken), &ReadOptions::default());
        let fault = found.expect_err(what);
        assert!(fault.to_string().contains(what), "{what}: {fault}");
    }
}

/// The grid as a Draco primitive: positions with 16 bits.
fn draco_asset() -> Builder {
    let (positions, indices) = grid();
    let mut position = draco::PointAttribute::new();
    position.init(draco::GeometryAttributeType::Position, 3, draco::DataType::Float32, false, positions.len());
    for (i, point) in positions.iter().enumerate() {
        let bytes: Vec<u8> = point.iter().flat_map(|x| x.to_le_bytes()).collect();
        position.buffer_mut().write(i * 12, &bytes);
    }
    let mut mesh = draco::Mesh::new();
    mesh.set_num_points(positions.len());
    let id = mesh.add_attribute(position);
    mesh.set_num_faces(indices.len() / 3);
    for (i, face) in indices.chunks(3).enumerate() {
        mesh.set_face(draco::FaceIndex(i as u32), [face[0], face[1], face[2]].map(draco::PointIndex));
    }
    let id = mesh.attribute(id).unique_id();
    let mut encoder = draco::MeshEncoder::new();
    encoder.set_mesh(mesh);
    let mut out = draco::EncoderBuffer::new();
    let mut options = draco::EncoderOptions::new();
    options.set_attribute_int(0, "quantization_bits", 16);
    encoder.encode(&options, &mut out).unwrap();

    let mut builder = Builder::new();
    let view = builder.view(out.data(), None);
    builder.push("accessors", json!({ "componentType": 5126, "count": 81, "type": "VEC3" }));
    builder.push("accessors", json!({ "componentType": 5125, "count": indices.len(), "type": "SCALAR" }));
    let packed = json!({ "KHR_draco_mesh_compression": { "bufferView": view, "attributes": { "POSITION": id } } });
    let primitive = json!({ "attributes": { "POSITION": 0 }, "indices": 1, "extensions": packed });
    builder.push("meshes", json!({ "primitives": [primitive] }));
    builder.push("nodes", json!({ "mesh": 0 }));
    builder.json["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
    builder.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    builder
}

#[test]
fn draco_streams_come_back_to_half_a_step() {
    let assembly = draco_asset().read().unwrap();
    let mesh = &assembly.meshes[0].mesh;
    let (positions, indices) = grid();
    assert_eq!(mesh.triangles.len() * 3, indices.len());
    // 16 bits over an extent of 1: half a step is 7.6e-6. Every corner is near one of the grid.
    for point in &mesh.positions {
        let near = |p: &[f32; 3]| (0..3).all(|i| (p[i] - point[i]).abs() < 8e-6);
        assert!(positions.iter().any(near), "{point:?}");
    }
    let area = |corners: &mut dyn Iterator<Item = [[f32; 3]; 3]>| -> f64 {
        corners
            .map(|[a, b, c]| {
                let [a, b, c] = [a, b, c].map(|p| glam::DVec3::from(p.map(f64::from)));
                (b - a).cross(c - a).z / 2.0
            })
            .sum()
    };
    let found = area(&mut mesh.triangles.iter().map(|t| t.map(|i| mesh.positions[i as usize])));
    assert!((found - 1.0).abs() < 1e-4, "projected area with sign: {found}");
}

#[test]
fn broken_draco_streams_are_faults() {
    let sound = draco_asset();
    let mut wrong = sound.clone();
    wrong.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]["attributes"]["POSITION"] =
        json!(7);
    assert!(wrong.read().unwrap_err().what.contains("no attribute of this id"));
    let mut opened = 0;
    for (place, flip) in (0..sound.bin.len()).flat_map(|i| [(i, 0x01u8), (i, 0xFF)]) {
        let mut broken = sound.clone();
        broken.bin[place] ^= flip;
        opened += usize::from(broken.read().is_ok());
    }
    // Some flips only move a vertex.
    assert!(opened < 2 * sound.bin.len());
}
