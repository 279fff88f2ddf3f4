//! Front end of XML: elements to a description with typed values.

use std::path::Path;

use super::document::{self, Document};
use super::element::Element;
use super::old_files;
use super::values::{lacks, parameter};
use crate::Result;
use crate::scene::description::kinds::{Kind, Type};
use crate::scene::description::object::{Entry, Object, Value};
use crate::scene::description::origin::{Format, Name};
use crate::scene::description::{Alias, Description};
use crate::scene::plugins::names::kind_of;

/// Reads the file at `path` with all its includes. `defines` replace the `<default>`s of their names.
pub(in crate::scene) fn read(path: &Path, defines: &[(String, String)]) -> Result<Description> {
    let Document { elements, folders, mut warnings, faults } = document::read(path, defines)?;
    warnings.extend(old_files::warning(&elements));
    let (aliases, elements): (Vec<_>, Vec<_>) = elements.into_iter().partition(|element| element.tag == "alias");
    let entries = elements.into_iter().map(|element| entry("scene", element)).collect();
    let aliases = aliases.iter().map(alias).collect::<Result<_>>()?;
    Ok(Description { folders, warnings, faults, aliases, ..Description::new(path, Format::Xml, entries) })
}

fn alias(element: &Element) -> Result<Alias> {
    let (id, name) = (element.required("id")?.to_owned(), element.required("as")?.to_owned());
    Ok(Alias { id, name, origin: element.location.clone() })
}

/// Entry of an object whose element has the tag `parent`.
fn entry(parent: &str, element: Element) -> Entry {
    let origin = Some(element.location.clone());
    let name: Name = element.attribute("name").unwrap_or_default().to_owned().into();
    let (kind, of) = (Kind::named(&element.tag), Type::named(&element.tag));
    let value = match (kind, of, &*element.tag) {
        (Some(kind), None, _) => object(kind, element),
        (_, _, "ref") => match element.attribute("id") {
            Some(id) => Value::Reference(id.to_owned()),
            None => Value::fault(None, lacks(&element, "id")),
        },
        (_, Some(_), _) if element.attribute("name").is_none() && parent != "scene" => {
            Value::fault(None, lacks(&element, "name"))
        }
        // A `<spectrum>` may be a plugin.
        (Some(kind), Some(_), _) if element.attribute("type").is_some() => object(kind, element),
        (_, Some(of), _) => parameter(of, &element).unwrap_or_else(|message| Value::fault(Some(of), message)),
        (.., tag) => Value::fault(None, format!("<{tag}> cannot stand directly in <{parent}>")),
    };
    Entry { name, value, origin }
}

fn object(kind: Kind, element: Element) -> Value {
    let Some(plugin) = element.attribute("type") else { return Value::fault(None, lacks(&element, "type")) };
    // Mitsuba 3 writes a spectrum that is a plugin as a texture.
    let is_spectrum = kind == Kind::Texture && kind_of(plugin) == Some(Kind::Spectrum);
    let kind = if is_spectrum { Kind::Spectrum } else { kind };
    let plugin = plugin.to_owned().into();
    let id = element.attribute("id").map(str::to_owned);
    let Element { children, location: origin, .. } = element;
    let entries = children.into_iter().map(|child| entry(kind.name(), child)).collect();
    Value::Object(Box::new(Object { kind, plugin, id, entries, origin }))
}
