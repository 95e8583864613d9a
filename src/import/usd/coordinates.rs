//! Texture coordinates on their way from a mesh to a picture: which set, and what nodes do to it.

use super::attribute::PrimView;
use super::network;
use super::reader::Reader;
use super::reads::{Coordinates, Set};
use super::shader::{self, End};
use super::value;
use eyebox_base::error::Result;

/// Rows of an affine map of texture coordinates.
pub(super) type Affine = [[f64; 3]; 2];

pub(super) const SAME: Affine = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// `first`, then `then`.
pub(super) fn after(first: Affine, then: Affine) -> Affine {
    then.map(|[a, b, c]| {
        let [p, q] = first;
        [a * p[0] + b * q[0], a * p[1] + b * q[1], a * p[2] + b * q[2] + c]
    })
}

pub(super) fn scaled([u, v]: [f64; 2]) -> Affine {
    [[u, 0.0, 0.0], [0.0, v, 0.0]]
}

pub(super) fn shifted([u, v]: [f64; 2]) -> Affine {
    [[1.0, 0.0, u], [0.0, 1.0, v]]
}

/// Against the clock.
pub(super) fn turned(deg: f64) -> Affine {
    let (sin, cos) = deg.to_radians().sin_cos();
    [[cos, -sin, 0.0], [sin, cos, 0.0]]
}

/// The one place that an input which is not connected says, if it is not; none of what is connected. UsdUVTexture's own is
/// (0, 0).
///
/// # Errors
/// What the library cannot read.
pub(super) fn constant(reader: &mut Reader, node: &PrimView, input: &str) -> Result<Option<[f64; 2]>> {
    Ok(match shader::follow(reader, node, input)? {
        End::Node(..) => None,
        End::Value(found, _) => Some(two(&found).unwrap_or([0.0; 2])),
        End::Nothing => Some([0.0; 2]),
    })
}

/// What becomes of the mesh's texture coordinates on their way to an input of a node, and which those are. What is not
/// connected has the first set (MaterialX 1.39, `defaultgeomprop="UV0"`).
///
/// # Errors
/// What the library cannot read.
pub(super) fn read(reader: &mut Reader, node: &PrimView, input: &str) -> Result<(Affine, Coordinates)> {
    // Nodes in a row.
    const MOST: usize = 32;
    let mut all = SAME;
    let first = Coordinates { set: Set::Numbered(0), fallback: [0.0; 2] };
    let mut next = shader::follow(reader, node, input)?;
    for _ in 0..MOST {
        let End::Node(here, _) = next else { return Ok((all, first)) };
        let id = shader::id(&here)?;
        let kind = network::kind(&id);
        if let Some(found) = source(reader, &here, kind, &id)? {
            return Ok((all, found));
        }
        let Some((own, before)) = step(reader, &here, kind)? else {
            let text = format!("the node `{id}` on texture coordinates is not used");
            reader.ledger.warn(here.at(), text);
            // What is below it may still say which set.
            let below = ["inputs:in", "inputs:in1", "inputs:texcoord"].into_iter().find(|name| here.has(name));
            let Some(below) = below else { return Ok((all, first)) };
            next = shader::follow(reader, &here, below)?;
            continue;
        };
        all = after(own, all);
        next = shader::follow(reader, &here, before)?;
    }
    Ok((all, first))
}

/// The set that a node reads from the mesh, if it is one that does.
fn source(reader: &mut Reader, node: &PrimView, kind: &str, id: &str) -> Result<Option<Coordinates>> {
    let (name, fallback) = match kind {
        "UsdPrimvarReader" => ("varname", "fallback"),
        "geompropvalue" => ("geomprop", "default"),
        "texcoord" => {
            let index = network::number(reader, node, "index", 0.0)?;
            return Ok(Some(Coordinates { set: Set::Numbered(index.max(0.0) as u32), fallback: [0.0; 2] }));
        }
        _ => return Ok(None),
    };
    let named = network::text(reader, node, name)?.filter(|name| !name.is_empty());
    let fallback = network::pair(reader, node, fallback, [0.0; 2])?.map(|x| x as f32);
    let set = match named {
        Some(named) => Set::Named(named),
        None => {
            reader.ledger.warn(node.at(), format!("`{id}` without `{name}`: the first set of texture coordinates"));
            Set::Numbered(0)
        }
    };
    Ok(Some(Coordinates { set, fallback }))
}

/// What a node does to coordinates, and the input that has them; none for one that is not known.
fn step(reader: &mut Reader, node: &PrimView, kind: &str) -> Result<Option<(Affine, &'static str)>> {
    let out = match kind {
        // UsdPreviewSurface 2.6, Transform2d: scaled, turned against the clock, moved.
        "UsdTransform2d" => {
            let scale = network::pair(reader, node, "scale", [1.0; 2])?;
            let shift = network::pair(reader, node, "translation", [0.0; 2])?;
            let turn = network::number(reader, node, "rotation", 0.0)?;
            (after(after(scaled(scale), turned(turn)), shifted(shift)), "inputs:in")
        }
        "place2d" => (placed(reader, node)?, "inputs:texcoord"),
        // MaterialX 1.39, rotate2d: a positive amount turns what is seen against the clock, and so the coordinates with it.
        "rotate2d" => (turned(-network::number(reader, node, "amount", 0.0)?), "inputs:in"),
        "multiply" | "divide" | "add" | "subtract" => return arithmetic(reader, node, kind),
        "dot" => (SAME, "inputs:in"),
        _ => return Ok(None),
    };
    Ok(Some(out))
}

/// MaterialX 1.39, place2d: about `pivot`, the picture is scaled, turned and moved, so that its coordinates are divided by
/// `scale`, turned with the clock, and `offset` is taken from them; in the other order where `operationorder` is 1.
fn placed(reader: &mut Reader, node: &PrimView) -> Result<Affine> {
    let pivot = network::pair(reader, node, "pivot", [0.0; 2])?;
    let scale = scaled(network::pair(reader, node, "scale", [1.0; 2])?.map(f64::recip));
    let turn = turned(-network::number(reader, node, "rotate", 0.0)?);
    let shift = shifted(network::pair(reader, node, "offset", [0.0; 2])?.map(|x| -x));
    let steps = if network::number(reader, node, "operationorder", 0.0)? == 1.0 {
        [shift, turn, scale]
    } else {
        [scale, turn, shift]
    };
    let all = steps.into_iter().fold(shifted(pivot.map(|x| -x)), after);
    Ok(after(all, shifted(pivot)))
}

/// Coordinates and a constant.
fn arithmetic(reader: &mut Reader, node: &PrimView, kind: &str) -> Result<Option<(Affine, &'static str)>> {
    let connected = |reader: &mut Reader, name: &str| -> Result<bool> {
        Ok(matches!(shader::follow(reader, node, name)?, End::Node(..)))
    };
    // Which of the two is the constant.
    let (name, before, first) = match (connected(reader, "inputs:in1")?, connected(reader, "inputs:in2")?) {
        (true, false) => ("in2", "inputs:in1", true),
        (false, true) => ("in1", "inputs:in2", false),
        (true, true) | (false, false) => return Ok(None),
    };
    let neutral = if matches!(kind, "multiply" | "divide") { 1.0 } else { 0.0 };
    let by = network::pair(reader, node, name, [neutral; 2])?;
    Ok(match (kind, first) {
        ("multiply", _) => Some((scaled(by), before)),
        ("divide", true) => Some((scaled(by.map(f64::recip)), before)),
        ("add", _) => Some((shifted(by), before)),
        ("subtract", true) => Some((shifted(by.map(|x| -x)), before)),
        ("subtract", false) => Some((after(scaled([-1.0; 2]), shifted(by)), before)),
        _ => None,
    })
}

/// Two numbers of a value; one stands for both.
pub(super) fn two(found: &openusd::sdf::Value) -> Option<[f64; 2]> {
    value::pair(found).or_else(|| value::number(found).map(|x| [x; 2]))
}
