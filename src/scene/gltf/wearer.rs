//! Facts of a primitive that its material depends on.

use gltf::accessor::Dimensions;
use gltf::material::AlphaMode;
use gltf::{Primitive, Semantic};

use super::asset::{Asset, plain};
use super::relief::Turned;
use crate::Result;

/// Source of a primitive's color besides the material.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Coloring {
    /// No other.
    None,
    /// The colors of the vertices.
    Vertices,
}

/// Facts of a primitive that decide what its material becomes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Wearer {
    pub coloring: Coloring,
    /// Bits of the alpha of the vertices' colors.
    pub alpha: u32,
    /// Directions of the normal map.
    pub turned: Turned,
}

impl Wearer {
    /// End of the material's id, which tells its forms apart.
    pub fn suffix(&self) -> String {
        let mut suffix = String::new();
        if self.coloring == Coloring::Vertices {
            suffix += "_colored";
        }
        if f32::from_bits(self.alpha) != 1.0 {
            suffix += &format!("_alpha{}", plain(&f32::from_bits(self.alpha).to_string()));
        }
        let turned = ["_red", "_green"].into_iter().zip(self.turned).filter(|(_, turned)| *turned);
        turned.for_each(|(channel, _)| suffix += channel);
        suffix
    }

    /// Vertex colors of a primitive other than white, and their alpha, where it counts.
    pub fn of(asset: &Asset, mesh: usize, primitive: &Primitive) -> Result<Self> {
        let none = Self { coloring: Coloring::None, alpha: 1.0_f32.to_bits(), turned: [false; 2] };
        let Some(accessor) = primitive.get(&Semantic::Colors(0)) else { return Ok(none) };
        let colors = asset.elements::<3>(&accessor)?;
        let is_white = colors.iter().flatten().all(|&channel| channel > 0.9999);
        let coloring = if is_white { Coloring::None } else { Coloring::Vertices };
        let counts =
            accessor.dimensions() == Dimensions::Vec4 && primitive.material().alpha_mode() != AlphaMode::Opaque;
        if !counts || colors.is_empty() {
            return Ok(Self { coloring, ..none });
        }
        let alphas = asset.elements::<4>(&accessor)?.into_iter().map(|color| color[3].clamp(0.0, 1.0));
        let (least, most) = alphas.clone().fold((1.0, 0.0), |(least, most), alpha| (alpha.min(least), alpha.max(most)));
        let mean = alphas.sum::<f64>() / colors.len() as f64;
        if most - least > 1.0e-3 {
            asset.warn(format!("mesh {mesh}: the alpha of its vertices varies; its mean of {mean:.3} is used"));
            return Ok(Self { coloring, alpha: (mean as f32).to_bits(), ..none });
        }
        Ok(Self { coloring, alpha: (least as f32).to_bits(), ..none })
    }
}
