//! A plugin's parameters, by name and type. What nobody asks for is reported at the end.

use std::collections::HashMap;
use std::rc::Rc;

use glam::{DMat4, DVec3, Vec3};

use super::element::{Element, Location, PARAMETER_TAGS};
use super::{color, numbers, transform};
use crate::Result;

/// Every object of the scene that has an `id`.
pub(super) type Ids<'a> = Rc<HashMap<&'a str, &'a Element>>;

/// Collects ids wherever they stand: a `ref` may come before what it names.
pub(super) fn collect_ids<'a>(elements: &'a [Element], ids: &mut HashMap<&'a str, &'a Element>) -> Result<()> {
    for element in elements {
        if let Some(id) = element.attribute("id").filter(|_| element.is_object())
            && let Some(first) = ids.insert(id, element)
        {
            return Err(element.error(format!("the id `{id}` is already used at {}", first.location)));
        }
        collect_ids(&element.children, ids)?;
    }
    Ok(())
}

/// The parameters and nested objects of one plugin.
pub(super) struct Properties<'a> {
    element: &'a Element,
    plugin: &'a str,
    parameters: HashMap<String, &'a Element>,
    /// What is nested, with references followed.
    objects: Vec<&'a Element>,
}

impl<'a> Properties<'a> {
    pub fn new(element: &'a Element, ids: &Ids<'a>) -> Result<Self> {
        let mut result = Self { element, plugin: element.plugin()?, parameters: HashMap::new(), objects: Vec::new() };
        for child in &element.children {
            if child.is_object() {
                result.objects.push(child);
            } else if child.tag == "ref" {
                result.objects.push(follow(child, ids)?);
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

    /// The plugin's element.
    pub fn element(&self) -> &'a Element {
        self.element
    }

    /// The plugin's name.
    pub fn plugin(&self) -> &'a str {
        self.plugin
    }

    /// Where a parameter stands, or else the plugin.
    pub fn location(&self, name: &str) -> &'a Location {
        let element = self.parameters.get(name).copied().unwrap_or(self.element);
        &element.location
    }

    /// Whether a parameter is given.
    pub fn has(&self, name: &str) -> bool {
        self.parameters.contains_key(name)
    }

    /// The element of a parameter, to point at it or to read it in a special way; it counts as known from here on.
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
        let Some(element) = self.take_tagged(name, &["float", "integer"])? else { return Ok(None) };
        Ok(Some(numbers::one(element, element.required("value")?)? as f32))
    }

    /// A float that must be greater than zero.
    pub fn positive_float(&mut self, name: &str, default: f32) -> Result<f32> {
        let element = self.parameters.get(name).copied();
        match (self.float(name)?, element) {
            (Some(value), Some(element)) if value <= 0.0 => {
                Err(element.error(format!("`{name}` must be greater than 0, not {value}")))
            }
            (value, _) => Ok(value.unwrap_or(default)),
        }
    }

    /// An integer in `range`.
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

    pub fn color(&mut self, name: &str) -> Result<Option<Vec3>> {
        let tags = ["rgb", "srgb", "spectrum", "blackbody", "float"];
        self.take_tagged(name, &tags)?.map(color::parse).transpose()
    }

    pub fn point(&mut self, name: &str) -> Result<Option<DVec3>> {
        let Some(element) = self.take_tagged(name, &["point", "vector"])? else { return Ok(None) };
        Ok(Some(numbers::xyz(element, 0.0)?.into()))
    }

    /// The transform `to_world`; the identity where there is none.
    pub fn take_to_world(&mut self) -> Result<DMat4> {
        let element = self.take_tagged("to_world", &["transform"])?;
        Ok(element.map(transform::parse).transpose()?.unwrap_or(DMat4::IDENTITY))
    }

    /// Removes and returns the nested objects of a kind.
    pub fn objects(&mut self, tag: &str) -> Vec<&'a Element> {
        self.objects.extract_if(.., |object| object.tag == tag).collect()
    }

    /// The one nested object of a kind; a second one is an error.
    pub fn object(&mut self, tag: &str) -> Result<Option<&'a Element>> {
        let objects = self.objects(tag);
        if let Some(second) = objects.get(1) {
            return Err(second.error(format!("a second <{tag}> in {} `{}`", self.element.tag, self.plugin)));
        }
        Ok(objects.first().copied())
    }

    /// Drops parameters that cannot change the picture.
    pub fn ignore(&mut self, names: &[&str]) {
        for name in names {
            self.parameters.remove(*name);
        }
    }

    /// What is left is unknown: a warning for each parameter, an error for a nested object.
    pub fn finish(self, warnings: &mut Vec<String>) -> Result<()> {
        let owner = format!("{} `{}`", self.element.tag, self.plugin);
        if let Some(object) = self.objects.first() {
            return Err(object.error(format!("<{}> is not supported in {owner}", object.tag)));
        }
        let mut unknown: Vec<_> = self.parameters.into_values().collect();
        unknown.sort_by_key(|parameter| parameter.location.line);
        for parameter in unknown {
            let name = parameter.attribute("name").unwrap_or_default();
            warnings.push(format!("{}: the parameter `{name}` of {owner} is unknown; ignored", parameter.location));
        }
        Ok(())
    }
}

fn follow<'a>(reference: &Element, ids: &Ids<'a>) -> Result<&'a Element> {
    let id = reference.required("id")?;
    ids.get(id).copied().ok_or_else(|| reference.error(format!("nothing in the scene has the id `{id}`")))
}
