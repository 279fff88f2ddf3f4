//! Parameters of the principled BSDFs.

use glam::Vec3;

use super::parameter::{Parameter, Value, number, parameters};
use super::texture::Textured;
use crate::generated::constants::*;

parameters! {
    /// Parameters of the principled BSDF. All but `eta` lie in [0, 1].
    #[derive(Debug, Clone, PartialEq, serde::Serialize)]
    pub struct Principled {
        /// Base color.
        base_color: Textured<Vec3> => PRINCIPLED_BASE_COLOR,
        /// Roughness; its square is the roughness of the microfacets.
        roughness: Textured<f32> => PRINCIPLED_ROUGHNESS,
        /// Stretch of highlights along the tangent.
        anisotropic: Textured<f32> => PRINCIPLED_ANISOTROPIC,
        /// Share of the metallic model.
        metallic: Textured<f32> => PRINCIPLED_METALLIC,
        /// Share of transmission.
        spec_trans: Textured<f32> => PRINCIPLED_SPEC_TRANS,
        /// Relative index of refraction, interior over exterior, > 1 (from `eta` or `specular`).
        eta: f32 => PRINCIPLED_ETA,
        /// Tint of the specular reflection by the base color.
        spec_tint: Textured<f32> => PRINCIPLED_SPEC_TINT,
        /// Strength of the sheen at grazing angles.
        sheen: Textured<f32> => PRINCIPLED_SHEEN,
        /// Tint of the sheen by the base color.
        sheen_tint: Textured<f32> => PRINCIPLED_SHEEN_TINT,
        /// Blend towards approximate subsurface scattering.
        flatness: Textured<f32> => PRINCIPLED_FLATNESS,
        /// Strength of the clear coat.
        clearcoat: Textured<f32> => PRINCIPLED_CLEARCOAT,
        /// Gloss of the clear coat.
        clearcoat_gloss: Textured<f32> => PRINCIPLED_CLEARCOAT_GLOSS,
    }
}

parameters! {
    /// Parameters of the principled BSDF of a thin sheet. All but `eta` lie in [0, 1], and so does the base color, unless `difftrans`
    /// is met from within a body of an index of refraction.
    #[derive(Debug, Clone, PartialEq, serde::Serialize)]
    pub struct PrincipledThin {
        /// Base color.
        base_color: Textured<Vec3> => PRINCIPLED_BASE_COLOR,
        /// Roughness; its square is the roughness of the microfacets.
        roughness: Textured<f32> => PRINCIPLED_ROUGHNESS,
        /// Stretch of highlights along the tangent.
        anisotropic: Textured<f32> => PRINCIPLED_ANISOTROPIC,
        /// Share of the specular lobes, of which one crosses the sheet.
        spec_trans: Textured<f32> => PRINCIPLED_SPEC_TRANS,
        /// Relative index of refraction, > 0.
        eta: f32 => PRINCIPLED_ETA,
        /// Tint of the specular reflection by the base color.
        spec_tint: Textured<f32> => PRINCIPLED_SPEC_TINT,
        /// Strength of the sheen at grazing angles.
        sheen: Textured<f32> => PRINCIPLED_SHEEN,
        /// Tint of the sheen by the base color.
        sheen_tint: Textured<f32> => PRINCIPLED_SHEEN_TINT,
        /// Blend towards approximate subsurface scattering.
        flatness: Textured<f32> => PRINCIPLED_FLATNESS,
        /// Share of the diffuse light that crosses the sheet: half of Mitsuba's `diff_trans`.
        crossing: Textured<f32> => PRINCIPLED_METALLIC,
    }
}
