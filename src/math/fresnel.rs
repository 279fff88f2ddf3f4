//! Fresnel's equations at the surface of a dielectric. GLSL: `glsl/include/math/fresnel.glsl`.

/// Reflection and refraction at a smooth surface between two dielectrics, for one direction of light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DielectricInterface {
    /// Share of the power that is reflected, in [0, 1].
    pub reflectance: f64,
    /// Cosine between the transmitted direction and the normal on its side, in [0, 1]. It is 0 if all light is reflected.
    pub cos_t: f64,
    /// Index of refraction on the transmitted side divided by the index on the incident side.
    pub eta: f64,
}

/// Fresnel's equations for unpolarized light. `cos_i` in [-1, 1] is the cosine between the incident direction and the outward
/// normal; it is negative for light from the inside. `eta` > 0 is the index of refraction inside divided by the index outside.
pub fn fresnel_dielectric(cos_i: f64, eta: f64) -> DielectricInterface {
    let relative = if cos_i >= 0.0 { eta } else { 1.0 / eta };
    let c = cos_i.abs();
    let cos_t = (1.0 - (1.0 - c * c) / (relative * relative)).max(0.0).sqrt();
    let reflectance = match (relative == 1.0, c == 0.0) {
        (true, _) => 0.0,
        (_, true) => 1.0,
        _ => {
            let s = (c - relative * cos_t) / (c + relative * cos_t);
            let p = (relative * c - cos_t) / (relative * c + cos_t);
            0.5 * (s * s + p * p)
        }
    };
    DielectricInterface { reflectance, cos_t, eta: relative }
}
