//! Rough surfaces made of microfacets, with the GGX (Walter et al. 2007) or the Beckmann distribution. Directions are in the
//! surface's frame, whose z-axis is the normal. GLSL: `glsl/include/math/microfacet.glsl`.

use glam::DVec3;

/// A surface of microfacets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Microfacets {
    /// Roughness along x and y, > 0.
    pub alpha: [f64; 2],
    /// Whether the distribution is GGX; otherwise it is Beckmann.
    pub is_ggx: bool,
}

impl Microfacets {
    /// Microfacets with this roughness, but at least 1e-4. Mitsuba has the same limit.
    pub fn new(alpha: [f64; 2], is_ggx: bool) -> Self {
        Self { alpha: alpha.map(|a| a.max(1.0e-4)), is_ggx }
    }
}

/// Share of the facets that are visible from the unit direction `v`, in [0, 1] (Smith's masking function). It is exact for GGX;
/// for Beckmann it is the rational approximation of Walter et al. (2007).
pub fn smith_g1(s: &Microfacets, v: DVec3) -> f64 {
    let [x, y] = [v.x * s.alpha[0], v.y * s.alpha[1]];
    let t = (x * x + y * y) / (v.z * v.z);
    let a = t.sqrt().recip();
    match (s.is_ggx, a < 1.6) {
        (true, _) => 2.0 / (1.0 + (1.0 + t).sqrt()),
        (false, true) => (3.535 * a + 2.181 * a * a) / (1.0 + 2.276 * a + 2.577 * a * a),
        (false, false) => 1.0,
    }
}
