//! Parameters of a plugin, by name and type. Parameters that were not read are reported at the end.

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Arc;

use glam::{DMat4, DVec3, Vec3};

use super::color;
use super::parameter::Parameter;
use super::scope::Scope;
use crate::Result;
use crate::scene::description::kinds::{Kind, Type};
use crate::scene::description::object::{Entry, Object, Value};
use crate::scene::description::origin::Origin;
use crate::scene::description::transform::Transform;
use crate::scene::folders::FoundFile;
use crate::scene::grids::Grid;
use crate::scene::spectrum::SpectrumUse;

/// Transforms at points in time.
pub(super) type Keys = Vec<(f64, DMat4)>;

/// Types of numbers.
const NUMBERS: [Type; 2] = [Type::Float, Type::Integer];

/// Types of colors.
const COLORS: [Type; 6] = [Type::Rgb, Type::Srgb, Type::Spectrum, Type::Blackbody, Type::Float, Type::Integer];

/// Parameters and nested objects of one plugin.
pub(super) struct Properties<'a> {
    owner: &'a Object,
    scope: Scope<'a>,
    /// Parameters by their names in snake_case, each with its place in the order of the scene.
    parameters: HashMap<Cow<'a, str>, (usize, Parameter<'a>)>,
    /// Parameters that are known but make no difference here.
    without_effect: Vec<(usize, Parameter<'a>)>,
    objects: Vec<Nested<'a>>,
}

/// Nested object, with references followed.
struct Nested<'a> {
    object: &'a Object,
    /// Entry at which the object is nested: its own, or the reference to it.
    at: Parameter<'a>,
}

impl<'a> Properties<'a> {
    pub fn new(owner: &'a Object, scope: &Scope<'a>) -> Result<Self> {
        let mut result = Self {
            owner,
            scope: Rc::clone(scope),
            parameters: HashMap::new(),
            without_effect: Vec::new(),
            objects: Vec::new(),
        };
        for (place, entry) in owner.entries.iter().enumerate() {
            let at = Parameter { owner, entry };
            match &entry.value {
                Value::Object(object) if object.kind != Kind::Spectrum => result.objects.push(Nested { object, at }),
                Value::Reference(id) if let Some(spectrum) = scope.spectrum(id) => {
                    let parameter = Parameter { owner, entry: spectrum };
                    if result.parameters.insert(entry.key(), (place, parameter)).is_some() {
                        return Err(at.error(format!("the parameter `{}` is given twice", entry.name)));
                    }
                }
                Value::Reference(id) => {
                    let object = scope.find(id).map_err(|message| at.error(message))?;
                    result.objects.push(Nested { object, at });
                }
                Value::Fault(fault) if fault.of.is_none() => return Err(at.error(&fault.message)),
                _ => {
                    if result.parameters.insert(entry.key(), (place, at)).is_some() {
                        return Err(at.error(format!("the parameter `{}` is given twice", entry.name)));
                    }
                }
            }
        }
        Ok(result)
    }

    /// Object of the plugin.
    pub fn owner(&self) -> &'a Object {
        self.owner
    }

    /// Name of the plugin.
    pub fn plugin(&self) -> &'a str {
        &self.owner.plugin
    }

    /// Place of a parameter, or else of the plugin.
    pub fn location(&self, name: &str) -> Origin {
        self.get(name).map_or_else(|| self.owner.origin.clone(), |parameter| parameter.origin())
    }

    fn get(&self, name: &str) -> Option<Parameter<'a>> {
        self.parameters.get(name).map(|(_, parameter)| *parameter)
    }

    /// Removes and returns a parameter, for messages or for special reading. The parameter then counts as read.
    pub fn take(&mut self, name: &str) -> Option<Parameter<'a>> {
        self.parameters.remove(name).map(|(_, parameter)| parameter)
    }

    /// Removes and returns a parameter that must have one of these types.
    pub fn take_typed(&mut self, name: &str, types: &[Type]) -> Result<Option<Parameter<'a>>> {
        let Some(parameter) = self.take(name) else { return Ok(None) };
        match &parameter.entry.value {
            value if value.type_of().is_none_or(|found| !types.contains(&found)) => {
                Err(parameter.mismatch(types[0].name(), name))
            }
            Value::Fault(fault) => Err(parameter.fault(fault)),
            _ => Ok(Some(parameter)),
        }
    }

    pub fn float(&mut self, name: &str) -> Result<Option<f32>> {
        let parameter = self.take_typed(name, &NUMBERS)?;
        parameter.map(|parameter| Ok(parameter.number()? as f32)).transpose()
    }

    pub fn is_number(&self, name: &str) -> bool {
        self.type_of(name).is_some_and(|found| NUMBERS.contains(&found))
    }

    pub fn is_vector(&self, name: &str) -> bool {
        matches!(self.type_of(name), Some(Type::Point | Type::Vector))
    }

    pub fn is_string(&self, name: &str) -> bool {
        self.type_of(name) == Some(Type::String)
    }

    fn type_of(&self, name: &str) -> Option<Type> {
        self.get(name)?.entry.value.type_of()
    }

    /// Reads a float that must be greater than zero.
    pub fn positive_float(&mut self, name: &str, default: f32) -> Result<f32> {
        let parameter = self.get(name);
        match (self.float(name)?, parameter) {
            (Some(value), Some(parameter)) if value <= 0.0 => {
                Err(parameter.error(format!("`{name}` must be greater than 0, not {value}")))
            }
            (value, _) => Ok(value.unwrap_or(default)),
        }
    }

    /// Reads an integer in `range`.
    pub fn integer(&mut self, name: &str, range: std::ops::RangeInclusive<i64>) -> Result<Option<i64>> {
        match self.take_typed(name, &[Type::Integer])? {
            Some(Parameter { entry: Entry { value: Value::Integer(value), .. }, .. }) if range.contains(value) => {
                Ok(Some(*value))
            }
            Some(parameter @ Parameter { entry: Entry { value: Value::Integer(value), .. }, .. }) => {
                let (first, last) = (range.start(), range.end());
                Err(parameter.error(format!("`{name}` must lie in {first}..{last}, not {value}")))
            }
            _ => Ok(None),
        }
    }

    pub fn boolean(&mut self, name: &str) -> Result<Option<bool>> {
        Ok(match self.take_typed(name, &[Type::Boolean])?.map(|parameter| &parameter.entry.value) {
            Some(Value::Boolean(value)) => Some(*value),
            _ => None,
        })
    }

    pub fn string(&mut self, name: &str) -> Result<Option<&'a str>> {
        Ok(match self.take_typed(name, &[Type::String])?.map(|parameter| &parameter.entry.value) {
            Some(Value::Text(text)) => Some(text),
            Some(Value::Image(image)) => Some(&image.name),
            _ => None,
        })
    }

    /// Reads a color of a material.
    pub fn color(&mut self, name: &str) -> Result<Option<Vec3>> {
        self.color_used_as(name, SpectrumUse::Material)
    }

    /// Reads a color of a material that may be negative.
    pub fn signed_color(&mut self, name: &str) -> Result<Option<Vec3>> {
        let parameter = self.take_typed(name, &COLORS)?;
        parameter.map(|parameter| color::signed(parameter, SpectrumUse::Material, self.scope.folders)).transpose()
    }

    /// Reads a color of emitted light.
    pub fn emission(&mut self, name: &str) -> Result<Option<Vec3>> {
        self.color_used_as(name, SpectrumUse::Emission)
    }

    fn color_used_as(&mut self, name: &str, spectrum_use: SpectrumUse) -> Result<Option<Vec3>> {
        let parameter = self.take_typed(name, &COLORS)?;
        parameter.map(|parameter| color::positive(parameter, spectrum_use, self.scope.folders)).transpose()
    }

    pub fn point(&mut self, name: &str) -> Result<Option<DVec3>> {
        let parameter = self.take_typed(name, &[Type::Point, Type::Vector])?;
        parameter.map(|parameter| parameter.three().map(DVec3::from)).transpose()
    }

    /// Reads the transform `to_world`; the identity where there is none.
    pub fn take_to_world(&mut self) -> Result<DMat4> {
        self.take_transform("to_world")
    }

    /// Reads the keys of an animated `to_world`; `None` where it does not depend on time.
    pub fn take_keys(&mut self) -> Result<Option<Box<Keys>>> {
        if self.type_of("to_world") != Some(Type::Animation) {
            return Ok(None);
        }
        match self.take_typed("to_world", &[Type::Animation])? {
            Some(parameter @ Parameter { entry: Entry { value: Value::Animation(keys), .. }, .. }) => {
                let format = self.owner.origin.format;
                let matrix = |(time, transform): &(f64, Transform)| Ok((*time, transform.product(format)?));
                let keys: Result<Keys, String> = keys.iter().map(matrix).collect();
                keys.map(|keys| Some(Box::new(keys))).map_err(|message| parameter.error(message))
            }
            _ => Ok(None),
        }
    }

    /// Reads a transform; the identity where there is none.
    pub fn take_transform(&mut self, name: &str) -> Result<DMat4> {
        if let Some(parameter) = self.get(name)
            && let Value::Animation(_) = parameter.entry.value
        {
            let transform = parameter.origin().word("transform");
            return Err(parameter.error(format!("{} cannot move; give its `{name}` as a {transform}", self.named())));
        }
        match self.take_typed(name, &[Type::Transform])? {
            Some(parameter @ Parameter { entry: Entry { value: Value::Transform(transform), .. }, .. }) => {
                transform.product(self.owner.origin.format).map_err(|message| parameter.error(message))
            }
            _ => Ok(DMat4::IDENTITY),
        }
    }

    /// Reads the file that a parameter names; `kind` says in messages what it is. A file in memory has a name and its content.
    pub fn file(&mut self, name: &str, kind: &str) -> Result<(FoundFile, Parameter<'a>)> {
        let parameter = self.take_typed(name, &[Type::String])?.ok_or_else(|| {
            let (kind, plugin) = (self.owner.kind.name(), self.plugin());
            self.owner.error(format!("{kind} plugin `{plugin}` needs its parameter `{name}`"))
        })?;
        let found = match &parameter.entry.value {
            Value::Image(image) => {
                Some(FoundFile { path: PathBuf::from(&image.name), bytes: Some(image.bytes.clone()) })
            }
            Value::Text(file) => {
                let path = self.scope.folders.find(file, &parameter.origin().file);
                path.and_then(|path| path.canonicalize().ok()).map(|path| FoundFile { path, bytes: None })
            }
            _ => None,
        };
        let found =
            found.ok_or_else(|| parameter.error(format!("the {kind} `{}` does not exist", parameter.text())))?;
        Ok((found, parameter))
    }

    /// Reads a mesh in memory, and returns its index among all of the scene; `None` where there is none.
    pub fn mesh(&mut self, name: &str) -> Option<usize> {
        let Value::Mesh(mesh) = &self.get(name)?.entry.value else { return None };
        self.take(name);
        self.scope.mesh_index(mesh)
    }

    /// Reads a grid in memory; `None` where there is none.
    pub fn grid(&mut self, name: &str) -> Option<Arc<Grid>> {
        let Value::Grid(grid) = &self.get(name)?.entry.value else { return None };
        self.take(name);
        Some(Arc::clone(grid))
    }

    /// Whether a parameter is given, as a value or as a texture.
    pub fn has(&self, name: &str) -> bool {
        self.parameters.contains_key(name) || self.objects.iter().any(|nested| nested.is_texture(name))
    }

    /// Removes and returns the nested objects of a kind.
    pub fn objects(&mut self, kind: Kind) -> Vec<&'a Object> {
        self.objects.extract_if(.., |nested| nested.object.kind == kind).map(|nested| nested.object).collect()
    }

    /// Removes and returns the nested objects of a kind, with the names that they have here.
    pub fn named_objects(&mut self, kind: Kind) -> Vec<(Cow<'a, str>, &'a Object)> {
        let nested = self.objects.extract_if(.., |nested| nested.object.kind == kind);
        nested.map(|nested| (nested.at.entry.key(), nested.object)).collect()
    }

    /// Removes and returns the object of a kind that is nested as a parameter.
    pub fn nested(&mut self, name: &str, kind: Kind) -> Result<Option<&'a Object>> {
        let is_it = |nested: &mut Nested| nested.object.kind == kind && nested.at.entry.key() == name;
        let found: Vec<_> = self.objects.extract_if(.., is_it).collect();
        match (self.get(name), found.get(1).map(|second| second.at)) {
            (Some(twice), _) | (None, Some(twice)) if !found.is_empty() => {
                Err(twice.error(format!("the parameter `{name}` is given twice")))
            }
            _ => Ok(found.first().map(|nested| nested.object)),
        }
    }

    /// Removes and returns the texture that is nested as a parameter.
    pub fn texture(&mut self, name: &str) -> Result<Option<&'a Object>> {
        self.nested(name, Kind::Texture)
    }

    /// Removes and returns the only nested object of a kind; a second one is an error.
    pub fn object(&mut self, kind: Kind) -> Result<Option<&'a Object>> {
        let objects = self.objects(kind);
        if let Some(second) = objects.get(1) {
            let word = self.owner.origin.word(kind.name());
            return Err(second.error(format!("a second {word} in {}", self.named())));
        }
        Ok(objects.first().copied())
    }

    /// Drops parameters of choices that are made elsewhere, such as how the picture is stored.
    pub fn ignore(&mut self, names: &[&str]) {
        for name in names {
            self.parameters.remove(*name);
        }
    }

    /// Drops parameters that would change only the noise in Mitsuba and have no effect here. Each gets a warning.
    pub fn ignore_sampling(&mut self, names: &[&str]) {
        self.without_effect.extend(names.iter().filter_map(|name| self.parameters.remove(*name)));
    }

    /// Kind and plugin, for messages.
    fn named(&self) -> String {
        format!("{} `{}`", self.owner.kind.name(), self.owner.plugin)
    }

    /// Reports what was not read: a warning for each parameter, an error for each nested object.
    pub fn finish(self, warnings: &mut Vec<String>) -> Result<()> {
        let owner = self.named();
        if let Some(Nested { object, at }) = self.objects.first() {
            let named = match &*at.entry.name {
                "" => String::new(),
                name => format!(" named `{name}`"),
            };
            let (word, plugin) = (at.origin().word(object.kind.name()), &object.plugin);
            return Err(at.error(format!("{word} plugin `{plugin}`{named} is not supported in {owner}")));
        }
        let unknown = self.parameters.into_values().map(|parameter| (parameter, "is unknown"));
        let without_effect = self.without_effect.into_iter().map(|parameter| (parameter, "changes only the noise"));
        let mut ignored: Vec<_> = unknown.chain(without_effect).collect();
        ignored.sort_by_key(|((place, _), _)| *place);
        for ((_, parameter), why) in ignored {
            let (origin, name) = (parameter.origin(), &parameter.entry.name);
            warnings.push(format!("{origin}: the parameter `{name}` of {owner} {why}; ignored"));
        }
        Ok(())
    }
}

impl Nested<'_> {
    fn is_texture(&self, name: &str) -> bool {
        self.object.kind == Kind::Texture && self.at.entry.key() == name
    }
}
