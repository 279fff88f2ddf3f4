//! `KHR_materials_pbrSpecularGlossiness` as a `principled`: the conversion that the extension's authors published.

use gltf::material::PbrSpecularGlossiness;

use super::images::{BaseColor, Coding, Images, TextureUse, at_place, scaled};
use crate::Result;
use crate::image::tone::srgb;
use crate::math::srgb::linear_from_srgb;
use crate::scene::description::kinds::Kind;
use crate::scene::description::make::{color, nested, number, object};
use crate::scene::description::object::Object;

/// Reflectance of a dielectric at normal incidence, for an index of refraction of 1.5.
const DIELECTRIC: f32 = 0.04;

/// Diffuse and specular color to base color and the share of metal.
fn metallic(diffuse: [f32; 3], specular: [f32; 3]) -> ([f32; 3], f32) {
    let brightness = |c: [f32; 3]| (0.299 * c[0] * c[0] + 0.587 * c[1] * c[1] + 0.114 * c[2] * c[2]).sqrt();
    let strongest = specular.into_iter().fold(0.0, f32::max);
    let one_minus = 1.0 - strongest;
    let (diffuse_brightness, specular_brightness) = (brightness(diffuse), brightness(specular));
    let metal = match specular_brightness < DIELECTRIC {
        true => 0.0,
        false => {
            let b = diffuse_brightness * one_minus / (1.0 - DIELECTRIC) + specular_brightness - 2.0 * DIELECTRIC;
            let c = DIELECTRIC - specular_brightness;
            let discriminant = (b * b - 4.0 * DIELECTRIC * c).max(0.0);
            ((-b + discriminant.sqrt()) / (2.0 * DIELECTRIC)).clamp(0.0, 1.0)
        }
    };
    let base = |channel: usize| {
        let from_diffuse = diffuse[channel] * one_minus / (1.0 - DIELECTRIC) / (1.0 - metal).max(1.0e-6);
        let from_specular = (specular[channel] - DIELECTRIC * (1.0 - metal)) / metal.max(1.0e-6);
        let share = metal * metal;
        (from_diffuse + share * (from_specular - from_diffuse)).clamp(0.0, 1.0)
    };
    ([base(0), base(1), base(2)], metal)
}

/// The material, with a texel of the result for each texel of the diffuse image, or else of the specular one.
pub(super) fn principled<'a>(
    images: &mut Images<'a>,
    material: &PbrSpecularGlossiness<'a>,
    base: &BaseColor<'a>,
    gloss: Option<&TextureUse<'a>>,
) -> Result<Object> {
    let [red, green, blue, _] = base.factor;
    let (diffuse_factor, specular_factor) = ([red, green, blue], material.specular_factor());
    let roughness = match gloss {
        Some(texture) => {
            let factor = material.glossiness_factor();
            let rough = |texel: [u8; 4]| (255.0 - f32::from(texel[3]) * factor).round() as u8;
            nested(images.numbers(texture, &format!("roughness{factor}"), rough)?)
        }
        None => number(1.0 - material.glossiness_factor().clamp(0.0, 1.0)),
    };
    let Some(carrier) = base.texture.as_ref().or(gloss) else {
        let (base_color, metal) = metallic(diffuse_factor, specular_factor);
        let entries = [("base_color", color(base_color)), ("metallic", number(metal)), ("roughness", roughness)];
        return Ok(object(Kind::Bsdf, "principled", entries));
    };
    let Some(gloss) = gloss else {
        // The specular color is even, so the share of metal is that of the mean color.
        let (_, metal) = metallic(diffuse_factor, specular_factor);
        let base_color = scaled(images.bitmap(carrier, Coding::Srgb)?, diffuse_factor);
        let entries = [("base_color", nested(base_color)), ("metallic", number(metal)), ("roughness", roughness)];
        return Ok(object(Kind::Bsdf, "principled", entries));
    };
    let specular = images.texels(gloss)?;
    let is_diffuse = base.texture.is_some();
    let linear = |bytes: [u8; 4], factor: [f32; 3]| {
        let decoded = |channel: usize| linear_from_srgb(f64::from(bytes[channel]) / 255.0) as f32 * factor[channel];
        [decoded(0), decoded(1), decoded(2)]
    };
    let solve = |bytes: [u8; 4], u: f32, v: f32| {
        let shine = linear(at_place(&specular, u, v), specular_factor);
        metallic(if is_diffuse { linear(bytes, diffuse_factor) } else { diffuse_factor }, shine)
    };
    let byte = |value: f32| (value.clamp(0.0, 1.0) * 255.0).round() as u8;
    let encoded = |value: f32| byte(srgb(f64::from(value)) as f32);
    let colors = |bytes: [u8; 4], u: f32, v: f32| solve(bytes, u, v).0.map(encoded);
    let metals = |bytes: [u8; 4], u: f32, v: f32| [byte(solve(bytes, u, v).1); 3];
    let other = if is_diffuse { format!("with{}", images.image(gloss)?.index()) } else { "alone".to_owned() };
    let factors = diffuse_factor.iter().chain(&specular_factor).map(f32::to_string).collect::<Vec<_>>().join("_");
    let tag = |what: &str| format!("{what}-{other}-{factors}");
    let base_color = images.made(carrier, &tag("base"), Coding::Srgb, colors)?;
    let metal = images.made(carrier, &tag("metal"), Coding::Linear, metals)?;
    let entries = [("base_color", nested(base_color)), ("metallic", nested(metal)), ("roughness", roughness)];
    Ok(object(Kind::Bsdf, "principled", entries))
}
