//! From USD's value types, of any precision, to the few that are needed here. `None` is a value of another type.

use openusd::sdf::Value;

/// A scalar.
pub(super) fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Bool(x) => Some(f64::from(u8::from(*x))),
        Value::Uchar(x) => Some(f64::from(*x)),
        Value::Int(x) => Some(f64::from(*x)),
        Value::Uint(x) => Some(f64::from(*x)),
        Value::Int64(x) => Some(*x as f64),
        Value::Uint64(x) => Some(*x as f64),
        Value::Half(x) => Some(x.to_f64()),
        Value::Float(x) => Some(f64::from(*x)),
        Value::Double(x) => Some(*x),
        Value::TimeCode(x) => Some(x.0),
        _ => None,
    }
}

pub(super) fn flag(value: &Value) -> Option<bool> {
    match value {
        Value::Bool(x) => Some(*x),
        other => number(other).map(|x| x != 0.0),
    }
}

/// Tokens and strings.
pub(super) fn text(value: &Value) -> Option<&str> {
    match value {
        Value::Token(x) => Some(x.as_str()),
        Value::String(x) => Some(x),
        _ => None,
    }
}

pub(super) fn texts(value: Value) -> Option<Vec<String>> {
    match value {
        Value::TokenVec(x) => Some(x.iter().map(|token| token.as_str().to_owned()).collect()),
        Value::StringVec(x) => Some(x),
        _ => None,
    }
}

/// Floating-point numbers of any precision, or whole ones.
pub(super) fn wide_numbers(value: Value) -> Option<Vec<f64>> {
    match value {
        Value::HalfVec(x) => Some(x.into_iter().map(|x| x.to_f64()).collect()),
        Value::FloatVec(x) => Some(x.into_iter().map(f64::from).collect()),
        Value::DoubleVec(x) => Some(x),
        other => integers(other).map(|all| all.into_iter().map(|x| x as f64).collect()),
    }
}

/// A vector, point or colour of three.
pub(super) fn triple(value: &Value) -> Option<[f64; 3]> {
    match value {
        Value::Vec3h(x) => Some([x.x, x.y, x.z].map(|x| x.to_f64())),
        Value::Vec3f(x) => Some([x.x, x.y, x.z].map(f64::from)),
        Value::Vec3d(x) => Some([x.x, x.y, x.z]),
        Value::Vec3i(x) => Some([x.x, x.y, x.z].map(f64::from)),
        _ => None,
    }
}

/// Four numbers; the fourth of three is 1.
pub(super) fn four(value: &Value) -> Option<[f64; 4]> {
    match value {
        Value::Vec4h(x) => Some([x.x, x.y, x.z, x.w].map(|x| x.to_f64())),
        Value::Vec4f(x) => Some([x.x, x.y, x.z, x.w].map(f64::from)),
        Value::Vec4d(x) => Some([x.x, x.y, x.z, x.w]),
        other => triple(other).map(|[x, y, z]| [x, y, z, 1.0]),
    }
}

/// Two numbers.
pub(super) fn pair(value: &Value) -> Option<[f64; 2]> {
    match value {
        Value::Vec2h(x) => Some([x.x, x.y].map(|x| x.to_f64())),
        Value::Vec2f(x) => Some([x.x, x.y].map(f64::from)),
        Value::Vec2d(x) => Some([x.x, x.y]),
        _ => None,
    }
}

/// A quaternion as x, y, z, w.
pub(super) fn quaternion(value: &Value) -> Option<[f64; 4]> {
    match value {
        Value::Quath(q) => Some([q.x, q.y, q.z, q.w].map(|x| x.to_f64())),
        Value::Quatf(q) => Some([q.x, q.y, q.z, q.w].map(f64::from)),
        Value::Quatd(q) => Some([q.x, q.y, q.z, q.w]),
        _ => None,
    }
}

pub(super) fn quaternions(value: Value) -> Option<Vec<[f64; 4]>> {
    match value {
        Value::QuathVec(x) => Some(x.into_iter().map(|q| [q.x, q.y, q.z, q.w].map(|x| x.to_f64())).collect()),
        Value::QuatfVec(x) => Some(x.into_iter().map(|q| [q.x, q.y, q.z, q.w].map(f64::from)).collect()),
        Value::QuatdVec(x) => Some(x.into_iter().map(|q| [q.x, q.y, q.z, q.w]).collect()),
        _ => None,
    }
}

/// Rows of a matrix for row vectors, as USD writes it.
pub(super) fn matrix(value: &Value) -> Option<[f64; 16]> {
    match value {
        Value::Matrix4d(m) => Some(m.0),
        _ => None,
    }
}

pub(super) fn integers(value: Value) -> Option<Vec<i64>> {
    match value {
        Value::IntVec(x) => Some(x.into_iter().map(i64::from).collect()),
        Value::UintVec(x) => Some(x.into_iter().map(i64::from).collect()),
        Value::Int64Vec(x) => Some(x),
        Value::Uint64Vec(x) => Some(x.into_iter().map(|x| i64::try_from(x).unwrap_or(i64::MAX)).collect()),
        Value::UcharVec(x) => Some(x.into_iter().map(i64::from).collect()),
        _ => None,
    }
}

/// Counts and indices, which are `int[]`: no copy where they are.
pub(super) fn ints(value: Value) -> Option<Vec<i32>> {
    match value {
        Value::IntVec(x) => Some(x),
        other => {
            let clamp = |x: i64| i32::try_from(x).unwrap_or(-1);
            integers(other).map(|all| all.into_iter().map(clamp).collect())
        }
    }
}

pub(super) fn triples(value: Value) -> Option<Vec<[f32; 3]>> {
    match value {
        Value::Vec3hVec(x) => Some(x.into_iter().map(|p| [p.x, p.y, p.z].map(|x| x.to_f32())).collect()),
        Value::Vec3fVec(x) => Some(x.into_iter().map(Into::into).collect()),
        Value::Vec3dVec(x) => Some(x.into_iter().map(|p| [p.x, p.y, p.z].map(|x| x as f32)).collect()),
        _ => None,
    }
}

/// As [`triples`], in f64.
pub(super) fn wide_triples(value: Value) -> Option<Vec<[f64; 3]>> {
    match value {
        Value::Vec3dVec(x) => Some(x.into_iter().map(Into::into).collect()),
        other => triples(other).map(|all| all.into_iter().map(|p| p.map(f64::from)).collect()),
    }
}

pub(super) fn pairs(value: Value) -> Option<Vec<[f32; 2]>> {
    match value {
        Value::Vec2hVec(x) => Some(x.into_iter().map(|p| [p.x, p.y].map(|x| x.to_f32())).collect()),
        Value::Vec2fVec(x) => Some(x.into_iter().map(Into::into).collect()),
        Value::Vec2dVec(x) => Some(x.into_iter().map(|p| [p.x, p.y].map(|x| x as f32)).collect()),
        // The third coordinate of texCoord3f says nothing for a picture.
        Value::Vec3hVec(_) | Value::Vec3fVec(_) | Value::Vec3dVec(_) => {
            triples(value).map(|all| all.into_iter().map(|[u, v, _]| [u, v]).collect())
        }
        _ => None,
    }
}

pub(super) fn numbers(value: Value) -> Option<Vec<f32>> {
    match value {
        Value::HalfVec(x) => Some(x.into_iter().map(|x| x.to_f32()).collect()),
        Value::FloatVec(x) => Some(x),
        Value::DoubleVec(x) => Some(x.into_iter().map(|x| x as f32).collect()),
        _ => None,
    }
}
