//! Places of triangles in an image of vertex colors.

use glam::Vec2;

/// Blocks of a mesh in an image of vertex colors. Each triangle has a block of 2 x 2 texels: its first vertex's color at
/// the upper left, the second's to the right of it, the third's below. The last texel is second plus third minus first,
/// so that interpolation between the four texels' centers is affine, which makes it interpolation over the triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ColorBlocks {
    /// Index of the first triangle's block.
    pub first: u32,
    /// Number of blocks in a row of the image.
    pub columns: u32,
    /// Number of rows of blocks.
    pub rows: u32,
}

impl ColorBlocks {
    /// Texture coordinates of the vertices of triangle number `index` of the mesh.
    pub fn uvs(&self, index: u32) -> [Vec2; 3] {
        let block = self.first + index;
        let (column, row) = (block % self.columns, block / self.columns);
        let center = |x: u32, y: u32| {
            let texel =
                |index: u32, offset: u32, count: u32| (f64::from(2 * index + offset) + 0.5) / f64::from(2 * count);
            Vec2::new(texel(column, x, self.columns) as f32, texel(row, y, self.rows) as f32)
        };
        [center(0, 0), center(1, 0), center(0, 1)]
    }
}
