//! What lies within a body (`KHR_materials_volume`), and what passes through a sheet diffusely (`KHR_materials_diffuse_transmission`).

use gltf::Material;

use crate::scene::description::kinds::Kind;
use crate::scene::description::make::{color, object};
use crate::scene::description::object::Object;

/// Least channel of a color that absorption leaves, so that the medium's coefficient is finite.
const LEAST: f32 = 1.0e-6;

/// Whether the shape is a body rather than a sheet.
pub(super) fn is_solid(material: &Material) -> bool {
    material.volume().is_some_and(|volume| volume.thickness_factor() > 0.0)
}

/// Medium within a body that light enters: what remains after the attenuation distance has the attenuation color.
pub(super) fn medium(material: &Material) -> Option<Object> {
    let volume = material.volume().filter(|volume| volume.thickness_factor() > 0.0)?;
    let enters = material.transmission().is_some_and(|transmission| transmission.transmission_factor() > 0.0)
        || diffuse_transmission(material).is_some();
    let distance = volume.attenuation_distance();
    let remains = volume.attenuation_color();
    if !enters || remains == [1.0; 3] || !distance.is_finite() || distance <= 0.0 {
        return None;
    }
    let absorption = remains.map(|channel| (-channel.clamp(LEAST, 1.0).ln() / distance).min(f32::MAX));
    let coefficients = [("sigma_a", color(absorption)), ("sigma_s", color([0.0; 3]))];
    Some(object(Kind::Medium, "homogeneous", coefficients))
}

/// Share of the light that passes through diffusely, where it is above 0, the sheet that lets it pass, and whether textures are given.
pub(super) fn diffuse_transmission(material: &Material) -> Option<(f32, Object, bool)> {
    let value = material.extension_value("KHR_materials_diffuse_transmission")?.as_object()?;
    let number_of = |key: &str| value.get(key).and_then(serde_json::Value::as_f64).map(|number| number as f32);
    let share = number_of("diffuseTransmissionFactor").unwrap_or(0.0).clamp(0.0, 1.0);
    if share <= 0.0 {
        return None;
    }
    let mut tint = [1.0_f32; 3];
    if let Some(given) = value.get("diffuseTransmissionColorFactor").and_then(serde_json::Value::as_array) {
        for (channel, given) in tint.iter_mut().zip(given) {
            *channel = given.as_f64().map_or(1.0, |given| (given as f32).clamp(0.0, 1.0));
        }
    }
    let has_textures = value.keys().any(|key| key.ends_with("Texture"));
    Some((share, object(Kind::Bsdf, "difftrans", [("transmittance", color(tint))]), has_textures))
}
