//! Values of attributes, of whatever precision, as numbers of one.

use openusd::gf::f16;
use openusd::sdf::Value;

/// Number of a scalar.
pub(super) fn number(value: &Value) -> Option<f64> {
    Some(match *value {
        Value::Float(value) => value.into(),
        Value::Double(value) => value,
        Value::Half(value) => value.to_f64(),
        Value::Int(value) => value.into(),
        Value::Uint(value) => value.into(),
        Value::Int64(value) => value as f64,
        Value::Uint64(value) => value as f64,
        Value::Uchar(value) => value.into(),
        Value::Bool(value) => f64::from(u8::from(value)),
        _ => return None,
    })
}

/// Whole numbers of an array, at least 0; others count as the largest.
pub(super) fn indices(value: &Value) -> Option<Vec<usize>> {
    let index = |value: i64| usize::try_from(value).unwrap_or(usize::MAX);
    Some(match value {
        Value::IntVec(list) => list.iter().map(|&value| index(value.into())).collect(),
        Value::UintVec(list) => list.iter().map(|&value| index(value.into())).collect(),
        Value::Int64Vec(list) => list.iter().map(|&value| index(value)).collect(),
        Value::Int(value) => vec![index((*value).into())],
        _ => return None,
    })
}

/// Text of a token, a string or an asset path as the file writes it.
pub(super) fn text(value: &Value) -> Option<String> {
    Some(match value {
        Value::Token(text) => text.as_str().to_owned(),
        Value::String(text) => text.clone(),
        Value::AssetPath(path) => path.asset_path().to_owned(),
        _ => return None,
    })
}

/// Words of an array of tokens or strings.
pub(super) fn words(value: &Value) -> Option<Vec<String>> {
    Some(match value {
        Value::TokenVec(list) => list.iter().map(|token| token.as_str().to_owned()).collect(),
        Value::StringVec(list) => list.clone(),
        _ => return None,
    })
}

/// Numbers of an array, or of a single number.
pub(super) fn numbers(value: &Value) -> Option<Vec<f64>> {
    Some(match value {
        Value::FloatVec(list) => list.iter().map(|&value| value.into()).collect(),
        Value::DoubleVec(list) => list.clone(),
        Value::HalfVec(list) => list.iter().map(|value| value.to_f64()).collect(),
        Value::IntVec(list) => list.iter().map(|&value| value.into()).collect(),
        other => vec![number(other)?],
    })
}

/// Elements of two numbers; those of three lose the last.
pub(super) fn pairs(value: &Value) -> Option<Vec<[f64; 2]>> {
    Some(match value {
        Value::Vec2fVec(list) => list.iter().map(|v| [v.x, v.y].map(f64::from)).collect(),
        Value::Vec2dVec(list) => list.iter().map(|v| [v.x, v.y]).collect(),
        Value::Vec2hVec(list) => list.iter().map(|v| [v.x, v.y].map(f16::to_f64)).collect(),
        Value::Vec2f(v) => vec![[v.x, v.y].map(f64::from)],
        Value::Vec2d(v) => vec![[v.x, v.y]],
        Value::Vec2h(v) => vec![[v.x, v.y].map(f16::to_f64)],
        other => triples(other)?.into_iter().map(|[x, y, _]| [x, y]).collect(),
    })
}

/// Elements of three numbers.
pub(super) fn triples(value: &Value) -> Option<Vec<[f64; 3]>> {
    Some(match value {
        Value::Vec3fVec(list) => list.iter().map(|v| [v.x, v.y, v.z].map(f64::from)).collect(),
        Value::Vec3dVec(list) => list.iter().map(|v| [v.x, v.y, v.z]).collect(),
        Value::Vec3hVec(list) => list.iter().map(|v| [v.x, v.y, v.z].map(f16::to_f64)).collect(),
        Value::Vec3f(v) => vec![[v.x, v.y, v.z].map(f64::from)],
        Value::Vec3d(v) => vec![[v.x, v.y, v.z]],
        Value::Vec3h(v) => vec![[v.x, v.y, v.z].map(f16::to_f64)],
        _ => return None,
    })
}

/// Four numbers.
pub(super) fn four(value: &Value) -> Option<[f64; 4]> {
    Some(match value {
        Value::Vec4f(v) => [v.x, v.y, v.z, v.w].map(f64::from),
        Value::Vec4d(v) => [v.x, v.y, v.z, v.w],
        Value::Vec4h(v) => [v.x, v.y, v.z, v.w].map(f16::to_f64),
        _ => return None,
    })
}

/// Quaternions in the order x, y, z, w.
pub(super) fn quaternions(value: &Value) -> Option<Vec<[f64; 4]>> {
    Some(match value {
        Value::QuathVec(list) => list.iter().map(|q| [q.x, q.y, q.z, q.w].map(f16::to_f64)).collect(),
        Value::QuatfVec(list) => list.iter().map(|q| [q.x, q.y, q.z, q.w].map(f64::from)).collect(),
        Value::QuatdVec(list) => list.iter().map(|q| [q.x, q.y, q.z, q.w]).collect(),
        Value::Quath(q) => vec![[q.x, q.y, q.z, q.w].map(f16::to_f64)],
        Value::Quatf(q) => vec![[q.x, q.y, q.z, q.w].map(f64::from)],
        Value::Quatd(q) => vec![[q.x, q.y, q.z, q.w]],
        _ => return None,
    })
}
