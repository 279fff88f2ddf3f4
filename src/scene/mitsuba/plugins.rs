//! Kinds of plugins by their names. In XML the element tells the kind; a dictionary has the name alone.

use super::element::MESH;
use super::{emitter_plugin, integrator, materials, shape, textures};

/// Names of plugins that other files do not list, by their kind.
const OTHERS: [(&str, &[&str]); 10] = [
    ("sensor", &["perspective", "thinlens", "orthographic", "batch", "distant", "irradiancemeter", "radiancemeter"]),
    ("film", &["hdrfilm", "ldrfilm", "specfilm"]),
    ("rfilter", &["box", "tent", "gaussian", "mitchell", "catmullrom", "lanczos"]),
    ("sampler", &["independent", "stratified", "multijitter", "orthogonal", "ldsampler"]),
    ("shape", &[MESH, "merge", "sdfgrid"]),
    ("emitter", &["timed_sunsky"]),
    ("texture", &["volume"]),
    ("bsdf", &["bsdf_mixture", "circular", "hair", "measured", "polarizer", "retarder"]),
    ("medium", &["homogeneous", "heterogeneous"]),
    ("spectrum", &["d65", "irregular", "regular", "srgb", "uniform"]),
];

/// Kind of the plugin `name`, as XML names it; `None` for an unknown plugin.
pub(super) fn tag_of(name: &str) -> Option<&'static str> {
    match () {
        () if shape::SUPPORTED.contains(&name) => Some("shape"),
        () if emitter_plugin::SUPPORTED.contains(&name) => Some("emitter"),
        () if textures::SUPPORTED.contains(&name) => Some("texture"),
        () if integrator::is_known(name) => Some("integrator"),
        () if materials::is_known(name) => Some("bsdf"),
        () => OTHERS.iter().find(|(_, names)| names.contains(&name)).map(|(tag, _)| *tag),
    }
}
