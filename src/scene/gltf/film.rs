//! Thin films over surfaces (`KHR_materials_iridescence`).

use gltf::{Document, Material};
use serde_json::Value as Json;

use super::images::TextureUse;

/// Film of a material.
pub(super) struct Film<'a> {
    /// Share of the surface that has the film, in [0, 1].
    pub factor: f32,
    /// Texture that multiplies the share by its red channel.
    pub factor_texture: Option<TextureUse<'a>>,
    /// Index of refraction.
    pub eta: f32,
    /// Thickness in nanometers where the green channel of the texture is 0, and where it is 1. Without a texture, the second counts.
    pub thickness: [f32; 2],
    pub thickness_texture: Option<TextureUse<'a>>,
}

/// Film of a material, where it has one.
pub(super) fn film<'a>(document: &'a Document, material: &Material) -> Option<Film<'a>> {
    let value = material.extension_value("KHR_materials_iridescence")?;
    let number = |key: &str, default: f32| {
        let given = value.get(key).and_then(Json::as_f64).map(|given| given as f32);
        given.filter(|given| given.is_finite()).unwrap_or(default).max(0.0)
    };
    let texture = |key: &str| TextureUse::of_json(document, value.get(key)?);
    let factor = number("iridescenceFactor", 0.0).min(1.0);
    let film = Film {
        factor,
        factor_texture: texture("iridescenceTexture"),
        eta: number("iridescenceIor", 1.3).max(1.0),
        thickness: [number("iridescenceThicknessMinimum", 100.0), number("iridescenceThicknessMaximum", 400.0)],
        thickness_texture: texture("iridescenceThicknessTexture"),
    };
    (factor > 0.0).then_some(film)
}

impl Film<'_> {
    /// Largest thickness, and the byte of a texture whose unit it is, by the byte of the given texture.
    pub fn thicknesses(&self) -> (f32, impl Fn([u8; 4]) -> u8 + use<>) {
        let [least, most] = self.thickness;
        let unit = least.max(most);
        let byte = move |texel: [u8; 4]| {
            let thickness = least + (most - least) * f32::from(texel[1]) / f32::from(u8::MAX);
            (thickness / unit.max(f32::MIN_POSITIVE) * f32::from(u8::MAX)).round() as u8
        };
        (unit, byte)
    }
}
