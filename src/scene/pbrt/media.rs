//! Media as objects.

use std::collections::{BTreeMap, HashMap};

use super::colors;
use super::files::Files;
use super::names::Names;
use super::nodes::rgb;
use super::parameters::Parameter;
use super::tokens::{Place, brief};
use super::world::{Entity, Sides};
use crate::Result;
use crate::scene::description::kinds::Kind;
use crate::scene::description::make::{nested, object};
use crate::scene::description::object::{Object, Value};
use crate::scene::faults::Faults;

/// Media that surfaces border or that the camera is in.
pub(super) struct Media {
    /// Ids of their objects, by their names.
    ids: HashMap<String, String>,
    objects: Vec<(String, Object)>,
}

impl Media {
    /// Makes the objects of the media that are used, each with the place of its first use.
    pub fn new(
        defined: &HashMap<String, Entity>,
        used: &BTreeMap<String, Place>,
        names: &Names,
        files: &mut Files,
        faults: &mut Faults,
    ) -> Self {
        let mut media = Self { ids: HashMap::new(), objects: Vec::new() };
        for (name, place) in used {
            let Some(entity) = defined.get(name) else {
                let name = brief(name);
                faults.add(place.error(format!("the medium `{name}` is not defined; define it by MakeNamedMedium")));
                continue;
            };
            let Some(made) = faults.keep(medium(name, entity, files)) else { continue };
            let id = names.id(name);
            let label = names.label(&entity.parameters.place, &format!("medium `{}`", brief(name)));
            media.objects.push((label, made.with_id(id.clone())));
            media.ids.insert(name.clone(), id);
        }
        media
    }

    /// The shape with the media on its sides. Where both are the same, pbrt's rays keep their medium.
    pub fn around(&self, shape: Object, sides: &Sides) -> Object {
        let [inside, outside] = &**sides;
        if inside == outside {
            return shape;
        }
        let with = |shape: Object, (key, name): (&'static str, &String)| self.named(shape, key, name);
        [("interior", inside), ("exterior", outside)].into_iter().fold(shape, with)
    }

    /// The object with the medium of that name.
    pub fn named(&self, object: Object, key: &'static str, name: &str) -> Object {
        match self.ids.get(name) {
            Some(id) => object.with(key, Value::Reference(id.clone())),
            None => object,
        }
    }

    /// Objects of the media.
    pub fn finish(self) -> Vec<(String, Object)> {
        self.objects
    }
}

/// Whether one of the numbers of a color is negative.
fn is_negative(color: &Parameter) -> bool {
    color.kind == "rgb" && color.numbers().is_ok_and(|numbers| numbers.iter().any(|number| *number < 0.0))
}

fn medium(name: &str, entity: &Entity, files: &mut Files) -> Result<Object> {
    let parameters = &entity.parameters;
    let name = brief(name);
    if entity.kind != "homogeneous" {
        let message =
            format!("the medium `{name}` of the type `{}` is not supported; use `homogeneous`", brief(&entity.kind));
        return Err(entity.error(message));
    }
    for unsupported in ["preset", "Le"] {
        if let Some(parameter) = parameters.get(unsupported) {
            return Err(parameter.error("of a medium is not supported; give `sigma_a` and `sigma_s`, and no light"));
        }
    }
    parameters.ignore(&["Lescale", "type"]);
    let mut color = |name: &str| match parameters.get(name) {
        Some(parameter) if is_negative(parameter) => Err(parameter.error("of a medium must not be negative")),
        Some(parameter) => colors::of_material(parameter, entity.color_space, files),
        None => Ok([1.0; 3]),
    };
    let (absorption, scattering) = (color("sigma_a")?, color("sigma_s")?);
    let scale = parameters.number("scale", 1.0)?;
    let g = parameters.number("g", 0.0)?;
    let phase = object(Kind::Phase, "hg", [("g", Value::Float(g))]);
    Ok(object(
        Kind::Medium,
        "homogeneous",
        [
            ("sigma_a", rgb(absorption)),
            ("sigma_s", rgb(scattering)),
            ("scale", Value::Float(scale)),
            ("phase", nested(phase)),
        ],
    ))
}
