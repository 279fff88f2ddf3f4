//! Front end of dictionaries: entries to a description with typed values.

use std::path::Path;
use std::sync::Arc;

use super::dictionary::{Array, Dictionary, Value};
use super::document::MAX_ELEMENT_DEPTH;
use super::mesh_arrays::{mesh, split_mesh};
use super::values::{rows, spectrum_of_text};
use crate::Result;
use crate::scene::description::Description;
use crate::scene::description::kinds::{Kind, Type};
use crate::scene::description::object::{Entry, MESH, Object, Spectrum, Value as Typed};
use crate::scene::description::origin::{Format, Origin};
use crate::scene::description::transform::{Operation, Transform, odd_length};
use crate::scene::numbers;
use crate::scene::plugins::names::kind_of;

/// Name of a scene that is a dictionary, with which the path of every entry begins.
pub(in crate::scene) const ROOT: &str = "scene";

/// Reads a dictionary of the type `scene`.
pub(in crate::scene) fn read(dictionary: &Dictionary) -> Result<Description> {
    let root = Path::new(ROOT);
    let origin = Origin::whole(root, Format::Dictionary);
    match dictionary.plugin(&origin)? {
        "scene" => {}
        other => return Err(origin.error(format!("its `type` must be `scene`, not `{other}`"))),
    }
    let mut warnings = Vec::new();
    let entries = entries(dictionary.parameters(), &origin, 1, &mut warnings)?;
    Ok(Description { warnings, ..Description::new(root, Format::Dictionary, entries) })
}

fn entries<'d>(
    parameters: impl Iterator<Item = &'d (String, Value)>,
    parent: &Origin,
    depth: usize,
    warnings: &mut Vec<String>,
) -> Result<Vec<Entry>> {
    parameters.map(|(key, value)| entry(key, value, parent, depth, warnings)).collect()
}

fn entry(key: &str, value: &Value, parent: &Origin, depth: usize, warnings: &mut Vec<String>) -> Result<Entry> {
    if key.contains(['.', '/', '\\']) {
        return Err(parent.error(format!("the key `{key}` has a dot or a slash; give it another name")));
    }
    let name = key.to_owned().into();
    let origin = parent.entry(&name);
    let value = match value {
        Value::Boolean(value) => Typed::Boolean(*value),
        Value::Integer(value) => Typed::Integer(*value),
        Value::Number(value) => Typed::Float(*value),
        Value::Text(value) => Typed::Text(value.clone()),
        Value::Array(array) => match (&array.shape[..], &array.values[..]) {
            ([], [value]) => Typed::Float(*value),
            ([_], &[x, y, z]) => Typed::Vector([x, y, z]),
            ([_], values) => Typed::Array(values.to_vec()),
            ([4, 4] | [3, 3], values) => {
                let rows = rows(values).map_err(|message| origin.error(message))?;
                Typed::Transform(Transform { operations: vec![Operation::Matrix(rows)] })
            }
            (shape, _) => {
                let message = format!(
                    "an array of the shape {shape:?} is no parameter; a point or a color has 3 numbers, a transform 4 x 4"
                );
                return Err(origin.error(message));
            }
        },
        Value::Transform(transform) => {
            warnings.extend(transform.operations.iter().filter_map(|operation| rotation_warning(operation, &origin)));
            Typed::Transform(transform.clone())
        }
        Value::Object(dictionary) => object(key, dictionary, parent.object(".", key), depth, warnings)?,
    };
    Ok(Entry { name, value, origin: None })
}

fn rotation_warning(operation: &Operation, origin: &Origin) -> Option<String> {
    let Operation::Rotate { axis, .. } = operation else { return None };
    let (word, length) = (origin.word("rotate"), odd_length(*axis)?);
    let what = "scales the shape, as in Mitsuba 3; give the axis the length 1 to rotate only";
    Some(format!("{origin}: the axis of this {word} has the length {length:.4}. It {what}"))
}

fn object(
    key: &str,
    dictionary: &Dictionary,
    origin: Origin,
    depth: usize,
    warnings: &mut Vec<String>,
) -> Result<Typed> {
    if depth > MAX_ELEMENT_DEPTH {
        return Err(origin.error(format!("entries are nested more than {MAX_ELEMENT_DEPTH} deep")));
    }
    let plugin = dictionary.plugin(&origin)?;
    let id = dictionary.text("id", &origin)?;
    let kind = match plugin {
        "ref" => {
            let id = id.ok_or_else(|| origin.error("a `ref` needs the `id` of the object that it refers to"))?;
            return Ok(Typed::Reference(id.to_owned()));
        }
        "rgb" => return rgb(dictionary, &origin),
        "spectrum" => return spectrum(dictionary, &origin),
        "blackbody" => {
            let message = "`blackbody` is not supported; give the color as `rgb`";
            return Ok(Typed::fault(Some(Type::Blackbody), message));
        }
        _ => kind_of(plugin).ok_or_else(|| {
            origin.error(format!("there is no plugin `{plugin}` that Lodestar knows; check its `type`"))
        })?,
    };
    // Mitsuba lets objects refer to the keys that stand directly in the scene.
    let id = id.or((depth == 1 && kind != Kind::Spectrum).then_some(key)).map(str::to_owned);
    let entries = match plugin {
        MESH => {
            let (arrays, others) = split_mesh(dictionary);
            let mesh = Typed::Mesh(Arc::new(mesh(&arrays, &origin)?));
            let mut entries = entries(others.parameters(), &origin, depth + 1, warnings)?;
            entries.push(Entry { name: MESH.into(), value: mesh, origin: None });
            entries
        }
        _ => entries(dictionary.parameters(), &origin, depth + 1, warnings)?,
    };
    Ok(Typed::Object(Box::new(Object { kind, plugin: plugin.to_owned().into(), id, entries, origin })))
}

/// Text or numbers of a color's entry.
enum Given<'d> {
    Text(&'d str),
    Numbers(&'d [f64]),
    Pairs(&'d [f64]),
}

impl<'d> Given<'d> {
    fn read(key: &str, value: &'d Value, number: &'d mut f64, origin: &Origin) -> Result<Self> {
        Ok(match value {
            Value::Text(text) => Self::Text(text),
            Value::Integer(value) => {
                *number = *value as f64;
                Self::Numbers(std::slice::from_ref(number))
            }
            Value::Number(value) => Self::Numbers(std::slice::from_ref(value)),
            Value::Array(Array { shape, values }) if shape.len() < 2 => Self::Numbers(values),
            Value::Array(Array { shape, values }) if shape[1..] == [2] => Self::Pairs(values),
            _ => return Err(origin.error(format!("its `{key}` must be numbers or a string"))),
        })
    }
}

/// Numbers as messages show them.
fn joined(values: &[f64]) -> String {
    values.iter().map(|value| format!("{value:?}")).collect::<Vec<_>>().join(" ")
}

/// Color in linear sRGB.
fn rgb(dictionary: &Dictionary, origin: &Origin) -> Result<Typed> {
    let fault = |message: String| Typed::fault(Some(Type::Rgb), message);
    let Some(value) = dictionary.get("value") else { return Ok(fault("`rgb` lacks its entry `value`".to_owned())) };
    Ok(match Given::read("value", value, &mut 0.0, origin)? {
        Given::Text(text) if text.trim().starts_with('#') => {
            fault(format!("`{text}` in `rgb`: hex digits are not read; give three numbers"))
        }
        Given::Text(text) => numbers::one_or_three(text).map_or_else(fault, Typed::Rgb),
        Given::Numbers(&[gray]) => Typed::Rgb([gray; 3]),
        Given::Numbers(&[red, green, blue]) => Typed::Rgb([red, green, blue]),
        Given::Numbers(values) | Given::Pairs(values) => {
            fault(format!("`{}` should be one number or three", joined(values)))
        }
    })
}

fn spectrum(dictionary: &Dictionary, origin: &Origin) -> Result<Typed> {
    let read = match (dictionary.get("value"), dictionary.text("filename", origin)?) {
        (Some(value), None) => match Given::read("value", value, &mut 0.0, origin)? {
            Given::Text(text) => spectrum_of_text(text, Format::Dictionary),
            Given::Numbers(&[value]) => Ok(Spectrum::Uniform(value)),
            // Mitsuba 0.6 accepts three numbers as a color.
            Given::Numbers(&[red, green, blue]) => Ok(Spectrum::Rgb([red, green, blue])),
            Given::Numbers(values) => {
                Err(format!("`{}` should be one number, three, or pairs of a wavelength and a value", joined(values)))
            }
            Given::Pairs(values) => Ok(Spectrum::Points(values.as_chunks().0.to_vec())),
        },
        (None, Some(name)) => Ok(Spectrum::File(name.to_owned())),
        _ => Err("a `spectrum` needs either its entry `value` or `filename`".to_owned()),
    };
    Ok(read.map_or_else(|message| Typed::fault(Some(Type::Spectrum), message), Typed::Spectrum))
}
