//! Lights of shapes.

use std::rc::Rc;

use super::delta_lights::color;
use super::nodes::{Node, rgb};
use super::rasters::Encoding;
use super::textures::Textures;
use super::world::Entity;
use crate::Result;
use crate::scene::description::kinds::Kind;
use crate::scene::description::make::{nested, object};
use crate::scene::description::object::{Object, Value};

/// Light of a shape, up to the area on which its radiance may depend.
pub(super) struct AreaLight {
    radiance: Radiance,
    /// Power of the whole light, where it is given.
    power: Option<f64>,
    pub is_two_sided: bool,
}

enum Radiance {
    Color([f64; 3]),
    /// Image, the factor of its colors, and its mean luminance, which is 1 where no power asks for it.
    Image {
        image: Node,
        factor: f64,
        luminance: f64,
    },
}

impl AreaLight {
    /// Reads an area light. `exposure` is a factor of all light.
    pub fn read(entity: &Rc<Entity>, exposure: f64, textures: &mut Textures) -> Result<Self> {
        let parameters = &entity.parameters;
        if entity.kind != "diffuse" {
            let kind = super::tokens::brief(&entity.kind);
            return Err(entity.error(format!("the area light `{kind}` is not known; use `diffuse`")));
        }
        let is_two_sided = parameters.boolean("twosided", false)?;
        let power = parameters.number("power", -1.0)?;
        let power = (power > 0.0).then_some(power);
        let radiance = match parameters.text("filename")? {
            None => Radiance::Color(color(entity, "L", exposure, textures.images.files)?),
            Some(name) => {
                if let Some(radiance) = parameters.get("L") {
                    return Err(radiance.error("cannot stand beside `filename`; give one of them"));
                }
                let image = textures.bitmap(name, Encoding::Srgb, &parameters.place)?;
                let luminance = match (power, &image) {
                    (Some(_), Node::Image { image, .. }) => textures.images.luminance_of(image, entity)?,
                    _ => 1.0,
                };
                let factor = color(entity, "L", exposure, textures.images.files)?[0];
                Radiance::Image { image, factor, luminance }
            }
        };
        textures.images.warnings.extend(parameters.unread());
        if is_two_sided {
            textures
                .images
                .warn(&parameters.place, "a light that emits from both sides becomes two shapes, back to back");
        }
        Ok(Self { radiance, power, is_two_sided })
    }

    /// Whether the radiance depends on the shape's area.
    pub fn has_power(&self) -> bool {
        self.power.is_some()
    }

    /// Whether the radiance varies over the shape.
    pub fn is_textured(&self) -> bool {
        matches!(self.radiance, Radiance::Image { .. })
    }

    /// Emitter of a shape with this area.
    pub fn emitter(&self, area: f64, textures: &mut Textures) -> Result<Object> {
        let sides = if self.is_two_sided { 2.0 } else { 1.0 };
        let of_power = |mean: f64| match self.power {
            Some(power) if mean * area > 0.0 => power / (mean * sides * area * std::f64::consts::PI),
            _ => 1.0,
        };
        let radiance = match &self.radiance {
            Radiance::Color(color) => {
                let factor = of_power(1.0);
                rgb(color.map(|channel| channel * factor))
            }
            Radiance::Image { image, factor, luminance } => {
                let texture = textures.color_value(image)?;
                let factor = factor * of_power(*luminance);
                match texture {
                    Value::Object(texture) if factor != 1.0 => {
                        let entries = [("scale", Value::Float(factor)), ("texture", Value::Object(texture))];
                        nested(object(Kind::Texture, "scale", entries))
                    }
                    texture => texture,
                }
            }
        };
        Ok(object(Kind::Emitter, "area", [("radiance", radiance)]))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::Arc;

    use super::super::color_space::ColorSpace;
    use super::super::files::Files;
    use super::super::images::Images;
    use super::super::names::Names;
    use super::super::parameters::Parameters;
    use super::super::tokens::{Place, Tokens};
    use super::super::transforms::Current;
    use super::super::world::World;
    use super::*;
    use crate::image::texels::encode_png;

    /// The reader of lights decodes an image only for a power, and once.
    #[test]
    fn images_are_decoded_for_powers_alone() {
        let folder = tempfile::tempdir().unwrap();
        let (main, path) = (folder.path().join("scene.pbrt"), folder.path().join("a.png"));
        let light = |power: &str| {
            let file: Arc<Path> = Arc::from(main.as_path());
            let text = format!("\"string filename\" \"a.png\" {power}");
            let mut tokens = Tokens::new(&text, Arc::clone(&file));
            let parameters = Parameters::read(&mut tokens, Place { file, line: 1 }, "a light".to_owned()).unwrap();
            let (to_world, color_space) = (Current::IDENTITY, ColorSpace::Srgb);
            Rc::new(Entity { kind: "diffuse".to_owned(), parameters, to_world, at_end: None, color_space })
        };
        let (world, mut files, mut warnings) = (World::default(), Files::new(&main), Vec::new());
        let names = Names::new(&main);
        let mut textures = Textures::new(&world, Images::new(&mut files, &mut warnings), &names);
        let mut is_read = |light: &Rc<Entity>| AreaLight::read(light, 1.0, &mut textures).is_ok();
        let (plain, powered) = (light(""), light("\"float power\" 1"));
        let write = |content: &[u8]| std::fs::write(&path, content).unwrap();
        write(b"no image");
        assert!(is_read(&plain) && !is_read(&powered));
        write(&encode_png(&path, 1, 1, &[[255; 4]]).unwrap());
        assert!(is_read(&powered));
        write(b"no image");
        assert!(is_read(&powered));
    }
}
