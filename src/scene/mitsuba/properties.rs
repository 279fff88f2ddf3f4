//! Parameters of a plugin, by name and type. Parameters that were not read are reported at the end.

use std::collections::HashMap;
use std::path::PathBuf;
use std::rc::Rc;

use glam::{DMat4, DVec3, Vec3};

use super::element::{Element, Location, PARAMETER_TAGS};
use super::folders::FoundFile;
use super::scope::Scope;
use super::spectrum::SpectrumUse;
use super::{color, numbers, transform};
use crate::Result;

/// Elements that give a number.
const NUMBER_TAGS: [&str; 2] = ["float", "integer"];

/// Elements that give a color.
const COLOR_TAGS: [&str; 6] = ["rgb", "srgb", "spectrum", "blackbody", "float", "integer"];

/// Parameters and nested objects of one plugin.
pub(super) struct Properties<'a> {
    element: &'a Element,
    plugin: &'a str,
    scope: Scope<'a>,
    parameters: HashMap<String, &'a Element>,
    /// Parameters that are known but make no difference here.
    without_effect: Vec<&'a Element>,
    objects: Vec<Nested<'a>>,
}

/// Nested object, with references followed.
struct Nested<'a> {
    object: &'a Element,
    /// Element at which the object is nested: the object itself, or the reference to it.
    at: &'a Element,
}

impl<'a> Properties<'a> {
    pub fn new(element: &'a Element, scope: &Scope<'a>) -> Result<Self> {
        let mut result = Self {
            element,
            plugin: element.plugin()?,
            scope: Rc::clone(scope),
            parameters: HashMap::new(),
            without_effect: Vec::new(),
            objects: Vec::new(),
        };
        for child in &element.children {
            if child.is_object() {
                result.objects.push(Nested { object: child, at: child });
            } else if child.tag == "ref" {
                result.objects.push(Nested { object: scope.follow(child)?, at: child });
            } else {
                result.add_parameter(child)?;
            }
        }
        Ok(result)
    }

    fn add_parameter(&mut self, child: &'a Element) -> Result<()> {
        if !PARAMETER_TAGS.contains(&child.tag.as_str()) {
            return Err(child.error(format!("<{}> cannot stand directly in <{}>", child.tag, self.element.tag)));
        }
        let name = child.required("name")?;
        let key = child.key().unwrap_or_default();
        match self.parameters.insert(key, child) {
            Some(_) => Err(child.error(format!("the parameter `{name}` is given twice"))),
            None => Ok(()),
        }
    }

    /// Element of the plugin.
    pub fn element(&self) -> &'a Element {
        self.element
    }

    /// Name of the plugin.
    pub fn plugin(&self) -> &'a str {
        self.plugin
    }

    /// Path of the file `name` that a parameter names; `None` where there is none.
    pub fn find_file(&self, parameter: &Element, name: &str) -> Option<PathBuf> {
        self.scope.folders.find(name, &parameter.location.file)
    }

    /// File `name` that a parameter names, which may lie in memory; `None` where there is none.
    pub fn find_any_file(&self, parameter: &Element, name: &str) -> Option<FoundFile> {
        self.scope.folders.find_any(name, &parameter.location.file)
    }

    /// Number of meshes in memory.
    pub fn mesh_count(&self) -> usize {
        self.scope.mesh_count
    }

    /// Location of a parameter, or else of the plugin.
    pub fn location(&self, name: &str) -> &'a Location {
        let element = self.parameters.get(name).copied().unwrap_or(self.element);
        &element.location
    }

    /// Removes and returns the element of a parameter, for messages or for special reading. The parameter then counts
    /// as read.
    pub fn take(&mut self, name: &str) -> Option<&'a Element> {
        self.parameters.remove(name)
    }

    fn take_tagged(&mut self, name: &str, tags: &[&str]) -> Result<Option<&'a Element>> {
        let Some(element) = self.take(name) else { return Ok(None) };
        if tags.contains(&element.tag.as_str()) {
            return Ok(Some(element));
        }
        Err(element.error(format!("the parameter `{name}` should be a <{}>, not a <{}>", tags[0], element.tag)))
    }

    pub fn float(&mut self, name: &str) -> Result<Option<f32>> {
        let Some(element) = self.take_tagged(name, &NUMBER_TAGS)? else { return Ok(None) };
        Ok(Some(numbers::one(element, element.required("value")?)? as f32))
    }

    pub fn is_number(&self, name: &str) -> bool {
        self.parameters.get(name).is_some_and(|element| NUMBER_TAGS.contains(&element.tag.as_str()))
    }

    pub fn is_string(&self, name: &str) -> bool {
        self.parameters.get(name).is_some_and(|element| element.tag == "string")
    }

    /// Reads a float that must be greater than zero.
    pub fn positive_float(&mut self, name: &str, default: f32) -> Result<f32> {
        let element = self.parameters.get(name).copied();
        match (self.float(name)?, element) {
            (Some(value), Some(element)) if value <= 0.0 => {
                Err(element.error(format!("`{name}` must be greater than 0, not {value}")))
            }
            (value, _) => Ok(value.unwrap_or(default)),
        }
    }

    /// Reads an integer in `range`.
    pub fn integer(&mut self, name: &str, range: std::ops::RangeInclusive<i64>) -> Result<Option<i64>> {
        let Some(element) = self.take_tagged(name, &["integer"])? else { return Ok(None) };
        let text = element.required("value")?;
        let value: i64 =
            text.trim().parse().map_err(|_| element.error(format!("`{name}`: `{text}` is not an integer")))?;
        if range.contains(&value) {
            return Ok(Some(value));
        }
        Err(element.error(format!("`{name}` must lie in {}..{}, not {value}", range.start(), range.end())))
    }

    pub fn boolean(&mut self, name: &str) -> Result<Option<bool>> {
        let Some(element) = self.take_tagged(name, &["boolean"])? else { return Ok(None) };
        match element.required("value")?.trim().to_ascii_lowercase().as_str() {
            "true" => Ok(Some(true)),
            "false" => Ok(Some(false)),
            text => Err(element.error(format!("`{name}` should be `true` or `false`, not `{text}`"))),
        }
    }

    pub fn string(&mut self, name: &str) -> Result<Option<&'a str>> {
        self.take_tagged(name, &["string"])?.map(|element| element.required("value")).transpose()
    }

    /// Reads a color of a material.
    pub fn color(&mut self, name: &str) -> Result<Option<Vec3>> {
        self.color_used_as(name, SpectrumUse::Material)
    }

    /// Reads a color of a material that may be negative.
    pub fn signed_color(&mut self, name: &str) -> Result<Option<Vec3>> {
        let element = self.take_tagged(name, &COLOR_TAGS)?;
        element.map(|element| color::parse_signed(element, SpectrumUse::Material, &self.scope.folders)).transpose()
    }

    /// Reads a color of emitted light.
    pub fn emission(&mut self, name: &str) -> Result<Option<Vec3>> {
        self.color_used_as(name, SpectrumUse::Emission)
    }

    fn color_used_as(&mut self, name: &str, spectrum_use: SpectrumUse) -> Result<Option<Vec3>> {
        let element = self.take_tagged(name, &COLOR_TAGS)?;
        element.map(|element| color::parse(element, spectrum_use, &self.scope.folders)).transpose()
    }

    pub fn point(&mut self, name: &str) -> Result<Option<DVec3>> {
        let Some(element) = self.take_tagged(name, &["point", "vector"])? else { return Ok(None) };
        Ok(Some(numbers::xyz(element, 0.0)?.into()))
    }

    /// Reads the transform `to_world`; the identity where there is none.
    pub fn take_to_world(&mut self) -> Result<DMat4> {
        self.take_transform("to_world")
    }

    /// Reads a transform; the identity where there is none.
    pub fn take_transform(&mut self, name: &str) -> Result<DMat4> {
        let element = self.take_tagged(name, &["transform"])?;
        Ok(element.map(transform::parse).transpose()?.unwrap_or(DMat4::IDENTITY))
    }

    /// Whether a parameter is given, as a value or as a texture.
    pub fn has(&self, name: &str) -> bool {
        self.parameters.contains_key(name) || self.objects.iter().any(|nested| nested.is_texture(name))
    }

    /// Removes and returns the nested objects of a kind.
    pub fn objects(&mut self, tag: &str) -> Vec<&'a Element> {
        self.objects.extract_if(.., |nested| nested.object.tag == tag).map(|nested| nested.object).collect()
    }

    /// Removes and returns the texture that is nested as a parameter.
    pub fn texture(&mut self, name: &str) -> Result<Option<&'a Element>> {
        let textures: Vec<_> = self.objects.extract_if(.., |nested| nested.is_texture(name)).collect();
        let value = self.parameters.get(name).copied();
        match (value, textures.get(1).map(|second| second.at)) {
            (Some(twice), _) | (None, Some(twice)) if !textures.is_empty() => {
                Err(twice.error(format!("the parameter `{name}` is given twice")))
            }
            _ => Ok(textures.first().map(|nested| nested.object)),
        }
    }

    /// Removes and returns the only nested object of a kind; a second one is an error.
    pub fn object(&mut self, tag: &str) -> Result<Option<&'a Element>> {
        let objects = self.objects(tag);
        if let Some(second) = objects.get(1) {
            return Err(second.error(format!("a second <{tag}> in {} `{}`", self.element.tag, self.plugin)));
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

    /// Reports what was not read: a warning for each parameter, an error for each nested object.
    pub fn finish(self, warnings: &mut Vec<String>) -> Result<()> {
        let owner = format!("{} `{}`", self.element.tag, self.plugin);
        if let Some(Nested { object, at }) = self.objects.first() {
            let named = at.attribute("name").map_or_else(String::new, |name| format!(" named `{name}`"));
            let plugin = object.attribute("type").unwrap_or_default();
            return Err(at.error(format!("<{}> plugin `{plugin}`{named} is not supported in {owner}", object.tag)));
        }
        let unknown = self.parameters.into_values().map(|parameter| (parameter, "is unknown"));
        let without_effect = self.without_effect.into_iter().map(|parameter| (parameter, "changes only the noise"));
        let mut ignored: Vec<_> = unknown.chain(without_effect).collect();
        ignored.sort_by_key(|(parameter, _)| parameter.location.line);
        for (parameter, why) in ignored {
            let name = parameter.attribute("name").unwrap_or_default();
            warnings.push(format!("{}: the parameter `{name}` of {owner} {why}; ignored", parameter.location));
        }
        Ok(())
    }
}

impl Nested<'_> {
    fn is_texture(&self, name: &str) -> bool {
        self.object.tag == "texture" && self.at.key().as_deref() == Some(name)
    }
}
