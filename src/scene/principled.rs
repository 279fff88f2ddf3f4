//! Parameters of the principled BSDFs.

use glam::Vec3;

use super::texture::Textured;

/// Parameters of the principled BSDF. All but `eta` lie in [0, 1].
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Principled {
    /// Base color.
    pub base_color: Textured<Vec3>,
    /// Roughness; its square is the roughness of the microfacets.
    pub roughness: Textured<f32>,
    /// Stretch of highlights along the tangent.
    pub anisotropic: Textured<f32>,
    /// Share of the metallic model.
    pub metallic: Textured<f32>,
    /// Share of transmission.
    pub spec_trans: Textured<f32>,
    /// Relative index of refraction, interior over exterior, > 1 (from `eta` or `specular`).
    pub eta: f32,
    /// Tint of the specular reflection by the base color.
    pub spec_tint: Textured<f32>,
    /// Strength of the sheen at grazing angles.
    pub sheen: Textured<f32>,
    /// Tint of the sheen by the base color.
    pub sheen_tint: Textured<f32>,
    /// Blend towards approximate subsurface scattering.
    pub flatness: Textured<f32>,
    /// Strength of the clear coat.
    pub clearcoat: Textured<f32>,
    /// Gloss of the clear coat.
    pub clearcoat_gloss: Textured<f32>,
}

impl Principled {
    pub(super) fn textures_mut(&mut self) -> Vec<&mut Option<u32>> {
        let scalars = [
            &mut self.roughness,
            &mut self.anisotropic,
            &mut self.metallic,
            &mut self.spec_trans,
            &mut self.spec_tint,
            &mut self.sheen,
            &mut self.sheen_tint,
            &mut self.flatness,
            &mut self.clearcoat,
            &mut self.clearcoat_gloss,
        ];
        let scalars = scalars.into_iter().map(|scalar| &mut scalar.texture);
        std::iter::once(&mut self.base_color.texture).chain(scalars).collect()
    }
}

/// Parameters of the principled BSDF of a thin sheet. All but `eta` lie in [0, 1].
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct PrincipledThin {
    /// Base color.
    pub base_color: Textured<Vec3>,
    /// Roughness; its square is the roughness of the microfacets.
    pub roughness: Textured<f32>,
    /// Stretch of highlights along the tangent.
    pub anisotropic: Textured<f32>,
    /// Share of the specular lobes, of which one crosses the sheet.
    pub spec_trans: Textured<f32>,
    /// Relative index of refraction, > 0.
    pub eta: f32,
    /// Tint of the specular reflection by the base color.
    pub spec_tint: Textured<f32>,
    /// Strength of the sheen at grazing angles.
    pub sheen: Textured<f32>,
    /// Tint of the sheen by the base color.
    pub sheen_tint: Textured<f32>,
    /// Blend towards approximate subsurface scattering.
    pub flatness: Textured<f32>,
    /// Share of the diffuse light that crosses the sheet: half of Mitsuba's `diff_trans`.
    pub crossing: Textured<f32>,
}

impl PrincipledThin {
    pub(super) fn textures_mut(&mut self) -> Vec<&mut Option<u32>> {
        let scalars = [
            &mut self.roughness,
            &mut self.anisotropic,
            &mut self.spec_trans,
            &mut self.spec_tint,
            &mut self.sheen,
            &mut self.sheen_tint,
            &mut self.flatness,
            &mut self.crossing,
        ];
        let scalars = scalars.into_iter().map(|scalar| &mut scalar.texture);
        std::iter::once(&mut self.base_color.texture).chain(scalars).collect()
    }
}
