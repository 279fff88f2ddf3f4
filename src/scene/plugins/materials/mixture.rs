//! `mixturebsdf`, a plugin of Mitsuba 0.6 that Mitsuba 3 lacks: several BSDFs with weights, as nested blends.

use glam::Vec3;

use super::parameters::Parameters;
use super::tree::Tree;
use crate::Result;
use crate::scene::bsdf::{Bsdf, SurfaceMaterial};
use crate::scene::numbers;
use crate::scene::texture::Textured;

/// Share of light that may be missing from the weights' sum, because scene files are printed with few digits.
const TOLERANCE: f64 = 1e-5;

/// Reads a `mixturebsdf`. As in Mitsuba 0.6, what its weights lack to 1 is absorbed, and weights whose sum exceeds 1 are
/// scaled down.
pub(super) fn mixture(parameters: &mut Parameters, parts: Vec<Tree>) -> Result<Tree> {
    let object = parameters.owner();
    let conserves = parameters.properties.boolean("ensure_energy_conservation")?.unwrap_or(true);
    let location = parameters.properties.location("weights");
    let text = parameters.properties.string("weights")?;
    let text = text.ok_or_else(|| object.error("bsdf plugin `mixturebsdf` needs its parameter `weights`"))?;
    let weights = numbers::list(text).map_err(|message| location.error(message))?;
    if parts.is_empty() || weights.len() != parts.len() {
        let (weights, parts, word) = (weights.len(), parts.len(), location.word("bsdf"));
        return Err(
            location.error(format!("a `mixturebsdf` needs a weight for each nested {word}: {weights} for {parts}"))
        );
    }
    if let Some(negative) = weights.iter().find(|&&weight| weight < 0.0) {
        return Err(location.error(format!("a weight must not be negative, as {negative} is")));
    }
    let sum: f64 = weights.iter().sum();
    let mut weighted: Vec<(f64, Tree)> = weights.into_iter().zip(parts).collect();
    if sum > 1.0 + TOLERANCE {
        if !conserves {
            return Err(location.error(format!("the weights' sum is {sum}; more than 1 would create light")));
        }
        parameters.warnings.push(format!("{location}: the weights' sum is {sum}; they are scaled to a sum of 1"));
    } else if sum < 1.0 - TOLERANCE {
        let black = Bsdf::Diffuse { reflectance: Textured::constant(Vec3::ZERO) };
        weighted.push((1.0 - sum, Tree::Surface(SurfaceMaterial::plain(black))));
    }
    Ok(blend(weighted).1)
}

/// Blends BSDFs in proportion to their weights, as shallow as can be. Returns the sum of the weights, too.
fn blend(mut weighted: Vec<(f64, Tree)>) -> (f64, Tree) {
    let second = weighted.split_off(weighted.len().div_ceil(2));
    let (first_weight, first) = match <[_; 1]>::try_from(weighted) {
        Ok([only]) => only,
        Err(several) => blend(several),
    };
    if second.is_empty() {
        return (first_weight, first);
    }
    let (second_weight, second) = blend(second);
    let sum = first_weight + second_weight;
    let share = if sum > 0.0 { second_weight / sum } else { 0.0 };
    (sum, Tree::Blend { weight: Textured::constant(share as f32), parts: Box::new([first, second]) })
}
