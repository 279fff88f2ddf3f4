//! Reader of `projector`, a point light that throws a picture.

use glam::{DMat4, Vec3};

use super::emission::{non_negative, picture};
use super::properties::Properties;
use super::textures::Textures;
use super::{sensor, transform};
use crate::Result;
use crate::scene::description::origin::Origin;
use crate::scene::texture::{Image, Pattern, Texture, Textured};
use crate::scene::{DeltaEmitter, DeltaKind, FovAxis, PictureAxes};

/// `projector` whose picture may not be decoded yet.
pub(super) struct Projector {
    position: Vec3,
    direction: Vec3,
    /// Unit directions along which the picture's coordinates grow.
    axes: [Vec3; 2],
    fov: f32,
    fov_axis: FovAxis,
    irradiance: Textured<Vec3>,
    sampling_weight: f32,
}

/// Reads a `projector`.
pub(super) fn parse<'a>(
    properties: &mut Properties<'a>,
    sampling_weight: f32,
    textures: &mut Textures<'a>,
    warnings: &mut Vec<String>,
) -> Result<Projector> {
    let location = properties.location("to_world");
    let to_world = properties.take_to_world()?;
    let axes = axes(&to_world, &location)?;
    let (fov, fov_axis) = sensor::parse_fov(properties)?;
    if !properties.has("irradiance") {
        return Err(properties.owner().error("emitter plugin `projector` needs its parameter `irradiance`"));
    }
    let scale = non_negative(properties, "scale", 1.0)?;
    let irradiance = picture(properties, "irradiance", textures, warnings)?;
    Ok(Projector {
        position: to_world.w_axis.truncate().as_vec3(),
        direction: to_world.z_axis.truncate().normalize().as_vec3(),
        // The picture's left is `+x`, and its top is `+y`, as with a camera.
        axes: axes.map(|axis| -axis),
        fov,
        fov_axis,
        irradiance: Textured { value: irradiance.value * scale, ..irradiance },
        sampling_weight,
    })
}

/// Unit axes `x` and `y` of a light that throws a picture. The error asks for a transform without scale and shear.
pub(super) fn axes(to_world: &DMat4, location: &Origin) -> Result<[Vec3; 2]> {
    let [x, y, _] = transform::axes(to_world);
    if !transform::is_similarity(to_world, 1.0e-3) || (x.length_squared() - 1.0).abs() > 1.0e-3 {
        return Err(location.error("the `to_world` of a light with a picture must neither scale nor shear"));
    }
    Ok([x, y].map(|axis| axis.normalize().as_vec3()))
}

impl Projector {
    /// The emitter, when all images are decoded.
    pub fn finish(self, textures: &[Texture], images: &[Image]) -> DeltaEmitter {
        let picture = self.irradiance.texture.map(|texture| &textures[texture as usize].pattern);
        let (width, height) = match picture {
            Some(Pattern::Bitmap { image, .. }) => {
                let image = &images[*image as usize];
                (image.width, image.height)
            }
            _ => (1, 1),
        };
        let half_width = self.fov_axis.tan_half_fov_x(self.fov, width, height);
        let half_height = half_width * height as f32 / width as f32;
        let [u, v] = self.axes;
        let axes = PictureAxes { u: u / (2.0 * half_width), v: v / (2.0 * half_height) };
        let Self { position, direction, irradiance, sampling_weight, .. } = self;
        DeltaEmitter { kind: DeltaKind::Projector { position, direction, axes, irradiance }, sampling_weight }
    }
}
