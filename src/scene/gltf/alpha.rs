//! Alpha of materials: the opacity of a surface, and its emission, which the alpha covers, too.

use gltf::Material;
use gltf::material::AlphaMode;

use super::images::{BaseColor, Coding, Images, TextureUse, at_place, scaled};
use crate::Result;
use crate::image::tone::srgb;
use crate::math::srgb::linear_from_srgb;
use crate::scene::description::make::{color, nested, number};
use crate::scene::description::object::Value;

/// Opacity of a surface with holes.
pub(super) struct Opacity<'a> {
    texture: Option<TextureUse<'a>>,
    /// Factor of the texture's alpha, or the alpha where there is no texture.
    factor: f32,
    /// Least alpha of what is there at all, where the mode is `MASK`.
    cutoff: Option<f32>,
}

impl<'a> Opacity<'a> {
    /// Opacity of a material with that base color; `None` where the surface has no holes.
    pub fn of(material: &Material, base: &BaseColor<'a>) -> Option<Self> {
        let (factor, texture) = (base.factor[3].clamp(0.0, 1.0), base.texture.clone());
        let cutoff = match material.alpha_mode() {
            AlphaMode::Opaque => return None,
            AlphaMode::Blend if texture.is_none() && factor == 1.0 => return None,
            AlphaMode::Blend => None,
            AlphaMode::Mask => Some(material.alpha_cutoff().unwrap_or(0.5)),
        };
        Some(Self { texture, factor, cutoff })
    }

    /// Opacity where there is no texture, or else the factor of [`Opacity::share`].
    pub fn scale(&self) -> f32 {
        match (self.cutoff, &self.texture) {
            (None, _) => self.factor,
            (Some(cutoff), None) => f32::from(u8::from(self.factor >= cutoff)),
            (Some(_), Some(_)) => 1.0,
        }
    }

    /// Opacity of a texel, as a byte.
    fn share(&self, texel: [u8; 4]) -> u8 {
        match self.cutoff {
            None => texel[3],
            Some(cutoff) if f32::from(texel[3]) / 255.0 * self.factor >= cutoff => u8::MAX,
            Some(_) => 0,
        }
    }

    /// Name of what is made of the texture's alpha.
    fn tag(&self) -> String {
        match self.cutoff {
            None => "alpha".to_owned(),
            Some(cutoff) => format!("cutoff{}", cutoff / self.factor.max(1.0e-6)),
        }
    }

    /// Value of a `mask`.
    pub fn value(&self, images: &mut Images<'a>) -> Result<Value> {
        Ok(match &self.texture {
            None => number(self.scale()),
            Some(texture) => {
                let texels = images.numbers(texture, &self.tag(), |texel| self.share(texel))?;
                nested(scaled(texels, [self.scale(); 3]))
            }
        })
    }

    /// Whether the texels of the opacity lie where those of `texture` lie.
    fn fits(&self, texture: Option<&TextureUse>) -> bool {
        self.texture.as_ref().zip(texture).is_none_or(|(own, other)| own.lies_as(other))
    }

    /// Radiance of an emission that the opacity covers.
    fn covered(
        &self,
        images: &mut Images<'a>,
        texture: Option<&TextureUse<'a>>,
        factor: [f32; 3],
    ) -> Result<Option<Value>> {
        let factor = factor.map(|channel| channel * self.scale());
        let Some(own) = &self.texture else { return plain(images, texture, factor) };
        let Some(texture) = texture else {
            let shares = images.numbers(own, &self.tag(), |texel| self.share(texel))?;
            return Ok(Some(nested(scaled(shares, factor))));
        };
        let alpha = images.texels(own)?;
        let tag = format!("under{}-{}", images.image(own)?.index(), self.tag());
        let covered = |texel: [u8; 4], u: f32, v: f32| {
            let share = f64::from(self.share(at_place(&alpha, u, v))) / 255.0;
            let [red, green, blue, _] = texel;
            [red, green, blue]
                .map(|byte| (srgb(share * linear_from_srgb(f64::from(byte) / 255.0)) * 255.0).round() as u8)
        };
        Ok(Some(nested(scaled(images.made(texture, &tag, Coding::Srgb, covered)?, factor))))
    }
}

/// Radiance of an emission by its texture and factor, under an opacity; `None` where nothing shines. `warn` is told where the
/// opacity cannot be followed.
pub(super) fn radiance<'a>(
    images: &mut Images<'a>,
    texture: Option<&TextureUse<'a>>,
    factor: [f32; 3],
    opacity: Option<&Opacity<'a>>,
    warn: impl FnOnce(&str),
) -> Result<Option<Value>> {
    match opacity {
        _ if factor == [0.0; 3] => Ok(None),
        Some(opacity) if opacity.scale() == 0.0 => Ok(None),
        Some(opacity) if opacity.fits(texture) => opacity.covered(images, texture, factor),
        Some(_) => {
            warn("the images of its emission and its alpha lie differently on it; its holes shine");
            plain(images, texture, factor)
        }
        None => plain(images, texture, factor),
    }
}

fn plain<'a>(images: &mut Images<'a>, texture: Option<&TextureUse<'a>>, factor: [f32; 3]) -> Result<Option<Value>> {
    Ok(Some(match texture {
        Some(texture) => nested(scaled(images.bitmap(texture, Coding::Srgb)?, factor)),
        None => color(factor),
    }))
}
