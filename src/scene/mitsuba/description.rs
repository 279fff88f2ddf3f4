//! Descriptions: what every reader but that of XML makes of its file. A description says in Mitsuba's terms what is in the
//! scene, so that one reader of plugins, materials and shapes stands behind all formats.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::dictionary::{Array, Dictionary, Value, at, joined, leaf, number};
use super::document::{Document, MAX_ELEMENT_DEPTH};
use super::element::{Element, Location, MESH, MESH_INDEX};
use super::faults::Faults;
use super::fit::View;
use super::folders::Folders;
use super::load::{self, Watch};
use super::mesh_arrays::{mesh, split_mesh};
use super::{plugins, transform};
use crate::Result;
use crate::scene::Scene;
use crate::scene::load_options::LoadOptions;
use crate::scene::mesh::Mesh;

/// Name of a scene that is a dictionary, with which the path of every entry begins.
pub(in crate::scene) const ROOT: &str = "scene";

/// Scene of a file in Mitsuba's terms, with the data that no file of Mitsuba's holds.
///
/// A key of an object that stands directly in the scene is its `id`, and names it in messages: a fault of the object
/// ``material `Wood` `` reads ``model.glb: material `Wood`.roughness: ...``.
#[derive(Debug, Default)]
pub(in crate::scene) struct Description {
    /// Path of the file. Files that the scene names are relative to its folder.
    pub path: PathBuf,
    /// Objects of the scene: a dictionary of the type `scene`.
    pub scene: Dictionary,
    /// Meshes. A shape of the type `mesh` names one by the parameter [`MESH_INDEX`].
    pub meshes: Vec<Mesh>,
    /// Files in memory by name, for the `filename` of a `bitmap` or `envmap`: images of any format.
    pub files: HashMap<String, Arc<[u8]>>,
    /// Sentences about things that were read but are not rendered exactly.
    pub warnings: Vec<String>,
}

impl Description {
    /// Scene that is described. The warnings of the description come first.
    pub fn into_scene(self, options: &LoadOptions, progress: &Watch) -> Result<Scene> {
        let path = self.path.clone();
        load::build(self.into_document(": ")?, &path, options, progress)
    }

    /// Elements of all objects. `separator` stands between the path and the key of an object in messages.
    pub(super) fn into_document(self, separator: &'static str) -> Result<Document> {
        let Self { path, scene, meshes, files, warnings } = self;
        let folders = Folders::new(&path).with_files(files);
        let mut reader = Reader { root: at(&path.to_string_lossy()), separator, meshes, warnings };
        let elements = reader.scene(&scene)?;
        let Reader { meshes, warnings, .. } = reader;
        let view = if separator == "." { View::Mitsuba } else { View::Front };
        Ok(Document { elements, folders, meshes, warnings, faults: Faults::default(), view })
    }
}

impl Scene {
    /// Reads a scene from a dictionary of the type `scene`. Files that it names are relative to the current folder. A shape of the
    /// type `mesh` has the arrays `vertices` and `faces`, and may have `normals`, `uvs` and `colors`, all in rows.
    ///
    /// # Errors
    /// Where an entry asks for something unsupported, or a file cannot be read. Messages name entries such as `scene.box.bsdf`.
    pub fn from_dictionary(dictionary: &Dictionary) -> Result<Self> {
        let root = Path::new(ROOT);
        let scene = dictionary.clone();
        let document = Description { path: root.into(), scene, ..Description::default() }.into_document(".")?;
        Ok(Self { name: ROOT.into(), ..load::build(document, root, &LoadOptions::default(), &|_| {})? })
    }
}

/// Reader of dictionaries, with what it has gathered.
struct Reader {
    root: Location,
    separator: &'static str,
    meshes: Vec<Mesh>,
    warnings: Vec<String>,
}

impl Reader {
    /// Elements that stand directly in the scene.
    fn scene(&mut self, dictionary: &Dictionary) -> Result<Vec<Element>> {
        let location = self.root.clone();
        match dictionary.plugin(&location)? {
            "scene" => {}
            other => return Err(location.error(format!("its `type` must be `scene`, not `{other}`"))),
        }
        self.entries(dictionary, &location, 1)
    }

    /// Elements of all entries but the type and the id.
    fn entries(&mut self, dictionary: &Dictionary, location: &Location, depth: usize) -> Result<Vec<Element>> {
        let nested = dictionary.entries.iter().filter(|(key, _)| key != "type" && key != "id");
        nested.map(|(key, value)| self.entry(key, value, location, depth)).collect()
    }

    fn entry(&mut self, key: &str, value: &Value, parent: &Location, depth: usize) -> Result<Element> {
        if self.separator == "." && key.contains(['.', '/', '\\']) {
            return Err(parent.error(format!("the key `{key}` has a dot or a slash; give it another name")));
        }
        let location = self.location(key, parent, depth);
        let parameter = |tag: &str, value: String| leaf(tag, [("name", key.to_owned()), ("value", value)], &location);
        Ok(match value {
            Value::Boolean(value) => parameter("boolean", value.to_string()),
            Value::Integer(value) => parameter("integer", value.to_string()),
            Value::Number(value) => parameter("float", number(*value)),
            Value::Text(value) => parameter("string", value.clone()),
            Value::Array(array) => match (&array.shape[..], &array.values[..]) {
                ([], [value]) => parameter("float", number(*value)),
                ([_], values) => parameter("vector", joined(values)),
                ([4, 4] | [3, 3], values) => {
                    let matrix = leaf("matrix", [("value", joined(values))], &location);
                    Element { children: vec![matrix], ..leaf("transform", [("name", key.to_owned())], &location) }
                }
                (shape, _) => {
                    let message = format!(
                        "an array of the shape {shape:?} is no parameter; a point or a color has 3 numbers, a transform 4 x 4"
                    );
                    return Err(location.error(message));
                }
            },
            Value::Transform(value) => {
                let element = value.element(key, &location);
                for operation in &element.children {
                    self.warnings.extend(transform::warning(operation)?);
                }
                element
            }
            Value::Object(dictionary) => self.object(key, dictionary, &location, depth)?,
        })
    }

    /// Location of an entry.
    fn location(&self, key: &str, parent: &Location, depth: usize) -> Location {
        let separator = if depth == 1 { self.separator } else { "." };
        at(&format!("{}{separator}{key}", parent.file.display()))
    }

    fn object(&mut self, key: &str, dictionary: &Dictionary, location: &Location, depth: usize) -> Result<Element> {
        if depth > MAX_ELEMENT_DEPTH {
            return Err(location.error(format!("entries are nested more than {MAX_ELEMENT_DEPTH} deep")));
        }
        let plugin = dictionary.plugin(location)?;
        let named = ("name", key.to_owned());
        let id = dictionary.text("id", location)?;
        let tag = match plugin {
            "ref" => {
                let id = id.ok_or_else(|| location.error("a `ref` needs the `id` of the object that it refers to"))?;
                return Ok(leaf("ref", [named, ("id", id.to_owned())], location));
            }
            "rgb" | "spectrum" | "blackbody" => return color(plugin, named, dictionary, location),
            _ => plugins::tag_of(plugin).ok_or_else(|| {
                location.error(format!("there is no plugin `{plugin}` that Lodestar knows; check its `type`"))
            })?,
        };
        let mut element = leaf(tag, [named, ("type", plugin.to_owned())], location);
        // Mitsuba lets objects refer to the keys that stand directly in the scene.
        let id = id.or((depth == 1 && element.is_object()).then_some(key));
        element.attributes.extend(id.map(|id| ("id".to_owned(), id.to_owned())));
        if plugin == MESH && dictionary.get(MESH_INDEX).is_none() {
            let (of_mesh, others) = split_mesh(dictionary);
            self.meshes.push(mesh(&of_mesh, location)?);
            let index = Value::Integer(self.meshes.len() as i64 - 1);
            element.children = self.entries(&others, location, depth + 1)?;
            element.children.push(self.entry(MESH_INDEX, &index, location, depth + 1)?);
        } else {
            element.children = self.entries(dictionary, location, depth + 1)?;
        }
        Ok(element)
    }
}

/// Element of a color, whose entries are attributes in XML.
fn color(tag: &str, named: (&str, String), dictionary: &Dictionary, location: &Location) -> Result<Element> {
    let mut element = leaf(tag, [named], location);
    for (key, value) in dictionary.entries.iter().filter(|(key, _)| key != "type" && key != "id") {
        let text = match value {
            Value::Integer(value) => value.to_string(),
            Value::Number(value) => number(*value),
            Value::Text(text) => text.clone(),
            Value::Array(Array { shape, values }) if shape.len() < 2 => joined(values),
            Value::Array(Array { shape, values }) if shape[1..] == [2] => {
                let pairs = values.chunks_exact(2).map(|pair| format!("{}:{}", number(pair[0]), number(pair[1])));
                pairs.collect::<Vec<_>>().join(", ")
            }
            _ => return Err(location.error(format!("its `{key}` must be numbers or a string"))),
        };
        element.attributes.push((key.clone(), text));
    }
    Ok(element)
}
