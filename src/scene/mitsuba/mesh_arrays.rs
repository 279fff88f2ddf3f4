//! Meshes of arrays, as dictionaries have them.

use glam::{Vec2, Vec3};

use super::dictionary::{Array, Dictionary, Value};
use crate::Result;
use crate::scene::deformation::MOST_INTERVALS;
use crate::scene::description::origin::Origin;
use crate::scene::mesh::{MAX_TRIANGLES, Mesh, MeshAttribute, set_attribute};

/// Arrays of a mesh by their key.
pub(super) type Arrays<'a> = Vec<(&'a str, &'a Value)>;

/// Keys of the arrays of a mesh.
const ARRAYS: [&str; 5] = ["vertices", "faces", "normals", "uvs", "colors"];

/// Arrays of a mesh, and the other entries of its shape.
pub(super) fn split_mesh(dictionary: &Dictionary) -> (Arrays<'_>, Dictionary) {
    let (arrays, others): (Vec<_>, Vec<_>) =
        dictionary.entries.iter().partition(|(key, _)| ARRAYS.contains(&key.as_str()));
    let arrays = arrays.into_iter().map(|(key, value)| (key.as_str(), value)).collect();
    (arrays, Dictionary { entries: others.into_iter().cloned().collect() })
}

/// Mesh of a dictionary's arrays.
pub(super) fn mesh(arrays: &Arrays, location: &Origin) -> Result<Mesh> {
    let rows = |key: &str| arrays.iter().find(|(found, _)| *found == key).map(|(_, value)| *value);
    let needs = |key: &str| rows(key).ok_or_else(|| location.error(format!("a `mesh` needs its array `{key}`")));
    let mut sets = sets_of_vertices("vertices", needs("vertices")?, location)?;
    let positions = sets.remove(0);
    let triangles = faces(needs("faces")?, positions.len(), location)?;
    let count = positions.len();
    let per_vertex = |key: &'static str| -> Result<Vec<Vec3>> {
        let Some(value) = rows(key) else { return Ok(Vec::new()) };
        let values: Vec<_> = of_rows::<3>(key, value, location)?.map(Vec3::from).collect();
        check_count(key, values.len(), count, location)?;
        Ok(values)
    };
    let mut attributes = later_sets("position", sets);
    let mut of_normals = match rows("normals") {
        Some(value) => sets_of_vertices("normals", value, location)?,
        None => vec![Vec::new()],
    };
    let normals = of_normals.remove(0);
    if !normals.is_empty() {
        check_count("normals", normals.len(), count, location)?;
    }
    if !of_normals.is_empty() && of_normals.len() != attributes.len() {
        let (sets, wanted) = (of_normals.len() + 1, attributes.len() + 1);
        return Err(location.error(format!(
            "its `normals` has {sets} sets, but `vertices` has {wanted}; give one set for each, or one for the first alone"
        )));
    }
    attributes.extend(later_sets("normal", of_normals));
    let colors = per_vertex("colors")?;
    let uvs: Vec<Vec2> = match rows("uvs") {
        Some(value) => of_rows::<2>("uvs", value, location)?.map(Vec2::from).collect(),
        None => Vec::new(),
    };
    if !uvs.is_empty() {
        check_count("uvs", uvs.len(), count, location)?;
    }
    Ok(Mesh { positions, normals, uvs, colors, attributes, triangles, ..Mesh::default() })
}

/// Sets of vertices: one of an array with a row for each vertex, several of an array of such arrays, at evenly spaced times.
fn sets_of_vertices(key: &'static str, value: &Value, location: &Origin) -> Result<Vec<Vec<Vec3>>> {
    let Value::Array(Array { shape, values }) = value else {
        return Ok(vec![of_rows::<3>(key, value, location)?.map(Vec3::from).collect()]);
    };
    let [sets, vertices, 3] = shape[..] else {
        return Ok(vec![of_rows::<3>(key, value, location)?.map(Vec3::from).collect()]);
    };
    if !(1..=MOST_INTERVALS + 1).contains(&sets) {
        let most = MOST_INTERVALS + 1;
        return Err(location.error(format!("its `{key}` has {sets} sets, but must have 1 to {most}")));
    }
    if values.iter().any(|&value| !(value as f32).is_finite()) {
        return Err(location.error(format!("its `{key}` has a number that is not finite")));
    }
    let all: Vec<Vec3> =
        values.chunks_exact(3).map(|row| Vec3::from_slice(&[row[0] as f32, row[1] as f32, row[2] as f32])).collect();
    Ok((0..sets).map(|set| all[set * vertices..(set + 1) * vertices].to_vec()).collect())
}

/// Attributes that have the later sets of a mesh.
fn later_sets(kind: &str, sets: Vec<Vec<Vec3>>) -> Vec<MeshAttribute> {
    let attribute = |(at, values)| MeshAttribute { name: set_attribute(kind, at), values };
    (1..).zip(sets).map(attribute).collect()
}

fn check_count(key: &str, count: usize, vertices: usize, location: &Origin) -> Result<()> {
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
    location: &Origin,
) -> Result<impl Iterator<Item = [f32; N]> + 'a> {
    let values = table::<N>(key, value, location)?;
    if let Some(wrong) = values.iter().position(|&value| !(value as f32).is_finite()) {
        return Err(location.error(format!("row {} of its `{key}` has a number that is not finite", wrong / N)));
    }
    Ok(values.chunks_exact(N).map(|row| std::array::from_fn(|column| row[column] as f32)))
}

fn faces(value: &Value, vertices: usize, location: &Origin) -> Result<Vec<[u32; 3]>> {
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
fn table<'a, const N: usize>(key: &str, value: &'a Value, location: &Origin) -> Result<&'a [f64]> {
    match value {
        Value::Array(Array { shape, values }) if shape.len() == 2 && shape[1] == N => Ok(values),
        Value::Array(Array { shape, .. }) => {
            Err(location.error(format!("its `{key}` has the shape {shape:?}, but must have rows of {N} numbers")))
        }
        _ => Err(location.error(format!("its `{key}` must be an array with rows of {N} numbers"))),
    }
}
