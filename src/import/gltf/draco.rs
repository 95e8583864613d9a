//! `KHR_draco_mesh_compression`: a primitive's attributes and indices.

use super::at::At;
use super::buffers::Buffers;
use super::compressed::Array;
use super::notes::Ledger;
use draco_core::{DecodeLimits, DecoderBuffer, Mesh, MeshDecoder};
use eyebox_base::error::Result;

/// The possible lanes of an attribute; none for one that is not read.
fn lanes_of(name: &str) -> Option<&'static [usize]> {
    Some(match name {
        "POSITION" | "NORMAL" => &[3],
        "TEXCOORD_0" | "TEXCOORD_1" => &[2],
        "TANGENT" => &[4],
        "COLOR_0" => &[3, 4],
        _ if is_joints(name) || name.starts_with("WEIGHTS_") => &[4],
        _ => return None,
    })
}

/// Joints are numbers of things; all else is measured.
fn is_joints(name: &str) -> bool {
    name.starts_with("JOINTS_")
}

/// Decodes the stream of the primitive `at`, whose extension object is `extension`. Attributes come as floats, integers
/// scaled as their accessor's `normalized` says; joints as 16-bit numbers.
///
/// # Errors
/// A broken stream, one that decodes to more than the file can honestly mean, an attribute that it does not hold.
pub(super) fn decode(
    root: &At<'_>,
    at: &At<'_>,
    extension: &At<'_>,
    buffers: &Buffers<'_>,
    ledger: &mut Ledger,
) -> Result<Vec<Array>> {
    let mesh = stream(root, extension, buffers, ledger)?;
    let (points, faces) = (mesh.num_points(), mesh.num_faces());
    let ids = extension.want("attributes")?;
    let attributes = at.want("attributes")?;
    ledger.budget.charge(extension, faces, 24)?;
    let mut indices = Vec::with_capacity(faces.saturating_mul(12));
    for face in mesh.faces() {
        for point in face {
            indices.extend_from_slice(&point.0.to_le_bytes());
        }
    }
    let mut arrays =
        vec![Array { name: None, kind: "SCALAR", component: 5125, count: faces.saturating_mul(3), bytes: indices }];
    let names = ids.json.as_object().into_iter().flat_map(|ids| ids.keys());
    for (name, wanted) in names.filter_map(|name| Some((name, lanes_of(name)?))) {
        let (Some(id_at), Some(reference)) = (ids.get(name)?, attributes.get(name)?) else { continue };
        let id = u32::try_from(id_at.count()?).ok().and_then(|id| mesh.attribute_by_unique_id(id));
        let Some(attribute) = id else {
            return Err(id_at.fault("the Draco stream has no attribute of this id"));
        };
        let lanes = usize::from(attribute.num_components());
        let kind = match lanes {
            2 => "VEC2",
            3 => "VEC3",
            _ => "VEC4",
        };
        if !wanted.contains(&lanes) {
            let expected: Vec<String> = wanted.iter().map(usize::to_string).collect();
            return Err(id_at
                .fault(format!("a Draco attribute of {lanes} components"))
                .expected(expected.join(" or ")));
        }
        ledger.budget.charge(extension, points, lanes * 16)?;
        let floats = attribute.read_f32s(points, lanes);
        let name = Some(name.clone());
        if is_joints(name.as_deref().unwrap_or_default()) {
            let bytes = floats.into_iter().flat_map(|x| (x as u16).to_le_bytes()).collect();
            arrays.push(Array { name, kind, component: 5123, count: points, bytes });
            continue;
        }
        let scale = scale(root, &reference)?;
        let bytes = floats.into_iter().flat_map(|x| scaled(x, scale).to_le_bytes()).collect();
        arrays.push(Array { name, kind, component: 5126, count: points, bytes });
    }
    Ok(arrays)
}

/// The decoded mesh; the decoder is told what the budget allows before it makes anything.
fn stream(root: &At<'_>, extension: &At<'_>, buffers: &Buffers<'_>, ledger: &mut Ledger) -> Result<Mesh> {
    let views = root.list("bufferViews")?;
    let reference = extension.want("bufferView")?;
    let view = views.get(reference.index(views.len(), "buffer view")?);
    let view = view.ok_or_else(|| reference.fault("no such buffer view"))?;
    let buffer = view.want("buffer")?;
    let Some(Some(slice)) = buffers.data.get(buffer.index(buffers.data.len(), "buffer")?) else {
        return Err(buffer.fault("the buffer of a Draco stream has no bytes"));
    };
    let bytes = buffers.bytes(*slice);
    let (start, length) = (view.count_or("byteOffset", 0)?, view.want("byteLength")?.count()?);
    let inside = start.checked_add(length).and_then(|end| bytes.get(start..end));
    let inside = inside.ok_or_else(|| view.fault("the view is not inside its buffer"))?;
    let left = ledger.budget.left() as u64;
    // Corner tables and attribute maps take about 100 bytes a face beside what comes out.
    let limits =
        DecodeLimits::default().with_max_points(left / 64).with_max_faces(left / 128).with_max_decoded_bytes(left / 4);
    let mut mesh = Mesh::new();
    let mut source = DecoderBuffer::new(inside).with_limits(limits);
    MeshDecoder::new().decode(&mut source, &mut mesh).map_err(|error| {
        extension.fault(format!("the Draco stream cannot be decoded: {error}")).expected("a Draco triangle mesh")
    })?;
    Ok(mesh)
}

/// What an integer attribute is divided by: its accessor's `normalized` (glTF 2.0, section 3.11).
fn scale(root: &At<'_>, reference: &At<'_>) -> Result<Option<f32>> {
    let accessors = root.list("accessors")?;
    let Some(accessor) = accessors.get(reference.index(accessors.len(), "accessor")?) else { return Ok(None) };
    if !accessor.get("normalized")?.map_or(Ok(false), |flag| flag.flag())? {
        return Ok(None);
    }
    Ok(match accessor.want("componentType")?.count()? {
        5120 => Some(127.0),
        5121 => Some(255.0),
        5122 => Some(32767.0),
        5123 => Some(65535.0),
        _ => None,
    })
}

fn scaled(x: f32, scale: Option<f32>) -> f32 {
    scale.map_or(x, |most| (x / most).max(-1.0))
}
