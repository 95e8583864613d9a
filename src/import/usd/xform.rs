//! The local transform of a prim: `xformOpOrder` and its ops (UsdGeomXformable), in f64.

use super::attribute::PrimView;
use super::notes::Ledger;
use super::value;
use crate::gltf::transform::is_singular;
use eyebox_base::Code;
use eyebox_base::error::Result;
use glam::{DAffine3, DMat3, DQuat, DVec3};
use openusd::sdf::Value;

/// Prim → parent, and whether the parent's own transform is to be left out (`!resetXformStack!`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Local {
    pub transform: DAffine3,
    pub resets: bool,
}

impl Local {
    pub const IDENTITY: Local = Local { transform: DAffine3::IDENTITY, resets: false };
}

const RESET: &str = "!resetXformStack!";
const INVERT: &str = "!invert!";
const PREFIX: &str = "xformOp:";

/// One op with its value.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Op {
    Translate(DVec3),
    Scale(DVec3),
    Orient(DQuat),
    /// By `degrees[i]` about `axes[i]` (0 is x), the first first.
    Rotate {
        degrees: [f64; 3],
        axes: [usize; 3],
    },
    Transform(DAffine3),
}

/// # Errors
/// An op with a value of another type, a matrix that is not affine, numbers that overflow.
pub(super) fn local(view: &PrimView, ledger: &mut Ledger) -> Result<Local> {
    let Some(order) = view.tokens("xformOpOrder")? else { return Ok(Local::IDENTITY) };
    if order.is_empty() {
        return Ok(Local::IDENTITY);
    }
    // Prims without a type and scopes are no UsdGeomXformable.
    if matches!(view.type_name()?.as_str(), "" | "Scope") {
        let text = "transform ops on a prim whose type has no transform: ignored, as USD does";
        ledger.warn(view.at_property("xformOpOrder"), text);
        return Ok(Local::IDENTITY);
    }
    let (mut ops, mut resets) = (Vec::with_capacity(order.len()), false);
    for name in &order {
        if name == RESET {
            resets = true;
            ops.clear();
        } else if name.starts_with(RESET) {
            // Only the word alone resets.
            let text = format!("`{name}` is no transform op: left out, as USD does; `{RESET}` stands alone");
            ledger.warn(view.at_property("xformOpOrder"), text);
        } else if let Some(op) = read(view, name, ledger)? {
            ops.push(op);
        }
    }
    let transform = product(&ops);
    if !transform.is_finite() {
        return Err(view
            .fault_in("xformOpOrder", "the prim's transform overflows or inverts a singular op")
            .expected("finite numbers"));
    }
    if is_singular(transform) {
        ledger.warn_of(Code::PartFlattened, view.at(), "a singular transform: it flattens whatever is below the prim");
    }
    Ok(Local { transform, resets })
}

fn read(view: &PrimView, name: &str, ledger: &mut Ledger) -> Result<Option<Op>> {
    let (name, inverse) = name.strip_prefix(INVERT).map_or((name, false), |name| (name, true));
    let Some(kind) = name.strip_prefix(PREFIX).map(|rest| rest.split(':').next().unwrap_or(rest)) else {
        return Err(view.fault_in("xformOpOrder", format!("`{name}` is no transform op")).expected("xformOp:…"));
    };
    let Some(found) = view.get(name)? else {
        ledger.warn(view.at_property("xformOpOrder"), format!("the transform op `{name}` has no value: left out"));
        return Ok(None);
    };
    let wrong = |expected: &str| view.fault_in(name, "a value of another type").expected(expected);
    let triple = || value::triple(&found).map(DVec3::from).ok_or_else(|| wrong("three numbers"));
    let single = || value::number(&found).ok_or_else(|| wrong("a number"));
    // The value is about x, y and z, whatever the order of the turns.
    let about = |axes: [usize; 3]| -> Result<Op> {
        let by = triple()?.to_array();
        Ok(Op::Rotate { degrees: axes.map(|axis| by[axis]), axes })
    };
    let one_axis = |axis: usize| -> Result<Op> {
        let mut degrees = [0.0; 3];
        degrees[0] = single()?;
        Ok(Op::Rotate { degrees, axes: [axis, (axis + 1) % 3, (axis + 2) % 3] })
    };
    let along = |axis: usize, rest: f64| -> Result<DVec3> {
        let mut out = [rest; 3];
        out[axis] = single()?;
        Ok(DVec3::from(out))
    };
    let op = match kind {
        "translate" => Op::Translate(triple()?),
        "translateX" => Op::Translate(along(0, 0.0)?),
        "translateY" => Op::Translate(along(1, 0.0)?),
        "translateZ" => Op::Translate(along(2, 0.0)?),
        "scale" => Op::Scale(triple()?),
        "scaleX" => Op::Scale(along(0, 1.0)?),
        "scaleY" => Op::Scale(along(1, 1.0)?),
        "scaleZ" => Op::Scale(along(2, 1.0)?),
        "rotateX" => one_axis(0)?,
        "rotateY" => one_axis(1)?,
        "rotateZ" => one_axis(2)?,
        "rotateXYZ" => about([0, 1, 2])?,
        "rotateXZY" => about([0, 2, 1])?,
        "rotateYXZ" => about([1, 0, 2])?,
        "rotateYZX" => about([1, 2, 0])?,
        "rotateZXY" => about([2, 0, 1])?,
        "rotateZYX" => about([2, 1, 0])?,
        "orient" => {
            let xyzw = value::quaternion(&found).ok_or_else(|| wrong("a quaternion"))?;
            Op::Orient(rotation(view, name, xyzw, ledger)?)
        }
        "transform" => Op::Transform(matrix(view, name, &found, ledger)?),
        _ => {
            let what = format!("`{name}` is no transform op that USD knows");
            return Err(view.fault_in("xformOpOrder", what).nearest(kind, KINDS.iter().copied()));
        }
    };
    Ok(Some(if inverse { op.inverse() } else { op }))
}

const KINDS: [&str; 18] = [
    "translate",
    "translateX",
    "translateY",
    "translateZ",
    "scale",
    "scaleX",
    "scaleY",
    "scaleZ",
    "rotateX",
    "rotateY",
    "rotateZ",
    "rotateXYZ",
    "rotateXZY",
    "rotateYXZ",
    "rotateYZX",
    "rotateZXY",
    "rotateZYX",
    "transform",
];

/// The quaternion (x, y, z, w) at unit length, by the same arithmetic as glTF's; USD takes one of length 0 for no
/// rotation.
pub(super) fn rotation(view: &PrimView, name: &str, xyzw: [f64; 4], ledger: &mut Ledger) -> Result<DQuat> {
    let quaternion = DQuat::from_array(xyzw);
    if !quaternion.is_finite() {
        return Err(view.fault_in(name, "a quaternion that is not finite").expected("finite numbers"));
    }
    let largest = xyzw.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    if largest == 0.0 {
        ledger.warn(view.at_property(name), "a rotation of length 0: taken as none");
        return Ok(DQuat::IDENTITY);
    }
    if (quaternion.length() - 1.0).abs() > 1e-3 {
        ledger.warn(view.at_property(name), "a rotation that is not a unit quaternion: normalised");
    }
    Ok((quaternion / largest).normalize())
}

/// Exactly the matrix in the file. USD writes rows for row vectors, which are our columns. Of a matrix that is not affine
/// the affine part is taken, with a warning.
fn matrix(view: &PrimView, name: &str, found: &Value, ledger: &mut Ledger) -> Result<DAffine3> {
    let Some(m) = value::matrix(found) else {
        return Err(view.fault_in(name, "a value of another type").expected("a matrix4d"));
    };
    let last = [m[3], m[7], m[11], m[15] - 1.0];
    if last.iter().any(|x| x.is_nan() || x.abs() > 1e-6) {
        let text = "the matrix is not affine (its last column is not 0, 0, 0, 1): its affine part is taken";
        ledger.warn(view.at_property(name), text);
    }
    let row = |r: usize| DVec3::new(m[4 * r], m[4 * r + 1], m[4 * r + 2]);
    Ok(DAffine3 { matrix3: DMat3::from_cols(row(0), row(1), row(2)), translation: row(3) })
}

impl Op {
    fn inverse(self) -> Op {
        match self {
            Op::Translate(by) => Op::Translate(-by),
            Op::Scale(by) => Op::Scale(by.recip()),
            Op::Orient(by) => Op::Orient(by.conjugate()),
            Op::Rotate { degrees: [a, b, c], axes: [x, y, z] } => Op::Rotate { degrees: [-c, -b, -a], axes: [z, y, x] },
            Op::Transform(by) => Op::Transform(by.inverse()),
        }
    }
    fn affine(self) -> DAffine3 {
        match self {
            Op::Translate(by) => DAffine3::from_translation(by),
            Op::Scale(by) => DAffine3::from_scale(by),
            Op::Orient(by) => DAffine3::from_quat(by),
            Op::Rotate { degrees: [a, b, c], axes: [x, y, z] } => {
                DAffine3::from_mat3(about(z, c) * about(y, b) * about(x, a))
            }
            Op::Transform(by) => by,
        }
    }
}

/// Points meet the last op of the order first. The common translate, orient, scale is put together as glTF's is.
fn product(ops: &[Op]) -> DAffine3 {
    if let [Op::Transform(only)] = ops {
        return *only;
    }
    let (mut rest, mut translation, mut orient, mut scale) = (ops, DVec3::ZERO, DQuat::IDENTITY, DVec3::ONE);
    if let [Op::Translate(by), tail @ ..] = rest {
        (translation, rest) = (*by, tail);
    }
    if let [Op::Orient(by), tail @ ..] = rest {
        (orient, rest) = (*by, tail);
    }
    if let [Op::Scale(by), tail @ ..] = rest {
        (scale, rest) = (*by, tail);
    }
    if rest.is_empty() {
        return DAffine3::from_scale_rotation_translation(scale, orient, translation);
    }
    ops.iter().fold(DAffine3::IDENTITY, |product, op| product * op.affine())
}

/// A rotation about an axis; exact for quarter turns.
fn about(axis: usize, degrees: f64) -> DMat3 {
    let (sin, cos) = sin_cos(degrees);
    match axis {
        0 => DMat3::from_cols(DVec3::X, DVec3::new(0.0, cos, sin), DVec3::new(0.0, -sin, cos)),
        1 => DMat3::from_cols(DVec3::new(cos, 0.0, -sin), DVec3::Y, DVec3::new(sin, 0.0, cos)),
        _ => DMat3::from_cols(DVec3::new(cos, sin, 0.0), DVec3::new(-sin, cos, 0.0), DVec3::Z),
    }
}

fn sin_cos(degrees: f64) -> (f64, f64) {
    let turned = degrees % 360.0;
    match turned {
        0.0 => (0.0, 1.0),
        90.0 | -270.0 => (1.0, 0.0),
        180.0 | -180.0 => (0.0, -1.0),
        270.0 | -90.0 => (-1.0, 0.0),
        _ => turned.to_radians().sin_cos(),
    }
}
