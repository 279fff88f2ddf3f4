//! Triangle meshes, as every reader of mesh files makes them.

use glam::{Vec2, Vec3};

/// Most triangles of a scene, copies of instances included. Devices can address this many at three texels each.
pub(in crate::scene) const MAX_TRIANGLES: usize = 1 << 25;

/// Message about a face that is a point or a line.
pub(in crate::scene) const TOO_FEW_VERTICES: &str = "a face needs at least three vertices";

/// One mesh. Vertices that differ in any attribute are kept apart, as in Mitsuba, so that smooth normals do not cross
/// texture seams.
#[derive(Debug, Default)]
pub(in crate::scene) struct Mesh {
    pub positions: Vec<Vec3>,
    /// One normal per vertex, of any length, zero where the file gives none; empty where no vertex has one.
    pub normals: Vec<Vec3>,
    /// One texture coordinate per vertex, as in the file; empty where it has none.
    pub uvs: Vec<Vec2>,
    /// One color per vertex, as in the file; empty where it has none. They may be no numbers.
    pub colors: Vec<Vec3>,
    /// Whether the file gives the colors as whole numbers, of which the largest stands for 1.
    pub has_byte_colors: bool,
    /// Largest distance from the surface that the mesh stands for, in radii of its tubes; 0 where the mesh is the surface.
    pub deviation: f32,
    /// Vertex indices of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

/// Cuts a polygon into triangles around its first vertex.
pub(in crate::scene) fn add_polygon<T: Copy>(triangles: &mut Vec<[T; 3]>, polygon: &[T]) -> Result<(), String> {
    if polygon.len() < 3 {
        return Err(TOO_FEW_VERTICES.to_string());
    }
    triangles.extend(polygon[1..].windows(2).map(|pair| [polygon[0], pair[0], pair[1]]));
    Ok(())
}
