//! Properties of affine transforms.

use glam::{DMat3, DMat4, DVec3, Mat3};

/// Transform of normals for points that are transformed by `matrix`: the inverse transpose up to a positive factor. It
/// is made of cofactors, so that it exists for a flattening matrix too.
pub(super) fn normal_matrix(matrix: &DMat4) -> DMat3 {
    let [x, y, z] = axes(matrix);
    let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    if is_mirrored(matrix) { -cofactors } else { cofactors }
}

/// Whether the matrix turns right-handed frames into left-handed ones.
pub(super) fn is_mirrored(matrix: &DMat4) -> bool {
    let [x, y, z] = axes(matrix);
    x.cross(y).dot(z) < 0.0
}

/// Images of the unit axes.
pub(super) fn axes(matrix: &DMat4) -> [DVec3; 3] {
    [matrix.x_axis.truncate(), matrix.y_axis.truncate(), matrix.z_axis.truncate()]
}

/// Whether the three axes are orthogonal and equally long, to within `tolerance` of their length.
pub(super) fn is_similarity(matrix: &DMat4, tolerance: f64) -> bool {
    let [x, y, z] = axes(matrix);
    let limit = tolerance * x.length_squared();
    let even = |axis: DVec3| (axis.length_squared() - x.length_squared()).abs() <= 2.0 * limit;
    even(y) && even(z) && [x.dot(y), y.dot(z), z.dot(x)].iter().all(|cosine| cosine.abs() <= limit)
}

/// Linear part of a matrix, made exactly orthogonal; `None` where it is not orthogonal to the precision of printed
/// scene files.
pub(super) fn orthogonal(matrix: &DMat4) -> Option<Mat3> {
    let [x, y, z] = axes(matrix);
    if !is_similarity(matrix, 1.0e-3) || (x.length() - 1.0).abs() > 1.0e-3 {
        return None;
    }
    let x = x.normalize();
    let y = (y - y.dot(x) * x).normalize();
    let z = x.cross(y) * x.cross(y).dot(z).signum();
    Some(Mat3::from_cols(x.as_vec3(), y.as_vec3(), z.as_vec3()))
}
