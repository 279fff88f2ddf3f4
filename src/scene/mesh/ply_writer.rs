//! Writer of binary PLY files.

use std::io::{self, Write};

use super::Mesh;

/// Writes `mesh` with everything that readers of formats and dictionaries make. Single-precision numbers keep all their bits.
pub(in crate::scene) fn write(mesh: &Mesh, to: &mut impl Write) -> io::Result<()> {
    let Mesh {
        positions,
        normals,
        uvs,
        colors,
        attributes: _,
        has_byte_colors: _,
        left_out: _,
        deviation: _,
        triangles,
    } = mesh;
    let names =
        [("x y z", true), ("nx ny nz", !normals.is_empty()), ("u v", !uvs.is_empty()), ("r g b", !colors.is_empty())];
    writeln!(to, "ply\nformat binary_little_endian 1.0\nelement vertex {}", positions.len())?;
    for (names, _) in names.iter().filter(|(_, is_there)| *is_there) {
        names.split(' ').try_for_each(|name| writeln!(to, "property float {name}"))?;
    }
    let sets = mesh.later_sets();
    for (at, set) in (1..).zip(&sets) {
        for (kind, _) in
            [("position", true), ("normal", !set.normals.is_empty())].iter().filter(|(_, is_there)| *is_there)
        {
            ["x", "y", "z"].iter().try_for_each(|axis| writeln!(to, "property float {kind}{at}_{axis}"))?;
        }
    }
    writeln!(to, "element face {}\nproperty list uchar int vertex_indices\nend_header", triangles.len())?;
    for (index, position) in positions.iter().enumerate() {
        let normal = normals.get(index).map(|normal| normal.to_array());
        let uv = uvs.get(index).map(|uv| uv.to_array());
        let color = colors.get(index).map(|color| color.to_array());
        let attributes =
            normal.into_iter().flatten().chain(uv.into_iter().flatten()).chain(color.into_iter().flatten());
        let of_sets = sets.iter().flat_map(|set| [set.positions.get(index), set.normals.get(index)]);
        let of_sets = of_sets.flatten().flat_map(|vector| vector.to_array());
        let values = position.to_array().into_iter().chain(attributes).chain(of_sets);
        values.into_iter().try_for_each(|value| to.write_all(&value.to_le_bytes()))?;
    }
    for triangle in triangles {
        to.write_all(&[3])?;
        triangle.iter().try_for_each(|index| to.write_all(&index.to_le_bytes()))?;
    }
    Ok(())
}
