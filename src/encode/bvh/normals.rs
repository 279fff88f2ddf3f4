//! Encoding of vertex normals.

use glam::Vec3;

/// Unit vector as two signed 16-bit numbers (Cigolle et al. 2014), which GLSL reads by `unpackSnorm2x16`.
pub(super) fn octahedral_encode(n: Vec3) -> u32 {
    let p = n / (n.x.abs() + n.y.abs() + n.z.abs());
    let (x, y) =
        if p.z >= 0.0 { (p.x, p.y) } else { ((1.0 - p.y.abs()).copysign(p.x), (1.0 - p.x.abs()).copysign(p.y)) };
    let snorm = |x: f32| u32::from((x.clamp(-1.0, 1.0) * 32767.0).round() as i16 as u16);
    snorm(x) | snorm(y) << 16
}
