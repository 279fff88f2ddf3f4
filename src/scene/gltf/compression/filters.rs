//! Filters of `EXT_meshopt_compression` and `KHR_meshopt_compression`, which turn decoded elements into what accessors describe.

use glam::{Vec2, Vec3};

/// Filter of decoded elements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Filter {
    None,
    Octahedral,
    Quaternion,
    Exponential,
    Color,
}

impl Filter {
    /// Filter by its name, if elements of `stride` bytes may have it.
    pub fn of(name: &str, stride: usize) -> Option<Self> {
        let (filter, fits) = match name {
            "NONE" => (Self::None, true),
            "OCTAHEDRAL" => (Self::Octahedral, matches!(stride, 4 | 8)),
            "QUATERNION" => (Self::Quaternion, stride == 8),
            "EXPONENTIAL" => (Self::Exponential, stride.is_multiple_of(4)),
            "COLOR" => (Self::Color, matches!(stride, 4 | 8)),
            _ => return None,
        };
        fits.then_some(filter)
    }

    /// Applies the filter to elements of `stride` bytes.
    pub fn apply(self, elements: &mut [u8], stride: usize) {
        match (self, stride) {
            (Self::None, _) => {}
            (Self::Octahedral, 4) => signed_bytes(elements, |bytes| octahedral(bytes, f32::from(i8::MAX))),
            (Self::Octahedral, _) => shorts(elements, |shorts| octahedral(shorts, f32::from(i16::MAX))),
            (Self::Quaternion, _) => shorts(elements, quaternion),
            (Self::Exponential, _) => words(elements, exponential),
            (Self::Color, 4) => {
                for four in elements.as_chunks_mut::<4>().0 {
                    let [y, co, cg, alpha] = *four;
                    let input = [i32::from(y), i32::from(co as i8), i32::from(cg as i8), i32::from(alpha)];
                    *four = color(input, f32::from(u8::MAX)).map(|value| value as u8);
                }
            }
            (Self::Color, _) => {
                for eight in elements.as_chunks_mut::<8>().0 {
                    let [y, co, cg, alpha] = shorts_of(eight);
                    let input = [i32::from(y as u16), i32::from(co), i32::from(cg), i32::from(alpha as u16)];
                    put_shorts(eight, color(input, f32::from(u16::MAX)).map(|value| value as u16 as i16));
                }
            }
        }
    }
}

fn signed_bytes(elements: &mut [u8], filter: impl Fn([f32; 4]) -> [f32; 3]) {
    for four in elements.as_chunks_mut::<4>().0 {
        let [x, y, z] = filter(four.map(|byte| f32::from(byte as i8)));
        *four = [x as i8 as u8, y as i8 as u8, z as i8 as u8, four[3]];
    }
}

fn shorts<const N: usize>(elements: &mut [u8], filter: impl Fn([f32; 4]) -> [f32; N]) {
    for eight in elements.as_chunks_mut::<8>().0 {
        let mut values = shorts_of(eight);
        let filtered = filter(values.map(f32::from));
        values.iter_mut().zip(filtered).for_each(|(value, filtered)| *value = filtered as i16);
        put_shorts(eight, values);
    }
}

fn words(elements: &mut [u8], filter: impl Fn(i32) -> f32) {
    for word in elements.as_chunks_mut::<4>().0 {
        *word = filter(i32::from_le_bytes(*word)).to_le_bytes();
    }
}

fn shorts_of(eight: &[u8; 8]) -> [i16; 4] {
    std::array::from_fn(|at| i16::from_le_bytes([eight[2 * at], eight[2 * at + 1]]))
}

fn put_shorts(eight: &mut [u8; 8], values: [i16; 4]) {
    for (pair, value) in eight.as_chunks_mut::<2>().0.iter_mut().zip(values) {
        *pair = value.to_le_bytes();
    }
}

/// Unit vector, times `largest`, of a point of the octahedron. The third component stands for 1.
fn octahedral([x, y, one, _]: [f32; 4], largest: f32) -> [f32; 3] {
    let point = Vec2::new(x, y) / one;
    let z = 1.0 - point.x.abs() - point.y.abs();
    let fold = z.min(0.0);
    let vector = Vec3::new(point.x + fold.copysign(-point.x), point.y + fold.copysign(-point.y), z);
    // A third component of 0 gives no vector.
    (vector.normalize_or_zero() * largest).round().to_array()
}

/// Quaternion, times 32767, of its three smaller components. The fourth number stands for 1, but for its two lowest bits, which name the
/// largest component.
fn quaternion([x, y, z, last]: [f32; 4]) -> [f32; 4] {
    let last = last as i16;
    let scale = std::f32::consts::FRAC_1_SQRT_2 / f32::from(last | 3);
    let [x, y, z] = [x * scale, y * scale, z * scale];
    let largest = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let mut all = [largest, x, y, z].map(|value| (value * f32::from(i16::MAX)).round());
    all.rotate_right(usize::from(last as u16 & 3));
    all
}

/// Number whose upper 8 bits are the exponent of a power of two, and whose lower 24 bits are the factor.
fn exponential(word: i32) -> f32 {
    (f64::from(word >> 24).exp2() * f64::from(word << 8 >> 8)) as f32
}

/// Red, green, blue and alpha, each up to `largest`, of luma, orange, green and alpha. The highest bit of alpha stands above all bits that
/// the numbers have.
fn color([y, co, cg, alpha]: [i32; 4], largest: f32) -> [f32; 4] {
    let most = ((alpha as u32 + 1).next_power_of_two() as i32 - 1).max(1);
    let alpha = alpha & most >> 1;
    let all = [y + co - cg, y + cg, y - co - cg, alpha << 1 | alpha & 1];
    all.map(|value| (value as f32 * (largest / most as f32)).round())
}

#[test]
fn filters_keep_what_they_are_made_for() {
    // The octahedron's lower half is folded: (1, 1) is straight down.
    assert_eq!(octahedral([0.0, 0.0, 127.0, 0.0], 127.0), [0.0, 0.0, 127.0]);
    assert_eq!(octahedral([127.0, 127.0, 127.0, 0.0], 127.0), [0.0, 0.0, -127.0]);
    assert_eq!(octahedral([-127.0, 0.0, 127.0, 0.0], 127.0), [-127.0, 0.0, 0.0]);
    assert_eq!(octahedral([1.0, 1.0, 0.0, 0.0], 127.0), [0.0; 3]);
    assert_eq!(quaternion([0.0, 0.0, 0.0, 32767.0]), [0.0, 0.0, 0.0, 32767.0]);
    assert_eq!(quaternion([0.0, 0.0, 0.0, 32764.0]), [32767.0, 0.0, 0.0, 0.0]);
    assert_eq!(exponential((-2_i32 << 24) | 3), 0.75);
    assert_eq!(exponential((1 << 24) | 0xff_ffff), -2.0);
    // Eight bits: alpha has seven and the bit above them.
    assert_eq!(color([100, 0, 0, 0xff], 255.0), [100.0, 100.0, 100.0, 255.0]);
    assert_eq!(color([60, 20, -10, 0x80], 255.0), [90.0, 50.0, 50.0, 0.0]);
    assert_eq!(color([0, 0, 0, 0], 255.0), [0.0; 4]);
}
