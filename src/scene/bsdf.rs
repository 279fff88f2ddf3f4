//! Materials and scattering functions.

use glam::Vec3;

use super::texture::Textured;

/// Material of a surface.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Material {
    /// The material's `id`, or its shape's, for messages.
    #[serde(skip)]
    pub name: String,
    /// Surface, or choice between materials.
    pub kind: MaterialKind,
}

/// Surface, or choice between materials.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub enum MaterialKind {
    /// Scattering surface.
    Surface(SurfaceMaterial),
    /// `blendbsdf`: the second material with probability `weight`, else the first. Indices into `Scene::materials`.
    Blend {
        /// Probability of the second material, in [0, 1].
        weight: Textured<f32>,
        /// Blended materials.
        materials: [u32; 2],
    },
    /// `twosided` with two materials. Indices into `Scene::materials`.
    Sides {
        /// Material of the side to which the shading normal points.
        front: u32,
        /// Material of the other side.
        back: u32,
    },
}

/// Scattering surface: a scattering function with its modifiers.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct SurfaceMaterial {
    /// The scattering function.
    pub bsdf: Bsdf,
    /// Inside `twosided`: the back scatters like the front. Otherwise the back of a material that only reflects is
    /// black.
    pub two_sided: bool,
    /// `mask`: share of the incident light that meets the surface, in [0, 1]; the rest goes straight on.
    pub opacity: Textured<f32>,
    /// `bumpmap` or `normalmap`.
    pub relief: Option<Relief>,
    /// Whether the relief lies around `twosided` rather than inside it. Inside, the back shows the front's relief
    /// mirrored. Outside, the tilted normal decides which side is met, and heights that rise on the front sink on the
    /// back.
    pub relief_outside: bool,
    /// `coating`.
    pub coating: Option<Coating>,
}

impl SurfaceMaterial {
    /// Surface of the scattering function alone: one-sided, opaque, flat, not coated.
    pub fn plain(bsdf: Bsdf) -> Self {
        let opacity = Textured::constant(1.0);
        Self { bsdf, two_sided: false, opacity, relief: None, relief_outside: false, coating: None }
    }

    /// Textures of the scattering function's parameters and of the opacity.
    pub(super) fn parameter_textures_mut(&mut self) -> Vec<&mut u32> {
        let mut all = self.bsdf.textures_mut();
        all.push(&mut self.opacity.texture);
        all.into_iter().flatten().collect()
    }

    /// Every texture that the surface refers to.
    pub(super) fn textures_mut(&mut self) -> Vec<&mut u32> {
        let mut all = self.bsdf.textures_mut();
        all.push(&mut self.opacity.texture);
        let relief = self.relief.as_mut().map(|relief| match relief {
            Relief::Bump { texture, .. } | Relief::NormalMap { texture } => texture,
        });
        all.into_iter().flatten().chain(relief).collect()
    }
}

/// Modifiers that tilt the shading normal.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub enum Relief {
    /// `bumpmap`: heights in scene units.
    Bump {
        /// Index into `Scene::textures`.
        texture: u32,
        /// Factor of the heights.
        scale: f32,
    },
    /// `normalmap`: normals in the local frame, stored as colors `(n + 1) / 2`.
    NormalMap {
        /// Index into `Scene::textures`.
        texture: u32,
    },
}

/// `coating`: a smooth dielectric layer over a scattering function (Weidlich and Wilkie 2007).
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Coating {
    /// Relative index of refraction, interior over exterior, > 0.
    pub eta: f32,
    /// Absorption times thickness, each channel >= 0.
    pub optical_thickness: Vec3,
    /// Factor of the light that the layer's surface reflects.
    pub specular_reflectance: Vec3,
}

/// Distributions of microfacet normals.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub enum Distribution {
    /// Beckmann distribution (Mitsuba's default).
    Beckmann,
    /// GGX, also called Trowbridge-Reitz.
    Ggx,
}

/// Roughness of a surface of microfacets.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Microfacets {
    /// Distribution of the facets' normals.
    pub distribution: Distribution,
    /// Roughness along the tangent, > 0.
    pub alpha_u: Textured<f32>,
    /// Roughness along the bitangent, > 0.
    pub alpha_v: Textured<f32>,
}

/// Scattering function with its parameters in linear sRGB. `eta` of a dielectric is interior over exterior, > 0.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub enum Bsdf {
    /// Ideal diffuse reflection.
    Diffuse {
        /// Albedo, each channel in [0, 1].
        reflectance: Textured<Vec3>,
    },
    /// Rough diffuse reflection (Oren and Nayar 1994).
    RoughDiffuse {
        /// Albedo, each channel in [0, 1].
        reflectance: Textured<Vec3>,
        /// Standard deviation of the facets' slopes, Mitsuba's `alpha`.
        alpha: Textured<f32>,
        /// Whether the qualitative model without interreflection is used.
        fast_approximation: bool,
    },
    /// Smooth dielectric.
    Dielectric {
        /// Relative index of refraction.
        eta: f32,
        /// Factor of reflection.
        specular_reflectance: Textured<Vec3>,
        /// Factor of transmission.
        specular_transmittance: Textured<Vec3>,
    },
    /// Thin sheet of a dielectric: light goes straight on.
    ThinDielectric {
        /// Relative index of refraction.
        eta: f32,
        /// Factor of reflection.
        specular_reflectance: Textured<Vec3>,
        /// Factor of transmission.
        specular_transmittance: Textured<Vec3>,
    },
    /// Rough dielectric (Walter et al. 2007).
    RoughDielectric {
        /// Roughness.
        microfacets: Microfacets,
        /// Relative index of refraction.
        eta: f32,
        /// Factor of reflection.
        specular_reflectance: Textured<Vec3>,
        /// Factor of transmission.
        specular_transmittance: Textured<Vec3>,
    },
    /// Smooth conductor.
    Conductor {
        /// Real part of the index of refraction. Where it was fitted to a color, a channel may be negative, and so may
        /// one of `k`.
        eta: Vec3,
        /// Imaginary part of the index of refraction.
        k: Vec3,
        /// Factor of reflection.
        specular_reflectance: Textured<Vec3>,
    },
    /// Rough conductor.
    RoughConductor {
        /// Roughness.
        microfacets: Microfacets,
        /// Real part of the index of refraction.
        eta: Vec3,
        /// Imaginary part of the index of refraction.
        k: Vec3,
        /// Factor of reflection.
        specular_reflectance: Textured<Vec3>,
    },
    /// Smooth dielectric layer over a diffuse base.
    Plastic {
        /// Relative index of refraction.
        eta: f32,
        /// Albedo of the base.
        diffuse_reflectance: Textured<Vec3>,
        /// Factor of the light that the layer reflects.
        specular_reflectance: Textured<Vec3>,
        /// Whether color shifts by internal scattering are kept.
        nonlinear: bool,
    },
    /// Rough dielectric layer over a diffuse base.
    RoughPlastic {
        /// Distribution of the facets' normals.
        distribution: Distribution,
        /// Roughness, > 0, uniform over the surface.
        alpha: f32,
        /// Relative index of refraction.
        eta: f32,
        /// Albedo of the base.
        diffuse_reflectance: Textured<Vec3>,
        /// Factor of the light that the layer reflects.
        specular_reflectance: Textured<Vec3>,
        /// Whether color shifts by internal scattering are kept.
        nonlinear: bool,
    },
    /// Principled BSDF (Burley 2012, 2015) as in Mitsuba; every parameter but `eta` lies in [0, 1].
    Principled(Principled),
}

impl Bsdf {
    fn textures_mut(&mut self) -> Vec<&mut Option<u32>> {
        match self {
            Self::Diffuse { reflectance } => vec![&mut reflectance.texture],
            Self::RoughDiffuse { reflectance, alpha, .. } => vec![&mut reflectance.texture, &mut alpha.texture],
            Self::Dielectric { specular_reflectance, specular_transmittance, .. }
            | Self::ThinDielectric { specular_reflectance, specular_transmittance, .. } => {
                vec![&mut specular_reflectance.texture, &mut specular_transmittance.texture]
            }
            Self::RoughDielectric { microfacets, specular_reflectance, specular_transmittance, .. } => vec![
                &mut microfacets.alpha_u.texture,
                &mut microfacets.alpha_v.texture,
                &mut specular_reflectance.texture,
                &mut specular_transmittance.texture,
            ],
            Self::Conductor { specular_reflectance, .. } => vec![&mut specular_reflectance.texture],
            Self::RoughConductor { microfacets, specular_reflectance, .. } => vec![
                &mut microfacets.alpha_u.texture,
                &mut microfacets.alpha_v.texture,
                &mut specular_reflectance.texture,
            ],
            Self::Plastic { diffuse_reflectance, specular_reflectance, .. }
            | Self::RoughPlastic { diffuse_reflectance, specular_reflectance, .. } => {
                vec![&mut diffuse_reflectance.texture, &mut specular_reflectance.texture]
            }
            Self::Principled(principled) => principled.textures_mut(),
        }
    }
}

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
    fn textures_mut(&mut self) -> Vec<&mut Option<u32>> {
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
