//! Scenes as dictionaries: Mitsuba's form of a scene in code. Plugins and parameters are those of its XML, and a scene has the
//! same primitives in either form.

use std::path::Path;
use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::document::{Document, MAX_ELEMENT_DEPTH};
use super::element::{Element, Location, MESH, MESH_INDEX};
use super::faults::Faults;
use super::folders::Folders;
use super::{load, plugins, transform};
use crate::Result;
use crate::scene::Scene;
use crate::scene::mesh::{MAX_TRIANGLES, Mesh};

/// Name of the whole dictionary, with which the path of every entry begins.
const ROOT: &str = "scene";

/// One object of a scene: its `type`, its parameters and its nested objects, in order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Dictionary {
    /// Keys with their values.
    pub entries: Vec<(String, Value)>,
}

/// Value of an entry.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A switch.
    Boolean(bool),
    /// A whole number.
    Integer(i64),
    /// A number.
    Number(f64),
    /// A word, or the name of a file relative to the current folder.
    Text(String),
    /// A point, a vector, a color, a matrix, pairs of a spectrum, or data of a mesh.
    Array(Array),
    /// A transform.
    Transform(Transform),
    /// A nested object. The types `ref`, `rgb` and `spectrum` are those of Mitsuba.
    Object(Dictionary),
}

/// Numbers in rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Array {
    /// Number of values along each axis.
    pub shape: Vec<usize>,
    /// The values; the last axis runs fastest.
    pub values: Vec<f64>,
}

/// A transform as a chain of operations, as a scene file writes it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Transform {
    /// The operations; the first is applied first.
    pub operations: Vec<Operation>,
}

/// One operation of a transform.
#[derive(Debug, Clone, PartialEq)]
pub enum Operation {
    /// A translation by a vector.
    Translate([f64; 3]),
    /// A scale by a factor along each axis.
    Scale([f64; 3]),
    /// A rotation about an axis, by an angle in degrees.
    Rotate {
        /// Axis. Its length should be 1: as in Mitsuba 3, another length scales, too.
        axis: [f64; 3],
        /// Angle in degrees, counterclockwise where the axis points to the viewer.
        degrees: f64,
    },
    /// A camera's place: `+z` looks from the origin to the target, `+x` points to the left of the picture.
    LookAt {
        /// Position of the camera.
        origin: [f64; 3],
        /// Point that the camera looks at.
        target: [f64; 3],
        /// Direction that points up in the picture.
        up: [f64; 3],
    },
    /// A matrix of four rows. The last row is 0 0 0 1.
    Matrix([f64; 16]),
}

impl Transform {
    /// Product of the operations, to the last bit as the reader of scenes computes it. The columns are those of `DMat4`.
    ///
    /// # Errors
    /// Where a number is not finite, an axis is zero, or a camera looks along its `up`.
    pub fn matrix(&self) -> Result<[f64; 16]> {
        let element = self.element("transform", &at("transform"));
        Ok(transform::parse(&element)?.to_cols_array())
    }

    fn element(&self, name: &str, location: &Location) -> Element {
        let children = self.operations.iter().map(|operation| operation.element(location)).collect();
        Element { children, ..leaf("transform", [("name", name.to_owned())], location) }
    }
}

impl Operation {
    fn element(&self, location: &Location) -> Element {
        match self {
            Self::Translate(by) => leaf("translate", [("value", joined(by))], location),
            Self::Scale(by) => leaf("scale", [("value", joined(by))], location),
            Self::Rotate { axis, degrees } => {
                leaf("rotate", [("value", joined(axis)), ("angle", number(*degrees))], location)
            }
            Self::LookAt { origin, target, up } => {
                let attributes = [("origin", joined(origin)), ("target", joined(target)), ("up", joined(up))];
                leaf("lookat", attributes, location)
            }
            Self::Matrix(rows) => leaf("matrix", [("value", joined(rows))], location),
        }
    }
}

impl Scene {
    /// Reads a scene from a dictionary of the type `scene`. Files that it names are relative to the current folder. A shape of the
    /// type `mesh` has the arrays `vertices` and `faces`, and may have `normals`, `uvs` and `colors`, all in rows.
    ///
    /// # Errors
    /// Where an entry asks for something unsupported, or a file cannot be read. Messages name entries such as `scene.box.bsdf`.
    pub fn from_dictionary(dictionary: &Dictionary) -> Result<Self> {
        Ok(Self { name: ROOT.into(), ..load::build(document(dictionary)?, Path::new(ROOT), &|_| {})? })
    }
}

/// Document of a dictionary of the type `scene`.
pub(super) fn document(dictionary: &Dictionary) -> Result<Document> {
    let mut reader = Reader { meshes: Vec::new(), warnings: Vec::new() };
    let elements = reader.scene(dictionary)?;
    let Reader { meshes, warnings } = reader;
    Ok(Document { elements, folders: Folders::new(Path::new(ROOT)), meshes, warnings, faults: Faults::default() })
}

/// Reader of dictionaries, with what it has gathered.
struct Reader {
    meshes: Vec<Mesh>,
    warnings: Vec<String>,
}

impl Reader {
    /// Elements that stand directly in the scene.
    fn scene(&mut self, dictionary: &Dictionary) -> Result<Vec<Element>> {
        let location = at(ROOT);
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
        if key.contains(['.', '/', '\\']) {
            return Err(parent.error(format!("the key `{key}` has a dot or a slash; give it another name")));
        }
        let location = at(&format!("{}.{key}", parent.file.display()));
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
        if plugin == MESH {
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

impl Dictionary {
    fn get(&self, key: &str) -> Option<&Value> {
        self.entries.iter().find(|(found, _)| found == key).map(|(_, value)| value)
    }

    fn text(&self, key: &str, location: &Location) -> Result<Option<&str>> {
        match self.get(key) {
            None => Ok(None),
            Some(Value::Text(text)) => Ok(Some(text)),
            Some(_) => Err(location.error(format!("its `{key}` must be a string"))),
        }
    }

    fn plugin(&self, location: &Location) -> Result<&str> {
        self.text("type", location)?.ok_or_else(|| location.error("it needs the entry `type`, the name of a plugin"))
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

/// Arrays of a mesh by their key.
type Arrays<'a> = Vec<(&'a str, &'a Value)>;

/// Keys of the arrays of a mesh.
const ARRAYS: [&str; 5] = ["vertices", "faces", "normals", "uvs", "colors"];

fn split_mesh(dictionary: &Dictionary) -> (Arrays<'_>, Dictionary) {
    let (arrays, others): (Vec<_>, Vec<_>) =
        dictionary.entries.iter().partition(|(key, _)| ARRAYS.contains(&key.as_str()));
    let arrays = arrays.into_iter().map(|(key, value)| (key.as_str(), value)).collect();
    (arrays, Dictionary { entries: others.into_iter().cloned().collect() })
}

fn mesh(arrays: &Arrays, location: &Location) -> Result<Mesh> {
    let rows = |key: &str| arrays.iter().find(|(found, _)| *found == key).map(|(_, value)| *value);
    let needs = |key: &str| rows(key).ok_or_else(|| location.error(format!("a `mesh` needs its array `{key}`")));
    let positions: Vec<Vec3> = of_rows::<3>("vertices", needs("vertices")?, location)?.map(Vec3::from).collect();
    let triangles = faces(needs("faces")?, positions.len(), location)?;
    let count = positions.len();
    let per_vertex = |key: &'static str| -> Result<Vec<Vec3>> {
        let Some(value) = rows(key) else { return Ok(Vec::new()) };
        let values: Vec<_> = of_rows::<3>(key, value, location)?.map(Vec3::from).collect();
        check_count(key, values.len(), count, location)?;
        Ok(values)
    };
    let (normals, colors) = (per_vertex("normals")?, per_vertex("colors")?);
    let uvs: Vec<Vec2> = match rows("uvs") {
        Some(value) => of_rows::<2>("uvs", value, location)?.map(Vec2::from).collect(),
        None => Vec::new(),
    };
    if !uvs.is_empty() {
        check_count("uvs", uvs.len(), count, location)?;
    }
    Ok(Mesh { positions, normals, uvs, colors, has_byte_colors: false, triangles })
}

fn check_count(key: &str, count: usize, vertices: usize, location: &Location) -> Result<()> {
    if count == vertices {
        return Ok(());
    }
    Err(location
        .error(format!("its `{key}` has {count} rows, but there are {vertices} vertices; give one row for each")))
}

/// Rows of an array of `N` columns, as finite single-precision numbers.
fn of_rows<'a, const N: usize>(
    key: &str,
    value: &'a Value,
    location: &Location,
) -> Result<impl Iterator<Item = [f32; N]> + 'a> {
    let values = table::<N>(key, value, location)?;
    if let Some(wrong) = values.iter().position(|&value| !(value as f32).is_finite()) {
        return Err(location.error(format!("row {} of its `{key}` has a number that is not finite", wrong / N)));
    }
    Ok(values.chunks_exact(N).map(|row| std::array::from_fn(|column| row[column] as f32)))
}

fn faces(value: &Value, vertices: usize, location: &Location) -> Result<Vec<[u32; 3]>> {
    let values = table::<3>("faces", value, location)?;
    if values.is_empty() || values.len() / 3 > MAX_TRIANGLES {
        let count = values.len() / 3;
        return Err(location.error(format!("its `faces` has {count} rows, but must have 1 to {MAX_TRIANGLES}")));
    }
    let is_index = |value: &f64| value.fract() == 0.0 && (0.0..vertices as f64).contains(value);
    if let Some(wrong) = values.iter().position(|value| !is_index(value)) {
        let message =
            format!("row {} of its `faces` has {}, but there are {vertices} vertices", wrong / 3, values[wrong]);
        return Err(location.error(message));
    }
    Ok(values.chunks_exact(3).map(|row| [row[0] as u32, row[1] as u32, row[2] as u32]).collect())
}

/// Values of an array with `N` columns.
fn table<'a, const N: usize>(key: &str, value: &'a Value, location: &Location) -> Result<&'a [f64]> {
    match value {
        Value::Array(Array { shape, values }) if shape.len() == 2 && shape[1] == N => Ok(values),
        Value::Array(Array { shape, .. }) => {
            Err(location.error(format!("its `{key}` has the shape {shape:?}, but must have rows of {N} numbers")))
        }
        _ => Err(location.error(format!("its `{key}` must be an array with rows of {N} numbers"))),
    }
}

fn at(path: &str) -> Location {
    Location { file: Arc::from(Path::new(path)), line: None }
}

fn leaf<const N: usize>(tag: &str, attributes: [(&str, String); N], location: &Location) -> Element {
    Element {
        tag: tag.to_owned(),
        attributes: attributes.map(|(name, value)| (name.to_owned(), value)).into(),
        children: Vec::new(),
        location: location.clone(),
        is_old: false,
    }
}

/// Text of a number that reads back as the same number.
fn number(value: f64) -> String {
    format!("{value:?}")
}

fn joined(values: &[f64]) -> String {
    values.iter().map(|value| number(*value)).collect::<Vec<_>>().join(" ")
}
