//! Kinds of plugins by their names, which dictionaries give alone.

use super::{emitter_plugin, integrator, materials, shape, textures};
use crate::scene::description::kinds::Kind;
use crate::scene::description::object::MESH;

/// Names of plugins that other files do not list, by their kind.
const OTHERS: [(Kind, &[&str]); 12] = [
    (
        Kind::Sensor,
        &[
            "perspective",
            "thinlens",
            "orthographic",
            "spherical",
            "batch",
            "distant",
            "irradiancemeter",
            "radiancemeter",
        ],
    ),
    (Kind::Film, &["hdrfilm", "ldrfilm", "specfilm"]),
    (Kind::Rfilter, &["box", "tent", "gaussian", "mitchell", "catmullrom", "lanczos"]),
    (Kind::Sampler, &["independent", "stratified", "multijitter", "orthogonal", "ldsampler"]),
    (Kind::Shape, &[MESH, "merge", "sdfgrid"]),
    (Kind::Emitter, &["timed_sunsky"]),
    (Kind::Texture, &["volume"]),
    (Kind::Bsdf, &["bsdf_mixture", "circular", "polarizer", "retarder"]),
    (Kind::Medium, &["homogeneous", "heterogeneous"]),
    (Kind::Phase, &["isotropic", "hg", "rayleigh", "blendphase", "tabphase", "sggx"]),
    (Kind::Volume, &["constvolume", "gridvolume"]),
    (Kind::Spectrum, &["d65", "irregular", "regular", "srgb", "uniform"]),
];

/// Kind of the plugin `name`; `None` for an unknown plugin.
pub(in crate::scene) fn kind_of(name: &str) -> Option<Kind> {
    match () {
        () if shape::plugins().any(|plugin| plugin == name) => Some(Kind::Shape),
        () if emitter_plugin::plugins().any(|plugin| plugin == name) => Some(Kind::Emitter),
        () if textures::is_known(name) => Some(Kind::Texture),
        () if integrator::is_known(name) => Some(Kind::Integrator),
        () if materials::is_known(name) => Some(Kind::Bsdf),
        () => OTHERS.iter().find(|(_, names)| names.contains(&name)).map(|(kind, _)| *kind),
    }
}
