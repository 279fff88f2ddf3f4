//! Nested BSDFs in normal form: choices above surfaces, with all modifiers moved down into the surfaces.

use glam::Vec3;

use crate::scene::bsdf::{Bsdf, Coating, Relief, ReliefRules, Sheen, SurfaceMaterial};
use crate::scene::texture::Textured;

/// Material in normal form: a surface, or a choice.
#[derive(Debug, Clone)]
pub(super) enum Tree {
    Surface(SurfaceMaterial),
    /// Choice by chance: the second part with probability `weight`, else the first.
    Blend {
        weight: Textured<f32>,
        parts: Box<[Tree; 2]>,
    },
    /// Front and back. Each part scatters equally on both of its own sides.
    Sides {
        parts: Box<[Tree; 2]>,
    },
}

/// Surface that absorbs all light.
fn black() -> SurfaceMaterial {
    SurfaceMaterial::plain(Bsdf::Diffuse { reflectance: Textured::constant(Vec3::ZERO) })
}

/// Surface that lets this share of light go straight on and absorbs the rest.
fn sheet(transmitted: f32) -> SurfaceMaterial {
    SurfaceMaterial { opacity: Textured::constant(1.0 - transmitted), ..black() }
}

/// Surface that all light passes.
pub(super) fn null_surface() -> SurfaceMaterial {
    sheet(1.0)
}

impl Tree {
    /// Surface that absorbs all light.
    pub fn black() -> Self {
        Self::Surface(black())
    }

    /// `null`: the surface lets all light pass, as a `mask` of opacity 0.
    pub fn null() -> Self {
        Self::sheet(1.0)
    }

    /// Sheet that lets this share of light go straight on and absorbs the rest.
    pub fn sheet(transmitted: f32) -> Self {
        Self::Surface(sheet(transmitted))
    }

    /// Changes every surface. The error says why one cannot be changed.
    fn map(
        self,
        change: &impl Fn(SurfaceMaterial) -> Result<SurfaceMaterial, &'static str>,
    ) -> Result<Self, &'static str> {
        let both = |parts: [Tree; 2]| -> Result<Box<[Tree; 2]>, &'static str> {
            let [first, second] = parts;
            Ok(Box::new([first.map(change)?, second.map(change)?]))
        };
        Ok(match self {
            Self::Surface(surface) => Self::Surface(change(surface)?),
            Self::Blend { weight, parts } => Self::Blend { weight, parts: both(*parts)? },
            Self::Sides { parts } => Self::Sides { parts: both(*parts)? },
        })
    }

    /// All surfaces that the material chooses between.
    pub fn surfaces(&self) -> Vec<&SurfaceMaterial> {
        match self {
            Self::Surface(surface) => vec![surface],
            Self::Blend { parts, .. } | Self::Sides { parts } => parts.iter().flat_map(Self::surfaces).collect(),
        }
    }

    /// Deepest nesting of choices.
    pub fn choice_depth(&self) -> usize {
        match self {
            Self::Surface(_) => 0,
            Self::Blend { parts, .. } | Self::Sides { parts } => {
                1 + parts.iter().map(Self::choice_depth).max().unwrap_or(0)
            }
        }
    }

    /// Puts a `mask` around the material. The opacities of masks that lie within each other are multiplied.
    pub fn masked(self, opacity: Textured<f32>) -> Result<Self, &'static str> {
        self.map(&|surface| {
            let inner = surface.opacity;
            let whole = match (opacity.texture, inner.texture) {
                _ if opacity.value * inner.value == 0.0 => Textured::constant(0.0),
                (None, _) => Textured { value: opacity.value * inner.value, ..inner },
                (_, None) => Textured { value: opacity.value * inner.value, ..opacity },
                _ => return Err("a `mask` whose opacity is a texture cannot lie inside another such `mask`"),
            };
            Ok(SurfaceMaterial { opacity: whole, ..surface })
        })
    }

    /// Puts `twosided` around one BSDF, which is then always met from its front.
    pub fn two_sided(self) -> Result<Self, &'static str> {
        match self {
            Self::Sides { parts } => {
                let [front, _] = *parts;
                front.two_sided()
            }
            Self::Blend { weight, parts } => {
                let [first, second] = *parts;
                Ok(Self::Blend { weight, parts: Box::new([first.two_sided()?, second.two_sided()?]) })
            }
            Self::Surface(surface) if is_transmissive(&surface) => {
                Err("`twosided` takes only materials that transmit nothing")
            }
            Self::Surface(surface) if surface.relief_outside => Err(NESTED_TWICE),
            Self::Surface(surface) => Ok(Self::Surface(SurfaceMaterial { two_sided: true, ..surface })),
        }
    }

    /// Puts `twosided` around two BSDFs. Mitsuba refuses those that transmit light; here each scatters on its own side as it does alone.
    pub fn sides(front: Self, back: Self) -> Result<Self, &'static str> {
        Ok(Self::Sides { parts: Box::new([front.one_side()?, back.one_side()?]) })
    }

    /// The material as one side of a `twosided`.
    fn one_side(self) -> Result<Self, &'static str> {
        match self {
            Self::Blend { weight, parts } => {
                let [first, second] = *parts;
                Ok(Self::Blend { weight, parts: Box::new([first.one_side()?, second.one_side()?]) })
            }
            Self::Surface(surface) if crosses(&surface) => Ok(Self::Surface(surface)),
            other => other.two_sided(),
        }
    }

    /// Puts a `bumpmap` or `normalmap` around the material.
    pub fn with_relief(self, relief: Relief, relief_rules: ReliefRules) -> Result<Self, &'static str> {
        if matches!(self, Self::Sides { .. }) {
            return Err(
                "a bump or normal map around a `twosided` with two sides is not supported; put one into each side",
            );
        }
        self.map(&|surface| match surface.relief {
            None => {
                let relief_outside = surface.two_sided;
                Ok(SurfaceMaterial { relief: Some(relief), relief_outside, relief_rules, ..surface })
            }
            Some(_) => Err("a bump or normal map inside another is not supported"),
        })
    }

    /// Puts a `coating` around the material. A coating is alike on both sides, so around `twosided` it is the same as
    /// inside.
    pub fn coated(self, coating: Coating) -> Result<Self, &'static str> {
        self.map(&|surface| {
            if surface.relief.is_some() {
                return Err(
                    "a `coating` around a bump or normal map is not supported; put the map around the `coating`",
                );
            }
            if surface.coating.is_some() {
                return Err("a `coating` inside another is not supported");
            }
            if surface.sheen.is_some() {
                return Err("a `coating` around a `sheen` is not supported; blend a `roughconductor` with the `sheen`");
            }
            if is_transmissive(&surface) {
                return Err("a `coating` over a material that transmits light is not supported");
            }
            Ok(SurfaceMaterial { coating: Some(Box::new(coating)), ..surface })
        })
    }

    /// Puts a `sheen` around the material.
    pub fn with_sheen(self, sheen: Sheen) -> Result<Self, &'static str> {
        self.map(&|surface| {
            if surface.relief.is_some() {
                return Err("a `sheen` around a bump or normal map is not supported; put the map around the `sheen`");
            }
            if surface.coating.is_some() || surface.sheen.is_some() {
                return Err("a `sheen` around a `coating` or another `sheen` is not supported");
            }
            if surface.opacity != Textured::constant(1.0) || matches!(surface.bsdf, Bsdf::ThinDielectric { .. }) {
                return Err("a `sheen` around a material that lets light go straight on is not supported");
            }
            Ok(SurfaceMaterial { sheen: Some(Box::new(sheen)), ..surface })
        })
    }
}

const NESTED_TWICE: &str = "`twosided` around a bump or normal map around another `twosided` is not supported";

/// Whether the whole surface scatters light to its other side, and lets none go straight on.
fn crosses(surface: &SurfaceMaterial) -> bool {
    let scatters =
        matches!(surface.bsdf, Bsdf::Dielectric { .. } | Bsdf::RoughDielectric { .. } | Bsdf::PrincipledThin(_));
    scatters && surface.opacity == Textured::constant(1.0)
}

fn is_transmissive(surface: &SurfaceMaterial) -> bool {
    let transmits = match &surface.bsdf {
        Bsdf::Dielectric { .. }
        | Bsdf::ThinDielectric { .. }
        | Bsdf::RoughDielectric { .. }
        | Bsdf::Hair { .. }
        | Bsdf::PrincipledThin(_) => true,
        Bsdf::Principled(principled) => principled.spec_trans != Textured::constant(0.0),
        _ => false,
    };
    transmits || surface.opacity != Textured::constant(1.0)
}
