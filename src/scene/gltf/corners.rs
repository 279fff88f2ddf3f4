//! Corners of triangles.

use gltf::Primitive;
use gltf::mesh::Mode;

use super::asset::Asset;
use crate::Result;

/// Triangles of a primitive, by the indices of their vertices, which may be too large.
pub(super) fn triangles(asset: &Asset, primitive: &Primitive, vertices: usize) -> Result<Vec<[u32; 3]>> {
    let indices: Vec<u32> = match primitive.indices() {
        Some(accessor) => asset.elements::<1>(&accessor)?.into_iter().map(|[index]| index as u32).collect(),
        None => (0..vertices as u32).collect(),
    };
    Ok(match primitive.mode() {
        Mode::TriangleStrip => {
            let corners = indices.windows(3).enumerate();
            corners.map(|(at, c)| if at % 2 == 0 { [c[0], c[1], c[2]] } else { [c[1], c[0], c[2]] }).collect()
        }
        Mode::TriangleFan => {
            indices.get(1..).unwrap_or_default().windows(2).map(|c| [indices[0], c[0], c[1]]).collect()
        }
        _ => indices.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(),
    })
}
