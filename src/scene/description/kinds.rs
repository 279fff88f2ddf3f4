//! Kinds of objects, and types of parameters.

/// Kinds of plugin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::scene) enum Kind {
    Bsdf,
    Emitter,
    Film,
    Integrator,
    Medium,
    Phase,
    Rfilter,
    Sampler,
    Sensor,
    Shape,
    Spectrum,
    Subsurface,
    Texture,
    Volume,
}

impl Kind {
    const ALL: [(Self, &'static str); 14] = [
        (Self::Bsdf, "bsdf"),
        (Self::Emitter, "emitter"),
        (Self::Film, "film"),
        (Self::Integrator, "integrator"),
        (Self::Medium, "medium"),
        (Self::Phase, "phase"),
        (Self::Rfilter, "rfilter"),
        (Self::Sampler, "sampler"),
        (Self::Sensor, "sensor"),
        (Self::Shape, "shape"),
        (Self::Spectrum, "spectrum"),
        (Self::Subsurface, "subsurface"),
        (Self::Texture, "texture"),
        (Self::Volume, "volume"),
    ];

    /// The kind that XML knows by this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().find(|(_, known)| *known == name).map(|(kind, _)| *kind)
    }

    /// Name in XML.
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].1
    }
}

/// Types of parameters that XML can write. Messages name them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::scene) enum Type {
    Animation,
    Blackbody,
    Boolean,
    Float,
    Integer,
    Point,
    Rgb,
    Spectrum,
    Srgb,
    String,
    Transform,
    Vector,
}

impl Type {
    const ALL: [(Self, &'static str); 12] = [
        (Self::Animation, "animation"),
        (Self::Blackbody, "blackbody"),
        (Self::Boolean, "boolean"),
        (Self::Float, "float"),
        (Self::Integer, "integer"),
        (Self::Point, "point"),
        (Self::Rgb, "rgb"),
        (Self::Spectrum, "spectrum"),
        (Self::Srgb, "srgb"),
        (Self::String, "string"),
        (Self::Transform, "transform"),
        (Self::Vector, "vector"),
    ];

    /// The type that XML knows by this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().find(|(_, known)| *known == name).map(|(kind, _)| *kind)
    }

    /// Name in XML.
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].1
    }
}
