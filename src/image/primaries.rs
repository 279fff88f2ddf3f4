//! Primaries and white points of pictures, and the matrix that takes their colors to linear sRGB.

use glam::{DMat3, DVec3};

/// Chromaticities `x`, `y` of red, green, blue and white.
pub(super) type Primaries = [[f32; 2]; 4];

/// Primaries and white point of sRGB and of Rec. 709.
pub(super) const SRGB: Primaries = [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], [0.3127, 0.329]];

/// Entries of a matrix below which it counts as the identity: writers round the primaries of sRGB in different ways.
const LEAST_DIFFERENCE: f64 = 2.0e-3;

/// Matrix, row by row, that takes a color to linear sRGB; `None` where the primaries are those of sRGB. As in Mitsuba, the white point is not
/// adapted: the picture of a white under another light keeps its tint.
///
/// # Errors
/// Where no light has such primaries.
pub(super) fn to_srgb(primaries: &Primaries) -> Result<Option<[[f32; 3]; 3]>, String> {
    let matrix = xyz_from(&SRGB).inverse() * xyz_from(primaries);
    if !matrix.is_finite() {
        return Err("its `chromaticities` are no primaries of a picture; save it without them".to_owned());
    }
    if matrix.abs_diff_eq(DMat3::IDENTITY, LEAST_DIFFERENCE) {
        return Ok(None);
    }
    Ok(Some(matrix.transpose().to_cols_array_2d().map(|row| row.map(|entry| entry as f32))))
}

/// Matrix from a color to CIE XYZ, of which white has the luminance 1.
fn xyz_from(primaries: &Primaries) -> DMat3 {
    let [red, green, blue, white] =
        primaries.map(|[x, y]| DVec3::new(x.into(), y.into(), 1.0 - f64::from(x) - f64::from(y)));
    let columns = DMat3::from_cols(red, green, blue);
    columns * DMat3::from_diagonal(columns.inverse() * (white / white.y))
}

#[test]
fn colors_of_other_primaries() {
    let apply = |primaries: Primaries| {
        let matrix = to_srgb(&primaries).unwrap().unwrap();
        matrix.map(|row| row[0] * 0.5 + row[1] * 0.3 + row[2] * 0.2)
    };
    let close =
        |a: [f32; 3], b: [f32; 3]| assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 2.0e-3), "{a:?} is not {b:?}");
    // The values are those of Mitsuba 3.9: AP1, and CIE XYZ itself.
    close(apply([[0.713, 0.293], [0.165, 0.83], [0.128, 0.044], [0.32168, 0.33767]]), [0.668, 0.273, 0.163]);
    close(apply([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [1.0 / 3.0, 1.0 / 3.0]]), [1.060, 0.086, 0.178]);
    assert_eq!(to_srgb(&SRGB), Ok(None));
    assert_eq!(to_srgb(&[[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], [0.31271, 0.32902]]), Ok(None));
    assert!(to_srgb(&[[0.3, 0.3]; 4]).is_err() && to_srgb(&[[f32::NAN; 2]; 4]).is_err());
}
