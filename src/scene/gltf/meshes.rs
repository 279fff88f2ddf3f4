//! Primitives of meshes to meshes, with morph targets at their default weights and skins at their default pose.

use glam::{DMat4, DVec3, Vec2, Vec3};
use gltf::mesh::Mode;
use gltf::{Accessor, Node, Primitive, Semantic};

use super::accessors::rows;
use super::document::Model;
use crate::Result;
use crate::scene::mesh::{MAX_TRIANGLES, Mesh};

/// Mesh of a primitive; `None` where it has no triangles. `uv_set` is the set of texture coordinates that its material
/// uses. `joints` are the matrices of the node's skin.
pub(super) fn mesh(
    model: &Model,
    node: &Node,
    primitive: &Primitive,
    uv_set: u32,
    joints: Option<&[DMat4]>,
    what: &str,
) -> Result<Option<Mesh>> {
    let Some(positions) = primitive.get(&Semantic::Positions) else { return Ok(None) };
    let mut positions = vectors(model, &positions, what)?;
    let count = positions.len();
    let mut normals = match primitive.get(&Semantic::Normals) {
        Some(accessor) => vectors(model, &accessor, what)?,
        None => Vec::new(),
    };
    let weights = node.weights().or_else(|| node.mesh()?.weights()).unwrap_or_default();
    for (target, &weight) in primitive.morph_targets().zip(weights) {
        for (values, change) in [(&mut positions, target.positions()), (&mut normals, target.normals())] {
            let Some(change) = change.filter(|_| weight != 0.0) else { continue };
            let change = vectors(model, &change, what)?;
            values.iter_mut().zip(change).for_each(|(value, change)| *value += f64::from(weight) * change);
        }
    }
    if let Some(joints) = joints {
        skin(model, primitive, joints, &mut positions, &mut normals, what)?;
    }
    let uvs: Vec<Vec2> = match primitive.get(&Semantic::TexCoords(uv_set)) {
        Some(accessor) => {
            let rows = rows(model, &accessor, what)?;
            rows.values.chunks_exact(rows.columns.max(2)).map(|row| Vec2::new(row[0] as f32, row[1] as f32)).collect()
        }
        None => Vec::new(),
    };
    let colors = match primitive.get(&Semantic::Colors(0)) {
        Some(accessor) => to_single(&vectors(model, &accessor, what)?),
        None => Vec::new(),
    };
    let colors = if colors.iter().all(|&color| color == Vec3::ONE) { Vec::new() } else { colors };
    for (name, length) in [("normals", normals.len()), ("texture coordinates", uvs.len()), ("colors", colors.len())] {
        if length != 0 && length != count {
            return Err(model.error(what, format!("it has {count} vertices, but {length} {name}")));
        }
    }
    let indices: Vec<u32> = match primitive.indices() {
        Some(accessor) => rows(model, &accessor, what)?.values.iter().map(|&index| index as u32).collect(),
        None => (0..count as u32).collect(),
    };
    if let Some(index) = indices.iter().find(|&&index| index as usize >= count) {
        return Err(model.error(what, format!("it names the vertex {index}, but has {count}")));
    }
    let triangles = triangles(primitive.mode(), &indices);
    if triangles.len() > MAX_TRIANGLES {
        return Err(model.error(what, format!("it has more than {MAX_TRIANGLES} triangles")));
    }
    let positions = to_single(&positions);
    let normals = to_single(&normals);
    let is_finite = positions.iter().chain(&normals).chain(&colors).all(|vector| vector.is_finite());
    if !is_finite || uvs.iter().any(|uv| !uv.is_finite()) {
        return Err(model.error(what, "a number of a vertex is not finite"));
    }
    let mesh = Mesh { positions, normals, uvs, colors, has_byte_colors: false, triangles };
    Ok(Some(mesh).filter(|mesh| !mesh.triangles.is_empty()))
}

/// Whether a mode makes triangles.
pub(super) fn has_triangles(mode: Mode) -> bool {
    matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)
}

fn triangles(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    let is_flat = |&[a, b, c]: &[u32; 3]| a == b || b == c || c == a;
    let all: Vec<[u32; 3]> = match mode {
        Mode::Triangles => indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
        Mode::TriangleStrip => {
            let turned = |(i, t): (usize, &[u32])| if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] };
            indices.windows(3).enumerate().map(turned).collect()
        }
        Mode::TriangleFan => indices.get(1..).unwrap_or_default().windows(2).map(|t| [indices[0], t[0], t[1]]).collect(),
        _ => Vec::new(),
    };
    all.into_iter().filter(|triangle| !is_flat(triangle)).collect()
}

/// Moves vertices with the joints of a skin.
fn skin(
    model: &Model,
    primitive: &Primitive,
    joints: &[DMat4],
    positions: &mut [DVec3],
    normals: &mut [DVec3],
    what: &str,
) -> Result<()> {
    let (Some(of), Some(weights)) = (primitive.get(&Semantic::Joints(0)), primitive.get(&Semantic::Weights(0))) else {
        return Ok(());
    };
    let (of, weights) = (rows(model, &of, what)?.values, rows(model, &weights, what)?.values);
    for (vertex, position) in positions.iter_mut().enumerate() {
        let mut matrix = DMat4::ZERO;
        for place in 4 * vertex..4 * vertex + 4 {
            let (Some(&joint), Some(&weight)) = (of.get(place), weights.get(place)) else { continue };
            let joint = joints.get(joint as usize).filter(|_| weight != 0.0);
            matrix += joint.map_or(DMat4::ZERO, |joint| *joint * weight);
        }
        let total = matrix.w_axis.w;
        if total > 0.0 {
            matrix *= 1.0 / total;
            *position = matrix.transform_point3(*position);
            if let Some(normal) = normals.get_mut(vertex) {
                *normal = matrix.inverse().transpose().transform_vector3(*normal);
            }
        }
    }
    Ok(())
}

/// Rows of three or more numbers.
fn vectors(model: &Model, accessor: &Accessor, what: &str) -> Result<Vec<DVec3>> {
    let rows = rows(model, accessor, what)?;
    if rows.columns < 3 {
        return Err(model.error(what, format!("accessor {} must have three columns", accessor.index())));
    }
    Ok(rows.values.chunks_exact(rows.columns).map(|row| DVec3::new(row[0], row[1], row[2])).collect())
}

fn to_single(vectors: &[DVec3]) -> Vec<Vec3> {
    vectors.iter().map(|vector| vector.as_vec3()).collect()
}
