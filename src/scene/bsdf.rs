//! Materials and scattering functions.

use glam::Vec3;

use super::texture::Textured;

/// What a surface is made of.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Material {
    /// The `id`, or the shape's, for messages.
    #[serde(skip)]
    pub name: String,
    /// A surface, or a choice between materials.
    pub kind: MaterialKind,
}

/// A surface, or a choice between materials.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub enum MaterialKind {
    /// Scatters.
    Surface(SurfaceMaterial),
    /// `blendbsdf`: with the probability `weight` the second material, else the first. Indices into `Scene::materials`.
    Blend {
        /// In [0, 1].
        weight: Textured<f32>,
        /// What is blended.
        materials: [u32; 2],
    },
    /// `twosided` with two materials. Indices into `Scene::materials`.
    Sides {
        /// Where the shading normal points.
        front: u32,
        /// The other side.
        back: u32,
    },
}

/// A scattering surface: a scattering function and what modifies it.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct SurfaceMaterial {
    /// The scattering function.
    pub bsdf: Bsdf,
    /// Inside `twosided`: the back scatters like the front. Otherwise the back of what only reflects is black.
    pub two_sided: bool,
    /// `mask`: share of the light that meets the surface, in [0, 1]; the rest goes straight on.
    pub opacity: Textured<f32>,
    /// `bumpmap` or `normalmap`.
    pub relief: Option<Relief>,
    /// Whether the relief lies around `twosided` rather than inside it. Inside, the back shows the front's relief as in a
    /// mirror; outside, the tilted normal decides which side is met, and heights that rise on the front sink on the back.
    pub relief_outside: bool,
    /// `coating`.
    pub coating: Option<Coating>,
}

impl SurfaceMaterial {
    /// The scattering function alone: one side, opaque, flat, not coated.
    pub fn plain(bsdf: Bsdf) -> Self {
        let opacity = Textured::constant(1.0);
        Self { bsdf, two_sided: false, opacity, relief: None, relief_outside: false, coating: None }
    }

    /// The textures of the scattering function's parameters and of the opacity.
    pub(super) fn parameter_textures_mut(&mut self) -> Vec<&mut u32> {
        let mut all = self.bsdf.textures_mut();
        all.push(&mut self.opacity.texture);
        all.into_iter().flatten().collect()
    }

    /// Every texture that it refers to.
    pub(super) fn textures_mut(&mut self) -> Vec<&mut u32> {
        let mut all = self.bsdf.textures_mut();
        all.push(&mut self.opacity.texture);
        let relief = self.relief.as_mut().map(|relief| match relief {
            Relief::Bump { texture, .. } | Relief::NormalMap { texture } => texture,
        });
        all.into_iter().flatten().chain(relief).collect()
    }
}

/// What tilts the shading normal.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub enum Relief {
    /// `bumpmap`: heights in scene units.
    Bump {
        /// Index into `Scene::textures`.
        texture: u32,
        /// Factor of the heights.
        scale: f32,
    },
    /// `normalmap`: normals in the local frame, `(n + 1) / 2` as a color.
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
    /// Factor of what the layer's surface reflects.
    pub specular_reflectance: Vec3,
}

/// A distribution of microfacet normals.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub enum Distribution {
    /// Beckmann (Mitsuba's default).
    Beckmann,
    /// GGX, also called Trowbridge and Reitz.
    Ggx,
}

/// Roughness of a surface of microfacets.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Microfacets {
    /// Distribution of their normals.
    pub distribution: Distribution,
    /// Roughness along the tangent, > 0.
    pub alpha_u: Textured<f32>,
    /// Roughness along the bitangent, > 0.
    pub alpha_v: Textured<f32>,
}

/// A scattering function with its parameters in linear sRGB. `eta` of a dielectric is interior over exterior, > 0.
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
        /// Standard deviation of the facets' slopes, as Mitsuba's `alpha`.
        alpha: Textured<f32>,
        /// The qualitative model without interreflection.
        fast_approximation: bool,
    },
    /// A smooth dielectric.
    Dielectric {
        /// Relative index of refraction.
        eta: f32,
        /// Factor of reflection.
        specular_reflectance: Textured<Vec3>,
        /// Factor of transmission.
        specular_transmittance: Textured<Vec3>,
    },
    /// A thin sheet of a dielectric: light goes straight on.
    ThinDielectric {
        /// Relative index of refraction.
        eta: f32,
        /// Factor of reflection.
        specular_reflectance: Textured<Vec3>,
        /// Factor of transmission.
        specular_transmittance: Textured<Vec3>,
    },
    /// A rough dielectric (Walter et al. 2007).
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
    /// A smooth conductor.
    Conductor {
        /// Index of refraction, real part. Fitted to a color, it may be negative in a channel, `k` likewise.
        eta: Vec3,
        /// Imaginary part.
        k: Vec3,
        /// Factor of reflection.
        specular_reflectance: Textured<Vec3>,
    },
    /// A rough conductor.
    RoughConductor {
        /// Roughness.
        microfacets: Microfacets,
        /// Index of refraction, real part.
        eta: Vec3,
        /// Imaginary part.
        k: Vec3,
        /// Factor of reflection.
        specular_reflectance: Textured<Vec3>,
    },
    /// A smooth dielectric layer over a diffuse base.
    Plastic {
        /// Relative index of refraction.
        eta: f32,
        /// Albedo of the base.
        diffuse_reflectance: Textured<Vec3>,
        /// Factor of what the layer reflects.
        specular_reflectance: Textured<Vec3>,
        /// Whether color shifts by internal scattering are kept.
        nonlinear: bool,
    },
    /// A rough dielectric layer over a diffuse base.
    RoughPlastic {
        /// Distribution of the facets' normals.
        distribution: Distribution,
        /// Roughness, > 0, the same everywhere.
        alpha: f32,
        /// Relative index of refraction.
        eta: f32,
        /// Albedo of the base.
        diffuse_reflectance: Textured<Vec3>,
        /// Factor of what the layer reflects.
        specular_reflectance: Textured<Vec3>,
        /// Whether color shifts by internal scattering are kept.
        nonlinear: bool,
    },
    /// The principled BSDF (Burley 2012, 2015) as in Mitsuba; every parameter but `eta` in [0, 1].
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

/// Parameters of the principled BSDF; each in [0, 1] but `eta`.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Principled {
    /// Color.
    pub base_color: Textured<Vec3>,
    /// Roughness; its square is the microfacets'.
    pub roughness: Textured<f32>,
    /// Stretches highlights along the tangent.
    pub anisotropic: Textured<f32>,
    /// Share of the metallic model.
    pub metallic: Textured<f32>,
    /// Share of transmission.
    pub spec_trans: Textured<f32>,
    /// Relative index of refraction, interior over exterior, > 1 (from `eta` or `specular`).
    pub eta: f32,
    /// Tints the specular reflection with the base color.
    pub spec_tint: Textured<f32>,
    /// Sheen at grazing angles.
    pub sheen: Textured<f32>,
    /// Tints the sheen.
    pub sheen_tint: Textured<f32>,
    /// Blends towards approximate subsurface scattering.
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
